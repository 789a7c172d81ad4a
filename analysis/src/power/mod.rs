//! Planning: what simulated studies say about a design before anybody is recruited.
//!
//! Simulations go in as plain numbers ([`Simulated`]); bias, root mean square error, coverage of the 95 % intervals and their
//! width come out, as functions of trials and of observers ([`Power`]). Whoever runs the simulations is no concern of
//! this module.

mod figure;

pub use figure::power_figure;

use crate::mar::Estimate;
use crate::numerics::{quantile_of_sorted, sorted_finite};
use crate::shares::{Mean, Share};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What one simulated observer gave for one quantity after a share of their trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// Which repetition of the whole study, from 0.
    pub repeat: u32,
    /// Which observer of it, from 0.
    pub observer: u32,
    /// The quantity: a name that stands for one estimate throughout.
    pub quantity: String,
    /// Which checkpoint: the share of the study's trials, 0–1; 1 is the whole study.
    pub share: f64,
    /// Answered trials up to there.
    pub trials: usize,
    /// The estimate; nothing if the data gave none.
    pub estimate: Option<f64>,
    /// Its 95 % interval, where the method has one.
    pub ci95: Option<[f64; 2]>,
    /// The observer's true value, where there is one.
    pub truth: Option<f64>,
}

/// What is known of a quantity besides its simulations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The name that simulations use.
    pub name: String,
    /// In words.
    pub label: String,
    /// Unit; may be empty.
    pub unit: String,
    /// Whether observers are averaged in its logarithm: for what is positive and varies in proportion.
    pub logarithmic: bool,
    /// The true value of the typical observer, where there is one.
    pub truth: Option<f64>,
}

/// What a design can be expected to give.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Power {
    /// Simulated sessions, all observers and repetitions together.
    pub sessions: usize,
    /// Sessions whose data gave no estimate of some quantity.
    pub failed: usize,
    /// Each quantity.
    pub quantities: Vec<QuantityPower>,
}

/// What a design can be expected to give for one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QuantityPower {
    /// What it is.
    #[serde(flatten)]
    pub quantity: Quantity,
    /// One observer, by trials; the last point is the whole study.
    pub by_trials: Vec<Point>,
    /// The mean over observers at the whole study, by the number of observers, with Student's t interval.
    pub by_observers: Vec<Point>,
}

/// Bias, error and intervals at one size of the study.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Observers in one estimate.
    pub observers: u32,
    /// Answered trials of one observer, median over the simulations.
    pub trials: usize,
    /// Estimates behind the point.
    pub estimates: usize,
    /// Simulations without an estimate.
    pub failed: usize,
    /// Mean of the estimates.
    pub mean: f64,
    /// Their standard deviation about the truth's difference.
    pub sd: f64,
    /// Mean of estimate − truth.
    pub bias: Option<f64>,
    /// Standard error of the bias: what the number of simulations leaves open.
    pub bias_se: Option<f64>,
    /// Root mean square of estimate − truth.
    pub rmse: Option<f64>,
    /// Share of 95 % intervals that hold the truth.
    pub coverage: Option<f64>,
    /// Wilson's 95 % interval of that share.
    pub coverage_ci95: Option<[f64; 2]>,
    /// Median width of the 95 % intervals.
    pub ci_width: Option<f64>,
}

/// Summarises simulations.
///
/// Checkpoints are ordered by their share. The mean over n observers is taken over the first n of each repetition, for n
/// of 1, 2, 3, 5, 10, 20, … up to all of them.
#[must_use]
pub fn summarise(simulated: &[Simulated], quantities: &[Quantity]) -> Power {
    let mut sessions: BTreeMap<(u32, u32), bool> = BTreeMap::new();
    for one in simulated {
        let whole = one.share >= 1.0;
        *sessions.entry((one.repeat, one.observer)).or_default() |= whole && one.estimate.is_none();
    }
    Power {
        sessions: sessions.len(),
        failed: sessions.values().filter(|&&failed| failed).count(),
        quantities: quantities
            .iter()
            .map(|quantity| {
                let own: Vec<&Simulated> = simulated.iter().filter(|one| one.quantity == quantity.name).collect();
                QuantityPower {
                    quantity: quantity.clone(),
                    by_trials: by_trials(&own),
                    by_observers: by_observers(&own, quantity),
                }
            })
            .collect(),
    }
}

