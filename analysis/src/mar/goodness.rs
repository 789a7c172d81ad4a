//! How well the fitted model describes the answers: a deviance, and how often the model itself would exceed it.
//!
//! Adaptive designs leave many levels with one or two trials, where a deviance says nothing about fit. Neighbouring levels
//! of one eccentricity are therefore pooled to at least [`POOL`] trials, and the reference distribution is simulated
//! instead of taken from χ².

use super::MarFitConfig;
use super::data::Data;
use experiments::mar::MarModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Goodness of fit of a MAR fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Goodness {
    /// Deviance of the pooled levels at the posterior mode: 2 Σ k ln(k/nψ) + (n − k) ln((n − k)/(n(1 − ψ))).
    pub deviance: f64,
    /// Pooled levels that it sums over.
    pub pooled_levels: usize,
    /// Posterior predictive p (Gelman, Meng and Stern 1996): the share of simulated data sets, one per posterior draw,
    /// whose deviance from that draw is at least the observed one's. Below about 0.01 the model misses structure in the
    /// data. Levels are held fixed.
    pub p: f64,
    /// Simulated data sets.
    pub simulations: usize,
}

/// Fewest trials in a pooled level.
pub(super) const POOL: u32 = 10;
const SIMULATIONS: usize = 300;

/// One (eccentricity, omega) of a pool.
struct Part {
    eccentricity_deg: f64,
    mar_deg: f64,
    n: u32,
    k: u32,
}

pub(super) fn goodness(data: &Data, map: &MarModel, draws: &[MarModel], config: &MarFitConfig) -> Goodness {
    let pools = pools(data);
    let mut rng = ChaCha8Rng::seed_from_u64(config.seed ^ 0x0600_df17);
    let mut exceeding = 0;
    let simulations = SIMULATIONS.min(draws.len());
    for draw in 0..simulations {
        // Spread over all draws, which lie in order of the integration's rounds.
        let model = &draws[draw * draws.len() / simulations];
        let (mut observed, mut simulated) = (0.0, 0.0);
        for pool in &pools {
            let (mut n, mut k, mut k_simulated, mut expected) = (0, 0, 0, 0.0);
            for part in pool {
                let p = model.probability_correct(part.eccentricity_deg, part.mar_deg, config.guess);
                n += part.n;
                k += part.k;
                k_simulated += (0..part.n).filter(|_| rng.random::<f64>() < p).count() as u32;
                expected += f64::from(part.n) * p;
            }
            observed += deviance(n, k, expected);
            simulated += deviance(n, k_simulated, expected);
        }
        exceeding += usize::from(simulated >= observed);
    }
    let at_map: f64 = pools
        .iter()
        .map(|pool| {
            let (n, k) = pool.iter().fold((0, 0), |(n, k), part| (n + part.n, k + part.k));
            let expected = pool
                .iter()
                .map(|part| {
                    f64::from(part.n) * map.probability_correct(part.eccentricity_deg, part.mar_deg, config.guess)
                })
                .sum();
            deviance(n, k, expected)
        })
        .sum();
    Goodness {
        deviance: at_map,
        pooled_levels: pools.len(),
        p: (exceeding as f64 + 1.0) / (simulations as f64 + 1.0),
        simulations,
    }
}

/// The binomial deviance of `k` of `n` against an expected count; never negative or NaN.
fn deviance(n: u32, k: u32, expected: f64) -> f64 {
    let term = |count: f64, expected: f64| {
        if count > 0.0 { count * (count / expected.max(1e-300)).ln() } else { 0.0 }
    };
    let (n, k) = (f64::from(n), f64::from(k));
    (2.0 * (term(k, expected) + term(n - k, n - expected))).max(0.0)
}

/// Shown cells of one eccentricity in order of omega, in groups of at least [`POOL`] trials where there are as many.
fn pools(data: &Data) -> Vec<Vec<Part>> {
    let mut pools: Vec<Vec<Part>> = Vec::new();
    let mut open = false;
    let mut last_e = f64::NAN;
    for cell in data.cells.iter().filter(|cell| cell.shown) {
        let same = cell.eccentricity_deg == last_e;
        if !(open && same) {
            // A short remainder of the previous eccentricity joins its neighbour.
            if open {
                close_short(&mut pools, last_e);
            }
            pools.push(Vec::new());
        }
        last_e = cell.eccentricity_deg;
        if let Some(pool) = pools.last_mut() {
            pool.push(Part { eccentricity_deg: cell.eccentricity_deg, mar_deg: cell.mar_deg, n: cell.n, k: cell.k });
            open = pool.iter().map(|part| part.n).sum::<u32>() < POOL;
        }
    }
    if open {
        close_short(&mut pools, last_e);
    }
    pools
}

fn close_short(pools: &mut Vec<Vec<Part>>, eccentricity_deg: f64) {
    let Some(short) = pools.pop() else { return };
    match pools.last_mut() {
        Some(before) if before.iter().all(|part| part.eccentricity_deg == eccentricity_deg) => {
            before.extend(short);
        }
        _ => pools.push(short),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviance_is_zero_at_the_data_and_known_elsewhere() {
        assert!(deviance(20, 15, 15.0).abs() < 1e-12);
        // 2 (15 ln(15/10) + 5 ln(5/10)) by hand.
        assert!((deviance(20, 15, 10.0) - 5.232_481_437_645_48).abs() < 1e-9);
        assert!(deviance(5, 0, 0.0).is_finite() && deviance(5, 5, 5.0) == 0.0);
    }
}
