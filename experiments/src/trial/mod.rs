//! The trial machine's vocabulary: what is presented, what may be entered, how a trial ends.
//!
//! A [`Protocol`] is a pure machine with neither clock nor I/O: it is told what happened and says what to show next. A
//! stage (a window, an offscreen target, a test) presents each [`Phase`] and reports back.

pub mod adjustment;
pub mod feedback;
pub mod form;
pub mod keys;
pub mod likert;
pub mod pair;
pub mod paired_task;
pub mod ramp;
pub mod slider;
pub mod toggle;
pub mod two_interval;

use crate::marks::Spheres;
use crate::study::plan::{BlockPlan, Level, ProtocolPlan};
use adjustment::Adjustment;
use feedback::WithFeedback;
use likert::Likert;
use pair::Pair;
use paired_task::PairedTask;
use ramp::Ramp;
use serde::{Deserialize, Serialize};
use slider::Slider;
use std::collections::BTreeMap;
use toggle::Toggle;
use two_interval::TwoInterval;

/// How a trial asks.
///
/// The first call passes `None` and yields the first phase. Each later call passes what happened during the phase that
/// is being shown: [`Input::Elapsed`] when its time is up, or an input that the phase accepts. A protocol is never
/// called again after it has returned [`Step::End`].
pub trait Protocol: std::fmt::Debug {
    /// Says what to show next.
    fn next(&mut self, input: Option<&Input>) -> Step;
}

/// What a trial is started with, besides its block.
#[derive(Debug, Clone, Copy)]
pub struct Setup<'a> {
    /// What the procedure chose.
    pub level: &'a Level,
    /// Which picture comes first; in a ramp, whether it starts at the reference quality.
    pub order: [Alternative; 2],
    /// Decides what a task shows; see [`crate::session::Trial::path_seed`].
    pub path_seed: u64,
}

/// Starts a trial of a block: its protocol, with feedback in practice.
#[must_use]
pub fn start(block: &BlockPlan, setup: Setup<'_>) -> Box<dyn Protocol> {
    let protocol: Box<dyn Protocol> = match &block.protocol {
        ProtocolPlan::TwoInterval(plan) => Box::new(TwoInterval::new(plan, setup.order)),
        ProtocolPlan::Toggle(plan) => Box::new(Toggle::new(plan, setup.order)),
        ProtocolPlan::Pair(plan) => Box::new(Pair::new(plan, setup.order)),
        ProtocolPlan::Ramp(plan) => Box::new(Ramp::new(plan, setup.level, setup.order)),
        ProtocolPlan::Slider(plan) => Box::new(Slider::new(plan)),
        ProtocolPlan::Likert(plan) => Box::new(Likert::new(plan)),
        ProtocolPlan::Adjustment(plan) => Box::new(Adjustment::new(plan, setup.level)),
        ProtocolPlan::PairedTask(plan) => Box::new(PairedTask::new(plan, setup.order, setup.path_seed)),
    };
    if block.practice { Box::new(WithFeedback::new(protocol, block.feedback_s)) } else { protocol }
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
    /// Answers that are taken; any other changes nothing. In the order in which digit keys stand for them.
    pub accepts: Vec<Answer>,
    /// Characters that are taken, as [`Answer::Typed`], besides [`Answer::Erase`].
    pub typing: Option<Typing>,
    /// What is being asked, where something is.
    pub asked: Option<Asked>,
    /// What gaze may do meanwhile.
    pub gaze: GazeRule,
}

impl Phase {
    /// A phase that takes no answer and does not mind the gaze.
    #[must_use]
    pub fn new(name: PhaseName, presentation: Presentation, duration_s: Option<f64>) -> Self {
        Self { name, presentation, duration_s, accepts: Vec::new(), typing: None, asked: None, gaze: GazeRule::Free }
    }

    /// The phase with a question and the answers that it takes.
    #[must_use]
    pub fn asking(self, asked: Asked, accepts: Vec<Answer>) -> Self {
        Self { asked: Some(asked), accepts, ..self }
    }

    /// The phase with a rule for the gaze.
    #[must_use]
    pub fn with_gaze(self, gaze: GazeRule) -> Self {
        Self { gaze, ..self }
    }

