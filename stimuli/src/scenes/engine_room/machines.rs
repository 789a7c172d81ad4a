//! The large machines: the engine in the middle with its row of cylinders, tanks along one wall, and their details.

use super::pipes::{flange, gauge, run, valve};
use super::stuff::Stuff;
use crate::scenes::parts::Batch;
use crate::scenes::parts::forms::{hanging, rod, torus};
use crate::world::MeshLevel;
use crate::world::shapes::{block, lathe, sphere, upright};
use glam::{Affine3A, Vec3};
use std::f32::consts::TAU;

/// Cylinders of the engine.
const CYLINDERS: u32 = 6;
/// Height of the crankshaft.
pub(super) const SHAFT_Y: f32 = 1.55;

/// Bolts in a ring about the y axis.
fn bolts(radius_m: f32, bolt_m: f32, count: u32) -> MeshLevel {
    let mut ring = MeshLevel::default();
    for i in 0..count {
        let (sin, cos) = (i as f32 / count as f32 * TAU).sin_cos();
        let at = radius_m * Vec3::new(sin, 0.0, cos);
        ring.append(&rod(at, at + Vec3::Y * bolt_m, 0.6 * bolt_m, 6));
    }
    ring
}

/// A block with its upper edges cut off, along x.
fn chamfered(low: Vec3, high: Vec3, cut: f32) -> MeshLevel {
    let mut level = block(low, high.with_y(high.y - cut));
    let (a, b) = (low.with_y(high.y - cut), Vec3::new(high.x, high.y - cut, high.z));
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let uv = [glam::Vec2::ZERO, glam::Vec2::new(high.x - low.x, cut)];
    let (top_a, top_b) = (a.z + cut, b.z - cut);
    level.quad(
        [corner(a.x, a.y, b.z), corner(b.x, a.y, b.z), corner(b.x, high.y, top_b), corner(a.x, high.y, top_b)],
        uv,
    );
    level.quad(
        [corner(b.x, a.y, a.z), corner(a.x, a.y, a.z), corner(a.x, high.y, top_a), corner(b.x, high.y, top_a)],
        uv,
    );
    level.quad(
        [
            corner(a.x, high.y, top_b),
            corner(b.x, high.y, top_b),
            corner(b.x, high.y, top_a),
            corner(a.x, high.y, top_a),
        ],
        uv,
    );
    for (x, flip) in [(b.x, false), (a.x, true)] {
        let corners = [corner(x, a.y, b.z), corner(x, a.y, a.z), corner(x, high.y, top_a), corner(x, high.y, top_b)];
        let [p, q, r, s] = corners;
        level.quad(if flip { [q, p, s, r] } else { corners }, uv);
    }
    level
}

/// The engine along x in the middle of the room.
pub(super) fn engine(batch: &mut Batch, stuff: &Stuff) {
    let half = 4.9;
    // The bed, the crankcase with doors, and the deck.
    batch.add(stuff.iron, &block(Vec3::new(-half - 0.5, 0.0, -1.7), Vec3::new(half + 0.5, 0.35, 1.7)));
    batch.add(stuff.green, &chamfered(Vec3::new(-half, 0.35, -1.35), Vec3::new(half, 2.5, 1.35), 0.35));
    batch.add(stuff.steel, &block(Vec3::new(-half + 0.1, 2.5, -0.8), Vec3::new(half - 0.1, 2.62, 0.8)));
    let spacing = 2.0 * (half - 0.5) / CYLINDERS as f32;
    for i in 0..CYLINDERS {
        let x = (i as f32 + 0.5) * spacing - (half - 0.5);
        for side in [-1.0_f32, 1.0] {
            // An inspection door with bolts and a handle.
            let facing = upright(Vec3::new(x, 1.25, side * 1.35), Vec3::Z * side);
            batch.add_at(stuff.green, &lathe(&[[0.48, 0.0], [0.48, 0.07], [0.44, 0.09], [0.0, 0.11]], 36), facing);
            batch.add_at(stuff.steel, &bolts(0.42, 0.045, 14), facing * Affine3A::from_translation(Vec3::Y * 0.08));
            batch.add_at(stuff.brass, &torus(0.13, 0.022, 24, 8), facing * Affine3A::from_translation(Vec3::Y * 0.14));
        }
        cylinder(batch, stuff, Vec3::new(x, 2.62, 0.0));
        // Exhaust to the header behind, fuel lines before.
        run(
            batch,
            stuff.copper,
            stuff.steel,
            &[Vec3::new(x, 3.45, -0.52), Vec3::new(x, 3.45, -1.15), Vec3::new(x, 3.95, -1.15)],
            0.15,
            3.0,
        );
        let fuel = [Vec3::new(x + 0.18, 4.1, 0.1), Vec3::new(x + 0.18, 4.28, 0.5), Vec3::new(x + 0.18, 2.75, 0.98)];
        batch.add(stuff.chrome, &crate::scenes::parts::forms::pipe(&fuel, 0.025, 0.22, 10));
    }
    // The exhaust header, the rails, and the walkway's lamps of the engine.
    run(
        batch,
        stuff.copper,
        stuff.steel,
        &[Vec3::new(-half, 4.1, -1.15), Vec3::new(half + 0.4, 4.1, -1.15), Vec3::new(half + 0.4, 8.4, -1.15)],
        0.32,
        1.6,
    );
    batch.add_at(stuff.copper, &sphere(0.32, 12), Affine3A::from_translation(Vec3::new(-half, 4.1, -1.15)));
    run(
        batch,
        stuff.chrome,
        stuff.brass,
        &[Vec3::new(-half + 0.2, 2.75, 0.98), Vec3::new(half - 0.2, 2.75, 0.98)],
        0.06,
        1.0,
    );
    run(
        batch,
        stuff.red,
        stuff.steel,
        &[Vec3::new(-half + 0.2, 2.3, 1.5), Vec3::new(half - 0.2, 2.3, 1.5)],
        0.075,
        2.2,
    );
    for i in 0..5 {
        let x = -3.6 + 1.8 * i as f32;
        gauge(batch, stuff, Vec3::new(x, 3.1, 1.06), Vec3::new(0.0, 0.25, 1.0), 0.15, 0.25 + 0.12 * i as f32);
        batch.add(stuff.brass, &rod(Vec3::new(x, 2.75, 0.98), Vec3::new(x, 3.0, 1.02), 0.018, 8));
    }
}

