//! What is crossed with what, and in which order trials come.

use super::Condition;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// One cell of a block's design: a condition, and the factor levels that made it.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Factor → level, empty for a block of one condition.
    pub factors: BTreeMap<String, String>,
    /// What is shown. Its name is unique in the study.
    pub condition: Condition,
}

/// Which of reference and test comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PresentationOrder {
    /// Drawn for each trial.
    #[default]
    Random,
    /// Each trial of the design comes in both orders, which doubles their number.
    Both,
    /// The reference comes first.
    ReferenceFirst,
    /// The test comes first.
    TestFirst,
}

/// In which order the trials of a block come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OrderPlan {
    /// Trials are grouped by the levels of these factors, the first outermost; empty for one group.
    pub grouped_by: Vec<String>,
    /// In which order the groups come.
    pub groups: GroupOrder,
    /// Whether the trials within a group are shuffled; else they come as the design lists them.
    pub shuffled: bool,
    /// Factors whose level never comes twice in a row.
    pub no_repeat: Vec<String>,
}

impl Default for OrderPlan {
    fn default() -> Self {
        Self { grouped_by: Vec::new(), groups: GroupOrder::Shuffled, shuffled: true, no_repeat: Vec::new() }
    }
}

/// In which order groups of trials come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GroupOrder {
    /// Drawn for each session.
    #[default]
    Shuffled,
    /// As the study lists the factor's levels.
    Listed,
    /// A row of a balanced Latin square (Williams 1949), by the observer's number in the study.
    LatinSquare,
}

/// Breaks within a block, taken between trials.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BreakPlan {
    /// After this many completed trials.
    pub every_trials: Option<u32>,
    /// After this much time since the block began or the last break ended, seconds.
    pub every_s: Option<f64>,
}

/// When a practice block has been passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriterionPlan {
    /// The share of right answers in a round, at least, 0–1.
    pub share_correct: f64,
    /// Rounds at most.
    pub max_rounds: u32,
    /// Whether the session ends when the criterion was not met in any round; else it goes on.
    pub ends_session: bool,
}

/// A study that is run in several sittings by each observer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SittingsPlan {
    /// How many.
    pub count: u32,
    /// The factor whose levels are dealt out over the sittings; without it, repetitions are.
    pub split_by: Option<String>,
}

/// One group of a between-subject design.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupPlan {
    /// Its name.
    pub name: String,
    /// The blocks that it runs, in their order.
    pub blocks: Vec<String>,
}

/// How a pilot run is shortened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PilotPlan {
    /// Trials of each block, at most.
    pub trials: u32,
    /// Stimulus durations of a second and more are multiplied by this.
    pub time_factor: f64,
}

impl Default for PilotPlan {
    fn default() -> Self {
        Self { trials: 6, time_factor: 1.0 }
    }
}
