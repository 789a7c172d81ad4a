//! Adjustment of several parameters: noisy hill-climbing, one parameter after the other.
//!
//! A difference that is seen is removed by making the selected parameter finer; where none is seen, the parameter is made
//! coarser until one is, and one step back; what is first seen there is checked against the reference and looked at again. After the last parameter the reference is looked at again, and if there is
//! still a difference, another round makes finer what can be made finer. Which way is finer is found by trying: whether a
//! move made the picture better is known without noise, as somebody who has used the controls before would know it.

use super::accepted;
use crate::study::plan::Level;
use crate::trial::{Alternative, Answer, Phase, Stimulus};
use std::collections::BTreeMap;

/// Rounds through all parameters, at most.
const MOST_ROUNDS: u32 = 10;
/// Moves of one parameter in one round, at most.
const MOST_MOVES: u32 = 24;
/// Moves that change nothing visible before another parameter is tried.
const MOST_FUTILE: u32 = 3;
/// Answers after which the observer says that both look the same, whatever they see.
const MOST_ANSWERS: u32 = 400;

/// How far an adjustment has come.
#[derive(Debug, Clone, Default)]
pub(super) struct Adjusting {
    answers: u32,
    round: u32,
    step: Doing,
    /// The selected parameter, counted from the one that was selected first.
    selected: usize,
    /// Moves of it in this round.
    moves: u32,
    /// How many of the last of them left the difference as it was.
    futile: u32,
    /// Whether a difference was seen while making it coarser, and is being checked.
    suspected: bool,
    /// Whether Up makes a parameter finer, where that is known.
    up_is_finer: BTreeMap<usize, bool>,
    /// The last move, and what was shown before it.
    moved: Option<(Answer, Level, f64)>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum Doing {
    /// About to look at the reference for the first time.
    #[default]
    Begin,
    /// Making the selected parameter finer while a difference is seen.
    Refine,
    /// Making it coarser while none is.
    Coarsen,
    /// Done with it.
    Next,
    /// Has looked at the reference for the last time.
    Check,
}

impl Adjusting {
    /// The next move. `excess` orders what is shown by its degradation; `above` is by how much a new look exceeds the
    /// criterion.
    pub(super) fn act(
        &mut self,
        phase: &Phase,
        stimulus: Option<&Stimulus>,
        excess: f64,
        above: f64,
    ) -> Option<Answer> {
        let stimulus = match stimulus {
            Some(stimulus) if stimulus.alternative == Alternative::Test => stimulus,
            _ => return accepted(phase, &[Answer::Compare, Answer::Continue, Answer::Switch]),
        };
        self.answers += 1;
        let stuck = self.learn(stimulus, excess);
        let (visible, parameters) = (above > 0.0, stimulus.level.len().max(1));
        if self.answers >= MOST_ANSWERS {
            return accepted(phase, &[Answer::Continue, Answer::Compare, Answer::Select]);
        }
        // One pass through the steps for each answer; a step that has nothing to do hands on to the next.
        loop {
            match self.step {
                Doing::Begin => {
                    self.step = Doing::Refine;
                    if phase.accepts.contains(&Answer::Compare) {
                        return Some(Answer::Compare);
                    }
                }
                Doing::Refine if visible && !stuck && self.moves < MOST_MOVES && self.futile < MOST_FUTILE => {
                    return self.move_selected(true, phase, stimulus, excess);
                }
                Doing::Refine if self.round == 0 && !visible => self.step = Doing::Coarsen,
                Doing::Coarsen if visible && !self.suspected && phase.accepts.contains(&Answer::Compare) => {
                    self.suspected = true;
                    return Some(Answer::Compare);
                }
                Doing::Coarsen if visible => {
                    // Too coarse: one step back, and on to the next parameter.
                    self.step = Doing::Next;
                    return self.move_selected(true, phase, stimulus, excess);
                }
                Doing::Coarsen if !stuck && self.moves < MOST_MOVES => {
                    self.suspected = false;
                    return self.move_selected(false, phase, stimulus, excess);
                }
                Doing::Refine | Doing::Coarsen => self.step = Doing::Next,
                Doing::Next => {
                    let last = (self.selected + 1).is_multiple_of(parameters);
                    self.step = if last { Doing::Check } else { Doing::Refine };
                    (self.moves, self.futile, self.suspected) = (0, 0, false);
                    let next = if last { Answer::Compare } else { Answer::Select };
                    if next == Answer::Select {
                        self.selected += 1;
                    }
                    if phase.accepts.contains(&next) {
                        return Some(next);
                    }
                }
                Doing::Check if !visible || self.round + 1 >= MOST_ROUNDS => {
                    return accepted(phase, &[Answer::Continue, Answer::Compare]);
                }
                Doing::Check => {
                    // Still different: another round, from the first parameter.
                    self.round += 1;
                    self.step = Doing::Refine;
                    self.selected = 0;
                    if parameters > 1 && phase.accepts.contains(&Answer::Select) {
                        return Some(Answer::Select);
                    }
                }
            }
        }
    }

    /// Learns from the last move which way is finer. Whether the move changed nothing.
    fn learn(&mut self, stimulus: &Stimulus, excess: f64) -> bool {
        let Some((answer, level, before)) = self.moved.take() else { return false };
        if level == stimulus.level {
            // At an end. Where Up was only taken to be finer, the parameter may just as well go the other way.
            if self.up_is_finer.contains_key(&self.selected) {
                return true;
            }
            self.up_is_finer.insert(self.selected, false);
        } else if excess < before {
            self.up_is_finer.insert(self.selected, answer == Answer::Up);
            self.futile = 0;
        } else if excess > before {
            self.up_is_finer.insert(self.selected, answer == Answer::Down);
            self.futile = 0;
        } else {
            // Another parameter hides what this one does.
            self.futile += 1;
        }
        false
    }

    fn move_selected(&mut self, finer: bool, phase: &Phase, stimulus: &Stimulus, excess: f64) -> Option<Answer> {
        let up_is_finer = self.up_is_finer.get(&self.selected).copied().unwrap_or(true);
        let wanted = if finer == up_is_finer { Answer::Up } else { Answer::Down };
        if !phase.accepts.contains(&wanted) {
            // At the end of what can be set: on with the next parameter.
            self.step = Doing::Next;
            return accepted(phase, &[Answer::Compare, Answer::Select, Answer::Continue]);
        }
        self.moves += 1;
        self.moved = Some((wanted, stimulus.level.clone(), excess));
        Some(wanted)
    }
}