/// One cylinder with its cooling fins, head, bolts and valve springs, on `foot`.
fn cylinder(batch: &mut Batch, stuff: &Stuff, foot: Vec3) {
    let mut fins = Vec::new();
    fins.push([0.50, 0.0]);
    for i in 0..7 {
        let y = 0.10 + 0.085 * i as f32;
        fins.extend([[0.47, y], [0.58, y + 0.008], [0.58, y + 0.028], [0.47, y + 0.036]]);
    }
    fins.push([0.47, 0.72]);
    batch.add_to(stuff.iron, &lathe(&fins, 40), foot);
    let head =
        lathe(&[[0.47, 0.72], [0.60, 0.72], [0.60, 0.86], [0.52, 0.90], [0.50, 1.06], [0.42, 1.12], [0.0, 1.14]], 40);
    batch.add_to(stuff.green, &head, foot);
    batch.add_to(stuff.chrome, &bolts(0.555, 0.07, 12), foot + Vec3::Y * 0.86);
    for (x, z) in [(-0.22, 0.0), (0.22, 0.0)] {
        // A spring: a helix of wire around its stem.
        let at = foot + Vec3::new(x, 1.12, z);
        let helix: Vec<Vec3> = (0..=90)
            .map(|i| i as f32 / 90.0)
            .map(|t| at + Vec3::new(0.085 * (6.0 * TAU * t).cos(), 0.30 * t, 0.085 * (6.0 * TAU * t).sin()))
            .collect();
        batch.add(stuff.steel, &crate::world::shapes::tube(&helix, 0.014, 8));
        batch.add(stuff.chrome, &rod(at, at + Vec3::Y * 0.38, 0.03, 12));
        batch.add(stuff.steel, &rod(at + Vec3::Y * 0.30, at + Vec3::Y * 0.33, 0.11, 20));
    }
    // The rocker over both stems.
    let rocker = block(Vec3::new(-0.30, 1.50, -0.05), Vec3::new(0.30, 1.57, 0.05));
    batch.add_to(stuff.brass, &rocker, foot);
    batch.add_to(stuff.steel, &rod(Vec3::new(0.0, 1.1, -0.02), Vec3::new(0.0, 1.66, -0.02), 0.05, 14), foot);
}

