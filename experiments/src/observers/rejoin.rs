//! Bringing a simulated observer back into a session that goes on.
//!
//! A person remembers where they were. A simulated observer is led through the journal again, and to go on like an
//! unbroken session it must not have met what the end of the program interrupted: that trial, or page, comes again.

use super::{Observer, Presented};
use crate::session::Session;
use crate::trial::PhaseName;

/// An observer on its way through a journal.
pub struct Rejoin {
    observer: Box<dyn Observer>,
    /// As it was before the trial or page that it is in.
    boundary: Box<dyn Observer>,
    trial: Option<u32>,
}

impl Rejoin {
    /// Begins with an observer who has met nothing yet.
    #[must_use]
    pub fn new(observer: Box<dyn Observer>) -> Self {
        Self { boundary: observer.fork(), observer, trial: None }
    }

    /// Meets the phase that a session is in. `seam` says that the session was reopened with it.
    pub fn meet(&mut self, session: &Session, seam: bool) {
        let Some(phase) = session.phase() else { return };
        if seam {
            self.observer = self.boundary.fork();
        }
        let trial = session.trial().map(|trial| trial.trial);
        if trial.is_none() || trial != self.trial {
            self.boundary = self.observer.fork();
        }
        self.trial = trial;
        if is_met(phase.name) {
            let level = session.shown_level();
            self.observer.meet(&presented(session, phase, level.as_ref()));
        }
    }

    /// The observer for the rest of the session: without the trial or page that was interrupted.
    #[must_use]
    pub fn into_observer(self) -> Box<dyn Observer> {
        self.boundary
    }
}

/// Whether observers take part in a phase. Pauses are no part of a study, and must not change what comes after them.
#[must_use]
pub fn is_met(phase: PhaseName) -> bool {
    phase != PhaseName::Paused
}

/// What an observer meets in the phase that a session is in.
#[must_use]
pub fn presented<'a>(
    session: &'a Session,
    phase: &'a crate::trial::Phase,
    level: Option<&'a crate::study::plan::Level>,
) -> Presented<'a> {
    let began_s = session.phase_began_s();
    Presented {
        phase,
        trial: session.trial(),
        condition: session.condition(),
        level,
        fixation_deg: session.look_at_deg(session.animation_s(began_s)),
        display: &session.plan().display,
        t_s: began_s,
    }
}
