//! The answers that a function is fitted to, and what is wrong with them.

use super::config::{Guess, Lapse, Overdispersion};
use super::prior::Prior;
use super::{PsychometricConfig, Scale, Sigmoid};
use serde::{Deserialize, Serialize};

/// The answers at one level, or in one block of answers at a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Count {
    /// The level, in its parameter's unit.
    pub level: f64,
    /// Answers.
    pub n: u32,
    /// Right ones.
    pub k: u32,
}

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PsychometricError {
    /// The standard priors follow the levels, of which there are too few.
    #[error(
        "answers at {levels} level(s), and a function needs at least 2, or the range of levels that could be shown"
    )]
    FewLevels {
        /// Levels with answers.
        levels: usize,
    },
    /// A count is impossible.
    #[error(
        "level {level}: expected a finite level{positive} with at most as many right answers as answers, found {k} of {n}"
    )]
    BadCount {
        /// The level.
        level: f64,
        /// `, above zero` on a logarithmic axis.
        positive: &'static str,
        /// Right answers.
        k: u32,
        /// Answers.
        n: u32,
    },
    /// The guess rate is impossible.
    #[error("the guess rate must lie from 0 to below 1, found {found}")]
    BadGuess {
        /// The rate.
        found: f64,
    },
    /// The lapse rate is impossible.
    #[error("the lapse rate must lie from 0 to below 1 minus the guess rate, found {found}")]
    BadLapse {
        /// The rate.
        found: f64,
    },
    /// The shape is none.
    #[error("Student's t needs degrees of freedom from 0.1 to 10000, found {found}")]
    BadShape {
        /// Degrees of freedom.
        found: f64,
    },
    /// The range is none.
    #[error("the range of levels must be two finite, rising levels{positive}, found {low} … {high}")]
    BadRange {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
        /// `, above zero` on a logarithmic axis.
        positive: &'static str,
    },
    /// A prior is no distribution over its parameter.
    #[error("the prior of {what} is no distribution over its values: {found:?}")]
    BadPrior {
        /// The parameter.
        what: &'static str,
        /// Its prior.
        found: Prior,
    },
    /// Two rates that leave no room for a function.
    #[error("a function with equal guess and lapse rates needs a free lapse rate")]
    EqualRatesFixed,
}

/// Counts and priors that can be fitted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Checked {
    /// Ascending in level. Equal levels are taken together where answers are independent.
    pub(super) counts: Vec<Count>,
    /// The range for the standard priors and the smallest step, in the axis's coordinate.
    pub(super) range: [f64; 2],
    pub(super) step: f64,
}

/// Whether counts and configuration can be fitted.
pub(super) fn checked(counts: &[Count], config: &PsychometricConfig) -> Result<Checked, PsychometricError> {
    check_config(config)?;
    let above_zero = config.scale == Scale::Logarithmic || config.sigmoid == Sigmoid::Weibull;
    let positive = if above_zero { ", above zero," } else { "" };
    let mut sorted: Vec<Count> = Vec::with_capacity(counts.len());
    for &Count { level, n, k } in counts {
        if !level.is_finite() || k > n || (above_zero && level <= 0.0) {
            return Err(PsychometricError::BadCount { level, positive, k, n });
        }
        if n > 0 {
            sorted.push(Count { level, n, k });
        }
    }
    sorted.sort_by(|a, b| a.level.total_cmp(&b.level));
    if config.overdispersion == Overdispersion::None {
        sorted = merged(&sorted);
    }
    let mut places: Vec<f64> = sorted.iter().map(|count| config.scale.coordinate(count.level)).collect();
    places.dedup();
    let (range, step) = match config.range {
        Some([low, high]) => {
            if !(low.is_finite() && high.is_finite() && low < high) || (above_zero && low <= 0.0) {
                return Err(PsychometricError::BadRange { low, high, positive });
            }
            ([low, high].map(|level| config.scale.coordinate(level)), smallest_step(&places))
        }
        None if places.len() < 2 && config.priors.need_range() => {
            return Err(PsychometricError::FewLevels { levels: places.len() });
        }
        None => ([places.first(), places.last()].map(|place| place.copied().unwrap_or(0.0)), smallest_step(&places)),
    };
    // With a range but without two levels, the width may be a tenth of the range.
    let step = if step.is_finite() { step } else { 0.1 * (range[1] - range[0]) };
    let resolved = config.priors.resolved(range, step);
    resolved.threshold.check("threshold")?;
    resolved.width.check("width")?;
    Ok(Checked { counts: sorted, range, step })
}

