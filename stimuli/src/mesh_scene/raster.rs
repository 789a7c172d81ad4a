//! The rasterised view: the drawing of a list of chunks into colour, motion, or surfaces.

use super::draw_list::{DrawKind, DrawList};
use super::gpu_world::GpuWorld;
use super::intermediates::Intermediates;
use super::pipelines::{LightKinds, Output, Pipelines, Use};
use crate::contract::DrawRequest;
use crate::gpu::Gpu;
use crate::surfaces::GBuffer;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Samples of a multisampled pixel.
const SAMPLES: u32 = 4;

/// Draws lists of chunks.
pub(super) struct Raster {
    pipelines: Arc<Pipelines>,
    lights: LightKinds,
    intermediates: Intermediates,
}

impl Raster {
    pub(super) fn new(pipelines: Arc<Pipelines>, on_gpu: &GpuWorld, casts_shadow: bool) -> Self {
        let [_, points, areas, _] = on_gpu.light_counts;
        let lights = LightKinds { shadow: casts_shadow, points: points > 0, areas: areas > 0 };
        Self { pipelines, lights, intermediates: Intermediates::default() }
    }

    /// Records the drawing of a list, and of the sky behind it, into the top left corner of `target` and, where it is
    /// asked for, its motion.
    #[expect(clippy::too_many_arguments, reason = "a draw is these things")]
    pub(super) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        on_gpu: &GpuWorld,
        group: &wgpu::BindGroup,
        list: &DrawList,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) {
        let samples = if request.multisampled { SAMPLES } else { 1 };
        let output = Output::Colour { samples, counted: request.tally.is_some() };
        let counters = request.tally.map(|tally| tally.bind(gpu, &self.pipelines.layouts.tally));
        self.pass(gpu, encoder, on_gpu, output, [Some(group), counters.as_ref()], list, request, &[target]);
        self.draw_motion(gpu, encoder, on_gpu, group, list, request);
    }

    /// Records the drawing of what a list shows, unshaded, and of its motion where that is asked for.
    #[expect(clippy::too_many_arguments, reason = "a draw is these things")]
    pub(super) fn draw_surfaces(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        on_gpu: &GpuWorld,
        group: &wgpu::BindGroup,
        list: &DrawList,
        request: &DrawRequest<'_>,
        targets: &GBuffer,
    ) {
        let views = targets.targets().map(|(view, _)| view);
        self.pass(gpu, encoder, on_gpu, Output::Surfaces, [Some(group), None], list, request, &views);
        self.draw_motion(gpu, encoder, on_gpu, group, list, request);
    }

    fn draw_motion(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        on_gpu: &GpuWorld,
        group: &wgpu::BindGroup,
        list: &DrawList,
        request: &DrawRequest<'_>,
    ) {
        if let Some(motion) = request.motion {
            self.pass(gpu, encoder, on_gpu, Output::Motion, [Some(group), None], list, request, &[motion.target]);
        }
    }

    #[expect(clippy::too_many_arguments, reason = "a draw is these things")]
    fn pass(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        on_gpu: &GpuWorld,
        output: Output,
        groups: [Option<&wgpu::BindGroup>; 2],
        list: &DrawList,
        request: &DrawRequest<'_>,
        targets: &[&wgpu::TextureView],
    ) {
        // Before the pass begins, since making one may take long.
        let kinds: BTreeSet<DrawKind> = list.draws.iter().map(|draw| draw.kind).collect();
        let pipeline = |kind| self.pipelines.get(gpu, Use { output, kind, lights: self.lights });
        let surfaces: BTreeMap<DrawKind, _> = kinds.into_iter().map(|kind| (kind, pipeline(Some(kind)))).collect();
        let sky = pipeline(None);
        let Some(texture) = targets.first().map(|target| target.texture()) else { return };
        let intermediate = self.intermediates.of(gpu, [texture.width(), texture.height()], output.samples());
        let attachments: Vec<_> = targets
            .iter()
            .map(|&target| {
                let (view, resolve_target, store) = match &intermediate.colour {
                    Some(multisampled) => (multisampled, Some(target), wgpu::StoreOp::Discard),
                    None => (target, None, wgpu::StoreOp::Store),
                };
                let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store };
                Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target, ops })
            })
            .collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("mesh scene"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &intermediate.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let [width, height] = request.view.target_px;
        pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(0, 0, width, height);
        for (group, index) in groups.iter().zip(0..) {
            if group.is_some() {
                pass.set_bind_group(index, *group, &[]);
            }
        }
        on_gpu.set_buffers(&mut pass);
        let mut current = None;
        for draw in &list.draws {
            if current != Some(draw.kind)
                && let Some(pipeline) = surfaces.get(&draw.kind)
            {
                pass.set_pipeline(pipeline);
                current = Some(draw.kind);
            }
            pass.draw_indexed(draw.indices.clone(), draw.base_vertex, draw.object..draw.object + 1);
        }
        pass.set_pipeline(&sky);
        pass.draw(0..3, 0..1);
    }
}
