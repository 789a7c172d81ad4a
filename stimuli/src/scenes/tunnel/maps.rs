//! The tunnel with smooth walls in sections, each covered with a checker, noise, a picture or a pattern between iron
//! ribs: all its detail comes from maps and shaders.

use super::{LENGTH, RADIUS, lamp, lamp_colour, lamps, path, station};
use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::mesh_scene;
use crate::scenes::parts::forms::{hanging, lattice, torus};
use crate::scenes::parts::noise::{clouds, hash, ridges};
use crate::scenes::parts::{Batch, camera};
use crate::world::{Environment, Light, Map, Material, Object, Panorama, Pattern, PatternKind, World};
use experiments::catalogue::{Parameters, SceneInfo};
use experiments::display::Display;
use glam::{Affine3A, IVec3, Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Sections of the wall, each with its own look.
const SECTIONS: u32 = 32;
/// Cells of a section along the tunnel, and around it.
const ALONG: u32 = 14;
const AROUND: u32 = 64;
/// Pixels on a side of the maps.
const MAP_PX: u32 = 256;

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "tunnel-maps".to_owned(),
        version: 1,
        about: "A smooth winding tunnel whose walls are covered with checkers, noise, pictures and patterns, flown \
                through."
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
        environment: Environment::of(Panorama::uniform(Vec3::new(0.10, 0.11, 0.13))),
        camera: camera::set(path(), parameters)?,
        light: SceneLight { exposure: 1.2, tone_map: ToneMap::Filmic },
        ..World::default()
    };
    let looks = looks(&mut world);
    for section in 0..SECTIONS {
        let turn = |i: i32| ((section * ALONG) as i32 + i) as f32 / (SECTIONS * ALONG) as f32;
        let place = |i: i32, j: i32| {
            let here = station(turn(i));
            here.at + RADIUS * here.across(j as f32 / AROUND as f32)
        };
        // Whole repeats around, so that the map closes: 10 on a circumference of 20.1 m.
        let uv = |i: i32, j: i32| Vec2::new(0.5 * turn(i) * LENGTH, -10.0 * j as f32 / AROUND as f32);
        let mesh = world.mesh(lattice(ALONG, AROUND, place, uv));
        world.objects.push(Object::still(mesh, looks[section as usize % looks.len()]));
    }
    furnish(&mut world);
    Ok(world)
}

/// A picture from a function of place, 0–1 on both axes.
fn map(colour_of: impl Fn(Vec2) -> Vec3) -> Map {
    let pixels = (0..MAP_PX * MAP_PX).flat_map(|i| {
        let at = Vec2::new((i % MAP_PX) as f32 + 0.5, (i / MAP_PX) as f32 + 0.5) / MAP_PX as f32;
        let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        let colour = colour_of(at);
        [byte(colour.x), byte(colour.y), byte(colour.z), 255]
    });
    Map { size: [MAP_PX; 2], rgba: pixels.collect() }
}

/// A place on a torus in space, so that noise there repeats from one side of a map to the other.
fn closed(at: Vec2, scale: f32) -> Vec3 {
    let ((s, c), (t, d)) = ((at.x * TAU).sin_cos(), (at.y * TAU).sin_cos());
    scale * Vec3::new((2.0 + c) * d, (2.0 + c) * t, s)
}

