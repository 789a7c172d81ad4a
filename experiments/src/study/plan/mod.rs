//! A study that has been checked: every name resolved, every number in bounds, the display known.
//!
//! A [`Plan`] is what the session machine runs. It is not the file: the file's types are in [`super::draft`], and
//! [`super::validate`] is the only way from one to the other.

mod design;
mod files;
mod form;
mod procedure;
mod protocol;

pub use design::*;
pub use files::*;
pub use form::*;
pub use procedure::*;
pub use protocol::*;

use crate::catalogue::{DetailLaw, ParameterValue, Parameters};
use crate::display::Display;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// One value of everything that a procedure varies: renderer parameter name → value in the parameter's unit.
///
/// A level names the renderer parameters that it sets, so that any protocol can vary anything.
pub type Level = BTreeMap<String, f64>;

/// A whole study, ready to run on one display.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Short name; the first part of a session folder's name.
    pub name: String,
    /// Title for people.
    pub title: String,
    /// What the study is for.
    pub about: String,
    /// The display it runs on.
    pub display: Display,
    /// What is demanded of the gaze.
    pub gaze: GazePlan,
    /// Pages shown around the blocks.
    pub texts: Texts,
    /// What is asked about the participant before anything else.
    pub participant: Vec<Item>,
    /// Scenes and renderers that the study brings along.
    pub files: Vec<NamedFile>,
    /// The blocks, in the order in which they run.
    pub blocks: Vec<BlockPlan>,
    /// The groups of a between-subject design; empty where every observer runs every block.
    pub groups: Vec<GroupPlan>,
    /// How the study is split into sittings, if it is.
    pub sittings: Option<SittingsPlan>,
    /// How a pilot run is shortened.
    pub pilot: PilotPlan,
}

impl Plan {
    /// The most trials that the study can have, all blocks together, aborted ones aside.
    #[must_use]
    pub fn max_trials(&self) -> u32 {
        self.blocks.iter().map(BlockPlan::max_trials).fold(0, u32::saturating_add)
    }
}

/// Where observers look and what happens when they do not.
#[derive(Debug, Clone, PartialEq)]
pub struct GazePlan {
    /// Where the fixation mark stands, in degrees from the display's centre.
    pub fixation_deg: [f64; 2],
    /// The gate around it, if the study has one.
    pub gate: Option<GatePlan>,
}

/// A fixation gate: what follows when gaze leaves it is the protocol's, phase by phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GatePlan {
    /// Radius of the gate around the fixation mark or moving target, in degrees of eccentricity.
    pub radius_deg: f64,
    /// How long gaze may be outside or lost (a blink, a noisy sample) before it counts, in seconds.
    pub grace_s: f64,
}

/// The pages of a study.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Texts {
    /// What the participant agrees to before anything else; a session without agreement ends.
    pub consent: Option<String>,
    /// Pages before the first block, in order.
    pub instructions: Vec<String>,
    /// Shown at a break; may be empty.
    pub pause: String,
    /// The last page.
    pub thanks: String,
}

/// One block of trials that share a protocol, a procedure and a design.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockPlan {
    /// Name, unique in the study.
    pub name: String,
    /// Practice gives feedback and is left out of the fits.
    pub practice: bool,
    /// When practice has been passed; without it, after one round.
    pub criterion: Option<CriterionPlan>,
    /// A page before the block, if any.
    pub instructions: Option<String>,
    /// What is shown: the cells of the design, in the order in which the study lists them.
    pub cells: Vec<Cell>,
    /// How a trial asks.
    pub protocol: ProtocolPlan,
    /// How long "right" or "wrong" is shown in practice, seconds.
    pub feedback_s: f64,
    /// How the next level is chosen, in every cell.
    pub procedure: ProcedurePlan,
    /// Which of reference and test comes first.
    pub presentation_order: PresentationOrder,
    /// In which order the trials come.
    pub order: OrderPlan,
    /// Breaks.
    pub breaks: BreakPlan,
    /// The block ends after this many completed trials, whatever is left: a pilot run's limit.
    pub at_most_trials: Option<u32>,
    /// Asked after the block.
    pub questionnaire: Vec<Item>,
}

