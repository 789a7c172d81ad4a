//! A town of cubes in low sun: streets of gabled houses and tower blocks, a clock tower on a plaza, parks, trees, lamp
//! posts and cars. Nothing is curved, and there are edges in depth everywhere.

mod buildings;
mod props;
mod stuff;
mod voxels;

use super::parts::noise::{clouds, hash, pick};
use super::parts::sky::Sky;
use super::parts::{camera, openness};
use crate::contract::{MakeError, Scene, SceneLight, ToneMap};
use crate::gpu::Gpu;
use crate::mesh_scene;
use crate::world::{CameraPath, Environment, Object, World};
use buildings::Plot;
use experiments::catalogue::{Parameters, SceneInfo};
use experiments::display::Display;
use glam::{Affine3A, DVec3, IVec3, Quat, Vec2, Vec3};
use std::collections::BTreeMap;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use stuff::{ASPHALT, GRASS, LINE, PAVEMENT, PLAZA, ROCK};
use voxels::{Stuff, Voxels};

/// From one street's middle to the next, metres; cubes have sides of a metre.
const PITCH: i32 = 18;
/// Half the width of a street, its pavements included.
const STREET: i32 = 4;
/// Blocks on a side of the town.
const BLOCKS: i32 = 8;
/// Half the town's side, its outermost streets included.
const HALF: i32 = BLOCKS / 2 * PITCH + STREET;
/// Cells below the ground's surface.
const DEEP: i32 = 3;
/// Height of the box of cubes.
const TALL: i32 = 48;

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "voxel-town".to_owned(),
        version: 1,
        about:
            "A town of cubes in low sun, with edges in depth everywhere, flown through along its streets and over its \
                roofs."
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
        environment: Environment::of(sky().paint(256)),
        camera: camera::set(path(), parameters)?,
        light: SceneLight { exposure: 0.78, tone_map: ToneMap::Filmic },
        shadow_bounds: Some([Vec3::new(-90.0, -2.0, -90.0), Vec3::new(90.0, 50.0, 90.0)]),
        ..World::default()
    };
    let mut builder = Builder { world: &mut world, materials: BTreeMap::new() };
    builder.add(&town(), 38);
    builder.add(&hills(), 20);
    builder.plant();
    openness::bake(&mut world, 1.0, 12.0, 0.35);
    Ok(world)
}

fn sky() -> Sky {
    Sky {
        sun_towards: Vec3::new(-0.62, 0.55, 0.56),
        sun_colour: Vec3::new(2.6, 2.0, 1.35),
        zenith: Vec3::new(0.24, 0.34, 0.54),
        horizon: Vec3::new(0.80, 0.76, 0.70),
        ground: Vec3::new(0.30, 0.26, 0.20),
        clouds: 0.0,
        mountains: 0.0,
        seed: 8,
    }
}

/// The cell at the middle of the town, on the ground.
const MIDDLE: IVec3 = IVec3::new(HALF, DEEP, HALF);

/// Everything of the town that is made of cubes of a metre.
fn town() -> Voxels {
    let size = IVec3::new(2 * HALF, TALL + DEEP, 2 * HALF);
    let mut town = Voxels::new(Vec3::new(-HALF as f32, -DEEP as f32, -HALF as f32), 1.0, size);
    pave(&mut town);
    for row in 0..BLOCKS {
        for column in 0..BLOCKS {
            let corner = IVec3::new(column, 0, row) * PITCH + IVec3::new(2 * STREET, DEEP, 2 * STREET);
            let side = PITCH - 2 * STREET;
            let key = IVec3::new(column, row, 0);
            // The four blocks around the middle are the plaza.
            let on_plaza = [column, row].iter().all(|&i| (BLOCKS / 2 - 1..=BLOCKS / 2).contains(&i));
            if on_plaza {
                continue;
            }
            let whole = Plot { at: corner, width: side, depth: side, seed: 1 };
            match pick(key, 17, 10) {
                0 => buildings::park(&mut town, whole),
                1..=4 => buildings::tower(&mut town, whole),
                5 | 6 => {
                    // Two houses that share a wall.
                    let half = Plot { width: side / 2, ..whole };
                    buildings::house(&mut town, half);
                    buildings::house(&mut town, Plot { at: corner + IVec3::X * (side / 2), seed: 2, ..half });
                }
                7 => {
                    let half = Plot { depth: side / 2, ..whole };
                    buildings::house(&mut town, half);
                    buildings::tower(&mut town, Plot { at: corner + IVec3::Z * (side / 2), seed: 3, ..half });
                }
                _ => buildings::house(&mut town, Plot { seed: 4, ..whole }),
            }
        }
    }
    buildings::clock_tower(&mut town, MIDDLE);
    town
}

