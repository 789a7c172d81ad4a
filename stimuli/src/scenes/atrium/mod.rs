//! A court of two storeys of arcades around an open hall: columns, round arches, vaulted aisles, cloth, a fountain, and a
//! high sun whose light and shadow divide it. A hall as renderers are commonly shown on, of a design of its own.

mod cloth;
mod furnishing;
mod masonry;

use super::parts::forms::lattice;
use super::parts::sky::Sky;
use super::parts::{Batch, camera, openness};
use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::mesh_scene;
use crate::world::shapes::block;
use crate::world::{CameraPath, Environment, Light, Material, MeshLevel, Pattern, PatternKind, World};
use experiments::catalogue::{Parameters, SceneInfo};
use experiments::display::Display;
use glam::{Affine3A, DVec3, Quat, Vec2, Vec3};
use masonry::ArchWall;
use std::f32::consts::FRAC_PI_2;

/// Half the width of the court and half its length, metres.
const COURT: [f32; 2] = [5.0, 18.0];
/// Depth of the aisles around it.
const AISLE: f32 = 4.5;
/// Bays along the court and across it.
const BAYS: [u32; 2] = [9, 3];
/// Heights: where the lower arches spring, the gallery's floor, where the upper arches spring, and the roof.
const SPRING: f32 = 4.2;
const GALLERY: f32 = 6.8;
const UPPER_SPRING: f32 = 9.5;
const ROOF: f32 = 11.8;
/// Thickness of the walls over the columns.
const WALL: f32 = 0.8;

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "atrium".to_owned(),
        version: 1,
        about:
            "A court of two storeys of arcades with columns, vaults, hanging cloth and a fountain in hard sunlight, \
                walked through along its nave and gallery."
                .to_owned(),
        parameters: camera::schemas(),
        animated: true,
    }
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    mesh_scene::make(gpu, display, world(parameters)?)
}

/// The world for completed parameters.
pub(crate) fn world(parameters: &Parameters) -> Result<World, MakeError> {
    let mut world = World {
        environment: Environment::of(sky().paint(512)),
        camera: camera::set(path(), parameters)?,
        light: SceneLight { exposure: 0.66, tone_map: ToneMap::Filmic },
        ..World::default()
    };
    let stuff = Stuff::of(&mut world);
    let mut batch = Batch::new(12.0);
    build_floors(&mut batch, &stuff);
    build_arcades(&mut batch, &stuff);
    build_aisles(&mut world, &mut batch, &stuff);
    hang_cloth(&mut batch, &stuff);
    furnish(&mut batch, &stuff);
    batch.finish(&mut world);
    openness::bake(&mut world, 0.25, 6.0, 0.22);
    Ok(world)
}

fn sky() -> Sky {
    Sky {
        sun_towards: Vec3::new(0.50, 1.0, 0.42),
        sun_colour: Vec3::new(3.6, 3.15, 2.5),
        zenith: Vec3::new(0.30, 0.42, 0.68),
        horizon: Vec3::new(0.88, 0.82, 0.72),
        // Sunlit stone, which lights the vaults from below.
        ground: Vec3::new(0.74, 0.55, 0.36),
        clouds: 0.35,
        mountains: 0.0,
        seed: 3,
    }
}

/// The materials, by their indices.
struct Stuff {
    wall: usize,
    shaft: usize,
    trim: usize,
    vault: usize,
    court_floor: usize,
    aisle_floor: usize,
    cloths: [usize; 3],
    sail: usize,
    water: usize,
    pot: usize,
    leaf: usize,
    brass: usize,
    glow: usize,
}

