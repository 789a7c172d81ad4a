//! Events: everything that happens in a session, as it is written to the journal.
//!
//! Inputs are the cause and all other events their consequence: feeding a journal's inputs to a new
//! [`super::Session`] of the same plan and seed gives the same events again. That one fact is resume, replay and the check
//! that a journal is what it claims to be.

use crate::procedures::Estimate;
use crate::study::plan::Level;
use crate::trial::form::Entries;
use crate::trial::{Alternative, Input, Outcome, PhaseName};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// A mark of the log: the log was opened. The hash ties the journal to its header.
    Opened {
        /// SHA-256 of the header without its wall-clock time, in hex.
        header_sha256: String,
        /// The [`Rules`] by which the session proceeds.
        #[serde(default, skip_serializing_if = "Rules::are_first")]
        rules: Rules,
    },
    /// A mark of the log: everything before it was to be on disk together.
    Tables(Rows),
    /// A mark of the log: the session went on after an end or a kill. The input `reopened` follows.
    Continued(Box<Seam>),
    /// A mark of the log: while the disk failed, more came than could be kept, and this was left out.
    Gap {
        /// Gaze samples that are in no table.
        gaze_samples: u64,
        /// Frames that are in no table.
        frames: u64,
    },
    /// A mark of the log: this folder is a repaired copy, and ends where the original was sound.
    Repaired {
        /// Rows that the copy's tables have, whatever earlier marks say.
        rows: Rows,
        /// What was left out, in words.
        left_out: Vec<String>,
    },
    /// A mark of the log: the program ended in order, with the session finished or left.
    Closed(Rows),
    /// The world did something. Inputs that the current phase does not accept are written too, and change nothing.
    Input {
        /// What.
        #[serde(flatten)]
        input: Input,
        /// Whether the machine took it.
        accepted: bool,
    },
    /// A block began.
    BlockBegan {
        /// Its name.
        block: String,
    },
    /// A trial began.
    TrialBegan(Trial),
    /// Something else is presented from now on.
    PhaseBegan {
        /// The trial it belongs to, if any.
        trial: Option<u32>,
        /// Which phase.
        phase: PhaseName,
        /// Which picture is shown, if one is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        shown: Option<Alternative>,
        /// The parameters that the phase shows instead of the trial's level: a ramp's, a slider's or an adjustment's.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        at: Level,
    },
    /// A trial ended.
    TrialEnded {
        /// Which.
        trial: u32,
        /// How.
        #[serde(flatten)]
        outcome: Outcome,
        /// From the start of the question to the answer, seconds.
        response_time_s: Option<f64>,
    },
    /// What an adaptive procedure believes after the trial.
    Estimated {
        /// The trial that was taken in.
        trial: u32,
        /// Mean and SD by quantity.
        estimate: Estimate,
    },
    /// A form was filled in.
    FormFilled {
        /// `participant`, or the block whose questionnaire it is.
        form: String,
        /// What was entered, by item.
        entries: Entries,
    },
    /// A round of a practice block with a criterion was judged.
    PracticeJudged {
        /// The block.
        block: String,
        /// The round, from 1.
        round: u32,
        /// Share of right answers, 0–1.
        share_correct: f64,
        /// Whether that was enough.
        passed: bool,
    },
    /// A block ended.
    BlockEnded {
        /// Its name.
        block: String,
        /// Completed trials.
        completed: u32,
    },
    /// The session ended before its design was complete, and cannot go on.
    Ended {
        /// Why.
        reason: EndReason,
    },
    /// The session is complete.
    Finished,
}

impl Event {
    /// Whether this is a mark of the log's own, which no input causes and the machine knows nothing of.
    #[must_use]
    pub fn is_mark(&self) -> bool {
        matches!(
            self,
            Self::Opened { .. }
                | Self::Tables(_)
                | Self::Continued(_)
                | Self::Gap { .. }
                | Self::Repaired { .. }
                | Self::Closed(_)
        )
    }
}

/// By which rules a machine proceeds, where they have changed: a journal is folded by those that it was written by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rules {
    /// A trial that was interrupted by the end of the program comes again later; after a pause between trials the next
    /// one begins at once.
    #[default]
    First,
    /// A trial that was interrupted by the end of the program comes again at once, as if it had never begun, so that the
    /// session goes on like an unbroken one; after a pause between trials the last one is waited for until it is on disk.
    Second,
}

impl Rules {
    /// Those of new sessions.
    pub const NEWEST: Self = Self::Second;

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
    fn are_first(&self) -> bool {
        *self == Self::First
    }
}

/// How many rows the tables beside the journal have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Rows {
    /// Rows of `gaze.csv`.
    pub gaze_rows: u64,
    /// Rows of `frames.csv`.
    pub frame_rows: u64,
}

/// Where a session went on: when, with what, and what was different from then on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Seam {
    /// Wall-clock time, RFC 3339.
    pub wall: String,
    /// Name and version of the program.
    pub program: String,
    /// The graphics adapter and driver, where pictures are drawn.
    pub gpu: Option<String>,
    /// Seconds between frames from here on.
    pub frame_s: f64,
    /// How frames are paced from here on.
    pub pacing: String,
    /// What is different from what was before and was accepted with `--force`; empty for a session that goes on as it was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changed: Vec<Change>,
    /// The study's text from here on, if that is different.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<String>,
    /// The display from here on, in the form of a display file, if that is different.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub display: Option<serde_json::Value>,
}

/// One difference.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    /// Where, for example `study: blocks[0].protocol.interval_s`.
    pub field: String,
    /// What it was; empty if it was not there.
    pub from: String,
    /// What it is; empty if it is gone.
    pub to: String,
}

/// Why a session ended before its design was complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndReason {
    /// The participant did not consent.
    Declined,
    /// Practice was not passed, and the study ends there.
    PracticeFailed,
}

/// One trial, as designed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Number within the session, from 1; aborted trials have numbers too.
    pub trial: u32,
    /// Its block.
    pub block: String,
    /// Whether it is practice.
    pub practice: bool,
    /// Its condition.
    pub condition: String,
    /// Factor → level, where the block has factors.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub factors: BTreeMap<String, String>,
    /// What the procedure chose.
    pub level: Level,
    /// The two pictures in the order of presentation.
    pub order: [Alternative; 2],
    /// The eccentricity at which it tests, where the study has one, degrees.
    pub eccentricity_deg: Option<f64>,
    /// The omega at which it tests, where the study has one, degrees per cycle.
    pub mar_deg: Option<f64>,
    /// Which repetition of its cell and level it is, from 1, where the design counts them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repetition: Option<u32>,
    /// Decides the moving target's path and the spheres to count: the same in all repetitions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path_seed: Option<u64>,
}

/// An event with its number and time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stamped {
    /// Position in the journal, from 0, without gaps.
    pub seq: u64,
    /// Seconds since the session's start.
    pub t_s: f64,
    /// What happened.
    #[serde(flatten)]
    pub event: Event,
}
