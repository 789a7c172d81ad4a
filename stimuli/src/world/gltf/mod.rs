//! Files in glTF 2.0, as text or binary, become worlds. A file is read whole and held against the specification first:
//! whatever is wrong is told at once, each mistake at its element, and what is not shown as the file asks is told as a
//! notice. Nothing in a file can lead outside its own data or ask for memory without bound.
//!
//! `container` fetches bytes, `document` types the JSON, `accessors` and `images` read numbers and pictures; `primitives`,
//! `materials`, `nodes`, `animation` and `lights` turn them into the parts of a [`World`].

mod accessors;
mod animation;
mod container;
mod document;
mod errors;
mod images;
mod lights;
mod materials;
mod nodes;
mod primitives;
mod scene;
#[cfg(test)]
mod tests;

pub(crate) use container::read_file;
pub(crate) use errors::Findings;
pub use errors::{Mistake, Notice, WorldError};

use super::{Mesh, Motion, Panorama, World};
use accessors::{Accessors, Buffers};
use animation::Clip;
use container::Container;
use document::Document;
use glam::{Affine3A, Vec3};
use images::Images;
use nodes::{Rest, Visited};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A glTF file that has been read and found sound; scenes are made of it without the disk.
#[derive(Debug, Clone)]
pub struct GltfFile {
    file: PathBuf,
    /// Meshes, materials, maps and lights; objects come with a choice of the animation.
    parts: World,
    /// The nodes of the scene.
    nodes: Vec<Visited>,
    /// Every node's place at rest, by its index in the file.
    rests: Vec<Rest>,
    /// Meshes and materials that nodes show: by node, indices into the parts.
    shown: Vec<Vec<(usize, usize)>>,
    /// Materials that are to look the same in any light.
    unlit: Vec<usize>,
    /// Positions in `nodes` of those that carry a camera.
    cameras: Vec<usize>,
    clips: Vec<Clip>,
    notices: Vec<Notice>,
    panorama: Option<Panorama>,
    version: u32,
}

