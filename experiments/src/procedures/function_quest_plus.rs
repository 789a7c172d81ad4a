//! QUEST+ over a psychometric function (Watson 2017): threshold, width, lapse and guess rate of one renderer parameter,
//! and, where a second one is varied with it, how the threshold rises with that.

use super::on_grid::OnGrid;
use super::tabulation::{Grid, Tabulation};
use super::{Estimate, Procedure};
use crate::study::plan::{FunctionPlan, Level};
use rand_chacha::ChaCha8Rng;

/// QUEST+ over a psychometric function. Estimates `threshold`, `width`, `lapse` and `guess`, and `threshold_slope` where
/// there is a covariate.
#[derive(Debug, Clone)]
pub struct FunctionQuestPlus(OnGrid);

impl FunctionQuestPlus {
    /// Starts the procedure; the first one of a plan makes its tables.
    #[must_use]
    pub fn new(plan: &FunctionPlan) -> Self {
        let value = |level: &Level, name: &str| level.get(name).copied().unwrap_or(f64::NAN);
        let stimulus = |level: &Level| {
            [value(level, &plan.parameter), plan.covariate.as_ref().map_or(0.0, |covariate| value(level, covariate))]
        };
        let tabulation = Tabulation {
            stimuli: plan.levels.iter().map(stimulus).collect(),
            grid: Grid {
                threshold_slope: plan.threshold_slope.clone(),
                threshold: plan.threshold.clone(),
                width: plan.width.clone(),
                lapse: plan.lapse.clone(),
                guess: plan.guess.clone(),
            },
            function: plan.function,
            axis: plan.axis,
            harder: plan.harder,
        };
        let slope = plan.covariate.is_some().then_some("threshold_slope");
        let names = [slope, Some("threshold"), Some("width"), Some("lapse"), Some("guess")];
        let all = vec![(0..plan.levels.len()).collect()];
        let reported = (names, tabulation.grid.clone());
        Self(OnGrid::new(&plan.levels, all, &tabulation, &plan.tables, reported, &plan.stop))
    }
}

impl Procedure for FunctionQuestPlus {
    fn level(&mut self, rng: &mut ChaCha8Rng) -> Level {
        self.0.level(rng)
    }

    fn update(&mut self, level: &Level, correct: bool) {
        self.0.update(level, correct);
    }

    fn put_back(&mut self, level: Level, rng: &mut ChaCha8Rng) {
        self.0.put_back(level, rng);
    }

    fn finished(&self) -> bool {
        self.0.finished()
    }

    fn estimate(&self) -> Estimate {
        self.0.estimate()
    }
}
