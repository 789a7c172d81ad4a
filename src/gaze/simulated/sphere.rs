//! Directions from the eye and small steps between them, as true angles.
//!
//! A step is an angle along a great circle, given by its right and upward parts in the plane that touches the sphere of
//! directions. So a microsaccade of 0.3° is 0.3° anywhere on the display, which adding to axis angles would not give.

use experiments::Display;

/// A unit vector from the eye: x right, y up, z into the display.
pub(super) type Direction = [f64; 3];

/// The largest angle on either axis that a simulated eye looks away from the display's centre, in degrees.
const MAX_AXIS_DEG: f64 = 80.0;

/// The direction of a place in degrees, kept in front of the eye.
pub(super) fn direction_from_deg(display: &Display, deg: [f64; 2]) -> Direction {
    let deg = deg.map(|x| x.clamp(-MAX_AXIS_DEG, MAX_AXIS_DEG));
    normalised(display.direction_from_mm(display.mm_from_deg(deg)))
}

/// Where a direction meets the display's plane, in pixels.
pub(super) fn px_from_direction(display: &Display, direction: Direction) -> [f64; 2] {
    // Noise on a gaze at the limit of the range could point along the plane; the floor keeps the place finite.
    let scale = display.distance_mm() / direction[2].max(0.05);
    display.px_from_mm([direction[0] * scale, direction[1] * scale])
}

/// The direction after a step of `step_deg` (right, up) from `from`.
pub(super) fn stepped(from: Direction, step_deg: [f64; 2]) -> Direction {
    let angle_deg = step_deg[0].hypot(step_deg[1]);
    if angle_deg <= 0.0 {
        return from;
    }
    let (right, up) = frame(from);
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    normalised(std::array::from_fn(|i| {
        from[i] * cos + (right[i] * step_deg[0] + up[i] * step_deg[1]) / angle_deg * sin
    }))
}

/// The step in degrees (right, up) that leads from one direction to another; the inverse of [`stepped`].
pub(super) fn step_deg(from: Direction, to: Direction) -> [f64; 2] {
    let angle_deg = experiments::display::angle_between_deg(from, to);
    let (right, up) = frame(from);
    let step = [dot(to, right), dot(to, up)];
    let length = step[0].hypot(step[1]);
    if length <= 0.0 {
        return [0.0, 0.0];
    }
    step.map(|x| x / length * angle_deg)
}

/// Unit vectors to the right of and above a direction; the first stays horizontal.
fn frame(direction: Direction) -> ([f64; 3], [f64; 3]) {
    let right = normalised([direction[2], 0.0, -direction[0]]);
    let [x, y, z] = direction;
    let up = [y * right[2] - z * right[1], z * right[0] - x * right[2], x * right[1] - y * right[0]];
    (right, up)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn normalised(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::display::angle_between_deg;

    #[test]
    fn steps_are_true_angles_and_invert() {
        let display = Display::named("guenter-2012").expect("ships");
        for at_deg in [[0.0, 0.0], [20.0, -12.0], [-23.0, 13.0]] {
            let from = direction_from_deg(&display, at_deg);
            for step in [[0.3, 0.0], [0.0, -0.3], [-7.0, 4.0]] {
                let to = stepped(from, step);
                assert!((angle_between_deg(from, to) - step[0].hypot(step[1])).abs() < 1e-12);
                let back = step_deg(from, to);
                assert!((back[0] - step[0]).hypot(back[1] - step[1]) < 1e-12);
            }
        }
    }

    #[test]
    fn directions_agree_with_the_display() {
        let display = Display::named("guenter-2012").expect("ships");
        let px = px_from_direction(&display, direction_from_deg(&display, [5.0, 3.0]));
        let expected = display.px_from_deg([5.0, 3.0]);
        assert!((px[0] - expected[0]).hypot(px[1] - expected[1]) < 1e-9);
        let up = stepped(direction_from_deg(&display, [0.0, 0.0]), [0.0, 1.0]);
        assert!(px_from_direction(&display, up)[1] < 540.0, "up on the display is a smaller row");
    }
}
