//! The filter of the calibration ring: a Gaussian low-pass that halves the amplitude at 1/omega cycles per degree, round
//! in visual angle and therefore an ellipse of changing shape on a flat display. Its shape and its mask are defined here,
//! the shaders (`renderers/low_passed.wgsl`, `renderers/ring.wgsl`) and the CPU oracle of the tests follow.

use experiments::display::Display;
use std::sync::LazyLock;

pub use experiments::mar::SIGMA_PER_MAR;

/// The standard deviation, in degrees, of the filter that removes detail finer than `mar_deg` degrees per cycle.
#[must_use]
pub fn sigma_deg(mar_deg: f64) -> f64 {
    SIGMA_PER_MAR * mar_deg
}

/// How far the filter reaches, in standard deviations.
pub const TRUNCATION: f64 = 3.5;

/// The filter's shape at a place on the display.
///
/// An isotropic Gaussian of angles becomes, on the plane one unit in front of the eye (u = x/d, v = y/d, r² = u² + v²),
/// a Gaussian of covariance σ² (1 + r²) (I + [u², uv; uv, v²]): the pixel shrinks with distance and with slant. Computed at
/// the pixel that is shown, in display pixels with y down, and scaled by [`effective_sigma_px`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariance {
    /// Variance along x, px².
    pub xx: f64,
    /// Covariance of x and y, px², y down.
    pub xy: f64,
    /// Variance along y, px².
    pub yy: f64,
}

impl Covariance {
    /// The filter at `at_px` for a detail limit of `mar_deg`.
    #[must_use]
    pub fn at(display: &Display, at_px: [f64; 2], mar_deg: f64) -> Self {
        let distance = display.distance_mm();
        let [u, v] = display.mm_from_px(at_px).map(|x| x / distance);
        let pitch = display.pitch_mm().map(|x| x / distance);
        let sigma = sigma_deg(mar_deg).to_radians();
        let stretch = 1.0 + u * u + v * v;
        // det(I + p pᵀ) = 1 + r², so the geometric mean of the two axes is σ (1 + r²)^¾.
        let mean_px = sigma * stretch.powf(0.75) / (pitch[0] * pitch[1]).sqrt();
        let scale = sigma * sigma * stretch * (effective_sigma_px(mean_px) / mean_px).powi(2);
        Self {
            xx: scale * (1.0 + u * u) / (pitch[0] * pitch[0]),
            xy: -scale * u * v / (pitch[0] * pitch[1]),
            yy: scale * (1.0 + v * v) / (pitch[1] * pitch[1]),
        }
    }

    /// How far the filter reaches on each axis, in pixels.
    #[must_use]
    pub fn reach_px(&self) -> [f64; 2] {
        [TRUNCATION * self.xx.sqrt(), TRUNCATION * self.yy.sqrt()]
    }
}

/// σ below which a Gaussian sampled at the pixels differs from the continuous one by what matters, px.
pub(crate) const CORRECTED_TO_PX: f64 = 1.0;
/// σ of the filter whose half-amplitude frequency is the display's Nyquist frequency (omega = 2 px).
pub(crate) const CORRECTED_FROM_PX: f64 = 2.0 * SIGMA_PER_MAR;
/// Intervals of the table that the shader interpolates.
pub(crate) const TABLE_STEPS: usize = 63;

/// The standard deviation at which a Gaussian *sampled at the pixels* halves the amplitude where the continuous Gaussian
/// of `sigma_px` does.
///
/// Near the display's limit a sampled Gaussian is weaker than a continuous one: at omega = 2 px, with weights taken at
/// σ = 0.375 px, the amplitude would be 0.89 instead of ½. This solves Σ w^{n²} cos(2πn/omega) = ½ Σ w^{n²} for
/// w = exp(−1/2σ²) along a pixel row. Above one pixel the two agree to 1e-7; below the display's limit nothing
/// that could be shown is halved, and the correction stays at its last factor, so that σ → 0 is the untouched picture.
#[must_use]
pub fn effective_sigma_px(sigma_px: f64) -> f64 {
    static TABLE: LazyLock<[f64; TABLE_STEPS + 1]> = LazyLock::new(|| {
        std::array::from_fn(|i| {
            let share = i as f64 / TABLE_STEPS as f64;
            solve_effective_sigma(CORRECTED_FROM_PX + share * (CORRECTED_TO_PX - CORRECTED_FROM_PX))
        })
    });
    if sigma_px >= CORRECTED_TO_PX {
        return sigma_px;
    }
    if sigma_px <= CORRECTED_FROM_PX {
        return sigma_px * TABLE[0] / CORRECTED_FROM_PX;
    }
    let place = (sigma_px - CORRECTED_FROM_PX) / (CORRECTED_TO_PX - CORRECTED_FROM_PX) * TABLE_STEPS as f64;
    let index = (place as usize).min(TABLE_STEPS - 1);
    let share = place - index as f64;
    TABLE[index] * (1.0 - share) + TABLE[index + 1] * share
}

