//! QUEST+ over the MAR model itself: it places eccentricity and omega together to learn m and omega0.
//!
//! The stimulus is a pair (eccentricity, omega); the parameters are m, omega0, width and lapse. One line through all
//! eccentricities is learned at once, instead of a threshold at each; the likelihood is [`MarModel`]'s.
//!
//! Left free, the procedure asks at the two ends of the range, where a line is learned fastest, and leaves nothing to
//! tell whether it is a line at all. A balanced plan therefore fixes the eccentricities, each equally often in shuffled
//! rounds, and leaves only omega to the procedure.

use super::quest_plus::QuestPlus;
use super::{Belief, Estimate, Procedure};
use crate::mar::MarModel;
use crate::study::plan::{Level, QuestPlusPlan};
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Guess rate of a two-alternative forced choice.
pub const GUESS: f64 = 0.5;

/// The adaptive procedure of the calibration study.
#[derive(Debug, Clone)]
pub struct MarQuestPlus {
    plan: QuestPlusPlan,
    engine: QuestPlus,
    /// The parameter values, in the engine's order.
    models: Vec<MarModel>,
    /// Indices of the levels at each eccentricity.
    groups: Vec<Vec<usize>>,
    /// Groups still to come in this round, the next one last; unused when not balanced.
    round: Vec<usize>,
    completed: u32,
}

impl MarQuestPlus {
    /// Tabulates the model for every level and parameter value of `plan`, with a uniform prior over the grid.
    #[must_use]
    pub fn new(plan: &QuestPlusPlan) -> Self {
        let mut models = Vec::new();
        for &m in &plan.m {
            for &omega0_deg in &plan.omega0_deg {
                for &width in &plan.width {
                    for &lapse in &plan.lapse {
                        models.push(MarModel { m, omega0_deg, width, lapse });
                    }
                }
            }
        }
        let value = |level: &Level, name: &str| level.get(name).copied().unwrap_or(f64::NAN);
        let stimuli: Vec<(f64, f64)> = plan
            .levels
            .iter()
            .map(|level| (value(level, &plan.axes.eccentricity), value(level, &plan.axes.mar)))
            .collect();
        let engine = QuestPlus::new(stimuli.len(), vec![1.0; models.len()], |s, t| {
            models[t].probability_correct(stimuli[s].0, stimuli[s].1, GUESS)
        });
        let mut groups: Vec<(f64, Vec<usize>)> = Vec::new();
        for (index, &(eccentricity, _)) in stimuli.iter().enumerate() {
            match groups.iter_mut().find(|(e, _)| *e == eccentricity) {
                Some((_, members)) => members.push(index),
                None => groups.push((eccentricity, vec![index])),
            }
        }
        let groups = groups.into_iter().map(|(_, members)| members).collect();
        Self { plan: plan.clone(), engine, models, groups, round: Vec::new(), completed: 0 }
    }

    fn belief(&self, of: impl Fn(&MarModel) -> f64) -> Belief {
        let weighted = |f: &dyn Fn(f64) -> f64| -> f64 {
            self.models.iter().zip(self.engine.posterior()).map(|(model, p)| p * f(of(model))).sum()
        };
        let mean = weighted(&|x| x);
        Belief { mean, sd: weighted(&|x| (x - mean).powi(2)).sqrt() }
    }
}

impl Procedure for MarQuestPlus {
    fn level(&mut self, rng: &mut ChaCha8Rng) -> Level {
        let best = if self.plan.balanced {
            if self.round.is_empty() {
                self.round = (0..self.groups.len()).collect();
                self.round.shuffle(rng);
            }
            let group = self.round.last().and_then(|&group| self.groups.get(group));
            group.and_then(|group| self.engine.best_among(group.iter().copied()))
        } else {
            self.engine.best_among(0..self.plan.levels.len())
        };
        best.and_then(|best| self.plan.levels.get(best)).cloned().unwrap_or_default()
    }

    fn update(&mut self, level: &Level, correct: bool) {
        self.completed += 1;
        self.round.pop();
        if let Some(stimulus) = self.plan.levels.iter().position(|candidate| candidate == level) {
            self.engine.update(stimulus, correct);
        }
    }

    /// Nothing to do: an unanswered level has taught nothing, so it is still the best one to show, and its eccentricity is
    /// still the next.
    fn put_back(&mut self, _level: Level, _rng: &mut ChaCha8Rng) {}

