//! Wheels that turn: spur gears that mesh, a flywheel, and fans.

use crate::scenes::parts::forms::{circle, plate, rod, torus};
use crate::world::shapes::{block, lathe};
use crate::world::{MeshLevel, Motion};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Pitch diameter for each tooth, metres: all gears here fit each other.
const MODULE: f32 = 0.075;

/// A gear's place in the plane of x and y, and how it is turned.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gear {
    pub(super) teeth: u32,
    pub(super) at: Vec2,
    /// Angle of a tooth's middle at the start, radians.
    pub(super) phase: f32,
    pub(super) speed_deg_s: f64,
}

impl Gear {
    /// Radius of the circles that roll on each other.
    pub(super) fn radius_m(&self) -> f32 {
        0.5 * MODULE * self.teeth as f32
    }

    /// A gear of `teeth` that this one drives, in the direction of `angle` radians from it: a tooth of one meets a gap of
    /// the other, and the rims are equally fast.
    pub(super) fn driving(&self, teeth: u32, angle: f32) -> Self {
        let mut driven = Self {
            teeth,
            at: Vec2::ZERO,
            phase: 0.0,
            speed_deg_s: -self.speed_deg_s * f64::from(self.teeth) / f64::from(teeth),
        };
        driven.at = self.at + Vec2::from_angle(angle) * (self.radius_m() + driven.radius_m());
        // How far through its period the driving gear is where they touch.
        let through = (angle - self.phase) * self.teeth as f32 / TAU;
        driven.phase = angle + PI - (0.5 - through) * TAU / teeth as f32;
        driven
    }

    /// How it stands and turns in the frame `within`.
    pub(super) fn motion(&self, within: Affine3A) -> Motion {
        let at = within * Affine3A::from_rotation_translation(Quat::from_rotation_z(self.phase), self.at.extend(0.0));
        Motion::Spin { at, axis: Vec3::Z, speed_deg_s: self.speed_deg_s }
    }

    /// The wheel about the z axis with a tooth towards +x: a toothed rim, a thinner web with holes between spokes, a hub
    /// and a piece of its shaft.
    pub(super) fn wheel(&self, half_m: f32) -> MeshLevel {
        let pitch = self.radius_m();
        let (tip, root) = (pitch + 0.95 * MODULE, pitch - 1.15 * MODULE);
        // Trapezes, half a period wide on the pitch circle.
        let profile = [(-0.36, root), (-0.14, tip), (0.14, tip), (0.36, root)];
        let corner = |tooth: u32, along: f32, radius: f32| {
            Vec2::from_angle((tooth as f32 + along) * TAU / self.teeth as f32) * radius
        };
        let outer: Vec<Vec2> =
            (0..self.teeth).flat_map(|t| profile.map(|(along, radius)| corner(t, along, radius))).collect();
        let inside = (root - 0.16).max(0.12);
        let inner: Vec<Vec2> =
            (0..self.teeth).flat_map(|t| profile.map(|(along, _)| corner(t, along, inside))).collect();
        let mut wheel = plate(&outer, &inner, half_m);
        let hub = (0.24 * pitch).max(0.10);
        wheel.append(&plate(&circle(hub, 32), &[Vec2::ZERO; 32], 1.35 * half_m));
        wheel.append(&plate(&circle(0.45 * hub, 20), &[Vec2::ZERO; 20], 2.4 * half_m));
        let spokes = if pitch > 0.6 { 6 } else { 4 };
        for i in 0..spokes {
            let turn = Affine3A::from_rotation_z(i as f32 * TAU / spokes as f32);
            let (low, high) = (0.8 * hub, 0.5 * (inside + root));
            let spoke = block(
                Vec3::new(low, -0.16 * hub - 0.03, -0.6 * half_m),
                Vec3::new(high, 0.16 * hub + 0.03, 0.6 * half_m),
            );
            wheel.append(&spoke.transformed(turn));
        }
        wheel
    }
}

