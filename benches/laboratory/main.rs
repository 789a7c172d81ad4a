//! What the laboratory's parts cost on this machine: a trial of the adaptive procedure, a fit and the log by criterion, then one
//! table of frames. `make bench`.
//!
//! It measures and judges nothing: it has no limits, and a machine without a graphics device gets the first half.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a benchmark tells what it measured")]

mod frames;
mod log;
mod trials;

use criterion::Criterion;
use std::time::Duration;

fn main() {
    // `cargo test --benches` asks for a run that only shows that it runs.
    let brief = std::env::args().any(|argument| argument == "--test");
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(4))
        .configure_from_args();
    trials::bench(&mut criterion);
    log::measure(&mut criterion);
    criterion.final_summary();
    if let Err(error) = frames::print_table(if brief { 1 } else { 10 }) {
        eprintln!("frames were not measured: {error}");
    }
}
