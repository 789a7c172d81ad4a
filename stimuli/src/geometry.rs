//! Display geometry as the shaders need it, and the places where a cone around the gaze cuts the display.
//!
//! The cones give exact bounding boxes and pixel counts without touching every pixel; the angles themselves are those of
//! [`experiments::display::Display`].

use experiments::display::Display;

/// WGSL that every shader of the crate begins with.
pub(crate) const GEOMETRY_WGSL: &str = include_str!("geometry.wgsl");

/// `Geometry` of `geometry.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct GeometryUniform {
    centre_px: [f32; 2],
    pitch_per_distance: [f32; 2],
    gaze: [f32; 3],
    reserved: f32,
}

impl GeometryUniform {
    /// The geometry of `display` with the eye turned to `gaze_deg`.
    pub(crate) fn new(display: &Display, gaze_deg: [f64; 2]) -> Self {
        let pitch = display.pitch_mm();
        Self {
            centre_px: display.resolution_px().map(|x| (0.5 * f64::from(x)) as f32),
            pitch_per_distance: pitch.map(|x| (x / display.distance_mm()) as f32),
            gaze: gaze_direction(display, gaze_deg).map(|x| x as f32),
            reserved: 0.0,
        }
    }
}

/// Gaze beyond this angle from the display's axis counts as this far out, so that it always meets the display's plane.
const FARTHEST_GAZE_DEG: f64 = 89.0;

/// Unit vector from the eye towards a place in degrees: x right, y up, z into the display.
#[must_use]
pub fn gaze_direction(display: &Display, gaze_deg: [f64; 2]) -> [f64; 3] {
    let clamped = gaze_deg.map(|x| x.clamp(-FARTHEST_GAZE_DEG, FARTHEST_GAZE_DEG));
    let v = display.direction_from_mm(display.mm_from_deg(clamped));
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / length)
}

/// A box of whole display pixels: `left..right` by `top..bottom`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelBox {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// One past the last column.
    pub right: u32,
    /// One past the last row.
    pub bottom: u32,
}

impl PixelBox {
    /// Width and height.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.right - self.left, self.bottom - self.top]
    }
}

/// Rows of the bands of [`Cone::boxes_around`]: few enough to follow a curve, enough for a draw to pay.
const BAND_ROWS: u32 = 8;

/// All directions within an angle of the gaze, as they meet a display.
#[derive(Debug, Clone, Copy)]
pub struct Cone {
    gaze: [f64; 3],
    cos: f64,
    centre_px: [f64; 2],
    /// Pixel pitch over viewing distance.
    pitch: [f64; 2],
    resolution_px: [u32; 2],
}

impl Cone {
    /// The directions within `radius_deg` (0–90°) of `gaze_deg`.
    #[must_use]
    pub fn new(display: &Display, gaze_deg: [f64; 2], radius_deg: f64) -> Self {
        let pitch = display.pitch_mm();
        Self {
            gaze: gaze_direction(display, gaze_deg),
            cos: radius_deg.clamp(0.0, 90.0).to_radians().cos(),
            centre_px: display.resolution_px().map(|x| 0.5 * f64::from(x)),
            pitch: pitch.map(|x| x / display.distance_mm()),
            resolution_px: display.resolution_px(),
        }
    }

    /// Every direction that meets a display.
    #[must_use]
    pub fn everything(display: &Display) -> Self {
        Self { gaze: [0.0, 0.0, 1.0], cos: -1.0, ..Self::new(display, [0.0; 2], 0.0) }
    }

    /// The columns of row `row` whose pixel centres lie inside, as `first..end`; empty when there are none.
    ///
    /// Along a row the direction turns in a plane through the eye. With ψ the angle from that plane's shortest line to
    /// the row, the angle to the gaze is smallest at ψ0, so the row is inside for |ψ − ψ0| ≤ δ: one span.
    #[must_use]
    pub fn row_span(&self, row: u32) -> std::ops::Range<u32> {
        let y = (self.centre_px[1] - (f64::from(row) + 0.5)) * self.pitch[1];
        let h = y.hypot(1.0);
        let along = self.gaze[0];
        let towards = (self.gaze[1] * y + self.gaze[2]) / h;
        let reach = along.hypot(towards);
        if reach <= 0.0 || self.cos > reach {
            return 0..0;
        }
        let psi0 = along.atan2(towards);
        let delta = (self.cos / reach).clamp(-1.0, 1.0).acos();
        // The column of an angle; at ±90° and beyond the row never gets there.
        let column = |psi: f64| {
            if psi <= -std::f64::consts::FRAC_PI_2 {
                f64::NEG_INFINITY
            } else if psi >= std::f64::consts::FRAC_PI_2 {
                f64::INFINITY
            } else {
                h * psi.tan() / self.pitch[0] + self.centre_px[0] - 0.5
            }
        };
        let width = f64::from(self.resolution_px[0]);
        let first = column(psi0 - delta).ceil().clamp(0.0, width) as u32;
        let end = (column(psi0 + delta).floor() + 1.0).clamp(0.0, width) as u32;
        first..end.max(first)
    }

