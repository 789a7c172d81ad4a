//! The study file as it is written: what serde reads and what the JSON Schema is generated from.
//!
//! These are types of a file, not of the domain: every field may be absent here, so that a file with mistakes can be
//! read as far as it goes and all of them reported at once. `schemars(required)` marks what must be there; the doc
//! comments become the schema's descriptions, which editors show. [`super::validate`] makes a plan of them.

use crate::catalogue::ParameterValue;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The version of the study format that this program reads.
pub const FORMAT: u32 = 1;

/// What every name in a study looks like.
pub const NAME_PATTERN: &str = "^[a-z0-9]+(-[a-z0-9]+)*$";

/// Numbers; one that could not be read is `None`, so that the others keep their places.
pub type NumberList = Vec<Option<f64>>;

/// A study: what is shown to an observer, how they are asked, and how the next question is chosen.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Parafovea study")]
pub struct StudyDraft {
    /// Where editors find this schema.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// Version of the format: 1.
    #[schemars(required, extend("const" = 1))]
    pub format: Option<u32>,
    /// Short name, the first part of a session folder's name: a-z, 0-9 and hyphens.
    #[schemars(required, extend("pattern" = NAME_PATTERN))]
    pub name: Option<String>,
    /// Title for people.
    #[schemars(required, length(min = 1))]
    pub title: Option<String>,
    /// What the study is for.
    pub about: Option<String>,
    /// The display the study is meant for: a shipped name, or its geometry. `--display` overrides it.
    pub display: Option<DisplayChoice>,
    /// Where observers look and what happens when they do not.
    pub gaze: Option<GazeDraft>,
    /// Pages shown around the blocks.
    pub texts: Option<TextsDraft>,
    /// What is shown, by name.
    #[schemars(required)]
    pub conditions: Option<BTreeMap<String, Option<ConditionDraft>>>,
    /// The blocks, in the order in which they run.
    #[schemars(required)]
    pub blocks: Option<Vec<Option<BlockDraft>>>,
}

/// A display: the name of one that ships, or its geometry.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum DisplayChoice {
    /// The name of a display that ships with the program.
    Named(String),
    /// A display's geometry.
    Described(DisplayDraft),
}

/// A flat display and the distance it is seen from.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Parafovea display")]
pub struct DisplayDraft {
    /// Where editors find this schema.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// Name, as it will stand in sessions and reports.
    #[schemars(required, length(min = 1))]
    pub name: Option<String>,
    /// Width and height in pixels.
    #[schemars(required, inner(range(min = 16, max = 16384)))]
    pub resolution_px: Option<[u32; 2]>,
    /// Width and height of the lit area, in millimetres; measure it, do not trust the diagonal.
    #[schemars(required, inner(range(min = 1.0, max = 100000.0)))]
    pub size_mm: Option<[f64; 2]>,
    /// Distance from the eye to the display's centre, in millimetres.
    #[schemars(required, range(min = 1.0, max = 1000000.0))]
    pub distance_mm: Option<f64>,
    /// Refresh rate in hertz; 60 when absent.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub refresh_hz: Option<f64>,
    /// Measured peak luminance in cd/m².
    #[schemars(range(min = 0.1, max = 100000.0))]
    pub peak_cd_m2: Option<f64>,
}

/// Where observers look and what happens when they do not.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GazeDraft {
    /// Where the fixation mark stands: degrees right and up from the display's centre. The centre when absent.
    #[schemars(inner(range(min = -80.0, max = 80.0)))]
    pub fixation_deg: Option<[f64; 2]>,
    /// Radius of the fixation gate in degrees; no gate when absent. Gaze that leaves it during an interval aborts the
    /// trial, which is asked again later.
    #[schemars(range(max = 90.0), extend("exclusiveMinimum" = 0))]
    pub gate_deg: Option<f64>,
    /// How long gaze may be outside the gate, or lost, before that counts, in seconds; 0.1 when absent.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub gate_grace_s: Option<f64>,
}

