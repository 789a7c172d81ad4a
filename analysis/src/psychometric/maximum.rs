//! The largest value of a smooth function inside a box: Newton's method with numerical derivatives.
//!
//! Densities here have at most a few dozen parameters, cost a microsecond and often have their maximum on a face of the box
//! (a lapse rate of zero). A coordinate on a face that it would leave is held there; the others take a damped step.

use nalgebra::{DMatrix, DVector};

/// A box, one pair of ends for each coordinate; equal ends fix a coordinate.
pub(super) type Bounds = [[f64; 2]];

/// The highest point that Newton's method climbs to from `start`, and its value.
///
/// `scale` is a length for each coordinate over which the function changes notably. `start` is brought into the box; a
/// start at which the function is not finite is returned as it is.
pub(super) fn maximise(f: impl Fn(&[f64]) -> f64, start: &[f64], bounds: &Bounds, scale: &[f64]) -> (Vec<f64>, f64) {
    let inside = |x: &[f64]| -> Vec<f64> {
        x.iter().zip(bounds).map(|(x, [low, high])| x.clamp(*low, high.max(*low))).collect()
    };
    let mut x = inside(start);
    let mut value = f(&x);
    let mut damping = 1e-3;
    if !value.is_finite() {
        return (x, value);
    }
    for _ in 0..200 {
        let (gradient, hessian, free) = derivatives(&f, &x, value, bounds, scale);
        if free.is_empty() {
            break;
        }
        let mut climbed = false;
        while damping < 1e14 {
            let mut matrix = hessian.clone();
            for i in 0..free.len() {
                matrix[(i, i)] += damping * hessian[(i, i)].abs().max(1.0);
            }
            let Some(factor) = matrix.cholesky() else {
                damping *= 8.0;
                continue;
            };
            let step = factor.solve(&gradient);
            let mut to = x.clone();
            for (index, step) in free.iter().zip(step.iter()) {
                to[*index] += step * scale[*index];
            }
            let to = inside(&to);
            let next = f(&to);
            if next > value {
                let gain = next - value;
                (x, value) = (to, next);
                damping = (damping * 0.1).max(1e-10);
                climbed = gain > 1e-11;
                break;
            }
            damping *= 8.0;
        }
        if !climbed {
            break;
        }
    }
    (x, value)
}

/// Gradient and negative Hessian in units of `scale`, over the coordinates that are free to move.
fn derivatives(
    f: &impl Fn(&[f64]) -> f64,
    x: &[f64],
    value: f64,
    bounds: &Bounds,
    scale: &[f64],
) -> (DVector<f64>, DMatrix<f64>, Vec<usize>) {
    let step = 1e-4;
    let at = |moves: &[(usize, f64)]| {
        let mut to = x.to_vec();
        moves.iter().for_each(|(index, by)| to[*index] += by * scale[*index]);
        f(&to)
    };
    let mut free = Vec::new();
    let (mut slopes, mut curvatures) = (Vec::new(), Vec::new());
    for (index, [low, high]) in bounds.iter().enumerate() {
        let room = [(x[index] - low) / scale[index], (high - x[index]) / scale[index]];
        if room[0] + room[1] <= 4.0 * step {
            continue;
        }
        let (slope, curvature) = if room[0] > step && room[1] > step {
            let (above, below) = (at(&[(index, step)]), at(&[(index, -step)]));
            ((above - below) / (2.0 * step), (above - 2.0 * value + below) / (step * step))
        } else {
            // At a face, from the inside.
            let side = if room[0] > room[1] { -step } else { step };
            let (near, far) = (at(&[(index, side)]), at(&[(index, 2.0 * side)]));
            ((4.0 * near - 3.0 * value - far) / (2.0 * side), (value - 2.0 * near + far) / (step * step))
        };
        let held = (room[0] <= 1e-12 && slope <= 0.0) || (room[1] <= 1e-12 && slope >= 0.0);
        if held || !slope.is_finite() || !curvature.is_finite() {
            continue;
        }
        free.push(index);
        slopes.push(slope);
        curvatures.push(curvature);
    }
    let n = free.len();
    let mut hessian = DMatrix::zeros(n, n);
    for i in 0..n {
        // A coordinate along which the function is convex is climbed along its slope.
        hessian[(i, i)] = if curvatures[i] < 0.0 { -curvatures[i] } else { slopes[i].abs().max(1e-6) };
    }
    for i in 0..n {
        for j in 0..i {
            let side = |index: usize| {
                let high = bounds[index][1];
                if (high - x[index]) / scale[index] > step { step } else { -step }
            };
            let (a, b) = (side(free[i]), side(free[j]));
            let (both, one, other) = (at(&[(free[i], a), (free[j], b)]), at(&[(free[i], a)]), at(&[(free[j], b)]));
            let mixed = (both - one - other + value) / (a * b);
            if mixed.is_finite() {
                hessian[(i, j)] = -mixed;
                hessian[(j, i)] = -mixed;
            }
        }
    }
    (DVector::from_vec(slopes), hessian, free)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_climbed_to_its_top() {
        let f = |x: &[f64]| -(x[0] - 1.0).powi(2) - 3.0 * (x[1] + 2.0).powi(2) + (x[0] - 1.0) * (x[1] + 2.0);
        let (x, value) = maximise(f, &[8.0, 5.0], &[[-10.0, 10.0], [-10.0, 10.0]], &[1.0, 1.0]);
        assert!((x[0] - 1.0).abs() < 1e-5 && (x[1] + 2.0).abs() < 1e-5 && value.abs() < 1e-9, "{x:?}");
    }

    /// Rosenbrock's valley; inside the box its top is on the face x = 0.5, at y = 0.25.
    #[test]
    fn a_bent_valley_and_a_face() {
        let f = |x: &[f64]| -(1.0 - x[0]).powi(2) - 100.0 * (x[1] - x[0] * x[0]).powi(2);
        let (x, _) = maximise(f, &[-1.2, 1.0], &[[-5.0, 5.0], [-5.0, 5.0]], &[1.0, 1.0]);
        assert!((x[0] - 1.0).abs() < 1e-4 && (x[1] - 1.0).abs() < 1e-4, "{x:?}");
        let (x, _) = maximise(f, &[-1.2, 1.0], &[[-5.0, 0.5], [-5.0, 5.0]], &[1.0, 1.0]);
        assert!(x[0] == 0.5 && (x[1] - 0.25).abs() < 1e-5, "{x:?}");
    }

    #[test]
    fn fixed_coordinates_stay_and_hopeless_starts_are_returned() {
        let f = |x: &[f64]| -(x[0] * x[0]) - x[1] * x[1];
        let (x, _) = maximise(f, &[3.0, 3.0], &[[2.0, 2.0], [-5.0, 5.0]], &[1.0, 1.0]);
        assert!(x[0] == 2.0 && x[1].abs() < 1e-5);
        let (x, value) = maximise(|_| f64::NAN, &[1.0], &[[0.0, 2.0]], &[1.0]);
        assert!(x == [1.0] && value.is_nan());
    }
}