    /// How many display pixels have their centres inside.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        (0..self.resolution_px[1])
            .map(|row| {
                u64::from({
                    let span = self.row_span(row);
                    span.end - span.start
                })
            })
            .sum()
    }

    /// Boxes of display pixels that hold every pixel inside this cone but not inside `hole`, and as little else as bands of
    /// a few rows allow. They do not overlap, and reach a pixel further than the cones, for those who compute with less
    /// precision.
    #[must_use]
    pub fn boxes_around(&self, hole: Option<&Self>) -> Vec<PixelBox> {
        let [width, height] = self.resolution_px;
        let mut boxes = Vec::new();
        for top in (0..height).step_by(BAND_ROWS as usize) {
            let bottom = (top + BAND_ROWS).min(height);
            let rows = top.saturating_sub(1)..(bottom + 1).min(height);

            // What any row needs, and what no row needs.
            let needed = rows.clone().map(|row| self.row_span(row)).filter(|span| !span.is_empty());
            let Some(needed) = needed.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)) else { continue };
            let (left, right) = (needed.start.saturating_sub(1), (needed.end + 1).min(width));
            let spare = hole.and_then(|hole| {
                rows.map(|row| hole.row_span(row)).reduce(|a, b| a.start.max(b.start)..a.end.min(b.end))
            });
            match spare.map(|spare| spare.start + 1..spare.end.saturating_sub(1)).filter(|spare| !spare.is_empty()) {
                Some(spare) => {
                    boxes.push(PixelBox { left, top, right: spare.start, bottom });
                    boxes.push(PixelBox { left: spare.end, top, right, bottom });
                }
                None => boxes.push(PixelBox { left, top, right, bottom }),
            }
        }
        boxes.retain(|area| area.left < area.right);
        boxes
    }

    /// The smallest box of display pixels that holds every centre inside; `None` when there is none.
    #[must_use]
    pub fn bounds(&self) -> Option<PixelBox> {
        let mut bounds: Option<PixelBox> = None;
        for row in 0..self.resolution_px[1] {
            let span = self.row_span(row);
            if !span.is_empty() {
                let found =
                    bounds.get_or_insert(PixelBox { left: span.start, top: row, right: span.end, bottom: row + 1 });
                found.left = found.left.min(span.start);
                found.right = found.right.max(span.end);
                found.bottom = row + 1;
            }
        }
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the display's own angles, pixel by pixel, for gazes on and off the display.
    #[test]
    fn cones_count_what_the_angles_say() {
        let display = Display::new("test", [97, 61], [500.0, 300.0], 320.0).expect("in range");
        for gaze_deg in [[0.0, 0.0], [20.0, -11.0], [-37.0, 24.0], [55.0, 5.0], [-80.0, 70.0]] {
            for radius_deg in [0.0, 3.0, 17.0, 44.0, 75.0, 90.0] {
                let cone = Cone::new(&display, gaze_deg, radius_deg);
                let mut expected = (0, None::<PixelBox>);
                for row in 0..61 {
                    for column in 0..97 {
                        let px = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                        let e = display.eccentricity_deg(gaze_deg, display.deg_from_px(px));
                        if e <= radius_deg {
                            expected.0 += 1;
                            let found =
                                expected.1.get_or_insert(PixelBox { left: column, top: row, right: 0, bottom: 0 });
                            found.left = found.left.min(column);
                            found.right = found.right.max(column + 1);
                            found.bottom = row + 1;
                        }
                    }
                }
                assert_eq!((cone.pixels(), cone.bounds()), expected, "{gaze_deg:?} {radius_deg}");
            }
        }
    }

    /// Every pixel between two cones is in exactly one box, the boxes stay on the display and hold little else.
    #[test]
    fn boxes_cover_a_ring_once() {
        let display = Display::new("test", [397, 261], [500.0, 330.0], 420.0).expect("in range");
        for gaze_deg in [[0.0, 0.0], [20.0, -11.0], [-37.0, 24.0], [55.0, 5.0], [-80.0, 70.0]] {
            for (outer_deg, hole_deg) in [(3.0, 0.0), (17.0, 12.0), (30.0, 28.0), (75.0, 40.0), (90.0, 1.0)] {
                let outer = Cone::new(&display, gaze_deg, outer_deg);
                let hole = (hole_deg > 0.0).then(|| Cone::new(&display, gaze_deg, hole_deg));
                let mut covered = vec![0_u32; display.pixels() as usize];
                for area in outer.boxes_around(hole.as_ref()) {
                    for row in area.top..area.bottom {
                        for column in area.left..area.right {
                            covered[(row * 397 + column) as usize] += 1;
                        }
                    }
                }
                let mut inside = 0;
                for row in 0..261 {
                    let (span, spare) = (outer.row_span(row), hole.as_ref().map_or(0..0, |hole| hole.row_span(row)));
                    for column in span.filter(|column| !spare.contains(column)) {
                        assert_eq!(
                            covered[(row * 397 + column) as usize],
                            1,
                            "{gaze_deg:?} {outer_deg}: {column} {row}"
                        );
                        inside += 1;
                    }
                }
                assert!(covered.iter().all(|&times| times <= 1));
                let launched: u32 = covered.iter().sum();
                println!("{gaze_deg:?} {hole_deg}°–{outer_deg}°: {launched} launched for {inside}");
            }
        }
    }
}
