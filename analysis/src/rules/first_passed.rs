//! The exact distribution of the first of several levels that passes, when each passes with a known chance.
//!
//! Guenter's thresholds and Tursun's strongest undetected blur are both "go through the levels in order and take the first
//! that passes". Such a result is an extreme of chance events: its mean lies before the level at which passing is even,
//! and the farther the more often each level is tried. Here that is computed, not simulated.

use serde::{Deserialize, Serialize};

/// One level, and how probably it is the first that passes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Passed {
    /// The level's value.
    pub value: f64,
    /// The probability that it is the first.
    pub probability: f64,
}

/// The distribution of the first level that passes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FirstPassed {
    /// The levels, in the order in which the rule goes through them.
    pub outcomes: Vec<Passed>,
    /// The probability that none passes.
    pub none: f64,
    /// The mean value, given that one passes; nothing if none can.
    pub mean: Option<f64>,
    /// The standard deviation, given that one passes.
    pub sd: Option<f64>,
}

impl FirstPassed {
    /// From (value, chance to pass) in the rule's order. Chances are kept within 0–1; levels that are not finite are left
    /// out.
    ///
    /// ```
    /// use analysis::rules::FirstPassed;
    /// // Two coins: the first shows heads half of the time, the second decides a quarter.
    /// let first = FirstPassed::new([(1.0, 0.5), (2.0, 0.5)]);
    /// assert_eq!((first.outcomes[1].probability, first.none), (0.25, 0.25));
    /// assert!((first.mean.unwrap() - 4.0 / 3.0).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn new(levels: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut left = 1.0;
        let mut outcomes = Vec::new();
        for (value, chance) in levels {
            if value.is_finite() && chance.is_finite() {
                let chance = chance.clamp(0.0, 1.0);
                outcomes.push(Passed { value, probability: left * chance });
                left *= 1.0 - chance;
            }
        }
        let any: f64 = outcomes.iter().map(|passed| passed.probability).sum();
        let moment = |of: &dyn Fn(f64) -> f64| {
            (any > 0.0).then(|| outcomes.iter().map(|passed| passed.probability / any * of(passed.value)).sum::<f64>())
        };
        let mean = moment(&|value| value);
        let sd = mean.and_then(|mean| moment(&|value| (value - mean).powi(2))).map(f64::sqrt);
        Self { outcomes, none: left, mean, sd }
    }

    /// How probably a level before `value` (in the rule's order) is the first, plus half of the probability of `value`
    /// itself, 0–1; `None` stands for no level, after all others. Nothing for a value that is no level.
    ///
    /// A result whose rank is near 0 or 1 does not go with the chances that were assumed.
    #[must_use]
    pub fn rank(&self, value: Option<f64>) -> Option<f64> {
        let Some(value) = value else { return Some(1.0 - 0.5 * self.none) };
        let at = self.outcomes.iter().position(|passed| passed.value.total_cmp(&value).is_eq())?;
        let before: f64 = self.outcomes[..at].iter().map(|passed| passed.probability).sum();
        Some(before + 0.5 * self.outcomes[at].probability)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal chances p give a geometric distribution: P(i) = (1 − p)^(i−1) p, mean 1/p.
    #[test]
    fn equal_chances_are_geometric() {
        let first = FirstPassed::new((1..=400).map(|i| (f64::from(i), 0.2)));
        assert!((first.mean.unwrap() - 5.0).abs() < 1e-9);
        // Variance (1 − p)/p² = 20.
        assert!((first.sd.unwrap() - 20f64.sqrt()).abs() < 1e-9);
        assert!((first.outcomes[2].probability - 0.64 * 0.2).abs() < 1e-15);
        // The median of Geometric(0.2): P(X ≤ 3) = 0.488; rank of 4 is 0.488 + 0.0512.
        assert!((first.rank(Some(4.0)).unwrap() - (0.488 + 0.0512)).abs() < 1e-12);
    }

    #[test]
    fn none_is_after_all_and_strange_input_is_no_nan() {
        let first = FirstPassed::new([(1.0, 0.0), (f64::NAN, 0.5), (2.0, 0.25), (3.0, f64::NAN), (4.0, -3.0)]);
        assert_eq!((first.outcomes.len(), first.none, first.mean, first.sd), (3, 0.75, Some(2.0), Some(0.0)));
        assert_eq!((first.rank(None), first.rank(Some(9.0))), (Some(0.625), None));
        let never = FirstPassed::new([(1.0, 0.0)]);
        assert_eq!((never.mean, never.sd, never.none), (None, None, 1.0));
        assert_eq!(FirstPassed::new([]).none, 1.0);
    }
}
