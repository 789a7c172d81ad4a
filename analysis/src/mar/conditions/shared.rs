//! Likelihood ratios: which parameters may conditions share? The lapse rate they share always.

use super::super::data::Data;
use super::super::maximum_likelihood::{Curves, LARGEST_LAPSE, LN_WIDTH, Maximum, ModelSize, chi_square_p, maximise};
use serde::{Deserialize, Serialize};

/// A set of the three parameters of a MAR line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameter {
    /// The slope m.
    M,
    /// The intercept omega0.
    Omega0,
    /// The width of the psychometric function.
    Width,
    /// All three at once.
    All,
}

/// A likelihood ratio of sharing a parameter over conditions against one value for each, the other parameters separate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SharedTest {
    /// What is shared under the null.
    pub parameter: Parameter,
    /// 2 (ln L separate − ln L shared), not below 0; summed over observers.
    pub deviance_difference: f64,
    /// Parameters saved by sharing; summed over observers.
    pub df: usize,
    /// P(χ²(df) ≥ difference).
    pub p: f64,
    /// The model that shares; ln likelihood and parameters summed over observers.
    pub shared: ModelSize,
    /// The model that shares only the lapse rate.
    pub separate: ModelSize,
}

const PARAMETERS: [Parameter; 4] = [Parameter::All, Parameter::M, Parameter::Omega0, Parameter::Width];

/// All four tests for one observer's conditions.
pub(super) fn shared_tests(groups: &[&Data], guess: f64) -> Vec<SharedTest> {
    let trials: f64 = groups.iter().flat_map(|g| &g.rings).flat_map(|r| &r.counts).map(|c| c.correct + c.wrong).sum();
    let separate_family = Family::new(groups, guess, [false; 3]);
    let all = Family::new(groups, guess, [true; 3]);
    let together = maximise(&all, groups, guess, &all.starts(None));
    // Every model starts from what conditions have together, too, so that it never ends below what it contains.
    let mut fits: Vec<(Family, Maximum)> = Vec::new();
    for shared in [[true, false, false], [false, true, false], [false, false, true]] {
        let family = Family::new(groups, guess, shared);
        let fit = maximise(&family, groups, guess, &family.starts(Some((&all, &together))));
        fits.push((family, fit));
    }
    let mut starts = separate_family.starts(Some((&all, &together)));
    for (family, fit) in &fits {
        starts.push(separate_family.start_from(family, fit));
    }
    let separate = maximise(&separate_family, groups, guess, &starts);
    fits.insert(0, (all, together));
    PARAMETERS
        .into_iter()
        .zip(fits)
        .map(|(parameter, (family, fit))| {
            let deviance_difference = (2.0 * (separate.ln_likelihood - fit.ln_likelihood)).max(0.0);
            let df = separate_family.bounds.len() - family.bounds.len();
            SharedTest {
                parameter,
                deviance_difference,
                df,
                p: chi_square_p(deviance_difference, df),
                shared: ModelSize::new(fit.ln_likelihood, family.bounds.len(), trials as usize),
                separate: ModelSize::new(separate.ln_likelihood, separate_family.bounds.len(), trials as usize),
            }
        })
        .collect()
}

/// Tests summed over observers: each has their own lines, and none differs under the null.
pub(super) fn summed(tests: &[Vec<SharedTest>], trials: usize) -> Vec<SharedTest> {
    PARAMETERS
        .into_iter()
        .enumerate()
        .filter_map(|(index, parameter)| {
            let own: Vec<&SharedTest> = tests.iter().filter_map(|tests| tests.get(index)).collect();
            (!own.is_empty()).then(|| {
                let deviance_difference = own.iter().map(|t| t.deviance_difference).sum();
                let df = own.iter().map(|t| t.df).sum();
                let size = |of: fn(&SharedTest) -> ModelSize| {
                    let ln = own.iter().map(|t| of(t).ln_likelihood).sum();
                    ModelSize::new(ln, own.iter().map(|t| of(t).parameters).sum(), trials)
                };
                SharedTest {
                    parameter,
                    deviance_difference,
                    df,
                    p: chi_square_p(deviance_difference, df),
                    shared: size(|t| t.shared),
                    separate: size(|t| t.separate),
                }
            })
        })
        .collect()
}

