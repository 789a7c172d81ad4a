//! Tests of hypotheses.

use analysis::statistics::Alternative;
use analysis::statistics::anova::{AnovaConfig, Observations, rm_anova};
use analysis::statistics::binomial::{binomial_test, clopper_pearson};
use analysis::statistics::t_tests::paired;
use criterion::Criterion;
use std::hint::black_box;

pub(crate) fn bench(criterion: &mut Criterion) {
    let mut observations = Observations::new(["scene", "method"]);
    for subject in 0..12u32 {
        for cell in 0..12u32 {
            // Anything without a pattern.
            let value = f64::from((subject * 7919 + cell * 104_729) % 1009) / 100.0 + f64::from(subject);
            observations.push(subject.to_string(), [(cell / 4).to_string(), (cell % 4).to_string()], value);
        }
    }
    // At most 0.1 ms.
    criterion.bench_function("repeated-measures ANOVA, 12 subjects, 3 × 4", |bencher| {
        bencher.iter(|| rm_anova(black_box(&observations), &AnovaConfig::default()));
    });
    criterion.bench_function("exact binomial test, n = 1e6", |bencher| {
        bencher.iter(|| binomial_test(black_box(499_000), 1_000_000, 0.5, Alternative::TwoSided));
    });
    criterion.bench_function("Clopper–Pearson, 31 of 40", |bencher| {
        bencher.iter(|| clopper_pearson(black_box(31), 40, 0.95));
    });
    let first: Vec<f64> = observations.rows.iter().take(12).map(|row| row.value).collect();
    let second: Vec<f64> = observations.rows.iter().skip(12).take(12).map(|row| row.value).collect();
    criterion.bench_function("paired t test with its effect sizes, 12 pairs", |bencher| {
        bencher.iter(|| paired(black_box(&first), &second, Alternative::TwoSided, 0.95));
    });
}