impl Stuff {
    fn of(world: &mut World) -> Self {
        let stone = |albedo: [f32; 3], second: [f32; 3], kind, scale: f32, strength: f32, roughness: f32| {
            Material::matt(albedo, roughness).with(Pattern { strength, ..Pattern::new(kind, second, scale) })
        };
        let cloth = |albedo: [f32; 3], second: [f32; 3]| Material {
            two_sided: true,
            ..Material::matt(albedo, 0.9)
                .with(Pattern { relief: 0.2, ..Pattern::new(PatternKind::Weave, second, 45.0) })
        };
        let mut wall = stone([0.60, 0.51, 0.38], [0.34, 0.27, 0.19], PatternKind::Bricks, 0.85, 0.75, 0.9);
        wall.pattern.relief = 0.012;
        let mut aisle_floor = stone([0.46, 0.38, 0.28], [0.18, 0.14, 0.10], PatternKind::Tiles, 1.3, 0.9, 0.42);
        aisle_floor.pattern.relief = 0.01;
        Self {
            wall: world.material(wall),
            shaft: world.material(stone([0.70, 0.62, 0.50], [0.56, 0.47, 0.36], PatternKind::Clouds, 0.9, 0.7, 0.6)),
            trim: world.material(stone([0.68, 0.60, 0.48], [0.56, 0.48, 0.37], PatternKind::Clouds, 1.7, 0.6, 0.8)),
            vault: world.material(stone([0.66, 0.58, 0.46], [0.52, 0.43, 0.32], PatternKind::Clouds, 0.6, 0.6, 0.95)),
            court_floor: world.material(stone(
                [0.56, 0.47, 0.36],
                [0.22, 0.12, 0.085],
                PatternKind::Checker,
                1.0,
                0.9,
                0.30,
            )),
            aisle_floor: world.material(aisle_floor),
            cloths: [
                world.material(cloth([0.50, 0.035, 0.03], [0.32, 0.02, 0.03])),
                world.material(cloth([0.04, 0.12, 0.36], [0.02, 0.05, 0.20])),
                world.material(cloth([0.04, 0.26, 0.12], [0.02, 0.14, 0.06])),
            ],
            sail: world.material(Material {
                two_sided: true,
                ..Material::matt([0.82, 0.76, 0.62], 0.9).with(Pattern::new(
                    PatternKind::Stripes,
                    [0.70, 0.36, 0.10],
                    0.75,
                ))
            }),
            water: world.material(Material::matt([0.02, 0.05, 0.05], 0.06)),
            pot: world.material(stone([0.50, 0.22, 0.12], [0.36, 0.15, 0.08], PatternKind::Clouds, 3.0, 0.8, 0.8)),
            leaf: world.material(Material { two_sided: true, ..Material::matt([0.14, 0.30, 0.12], 0.5) }),
            brass: world.material(Material::metal([0.85, 0.62, 0.30], 0.3)),
            glow: world
                .material(Material { emission: Vec3::new(5.0, 3.1, 1.4), ..Material::matt([0.9, 0.8, 0.6], 0.5) }),
        }
    }
}

/// A flat floor, seen from above, in cells of about half a metre: one corner and the opposite one.
fn floor(low: Vec2, high: Vec2, y: f32) -> MeshLevel {
    let cells = ((high - low) / 0.5).ceil();
    let place = |i: i32, j: i32| {
        let t = Vec2::new(i as f32, cells.y - j as f32) / cells;
        let at = low + t * (high - low);
        Vec3::new(at.x, y, at.y)
    };
    lattice(cells.x as u32, cells.y as u32, place, |i, j| {
        let at = place(i, j);
        Vec2::new(at.x, at.z)
    })
}

/// A flat wall from `a` to `b` along the ground, seen with `a` on the left, in cells of about a metre.
fn upright(a: Vec2, b: Vec2, low: f32, high: f32) -> MeshLevel {
    let cells = [a.distance(b).ceil(), (high - low).ceil()];
    let place = |i: i32, j: i32| {
        let at = a.lerp(b, i as f32 / cells[0]);
        Vec3::new(at.x, low + (high - low) * j as f32 / cells[1], at.y)
    };
    let long = a.distance(b);
    lattice(cells[0] as u32, cells[1] as u32, place, |i, j| {
        Vec2::new(long * i as f32 / cells[0], -(low + (high - low) * j as f32 / cells[1]))
    })
}

