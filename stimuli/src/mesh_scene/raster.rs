//! The rasterised view: pipelines for every kind of surface, and the drawing of a list of chunks into colour and motion.

use super::draw_list::{DrawKind, DrawList};
use super::gpu_world::GpuWorld;
use super::intermediates::{DEPTH_FORMAT, Intermediates};
use crate::contract::{DrawRequest, LINEAR_FORMAT};
use crate::geometry::GEOMETRY_WGSL;
use crate::gpu::Gpu;
use crate::surfaces::GBuffer;
use crate::world::mesh::Vertex;
use std::collections::{BTreeMap, BTreeSet};

pub(crate) const WGSL: &str = concat!(
    include_str!("world.wgsl"),
    "\n",
    include_str!("patterns.wgsl"),
    "\n",
    include_str!("shading.wgsl"),
    "\n",
    include_str!("raster.wgsl"),
    "\n",
    include_str!("g_buffer.wgsl")
);
pub(crate) const COUNTED_WGSL: &str = concat!(
    include_str!("world.wgsl"),
    "\n",
    include_str!("patterns.wgsl"),
    "\n",
    include_str!("shading.wgsl"),
    "\n",
    include_str!("raster.wgsl"),
    "\n",
    include_str!("../tally.wgsl"),
    "\n",
    include_str!("counted.wgsl")
);

/// The attribute by which counted shaders have depth tested before.
const EARLY_DEPTH: &str = "@early_depth_test(force)";
/// Samples of a multisampled pixel.
const SAMPLES: u32 = 4;

/// What a pass writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Output {
    Colour { samples: u32, counted: bool },
    Motion,
    Surfaces,
}

impl Output {
    fn samples(self) -> u32 {
        match self {
            Self::Colour { samples, .. } => samples,
            Self::Motion | Self::Surfaces => 1,
        }
    }

    fn is_counted(self) -> bool {
        matches!(self, Self::Colour { counted: true, .. })
    }

    /// Fragment shaders for whole surfaces, for those with holes, and for the sky.
    fn entries(self) -> [&'static str; 3] {
        match self {
            Self::Colour { counted: false, .. } => ["colour", "colour_with_holes", "sky_colour"],
            Self::Colour { counted: true, .. } => ["colour_counted", "colour_with_holes_counted", "sky_colour_counted"],
            Self::Motion => ["motion", "motion_with_holes", "sky_motion"],
            Self::Surfaces => ["surfaces", "surfaces_with_holes", "sky_surfaces"],
        }
    }

    fn formats(self) -> Vec<wgpu::TextureFormat> {
        match self {
            Self::Colour { .. } | Self::Motion => vec![LINEAR_FORMAT],
            Self::Surfaces => vec![LINEAR_FORMAT, LINEAR_FORMAT, LINEAR_FORMAT, GBuffer::DEPTH_FORMAT],
        }
    }
}

/// Which pipeline: what it writes, and for which kind of surface; the sky where there is none.
type Use = (Output, Option<DrawKind>);

/// Draws lists of chunks.
pub(super) struct Raster {
    module: wgpu::ShaderModule,
    /// Compiled when something is first counted.
    counted_module: Option<wgpu::ShaderModule>,
    layout: wgpu::PipelineLayout,
    counted_layout: wgpu::PipelineLayout,
    tally_layout: wgpu::BindGroupLayout,
    light_counts: [u32; 4],
    casts_shadow: bool,
    /// Each made when it is first needed: drivers take their time.
    pipelines: BTreeMap<Use, wgpu::RenderPipeline>,
    intermediates: Intermediates,
}

fn module(gpu: &Gpu, wgsl: &str) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("mesh scene"),
        source: wgpu::ShaderSource::Wgsl(format!("{GEOMETRY_WGSL}\n{wgsl}").into()),
    })
}