impl GltfFile {
    /// Reads a `.gltf` or `.glb` file with everything it refers to.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn read(file: &Path) -> Result<Self, WorldError> {
        let bytes = read_file(file).map_err(|message| Findings::new(file).refuse("", message))?;
        Self::of_bytes(bytes, file, accessors::MOST_ITEMS)
    }

    /// The same from a file's bytes; `file` is what errors name, and its folder is where neighbours are looked for. At most
    /// `most_items` vertices, indices and keys are read.
    fn of_bytes(bytes: Vec<u8>, file: &Path, most_items: u64) -> Result<Self, WorldError> {
        let mut found = Findings::new(file);
        let mut version = Version::default();
        version.add(&bytes);
        let container = Container::split(bytes, &mut found)?;
        let document = Document::parse(&container.json, &mut found)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let buffers = Buffers::load(&document, container.binary, folder, &mut found);
        // What follows would only repeat what is wrong so far, at other places.
        found.check()?;
        buffers.each(|bytes| version.add(bytes));
        let accessors = Accessors::check(&document, &buffers, most_items, &mut found);
        found.check()?;

        let rests = nodes::rests(&document, &mut found);
        let nodes = nodes::visited(&document, &mut found);
        let mut parts = World::default();
        let shown = surfaces_and_meshes(&document, &buffers, &accessors, folder, &mut parts, &mut found);
        let clip = |(index, animation)| {
            animation::clip(animation, &format!("animations[{index}]"), &document, &rests, &accessors, &mut found)
        };
        let clips: Vec<Clip> = document.animations.iter().enumerate().map(clip).collect();
        let shown = shown_by_nodes(&document, &nodes, &shown, &mut found);
        let cameras = cameras(&document, &nodes, &mut found);
        found.check()?;
        let unlit =
            (0..document.materials.len()).filter(|&i| document.materials[i].extensions.unlit.is_some()).collect();

        for map in parts.colour_maps.iter().chain(&parts.data_maps) {
            version.add(&map.rgba);
        }
        let mut read = Self {
            file: file.to_owned(),
            parts,
            nodes,
            rests,
            shown,
            unlit,
            cameras,
            clips,
            notices: Vec::new(),
            panorama: None,
            version: version.folded(),
        };
        if read.nodes.iter().all(|visited| read.shown[visited.node].is_empty()) {
            let left_out = found.left_out();
            let because = if left_out.is_empty() { left_out } else { format!(" ({left_out})") };
            return Err(
                found.refuse("", format!("there is nothing to show: no node of the scene has a triangle{because}"))
            );
        }
        read.parts.lights = read.placed_lights(&document, &mut found);
        read.notices = found.finish()?;
        Ok(read)
    }

    /// Shows the world under the panorama in an `.hdr` or `.exr` file instead of a shipped one.
    ///
    /// # Errors
    /// When it cannot be read as a panorama.
    pub fn with_environment(mut self, file: &Path) -> Result<Self, WorldError> {
        self.panorama = Some(super::panorama_file::read(file)?);
        Ok(self)
    }

    /// What is left out of the file, or shown otherwise than it asks.
    #[must_use]
    pub fn notices(&self) -> &[Notice] {
        &self.notices
    }

    /// Which file it is.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Triangles of all objects together.
    #[must_use]
    pub fn triangles(&self) -> usize {
        let of_mesh = |&(mesh, _): &(usize, usize)| {
            self.parts.meshes[mesh].levels.iter().map(super::MeshLevel::triangles).sum::<usize>()
        };
        self.nodes.iter().flat_map(|visited| &self.shown[visited.node]).map(of_mesh).sum()
    }

    /// How many cameras its scene has.
    #[must_use]
    pub fn cameras(&self) -> usize {
        self.cameras.len()
    }

    /// How many animations it has.
    #[must_use]
    pub fn animations(&self) -> usize {
        self.clips.len()
    }

    /// Where every node of the scene is, under an animation or at rest.
    fn motions(&self, clip: Option<&Clip>) -> Vec<Arc<Motion>> {
        let mut motions: Vec<Arc<Motion>> = Vec::with_capacity(self.nodes.len());
        for visited in &self.nodes {
            let own = match clip.and_then(|clip| clip.get(&visited.node)) {
                Some(channels) => Motion::Channels(Arc::clone(channels)),
                None => Motion::Still(self.rests[visited.node].place()),
            };
            let motion = match visited.parent {
                Some(parent) => Motion::within(&motions[parent], own),
                None => own,
            };
            motions.push(Arc::new(motion));
        }
        motions
    }

    fn placed_lights(&self, document: &Document, found: &mut Findings) -> Vec<super::Light> {
        let mut lights = Vec::new();
        let moves = |node: usize| self.clips.iter().any(|clip| clip.contains_key(&node));
        let motions = self.motions(None);
        for (visited, motion) in self.nodes.iter().zip(&motions) {
            let Some(carried) = &document.nodes[visited.node].extensions.light else { continue };
            let place = format!("nodes[{}].extensions.KHR_lights_punctual", visited.node);
            let Some(light) = document.lights.get(carried.light) else {
                let count = document.lights.len();
                found.wrong(
                    format!("{place}.light"),
                    format!("there is no light {}; the file has {count}", carried.light),
                );
                continue;
            };
            if moves(visited.node) {
                found.note(place, "lights do not move here");
            }
            let place = format!("extensions.KHR_lights_punctual.lights[{}]", carried.light);
            lights.extend(lights::light(light, &motion.at(0.0), &place, found));
        }
        if lights.iter().any(|light| matches!(light, super::Light::Directional { .. })) {
            found
                .note("extensions.KHR_lights_punctual", "the first directional light takes the place of the sky's sun");
        }
        if !lights.is_empty() {
            let world = self.assembled(&motions);
            lights::scale(&mut lights, world.bounds(0.0), found);
        }
        lights
    }

    /// The parts with an object for everything that a node shows.
    fn assembled(&self, motions: &[Arc<Motion>]) -> World {
        let mut world = self.parts.clone();
        let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        let mut mirrored: std::collections::HashMap<usize, usize> = std::collections::HashMap::new();
        for (visited, motion) in self.nodes.iter().zip(motions) {
            for &(mesh, material) in &self.shown[visited.node] {
                let mut object =
                    super::Object { motion: motion.as_ref().clone(), ..super::Object::still(mesh, material) };
                // What is mirrored would show its inside, so the mesh is mirrored and the object mirrored back.
                if motion.at(0.0).matrix3.determinant() < 0.0 {
                    object.mesh = *mirrored.entry(mesh).or_insert_with(|| {
                        let levels = world.meshes[mesh].levels.iter().map(|level| level.clone().transformed(mirror));
                        let levels = levels.collect();
                        world.mesh(Mesh { levels })
                    });
                    object.motion = Motion::within(motion, Motion::Still(mirror));
                }
                world.objects.push(object);
            }
        }
        world
    }
}