fn by_trials(own: &[&Simulated]) -> Vec<Point> {
    let mut shares: Vec<f64> = own.iter().map(|one| one.share).collect();
    shares.sort_by(f64::total_cmp);
    shares.dedup_by(|a, b| a.total_cmp(b).is_eq());
    shares
        .into_iter()
        .map(|share| {
            let here: Vec<&Simulated> = own.iter().copied().filter(|one| one.share.total_cmp(&share).is_eq()).collect();
            let estimates: Vec<Judged> = here
                .iter()
                .filter_map(|one| Some(Judged { estimate: one.estimate?, ci95: one.ci95, truth: one.truth }))
                .collect();
            point(1, median_trials(&here), here.len() - estimates.len(), &estimates)
        })
        .collect()
}

fn by_observers(own: &[&Simulated], quantity: &Quantity) -> Vec<Point> {
    let whole: Vec<&Simulated> = own.iter().copied().filter(|one| one.share >= 1.0).collect();
    let observers = whole.iter().map(|one| one.observer + 1).max().unwrap_or(0);
    let mut repeats: BTreeMap<u32, Vec<&Simulated>> = BTreeMap::new();
    for one in &whole {
        repeats.entry(one.repeat).or_default().push(one);
    }
    let forward = |x: f64| if quantity.logarithmic { x.ln() } else { x };
    let back = |x: f64| if quantity.logarithmic { x.exp() } else { x };
    sizes(observers)
        .into_iter()
        .map(|n| {
            let mut failed = 0;
            let mut estimates = Vec::new();
            for group in repeats.values() {
                let values: Vec<f64> =
                    group.iter().filter(|one| one.observer < n).filter_map(|one| one.estimate.map(forward)).collect();
                match Mean::new(values) {
                    Some(mean) => estimates.push(Judged {
                        estimate: back(mean.mean),
                        ci95: mean.ci95.map(|interval| interval.map(back)),
                        truth: quantity.truth,
                    }),
                    None => failed += 1,
                }
            }
            point(n, median_trials(&whole), failed, &estimates)
        })
        .collect()
}

/// 1, 2, 3, 5, 10, 20, 30, 50, … and `most` itself.
fn sizes(most: u32) -> Vec<u32> {
    let steps = [1, 2, 3, 5, 10, 20, 30, 50, 100, 200, 300, 500, 1000];
    let mut sizes: Vec<u32> = steps.into_iter().filter(|&n| n < most).collect();
    if most > 0 {
        sizes.push(most);
    }
    sizes
}

/// An estimate to be held against its truth.
struct Judged {
    estimate: f64,
    ci95: Option<[f64; 2]>,
    truth: Option<f64>,
}

fn median_trials(simulated: &[&Simulated]) -> usize {
    let mut trials: Vec<usize> = simulated.iter().map(|one| one.trials).collect();
    trials.sort_unstable();
    trials.get(trials.len() / 2).copied().unwrap_or(0)
}

fn point(observers: u32, trials: usize, failed: usize, estimates: &[Judged]) -> Point {
    let n = estimates.len();
    let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let all: Vec<f64> = estimates.iter().map(|one| one.estimate).collect();
    let errors: Vec<f64> = estimates.iter().filter_map(|one| Some(one.estimate - one.truth?)).collect();
    let judged = !errors.is_empty();
    let spread = |values: &[f64]| {
        let mean = mean_of(values);
        (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0).max(1.0)).sqrt()
    };
    let held: Vec<bool> = estimates
        .iter()
        .filter_map(|one| {
            let [low, high] = one.ci95?;
            one.truth.map(|truth| (low..=high).contains(&truth))
        })
        .collect();
    let coverage = Share::of(&held, |&held| held);
    let widths = sorted_finite(estimates.iter().filter_map(|one| one.ci95.map(|[low, high]| high - low)));
    Point {
        observers,
        trials,
        estimates: n,
        failed,
        mean: mean_of(&all),
        sd: spread(if judged { &errors } else { &all }),
        bias: judged.then(|| mean_of(&errors)),
        bias_se: (errors.len() > 1).then(|| spread(&errors) / (errors.len() as f64).sqrt()),
        rmse: judged.then(|| mean_of(&errors.iter().map(|e| e * e).collect::<Vec<_>>()).sqrt()),
        coverage: coverage.map(|share| share.share),
        coverage_ci95: coverage.map(|share| share.wilson95),
        ci_width: quantile_of_sorted(&widths, 0.5),
    }
}

