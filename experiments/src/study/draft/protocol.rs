//! How a trial asks, as a study writes it.

use super::{ItemDraft, NumberList};
use crate::study::plan::{Finer, OnGazeLeft, Wanted};
use schemars::JsonSchema;
use serde::Deserialize;

/// How a trial asks.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ProtocolDraft {
    /// Two intervals, one of them degraded; the observer says which.
    TwoInterval(TwoIntervalDraft),
    /// Two alternatives, A and B, between which the observer switches freely; they say which is the reference.
    Toggle(ToggleDraft),
    /// Two sequences; the observer says which was better, or that both were the same.
    Pair(PairDraft),
    /// Quality rises or falls in steps; the observer says whether it increased, decreased or stayed the same.
    Ramp(RampDraft),
    /// The observer goes up and down in quality until the test looks like the reference.
    Slider(SliderDraft),
    /// A sequence that is rated afterwards, item by item.
    Likert(LikertDraft),
    /// The observer sets several parameters of the renderer until no difference from the reference is seen.
    Adjustment(AdjustmentDraft),
    /// Two sequences, each with a task; the observer says which was better, or that they were equal.
    PairedTask(PairedTaskDraft),
}

/// What follows when gaze leaves the gate during something that is shown for a set time: it cannot hide and go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnGazeLeftTimed {
    /// Nothing.
    #[default]
    Ignore,
    /// The trial ends and is asked again later.
    Abort,
}

impl From<OnGazeLeftTimed> for OnGazeLeft {
    fn from(timed: OnGazeLeftTimed) -> Self {
        match timed {
            OnGazeLeftTimed::Ignore => Self::Ignore,
            OnGazeLeftTimed::Abort => Self::Abort,
        }
    }
}

impl ProtocolDraft {
    /// How long feedback is shown in practice, if the study says; some protocols have no right answers.
    pub(in crate::study) fn feedback_s(&self) -> Option<f64> {
        match self {
            Self::TwoInterval(draft) => draft.feedback_s,
            Self::Toggle(draft) => draft.feedback_s,
            Self::Pair(draft) => draft.feedback_s,
            Self::Ramp(draft) => draft.feedback_s,
            Self::PairedTask(draft) => draft.feedback_s,
            Self::Slider(_) | Self::Likert(_) | Self::Adjustment(_) => None,
        }
    }
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
    /// Which one the question asks for: the "degraded" one (when absent) or the "reference".
    pub asks_for: Option<Wanted>,
    /// The question; "Which one was degraded: the first or the second?" when absent, or the same with "not degraded" where
    /// the reference is asked for.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
}

/// Two alternatives, A and B, between which the observer switches freely; they say which is the reference.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToggleDraft {
    /// Fixation before the first alternative, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub fixation_s: Option<f64>,
    /// Uniform grey between the alternatives, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub switch_s: Option<f64>,
    /// After so many switches only an answer is taken; switching is free when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub most_switches: Option<u32>,
    /// How long "right" or "wrong" is shown in practice, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub feedback_s: Option<f64>,
    /// Which one the question asks for: the "degraded" one or the "reference" (when absent).
    pub asks_for: Option<Wanted>,
    /// The question, for descriptions; "Which one is not degraded: A or B?" when absent, or the same with "degraded". No
    /// words stand beside a stimulus: say it in the block's instructions too.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
    /// What follows when gaze leaves the gate: "hide" the stimulus until it is back (when absent), "abort" the trial, which
    /// is asked again later, or "ignore" it.
    pub on_gaze_left: Option<OnGazeLeft>,
}

/// Two sequences; the observer says which was better, or that both were the same.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairDraft {
    /// Fixation before the first sequence, in seconds; none when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub fixation_s: Option<f64>,
    /// Each sequence, in seconds; 8 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub sequence_s: Option<f64>,
    /// Black between the sequences, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub black_s: Option<f64>,
    /// How long an answer is waited for, in seconds, before the trial is asked again later; for ever when absent.
    #[schemars(range(max = 3600.0), extend("exclusiveMinimum" = 0))]
    pub answer_timeout_s: Option<f64>,
    /// How long "right" or "wrong" is shown in practice, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub feedback_s: Option<f64>,
    /// The question; "Which one was better: the first, the second, or were both the same?" when absent.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
    /// What follows when gaze leaves the gate during a sequence: "ignore" (when absent) or "abort", after which the trial is
    /// asked again later.
    pub on_gaze_left: Option<OnGazeLeftTimed>,
}