/// Fills in the materials, maps and meshes; for every mesh of the file, the meshes and materials of its primitives.
fn surfaces_and_meshes(
    document: &Document,
    buffers: &Buffers,
    accessors: &Accessors<'_>,
    folder: &Path,
    parts: &mut World,
    found: &mut Findings,
) -> Vec<Vec<(usize, usize)>> {
    let mut images = Images::new(document, buffers, folder);
    let mut surfaces: Vec<materials::Surface> = document
        .materials
        .iter()
        .enumerate()
        .map(|(i, material)| materials::surface(material, &format!("materials[{i}]"), document, &mut images, found))
        .collect();
    // What has no material has the default one, the last.
    surfaces.push(materials::surface(&document::Material::default(), "materials", document, &mut images, found));
    parts.materials = surfaces.iter().map(|surface| surface.material.clone()).collect();
    (parts.colour_maps, parts.data_maps) = (images.colour_maps, images.data_maps);

    let mut shown = Vec::with_capacity(document.meshes.len());
    for (i, mesh) in document.meshes.iter().enumerate() {
        let mut primitives = Vec::new();
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("meshes[{i}].primitives[{k}]");
            let material = primitive.material.unwrap_or(document.materials.len());
            let Some(surface) =
                surfaces.get(material).filter(|_| primitive.material.is_none_or(|m| m < document.materials.len()))
            else {
                let count = document.materials.len();
                found.wrong(
                    format!("{place}.material"),
                    format!("there is no material {material}; the file has {count}"),
                );
                continue;
            };
            let Some(level) = primitives::level(primitive, surface, &place, document, accessors, found) else {
                continue;
            };
            if surface.visible {
                primitives.push((parts.mesh(level), material));
            } else {
                found.note(place, "its material is transparent and it is left out");
            }
        }
        shown.push(primitives);
    }
    shown
}

/// By node, what it shows.
fn shown_by_nodes(
    document: &Document,
    nodes: &[Visited],
    meshes: &[Vec<(usize, usize)>],
    found: &mut Findings,
) -> Vec<Vec<(usize, usize)>> {
    for (index, node) in document.nodes.iter().enumerate() {
        if let Some(mesh) = node.mesh.filter(|&mesh| mesh >= meshes.len()) {
            found.wrong(
                format!("nodes[{index}].mesh"),
                format!("there is no mesh {mesh}; the file has {}", meshes.len()),
            );
        }
    }
    let mut shown = vec![Vec::new(); document.nodes.len()];
    for visited in nodes {
        let node = &document.nodes[visited.node];
        let place = format!("nodes[{}]", visited.node);
        if node.skin.is_some() {
            found.note(&*place, "skins do not bend: the mesh is shown as it was bound");
        }
        if node.extensions.instancing.is_some() {
            found.note(&*place, "EXT_mesh_gpu_instancing is left out, the mesh is shown once");
        }
        shown[visited.node] = node.mesh.and_then(|mesh| meshes.get(mesh)).cloned().unwrap_or_default();
    }
    shown
}

/// Positions in `nodes` of those that carry a camera.
fn cameras(document: &Document, nodes: &[Visited], found: &mut Findings) -> Vec<usize> {
    for (index, camera) in document.cameras.iter().enumerate() {
        match camera.kind.as_str() {
            "perspective" => {}
            "orthographic" => {
                found.note(format!("cameras[{index}]"), "it has no perspective in the file; it has the display's here");
            }
            kind => {
                let kind = accessors::shown(kind);
                found.wrong(
                    format!("cameras[{index}].type"),
                    format!("\"{kind}\" is none of perspective, orthographic"),
                );
            }
        }
    }
    let mut cameras = Vec::new();
    for (position, visited) in nodes.iter().enumerate() {
        let Some(camera) = document.nodes[visited.node].camera else { continue };
        if camera < document.cameras.len() {
            cameras.push(position);
        } else {
            let count = document.cameras.len();
            let message = format!("there is no camera {camera}; the file has {count}");
            found.wrong(format!("nodes[{}].camera", visited.node), message);
        }
    }
    cameras
}

/// A number that differs between files that differ: FNV-1a.
#[derive(Debug)]
struct Version(u64);

impl Default for Version {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Version {
    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn folded(&self) -> u32 {
        ((self.0 >> 32) ^ (self.0 & 0xffff_ffff)) as u32
    }
}
