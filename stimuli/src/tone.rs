//! The first two steps of the display transform: exposure, and the tone map that brings light into 0–1. Here on the CPU;
//! `display_pass.wgsl` does the same, and the third step, the display's transfer, is
//! [`experiments::display::Transfer`]'s.
//!
//! The filmic curve is applied to each channel, as layers of film are exposed each by its own light, so that what is much
//! too bright turns white instead of staying a saturated colour. Up to [`KNEE`] it leaves light as it is. Beyond, with
//! `t = (x − KNEE) / (1 − KNEE)`, it is `KNEE + (1 − KNEE) · t (1 + t / T²) / (1 + t)`, the compression of Reinhard, Stark,
//! Shirley and Ferwerda ("Photographic Tone Reproduction for Digital Images", ACM TOG 21(3), 2002, Eq. 4), which leaves the
//! knee with slope 1, rises throughout and reaches 1 at `t = T`, which is at [`WHITE`].

use crate::contract::{SceneLight, ToneMap};

/// Up to this light the filmic curve changes nothing: a mid grey of 18 % keeps its value.
pub const KNEE: f64 = 0.25;
/// The light that the filmic curve shows as 1, in units of the display's peak.
pub const WHITE: f64 = 8.0;

impl ToneMap {
    /// What is shown, 0–1, of light that is relative to the display's peak.
    #[must_use]
    pub fn shown(self, light: f64) -> f64 {
        match self {
            Self::Clamp => light.clamp(0.0, 1.0),
            Self::Filmic => {
                let t = (light.clamp(0.0, WHITE) - KNEE).max(0.0) / (1.0 - KNEE);
                let end = (WHITE - KNEE) / (1.0 - KNEE);
                let shoulder = t * (1.0 + t / (end * end)) / (1.0 + t);
                (light.clamp(0.0, KNEE) + (1.0 - KNEE) * shoulder).min(1.0)
            }
        }
    }
}

impl SceneLight {
    /// The least light of the scene that is shown as 1: what is brighter looks the same.
    #[must_use]
    pub fn white(&self) -> f64 {
        let shown_as_one = match self.tone_map {
            ToneMap::Clamp => 1.0,
            ToneMap::Filmic => WHITE,
        };
        shown_as_one / self.exposure.max(f64::MIN_POSITIVE)
    }

    /// What is shown of a colour of the scene: linear, 0–1 in each channel.
    #[must_use]
    pub fn shown(self, light: [f64; 3]) -> [f64; 3] {
        light.map(|x| self.tone_map.shown(self.exposure * x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filmic_curve_is_linear_in_the_shadows_rises_and_ends_at_one() {
        let curve = |x: f64| ToneMap::Filmic.shown(x);
        for x in [-1.0, 0.0, 0.01, 0.18, KNEE] {
            assert!((curve(x) - x.max(0.0)).abs() < 1e-15, "{x}");
        }
        // Slope 1 on both sides of the knee.
        let slope = (curve(KNEE + 1e-6) - curve(KNEE)) / 1e-6;
        assert!((slope - 1.0).abs() < 1e-5, "{slope}");
        let values: Vec<f64> = (0..=8000).map(|i| curve(f64::from(i) * 1e-3)).collect();
        assert!(values.windows(2).all(|pair| pair[1] > pair[0]));
        // It only ever darkens, and falls away from the line by more the brighter it gets.
        assert!(values.iter().zip(0..).all(|(&y, i)| y <= f64::from(i) * 1e-3 + 1e-12));
        for x in [WHITE, 9.0, 1e30] {
            assert!((curve(x) - 1.0).abs() < 1e-12, "{x}: {}", curve(x));
        }
    }

    #[test]
    fn exposure_comes_first() {
        let light = SceneLight { exposure: 4.0, tone_map: ToneMap::Clamp };
        assert_eq!(light.shown([0.0, 0.125, 0.5]), [0.0, 0.5, 1.0]);
        let filmic = SceneLight { exposure: 0.5, tone_map: ToneMap::Filmic };
        assert!((filmic.shown([0.5, 16.0, 0.0])[0] - 0.25).abs() < 1e-15);
        assert!((filmic.shown([0.5, 16.0, 0.0])[1] - 1.0).abs() < 1e-12);
    }
}