fn build_floors(batch: &mut Batch, stuff: &Stuff) {
    let [x, z] = COURT;
    // A little into the walls, so that nothing shows between.
    let (outer_x, outer_z) = (x + AISLE + 0.15, z + AISLE + 0.15);
    batch.add(stuff.court_floor, &floor(Vec2::new(-x, -z), Vec2::new(x, z), 0.0));
    // Four strips around the court on each storey; the gallery's have an underside and an edge, too.
    for (low, high) in [
        (Vec2::new(-outer_x, -outer_z), Vec2::new(-x, outer_z)),
        (Vec2::new(x, -outer_z), Vec2::new(outer_x, outer_z)),
        (Vec2::new(-x, -outer_z), Vec2::new(x, -z)),
        (Vec2::new(-x, z), Vec2::new(x, outer_z)),
    ] {
        batch.add(stuff.aisle_floor, &floor(low, high, 0.0));
        batch.add(stuff.aisle_floor, &floor(low, high, GALLERY));
        let slab = block(Vec3::new(low.x, ROOF, low.y), Vec3::new(high.x, ROOF + 0.4, high.y));
        batch.add(stuff.trim, &slab);
    }
}

/// The sides of the court: the middle of each, its direction along the wall, its bays and half its length.
fn sides() -> [(Vec3, f32, u32, f32); 4] {
    let [x, z] = COURT;
    // The angle turns the wall's front, +z, towards the court.
    [
        (Vec3::X * x, -FRAC_PI_2, BAYS[0], z),
        (Vec3::NEG_X * x, FRAC_PI_2, BAYS[0], z),
        (Vec3::Z * z, std::f32::consts::PI, BAYS[1], x),
        (Vec3::NEG_Z * z, 0.0, BAYS[1], x),
    ]
}

fn build_arcades(batch: &mut Batch, stuff: &Stuff) {
    let lower = masonry::column(0.36, SPRING);
    let upper = masonry::column(0.23, UPPER_SPRING - GALLERY);
    for (middle, angle, bays, half) in sides() {
        let turn = Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), middle);
        let span = 2.0 * half / bays as f32;
        let along = |x: f32, y: f32| turn * Affine3A::from_translation(Vec3::new(x, y, 0.0));
        let storeys = [(SPRING, GALLERY - SPRING, 0.44, 0.26), (UPPER_SPRING, ROOF - UPPER_SPRING, 0.32, 0.20)];
        for (spring, height_m, inset, moulding) in storeys {
            let arch = ArchWall { span_m: span, height_m, radius_m: 0.5 * span - inset, thickness_m: WALL };
            let (wall, archivolt) = (arch.wall(), arch.archivolt(moulding, 0.07));
            for bay in 0..bays {
                let x = -half + (bay as f32 + 0.5) * span;
                batch.add_at(stuff.wall, &wall, along(x, spring));
                batch.add_at(stuff.trim, &archivolt, along(x, spring));
            }
        }
        // Columns stand between the bays; those at the corners belong to the long sides.
        let ends = u32::from(half < COURT[1]);
        for i in ends..=bays - ends {
            let x = -half + i as f32 * span;
            batch.add_at(stuff.shaft, &lower, along(x, 0.0));
            batch.add_at(stuff.shaft, &upper, along(x, GALLERY));
        }
        for bay in 0..bays {
            let x = -half + (bay as f32 + 0.5) * span;
            batch.add_at(stuff.trim, &masonry::balustrade(span - 0.5), along(x, GALLERY));
        }
        for (y, length) in [(GALLERY - 0.30, 2.0 * half - WALL), (ROOF - 0.36, 2.0 * half - WALL)] {
            let front = turn * Affine3A::from_translation(Vec3::new(0.0, y, 0.5 * WALL));
            batch.add_at(stuff.trim, &masonry::cornice(length), front);
        }
        // A parapet on the roof.
        let parapet = block(Vec3::new(-half - 0.3, ROOF, -0.3), Vec3::new(half + 0.3, ROOF + 1.1, 0.3));
        batch.add_at(stuff.wall, &parapet, turn);
    }
}

