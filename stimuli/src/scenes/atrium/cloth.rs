//! Hanging cloth: banners that fall from a rail in folds, and long sails across the court that sag under their weight.

use crate::scenes::parts::forms::lattice;
use crate::scenes::parts::noise::noise;
use crate::world::MeshLevel;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A banner in the plane of x and y, `width_m` wide, that hangs from y = 0 down by `drop_m`; its folds are shallow at the
/// rail, deeper below, and no two alike.
pub(super) fn banner(width_m: f32, drop_m: f32, folds: f32, seed: u32) -> MeshLevel {
    let (columns, rows) = (56, 40);
    let place = |i: i32, j: i32| {
        let (u, v) = (i as f32 / columns as f32, j as f32 / rows as f32);
        let down = 1.0 - v;
        let wander = 0.8 * noise(Vec3::new(2.5 * u, 1.7 * down, 0.0), seed);
        let deep = 0.03 + 0.12 * down.max(0.0).powf(0.7);
        let z = deep * (TAU * folds * u + wander * 2.0).sin() + 0.10 * noise(Vec3::new(1.2 * u, 2.0 * down, 3.0), seed);
        // It narrows where it is drawn into folds, and its lower edge is not quite straight.
        let x = (u - 0.5) * width_m * (1.0 - 0.10 * (PI * down).sin());
        let hem = 0.05 * down * (TAU * folds * u).cos();
        Vec3::new(x, -down * drop_m + hem, z)
    };
    lattice(columns, rows, place, |i, j| {
        Vec2::new(width_m * i as f32 / columns as f32, drop_m * (1.0 - j as f32 / rows as f32))
    })
}

/// A sail between two rails along z at x = ±`span_m`/2, `width_m` wide: it sags by `sag_m` in the middle, with ripples
/// along it. Seen from above.
pub(super) fn sail(span_m: f32, width_m: f32, sag_m: f32, seed: u32) -> MeshLevel {
    let (columns, rows) = (64, 24);
    let place = |i: i32, j: i32| {
        let (u, v) = (i as f32 / columns as f32, j as f32 / rows as f32);
        let hang = 4.0 * u * (1.0 - u);
        let ripple = 0.09 * (5.0 * PI * v + 2.0 * noise(Vec3::new(3.0 * u, 0.0, 0.0), seed)).sin() * (0.25 + hang);
        let x = (u - 0.5) * span_m;
        // Its free edges draw in where it sags.
        let z = (0.5 - v) * width_m * (1.0 - 0.16 * hang);
        let billow = 0.25 * noise(Vec3::new(2.0 * u, 1.5 * v, 1.0), seed) * hang;
        Vec3::new(x, -sag_m * hang + ripple + billow, z)
    };
    lattice(columns, rows, place, |i, j| {
        Vec2::new(span_m * i as f32 / columns as f32, width_m * (1.0 - j as f32 / rows as f32))
    })
}
