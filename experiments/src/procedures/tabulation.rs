//! Likelihood tables of psychometric functions over grids of their parameters, made once for a plan and shared.
//!
//! A power analysis runs one plan hundreds of times, and a design has one procedure a cell: all of them read the tables
//! that the first one made.

use super::quest_plus::Tables;
use super::{Belief, psychometric};
use crate::study::plan::{Axis, Function, Harder};
use std::fmt;
use std::sync::{Arc, OnceLock};

/// The parameters of a psychometric function, each with its values: ψ = γ + (1 − γ − λ) F, where F rises around
/// threshold + threshold_slope · covariate. Threshold slopes vary slowest, guess rates fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// How far the threshold rises with each unit of the covariate.
    pub threshold_slope: Vec<f64>,
    /// The threshold where the covariate is zero, in the stimulus's unit.
    pub threshold: Vec<f64>,
    /// Widths from 5 % to 95 % of F: in the stimulus's unit, or in natural-log units on a log axis.
    pub width: Vec<f64>,
    /// Lapse rates λ.
    pub lapse: Vec<f64>,
    /// Guess rates γ.
    pub guess: Vec<f64>,
}

impl Grid {
    /// The number of grid points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.axes().iter().map(|axis| axis.len()).product()
    }

    /// The axes, from the slowest to the fastest.
    #[must_use]
    pub fn axes(&self) -> [&[f64]; 5] {
        [&self.threshold_slope, &self.threshold, &self.width, &self.lapse, &self.guess]
    }

    /// Mean and standard deviation along each axis of a distribution over the grid points.
    #[must_use]
    pub fn beliefs(&self, posterior: &[f64]) -> [Belief; 5] {
        let mut left = posterior.to_vec();
        let mut beliefs = [Belief { mean: f64::NAN, sd: f64::NAN }; 5];
        // The fastest axis is summed out first, so that each one costs less than the one before.
        for (values, belief) in self.axes().into_iter().zip(&mut beliefs).rev() {
            let mut marginal = vec![0.0; values.len()];
            let mut rest = Vec::with_capacity(left.len() / values.len().max(1));
            for group in left.chunks_exact(values.len().max(1)) {
                marginal.iter_mut().zip(group).for_each(|(sum, p)| *sum += p);
                rest.push(group.iter().sum());
            }
            let mean: f64 = marginal.iter().zip(values).map(|(p, x)| p * x).sum();
            let variance: f64 = marginal.iter().zip(values).map(|(p, x)| p * (x - mean).powi(2)).sum();
            *belief = Belief { mean, sd: variance.sqrt() };
            left = rest;
        }
        beliefs
    }
}

/// Everything that a set of tables follows from.
#[derive(Debug, Clone, PartialEq)]
pub struct Tabulation {
    /// The stimuli, each with its covariate (0 where there is none).
    pub stimuli: Vec<[f64; 2]>,
    /// The parameters.
    pub grid: Grid,
    /// The shape F.
    pub function: Function,
    /// The axis on which F has this shape; on a log axis stimuli and thresholds are above zero.
    pub axis: Axis,
    /// Whether F rises towards larger or smaller values.
    pub harder: Harder,
}

impl Tabulation {
    /// Makes the tables: two outcomes, wrong and right, and a uniform prior.
    #[must_use]
    pub fn tables(&self) -> Tables {
        let grid = &self.grid;
        let on_axis = |value: f64| match self.axis {
            Axis::Linear => value,
            Axis::Log => value.ln(),
        };
        let mut success = Vec::with_capacity(self.stimuli.len() * grid.points());
        for &[stimulus, covariate] in &self.stimuli {
            for &slope in &grid.threshold_slope {
                for &threshold in &grid.threshold {
                    let distance = on_axis(stimulus) - on_axis(threshold + slope * covariate);
                    for &width in &grid.width {
                        let seen = psychometric::unscaled(self.function, -self.harder.sign() * distance / width);
                        for &lapse in &grid.lapse {
                            success.extend(grid.guess.iter().map(|&guess| guess + (1.0 - guess - lapse) * seen));
                        }
                    }
                }
            }
        }
        let points = grid.points();
        Tables::of_success(self.stimuli.len(), vec![1.0; points], |s, t| success[s * points + t])
    }
}

/// A place in a plan for its tables. Copies of a plan share it; to comparisons it is nothing.
#[derive(Clone, Default)]
pub struct Shared(Arc<OnceLock<(Tabulation, Arc<Tables>)>>);

impl Shared {
    /// The tables of a tabulation: those that are here already, if they are of the same one.
    #[must_use]
    pub fn tables(&self, wanted: &Tabulation) -> Arc<Tables> {
        let (made, tables) = self.0.get_or_init(|| (wanted.clone(), Arc::new(wanted.tables())));
        // A plan that was changed after it was copied has tables of its own.
        if made == wanted { Arc::clone(tables) } else { Arc::new(wanted.tables()) }
    }
}

impl PartialEq for Shared {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.get().is_some() { "Shared(tables)" } else { "Shared(nothing yet)" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tabulation() -> Tabulation {
        Tabulation {
            stimuli: vec![[1.0, 0.0], [2.0, 3.0]],
            grid: Grid {
                threshold_slope: vec![0.1, 0.2],
                threshold: vec![0.5, 1.0, 1.5],
                width: vec![0.4, 0.8],
                lapse: vec![0.0, 0.1],
                guess: vec![0.5],
            },
            function: Function::Logistic,
            axis: Axis::Log,
            harder: Harder::Down,
        }
    }

    #[test]
    fn beliefs_are_the_moments_over_all_points() {
        let grid = tabulation().grid;
        let mut posterior: Vec<f64> = (0..grid.points()).map(|i| 1.0 + ((7 * i) % 5) as f64).collect();
        let sum: f64 = posterior.iter().sum();
        posterior.iter_mut().for_each(|p| *p /= sum);
        let mut points = Vec::new();
        for &a in &grid.threshold_slope {
            for &b in &grid.threshold {
                for &c in &grid.width {
                    for &d in &grid.lapse {
                        points.push([a, b, c, d, 0.5]);
                    }
                }
            }
        }
        for (axis, belief) in grid.beliefs(&posterior).into_iter().enumerate() {
            let mean: f64 = points.iter().zip(&posterior).map(|(x, p)| p * x[axis]).sum();
            let variance: f64 = points.iter().zip(&posterior).map(|(x, p)| p * (x[axis] - mean).powi(2)).sum();
            assert!((belief.mean - mean).abs() < 1e-12 && (belief.sd - variance.sqrt()).abs() < 1e-9);
        }
    }

    #[test]
    fn tables_are_shared_between_copies_but_not_with_a_changed_plan() {
        let shared = Shared::default();
        let first = shared.tables(&tabulation());
        assert!(Arc::ptr_eq(&first, &shared.clone().tables(&tabulation())));
        let mut other = tabulation();
        other.grid.width[0] = 0.3;
        assert_eq!(*shared.tables(&other), other.tables());
        assert!(Arc::ptr_eq(&first, &shared.tables(&tabulation())));
    }
}