/// A flywheel about the z axis.
pub(super) fn flywheel(radius_m: f32) -> MeshLevel {
    let turn = Affine3A::from_rotation_x(FRAC_PI_2);
    let (low, high) = (radius_m - 0.22, radius_m);
    let rim = [
        [low, -0.16],
        [high, -0.16],
        [high + 0.03, -0.10],
        [high + 0.03, 0.10],
        [high, 0.16],
        [low, 0.16],
        [low, -0.16],
    ];
    let mut wheel = lathe(&rim, 72);
    wheel.append(&lathe(&[[0.0, -0.24], [0.24, -0.24], [0.28, -0.18], [0.28, 0.18], [0.24, 0.24], [0.0, 0.24]], 32));
    for i in 0..8 {
        let (sin, cos) = (i as f32 / 8.0 * TAU).sin_cos();
        let at = |radius: f32| Vec3::new(radius * sin, 0.0, radius * cos);
        wheel.append(&rod(at(0.2), at(low + 0.03), 0.055, 12));
    }
    wheel.transformed(turn)
}

/// A fan about the z axis: twisted blades on a hub.
pub(super) fn fan(radius_m: f32) -> MeshLevel {
    let mut fan = plate(&circle(0.2 * radius_m, 28), &[Vec2::ZERO; 28], 0.10);
    for i in 0..6 {
        let turn = Affine3A::from_rotation_z(i as f32 / 6.0 * TAU);
        let mut blade = MeshLevel::default();
        let edge = |t: f32, side: f32| {
            let radius = radius_m * (0.15 + 0.82 * t);
            let half = radius_m * (0.13 + 0.14 * t);
            let twist = 0.9 - 0.45 * t;
            Vec3::new(radius, side * half * twist.cos(), side * half * twist.sin())
        };
        for step in 0..6 {
            let (t, next) = (step as f32 / 6.0, (step + 1) as f32 / 6.0);
            let corners = [edge(t, -1.0), edge(next, -1.0), edge(next, 1.0), edge(t, 1.0)];
            blade.quad(corners, [Vec2::ZERO, Vec2::ONE]);
            let [a, b, c, d] = corners;
            blade.quad([d, c, b, a], [Vec2::ZERO, Vec2::ONE]);
        }
        fan.append(&blade.transformed(turn));
    }
    fan
}

/// A hand wheel about the y axis on a stem that reaches down from it.
pub(super) fn hand_wheel(radius_m: f32, stem_m: f32) -> MeshLevel {
    let mut wheel = torus(radius_m, 0.09 * radius_m, 32, 8);
    for i in 0..5 {
        let (sin, cos) = (i as f32 / 5.0 * TAU).sin_cos();
        let rim = Vec3::new(radius_m * sin, 0.0, radius_m * cos);
        wheel.append(&rod(Vec3::Y * (-0.18 * radius_m), rim, 0.055 * radius_m, 8));
    }
    wheel.append(&lathe(
        &[[0.16 * radius_m, -0.3 * radius_m], [0.16 * radius_m, 0.06 * radius_m], [0.0, 0.1 * radius_m]],
        12,
    ));
    wheel.append(&rod(Vec3::Y * -stem_m, Vec3::ZERO, 0.08 * radius_m, 10));
    wheel
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where two gears touch, the middle of a tooth meets the middle of a gap at every time.
    #[test]
    fn teeth_meet_gaps() {
        let first = Gear { teeth: 31, at: Vec2::new(0.3, -0.2), phase: 0.7, speed_deg_s: 24.0 };
        for (teeth, angle) in [(17, 0.4), (40, 2.9), (23, -1.2)] {
            let second = first.driving(teeth, angle);
            assert!((second.at.distance(first.at) - first.radius_m() - second.radius_m()).abs() < 1e-6);
            for i in 0..50 {
                let time_s = f64::from(i) * 0.37;
                let through = |gear: &Gear, direction: f32| {
                    let phase = f64::from(gear.phase) + (gear.speed_deg_s * time_s).to_radians();
                    (f64::from(direction) - phase) * f64::from(gear.teeth) / f64::from(TAU)
                };
                let sum = through(&first, angle) + through(&second, angle + PI);
                let off = (sum - 0.5 - (sum - 0.5).round()).abs();
                assert!(off < 1e-3, "{teeth} teeth after {time_s} s: {off}");
            }
        }
    }
}
