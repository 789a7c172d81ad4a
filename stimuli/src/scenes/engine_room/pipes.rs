//! Pipes with elbows, flanges with bolts, valves with hand wheels, and gauges.

use super::gears::hand_wheel;
use super::stuff::Stuff;
use crate::scenes::parts::Batch;
use crate::scenes::parts::forms::{bent, disc, rod, torus};
use crate::world::MeshLevel;
use crate::world::shapes::{block, lathe, tube, upright};
use glam::{Affine3A, Vec3};
use std::f32::consts::TAU;

/// A pair of flanges about the y axis with bolts through them, for a pipe of `radius_m`.
pub(super) fn flange(radius_m: f32) -> MeshLevel {
    let r = radius_m;
    let (out, half) = (1.55 * r + 0.02, 0.20 * r + 0.012);
    let mut flange = lathe(
        &[
            [r, -1.6 * half],
            [1.15 * r, -1.5 * half],
            [1.15 * r, -half],
            [out, -half],
            [out, -0.08 * half],
            [out - 0.006, 0.0],
            [out, 0.08 * half],
            [out, half],
            [1.15 * r, half],
            [1.15 * r, 1.5 * half],
            [r, 1.6 * half],
        ],
        28,
    );
    let bolts = if r > 0.2 { 12 } else { 8 };
    for i in 0..bolts {
        let (sin, cos) = (i as f32 / bolts as f32 * TAU).sin_cos();
        let at = 1.35 * r * Vec3::new(sin, 0.0, cos);
        flange.append(&rod(at - Vec3::Y * (1.5 * half), at + Vec3::Y * (1.5 * half), 0.09 * r + 0.004, 6));
    }
    flange
}

/// A pipe through `corners` with round elbows and flanges at its ends and about every `every_m` of its straights.
pub(super) fn run(batch: &mut Batch, pipe: usize, joints: usize, corners: &[Vec3], radius_m: f32, every_m: f32) {
    let elbow_m = 2.4 * radius_m;
    batch.add(pipe, &tube(&bent(corners, elbow_m, 8), radius_m, 22));
    let flange = flange(radius_m);
    for pair in corners.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let free = a.distance(b) - 2.0 * elbow_m - 2.0 * radius_m;
        if free < 0.0 {
            continue;
        }
        let along = (b - a).normalize_or(Vec3::Y);
        let count = (free / every_m).floor() as u32 + 1;
        for i in 0..=count {
            let at = a + along * (elbow_m + radius_m + free * i as f32 / count as f32);
            batch.add_at(joints, &flange, upright(at, along));
        }
    }
}

/// A valve on a pipe of `radius_m` at `at` along `along`: its body, bonnet and hand wheel towards `up`.
pub(super) fn valve(batch: &mut Batch, stuff: &Stuff, paint: usize, at: Vec3, along: Vec3, up: Vec3, radius_m: f32) {
    let r = radius_m;
    let body = lathe(
        &[
            [r, -2.2 * r],
            [1.2 * r, -1.5 * r],
            [1.7 * r, -0.5 * r],
            [1.7 * r, 0.5 * r],
            [1.2 * r, 1.5 * r],
            [r, 2.2 * r],
        ],
        24,
    );
    batch.add_at(paint, &body, upright(at, along));
    for side in [-1.0, 1.0] {
        batch.add_at(stuff.steel, &flange(r), upright(at + along * (side * 2.2 * r), along));
    }
    let bonnet = lathe(
        &[
            [1.05 * r, 1.2 * r],
            [1.0 * r, 2.0 * r],
            [1.3 * r, 2.0 * r],
            [1.3 * r, 2.3 * r],
            [0.7 * r, 2.4 * r],
            [0.45 * r, 3.4 * r],
            [0.3 * r, 3.5 * r],
            [0.0, 3.5 * r],
        ],
        20,
    );
    let stand = upright(at, up);
    batch.add_at(paint, &bonnet, stand);
    let wheel = hand_wheel(2.0 * r + 0.04, 2.0 * r);
    batch.add_at(stuff.red, &wheel, stand * Affine3A::from_translation(Vec3::Y * (5.0 * r)));
}

/// A round gauge of `radius_m` that faces `towards`: brass rim, pale dial with marks, and a needle at `share` of its range.
pub(super) fn gauge(batch: &mut Batch, stuff: &Stuff, at: Vec3, towards: Vec3, radius_m: f32, share: f32) {
    let r = radius_m;
    let stand = upright(at, towards);
    batch.add_at(stuff.brass, &lathe(&[[0.0, -0.3 * r], [0.9 * r, -0.3 * r], [r, -0.2 * r], [r, 0.08 * r]], 32), stand);
    batch.add_at(
        stuff.brass,
        &torus(0.97 * r, 0.08 * r, 36, 8),
        stand * Affine3A::from_translation(Vec3::Y * (0.08 * r)),
    );
    batch.add_at(stuff.dial, &disc(0.92 * r, 32), stand * Affine3A::from_translation(Vec3::Y * (0.02 * r)));
    // The face's upper side is the part of its plane that looks up.
    let up = stand.matrix3.inverse() * glam::Vec3A::Y;
    let zero = f32::atan2(up.x, up.z);
    let on_face = |angle: f32, radius: f32, lift: f32| {
        let (sin, cos) = (zero + angle).sin_cos();
        Vec3::new(radius * sin, lift, radius * cos)
    };
    let mut marks = MeshLevel::default();
    for i in 0..=10 {
        let angle = (i as f32 / 10.0 - 0.5) * 4.4;
        marks.append(&rod(on_face(angle, 0.70 * r, 0.03 * r), on_face(angle, 0.84 * r, 0.03 * r), 0.022 * r, 4));
    }
    let angle = (share - 0.5) * 4.4;
    marks.append(&rod(on_face(angle, -0.18 * r, 0.06 * r), on_face(angle, 0.66 * r, 0.06 * r), 0.03 * r, 6));
    batch.add_at(stuff.rubber, &marks, stand);
}

/// Brackets that hold a horizontal pipe to a wall: from `at` on the pipe's middle to the wall at `wall`.
pub(super) fn bracket(batch: &mut Batch, stuff: &Stuff, at: Vec3, wall: Vec3, radius_m: f32) {
    let along = (wall - at).cross(Vec3::Y).normalize_or(Vec3::X);
    batch.add_at(stuff.iron, &lathe(&[[1.12 * radius_m, -0.03], [1.12 * radius_m, 0.03]], 20), upright(at, along));
    batch.add(stuff.iron, &rod(at + (wall - at).normalize_or(Vec3::X) * radius_m, wall, 0.025, 8));
    let plate = block(Vec3::new(-0.08, -0.012, -0.08), Vec3::new(0.08, 0.012, 0.08));
    batch.add_at(stuff.iron, &plate, upright(wall, wall - at));
}
