//! Directions from the eye, true angles between them, and the plane that touches the sphere of directions at one of them.
//!
//! A place in degrees is each axis's own angle on a flat display ([`experiments::Display`]), which fixes the direction
//! without the display's distance. Differences of such coordinates are no angles away from the centre, so every angle,
//! spread and velocity here is taken between directions.

/// A unit vector from the eye: x right, y up, z into the display.
pub(crate) type Direction = [f64; 3];

/// No flat display reaches this far on one axis, degrees; a place beyond is no place.
const MAX_AXIS_DEG: f64 = 89.0;

/// The direction of a place in degrees right and up of the display's centre; `None` for what is no place on a display.
pub(crate) fn direction_from_deg(deg: [f64; 2]) -> Option<Direction> {
    // NaN is in no range.
    deg.iter()
        .all(|axis| (-MAX_AXIS_DEG..=MAX_AXIS_DEG).contains(axis))
        .then(|| normalised([deg[0].to_radians().tan(), deg[1].to_radians().tan(), 1.0]))
}

/// Below this square of a sine or half chord, 5.7°, the series of the arc sine is exact to rounding.
const SMALL: f64 = 0.01;

/// asin(s) / s from s² up to [`SMALL`]; most angles between samples are small, and this costs neither a root nor a call.
fn asin_over_sine(s2: f64) -> f64 {
    const TERMS: [f64; 7] = [
        1.0 / 6.0,
        3.0 / 40.0,
        15.0 / 336.0,
        105.0 / 3456.0,
        945.0 / 42_240.0,
        10_395.0 / 599_040.0,
        135_135.0 / 9_676_800.0,
    ];
    1.0 + s2 * TERMS.iter().rev().fold(0.0, |sum, term| term + s2 * sum)
}

/// The place in degrees of a direction that meets the display.
pub(crate) fn deg_from_direction([x, y, z]: Direction) -> [f64; 2] {
    [x.atan2(z).to_degrees(), y.atan2(z).to_degrees()]
}

/// The angle between two unit vectors, degrees, from the chord between them: exact for small angles, where the arc
/// cosine is not, and cheaper than `experiments::display::angle_between_deg` where millions are wanted.
pub(crate) fn angle_deg(a: Direction, b: Direction) -> f64 {
    let half2 = 0.25 * chord2(a, b);
    let half = half2.sqrt();
    let half_angle = if half2 < SMALL { half * asin_over_sine(half2) } else { half.min(1.0).asin() };
    (2.0 * half_angle).to_degrees()
}

/// The square of [`angle_deg`], without its root.
pub(crate) fn squared_angle_deg2(a: Direction, b: Direction) -> f64 {
    let chord2 = chord2(a, b);
    if 0.25 * chord2 < SMALL {
        let scale = asin_over_sine(0.25 * chord2).to_degrees();
        chord2 * scale * scale
    } else {
        angle_deg(a, b).powi(2)
    }
}