/// Amplitude at `cycles_per_px` of a Gaussian of `sigma_px` sampled at whole pixels and normalised.
fn sampled_amplitude(sigma_px: f64, cycles_per_px: f64) -> f64 {
    let weights = (1..=12).map(|n| (-0.5 * f64::from(n * n) / (sigma_px * sigma_px)).exp()).zip(1..);
    let (mut sum, mut response) = (1.0, 1.0);
    for (weight, n) in weights {
        sum += 2.0 * weight;
        response += 2.0 * weight * (std::f64::consts::TAU * cycles_per_px * f64::from(n)).cos();
    }
    response / sum
}

fn solve_effective_sigma(sigma_px: f64) -> f64 {
    let half_amplitude_at = SIGMA_PER_MAR / sigma_px;
    let (mut low, mut high) = (sigma_px, 2.0 * sigma_px);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if sampled_amplitude(middle, half_amplitude_at) > 0.5 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// How much of the filtered picture shows at an eccentricity, 0–1.
///
/// 1 within `width_deg / 2` of `ring_deg`, falling to 0 over a further `edge_deg` by 3t² − 2t³. A ring at 0° is a disc.
#[must_use]
pub fn ring_mask(eccentricity_deg: f64, ring_deg: f64, width_deg: f64, edge_deg: f64) -> f64 {
    let beyond = (eccentricity_deg - ring_deg).abs() - 0.5 * width_deg;
    let t = 1.0 - (beyond / edge_deg.max(1e-9)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitude_is_half_at_the_detail_limit() {
        let exact = (std::f64::consts::LN_2 / (2.0 * std::f64::consts::PI.powi(2))).sqrt();
        assert!((SIGMA_PER_MAR - exact).abs() < 1e-15, "{exact:.20}");
        let amplitude = (-2.0 * std::f64::consts::PI.powi(2) * SIGMA_PER_MAR.powi(2)).exp();
        assert!((amplitude - 0.5).abs() < 1e-12);
    }

    #[test]
    fn sampled_filter_halves_the_amplitude_down_to_the_display_limit() {
        let mut worst: f64 = 0.0;
        for step in 0..400 {
            let omega_px = 2.0 + 0.02 * f64::from(step);
            let sigma = effective_sigma_px(SIGMA_PER_MAR * omega_px);
            worst = worst.max((sampled_amplitude(sigma, 1.0 / omega_px) - 0.5).abs());
        }
        println!("largest departure from ½ for omega of 2–10 px: {worst:.2e}");
        assert!(worst < 1e-3);
        assert!(effective_sigma_px(1e-6) < 2e-6);
    }

    /// The covariance from its definition: small steps of angle in all directions around a place, by finite differences.
    #[test]
    fn covariance_is_round_in_visual_angle() {
        let display = Display::new("wide", [800, 500], [900.0, 560.0], 400.0).expect("in range");
        let mar_deg = 2.0;
        for at_px in [[400.0, 250.0], [31.0, 470.0], [700.0, 100.0]] {
            let c = Covariance::at(&display, at_px, mar_deg);
            let det = c.xx * c.yy - c.xy * c.xy;
            for step in 0..16 {
                let (sin, cos) = (f64::from(step) * 0.4).sin_cos();
                let (dx, dy) = (cos * 1e-3, sin * 1e-3);
                // Mahalanobis length of the step against its true angle over σ.
                let length = ((c.yy * dx * dx - 2.0 * c.xy * dx * dy + c.xx * dy * dy) / det).sqrt();
                let angle = display.eccentricity_px_deg(at_px, [at_px[0] + dx, at_px[1] + dy]);
                assert!((length / (angle / sigma_deg(mar_deg)) - 1.0).abs() < 1e-4, "{at_px:?} {step}");
            }
        }
    }

    #[test]
    fn mask_is_one_on_the_plateau_and_zero_beyond_the_edge() {
        for (e, expected) in [(8.0, 1.0), (10.0, 1.0), (12.0, 1.0), (12.25, 0.5), (12.5, 0.0), (7.75, 0.5), (0.0, 0.0)]
        {
            assert!((ring_mask(e, 10.0, 4.0, 0.5) - expected).abs() < 1e-12, "{e}");
        }
        assert!((ring_mask(0.0, 0.0, 4.0, 0.0) - 1.0).abs() < 1e-12);
        assert!(ring_mask(2.01, 0.0, 4.0, 0.0).abs() < 1e-12);
    }
}
