//! Power: whole studies with simulated observers, in parallel and without pictures, before anybody is recruited.
//!
//! Every simulated observer runs every sitting of their assignment through the same machine as a person would, and their
//! answers go through the same analysis. What the observers are is known, so that estimates can be held against it.

mod estimates;
mod expected;

use crate::error::LabError;
use analysis::power::{Power, Quantity, Simulated, summarise};
use estimates::{Estimator, Observed};
use experiments::design::assignment::Earlier;
use experiments::design::assignment::{Assignment, next_assignment};
use experiments::observers::{Simulation, Truth};
use experiments::session::record::{Record, TrialRecord};
use experiments::session::simulate::simulate;
use experiments::study::Plan;
use experiments::study::plan::GroupOrder;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::function::erf::erf_inv;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Shares of the study's trials after which estimates are made.
const CHECKPOINTS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// What is to be simulated.
#[derive(Debug, Clone)]
pub struct Request {
    /// The whole study.
    pub plan: Plan,
    /// The typical observer.
    pub simulation: Simulation,
    /// Observers of one study.
    pub observers: u32,
    /// How often the whole study is repeated.
    pub repeats: u32,
    /// Seed of everything random.
    pub seed: u64,
    /// How much observers differ: the standard deviation of ln m and ln omega0, or of a threshold relative to itself.
    pub spread: f64,
}

/// Simulates. `progress` is told of every session that is done, from any thread.
///
/// # Errors
/// When the study cannot be assigned, or a worker cannot be started.
pub fn run(request: &Request, progress: &(dyn Fn() + Sync)) -> Result<Power, LabError> {
    let sessions = u64::from(request.observers) * u64::from(request.repeats);
    let assignments = assignments(&request.plan, request.observers);
    let plans = Plans::default();
    let estimator = Estimator::new(&request.plan, &request.simulation);
    let (next, failure) = (AtomicU64::new(0), Mutex::new(None));
    let done: Mutex<Vec<Vec<Simulated>>> = Mutex::new(Vec::new());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= sessions {
                break;
            }
            let (repeat, observer) = (index / u64::from(request.observers), index % u64::from(request.observers));
            let assignment = &assignments[observer as usize];
            match one(request, &plans, &estimator, repeat as u32, observer as u32, assignment) {
                Ok(simulated) => done.lock().unwrap_or_else(PoisonError::into_inner).push(simulated),
                Err(error) => {
                    failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    next.store(sessions, Ordering::Relaxed);
                }
            }
            progress();
        }
    };
    std::thread::scope(|scope| -> Result<(), LabError> {
        for worker in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            std::thread::Builder::new()
                .name(format!("power {worker}"))
                .spawn_scoped(scope, work)
                .map_err(|error| LabError::Failed(format!("cannot start a thread: {error}")))?;
        }
        Ok(())
    })?;
    if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    // Threads finish in any order; the result must not depend on it.
    let mut simulated: Vec<Simulated> =
        done.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().flatten().collect();
    simulated.sort_by_key(|one| (one.repeat, one.observer));
    let mut quantities: Vec<Quantity> = Vec::new();
    for one in &simulated {
        if !quantities.iter().any(|known| known.name == one.quantity) {
            quantities.push(estimator.quantity(&one.quantity));
        }
    }
    Ok(summarise(&simulated, &quantities))
}

/// Who is given what, as `run` would give it in this order.
fn assignments(plan: &Plan, observers: u32) -> Vec<Assignment> {
    let mut earlier: Vec<Earlier> = Vec::new();
    for index in 0..observers {
        let observer = format!("{index}");
        let assignment = next_assignment(plan, &observer, &earlier, false);
        earlier.push(Earlier { observer, assignment, finished: true });
    }
    earlier.into_iter().map(|session| session.assignment).collect()
}

/// What of an assignment decides its plan: group, sitting, and the observer's number where something goes round with it.
type PlanKey = (Option<String>, u32, u32);

/// The plans of assignments, made once each.
#[derive(Default)]
struct Plans(Mutex<HashMap<PlanKey, Arc<Plan>>>);

impl Plans {
    fn of(&self, whole: &Plan, assignment: &Assignment) -> Result<Arc<Plan>, LabError> {
        // The observer's number matters only where something goes round with it.
        let goes_round = whole.sittings.as_ref().is_some_and(|sittings| sittings.split_by.is_some())
            || whole.blocks.iter().any(|block| block.order.groups == GroupOrder::LatinSquare);
        let number = if goes_round { assignment.number } else { 0 };
        let key = (assignment.group.clone(), assignment.sitting, number);
        let mut plans = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(plan) = plans.get(&key) {
            return Ok(Arc::clone(plan));
        }
        let plan = whole.assigned(assignment).map_err(|error| LabError::BadInput(error.to_string()))?;
        Ok(Arc::clone(plans.entry(key).or_insert(Arc::new(plan))))
    }
}

/// One observer through all sittings, and what their answers give at each checkpoint.
fn one(
    request: &Request,
    plans: &Plans,
    estimator: &Estimator<'_>,
    repeat: u32,
    observer: u32,
    assignment: &Assignment,
) -> Result<Vec<Simulated>, LabError> {
    let seed = seed_of(request.seed, repeat, observer);
    let simulation = varied(&request.simulation, request.spread, seed);
    let sittings = request.plan.sittings.as_ref().map_or(1, |sittings| sittings.count);
    let mut answered: Vec<TrialRecord> = Vec::new();
    for sitting in 1..=sittings {
        let plan = plans.of(&request.plan, &Assignment { sitting, ..assignment.clone() })?;
        let seed = seed.wrapping_add(u64::from(sitting));
        let journal = simulate(&plan, seed, simulation.observer(seed).as_mut());
        let record = Record::from_events(&journal);
        answered.extend(record.trials.into_iter().filter(TrialRecord::counts));
    }
    let observed = Observed { simulation: &simulation, answered: &answered };
    let estimates = CHECKPOINTS.iter().flat_map(|&share| {
        let estimates = estimator.estimates(&observed, share);
        estimates.into_iter().map(move |estimate| Simulated { repeat, observer, share, ..estimate })
    });
    Ok(estimates.collect())
}

/// A seed for each observer of each repetition.
fn seed_of(seed: u64, repeat: u32, observer: u32) -> u64 {
    let place = (u64::from(repeat) << 32) | u64::from(observer);
    ChaCha8Rng::seed_from_u64(seed ^ place.wrapping_mul(0x9e37_79b9_7f4a_7c15)).random::<u64>() >> 11
}

/// An observer who differs from the typical one.
fn varied(simulation: &Simulation, spread: f64, seed: u64) -> Simulation {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || std::f64::consts::SQRT_2 * erf_inv(2.0 * rng.random_range(1e-9..1.0 - 1e-9) - 1.0);
    let mut simulation = simulation.clone();
    match &mut simulation.truth {
        Some(Truth::Mar(model)) => {
            model.m *= (spread * normal()).exp();
            model.omega0_deg *= (spread * normal()).exp();
        }
        Some(Truth::Parameter(truth)) if truth.log => truth.threshold *= (spread * normal()).exp(),
        Some(Truth::Parameter(truth)) => truth.threshold *= 1.0 + spread * normal(),
        None => {}
    }
    simulation
}
