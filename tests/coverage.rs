//! Do the 95 % intervals hold the truth? The shipped demo study is run by 200 simulated observers who differ only in
//! their seed, and every session is fitted as `analyze` fits it.
//!
//! With exact intervals 190 of 200 are expected to hold; 180 to 198 is 90–99 %.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

use analysis::mar::Estimate;
use experiments::observers::{Simulation, Truth};
use experiments::session::record::Record;
use experiments::session::simulate::simulate;
use experiments::study::{Plan, parse_study, shipped};
use parafovea::results::fit_sessions;
use parafovea::session::SessionFolder;
use parafovea::session::header::{Header, StageRecord};
use parafovea::session::journal::Journal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

const SEEDS: u64 = 200;
const TRUTH: &str = "omega0=0.021,m=0.022,width=0.6,lapse=0.02";

/// What one simulated session gave.
struct Fitted {
    seed: u64,
    trials: usize,
    m: Estimate,
    omega0: Estimate,
}

/// The session that `run` would have written, without its disk.
fn session_in_memory(plan: &Arc<Plan>, text: &str, seed: u64) -> SessionFolder {
    let mut observer = Simulation::parse(TRUTH).unwrap().observer(seed);
    let events = simulate(plan, seed, observer.as_mut());
    let record = Record::from_events(&events);
    assert!(record.finished, "seed {seed}");
    let header = Header::new(plan, text, "SIM", seed, StageRecord::offscreen(&plan.display, false));
    let journal = Journal::in_memory(events);
    SessionFolder {
        path: PathBuf::from(format!("seed-{seed}")),
        header,
        display: plan.display.clone(),
        study: serde_json::from_str(text).unwrap(),
        journal,
        record,
    }
}

fn fitted(plan: &Arc<Plan>, text: &str, seed: u64) -> Fitted {
    let sessions = [session_in_memory(plan, text, seed)];
    let results = fit_sessions(&sessions).unwrap();
    let fit = results[0].fit.as_ref().unwrap();
    Fitted { seed, trials: fit.trials, m: fit.m, omega0: fit.omega0 }
}

/// How many intervals hold the truth; says which do not and how wide they are.
fn count(name: &str, truth: f64, all: &[Fitted], estimate: impl Fn(&Fitted) -> Estimate) -> usize {
    let mut widths: Vec<f64> = all.iter().map(&estimate).map(|e| (e.ci95[1] - e.ci95[0]) / truth).collect();
    widths.sort_by(f64::total_cmp);
    let mut estimates: Vec<f64> = all.iter().map(|one| estimate(one).estimate).collect();
    estimates.sort_by(f64::total_cmp);
    let missed: Vec<String> = all
        .iter()
        .filter(|one| !(estimate(one).ci95[0]..=estimate(one).ci95[1]).contains(&truth))
        .map(|one| format!("seed {}: {:.5} – {:.5}", one.seed, estimate(one).ci95[0], estimate(one).ci95[1]))
        .collect();
    let held = all.len() - missed.len();
    println!(
        "{name} = {truth}: {held} of {} intervals hold it; median estimate {:.5}, median width {:.0} % of it; missed: \
         {missed:?}",
        all.len(),
        estimates[all.len() / 2],
        100.0 * widths[all.len() / 2]
    );
    held
}

#[test]
fn the_intervals_of_m_and_omega0_hold_the_truth_as_often_as_they_say() {
    let study = shipped().iter().find(|study| study.name == "mar-demo").unwrap();
    let plan = Arc::new(parse_study(study.name, study.json, &stimuli::registry::catalogue(), None).unwrap());
    let (next, done) = (AtomicU64::new(1), Mutex::new(Vec::new()));
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed > SEEDS {
                        break;
                    }
                    let one = fitted(&plan, study.json, seed);
                    done.lock().unwrap().push(one);
                }
            });
        }
    });
    let mut all = done.into_inner().unwrap();
    all.sort_by_key(|one| one.seed);
    assert_eq!(all.len() as u64, SEEDS);
    let trials: Vec<usize> = all.iter().map(|one| one.trials).collect();
    println!("seeds 1 to {SEEDS}, {} to {} trials", trials.iter().min().unwrap(), trials.iter().max().unwrap());
    let Some(Truth::Mar(truth)) = Simulation::parse(TRUTH).unwrap().truth else { panic!("a MAR line") };
    let m = count("m", truth.m, &all, |one| one.m);
    let omega0 = count("omega0", truth.omega0_deg, &all, |one| one.omega0);
    assert!((180..=198).contains(&m), "m is held by {m} of {SEEDS}");
    assert!((180..=198).contains(&omega0), "omega0 is held by {omega0} of {SEEDS}");
}
