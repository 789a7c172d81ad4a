//! Psi (Kontsevich & Tyler 1999): threshold and slope of a psychometric function, asked about wherever the least entropy
//! is expected to be left over both.
//!
//! Guess and lapse rate are fixed, as in the paper. With them fixed this is what QUEST+ does over two parameters (Watson
//! 2017 generalises it), so it runs on the same engine; it is a procedure of its own because its model is stated by slopes
//! and its estimates are the paper's, the posterior means of threshold and slope.

use super::on_grid::OnGrid;
use super::psychometric::width_from_slope;
use super::tabulation::{Grid, Tabulation};
use super::{Estimate, Procedure};
use crate::study::plan::{Level, PsiPlan};
use rand_chacha::ChaCha8Rng;

/// Psi. Estimates `threshold` and `slope`.
#[derive(Debug, Clone)]
pub struct Psi(OnGrid);

impl Psi {
    /// Starts the procedure; the first one of a plan makes its tables.
    #[must_use]
    pub fn new(plan: &PsiPlan) -> Self {
        let stimulus = |level: &Level| [level.get(&plan.parameter).copied().unwrap_or(f64::NAN), 0.0];
        let tabulation = Tabulation {
            stimuli: plan.levels.iter().map(stimulus).collect(),
            grid: Grid {
                threshold_slope: vec![0.0],
                threshold: plan.threshold.clone(),
                width: plan.slope.iter().map(|&slope| width_from_slope(plan.function, slope)).collect(),
                lapse: vec![plan.lapse],
                guess: vec![plan.guess],
            },
            function: plan.function,
            axis: plan.axis,
            harder: plan.harder,
        };
        // The posterior is over slopes, in the order of their widths.
        let reported = Grid { width: plan.slope.clone(), ..tabulation.grid.clone() };
        let names = [None, Some("threshold"), Some("slope"), None, None];
        let all = vec![(0..plan.levels.len()).collect()];
        Self(OnGrid::new(&plan.levels, all, &tabulation, &plan.tables, (names, reported), &plan.stop))
    }
}

impl Procedure for Psi {
    fn level(&mut self, rng: &mut ChaCha8Rng) -> Level {
        self.0.level(rng)
    }

    fn update(&mut self, level: &Level, correct: bool) {
        self.0.update(level, correct);
    }

    fn put_back(&mut self, level: Level, rng: &mut ChaCha8Rng) {
        self.0.put_back(level, rng);
    }

    fn finished(&self) -> bool {
        self.0.finished()
    }

