//! What is laid over a picture: where gaze was, where it came from, and rings of equal eccentricity around it, as places in
//! display pixels. Painting them is [`super::ink`]'s and [`super::panel`]'s.

use super::Replay;
use crate::session::tables::FrameRow;
use experiments::Display;

/// How far back the trail goes, seconds.
pub const TRAIL_S: f64 = 0.5;
/// The eccentricities of the rings, degrees, as far as they are on the display.
pub const RINGS_DEG: [f64; 9] = [5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0];
/// A gaze older than this when its frame was presented was lost, seconds.
const LOST_S: f64 = 0.1;
/// Directions in which a ring is followed.
const RING_STEPS: u32 = 240;

/// Which parts are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Parts {
    /// Where gaze was.
    pub gaze: bool,
    /// Where it came from.
    pub trail: bool,
    /// Rings of equal eccentricity.
    pub rings: bool,
}

impl Parts {
    /// Whether nothing is wanted.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }
}

/// A line through places in display pixels.
pub type Line = Vec<[f64; 2]>;

/// Where all directions from the eye make one angle with the gaze.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// The angle, degrees.
    pub eccentricity_deg: f64,
    /// The parts of it that are on the display or close to it.
    pub lines: Vec<Line>,
    /// A place on the display beside which its number can stand, if there is one.
    pub label_px: Option<[f64; 2]>,
}

/// What is laid over one frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Overlay {
    /// Where gaze was when the frame was drawn, display pixels.
    pub gaze_px: Option<[f64; 2]>,
    /// Whether the tracker had lost the eye since.
    pub lost: bool,
    /// Where it came from, oldest first; lines are broken where the eye was lost.
    pub trail: Vec<Line>,
    /// Rings around it.
    pub rings: Vec<Ring>,
}

impl Overlay {
    /// What is laid over a frame.
    #[must_use]
    pub fn of(replay: &Replay, frame: &FrameRow, parts: Parts) -> Self {
        let rows = replay.gaze();
        let row = frame.gaze_row.and_then(|row| usize::try_from(row).ok());
        let Some((row, sample)) = row.and_then(|row| Some((row, rows.get(row)?))) else {
            return Self::default();
        };
        let mut overlay = Self { lost: frame.presented_s - sample.t_s > LOST_S, ..Self::default() };
        if parts.gaze {
            overlay.gaze_px = Some([sample.x_px, sample.y_px]);
        }
        if parts.trail {
            let mut line = Line::new();
            for earlier in rows[..=row].iter().rev().take_while(|earlier| earlier.t_s >= sample.t_s - TRAIL_S) {
                if earlier.valid {
                    line.push([earlier.x_px, earlier.y_px]);
                } else if !line.is_empty() {
                    overlay.trail.push(std::mem::take(&mut line));
                }
            }
            overlay.trail.push(line);
            overlay.trail.iter_mut().for_each(|line| line.reverse());
            overlay.trail.reverse();
            overlay.trail.retain(|line| line.len() > 1);
        }
        if parts.rings {
            let display = replay.display(frame);
            let rings = RINGS_DEG.iter().filter_map(|&deg| ring(display, [sample.x_deg, sample.y_deg], deg));
            overlay.rings = rings.collect();
        }
        overlay
    }
}

/// The ring at an eccentricity around a gaze; nothing if none of it is on the display.
#[must_use]
pub fn ring(display: &Display, gaze_deg: [f64; 2], eccentricity_deg: f64) -> Option<Ring> {
    let ahead = normalised(display.direction_from_mm(display.mm_from_deg(gaze_deg)));
    // Two directions across the gaze; the display's upright is never along it, since the gaze goes into the display.
    let across = normalised(cross([0.0, 1.0, 0.0], ahead));
    let up = cross(ahead, across);
    let (sine, cosine) = eccentricity_deg.to_radians().sin_cos();
    let [width, height] = display.resolution_px().map(f64::from);
    let within = |[x, y]: [f64; 2], margin: f64| {
        (-margin * width..=(1.0 + margin) * width).contains(&x)
            && (-margin * height..=(1.0 + margin) * height).contains(&y)
    };
    let (mut lines, mut line, mut label_px) = (Vec::new(), Line::new(), None);
    for step in 0..=RING_STEPS {
        let turn = std::f64::consts::TAU * f64::from(step) / f64::from(RING_STEPS);
        let (y, x) = turn.sin_cos();
        let towards: [f64; 3] = std::array::from_fn(|i| cosine * ahead[i] + sine * (x * across[i] + y * up[i]));
        // A direction along the display or away from it meets it nowhere.
        let place = (towards[2] > 1e-6).then(|| {
            let reach = display.distance_mm() / towards[2];
            display.px_from_mm([reach * towards[0], reach * towards[1]])
        });
        match place.filter(|place| within(*place, 1.0)) {
            Some(place) => {
                // The number stands where the ring is first met a little above the level of the gaze.
                if label_px.is_none() && step >= RING_STEPS / 12 && within(place, -0.02) {
                    label_px = Some(place);
                }
                line.push(place);
            }
            None if line.is_empty() => {}
            None => lines.push(std::mem::take(&mut line)),
        }
    }
    lines.push(line);
    lines.retain(|line| line.len() > 1);
    let seen = lines.iter().flatten().any(|place| within(*place, 0.0));
    seen.then_some(Ring { eccentricity_deg, lines, label_px })
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn normalised(a: [f64; 3]) -> [f64; 3] {
    let length = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    a.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every place of a ring is at its angle from the gaze, by the display's own cross product, wherever the gaze is.
    #[test]
    fn rings_are_at_true_angles() {
        let display = Display::named("guenter-2012").expect("ships");
        let mut places = 0;
        let mut largest_error_deg: f64 = 0.0;
        for gaze_deg in [[0.0, 0.0], [17.0, -9.0], [-23.0, 13.0]] {
            for eccentricity_deg in RINGS_DEG {
                let Some(ring) = ring(&display, gaze_deg, eccentricity_deg) else { continue };
                for place in ring.lines.iter().flatten() {
                    let at_deg = display.eccentricity_deg(gaze_deg, display.deg_from_px(*place));
                    largest_error_deg = largest_error_deg.max((at_deg - eccentricity_deg).abs());
                    places += 1;
                }
            }
        }
        println!("{places} places, largest error {largest_error_deg:.1e}°");
        assert!(places > 2000 && largest_error_deg < 1e-9, "{places} places, {largest_error_deg}°");
    }

    /// On the axis a ring is a circle of radius d · tan(e): 59 cm · tan 10° = 104.03 mm.
    #[test]
    fn a_ring_on_the_axis_is_a_circle() {
        let display = Display::named("guenter-2012").expect("ships");
        let ring = ring(&display, [0.0, 0.0], 10.0).expect("is on the display");
        assert_eq!(ring.lines.len(), 1);
        for place in &ring.lines[0] {
            let [x, y] = display.mm_from_px(*place);
            assert!((x.hypot(y) - 590.0 * 10f64.to_radians().tan()).abs() < 1e-9);
        }
        let label = ring.label_px.expect("there is room");
        assert!(ring.lines[0].contains(&label));
    }

    #[test]
    fn rings_that_the_display_does_not_reach_are_left_out() {
        // Half a diagonal of this display is 26.3°.
        let display = Display::named("guenter-2012").expect("ships");
        assert!(ring(&display, [0.0, 0.0], 20.0).is_some());
        assert!(ring(&display, [0.0, 0.0], 30.0).is_none());
        assert!(ring(&display, [-20.0, 0.0], 40.0).is_some());
    }
}