/// Pages shown around the blocks.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TextsDraft {
    /// Pages before the first block, in order.
    pub instructions: Option<Vec<Option<String>>>,
    /// Shown at every break; a plain sentence when absent.
    pub pause: Option<String>,
    /// The last page; a plain sentence when absent.
    pub thanks: Option<String>,
}

/// What is shown: a scene under a renderer.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionDraft {
    /// The scene's id.
    #[schemars(required)]
    pub scene: Option<String>,
    /// The scene's parameters by name; those that are absent keep their defaults.
    pub scene_parameters: Option<BTreeMap<String, Option<ParameterValue>>>,
    /// The id of the renderer under test; it is always compared with the full-resolution reference.
    #[schemars(required)]
    pub renderer: Option<String>,
    /// The renderer's parameters by name; those that are absent keep their defaults, and a level overrides some.
    pub renderer_parameters: Option<BTreeMap<String, Option<ParameterValue>>>,
}

/// Trials that share a condition, a protocol and a procedure.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlockDraft {
    /// Name, unique in the study: a-z, 0-9 and hyphens.
    #[schemars(required, extend("pattern" = NAME_PATTERN))]
    pub name: Option<String>,
    /// Practice gives feedback and is left out of the fits; false when absent.
    pub practice: Option<bool>,
    /// A page before the block.
    pub instructions: Option<String>,
    /// The name of one of the study's conditions.
    #[schemars(required)]
    pub condition: Option<String>,
    /// How a trial asks.
    #[schemars(required)]
    pub protocol: Option<ProtocolDraft>,
    /// How the next level is chosen.
    #[schemars(required)]
    pub procedure: Option<ProcedureDraft>,
    /// A break after this many completed trials; no breaks when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub break_every_trials: Option<u32>,
}

/// How a trial asks.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ProtocolDraft {
    /// Two intervals, one of them degraded; the observer says which.
    TwoInterval(TwoIntervalDraft),
}

/// Two intervals, one of them degraded; the observer says which.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwoIntervalDraft {
    /// Fixation before the first interval, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub fixation_s: Option<f64>,
    /// Each interval, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub interval_s: Option<f64>,
    /// Grey between the intervals, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub gap_s: Option<f64>,
    /// How long an answer is waited for, in seconds, before the trial is asked again later; for ever when absent.
    #[schemars(range(max = 3600.0), extend("exclusiveMinimum" = 0))]
    pub answer_timeout_s: Option<f64>,
    /// How long "right" or "wrong" is shown in practice, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub feedback_s: Option<f64>,
    /// The question; "Which one was degraded: the first or the second?" when absent.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
}

/// How the next level is chosen.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ProcedureDraft {
    /// Constant stimuli: every level, so many times, shuffled.
    Constant(ConstantDraft),
    /// QUEST+ over the MAR model, omega = m·e + omega0.
    QuestPlus(Box<QuestPlusDraft>),
}

/// Constant stimuli: every level, so many times, shuffled.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantDraft {
    /// Renderer parameter → the values it takes; the levels are all combinations. Eccentricity and MAR that have no list
    /// keep the condition's value.
    #[schemars(required)]
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
    pub stop: Option<StopDraft>,
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

/// When an adaptive block ends: at `max_trials`, or from `min_trials` on as soon as every rule that is given holds.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopDraft {
    /// The block never has more completed trials.
    #[schemars(required, range(min = 1, max = 100000))]
    pub max_trials: Option<u32>,
    /// The rules are not asked before; a quarter of `max_trials` when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub min_trials: Option<u32>,
    /// Posterior SD of m divided by its mean, at most.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0))]
    pub m_relative_sd: Option<f64>,
    /// Posterior SD of omega0 divided by its mean, at most.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0))]
    pub omega0_relative_sd: Option<f64>,
}
