//! QUEST (Watson & Pelli 1983), with the tables and the choices of Pelli's program (`QuestCreate`, `QuestUpdate`,
//! `QuestQuantile`, … of the Psychophysics Toolbox, and PsychoPy's translation of it).
//!
//! The psychometric function over intensity x, relative to the threshold t, is a Weibull function of 10^x (Pelli 1987):
//! p(x) = δγ + (1 − δ) (1 − (1 − γ) exp(−10^{β (x − t + ε)})), with ε such that p = `p_threshold` at threshold. The posterior
//! stands on a grid of thresholds around the start. Intensity is the parameter or its log10, negated where larger values are
//! harder, so that p always rises with it.

use super::{Belief, Estimate, Procedure};
use crate::study::plan::{Axis, Harder, Level, QuestMethod, QuestPlan};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::LN_10;

/// The largest number of grid points between the start and either end of the range.
pub const MOST_HALF_POINTS: i64 = 50_000;

/// QUEST. Estimates the parameter that it moves, by its own name: the posterior mean, on a log axis the geometric one, with
/// the posterior SD, on a log axis carried over to the parameter to first order.
#[derive(Debug, Clone)]
pub struct Quest {
    plan: QuestPlan,
    /// Grid points on either side of the start.
    half: i64,
    /// Intensity at the start.
    guess: f64,
    /// Relative thresholds −half … half, times the grain; sums to 1.
    posterior: Vec<f64>,
    /// Probability of a right answer at intensities −2 half … 2 half, times the grain, above threshold.
    success: Vec<f64>,
    /// The quantile that tells most.
    quantile_order: f64,
    completed: u32,
    finished: bool,
}

impl Quest {
    /// Tabulates prior and psychometric function.
    #[must_use]
    pub fn new(plan: &QuestPlan) -> Self {
        let half = half_points(plan);
        let relative = |index: i64| index as f64 * plan.grain;
        let prior = (-half..=half).map(|index| (-0.5 * (relative(index) / plan.start_sd).powi(2)).exp());
        let mut posterior: Vec<f64> = prior.collect();
        normalise(&mut posterior);

        // The offset is read off the tabulated function, as in Pelli's program.
        let weibull = |x: f64| {
            let miss = (-10_f64.powf(plan.beta * x)).exp();
            plan.delta * plan.gamma + (1.0 - plan.delta) * (1.0 - (1.0 - plan.gamma) * miss)
        };
        let intensities: Vec<f64> = (-2 * half..=2 * half).map(relative).collect();
        let raw: Vec<f64> = intensities.iter().map(|&x| weibull(x)).collect();
        let rising: Vec<usize> = (0..raw.len().saturating_sub(1)).filter(|&i| raw[i + 1] > raw[i]).collect();
        let offset = interpolate(plan.p_threshold, rising.iter().map(|&i| (raw[i], intensities[i])));
        let success: Vec<f64> = intensities.iter().map(|&x| weibull(x + offset)).collect();

        Self {
            quantile_order: best_quantile(success[0], success[success.len() - 1]),
            guess: intensity(plan, plan.start),
            plan: plan.clone(),
            half,
            posterior,
            success,
            completed: 0,
            finished: false,
        }
    }

    /// Relative threshold of a grid point.
    fn relative(&self, index: usize) -> f64 {
        (index as i64 - self.half) as f64 * self.plan.grain
    }

    /// Posterior mean and SD of the threshold's intensity.
    fn moments(&self) -> (f64, f64) {
        let weighted = |of: &dyn Fn(f64) -> f64| -> f64 {
            self.posterior.iter().enumerate().map(|(index, p)| p * of(self.relative(index))).sum()
        };
        let mean = weighted(&|x| x);
        (self.guess + mean, weighted(&|x| (x - mean).powi(2)).max(0.0).sqrt())
    }

    /// The posterior's mode, as an intensity; the first of equals.
    fn mode(&self) -> f64 {
        let best = |best: usize, index: usize| if self.posterior[index] > self.posterior[best] { index } else { best };
        self.guess + self.relative((0..self.posterior.len()).fold(0, best))
    }

    /// A quantile of the posterior, as an intensity, between grid points by interpolation.
    fn quantile(&self, order: f64) -> f64 {
        let mut sum = 0.0;
        let mut points = Vec::with_capacity(self.posterior.len());
        for (index, p) in self.posterior.iter().enumerate() {
            let before = sum;
            sum += p;
            if sum > before || index == 0 {
                points.push((sum, self.relative(index)));
            }
        }
        self.guess + interpolate(order * sum, points.into_iter())
    }

