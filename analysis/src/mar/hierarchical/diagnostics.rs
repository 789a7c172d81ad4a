//! Whether chains agree: split R-hat and effective size (Gelman et al. 2013, §11.4–11.5).

use serde::{Deserialize, Serialize};

/// How far the chains can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Diagnostics {
    /// The largest split R-hat over the population's means and SDs; 1 when chains agree, suspect above 1.05.
    pub max_r_hat: f64,
    /// The smallest effective number of draws over the same.
    pub least_ess: f64,
    /// Draws kept, over all chains.
    pub draws: usize,
}

impl Diagnostics {
    /// R-hat at most 1.05 and at least 100 effective draws.
    #[must_use]
    pub fn settled(&self) -> bool {
        self.max_r_hat <= 1.05 && self.least_ess >= 100.0
    }
}

/// R-hat and effective size of one quantity from its chains, all of one length.
pub(in super::super) fn r_hat_and_ess(chains: &[Vec<f64>]) -> (f64, f64) {
    let halves: Vec<&[f64]> = chains
        .iter()
        .flat_map(|chain| {
            let half = chain.len() / 2;
            [&chain[..half], &chain[chain.len() - half..]]
        })
        .collect();
    let n = halves.first().map_or(0, |half| half.len());
    let m = halves.len() as f64;
    if n < 4 {
        return (f64::INFINITY, 1.0);
    }
    let length = n as f64;
    let means: Vec<f64> = halves.iter().map(|half| half.iter().sum::<f64>() / length).collect();
    let within = halves
        .iter()
        .zip(&means)
        .map(|(half, mean)| half.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (length - 1.0))
        .sum::<f64>()
        / m;
    let grand = means.iter().sum::<f64>() / m;
    let between = length * means.iter().map(|mean| (mean - grand).powi(2)).sum::<f64>() / (m - 1.0).max(1.0);
    let pooled = (length - 1.0) / length * within + between / length;
    if !(pooled > 0.0 && within > 0.0) {
        return (1.0, m * length);
    }
    // Autocorrelation by the variogram, summed in pairs while these are positive.
    let correlation = |lag: usize| {
        let variogram = halves
            .iter()
            .map(|half| half[lag..].iter().zip(*half).map(|(a, b)| (a - b).powi(2)).sum::<f64>())
            .sum::<f64>()
            / (m * (n - lag) as f64);
        1.0 - variogram / (2.0 * pooled)
    };
    let mut sum = 0.0;
    let mut lag = 1;
    while lag + 1 < n.min(400) {
        let pair = correlation(lag) + correlation(lag + 1);
        if pair < 0.0 {
            break;
        }
        sum += pair;
        lag += 2;
    }
    ((pooled / within).sqrt(), (m * length / (1.0 + 2.0 * sum)).min(m * length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// An autoregression of first order with coefficient ρ has n (1 − ρ)/(1 + ρ) effective draws.
    #[test]
    fn the_effective_size_of_an_autoregression_is_known() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        for rho in [0.0f64, 0.5, 0.8] {
            let chains: Vec<Vec<f64>> = (0..4)
                .map(|_| {
                    let mut x = 0.0;
                    (0..5000)
                        .map(|_| {
                            x = rho * x + crate::numerics::normal_quantile(rng.random_range(1e-9..1.0 - 1e-9));
                            x
                        })
                        .collect()
                })
                .collect();
            let (r_hat, ess) = r_hat_and_ess(&chains);
            let expected = 20_000.0 * (1.0 - rho) / (1.0 + rho);
            assert!((ess / expected - 1.0).abs() < 0.12, "ρ = {rho}: {ess} against {expected}");
            assert!(r_hat < 1.01);
        }
    }

    #[test]
    fn chains_apart_are_seen() {
        let chain = |offset: f64| (0..200).map(|i| offset + f64::from(i % 7)).collect::<Vec<f64>>();
        assert!(r_hat_and_ess(&[chain(0.0), chain(30.0)]).0 > 3.0);
        assert_eq!(r_hat_and_ess(&[vec![1.0; 50], vec![1.0; 50]]).0, 1.0);
    }
}
