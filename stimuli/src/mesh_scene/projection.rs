//! From the world to a view of the display: the camera's rays pass through the display's own pixels, so that a degree in
//! the world is a degree on the display, whatever its size and distance.

use crate::contract::View;
use crate::world::Pose;
use experiments::display::Display;
use glam::{DMat4, DVec3, DVec4, Vec3};

/// Nearest distance that is drawn, metres.
pub(super) const NEAR_M: f64 = 0.02;

/// The matrix from the world to clip space, for a rectangle of the display. Depth is reversed: 1 at the nearest distance,
/// 0 infinitely far, which keeps the digits of half a world.
pub(super) fn clip_from_world(display: &Display, view: &View, pose: &Pose) -> DMat4 {
    let pitch = display.pitch_mm().map(|x| x / display.distance_mm());
    let centre = display.resolution_px().map(|x| 0.5 * f64::from(x));
    let [left, top] = view.origin_px;
    let [width, height] = view.size_px;
    // A place at (X, Y, Z) before the eye falls on px = centre + (X, −Y) / (Z pitch).
    let projection = DMat4::from_cols(
        DVec4::new(2.0 / (width * pitch[0]), 0.0, 0.0, 0.0),
        DVec4::new(0.0, 2.0 / (height * pitch[1]), 0.0, 0.0),
        DVec4::new(2.0 * (centre[0] - left) / width - 1.0, 1.0 - 2.0 * (centre[1] - top) / height, 0.0, 1.0),
        DVec4::new(0.0, 0.0, NEAR_M, 0.0),
    );
    let axes = [pose.right, pose.up, pose.forward];
    let shift = axes.map(|axis| -axis.dot(pose.eye));
    let camera = DMat4::from_cols(
        DVec4::new(axes[0].x, axes[1].x, axes[2].x, 0.0),
        DVec4::new(axes[0].y, axes[1].y, axes[2].y, 0.0),
        DVec4::new(axes[0].z, axes[1].z, axes[2].z, 0.0),
        DVec4::new(shift[0], shift[1], shift[2], 1.0),
    );
    projection * camera
}

/// The sides of what a view shows: unit normals inwards, with the eye on all but the last plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frustum {
    /// Normal and distance: inside where `normal · place + distance` is not negative.
    planes: [(DVec3, f64); 5],
}

impl Frustum {
    /// What `clip` shows.
    pub(super) fn of(clip: &DMat4) -> Self {
        let row = |i: usize| clip.row(i);
        let plane = |v: DVec4| {
            let normal = v.truncate();
            let length = normal.length().max(f64::MIN_POSITIVE);
            (normal / length, v.w / length)
        };
        let w = row(3);
        Self { planes: [plane(w + row(0)), plane(w - row(0)), plane(w + row(1)), plane(w - row(1)), plane(w)] }
    }

    /// Whether a box from `low` to `high` may be seen.
    pub(super) fn touches(&self, [low, high]: [Vec3; 2]) -> bool {
        self.planes.iter().all(|&(normal, distance)| {
            // The corner furthest inwards.
            let pick = |n: f64, low: f32, high: f32| n * f64::from(if n > 0.0 { high } else { low });
            let reach = pick(normal.x, low.x, high.x) + pick(normal.y, low.y, high.y) + pick(normal.z, low.z, high.z);
            reach + distance >= 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn display() -> Display {
        Display::new("test", [640, 360], [500.0, 290.0], 600.0).expect("in range")
    }

    /// A place in the direction of a pixel falls into the middle of that pixel of whatever view.
    #[test]
    fn places_fall_where_the_display_shows_them() {
        let display = display();
        let pose = Pose::looking(DVec3::new(3.0, 2.0, -1.0), DVec3::new(-4.0, 1.0, 6.0));
        let views =
            [View::full([640, 360]), View { origin_px: [100.25, -3.5], size_px: [200.0, 90.0], target_px: [50, 30] }];
        let mut worst: f64 = 0.0;
        for view in views {
            let clip = clip_from_world(&display, &view, &pose);
            for px in [[320.0, 180.0], [12.5, 300.5], [150.5, 20.5]] {
                let d = display.direction_from_mm(display.mm_from_px(px));
                let [x, y, z] = d.map(|v| v / d[2]);
                let place = pose.eye + 7.0 * (pose.right * x + pose.up * y + pose.forward * z);
                let c = clip * place.extend(1.0);
                let ndc = c.truncate() / c.w;
                let found = [0, 1].map(|axis| {
                    let share = if axis == 0 { 0.5 * (ndc.x + 1.0) } else { 0.5 * (1.0 - ndc.y) };
                    view.origin_px[axis] + share * view.size_px[axis]
                });
                worst = worst.max((found[0] - px[0]).abs()).max((found[1] - px[1]).abs());
                assert!((ndc.z - NEAR_M / 7.0).abs() < 1e-12, "depth {}", ndc.z);
            }
        }
        println!("largest departure {worst:.1e} px");
        assert!(worst < 1e-9);
    }

    #[test]
    fn boxes_outside_are_left_out() {
        let display = display();
        let pose = Pose::looking(DVec3::ZERO, DVec3::NEG_Z);
        let frustum = Frustum::of(&clip_from_world(&display, &View::full([640, 360]), &pose));
        let cube = |x: f32, y: f32, z: f32| [Vec3::new(x, y, z) - 0.5, Vec3::new(x, y, z) + 0.5];
        assert!(frustum.touches(cube(0.0, 0.0, -5.0)));
        assert!(frustum.touches(cube(0.0, 0.0, 0.0)));
        assert!(!frustum.touches(cube(0.0, 0.0, 5.0)));
        assert!(!frustum.touches(cube(20.0, 0.0, -5.0)));
        assert!(!frustum.touches(cube(0.0, -20.0, -5.0)));
    }
}