    fn estimate(&self) -> Estimate {
        self.0.estimate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedures::psychometric::unscaled;
    use crate::streams::Stream;
    use crate::study::plan::{Axis, Function, Harder, Stop};
    use rand::RngExt;

    fn plan(function: Function, levels: &[f64], threshold: Vec<f64>, slope: Vec<f64>, trials: u32) -> PsiPlan {
        PsiPlan {
            levels: levels.iter().map(|&x| Level::from([("x".to_owned(), x)])).collect(),
            levels_beyond_display: 0,
            parameter: "x".to_owned(),
            harder: Harder::Down,
            function,
            axis: Axis::Linear,
            threshold,
            slope,
            guess: 0.5,
            lapse: 0.02,
            stop: Stop::Trials(trials),
            tables: Default::default(),
        }
    }

    fn spaced(min: f64, max: f64, steps: u32) -> Vec<f64> {
        (0..steps).map(|i| min + (max - min) * f64::from(i) / f64::from(steps - 1)).collect()
    }

    /// PsychoPy 2026.2.5's `PsiObject` (numpy 2.4.6, scipy 1.17.1) on the same grid and answers; made by
    /// tests/peers/psychopy_peer.py. Its lapse is δ/2 and its β is the SD of the normal, 1 / slope.
    #[test]
    fn levels_and_estimates_are_psychopys() {
        let levels = spaced(-5.0, 5.0, 41);
        let slope = spaced(0.5, 3.0, 11).into_iter().map(|sd| 1.0 / sd).collect();
        let mut psi = Psi::new(&plan(Function::CumulativeGauss, &levels, spaced(-4.0, 4.0, 33), slope, 12));
        let mut rng = Stream::Procedure.generator(1);
        let mut found = Vec::new();
        for right in [1, 1, 0, 1, 0, 1, 1, 1, 0, 1, 1, 1] {
            let level = psi.level(&mut rng);
            found.push(level["x"]);
            psi.update(&level, right == 1);
        }
        println!("{found:?} {:?}", psi.estimate());
        for (found, expected) in found.iter().zip(PSYCHOPY_LEVELS) {
            assert!((found - expected).abs() < 1e-9);
        }
        assert!((psi.estimate()["threshold"].mean - PSYCHOPY_THRESHOLD).abs() < 1e-9);
    }

    const PSYCHOPY_LEVELS: [f64; 12] = [0.75, 0.25, 0.0, 1.5, 1.5, 2.25, 2.25, 2.0, 2.0, 2.75, 2.5, 2.5];
    const PSYCHOPY_THRESHOLD: f64 = 1.515_104_692_146_851_8;

    /// Kontsevich & Tyler's steps 1 to 5, written out: the first level has the least expected entropy.
    #[test]
    fn the_first_level_is_the_definitions() {
        for function in [Function::CumulativeGauss, Function::Logistic] {
            let (levels, thresholds, slopes) = (spaced(-3.0, 4.0, 29), spaced(-2.0, 3.0, 16), spaced(0.4, 4.0, 9));
            let mut points = Vec::new();
            for &t in &thresholds {
                points.extend(slopes.iter().map(|&s| (t, s)));
            }
            let expected = |x: f64| -> f64 {
                [true, false]
                    .into_iter()
                    .map(|right| {
                        let likelihood = |&(t, s): &(f64, f64)| {
                            let seen = match function {
                                Function::Logistic => 1.0 / (1.0 + (-s * (x - t)).exp()),
                                _ => crate::mar::standard_normal_cdf(s * (x - t)),
                            };
                            let p = 0.5 + 0.48 * seen;
                            if right { p } else { 1.0 - p }
                        };
                        let sum: f64 = points.iter().map(likelihood).sum();
                        let posterior = points.iter().map(|point| likelihood(point) / sum);
                        let entropy: f64 = posterior.map(|p| -p * p.ln()).sum();
                        entropy * sum / points.len() as f64
                    })
                    .sum()
            };
            let direct = levels.iter().copied().min_by(|&a, &b| expected(a).total_cmp(&expected(b))).expect("levels");
            let mut psi = Psi::new(&plan(function, &levels, thresholds, slopes, 1));
            let first = psi.level(&mut Stream::Procedure.generator(1))["x"];
            assert!((first - direct).abs() < 1e-12, "{function:?}: {first} {direct}");
        }
    }

    /// With a known truth, the means of threshold and slope come to it within their error.
    #[test]
    fn it_closes_in_on_threshold_and_slope() {
        let function = Function::Logistic;
        let (truth, slope) = (0.7, 2.0);
        for seed in 1..=5 {
            let levels = spaced(-4.0, 4.0, 41);
            let grid = (spaced(-3.0, 3.0, 61), spaced(-1.0, 1.2, 23).into_iter().map(|log| 10_f64.powf(log)).collect());
            let mut psi = Psi::new(&plan(function, &levels, grid.0, grid.1, 400));
            let mut rng = Stream::Observer.generator(seed);
            while !psi.finished() {
                let level = psi.level(&mut rng);
                let seen = unscaled(function, (level["x"] - truth) / width_from_slope(function, slope));
                psi.update(&level, rng.random::<f64>() < 0.5 + 0.48 * seen);
            }
            let estimate = psi.estimate();
            println!("seed {seed}: {estimate:?}");
            assert!((estimate["threshold"].mean - truth).abs() < 4.0 * estimate["threshold"].sd);
            assert!(estimate["threshold"].sd < 0.2);
            assert!((estimate["slope"].mean - slope).abs() < 4.0 * estimate["slope"].sd);
        }
    }
}