    /// What is asked at next, as a value of the parameter.
    fn next_value(&self) -> f64 {
        if self.completed == 0 {
            return self.plan.start;
        }
        let wanted = match self.plan.method {
            QuestMethod::Quantile => self.quantile(self.quantile_order),
            QuestMethod::Mean => self.moments().0,
            QuestMethod::Mode => self.mode(),
        };
        value(&self.plan, wanted)
    }
}

/// Grid points on either side of the start: half the range over the grain, rounded up.
fn half_points(plan: &QuestPlan) -> i64 {
    ((plan.range / plan.grain / 2.0).ceil() as i64).clamp(1, MOST_HALF_POINTS)
}

fn sign(harder: Harder) -> f64 {
    -harder.sign()
}

/// The intensity of a parameter's value.
fn intensity(plan: &QuestPlan, value: f64) -> f64 {
    sign(plan.harder)
        * match plan.axis {
            Axis::Linear => value,
            Axis::Log => value.log10(),
        }
}

/// The parameter's value at an intensity.
fn value(plan: &QuestPlan, intensity: f64) -> f64 {
    let on_axis = sign(plan.harder) * intensity;
    match plan.axis {
        Axis::Linear => on_axis,
        Axis::Log => 10_f64.powf(on_axis),
    }
}

/// The quantile order of Pelli's ideal procedure, from the lowest and the highest probability of a right answer.
fn best_quantile(low: f64, high: f64) -> f64 {
    const TINY: f64 = 1e-14;
    let entropies = high * (high + TINY).ln() - low * (low + TINY).ln()
        + (1.0 - high + TINY) * (1.0 - high + TINY).ln()
        - (1.0 - low + TINY) * (1.0 - low + TINY).ln();
    let best = 1.0 / (1.0 + (entropies / (low - high)).exp());
    (best - low) / (high - low)
}

/// y at `x`, on straight lines through points of rising x; beyond them the nearest point's.
fn interpolate(x: f64, points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut before: Option<(f64, f64)> = None;
    for (right, y) in points {
        if x <= right {
            return before.map_or(y, |(left, low)| low + (y - low) * (x - left) / (right - left));
        }
        before = Some((right, y));
    }
    before.map_or(0.0, |(_, y)| y)
}

/// Divides by the sum; answers that exclude every threshold leave all equal.
fn normalise(values: &mut [f64]) {
    let sum: f64 = values.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        values.iter_mut().for_each(|p| *p /= sum);
    } else {
        let share = 1.0 / values.len().max(1) as f64;
        values.fill(share);
    }
}

impl Procedure for Quest {
    fn level(&mut self, _rng: &mut ChaCha8Rng) -> Level {
        self.plan.place.level(self.next_value())
    }

    fn update(&mut self, level: &Level, correct: bool) {
        self.completed += 1;
        if let Some(&shown) = level.get(self.plan.place.parameter()) {
            // Intensities beyond the range teach what its end would, as in Pelli's program.
            let from_guess = (intensity(&self.plan, shown) - self.guess) / self.plan.grain;
            let shift = (from_guess.round_ties_even() as i64).clamp(-self.half, self.half);
            // A threshold at grid point i is met with an intensity of shift − (i − half); the table starts at −2 half.
            let highest = usize::try_from(shift + 3 * self.half).unwrap_or(0);
            for (index, p) in self.posterior.iter_mut().enumerate() {
                let success = self.success[highest - index];
                *p *= if correct { success } else { 1.0 - success };
            }
            normalise(&mut self.posterior);
        }
        self.finished = self.plan.stop.holds(self.completed, 0, &self.estimate());
    }

    /// Nothing to do: the posterior has not moved.
    fn put_back(&mut self, _level: Level, _rng: &mut ChaCha8Rng) {}

    fn finished(&self) -> bool {
        self.finished
    }

