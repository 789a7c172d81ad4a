//! Procedures: how the next level is chosen from what has been answered so far.
//!
//! One file for each procedure. All are pure and deterministic in their random stream, so that a resumed session, which
//! replays its journal, goes on exactly where it stopped.

pub mod function_quest_plus;
pub mod mar_quest_plus;
mod on_grid;
pub mod psi;
pub mod psychometric;
pub mod quest;
pub mod quest_plus;
pub mod staircase;
pub mod tabulation;
#[cfg(test)]
mod tests;

use crate::study::plan::{Level, ProcedurePlan};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Chooses levels.
pub trait Procedure: std::fmt::Debug {
    /// The level of the next trial. Called only while [`Procedure::finished`] is false.
    fn level(&mut self, rng: &mut ChaCha8Rng) -> Level;

    /// Takes in a completed trial.
    fn update(&mut self, level: &Level, correct: bool);

    /// Takes back a level whose trial was not completed, to be shown again.
    fn put_back(&mut self, level: Level, rng: &mut ChaCha8Rng);

    /// Whether the block is over.
    fn finished(&self) -> bool;

    /// What is known so far, by quantity; empty for a procedure that estimates nothing.
    fn estimate(&self) -> Estimate;
}

/// Mean and standard deviation by quantity name (`m`, `omega0_deg`, …): the posterior's, or of a staircase its reversals'.
pub type Estimate = BTreeMap<String, Belief>;

/// What a procedure believes about one quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Belief {
    /// Posterior mean; of a staircase, the mean of its last reversals.
    pub mean: f64,
    /// Posterior standard deviation; of a staircase, the spread of its last reversals.
    pub sd: f64,
}

/// Starts the adaptive procedure that a plan asks for; nothing for constant stimuli, which are the design's own list.
#[must_use]
pub fn start(plan: &ProcedurePlan, _rng: &mut ChaCha8Rng) -> Option<Box<dyn Procedure>> {
    match plan {
        ProcedurePlan::Constant(_) => None,
        ProcedurePlan::Staircase(plan) => Some(Box::new(staircase::Staircase::new(plan))),
        ProcedurePlan::Quest(plan) => Some(Box::new(quest::Quest::new(plan))),
        ProcedurePlan::QuestPlus(plan) => Some(Box::new(mar_quest_plus::MarQuestPlus::new(plan))),
        ProcedurePlan::QuestPlusFunction(plan) => Some(Box::new(function_quest_plus::FunctionQuestPlus::new(plan))),
        ProcedurePlan::Psi(plan) => Some(Box::new(psi::Psi::new(plan))),
    }
}
