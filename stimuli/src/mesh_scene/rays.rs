//! The traced view: the triangles and hierarchies of a world as `rays.wgsl` walks them.
//!
//! Every mesh is traced at its finest level: a ray does not care how many triangles it passes by.

use super::gpu_world::buffer;
use crate::gpu::Gpu;
use crate::world::World;
use crate::world::bvh::{Bvh, Node};
use glam::{Affine3A, Mat4, Vec3, Vec4};

/// Triangles of a leaf, about.
const LEAF_TRIANGLES: u32 = 4;

/// `Traced` of `rays.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct TracedRecord {
    inverse: [Vec4; 3],
    root: u32,
    object: u32,
    reserved: [u32; 2],
}

/// A world's triangles in hierarchies, on the GPU.
pub(super) struct Rays {
    mesh_nodes: wgpu::Buffer,
    triangles: wgpu::Buffer,
    vertices: wgpu::Buffer,
    /// Of each mesh the root among the nodes and its box; nothing for an empty one.
    roots: Vec<Option<(u32, [Vec3; 2])>>,
    pub(super) layout: wgpu::BindGroupLayout,
}

impl Rays {
    /// Builds the hierarchies of every mesh.
    pub(super) fn new(gpu: &Gpu, world: &World) -> Self {
        let (mut nodes, mut triangles, mut vertices): (Vec<Node>, Vec<u32>, Vec<_>) = Default::default();
        let roots = world
            .meshes
            .iter()
            .map(|mesh| {
                let level = mesh.levels.first()?;
                let first_vertex = vertices.len() as u32;
                let place = |index: u32| level.vertices.get(index as usize).map_or(Vec3::ZERO, |v| v.position.into());
                let corners: Vec<&[u32]> = level.indices.chunks_exact(3).collect();
                let boxes: Vec<[Vec3; 2]> = corners
                    .iter()
                    .map(|t| {
                        let [a, b, c] = [place(t[0]), place(t[1]), place(t[2])];
                        [a.min(b).min(c), a.max(b).max(c)]
                    })
                    .collect();
                let bvh = Bvh::over(&boxes, LEAF_TRIANGLES);
                let (first_node, first_triangle) = (nodes.len() as u32, triangles.len() as u32 / 3);
                nodes.extend(bvh.nodes.iter().map(|node| {
                    let begin = if node.count == 0 { first_node } else { first_triangle };
                    Node { first: node.first + begin, ..*node }
                }));
                for &item in &bvh.items {
                    triangles.extend(corners[item as usize].iter().map(|index| index + first_vertex));
                }
                vertices.extend_from_slice(&level.vertices);
                Some((first_node, mesh.bounds()?)).filter(|_| !bvh.nodes.is_empty())
            })
            .collect();
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let visibility = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let entries: Vec<_> = (0..5)
            .map(|binding| wgpu::BindGroupLayoutEntry { binding, visibility, ty: storage, count: None })
            .collect();
        Self {
            mesh_nodes: buffer(gpu, &nodes, wgpu::BufferUsages::STORAGE),
            triangles: buffer(gpu, &triangles, wgpu::BufferUsages::STORAGE),
            vertices: buffer(gpu, &vertices, wgpu::BufferUsages::STORAGE),
            roots,
            layout: gpu
                .device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("rays"), entries: &entries }),
        }
    }

    /// Group 1 with the objects at their places.
    pub(super) fn bind(&self, gpu: &Gpu, world: &World, places: &[Affine3A]) -> wgpu::BindGroup {
        let mut records = Vec::new();
        let mut boxes = Vec::new();
        for ((object, place), index) in world.objects.iter().zip(places).zip(0..) {
            let Some((root, bounds)) = self.roots.get(object.mesh).copied().flatten() else { continue };
            let inverse = place.inverse();
            if !inverse.is_finite() {
                // Flattened to nothing that a ray could meet.
                continue;
            }
            let rows = Mat4::from(inverse);
            let inverse = [rows.row(0), rows.row(1), rows.row(2)];
            records.push(TracedRecord { inverse, root, object: index, reserved: [0; 2] });
            boxes.push(super::draw_list::moved_box(bounds, place));
        }
        let bvh = Bvh::over(&boxes, 1);
        let mut sorted: Vec<TracedRecord> = bvh.items.iter().map(|&item| records[item as usize]).collect();
        if sorted.is_empty() {
            // Says that there is nothing.
            sorted.push(TracedRecord { inverse: [Vec4::ZERO; 3], root: u32::MAX, object: 0, reserved: [0; 2] });
        }
        let object_nodes = buffer(gpu, &bvh.nodes, wgpu::BufferUsages::STORAGE);
        let traced = buffer(gpu, &sorted, wgpu::BufferUsages::STORAGE);
        let buffers = [&object_nodes, &traced, &self.mesh_nodes, &self.triangles, &self.vertices];
        let entries = buffers.iter().zip(0..);
        let entries: Vec<_> = entries
            .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("rays"),
            layout: &self.layout,
            entries: &entries,
        })
    }
}
