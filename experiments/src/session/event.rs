//! Events: everything that happens in a session, as it is written to the journal.
//!
//! Inputs are the cause and all other events their consequence: feeding a journal's inputs to a new
//! [`super::Session`] of the same plan and seed gives the same events again. That one fact is resume, replay and the check
//! that a journal is what it claims to be.

use crate::procedures::Estimate;
use crate::study::plan::Level;
use crate::trial::{Alternative, Input, Outcome, PhaseName};
use serde::{Deserialize, Serialize};

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// The log was opened. The only event that no input causes; the hash ties the journal to its header.
    Opened {
        /// SHA-256 of the header without its wall-clock time, in hex.
        header_sha256: String,
    },
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
    /// A block ended.
    BlockEnded {
        /// Its name.
        block: String,
        /// Completed trials.
        completed: u32,
    },
    /// The session is complete.
    Finished,
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
    /// What the procedure chose.
    pub level: Level,
    /// The two pictures in the order of presentation.
    pub order: [Alternative; 2],
    /// The eccentricity at which it tests, where the study has one, degrees.
    pub eccentricity_deg: Option<f64>,
    /// The omega at which it tests, where the study has one, degrees per cycle.
    pub mar_deg: Option<f64>,
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
