//! What of a world does not change, on the GPU: triangles in chunks, materials, maps, lights and the sky.

use super::frame::Frame;
use super::shadow::Shadow;
use crate::contract::{LINEAR_FORMAT, MakeError};
use crate::gpu::{Gpu, GpuError};
use crate::world::mesh::{MeshLevel, Vertex};
use crate::world::{Light, Map, Material, Panorama, World};
use glam::{Vec3, Vec4};
use std::ops::Range;
use wgpu::util::DeviceExt;

/// Triangles of a chunk, about: fewer are left out more often, more are drawn with fewer calls.
const CHUNK_TRIANGLES: usize = 192;
/// Longest side of a map, pixels.
const LARGEST_MAP: u32 = 1024;

/// Triangles that lie together.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    pub(super) indices: Range<u32>,
    pub(super) base_vertex: i32,
    /// Lowest and highest corner in the mesh's space.
    pub(super) bounds: [Vec3; 2],
}

/// Bind group layouts of the mesh shaders.
pub(super) struct Layouts {
    /// Group 0, see `world.wgsl`.
    pub(super) world: wgpu::BindGroupLayout,
    /// Group 1 of shaders that count, see `tally.wgsl`.
    pub(super) tally: wgpu::BindGroupLayout,
}

/// A world's constant part on the GPU.
pub(super) struct GpuWorld {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    materials: wgpu::Buffer,
    lights: wgpu::Buffer,
    /// Lights from far, points, rectangles, nothing.
    pub(super) light_counts: [u32; 4],
    sky: wgpu::TextureView,
    pub(super) sky_levels: u32,
    sky_sampler: wgpu::Sampler,
    colour_maps: wgpu::TextureView,
    data_maps: wgpu::TextureView,
    map_sampler: wgpu::Sampler,
    shadow_sampler: wgpu::Sampler,
    /// By mesh and level.
    chunks: Vec<Vec<Vec<Chunk>>>,
}

/// `Material` of `world.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct MaterialRecord {
    albedo: Vec3,
    roughness: f32,
    emission: Vec3,
    metalness: f32,
    pattern_colour: Vec3,
    pattern_scale: f32,
    pattern: u32,
    pattern_strength: f32,
    pattern_roughness: f32,
    pattern_relief: f32,
    maps: [i32; 4],
    normal_scale: f32,
    cutout: f32,
    reserved: [f32; 2],
}

impl From<&Material> for MaterialRecord {
    fn from(m: &Material) -> Self {
        let map = |index: Option<usize>| index.map_or(-1, |index| index as i32);
        Self {
            albedo: m.albedo,
            roughness: m.roughness,
            emission: m.emission,
            metalness: m.metalness,
            pattern_colour: m.pattern.colour,
            pattern_scale: m.pattern.scale.max(1e-6),
            pattern: m.pattern.kind as u32,
            pattern_strength: m.pattern.strength,
            pattern_roughness: m.pattern.roughness,
            pattern_relief: m.pattern.relief,
            maps: [m.albedo_map, m.emission_map, m.normal_map, m.roughness_map].map(map),
            normal_scale: m.normal_scale,
            cutout: m.cutout.unwrap_or(-1.0),
            reserved: [0.0; 2],
        }
    }
}

/// `Light` of `world.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct LightRecord {
    reach_m: f32,
    reserved: [f32; 3],
    at: Vec4,
    colour: Vec4,
    half_right: Vec4,
    half_up: Vec4,
}

