//! QUEST+ over the MAR model itself: it places eccentricity and omega together to learn m and omega0.
//!
//! The stimulus is a pair (eccentricity, omega); the parameters are m, omega0, width and lapse. One line through all
//! eccentricities is learned at once, instead of a threshold at each; the likelihood is [`crate::mar::MarModel`]'s.
//!
//! Left free, the procedure asks at the two ends of the range, where a line is learned fastest, and leaves nothing to
//! tell whether it is a line at all. A balanced plan therefore fixes the eccentricities, each equally often in shuffled
//! rounds, and leaves only omega to the procedure.

use super::on_grid::OnGrid;
use super::tabulation::{Grid, Tabulation};
use super::{Estimate, Procedure};
use crate::study::plan::{Axis, Function, Harder, Level, QuestPlusPlan};
use rand_chacha::ChaCha8Rng;

/// Guess rate of a two-alternative forced choice.
pub const GUESS: f64 = 0.5;

/// The adaptive procedure of the calibration study. Estimates `m`, `omega0_deg`, `width` and `lapse`.
#[derive(Debug, Clone)]
pub struct MarQuestPlus(OnGrid);

impl MarQuestPlus {
    /// Starts the procedure; the first one of a plan tabulates the model for every level and parameter value, with a uniform
    /// prior over the grid.
    #[must_use]
    pub fn new(plan: &QuestPlusPlan) -> Self {
        let tabulation = tabulation(plan);
        let groups = if plan.balanced {
            let mut groups: Vec<(f64, Vec<usize>)> = Vec::new();
            for (index, &[_, eccentricity]) in tabulation.stimuli.iter().enumerate() {
                match groups.iter_mut().find(|(e, _)| *e == eccentricity) {
                    Some((_, members)) => members.push(index),
                    None => groups.push((eccentricity, vec![index])),
                }
            }
            groups.into_iter().map(|(_, members)| members).collect()
        } else {
            vec![(0..plan.levels.len()).collect()]
        };
        let names = [Some("m"), Some("omega0_deg"), Some("width"), Some("lapse"), None];
        let reported = (names, tabulation.grid.clone());
        Self(OnGrid::new(&plan.levels, groups, &tabulation, &plan.tables, reported, &plan.stop))
    }
}

/// The MAR model as a psychometric function: a cumulative Gauss of ln omega, whose threshold is linear in eccentricity.
fn tabulation(plan: &QuestPlusPlan) -> Tabulation {
    let value = |level: &Level, name: &str| level.get(name).copied().unwrap_or(f64::NAN);
    let stimulus = |level: &Level| [value(level, &plan.axes.mar), value(level, &plan.axes.eccentricity)];
    Tabulation {
        stimuli: plan.levels.iter().map(stimulus).collect(),
        grid: Grid {
            threshold_slope: plan.m.clone(),
            threshold: plan.omega0_deg.clone(),
            width: plan.width.clone(),
            lapse: plan.lapse.clone(),
            guess: vec![GUESS],
        },
        function: Function::CumulativeGauss,
        axis: Axis::Log,
        harder: Harder::Down,
    }
}

impl Procedure for MarQuestPlus {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mar::MarModel;
    use crate::procedures::quest_plus::Tables;
    use crate::streams::Stream;
    use crate::study::plan::{MarAxes, Stop};
    use crate::study::{parse_study, shipped};
    use rand::RngExt;
    use std::collections::BTreeMap;

    fn log_grid(min: f64, max: f64, steps: i32) -> Vec<f64> {
        (0..steps).map(|i| min * (max / min).powf(f64::from(i) / f64::from(steps - 1))).collect()
    }

