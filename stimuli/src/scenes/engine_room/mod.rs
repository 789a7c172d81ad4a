//! An engine room: an engine of six cylinders that drives gears and a flywheel, tanks, pipes, valves, gauges and cables
//! around a catwalk of grating. Dense, shiny and full of fine highlights, in sunlight from roof lights and under lamps.

mod gears;
mod machines;
mod pipes;
mod stuff;

use super::parts::forms::{circle, lattice, plate, rod};
use super::parts::noise::smoothstep;
use super::parts::{Batch, camera, openness};
use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::mesh_scene;
use crate::world::shapes::{block, lathe, sphere, upright};
use crate::world::{CameraPath, Environment, Light, MeshLevel, Motion, Object, Panorama, World};
use experiments::catalogue::{Parameters, SceneInfo};
use experiments::display::Display;
use gears::Gear;
use glam::{Affine3A, DVec3, Quat, Vec2, Vec3};
use pipes::{bracket, gauge, run, valve};
use std::f32::consts::FRAC_PI_2;
use stuff::Stuff;

/// Half the room's length and width, and its height, metres.
const ROOM: Vec3 = Vec3::new(14.0, 8.6, 9.0);
/// Where the catwalk's middle runs: half its rectangle's length and width, and its height.
const WALK: Vec3 = Vec3::new(8.6, 3.1, 4.2);
/// Half the catwalk's width.
const WALK_HALF: f32 = 0.65;
/// How fast the engine's first gear turns, degrees per second.
const GEAR_DEG_S: f64 = 32.0;

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "engine-room".to_owned(),
        version: 1,
        about: "A dense engine room of shiny pipes, tanks, valves and gears that turn, walked around on a catwalk."
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
        environment: Environment::of(surroundings()),
        camera: camera::set(path(), parameters)?,
        light: SceneLight { exposure: 0.80, tone_map: ToneMap::Filmic },
        ..World::default()
    };
    let stuff = Stuff::of(&mut world);
    let mut batch = Batch::new(7.0);
    build_room(&mut world, &mut batch, &stuff);
    build_catwalk(&mut batch, &stuff);
    machines::engine(&mut batch, &stuff);
    machines::tanks(&mut batch, &stuff, -ROOM.z);
    machines::cables(&mut batch, &stuff, 7.4, 5.9);
    build_pipe_wall(&mut batch, &stuff);
    build_ends(&mut world, &mut batch, &stuff);
    batch.finish(&mut world);
    openness::bake(&mut world, 0.2, 2.6, 0.2);
    let sun =
        Light::Directional { towards: Vec3::new(-0.38, 0.82, 0.42).normalize(), colour: Vec3::new(2.9, 2.4, 1.75) };
    world.lights.insert(0, sun);
    Ok(world)
}

/// What the metal mirrors and the corners are lit by: roof lights and lamps over dim walls and a brown floor.
fn surroundings() -> Panorama {
    Panorama::painted(256, |d| {
        let wall = Vec3::new(0.40, 0.41, 0.42).lerp(Vec3::new(0.20, 0.16, 0.12), smoothstep(0.1, -0.6, d.y));
        let mut light = wall * (1.0 + 0.6 * (9.0 * f32::atan2(d.z, d.x)).sin() * smoothstep(0.5, 0.1, d.y.abs()));
        if d.y > 0.12 {
            // Places on a ceiling at a height of 1: two long roof lights, and rows of lamps between them.
            let at = Vec2::new(d.x, d.z) / d.y;
            let strip = |x: f32, half: f32| smoothstep(half + 0.06, half - 0.06, x.abs());
            let roof_light = strip(at.y.abs() - 0.55, 0.16) * strip(at.x, 2.6);
            let lamp = strip(at.y, 0.07) * strip((at.x + 0.4).rem_euclid(0.8) - 0.4, 0.25) * strip(at.x, 3.0);
            light = light.lerp(Vec3::splat(0.10), 0.6);
            light += Vec3::new(1.7, 1.9, 2.2) * roof_light + Vec3::new(2.2, 1.6, 0.9) * lamp;
        }
        // Daylight behind the fans at one end.
        let window = smoothstep(0.90, 0.97, -d.x) * smoothstep(0.3, 0.2, d.y.abs());
        light + Vec3::new(0.9, 1.2, 1.5) * window
    })
}

