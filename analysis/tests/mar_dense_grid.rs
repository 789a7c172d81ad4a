//! The posterior against a dense four-dimensional grid, integrated here from the model's definition.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod common;

use analysis::mar::{Estimate, MarFitConfig, Moments, fit_mar};
use common::{ECCENTRICITIES, TRUTH, constant_stimuli};
use experiments::mar::MarModel;

const N: usize = 33;

/// Name, reference, our moments, our estimate, and the parameter of a coordinate.
type Check<'a> = (&'a str, &'a Marginal, &'a Moments, &'a Estimate, fn(f64) -> f64);

/// A uniform grid with the marginal density on it.
struct Marginal {
    grid: Vec<f64>,
    mass: Vec<f64>,
}

impl Marginal {
    fn new(low: f64, high: f64) -> Self {
        let grid = (0..N).map(|i| low + (high - low) * (i as f64 + 0.5) / N as f64).collect();
        Self { grid, mass: vec![0.0; N] }
    }

    fn moments(&self) -> (f64, f64) {
        let total: f64 = self.mass.iter().sum();
        let mean = self.grid.iter().zip(&self.mass).map(|(x, p)| x * p).sum::<f64>() / total;
        let square = self.grid.iter().zip(&self.mass).map(|(x, p)| (x - mean).powi(2) * p).sum::<f64>() / total;
        (mean, square.sqrt())
    }

    /// The density is taken log-linear inside a cell, with the slope of its neighbours.
    fn quantile(&self, q: f64) -> f64 {
        let goal = q * self.mass.iter().sum::<f64>();
        let step = self.grid[1] - self.grid[0];
        let mut before = 0.0;
        for (i, mass) in self.mass.iter().enumerate() {
            if before + mass >= goal {
                let (left, right) = (self.mass[i.saturating_sub(1)], self.mass[(i + 1).min(N - 1)]);
                let rate = 0.5 * (right.max(1e-300) / left.max(1e-300)).ln();
                let share = (goal - before) / mass;
                let u = if rate.abs() < 1e-6 { share } else { (share * rate.exp_m1()).ln_1p() / rate };
                return self.grid[i] + step * (u - 0.5);
            }
            before += mass;
        }
        f64::NAN
    }
}

#[test]
fn moments_and_quantiles_agree_with_a_dense_grid() {
    let seed = 11;
    let trials = constant_stimuli(&TRUTH, &ECCENTRICITIES, 140, seed);
    let fit = fit_mar(&trials, &MarFitConfig { seed, ..MarFitConfig::default() }).unwrap();

    // The grid spans six posterior standard deviations; lapses go from 0.
    let around = |m: &Moments| Marginal::new(m.mean - 6.0 * m.sd, m.mean + 5.0 * m.sd);
    let mut axes = [
        around(&fit.moments.ln_m),
        around(&fit.moments.ln_omega0),
        around(&fit.moments.ln_width),
        Marginal::new(0.0, fit.moments.lapse.mean + 7.0 * fit.moments.lapse.sd),
    ];
    let normal = |x: f64, mean: f64, sd: f64| -0.5 * ((x - mean) / sd).powi(2);
    let ln_density = |x: [f64; 4]| {
        let model = MarModel { m: x[0].exp(), omega0_deg: x[1].exp(), width: x[2].exp(), lapse: x[3] };
        let mut sum = normal(x[0], 0.025f64.ln(), 1.5) + normal(x[1], (1.0f64 / 48.0).ln(), 1.5);
        sum += normal(x[2], 0.8f64.ln(), 0.8) + 9.0 * (1.0 - x[3]).ln();
        for cell in &fit.cells {
            let p = model.probability_correct(cell.eccentricity_deg, cell.mar_deg, 0.5);
            sum += f64::from(cell.k) * p.ln() + f64::from(cell.n - cell.k) * (1.0 - p).ln();
        }
        sum
    };
    let map = &fit.map;
    let top = ln_density([map.m.ln(), map.omega0_deg.ln(), map.width.ln(), map.lapse]);
    let grids: Vec<Vec<f64>> = axes.iter().map(|axis| axis.grid.clone()).collect();
    for i in 0..N {
        for j in 0..N {
            for k in 0..N {
                for l in 0..N {
                    let ln = ln_density([grids[0][i], grids[1][j], grids[2][k], grids[3][l]]);
                    assert!(ln <= top + 1e-9, "the reported mode is not the highest point");
                    let p = (ln - top).exp();
                    for (axis, index) in axes.iter_mut().zip([i, j, k, l]) {
                        axis.mass[index] += p;
                    }
                }
            }
        }
    }

    let exponential: fn(f64) -> f64 = f64::exp;
    let checks: [Check<'_>; 4] = [
        ("ln m", &axes[0], &fit.moments.ln_m, &fit.m, exponential),
        ("ln omega0", &axes[1], &fit.moments.ln_omega0, &fit.omega0, exponential),
        ("ln width", &axes[2], &fit.moments.ln_width, &fit.width, exponential),
        ("lapse", &axes[3], &fit.moments.lapse, &fit.lapse, |x| x),
    ];
    for (name, marginal, moments, estimate, value) in checks {
        let (mean, sd) = marginal.moments();
        let mean_error = (moments.mean - mean) / sd;
        let sd_error = moments.sd / sd - 1.0;
        let width = value(marginal.quantile(0.975)) - value(marginal.quantile(0.025));
        let errors = [(0.025, estimate.ci95[0]), (0.5, estimate.estimate), (0.975, estimate.ci95[1])]
            .map(|(q, ours)| (ours - value(marginal.quantile(q))) / width);
        println!(
            "seed {seed}, {name}: mean off by {mean_error:+.4} SD, SD by {:+.2} %, quantiles (2.5, 50, 97.5 %) by \
             {:+.4}, {:+.4}, {:+.4} of the interval",
            100.0 * sd_error,
            errors[0],
            errors[1],
            errors[2]
        );
        assert!(mean_error.abs() < 0.03, "{name}: mean");
        assert!(sd_error.abs() < 0.03, "{name}: standard deviation");
        assert!(errors.iter().all(|e| e.abs() < 0.02), "{name}: quantiles {errors:?}");
    }
}
