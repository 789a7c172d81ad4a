//! How sensitive the eye is to each band at each place, apart from the light that it is adapted to (Tursun 2019, Eq. 3).

use super::csf::Csf;
use super::{Parameters, Plane};
use crate::display::Display;

/// Radii at which the frequency of a band is computed; between them it is interpolated.
const RADII: usize = 1024;

/// ln of S'(f) exp(−c_a θ f) in every band; the finest first.
#[derive(Debug, Clone, PartialEq)]
pub enum Sensitivity {
    /// The same all over a patch: one number for each band.
    Uniform(Vec<f32>),
    /// At each sample of each band.
    Map(Vec<Plane>),
}

/// The highest frequency that a display can show at an angle of `axis_deg` off its axis, cycles per degree:
/// d (tan(φ + ½°) − tan(φ − ½°)) / pitch / 2, with the mean pitch of both directions.
///
/// For a gaze at the display's centre φ is the eccentricity θ. Elsewhere how many pixels lie in a degree still depends on
/// the angle off the axis, and only the eye's sensitivity on θ.
#[must_use]
pub fn peak_cpd(display: &Display, axis_deg: f64) -> f64 {
    let pitch = display.pitch_mm();
    let tan = |deg: f64| deg.to_radians().tan();
    display.distance_mm() * (tan(axis_deg + 0.5) - tan(axis_deg - 0.5)) / (0.5 * (pitch[0] + pitch[1])) / 2.0
}

impl Sensitivity {
    /// For a patch at one eccentricity in degrees, whose finest band has the frequency `peak_cpd`.
    #[must_use]
    pub fn uniform(parameters: &Parameters, eccentricity_deg: f64, peak_cpd: f64, bands: usize) -> Self {
        let csf = Csf::new(parameters);
        let ln = |band: usize| {
            let cpd = band_cpd(peak_cpd, band);
            (csf.ln_sensitivity(cpd) - parameters.c_a * eccentricity_deg * cpd) as f32
        };
        Self::Uniform((0..bands).map(ln).collect())
    }

    /// For a picture that fills the display, seen by an eye that looks at `gaze_deg`.
    ///
    /// A picture of fewer pixels than the display's is taken as one that is shown enlarged: its samples are farther apart.
    #[must_use]
    pub fn of_display(
        parameters: &Parameters,
        display: &Display,
        gaze_deg: [f64; 2],
        size_px: [u32; 2],
        bands: usize,
    ) -> Self {
        let csf = Csf::new(parameters);
        let size_mm = display.size_mm();
        let spacing_mm = [0, 1].map(|axis| size_mm[axis] / f64::from(size_px[axis].max(1)));
        let enlarged = f64::from(display.resolution_px()[0]) / f64::from(size_px[0].max(1));
        let distance = display.distance_mm() as f32;
        let radius_mm = (0.5 * size_mm[0].hypot(size_mm[1])) as f32;
        let gaze = unit(display.mm_from_deg(gaze_deg).map(|x| x as f32), distance);
        let mut planes = Vec::with_capacity(bands);
        let [mut width, mut height] = size_px.map(|extent| extent as usize);
        for band in 0..bands {
            let per_radius = RADII as f32 / radius_mm;
            let table: Vec<(f32, f32)> = (0..=RADII + 1)
                .map(|step| {
                    let axis_deg = (step as f32 / per_radius / distance).atan().to_degrees();
                    let cpd = band_cpd(peak_cpd(display, f64::from(axis_deg)) / enlarged, band);
                    (csf.ln_sensitivity(cpd) as f32, (parameters.c_a * cpd) as f32)
                })
                .collect();
            // Samples of a coarser band sit on every second sample of the finer one, beginning with the first.
            let step = (1_usize << band) as f32;
            let [dx, dy] = spacing_mm.map(|spacing| spacing as f32);
            let [left, top] = [-0.5 * size_mm[0] as f32, 0.5 * size_mm[1] as f32];
            planes.push(Plane::from_fn(width, height, |x, y| {
                let mm = [left + (x as f32 * step + 0.5) * dx, top - (y as f32 * step + 0.5) * dy];
                let at = (mm[0].hypot(mm[1]) * per_radius).min(RADII as f32);
                let (below, share) = (at as usize, at.fract());
                let [(s0, f0), (s1, f1)] = [table[below], table[below + 1]];
                let direction = unit(mm, distance);
                let chord = direction.iter().zip(gaze).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
                let theta_deg = 2.0 * (0.5 * chord).asin().to_degrees();
                s0 + share * (s1 - s0) - theta_deg * (f0 + share * (f1 - f0))
            }));
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
        }
        Self::Map(planes)
    }

