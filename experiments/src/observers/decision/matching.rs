//! The slider: up while a difference is seen, then the comparison, then perhaps on.

use super::accepted;
use crate::trial::{Answer, Phase};

/// How far below the criterion evidence has to be for going down again, in SDs of one look.
const FAR: f64 = 2.5;
/// Steps down, at most.
const MOST_DOWN: u32 = 2;
/// Answers after which the observer says that both look the same, whatever they see.
const MOST_ANSWERS: u32 = 80;

/// How far a slider trial has come.
#[derive(Debug, Clone, Default)]
pub(super) struct Matching {
    answers: u32,
    downs: u32,
    /// Whether the reference was looked at since the last move.
    compared: bool,
}

impl Matching {
    /// The next move. `above` is by how much a new look at the picture exceeds the criterion.
    ///
    /// Each level is looked at anew, so that the level of the first comparison is noisy: there is a chance at every step to
    /// stop too early, and the mean lies somewhat below the level at which the look would just reach the criterion.
    pub(super) fn act(&mut self, phase: &Phase, reference: bool, above: f64) -> Option<Answer> {
        if reference {
            return accepted(phase, &[Answer::Compare, Answer::Continue, Answer::Switch]);
        }
        self.answers += 1;
        let can = |answer| phase.accepts.contains(&answer);
        if self.answers >= MOST_ANSWERS {
            return accepted(phase, &[Answer::Continue, Answer::Compare, Answer::Up]);
        }
        if above > 0.0 && can(Answer::Up) {
            self.compared = false;
            return Some(Answer::Up);
        }
        if !self.compared && can(Answer::Compare) {
            self.compared = true;
            return Some(Answer::Compare);
        }
        if above < -FAR && self.downs < MOST_DOWN && can(Answer::Down) {
            self.downs += 1;
            self.compared = false;
            return Some(Answer::Down);
        }
        accepted(phase, &[Answer::Continue, Answer::Compare, Answer::Up])
    }
}
