//! How a trial asks: one plan for each protocol, with what can be said of all of them.
//!
//! `compared` holds the plans of protocols that show reference and test one after the other, `moved` those that move a
//! parameter within a trial; a rated sequence is here.

mod compared;
mod moved;

pub use compared::*;
pub use moved::*;

use super::Item;
use crate::trial::{Alternative, GazeRule};
use schemars::JsonSchema;
use serde::Deserialize;

/// How a trial asks.
#[derive(Debug, Clone, PartialEq)]
pub enum ProtocolPlan {
    /// Two intervals, one of them degraded; "which one was it?".
    TwoInterval(TwoIntervalPlan),
    /// Two alternatives between which the observer switches; "which one is not foveated?".
    Toggle(TogglePlan),
    /// Two sequences; "first better, second better, or the same?".
    Pair(PairPlan),
    /// Quality in steps up or down; "increased, decreased, or the same?".
    Ramp(RampPlan),
    /// The observer goes up and down until the test looks like the reference.
    Slider(SliderPlan),
    /// A sequence, then items to be rated.
    Likert(LikertPlan),
    /// The observer sets several parameters until no difference is seen.
    Adjustment(AdjustmentPlan),
    /// Two sequences, each with a task; "first better, equal, or second better?".
    PairedTask(PairedTaskPlan),
}

/// Switches that a typical toggled trial is taken to have: Tursun's observers made 540 comparisons in 40 minutes (2019, §5),
/// one in 4.4 s.
const TYPICAL_SWITCHES: u32 = 3;
/// Comparisons with the reference that a typical slider trial is taken to have.
const TYPICAL_COMPARISONS: f64 = 2.0;
/// Moves of each parameter that a typical adjustment is taken to have.
const TYPICAL_MOVES: f64 = 10.0;

