//! The town's buildings, cube by cube: gabled houses in rows, towers with balconies, a clock tower on the plaza, parks.

use super::stuff::{self, AWNING, DARK, GLASS, GOLD, GRASS, PAVEMENT, PLAZA, ROOF, SLATE, STONE, WATER, WOOD};
use super::voxels::{Stuff, Voxels};
use crate::scenes::parts::noise::{hash, pick};
use glam::IVec3;

/// A plot of land: its lowest corner on the ground and its size, cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plot {
    pub(super) at: IVec3,
    pub(super) width: i32,
    pub(super) depth: i32,
    pub(super) seed: u32,
}

impl Plot {
    fn random(&self, salt: u32) -> f32 {
        hash(self.at, self.seed.wrapping_mul(31).wrapping_add(salt))
    }

    fn choice(&self, salt: u32, count: usize) -> usize {
        pick(self.at, self.seed.wrapping_mul(31).wrapping_add(salt), count)
    }
}

/// Four walls with windows on every second column, in storeys of three cells, from the ground up to `high`.
fn walls(town: &mut Voxels, plot: Plot, high: i32, colour: usize, corner: Stuff) {
    let Plot { at, width, depth, .. } = plot;
    for y in 0..high {
        for z in 0..depth {
            for x in 0..width {
                let outer_x = x == 0 || x == width - 1;
                let outer_z = z == 0 || z == depth - 1;
                let along = if outer_x { z } else { x };
                let last = if outer_x { depth - 1 } else { width - 1 };
                let stuff = match (outer_x, outer_z) {
                    (true, true) => corner,
                    (false, false) => stuff::wall(colour, false),
                    // The ground floor has shop windows and doors.
                    _ if y < 2 && along % 3 != 0 => GLASS,
                    _ if y == 2 => corner,
                    _ => stuff::wall(colour, (along % 2 == 1 || along == last - 1) && y % 3 == 1),
                };
                town.set(at + IVec3::new(x, y, z), stuff);
            }
        }
    }
}

/// A house with a stepped gable roof, whose ridge runs along the longer side.
pub(super) fn house(town: &mut Voxels, plot: Plot) {
    let Plot { at, width, depth, .. } = plot;
    let high = 4 + 3 * (1 + plot.choice(1, 3) as i32);
    let colour = plot.choice(2, stuff::WALL_COLOURS);
    let trim = [STONE, WOOD, stuff::wall(2, false)][plot.choice(3, 3)];
    walls(town, plot, high, colour, trim);
    // Cross beams between storeys and an awning over the shop.
    let roof = if plot.random(4) < 0.65 { ROOF } else { SLATE };
    let along_x = width > depth;
    let span = if along_x { depth } else { width };
    for step in 0..=span / 2 {
        let (low, top) = (step - 1, span - step + 1);
        let y = high + step;
        // The eaves stand out by one cell.
        let (a, b) = if along_x {
            (IVec3::new(-1, y, low), IVec3::new(width + 1, y + 1, top))
        } else {
            (IVec3::new(low, y, -1), IVec3::new(top, y + 1, depth + 1))
        };
        if low < top {
            town.fill(at + a, at + b, roof);
        }
        // The gables' walls within the eaves.
        let (a, b) = if along_x {
            (IVec3::new(0, y, low + 1), IVec3::new(width, y + 1, top - 1))
        } else {
            (IVec3::new(low + 1, y, 0), IVec3::new(top - 1, y + 1, depth))
        };
        if low + 1 < top - 1 {
            town.fill(at + a, at + b, stuff::wall(colour, false));
        }
    }
    // A chimney beside the ridge.
    let chimney = at + IVec3::new(1 + plot.choice(5, 2) as i32, high, 1 + plot.choice(6, 3) as i32);
    town.fill(chimney, chimney + IVec3::new(1, span / 2 + 3, 1), STONE);
    town.set(chimney + IVec3::Y * (span / 2 + 3), DARK);
    // An awning over the shop, to a side of the street.
    if plot.random(7) < 0.6 {
        let z = if plot.random(8) < 0.5 { -1 } else { depth };
        town.fill(at + IVec3::new(1, 2, z), at + IVec3::new(width - 1, 3, z + 1), AWNING);
    }
}

