//! When an adaptive procedure ends.

use crate::procedures::Estimate;

/// A rule for the end of a procedure: trials, reversals and precision, joined by "all of" and "any of".
#[derive(Debug, Clone, PartialEq)]
pub enum Stop {
    /// So many completed trials, or more.
    Trials(u32),
    /// So many reversals, or more.
    Reversals(u32),
    /// A quantity is known well enough. Never before the first answer, nor while the procedure has no estimate.
    Narrow {
        /// A name in the procedure's [`Estimate`].
        quantity: String,
        /// How well it must be known.
        limit: Precision,
    },
    /// Every one of these rules.
    All(Vec<Stop>),
    /// At least one of these rules.
    Any(Vec<Stop>),
}

/// How well a quantity must be known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Precision {
    /// Standard deviation at most, in the quantity's unit.
    Sd(f64),
    /// Standard deviation over the mean's magnitude, at most.
    RelativeSd(f64),
}

impl Stop {
    /// Whether the rule holds after `trials` completed trials with `reversals` reversals, at this estimate.
    #[must_use]
    pub fn holds(&self, trials: u32, reversals: u32, estimate: &Estimate) -> bool {
        match self {
            Self::Trials(count) => trials >= *count,
            Self::Reversals(count) => reversals >= *count,
            Self::Narrow { quantity, limit } => estimate.get(quantity).is_some_and(|belief| {
                let most = match limit {
                    Precision::Sd(sd) => *sd,
                    Precision::RelativeSd(share) => share * belief.mean.abs(),
                };
                trials > 0 && belief.sd <= most
            }),
            Self::All(rules) => rules.iter().all(|rule| rule.holds(trials, reversals, estimate)),
            Self::Any(rules) => rules.iter().any(|rule| rule.holds(trials, reversals, estimate)),
        }
    }

    /// The number of trials after which the rule holds whatever is answered; nothing if it may never hold.
    ///
    /// Reversals and precision are in the observer's hands, so they bound nothing. Of "all" the latest counts, of "any"
    /// the earliest.
    #[must_use]
    pub fn max_trials(&self) -> Option<u32> {
        match self {
            Self::Trials(count) => Some(*count),
            Self::Reversals(_) | Self::Narrow { .. } => None,
            Self::All(rules) => rules.iter().map(Self::max_trials).try_fold(0, |most, rule| Some(most.max(rule?))),
            Self::Any(rules) => rules.iter().filter_map(Self::max_trials).min(),
        }
    }

    /// The fewest trials after which the rule can hold; `for_reversals` says it for a number of reversals.
    #[must_use]
    pub fn min_trials(&self, for_reversals: impl Fn(u32) -> u32 + Copy) -> u32 {
        match self {
            Self::Trials(count) => *count,
            Self::Reversals(count) => for_reversals(*count),
            Self::Narrow { .. } => 1,
            Self::All(rules) => rules.iter().map(|rule| rule.min_trials(for_reversals)).max().unwrap_or(0),
            Self::Any(rules) => rules.iter().map(|rule| rule.min_trials(for_reversals)).min().unwrap_or(u32::MAX),
        }
    }

    /// At `max_trials`, or as soon as `min_trials` are done and every one of the relative precisions holds; without any, at
    /// `max_trials`.
    #[must_use]
    pub fn at_most(max_trials: u32, min_trials: u32, relative: &[(&str, f64)]) -> Self {
        if relative.is_empty() {
            return Self::Trials(max_trials);
        }
        let narrow = relative.iter().map(|&(quantity, share)| Self::Narrow {
            quantity: quantity.to_owned(),
            limit: Precision::RelativeSd(share),
        });
        let all = std::iter::once(Self::Trials(min_trials)).chain(narrow).collect();
        Self::Any(vec![Self::Trials(max_trials), Self::All(all)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::Belief;

    fn narrow() -> Stop {
        Stop::Narrow { quantity: "m".to_owned(), limit: Precision::RelativeSd(0.1) }
    }

    #[test]
    fn limits_follow_the_tree() {
        let trees = [
            (Stop::Trials(30), Some(30), 30),
            (Stop::Reversals(6), None, 7),
            (narrow(), None, 1),
            (Stop::All(vec![Stop::Trials(30), Stop::Trials(60)]), Some(60), 60),
            (Stop::Any(vec![Stop::Trials(30), Stop::Trials(60)]), Some(30), 30),
            (Stop::All(vec![Stop::Trials(30), Stop::Reversals(6)]), None, 30),
            (Stop::Any(vec![Stop::Trials(30), Stop::Reversals(6)]), Some(30), 7),
            (Stop::Any(vec![Stop::Trials(60), Stop::All(vec![Stop::Reversals(10), Stop::Trials(30)])]), Some(60), 30),
            (Stop::at_most(400, 160, &[("m", 0.1), ("omega0_deg", 0.2)]), Some(400), 160),
            (Stop::at_most(400, 160, &[]), Some(400), 400),
        ];
        for (tree, most, fewest) in trees {
            assert_eq!((tree.max_trials(), tree.min_trials(|n| n + 1)), (most, fewest), "{tree:?}");
        }
    }

    #[test]
    fn rules_hold_when_they_should() {
        let estimate = |mean, sd| Estimate::from([("m".to_owned(), Belief { mean, sd })]);
        assert!(narrow().holds(1, 0, &estimate(-2.0, 0.2)));
        assert!(!narrow().holds(1, 0, &estimate(2.0, 0.21)));
        assert!(!narrow().holds(0, 0, &estimate(2.0, 0.0)), "never before the first answer");
        assert!(!narrow().holds(9, 9, &Estimate::new()), "never without an estimate");
        let both = Stop::All(vec![Stop::Trials(3), Stop::Reversals(2)]);
        let either = Stop::Any(vec![Stop::Trials(3), Stop::Reversals(2)]);
        for (trials, reversals) in [(2, 1), (2, 2), (3, 1), (3, 2)] {
            let (enough, turned) = (trials >= 3, reversals >= 2);
            assert_eq!(both.holds(trials, reversals, &Estimate::new()), enough && turned);
            assert_eq!(either.holds(trials, reversals, &Estimate::new()), enough || turned);
        }
    }
}
