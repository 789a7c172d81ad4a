//! Designs, as a study writes them: factors, orders, breaks, practice, groups, sittings, pilot runs.

use super::{NAME_PATTERN, OptionalParameters};
use crate::study::plan::{FoveationCentre, GroupOrder};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A factor: what is varied from cell to cell of the design. Every level is crossed with every level of the others.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FactorDraft {
    /// Name, unique in the block: a-z, 0-9 and hyphens.
    #[schemars(required, extend("pattern" = NAME_PATTERN))]
    pub name: Option<String>,
    /// Its levels.
    #[schemars(required)]
    pub levels: Option<Vec<Option<FactorLevelDraft>>>,
}

/// A level of a factor: what it sets on top of the block's condition.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FactorLevelDraft {
    /// Name, unique in the factor: a-z, 0-9 and hyphens.
    #[schemars(required, extend("pattern" = NAME_PATTERN))]
    pub name: Option<String>,
    /// Nesting: this level exists only within these levels of other factors, as factor → levels.
    pub within: Option<BTreeMap<String, Option<Vec<Option<String>>>>>,
    /// Another scene; its parameters start from their defaults.
    pub scene: Option<String>,
    /// Scene parameters on top of the condition's.
    pub scene_parameters: Option<OptionalParameters>,
    /// Another renderer; its parameters start from their defaults.
    pub renderer: Option<String>,
    /// Renderer parameters on top of the condition's.
    pub renderer_parameters: Option<OptionalParameters>,
    /// Another way of looking.
    pub fixation: Option<FixationDraft>,
    /// What the renderer takes for the gaze: "gaze" or "target".
    pub foveate: Option<FoveationCentre>,
}

/// How observers look while stimuli are shown.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum FixationDraft {
    /// At the fixation mark.
    Cross(NoSettings),
    /// At a target that moves on a smooth path, another in every trial but its repetitions.
    Moving(MovingDraft),
    /// Wherever they like.
    Free(NoSettings),
}

/// Nothing to set.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NoSettings {}

/// A target that moves on a smooth path.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MovingDraft {
    /// Root mean square of its speed in degrees per second; 5 when absent.
    #[schemars(range(max = 60.0), extend("exclusiveMinimum" = 0))]
    pub speed_deg_s: Option<f64>,
    /// How far it goes from the fixation mark, right and up, in degrees; 60 % of the room that the display leaves when
    /// absent.
    #[schemars(inner(range(min = 0.1, max = 80.0)))]
    pub reach_deg: Option<[f64; 2]>,
    /// Its diameter in degrees; 0.8 when absent.
    #[schemars(range(min = 0.05, max = 10.0))]
    pub diameter_deg: Option<f64>,
}

/// In which order the trials of a block come.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrderDraft {
    /// Trials are kept together by the levels of these factors, the first outermost; not at all when absent.
    pub grouped_by: Option<Vec<Option<String>>>,
    /// In which order the groups come: "shuffled" (when absent), "listed", or "latin-square" (a row of a balanced square
    /// by the observer's number).
    pub groups: Option<GroupOrder>,
    /// Whether trials are shuffled (true when absent) or come as the design lists them. Adaptive procedures are
    /// interleaved when shuffled, and run one after the other when not.
    pub shuffled: Option<bool>,
    /// Factors whose level never comes twice in a row.
    pub no_repeat: Option<Vec<Option<String>>>,
}

/// When practice has been passed.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CriterionDraft {
    /// The share of right answers in a round, at least: 0 to 1.
    #[schemars(required, range(min = 0.0, max = 1.0))]
    pub share_correct: Option<f64>,
    /// How often practice is repeated at most, the first round counted; 3 when absent.
    #[schemars(range(min = 1, max = 100))]
    pub max_rounds: Option<u32>,
    /// What follows when no round was enough: "go-on" (when absent) or "end".
    pub otherwise: Option<Otherwise>,
}

/// What follows when practice was not passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Otherwise {
    /// The session goes on with the next block.
    #[default]
    GoOn,
    /// The session ends.
    End,
}

/// One group of a between-subject design. New observers go to the group with the fewest.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroupDraft {
    /// Name, unique in the study: a-z, 0-9 and hyphens.
    #[schemars(required, extend("pattern" = NAME_PATTERN))]
    pub name: Option<String>,
    /// The blocks that this group runs, in their order.
    #[schemars(required)]
    pub blocks: Option<Vec<Option<String>>>,
}

/// A study that each observer runs in several sittings.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SittingsDraft {
    /// How many.
    #[schemars(required, range(min = 2, max = 1000))]
    pub count: Option<u32>,
    /// The factor whose levels are dealt out over the sittings; repetitions are when absent. Practice is in every sitting.
    pub split_by: Option<String>,
}

/// How a pilot run (`run --pilot`) is shortened.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PilotDraft {
    /// Trials of each block, at most; 6 when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub trials: Option<u32>,
    /// Stimuli of a second and more are shown for this share of their time; 1 when absent.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0))]
    pub time_factor: Option<f64>,
}
