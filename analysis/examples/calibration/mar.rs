//! Simulations for the MAR fits, shared by the example and by `tests/calibration_mar.rs`.
//!
//! Levels are constant stimuli that know nothing of the truth: at each eccentricity seven levels from 0.45 to 2.2 times
//! the MAR of the prior's median observer.
#![allow(dead_code, unreachable_pub, clippy::print_stdout, clippy::unwrap_used)]

use crate::ranks::{Calibration, print_table};
use analysis::mar::hierarchical::{HierarchicalConfig, ObserverTrials, fit_hierarchical};
use analysis::mar::{LogNormal, MarFitConfig, MarPriors, MarTrial, fit_mar};
use experiments::mar::MarModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use statrs::distribution::{Beta, ContinuousCDF, Normal};

pub const ECCENTRICITIES: [f64; 5] = [2.0, 6.0, 11.0, 17.0, 24.0];

/// The prior from which truths are drawn and under which they are fitted: narrower than the default, so that most
/// observers can see some levels and not others.
pub fn narrow_prior() -> MarPriors {
    MarPriors {
        m: LogNormal { median: 0.022, sd_ln: 0.4 },
        omega0: LogNormal { median: 1.0 / 48.0, sd_ln: 0.5 },
        width: LogNormal { median: 0.8, sd_ln: 0.4 },
        lapse_beta: [1.0, 10.0],
    }
}

/// A beta deviate by inversion, cut at `most`.
fn beta(shapes: [f64; 2], most: f64, rng: &mut ChaCha8Rng) -> f64 {
    if shapes[0] == 1.0 {
        // In closed form: 1 − (1 − u)^(1/b).
        let below = 1.0 - (1.0 - most).powf(shapes[1]);
        return -((-rng.random::<f64>() * below).ln_1p() / shapes[1]).exp_m1();
    }
    let distribution = Beta::new(shapes[0], shapes[1]).unwrap();
    distribution.inverse_cdf(rng.random::<f64>() * distribution.cdf(most)).clamp(0.0, most)
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    Normal::standard().inverse_cdf(rng.random_range(1e-12..1.0 - 1e-12))
}

fn lognormal(prior: LogNormal, rng: &mut ChaCha8Rng) -> f64 {
    prior.median * (prior.sd_ln * normal(rng)).exp()
}

/// `per_level` trials at each of seven levels of each eccentricity.
pub fn trials(truth: &MarModel, median: (f64, f64), per_level: usize, rng: &mut ChaCha8Rng) -> Vec<MarTrial> {
    let mut trials = Vec::new();
    for eccentricity_deg in ECCENTRICITIES {
        for step in 0..7 {
            let mar_deg = (median.0 * eccentricity_deg + median.1) * (0.264 * f64::from(step) - 0.8).exp();
            let p = truth.probability_correct(eccentricity_deg, mar_deg, 0.5);
            trials.extend((0..per_level).map(|_| MarTrial {
                eccentricity_deg,
                mar_deg,
                correct: rng.random::<f64>() < p,
            }));
        }
    }
    trials
}