/// Streets with pavements and lines, blocks, and the plaza.
fn pave(town: &mut Voxels) {
    for z in 0..2 * HALF {
        for x in 0..2 * HALF {
            let (dx, dz) = (x - HALF, z - HALF);
            // How far from the nearest street's middle, in half cells, on either axis.
            let off = |d: i32| ((2 * d + 1 + PITCH).rem_euclid(2 * PITCH) - PITCH).abs();
            let (across, along) = (off(dx), off(dz));
            let road = 2 * (STREET - 1);
            let plaza = (-14..14).contains(&dx) && (-14..14).contains(&dz);
            let top = if plaza {
                PLAZA
            } else if across.min(along) < road {
                let dashes = |near: i32, far: i32, d: i32| near < 2 && far > road + 2 && d.rem_euclid(4) < 2;
                // A single line of cells left of the middle.
                let line = (dashes(across, along, dz) && dx.rem_euclid(PITCH) == 0)
                    || (dashes(along, across, dx) && dz.rem_euclid(PITCH) == 0);
                if line { LINE } else { ASPHALT }
            } else {
                PAVEMENT
            };
            town.fill(IVec3::new(x, 0, z), IVec3::new(x + 1, DEEP - 1, z + 1), ROCK);
            // Roads lie lower than pavements by what a cube allows: not at all; only parks are dug.
            town.set(IVec3::new(x, DEEP - 1, z), top);
        }
    }
}

/// Hills of larger cubes around the town.
fn hills() -> Voxels {
    const CELL: f32 = 4.0;
    let half = 60;
    let size = IVec3::new(2 * half, 14, 2 * half);
    let low = Vec3::new(-half as f32 * CELL, -2.0 * CELL, -half as f32 * CELL);
    let mut hills = Voxels::new(low, CELL, size);
    for z in 0..size.z {
        for x in 0..size.x {
            let at = Vec2::new((x - half) as f32 + 0.5, (z - half) as f32 + 0.5) * CELL;
            let away = at.abs().max_element();
            if away < HALF as f32 {
                continue;
            }
            let rise = ((away - HALF as f32) / 150.0).clamp(0.0, 1.0);
            let height = 26.0 * rise * (0.75 + 0.9 * clouds(Vec3::new(at.x, 0.0, at.y) / 55.0, 3, 6));
            let top = 2 + (height / CELL).round().max(0.0) as i32;
            hills.fill(IVec3::new(x, 0, z), IVec3::new(x + 1, top - 1, z + 1), ROCK);
            hills.set(IVec3::new(x, top - 1, z), if top > 9 { ROCK } else { GRASS });
        }
    }
    hills
}

/// Puts models of cubes into a world.
struct Builder<'a> {
    world: &'a mut World,
    /// By what they are made of.
    materials: BTreeMap<Stuff, usize>,
}

