//! The study file as it is written: what serde reads and what the JSON Schema is generated from.
//!
//! These are types of a file, not of the domain: every field may be absent here, so that a file with mistakes can be
//! read as far as it goes and all of them reported at once. `schemars(required)` marks what must be there; the doc
//! comments become the schema's descriptions, which editors show. [`super::validate`] makes a plan of them.

mod design;
mod form;
mod procedure;
mod protocol;

pub use design::*;
pub use form::*;
pub use procedure::*;
pub use protocol::*;

use crate::catalogue::ParameterValue;
use crate::study::plan::{FoveationCentre, PresentationOrder};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The version of the study format that this program reads.
pub const FORMAT: u32 = 1;

/// What every name in a study looks like.
pub const NAME_PATTERN: &str = "^[a-z0-9]+(-[a-z0-9]+)*$";

/// Numbers; one that could not be read is `None`, so that the others keep their places.
pub type NumberList = Vec<Option<f64>>;

/// Parameters by name; one that could not be read is `None`.
pub type OptionalParameters = BTreeMap<String, Option<ParameterValue>>;

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
    /// What is asked about the participant before anything else; of several sittings, in the first.
    pub participant: Option<Vec<Option<ItemDraft>>>,
    /// What is shown, by name.
    #[schemars(required)]
    pub conditions: Option<BTreeMap<String, Option<ConditionDraft>>>,
    /// The blocks, in the order in which they run.
    #[schemars(required)]
    pub blocks: Option<Vec<Option<BlockDraft>>>,
    /// The groups of a between-subject design; when absent, every observer runs every block.
    pub groups: Option<Vec<Option<GroupDraft>>>,
    /// How the study is split into sittings; one when absent.
    pub sittings: Option<SittingsDraft>,
    /// How a pilot run is shortened.
    pub pilot: Option<PilotDraft>,
}

/// A display: the name of one that ships, or its geometry.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum DisplayChoice {
    /// The name of a display that ships with the program.
    Named(String),
    /// A display's geometry.
    Described(Box<DisplayDraft>),
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
    /// How much light each channel gives for what is sent to it; sRGB when absent.
    pub transfer: Option<TransferDraft>,
}

/// A display's transfer: either `gamma`, or `levels` with the luminances of `red`, `green` and `blue` there.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TransferDraft {
    /// The exponents of the red, green and blue channel.
    #[schemars(inner(range(min = 1.0, max = 4.0)))]
    pub gamma: Option<[f64; 3]>,
    /// The 8-bit values at which luminances were measured, rising from 0 to 255.
    #[schemars(length(min = 2), inner(range(min = 0.0, max = 255.0)))]
    pub levels: Option<Vec<Option<f64>>>,
    /// The red channel's luminance at each level, rising strictly, in any unit.
    #[schemars(inner(range(min = 0.0)))]
    pub red: Option<Vec<Option<f64>>>,
    /// The green channel's luminance at each level, rising strictly, in any unit.
    #[schemars(inner(range(min = 0.0)))]
    pub green: Option<Vec<Option<f64>>>,
    /// The blue channel's luminance at each level, rising strictly, in any unit.
    #[schemars(inner(range(min = 0.0)))]
    pub blue: Option<Vec<Option<f64>>>,
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
    /// What the participant agrees to before anything else. Who does not agree is asked nothing.
    #[schemars(length(min = 1))]
    pub consent: Option<String>,
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
    pub scene_parameters: Option<OptionalParameters>,
    /// The id of the renderer under test; it is always compared with the full-resolution reference.
    #[schemars(required)]
    pub renderer: Option<String>,
    /// The renderer's parameters by name; those that are absent keep their defaults, and a level overrides some.
    pub renderer_parameters: Option<OptionalParameters>,
    /// How observers look while stimuli are shown; at the fixation mark when absent.
    pub fixation: Option<FixationDraft>,
    /// What the renderer takes for the gaze: "gaze" (when absent) or "target", the fixation mark or moving target wherever
    /// the gaze is.
    pub foveate: Option<FoveationCentre>,
}

/// Trials that share a design, a protocol and a procedure.
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
    /// When practice has been passed; after one round when absent.
    pub criterion: Option<CriterionDraft>,
    /// The name of one of the study's conditions; factors vary it.
    #[schemars(required)]
    pub condition: Option<String>,
    /// What is crossed: the block's cells are all combinations of the factors' levels.
    pub factors: Option<Vec<Option<FactorDraft>>>,
    /// Says that cells are not meant to be equally many for each level of a factor; false when absent.
    pub unbalanced: Option<bool>,
    /// How a trial asks.
    #[schemars(required)]
    pub protocol: Option<ProtocolDraft>,
    /// How the next level is chosen.
    #[schemars(required)]
    pub procedure: Option<ProcedureDraft>,
    /// Which of reference and test comes first: "random" (when absent), "both" (every trial comes in both orders),
    /// "reference-first" or "test-first".
    pub presentation: Option<PresentationOrder>,
    /// In which order the trials come; shuffled when absent.
    pub order: Option<OrderDraft>,
    /// A break after this many completed trials; no breaks when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub break_every_trials: Option<u32>,
    /// A break after this many minutes since the block began or the last break ended; no breaks when absent.
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0))]
    pub break_every_minutes: Option<f64>,
    /// Asked after the block.
    pub questionnaire: Option<Vec<Option<ItemDraft>>>,
}
