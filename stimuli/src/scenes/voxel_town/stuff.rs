//! What the town's cubes are made of.

use super::voxels::Stuff;
use crate::world::{Material, Pattern, PatternKind};
use glam::Vec3;

pub(super) const ASPHALT: Stuff = 1;
pub(super) const PAVEMENT: Stuff = 2;
pub(super) const GRASS: Stuff = 3;
pub(super) const WATER: Stuff = 4;
pub(super) const PLAZA: Stuff = 5;
pub(super) const ROOF: Stuff = 6;
pub(super) const SLATE: Stuff = 7;
pub(super) const STONE: Stuff = 8;
pub(super) const TRUNK: Stuff = 9;
pub(super) const LEAVES: Stuff = 10;
pub(super) const LEAVES_LIGHT: Stuff = 11;
pub(super) const LEAVES_AUTUMN: Stuff = 12;
pub(super) const WOOD: Stuff = 13;
pub(super) const GOLD: Stuff = 14;
pub(super) const AWNING: Stuff = 15;
pub(super) const DARK: Stuff = 16;
pub(super) const GLASS: Stuff = 17;
pub(super) const CAR: [Stuff; 3] = [18, 19, 20];
pub(super) const LIGHT: Stuff = 21;
pub(super) const LINE: Stuff = 22;
pub(super) const CLOUD: Stuff = 23;
pub(super) const ROCK: Stuff = 24;
/// The first of the walls: seven colours, each plain and with a window.
const WALLS: Stuff = 30;
/// How many colours of walls there are.
pub(super) const WALL_COLOURS: usize = 7;

/// A wall of a colour.
pub(super) fn wall(colour: usize, window: bool) -> Stuff {
    WALLS + 2 * (colour % WALL_COLOURS) as Stuff + Stuff::from(window)
}

/// The material of `stuff`.
pub(super) fn material(stuff: Stuff) -> Material {
    let flat = |albedo: [f32; 3], roughness: f32| Material::matt(albedo, roughness);
    let mixed = |albedo: [f32; 3], second: [f32; 3], kind, scale: f32, roughness: f32| {
        flat(albedo, roughness).with(Pattern::new(kind, second, scale))
    };
    match stuff {
        ASPHALT => mixed([0.17, 0.165, 0.16], [0.23, 0.22, 0.21], PatternKind::Clouds, 1.3, 0.8),
        PAVEMENT => mixed([0.44, 0.41, 0.37], [0.24, 0.22, 0.20], PatternKind::Tiles, 2.0, 0.8),
        GRASS => mixed([0.16, 0.27, 0.05], [0.24, 0.33, 0.08], PatternKind::Clouds, 0.7, 0.95),
        WATER => flat([0.02, 0.07, 0.08], 0.08),
        PLAZA => mixed([0.56, 0.46, 0.35], [0.36, 0.25, 0.19], PatternKind::Checker, 1.0, 0.55),
        ROOF => mixed([0.50, 0.16, 0.08], [0.32, 0.09, 0.05], PatternKind::Bricks, 2.0, 0.8),
        SLATE => mixed([0.15, 0.18, 0.22], [0.07, 0.09, 0.11], PatternKind::Bricks, 2.0, 0.5),
        STONE => mixed([0.52, 0.48, 0.42], [0.34, 0.31, 0.27], PatternKind::Bricks, 1.0, 0.85),
        TRUNK => flat([0.20, 0.12, 0.06], 0.9),
        LEAVES => flat([0.09, 0.22, 0.04], 0.85),
        LEAVES_LIGHT => flat([0.20, 0.32, 0.06], 0.85),
        LEAVES_AUTUMN => flat([0.52, 0.24, 0.04], 0.85),
        WOOD => mixed([0.34, 0.20, 0.10], [0.22, 0.12, 0.06], PatternKind::Stripes, 3.0, 0.8),
        GOLD => Material::metal([0.95, 0.70, 0.28], 0.22),
        AWNING => mixed([0.82, 0.78, 0.70], [0.62, 0.07, 0.05], PatternKind::Stripes, 2.0, 0.8),
        DARK => flat([0.05, 0.05, 0.055], 0.5),
        GLASS => flat([0.03, 0.05, 0.06], 0.06),
        18 => flat([0.55, 0.05, 0.04], 0.22),
        19 => flat([0.75, 0.72, 0.66], 0.22),
        20 => flat([0.05, 0.16, 0.32], 0.22),
        LIGHT => Material { emission: Vec3::new(3.2, 2.3, 1.2), ..flat([0.9, 0.8, 0.6], 0.5) },
        LINE => flat([0.72, 0.70, 0.62], 0.8),
        CLOUD => Material { emission: Vec3::splat(0.12), ..flat([0.92, 0.92, 0.94], 1.0) },
        ROCK => mixed([0.34, 0.31, 0.27], [0.24, 0.22, 0.20], PatternKind::Clouds, 0.3, 0.95),
        wall => {
            let index = usize::from(wall.saturating_sub(WALLS)) / 2 % WALL_COLOURS;
            let albedo = [
                [0.74, 0.62, 0.44],
                [0.66, 0.33, 0.22],
                [0.78, 0.72, 0.62],
                [0.46, 0.53, 0.58],
                [0.70, 0.50, 0.24],
                [0.44, 0.20, 0.15],
                [0.52, 0.57, 0.42],
            ][index];
            if wall.saturating_sub(WALLS) % 2 == 1 {
                Material {
                    roughness: 0.75,
                    ..flat(albedo, 0.75).with(Pattern {
                        roughness: -0.65,
                        relief: 0.06,
                        ..Pattern::new(PatternKind::Windows, [0.035, 0.05, 0.07], 1.0)
                    })
                }
            } else {
                flat(albedo, 0.85)
                    .with(Pattern { strength: 0.35, ..Pattern::new(PatternKind::Clouds, albedo.map(|x| 0.6 * x), 0.8) })
            }
        }
    }
}