    fn estimate(&self) -> Estimate {
        let (mean, sd) = self.moments();
        let mean = value(&self.plan, mean);
        let sd = match self.plan.axis {
            Axis::Linear => sd,
            Axis::Log => LN_10 * mean * sd,
        };
        Estimate::from([(self.plan.place.parameter().to_owned(), Belief { mean, sd })])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::Stream;
    use crate::study::plan::{Place, Stop};
    use rand::RngExt;

    fn plan() -> QuestPlan {
        QuestPlan {
            place: Place::new("x", Level::new(), [0.0, 100.0]),
            harder: Harder::Down,
            axis: Axis::Linear,
            start: 50.0,
            start_sd: 50.0,
            p_threshold: 0.82,
            beta: 3.5,
            delta: 0.01,
            gamma: 0.5,
            grain: 0.01,
            range: 100.0,
            method: QuestMethod::Quantile,
            stop: Stop::Trials(10),
        }
    }

    fn run(plan: &QuestPlan) -> (Vec<f64>, Quest) {
        let mut quest = Quest::new(plan);
        let mut rng = Stream::Procedure.generator(1);
        let mut levels = Vec::new();
        for right in [1, 1, 0, 0, 1, 1, 0, 0, 1, 1] {
            let level = quest.level(&mut rng);
            levels.push(level["x"]);
            quest.update(&level, right == 1);
        }
        assert!(quest.finished());
        (levels, quest)
    }

    /// PsychoPy 2026.2.5, psychopy/tests/test_data/test_StairHandlers.py, test_QuestHandler.
    const PSYCHOPY: [f64; 10] = [
        50.0,
        45.139_710_407_074_87,
        37.291_086_503_930_74,
        58.297_413_127_139_95,
        80.182_967_131_096_55,
        75.295_251_409_003_53,
        71.576_271_924_237_83,
        79.881_680_484_036_9,
        90.712_313_302_815_52,
        88.265_808_957_695_8,
    ];

    #[test]
    fn levels_and_summaries_are_psychopys() {
        let (levels, quest) = run(&plan());
        println!("{levels:?}");
        for (found, expected) in levels.iter().zip(PSYCHOPY) {
            assert!((found - expected).abs() < 1e-8, "{levels:?}");
        }
        let belief = quest.estimate()["x"];
        assert!((belief.mean - 86.077_216_942_7).abs() < 1e-8, "{belief:?}");
        assert!((quest.mode() - 80.11).abs() < 1e-9);
        assert!((quest.quantile(quest.quantile_order) - 86.384_903_108_5).abs() < 1e-8);
    }

    /// The same answers where larger values are harder are the mirror image.
    #[test]
    fn the_other_direction_is_the_mirror_image() {
        let (levels, _) = run(&QuestPlan { harder: Harder::Up, ..plan() });
        for (found, expected) in levels.iter().zip(PSYCHOPY) {
            assert!((found - (100.0 - expected)).abs() < 1e-8, "{levels:?}");
        }
    }

    /// A log axis is the linear one of the logarithm, whatever the method.
    #[test]
    fn a_log_axis_is_a_linear_one_of_the_logarithm() {
        for method in [QuestMethod::Quantile, QuestMethod::Mean, QuestMethod::Mode] {
            let linear = QuestPlan {
                place: Place::new("x", Level::new(), [-3.0, 1.0]),
                start: -1.0,
                start_sd: 0.8,
                range: 5.0,
                method,
                ..plan()
            };
            let log = QuestPlan {
                place: Place::new("x", Level::new(), [1e-3, 10.0]),
                start: 0.1,
                axis: Axis::Log,
                ..linear.clone()
            };
            let ((a, linear), (b, log)) = (run(&linear), run(&log));
            for (a, b) in a.iter().zip(&b) {
                assert!((a - b.log10()).abs() < 1e-9, "{method:?}: {a} {b}");
            }
            let (a, b) = (linear.estimate()["x"], log.estimate()["x"]);
            assert!((10_f64.powf(a.mean) - b.mean).abs() < 1e-9);
            assert!((a.sd * LN_10 - b.sd / b.mean).abs() < 1e-9);
        }
    }

    #[test]
    fn it_closes_in_on_a_threshold() {
        let weibull = |x: f64| 0.005 + 0.99 * (1.0 - 0.5 * (-10_f64.powf(3.5 * x)).exp());
        // ε: where the function above is 0.82.
        let epsilon = ((0.5 * 0.99_f64 / (0.995 - 0.82)).ln().log10()) / 3.5;
        assert!((weibull(epsilon) - 0.82).abs() < 1e-12);
        let stop = Stop::at_most(400, 20, &[("x", 0.08)]);
        for (seed, truth) in [(1, -1.2_f64), (2, -0.4), (3, -2.0)] {
            let plan = QuestPlan {
                place: Place::new("x", Level::new(), [1e-4, 10.0]),
                start: 0.1,
                start_sd: 1.0,
                axis: Axis::Log,
                range: 6.0,
                stop: stop.clone(),
                ..plan()
            };
            let mut quest = Quest::new(&plan);
            let mut rng = Stream::Observer.generator(seed);
            while !quest.finished() {
                let level = quest.level(&mut rng);
                let p = weibull(level["x"].log10() - truth + epsilon);
                quest.update(&level, rng.random::<f64>() < p);
            }
            let belief = quest.estimate()["x"];
            println!("seed {seed}: {} trials, {belief:?}, truth {}", quest.completed, 10_f64.powf(truth));
            assert!(quest.completed < 400 && belief.sd <= 0.08 * belief.mean);
            assert!((belief.mean - 10_f64.powf(truth)).abs() < 4.0 * belief.sd);
        }
    }
}