/// Fit simulated observers and rank their truths; `truth` fixes them, otherwise they are drawn from `priors`.
pub fn simulate(
    fits: usize,
    seed: u64,
    priors: &MarPriors,
    per_level: usize,
    truth: Option<MarModel>,
) -> Vec<Calibration> {
    let results: Vec<[(f64, bool); 4]> = (0..fits)
        .into_par_iter()
        .map(|index| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(index as u64);
            let drawn = MarModel {
                m: lognormal(priors.m, &mut rng),
                omega0_deg: lognormal(priors.omega0, &mut rng),
                width: lognormal(priors.width, &mut rng),
                lapse: beta(priors.lapse_beta, 0.5, &mut rng),
            };
            let truth = truth.unwrap_or(drawn);
            let trials = trials(&truth, (priors.m.median, priors.omega0.median), per_level, &mut rng);
            let config =
                MarFitConfig { priors: *priors, seed: seed.wrapping_add(index as u64), ..MarFitConfig::default() };
            let fit = fit_mar(&trials, &config).unwrap();
            let rank = |of: fn(&MarModel) -> f64| {
                let below = fit.posterior.iter().filter(|draw| of(draw) < of(&truth)).count();
                (below as f64 + 0.5) / (fit.posterior.len() as f64 + 1.0)
            };
            let inside = |ci: [f64; 2], value: f64| ci[0] <= value && value <= ci[1];
            [
                (rank(|p| p.m), inside(fit.m.ci95, truth.m)),
                (rank(|p| p.omega0_deg), inside(fit.omega0.ci95, truth.omega0_deg)),
                (rank(|p| p.width), inside(fit.width.ci95, truth.width)),
                (rank(|p| p.lapse), inside(fit.lapse.ci95, truth.lapse)),
            ]
        })
        .collect();
    ["m", "omega0", "width", "lapse"]
        .into_iter()
        .enumerate()
        .map(|(i, name)| Calibration {
            name,
            ranks: results.iter().map(|r| r[i].0).collect(),
            covered: results.iter().filter(|r| r[i].1).count(),
        })
        .collect()
}

pub const TRUTH: MarModel = MarModel { m: 0.022, omega0_deg: 1.0 / 48.0, width: 0.8, lapse: 0.02 };

pub const SEED: u64 = 20_251_122;

pub fn print(fits: usize, seed: u64) {
    for (table, (title, priors, per_level, truth)) in [
        ("truths from the narrow prior, 700 trials", narrow_prior(), 20, None),
        ("truths from the narrow prior, 175 trials", narrow_prior(), 5, None),
        ("truths from the default prior, 350 trials", MarPriors::default(), 10, None),
        ("fixed truth, default prior in the fit, 700 trials", MarPriors::default(), 20, Some(TRUTH)),
        ("fixed truth, default prior in the fit, 280 trials", MarPriors::default(), 8, Some(TRUTH)),
    ]
    .into_iter()
    .enumerate()
    {
        // Tables of one seed would share their truths and be wrong together.
        let seed = seed + 1_000_000 * table as u64;
        let calibrations = simulate(fits, seed, &priors, per_level, truth);
        print_table(&format!("{title}: {fits} fits, seed {seed}"), &calibrations, true);
    }
}

/// The population from which groups are drawn: medians and SDs of ln m, ln omega0, ln width; lapses from Beta(1, 20).
pub const POPULATION: [(f64, f64); 3] = [(0.022, 0.25), (1.0 / 48.0, 0.3), (0.8, 0.25)];

/// One simulated group.
pub fn group(observers: usize, per_level: usize, rng: &mut ChaCha8Rng) -> (Vec<MarModel>, Vec<ObserverTrials>) {
    (0..observers)
        .map(|who| {
            let draw = |(median, sd_ln): (f64, f64), rng: &mut ChaCha8Rng| lognormal(LogNormal { median, sd_ln }, rng);
            let truth = MarModel {
                m: draw(POPULATION[0], rng),
                omega0_deg: draw(POPULATION[1], rng),
                width: draw(POPULATION[2], rng),
                lapse: beta([1.0, 20.0], 0.2, rng),
            };
            let trials = trials(&truth, (POPULATION[0].0, POPULATION[1].0), per_level, rng);
            (truth, ObserverTrials { id: format!("P{who:02}"), trials, finest_mar: Vec::new() })
        })
        .unzip()
}

/// How often intervals of a group's fit held the truth.
#[derive(Debug, Clone, Copy, Default)]
pub struct GroupCoverage {
    pub groups: usize,
    pub observers: usize,
    pub m: usize,
    pub omega0: usize,
    pub width: usize,
    pub sd_m: usize,
    pub sd_omega0: usize,
    /// A new observer's m in its prediction interval.
    pub new_m: usize,
    /// Observers' own m in their pooled intervals, over `groups · observers`.
    pub own_m: usize,
    /// Mean ratio of interval ends of the group's m.
    pub interval_ratio: f64,
    /// RMSE of ln m of single observers, pooled and alone.
    pub rmse: [f64; 2],
    pub max_r_hat: f64,
    pub least_ess: f64,
}