/// A tower block with cornices, balconies, and a roof with a parapet, a tank or a garden.
pub(super) fn tower(town: &mut Voxels, plot: Plot) {
    let Plot { at, width, depth, .. } = plot;
    let storeys = 4 + plot.choice(1, 5) as i32;
    let high = 4 + 3 * storeys;
    let colour = plot.choice(2, stuff::WALL_COLOURS);
    let trim = [STONE, stuff::wall(2, false), stuff::wall(5, false)][plot.choice(3, 3)];
    walls(town, plot, high, colour, trim);
    let ring = |town: &mut Voxels, y: i32, out: i32, stuff: Stuff| {
        let (low, top) = (at + IVec3::new(-out, y, -out), at + IVec3::new(width + out, y + 1, depth + out));
        for z in low.z..top.z {
            for x in low.x..top.x {
                if x == low.x || x == top.x - 1 || z == low.z || z == top.z - 1 {
                    town.set(IVec3::new(x, low.y, z), stuff);
                }
            }
        }
    };
    ring(town, 3, 1, trim);
    ring(town, high - 1, 1, trim);
    ring(town, high, 0, trim);
    // Every second cell of the parapet.
    for i in 0..width.max(depth) {
        if i % 2 == 0 {
            for place in [[i, 0], [i, depth - 1], [0, i], [width - 1, i]] {
                if place[0] < width && place[1] < depth {
                    town.set(at + IVec3::new(place[0], high + 1, place[1]), trim);
                }
            }
        }
    }
    // Balconies on one pair of sides.
    if plot.random(4) < 0.7 {
        for storey in 1..storeys {
            let y = 3 + 3 * storey;
            for x in [2, width - 4] {
                for z in [-1, depth] {
                    town.fill(at + IVec3::new(x, y, z), at + IVec3::new(x + 2, y + 1, z + 1), WOOD);
                }
            }
        }
    }
    let middle = at + IVec3::new(width / 2, high, depth / 2);
    match plot.choice(5, 3) {
        0 => {
            // A water tank on legs.
            for (x, z) in [(-1, -1), (1, -1), (-1, 1), (1, 1)] {
                town.fill(middle + IVec3::new(x, 0, z), middle + IVec3::new(x + 1, 2, z + 1), DARK);
            }
            town.fill(middle + IVec3::new(-1, 2, -1), middle + IVec3::new(2, 5, 2), WOOD);
            town.set(middle + IVec3::Y * 5, SLATE);
        }
        1 => {
            // A stairwell, and a mast on it.
            town.fill(middle + IVec3::new(-2, 0, -1), middle + IVec3::new(1, 3, 2), stuff::wall(colour, false));
            town.fill(middle + IVec3::new(-1, 3, 0), middle + IVec3::new(0, 6, 1), DARK);
        }
        _ => {
            town.fill(at + IVec3::new(1, high, 1), at + IVec3::new(width - 1, high + 1, depth - 1), GRASS);
        }
    }
}

/// A lawn around a pond. Trees are planted elsewhere.
pub(super) fn park(town: &mut Voxels, plot: Plot) {
    let Plot { at, width, depth, .. } = plot;
    town.fill(at - IVec3::Y, at + IVec3::new(width, 0, depth), GRASS);
    let middle = IVec3::new(width / 2, 0, depth / 2);
    for z in 0..depth {
        for x in 0..width {
            let away = (IVec3::new(x, 0, z) - middle).as_vec3().length();
            let shore = 3.2 + 0.8 * hash(at + IVec3::new(x, 0, z), 5);
            if away < shore - 0.6 {
                town.set(at + IVec3::new(x, -1, z), 0);
                town.set(at + IVec3::new(x, -2, z), WATER);
            } else if away < shore + 0.4 {
                town.set(at + IVec3::new(x, -1, z), PAVEMENT);
            }
        }
    }
}

/// The clock tower in the middle of the plaza, about `middle`.
pub(super) fn clock_tower(town: &mut Voxels, middle: IVec3) {
    let square = |town: &mut Voxels, half: i32, low: i32, high: i32, stuff: Stuff| {
        let from = middle + IVec3::new(-half, low, -half);
        town.fill(from, middle + IVec3::new(half + 1, high, half + 1), stuff);
    };
    square(town, 5, 0, 1, STONE);
    square(town, 4, 1, 2, PLAZA);
    square(town, 3, 2, 24, STONE);
    // A gate through the foot, and slits above it.
    for axis in [IVec3::X, IVec3::Z] {
        let side = IVec3::new(axis.z, 0, axis.x);
        town.fill(middle - 3 * axis - side + 2 * IVec3::Y, middle + 4 * axis + 2 * side + 6 * IVec3::Y, 0);
        for along in [-3, 3] {
            for y in [10, 11, 14, 15] {
                town.set(middle + along * axis + IVec3::Y * y, DARK);
            }
        }
    }
    square(town, 4, 18, 19, stuff::wall(2, false));
    square(town, 4, 24, 25, stuff::wall(2, false));
    // Dials of gold with dark hands on every side.
    for axis in [IVec3::X, IVec3::NEG_X, IVec3::Z, IVec3::NEG_Z] {
        let side = IVec3::new(axis.z.abs(), 0, axis.x.abs());
        let dial = middle + 3 * axis + IVec3::Y * 21;
        for (u, v) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1), (0, 0)] {
            town.set(dial + u * side + v * IVec3::Y, GOLD);
        }
        town.set(dial + IVec3::Y, DARK);
        town.set(dial, DARK);
        town.set(dial + side, DARK);
    }
    // An open belfry, and a steep roof.
    for (x, z) in [(-3, -3), (3, -3), (-3, 3), (3, 3)] {
        let foot = middle + IVec3::new(x, 25, z);
        town.fill(foot, foot + IVec3::new(1, 5, 1), STONE);
    }
    square(town, 1, 27, 29, GOLD);
    square(town, 4, 30, 31, stuff::wall(2, false));
    for (step, half) in [3, 3, 2, 2, 1, 1, 0, 0].into_iter().enumerate() {
        let y = 31 + step as i32;
        square(town, half, y, y + 1, SLATE);
    }
    square(town, 0, 39, 41, GOLD);
}
