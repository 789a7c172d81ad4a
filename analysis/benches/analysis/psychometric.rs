//! Posterior of one psychometric function.

use analysis::psychometric::{Count, Overdispersion, PsychometricConfig, fit_psychometric};
use criterion::Criterion;
use std::hint::black_box;

/// Seven levels, two alternatives: at most 40 ms.
pub(crate) fn bench(criterion: &mut Criterion) {
    let counts: Vec<Count> = (1u8..)
        .zip([19, 22, 27, 32, 37, 39, 39])
        .map(|(level, k)| Count { level: f64::from(level), n: 40, k })
        .collect();
    let config = PsychometricConfig { overdispersion: Overdispersion::Free, ..PsychometricConfig::TWO_ALTERNATIVES };
    criterion.bench_function("posterior of a 7-level 2AFC function, lapse rate and overdispersion free", |bencher| {
        bencher.iter(|| fit_psychometric(black_box(&counts), &config));
    });
}
