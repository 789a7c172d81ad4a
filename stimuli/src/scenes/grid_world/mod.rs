//! The world of Guenter et al. 2012, §5 and §6: a terrain of some 20,000 triangles, above it a grid of 20×20 parametric
//! objects from diffuse to glossy with procedural shaders, around it mountains and clouds, and a camera that weaves
//! through the grid for several minutes.

mod materials;
mod shapes;

use super::parts::camera;
use super::parts::forms::lattice;
use super::parts::noise::{clouds, hash, pick, ridges, smoothstep};
use super::parts::sky::Sky;
use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::mesh_scene;
use crate::parameters::{number, text};
use crate::world::{CameraPath, Detail, Environment, Motion, Object, World};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;
use glam::{Affine3A, DVec3, IVec3, Quat, Vec2, Vec3};

/// Objects on a side of the grid.
const GRID: i32 = 20;
/// Metres between two objects.
const SPACING_M: f32 = 7.0;
/// Cells of the terrain on a side.
const CELLS: u32 = 100;
/// The camera's own pace, m/s.
const PACE_M_S: f64 = 2.2;

pub(crate) fn info() -> SceneInfo {
    let mut parameters = camera::schemas();
    parameters.push(ParameterSchema::choice(
        "objects_move",
        &["off", "on"],
        "Whether every third object spins about its own upright axis.",
    ));
    parameters.push(ParameterSchema::number(
        "pattern_samples",
        "",
        1.0..=64.0,
        1.0,
        "How many points of a procedural pattern are averaged in each pixel; whole numbers. More make smoother pictures of \
         an expensive shader.",
    ));
    SceneInfo {
        id: "grid-world".to_owned(),
        version: 1,
        about: "Four hundred objects from diffuse to glossy above a terrain among mountains, through which a camera \
                weaves (the world of Guenter et al. 2012)."
            .to_owned(),
        parameters,
        animated: true,
    }
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    mesh_scene::make(gpu, display, world(parameters)?)
}

/// The world for completed parameters.
pub(crate) fn world(parameters: &Parameters) -> Result<World, MakeError> {
    let moving = text(parameters, "objects_move")? == "on";
    let mut world = World {
        environment: Environment::of(sky().paint(1536)),
        camera: camera::set(path(), parameters)?,
        light: SceneLight { exposure: 0.64, tone_map: ToneMap::Filmic },
        pattern_samples: number(parameters, "pattern_samples")?.round() as u32,
        shadow_bounds: Some([Vec3::new(-80.0, -6.0, -80.0), Vec3::new(80.0, 10.0, 80.0)]),
        ..World::default()
    };
    place_terrain(&mut world);
    place_objects(&mut world, moving);
    Ok(world)
}

fn sky() -> Sky {
    Sky {
        sun_towards: Vec3::new(0.62, 0.50, 0.60),
        sun_colour: Vec3::new(2.1, 1.85, 1.5),
        zenith: Vec3::new(0.10, 0.24, 0.62),
        horizon: Vec3::new(0.50, 0.64, 0.84),
        ground: Vec3::new(0.16, 0.18, 0.12),
        clouds: 0.42,
        mountains: 0.17,
        seed: 11,
    }
}

/// Height of the terrain, metres: rolling under the grid, hills around it.
fn height_m(x: f32, z: f32) -> f32 {
    let at = Vec3::new(x, 0.0, z);
    let rolling = 2.2 * clouds(at / 34.0, 3, 21) + 0.25 * clouds(at / 6.0, 2, 22);
    let hills = smoothstep(80.0, 330.0, Vec2::new(x, z).length());
    rolling + hills * (34.0 * ridges(at / 130.0, 4, 23) - 4.0)
}

fn place_terrain(world: &mut World) {
    // Cells are finest in the middle: the sides of the grid lie where they are still smaller than an object.
    let side = |i: i32| {
        let s = 2.0 * i as f32 / CELLS as f32 - 1.0;
        75.0 * s + 325.0 * s.powi(5)
    };
    let place = |i: i32, j: i32| {
        let (x, z) = (side(i), -side(j));
        Vec3::new(x, height_m(x, z), z)
    };
    let uv = |i: i32, j: i32| Vec2::new(side(i), -side(j));
    let mesh = world.mesh(lattice(CELLS, CELLS, place, uv));
    let material = world.material(materials::terrain());
    world.objects.push(Object::still(mesh, material));
}

/// The middle of an object by its column and row.
fn middle(column: i32, row: i32) -> Vec3 {
    let [x, z] = [column, row].map(|i| (i as f32 - 0.5 * (GRID - 1) as f32) * SPACING_M);
    let lift = 2.3 + 0.9 * hash(IVec3::new(column, row, 0), 31);
    Vec3::new(x, height_m(x, z) + lift, z)
}