    /// Whether an answer is taken.
    #[must_use]
    pub fn takes(&self, answer: Answer) -> bool {
        match answer {
            Answer::Typed(character) => self.typing.is_some_and(|typing| typing.takes(character)),
            Answer::Erase => self.typing.is_some(),
            _ => self.accepts.contains(&answer),
        }
    }
}

/// What gaze may do during a phase, where the study has a fixation gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GazeRule {
    /// Anything.
    Free,
    /// The phase's time runs only while gaze is inside the gate.
    Hold,
    /// Leaving the gate aborts the trial.
    Abort,
    /// Leaving the gate is told to the protocol, which hides the stimulus ([`Input::GazeLeft`]).
    Hide,
    /// The stimulus is hidden; coming back is told to the protocol ([`Input::GazeReturned`]).
    AwaitReturn,
}

/// What may be typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Typing {
    /// Digits, a point and a minus.
    Number,
    /// Anything that can be printed.
    Text,
}

impl Typing {
    /// Whether a character is taken.
    #[must_use]
    pub fn takes(self, character: char) -> bool {
        match self {
            Self::Number => character.is_ascii_digit() || character == '.' || character == '-',
            Self::Text => !character.is_control(),
        }
    }
}

/// What a phase asks.
///
/// Simulated observers answer by it, and logs say it. A person reads the question's own words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Asked {
    /// Which of two was degraded; First or Second.
    WhichDegraded,
    /// Which of two was the full-resolution reference; First or Second.
    WhichReference,
    /// Which of two was better; First, Second or Same.
    WhichBetter,
    /// Whether quality rose, fell or stayed; Increased, Decreased or Same.
    Direction,
    /// Toggle between two (Switch), and say when sure (First or Second) which was degraded.
    ToggleDegraded,
    /// Toggle between two (Switch), and say when sure (First or Second) which was the reference.
    ToggleReference,
    /// Slider: Up, Down, Compare with the reference, or Continue when both look the same.
    Match,
    /// Adjustment: Up and Down of one of several parameters, Select the next, Compare with the reference, or Continue.
    Adjust,
    /// How far a statement is agreed with; an Option.
    Agreement,
    /// A choice among options; an Option.
    Choice,
    /// A number or a text, typed and confirmed with Continue.
    Entry,
    /// How many there were; a number, typed and confirmed with Continue.
    Count,
    /// Consent: First agrees, Second does not.
    Consent,
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
    /// Grey or black between intervals, steps or alternatives.
    Gap,
    /// The second interval.
    Interval2,
    /// One step of a ramp.
    Step,
    /// A sequence that is rated afterwards.
    Sequence,
    /// The alternative A of a toggled comparison.
    AlternativeA,
    /// The alternative B of a toggled comparison.
    AlternativeB,
    /// The reference, to compare with.
    Reference,
    /// The test, to be adjusted.
    Adjust,
    /// A task is explained.
    Task,
    /// Grey with the mark after a sequence.
    Marker,
    /// The stimulus is hidden until gaze is back.
    Hidden,
    /// The question.
    Ask,
    /// An item of a form.
    Form,
    /// The consent page.
    Consent,
    /// Right or wrong, in practice.
    Feedback,
    /// Grey between trials, while the last one is being saved.
    Save,
    /// The session is paused.
    Paused,
}

impl PhaseName {
    /// Every phase.
    pub const ALL: [Self; 20] = [
        Self::Page,
        Self::Fixate,
        Self::Interval1,
        Self::Gap,
        Self::Interval2,
        Self::Step,
        Self::Sequence,
        Self::AlternativeA,
        Self::AlternativeB,
        Self::Reference,
        Self::Adjust,
        Self::Task,
        Self::Marker,
        Self::Hidden,
        Self::Ask,
        Self::Form,
        Self::Consent,
        Self::Feedback,
        Self::Save,
        Self::Paused,
    ];