/// Upright tanks along the wall at z = `wall_z`, each with bands of rivets, a gauge glass, a manhole and pipes.
pub(super) fn tanks(batch: &mut Batch, stuff: &Stuff, wall_z: f32) {
    let z = wall_z + 1.75;
    for (i, (x, radius, high, paint)) in [
        (-9.6, 1.25, 5.6, stuff.cream),
        (-6.0, 1.05, 5.0, stuff.copper),
        (-2.7, 1.25, 5.9, stuff.blue),
        (1.0, 1.15, 5.2, stuff.steel),
        (4.5, 1.25, 5.7, stuff.red),
        (8.0, 1.10, 5.2, stuff.copper),
    ]
    .into_iter()
    .enumerate()
    {
        let at = Vec3::new(x, 0.0, z);
        let r: f32 = radius;
        let mut profile = vec![[0.0, 0.5]];
        let dome = |t: f32| {
            [r * (t * 0.5 * std::f32::consts::PI).sin(), 0.45 * r * (1.0 - (t * 0.5 * std::f32::consts::PI).cos())]
        };
        profile.extend((1..=8).map(|k| dome(k as f32 / 8.0)).map(|[x, y]| [x, 0.5 + y]));
        profile.extend((0..8).rev().map(|k| dome(k as f32 / 8.0)).map(|[x, y]| [x, high - y]));
        batch.add_to(paint, &lathe(&profile, 56), at);
        // Bands with rivets, and legs.
        for y in [0.5 + 0.5 * r, 0.5 * high, high - 0.5 * r] {
            let band = lathe(&[[r, -0.09], [r + 0.025, -0.08], [r + 0.025, 0.08], [r, 0.09]], 56);
            batch.add_to(paint, &band, at + Vec3::Y * y);
            for k in 0..40 {
                let out = Vec3::new((k as f32 / 40.0 * TAU).sin(), 0.0, (k as f32 / 40.0 * TAU).cos());
                let rivet = lathe(&[[0.03, 0.0], [0.024, 0.014], [0.0, 0.02]], 6);
                batch.add_at(stuff.steel, &rivet, upright(at + Vec3::Y * y + out * (r + 0.025), out));
            }
        }
        for k in 0..4 {
            let (sin, cos) = ((k as f32 + 0.5) / 4.0 * TAU).sin_cos();
            let foot = at + 0.78 * r * Vec3::new(sin, 0.0, cos);
            batch.add(stuff.iron, &rod(foot, foot + Vec3::Y * 0.95, 0.09, 14));
            batch.add(stuff.iron, &rod(foot, foot + Vec3::Y * 0.05, 0.18, 14));
        }
        // A manhole towards the room, a gauge above it, and a level glass beside it.
        let facing = |y: f32, angle: f32| {
            let out = Vec3::new(angle.sin(), 0.0, angle.cos());
            upright(at + Vec3::Y * y + out * (r - 0.02), out)
        };
        let hole = facing(0.42 * high, 0.0);
        batch.add_at(paint, &lathe(&[[0.36, 0.0], [0.36, 0.14], [0.44, 0.14], [0.44, 0.22], [0.0, 0.25]], 32), hole);
        batch.add_at(stuff.steel, &bolts(0.40, 0.05, 12), hole * Affine3A::from_translation(Vec3::Y * 0.21));
        gauge(batch, stuff, at + Vec3::new(0.0, 0.70 * high, r + 0.16), Vec3::Z, 0.20, 0.2 + 0.13 * i as f32);
        batch.add(
            stuff.brass,
            &rod(at + Vec3::new(0.0, 0.70 * high, r - 0.05), at + Vec3::new(0.0, 0.70 * high, r + 0.1), 0.03, 8),
        );
        let glass_at = |y: f32, out: f32| at + Vec3::new((r + out) * 0.6, y, (r + out) * 0.8);
        batch.add(stuff.brass, &rod(glass_at(0.35 * high, 0.10), glass_at(0.65 * high, 0.10), 0.03, 10));
        for y in [0.35, 0.65] {
            batch.add(stuff.brass, &rod(glass_at(y * high, -0.05), glass_at(y * high, 0.14), 0.035, 10));
        }
        // From the top to the header under the roof, with a valve in every second one.
        let crown = at + Vec3::Y * (high - 0.02);
        let up = [crown, Vec3::new(x, 7.25, z), Vec3::new(x, 7.25, wall_z + 0.75)];
        run(batch, if i % 2 == 0 { stuff.copper } else { stuff.steel }, stuff.steel, &up, 0.13, 4.0);
        if i % 2 == 0 {
            valve(batch, stuff, stuff.green, crown + Vec3::Y * 0.75, Vec3::Y, Vec3::Z, 0.13);
        }
        // From its foot into the trench.
        let down = [at + Vec3::Y * 0.52, at + Vec3::Y * 0.22, at + Vec3::new(0.0, 0.22, 2.2)];
        run(batch, stuff.iron, stuff.steel, &down, 0.09, 4.0);
    }
    run(
        batch,
        stuff.cream,
        stuff.steel,
        &[Vec3::new(-12.6, 7.25, wall_z + 0.75), Vec3::new(12.6, 7.25, wall_z + 0.75)],
        0.24,
        2.4,
    );
}

/// Cables that hang from hook to hook along x.
pub(super) fn cables(batch: &mut Batch, stuff: &Stuff, y: f32, z: f32) {
    for (i, sag) in [0.30, 0.42, 0.36].into_iter().enumerate() {
        let z = z + 0.09 * i as f32;
        for span in 0..8 {
            let x = -12.0 + 3.0 * span as f32;
            let extra = 0.08 * ((span + i) % 3) as f32;
            batch.add(stuff.rubber, &hanging(Vec3::new(x, y, z), Vec3::new(x + 3.0, y, z), sag + extra, 0.028, 8));
        }
    }
    for hook in 0..9 {
        let at = Vec3::new(-12.0 + 3.0 * hook as f32, y, z + 0.09);
        batch.add(stuff.iron, &rod(at, at + Vec3::Y * 0.6, 0.02, 8));
        batch.add_at(stuff.iron, &flange(0.05), upright(at, Vec3::X));
    }
}