/// A flat rectangle at `at` from its lower left corner, by the vectors to the right and up, in cells of `cell_m`.
fn panel(at: Vec3, right: Vec3, up: Vec3, cell_m: f32) -> MeshLevel {
    let (long, high) = (right.length(), up.length());
    let cells = [long, high].map(|m| (m / cell_m).ceil().max(1.0));
    let place = |i: i32, j: i32| at + right * (i as f32 / cells[0]) + up * (j as f32 / cells[1]);
    lattice(cells[0] as u32, cells[1] as u32, place, |i, j| {
        Vec2::new(long * i as f32 / cells[0], high * (1.0 - j as f32 / cells[1]))
    })
}

fn build_room(world: &mut World, batch: &mut Batch, stuff: &Stuff) {
    let Vec3 { x, y, z } = ROOM;
    batch.add(stuff.plate, &panel(Vec3::new(-x, 0.0, z), Vec3::X * (2.0 * x), Vec3::Z * (-2.0 * z), 0.4));
    let dado = 1.5;
    for (corner, right) in [
        (Vec3::new(-x, 0.0, -z), Vec3::X * (2.0 * x)),
        (Vec3::new(x, 0.0, -z), Vec3::Z * (2.0 * z)),
        (Vec3::new(x, 0.0, z), Vec3::X * (-2.0 * x)),
        (Vec3::new(-x, 0.0, z), Vec3::Z * (-2.0 * z)),
    ] {
        batch.add(stuff.dado, &panel(corner, right, Vec3::Y * dado, 0.5));
        batch.add(stuff.wall, &panel(corner + Vec3::Y * dado, right, Vec3::Y * (y - dado), 0.5));
        // Outside, for the shadow.
        batch.add(stuff.wall, &panel(corner + right, -right, Vec3::Y * y, 4.0));
        let inwards = right.cross(Vec3::Y).normalize() * 0.03;
        batch.add(stuff.hazard, &panel(corner + inwards + Vec3::Y * dado, right, Vec3::Y * 0.10, 0.5));
    }
    // The roof leaves two long lights open; beams cross them.
    let (low, high) = (2.6, 4.4);
    for (a, b) in [(-z, -high), (-low, low), (high, z)] {
        batch.add(stuff.wall, &block(Vec3::new(-x, y, a), Vec3::new(x, y + 0.3, b)));
    }
    for i in 0..8 {
        let at = -x + (i as f32 + 0.5) * x / 4.0;
        beam(batch, stuff, at, y);
    }
    for side in [-1.0, 1.0] {
        for bar in 0..29 {
            let at = -x + bar as f32;
            let glazing =
                block(Vec3::new(at - 0.04, y + 0.1, side * 3.5 - 0.9), Vec3::new(at + 0.04, y + 0.2, side * 3.5 + 0.9));
            batch.add(stuff.iron, &glazing);
        }
    }
    // Lamps that hang in a row over the engine.
    for i in 0..2 {
        let at = Vec3::new(-4.5 + 9.0 * i as f32, 6.9, 0.0);
        let shade = block(at + Vec3::new(-2.3, 0.03, -0.22), at + Vec3::new(2.3, 0.16, 0.22));
        batch.add(stuff.green, &shade);
        let face = panel(at + Vec3::new(-2.25, 0.02, -0.17), Vec3::X * 4.5, Vec3::Z * 0.34, 1.0);
        batch.add(stuff.lamp, &face);
        for end in [-1.9, 1.9] {
            batch.add(stuff.iron, &rod(at + Vec3::new(end, 0.16, 0.0), Vec3::new(at.x + end, y, 0.0), 0.015, 6));
        }
        world.lights.push(Light::Area {
            at,
            half_right: Vec3::X * 2.25,
            half_up: Vec3::Z * 0.17,
            colour: Vec3::new(5.2, 5.6, 6.0),
        });
    }
    // Warm bulkhead lamps on the long walls.
    for i in 0..3 {
        for side in [-1.0, 1.0] {
            let at = Vec3::new(-9.0 + 9.0 * i as f32, 3.6, side * (z - 0.12));
            let facing = upright(at, Vec3::NEG_Z * side);
            batch.add_at(stuff.iron, &lathe(&[[0.2, -0.12], [0.2, 0.02], [0.15, 0.03]], 24), facing);
            batch.add_at(stuff.warm_lamp, &sphere(0.14, 10), facing * Affine3A::from_translation(Vec3::Y * 0.03));
            let light = at - Vec3::Z * (side * 0.35);
            world.lights.push(Light::Point { at: light, colour: Vec3::new(1.5, 0.85, 0.34), reach_m: 6.0 });
        }
    }
}

