//! Tests of the simulated eye: its movements against the cited formulae, its tracker against the parameters.

mod following;
mod movements;
mod tracker;

use super::*;
use rand::SeedableRng;

fn display() -> Display {
    Display::named("guenter-2012").expect("ships")
}

/// An eye on the given display place; prints its seed.
fn eye_at(eye: SimulatedEye, start_deg: [f64; 2], seed: u64) -> Simulated {
    println!("seed {seed}");
    Simulated::new(eye, &display(), start_deg, ChaCha8Rng::seed_from_u64(seed)).expect("a possible eye")
}

fn polled(source: &mut Simulated, now_s: f64) -> Vec<GazeSample> {
    let mut out = Vec::new();
    source.poll(now_s, &mut out);
    out
}

/// The true angle between two samples, in degrees.
fn angle_deg(a: &GazeSample, b: &GazeSample) -> f64 {
    display().eccentricity_px_deg(a.px, b.px)
}

/// The indices (last sample at rest, first sample at rest again) of every movement faster than `threshold_deg_s`.
fn movements(samples: &[GazeSample], threshold_deg_s: f64) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for i in 1..samples.len() {
        let step_s = samples[i].t_s - samples[i - 1].t_s;
        let fast = angle_deg(&samples[i - 1], &samples[i]) / step_s > threshold_deg_s;
        match (fast, start) {
            (true, None) => start = Some(i - 1),
            (false, Some(from)) => {
                found.push((from, i - 1));
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn sd(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Panics unless `found` is within `tolerance` (a share) of `expected`.
fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    println!("{what}: {found:.5}, expected {expected:.5} ± {:.1} %", 100.0 * tolerance);
    assert!((found / expected - 1.0).abs() <= tolerance, "{what}: {found} is not {expected} ± {tolerance}");
}
