//! Likelihood and priors of one function, in the coordinate in which it rises as a cumulative Gaussian.

use super::{Count, Guess, Psychometric, PsychometricConfig, WIDTH_IN_SD};
use crate::numerics::normal_cdf_pair;
use std::f64::consts::PI;

/// λ and a free γ are cut here; Beta(1, 10) has 0.1 % of its mass beyond.
const LARGEST_RATE: f64 = 0.5;

/// One level in the likelihood.
#[derive(Debug, Clone, Copy)]
struct Cell {
    x: f64,
    right: f64,
    wrong: f64,
}

/// The unnormalised posterior density over (threshold, width, λ, γ).
#[derive(Debug)]
pub(super) struct Posterior {
    cells: Vec<Cell>,
    guess: Guess,
    /// First and last level.
    range: [f64; 2],
    /// The smallest step between levels.
    step: f64,
}

impl Posterior {
    /// `counts` ascend in level, at least three of them.
    pub(super) fn new(counts: &[Count], config: &PsychometricConfig) -> Self {
        let sign = config.direction.sign();
        let mut cells: Vec<Cell> = counts
            .iter()
            .map(|count| Cell {
                x: sign * config.scale.coordinate(count.level),
                right: f64::from(count.k),
                wrong: f64::from(count.n - count.k),
            })
            .collect();
        cells.sort_by(|a, b| a.x.total_cmp(&b.x));
        let range = [cells[0].x, cells[cells.len() - 1].x];
        let step = cells.windows(2).map(|pair| pair[1].x - pair[0].x).fold(f64::INFINITY, f64::min);
        Self { cells, guess: config.guess, range, step }
    }

    fn spread(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    /// Where the prior of the threshold is above zero.
    pub(super) fn thresholds(&self) -> [f64; 2] {
        [self.range[0] - 0.5 * self.spread(), self.range[1] + 0.5 * self.spread()]
    }

    /// Where the prior of the width is above zero.
    pub(super) fn widths(&self) -> [f64; 2] {
        [self.step, 3.0 * self.spread()]
    }

    /// Where the prior of λ is above zero.
    pub(super) fn lapses(&self) -> [f64; 2] {
        let most = match self.guess {
            Guess::Fixed(guess) => LARGEST_RATE.min(1.0 - guess),
            Guess::Free => LARGEST_RATE,
        };
        [0.0, most]
    }

    /// Where the prior of γ is above zero; both ends are the same if it is fixed.
    pub(super) fn guesses(&self) -> [f64; 2] {
        match self.guess {
            Guess::Fixed(guess) => [guess, guess],
            Guess::Free => [0.0, LARGEST_RATE],
        }
    }

    pub(super) fn guess_is_free(&self) -> bool {
        self.guess == Guess::Free
    }

    /// ln of the prior of threshold and width, without its constant.
    pub(super) fn ln_prior_place(&self, threshold: f64, width: f64) -> f64 {
        let spread = self.spread();
        let outside = (self.range[0] - threshold).max(threshold - self.range[1]).max(0.0);
        let of_threshold = if outside >= 0.5 * spread { 0.0 } else { 0.5 + 0.5 * (2.0 * PI * outside / spread).cos() };
        let of_width = if width <= self.step || width >= 3.0 * spread {
            0.0
        } else if width < 2.0 * self.step {
            0.5 - 0.5 * (PI * (width - self.step) / self.step).cos()
        } else if width <= spread {
            1.0
        } else {
            0.5 + 0.5 * (0.5 * PI * (width - spread) / spread).cos()
        };
        (of_threshold * of_width).ln()
    }

    /// ln of the prior of the two rates, without its constant.
    pub(super) fn ln_prior_rates(&self, lapse: f64, guess: f64) -> f64 {
        let of_guess = if self.guess_is_free() { 9.0 * (1.0 - guess).ln() } else { 0.0 };
        9.0 * (1.0 - lapse).ln() + of_guess
    }

    /// Φ and 1 − Φ at every level, into `seen`.
    pub(super) fn fill_seen(&self, threshold: f64, width: f64, seen: &mut Vec<(f64, f64)>) {
        seen.clear();
        seen.extend(self.cells.iter().map(|cell| normal_cdf_pair(WIDTH_IN_SD * (cell.x - threshold) / width)));
    }

    /// The log likelihood of two rates, given Φ at every level.
    pub(super) fn ln_likelihood(&self, seen: &[(f64, f64)], lapse: f64, guess: f64) -> f64 {
        let rise = 1.0 - guess - lapse;
        if rise <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let mut sum = 0.0;
        for (cell, (below, above)) in self.cells.iter().zip(seen) {
            if cell.right > 0.0 {
                sum += cell.right * (guess + rise * below).ln();
            }
            if cell.wrong > 0.0 {
                sum += cell.wrong * (lapse + rise * above).ln();
            }
        }
        sum
    }

    /// The log density at a point, in the axis's rising coordinate.
    pub(super) fn ln_density(&self, at: &Psychometric) -> f64 {
        let [low, high] = self.lapses();
        let [least, most] = self.guesses();
        if !(low..=high).contains(&at.lapse) || !(least..=most).contains(&at.guess) {
            return f64::NEG_INFINITY;
        }
        let prior = self.ln_prior_place(at.threshold, at.width);
        if prior == f64::NEG_INFINITY {
            return prior;
        }
        let mut seen = Vec::with_capacity(self.cells.len());
        self.fill_seen(at.threshold, at.width, &mut seen);
        prior + self.ln_prior_rates(at.lapse, at.guess) + self.ln_likelihood(&seen, at.lapse, at.guess)
    }

    /// The log likelihood of any function of the level.
    pub(super) fn ln_likelihood_of(&self, counts: &[Count], probability: impl Fn(f64) -> f64) -> f64 {
        let term = |count: u32, p: f64| if count > 0 { f64::from(count) * p.ln() } else { 0.0 };
        counts
            .iter()
            .map(|count| {
                let p = probability(count.level);
                term(count.k, p) + term(count.n - count.k, 1.0 - p)
            })
            .sum()
    }
}
