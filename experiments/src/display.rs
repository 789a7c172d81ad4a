//! Display geometry: where a pixel is in millimetres, in degrees, and how fine a detail it can show.
//!
//! The eye sits on the axis through the display's centre, `distance_mm` away, and the display is flat. Three spaces
//! meet here, and every name says which one it means:
//!
//! - `px`: origin at the top left corner, x right, y down; pixel `(i, j)` covers `i..i+1`, its centre is at `i + 0.5`;
//! - `mm`: origin at the display's centre, x right, y up;
//! - `deg`: origin at the display's centre, x right, y up; each coordinate is the true angle of its own axis,
//!   `atan(x_mm / distance_mm)`. Angles *between* points come from [`Display::eccentricity_deg`], never from
//!   subtracting these coordinates.

mod transfer;

pub use transfer::{CHANNELS, MeasuredTransfer, Transfer, TransferError, TransferNumbers};

use serde::Serialize;

/// A flat display seen from a fixed distance.
///
/// Built only by [`Display::new`], which refuses geometry that is absent or impossible, so that every figure in degrees
/// rests on a measured display.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Display {
    name: String,
    resolution_px: [u32; 2],
    size_mm: [f64; 2],
    distance_mm: f64,
    refresh_hz: f64,
    peak_cd_m2: Option<f64>,
    #[serde(skip_serializing_if = "Transfer::is_srgb")]
    transfer: Transfer,
}

/// Why a display cannot exist.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field}: {expected}, found {found}")]
pub struct DisplayError {
    /// The field at fault, as it is written in a display file.
    pub field: &'static str,
    /// What would have been accepted.
    pub expected: &'static str,
    /// What was there.
    pub found: String,
}

/// The refresh rate of a display that states none, in hertz.
pub const DEFAULT_REFRESH_HZ: f64 = 60.0;

/// The displays that ship by name.
pub const NAMED_DISPLAYS: [&str; 4] = ["guenter-2012", "tursun-2019-27in", "tursun-2019-32in", "demo-540p"];

impl Display {
    /// A display of `resolution_px` (width, height) pixels and `size_mm` (width, height), seen from `distance_mm`.
    ///
    /// # Errors
    /// One [`DisplayError`] for each number that is not finite and positive, or out of the range of any real display.
    pub fn new(
        name: impl Into<String>,
        resolution_px: [u32; 2],
        size_mm: [f64; 2],
        distance_mm: f64,
    ) -> Result<Self, Vec<DisplayError>> {
        let mut errors = Vec::new();
        for extent in resolution_px {
            if !(16..=16_384).contains(&extent) {
                errors.push(DisplayError {
                    field: "resolution_px",
                    expected: "whole pixels from 16 to 16384",
                    found: extent.to_string(),
                });
            }
        }
        for extent in size_mm {
            if !(1.0..=100_000.0).contains(&extent) {
                errors.push(DisplayError {
                    field: "size_mm",
                    expected: "millimetres from 1 to 100000",
                    found: extent.to_string(),
                });
            }
        }
        if !(1.0..=1_000_000.0).contains(&distance_mm) {
            errors.push(DisplayError {
                field: "distance_mm",
                expected: "millimetres from 1 to 1000000",
                found: distance_mm.to_string(),
            });
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Self {
            name: name.into(),
            resolution_px,
            size_mm,
            distance_mm,
            refresh_hz: DEFAULT_REFRESH_HZ,
            peak_cd_m2: None,
            transfer: Transfer::Srgb,
        })
    }

    /// The same display with a refresh rate, in hertz.
    ///
    /// # Errors
    /// When `refresh_hz` is outside 1–1000 Hz.
    pub fn with_refresh_hz(mut self, refresh_hz: f64) -> Result<Self, DisplayError> {
        if !(1.0..=1000.0).contains(&refresh_hz) {
            return Err(DisplayError {
                field: "refresh_hz",
                expected: "hertz from 1 to 1000",
                found: refresh_hz.to_string(),
            });
        }
        self.refresh_hz = refresh_hz;
        Ok(self)
    }

    /// The same display with a measured peak luminance, in cd/m².
    ///
    /// # Errors
    /// When `peak_cd_m2` is outside 0.1–100000 cd/m².
    pub fn with_peak_cd_m2(mut self, peak_cd_m2: f64) -> Result<Self, DisplayError> {
        if !(0.1..=100_000.0).contains(&peak_cd_m2) {
            return Err(DisplayError {
                field: "peak_cd_m2",
                expected: "cd/m² from 0.1 to 100000",
                found: peak_cd_m2.to_string(),
            });
        }
        self.peak_cd_m2 = Some(peak_cd_m2);
        Ok(self)
    }

    /// The same display with the transfer that it has; sRGB until then.
    #[must_use]
    pub fn with_transfer(mut self, transfer: Transfer) -> Self {
        self.transfer = transfer;
        self
    }

