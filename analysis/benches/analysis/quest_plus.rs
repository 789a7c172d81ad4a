//! One trial of QUEST+: the choice among 40 stimuli and the update, over 50 × 20 × 5 parameter values: at most 0.4 ms.

use criterion::Criterion;
use experiments::mar::WIDTH_SCALE;
use experiments::procedures::quest_plus::{QuestPlus, Tables};
use statrs::function::erf::erf;
use std::f64::consts::SQRT_2;
use std::hint::black_box;
use std::sync::Arc;

const STIMULI: usize = 40;
const AXES: [usize; 3] = [50, 20, 5];

pub(crate) fn bench(criterion: &mut Criterion) {
    let parameters = AXES.iter().product();
    let success = |stimulus: usize, parameter: usize| {
        let [threshold, width, lapse] =
            [parameter / (AXES[1] * AXES[2]), parameter / AXES[2] % AXES[1], parameter % AXES[2]].map(|i| i as f64);
        let (level, threshold) = (stimulus as f64 / 4.0, threshold / 5.0);
        let z = WIDTH_SCALE * (level - threshold) / (0.5 + 0.4 * width);
        0.5 + (0.5 - 0.02 * lapse) * (0.5 + 0.5 * erf(z / SQRT_2))
    };
    let tables = Arc::new(Tables::of_success(STIMULI, vec![1.0; parameters], success));
    let fresh = QuestPlus::new(Arc::clone(&tables), parameters);
    // From the flat prior all values count; after some answers most are passed over.
    criterion.bench_function("QUEST+ trial over 50 × 20 × 5 values and 40 stimuli, the first", |bencher| {
        bencher.iter_batched_ref(
            || fresh.clone(),
            |engine| {
                let stimulus = engine.best_among(0..STIMULI).unwrap_or(0);
                engine.update(black_box(stimulus), 1);
            },
            criterion::BatchSize::SmallInput,
        );
    });
    let mut later = fresh;
    for answer in 0..20 {
        let stimulus = later.best_among(0..STIMULI).unwrap_or(0);
        later.update(stimulus, usize::from(stimulus > 20 || answer % 2 == 0));
    }
    criterion.bench_function("QUEST+ trial over 50 × 20 × 5 values and 40 stimuli, the 21st", |bencher| {
        bencher.iter_batched_ref(
            || later.clone(),
            |engine| {
                let stimulus = engine.best_among(0..STIMULI).unwrap_or(0);
                engine.update(black_box(stimulus), 1);
            },
            criterion::BatchSize::SmallInput,
        );
    });
}
