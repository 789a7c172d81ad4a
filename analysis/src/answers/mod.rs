//! What the answers of a block come to, for every protocol: shares and a psychometric function, matches, ratings, tasks.
//!
//! Trials come in as plain [`Row`]s, one for each answered trial of a block that is no practice; a [`BlockSummary`] goes
//! out. The family of a summary follows the protocol where it is known, and what was recorded where it is not. Groups of
//! observers are in [`group`].

mod detection;
pub mod group;
mod matches;
mod ratings;
pub(crate) mod strata;
mod tasks;

pub use detection::{Detection, DetectionPart, LevelCell};
pub use matches::{Matches, MatchesPart, Quantity};
pub use ratings::{Item, ItemRating, Ratings, RatingsPart, StepCount};
pub use tasks::{Counting, Tasks, TasksPart};

use crate::shares::Mean;
use experiments::session::record::TrialRecord;
use experiments::trial::{Answer, Outcome};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One answered trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The condition's name.
    pub condition: String,
    /// Factor → level, where the block has factors.
    pub factors: BTreeMap<String, String>,
    /// Renderer parameter → value, as the procedure chose them.
    pub level: BTreeMap<String, f64>,
    /// What was said.
    pub answer: Answer,
    /// Whether it was right, where there is a right and a wrong.
    pub correct: Option<bool>,
    /// What else was found, by name.
    pub found: BTreeMap<String, f64>,
    /// From the question to the answer, seconds.
    pub response_time_s: Option<f64>,
}

impl Row {
    /// A trial of a session's record; nothing for one without an answer.
    #[must_use]
    pub fn of_record(record: &TrialRecord) -> Option<Self> {
        let Outcome::Answered { answer, correct, found } = &record.outcome else { return None };
        Some(Self {
            condition: record.trial.condition.clone(),
            factors: record.trial.factors.clone(),
            level: record.trial.level.clone(),
            answer: *answer,
            correct: *correct,
            found: found.clone(),
            response_time_s: record.response_time_s,
        })
    }
}

/// How the trials of a block asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Protocol {
    /// Two intervals, one of them degraded.
    TwoInterval,
    /// Two alternatives to toggle between (Tursun 2019, §5.1).
    Toggle,
    /// Reference and test, "first better / second better / same" (Guenter 2012, §5).
    Pair,
    /// Quality that rises or falls in steps (Guenter 2012, §5).
    Ramp,
    /// Quality raised until it looks like the reference (Guenter 2012, §5).
    Slider,
    /// Statements rated after a sequence (Weier 2016, §4.2).
    Likert,
    /// Several parameters adjusted at will (Stengel 2016, §7.1).
    Adjustment,
    /// Reference and test compared after a task in each (Stengel 2016, §7.2).
    PairedTask,
}

impl Protocol {
    /// The protocol that a study names so, such as `two-interval`.
    #[must_use]
    pub fn named(kind: &str) -> Option<Self> {
        serde_json::from_value(serde_json::Value::from(kind)).ok()
    }

    /// Its name in studies.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::TwoInterval => "two-interval",
            Self::Toggle => "toggle",
            Self::Pair => "pair",
            Self::Ramp => "ramp",
            Self::Slider => "slider",
            Self::Likert => "likert",
            Self::Adjustment => "adjustment",
            Self::PairedTask => "paired-task",
        }
    }

    /// The protocol that answers like these come from; of several that answer alike, the simplest. Nothing for no rows, or
    /// for answers without right, wrong or any finding.
    #[must_use]
    pub fn of_rows(rows: &[Row]) -> Option<Self> {
        let any = |is: &dyn Fn(&Row) -> bool| rows.iter().any(is);
        let found = |end: &'static str| any(&|row: &Row| row.found.keys().any(|name| name.ends_with(end)));
        let said = |answer: Answer| any(&|row: &Row| row.answer == answer);
        if any(&|row| row.found.contains_key("count_1") || row.found.contains_key("spheres_1")) {
            Some(Self::PairedTask)
        } else if any(&|row| row.correct.is_some()) {
            Some(if said(Answer::Increased) || said(Answer::Decreased) {
                Self::Ramp
            } else if said(Answer::Same) {
                Self::Pair
            } else {
                Self::TwoInterval
            })
        } else if found("_settled") {
            Some(Self::Slider)
        } else if found("comparisons") {
            Some(Self::Adjustment)
        } else {
            any(&|row| !row.found.is_empty()).then_some(Self::Likert)
        }
    }

    /// Whether a trial is a choice between two alternatives, of which one must be named.
    #[must_use]
    pub fn is_forced_choice(self) -> bool {
        matches!(self, Self::TwoInterval | Self::Toggle)
    }
}

/// What the answers of one observer's block come to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockSummary {
    /// The study's name.
    pub study: String,
    /// The block's name.
    pub block: String,
    /// How it asked; nothing if neither the study nor the answers say.
    pub protocol: Option<Protocol>,
    /// Answered trials.
    pub trials: usize,
    /// Time to answer, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response_time_s: Option<Mean>,
    /// Whether its answers entered the observer's MAR fit too.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub in_mar_fit: bool,
    /// The summary.
    pub summary: Summary,
}