impl Builder<'_> {
    /// Adds the surface of `voxels` in pieces and returns the pairs of mesh and material.
    fn meshes(&mut self, voxels: &Voxels, piece: i32) -> Vec<(usize, usize)> {
        let parts = voxels.surface(piece);
        let add = |((stuff, _), level)| {
            let material = *self.materials.entry(stuff).or_insert_with(|| {
                self.world.materials.push(stuff::material(stuff));
                self.world.materials.len() - 1
            });
            (self.world.mesh(level), material)
        };
        parts.into_iter().map(add).collect()
    }

    fn add(&mut self, voxels: &Voxels, piece: i32) {
        for (mesh, material) in self.meshes(voxels, piece) {
            self.world.objects.push(Object::still(mesh, material));
        }
    }

    fn place(&mut self, model: &[(usize, usize)], at: Vec3, angle: f32, size: f32) {
        let at = Affine3A::from_scale_rotation_translation(Vec3::splat(size), Quat::from_rotation_y(angle), at);
        for &(mesh, material) in model {
            self.world.place(mesh, material, at);
        }
    }

    /// Trees, lamps and cars along the streets, trees in parks and on the hills, and clouds.
    fn plant(&mut self) {
        let mut model = |voxels: Voxels| self.meshes(&voxels, 1000);
        let trees: Vec<_> = [0, 1, 3, 2].into_iter().map(|variant| model(props::tree(variant))).collect();
        let (fir, lamp) = (model(props::fir()), model(props::lamp_post()));
        let cars: Vec<_> = (0..3).map(|variant| model(props::car(variant))).collect();
        let sky: Vec<_> = (0..3).map(|seed| model(props::cloud(seed + 20))).collect();
        let quarter = |key: IVec3, seed: u32| pick(key, seed, 4) as f32 * FRAC_PI_2;
        for street in -BLOCKS / 2..=BLOCKS / 2 {
            for block in -BLOCKS / 2..BLOCKS / 2 {
                for upright in [false, true] {
                    let middle_m = (street * PITCH) as f32;
                    let begin_m = (block * PITCH) as f32;
                    // Along z for upright streets, along x for the others.
                    let at = |along: f32, across: f32| {
                        let (a, b) = (begin_m + along, middle_m + across);
                        if upright { Vec3::new(b, 0.0, a) } else { Vec3::new(a, 0.0, b) }
                    };
                    let on_plaza = street == 0 && (-1..=0).contains(&block);
                    if on_plaza {
                        continue;
                    }
                    for side in [-1.0_f32, 1.0] {
                        let key = IVec3::new(street, block, i32::from(upright) * 2 + i32::from(side > 0.0));
                        let turn = if upright { 0.0 } else { -FRAC_PI_2 };
                        for (slot, along) in [6.5_f32, 11.5].into_iter().enumerate() {
                            let salt = 50 + slot as u32;
                            if hash(key, salt) < 0.6 {
                                let tree = &trees[pick(key, salt + 4, trees.len())];
                                let size = 0.72 + 0.2 * hash(key, salt + 8);
                                self.place(tree, at(along, 3.5 * side), quarter(key, salt), size);
                            }
                        }
                        let inwards = if side > 0.0 { PI } else { 0.0 };
                        self.place(&lamp, at(9.0, 3.3 * side), turn + inwards, 1.0);
                        if hash(key, 60) < 0.4 {
                            let along = 5.5 + 7.0 * hash(key, 61);
                            let car = &cars[pick(key, 62, cars.len())];
                            let turn = turn + if side > 0.0 { 0.0 } else { PI };
                            self.place(car, at(along, 2.05 * side), turn, 1.0);
                        }
                    }
                }
            }
        }
        // Around the plaza.
        for i in 0..12 {
            let (sin, cos) = ((i as f32 + 0.5) / 12.0 * TAU).sin_cos();
            let at = Vec3::new(11.8 * cos.signum() * cos.abs().sqrt(), 0.0, 11.8 * sin.signum() * sin.abs().sqrt());
            self.place(&trees[i % 3], at, 0.0, 0.7);
        }
        for i in 0..220 {
            let key = IVec3::new(i, 7, 0);
            let at = (Vec2::new(hash(key, 70), hash(key, 71)) - 0.5) * 440.0;
            let cell = ((at / 4.0).floor() + 0.5) * 4.0;
            if cell.abs().max_element() < HALF as f32 + 4.0 {
                continue;
            }
            let top = hill_top(cell);
            let tree = if hash(key, 72) < 0.6 { &fir } else { &trees[i as usize % trees.len()] };
            self.place(tree, Vec3::new(cell.x, top, cell.y), quarter(key, 73), 1.3 + 0.8 * hash(key, 74));
        }
        for (i, (x, y, z)) in [
            (-70.0, 78.0, -150.0),
            (40.0, 88.0, -190.0),
            (150.0, 80.0, -60.0),
            (-160.0, 84.0, 30.0),
            (90.0, 92.0, 150.0),
        ]
        .into_iter()
        .enumerate()
        {
            self.place(&sky[i % sky.len()], Vec3::new(x, y, z), 0.0, 1.0 + 0.2 * (i % 2) as f32);
        }
    }
}

