//! A picture with coarser and coarser copies of itself, averaged in linear light on the GPU.

use crate::contract::LINEAR_FORMAT;
use crate::gpu::Gpu;
use crate::pass::{self, Extent};

pub(crate) const WGSL: &str = include_str!("mips.wgsl");

/// A picture's mip chain.
pub(crate) struct Mips {
    texture: wgpu::Texture,
    /// All levels.
    pub(crate) view: wgpu::TextureView,
    levels: Vec<wgpu::TextureView>,
    pipeline: wgpu::RenderPipeline,
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    source: [i32; 2],
    target: [i32; 2],
}

/// Width and height of a level of a picture of `size`, as the GPU has it.
fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|extent| extent.checked_shr(level).unwrap_or(0).max(1))
}

impl Mips {
    /// A chain down to one pixel, for pictures of `size`. Nothing is in it yet.
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let count = 1 + size[0].max(size[1]).max(1).ilog2();
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("mip chain"),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: LINEAR_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let level = |level| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            })
        };
        Self {
            levels: (0..count).map(level).collect(),
            view: pass::view(&texture),
            pipeline: pass::pipeline(gpu, "mips", WGSL, "shrink", LINEAR_FORMAT),
            texture,
        }
    }

    /// Records the copying of `picture`, which has the chain's size, and the making of every level below it.
    pub(crate) fn update(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, picture: &wgpu::Texture) {
        pass::copy(encoder, picture, &self.texture);
        let size = [self.texture.width(), self.texture.height()];
        for (pair, level) in self.levels.windows(2).zip(1..) {
            let [finer, coarser] = pair else { continue };
            let to = |level| level_size(size, level).map(|x| x as i32);
            let uniform = pass::uniform(gpu, &Uniform { source: to(level - 1), target: to(level) });
            let bind_group = pass::bind(gpu, &self.pipeline, &uniform, &[finer]);
            pass::draw(encoder, &self.pipeline, &bind_group, coarser, Extent::All);
        }
    }
}
