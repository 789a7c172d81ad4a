//! Constant stimuli: every level so many times, in a random order that is fixed by the seed.

use super::{Estimate, Procedure};
use crate::study::plan::{ConstantPlan, Level};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// The method of constant stimuli.
#[derive(Debug, Clone)]
pub struct Constant {
    /// What is still to be shown, the next one last.
    left: Vec<Level>,
    /// Shown and not yet completed.
    outstanding: usize,
}

impl Constant {
    /// Shuffles the levels of `plan`, each repeated as often as it says.
    #[must_use]
    pub fn new(plan: &ConstantPlan, rng: &mut ChaCha8Rng) -> Self {
        let mut left: Vec<Level> = (0..plan.repetitions).flat_map(|_| plan.levels.iter().cloned()).collect();
        left.shuffle(rng);
        Self { left, outstanding: 0 }
    }
}

impl Procedure for Constant {
    fn level(&mut self, _rng: &mut ChaCha8Rng) -> Level {
        self.outstanding += 1;
        self.left.pop().unwrap_or_default()
    }

    fn update(&mut self, _level: &Level, _correct: bool) {
        self.outstanding = self.outstanding.saturating_sub(1);
    }

    /// The level comes again at a random later place, so that an observer cannot foresee it.
    fn put_back(&mut self, level: Level, rng: &mut ChaCha8Rng) {
        self.outstanding = self.outstanding.saturating_sub(1);
        let place = rng.random_range(0..=self.left.len());
        self.left.insert(place, level);
    }

    fn finished(&self) -> bool {
        self.left.is_empty() && self.outstanding == 0
    }

    fn estimate(&self) -> Estimate {
        Estimate::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::Stream;
    use crate::study::plan::MarAxes;
    use std::collections::HashMap;

    #[test]
    fn each_level_is_completed_as_often_as_designed_though_trials_abort() {
        let levels: Vec<Level> = (1..=4).map(|i| Level::from([("mar_deg".to_owned(), f64::from(i))])).collect();
        let plan = ConstantPlan { levels, repetitions: 5, axes: MarAxes::default() };
        for seed in 0..20 {
            let mut rng = Stream::Design.generator(seed);
            let mut procedure = Constant::new(&plan, &mut rng);
            let mut completed: HashMap<String, u32> = HashMap::new();
            let mut shown = 0u64;
            while !procedure.finished() {
                shown += 1;
                let level = procedure.level(&mut rng);
                if (shown * 7 + seed).is_multiple_of(5) {
                    procedure.put_back(level, &mut rng);
                } else {
                    procedure.update(&level, true);
                    *completed.entry(format!("{level:?}")).or_default() += 1;
                }
            }
            assert_eq!(completed.len(), 4, "seed {seed}");
            assert!(completed.values().all(|&n| n == 5), "seed {seed}: {completed:?}");
        }
    }
}