/// A beam of H-section across the room.
fn beam(batch: &mut Batch, stuff: &Stuff, x: f32, roof: f32) {
    let bar = |low: f32, high: f32, half: f32| {
        block(Vec3::new(x - half, roof - high, -ROOM.z), Vec3::new(x + half, roof - low, ROOM.z))
    };
    for (low, high, half) in [(0.0, 0.05, 0.16), (0.05, 0.45, 0.03), (0.45, 0.50, 0.16)] {
        batch.add(stuff.iron, &bar(low, high, half));
    }
    for side in [-1.0, 1.0] {
        let z = side * (ROOM.z - 0.12);
        batch.add(stuff.iron, &block(Vec3::new(x - 0.16, 0.0, z - 0.12), Vec3::new(x + 0.16, roof - 0.5, z + 0.12)));
    }
}

/// The catwalk: grating on bearers, kickboards, and rails on posts.
fn build_catwalk(batch: &mut Batch, stuff: &Stuff) {
    let (lx, lz, y) = (WALK.x, WALK.z, WALK.y);
    // The four sides: from, to.
    let corners = [Vec3::new(-lx, y, lz), Vec3::new(lx, y, lz), Vec3::new(lx, y, -lz), Vec3::new(-lx, y, -lz)];
    for i in 0..4 {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        let along = (to - from).normalize();
        let aside = along.cross(Vec3::Y);
        let (begin, end) = (from - along * WALK_HALF, to - along * WALK_HALF);
        let length = begin.distance(end);
        let frame = Affine3A::from_mat3_translation(glam::Mat3::from_cols(along, Vec3::Y, aside), begin);
        // Bars along, and thinner ones across.
        for bar in 0..=16 {
            let z = WALK_HALF * (bar as f32 / 8.0 - 1.0);
            let part = block(Vec3::new(0.0, -0.04, z - 0.008), Vec3::new(length, 0.0, z + 0.008));
            batch.add_at(stuff.grating, &part, frame);
        }
        for bar in 0..=(length / 0.09) as u32 {
            let x = bar as f32 * 0.09;
            let part = block(Vec3::new(x - 0.006, -0.025, -WALK_HALF), Vec3::new(x + 0.006, -0.006, WALK_HALF));
            batch.add_at(stuff.grating, &part, frame);
        }
        for side in [-1.0, 1.0] {
            let z = side * WALK_HALF;
            let bearer = block(Vec3::new(0.0, -0.22, z - 0.03), Vec3::new(length, 0.10, z + 0.03));
            batch.add_at(stuff.yellow, &bearer, frame);
        }
        // Rails: the outer one goes around the corner, the inner one ends before the next side's.
        for (side, low, high) in [(1.0, 2.0 * WALK_HALF, length), (-1.0, 0.0, length + 2.0 * WALK_HALF)] {
            // The loop turns to the right, so that its left side is the outer one.
            let z = side * WALK_HALF;
            for height in [0.55, 1.05] {
                let at = |x: f32| frame.transform_point3(Vec3::new(x, height, z));
                batch.add(stuff.yellow, &rod(at(low), at(high), 0.026, 12));
            }
            let posts = ((high - low) / 1.5).round();
            for post in 0..=posts as u32 {
                let x = low + (high - low) * post as f32 / posts;
                let at = |y: f32| frame.transform_point3(Vec3::new(x, y, z));
                batch.add(stuff.yellow, &rod(at(-0.1), at(1.06), 0.024, 10));
                batch.add_to(stuff.brass, &sphere(0.04, 8), at(1.07));
            }
        }
        // Columns under it.
        for post in 0..=(length / 4.0) as u32 {
            let at = frame.transform_point3(Vec3::new(post as f32 * 4.0 + 0.2, -0.2, 0.0));
            batch.add(stuff.iron, &rod(at.with_y(0.0), at, 0.07, 14));
        }
    }
}

