//! Multisampled colours and depths as large as the targets that are drawn: kept, because a frame's layers take turns.

use crate::contract::LINEAR_FORMAT;
use crate::gpu::Gpu;

/// The format of depths.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Sets that are kept: four layers, and the whole display.
const KEPT: usize = 6;

/// Buffers for one size of target.
pub(super) struct Intermediate {
    size: [u32; 2],
    samples: u32,
    pub(super) depth: wgpu::TextureView,
    /// Where there are several samples a pixel.
    pub(super) colour: Option<wgpu::TextureView>,
}

#[derive(Default)]
pub(super) struct Intermediates {
    /// Used last comes last.
    kept: Vec<Intermediate>,
}

impl Intermediates {
    /// The buffers for a target of `size` with `samples` samples a pixel.
    pub(super) fn of(&mut self, gpu: &Gpu, size: [u32; 2], samples: u32) -> &Intermediate {
        let found = self.kept.iter().position(|kept| kept.size == size && kept.samples == samples);
        let used = match found {
            Some(index) => self.kept.remove(index),
            None => {
                if self.kept.len() >= KEPT {
                    self.kept.remove(0);
                }
                let texture = |format| {
                    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                        label: Some("intermediate"),
                        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                        mip_level_count: 1,
                        sample_count: samples,
                        dimension: wgpu::TextureDimension::D2,
                        format,
                        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                        view_formats: &[],
                    });
                    texture.create_view(&wgpu::TextureViewDescriptor::default())
                };
                let colour = (samples > 1).then(|| texture(LINEAR_FORMAT));
                Intermediate { size, samples, depth: texture(DEPTH_FORMAT), colour }
            }
        };
        self.kept.push(used);
        &self.kept[self.kept.len() - 1]
    }
}
