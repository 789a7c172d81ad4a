//! Constant stimuli: cells × levels × repetitions × orders, arranged once; what was interrupted comes again later.

use super::order::{Factors, arrange, group_key, may_follow, rearrange};
use super::{Planned, REFERENCE_FIRST, TEST_FIRST, path_seed};
use crate::study::plan::{BlockPlan, OrderPlan, PresentationOrder, ProcedurePlan};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, VecDeque};

/// The list of a block's trials.
#[derive(Debug)]
pub(super) struct Listed {
    /// What is still to be shown, the next one first.
    left: VecDeque<Planned>,
    /// Factors by cell.
    factors: Vec<BTreeMap<String, String>>,
    order: OrderPlan,
    /// The cell shown last.
    last: Option<usize>,
    /// Shown and not yet completed.
    outstanding: usize,
}

impl Listed {
    /// The list of a block; nothing if its procedure is adaptive.
    pub(super) fn new(block: &BlockPlan, rng: &mut ChaCha8Rng) -> Option<Self> {
        let ProcedurePlan::Constant(constant) = &block.procedure else { return None };
        let base: u64 = rng.random();
        let mut trials = Vec::new();
        for repetition in 1..=constant.repetitions {
            for cell in 0..block.cells.len() {
                for (index, level) in constant.levels.iter().enumerate() {
                    let place = (cell * constant.levels.len() + index) as u64;
                    let path_seed = path_seed(base, place);
                    let orders: &[_] = match block.presentation_order {
                        PresentationOrder::Both => &[REFERENCE_FIRST, TEST_FIRST],
                        PresentationOrder::ReferenceFirst => &[REFERENCE_FIRST],
                        PresentationOrder::TestFirst => &[TEST_FIRST],
                        PresentationOrder::Random => {
                            if rng.random() {
                                &[TEST_FIRST]
                            } else {
                                &[REFERENCE_FIRST]
                            }
                        }
                    };
                    trials.extend(orders.iter().map(|&order| Planned {
                        cell,
                        level: level.clone(),
                        order,
                        repetition: Some(repetition),
                        path_seed,
                    }));
                }
            }
        }
        let factors: Vec<BTreeMap<String, String>> = block.cells.iter().map(|cell| cell.factors.clone()).collect();
        let of_trials: Vec<Factors<'_>> = trials.iter().map(|trial| &factors[trial.cell]).collect();
        let (arranged, _) = arrange(&of_trials, &block.order, rng);
        let left = arranged.into_iter().map(|index| trials[index].clone()).collect();
        Some(Self { left, factors, order: block.order.clone(), last: None, outstanding: 0 })
    }

    pub(super) fn next(&mut self) -> Option<Planned> {
        let planned = self.left.pop_front()?;
        self.outstanding += 1;
        self.last = Some(planned.cell);
        Some(planned)
    }

    pub(super) fn complete(&mut self) {
        self.outstanding = self.outstanding.saturating_sub(1);
    }

    /// The trial comes again at a random later place of its group, so that an observer cannot foresee it: where it
    /// repeats nothing, if there is such a place. Where trials come as listed, it comes again at once.
    pub(super) fn put_back(&mut self, planned: Planned, rng: &mut ChaCha8Rng) {
        self.outstanding = self.outstanding.saturating_sub(1);
        let key = group_key(&self.factors[planned.cell], &self.order);
        let same_group = |trial: &&Planned| group_key(&self.factors[trial.cell], &self.order) == key;
        let places = if self.order.shuffled { self.left.iter().take_while(same_group).count() } else { 0 };
        let fits = |place: usize| {
            let before = place.checked_sub(1).map_or(self.last, |before| Some(self.left[before].cell));
            let after = self.left.get(place).map(|trial| trial.cell);
            let may = |a: Option<usize>, b: Option<usize>| {
                a.zip(b).is_none_or(|(a, b)| may_follow(&self.factors[a], &self.factors[b], &self.order))
            };
            may(before, Some(planned.cell)) && may(Some(planned.cell), after)
        };
        let fitting: Vec<usize> = (0..=places).filter(|&place| fits(place)).collect();
        if !fitting.is_empty() {
            let place = fitting[rng.random_range(0..fitting.len())];
            return self.left.insert(place, planned);
        }
        // No gap is left for it: what is left of the group comes in another order.
        let mut group: Vec<Planned> = self.left.drain(..places).collect();
        group.push(planned);
        let factors: Vec<Factors<'_>> = group.iter().map(|trial| &self.factors[trial.cell]).collect();
        let before = self.last.map(|cell| &self.factors[cell]);
        let order = rearrange(&factors, before, &self.order, rng);
        for &index in order.iter().rev() {
            self.left.push_front(group[index].clone());
        }
    }

    pub(super) fn finished(&self) -> bool {
        self.left.is_empty() && self.outstanding == 0
    }
}
