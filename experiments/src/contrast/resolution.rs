//! The blur that a patch tolerates unseen (Tursun 2019, Eqs. 8–13).

use super::perceived::bands;
use super::{Parameters, Plane, Sensitivity};
use std::f64::consts::PI;

/// The largest blur that is given: a flat patch tolerates anything. Pixels.
const LARGEST_SIGMA_PX: f64 = 10.0;

/// σ_s: the standard deviation, in pixels of the full resolution, of the Gaussian that a patch of luminance (cd/m²)
/// tolerates; at most 10.
///
/// `subsampling` is 1 for a patch in full resolution and 4 for every fourth pixel of one. Eq. 11 is read as
/// C'_n = (|C_n|^α − 1 − M)^{1/α} where that is not negative and 0 elsewhere, since as printed most pixels would take the
/// root of a negative number.
#[must_use]
pub fn tolerated_sigma_px(patch: Plane, parameters: &Parameters, sensitivity: &Sensitivity, subsampling: u32) -> f64 {
    let (width, height) = (patch.width, patch.height);
    // The largest 1/σ_s of all bands at each pixel: the least blur that anything there tolerates.
    let mut sharpest = vec![0.0_f64; width * height];
    for (index, band) in bands(patch, parameters, sensitivity).iter().enumerate() {
        let frequency = 0.5_f64.powi(index as i32 + 1) / f64::from(subsampling);
        let passed = Plane {
            data: (band.normalised.data.iter().zip(&band.masking.data))
                .map(|(normalised, masking)| {
                    let left = f64::from(*normalised).powf(parameters.alpha) - 1.0 - f64::from(*masking);
                    if left < 0.0 { 0.0 } else { (left.powf(1.0 / parameters.alpha) / f64::from(*normalised)) as f32 }
                })
                .collect(),
            ..band.normalised
        };
        for (pixel, sharpest) in sharpest.iter_mut().enumerate() {
            let share = f64::from(bilinear(&passed, pixel % width, pixel / width, width, height));
            // Eq. 8: σ_f = f / √(−2 ln(C'_n / C_n)), and 1/σ_s = 2π σ_f.
            if share > 0.0 && share < 1.0 {
                *sharpest = sharpest.max(2.0 * PI * frequency / (-2.0 * share.ln()).sqrt());
            }
        }
    }
    // Eq. 12: its ω acts on 1/σ_s in px⁻¹.
    let (mut sum, mut weights) = (0.0, 0.0);
    for value in &sharpest {
        let w = (parameters.omega * value).exp();
        sum += value * w;
        weights += w;
    }
    // A flat patch has a sum of zero, and a quotient beyond all bounds.
    (weights / sum).min(LARGEST_SIGMA_PX)
}

/// A plane at a pixel of another that covers the same area with `width` × `height` pixels; bilinear between the samples'
/// middles, level beyond them.
fn bilinear(plane: &Plane, x: usize, y: usize, width: usize, height: usize) -> f32 {
    let place = |at: usize, to: usize, from: usize| {
        let at = ((at as f32 + 0.5) * from as f32 / to as f32 - 0.5).clamp(0.0, (from - 1) as f32);
        let low = at as usize;
        (low, (low + 1).min(from - 1), at.fract())
    };
    let (left, right, u) = place(x, width, plane.width);
    let (top, bottom, v) = place(y, height, plane.height);
    let row = |y: usize| {
        let row = &plane.data[y * plane.width..];
        row[left] + u * (row[right] - row[left])
    };
    row(top) + v * (row(bottom) - row(top))
}

#[cfg(test)]
mod tests {
    use super::super::{BANDS, FULL_RESOLUTION, QUARTER_RESOLUTION, sensitivity::peak_cpd};
    use super::*;
    use crate::display::Display;

    const ECCENTRICITIES_DEG: [f64; 6] = [5.0, 10.0, 15.0, 20.0, 25.0, 30.0];

    fn display() -> Display {
        Display::new("27in", [2560, 1440], [596.74, 596.74 * 9.0 / 16.0], 665.0).expect("possible")
    }

    fn sigmas(patch: &Plane, parameters: &Parameters, subsampling: u32, bands: usize) -> Vec<f64> {
        let display = display();
        let sigma = |&e: &f64| {
            let peak = peak_cpd(&display, e) / f64::from(subsampling);
            let sensitivity = Sensitivity::uniform(parameters, e, peak, bands);
            tolerated_sigma_px(patch.clone(), parameters, &sensitivity, subsampling)
        };
        ECCENTRICITIES_DEG.iter().map(sigma).collect()
    }

    fn step(x: usize) -> f32 {
        if x < 64 { 50.0 } else { 150.0 }
    }

    fn checker(x: usize, y: usize) -> f32 {
        if (x / 8 + y / 8).is_multiple_of(2) { 20.0 } else { 180.0 }
    }

    /// The figures of an independent computation of the same equations, σ_s in pixels at 5, 10, …, 30°: a step from 50 to
    /// 150 cd/m² and a checkerboard of 8 pixels, 20 and 180 cd/m².
    #[test]
    fn patches_tolerate_the_blur_that_was_computed_for_them() {
        let full = |f: &dyn Fn(usize, usize) -> f32| sigmas(&Plane::from_fn(128, 128, f), &FULL_RESOLUTION, 1, BANDS);
        let quarter = |f: &dyn Fn(usize, usize) -> f32| {
            sigmas(&Plane::from_fn(32, 32, |x, y| f(4 * x, 4 * y)), &QUARTER_RESOLUTION, 4, 2)
        };
        let cases = [
            (full(&|x, _| step(x)), [0.127, 0.257, 0.700, 1.229, 1.813, 2.246], 0.005),
            (full(&checker), [0.126, 0.240, 0.477, 0.708, 1.366, 2.133], 0.005),
            (quarter(&|x, _| step(x)), [0.242, 0.336, 0.503, 0.846, 1.525, 2.655], 0.02),
            (quarter(&checker), [0.203, 0.265, 0.354, 0.494, 0.750, 1.378], 0.02),
        ];
        for (found, expected, tolerance) in cases {
            println!("{found:.4?} for {expected:?}");
            assert!(found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < tolerance), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn a_flat_patch_tolerates_the_largest_blur() {
        let found = sigmas(&Plane::from_fn(128, 128, |_, _| 0.0), &FULL_RESOLUTION, 1, BANDS);
        assert!(found.iter().all(|sigma| (sigma - LARGEST_SIGMA_PX).abs() < 1e-12), "{found:?}");
    }
}