impl Raster {
    pub(super) fn new(gpu: &Gpu, on_gpu: &GpuWorld, casts_shadow: bool) -> Self {
        let layouts = &on_gpu.layouts;
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("mesh scene"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        Self {
            module: module(gpu, WGSL),
            counted_module: None,
            layout: layout(&[Some(&layouts.world)]),
            counted_layout: layout(&[Some(&layouts.world), Some(&layouts.tally)]),
            tally_layout: layouts.tally.clone(),
            light_counts: on_gpu.light_counts,
            casts_shadow,
            pipelines: BTreeMap::new(),
            intermediates: Intermediates::default(),
        }
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
        let counters = request.tally.map(|tally| tally.bind(gpu, &self.tally_layout));
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
        self.make_pipelines(gpu, output, list);
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
                && let Some(pipeline) = self.pipelines.get(&(output, Some(draw.kind)))
            {
                pass.set_pipeline(pipeline);
                current = Some(draw.kind);
            }
            pass.draw_indexed(draw.indices.clone(), draw.base_vertex, draw.object..draw.object + 1);
        }
        if let Some(sky) = self.pipelines.get(&(output, None)) {
            pass.set_pipeline(sky);
            pass.draw(0..3, 0..1);
        }
    }

    /// Makes what a list needs and is not there yet.
    fn make_pipelines(&mut self, gpu: &Gpu, output: Output, list: &DrawList) {
        let [colour, holes, sky] = output.entries();
        if output.is_counted() && self.counted_module.is_none() {
            // Where depth cannot be tested before by command, what is hidden is counted as well.
            let forced = gpu.device.features().contains(wgpu::Features::SHADER_EARLY_DEPTH_TEST);
            let attribute = if forced { EARLY_DEPTH } else { "" };
            self.counted_module = Some(module(gpu, &COUNTED_WGSL.replace(EARLY_DEPTH, attribute)));
        }
        let kinds: BTreeSet<Option<DrawKind>> =
            list.draws.iter().map(|draw| Some(draw.kind)).chain(std::iter::once(None)).collect();
        for kind in kinds {
            if self.pipelines.contains_key(&(output, kind)) {
                continue;
            }
            let (vertex, fragment) = match kind {
                None => ("cover_far", sky),
                Some(kind) => ("transform", if kind.holes { holes } else { colour }),
            };
            let made = self.pipeline(gpu, output, vertex, fragment, kind);
            self.pipelines.insert((output, kind), made);
        }
    }

    /// A pipeline for a kind of surface, or for the sky.
    fn pipeline(
        &self,
        gpu: &Gpu,
        output: Output,
        vertex: &str,
        fragment: &str,
        kind: Option<DrawKind>,
    ) -> wgpu::RenderPipeline {
        let (module, layout) = match &self.counted_module {
            Some(module) if output.is_counted() => (module, &self.counted_layout),
            _ => (&self.module, &self.layout),
        };
        let corners = [Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x2],
        })];
        let targets: Vec<_> = output.formats().into_iter().map(|format| Some(format.into())).collect();
        // What this pipeline need not ask at every pixel.
        let [_, points, areas, _] = self.light_counts;
        let constants = [
            ("PATTERN", f64::from(kind.map_or(0, |kind| kind.pattern))),
            ("HAS_MAPS", f64::from(u8::from(kind.is_some_and(|kind| kind.maps)))),
            ("HAS_RELIEF", f64::from(u8::from(kind.is_some_and(|kind| kind.relief)))),
            ("HAS_SHADOW", f64::from(u8::from(self.casts_shadow))),
            ("HAS_POINT_LIGHTS", f64::from(u8::from(points > 0))),
            ("HAS_AREA_LIGHTS", f64::from(u8::from(areas > 0))),
        ];
        let one_sided = kind.is_some_and(|kind| !kind.two_sided);
        let mirrored = kind.is_some_and(|kind| kind.mirrored);
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: Default::default(),
                buffers: if kind.is_some() { &corners } else { &[] },
            },
            primitive: wgpu::PrimitiveState {
                front_face: if mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
                cull_mode: one_sided.then_some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(kind.is_some()),
                // Nothing but the sky is at depth 0.
                depth_compare: Some(if kind.is_some() {
                    wgpu::CompareFunction::Greater
                } else {
                    wgpu::CompareFunction::GreaterEqual
                }),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: output.samples(), ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
