//! What stands and hangs in the atrium beside its masonry: the fountain, pots with agaves, and lamps.

use crate::scenes::parts::forms::{disc, rod, torus};
use crate::scenes::parts::noise::hash;
use crate::world::shapes::{lathe, sphere};
use crate::world::{MeshLevel, Vertex};
use glam::{Affine3A, IVec3, Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// A fountain about the y axis: stone, and the water in its two bowls.
pub(super) fn fountain() -> (MeshLevel, MeshLevel) {
    let mut stone = lathe(
        &[
            [0.0, 0.0],
            [2.1, 0.0],
            [2.1, 0.16],
            [1.86, 0.16],
            [1.80, 0.30],
            [1.84, 0.42],
            [1.98, 0.50],
            [2.0, 0.60],
            [1.72, 0.60],
            [1.66, 0.54],
            [1.66, 0.20],
            [0.0, 0.20],
        ],
        48,
    );
    stone.append(&lathe(
        &[
            [0.42, 0.20],
            [0.42, 0.34],
            [0.26, 0.44],
            [0.20, 0.62],
            [0.24, 0.90],
            [0.20, 1.08],
            [0.30, 1.16],
            [0.62, 1.26],
            [0.86, 1.44],
            [0.90, 1.52],
            [0.82, 1.52],
            [0.56, 1.36],
            [0.14, 1.34],
            [0.10, 1.52],
            [0.16, 1.66],
            [0.10, 1.80],
            [0.0, 1.92],
        ],
        40,
    ));
    let mut water = disc(1.67, 48).transformed(Affine3A::from_translation(Vec3::Y * 0.50));
    water.append(&disc(0.80, 40).transformed(Affine3A::from_translation(Vec3::Y * 1.48)));
    (stone, water)
}

/// A pot, and the agave that grows in it: blades in a golden spiral, the inner ones steeper.
pub(super) fn agave(seed: u32) -> (MeshLevel, MeshLevel) {
    let pot = lathe(
        &[
            [0.0, 0.0],
            [0.30, 0.0],
            [0.32, 0.05],
            [0.26, 0.09],
            [0.38, 0.28],
            [0.46, 0.52],
            [0.43, 0.66],
            [0.50, 0.70],
            [0.50, 0.76],
            [0.40, 0.76],
            [0.38, 0.68],
            [0.0, 0.68],
        ],
        28,
    );
    let mut plant = MeshLevel::default();
    const BLADES: i32 = 34;
    for i in 0..BLADES {
        let inner = i as f32 / BLADES as f32;
        let turn = Quat::from_rotation_y(i as f32 * 0.381_966 * TAU);
        let random = hash(IVec3::new(i, 0, 0), seed);
        let (long, steep) = (0.95 - 0.25 * inner + 0.2 * random, 0.35 + 1.05 * inner);
        plant.append(&blade(long, steep).transformed(Affine3A::from_rotation_translation(turn, Vec3::Y * 0.66)));
    }
    (pot, plant)
}

/// A pointed leaf that rises towards +x at `steep` radians and bends over.
fn blade(long_m: f32, steep: f32) -> MeshLevel {
    const STEPS: u32 = 8;
    let mut level = MeshLevel::default();
    let mut at = Vec2::ZERO;
    for i in 0..=STEPS {
        let t = i as f32 / STEPS as f32;
        let angle = steep - 1.1 * t * t;
        let along = Vec2::from_angle(angle);
        let half = 0.075 * (1.0 - t.powi(3)) * (0.55 + 1.2 * t * (1.0 - t)) + 0.002;
        let fold = 0.35 * half;
        for side in [-1.0, 0.0, 1.0] {
            let up = Vec2::new(-along.y, along.x) * (fold * f32::abs(side));
            let place = Vec3::new(at.x + up.x, at.y + up.y, side * half);
            let normal = Vec3::new(-along.y, along.x, -0.35 * side).normalize_or(Vec3::Y);
            level.vertices.push(Vertex::new(place, normal, Vec2::new(0.5 + 0.5 * side, t)));
        }
        at += along * (long_m / STEPS as f32);
    }
    for row in 0..STEPS {
        for column in 0..2 {
            let a = 3 * row + column;
            level.indices.extend([a, a + 1, a + 4, a, a + 4, a + 3]);
        }
    }
    level
}

/// A lamp that hangs `drop_m` below the origin: brass, and the glowing globe in it.
pub(super) fn lamp(drop_m: f32) -> (MeshLevel, MeshLevel) {
    let globe = Vec3::Y * -drop_m;
    let mut brass = rod(Vec3::ZERO, globe + Vec3::Y * 0.34, 0.012, 8);
    let moved = |level: MeshLevel, y: f32| level.transformed(Affine3A::from_translation(globe + Vec3::Y * y));
    brass.append(&moved(lathe(&[[0.0, 0.20], [0.16, 0.16], [0.17, 0.19], [0.06, 0.28], [0.02, 0.36]], 20), 0.0));
    brass.append(&moved(torus(0.17, 0.014, 28, 8), 0.0));
    brass.append(&moved(lathe(&[[0.0, -0.26], [0.03, -0.22], [0.08, -0.16], [0.0, -0.15]], 16), 0.0));
    for i in 0..6 {
        let (sin, cos) = (i as f32 / 6.0 * TAU).sin_cos();
        let bar = |radius: f32, y: f32| globe + Vec3::new(radius * cos, y, radius * sin);
        brass.append(&rod(bar(0.17, 0.0), bar(0.15, 0.17), 0.008, 6));
        brass.append(&rod(bar(0.17, 0.0), bar(0.06, -0.18), 0.008, 6));
    }
    (brass, moved(sphere(0.12, 10), 0.0))
}
