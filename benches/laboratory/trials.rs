//! What happens between trials and after a session: the next level of QUEST+ and the fit of the acuity line.

use analysis::{MarFitConfig, MarTrial, fit_mar};
use criterion::Criterion;
use experiments::mar::MarModel;
use experiments::procedures::Procedure;
use experiments::procedures::mar_quest_plus::{GUESS, MarQuestPlus};
use experiments::streams::Stream;
use experiments::study::plan::{ProcedurePlan, QuestPlusPlan};
use experiments::study::{parse_study, shipped};
use rand::RngExt;
use std::hint::black_box;

/// The observer that answers: Guenter's acuity line.
const OBSERVER: MarModel = MarModel { m: 0.022, omega0_deg: 1.0 / 48.0, width: 0.6, lapse: 0.02 };
const SEED: u64 = 1;
/// Trials of the fit: a session of the calibration study.
const FITTED_TRIALS: usize = 700;

/// The adaptive block of the shipped study `mar-demo`.
fn demo_plan() -> Option<QuestPlusPlan> {
    let study = shipped().iter().find(|study| study.name == "mar-demo")?;
    let plan = parse_study(study.name, study.json, &stimuli::catalogue(), None).ok()?;
    plan.blocks.into_iter().find_map(|block| match block.procedure {
        ProcedurePlan::QuestPlus(plan) => Some(plan),
        _ => None,
    })
}

/// Measures a trial of QUEST+ and a fit.
pub(crate) fn bench(criterion: &mut Criterion) {
    let Some(plan) = demo_plan() else {
        eprintln!("the study mar-demo has no adaptive block: nothing to measure");
        return;
    };

    // A trial: the level is chosen, answered, and taken in. A new block begins where one would end.
    let mut answers = Stream::Observer.generator(SEED);
    let mut order = Stream::Procedure.generator(SEED);
    let fresh = MarQuestPlus::new(&plan);
    let mut procedure = fresh.clone();
    let mut answered = 0;
    let most_trials = plan.stop.max_trials().unwrap_or(u32::MAX);
    criterion.bench_function("QUEST+ trial of mar-demo (level and update)", |bencher| {
        bencher.iter(|| {
            if answered == most_trials {
                (procedure, answered) = (fresh.clone(), 0);
            }
            answered += 1;
            let level = procedure.level(&mut order);
            let value = |name: &str| level.get(name).copied().unwrap_or(f64::NAN);
            let (eccentricity_deg, mar_deg) = (value(&plan.axes.eccentricity), value(&plan.axes.mar));
            let right = answers.random::<f64>() < OBSERVER.probability_correct(eccentricity_deg, mar_deg, GUESS);
            procedure.update(&level, right);
        });
    });

    // A fit, of every level equally often.
    let trials: Vec<MarTrial> = plan
        .levels
        .iter()
        .cycle()
        .take(FITTED_TRIALS)
        .map(|level| {
            let value = |name: &str| level.get(name).copied().unwrap_or(f64::NAN);
            let (eccentricity_deg, mar_deg) = (value(&plan.axes.eccentricity), value(&plan.axes.mar));
            let p = OBSERVER.probability_correct(eccentricity_deg, mar_deg, GUESS);
            MarTrial { eccentricity_deg, mar_deg, correct: answers.random::<f64>() < p }
        })
        .collect();
    let config = MarFitConfig::default();
    criterion.bench_function("fit_mar of 700 trials", |bencher| {
        bencher.iter(|| black_box(fit_mar(black_box(&trials), &config).is_ok()));
    });
}