impl Simulated {
    /// The estimate with its interval taken from a fit.
    #[must_use]
    pub fn with_fit(self, fit: Estimate) -> Self {
        Self { estimate: Some(fit.estimate), ci95: Some(fit.ci95), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn quantity(logarithmic: bool) -> Quantity {
        Quantity {
            name: "m".to_owned(),
            label: "slope".to_owned(),
            unit: String::new(),
            logarithmic,
            truth: Some(if logarithmic { 2.0 } else { 10.0 }),
        }
    }

    fn one(repeat: u32, observer: u32, share: f64, estimate: Option<f64>) -> Simulated {
        Simulated {
            repeat,
            observer,
            quantity: "m".to_owned(),
            share,
            trials: (100.0 * share) as usize,
            estimate,
            ci95: estimate.map(|x| [x - 1.0, x + 1.0]),
            truth: Some(10.0),
        }
    }

    #[test]
    fn bias_error_and_coverage_are_what_a_hand_computes() {
        // Estimates 9, 10.5 and 12 of 10: errors −1, 0.5, 2; the last interval (11 to 13) does not hold 10.
        let runs =
            [one(0, 0, 1.0, Some(9.0)), one(1, 0, 1.0, Some(10.5)), one(2, 0, 1.0, Some(12.0)), one(3, 0, 1.0, None)];
        let power = summarise(&runs, &[quantity(false)]);
        assert_eq!((power.sessions, power.failed), (4, 1));
        let point = power.quantities[0].by_trials[0];
        assert_eq!((point.estimates, point.failed, point.trials), (3, 1, 100));
        assert!((point.bias.expect("truth") - 0.5).abs() < 1e-12);
        assert!((point.rmse.expect("truth") - (5.25_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((point.coverage.expect("intervals") - 2.0 / 3.0).abs() < 1e-12);
        assert!((point.ci_width.expect("intervals") - 2.0).abs() < 1e-12);
        assert!((point.sd - 1.5).abs() < 1e-12);
    }

    #[test]
    fn checkpoints_come_in_order_of_their_trials() {
        let runs: Vec<Simulated> = [1.0, 0.25, 0.5].map(|share| one(0, 0, share, Some(10.0))).to_vec();
        let trials: Vec<usize> =
            summarise(&runs, &[quantity(false)]).quantities[0].by_trials.iter().map(|p| p.trials).collect();
        assert_eq!(trials, [25, 50, 100]);
    }

    /// Student's t interval of a mean over observers holds the truth in 95 % of repetitions, also of few observers, and
    /// shrinks as it should.
    #[test]
    fn intervals_over_observers_have_their_coverage() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let mut runs = Vec::new();
        for repeat in 0..1500 {
            for observer in 0..10 {
                runs.push(one(repeat, observer, 1.0, Some((2.0_f64.ln() + 0.3 * normal()).exp())));
            }
        }
        let power = summarise(&runs, &[quantity(true)]);
        let points = &power.quantities[0].by_observers;
        assert_eq!(points.iter().map(|p| p.observers).collect::<Vec<_>>(), [1, 2, 3, 5, 10]);
        assert_eq!(points[0].coverage, None);
        for point in &points[1..] {
            let coverage = point.coverage.expect("intervals");
            println!("{} observers: coverage {coverage:.3}, bias {:.4}", point.observers, point.bias.expect("truth"));
            assert!((0.93..0.97).contains(&coverage), "{coverage}");
        }
        let ratio = points[2].sd / points[4].sd;
        assert!((ratio - (10.0_f64 / 3.0).sqrt()).abs() < 0.15, "{ratio}");
    }
}