/// The outer walls with blind arches, the vaults, and a lamp in every bay.
fn build_aisles(world: &mut World, batch: &mut Batch, stuff: &Stuff) {
    let [x, z] = COURT;
    let (brass, glow) = furnishing::lamp(1.5);
    let mut bays = Vec::new();
    let (long, short) = (2.0 * z / BAYS[0] as f32, 2.0 * x / BAYS[1] as f32);
    for side in [-1.0, 1.0] {
        for bay in 0..BAYS[0] {
            let at = Vec3::new(side * (x + 0.5 * AISLE), SPRING, -z + (bay as f32 + 0.5) * long);
            bays.push((at, AISLE, long, Vec3::X * side));
        }
        for bay in 0..BAYS[1] {
            let at = Vec3::new(-x + (bay as f32 + 0.5) * short, SPRING, side * (z + 0.5 * AISLE));
            bays.push((at, short, AISLE, Vec3::Z * side));
        }
        for end in [-1.0, 1.0] {
            let at = Vec3::new(side * (x + 0.5 * AISLE), SPRING, end * (z + 0.5 * AISLE));
            bays.push((at, AISLE, AISLE, Vec3::ZERO));
        }
    }
    for (index, &(at, width, depth, outwards)) in bays.iter().enumerate() {
        for (y, rise) in [(SPRING, 2.25), (UPPER_SPRING, 2.15)] {
            batch.add_to(stuff.vault, &masonry::vault(width, depth, rise), at.with_y(y));
        }
        // The lamp hangs from the crown of the vault.
        batch.add_to(stuff.brass, &brass, at + Vec3::Y * 2.25);
        batch.add_to(stuff.glow, &glow, at + Vec3::Y * 2.25);
        if index % 3 == 1 {
            let light = at + Vec3::Y * 0.55;
            world.lights.push(Light::Point { at: light, colour: Vec3::new(2.6, 1.5, 0.62), reach_m: 7.0 });
        }
        if outwards == Vec3::ZERO {
            continue;
        }
        // A blind arch before the outer wall, on two half columns.
        let span = if outwards.x == 0.0 { width } else { depth };
        let arch = ArchWall { span_m: span, height_m: 2.4, radius_m: 0.5 * span - 0.5, thickness_m: 0.3 };
        let angle = f32::atan2(-outwards.x, -outwards.z);
        let foot = (at + outwards * (0.5 * AISLE - 0.15)).with_y(0.0);
        let turn = Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), foot);
        for floor_y in [0.0, GALLERY] {
            let spring = if floor_y > 0.0 { UPPER_SPRING - 0.2 } else { SPRING - 0.2 };
            let up = |y: f32| turn * Affine3A::from_translation(Vec3::Y * y);
            batch.add_at(stuff.trim, &arch.wall(), up(spring));
            for end in [-1.0, 1.0] {
                let (a, b) = (end * 0.5 * span, end * (0.5 * span - 0.46));
                let pier = block(Vec3::new(a.min(b), floor_y, -0.15), Vec3::new(a.max(b), spring, 0.15));
                batch.add_at(stuff.trim, &pier, turn);
            }
        }
    }
    // The outer walls, seen from inside.
    let (outer_x, outer_z) = (x + AISLE, z + AISLE);
    let corners = [
        Vec2::new(-outer_x, -outer_z),
        Vec2::new(outer_x, -outer_z),
        Vec2::new(outer_x, outer_z),
        Vec2::new(-outer_x, outer_z),
    ];
    for i in 0..4 {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        batch.add(stuff.wall, &upright(a, b, -0.1, ROOF + 0.1));
        // And from outside, for the shadow.
        batch.add(stuff.wall, &upright(b, a, -0.1, ROOF + 0.1));
    }
}

