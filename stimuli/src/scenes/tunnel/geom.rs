//! The tunnel as a cave: its walls are displaced by noise in some 200,000 triangles, wet, and lit by lamps on a cable,
//! with crystals that glow in its niches.

use super::{LENGTH, RADIUS, Station, lamp, lamp_colour, lamps, path, station};
use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::mesh_scene;
use crate::scenes::parts::forms::{hanging, lattice};
use crate::scenes::parts::noise::{clouds, hash, ridges, smoothstep};
use crate::scenes::parts::{Batch, camera, openness};
use crate::world::shapes::{block, upright};
use crate::world::{Environment, Light, Material, MeshLevel, Object, Panorama, Pattern, PatternKind, World};
use experiments::catalogue::{Parameters, SceneInfo};
use experiments::display::Display;
use glam::{Affine3A, IVec3, Vec2, Vec3};
use std::f32::consts::TAU;

/// Cells along the loop and around the tunnel: 2 · 1120 · 90 = 201,600 triangles.
const ALONG: u32 = 1120;
const AROUND: u32 = 90;
/// Pieces of the wall.
const PIECES: u32 = 40;
/// Height of the floor over the lowest point of the circle, metres.
const FLOOR: f32 = 1.1;

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "tunnel-geom".to_owned(),
        version: 1,
        about: "A winding cave whose walls are displaced by noise in dense geometry, lit by lamps, flown through."
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
        environment: Environment::of(Panorama::uniform(Vec3::new(0.06, 0.07, 0.09))),
        camera: camera::set(path(), parameters)?,
        light: SceneLight { exposure: 1.0, tone_map: ToneMap::Filmic },
        ..World::default()
    };
    let rock = Material::matt([0.42, 0.34, 0.27], 0.42)
        .with(Pattern { roughness: 0.35, ..Pattern::new(PatternKind::Clouds, [0.20, 0.17, 0.16], 1.1) });
    let rock = world.material(rock);
    let columns = ALONG / PIECES;
    for piece in 0..PIECES {
        let first = (piece * columns) as i32;
        // Seen from within, the tunnel runs to the right and the wall rises from below over the left.
        let place = |i: i32, j: i32| wall((first + i) as f32 / ALONG as f32, j as f32 / AROUND as f32);
        let uv = |i: i32, j: i32| {
            Vec2::new((first + i) as f32 / ALONG as f32 * LENGTH, j as f32 / AROUND as f32 * TAU * RADIUS)
        };
        let mesh = world.mesh(lattice(columns, AROUND, place, uv));
        world.objects.push(Object::still(mesh, rock));
    }
    furnish(&mut world);
    openness::bake(&mut world, 0.15, 1.6, 0.25);
    Ok(world)
}

/// The wall at `turn` of the loop and `around` the tunnel, both 0–1 and going on beyond.
fn wall(turn: f32, around: f32) -> Vec3 {
    let here = station(turn);
    let out = here.across(around);
    let smooth = here.at + RADIUS * out;
    // Bulges, ridges and grain; the floor is calmer.
    let up = out.dot(here.up);
    let calm = 1.0 - 0.75 * smoothstep(0.3, 0.85, -up);
    let bulge = 0.55 * clouds(0.30 * smooth, 2, 7);
    let ridge = 0.62 * (ridges(0.45 * smooth + 3.0, 4, 8) - 0.45);
    let grain = 0.05 * clouds(3.2 * smooth, 2, 9);
    let radius = RADIUS + calm * (bulge - ridge) + grain;
    let mut at = here.at + radius * out;
    // A trodden floor cuts the lowest part of the circle off.
    let depth = (at - here.at).dot(here.up) + RADIUS - FLOOR;
    let level = 0.10 * clouds(0.8 * smooth, 3, 10);
    if depth < level {
        at += here.up * (level - depth) * 0.92;
    }
    at
}

