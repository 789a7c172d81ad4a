//! Designs: which trials a block has, and which of them comes next.
//!
//! [`Schedule`] is what the session machine asks. Constant stimuli are a list, arranged once ([`order`]); adaptive
//! procedures run one in every cell and are interleaved. [`assignment`] makes of a study what one observer runs in one
//! sitting.

mod adaptive;
pub mod assignment;
pub mod latin_square;
mod listed;
pub mod order;
#[cfg(test)]
mod tests;

use crate::procedures::Estimate;
use crate::study::plan::{BlockPlan, Level};
use crate::trial::Alternative;
use adaptive::Adaptive;
use listed::Listed;
use rand_chacha::ChaCha8Rng;

/// A trial, as the design wants it.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Its cell: an index into the block's cells.
    pub cell: usize,
    /// Its level.
    pub level: Level,
    /// The two pictures in the order of presentation.
    pub order: [Alternative; 2],
    /// Which repetition it is, from 1, where the design counts them.
    pub repetition: Option<u32>,
    /// Decides target paths and spheres: the same in all repetitions.
    pub path_seed: u64,
}

/// A seed for each `place`, in golden-ratio steps. It has 53 bits, so that every reader of a journal takes it whole.
fn path_seed(base: u64, place: u64) -> u64 {
    base.wrapping_add(place.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 11
}

/// The reference first.
pub(crate) const REFERENCE_FIRST: [Alternative; 2] = [Alternative::Reference, Alternative::Test];
/// The test first.
pub(crate) const TEST_FIRST: [Alternative; 2] = [Alternative::Test, Alternative::Reference];

/// The trials of one round of a block.
#[derive(Debug)]
pub struct Schedule {
    kind: Kind,
    completed: u32,
    at_most: Option<u32>,
}

#[derive(Debug)]
enum Kind {
    Listed(Listed),
    Adaptive(Adaptive),
}

impl Schedule {
    /// The schedule of a block, drawn from the session's `design` stream.
    #[must_use]
    pub fn new(block: &BlockPlan, rng: &mut ChaCha8Rng) -> Self {
        let kind = match Listed::new(block, rng) {
            Some(listed) => Kind::Listed(listed),
            None => Kind::Adaptive(Adaptive::new(block, rng)),
        };
        Self { kind, completed: 0, at_most: block.at_most_trials }
    }

    /// The next trial. `design` and `choice` are the session's streams of those names. Asked only while the schedule is
    /// not finished.
    pub fn next(&mut self, design: &mut ChaCha8Rng, choice: &mut ChaCha8Rng) -> Option<Planned> {
        match &mut self.kind {
            Kind::Listed(listed) => listed.next(),
            Kind::Adaptive(adaptive) => adaptive.next(design, choice),
        }
    }

    /// Takes in a completed trial, and whether it was right.
    pub fn complete(&mut self, planned: &Planned, correct: Option<bool>) {
        self.completed += 1;
        match &mut self.kind {
            Kind::Listed(listed) => listed.complete(),
            Kind::Adaptive(adaptive) => adaptive.complete(planned, correct),
        }
    }

    /// Takes back a trial that was not completed, to be shown again.
    pub fn put_back(&mut self, planned: Planned, design: &mut ChaCha8Rng) {
        match &mut self.kind {
            Kind::Listed(listed) => listed.put_back(planned, design),
            Kind::Adaptive(adaptive) => adaptive.put_back(planned, design),
        }
    }

    /// Whether every trial has been completed.
    #[must_use]
    pub fn finished(&self) -> bool {
        self.at_most.is_some_and(|most| self.completed >= most)
            || match &self.kind {
                Kind::Listed(listed) => listed.finished(),
                Kind::Adaptive(adaptive) => adaptive.finished(),
            }
    }

    /// What the procedure of a cell has learned; empty where nothing is estimated.
    #[must_use]
    pub fn estimate(&self, cell: usize) -> Estimate {
        match &self.kind {
            Kind::Listed(_) => Estimate::new(),
            Kind::Adaptive(adaptive) => adaptive.estimate(cell),
        }
    }
}