/// A summary by family of protocols.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "family", rename_all = "kebab-case")]
pub enum Summary {
    /// Right and wrong by level: two-interval, toggle, pair, ramp.
    Detection(Detection),
    /// Values that were set: slider, adjustment.
    Matches(Matches),
    /// Values of items: Likert.
    Ratings(Ratings),
    /// Recognised references and counted spheres: paired tasks.
    Tasks(Tasks),
    /// Nothing can be said.
    Nothing {
        /// Why not.
        reason: String,
    },
}

/// Sums up a block. `protocol` is what the study says; without it, it is told from the rows.
#[must_use]
pub fn summarise(study: &str, block: &str, protocol: Option<Protocol>, rows: &[Row]) -> BlockSummary {
    let protocol = protocol.or_else(|| Protocol::of_rows(rows));
    let nothing = |reason: &str| Summary::Nothing { reason: reason.to_owned() };
    let summary = if rows.is_empty() {
        nothing("no trial was answered")
    } else {
        match protocol {
            Some(Protocol::TwoInterval | Protocol::Toggle | Protocol::Pair | Protocol::Ramp) => {
                Detection::new(protocol, rows).map(Summary::Detection)
            }
            Some(Protocol::Slider | Protocol::Adjustment) => Matches::new(rows).map(Summary::Matches),
            Some(Protocol::Likert) => Ratings::new(rows).map(Summary::Ratings),
            Some(Protocol::PairedTask) => Tasks::new(rows).map(Summary::Tasks),
            None => None,
        }
        .unwrap_or_else(|| nothing("the answers hold nothing that this protocol is summed up by"))
    };
    BlockSummary {
        study: study.to_owned(),
        block: block.to_owned(),
        protocol,
        trials: rows.len(),
        response_time_s: Mean::new(rows.iter().filter_map(|row| row.response_time_s)),
        in_mar_fit: false,
        summary,
    }
}

/// The part of a block that a summary is about, in words: `all trials`, or `scene = forest, region = small`.
#[must_use]
pub fn part_name(by: &BTreeMap<String, String>) -> String {
    if by.is_empty() {
        return "all trials".to_owned();
    }
    by.iter().map(|(factor, level)| format!("{factor} = {level}")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn row(answer: Answer, correct: Option<bool>) -> Row {
        Row {
            condition: "one".to_owned(),
            factors: BTreeMap::new(),
            level: BTreeMap::new(),
            answer,
            correct,
            found: BTreeMap::new(),
            response_time_s: Some(1.0),
        }
    }

    impl Row {
        pub(crate) fn at(mut self, parameter: &str, value: f64) -> Self {
            self.level.insert(parameter.to_owned(), value);
            self
        }

        pub(crate) fn in_cell(mut self, factor: &str, level: &str) -> Self {
            self.factors.insert(factor.to_owned(), level.to_owned());
            self
        }

        pub(crate) fn found(mut self, name: &str, value: f64) -> Self {
            self.found.insert(name.to_owned(), value);
            self
        }
    }

    #[test]
    fn the_protocol_is_told_from_its_answers() {
        let first = || row(Answer::First, Some(true));
        let cases = [
            (vec![first()], Protocol::TwoInterval),
            (vec![first(), row(Answer::Same, Some(false))], Protocol::Pair),
            (vec![row(Answer::Decreased, Some(true)).found("from", 22.0)], Protocol::Ramp),
            (vec![row(Answer::Continue, None).found("j", 9.0).found("j_settled", 10.0)], Protocol::Slider),
            (vec![row(Answer::Continue, None).found("k", 9.0).found("comparisons", 2.0)], Protocol::Adjustment),
            (vec![row(Answer::Option(2), None).found("noise", 2.0)], Protocol::Likert),
            (vec![first().found("count_1", 9.0).found("spheres_1", 10.0)], Protocol::PairedTask),
        ];
        for (rows, expected) in cases {
            assert_eq!(Protocol::of_rows(&rows), Some(expected));
            assert_eq!(Protocol::named(expected.as_str()), Some(expected));
        }
        assert_eq!(Protocol::of_rows(&[]), None);
        assert_eq!(Protocol::named("guessing"), None);
    }

    #[test]
    fn no_rows_and_strange_rows_are_nothing_with_a_reason() {
        for (protocol, rows) in [
            (None, vec![]),
            (Some(Protocol::Pair), vec![]),
            (None, vec![row(Answer::Continue, None)]),
            (Some(Protocol::Pair), vec![row(Answer::Continue, None)]),
            (Some(Protocol::Slider), vec![row(Answer::First, Some(true))]),
            (Some(Protocol::Likert), vec![row(Answer::First, Some(true))]),
            (Some(Protocol::PairedTask), vec![row(Answer::Continue, None)]),
        ] {
            let summary = summarise("study", "block", protocol, &rows);
            assert!(matches!(summary.summary, Summary::Nothing { .. }), "{summary:?}");
            assert_eq!(summary.trials, rows.len());
        }
    }
}