fn furnish(world: &mut World) {
    let iron = world.material(Material::metal([0.30, 0.27, 0.25], 0.55).with(Pattern::new(
        PatternKind::Worn,
        [0.30, 0.13, 0.06],
        3.0,
    )));
    let rubber = world.material(Material::matt([0.03, 0.03, 0.03], 0.5));
    let wood = world.material(
        Material::matt([0.24, 0.15, 0.08], 0.85)
            .with(Pattern { roughness: 0.1, ..Pattern::new(PatternKind::Clouds, [0.12, 0.07, 0.04], 2.5) }),
    );
    let mut batch = Batch::new(14.0);
    let (cage, glass) = lamp();
    let ceiling = |here: &Station, turn: f32| {
        let top = wall(turn, 0.5);
        here.at + here.up * ((top - here.at).dot(here.up) - 0.08)
    };
    let glows = [true, false]
        .map(|warm| world.material(Material { emission: 9.0 * lamp_colour(warm), ..Material::matt([0.9; 3], 0.4) }));
    let count = super::LAMPS;
    let mut hooks = Vec::new();
    for (i, (here, warm)) in lamps().enumerate() {
        let turn = (i as f32 + 0.5) / count as f32;
        let at = ceiling(&here, turn);
        let frame = Affine3A { translation: at.into(), ..here.frame() };
        batch.add_at(iron, &cage, frame);
        batch.add_at(glows[usize::from(!warm)], &glass, frame);
        let light = at - here.up * 0.45;
        world.lights.push(Light::Point { at: light, colour: 9.0 * lamp_colour(warm), reach_m: 15.0 });
        hooks.push(at + here.up * 0.02);
        let middle_turn = (i as f32 + 1.0) / count as f32;
        hooks.push(ceiling(&station(middle_turn), middle_turn));
    }
    // The cable from lamp to lamp.
    for (i, &hook) in hooks.iter().enumerate() {
        batch.add(rubber, &hanging(hook, hooks[(i + 1) % hooks.len()], 0.22, 0.022, 8));
    }
    // Sleepers and rails on the floor.
    let sleepers = (LENGTH / 0.75) as u32;
    for i in 0..sleepers {
        let here = station(i as f32 / sleepers as f32);
        let lowered = here.frame() * Affine3A::from_translation(Vec3::Y * (FLOOR - RADIUS + 0.04));
        let jitter = 0.08 * (hash(IVec3::new(i as i32, 0, 0), 3) - 0.5);
        let plank = block(Vec3::new(-0.62 + jitter, -0.10, -0.09), Vec3::new(0.62 + jitter, 0.07, 0.09));
        batch.add_at(wood, &plank, lowered);
    }
    for side in [-1.0, 1.0] {
        let steps = 480;
        for piece in 0..24 {
            let path: Vec<Vec3> = (0..=steps / 24)
                .map(|i| {
                    let here = station((piece * steps / 24 + i) as f32 / steps as f32);
                    here.at + here.right * (0.42 * side) - here.up * (RADIUS - FLOOR - 0.16)
                })
                .collect();
            batch.add(iron, &crate::world::shapes::tube(&path, 0.045, 8));
        }
    }
    crystals(world, &mut batch);
    batch.finish(world);
}

/// Clusters of six-sided crystals that grow out of the wall and glow faintly.
fn crystals(world: &mut World, batch: &mut Batch) {
    let kinds = [
        ([0.20, 0.55, 0.75], Vec3::new(0.005, 0.05, 0.09)),
        ([0.62, 0.25, 0.70], Vec3::new(0.06, 0.01, 0.08)),
        ([0.85, 0.62, 0.22], Vec3::new(0.09, 0.045, 0.005)),
    ]
    .map(|(albedo, emission)| world.material(Material { emission, ..Material::matt(albedo, 0.12) }));
    let crystal = crystal();
    for cluster in 0..46 {
        let key = IVec3::new(cluster, 0, 0);
        let turn = (cluster as f32 + 0.6 * hash(key, 1)) / 46.0;
        // On the lower walls to both sides.
        let side = if cluster % 2 == 0 { 1.0 } else { -1.0 };
        let around = side * (0.16 + 0.14 * hash(key, 2));
        let (at, inwards) = (wall(turn, around), -station(turn).across(around));
        for i in 0..7 {
            let random = |salt: u32| hash(IVec3::new(cluster, i, 1), salt) - 0.5;
            let lean = Vec3::new(random(1), random(2), random(3));
            let foot = at + 0.35 * (lean - inwards * lean.dot(inwards));
            let size = 0.55 + 1.0 * (random(4) + 0.5) * (if i == 0 { 1.3 } else { 0.8 });
            let place = upright(foot, inwards + 0.9 * lean) * Affine3A::from_scale(Vec3::splat(size));
            batch.add_at(kinds[cluster as usize % kinds.len()], &crystal, place);
        }
    }
}

/// A pointed prism of six flat sides along y.
fn crystal() -> MeshLevel {
    let mut level = MeshLevel::default();
    let corner = |i: u32, radius: f32, y: f32| {
        let (sin, cos) = (i as f32 / 6.0 * TAU).sin_cos();
        Vec3::new(radius * sin, y, radius * cos)
    };
    let uv = [Vec2::ZERO, Vec2::ONE];
    for i in 0..6 {
        let (low, high) = (|i| corner(i, 0.06, -0.15), |i| corner(i, 0.08, 0.42));
        level.quad([low(i), low(i + 1), high(i + 1), high(i)], uv);
        // The tip's triangle as two, so that none is empty.
        let tip = Vec3::Y * 0.62;
        level.quad([high(i), high(i + 1), 0.5 * (high(i + 1) + tip), tip], uv);
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The wall closes on itself both ways, and the camera never comes nearer to it than half a metre.
    #[test]
    fn the_camera_stays_inside() {
        for i in 0..20 {
            let t = i as f32 / 20.0;
            assert!(wall(0.0, t).distance(wall(1.0, t)) < 2e-2 && wall(t, 0.0).distance(wall(t, 1.0)) < 2e-2);
        }
        let path = path();
        let mut nearest = f64::MAX;
        let points: Vec<_> = (0..ALONG)
            .flat_map(|i| (0..AROUND).map(move |j| (i, j)))
            .map(|(i, j)| wall(i as f32 / ALONG as f32, j as f32 / AROUND as f32).as_dvec3())
            .collect();
        for i in 0..400 {
            let eye = path.pose(path.span_s() * f64::from(i) / 400.0).eye;
            nearest = points.iter().map(|p| p.distance_squared(eye)).fold(nearest, f64::min);
        }
        println!("nearest wall {:.2} m, round {:.0} s", nearest.sqrt(), path.span_s());
        assert!(nearest.sqrt() > 0.5);
    }
}
