//! What QUEST+ and Psi have in common as procedures: an engine over a grid, levels to choose from, names for the grid's
//! axes, a stop rule, and rounds if groups of levels are to come equally often.

use super::quest_plus::QuestPlus;
use super::tabulation::{Grid, Shared, Tabulation};
use super::{Estimate, Procedure};
use crate::study::plan::{Level, Stop};
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// How the grid's axes stand in the estimate: their names (those without one are fixed), and their values as reported.
pub(super) type Reported = ([Option<&'static str>; 5], Grid);

/// A procedure that asks wherever it expects to learn most over a grid.
#[derive(Debug, Clone)]
pub(super) struct OnGrid {
    levels: Vec<Level>,
    engine: QuestPlus,
    reported: Reported,
    stop: Stop,
    /// Indices of the levels of each group.
    groups: Vec<Vec<usize>>,
    /// Groups still to come in this round, the next one last.
    round: Vec<usize>,
    completed: u32,
    /// Known once for each answer: both are asked for several times between two.
    estimate: Estimate,
    finished: bool,
}

impl OnGrid {
    /// `groups` are taken in shuffled rounds; one group of all levels leaves the choice free. `tabulation` has a stimulus
    /// for each level.
    pub(super) fn new(
        levels: &[Level],
        groups: Vec<Vec<usize>>,
        tabulation: &Tabulation,
        shared: &Shared,
        reported: Reported,
        stop: &Stop,
    ) -> Self {
        let tables = shared.tables(tabulation);
        let engine = QuestPlus::new(tables, tabulation.grid.points());
        let mut procedure = Self {
            levels: levels.to_vec(),
            engine,
            reported,
            stop: stop.clone(),
            groups,
            round: Vec::new(),
            completed: 0,
            estimate: Estimate::new(),
            finished: false,
        };
        procedure.settle();
        procedure
    }

    /// Completed trials.
    #[cfg(test)]
    pub(super) fn completed(&self) -> u32 {
        self.completed
    }

    fn settle(&mut self) {
        let (names, grid) = &self.reported;
        let beliefs = grid.beliefs(self.engine.posterior());
        let named = names.iter().zip(beliefs).filter_map(|(name, belief)| Some(((*name)?.to_owned(), belief)));
        self.estimate = named.collect();
        self.finished = self.stop.holds(self.completed, 0, &self.estimate);
    }
}

impl Procedure for OnGrid {
    fn level(&mut self, rng: &mut ChaCha8Rng) -> Level {
        if self.round.is_empty() {
            self.round = (0..self.groups.len()).collect();
            // One group has no order, and needs nothing from the random stream.
            if self.groups.len() > 1 {
                self.round.shuffle(rng);
            }
        }
        let group = self.round.last().and_then(|&group| self.groups.get(group));
        let best = group.and_then(|group| self.engine.best_among(group.iter().copied()));
        best.and_then(|best| self.levels.get(best)).cloned().unwrap_or_default()
    }

    fn update(&mut self, level: &Level, correct: bool) {
        self.completed += 1;
        self.round.pop();
        if let Some(stimulus) = self.levels.iter().position(|candidate| candidate == level) {
            self.engine.update(stimulus, usize::from(correct));
        }
        self.settle();
    }

    /// Nothing to do: an unanswered level has taught nothing, so it is still the best one to show, and its group is still
    /// the next.
    fn put_back(&mut self, _level: Level, _rng: &mut ChaCha8Rng) {}

    fn finished(&self) -> bool {
        self.finished
    }

    fn estimate(&self) -> Estimate {
        self.estimate.clone()
    }
}