    fn finished(&self) -> bool {
        let stop = &self.plan.stop;
        if self.completed >= stop.max_trials {
            return true;
        }
        if self.completed < stop.min_trials || !stop.has_posterior_rule() {
            return false;
        }
        let narrow = |limit: Option<f64>, belief: Belief| limit.is_none_or(|limit| belief.sd <= limit * belief.mean);
        narrow(stop.m_relative_sd, self.belief(|model| model.m))
            && narrow(stop.omega0_relative_sd, self.belief(|model| model.omega0_deg))
    }

    fn estimate(&self) -> Estimate {
        Estimate::from([
            ("m".to_owned(), self.belief(|model| model.m)),
            ("omega0_deg".to_owned(), self.belief(|model| model.omega0_deg)),
            ("width".to_owned(), self.belief(|model| model.width)),
            ("lapse".to_owned(), self.belief(|model| model.lapse)),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::Stream;
    use crate::study::plan::{MarAxes, StopRule};
    use rand::RngExt;

    fn log_grid(min: f64, max: f64, steps: i32) -> Vec<f64> {
        (0..steps).map(|i| min * (max / min).powf(f64::from(i) / f64::from(steps - 1))).collect()
    }

    fn plan(stop: StopRule) -> QuestPlusPlan {
        let mut levels = Vec::new();
        for e in [0.0, 2.0, 5.0, 10.0] {
            for &omega in &log_grid(0.01, 2.0, 20) {
                levels.push(Level::from([("eccentricity_deg".to_owned(), e), ("mar_deg".to_owned(), omega)]));
            }
        }
        QuestPlusPlan {
            levels,
            levels_beyond_display: 0,
            axes: MarAxes::default(),
            balanced: false,
            m: log_grid(0.005, 0.08, 15),
            omega0_deg: log_grid(0.005, 0.08, 15),
            width: log_grid(0.3, 1.5, 3),
            lapse: vec![0.0, 0.03],
            stop,
        }
    }

    fn run(stop: StopRule, seed: u64) -> (u32, Estimate) {
        let truth = MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.02 };
        let mut procedure = MarQuestPlus::new(&plan(stop));
        let mut rng = Stream::Observer.generator(seed);
        while !procedure.finished() {
            let level = procedure.level(&mut rng);
            let p = truth.probability_correct(level["eccentricity_deg"], level["mar_deg"], GUESS);
            procedure.update(&level, rng.random::<f64>() < p);
        }
        (procedure.completed, procedure.estimate())
    }

    #[test]
    fn it_closes_in_on_the_observer() {
        let stop = StopRule { max_trials: 200, min_trials: 1, m_relative_sd: None, omega0_relative_sd: None };
        for seed in 1..=5 {
            let (trials, estimate) = run(stop, seed);
            println!("seed {seed}: {trials} trials, {estimate:?}");
            assert_eq!(trials, 200);
            for (name, truth) in [("m", 0.022), ("omega0_deg", 0.021)] {
                let belief = estimate[name];
                assert!(belief.sd < 0.3 * truth, "seed {seed} {name} {belief:?}");
                assert!((belief.mean - truth).abs() < 4.0 * belief.sd, "seed {seed} {name} {belief:?}");
            }
        }
    }

    #[test]
    fn a_balanced_plan_asks_at_every_eccentricity_equally_often_though_trials_abort() {
        let stop = StopRule { max_trials: 80, min_trials: 1, m_relative_sd: None, omega0_relative_sd: None };
        let mut procedure = MarQuestPlus::new(&QuestPlusPlan { balanced: true, ..plan(stop) });
        let mut rng = Stream::Procedure.generator(9);
        let mut counts = std::collections::BTreeMap::new();
        let mut shown = 0;
        while !procedure.finished() {
            let level = procedure.level(&mut rng);
            shown += 1;
            if shown % 3 == 0 {
                procedure.put_back(level, &mut rng);
                continue;
            }
            *counts.entry(format!("{}", level["eccentricity_deg"])).or_insert(0) += 1;
            procedure.update(&level, level["mar_deg"] > 0.022 * level["eccentricity_deg"] + 0.021);
        }
        assert_eq!(counts.len(), 4);
        assert!(counts.values().all(|&n| n == 20), "{counts:?}");
    }

    #[test]
    fn the_posterior_rule_ends_a_block_early_but_not_before_its_minimum() {
        let stop = |relative| StopRule {
            max_trials: 400,
            min_trials: 30,
            m_relative_sd: Some(relative),
            omega0_relative_sd: None,
        };
        let (loose, _) = run(stop(10.0), 1);
        assert_eq!(loose, 30);
        let (tight, estimate) = run(stop(0.12), 1);
        assert!(tight > 30 && tight < 400, "{tight}");
        assert!(estimate["m"].sd <= 0.12 * estimate["m"].mean);
    }
}
