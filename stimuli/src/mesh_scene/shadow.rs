//! The shadow of the sun: depths of the whole world as seen from it, drawn again only when something has moved.

use super::draw_list::DrawList;
use super::frame::Frame;
use super::gpu_world::GpuWorld;
use super::intermediates::DEPTH_FORMAT;
use crate::geometry::GEOMETRY_WGSL;
use crate::gpu::Gpu;
use crate::world::environment::Sun;
use crate::world::mesh::Vertex;
use crate::world::{Light, World};
use glam::{Mat4, Vec3};

pub(crate) const WGSL: &str = concat!(include_str!("world.wgsl"), "\n", include_str!("shadow.wgsl"));

/// Texels along a side.
const SIZE: u32 = 2048;

/// The sun's view of the world.
pub(super) struct Shadow {
    sun: Sun,
    matrix: Mat4,
    texel_m: f32,
    pub(super) view: wgpu::TextureView,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    drawn_s: Option<f64>,
}

impl Shadow {
    pub(super) fn new(gpu: &Gpu, world: &World) -> Self {
        // The first light from far, or else the sky's own sun.
        let lamp = world.lights.iter().find_map(|light| match *light {
            Light::Directional { towards, colour } => Some(Sun { towards: towards.normalize_or(Vec3::Y), colour }),
            _ => None,
        });
        let sun = lamp.or(world.environment.sun);
        let bounds = sun.and(world.shadow_bounds.or_else(|| world.bounds(0.0)));
        let (matrix, texel_m) = bounds.zip(sun).map_or((Mat4::IDENTITY, 0.0), |(b, sun)| sun_view(b, sun.towards));
        let size = if texel_m > 0.0 { SIZE } else { 1 };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shadow"),
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform),
                entry(1, wgpu::BufferBindingType::Storage { read_only: true }),
            ],
        });
        Self {
            sun: sun.unwrap_or(Sun { towards: Vec3::Y, colour: Vec3::ZERO }),
            matrix,
            texel_m,
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            pipeline: pipeline(gpu, &layout),
            layout,
            drawn_s: None,
        }
    }

    /// The light that casts the shadow; dark where there is none.
    pub(super) fn sun(&self) -> Sun {
        self.sun
    }

    /// From the world to places and depths on the map, 0–1.
    pub(super) fn matrix(&self) -> Mat4 {
        self.matrix
    }

    /// Width of a texel, metres; 0 where there is no shadow.
    pub(super) fn texel_m(&self) -> f32 {
        self.texel_m
    }

    /// Records the drawing of the map, if what it shows has moved.
    pub(super) fn update(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        world: &World,
        on_gpu: &GpuWorld,
        frame: &Frame,
        animation_s: f64,
    ) {
        let current = self.drawn_s.is_some_and(|drawn_s| drawn_s == animation_s || !world.has_moving_objects());
        if current || self.texel_m <= 0.0 {
            return;
        }
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: frame.uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: frame.objects.as_entire_binding() },
            ],
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            color_attachments: &[],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        on_gpu.set_buffers(&mut pass);
        for draw in DrawList::everything(world, on_gpu, frame).draws {
            pass.draw_indexed(draw.indices, draw.base_vertex, draw.object..draw.object + 1);
        }
        drop(pass);
        self.drawn_s = Some(animation_s);
    }
}

/// The matrix of a view along the light that holds a box, and the width of a texel.
fn sun_view([low, high]: [Vec3; 2], towards: Vec3) -> (Mat4, f32) {
    let middle = 0.5 * (low + high);
    let right = towards.any_orthonormal_vector();
    let up = towards.cross(right);
    let half = 0.5 * (high - low);
    let reach = |axis: Vec3| axis.abs().dot(half).max(1e-3) * 1.01;
    let [x, y, z] = [right, up, towards].map(|axis| (axis, reach(axis)));
    let row = |(axis, reach): (Vec3, f32), sign: f32| {
        (sign * axis / (2.0 * reach)).extend(0.5 - sign * axis.dot(middle) / (2.0 * reach))
    };
    let matrix = Mat4::from_cols(row(x, 1.0), row(y, -1.0), row(z, -1.0), glam::Vec4::W).transpose();
    (matrix, 2.0 * x.1.max(y.1) / SIZE as f32)
}

fn pipeline(gpu: &Gpu, layout: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("shadow"),
        source: wgpu::ShaderSource::Wgsl(format!("{GEOMETRY_WGSL}\n{WGSL}").into()),
    });
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("shadow"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("shadow"),
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("transform_to_sun"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState { constant: 2, slope_scale: 1.5, clamp: 0.0 },
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}
