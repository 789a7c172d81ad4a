//! Protocols that show reference and test one after the other: two intervals, toggled, pairs, pairs with a task.

use super::{OnGazeLeft, Wanted};

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
    /// The question.
    pub question: String,
    /// Which picture the question asks for.
    pub wanted: Wanted,
}

/// Timing and rules of the toggled 2AFC (Tursun 2019, §5).
#[derive(Debug, Clone, PartialEq)]
pub struct TogglePlan {
    /// Fixation before the first alternative, seconds.
    pub fixation_s: f64,
    /// Uniform grey between the alternatives, seconds.
    pub switch_s: f64,
    /// After so many switches only an answer is taken; without it, switching is free.
    pub most_switches: Option<u32>,
    /// The question, for descriptions: beside a stimulus there is no room for words, so that the block's own page has to
    /// ask it.
    pub question: String,
    /// Which picture the question asks for.
    pub wanted: Wanted,
    /// What follows when gaze leaves the gate.
    pub on_gaze_left: OnGazeLeft,
}

/// Timing and texts of the pair test (Guenter 2012, §5).
#[derive(Debug, Clone, PartialEq)]
pub struct PairPlan {
    /// Fixation before the first sequence, seconds, if there is any.
    pub fixation_s: Option<f64>,
    /// Each sequence, seconds.
    pub sequence_s: f64,
    /// Black between the sequences, seconds.
    pub black_s: f64,
    /// How long an answer is waited for, seconds; without it, for ever.
    pub answer_timeout_s: Option<f64>,
    /// The question.
    pub question: String,
    /// What follows when gaze leaves the gate: not [`OnGazeLeft::Hide`].
    pub on_gaze_left: OnGazeLeft,
}

/// Timing, task and texts of the paired comparison with a task (Stengel 2016, §6.2).
#[derive(Debug, Clone, PartialEq)]
pub struct PairedTaskPlan {
    /// What the observer does meanwhile.
    pub task: Task,
    /// Each sequence, seconds.
    pub sequence_s: f64,
    /// Grey with the fixation mark after each sequence, seconds.
    pub marker_s: f64,
    /// The question about the pair.
    pub question: String,
    /// How long an answer to it is waited for, seconds; without it, for ever.
    pub answer_timeout_s: Option<f64>,
    /// What follows when gaze leaves the gate: not [`OnGazeLeft::Hide`].
    pub on_gaze_left: OnGazeLeft,
}

/// What observers do during a sequence.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// They count spheres (T1).
    Count {
        /// What they are told before.
        instructions: String,
        /// What they are asked after each sequence.
        question: String,
        /// The fewest spheres.
        min: u32,
        /// The most spheres.
        max: u32,
    },
    /// They look around (T2, T4, T6).
    FreeViewing {
        /// What they are told before.
        instructions: String,
    },
    /// They follow the moving target of the condition (T5).
    Follow {
        /// What they are told before.
        instructions: String,
    },
}

impl Task {
    /// What observers are told before the first sequence.
    #[must_use]
    pub fn instructions(&self) -> &str {
        match self {
            Self::Count { instructions, .. } | Self::FreeViewing { instructions } | Self::Follow { instructions } => {
                instructions
            }
        }
    }
}