fn check_config(config: &PsychometricConfig) -> Result<(), PsychometricError> {
    if let Sigmoid::StudentT { df } = config.sigmoid
        && !(0.1..=1e4).contains(&df)
    {
        return Err(PsychometricError::BadShape { found: df });
    }
    let mut guess = 0.0;
    if let Guess::Fixed(found) = config.guess {
        if !(0.0..1.0).contains(&found) {
            return Err(PsychometricError::BadGuess { found });
        }
        guess = found;
    }
    if let Lapse::Fixed(found) = config.lapse {
        if config.guess == Guess::EqualToLapse {
            return Err(PsychometricError::EqualRatesFixed);
        }
        if !(0.0..1.0 - guess).contains(&found) {
            return Err(PsychometricError::BadLapse { found });
        }
    } else {
        config.priors.lapse.check("lapse")?;
    }
    if config.guess == Guess::Free {
        config.priors.guess.check("guess")?;
    }
    if config.overdispersion == Overdispersion::Free {
        config.priors.overdispersion.check("overdispersion")?;
    }
    Ok(())
}

/// Equal levels taken together; `counts` ascend in level.
pub(super) fn merged(counts: &[Count]) -> Vec<Count> {
    let mut merged: Vec<Count> = Vec::with_capacity(counts.len());
    for count in counts {
        match merged.last_mut() {
            Some(last) if last.level == count.level => {
                last.n += count.n;
                last.k += count.k;
            }
            _ => merged.push(*count),
        }
    }
    merged
}

fn smallest_step(places: &[f64]) -> f64 {
    places.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::super::fit_psychometric;
    use super::*;

    fn count(level: f64, n: u32, k: u32) -> Count {
        Count { level, n, k }
    }

    #[test]
    fn impossible_input_is_named() {
        let config = PsychometricConfig { scale: Scale::Logarithmic, ..PsychometricConfig::TWO_ALTERNATIVES };
        let few = fit_psychometric(&[count(1.0, 4, 2), count(1.0, 4, 2), count(3.0, 0, 0)], &config);
        assert_eq!(few.err(), Some(PsychometricError::FewLevels { levels: 1 }));
        for bad in [count(0.0, 4, 2), count(f64::NAN, 4, 2), count(1.0, 4, 5)] {
            let found = fit_psychometric(&[bad, count(2.0, 4, 4), count(3.0, 4, 4)], &config);
            assert!(matches!(found, Err(PsychometricError::BadCount { .. })), "{found:?}");
        }
        let all = [count(1.0, 4, 2), count(2.0, 4, 4), count(3.0, 4, 4)];
        let with = |change: &dyn Fn(&mut PsychometricConfig)| {
            let mut config = config;
            change(&mut config);
            fit_psychometric(&all, &config).err()
        };
        assert_eq!(with(&|c| c.guess = Guess::Fixed(1.0)), Some(PsychometricError::BadGuess { found: 1.0 }));
        assert_eq!(with(&|c| c.lapse = Lapse::Fixed(0.5)), Some(PsychometricError::BadLapse { found: 0.5 }));
        let df = f64::NAN;
        assert!(matches!(with(&|c| c.sigmoid = Sigmoid::StudentT { df }), Some(PsychometricError::BadShape { .. })));
        assert!(matches!(with(&|c| c.range = Some([0.0, 1.0])), Some(PsychometricError::BadRange { .. })));
        for (prior, what) in [
            (Prior::Uniform { low: 1.0, high: 1.0 }, "threshold"),
            (Prior::Normal { mean: -5.0, sd: 0.1 }, "width"),
            (Prior::Beta { a: 0.5, b: 1.0 }, "lapse"),
        ] {
            let found = with(&|c| match what {
                "threshold" => c.priors.threshold = prior,
                "width" => c.priors.width = prior,
                _ => c.priors.lapse = prior,
            });
            assert_eq!(found, Some(PsychometricError::BadPrior { what, found: prior }));
        }
        let equal = PsychometricConfig { guess: Guess::EqualToLapse, lapse: Lapse::Fixed(0.1), ..Default::default() };
        assert_eq!(fit_psychometric(&all, &equal).err(), Some(PsychometricError::EqualRatesFixed));
    }
}
