//! Folding a journal again: the same inputs through the same machine, and the check that they give the same events.
//!
//! Resuming needs the machine's state, replaying needs what was presented when; both come from here, so that neither can
//! differ from the run.

use super::event::Rules;
use super::{Event, Session, Stamped};
use crate::study::Plan;
use crate::trial::Input;
use std::sync::Arc;

/// A session brought back from its journal.
#[derive(Debug)]
pub struct Refolded {
    /// The machine, where the journal left it.
    pub session: Session,
    /// Consequences of the last input that the journal does not hold, because it was cut off between the two. They go
    /// into the journal before anything else.
    pub missing: Vec<Event>,
}

/// The journal says something else than the machine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "event {seq} of the journal is not what the study gives there: expected {expected}, found {found}; the study, the \
     seed or the program is not the one that wrote it"
)]
pub struct Disagreement {
    /// Number of the event.
    pub seq: u64,
    /// What the machine says.
    pub expected: String,
    /// What the journal says.
    pub found: String,
}

/// Feeds a journal's inputs to a new session of `plan` and `seed`.
///
/// `visit` is called whenever a new phase has begun, with the session and the number of the event that began it (for the
/// last phase, if that event is among the missing ones, a number near it that no event has).
///
/// # Errors
/// At the first event of the journal that the machine does not give.
pub fn refold(
    plan: Arc<Plan>,
    seed: u64,
    journal: &[Stamped],
    mut visit: impl FnMut(&Session, u64),
) -> Result<Refolded, Disagreement> {
    let rules = match journal.first().map(|first| &first.event) {
        Some(Event::Opened { rules, .. }) => *rules,
        _ => Rules::NEWEST,
    };
    let (mut session, mut caused) = Session::begin_by(rules, plan, seed);
    // The log's own marks are no business of the machine. A repaired copy may have one even between an input and what it
    // caused, where the original was cut.
    let past_marks = |mut next: usize| {
        while journal.get(next).is_some_and(|stamped| stamped.event.is_mark()) {
            next += 1;
        }
        next
    };
    let mut next = past_marks(0);
    loop {
        // Hold what the machine gave against the journal, event by event.
        let mut began_phase = None;
        for (index, expected) in caused.iter().enumerate() {
            next = past_marks(next);
            let Some(found) = journal.get(next) else {
                let missing = caused.split_off(index);
                if missing.iter().any(|event| matches!(event, Event::PhaseBegan { .. })) && !session.finished() {
                    visit(&session, (next + missing.len()) as u64 - 1);
                }
                return Ok(Refolded { session, missing });
            };
            if found.event != *expected {
                return Err(Disagreement {
                    seq: found.seq,
                    expected: in_words(expected),
                    found: in_words(&found.event),
                });
            }
            if matches!(expected, Event::PhaseBegan { .. }) {
                began_phase = Some(found.seq);
            }
            next += 1;
        }
        if let Some(seq) = began_phase
            && !session.finished()
        {
            visit(&session, seq);
        }

        // The next event is an input, or the journal ends here.
        next = past_marks(next);
        match journal.get(next) {
            None => return Ok(Refolded { session, missing: Vec::new() }),
            Some(Stamped { event: Event::Input { input, .. }, t_s, .. }) => caused = session.handle(*t_s, *input),
            Some(Stamped { event, seq, .. }) => {
                return Err(Disagreement { seq: *seq, expected: "an input".to_owned(), found: in_words(event) });
            }
        }
    }
}

/// Whether the phase that event `seq` of a journal began came of reopening the session.
#[must_use]
pub fn seam_at(journal: &[Stamped], seq: u64) -> bool {
    let before = journal.get(..usize::try_from(seq).unwrap_or(usize::MAX)).unwrap_or(journal);
    let input = before.iter().rev().find_map(|stamped| match stamped.event {
        Event::Input { input, .. } => Some(input),
        _ => None,
    });
    input == Some(Input::Reopened)
}

fn in_words(event: &Event) -> String {
    serde_json::to_string(event).unwrap_or_else(|_| format!("{event:?}"))
}
