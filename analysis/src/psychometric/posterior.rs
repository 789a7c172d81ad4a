//! The unnormalised posterior density of one function over its five parameters.
//!
//! A point is (threshold, width, λ, γ, η) with threshold and width in the axis's coordinate. What is fixed has the same
//! value at both ends of its bounds; equal asymptotes have γ tied to λ.

use super::config::{Guess, Lapse, Overdispersion};
use super::data::Checked;
use super::likelihood::Likelihood;
use super::prior::Priors;
use super::{Psychometric, PsychometricConfig, Scale, Sigmoid};

/// (threshold, width, λ, γ, η), threshold and width in the axis's coordinate.
pub(super) type Point = [f64; 5];

/// The point of (threshold, ln width, λ, γ, η), the coordinates of searches.
pub(super) fn point_of(x: &[f64]) -> Point {
    [x[0], x[1].exp(), x[2], x[3], x[4]]
}

/// The posterior of one data set.
#[derive(Debug, Clone)]
pub(super) struct Posterior {
    pub(super) likelihood: Likelihood,
    pub(super) priors: Priors,
    pub(super) config: PsychometricConfig,
}

impl Posterior {
    pub(super) fn new(data: &Checked, config: &PsychometricConfig) -> Self {
        let priors = config.priors.resolved(data.range, data.step);
        Self { likelihood: Likelihood::new(&data.counts, config), priors, config: *config }
    }

    pub(super) fn tied(&self) -> bool {
        self.config.guess == Guess::EqualToLapse
    }

    /// Where the priors are above zero, (threshold, width, λ, γ, η).
    pub(super) fn bounds(&self) -> [[f64; 2]; 5] {
        let mut threshold = self.priors.threshold.support();
        if self.config.sigmoid == Sigmoid::Weibull && self.config.scale == Scale::Linear {
            // A Weibull function has no threshold at zero or below.
            threshold[0] = threshold[0].max(1e-6 * threshold[1]);
        }
        let guess = match self.config.guess {
            Guess::Fixed(guess) => [guess, guess],
            Guess::Free => self.priors.guess.rate_support(),
            // Not used: γ is tied to λ.
            Guess::EqualToLapse => [0.0, 0.0],
        };
        let lapse = match self.config.lapse {
            Lapse::Fixed(lapse) => [lapse, lapse],
            Lapse::Free => {
                let [low, high] = self.priors.lapse.rate_support();
                // Beyond this the function would be upside down.
                let room = if let Guess::Fixed(guess) = self.config.guess { 1.0 - guess } else { 1.0 };
                [low, high.min(room * (1.0 - 1e-9))]
            }
        };
        let overdispersion = match self.config.overdispersion {
            Overdispersion::None => [0.0, 0.0],
            Overdispersion::Free => self.priors.overdispersion.overdispersion_support(),
        };
        [threshold, self.priors.width.width_support(), lapse, guess, overdispersion]
    }

    /// γ at a point's λ and γ.
    pub(super) fn guess(&self, lapse: f64, guess: f64) -> f64 {
        if self.tied() { lapse } else { guess }
    }

    pub(super) fn ln_prior_place(&self, threshold: f64, width: f64) -> f64 {
        self.priors.threshold.ln_density(threshold) + self.priors.width.ln_density(width)
    }

    /// ln of the prior of the rates that are free. With equal asymptotes the one free rate has one prior.
    pub(super) fn ln_prior_rates(&self, lapse: f64, guess: f64) -> f64 {
        let of_lapse = if self.config.lapse == Lapse::Free { self.priors.lapse.ln_density(lapse) } else { 0.0 };
        let of_guess = if self.config.guess == Guess::Free { self.priors.guess.ln_density(guess) } else { 0.0 };
        of_lapse + of_guess
    }

    pub(super) fn ln_prior_overdispersion(&self, eta: f64) -> f64 {
        match self.config.overdispersion {
            Overdispersion::None => 0.0,
            Overdispersion::Free => self.priors.overdispersion.ln_density(eta),
        }
    }

    /// The log density; −∞ out of bounds.
    pub(super) fn ln_density(&self, at: &Point) -> f64 {
        for (index, ([low, high], x)) in self.bounds().iter().zip(at).enumerate() {
            if !((low..=high).contains(&x) || (index == 3 && self.tied())) {
                return f64::NEG_INFINITY;
            }
        }
        let [threshold, width, lapse, guess, eta] = *at;
        let guess = self.guess(lapse, guess);
        let prior = self.ln_prior_place(threshold, width)
            + self.ln_prior_rates(lapse, guess)
            + self.ln_prior_overdispersion(eta);
        if prior == f64::NEG_INFINITY {
            return prior;
        }
        prior + self.likelihood.ln_likelihood(threshold, width, lapse, guess, eta)
    }

    /// The function at a point.
    pub(super) fn function(&self, at: &Point) -> Psychometric {
        let [threshold, width, lapse, guess, overdispersion] = *at;
        Psychometric {
            threshold: self.config.scale.level(threshold),
            width,
            lapse,
            guess: self.guess(lapse, guess),
            overdispersion,
        }
    }

    /// The point of a function.
    pub(super) fn point(&self, function: &Psychometric) -> Point {
        let Psychometric { threshold, width, lapse, guess, overdispersion } = *function;
        [self.config.scale.coordinate(threshold), width, lapse, guess, overdispersion]
    }
}