/// The long wall at +z: a rack of pipes at many heights with valves and gauges.
fn build_pipe_wall(batch: &mut Batch, stuff: &Stuff) {
    let wall = ROOM.z;
    let pipes = [
        (stuff.red, 0.16, 1.2, 0.55),
        (stuff.copper, 0.10, 1.75, 0.45),
        (stuff.steel, 0.20, 2.35, 0.60),
        (stuff.green, 0.13, 3.0, 0.50),
        (stuff.copper, 0.08, 4.35, 0.40),
        (stuff.blue, 0.18, 4.85, 0.60),
        (stuff.chrome, 0.06, 5.3, 0.40),
        (stuff.yellow, 0.14, 5.75, 0.55),
        (stuff.steel, 0.24, 6.5, 0.70),
    ];
    for (i, &(material, radius, y, off)) in pipes.iter().enumerate() {
        let z = wall - off;
        // Every pipe leaves the wall at a place of its own, up or down.
        let leave = -9.0 + 2.3 * i as f32;
        let up = i % 2 == 0;
        let far = if up { ROOM.y } else { 0.0 };
        let corners = [
            Vec3::new(-ROOM.x, y, z),
            Vec3::new(leave, y, z),
            Vec3::new(leave, y, z - 0.55),
            Vec3::new(leave, far, z - 0.55),
        ];
        run(batch, material, stuff.steel, &corners, radius, 2.6);
        let rest =
            [Vec3::new(leave + 1.1, far, z - 0.5), Vec3::new(leave + 1.1, y, z - 0.5), Vec3::new(ROOM.x, y, z - 0.5)];
        run(batch, material, stuff.steel, &rest, radius, 3.1);
        for k in 0..8 {
            let x = -12.6 + 3.1 * k as f32 + 0.23 * i as f32;
            let here = if x < leave - 0.6 { z } else { z - 0.5 };
            if (x - leave).abs() > 0.6 && (x - leave - 1.1).abs() > 0.6 {
                bracket(batch, stuff, Vec3::new(x, y, here), Vec3::new(x, y, wall), radius);
            }
        }
        let at = Vec3::new(if leave < 0.0 { leave + 4.2 } else { leave - 4.2 }, y, 0.0);
        let here = if at.x < leave { z } else { z - 0.5 };
        let paint = [stuff.green, stuff.brass, stuff.blue][i % 3];
        if radius > 0.07 {
            valve(batch, stuff, paint, at.with_z(here), Vec3::X, Vec3::new(0.0, 0.5, -1.0).normalize(), radius);
        }
        for k in 0..2 {
            let x = at.x + 1.6 + 1.9 * k as f32;
            let here = if x < leave { z } else { z - 0.5 };
            let foot = Vec3::new(x, y, here);
            let head = foot + Vec3::new(0.0, 0.12, -radius - 0.16);
            batch.add(stuff.brass, &rod(foot, head, 0.022, 8));
            gauge(batch, stuff, head, Vec3::new(0.0, 0.15, -1.0), 0.13, 0.15 + 0.17 * ((i + 3 * k) % 5) as f32);
        }
    }
}