impl BlockPlan {
    /// How often each trial of the design is there on account of the presentation order.
    #[must_use]
    pub fn orders(&self) -> u32 {
        if self.presentation_order == PresentationOrder::Both { 2 } else { 1 }
    }

    /// The most trials of one round, aborted ones aside.
    #[must_use]
    pub fn max_trials(&self) -> u32 {
        self.in_every_cell(self.procedure.max_trials())
    }

    /// The fewest trials of one round.
    #[must_use]
    pub fn min_trials(&self) -> u32 {
        self.in_every_cell(self.procedure.min_trials())
    }

    fn in_every_cell(&self, trials: u32) -> u32 {
        let most = self.at_most_trials.unwrap_or(u32::MAX);
        let cells = u32::try_from(self.cells.len()).unwrap_or(u32::MAX);
        // An adaptive procedure counts its trials itself, whatever their order.
        let orders = if self.procedure.is_adaptive() { 1 } else { self.orders() };
        trials.saturating_mul(cells).saturating_mul(orders).min(most)
    }
}

/// What is shown in a cell of the design.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// Its name in the study.
    pub name: String,
    /// Scene id.
    pub scene: String,
    /// Scene parameters, complete.
    pub scene_parameters: Parameters,
    /// Renderer id of the test stimulus; the comparison is always the full-resolution `reference`.
    pub renderer: String,
    /// Renderer parameters, complete; a level overrides some of them.
    pub renderer_parameters: Parameters,
    /// How the renderer's parameters decide the detail that is left, from the catalogue.
    pub detail: DetailLaw,
    /// How observers look while stimuli are shown.
    pub fixation: Fixation,
    /// What the renderer takes for the gaze.
    pub foveation: FoveationCentre,
}

impl Condition {
    /// The renderer's parameters at a level: the condition's own, with the level's on top.
    #[must_use]
    pub fn parameters_at(&self, level: &Level) -> Parameters {
        let mut parameters = self.renderer_parameters.clone();
        parameters.extend(level.iter().map(|(name, &value)| (name.clone(), ParameterValue::Number(value))));
        parameters
    }

    /// The eccentricity in degrees and the omega in degrees per cycle at which a level tests, where the renderer has a
    /// ring.
    #[must_use]
    pub fn tested_at(&self, level: &Level) -> [Option<f64>; 2] {
        let DetailLaw::Ring { eccentricity, mar, .. } = &self.detail else { return [None; 2] };
        let parameters = self.parameters_at(level);
        [eccentricity, mar].map(|name| match parameters.get(name) {
            Some(ParameterValue::Number(value)) => Some(*value),
            _ => None,
        })
    }
}

/// How observers look while stimuli are shown (Weier 2016, §4.2.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fixation {
    /// At the fixation mark.
    Cross,
    /// At a moving target.
    Moving(MovingTarget),
    /// Wherever they like.
    Free,
}

impl Fixation {
    /// Its name in studies and logs.
    #[must_use]
    pub fn as_str(&self) -> &'static str {
        match self {
            Self::Cross => "cross",
            Self::Moving(_) => "moving",
            Self::Free => "free",
        }
    }
}

/// A target that moves on a smooth path, another in every trial but its repetitions; see [`crate::marks::TargetPath`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingTarget {
    /// Root mean square of its speed, degrees per second.
    pub speed_deg_s: f64,
    /// How far it goes from the fixation mark, right and up, degrees.
    pub reach_deg: [f64; 2],
    /// Its diameter, degrees.
    pub diameter_deg: f64,
}

/// What a renderer takes for the gaze.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FoveationCentre {
    /// The measured gaze.
    #[default]
    Gaze,
    /// The fixation mark or the moving target, wherever the gaze is.
    Target,
}