    /// The same display, as large and as far away, with other pixels.
    ///
    /// # Errors
    /// When the resolution is impossible.
    pub fn with_resolution_px(&self, resolution_px: [u32; 2]) -> Result<Self, Vec<DisplayError>> {
        let checked = Self::new(self.name.as_str(), resolution_px, self.size_mm, self.distance_mm)?;
        Ok(Self { resolution_px: checked.resolution_px, ..self.clone() })
    }

    /// A display that ships with the program, one of [`NAMED_DISPLAYS`].
    ///
    /// - `guenter-2012`: LG W2363D (Guenter 2012, §5: 51 cm wide, 1920×1080, 120 Hz, 59 cm).
    /// - `tursun-2019-27in`: ASUS PG278Q (Tursun 2019, §5.1: 48.3° × 28.3° from 66.5 cm, 214.6 cd/m²).
    /// - `tursun-2019-32in`: Dell UP3216Q (Tursun 2019, §5.1: 52.3° × 30.9° from 71 cm, 199.2 cd/m²).
    /// - `demo-540p`: no real device; 960×540 pixels of a 27" panel's size from 1.1 m, small enough for software
    ///   rendering and fine enough (0.065° per cycle) to show a peripheral threshold.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let (resolution_px, size_mm, distance_mm, refresh_hz, peak_cd_m2) = match name {
            "guenter-2012" => ([1920, 1080], [510.0, 510.0 * 9.0 / 16.0], 590.0, 120.0, None),
            "tursun-2019-27in" => ([2560, 1440], [596.74, 596.74 * 9.0 / 16.0], 665.0, 144.0, Some(214.6)),
            "tursun-2019-32in" => ([3840, 2160], [697.1, 697.1 * 9.0 / 16.0], 710.0, 60.0, Some(199.2)),
            "demo-540p" => ([960, 540], [597.0, 597.0 * 9.0 / 16.0], 1100.0, 60.0, None),
            _ => return None,
        };
        let mut display = Self::new(name, resolution_px, size_mm, distance_mm).ok()?;
        display.refresh_hz = refresh_hz;
        display.peak_cd_m2 = peak_cd_m2;
        Some(display)
    }

    /// The display's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn resolution_px(&self) -> [u32; 2] {
        self.resolution_px
    }

    /// Width and height of the lit area, in millimetres.
    #[must_use]
    pub fn size_mm(&self) -> [f64; 2] {
        self.size_mm
    }

    /// Distance from the eye to the display's centre, in millimetres.
    #[must_use]
    pub fn distance_mm(&self) -> f64 {
        self.distance_mm
    }

    /// Refresh rate in hertz, as declared; a window measures its own.
    #[must_use]
    pub fn refresh_hz(&self) -> f64 {
        self.refresh_hz
    }

    /// Peak luminance in cd/m², where it was measured.
    #[must_use]
    pub fn peak_cd_m2(&self) -> Option<f64> {
        self.peak_cd_m2
    }

    /// How much light each channel gives for what is sent to it.
    #[must_use]
    pub fn transfer(&self) -> &Transfer {
        &self.transfer
    }

    /// Width and height of one pixel, in millimetres.
    #[must_use]
    pub fn pitch_mm(&self) -> [f64; 2] {
        [self.size_mm[0] / f64::from(self.resolution_px[0]), self.size_mm[1] / f64::from(self.resolution_px[1])]
    }

    /// The number of pixels on the display.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        u64::from(self.resolution_px[0]) * u64::from(self.resolution_px[1])
    }

    /// Millimetres from the display's centre (x right, y up) of a place in pixels.
    #[must_use]
    pub fn mm_from_px(&self, px: [f64; 2]) -> [f64; 2] {
        let pitch = self.pitch_mm();
        [
            (px[0] - 0.5 * f64::from(self.resolution_px[0])) * pitch[0],
            (0.5 * f64::from(self.resolution_px[1]) - px[1]) * pitch[1],
        ]
    }

    /// The place in pixels of a point in millimetres from the centre.
    #[must_use]
    pub fn px_from_mm(&self, mm: [f64; 2]) -> [f64; 2] {
        let pitch = self.pitch_mm();
        [
            mm[0] / pitch[0] + 0.5 * f64::from(self.resolution_px[0]),
            0.5 * f64::from(self.resolution_px[1]) - mm[1] / pitch[1],
        ]
    }

    /// Degrees from the display's centre of a point in millimetres.
    #[must_use]
    pub fn deg_from_mm(&self, mm: [f64; 2]) -> [f64; 2] {
        mm.map(|x| (x / self.distance_mm).atan().to_degrees())
    }

    /// The point in millimetres of a place in degrees.
    #[must_use]
    pub fn mm_from_deg(&self, deg: [f64; 2]) -> [f64; 2] {
        deg.map(|x| x.to_radians().tan() * self.distance_mm)
    }

    /// Degrees from the display's centre (x right, y up) of a place in pixels.
    #[must_use]
    pub fn deg_from_px(&self, px: [f64; 2]) -> [f64; 2] {
        self.deg_from_mm(self.mm_from_px(px))
    }

    /// The place in pixels of a place in degrees.
    #[must_use]
    pub fn px_from_deg(&self, deg: [f64; 2]) -> [f64; 2] {
        self.px_from_mm(self.mm_from_deg(deg))
    }

    /// The true angle, in degrees, between the directions from the eye to two places in degrees.
    ///
    /// Computed from the cross product, which stays exact for small angles where the arc cosine would not.
    #[must_use]
    pub fn eccentricity_deg(&self, a_deg: [f64; 2], b_deg: [f64; 2]) -> f64 {
        angle_between_deg(
            self.direction_from_mm(self.mm_from_deg(a_deg)),
            self.direction_from_mm(self.mm_from_deg(b_deg)),
        )
    }

    /// The true angle, in degrees, between the directions from the eye to two places in pixels.
    #[must_use]
    pub fn eccentricity_px_deg(&self, a_px: [f64; 2], b_px: [f64; 2]) -> f64 {
        angle_between_deg(self.direction_from_mm(self.mm_from_px(a_px)), self.direction_from_mm(self.mm_from_px(b_px)))
    }

    /// The vector from the eye to a point on the display, in millimetres: x right, y up, z into the display.
    #[must_use]
    pub fn direction_from_mm(&self, mm: [f64; 2]) -> [f64; 3] {
        [mm[0], mm[1], self.distance_mm]
    }

    /// Half the horizontal and half the vertical field of view, in degrees; the first is Guenter's e* (2012, Eq. 6).
    #[must_use]
    pub fn half_field_deg(&self) -> [f64; 2] {
        self.deg_from_mm(self.size_mm.map(|x| 0.5 * x))
    }

    /// The largest angle of one pixel at a place, in degrees.
    ///
    /// Off the axis a pixel of a flat display shrinks by cos φ across and cos² φ along the direction to the centre; the
    /// larger of the two limits what can be shown there.
    #[must_use]
    pub fn pixel_deg(&self, at_deg: [f64; 2]) -> f64 {
        let mm = self.mm_from_deg(at_deg);
        let slant_mm = self.distance_mm.hypot(mm[0].hypot(mm[1]));
        let pitch = self.pitch_mm();
        (pitch[0].max(pitch[1]) / slant_mm).atan().to_degrees()
    }

    /// The finest MAR, in degrees per cycle, that the display can show at a place: two of its pixels.
    ///
    /// At the centre this is Guenter's omega* (2012, Eq. 7).
    #[must_use]
    pub fn finest_mar_deg(&self, at_deg: [f64; 2]) -> f64 {
        let mm = self.mm_from_deg(at_deg);
        let slant_mm = self.distance_mm.hypot(mm[0].hypot(mm[1]));
        let pitch = self.pitch_mm();
        (2.0 * pitch[0].max(pitch[1]) / slant_mm).atan().to_degrees()
    }

    /// Cycles per pixel of a grating of `cpd` cycles per degree at a place.
    #[must_use]
    pub fn cycles_per_px_from_cpd(&self, cpd: f64, at_deg: [f64; 2]) -> f64 {
        cpd * self.pixel_deg(at_deg)
    }

    /// Cycles per degree of a grating of `cycles_per_px` at a place.
    #[must_use]
    pub fn cpd_from_cycles_per_px(&self, cycles_per_px: f64, at_deg: [f64; 2]) -> f64 {
        cycles_per_px / self.pixel_deg(at_deg)
    }

    /// The share of the circle of directions at `eccentricity_deg` around `gaze_deg` that falls on the display, 0–1.
    ///
    /// One direction a degree of the circle is tried, so the figure is good to about 0.003.
    #[must_use]
    pub fn visible_share(&self, gaze_deg: [f64; 2], eccentricity_deg: f64) -> f64 {
        const STEPS: u32 = 360;
        let gaze = normalised(self.direction_from_mm(self.mm_from_deg(gaze_deg)));
        // An orthonormal frame around the gaze: `right` stays horizontal, so it never degenerates on a display.
        let right = normalised([gaze[2], 0.0, -gaze[0]]);
        let up = cross(gaze, right);
        let (sin_e, cos_e) = eccentricity_deg.to_radians().sin_cos();
        let inside = (0..STEPS)
            .filter(|&step| {
                let (sin_t, cos_t) = (f64::from(step) / f64::from(STEPS) * std::f64::consts::TAU).sin_cos();
                let direction: [f64; 3] =
                    std::array::from_fn(|i| gaze[i] * cos_e + (right[i] * cos_t + up[i] * sin_t) * sin_e);
                direction[2] > 0.0 && {
                    let scale = self.distance_mm / direction[2];
                    (direction[0] * scale).abs() <= 0.5 * self.size_mm[0]
                        && (direction[1] * scale).abs() <= 0.5 * self.size_mm[1]
                }
            })
            .count();
        inside as f64 / f64::from(STEPS)
    }
}

