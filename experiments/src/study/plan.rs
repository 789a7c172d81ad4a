//! A study that has been checked: every name resolved, every number in bounds, the display known.
//!
//! A [`Plan`] is what the session machine runs. It is not the file: the file's types are in [`super::draft`], and
//! [`super::validate`] is the only way from one to the other.

use crate::catalogue::{ParameterValue, Parameters};
use crate::display::Display;
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
    /// The blocks, in the order in which they run.
    pub blocks: Vec<BlockPlan>,
}

impl Plan {
    /// The most trials that the study can have, all blocks together, aborted ones aside.
    #[must_use]
    pub fn max_trials(&self) -> u32 {
        self.blocks.iter().map(|block| block.procedure.max_trials()).fold(0, u32::saturating_add)
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

/// A fixation gate: when gaze leaves it during an interval, the stimulus hides and the trial is aborted and queued again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GatePlan {
    /// Radius of the gate around the fixation mark, in degrees of eccentricity.
    pub radius_deg: f64,
    /// How long gaze may be outside or lost (a blink, a noisy sample) before it counts, in seconds.
    pub grace_s: f64,
}

/// The pages of a study.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Texts {
    /// Pages before the first block, in order.
    pub instructions: Vec<String>,
    /// Shown at a break; may be empty.
    pub pause: String,
    /// The last page.
    pub thanks: String,
}

/// One block of trials that share a condition, a protocol and a procedure.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockPlan {
    /// Name, unique in the study.
    pub name: String,
    /// Practice gives feedback and is left out of the fits.
    pub practice: bool,
    /// A page before the block, if any.
    pub instructions: Option<String>,
    /// What is shown.
    pub condition: Condition,
    /// How a trial asks.
    pub protocol: ProtocolPlan,
    /// How the next level is chosen.
    pub procedure: ProcedurePlan,
    /// A break after this many completed trials, if any.
    pub break_every_trials: Option<u32>,
}

/// One cell of the design.
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
}

impl Condition {
    /// The renderer's parameters at a level: the condition's own, with the level's on top.
    #[must_use]
    pub fn parameters_at(&self, level: &Level) -> Parameters {
        let mut parameters = self.renderer_parameters.clone();
        parameters.extend(level.iter().map(|(name, &value)| (name.clone(), ParameterValue::Number(value))));
        parameters
    }
}

/// How a trial asks.
#[derive(Debug, Clone, PartialEq)]
pub enum ProtocolPlan {
    /// Two intervals, one of them degraded; "which one was it?".
    TwoInterval(TwoIntervalPlan),
}

impl ProtocolPlan {
    /// How long one trial takes, in seconds, if the answer comes after `answer_s`.
    #[must_use]
    pub fn trial_s(&self, answer_s: f64) -> f64 {
        match self {
            Self::TwoInterval(plan) => plan.fixation_s + 2.0 * plan.interval_s + plan.gap_s + answer_s,
        }
    }
}

/// Timing and texts of the two-interval 2AFC.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoIntervalPlan {
    /// Fixation before the first interval, seconds.
    pub fixation_s: f64,
    /// Each interval, seconds.
    pub interval_s: f64,
    /// Grey between the intervals, seconds.
    pub gap_s: f64,
    /// How long an answer is waited for, seconds; without it, for ever.
    pub answer_timeout_s: Option<f64>,
    /// How long feedback is shown in practice, seconds.
    pub feedback_s: f64,
    /// The question.
    pub question: String,
}

/// How the next level is chosen.
#[derive(Debug, Clone, PartialEq)]
pub enum ProcedurePlan {
    /// Constant stimuli: every level, so many times, shuffled.
    Constant(ConstantPlan),
    /// QUEST+ over the MAR model.
    QuestPlus(QuestPlusPlan),
}

impl ProcedurePlan {
    /// Every level that may be shown.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        match self {
            Self::Constant(plan) => &plan.levels,
            Self::QuestPlus(plan) => &plan.levels,
        }
    }

    /// The most trials that the block can have, aborted ones aside.
    #[must_use]
    pub fn max_trials(&self) -> u32 {
        match self {
            Self::Constant(plan) => plan.repetitions.saturating_mul(plan.levels.len() as u32),
            Self::QuestPlus(plan) => plan.stop.max_trials,
        }
    }

    /// The fewest trials that the block can have.
    #[must_use]
    pub fn min_trials(&self) -> u32 {
        match self {
            Self::Constant(_) => self.max_trials(),
            Self::QuestPlus(plan) if plan.stop.has_posterior_rule() => plan.stop.min_trials,
            Self::QuestPlus(plan) => plan.stop.max_trials,
        }
    }

    /// The renderer parameters that carry eccentricity and MAR, for the analysis.
    #[must_use]
    pub fn axes(&self) -> &MarAxes {
        match self {
            Self::Constant(plan) => &plan.axes,
            Self::QuestPlus(plan) => &plan.axes,
        }
    }
}

/// Which renderer parameters a MAR analysis reads.
#[derive(Debug, Clone, PartialEq)]
pub struct MarAxes {
    /// The parameter that is the eccentricity, in degrees.
    pub eccentricity: String,
    /// The parameter that is omega, in degrees per cycle.
    pub mar: String,
}

impl Default for MarAxes {
    fn default() -> Self {
        Self { eccentricity: "eccentricity_deg".to_owned(), mar: "mar_deg".to_owned() }
    }
}

/// Constant stimuli.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantPlan {
    /// The levels, each shown `repetitions` times.
    pub levels: Vec<Level>,
    /// Times each level is shown.
    pub repetitions: u32,
    /// Where the analysis finds eccentricity and omega.
    pub axes: MarAxes,
}

/// QUEST+ over the MAR model (Watson 2017; the model is [`crate::mar::MarModel`]).
#[derive(Debug, Clone, PartialEq)]
pub struct QuestPlusPlan {
    /// The stimuli: eccentricity × omega, without those finer than the display can show.
    pub levels: Vec<Level>,
    /// How many eccentricity × omega pairs were left out because the display cannot show them.
    pub levels_beyond_display: usize,
    /// Where eccentricity and omega are set.
    pub axes: MarAxes,
    /// Whether every eccentricity comes equally often, in shuffled rounds, so that the line can be held against the
    /// thresholds; else the procedure asks wherever it learns most about the line, which is at its two ends.
    pub balanced: bool,
    /// Prior values of m, uniform.
    pub m: Vec<f64>,
    /// Prior values of omega0 in degrees per cycle, uniform.
    pub omega0_deg: Vec<f64>,
    /// Prior values of the width in ln omega, uniform.
    pub width: Vec<f64>,
    /// Prior values of the lapse rate, uniform.
    pub lapse: Vec<f64>,
    /// When to stop.
    pub stop: StopRule,
}

/// When an adaptive block ends: at `max_trials`, or as soon as `min_trials` are done and every posterior rule holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopRule {
    /// The block never has more completed trials.
    pub max_trials: u32,
    /// The posterior rules are not asked before.
    pub min_trials: u32,
    /// Posterior SD of m divided by its mean, at most.
    pub m_relative_sd: Option<f64>,
    /// Posterior SD of omega0 divided by its mean, at most.
    pub omega0_relative_sd: Option<f64>,
}

impl StopRule {
    /// Whether the block can end before `max_trials`.
    #[must_use]
    pub fn has_posterior_rule(&self) -> bool {
        self.m_relative_sd.is_some() || self.omega0_relative_sd.is_some()
    }
}
