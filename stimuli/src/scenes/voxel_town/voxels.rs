//! Boxes of cubes and their surfaces: a quadrilateral for every face that is not hidden, darker in the corners.

use crate::world::{MeshLevel, Vertex};
use glam::{IVec3, Vec2, Vec3};
use std::collections::BTreeMap;

/// What a cube is made of; 0 is air.
pub(super) type Stuff = u8;

/// A box of cubes with sides of `cell_m`, whose lowest corner is at `low`.
pub(super) struct Voxels {
    pub(super) low: Vec3,
    pub(super) cell_m: f32,
    pub(super) size: IVec3,
    stuff: Vec<Stuff>,
}

impl Voxels {
    /// All air.
    pub(super) fn new(low: Vec3, cell_m: f32, size: IVec3) -> Self {
        Self { low, cell_m, size, stuff: vec![0; (size.x * size.y * size.z).max(0) as usize] }
    }

    fn index(&self, at: IVec3) -> Option<usize> {
        let inside = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.size).all();
        inside.then(|| ((at.y * self.size.z + at.z) * self.size.x + at.x) as usize)
    }

    /// What is in a cell; air outside.
    pub(super) fn get(&self, at: IVec3) -> Stuff {
        self.index(at).map_or(0, |index| self.stuff[index])
    }

    /// What is at a place, metres.
    #[cfg(test)]
    pub(super) fn at(&self, place: Vec3) -> Stuff {
        self.get(((place - self.low) / self.cell_m).floor().as_ivec3())
    }

    pub(super) fn set(&mut self, at: IVec3, stuff: Stuff) {
        if let Some(index) = self.index(at) {
            self.stuff[index] = stuff;
        }
    }

    /// Fills the cells from `low` up to but without `high`.
    pub(super) fn fill(&mut self, low: IVec3, high: IVec3, stuff: Stuff) {
        for y in low.y..high.y {
            for z in low.z..high.z {
                for x in low.x..high.x {
                    self.set(IVec3::new(x, y, z), stuff);
                }
            }
        }
    }

    /// The surface in pieces of `piece` columns on a side, by what it is made of. Faces to the bottom of the box are left
    /// out. The map coordinates count cells.
    pub(super) fn surface(&self, piece: i32) -> BTreeMap<(Stuff, [i32; 2]), MeshLevel> {
        let mut parts: BTreeMap<(Stuff, [i32; 2]), MeshLevel> = BTreeMap::new();
        for y in 0..self.size.y {
            for z in 0..self.size.z {
                for x in 0..self.size.x {
                    let cell = IVec3::new(x, y, z);
                    let stuff = self.get(cell);
                    if stuff == 0 {
                        continue;
                    }
                    let hidden = |normal: IVec3| self.get(cell + normal) != 0 || (y == 0 && normal.y < 0);
                    for (normal, right, up) in FACES.iter().filter(|(normal, ..)| !hidden(*normal)) {
                        let part = parts.entry((stuff, [x / piece, z / piece])).or_default();
                        self.face(part, cell, *normal, [*right, *up]);
                    }
                }
            }
        }
        parts
    }

    fn face(&self, part: &mut MeshLevel, cell: IVec3, normal: IVec3, [right, up]: [IVec3; 2]) {
        let full = |at: IVec3| i32::from(self.get(at) != 0);
        let before = cell + normal;
        // The corners counter-clockwise from outside, as steps of −1 or 1 to the right and upwards.
        let corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)].map(|(u, v)| {
            let (side, above, beyond) =
                (full(before + u * right), full(before + v * up), full(before + u * right + v * up));
            // A corner between two walls is as dark as one that is filled.
            let walls = if side + above == 2 { 3 } else { side + above + beyond };
            let offset = (normal + u * right + v * up + 1).as_vec3() * 0.5;
            let at = self.low + self.cell_m * (cell.as_vec3() + offset);
            let place = cell.as_vec3() + offset;
            let uv = Vec2::new(place.dot(right.as_vec3()), -place.dot(up.as_vec3()));
            (at, uv, 1.0 - 0.22 * walls as f32)
        });
        let first = part.vertices.len() as u32;
        part.vertices.extend(corners.iter().map(|&(at, uv, open)| Vertex {
            tangent: right.as_vec3().extend(open).into(),
            ..Vertex::new(at, normal.as_vec3(), uv)
        }));
        // Cut along the diagonal that keeps the shade of a single dark corner in its corner.
        let open = corners.map(|(.., open)| open);
        let cut = if open[0] + open[2] >= open[1] + open[3] { [0, 1, 2, 0, 2, 3] } else { [1, 2, 3, 1, 3, 0] };
        part.indices.extend(cut.map(|index| first + index));
    }
}

/// The six faces: outwards, to the right and upwards seen from outside.
const FACES: [(IVec3, IVec3, IVec3); 6] = [
    (IVec3::X, IVec3::NEG_Z, IVec3::Y),
    (IVec3::NEG_X, IVec3::Z, IVec3::Y),
    (IVec3::Z, IVec3::X, IVec3::Y),
    (IVec3::NEG_Z, IVec3::NEG_X, IVec3::Y),
    (IVec3::Y, IVec3::X, IVec3::NEG_Z),
    (IVec3::NEG_Y, IVec3::X, IVec3::Z),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface of cubes encloses their volume, and only their outer faces are there.
    #[test]
    fn surfaces_enclose_their_cubes() {
        let mut voxels = Voxels::new(Vec3::new(-3.0, 1.0, 2.0), 0.5, IVec3::splat(8));
        voxels.fill(IVec3::new(2, 2, 2), IVec3::new(5, 4, 6), 3);
        let parts = voxels.surface(100);
        let level = &parts[&(3, [0, 0])];
        assert_eq!(level.triangles(), 2 * 2 * (3 * 2 + 3 * 4 + 2 * 4));
        let place = |i: u32| Vec3::from(level.vertices[i as usize].position);
        let volume: f32 =
            level.indices.chunks_exact(3).map(|t| place(t[0]).dot(place(t[1]).cross(place(t[2]))) / 6.0).sum();
        assert!((volume - 24.0 * 0.125).abs() < 1e-4, "{volume}");
    }
}
