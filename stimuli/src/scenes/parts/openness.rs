//! How much of the surroundings every vertex sees: rays through a coarse occupancy grid of the world, once, while it is
//! built. Corners and what lies under roofs then get less of the sky's light, which no lamp's shadow shows.

use crate::world::{MeshLevel, World};
use glam::{Affine3A, IVec3, Vec3};
use std::f32::consts::TAU;
use std::sync::Mutex;

/// Rays from every vertex.
const RAYS: u32 = 10;

/// A box of cells, each full or empty.
struct Occupancy {
    low: Vec3,
    cell_m: f32,
    size: IVec3,
    full: Vec<bool>,
}

impl Occupancy {
    fn of(world: &World, cell_m: f32) -> Option<Self> {
        let [low, high] = world.bounds(0.0)?;
        let low = low - cell_m;
        let size = ((high + cell_m - low) / cell_m).ceil().as_ivec3() + 1;
        let mut grid = Self { low, cell_m, size, full: vec![false; (size.x * size.y * size.z) as usize] };
        for object in &world.objects {
            if let Some(level) = world.meshes.get(object.mesh).and_then(|mesh| mesh.levels.first()) {
                grid.fill(level, object.motion.at(0.0));
            }
        }
        Some(grid)
    }

    fn index(&self, at: Vec3) -> Option<usize> {
        let cell = ((at - self.low) / self.cell_m).floor().as_ivec3();
        let inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(self.size).all();
        inside.then(|| ((cell.z * self.size.y + cell.y) * self.size.x + cell.x) as usize)
    }

    /// Fills the cells that points of the triangles, closer together than a cell, lie in.
    fn fill(&mut self, level: &MeshLevel, at: Affine3A) {
        let place = |i: u32| at.transform_point3(Vec3::from(level.vertices[i as usize].position));
        for triangle in level.indices.chunks_exact(3) {
            let [a, b, c] = [place(triangle[0]), place(triangle[1]), place(triangle[2])];
            let longest = (b - a).length().max((c - a).length()).max((c - b).length());
            let steps = ((longest / (0.7 * self.cell_m)).ceil() as i32).clamp(1, 400);
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let (u, v) = (i as f32 / steps as f32, j as f32 / steps as f32);
                    if let Some(index) = self.index(a + u * (b - a) + v * (c - a)) {
                        self.full[index] = true;
                    }
                }
            }
        }
    }

    /// Share of the cosine-weighted half space over `normal` that is free for `reach_m`.
    fn open(&self, at: Vec3, normal: Vec3, reach_m: f32) -> f32 {
        let right = normal.any_orthonormal_vector();
        let up = normal.cross(right);
        // The surface's own cells do not count.
        let start = at + normal * (1.6 * self.cell_m);
        let mut free = 0.0;
        for ray in 0..RAYS {
            let share = (ray as f32 + 0.5) / RAYS as f32;
            let (sin, cos) = (ray as f32 * 0.618_034 * TAU).sin_cos();
            let flat = share.sqrt();
            let d = right * (flat * cos) + up * (flat * sin) + normal * (1.0 - share).sqrt();
            // Steps of a cell at first, longer farther away.
            let mut along = 0.0;
            while along < reach_m && !self.index(start + d * along).is_some_and(|index| self.full[index]) {
                along += self.cell_m.max(0.2 * along);
            }
            // What is farther away darkens less.
            free += (along / reach_m).min(1.0).powi(2);
        }
        free / RAYS as f32
    }
}

/// Writes into every vertex how open it is: rays of `reach_m` through cells of `cell_m`.
/// The rays give no less than `least`. Meshes that stand in several places, or move, are left as they are.
pub(crate) fn bake(world: &mut World, cell_m: f32, reach_m: f32, least: f32) {
    let Some(grid) = Occupancy::of(world, cell_m) else { return };
    let mut uses = vec![0_usize; world.meshes.len()];
    for object in &world.objects {
        if let Some(count) = uses.get_mut(object.mesh) {
            *count += 1;
        }
    }
    let mut places = vec![None; world.meshes.len()];
    for object in world.objects.iter().filter(|object| !object.motion.moves() && uses.get(object.mesh) == Some(&1)) {
        places[object.mesh] = Some(object.motion.at(0.0));
    }
    let jobs = Mutex::new(world.meshes.iter_mut().zip(places));
    let work = || {
        loop {
            let Some((mesh, at)) = jobs.lock().ok().and_then(|mut jobs| jobs.next()) else { return };
            let Some(at) = at else { continue };
            for vertex in mesh.levels.iter_mut().flat_map(|level| &mut level.vertices) {
                let place = at.transform_point3(vertex.position.into());
                let normal = at.transform_vector3(vertex.normal.into()).normalize_or(Vec3::Y);
                let open = grid.open(place, normal, reach_m);
                vertex.tangent[3] *= least + (1.0 - least) * open;
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, std::num::NonZero::get) {
            scope.spawn(work);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Object;
    use crate::world::shapes::block;

    /// In the middle of a large floor everything is open; at the foot of a high wall, half of it.
    #[test]
    fn a_wall_hides_half_the_sky() {
        let mut world = World::default();
        for (low, high) in [
            (Vec3::new(-8.0, -0.5, -8.0), Vec3::new(8.0, 0.0, 8.0)),
            (Vec3::new(5.0, 0.0, -8.0), Vec3::new(5.5, 8.0, 8.0)),
        ] {
            let mesh = world.mesh(block(low, high));
            world.objects.push(Object::still(mesh, 0));
        }
        let grid = Occupancy::of(&world, 0.1).expect("there is something");
        let open = |x: f32| grid.open(Vec3::new(x, 0.0, 0.0), Vec3::Y, 40.0);
        println!("far from the wall {:.2}, at its foot {:.2}", open(-7.0), open(4.9));
        assert!(open(-7.0) > 0.85 && (open(4.9) - 0.5).abs() < 0.1);
    }
}