impl ProtocolPlan {
    /// The `kind` that a study names it by.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::TwoInterval(_) => "two-interval",
            Self::Toggle(_) => "toggle",
            Self::Pair(_) => "pair",
            Self::Ramp(_) => "ramp",
            Self::Slider(_) => "slider",
            Self::Likert(_) => "likert",
            Self::Adjustment(_) => "adjustment",
            Self::PairedTask(_) => "paired-task",
        }
    }

    /// How long stimuli are shown, to be shortened in a pilot run. What the observer ends is not among them.
    pub(crate) fn stimulus_durations_mut(&mut self) -> Vec<&mut f64> {
        match self {
            Self::TwoInterval(plan) => vec![&mut plan.interval_s],
            Self::Toggle(_) | Self::Adjustment(_) => Vec::new(),
            Self::Pair(plan) => vec![&mut plan.sequence_s],
            Self::Ramp(plan) => vec![&mut plan.step_s],
            Self::Slider(plan) => std::iter::once(&mut plan.reference_s).chain(&mut plan.compare_s).collect(),
            Self::Likert(plan) => vec![&mut plan.sequence_s],
            Self::PairedTask(plan) => vec![&mut plan.sequence_s],
        }
    }

    /// How long one trial takes, in seconds, if every answer comes after `answer_s`.
    ///
    /// Where observers set the pace, a typical trial is assumed: three switches of a toggle, each after a look of
    /// `answer_s`; half of a slider's values and two comparisons, each asked for after `answer_s` and shown for
    /// `compare_s` or else `answer_s`; ten moves of each adjusted parameter at `answer_s` each.
    #[must_use]
    pub fn trial_s(&self, answer_s: f64) -> f64 {
        match self {
            Self::TwoInterval(plan) => plan.fixation_s + 2.0 * plan.interval_s + plan.gap_s + answer_s,
            Self::Toggle(plan) => {
                let switches = f64::from(plan.most_switches.unwrap_or(TYPICAL_SWITCHES).min(TYPICAL_SWITCHES));
                plan.fixation_s + switches * (answer_s + plan.switch_s) + answer_s
            }
            Self::Pair(plan) => plan.fixation_s.unwrap_or(0.0) + 2.0 * plan.sequence_s + plan.black_s + answer_s,
            Self::Ramp(plan) => {
                let steps = f64::from(plan.steps);
                steps * plan.step_s + (steps - 1.0) * plan.black_s + answer_s
            }
            Self::Slider(plan) => {
                let moves = 0.5 * plan.values.len() as f64;
                let comparison_s = answer_s + plan.compare_s.unwrap_or(answer_s);
                plan.reference_s + moves * answer_s + TYPICAL_COMPARISONS * comparison_s + answer_s
            }
            Self::Likert(plan) => plan.fixation_s.unwrap_or(0.0) + plan.sequence_s + plan.items.len() as f64 * answer_s,
            Self::Adjustment(plan) => TYPICAL_MOVES * plan.parameters.len() as f64 * answer_s,
            Self::PairedTask(plan) => {
                let counts = if matches!(plan.task, Task::Count { .. }) { 2.0 * answer_s } else { 0.0 };
                answer_s + 2.0 * (plan.sequence_s + plan.marker_s) + counts + answer_s
            }
        }
    }

    /// Whether an answer can be right or wrong, so that practice can tell.
    #[must_use]
    pub fn has_right_answers(&self) -> bool {
        !matches!(self, Self::Slider(_) | Self::Likert(_) | Self::Adjustment(_))
    }

    /// Whether it means anything which of reference and test comes first.
    #[must_use]
    pub fn alternatives_matter(&self) -> bool {
        !matches!(self, Self::Slider(_) | Self::Likert(_) | Self::Adjustment(_))
    }

    /// The renderer parameters that the protocol itself sets in the course of a trial.
    #[must_use]
    pub fn parameters(&self) -> Vec<&str> {
        match self {
            Self::Ramp(plan) => vec![&plan.parameter],
            Self::Slider(plan) => vec![&plan.parameter],
            Self::Adjustment(plan) => plan.parameters.iter().map(|adjusted| adjusted.parameter.as_str()).collect(),
            _ => Vec::new(),
        }
    }

    /// The renderer parameter that every level of the procedure must set: a ramp's goal.
    #[must_use]
    pub fn needs_level(&self) -> Option<&str> {
        match self {
            Self::Ramp(plan) => Some(&plan.parameter),
            _ => None,
        }
    }

    /// Whether the task makes sense only where the condition's fixation is a moving target.
    #[must_use]
    pub fn needs_moving_target(&self) -> bool {
        matches!(self, Self::PairedTask(PairedTaskPlan { task: Task::Follow { .. }, .. }))
    }
}

/// Which of two pictures a forced choice asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Wanted {
    /// The degraded one.
    Degraded,
    /// The full-resolution reference.
    Reference,
}

impl Wanted {
    /// Whether this picture is the one that is asked for.
    #[must_use]
    pub fn is(self, alternative: Alternative) -> bool {
        match self {
            Self::Degraded => alternative == Alternative::Test,
            Self::Reference => alternative == Alternative::Reference,
        }
    }
}

/// What follows when gaze leaves the gate while a stimulus is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnGazeLeft {
    /// Nothing.
    Ignore,
    /// The trial ends and is asked again later.
    Abort,
    /// The stimulus hides until gaze is back; only for stimuli without a duration of their own, since a protocol has no
    /// clock to tell what is left of it.
    Hide,
}

impl OnGazeLeft {
    /// The rule for phases that show a stimulus.
    #[must_use]
    pub fn rule(self) -> GazeRule {
        match self {
            Self::Ignore => GazeRule::Free,
            Self::Abort => GazeRule::Abort,
            Self::Hide => GazeRule::Hide,
        }
    }
}

/// Timing and items of a rated sequence (Weier 2016, §4.2.1).
#[derive(Debug, Clone, PartialEq)]
pub struct LikertPlan {
    /// Fixation before the sequence, seconds, if there is any.
    pub fixation_s: Option<f64>,
    /// The sequence, seconds.
    pub sequence_s: f64,
    /// What is asked about it; never a text.
    pub items: Vec<Item>,
    /// What follows when gaze leaves the gate: not [`OnGazeLeft::Hide`].
    pub on_gaze_left: OnGazeLeft,
}
