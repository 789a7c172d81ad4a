//! The record of a session: its journal folded into one row a trial, for analysis and export.
//!
//! The record reads events only; it neither needs the plan nor runs the machine, so data outlive the study's code.

use super::event::{EndReason, Event, Seam, Stamped, Trial};
use crate::procedures::Estimate;
use crate::study::plan::Level;
use crate::trial::form::Entries;
use crate::trial::{Alternative, Outcome, PhaseName};
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
    /// Its phases, in order.
    pub phases: Vec<PhaseRecord>,
    /// In which part of the session it ran, from 1: a session that was ended or killed and gone on with has several.
    pub part: u32,
}

impl TrialRecord {
    /// Whether the trial was answered and is no practice: what analysis counts.
    #[must_use]
    pub fn counts(&self) -> bool {
        matches!(self.outcome, Outcome::Answered { .. }) && !self.trial.practice
    }

    /// Whether the answer was right; nothing for a trial without one.
    #[must_use]
    pub fn correct(&self) -> Option<bool> {
        match self.outcome {
            Outcome::Answered { correct, .. } => correct,
            Outcome::TimedOut | Outcome::Aborted { .. } => None,
        }
    }
}

/// One phase of a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhaseRecord {
    /// Which.
    pub phase: PhaseName,
    /// When it began, seconds.
    pub began_s: f64,
    /// Which picture was shown, if one was.
    pub shown: Option<Alternative>,
    /// The parameters shown instead of the trial's level.
    pub at: Level,
}

/// A form that was filled in.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FormRecord {
    /// `participant`, or the block whose questionnaire it is.
    pub form: String,
    /// When it was complete, seconds.
    pub t_s: f64,
    /// What was entered, by item.
    pub entries: Entries,
}

/// A session's trials and how it stands.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Record {
    /// Trials that ended, in order.
    pub trials: Vec<TrialRecord>,
    /// The trial that had begun but not ended when the journal stops.
    pub open_trial: Option<Trial>,
    /// Forms that were filled in, in order.
    pub forms: Vec<FormRecord>,
    /// Whether the session ran to its end.
    pub finished: bool,
    /// Why it ended before its design was complete, if it did.
    pub ended: Option<EndReason>,
    /// Times at which the session was reopened after an end or a kill, seconds.
    pub reopened_s: Vec<f64>,
    /// What the journal says of each reopening; logs of format 1 say only when.
    pub seams: Vec<SeamRecord>,
    /// Gaze samples and frames that could not be kept while the disk failed.
    pub dropped: [u64; 2],
}

/// A place where the session went on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SeamRecord {
    /// Number of the mark in the journal.
    pub seq: u64,
    /// When, seconds.
    pub t_s: f64,
    /// With what.
    #[serde(flatten)]
    pub seam: Seam,
}

/// A trial that has begun.
struct OpenTrial {
    trial: Trial,
    began_s: f64,
    phases: Vec<PhaseRecord>,
}

impl Record {
    /// Whether the session cannot go on: it ran to its end, or ended early for good.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.finished || self.ended.is_some()
    }

    /// Folds events, in their order, into a record.
    #[must_use]
    pub fn from_events<'a>(events: impl IntoIterator<Item = &'a Stamped>) -> Self {
        let mut record = Self::default();
        // A session has one trial at a time.
        let mut open: Option<OpenTrial> = None;
        for Stamped { seq, t_s, event } in events {
            match event {
                Event::TrialBegan(trial) => {
                    open = Some(OpenTrial { trial: trial.clone(), began_s: *t_s, phases: Vec::new() });
                }
                Event::PhaseBegan { trial: Some(_), phase, shown, at } => {
                    if let Some(open) = &mut open {
                        open.phases.push(PhaseRecord { phase: *phase, began_s: *t_s, shown: *shown, at: at.clone() });
                    }
                }
                Event::TrialEnded { outcome, response_time_s, .. } => {
                    if let Some(OpenTrial { trial, began_s, phases }) = open.take() {
                        record.trials.push(TrialRecord {
                            trial,
                            began_s,
                            ended_s: *t_s,
                            outcome: outcome.clone(),
                            response_time_s: *response_time_s,
                            estimate: None,
                            phases,
                            part: u32::try_from(record.reopened_s.len()).unwrap_or(u32::MAX).saturating_add(1),
                        });
                    }
                }
                Event::Estimated { trial, estimate } => {
                    if let Some(last) = record.trials.iter_mut().rfind(|last| last.trial.trial == *trial) {
                        last.estimate = Some(estimate.clone());
                    }
                }
                Event::Input { input: crate::trial::Input::Reopened, .. } => record.reopened_s.push(*t_s),
                Event::Continued(seam) => {
                    record.seams.push(SeamRecord { seq: *seq, t_s: *t_s, seam: (**seam).clone() });
                }
                Event::Gap { gaze_samples, frames } => {
                    record.dropped[0] += gaze_samples;
                    record.dropped[1] += frames;
                }
                Event::FormFilled { form, entries } => {
                    record.forms.push(FormRecord { form: form.clone(), t_s: *t_s, entries: entries.clone() });
                }
                Event::Finished => record.finished = true,
                Event::Ended { reason } => record.ended = Some(*reason),
                _ => {}
            }
        }
        record.open_trial = open.map(|open| open.trial);
        record
    }
}