/// The ends: gears and a flywheel on the engine, fans in one wall, a control desk at the other.
fn build_ends(world: &mut World, batch: &mut Batch, stuff: &Stuff) {
    // The train of gears at the engine's +x end, in a plane whose x runs to −z.
    let face =
        Affine3A::from_rotation_translation(Quat::from_rotation_y(FRAC_PI_2), Vec3::new(5.35, machines::SHAFT_Y, 0.0));
    let first = Gear { teeth: 30, at: Vec2::ZERO, phase: 0.0, speed_deg_s: GEAR_DEG_S };
    let left = first.driving(18, 2.2);
    let right = first.driving(22, 0.75);
    let top = right.driving(40, 1.55);
    let small = top.driving(14, 2.9);
    for (gear, material, half) in [
        (first, stuff.steel, 0.13),
        (left, stuff.brass, 0.11),
        (right, stuff.brass, 0.11),
        (top, stuff.steel, 0.10),
        (small, stuff.copper, 0.12),
    ] {
        let mesh = world.mesh(gear.wheel(half));
        world.objects.push(Object { motion: gear.motion(face), ..Object::still(mesh, material) });
        let at = |x: f32| face.transform_point3(gear.at.extend(x));
        batch.add(stuff.chrome, &rod(at(-0.5), at(0.30), 0.06, 16));
    }
    // Its back plate.
    let back = face.transform_point3(Vec3::new(0.35, 0.9, -0.32));
    batch.add(stuff.green, &block(back + Vec3::new(-0.10, -1.9, -1.5), back + Vec3::new(0.04, 0.9, 1.5)));
    // The flywheel and its shaft at the other end.
    let wheel = world.mesh(gears::flywheel(1.45));
    let at =
        Affine3A::from_rotation_translation(Quat::from_rotation_y(FRAC_PI_2), Vec3::new(-5.75, machines::SHAFT_Y, 0.0));
    world.objects.push(Object {
        motion: Motion::Spin { at, axis: Vec3::Z, speed_deg_s: GEAR_DEG_S },
        ..Object::still(wheel, stuff.red)
    });
    let shaft = |x: f32| Vec3::new(x, machines::SHAFT_Y, 0.0);
    batch.add(stuff.chrome, &rod(shaft(-7.4), shaft(-4.9), 0.16, 28));
    batch.add(stuff.iron, &block(Vec3::new(-7.5, 0.0, -0.55), Vec3::new(-6.7, 1.25, 0.55)));
    batch.add(stuff.blue, &rod(shaft(-7.55), shaft(-6.65), 0.42, 32));
    fans(world, batch, stuff);
    desk(batch, stuff);
}

/// Two fans in the wall at −x with daylight behind them.
fn fans(world: &mut World, batch: &mut Batch, stuff: &Stuff) {
    let fan = world.mesh(gears::fan(1.25));
    for z in [-3.6, 3.6] {
        let at = Vec3::new(-ROOM.x + 0.25, 5.9, z);
        let turn = Quat::from_rotation_y(FRAC_PI_2);
        let frame = Affine3A::from_rotation_translation(turn, at);
        let speed_deg_s = if z > 0.0 { 70.0 } else { -55.0 };
        let motion = Motion::Spin { at: frame, axis: Vec3::Z, speed_deg_s };
        world.objects.push(Object { motion, ..Object::still(fan, stuff.iron) });
        let housing = plate(&circle(1.55, 48), &circle(1.30, 48), 0.24);
        batch.add_at(stuff.yellow, &housing, frame);
        let light = plate(&circle(1.30, 48), &[Vec2::ZERO; 48], 0.02);
        batch.add_at(stuff.lamp, &light, frame * Affine3A::from_translation(Vec3::Z * -0.2));
        for ring in 1..=3 {
            let radius = 0.42 * ring as f32;
            let guard =
                super::parts::forms::torus(radius, 0.014, 48, 6).transformed(Affine3A::from_rotation_x(FRAC_PI_2));
            batch.add_at(stuff.grating, &guard, frame * Affine3A::from_translation(Vec3::Z * 0.2));
        }
        for bar in 0..4 {
            let direction = Vec2::from_angle(bar as f32 * FRAC_PI_2 / 2.0) * 1.32;
            let guard = rod(direction.extend(0.2), (-direction).extend(0.2), 0.016, 6);
            batch.add_at(stuff.grating, &guard, frame);
        }
        world.lights.push(Light::Point { at: at + Vec3::X * 1.0, colour: Vec3::new(1.4, 1.7, 2.0), reach_m: 7.0 });
    }
}