fn hang_cloth(batch: &mut Batch, stuff: &Stuff) {
    let span = 2.0 * COURT[1] / BAYS[0] as f32;
    // Banners before every other column, from the gallery's rail.
    for (i, column) in (1..BAYS[0]).enumerate() {
        for side in [-1.0_f32, 1.0] {
            let odd = (i as u32 + u32::from(side > 0.0)) % 2;
            if odd == 1 {
                continue;
            }
            let z = -COURT[1] + column as f32 * span;
            let at = Vec3::new(side * (COURT[0] - 0.5 * WALL - 0.42), GALLERY + 1.02, z);
            let turn = Affine3A::from_rotation_translation(Quat::from_rotation_y(-side * FRAC_PI_2), at);
            let banner = cloth::banner(1.7, 3.5, 4.5, column * 7 + odd);
            let which = (column as usize / 2 + usize::from(side > 0.0)) % 3;
            batch.add_at(stuff.cloths[which], &banner, turn);
            // The rod that it hangs from.
            let rod = super::parts::forms::rod(Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), 0.03, 8);
            batch.add_at(stuff.brass, &rod, turn);
            for x in [-0.8, 0.8] {
                let arm = super::parts::forms::rod(Vec3::new(x, 0.0, 0.0), Vec3::new(x, -0.1, -0.75), 0.02, 6);
                batch.add_at(stuff.brass, &arm, turn);
            }
        }
    }
    // Sails over the court.
    for (i, z) in [-10.0, -2.0, 8.0].into_iter().enumerate() {
        let sail = cloth::sail(2.0 * COURT[0] - WALL, 3.4, 1.3, 60 + i as u32);
        batch.add_to(stuff.sail, &sail, Vec3::new(0.0, ROOF - 0.5, z));
    }
}

fn furnish(batch: &mut Batch, stuff: &Stuff) {
    let (stone, water) = furnishing::fountain();
    batch.add(stuff.trim, &stone);
    batch.add(stuff.water, &water);
    let span = 2.0 * COURT[1] / BAYS[0] as f32;
    for (i, column) in [1, 3, 6, 8].into_iter().enumerate() {
        for side in [-1.0, 1.0] {
            let at = Vec3::new(side * (COURT[0] - 1.25), 0.0, -COURT[1] + column as f32 * span);
            let (pot, plant) = furnishing::agave(i as u32 + 10 * u32::from(side > 0.0));
            batch.add_to(stuff.pot, &pot, at);
            batch.add_to(stuff.leaf, &plant, at);
        }
    }
}

/// Along the nave past the fountain, up through the court into the gallery, back along it, and down again.
fn path() -> CameraPath {
    let places = [
        ([0.9, 1.75, 17.0], [-0.9, 2.9, -16.0]),
        ([1.4, 1.75, 11.5], [-1.6, 2.9, -16.0]),
        ([2.6, 1.75, 6.0], [-1.8, 2.7, -16.0]),
        ([3.1, 1.75, 0.0], [-3.0, 3.0, -18.0]),
        ([3.2, 1.9, -6.0], [-9.0, 4.4, -15.0]),
        ([3.0, 3.6, -10.0], [-10.0, 5.2, -6.0]),
        ([2.4, 5.8, -13.0], [-8.0, 5.2, 5.0]),
        ([2.0, 7.8, -15.4], [-3.0, 5.0, 10.0]),
        ([3.2, 8.7, -16.2], [0.5, 5.2, 8.0]),
        ([5.0, 8.9, -16.0], [2.0, 5.6, 6.0]),
        ([6.2, 8.8, -14.2], [3.2, 6.4, 6.0]),
        ([6.1, 8.75, -10.0], [1.0, 5.8, 8.0]),
        ([6.1, 8.75, -4.0], [-2.0, 5.2, 12.0]),
        ([6.1, 8.75, 2.0], [-5.0, 5.2, 16.0]),
        ([6.1, 8.75, 8.0], [-6.0, 5.6, 17.0]),
        ([6.1, 8.8, 13.6], [-8.0, 5.8, 12.0]),
        ([5.0, 8.9, 16.0], [-7.0, 5.4, 2.0]),
        ([2.4, 7.4, 16.4], [-4.0, 4.4, -10.0]),
        ([0.8, 4.0, 16.9], [-1.6, 3.2, -14.0]),
    ];
    let places = places.map(|(eye, target)| (DVec3::from(eye), DVec3::from(target)));
    camera::round(&places, 1.2)
}
