//! The trial machine's vocabulary: what is presented, what may be entered, how a trial ends.
//!
//! A [`Protocol`] is a pure machine with neither clock nor I/O: it is told what happened and says what to show next. A
//! stage (a window, an offscreen target, a test) presents each [`Phase`] and reports back.

pub mod two_interval;

use serde::{Deserialize, Serialize};

/// How a trial asks.
///
/// The first call passes `None` and yields the first phase. Each later call passes what happened during the phase that
/// is being shown: [`Input::Elapsed`] when its time is up, or an input that the phase accepts. A protocol is never
/// called again after it has returned [`Step::End`].
pub trait Protocol: std::fmt::Debug {
    /// Says what to show next.
    fn next(&mut self, input: Option<&Input>) -> Step;
}

/// What a protocol wants now.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Present this.
    Show(Phase),
    /// The trial is over.
    End(Outcome),
}

/// One stretch of a trial during which the same thing is presented.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// Which part of the trial this is.
    pub name: PhaseName,
    /// What is presented.
    pub presentation: Presentation,
    /// How long, in seconds; without it, until an accepted input.
    pub duration_s: Option<f64>,
    /// Answers that end the phase.
    pub accepts: Vec<Answer>,
    /// Whether leaving the fixation gate aborts the trial.
    pub gated: bool,
    /// Whether the phase's time runs only while gaze is inside the fixation gate.
    pub hold_for_gaze: bool,
}

/// The name of a phase, as written to logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PhaseName {
    /// A page of text.
    Page,
    /// The fixation mark.
    Fixate,
    /// The first interval.
    Interval1,
    /// Grey between intervals.
    Gap,
    /// The second interval.
    Interval2,
    /// The question.
    Ask,
    /// Right or wrong, in practice.
    Feedback,
    /// Grey between trials, while the last one is being saved.
    Save,
    /// The session is paused.
    Paused,
}

impl PhaseName {
    /// The name as written to logs.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Page => "page",
            Self::Fixate => "fixate",
            Self::Interval1 => "interval1",
            Self::Gap => "gap",
            Self::Interval2 => "interval2",
            Self::Ask => "ask",
            Self::Feedback => "feedback",
            Self::Save => "save",
            Self::Paused => "paused",
        }
    }
}

/// What is on the display.
#[derive(Debug, Clone, PartialEq)]
pub enum Presentation {
    /// Uniform mid grey.
    Grey,
    /// The fixation mark on grey.
    Fixation,
    /// The condition's scene.
    Stimulus(Alternative),
    /// Text on grey.
    Text(String),
}

/// Which of the two pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alternative {
    /// The full-resolution reference.
    Reference,
    /// The condition's renderer at the trial's level.
    Test,
}

/// What an observer can say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// "The first."
    First,
    /// "The second."
    Second,
    /// "Go on."
    Continue,
}

/// What happened to a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "kebab-case")]
pub enum Input {
    /// Its time is up.
    Elapsed,
    /// The observer answered.
    Answered {
        /// What they said.
        answer: Answer,
    },
    /// Gaze left the fixation gate.
    GazeLeft,
    /// Somebody asked for a pause.
    Pause,
    /// The pause is over.
    Resume,
    /// The last trial is on disk.
    Saved,
    /// The program was ended or killed and has started again.
    Reopened,
}

/// How a trial ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "kebab-case")]
pub enum Outcome {
    /// With an answer.
    Answered {
        /// What was said.
        answer: Answer,
        /// Whether it named the degraded interval.
        correct: bool,
    },
    /// No answer in time; the trial is queued again.
    TimedOut,
    /// Gaze left the gate, the session was paused or the program ended; the trial is queued again.
    Aborted {
        /// Why.
        reason: AbortReason,
    },
}

/// Why a trial was aborted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AbortReason {
    /// Gaze left the fixation gate.
    GazeLeft,
    /// The session was paused in the middle of the trial.
    Paused,
    /// The program ended in the middle of the trial.
    Interrupted,
}
