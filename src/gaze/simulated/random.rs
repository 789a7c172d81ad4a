//! Draws for the simulated eye: one generator for each process, so that none shifts another's numbers.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One process's source of chance.
#[derive(Debug)]
pub(super) struct Random {
    generator: ChaCha8Rng,
    spare: Option<f64>,
}

impl Random {
    /// An own generator, seeded from the next 32 bytes of `parent`.
    pub(super) fn split_from(parent: &mut ChaCha8Rng) -> Self {
        Self { generator: ChaCha8Rng::from_rng(parent), spare: None }
    }

    /// Uniform in 0–1, 1 excluded.
    pub(super) fn uniform(&mut self) -> f64 {
        self.generator.random()
    }

    /// Normal with mean 0 and standard deviation 1 (Box & Muller 1958).
    pub(super) fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// Exponential with the given mean, in its unit.
    pub(super) fn exponential(&mut self, mean: f64) -> f64 {
        -mean * (1.0 - self.uniform()).ln()
    }
}
