//! Small models of finer cubes that stand in the town many times: trees, parked cars, lamp posts, clouds.

use super::stuff::{CAR, CLOUD, DARK, GLASS, LEAVES, LEAVES_AUTUMN, LEAVES_LIGHT, LIGHT, TRUNK};
use super::voxels::{Stuff, Voxels};
use crate::scenes::parts::noise::{hash, noise};
use glam::{IVec3, Vec3};

/// A broad tree, about 6 m high, on the origin.
pub(super) fn tree(variant: u32) -> Voxels {
    const CELL: f32 = 0.6;
    let size = IVec3::new(7, 11, 7);
    let mut tree = Voxels::new(Vec3::new(-3.5 * CELL, 0.0, -3.5 * CELL), CELL, size);
    let leaves = [LEAVES, LEAVES_LIGHT, LEAVES_AUTUMN][variant as usize % 3];
    tree.fill(IVec3::new(3, 0, 3), IVec3::new(4, 6, 4), TRUNK);
    let middle = Vec3::new(3.5, 7.2, 3.5);
    for y in 3..size.y {
        for z in 0..size.z {
            for x in 0..size.x {
                let cell = IVec3::new(x, y, z);
                let from = (cell.as_vec3() + 0.5 - middle) / Vec3::new(3.4, 3.8, 3.4);
                let rough = 0.5 * noise(cell.as_vec3() * 0.65 + 0.3, variant + 3) + 0.2 * hash(cell, variant);
                if from.length() + rough < 1.0 {
                    tree.set(cell, leaves);
                }
            }
        }
    }
    tree
}

/// A fir, about 7 m high.
pub(super) fn fir() -> Voxels {
    const CELL: f32 = 0.6;
    let mut tree = Voxels::new(Vec3::new(-3.5 * CELL, 0.0, -3.5 * CELL), CELL, IVec3::new(7, 12, 7));
    tree.fill(IVec3::new(3, 0, 3), IVec3::new(4, 11, 4), TRUNK);
    for y in 2..12 {
        let tier = (y - 2) % 3;
        let half: i32 = ((11 - y) / 3 + 2 - tier).clamp(0, 3);
        for z in -half..=half {
            for x in -half..=half {
                if x.abs() + z.abs() <= half + 1 {
                    tree.set(IVec3::new(3 + x, y, 3 + z), LEAVES);
                }
            }
        }
    }
    tree
}

/// A car, 4 m long towards −z.
pub(super) fn car(variant: usize) -> Voxels {
    const CELL: f32 = 0.25;
    let paint = CAR[variant % CAR.len()];
    let mut car = Voxels::new(Vec3::new(-3.5 * CELL, 0.0, -8.0 * CELL), CELL, IVec3::new(7, 7, 16));
    let mut part = |low: [i32; 3], high: [i32; 3], stuff: Stuff| car.fill(low.into(), high.into(), stuff);
    part([0, 1, 0], [7, 4, 16], paint);
    part([1, 4, 4], [6, 6, 13], GLASS);
    part([1, 6, 5], [6, 7, 12], paint);
    part([0, 4, 8], [7, 6, 9], paint);
    for z in [2, 11] {
        part([0, 0, z], [1, 2, z + 3], DARK);
        part([6, 0, z], [7, 2, z + 3], DARK);
    }
    part([0, 2, 0], [2, 3, 1], LIGHT);
    part([5, 2, 0], [7, 3, 1], LIGHT);
    car
}

/// A lamp post, 4 m high, whose arm reaches to +x.
pub(super) fn lamp_post() -> Voxels {
    const CELL: f32 = 0.28;
    let mut post = Voxels::new(Vec3::new(-0.5 * CELL, 0.0, -0.5 * CELL), CELL, IVec3::new(5, 15, 1));
    post.fill(IVec3::new(0, 0, 0), IVec3::new(1, 15, 1), DARK);
    post.fill(IVec3::new(1, 14, 0), IVec3::new(5, 15, 1), DARK);
    post.fill(IVec3::new(3, 13, 0), IVec3::new(5, 14, 1), LIGHT);
    post
}

/// A cloud of large cubes.
pub(super) fn cloud(seed: u32) -> Voxels {
    let size = IVec3::new(14, 4, 9);
    let mut cloud = Voxels::new(-2.5 * size.as_vec3() * Vec3::new(0.5, 0.0, 0.5), 2.5, size);
    for y in 0..size.y {
        for z in 0..size.z {
            for x in 0..size.x {
                let cell = IVec3::new(x, y, z);
                let from = (cell.as_vec3() + 0.5) / size.as_vec3() - Vec3::new(0.5, 0.1, 0.5);
                let rough = 0.34 * noise(cell.as_vec3() * Vec3::new(0.33, 0.4, 0.33) + 0.4, seed);
                if (from * Vec3::new(2.0, 1.15, 2.0)).length() + rough < 0.78 {
                    cloud.set(cell, CLOUD);
                }
            }
        }
    }
    cloud
}
