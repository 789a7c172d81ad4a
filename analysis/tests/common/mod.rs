//! Simulated calibrations with known truth, shared by the integration tests.
#![allow(dead_code, unreachable_pub)]

use analysis::mar::MarTrial;
use experiments::mar::MarModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The observer of Guenter's final slope with an ordinary width and a few lapses.
pub const TRUTH: MarModel = MarModel { m: 0.022, omega0_deg: 1.0 / 48.0, width: 0.8, lapse: 0.02 };

pub const ECCENTRICITIES: [f64; 5] = [2.0, 6.0, 11.0, 17.0, 24.0];

/// Constant stimuli: at each eccentricity, `per_ring` trials over seven levels around a threshold misjudged by up to 20 %.
pub fn constant_stimuli(truth: &MarModel, eccentricities: &[f64], per_ring: usize, seed: u64) -> Vec<MarTrial> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut trials = Vec::new();
    for &eccentricity_deg in eccentricities {
        let centre = truth.threshold_deg(eccentricity_deg) * (0.2 * (2.0 * rng.random::<f64>() - 1.0)).exp();
        for i in 0..per_ring {
            let mar_deg = centre * ((i % 7) as f64 * 0.25 - 0.75).exp();
            let p = truth.probability_correct(eccentricity_deg, mar_deg, 0.5);
            trials.push(MarTrial { eccentricity_deg, mar_deg, correct: rng.random::<f64>() < p });
        }
    }
    trials
}

/// A transformed staircase (one up, three down in ln omega) at each eccentricity, starting far above threshold.
pub fn staircase(truth: &MarModel, eccentricities: &[f64], per_ring: usize, seed: u64) -> Vec<MarTrial> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut trials = Vec::new();
    for &eccentricity_deg in eccentricities {
        let (mut level, mut run) = (8i32, 0);
        for trial in 0..per_ring {
            let mar_deg = 0.04 * (eccentricity_deg + 1.0).sqrt() * (0.15 * f64::from(level)).exp();
            let p = truth.probability_correct(eccentricity_deg, mar_deg, 0.5);
            let correct = rng.random::<f64>() < p;
            trials.push(MarTrial { eccentricity_deg, mar_deg, correct });
            let step = if trial < 12 { 3 } else { 1 };
            run = if correct { run + 1 } else { 0 };
            if !correct {
                level += step;
            } else if run == 3 {
                (level, run) = (level - step, 0);
            }
        }
    }
    trials
}
