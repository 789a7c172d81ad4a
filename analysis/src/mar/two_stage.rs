//! The two-stage regression of older studies, for comparison: a threshold for every eccentricity, then a weighted line.
//!
//! Thresholds are fitted each alone, with their own width and lapse rate, or taken from a joint fit. The line's weights are
//! the thresholds' variances, taken as known; a threshold below what the display could show enters as left-censored (Tobit
//! likelihood, Tobin 1958). It uses less of the data than [`super::fit_mar`], which is what to report.

use super::data::{Data, FitError};
use super::maximum_likelihood::chi_square_p;
use super::{Estimate, MarFitConfig, MarTrial, Threshold, fit_mar};
use crate::numerics::{normal_cdf_pair, normal_pdf};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How a two-stage fit is made.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TwoStageConfig {
    /// The first stage: guess rate, priors, what the display could show, seed.
    pub first: MarFitConfig,
}

/// Why there is no line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TwoStageError {
    /// Trials or configuration are at fault.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A line needs two measured points.
    #[error("a line through thresholds needs at least 2 that could be measured, found {measured} of {all}")]
    TooFewThresholds {
        /// Thresholds above what the display could show.
        measured: usize,
        /// All of them.
        all: usize,
    },
    /// A threshold is not a number with an error.
    #[error("threshold {index} (counted from 0): {field} must be {expected}, found {found}")]
    BadThreshold {
        /// Position, from 0.
        index: usize,
        /// The field at fault.
        field: &'static str,
        /// What would have been accepted.
        expected: &'static str,
        /// What was there.
        found: f64,
    },
}

/// A threshold as the line sees it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Degrees.
    pub eccentricity_deg: f64,
    /// Threshold, degrees per cycle; where `censored`, the display's limit, below which it lies.
    pub mar_deg: f64,
    /// Its standard error, degrees per cycle; of a censored one, what it would be at the limit.
    pub se_deg: f64,
    /// The threshold lies below `mar_deg`.
    pub censored: bool,
}

/// A weighted line through thresholds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TwoStageFit {
    /// Slope and 95 % interval.
    pub m: Estimate,
    /// Intercept and 95 % interval, degrees per cycle; nothing keeps it positive.
    pub omega0: Estimate,
    /// Standard errors of slope and intercept from the information at the maximum.
    pub se: [f64; 2],
    /// Σ ((threshold − line)/error)² over the measured thresholds.
    pub chi_square: f64,
    /// Measured thresholds less two.
    pub df: usize,
    /// P(χ²(df) ≥ chi_square): small where a line or the stated errors do not hold.
    pub p: f64,
    /// The points.
    pub points: Vec<Point>,
}

/// Thresholds alone, then a line.
///
/// # Errors
/// [`TwoStageError`]: trials out of range, or fewer than two thresholds that could be measured.
///
/// ```
/// use analysis::mar::{MarTrial, two_stage::{TwoStageConfig, fit_two_stage}};
/// let trials: Vec<MarTrial> = (0..480)
///     .map(|i| {
///         let eccentricity_deg = f64::from(5 * (i % 4));
///         let mar_deg = (0.022 * eccentricity_deg + 0.021) * 0.4 * 1.3f64.powi(i / 4 % 8);
///         MarTrial { eccentricity_deg, mar_deg, correct: i / 4 % 8 >= 4 || i / 32 % 2 == 0 }
///     })
///     .collect();
/// let fit = fit_two_stage(&trials, &TwoStageConfig::default())?;
/// assert!(fit.m.ci95[0] < fit.m.estimate && fit.m.estimate < fit.m.ci95[1]);
/// # Ok::<(), analysis::mar::two_stage::TwoStageError>(())
/// ```
pub fn fit_two_stage(trials: &[MarTrial], config: &TwoStageConfig) -> Result<TwoStageFit, TwoStageError> {
    let data = Data::new(trials, &config.first)?;
    let thresholds: Vec<Threshold> = data
        .rings
        .par_iter()
        .map(|ring| {
            let own: Vec<MarTrial> =
                trials.iter().filter(|t| t.eccentricity_deg + 0.0 == ring.eccentricity_deg).copied().collect();
            let fit = fit_mar(&own, &MarFitConfig { draws: config.first.draws.min(1024), ..config.first.clone() })?;
            fit.thresholds.first().copied().ok_or(FitError::NoTrials)
        })
        .collect::<Result<_, FitError>>()?;
    line_through(&thresholds)
}