/// Height of the hills' surface in the cell about `at`.
fn hill_top(at: Vec2) -> f32 {
    let away = at.abs().max_element();
    let rise = ((away - HALF as f32) / 150.0).clamp(0.0, 1.0);
    let height = 26.0 * rise * (0.75 + 0.9 * clouds(Vec3::new(at.x, 0.0, at.y) / 55.0, 3, 6));
    4.0 * (height / 4.0).round().max(0.0)
}

/// Along a street to the plaza, around the clock tower, up a street over the roofs, and down again.
fn path() -> CameraPath {
    let mut eyes = [
        [0.0, 2.6, 48.0],
        [0.0, 2.4, 36.0],
        [0.0, 2.6, 24.0],
        [1.0, 3.2, 14.5],
        [6.0, 4.2, 8.0],
        [7.8, 5.5, 0.0],
        [6.0, 6.6, -7.5],
        [1.0, 6.8, -15.0],
        [0.0, 5.0, -27.0],
        [1.0, 3.4, -34.5],
        [9.0, 3.0, -36.0],
        [22.0, 4.0, -36.0],
        [34.0, 7.0, -36.0],
        [36.0, 11.0, -28.0],
        [36.0, 18.0, -18.0],
        [36.0, 27.0, -6.0],
        [40.0, 36.0, 12.0],
        [48.0, 40.0, 40.0],
        [28.0, 43.0, 70.0],
        [-14.0, 43.0, 80.0],
        [-56.0, 41.0, 64.0],
        [-80.0, 39.0, 24.0],
        [-76.0, 37.0, -14.0],
        [-60.0, 34.0, -34.0],
        [-54.0, 25.0, -22.0],
        [-54.0, 13.0, -4.0],
        [-54.0, 7.0, 14.0],
        [-54.0, 4.0, 32.0],
        [-53.0, 3.2, 51.5],
        [-46.0, 3.0, 54.0],
        [-30.0, 2.8, 54.0],
        [-14.0, 2.7, 54.0],
        [-3.0, 2.6, 53.5],
    ]
    .map(DVec3::from);
    // It starts over the roofs.
    eyes.rotate_left(18);
    // Climbing, it still looks to the horizon, and from above the roofs over the town to the clock tower.
    let mut path = camera::ahead(&eyes, 12.0, 4.0, |along| DVec3::new(along.x, 0.2 * along.y, along.z));
    for key in &mut path.keys {
        let above = ((key.eye.y - 12.0) / 26.0).clamp(0.0, 1.0);
        let above = above * above * (3.0 - 2.0 * above);
        let to_tower = (DVec3::new(0.0, 14.0, 0.0) - key.eye).normalize_or(DVec3::NEG_Y);
        let along = key.target - key.eye;
        key.target = key.eye + along.lerp(to_tower, 0.85 * above);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The camera is never within half a metre of a cube.
    #[test]
    fn the_camera_flies_between_the_cubes() {
        let (town, path) = (town(), path());
        for i in 0..(path.span_s() * 20.0) as usize {
            let eye = path.pose(i as f64 / 20.0).eye.as_vec3();
            assert!(eye.y > 1.0, "{eye}");
            for corner in 0..8 {
                let offset = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2).as_vec3() - 0.5;
                assert_eq!(town.at(eye + 1.2 * offset), 0, "at {eye} after {:.1} s", i as f64 / 20.0);
            }
        }
    }
}