/// `per_level` 7 is 245 trials.
pub fn simulate_groups(groups: usize, observers: usize, per_level: usize, seed: u64) -> GroupCoverage {
    let results: Vec<GroupCoverage> = (0..groups)
        .into_par_iter()
        .map(|index| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(index as u64);
            let (truths, data) = group(observers, per_level, &mut rng);
            let config = HierarchicalConfig { seed: seed.wrapping_add(index as u64), ..HierarchicalConfig::default() };
            let fit = fit_hierarchical(&data, &config).unwrap();
            let holds = |ci: [f64; 2], value: f64| usize::from(ci[0] <= value && value <= ci[1]);
            let new_m = lognormal(LogNormal { median: POPULATION[0].0, sd_ln: POPULATION[0].1 }, &mut rng);
            let n = observers as f64;
            let error = |value: fn(&analysis::mar::hierarchical::ObserverEstimate) -> f64| {
                fit.observers.iter().zip(&truths).map(|(o, truth)| (value(o) / truth.m).ln().powi(2)).sum::<f64>() / n
            };
            GroupCoverage {
                groups: 1,
                observers,
                m: holds(fit.m.median.ci95, POPULATION[0].0),
                omega0: holds(fit.omega0.median.ci95, POPULATION[1].0),
                width: holds(fit.width.median.ci95, POPULATION[2].0),
                sd_m: holds(fit.m.sd_ln.ci95, POPULATION[0].1),
                sd_omega0: holds(fit.omega0.sd_ln.ci95, POPULATION[1].1),
                new_m: holds(fit.m.new_observer.ci95, new_m),
                own_m: fit.observers.iter().zip(&truths).map(|(o, truth)| holds(o.m.pooled.ci95, truth.m)).sum(),
                interval_ratio: fit.m.median.ci95[1] / fit.m.median.ci95[0],
                rmse: [error(|o| o.m.pooled.estimate), error(|o| o.m.alone.estimate)],
                max_r_hat: fit.diagnostics.max_r_hat,
                least_ess: fit.diagnostics.least_ess,
            }
        })
        .collect();
    let mut total = GroupCoverage { observers, least_ess: f64::INFINITY, ..GroupCoverage::default() };
    for r in &results {
        total.groups += 1;
        total.m += r.m;
        total.omega0 += r.omega0;
        total.width += r.width;
        total.sd_m += r.sd_m;
        total.sd_omega0 += r.sd_omega0;
        total.new_m += r.new_m;
        total.own_m += r.own_m;
        total.interval_ratio += r.interval_ratio / groups as f64;
        total.rmse = [total.rmse[0] + r.rmse[0] / groups as f64, total.rmse[1] + r.rmse[1] / groups as f64];
        total.max_r_hat = total.max_r_hat.max(r.max_r_hat);
        total.least_ess = total.least_ess.min(r.least_ess);
    }
    total.rmse = total.rmse.map(f64::sqrt);
    total
}

pub fn print_groups(groups: usize, observers: usize, seed: u64) {
    let c = simulate_groups(groups, observers, 7, seed);
    let share = |count: usize| count as f64 / groups as f64;
    println!("{groups} groups of {observers} observers × 245 trials, seed {seed}: coverage of 95 % intervals");
    println!("| m | omega0 | width | SD of ln m | SD of ln omega0 | new observer's m | observers' own m |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    println!(
        "| {:.4} | {:.4} | {:.4} | {:.4} | {:.4} | {:.4} | {:.4} |",
        share(c.m),
        share(c.omega0),
        share(c.width),
        share(c.sd_m),
        share(c.sd_omega0),
        share(c.new_m),
        share(c.own_m) / observers as f64
    );
    println!(
        "mean ratio of the interval's ends of m {:.2}; RMSE of ln m of single observers {:.4} pooled, {:.4} alone; largest \
         R-hat {:.3}, least ESS {:.0}\n",
        c.interval_ratio, c.rmse[0], c.rmse[1], c.max_r_hat, c.least_ess
    );
}
