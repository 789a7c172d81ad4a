//! What the objects of the grid are made of: every procedural pattern, from chalk to mirror.

use crate::world::{Material, Pattern, PatternKind};
use glam::Vec3;

/// Steps from diffuse to glossy.
pub(super) const FINISHES: usize = 6;

/// A pattern with its two colours, scale and relief; whether it is a metal's.
struct Look {
    kind: PatternKind,
    colours: [[f32; 3]; 2],
    scale: f32,
    relief: f32,
    metal: bool,
}

const fn look(kind: PatternKind, colours: [[f32; 3]; 2], scale: f32, relief: f32, metal: bool) -> Look {
    Look { kind, colours, scale, relief, metal }
}

/// The looks; those on map coordinates repeat so often from one side of the map to the other.
const LOOKS: [Look; 14] = [
    look(PatternKind::Checker, [[0.85, 0.80, 0.70], [0.55, 0.05, 0.04]], 1.6, 0.0, false),
    look(PatternKind::Marble, [[0.88, 0.86, 0.82], [0.12, 0.20, 0.17]], 1.1, 0.0, false),
    look(PatternKind::Wood, [[0.56, 0.30, 0.12], [0.22, 0.09, 0.03]], 2.4, 0.0, false),
    look(PatternKind::Bricks, [[0.50, 0.14, 0.08], [0.62, 0.58, 0.52]], 8.0, 0.08, false),
    look(PatternKind::Tiles, [[0.05, 0.30, 0.42], [0.82, 0.82, 0.78]], 12.0, 0.05, false),
    look(PatternKind::Weave, [[0.72, 0.42, 0.10], [0.30, 0.10, 0.18]], 26.0, 0.10, false),
    look(PatternKind::Worn, [[0.95, 0.64, 0.40], [0.10, 0.30, 0.24]], 1.5, 0.0, true),
    look(PatternKind::Stripes, [[0.90, 0.86, 0.74], [0.06, 0.16, 0.45]], 10.0, 0.0, false),
    look(PatternKind::Dots, [[0.90, 0.62, 0.08], [0.10, 0.10, 0.14]], 12.0, 0.0, false),
    look(PatternKind::Clouds, [[0.20, 0.48, 0.62], [0.88, 0.90, 0.86]], 1.3, 0.0, false),
    look(PatternKind::Worn, [[0.92, 0.92, 0.94], [0.28, 0.24, 0.22]], 1.2, 0.0, true),
    look(PatternKind::Marble, [[0.06, 0.07, 0.08], [0.80, 0.66, 0.36]], 0.9, 0.0, false),
    look(PatternKind::Windows, [[0.72, 0.70, 0.66], [0.03, 0.05, 0.08]], 14.0, 0.0, false),
    look(PatternKind::Checker, [[0.98, 0.78, 0.38], [0.96, 0.94, 0.92]], 2.2, 0.0, true),
];

/// Every look in every finish: index `look · FINISHES + finish`, the first finish the most diffuse.
pub(super) fn materials() -> Vec<Material> {
    let finished = |look: &Look, finish: usize| {
        let glossy = finish as f32 / (FINISHES - 1) as f32;
        let roughness = if look.metal { 0.55 - 0.49 * glossy } else { 0.95 - 0.88 * glossy };
        let [albedo, second] = look.colours;
        let base = if look.metal { Material::metal(albedo, roughness) } else { Material::matt(albedo, roughness) };
        base.with(Pattern { relief: look.relief, ..Pattern::new(look.kind, second, look.scale) })
    };
    LOOKS.iter().flat_map(|look| (0..FINISHES).map(move |finish| finished(look, finish))).collect()
}

/// Meadow, rock and snow.
pub(super) fn terrain() -> Material {
    Material { albedo: Vec3::new(0.13, 0.20, 0.045), roughness: 0.95, ..Material::default() }.with(Pattern::new(
        PatternKind::Terrain,
        [0.30, 0.25, 0.19],
        0.35,
    ))
}

/// How many looks there are.
pub(super) const fn looks() -> usize {
    LOOKS.len()
}
