//! A paper's rule beside a fitted function: what each says of the same answers, and what the rule would say if the fitted
//! function were the truth.
//!
//! The two measure different things. The function's threshold is where half of the changes are noticed (chance taken off),
//! Guenter's rule the coarsest single miss. Their difference is mostly the rule's bias, which the function foretells
//! exactly; where it does not, the `rank` is near 0 or 1 and one of the two does not describe the observer.

use super::guenter::{ObserverThreshold, Thresholds, direction_order, unnoticed_once};
use super::{Bootstrap, FirstPassed, OverObservers};
use crate::comparison::ComparisonFit;
use crate::mar::Estimate;
use crate::psychometric::PsychometricFit;
use serde::{Deserialize, Serialize};

/// The fits of one observer's answers.
#[derive(Debug, Clone, Copy)]
pub struct Fitted<'a> {
    /// The observer's code.
    pub observer: &'a str,
    /// The function of how often a level is noticed.
    pub function: &'a PsychometricFit,
    /// The model of all three answers of a pair test, if there is one.
    pub three_answers: Option<&'a ComparisonFit>,
}

/// A rule's threshold beside the fitted one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RuleAgainstFit {
    /// The observer's code.
    pub observer: String,
    /// By the rule; it has no interval.
    pub rule: Option<f64>,
    /// By the function: estimate and interval.
    pub fitted: Estimate,
    /// By the model of all three answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub three_answers: Option<Estimate>,
    /// Whether the answers support the function; without that, nothing below means anything.
    pub is_supported: bool,
    /// What the rule gives to an observer with the function's most probable parameters, in this observer's trials.
    pub expected: FirstPassed,
    /// The rule's bias: its expected mean less the function's most probable threshold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<f64>,
    /// The rule's threshold less its bias.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corrected: Option<f64>,
    /// How far along its expected distribution the rule's threshold lies, 0 (coarse end) to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rank: Option<f64>,
}

/// Rules beside fits, for some observers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RulesAgainstFits {
    /// The level's parameter.
    pub parameter: String,
    /// Observers who have both, in alphabetical order.
    pub observers: Vec<RuleAgainstFit>,
    /// The rule's thresholds, over observers who have both thresholds and a function that their answers support.
    pub rule: Option<OverObservers>,
    /// The functions' thresholds, over the same observers.
    pub fitted: Option<OverObservers>,
    /// Rule less function, over the same observers.
    pub difference: Option<OverObservers>,
    /// The rule's bias as the functions foretell it, over the same observers.
    pub bias: Option<OverObservers>,
}

/// A pair or ramp threshold beside the fit of the same answers.
#[must_use]
pub fn against_fit(rule: &ObserverThreshold, fitted: &Fitted<'_>) -> RuleAgainstFit {
    let function = fitted.function;
    let mut levels = rule.tally.clone();
    levels.sort_by(|a, b| direction_order(function.config.direction, a.level, b.level));
    let expected = FirstPassed::new(levels.iter().map(|at| {
        // Where nothing changes, any answer is "unnoticed": the right one says so, and the others are wrong.
        let chance = if at.without_change { 1.0 } else { unnoticed_once(function.probability(at.level), at.n) };
        (at.level, chance)
    }));
    let bias = expected.mean.map(|mean| mean - function.map.threshold).filter(|bias| bias.is_finite());
    RuleAgainstFit {
        observer: rule.observer.clone(),
        rule: rule.threshold,
        fitted: function.threshold,
        three_answers: fitted.three_answers.map(|fit| fit.threshold),
        is_supported: function.support.is_supported(),
        corrected: rule.threshold.zip(bias).map(|(threshold, bias)| threshold - bias),
        rank: expected.rank(rule.threshold),
        bias,
        expected,
    }
}

/// The thresholds of a pair or ramp test beside the fits of the same observers' answers.
#[must_use]
pub fn against_fits(rules: &Thresholds, fits: &[Fitted<'_>], bootstrap: &Bootstrap) -> RulesAgainstFits {
    let observers: Vec<RuleAgainstFit> = rules
        .observers
        .iter()
        .filter(|rule| !rule.tally.is_empty())
        .filter_map(|rule| Some(against_fit(rule, fits.iter().find(|fit| fit.observer == rule.observer)?)))
        .collect();
    let over = |of: &dyn Fn(&RuleAgainstFit) -> Option<f64>| {
        let both = observers.iter().filter(|one| one.is_supported && one.rule.is_some());
        OverObservers::new(both.filter_map(of), bootstrap)
    };
    RulesAgainstFits {
        parameter: rules.options.parameter.clone(),
        rule: over(&|one| one.rule),
        fitted: over(&|one| Some(one.fitted.estimate)),
        difference: over(&|one| Some(one.rule? - one.fitted.estimate)),
        bias: over(&|one| one.bias),
        observers,
    }
}
