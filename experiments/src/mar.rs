//! The acuity model that the laboratory measures: MAR grows linearly with eccentricity.
//!
//! The model is shared by whoever answers (simulated observers), whoever asks (QUEST+) and whoever fits (`analysis`), so
//! that a study is planned, simulated and analysed with one likelihood.

use serde::{Deserialize, Serialize};
use statrs::function::erf::erfc;

/// Scale that makes [`MarModel::width`] the distance, in ln omega, from 5 % to 95 % of the unscaled function:
/// Φ⁻¹(0.95) − Φ⁻¹(0.05) (Schütt et al. 2016, for the cumulative Gauss).
pub const WIDTH_SCALE: f64 = 3.289_707_253_902_945;

/// Standard deviation over omega of the Gaussian low-pass that stands for a detail limit: its amplitude
/// exp(−2π²σ²f²) is ½ at f = 1/omega. √(ln 2 / (2π²)).
pub const SIGMA_PER_MAR: f64 = 0.187_390_625_129_277_6;

/// Guenter's quality index law: slope m = 0.33 / j, in degrees per cycle per degree.
///
/// The paper's supplement is not at hand; its pairs j = 12 ↔ 0.0275 and j = 15 ↔ 0.0220 (Guenter 2012, §5) give the
/// constant. Larger j is finer; the studies used j from 4 to 22.
#[must_use]
pub fn slope_from_quality_index(quality_index: f64) -> f64 {
    0.33 / quality_index
}

/// The quality index of a slope: the inverse of [`slope_from_quality_index`].
#[must_use]
pub fn quality_index_from_slope(m: f64) -> f64 {
    0.33 / m
}

/// An observer's detail limit and how sharply they know it.
///
/// `omega = m e + omega0` (Guenter 2012, Eq. 1), and the probability of a correct answer is
/// ψ(e, ω) = γ + (1 − γ − λ) Φ(3.2897 (ln ω − ln(m e + ω0)) / w).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MarModel {
    /// MAR slope: degrees per cycle gained by each degree of eccentricity.
    pub m: f64,
    /// MAR at the fovea, degrees per cycle.
    pub omega0_deg: f64,
    /// Width of the psychometric function in ln omega, from 5 % to 95 % of its rise.
    pub width: f64,
    /// Lapse rate λ: the share of answers given without regard to the stimulus.
    pub lapse: f64,
}

impl MarModel {
    /// The threshold omega at an eccentricity, in degrees per cycle.
    #[must_use]
    pub fn threshold_deg(&self, eccentricity_deg: f64) -> f64 {
        self.m * eccentricity_deg + self.omega0_deg
    }

    /// ψ: the probability of a correct answer, with guess rate `guess` (½ for two alternatives).
    #[must_use]
    pub fn probability_correct(&self, eccentricity_deg: f64, mar_deg: f64, guess: f64) -> f64 {
        let u = (mar_deg.ln() - self.threshold_deg(eccentricity_deg).ln()) / self.width;
        guess + (1.0 - guess - self.lapse) * standard_normal_cdf(WIDTH_SCALE * u)
    }
}

/// Φ, the cumulative distribution of the standard normal.
#[must_use]
pub fn standard_normal_cdf(x: f64) -> f64 {
    0.5 * erfc(-x / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_spans_five_to_ninety_five_percent() {
        let model = MarModel { m: 0.022, omega0_deg: 1.0 / 48.0, width: 0.8, lapse: 0.0 };
        let threshold = model.threshold_deg(10.0);
        let at = |ln_offset: f64| model.probability_correct(10.0, threshold * ln_offset.exp(), 0.0);
        assert!((at(-0.4) - 0.05).abs() < 1e-9);
        assert!((at(0.0) - 0.5).abs() < 1e-12);
        assert!((at(0.4) - 0.95).abs() < 1e-9);
    }

    #[test]
    fn guess_and_lapse_bound_the_function() {
        let model = MarModel { m: 0.022, omega0_deg: 0.02, width: 0.5, lapse: 0.03 };
        assert!((model.probability_correct(5.0, 1e-6, 0.5) - 0.5).abs() < 1e-12);
        assert!((model.probability_correct(5.0, 1e6, 0.5) - 0.97).abs() < 1e-12);
    }
}