    /// The phase with a name as written to logs.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|phase| phase.as_str() == name)
    }

    /// The name as written to logs.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Page => "page",
            Self::Fixate => "fixate",
            Self::Interval1 => "interval1",
            Self::Gap => "gap",
            Self::Interval2 => "interval2",
            Self::Step => "step",
            Self::Sequence => "sequence",
            Self::AlternativeA => "alternative-a",
            Self::AlternativeB => "alternative-b",
            Self::Reference => "reference",
            Self::Adjust => "adjust",
            Self::Task => "task",
            Self::Marker => "marker",
            Self::Hidden => "hidden",
            Self::Form => "form",
            Self::Consent => "consent",
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
    /// Black.
    Black,
    /// The fixation mark on grey.
    Fixation,
    /// The condition's scene.
    Stimulus(Stimulus),
    /// Text on grey.
    Text(String),
    /// A statement or question over a row of labelled steps, on grey.
    Scale(Scale),
}

impl Presentation {
    /// A stimulus at the trial's own level.
    #[must_use]
    pub fn stimulus(alternative: Alternative) -> Self {
        Self::Stimulus(Stimulus::new(alternative))
    }
}

/// A picture of the condition's scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Stimulus {
    /// Which picture.
    pub alternative: Alternative,
    /// What is shown instead of the trial's level, parameter by parameter: ramps, sliders and adjustments move within
    /// a trial.
    pub level: Level,
    /// Which clock the scene runs on.
    pub clock: SceneClock,
    /// A letter at the centre in place of the fixation mark.
    pub letter: Option<char>,
    /// Spheres to be counted, if that is the task.
    pub spheres: Option<Spheres>,
}

impl Stimulus {
    /// A picture at the trial's own level, on a clock that starts with the phase.
    #[must_use]
    pub fn new(alternative: Alternative) -> Self {
        Self { alternative, level: Level::new(), clock: SceneClock::Phase, letter: None, spheres: None }
    }
}

/// Which clock a scene's animation runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneClock {
    /// From the start of the phase: both intervals show the same sequence.
    Phase,
    /// From the trial's first stimulus: what is toggled or adjusted goes on moving.
    Trial,
}

/// A row of steps to choose from.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The statement or question.
    pub question: String,
    /// What stands under each step; empty texts leave it to its number.
    pub steps: Vec<String>,
    /// What stands at the left end.
    pub low: String,
    /// What stands at the right end.
    pub high: String,
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
    /// "The first", or "A".
    First,
    /// "The second", or "B".
    Second,
    /// "Both the same", "equal", "no change".
    Same,
    /// "Quality has increased."
    Increased,
    /// "Quality has decreased."
    Decreased,
    /// "Go on", "I agree with what is there", "done".
    Continue,
    /// One step up.
    Up,
    /// One step down.
    Down,
    /// "Show me the reference", or back from it.
    Compare,
    /// "Show me the other one."
    Switch,
    /// "The next parameter."
    Select,
    /// An option of a scale or a choice: the scale's own value, or the choice's number from 1.
    Option(i32),
    /// A typed character.
    Typed(char),
    /// Takes back the last typed character.
    Erase,
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
    /// Gaze is inside the fixation gate again.
    GazeReturned,
    /// Somebody asked for a pause.
    Pause,
    /// The pause is over.
    Resume,
    /// The last trial is on disk.
    Saved,
    /// The last trial cannot be put on disk at the moment.
    Unsaved {
        /// Why.
        trouble: Trouble,
    },
    /// The program was ended or killed and has started again.
    Reopened,
}

/// Why a disk does not take what it is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trouble {
    /// It is full.
    Full,
    /// It may not be written.
    ReadOnly,
    /// It is not there any more.
    Gone,
    /// It fails.
    Fails,
}

impl Trouble {
    /// A sentence for the observer.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Full => "The disk is full.",
            Self::ReadOnly => "The folder for the data is read-only.",
            Self::Gone => "The folder for the data is gone.",
            Self::Fails => "The disk fails.",
        }
    }
}

/// What a trial found besides its answer, by name: the slider's `<parameter>`, the adjusted parameters, the values of
/// Likert items, the count of a task.
pub type Found = BTreeMap<String, f64>;

/// How a trial ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "kebab-case")]
pub enum Outcome {
    /// With an answer.
    Answered {
        /// What was said.
        answer: Answer,
        /// Whether it was right: named the picture that was asked for, named the reference as the better one, or named a
        /// ramp's direction. Nothing where there is no right or wrong.
        #[serde(default)]
        correct: Option<bool>,
        /// What else was found.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        found: Found,
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
