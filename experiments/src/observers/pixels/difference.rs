//! How visible the difference between two pictures is.
//!
//! V = (1/A Σ_bands Σ_samples a |C_t − C'_t|^4)^{1/4}: a Minkowski sum, with a the solid angle of a sample of its band and
//! A that of a patch. A difference of one JND all over one patch in one band has V = 1, and more places or bands with a
//! difference make it more visible, as chances to notice it add up. The exponent 4 is our choice, near those of
//! probability summation in detection (Robson & Graham 1981 found 3.5); so is pooling over the whole display.

use crate::contrast::luminance::luminance;
use crate::contrast::perceived::{Band, bands};
use crate::contrast::{DEFAULT_PEAK_CD_M2, FULL_RESOLUTION, Sensitivity};
use crate::observers::{Picture, Seen};

/// The exponent of the Minkowski sum.
pub const EXPONENT: i32 = 4;

/// The side of a patch, degrees: 128 pixels of the first display of Tursun 2019 and 192 of the second are 2.6° and 2.8°.
pub const PATCH_DEG: f64 = 2.6;

/// V of what is shown against the reference; nothing if the pictures are not of one size.
#[must_use]
pub fn visibility(seen: &Seen<'_>, sensitivity: &Sensitivity) -> Option<f64> {
    if seen.shown.size_px != seen.reference.size_px {
        return None;
    }
    if seen.shown.rgba == seen.reference.rgba {
        return Some(0.0);
    }
    let peak_cd_m2 = seen.display.peak_cd_m2().unwrap_or(DEFAULT_PEAK_CD_M2);
    let felt = |picture: &Picture<'_>| {
        let light = luminance(picture.size_px, picture.rgba, seen.display.transfer(), peak_cd_m2)?;
        Some(bands(light, &FULL_RESOLUTION, sensitivity))
    };
    let (shown, reference) = (felt(&seen.shown)?, felt(&seen.reference)?);
    let size_mm = seen.display.size_mm();
    let sample_mm2 = size_mm[0] * size_mm[1] / (f64::from(seen.shown.size_px[0]) * f64::from(seen.shown.size_px[1]));
    let patch_mm = 2.0 * (0.5 * PATCH_DEG).to_radians().tan() * seen.display.distance_mm();
    let share = sample_mm2 / patch_mm.powi(2);
    let sum: f64 = (shown.iter().zip(&reference).enumerate())
        .map(|(band, (shown, reference))| share * 4f64.powi(band as i32) * powers(shown, reference))
        .sum();
    Some(sum.powf(1.0 / f64::from(EXPONENT)))
}

/// The sum of the differences' powers over a band.
fn powers(shown: &Band, reference: &Band) -> f64 {
    let power = |(a, b): (&f32, &f32)| f64::from(a - b).powi(EXPONENT);
    shown.perceived.data.iter().zip(&reference.perceived.data).map(power).sum()
}