impl From<&Light> for LightRecord {
    fn from(light: &Light) -> Self {
        let record = |reach_m, at: Vec3, colour: Vec3, half_right: Vec3, half_up: Vec3| Self {
            reach_m,
            reserved: [0.0; 3],
            at: at.extend(0.0),
            colour: colour.extend(0.0),
            half_right: half_right.extend(0.0),
            half_up: half_up.extend(0.0),
        };
        match *light {
            Light::Directional { towards, colour } => {
                record(0.0, towards.normalize_or(Vec3::Y), colour, Vec3::ZERO, Vec3::ZERO)
            }
            Light::Point { at, colour, reach_m } => record(reach_m.max(1e-3), at, colour, Vec3::ZERO, Vec3::ZERO),
            Light::Area { at, half_right, half_up, colour } => record(0.0, at, colour, half_right, half_up),
        }
    }
}

impl GpuWorld {
    /// Uploads `world`.
    ///
    /// # Errors
    /// When it has more triangles or maps than the device can hold.
    pub(super) fn new(gpu: &Gpu, world: &World) -> Result<Self, MakeError> {
        let (mut vertices, mut indices) = (Vec::new(), Vec::new());
        let chunks = world
            .meshes
            .iter()
            .map(|mesh| mesh.levels.iter().map(|level| add_level(level, &mut vertices, &mut indices)).collect());
        let chunks = chunks.collect();
        let most = gpu.device.limits().max_buffer_size;
        let needed = (vertices.len() * size_of::<Vertex>()).max(4 * indices.len()) as u64;
        if needed > most {
            let message = format!("the scene needs a buffer of {needed} bytes, the device allows {most}");
            return Err(GpuError::Fault(message).into());
        }
        let layers = gpu.device.limits().max_texture_array_layers as usize;
        let maps = world.colour_maps.len().max(world.data_maps.len());
        if maps > layers {
            let message = format!("the scene has {maps} maps of one kind, the device allows {layers}");
            return Err(GpuError::Fault(message).into());
        }
        // The light that casts the shadow is drawn with it, not with the others; these are sorted by kind.
        let mut shadowed = true;
        let mut lights: [Vec<LightRecord>; 3] = Default::default();
        for light in &world.lights {
            match light {
                Light::Directional { .. } if std::mem::take(&mut shadowed) => {}
                Light::Directional { .. } => lights[0].push(light.into()),
                Light::Point { .. } => lights[1].push(light.into()),
                Light::Area { .. } => lights[2].push(light.into()),
            }
        }
        let count = |kind: usize| lights[kind].len() as u32;
        let light_counts = [count(0), count(1), count(2), 0];
        let lights = lights.concat();
        let materials: Vec<MaterialRecord> = world.materials.iter().map(MaterialRecord::from).collect();
        let levels = world.environment.panorama.pyramid();
        let sampler = |address_mode_u, address_mode_v| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u,
                address_mode_v,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            })
        };
        use wgpu::AddressMode::{ClampToEdge, Repeat};
        Ok(Self {
            vertices: buffer(gpu, &vertices, wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE),
            indices: buffer(gpu, &indices, wgpu::BufferUsages::INDEX | wgpu::BufferUsages::STORAGE),
            materials: buffer(gpu, &materials, wgpu::BufferUsages::STORAGE),
            light_counts,
            lights: buffer(gpu, &lights, wgpu::BufferUsages::STORAGE),
            sky: sky_texture(gpu, &levels),
            sky_levels: levels.len() as u32,
            sky_sampler: sampler(Repeat, ClampToEdge),
            colour_maps: map_array(gpu, &world.colour_maps, wgpu::TextureFormat::Rgba8UnormSrgb),
            data_maps: map_array(gpu, &world.data_maps, wgpu::TextureFormat::Rgba8Unorm),
            map_sampler: sampler(Repeat, Repeat),
            shadow_sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare: Some(wgpu::CompareFunction::LessEqual),
                ..Default::default()
            }),
            chunks,
        })
    }

    /// The chunks of a mesh at a level of detail.
    pub(super) fn chunks(&self, mesh: usize, level: usize) -> &[Chunk] {
        self.chunks.get(mesh).and_then(|levels| levels.get(level)).map_or(&[], Vec::as_slice)
    }

    /// Vertices and indices for draws of chunks.
    pub(super) fn set_buffers(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
    }

    /// Group 0 for one frame.
    pub(super) fn bind(&self, gpu: &Gpu, layouts: &Layouts, frame: &Frame, shadow: &Shadow) -> wgpu::BindGroup {
        use wgpu::BindingResource::{Sampler, TextureView};
        let resources = [
            frame.uniform.as_entire_binding(),
            frame.objects.as_entire_binding(),
            self.materials.as_entire_binding(),
            self.lights.as_entire_binding(),
            TextureView(&self.sky),
            Sampler(&self.sky_sampler),
            TextureView(&self.colour_maps),
            TextureView(&self.data_maps),
            Sampler(&self.map_sampler),
            TextureView(&shadow.view),
            Sampler(&self.shadow_sampler),
        ];
        let entries = resources.into_iter().zip(0..);
        let entries: Vec<_> = entries.map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource }).collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("world"),
            layout: &layouts.world,
            entries: &entries,
        })
    }
}