/// The line through thresholds that are already fitted, as in [`super::MarFit::thresholds`].
///
/// A threshold's standard error is a quarter (1/3.92) of its 95 % interval. A censored one has the median *relative* error
/// of the measured ones.
///
/// # Errors
/// [`TwoStageError::TooFewThresholds`] with fewer than two measured ones, [`TwoStageError::BadThreshold`] for numbers that are
/// not finite or an interval without width.
pub fn line_through(thresholds: &[Threshold]) -> Result<TwoStageFit, TwoStageError> {
    for (index, t) in thresholds.iter().enumerate() {
        let bad = |field, expected, found| Err(TwoStageError::BadThreshold { index, field, expected, found });
        if !(0.0..=180.0).contains(&t.eccentricity_deg) {
            return bad("eccentricity_deg", "degrees from 0 to 180", t.eccentricity_deg);
        }
        if !(t.mar_deg > 0.0 && t.mar_deg.is_finite()) {
            return bad("mar_deg", "degrees per cycle, finite and above 0", t.mar_deg);
        }
        let width = t.ci95[1] - t.ci95[0];
        let sound = width > 0.0 && width.is_finite();
        if !(t.limited || sound) {
            return bad("ci95", "an interval with a finite width above 0", width);
        }
    }
    let measured = thresholds.iter().filter(|t| !t.limited).count();
    let se = |t: &Threshold| (t.ci95[1] - t.ci95[0]) / (2.0 * Z95);
    let relative = crate::numerics::sorted_finite(thresholds.iter().filter(|t| !t.limited).map(|t| se(t) / t.mar_deg));
    let typical = crate::numerics::quantile_of_sorted(&relative, 0.5).unwrap_or(1.0);
    let points: Vec<Point> = thresholds
        .iter()
        .map(|t| Point {
            eccentricity_deg: t.eccentricity_deg,
            mar_deg: t.mar_deg,
            se_deg: if t.limited { typical * t.mar_deg } else { se(t) },
            censored: t.limited,
        })
        .collect();
    let distinct = points
        .iter()
        .filter(|p| !p.censored)
        .any(|p| points.iter().any(|other| !other.censored && other.eccentricity_deg != p.eccentricity_deg));
    if measured < 2 || !distinct {
        return Err(TwoStageError::TooFewThresholds { measured, all: thresholds.len() });
    }

    // In units of the largest threshold, so that no square overflows.
    let unit = points.iter().map(|p| p.mar_deg).fold(0.0, f64::max);
    let given = points;
    let points: Vec<Point> =
        given.iter().map(|p| Point { mar_deg: p.mar_deg / unit, se_deg: (p.se_deg / unit).max(1e-9), ..*p }).collect();
    let top = climb(&points, [0.0, 0.0], None);
    let Scored { information, determinant, .. } = scored(&points, top);
    let se = [(information[2] / determinant).max(0.0).sqrt(), (information[0] / determinant).max(0.0).sqrt()];
    let estimate = |axis: usize| Estimate {
        estimate: top[axis] * unit,
        ci95: [-1.0, 1.0].map(|side| unit * profile_end(&points, top, axis, side * se[axis])),
    };
    let chi_square = points
        .iter()
        .filter(|p| !p.censored)
        .map(|p| ((p.mar_deg - top[0] * p.eccentricity_deg - top[1]) / p.se_deg).powi(2))
        .sum();
    let df = measured - 2;
    Ok(TwoStageFit {
        m: estimate(0),
        omega0: estimate(1),
        se: se.map(|se| se * unit),
        chi_square,
        df,
        p: chi_square_p(chi_square, df),
        points: given,
    })
}

/// Φ⁻¹(0.975), and its square.
const Z95: f64 = 1.959_963_984_540_054;

