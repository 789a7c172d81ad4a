//! Many small parts made into few objects: what has the same material and stands in the same cell of a coarse grid
//! becomes one mesh, small enough to be left out as a whole when it is out of view.

use crate::world::{MeshLevel, Object, World};
use glam::{Affine3A, Vec3};
use std::collections::BTreeMap;

/// Parts gathered by material and place.
pub(crate) struct Batch {
    cell_m: f32,
    parts: BTreeMap<(usize, [i32; 3]), MeshLevel>,
}

impl Batch {
    /// Nothing yet, in cells `cell_m` wide.
    pub(crate) fn new(cell_m: f32) -> Self {
        Self { cell_m, parts: BTreeMap::new() }
    }

    /// Adds a part that is already where it belongs; the cell is that of its first vertex.
    pub(crate) fn add(&mut self, material: usize, part: &MeshLevel) {
        let Some(first) = part.vertices.first() else { return };
        let cell = first.position.map(|x| (x / self.cell_m).floor() as i32);
        self.parts.entry((material, cell)).or_default().append(part);
    }

    /// Adds a copy of `part`, moved by `by`.
    pub(crate) fn add_at(&mut self, material: usize, part: &MeshLevel, by: Affine3A) {
        self.add(material, &part.clone().transformed(by));
    }

    /// Adds a copy of `part`, moved to `at`.
    pub(crate) fn add_to(&mut self, material: usize, part: &MeshLevel, at: Vec3) {
        self.add_at(material, part, Affine3A::from_translation(at));
    }

    /// Puts everything into `world`.
    pub(crate) fn finish(self, world: &mut World) {
        for ((material, _), part) in self.parts {
            let mesh = world.mesh(part);
            world.objects.push(Object::still(mesh, material));
        }
    }
}
