//! The MAR fit's intervals are as wide as they say: ranks of drawn truths are uniform, 95 % intervals hold 95 %.
//!
//! Simulation-based calibration (Talts et al. 2018). The full run of 2000 fits is
//! `cargo run --release -p analysis --example calibration -- mar 2000`; what it printed is in `CALIBRATION.md`.
#![allow(clippy::print_stdout)]

#[path = "../examples/calibration/mar.rs"]
mod simulation;

use analysis::mar::MarPriors;
use simulation::{Calibration, SEED, TRUTH, narrow_prior, simulate};
use statrs::distribution::{Binomial, DiscreteCDF};

/// 95 % intervals must hold as many truths as a binomial with p = 0.95 does, outside it once in 2000 on either side.
fn assert_covers(calibrations: &[Calibration], title: &str) {
    for c in calibrations {
        let n = c.ranks.len() as u64;
        #[allow(clippy::expect_used)]
        let binomial = Binomial::new(0.95, n).expect("0.95 is a probability");
        let ((chi2, p), (distance, p_distance)) = (c.uniformity(), c.distance());
        println!(
            "{title}, {}: held {} of {n}; ranks χ²(19) {chi2:.1}, p {p:.4}; KS {distance:.4}, p {p_distance:.4}",
            c.name, c.covered
        );
        let (low, high) = (binomial.cdf(c.covered as u64), 1.0 - binomial.cdf(c.covered.saturating_sub(1) as u64));
        assert!(low > 5e-4 && high > 5e-4, "{title}, {}: {} of {n} held", c.name, c.covered);
    }
}

fn assert_uniform(calibrations: &[Calibration], title: &str) {
    for c in calibrations {
        let ((_, p), (_, p_distance)) = (c.uniformity(), c.distance());
        // Eight tests of two statistics each: one below 1e-4 comes once in 600 runs of a right fit with other seeds.
        assert!(p > 1e-4 && p_distance > 1e-4, "{title}, {}: p {p}, {p_distance}", c.name);
    }
}

#[test]
fn truths_drawn_from_the_prior_have_uniform_ranks_and_coverage() {
    for (title, priors, per_level, fits) in [
        ("narrow prior, 350 trials", narrow_prior(), 10, 300),
        ("default prior, 175 trials", MarPriors::default(), 5, 150),
    ] {
        let calibrations = simulate(fits, SEED ^ 1, &priors, per_level, None);
        assert_covers(&calibrations, title);
        assert_uniform(&calibrations, title);
    }
}

#[test]
fn a_fixed_truth_is_held() {
    let calibrations = simulate(150, SEED ^ 2, &MarPriors::default(), 8, Some(TRUTH));
    // A fixed truth has no uniform ranks under a prior; coverage is near 95 % where the data say much.
    assert_covers(&calibrations[..2], "fixed truth, 280 trials");
}