/// The control desk at +x: a cabinet with gauges, signal lamps and levers.
fn desk(batch: &mut Batch, stuff: &Stuff) {
    let x = ROOM.x;
    batch.add(stuff.cream, &block(Vec3::new(x - 0.9, 0.0, -4.0), Vec3::new(x, 5.6, 4.0)));
    batch.add(stuff.iron, &block(Vec3::new(x - 1.5, 0.0, -4.2), Vec3::new(x - 0.9, 1.0, 4.2)));
    for row in 0..4 {
        for column in 0..9 {
            let at = Vec3::new(x - 0.92, 1.9 + 0.85 * row as f32, -3.4 + 0.85 * column as f32);
            match (row + 2 * column) % 4 {
                0 | 1 => {
                    let share = ((3 * row + 5 * column) % 9) as f32 / 9.0;
                    gauge(batch, stuff, at - Vec3::X * 0.08, Vec3::NEG_X, 0.27, share);
                }
                2 => {
                    for k in 0..4 {
                        let lamp = at + Vec3::new(0.0, 0.16 * (k / 2 * 2 - 1) as f32, 0.16 * (k % 2 * 2 - 1) as f32);
                        let which = (row * 5 + column * 3 + k) as usize % 3;
                        batch.add_to(stuff.signals[which], &sphere(0.06, 8), lamp);
                        let collar = lathe(&[[0.085, 0.0], [0.085, 0.04], [0.06, 0.05]], 16);
                        batch.add_at(stuff.chrome, &collar, upright(lamp, Vec3::NEG_X));
                    }
                }
                _ => {
                    batch.add_at(
                        stuff.chrome,
                        &lathe(&[[0.16, 0.0], [0.16, 0.04], [0.0, 0.05]], 24),
                        upright(at, Vec3::NEG_X),
                    );
                    let tip = at + Vec3::new(-0.42, 0.2, 0.0);
                    batch.add(stuff.steel, &rod(at, tip, 0.025, 10));
                    batch.add_to(stuff.red, &sphere(0.06, 10), tip);
                }
            }
        }
    }
    // Conduits from the desk to the roof.
    for k in 0..7 {
        let z = -3.3 + 1.1 * k as f32;
        let corners = [
            Vec3::new(x - 0.4, 5.6, z),
            Vec3::new(x - 0.4, 7.0, z),
            Vec3::new(x - 0.4, 7.0, z * 1.5),
            Vec3::new(x - 0.4, ROOM.y, z * 1.5),
        ];
        run(batch, [stuff.steel, stuff.copper][k % 2], stuff.brass, &corners, 0.06, 5.0);
    }
}

/// Once around the catwalk, looking inwards and ahead.
fn path() -> CameraPath {
    let (x, z) = (f64::from(WALK.x), f64::from(WALK.z));
    let eye_y = f64::from(WALK.y) + 1.65;
    let places = [
        ([x - 0.4, z - 1.0], [-5.0, 2.4, -4.0]),
        ([x - 1.2, z], [-6.0, 2.6, -3.0]),
        ([5.0, z], [-5.0, 2.8, -1.5]),
        ([1.5, z], [-8.0, 2.6, -1.0]),
        ([-2.0, z], [-8.5, 2.4, -2.5]),
        ([-5.5, z], [-10.0, 3.2, -9.0]),
        ([-x + 1.2, z], [-7.0, 3.4, -9.0]),
        ([-x, z - 1.2], [-4.0, 3.2, -9.0]),
        ([-x, 0.0], [3.0, 3.0, -8.0]),
        ([-x, 1.2 - z], [5.0, 3.4, -7.0]),
        ([1.2 - x, -z], [6.0, 3.6, -6.4]),
        ([-5.0, -z], [9.0, 3.6, -6.0]),
        ([-1.5, -z], [13.0, 3.6, -5.0]),
        ([2.0, -z], [14.0, 3.7, -2.0]),
        ([5.5, -z], [14.0, 3.6, 2.0]),
        ([x - 1.2, -z], [12.0, 3.8, 8.0]),
        ([x, 1.2 - z], [5.0, 3.8, 9.0]),
        ([x, 0.0], [-3.0, 3.4, 7.0]),
    ];
    let mut places = places.map(|([x, z], target)| (DVec3::new(x, eye_y, z), DVec3::from(target)));
    // It starts with the row of tanks in view.
    places.rotate_left(9);
    camera::round(&places, 0.75)
}