/// The angle between two vectors of any length, in degrees.
#[must_use]
pub fn angle_between_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    length(cross(a, b)).atan2(dot(a, b)).to_degrees()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn normalised(a: [f64; 3]) -> [f64; 3] {
    let length = length(a);
    a.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn displays() -> impl Strategy<Value = Display> {
        ((64u32..8000, 64u32..8000), (50.0..2000.0, 50.0..2000.0), 100.0..3000.0)
            .prop_map(|((w, h), (x, y), d)| Display::new("random", [w, h], [x, y], d).expect("in range"))
    }

    proptest! {
        #[test]
        fn px_mm_deg_and_cpd_round_trip(
            display in displays(),
            u in 0.0..1.0f64,
            v in 0.0..1.0f64,
            cpd in 0.01..100.0f64,
        ) {
            let px = [u * f64::from(display.resolution_px()[0]), v * f64::from(display.resolution_px()[1])];
            let mm = display.mm_from_px(px);
            let deg = display.deg_from_mm(mm);
            let back = display.px_from_deg(deg);
            for axis in 0..2 {
                prop_assert!((display.px_from_mm(mm)[axis] - px[axis]).abs() < 1e-9);
                prop_assert!((display.mm_from_deg(deg)[axis] - mm[axis]).abs() < 1e-9);
                prop_assert!((back[axis] - px[axis]).abs() < 1e-9);
            }
            let there = display.cycles_per_px_from_cpd(cpd, deg);
            prop_assert!((display.cpd_from_cycles_per_px(there, deg) - cpd).abs() < 1e-9 * cpd.max(1.0));
        }

        #[test]
        fn eccentricity_is_symmetric_and_zero_at_itself(display in displays(), x in -20.0..20.0f64, y in -20.0..20.0f64) {
            let (a, b) = ([x, y], [0.3 * y, -0.7 * x]);
            prop_assert!(display.eccentricity_deg(a, a) < 1e-12);
            prop_assert!((display.eccentricity_deg(a, b) - display.eccentricity_deg(b, a)).abs() < 1e-12);
            // From the centre along one axis, the eccentricity is that axis's own angle.
            prop_assert!((display.eccentricity_deg([0.0, 0.0], [x, 0.0]) - x.abs()).abs() < 1e-9);
        }
    }

    /// Guenter 2012, §5: e* = 23.4°, omega* = 0.0516°; READINGS gives the figures to five digits.
    #[test]
    fn guenter_display_has_the_published_figures() {
        let display = Display::named("guenter-2012").expect("ships");
        assert!((display.half_field_deg()[0] - 23.374).abs() < 5e-4);
        assert!((display.finest_mar_deg([0.0, 0.0]) - 0.051_59).abs() < 5e-6);
    }

    /// Tursun 2019, §5.1: 48.3° × 28.3° and 52.3° × 30.9°.
    #[test]
    fn tursun_displays_span_the_published_fields() {
        for (name, field_deg) in [("tursun-2019-27in", [48.3, 28.3]), ("tursun-2019-32in", [52.3, 30.9])] {
            let half = Display::named(name).expect("ships").half_field_deg();
            for axis in 0..2 {
                assert!((2.0 * half[axis] - field_deg[axis]).abs() < 0.05, "{name} {half:?}");
            }
        }
    }

    #[test]
    fn impossible_displays_name_every_field() {
        let errors = Display::new("bad", [0, 1080], [f64::NAN, 300.0], -1.0).expect_err("three faults");
        let fields: Vec<_> = errors.iter().map(|e| e.field).collect();
        assert_eq!(fields, ["resolution_px", "size_mm", "distance_mm"]);
    }

    #[test]
    fn a_circle_leaves_the_display_gradually() {
        let display = Display::named("guenter-2012").expect("ships");
        assert!((display.visible_share([0.0, 0.0], 5.0) - 1.0).abs() < 1e-12);
        let far = display.visible_share([0.0, 0.0], 20.0);
        assert!(far > 0.2 && far < 0.9, "{far}");
        assert!(display.visible_share([0.0, 0.0], 40.0) < 1e-12);
    }

    #[test]
    fn every_shipped_name_exists() {
        assert!(NAMED_DISPLAYS.iter().all(|name| Display::named(name).is_some()));
        assert!(Display::named("no-such-display").is_none());
    }
}