/// Quality rises or falls in steps; the observer says whether it increased, decreased or stayed the same.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampDraft {
    /// The renderer parameter that is ramped. The procedure's levels set it too: they are the end that varies.
    #[schemars(required)]
    pub parameter: Option<String>,
    /// The end that is the same in every trial, in the parameter's unit.
    #[schemars(required)]
    pub from: Option<f64>,
    /// Which way the parameter makes the picture finer: "up" (when absent; larger is finer, as with a quality index) or
    /// "down".
    pub finer: Option<Finer>,
    /// Steps, both ends included; 5 when absent.
    #[schemars(range(min = 2, max = 1000))]
    pub steps: Option<u32>,
    /// Each step, in seconds; 5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub step_s: Option<f64>,
    /// Black between steps, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub black_s: Option<f64>,
    /// How long an answer is waited for, in seconds, before the trial is asked again later; for ever when absent.
    #[schemars(range(max = 3600.0), extend("exclusiveMinimum" = 0))]
    pub answer_timeout_s: Option<f64>,
    /// How long "right" or "wrong" is shown in practice, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub feedback_s: Option<f64>,
    /// The question; "Did the quality increase, decrease, or stay the same?" when absent.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
    /// What follows when gaze leaves the gate during a sequence: "ignore" (when absent) or "abort", after which the trial is
    /// asked again later.
    pub on_gaze_left: Option<OnGazeLeftTimed>,
}

/// The observer goes up and down in quality until the test looks like the reference.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SliderDraft {
    /// The renderer parameter that the observer moves.
    #[schemars(required)]
    pub parameter: Option<String>,
    /// Its values in the parameter's unit, from the lowest quality up; at least two, rising or falling throughout.
    #[schemars(required)]
    pub values: Option<NumberList>,
    /// The first showing of the reference, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub reference_s: Option<f64>,
    /// How long a comparison shows the reference, in seconds; until a key when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub compare_s: Option<f64>,
    /// After so many moves the value stays where it is; moving is free when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub most_moves: Option<u32>,
}

/// A sequence that is rated afterwards, item by item.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LikertDraft {
    /// Fixation before the sequence, in seconds; none when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub fixation_s: Option<f64>,
    /// The sequence, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub sequence_s: Option<f64>,
    /// What is asked about it, in order: scales, choices and numbers.
    #[schemars(required)]
    pub items: Option<Vec<Option<ItemDraft>>>,
    /// What follows when gaze leaves the gate during a sequence: "ignore" (when absent) or "abort", after which the trial is
    /// asked again later.
    pub on_gaze_left: Option<OnGazeLeftTimed>,
}

/// The observer sets several parameters of the renderer until no difference from the reference is seen.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdjustmentDraft {
    /// What is adjusted: at most nine parameters of the renderer. A trial starts at its level; what that does not set starts
    /// in the middle of its range.
    #[schemars(required)]
    pub parameters: Option<Vec<Option<AdjustedDraft>>>,
    /// After so many moves, of all parameters together, the values stay where they are; moving is free when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub most_moves: Option<u32>,
}

/// A parameter that the observer adjusts, with its range and either `add` or `multiply`.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdjustedDraft {
    /// The renderer parameter.
    #[schemars(required)]
    pub parameter: Option<String>,
    /// The smallest value, in the parameter's unit.
    #[schemars(required)]
    pub min: Option<f64>,
    /// The largest value, in the parameter's unit.
    #[schemars(required)]
    pub max: Option<f64>,
    /// What one move adds or subtracts.
    pub add: Option<f64>,
    /// What one move multiplies or divides by.
    pub multiply: Option<f64>,
}

/// Two sequences, each with a task; the observer says which was better, or that they were equal.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairedTaskDraft {
    /// What the observer does meanwhile.
    #[schemars(required)]
    pub task: Option<TaskDraft>,
    /// Each sequence, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub sequence_s: Option<f64>,
    /// Grey with the fixation mark after each sequence, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub marker_s: Option<f64>,
    /// How long an answer is waited for, in seconds, before the trial is asked again later; for ever when absent.
    #[schemars(range(max = 3600.0), extend("exclusiveMinimum" = 0))]
    pub answer_timeout_s: Option<f64>,
    /// How long "right" or "wrong" is shown in practice, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub feedback_s: Option<f64>,
    /// The question; "Which one was better: the first, the second, or were they equal?" when absent.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
    /// What follows when gaze leaves the gate during a sequence: "ignore" (when absent) or "abort", after which the trial is
    /// asked again later.
    pub on_gaze_left: Option<OnGazeLeftTimed>,
}

/// What observers do during a sequence.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum TaskDraft {
    /// They count spheres that come and go, and say how many there were.
    Count(CountDraft),
    /// They look around.
    FreeViewing(ViewingDraft),
    /// They follow the moving target of the condition.
    Follow(ViewingDraft),
}

/// Spheres to be counted.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CountDraft {
    /// What observers are told before; a plain sentence when absent.
    #[schemars(length(min = 1))]
    pub instructions: Option<String>,
    /// What they are asked after each sequence; "How many spheres were there?" when absent.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
    /// The fewest spheres.
    #[schemars(required, range(min = 0, max = 1000))]
    pub min: Option<u32>,
    /// The most spheres.
    #[schemars(required, range(min = 1, max = 1000))]
    pub max: Option<u32>,
}

/// A task without an answer of its own.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewingDraft {
    /// What observers are told before; a plain sentence when absent.
    #[schemars(length(min = 1))]
    pub instructions: Option<String>,
}