fn chord2(a: Direction, b: Direction) -> f64 {
    dot_self([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}

/// The mean direction of some unit vectors; `None` for none.
pub(crate) fn mean_direction(directions: impl IntoIterator<Item = Direction>) -> Option<Direction> {
    let (mut sum, mut any) = ([0.0; 3], false);
    for direction in directions {
        sum = std::array::from_fn(|i| sum[i] + direction[i]);
        any = true;
    }
    // All lie in front of the display, so they cannot cancel.
    any.then(|| normalised(sum))
}

/// The tangent plane at a direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    at: Direction,
    right: Direction,
    up: Direction,
}

impl Plane {
    /// The plane at `at`; its right axis stays horizontal.
    pub(crate) fn new(at: Direction) -> Self {
        let right = normalised([at[2], 0.0, -at[0]]);
        let [x, y, z] = at;
        let up = [y * right[2] - z * right[1], z * right[0] - x * right[2], x * right[1] - y * right[0]];
        Self { at, right, up }
    }

    /// The step in degrees (right, up) along the great circle from the plane's direction to another; its length is the
    /// true angle between them.
    pub(crate) fn step_deg(&self, to: Direction) -> [f64; 2] {
        let step = [dot(to, self.right), dot(to, self.up)];
        // The length is the sine of the angle.
        let length2 = step[0] * step[0] + step[1] * step[1];
        let scale = if length2 < SMALL && dot(self.at, to) > 0.0 {
            asin_over_sine(length2).to_degrees()
        } else {
            angle_deg(self.at, to) / length2.sqrt().max(f64::MIN_POSITIVE)
        };
        step.map(|x| x * scale)
    }
}

/// The part of a small difference of unit vectors that lies in the plane which touches the sphere at a direction,
/// degrees (right, up): what [`Plane`] has, without setting one up.
pub(crate) fn projected_deg([x, y, z]: Direction, [dx, dy, dz]: [f64; 3]) -> [f64; 2] {
    let flat2 = x * x + z * z;
    let scale = (1.0 / flat2.sqrt()).to_degrees();
    [scale * (z * dx - x * dz), scale * (flat2 * dy - y * (x * dx + z * dz))]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn dot_self(a: [f64; 3]) -> f64 {
    dot(a, a)
}

fn normalised(a: [f64; 3]) -> [f64; 3] {
    let scale = 1.0 / dot_self(a).sqrt();
    a.map(|x| x * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::Display;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn angles_are_the_displays(a in [-60.0..60.0f64, -60.0..60.0], b in [-60.0..60.0f64, -60.0..60.0]) {
            let display = Display::named("guenter-2012").expect("ships");
            let (from, to) = (direction_from_deg(a).expect("a place"), direction_from_deg(b).expect("a place"));
            prop_assert!((angle_deg(from, to) - display.eccentricity_deg(a, b)).abs() < 1e-9);
            let step = Plane::new(from).step_deg(to);
            prop_assert!((step[0].hypot(step[1]) - display.eccentricity_deg(a, b)).abs() < 1e-9);
            let back = deg_from_direction(from);
            prop_assert!((back[0] - a[0]).abs() < 1e-9 && (back[1] - a[1]).abs() < 1e-9);
        }
    }

    proptest! {
        /// Against the arc tangent of `experiments`, over all sizes of angle, small ones above all.
        #[test]
        fn small_angles_are_exact(ln_size in -20.0..4.0f64, turn in 0.0..360.0f64) {
            let from = direction_from_deg([12.0, -7.0]).expect("a place");
            let plane = Plane::new(from);
            let (sin, cos) = turn.to_radians().sin_cos();
            let (sin_size, cos_size) = ln_size.exp().to_radians().sin_cos();
            let to: Direction =
                std::array::from_fn(|i| from[i] * cos_size + (plane.right[i] * cos + plane.up[i] * sin) * sin_size);
            let exact = experiments::display::angle_between_deg(from, to);
            // Rounding of unit vectors is 1e-16 of a radian.
            prop_assert!((angle_deg(from, to) - exact).abs() < 1e-13 + 1e-13 * exact);
            prop_assert!((squared_angle_deg2(from, to).sqrt() - exact).abs() < 1e-13 + 1e-13 * exact);
            let step = plane.step_deg(to);
            prop_assert!((step[0] - ln_size.exp() * cos).abs() < 2e-13 + 1e-13 * exact);
            prop_assert!((step[1] - ln_size.exp() * sin).abs() < 2e-13 + 1e-13 * exact);
            let difference = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
            let projected = projected_deg(from, difference);
            prop_assert!((projected[0] - dot(difference, plane.right).to_degrees()).abs() < 1e-12);
            prop_assert!((projected[1] - dot(difference, plane.up).to_degrees()).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_no_place_has_no_direction() {
        for deg in [[f64::NAN, 0.0], [0.0, f64::INFINITY], [90.0, 0.0], [0.0, -400.0]] {
            assert_eq!(direction_from_deg(deg), None);
        }
        assert_eq!(mean_direction([]), None);
    }
}
