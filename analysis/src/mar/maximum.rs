//! The modes of a MAR posterior, by damped Fisher scoring.
//!
//! Scoring replaces the Hessian by the expected information, which is never indefinite, so that the damped step always
//! climbs. The working mode starts the integration; the natural mode, with λ held at its bound where it must be, is the
//! reported maximum.

use super::posterior::{Posterior, Scored, model_from_natural};
use experiments::mar::MarModel;
use nalgebra::{Matrix4, Vector4};

/// A local maximum and the covariance of its normal approximation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mode {
    pub(super) at: Vector4<f64>,
    pub(super) value: f64,
    pub(super) covariance: Matrix4<f64>,
}

/// The distinct maxima over the working coordinates, best first; at least one.
pub(super) fn working_modes(target: &Posterior<'_>) -> Vec<Mode> {
    let mut starts = vec![Vector4::zeros(), best_of_coarse_grid(target)];
    starts.push(Vector4::new(starts[1][0], starts[1][1], 0.0, 0.0));
    let mut modes: Vec<Mode> = Vec::new();
    for start in starts {
        let (at, scored) = climb(start, |x| scored_working(target, x), |_, x| x);
        let covariance = scored.information.cholesky().map_or_else(Matrix4::identity, |factor| factor.inverse());
        let known = modes.iter().any(|mode| (mode.at - at).norm() < 0.05);
        if !known && at.iter().all(|v| v.is_finite()) {
            modes.push(Mode { at, value: scored.value, covariance });
        }
    }
    if modes.is_empty() {
        modes.push(Mode { at: Vector4::zeros(), value: 0.0, covariance: Matrix4::identity() });
    }
    modes.sort_by(|a, b| b.value.total_cmp(&a.value));
    // A mode e^15 times lower holds no mass worth a component.
    let floor = modes[0].value - 15.0;
    modes.retain(|mode| mode.value >= floor);
    modes
}

/// The mode of the posterior density over (ln m, ln omega0, ln width, λ).
pub(super) fn map(target: &Posterior<'_>, modes: &[Mode]) -> MarModel {
    let bounds = [if target.lapse_beta[0] > 1.0 { 1e-12 } else { 0.0 }, (1.0 - target.guess) * (1.0 - 1e-9)];
    let project = |_from: Vector4<f64>, mut theta: Vector4<f64>| {
        theta[3] = theta[3].clamp(bounds[0], bounds[1]);
        theta
    };
    let scored = |theta: &Vector4<f64>| {
        let mut scored = scored_natural(target, theta);
        // On its bound and pushed outwards, λ is held.
        let held =
            (theta[3] <= bounds[0] && scored.gradient[3] < 0.0) || (theta[3] >= bounds[1] && scored.gradient[3] > 0.0);
        if held {
            scored.gradient[3] = 0.0;
            for i in 0..3 {
                scored.information[(3, i)] = 0.0;
                scored.information[(i, 3)] = 0.0;
            }
        }
        scored
    };
    let mut best: Option<(f64, Vector4<f64>)> = None;
    for mode in modes {
        let (theta, end) = climb(target.natural(&mode.at), scored, project);
        if best.is_none_or(|(value, _)| end.value > value) {
            best = Some((end.value, theta));
        }
    }
    model_from_natural(&best.map_or_else(|| target.natural(&Vector4::zeros()), |(_, theta)| theta))
}

fn scored_working(target: &Posterior<'_>, x: &Vector4<f64>) -> Scored {
    let mut scored = target.scored_likelihood(&target.natural(x));
    let z = x[3];
    let step = 1e-4;
    let lapse_slope = (target.lapse(z + step) - target.lapse(z - step)) / (2.0 * step);
    let scale = Vector4::new(target.spread[0], target.spread[1], target.spread[2], lapse_slope);
    scored.gradient.component_mul_assign(&scale);
    let scale = Matrix4::from_diagonal(&scale);
    scored.information = scale * scored.information * scale + Matrix4::identity();

    let prior = target.ln_z_prior(z);
    scored.value += prior - 0.5 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    scored.gradient -= Vector4::new(x[0], x[1], x[2], 0.0);
    if prior.is_finite() {
        scored.gradient[3] += (target.ln_z_prior(z + step) - target.ln_z_prior(z - step)) / (2.0 * step);
    }
    scored
}

fn scored_natural(target: &Posterior<'_>, theta: &Vector4<f64>) -> Scored {
    let mut scored = target.scored_likelihood(theta);
    for i in 0..3 {
        let precision = target.spread[i].powi(-2);
        let offset = theta[i] - target.center[i];
        scored.value -= 0.5 * precision * offset * offset;
        scored.gradient[i] -= precision * offset;
        scored.information[(i, i)] += precision;
    }
    let [a, b] = target.lapse_beta;
    let lapse = theta[3];
    scored.value += target.ln_lapse_prior(lapse);
    scored.gradient[3] -= (b - 1.0) / (1.0 - lapse);
    scored.information[(3, 3)] += (b - 1.0) / (1.0 - lapse).powi(2) + 1e-9;
    if a > 1.0 {
        scored.gradient[3] += (a - 1.0) / lapse;
        scored.information[(3, 3)] += (a - 1.0) / lapse.powi(2);
    }
    scored
}

/// Climb from `start` until steps no longer help; `project(from, to)` brings a step back into bounds.
fn climb(
    start: Vector4<f64>,
    scored: impl Fn(&Vector4<f64>) -> Scored,
    project: impl Fn(Vector4<f64>, Vector4<f64>) -> Vector4<f64>,
) -> (Vector4<f64>, Scored) {
    let mut at = project(start, start);
    let mut current = scored(&at);
    let mut damping = 1e-3;
    for _ in 0..200 {
        let mut damped = current.information;
        for i in 0..4 {
            damped[(i, i)] *= 1.0 + damping;
        }
        let Some(factor) = damped.cholesky() else {
            break;
        };
        let to = project(at, at + factor.solve(&current.gradient));
        let step = to - at;
        let next = scored(&to);
        if next.value.is_finite() && next.value >= current.value {
            let size = (current.information * step).dot(&step);
            (at, current) = (to, next);
            damping = (damping * 0.1).max(1e-12);
            // The step is below a millionth of a posterior standard deviation.
            if size < 1e-14 {
                break;
            }
        } else {
            damping = damping.max(1e-4) * 8.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    (at, current)
}

/// The best of a coarse grid over ±3 prior standard deviations, so that a far optimum is not missed.
fn best_of_coarse_grid(target: &Posterior<'_>) -> Vector4<f64> {
    let mut best = (f64::NEG_INFINITY, Vector4::zeros());
    for i in -3..=3 {
        for j in -3..=3 {
            for k in -1..=1 {
                let x = Vector4::new(f64::from(i), f64::from(j), f64::from(k), 0.0);
                let value = target.ln_density(&x);
                if value > best.0 {
                    best = (value, x);
                }
            }
        }
    }
    best.1
}
