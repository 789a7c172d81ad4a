//! What fits and tests cost, on one thread: `cargo bench -p analysis`.
//!
//! It measures and judges nothing; the limits that the project has set itself are named beside each benchmark.

mod gaze;
mod mar;
mod psychometric;
mod quest_plus;
mod rules;
mod statistics;

use criterion::Criterion;
use std::time::Duration;

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(4))
        .configure_from_args();
    gaze::bench(&mut criterion);
    mar::bench(&mut criterion);
    psychometric::bench(&mut criterion);
    quest_plus::bench(&mut criterion);
    rules::bench(&mut criterion);
    statistics::bench(&mut criterion);
    criterion.final_summary();
}