fn place_objects(world: &mut World, moving: bool) {
    let meshes: Vec<usize> = shapes::meshes().into_iter().map(|mesh| world.mesh(mesh)).collect();
    let materials: Vec<usize> = materials::materials().into_iter().map(|m| world.material(m)).collect();
    // A typical full view then has the paper's 250,000 triangles.
    let detail = Detail {
        near_m: 4.0,
        far_m: 48.0,
        most: f64::from(2 * shapes::MOST.pow(2)),
        fewest: f64::from(2 * shapes::FEWEST.pow(2)),
    };
    let mut before = (usize::MAX, usize::MAX);
    for row in 0..GRID {
        for column in 0..GRID {
            let cell = IVec3::new(column, row, 0);
            // Neighbours differ in shape and look.
            let mut shape = pick(cell, 41, meshes.len());
            let mut look = pick(cell, 42, materials::looks());
            shape = (shape + usize::from(shape == before.0)) % meshes.len();
            look = (look + usize::from(look == before.1)) % materials::looks();
            before = (shape, look);
            let finish = pick(cell, 43, materials::FINISHES);
            let turn = Quat::from_rotation_y(std::f32::consts::TAU * hash(cell, 44))
                * Quat::from_rotation_x(0.5 * (hash(cell, 45) - 0.5));
            let size = 0.85 + 0.2 * hash(cell, 46);
            let at = Affine3A::from_scale_rotation_translation(Vec3::splat(size), turn, middle(column, row));
            let spins = moving && (column + 2 * row) % 3 == 0;
            let motion = if spins {
                Motion::Spin { at, axis: Vec3::Y, speed_deg_s: f64::from(20.0 + 50.0 * hash(cell, 47)) }
            } else {
                Motion::Still(at)
            };
            let material = materials[look * materials::FINISHES + finish];
            world.objects.push(Object { mesh: meshes[shape], material, motion, detail: Some(detail) });
        }
    }
}

/// Around a rectangle of the grid's rows and columns, in serpentines that leave two objects on each side in turn.
fn path() -> CameraPath {
    let half = 0.5 * (GRID - 1) as f32;
    let line = |index: i32| f64::from((index as f32 - half) * SPACING_M);
    // Legs from corner to corner: column, row. With 15 and 11 steps a leg begins and ends outside the rectangle, so that
    // the path goes around the objects at its corners.
    let corners = [(2, 15), (17, 15), (17, 4), (2, 4)];
    let mut eyes = Vec::new();
    for (leg, &(column, row)) in corners.iter().enumerate() {
        let (to_column, to_row) = corners[(leg + 1) % corners.len()];
        let (from, to) = (DVec3::new(line(column), 0.0, line(row)), DVec3::new(line(to_column), 0.0, line(to_row)));
        let along = (to - from).normalize();
        let aside = DVec3::new(-along.z, 0.0, along.x);
        let spacing = f64::from(SPACING_M);
        let steps = (from.distance(to) / spacing).round() as i32;
        // Beside every object of the leg but the corners': left, left, right, right.
        for step in 1..steps {
            let side = if (step - 1) / 2 % 2 == 0 { 1.0 } else { -1.0 };
            let swing = 0.48 * spacing * side;
            let mut eye = from + along * (f64::from(step) * spacing) + aside * swing;
            let ground = f64::from(height_m(eye.x as f32, eye.z as f32));
            eye.y = ground + 3.2 + 0.8 * (0.9 * f64::from(step) + f64::from(leg as u32)).sin();
            eyes.push(eye);
        }
    }
    // Level, and slightly downwards, wherever the path climbs.
    camera::ahead(&eyes, 18.0, PACE_M_S, |along| DVec3::new(along.x, 0.25 * along.y - 0.05, along.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::catalogue::complete_parameters;

    fn built() -> World {
        let parameters = complete_parameters(&info().parameters, &Parameters::new()).expect("defaults are accepted");
        world(&parameters).expect("it can be built")
    }

    /// The paper's figures: a terrain of about 20,000 triangles, 20×20 objects of at most 20,000, and about 250,000
    /// triangles in view on the study's display (46.7° wide, 27.3° high).
    #[test]
    fn it_has_the_papers_counts() {
        let world = built();
        assert_eq!(world.objects.len(), 401);
        assert_eq!(world.meshes[world.objects[0].mesh].levels[0].triangles(), 20_000);
        let span_s = world.camera.span_s();
        let counts: Vec<f64> = (0..60)
            .map(|i| {
                let pose = world.camera.pose(span_s * f64::from(i) / 60.0);
                let seen = world.objects[1..].iter().filter_map(|object| {
                    let to = object.motion.at(0.0).translation.as_dvec3() - pose.eye;
                    let depth = to.dot(pose.forward);
                    let inside = |x: f64, half_deg: f64| {
                        x.abs() < depth * half_deg.to_radians().tan() + 1.5 / half_deg.to_radians().cos()
                    };
                    let seen = depth > -1.5 && inside(to.dot(pose.right), 23.4) && inside(to.dot(pose.up), 13.7);
                    seen.then(|| object.detail.map_or(0.0, |detail| detail.triangles(to.length(), 1.0)))
                });
                20_000.0 + seen.sum::<f64>()
            })
            .collect();
        let mean = counts.iter().sum::<f64>() / 60.0;
        let most = counts.iter().copied().fold(0.0, f64::max);
        println!("{mean:.0} triangles in view on average, {most:.0} at most, over {span_s:.0} s");
        assert!((200_000.0..300_000.0).contains(&mean));
        assert!((150.0..400.0).contains(&span_s));
    }

    /// The camera keeps a metre of air above the ground and never enters the ball around an object.
    #[test]
    fn the_camera_flies_free() {
        let path = path();
        let (mut lowest, mut nearest) = (f64::MAX, f64::MAX);
        let middles: Vec<DVec3> = (0..GRID * GRID).map(|i| middle(i % GRID, i / GRID).as_dvec3()).collect();
        for i in 0..(path.span_s() * 10.0) as usize {
            let eye = path.pose(i as f64 / 10.0).eye;
            lowest = lowest.min(eye.y - f64::from(height_m(eye.x as f32, eye.z as f32)));
            nearest = middles.iter().map(|m| m.distance(eye)).fold(nearest, f64::min);
        }
        println!("at least {lowest:.2} m above ground, {nearest:.2} m from the middle of an object");
        assert!(lowest > 1.0 && nearest > f64::from(1.05 * shapes::REACH_M));
    }
}