    fn plan(stop: Stop) -> QuestPlusPlan {
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
            tables: Default::default(),
        }
    }

    fn run(stop: Stop, seed: u64) -> (u32, Estimate) {
        let truth = MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.02 };
        let mut procedure = MarQuestPlus::new(&plan(stop));
        let mut rng = Stream::Observer.generator(seed);
        while !procedure.finished() {
            let level = procedure.level(&mut rng);
            let p = truth.probability_correct(level["eccentricity_deg"], level["mar_deg"], GUESS);
            procedure.update(&level, rng.random::<f64>() < p);
        }
        (procedure.0.completed(), procedure.estimate())
    }

    #[test]
    fn it_closes_in_on_the_observer() {
        for seed in 1..=5 {
            let (trials, estimate) = run(Stop::Trials(200), seed);
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
        let mut procedure = MarQuestPlus::new(&QuestPlusPlan { balanced: true, ..plan(Stop::Trials(80)) });
        let mut rng = Stream::Procedure.generator(9);
        let mut counts = BTreeMap::new();
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
        let stop = |relative| Stop::at_most(400, 30, &[("m", relative)]);
        let (loose, _) = run(stop(10.0), 1);
        assert_eq!(loose, 30);
        let (tight, estimate) = run(stop(0.12), 1);
        assert!(tight > 30 && tight < 400, "{tight}");
        assert!(estimate["m"].sd <= 0.12 * estimate["m"].mean);
    }

    #[test]
    fn the_tables_are_the_mar_models() {
        let plan = plan(Stop::Trials(1));
        let tabulation = tabulation(&plan);
        let mut models = Vec::new();
        for &m in &plan.m {
            for &omega0_deg in &plan.omega0_deg {
                for &width in &plan.width {
                    models.extend(plan.lapse.iter().map(|&lapse| MarModel { m, omega0_deg, width, lapse }));
                }
            }
        }
        let direct = Tables::of_success(plan.levels.len(), vec![1.0; models.len()], |s, t| {
            let level = &plan.levels[s];
            models[t].probability_correct(level["eccentricity_deg"], level["mar_deg"], GUESS)
        });
        assert!(tabulation.tables().largest_difference(&direct) < 1e-12);
    }

    /// QUEST+ as plainly as it can be written: f64 throughout, every parameter value in every sum, the expected entropy by
    /// its definition. What the engine leaves out to be fast must not change what it asks.
    struct Plain {
        stimuli: Vec<[f64; 2]>,
        models: Vec<MarModel>,
        posterior: Vec<f64>,
        /// Right answers' probabilities, a row for each stimulus.
        success: Vec<Vec<f64>>,
    }

    impl Plain {
        fn new(plan: &QuestPlusPlan) -> Self {
            let mut models = Vec::new();
            for &m in &plan.m {
                for &omega0_deg in &plan.omega0_deg {
                    for &width in &plan.width {
                        models.extend(plan.lapse.iter().map(|&lapse| MarModel { m, omega0_deg, width, lapse }));
                    }
                }
            }
            let stimuli: Vec<[f64; 2]> =
                plan.levels.iter().map(|level| [level["eccentricity_deg"], level["mar_deg"]]).collect();
            let row = |&[e, omega]: &[f64; 2]| models.iter().map(|m| m.probability_correct(e, omega, GUESS)).collect();
            let success = stimuli.iter().map(row).collect();
            Self { posterior: vec![1.0 / models.len() as f64; models.len()], stimuli, models, success }
        }

        /// Expected entropy, by Bayes for each outcome: H = Σ_o P(o) H(θ | o) = Σ_o (P ln P − Σ q ln q), q = p ψ_o.
        fn expected_entropy(&self, stimulus: usize) -> f64 {
            let mut expected = 0.0;
            for right in [false, true] {
                let (mut sum, mut parts) = (0.0, 0.0);
                for (p, psi) in self.posterior.iter().zip(&self.success[stimulus]) {
                    let q = p * if right { *psi } else { 1.0 - psi };
                    if q > 0.0 {
                        sum += q;
                        parts += q * q.ln();
                    }
                }
                expected += sum * sum.ln() - parts;
            }
            expected
        }

        fn update(&mut self, stimulus: usize, right: bool) {
            for (p, psi) in self.posterior.iter_mut().zip(&self.success[stimulus]) {
                *p *= if right { *psi } else { 1.0 - psi };
            }
            let sum: f64 = self.posterior.iter().sum();
            self.posterior.iter_mut().for_each(|p| *p /= sum);
        }
    }

    /// Two whole sessions of the shipped calibration against the plain engine: at every trial the asked level has the least
    /// expected entropy of its eccentricity, within rounding, and the two posteriors stay one.
    #[test]
    fn the_fast_engine_asks_what_the_plain_one_asks() {
        let study = shipped().iter().find(|study| study.name == "mar-calibration").expect("ships");
        let catalogue = crate::study::tests::catalogue();
        let plan = parse_study(study.name, study.json, &catalogue, None).expect("parses");
        let plan = plan.blocks.into_iter().find_map(|block| match block.procedure {
            crate::study::plan::ProcedurePlan::QuestPlus(plan) => Some(plan),
            _ => None,
        });
        let plan = QuestPlusPlan { stop: Stop::Trials(200), ..plan.expect("adaptive") };
        for (seed, truth) in [
            (1, MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.02 }),
            (2, MarModel { m: 0.04, omega0_deg: 0.05, width: 1.5, lapse: 0.04 }),
        ] {
            let mut plain = Plain::new(&plan);
            let mut fast = MarQuestPlus::new(&plan);
            let mut rng = Stream::Observer.generator(seed);
            let mut ties = 0;
            while !fast.finished() {
                let level = fast.level(&mut rng);
                let asked = plan.levels.iter().position(|candidate| *candidate == level).expect("a level of the plan");
                let same_e = |&s: &usize| (plain.stimuli[s][0] - plain.stimuli[asked][0]).abs() < 1e-12;
                let entropies: Vec<(usize, f64)> =
                    (0..plain.stimuli.len()).filter(same_e).map(|s| (s, plain.expected_entropy(s))).collect();
                let least = entropies.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("stimuli");
                if least.0 != asked {
                    ties += 1;
                    let at = entropies.iter().find(|(s, _)| *s == asked).expect("asked").1;
                    assert!(at - least.1 < 1e-10, "seed {seed}: asked {asked} at {at}, least {least:?}");
                }
                let [e, omega] = plain.stimuli[asked];
                let right = rng.random::<f64>() < truth.probability_correct(e, omega, GUESS);
                fast.update(&level, right);
                plain.update(asked, right);
            }
            let estimate = fast.estimate();
            let of = |value: &dyn Fn(&MarModel) -> f64| -> f64 {
                plain.models.iter().zip(&plain.posterior).map(|(model, p)| p * value(model)).sum()
            };
            println!("seed {seed}: {ties} ties, {estimate:?}");
            assert!((estimate["m"].mean / of(&|model| model.m) - 1.0).abs() < 1e-9);
            assert!((estimate["omega0_deg"].mean / of(&|model| model.omega0_deg) - 1.0).abs() < 1e-9);
            assert!((estimate["lapse"].mean - of(&|model| model.lapse)).abs() < 1e-9);
        }
    }
}