    /// The bands there are.
    #[must_use]
    pub fn bands(&self) -> usize {
        match self {
            Self::Uniform(bands) => bands.len(),
            Self::Map(bands) => bands.len(),
        }
    }

    /// ln sensitivity of a band at a sample.
    pub(super) fn ln_at(&self, band: usize, sample: usize) -> f32 {
        match self {
            Self::Uniform(bands) => bands[band],
            Self::Map(bands) => bands[band].data[sample],
        }
    }
}

/// The frequency of a band, the finest being 0: f_i = pcpd 2^{1−i} with i from 1.
fn band_cpd(peak_cpd: f64, band: usize) -> f64 {
    peak_cpd / f64::from(1_u32 << band)
}

fn unit([x, y]: [f32; 2], z: f32) -> [f32; 3] {
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

#[cfg(test)]
mod tests {
    use super::super::{BANDS, FULL_RESOLUTION};
    use super::*;

    /// Tursun 2019, §5.1: 24.9 and 34.1 cycles per degree at the centres of the two displays.
    #[test]
    fn displays_show_the_published_frequencies() {
        for (name, cpd) in [("tursun-2019-27in", 24.9), ("tursun-2019-32in", 34.1)] {
            let display = Display::named(name).expect("ships");
            assert!((peak_cpd(&display, 0.0) - cpd).abs() < 0.05, "{name}: {}", peak_cpd(&display, 0.0));
        }
    }

    #[test]
    fn a_map_agrees_with_the_patch_at_its_place() {
        let display = Display::named("tursun-2019-27in").expect("ships");
        let size_px = display.resolution_px();
        let map = Sensitivity::of_display(&FULL_RESOLUTION, &display, [0.0, 0.0], size_px, BANDS);
        for px in [[1280_u32, 720], [1280, 0], [2000, 400], [0, 0]] {
            let at_px = px.map(|x| f64::from(x) + 0.5);
            let e = display.eccentricity_px_deg([1280.0, 720.0], at_px);
            let patch = Sensitivity::uniform(&FULL_RESOLUTION, e, peak_cpd(&display, e), BANDS);
            let sample = px[1] as usize * 2560 + px[0] as usize;
            let (there, here) = (map.ln_at(0, sample), patch.ln_at(0, 0));
            assert!((there - here).abs() < 0.05 * here.abs().max(1.0), "{px:?}: {there} {here}");
        }
    }

    #[test]
    fn sensitivity_falls_with_eccentricity_and_the_more_the_finer_the_band() {
        let at = |e| Sensitivity::uniform(&FULL_RESOLUTION, e, 24.9, BANDS);
        let mut fall_before = f32::INFINITY;
        for band in 0..BANDS {
            let [near, middle, far] = [0.0, 10.0, 20.0].map(|e| at(e).ln_at(band, 0));
            assert!(near > middle && middle > far);
            // Twenty degrees cost c_a θ f in ln.
            let cpd = 24.9 / f64::from(1 << band);
            assert!((f64::from(near - far) - 0.038_218 * 20.0 * cpd).abs() < 1e-3);
            assert!(near - far < fall_before);
            fall_before = near - far;
        }
    }
}
