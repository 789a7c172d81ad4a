//! Adaptive procedures, one in every cell of the design, interleaved in shuffled rounds or one after the other.

use super::order::{Factors, arrange, group_key, may_follow};
use super::{Planned, REFERENCE_FIRST, TEST_FIRST, path_seed};
use crate::procedures::{self, Estimate, Procedure};
use crate::study::plan::{BlockPlan, OrderPlan, PresentationOrder};
use crate::trial::Alternative;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// The procedures of a block.
#[derive(Debug)]
pub(super) struct Adaptive {
    procedures: Vec<Box<dyn Procedure>>,
    factors: Vec<BTreeMap<String, String>>,
    order: OrderPlan,
    presentation_order: PresentationOrder,
    /// Cells in the order in which their groups come.
    cells: Vec<usize>,
    /// Cells still to come in this round, the next one last.
    round: Vec<usize>,
    /// The cell shown last.
    last: Option<usize>,
    /// Where both orders are wanted: the other half of a pair, by cell.
    owed: Vec<Option<[Alternative; 2]>>,
    base: u64,
    trials: u64,
}

impl Adaptive {
    pub(super) fn new(block: &BlockPlan, rng: &mut ChaCha8Rng) -> Self {
        let base: u64 = rng.random();
        let factors: Vec<BTreeMap<String, String>> = block.cells.iter().map(|cell| cell.factors.clone()).collect();
        // Which group comes when is decided once; within a group, rounds are shuffled as they come.
        let groups = OrderPlan { shuffled: false, no_repeat: Vec::new(), ..block.order.clone() };
        let (cells, _) = arrange(&factors.iter().collect::<Vec<Factors<'_>>>(), &groups, rng);
        Self {
            procedures: block.cells.iter().filter_map(|_| procedures::start(&block.procedure, rng)).collect(),
            owed: vec![None; block.cells.len()],
            order: block.order.clone(),
            presentation_order: block.presentation_order,
            factors,
            cells,
            round: Vec::new(),
            last: None,
            base,
            trials: 0,
        }
    }

    pub(super) fn next(&mut self, design: &mut ChaCha8Rng, choice: &mut ChaCha8Rng) -> Option<Planned> {
        self.round.retain(|&cell| !self.procedures[cell].finished());
        if self.round.is_empty() {
            self.begin_round(design);
        }
        let cell = self.round.pop()?;
        self.last = Some(cell);
        let order = match (self.presentation_order, self.owed[cell].take()) {
            (PresentationOrder::ReferenceFirst, _) => REFERENCE_FIRST,
            (PresentationOrder::TestFirst, _) => TEST_FIRST,
            (PresentationOrder::Both, Some(owed)) => owed,
            (PresentationOrder::Both | PresentationOrder::Random, _) => {
                let test_first = design.random();
                let [order, other] =
                    if test_first { [TEST_FIRST, REFERENCE_FIRST] } else { [REFERENCE_FIRST, TEST_FIRST] };
                self.owed[cell] = (self.presentation_order == PresentationOrder::Both).then_some(other);
                order
            }
        };
        self.trials += 1;
        Some(Planned {
            cell,
            level: self.procedures[cell].level(choice),
            order,
            repetition: None,
            path_seed: path_seed(self.base, self.trials),
        })
    }

    /// The unfinished cells of the first unfinished group, shuffled; without shuffling, the first of them alone.
    fn begin_round(&mut self, rng: &mut ChaCha8Rng) {
        let key = |cell: usize| group_key(&self.factors[cell], &self.order);
        let unfinished: Vec<usize> =
            self.cells.iter().copied().filter(|&cell| !self.procedures[cell].finished()).collect();
        let Some(&first) = unfinished.first() else { return };
        let mut round: Vec<usize> = unfinished.into_iter().filter(|&cell| key(cell) == key(first)).collect();
        if self.order.shuffled {
            round.shuffle(rng);
            // The seam between rounds keeps the constraint where it can.
            let follows = |&cell: &usize| {
                self.last.is_none_or(|last| may_follow(&self.factors[last], &self.factors[cell], &self.order))
            };
            if let Some(at) = round.iter().rposition(follows) {
                let end = round.len() - 1;
                round.swap(at, end);
            }
        } else {
            round.truncate(1);
        }
        self.round = round;
    }

    pub(super) fn complete(&mut self, planned: &Planned, correct: Option<bool>) {
        if let Some(correct) = correct {
            self.procedures[planned.cell].update(&planned.level, correct);
        }
    }

    /// The cell comes again at once: a round is short, and what comes next is no longer than it was.
    pub(super) fn put_back(&mut self, planned: Planned, rng: &mut ChaCha8Rng) {
        if self.presentation_order == PresentationOrder::Both {
            // The pair is whole again only when this order has been answered too.
            self.owed[planned.cell] = match self.owed[planned.cell] {
                Some(_) => None,
                None => Some(planned.order),
            };
        }
        self.procedures[planned.cell].put_back(planned.level, rng);
        self.round.push(planned.cell);
    }

    pub(super) fn finished(&self) -> bool {
        self.procedures.iter().all(|procedure| procedure.finished())
    }

    pub(super) fn estimate(&self, cell: usize) -> Estimate {
        self.procedures.get(cell).map(|procedure| procedure.estimate()).unwrap_or_default()
    }
}