/// The sections' materials in their order; those of maps repeat every two metres.
fn looks(world: &mut World) -> Vec<usize> {
    let colours = |a: [f32; 3], b: [f32; 3], t: f32| Vec3::from(a).lerp(b.into(), t);
    let checker = map(|at| {
        let odd = ((at.x * 4.0).floor() + (at.y * 4.0).floor()) as i32 % 2 == 0;
        Vec3::splat(if odd { 0.88 } else { 0.10 })
    });
    let painted_checker = map(|at| {
        let cell = IVec3::new((at.x * 4.0) as i32, (at.y * 4.0) as i32, 0);
        let dirt = 0.12 * clouds(closed(at, 3.0), 4, 5);
        let tint = colours([0.86, 0.74, 0.45], [0.10, 0.30, 0.42], f32::from((cell.x + cell.y) % 2 == 0));
        tint * (0.85 + 0.2 * hash(cell, 2)) + dirt
    });
    let noise = map(|at| Vec3::splat(0.5 + 0.62 * clouds(closed(at, 2.2), 6, 12)));
    let veins = map(|at| {
        let vein = ridges(closed(at, 1.1), 5, 14).clamp(0.0, 1.0).powi(3);
        colours([0.16, 0.24, 0.22], [0.92, 0.86, 0.66], vein)
    });
    let rust = map(|at| {
        let amount = 0.5 + 0.9 * clouds(closed(at, 1.6), 6, 15);
        colours([0.40, 0.52, 0.55], [0.52, 0.24, 0.10], amount.clamp(0.0, 1.0))
    });
    let mut mapped = |picture: Map, roughness: f32| {
        world.colour_maps.push(picture);
        let albedo_map = Some(world.colour_maps.len() - 1);
        world.material(Material { albedo_map, ..Material::matt([0.9; 3], roughness) })
    };
    let [checker, painted, noise, veins, rust] =
        [(checker, 0.35), (painted_checker, 0.5), (noise, 0.6), (veins, 0.25), (rust, 0.45)]
            .map(|(picture, roughness)| mapped(picture, roughness));
    let mut patterned = |albedo: [f32; 3], second: [f32; 3], kind, scale: f32, relief: f32, roughness: f32| {
        let pattern = Pattern { relief, ..Pattern::new(kind, second, scale) };
        world.material(Material::matt(albedo, roughness).with(pattern))
    };
    let bricks = patterned([0.46, 0.17, 0.10], [0.50, 0.46, 0.40], PatternKind::Bricks, 2.0, 0.05, 0.8);
    let tiles = patterned([0.70, 0.76, 0.74], [0.14, 0.20, 0.20], PatternKind::Tiles, 3.0, 0.03, 0.15);
    let weave = patterned([0.60, 0.38, 0.10], [0.14, 0.06, 0.05], PatternKind::Weave, 3.0, 0.06, 0.6);
    let dots = patterned([0.86, 0.80, 0.66], [0.60, 0.08, 0.06], PatternKind::Dots, 2.0, 0.0, 0.35);
    let stripes = patterned([0.80, 0.78, 0.72], [0.08, 0.16, 0.40], PatternKind::Stripes, 1.0, 0.0, 0.4);
    let cloudy = patterned([0.55, 0.46, 0.36], [0.16, 0.13, 0.12], PatternKind::Clouds, 1.0, 0.12, 0.6);
    let marble = patterned([0.82, 0.80, 0.76], [0.10, 0.12, 0.14], PatternKind::Marble, 0.5, 0.0, 0.15);
    vec![
        checker, noise, bricks, painted, tiles, cloudy, veins, dots, checker, rust, weave, marble, painted, stripes,
        noise, tiles,
    ]
}

fn furnish(world: &mut World) {
    let iron = world.material(
        Material::metal([0.42, 0.40, 0.38], 0.38)
            .with(Pattern { strength: 0.8, ..Pattern::new(PatternKind::Worn, [0.28, 0.13, 0.06], 2.0) }),
    );
    let brass = world.material(Material::metal([0.86, 0.64, 0.30], 0.25));
    let rubber = world.material(Material::matt([0.03, 0.03, 0.03], 0.5));
    let glows = [true, false]
        .map(|warm| world.material(Material { emission: 9.0 * lamp_colour(warm), ..Material::matt([0.9; 3], 0.4) }));
    let mut batch = Batch::new(14.0);
    // Ribs between the sections, with rivets.
    let rib = torus(RADIUS, 0.09, 64, 12).transformed(Affine3A::from_quat(Quat::from_rotation_x(FRAC_PI_2)));
    let rivet = crate::world::shapes::sphere(0.035, 5);
    for section in 0..SECTIONS {
        let here = station(section as f32 / SECTIONS as f32);
        batch.add_at(iron, &rib, here.frame());
        for i in 0..24 {
            batch.add_to(brass, &rivet, here.at + (RADIUS - 0.09) * here.across((i as f32 + 0.5) / 24.0));
        }
    }
    let (cage, glass) = lamp();
    let mut hooks = Vec::new();
    for (i, (here, warm)) in lamps().enumerate() {
        let at = here.at + here.up * (RADIUS - 0.1);
        let frame = Affine3A { translation: at.into(), ..here.frame() };
        batch.add_at(iron, &cage, frame);
        batch.add_at(glows[usize::from(!warm)], &glass, frame);
        let colour = lamp_colour(warm).lerp(Vec3::ONE, 0.45);
        world.lights.push(Light::Point { at: at - here.up * 0.5, colour: 8.0 * colour, reach_m: 15.0 });
        hooks.push(at + here.up * 0.08);
        let between = station((i as f32 + 1.0) / super::LAMPS as f32);
        hooks.push(between.at + between.up * (RADIUS - 0.02));
    }
    for (i, &hook) in hooks.iter().enumerate() {
        batch.add(rubber, &hanging(hook, hooks[(i + 1) % hooks.len()], 0.18, 0.022, 8));
    }
    // Pipes along both walls.
    for (around, radius) in [(0.17, 0.07), (0.20, 0.045), (-0.18, 0.09)] {
        let steps = 480;
        for piece in 0..24 {
            let path: Vec<Vec3> = (0..=steps / 24)
                .map(|i| {
                    let here = station((piece * steps / 24 + i) as f32 / steps as f32);
                    here.at + here.across(around) * (RADIUS - 0.20)
                })
                .collect();
            batch.add(if radius > 0.06 { iron } else { brass }, &crate::world::shapes::tube(&path, radius, 12));
        }
    }
    batch.finish(world);
}
