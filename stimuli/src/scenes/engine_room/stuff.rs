//! The engine room's materials: metals from chrome to rust, and coloured paint.

use crate::world::{Material, Pattern, PatternKind, World};
use glam::Vec3;

/// The materials, by their indices.
pub(super) struct Stuff {
    pub(super) steel: usize,
    pub(super) chrome: usize,
    pub(super) iron: usize,
    pub(super) copper: usize,
    pub(super) brass: usize,
    pub(super) green: usize,
    pub(super) red: usize,
    pub(super) blue: usize,
    pub(super) yellow: usize,
    pub(super) cream: usize,
    pub(super) rubber: usize,
    pub(super) grating: usize,
    pub(super) plate: usize,
    pub(super) wall: usize,
    pub(super) dado: usize,
    pub(super) hazard: usize,
    pub(super) dial: usize,
    pub(super) lamp: usize,
    pub(super) warm_lamp: usize,
    pub(super) signals: [usize; 3],
}

impl Stuff {
    pub(super) fn of(world: &mut World) -> Self {
        let worn = |material: Material, second: [f32; 3], scale: f32, strength: f32, roughness: f32| {
            material.with(Pattern { strength, roughness, ..Pattern::new(PatternKind::Worn, second, scale) })
        };
        let paint = |albedo: [f32; 3]| worn(Material::matt(albedo, 0.24), albedo.map(|x| 0.55 * x), 1.6, 0.5, 0.25);
        let glow = |emission: [f32; 3]| Material { emission: emission.into(), ..Material::matt([0.9; 3], 0.3) };
        let mut plate = Material::metal([0.42, 0.42, 0.43], 0.40).with(Pattern {
            relief: 0.10,
            strength: 0.35,
            ..Pattern::new(PatternKind::Dots, [0.30, 0.30, 0.31], 5.0)
        });
        plate.pattern.roughness = 0.1;
        Self {
            steel: world.material(worn(Material::metal([0.66, 0.66, 0.67], 0.26), [0.46, 0.45, 0.44], 1.3, 0.6, 0.2)),
            chrome: world.material(Material::metal([0.80, 0.81, 0.83], 0.07)),
            iron: world.material(worn(Material::metal([0.34, 0.33, 0.33], 0.46), [0.26, 0.16, 0.10], 1.8, 0.6, 0.25)),
            copper: world.material(worn(Material::metal([0.95, 0.60, 0.46], 0.20), [0.52, 0.34, 0.24], 1.5, 0.6, 0.2)),
            brass: world.material(Material::metal([0.93, 0.71, 0.34], 0.18)),
            green: world.material(paint([0.06, 0.25, 0.19])),
            red: world.material(paint([0.55, 0.05, 0.035])),
            blue: world.material(paint([0.05, 0.17, 0.40])),
            yellow: world.material(paint([0.85, 0.52, 0.04])),
            cream: world.material(paint([0.66, 0.60, 0.46])),
            rubber: world.material(Material::matt([0.025, 0.025, 0.028], 0.45)),
            grating: world.material(Material::metal([0.50, 0.50, 0.51], 0.35)),
            plate: world.material(plate),
            wall: world.material(Material::matt([0.46, 0.47, 0.44], 0.6).with(Pattern {
                relief: 0.01,
                strength: 0.6,
                ..Pattern::new(PatternKind::Tiles, [0.22, 0.23, 0.22], 0.7)
            })),
            dado: world.material(
                Material::matt([0.08, 0.20, 0.18], 0.32)
                    .with(Pattern { strength: 0.5, ..Pattern::new(PatternKind::Clouds, [0.05, 0.13, 0.12], 1.2) }),
            ),
            hazard: world.material(Material::matt([0.86, 0.56, 0.05], 0.5).with(Pattern::new(
                PatternKind::Stripes,
                [0.03, 0.03, 0.03],
                2.5,
            ))),
            dial: world.material(Material {
                emission: Vec3::splat(0.12),
                ..Material::matt([0.88, 0.86, 0.78], 0.25).with(Pattern::default())
            }),
            lamp: world.material(glow([5.2, 5.6, 6.0])),
            warm_lamp: world.material(glow([6.0, 3.4, 1.3])),
            signals: [[2.6, 0.12, 0.06], [0.15, 2.0, 0.35], [2.6, 1.4, 0.10]]
                .map(|colour| world.material(glow(colour))),
        }
    }
}
