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

/// The place in degrees of a direction that meets the display.
pub(crate) fn deg_from_direction([x, y, z]: Direction) -> [f64; 2] {
    [x.atan2(z).to_degrees(), y.atan2(z).to_degrees()]
}

/// The angle between two unit vectors, degrees, from the chord between them: exact for small angles, where the arc
/// cosine is not, and cheaper than `experiments::display::angle_between_deg` where millions are wanted.
pub(crate) fn angle_deg(a: Direction, b: Direction) -> f64 {
    let chord = dot_self(std::array::from_fn(|i| a[i] - b[i])).sqrt();
    2.0 * (0.5 * chord).min(1.0).asin().to_degrees()
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
        let length = step[0].hypot(step[1]);
        if length <= 0.0 {
            return [0.0, 0.0];
        }
        let scale = angle_deg(self.at, to) / length;
        step.map(|x| x * scale)
    }

    /// The part of a small difference of unit vectors that lies in the plane, degrees (right, up).
    pub(crate) fn projected_deg(&self, difference: [f64; 3]) -> [f64; 2] {
        [dot(difference, self.right).to_degrees(), dot(difference, self.up).to_degrees()]
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn dot_self(a: [f64; 3]) -> f64 {
    dot(a, a)
}

fn normalised(a: [f64; 3]) -> [f64; 3] {
    let length = dot_self(a).sqrt();
    a.map(|x| x / length)
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

    #[test]
    fn what_is_no_place_has_no_direction() {
        for deg in [[f64::NAN, 0.0], [0.0, f64::INFINITY], [90.0, 0.0], [0.0, -400.0]] {
            assert_eq!(direction_from_deg(deg), None);
        }
        assert_eq!(mean_direction([]), None);
    }
}