struct Scored {
    value: f64,
    gradient: [f64; 2],
    /// Observed information: (m, m), (m, omega0), (omega0, omega0). The Tobit likelihood is concave.
    information: [f64; 3],
    /// Its determinant, as a sum over pairs of points: a difference of products would lose all digits where one point
    /// weighs far more than the others.
    determinant: f64,
}

/// The Tobit log likelihood at (m, omega0).
fn scored(points: &[Point], [m, omega0]: [f64; 2]) -> Scored {
    let mut scored = Scored { value: 0.0, gradient: [0.0; 2], information: [0.0; 3], determinant: 0.0 };
    let mut weights: Vec<(f64, f64)> = Vec::with_capacity(points.len());
    for p in points {
        let u = (p.mar_deg - m * p.eccentricity_deg - omega0) / p.se_deg;
        // d ln L/du and −d² ln L/du².
        let (value, slope, curvature) = if p.censored { ln_cdf(u) } else { (-0.5 * u * u, -u, 1.0) };
        let (x, scale) = (p.eccentricity_deg, 1.0 / p.se_deg);
        scored.value += value;
        scored.gradient[0] -= slope * x * scale;
        scored.gradient[1] -= slope * scale;
        scored.information[0] += curvature * x * x * scale * scale;
        scored.information[1] += curvature * x * scale * scale;
        scored.information[2] += curvature * scale * scale;
        let weight = curvature * scale * scale;
        scored.determinant += weights.iter().map(|(w, at)| w * weight * (x - at) * (x - at)).sum::<f64>();
        weights.push((weight, x));
    }
    scored
}

/// ln Φ(u), its slope, and its curvature with the sign turned.
fn ln_cdf(u: f64) -> (f64, f64, f64) {
    let (lower, _) = normal_cdf_pair(u);
    let (value, slope) = if u > -30.0 {
        (lower.ln(), normal_pdf(u) / lower)
    } else {
        // Mills' ratio far out.
        let mills = 1.0 / (-u) * (1.0 - 1.0 / (u * u));
        (-0.5 * u * u + mills.ln() - crate::numerics::LN_SQRT_TAU, 1.0 / mills)
    };
    (value, slope, (slope * (slope + u)).max(0.0))
}

/// The maximum of the concave likelihood by damped Newton steps; with `hold`, that axis stays.
fn climb(points: &[Point], start: [f64; 2], hold: Option<usize>) -> [f64; 2] {
    let mut at = start;
    let mut current = scored(points, at);
    for _ in 0..200 {
        let [a, b, c] = current.information;
        let [g, h] = current.gradient;
        let step = match hold {
            None => {
                let determinant = current.determinant;
                [(c * g - b * h) / determinant, (a * h - b * g) / determinant]
            }
            Some(0) => [0.0, h / c],
            Some(_) => [g / a, 0.0],
        };
        if !step.iter().all(|s| s.is_finite()) {
            break;
        }
        let mut length = 1.0;
        let (to, next) = loop {
            let to = [at[0] + length * step[0], at[1] + length * step[1]];
            let next = scored(points, to);
            if next.value >= current.value || length < 1e-9 {
                break (to, next);
            }
            length *= 0.5;
        };
        let gain = next.value - current.value;
        if gain < 0.0 || !next.value.is_finite() {
            break;
        }
        (at, current) = (to, next);
        if gain < 1e-14 {
            break;
        }
    }
    at
}

/// Where the profile likelihood has fallen by half of χ²(1)'s 95 %: exactly 1.96 standard errors without censoring.
fn profile_end(points: &[Point], top: [f64; 2], axis: usize, unit: f64) -> f64 {
    let level = scored(points, top).value - 0.5 * Z95 * Z95;
    let profile = |value: f64| {
        let mut start = top;
        start[axis] = value;
        scored(points, climb(points, start, Some(axis))).value
    };
    if unit == 0.0 || !unit.is_finite() {
        return top[axis];
    }
    let mut out = 2.0;
    while profile(top[axis] + out * unit) > level && out < 1e6 {
        out *= 1.5;
    }
    let (mut low, mut high) = (0.0, out);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if profile(top[axis] + middle * unit) > level {
            low = middle;
        } else {
            high = middle;
        }
    }
    top[axis] + 0.5 * (low + high) * unit
}
