//! The four papers' own rules: how each read a result from its answers, under the rule's name and beside what it published.
//!
//! A rule is no model. It says what a paper did (the lowest index that once went unnoticed, the strongest blur below 75 %,
//! the share of recognised pictures, the mean rating), so that a replication can be held against the paper in the paper's
//! own measure. Several of these rules are biased, and by how much depends on the design; where the bias has a closed form it is here
//! ([`FirstPassed`], [`against_fit()`]). Functions with thresholds and intervals are fitted in [`crate::psychometric`] and
//! [`crate::mar`]; tests over observers are elsewhere.
//!
//! - [`guenter`]: thresholds of the pair, ramp and slider tests (Guenter 2012, §5);
//! - [`tursun`]: the strongest undetected blur at each eccentricity (Tursun 2019, §5);
//! - [`stengel`]: recognised pictures and adjusted parameters (Stengel 2016, §§6–7);
//! - [`weier`]: ratings by condition, and the long table of their analysis of variance (Weier 2016, §4.2);
//! - [`of_block`] picks the rule of a protocol.

mod against_fit;
mod first_passed;
pub mod guenter;
mod long;
mod observers;
pub mod stengel;
pub mod tursun;
pub mod weier;

pub use against_fit::{Fitted, RuleAgainstFit, RulesAgainstFits, against_fit, against_fits};
pub use first_passed::{FirstPassed, Passed};
pub use long::{LongRow, LongTable};
pub use observers::{Bootstrap, OverObservers};

use crate::answers::{Protocol, Row};
use serde::{Deserialize, Serialize};

/// One observer's answered trials of one block.
#[derive(Debug, Clone, Copy)]
pub struct ObserverRows<'a> {
    /// The observer's code. What is given under the same code is put together.
    pub observer: &'a str,
    /// The trials.
    pub rows: &'a [Row],
}

/// A rule, and where it stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rule {
    /// Its name.
    pub name: String,
    /// What it says, in one sentence.
    pub says: String,
    /// Paper, section, equation.
    pub source: String,
}

impl Rule {
    fn new(name: &str, says: &str, source: &str) -> Self {
        Self { name: name.to_owned(), says: says.to_owned(), source: source.to_owned() }
    }
}

/// A published figure, to be shown beside ours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// What it is about.
    pub what: String,
    /// The figure.
    pub value: f64,
    /// Its standard deviation, if printed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<f64>,
    /// Observers, if printed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observers: Option<usize>,
    /// Paper and section.
    pub source: String,
    /// What to know before comparing; empty if both are the same measure.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub caveats: Vec<String>,
}

impl Published {
    fn new(what: &str, value: f64, source: &str) -> Self {
        let (what, source) = (what.to_owned(), source.to_owned());
        Self { what, value, sd: None, observers: None, source, caveats: Vec::new() }
    }

    fn sd(self, sd: f64) -> Self {
        Self { sd: Some(sd), ..self }
    }

    fn observers(self, observers: usize) -> Self {
        Self { observers: Some(observers), ..self }
    }

    fn caveat(mut self, caveat: &str) -> Self {
        self.caveats.push(caveat.to_owned());
        self
    }
}

/// Why a rule gives nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RuleError {
    /// No trial has what the rule looks at.
    #[error("{rule}: expected trials with {expected}, found none among {trials} trial(s) of {observers} observer(s)")]
    NothingToJudge {
        /// The rule's name.
        rule: String,
        /// What a trial must have.
        expected: String,
        /// Trials looked at.
        trials: usize,
        /// Observers looked at.
        observers: usize,
    },
    /// The papers have no rule for a protocol.
    #[error("block {block}: none of the papers has a rule for {protocol} trials; fit a function instead")]
    NoRule {
        /// The block.
        block: String,
        /// Its protocol.
        protocol: &'static str,
    },
    /// Predictions and measurements are not about the same patches and eccentricities.
    #[error("patch {patch}: expected {expected} finite value(s), one for each eccentricity, found {found}")]
    Mismatch {
        /// Which patch, counted from 0.
        patch: usize,
        /// Values expected.
        expected: usize,
        /// Finite values found.
        found: usize,
    },
}

impl RuleError {
    fn nothing(rule: &str, expected: &str, observers: &[ObserverRows<'_>]) -> Self {
        Self::NothingToJudge {
            rule: rule.to_owned(),
            expected: expected.to_owned(),
            trials: observers.iter().map(|observer| observer.rows.len()).sum(),
            observers: observers.len(),
        }
    }
}

/// What a block comes to by its paper's rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "paper", rename_all = "kebab-case")]
pub enum RuleResult {
    /// Pair, ramp, slider.
    Guenter(guenter::Thresholds),
    /// Toggled choices over radii and rates of blur.
    Tursun(tursun::Tolerances),
    /// Comparisons after a task, and toggled choices without a level.
    StengelTask(stengel::Recognised),
    /// Adjustments.
    StengelSettings(stengel::Settings),
    /// Ratings.
    Weier(weier::Ratings),
}

/// Sums up a block of any number of observers by the rule of the paper that its protocol comes from, with the rule's default options.
///
/// A toggled choice is Tursun's where its level has a radius and a rate, and Stengel's task T3 otherwise.
///
/// # Errors
/// If there is no such rule, or no trial has what it looks at.
pub fn of_block(
    block: &str,
    protocol: Protocol,
    observers: &[ObserverRows<'_>],
    bootstrap: Bootstrap,
) -> Result<RuleResult, RuleError> {
    let guenter = |test| {
        let options = guenter::Options { bootstrap, ..guenter::Options::of_rows(test, observers) };
        guenter::thresholds(test, observers, &options).map(RuleResult::Guenter)
    };
    match protocol {
        Protocol::Pair => guenter(guenter::Test::Pair),
        Protocol::Ramp => guenter(guenter::Test::Ramp),
        Protocol::Slider => guenter(guenter::Test::Slider),
        Protocol::Toggle => {
            let options = tursun::Options { bootstrap, ..tursun::Options::default() };
            if options.is_about(observers) {
                tursun::tolerances(observers, &options).map(RuleResult::Tursun)
            } else {
                stengel::recognised(block, protocol, observers, &bootstrap).map(RuleResult::StengelTask)
            }
        }
        Protocol::PairedTask => {
            stengel::recognised(block, protocol, observers, &bootstrap).map(RuleResult::StengelTask)
        }
        Protocol::Adjustment => stengel::settings(observers, &bootstrap).map(RuleResult::StengelSettings),
        Protocol::Likert => weier::ratings(observers, &bootstrap).map(RuleResult::Weier),
        Protocol::TwoInterval => Err(RuleError::NoRule { block: block.to_owned(), protocol: protocol.as_str() }),
    }
}
