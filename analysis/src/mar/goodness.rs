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
                k_simulated += binomial(part.n, p, &mut rng);
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

/// A binomial count by inversion: one uniform, walked up the distribution. Large counts are drawn in parts, since the
/// walk starts at (1 − p)ⁿ.
pub(super) fn binomial(n: u32, p: f64, rng: &mut ChaCha8Rng) -> u32 {
    const PART: u32 = 50;
    let p = p.clamp(0.0, 1.0);
    let (q, mirrored) = if p > 0.5 { (1.0 - p, true) } else { (p, false) };
    let odds = q / (1.0 - q);
    let (mut left, mut count) = (n, 0);
    while left > 0 {
        let part = left.min(PART);
        left -= part;
        let mut mass = (1.0 - q).powi(part as i32);
        let mut u = rng.random::<f64>();
        let mut k = 0;
        while u >= mass && k < part {
            u -= mass;
            mass *= odds * f64::from(part - k) / f64::from(k + 1);
            k += 1;
        }
        count += k;
    }
    if mirrored { n - count } else { count }
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
    fn binomial_counts_have_the_moments_of_their_distribution() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for (n, p) in [(1, 0.3), (20, 0.9), (20, 0.5), (130, 0.02), (7, 1.0), (7, 0.0)] {
            let draws: Vec<f64> = (0..20_000).map(|_| f64::from(binomial(n, p, &mut rng))).collect();
            let mean = draws.iter().sum::<f64>() / 20_000.0;
            let variance = draws.iter().map(|k| (k - mean).powi(2)).sum::<f64>() / 19_999.0;
            let expected = f64::from(n) * p * (1.0 - p);
            // Five standard errors of the mean; the variance's is below 3 % of itself here.
            assert!((mean - f64::from(n) * p).abs() <= 5.0 * (expected / 20_000.0).sqrt(), "{n}, {p}: mean {mean}");
            assert!((variance - expected).abs() <= 0.06 * expected, "{n}, {p}: variance {variance}, {expected}");
        }
    }

    #[test]
    fn the_deviance_is_zero_at_the_data_and_known_elsewhere() {
        assert!(deviance(20, 15, 15.0).abs() < 1e-12);
        // 2 (15 ln(15/10) + 5 ln(5/10)) by hand.
        assert!((deviance(20, 15, 10.0) - 5.232_481_437_645_48).abs() < 1e-9);
        assert!(deviance(5, 0, 0.0).is_finite() && deviance(5, 5, 5.0) == 0.0);
    }
}
