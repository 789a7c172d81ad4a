//! A whole session in virtual time, without display, gaze or disk: for tests, and for planning studies.
//!
//! It feeds the same machine as every stage; only the pictures, the eye and the files are missing.

use super::{Event, Session, Stamped};
use crate::observers::Observer;
use crate::observers::rejoin::presented;
use crate::study::Plan;
use crate::trial::{Input, PhaseName};
use std::sync::Arc;

/// Inputs after which a session is given up: no study that passes its checks needs as many.
const MAX_INPUTS: u64 = 10_000_000;

/// Runs a session with an observer who answers every question, and returns its events.
///
/// An observer who never answers a question without a timeout ends the simulation at that point.
#[must_use]
pub fn simulate(plan: &Arc<Plan>, seed: u64, observer: &mut dyn Observer) -> Vec<Stamped> {
    let (mut session, first) = Session::begin(Arc::clone(plan), seed);
    let mut journal: Vec<Stamped> = Vec::new();
    let mut t_s = 0.0;
    let log = |t_s: f64, events: Vec<Event>, journal: &mut Vec<Stamped>| {
        for event in events {
            journal.push(Stamped { seq: journal.len() as u64, t_s, event });
        }
    };
    log(t_s, first, &mut journal);
    for _ in 0..MAX_INPUTS {
        let Some(phase) = session.phase() else {
            break;
        };
        let level = session.shown_level();
        let answer = observer.meet(&presented(&session, phase, level.as_ref())).answer;
        let (input, after_s) = match (answer, phase.duration_s) {
            _ if phase.name == PhaseName::Save => (Input::Saved, 0.0),
            (Some((answer, after_s)), None) => (Input::Answered { answer }, after_s),
            (Some((answer, after_s)), Some(limit_s)) if after_s < limit_s => (Input::Answered { answer }, after_s),
            (_, Some(limit_s)) => (Input::Elapsed, limit_s),
            (None, None) => break,
        };
        t_s += after_s;
        let events = session.handle(t_s, input);
        log(t_s, events, &mut journal);
    }
    journal
}