impl Layouts {
    pub(super) fn new(gpu: &Gpu) -> Self {
        use wgpu::BindingType as Type;
        use wgpu::{BufferBindingType, SamplerBindingType, TextureSampleType, TextureViewDimension};
        let layout = |label, types: &[Type], visibility| {
            let entry = |(&ty, binding)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
            let entries: Vec<_> = types.iter().zip(0..).map(entry).collect();
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let data = |ty| Type::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let texture = |sample_type, view_dimension| Type::Texture { sample_type, view_dimension, multisampled: false };
        let colours = TextureSampleType::Float { filterable: true };
        let uniform = data(BufferBindingType::Uniform);
        let storage = data(BufferBindingType::Storage { read_only: true });
        let counters = data(BufferBindingType::Storage { read_only: false });
        let filtering = Type::Sampler(SamplerBindingType::Filtering);
        let everywhere = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let seen = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        Self {
            world: layout(
                "world",
                &[
                    uniform,
                    storage,
                    storage,
                    storage,
                    texture(colours, TextureViewDimension::D2),
                    filtering,
                    texture(colours, TextureViewDimension::D2Array),
                    texture(colours, TextureViewDimension::D2Array),
                    filtering,
                    texture(TextureSampleType::Depth, TextureViewDimension::D2),
                    Type::Sampler(SamplerBindingType::Comparison),
                ],
                everywhere,
            ),
            tally: layout("tally", &[uniform, counters, counters], seen),
        }
    }
}

/// A buffer of records, one zero record where there are none.
pub(super) fn buffer<T: bytemuck::Pod>(gpu: &Gpu, records: &[T], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let none = [T::zeroed()];
    let contents = bytemuck::cast_slice(if records.is_empty() { &none } else { records });
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

/// Adds a level's vertices and indices, its triangles sorted so that those of a chunk lie together.
fn add_level(level: &MeshLevel, vertices: &mut Vec<Vertex>, indices: &mut Vec<u32>) -> Vec<Chunk> {
    let base_vertex = vertices.len() as i32;
    vertices.extend_from_slice(&level.vertices);
    let place = |index: u32| level.vertices.get(index as usize).map_or(Vec3::ZERO, |v| Vec3::from(v.position));
    let mut triangles: Vec<[u32; 3]> = level.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    if triangles.len() > CHUNK_TRIANGLES {
        let middle = |t: &[u32; 3]| (place(t[0]) + place(t[1]) + place(t[2])) / 3.0;
        let (low, high) = triangles
            .iter()
            .map(middle)
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let cell = (high - low).max_element().max(1e-9) / 1023.0;
        triangles.sort_by_cached_key(|t| morton(((middle(t) - low) / cell).to_array().map(|x| x as u32)));
    }
    let bounds = |chunk: &[[u32; 3]]| {
        let corners = chunk.iter().flatten().map(|&index| place(index));
        corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
    };
    let add = |chunk: &[[u32; 3]]| {
        let first = indices.len() as u32;
        indices.extend(chunk.iter().flatten());
        Chunk { indices: first..indices.len() as u32, base_vertex, bounds: bounds(chunk) }
    };
    triangles.chunks(CHUNK_TRIANGLES).map(add).collect()
}

/// The bits of three numbers below 1024 in turns, so that near cells have near numbers.
fn morton(cell: [u32; 3]) -> u32 {
    let spread = |x: u32| (0..10).fold(0, |sum, bit| sum | (x >> bit & 1) << (3 * bit));
    spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2
}

/// The sky as half floats with its pyramid.
fn sky_texture(gpu: &Gpu, levels: &[Panorama]) -> wgpu::TextureView {
    let size = levels.first().map_or([1, 1], |level| level.size);
    // The texture's own levels, each as large as the device expects; the pyramid's are the same.
    let texels = levels.iter().flat_map(|level| {
        // Half floats end at 65504; nothing that is shown comes near.
        level.radiance.iter().flat_map(|c| c.min(Vec3::splat(6e4)).extend(1.0).to_array())
    });
    let halves: Vec<u16> = texels.map(|x| half::f16::from_f32(x).to_bits()).collect();
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some("sky"),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: levels.len().max(1) as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: LINEAR_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&halves),
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// All maps of a kind as layers of one texture with their pyramids, each brought to the size of the largest.
fn map_array(gpu: &Gpu, maps: &[Map], format: wgpu::TextureFormat) -> wgpu::TextureView {
    let longest = maps.iter().map(|map| map.size[0].max(map.size[1])).max().unwrap_or(1);
    let side = longest.next_power_of_two().clamp(1, LARGEST_MAP);
    let white = Map { size: [1, 1], rgba: vec![255; 4] };
    let used = if maps.is_empty() { std::slice::from_ref(&white) } else { maps };
    let mut bytes = Vec::new();
    for map in used {
        bytes.extend(map_pyramid(map, side, format.is_srgb()));
    }
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some("maps"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: used.len() as u32 },
            mip_level_count: side.ilog2() + 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &bytes,
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

/// A map's levels from `side` × `side` pixels down to one; colours are averaged in linear light.
fn map_pyramid(map: &Map, side: u32, srgb: bool) -> Vec<u8> {
    let decode = |byte: u8, channel: usize| {
        if srgb && channel < 3 { crate::display_pass::linear_from_srgb8(byte) } else { f32::from(byte) / 255.0 }
    };
    let encode = |value: f32, channel: usize| {
        let value = if srgb && channel < 3 { srgb_from_linear(value) } else { value };
        (255.0 * value).round().clamp(0.0, 255.0) as u8
    };
    let table: Vec<[f32; 2]> = (0..=255).map(|byte| [decode(byte, 0), decode(byte, 3)]).collect();
    let pixels = map
        .rgba
        .chunks_exact(4)
        .map(|p| [0, 1, 2, 3].map(|channel| table[usize::from(p[channel])][usize::from(channel == 3)]));
    let mut level = image::Rgba32FImage::from_raw(map.size[0], map.size[1], pixels.flatten().collect())
        .unwrap_or_else(|| image::Rgba32FImage::from_pixel(1, 1, image::Rgba([1.0; 4])));
    let mut bytes = Vec::new();
    let mut width = side;
    loop {
        if [level.width(), level.height()] != [width; 2] {
            // Triangle: the average over the footprint where it shrinks, linear between pixels where it grows.
            level = image::imageops::resize(&level, width, width, image::imageops::FilterType::Triangle);
        }
        bytes.extend(level.pixels().flat_map(|p| [0, 1, 2, 3].map(|channel| encode(p.0[channel], channel))));
        if width == 1 {
            return bytes;
        }
        width /= 2;
    }
}

fn srgb_from_linear(c: f32) -> f32 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}
