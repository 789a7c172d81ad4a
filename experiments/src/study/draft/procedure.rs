//! How the next level is chosen, as a study writes it.

mod adaptive;
mod stop;

pub use adaptive::*;
pub use stop::*;

use super::NumberList;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// How the next level is chosen.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ProcedureDraft {
    /// Constant stimuli: every level, so many times, shuffled.
    Constant(ConstantDraft),
    /// A staircase on one parameter: n-up-m-down, or weighted.
    Staircase(Box<StaircaseDraft>),
    /// QUEST on one parameter.
    Quest(Box<QuestDraft>),
    /// QUEST+ over the MAR model, omega = m·e + omega0.
    QuestPlus(Box<QuestPlusDraft>),
    /// QUEST+ over a psychometric function of one parameter, whose threshold may be linear in a second one.
    QuestPlusFunction(Box<FunctionDraft>),
    /// Psi: threshold and slope of a psychometric function of one parameter.
    Psi(Box<PsiDraft>),
}

/// Constant stimuli: every level, so many times, shuffled.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantDraft {
    /// Renderer parameter → the values it takes; the levels are all combinations. Parameters that have no list keep the
    /// condition's value, and without any list that is the one level.
    pub levels: Option<BTreeMap<String, Option<NumberList>>>,
    /// How often each level is shown.
    #[schemars(required, range(min = 1, max = 100000))]
    pub repetitions: Option<u32>,
}

/// QUEST+ over the MAR model, omega = m·e + omega0.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QuestPlusDraft {
    /// The eccentricities that are asked about.
    #[schemars(required)]
    pub eccentricity: Option<EccentricityDraft>,
    /// The detail limits that are asked about.
    #[schemars(required)]
    pub mar: Option<MarDraft>,
    /// What is held possible before the first answer.
    pub prior: Option<PriorDraft>,
    /// When the block ends.
    #[schemars(required)]
    pub stop: Option<MarStopDraft>,
}

/// The eccentricities that a procedure asks about.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EccentricityDraft {
    /// The renderer parameter that is the eccentricity; `eccentricity_deg` when absent.
    pub parameter: Option<String>,
    /// Eccentricities in degrees.
    #[schemars(required, inner(range(min = 0.0, max = 90.0)), extend("x-unit" = "degrees"))]
    pub values: Option<NumberList>,
    /// Whether each eccentricity comes equally often, in shuffled rounds (true when absent), or whichever teaches most
    /// about the line.
    pub balanced: Option<bool>,
}

/// The detail limits omega that a procedure asks about, equally spaced in ln omega.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MarDraft {
    /// The renderer parameter that is omega; `mar_deg` when absent.
    pub parameter: Option<String>,
    /// The finest, in degrees per cycle.
    #[schemars(required, extend("exclusiveMinimum" = 0, "x-unit" = "degrees per cycle"))]
    pub min: Option<f64>,
    /// The coarsest, in degrees per cycle.
    #[schemars(required, extend("exclusiveMinimum" = 0, "x-unit" = "degrees per cycle"))]
    pub max: Option<f64>,
    /// How many, both ends included.
    #[schemars(required, range(min = 2, max = 1000))]
    pub steps: Option<u32>,
}

/// What is held possible before the first answer: a grid, every point of it equally likely.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PriorDraft {
    /// The MAR slope m; 20 values from 0.005 to 0.08 when absent.
    pub m: Option<AxisDraft>,
    /// The MAR at the fovea in degrees per cycle; 20 values from 0.005 to 0.1 when absent.
    pub omega0_deg: Option<AxisDraft>,
    /// The width of the psychometric function in ln omega, from 5 % to 95 %; 7 values from 0.2 to 3 when absent.
    pub width: Option<AxisDraft>,
    /// The lapse rate; 0, 0.02 and 0.05 when absent.
    pub lapse: Option<AxisDraft>,
}

/// Values of one model parameter: a list, or a range with equal ratios.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum AxisDraft {
    /// The values.
    List(NumberList),
    /// A range with equal ratios between neighbours.
    Range(RangeDraft),
}

/// A range with equal ratios between neighbours.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RangeDraft {
    /// The smallest value.
    #[schemars(required, extend("exclusiveMinimum" = 0))]
    pub min: Option<f64>,
    /// The largest value.
    #[schemars(required, extend("exclusiveMinimum" = 0))]
    pub max: Option<f64>,
    /// How many, both ends included.
    #[schemars(required, range(min = 2, max = 1000))]
    pub steps: Option<u32>,
}
