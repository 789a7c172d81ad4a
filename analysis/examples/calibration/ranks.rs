//! Ranks of truths within their posteriors: uniform where intervals are as wide as they say (Talts et al. 2018).
#![allow(dead_code, unreachable_pub, clippy::print_stdout)]

use statrs::distribution::{Binomial, ChiSquared, ContinuousCDF, DiscreteCDF};

pub const BINS: usize = 20;

/// How one parameter came out over many fits.
#[derive(Debug, Clone, Default)]
pub struct Calibration {
    pub name: &'static str,
    /// Of the truth within the posterior, 0–1; uniform where the fit is right.
    pub ranks: Vec<f64>,
    pub covered: usize,
}

impl Calibration {
    pub fn coverage(&self) -> f64 {
        self.covered as f64 / self.ranks.len() as f64
    }

    /// χ² of the ranks in 20 bins against equal counts, and its p.
    pub fn uniformity(&self) -> (f64, f64) {
        let expected = self.ranks.len() as f64 / BINS as f64;
        let mut counts = [0.0; BINS];
        for rank in &self.ranks {
            counts[((rank * BINS as f64) as usize).min(BINS - 1)] += 1.0;
        }
        let chi2: f64 = counts.iter().map(|count| (count - expected).powi(2) / expected).sum();
        #[allow(clippy::expect_used)]
        let distribution = ChiSquared::new(BINS as f64 - 1.0).expect("19 is a number of degrees of freedom");
        (chi2, distribution.sf(chi2))
    }

    /// Kolmogorov's distance of the ranks from uniform, and its p (asymptotic series).
    pub fn distance(&self) -> (f64, f64) {
        let mut sorted = self.ranks.clone();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len() as f64;
        let distance = sorted
            .iter()
            .enumerate()
            .map(|(i, u)| (u - i as f64 / n).abs().max((i as f64 + 1.0) / n - u))
            .fold(0.0, f64::max);
        let t = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
        let p: f64 = (1..100)
            .map(|k| {
                let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
                2.0 * sign * (-2.0 * f64::from(k * k) * t * t).exp()
            })
            .sum();
        (distance, p.clamp(0.0, 1.0))
    }
}

/// 95 % intervals must hold as many truths as a binomial with p = 0.95 does, outside it once in 2000 on either side.
pub fn assert_covers(calibrations: &[Calibration], title: &str) {
    for c in calibrations {
        let n = c.ranks.len() as u64;
        #[allow(clippy::expect_used)]
        let binomial = Binomial::new(0.95, n).expect("0.95 is a probability");
        let ((chi2, p), (distance, p_distance)) = (c.uniformity(), c.distance());
        println!(
            "{title}, {}: held {} of {n}; ranks χ²(19) {chi2:.1}, p {p:.4}; KS {distance:.4}, p {p_distance:.4}",
            c.name, c.covered
        );
        let (low, high) = (binomial.cdf(c.covered as u64), 1.0 - binomial.cdf((c.covered as u64).saturating_sub(1)));
        assert!(low > 5e-4 && high > 5e-4, "{title}, {}: {} of {n} held", c.name, c.covered);
    }
}

/// Ranks must be uniform: with a dozen parameters, one p below 10⁻⁴ comes once in some hundred runs with other seeds.
pub fn assert_uniform(calibrations: &[Calibration], title: &str) {
    for c in calibrations {
        let ((_, p), (_, p_distance)) = (c.uniformity(), c.distance());
        assert!(p > 1e-4 && p_distance > 1e-4, "{title}, {}: p {p}, {p_distance}", c.name);
    }
}

/// A table of `CALIBRATION.md`; ranks are shown where they should be uniform.
pub fn print_table(title: &str, calibrations: &[Calibration], with_ranks: bool) {
    println!("{title}");
    if with_ranks {
        println!("\n| parameter | coverage of 95 % | mean rank | χ²(19) of ranks | p | KS distance | p |");
        println!("| --- | --- | --- | --- | --- | --- | --- |");
    } else {
        println!("\n| parameter | coverage of 95 % |\n| --- | --- |");
    }
    for c in calibrations {
        let ((chi2, p), (distance, p_distance)) = (c.uniformity(), c.distance());
        if with_ranks {
            let mean = c.ranks.iter().sum::<f64>() / c.ranks.len() as f64;
            println!(
                "| {} | {:.4} | {mean:.4} | {chi2:.1} | {p:.3} | {distance:.4} | {p_distance:.3} |",
                c.name,
                c.coverage()
            );
        } else {
            println!("| {} | {:.4} |", c.name, c.coverage());
        }
    }
    println!();
}
