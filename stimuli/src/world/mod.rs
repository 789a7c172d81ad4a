//! A world of meshes as data: surfaces, materials, lights, a sky and a camera's path. Needs no GPU; [`crate::mesh_scene`]
//! draws it, and every procedural scene and every loaded file is one of these.
//!
//! Lengths are metres, y points up, light is linear and relative: a white surface in full light comes out near 1 after
//! the world's exposure.

pub(crate) mod bvh;
pub(crate) mod camera;
pub(crate) mod channels;
pub(crate) mod environment;
pub(crate) mod gltf;
pub(crate) mod light;
pub(crate) mod material;
pub(crate) mod mesh;
pub(crate) mod motion;
pub(crate) mod panorama_file;
pub(crate) mod shapes;
pub(crate) mod sky;

pub(crate) use camera::{CameraPath, Pose};
pub(crate) use environment::{Environment, Panorama};
pub(crate) use light::Light;
pub(crate) use material::{Map, Material, Pattern, PatternKind};
pub(crate) use mesh::{Detail, Mesh, MeshLevel, Vertex};
pub(crate) use motion::Motion;
pub(crate) use sky::Sky;

use crate::contract::SceneLight;

/// A mesh with a material at a place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Object {
    /// Index into [`World::meshes`].
    pub(crate) mesh: usize,
    /// Index into [`World::materials`].
    pub(crate) material: usize,
    /// Where it is, at any time.
    pub(crate) motion: Motion,
    /// How its triangles grow fewer with distance; every triangle where there is nothing.
    pub(crate) detail: Option<Detail>,
}

impl Object {
    /// An object that stands where its mesh was made.
    pub(crate) fn still(mesh: usize, material: usize) -> Self {
        Self { mesh, material, motion: Motion::default(), detail: None }
    }
}

/// Everything that can be seen, and the eye that sees it.
#[derive(Debug, Clone, Default)]
pub(crate) struct World {
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) materials: Vec<Material>,
    /// Pictures of colours, sRGB.
    pub(crate) colour_maps: Vec<Map>,
    /// Pictures of numbers: normals, roughness and metalness.
    pub(crate) data_maps: Vec<Map>,
    pub(crate) objects: Vec<Object>,
    pub(crate) lights: Vec<Light>,
    pub(crate) environment: Environment,
    pub(crate) camera: CameraPath,
    pub(crate) light: SceneLight,
    /// Points of a procedural pattern that are averaged in each pixel; 0 counts as 1.
    pub(crate) pattern_samples: u32,
    /// Where the sun's shadows are wanted, lowest and highest corner, where that is less than the whole world: the smaller,
    /// the finer they are.
    pub(crate) shadow_bounds: Option<[glam::Vec3; 2]>,
}

impl World {
    /// Adds a mesh and returns its index.
    pub(crate) fn mesh(&mut self, mesh: impl Into<Mesh>) -> usize {
        self.meshes.push(mesh.into());
        self.meshes.len() - 1
    }

    /// Adds a material and returns its index.
    pub(crate) fn material(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds an object that does not move.
    pub(crate) fn place(&mut self, mesh: usize, material: usize, at: glam::Affine3A) {
        self.objects.push(Object { motion: Motion::Still(at), ..Object::still(mesh, material) });
    }

    /// Whether anything but the camera moves.
    pub(crate) fn has_moving_objects(&self) -> bool {
        self.objects.iter().any(|object| object.motion.moves())
    }

    /// The smallest box that holds every object at `animation_s`: lowest and highest corner; nothing in an empty world.
    pub(crate) fn bounds(&self, animation_s: f64) -> Option<[glam::Vec3; 2]> {
        let mut bounds: Option<[glam::Vec3; 2]> = None;
        for object in &self.objects {
            let at = object.motion.at(animation_s);
            let Some([low, high]) = self.meshes.get(object.mesh).and_then(Mesh::bounds) else { continue };
            for corner in 0..8 {
                let pick = |bit: usize, a: f32, b: f32| if corner >> bit & 1 == 0 { a } else { b };
                let place = at.transform_point3(glam::Vec3::new(
                    pick(0, low.x, high.x),
                    pick(1, low.y, high.y),
                    pick(2, low.z, high.z),
                ));
                let found = bounds.get_or_insert([place; 2]);
                *found = [found[0].min(place), found[1].max(place)];
            }
        }
        bounds
    }
}
