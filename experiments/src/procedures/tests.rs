//! What holds for every adaptive procedure, whatever is answered: it ends in time, it is a function of its calls, and a
//! trial that was not completed teaches nothing.

use super::{Procedure, start};
use crate::streams::Stream;
use crate::study::plan::*;
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;

fn levels(values: &[f64]) -> Vec<Level> {
    values.iter().map(|&x| Level::from([("x".to_owned(), x)])).collect()
}

fn place() -> Place {
    Place::new("x", Level::from([("y".to_owned(), 3.0)]), [0.05, 3.0])
}

/// One plan of each kind, all with this stop rule but for the quantity it names.
fn plans(trials: u32) -> Vec<ProcedurePlan> {
    let stop = |quantity: &str| {
        let narrow = Stop::Narrow { quantity: quantity.to_owned(), limit: Precision::RelativeSd(0.15) };
        Stop::Any(vec![Stop::Trials(trials), Stop::All(vec![Stop::Trials(5), narrow])])
    };
    let values = [0.1, 0.2, 0.3, 0.5, 0.8, 1.3, 2.0];
    let mar = |balanced| {
        let mut levels = Vec::new();
        for e in [2.0, 8.0] {
            levels.extend(values.map(|w| Level::from([("eccentricity_deg".to_owned(), e), ("mar_deg".to_owned(), w)])));
        }
        ProcedurePlan::QuestPlus(QuestPlusPlan {
            levels,
            levels_beyond_display: 0,
            axes: MarAxes::default(),
            balanced,
            m: vec![0.01, 0.02, 0.04],
            omega0_deg: vec![0.02, 0.06],
            width: vec![0.5, 1.0],
            lapse: vec![0.02],
            stop: stop("m"),
            tables: Default::default(),
        })
    };
    vec![
        ProcedurePlan::Staircase(StaircasePlan {
            place: place(),
            harder: Harder::Down,
            start: vec![2.0, 0.1, 0.7],
            steps: vec![0.3, 0.1],
            step_type: StepType::Log,
            up_down_ratio: 1.5,
            n_up: 1,
            n_down: 2,
            initial_rule: true,
            estimate_reversals: 4,
            stop: Stop::Any(vec![stop("x"), Stop::Reversals(7)]),
        }),
        ProcedurePlan::Quest(QuestPlan {
            place: place(),
            harder: Harder::Down,
            axis: Axis::Log,
            start: 0.4,
            start_sd: 0.5,
            p_threshold: 0.82,
            beta: 3.5,
            delta: 0.01,
            gamma: 0.5,
            grain: 0.05,
            range: 3.0,
            method: QuestMethod::Quantile,
            stop: stop("x"),
        }),
        mar(true),
        mar(false),
        ProcedurePlan::QuestPlusFunction(FunctionPlan {
            levels: levels(&values),
            levels_beyond_display: 0,
            parameter: "x".to_owned(),
            covariate: None,
            harder: Harder::Up,
            function: Function::Weibull,
            axis: Axis::Log,
            threshold: vec![0.2, 0.4, 0.8],
            threshold_slope: vec![0.0],
            width: vec![0.5, 1.0],
            lapse: vec![0.0, 0.05],
            guess: vec![0.5],
            stop: stop("threshold"),
            tables: Default::default(),
        }),
        ProcedurePlan::Psi(PsiPlan {
            levels: levels(&values),
            levels_beyond_display: 0,
            parameter: "x".to_owned(),
            harder: Harder::Down,
            function: Function::Logistic,
            axis: Axis::Linear,
            threshold: vec![0.2, 0.4, 0.8],
            slope: vec![1.0, 4.0],
            guess: 0.5,
            lapse: 0.02,
            stop: stop("threshold"),
            tables: Default::default(),
        }),
    ]
}

fn begun(plan: &ProcedurePlan, seed: u64) -> (Box<dyn Procedure>, ChaCha8Rng) {
    let mut rng = Stream::Procedure.generator(seed);
    (start(plan, &mut rng).expect("adaptive"), rng)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// `calls`: 0 a wrong answer, 1 a right one, 2 an aborted trial.
    #[test]
    fn procedures_are_functions_of_their_calls_and_end_in_time(
        calls in prop::collection::vec(0u8..3, 1..150),
        seed in 0u64..1000,
        trials in 1u32..60,
    ) {
        for plan in plans(trials) {
            let (mut procedure, mut rng) = begun(&plan, seed);
            let (mut copy, mut copy_rng) = begun(&plan, seed);
            let mut completed = 0;
            for &call in &calls {
                if procedure.finished() {
                    break;
                }
                let level = procedure.level(&mut rng);
                prop_assert_eq!(&level, &copy.level(&mut copy_rng));
                if call == 2 {
                    let before = (procedure.estimate(), procedure.finished());
                    procedure.put_back(level.clone(), &mut rng);
                    copy.put_back(level.clone(), &mut copy_rng);
                    prop_assert_eq!(before, (procedure.estimate(), procedure.finished()));
                    // What was not answered is asked again.
                    prop_assert_eq!(procedure.level(&mut rng), level.clone());
                    prop_assert_eq!(copy.level(&mut copy_rng), level);
                } else {
                    procedure.update(&level, call == 1);
                    copy.update(&level, call == 1);
                    completed += 1;
                }
                prop_assert_eq!(procedure.estimate(), copy.estimate());
                prop_assert_eq!(procedure.finished(), copy.finished());
            }
            prop_assert!(completed <= plan.max_trials(), "{plan:?}");
            prop_assert!(completed < plan.max_trials() || procedure.finished(), "{plan:?}");
            prop_assert!(!procedure.finished() || completed >= plan.min_trials(), "{plan:?}");
            for belief in procedure.estimate().values() {
                prop_assert!(belief.mean.is_finite() && belief.sd.is_finite() && belief.sd >= 0.0);
            }
        }
    }

    /// Aborted trials change nothing about what comes after them.
    #[test]
    fn what_is_put_back_teaches_nothing(answers in prop::collection::vec(any::<bool>(), 1..40), seed in 0u64..1000) {
        for plan in plans(40) {
            let (mut steady, mut steady_rng) = begun(&plan, seed);
            let (mut broken, mut broken_rng) = begun(&plan, seed);
            for (trial, &right) in answers.iter().enumerate() {
                if steady.finished() {
                    break;
                }
                for _ in 0..trial % 3 {
                    let level = broken.level(&mut broken_rng);
                    broken.put_back(level, &mut broken_rng);
                }
                let level = steady.level(&mut steady_rng);
                prop_assert_eq!(&level, &broken.level(&mut broken_rng));
                steady.update(&level, right);
                broken.update(&level, right);
                prop_assert_eq!(steady.estimate(), broken.estimate());
            }
        }
    }
}