/// Lines for K conditions: ln m, ln omega0 and ln width, each one or K numbers, and the lapse rate.
struct Family {
    /// First index of each of ln m, ln omega0, ln width, and whether it is one number.
    at: [(usize, bool); 3],
    conditions: usize,
    bounds: Vec<[f64; 2]>,
    middle: [f64; 2],
}

impl Family {
    fn new(groups: &[&Data], guess: f64, shared: [bool; 3]) -> Self {
        let conditions = groups.len();
        let levels = || groups.iter().flat_map(|g| &g.rings).flat_map(|r| &r.counts).map(|c| c.ln_omega);
        let (low, high) = levels().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        let far = groups.iter().flat_map(|g| &g.rings).map(|r| r.eccentricity_deg).fold(0.0, f64::max);
        let ln_far = if far > 0.0 { far.ln() } else { 0.0 };
        let omega0 = [(low - 6.9).max(-690.0), (high + 6.9).min(690.0)];
        let m = [(low - 6.9 - ln_far).max(-690.0), (high + 6.9 - ln_far).min(690.0)];
        let mut bounds = Vec::new();
        let mut at = [(0, false); 3];
        for (index, bound) in [m, omega0, LN_WIDTH].into_iter().enumerate() {
            at[index] = (bounds.len(), shared[index]);
            bounds.extend(std::iter::repeat_n(bound, if shared[index] { 1 } else { conditions }));
        }
        bounds.push([0.0, LARGEST_LAPSE.min(0.9 * (1.0 - guess))]);
        let mean = levels().sum::<f64>() / levels().count().max(1) as f64;
        Self { at, conditions, bounds, middle: [mean - ln_far, mean] }
    }

    fn index(&self, parameter: usize, condition: usize) -> usize {
        let (first, shared) = self.at[parameter];
        if shared { first } else { first + condition }
    }

    /// A point with the same (ln m, ln omega0, ln width) in every condition.
    fn uniform(&self, point: [f64; 4]) -> Vec<f64> {
        let mut start = vec![point[3]; self.bounds.len()];
        for (parameter, value) in point.iter().take(3).enumerate() {
            for condition in 0..self.conditions {
                start[self.index(parameter, condition)] = *value;
            }
        }
        start
    }

    fn start_from(&self, family: &Self, fit: &Maximum) -> Vec<f64> {
        let mut start = vec![fit.parameters.last().copied().unwrap_or(0.0); self.bounds.len()];
        for parameter in 0..3 {
            for condition in 0..self.conditions {
                start[self.index(parameter, condition)] = fit.parameters[family.index(parameter, condition)];
            }
        }
        start
    }

    fn starts(&self, from: Option<(&Self, &Maximum)>) -> Vec<Vec<f64>> {
        let [m, omega0] = self.middle;
        let mut starts = vec![
            self.uniform([0.022f64.ln(), (1.0f64 / 48.0).ln(), -0.2, 0.02]),
            self.uniform([m - 0.5, omega0 - 1.0, 0.0, 0.02]),
        ];
        starts.extend(from.map(|(family, fit)| self.start_from(family, fit)));
        starts
    }
}

impl Curves for Family {
    fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    fn width_index(&self, group: usize) -> usize {
        self.index(2, group)
    }

    fn ln_threshold(&self, p: &[f64], group: usize, eccentricity_deg: f64, gradient: &mut [f64]) -> f64 {
        let (m, omega0) = (self.index(0, group), self.index(1, group));
        let ln = crate::numerics::ln_add_exp(p[m] + eccentricity_deg.ln(), p[omega0]);
        gradient[m] = (p[m] + eccentricity_deg.ln() - ln).exp();
        gradient[omega0] = (p[omega0] - ln).exp();
        ln
    }
}
