//! The record of a session: its journal folded into one row a trial, for analysis and export.
//!
//! The record reads events only; it neither needs the plan nor runs the machine, so data outlive the study's code.

use super::event::{Event, Stamped, Trial};
use crate::procedures::Estimate;
use crate::trial::{Outcome, PhaseName};
use serde::Serialize;

/// One trial, as it went.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrialRecord {
    /// As it was designed.
    #[serde(flatten)]
    pub trial: Trial,
    /// When it began, seconds.
    pub began_s: f64,
    /// When it ended, seconds.
    pub ended_s: f64,
    /// How it ended.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// From the question to the answer, seconds.
    pub response_time_s: Option<f64>,
    /// What the procedure believed afterwards.
    pub estimate: Option<Estimate>,
    /// When each phase began, seconds, in order.
    pub phases: Vec<(PhaseName, f64)>,
}

impl TrialRecord {
    /// Whether the answer was right; nothing for a trial without one.
    #[must_use]
    pub fn correct(&self) -> Option<bool> {
        match self.outcome {
            Outcome::Answered { correct, .. } => Some(correct),
            Outcome::TimedOut | Outcome::Aborted { .. } => None,
        }
    }
}

/// A session's trials and how it stands.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Record {
    /// Trials that ended, in order.
    pub trials: Vec<TrialRecord>,
    /// The trial that had begun but not ended when the journal stops.
    pub open_trial: Option<Trial>,
    /// Whether the session ran to its end.
    pub finished: bool,
    /// Times at which the session was reopened after an end or a kill, seconds.
    pub reopened_s: Vec<f64>,
}

/// A trial that has begun.
struct OpenTrial {
    trial: Trial,
    began_s: f64,
    phases: Vec<(PhaseName, f64)>,
}

impl Record {
    /// Folds events, in their order, into a record.
    #[must_use]
    pub fn from_events<'a>(events: impl IntoIterator<Item = &'a Stamped>) -> Self {
        let mut record = Self::default();
        // A session has one trial at a time.
        let mut open: Option<OpenTrial> = None;
        for Stamped { t_s, event, .. } in events {
            match event {
                Event::TrialBegan(trial) => {
                    open = Some(OpenTrial { trial: trial.clone(), began_s: *t_s, phases: Vec::new() });
                }
                Event::PhaseBegan { trial: Some(_), phase } => {
                    if let Some(open) = &mut open {
                        open.phases.push((*phase, *t_s));
                    }
                }
                Event::TrialEnded { outcome, response_time_s, .. } => {
                    if let Some(OpenTrial { trial, began_s, phases }) = open.take() {
                        record.trials.push(TrialRecord {
                            trial,
                            began_s,
                            ended_s: *t_s,
                            outcome: *outcome,
                            response_time_s: *response_time_s,
                            estimate: None,
                            phases,
                        });
                    }
                }
                Event::Estimated { trial, estimate } => {
                    if let Some(last) = record.trials.iter_mut().rfind(|last| last.trial.trial == *trial) {
                        last.estimate = Some(estimate.clone());
                    }
                }
                Event::Input { input: crate::trial::Input::Reopened, .. } => record.reopened_s.push(*t_s),
                Event::Finished => record.finished = true,
                _ => {}
            }
        }
        record.open_trial = open.map(|open| open.trial);
        record
    }
}
