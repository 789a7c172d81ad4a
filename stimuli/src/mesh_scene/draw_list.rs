//! What is drawn in a view: the chunks of triangles that may be seen, each object at its level of detail, nearest first
//! so that what is hidden is shaded rarely.

use super::frame::Frame;
use super::gpu_world::{Chunk, GpuWorld};
use crate::contract::DrawRequest;
use crate::world::{Material, World};
use glam::{Affine3A, Vec3};
use std::ops::Range;

/// One draw: indices of one object.
#[derive(Debug, Clone)]
pub(super) struct Draw {
    pub(super) object: u32,
    pub(super) indices: Range<u32>,
    pub(super) base_vertex: i32,
    pub(super) kind: DrawKind,
    distance: f32,
}

impl Draw {
    fn triangles(&self) -> u32 {
        (self.indices.end - self.indices.start) / 3
    }
}

/// Triangles of a draw beyond which no chunk is added: a draw that spans a hall would not be nearer than anything.
const LONGEST_RUN: u32 = 4096;

/// Which pipeline draws a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct DrawKind {
    /// Parts of it are cut out.
    pub(super) holes: bool,
    /// It is seen from behind, too.
    pub(super) two_sided: bool,
    /// Its place turns the surface inside out.
    pub(super) mirrored: bool,
    /// Some of its values come from maps.
    pub(super) maps: bool,
    /// Its pattern, by its number.
    pub(super) pattern: u32,
    /// The pattern is in relief.
    pub(super) relief: bool,
}

impl DrawKind {
    fn of(material: &Material, place: &Affine3A) -> Self {
        let maps = [material.albedo_map, material.emission_map, material.normal_map, material.roughness_map];
        Self {
            holes: material.cutout.is_some() && material.albedo_map.is_some(),
            two_sided: material.two_sided,
            mirrored: place.matrix3.determinant() < 0.0,
            maps: maps.iter().any(Option::is_some),
            pattern: material.pattern.kind as u32,
            relief: material.pattern.relief.abs() > 0.0,
        }
    }
}

#[derive(Debug)]
pub(super) struct DrawList {
    pub(super) draws: Vec<Draw>,
    pub(super) triangles: u64,
}

impl DrawList {
    pub(super) fn new(world: &World, on_gpu: &GpuWorld, frame: &Frame, request: &DrawRequest<'_>) -> Self {
        let visible = |chunk: &Chunk, place: &Affine3A| frame.frustum.touches(moved_box(chunk.bounds, place));
        Self::of(world, on_gpu, frame, request.detail, visible)
    }

    /// Every object in whole, at its finest.
    pub(super) fn everything(world: &World, on_gpu: &GpuWorld, frame: &Frame) -> Self {
        Self::of(world, on_gpu, frame, 1.0, |_, _| true)
    }

    fn of(
        world: &World,
        on_gpu: &GpuWorld,
        frame: &Frame,
        share: f64,
        visible: impl Fn(&Chunk, &Affine3A) -> bool,
    ) -> Self {
        let eye = frame.eye.as_vec3();
        let mut draws = Vec::new();
        for ((object, place), index) in world.objects.iter().zip(&frame.places).zip(0..) {
            let (Some(mesh), Some(material)) = (world.meshes.get(object.mesh), world.materials.get(object.material))
            else {
                continue;
            };
            let level = object.detail.map_or(0, |detail| {
                let distance_m = f64::from(Vec3::from(place.translation).distance(eye));
                mesh.level_of(detail.triangles(distance_m, share))
            });
            let kind = DrawKind::of(material, place);
            // Chunks that follow each other in the buffer and are both seen are one draw.
            let mut run: Option<Draw> = None;
            for chunk in on_gpu.chunks(object.mesh, level).iter().filter(|chunk| visible(chunk, place)) {
                let [low, high] = moved_box(chunk.bounds, place);
                let distance = eye.clamp(low, high).distance(eye);
                match &mut run {
                    Some(draw) if draw.indices.end == chunk.indices.start && draw.triangles() < LONGEST_RUN => {
                        draw.indices.end = chunk.indices.end;
                        draw.distance = draw.distance.min(distance);
                    }
                    _ => draws.extend(run.replace(Draw {
                        object: index,
                        indices: chunk.indices.clone(),
                        base_vertex: chunk.base_vertex,
                        kind,
                        distance,
                    })),
                }
            }
            draws.extend(run);
        }
        draws.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let triangles = draws.iter().map(|draw| u64::from(draw.triangles())).sum();
        Self { draws, triangles }
    }
}

/// The box around a box that was moved.
pub(super) fn moved_box([low, high]: [Vec3; 2], place: &Affine3A) -> [Vec3; 2] {
    let middle = place.transform_point3(0.5 * (low + high));
    let half = 0.5 * (high - low);
    let [x, y, z] = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis].map(Vec3::from);
    let reach = x.abs() * half.x + y.abs() * half.y + z.abs() * half.z;
    [middle - reach, middle + reach]
}
