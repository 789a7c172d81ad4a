//! The pipelines of mesh scenes, made once for a device and shared by all scenes: drivers take their time over each.

use super::draw_list::DrawKind;
use super::gpu_world::Layouts;
use super::intermediates::DEPTH_FORMAT;
use crate::contract::LINEAR_FORMAT;
use crate::geometry::GEOMETRY_WGSL;
use crate::gpu::Gpu;
use crate::surfaces::GBuffer;
use crate::world::mesh::Vertex;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The text of group 0 and the shading function, which all of these begin with.
macro_rules! shading {
    () => {
        concat!(include_str!("world.wgsl"), "\n", include_str!("patterns.wgsl"), "\n", include_str!("shading.wgsl"))
    };
}

pub(crate) const WGSL: &str =
    concat!(shading!(), "\n", include_str!("raster.wgsl"), "\n", include_str!("g_buffer.wgsl"));
pub(crate) const COUNTED_WGSL: &str = concat!(
    shading!(),
    "\n",
    include_str!("raster.wgsl"),
    "\n",
    include_str!("../tally.wgsl"),
    "\n",
    include_str!("counted.wgsl")
);
/// What [`crate::surfaces::SHADING_WGSL`] is.
pub(crate) const SHADING_WGSL: &str =
    concat!(include_str!("../geometry.wgsl"), "\n", shading!(), "\n", include_str!("deferred.wgsl"));
/// What [`crate::surfaces::RAYS_WGSL`] is.
pub(crate) const RAYS_WGSL: &str = concat!(
    include_str!("../geometry.wgsl"),
    "\n",
    shading!(),
    "\n",
    include_str!("deferred.wgsl"),
    "\n",
    include_str!("rays.wgsl")
);
/// The attribute by which counted shaders have depth tested before.
const EARLY_DEPTH: &str = "@early_depth_test(force)";
/// What a pass writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Output {
    Colour { samples: u32, counted: bool },
    Motion,
    Surfaces,
}

impl Output {
    pub(super) fn samples(self) -> u32 {
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

/// Which pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    /// What it writes.
    pub(super) output: Output,
    /// For which kind of surface; the sky where there is none.
    pub(super) kind: Option<DrawKind>,
    pub(super) lights: LightKinds,
}

/// Which kinds of light a world has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct LightKinds {
    pub(super) shadow: bool,
    pub(super) points: bool,
    pub(super) areas: bool,
}

/// Modules, layouts and pipelines of one device.
pub(super) struct Pipelines {
    pub(super) layouts: Layouts,
    module: wgpu::ShaderModule,
    /// Compiled when something is first counted.
    counted_module: OnceLock<wgpu::ShaderModule>,
    layout: wgpu::PipelineLayout,
    counted_layout: wgpu::PipelineLayout,
    made: Mutex<BTreeMap<Use, wgpu::RenderPipeline>>,
}

fn module(gpu: &Gpu, wgsl: &str) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("mesh scene"),
        source: wgpu::ShaderSource::Wgsl(format!("{GEOMETRY_WGSL}\n{wgsl}").into()),
    })
}

impl Pipelines {
    /// Those of a device.
    pub(super) fn of(gpu: &Gpu) -> Arc<Self> {
        gpu.shared(Self::new)
    }

    fn new(gpu: &Gpu) -> Self {
        let layouts = Layouts::new(gpu);
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("mesh scene"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        Self {
            module: module(gpu, WGSL),
            counted_module: OnceLock::new(),
            layout: layout(&[Some(&layouts.world)]),
            counted_layout: layout(&[Some(&layouts.world), Some(&layouts.tally)]),
            layouts,
            made: Mutex::default(),
        }
    }

    /// The pipeline for a use, made when it is first needed.
    pub(super) fn get(&self, gpu: &Gpu, wanted: Use) -> wgpu::RenderPipeline {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        made.entry(wanted).or_insert_with(|| self.make(gpu, wanted)).clone()
    }

    /// The module that counts. Where depth cannot be tested before by command, what is hidden is counted as well.
    fn counted_module(&self, gpu: &Gpu) -> &wgpu::ShaderModule {
        self.counted_module.get_or_init(|| {
            let forced = gpu.device.features().contains(wgpu::Features::SHADER_EARLY_DEPTH_TEST);
            let attribute = if forced { EARLY_DEPTH } else { "" };
            module(gpu, &COUNTED_WGSL.replace(EARLY_DEPTH, attribute))
        })
    }

    fn make(&self, gpu: &Gpu, Use { output, kind, lights }: Use) -> wgpu::RenderPipeline {
        let [colour, holes, sky] = output.entries();
        let (vertex, fragment) = match kind {
            None => ("cover_far", sky),
            Some(kind) if kind.holes => ("transform", holes),
            Some(_) if output == Output::Motion => ("transform_for_motion", colour),
            Some(_) => ("transform", colour),
        };
        let (module, layout) = match output.is_counted() {
            true => (self.counted_module(gpu), &self.counted_layout),
            false => (&self.module, &self.layout),
        };
        let corners = [Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x2],
        })];
        let targets: Vec<_> = output.formats().into_iter().map(|format| Some(format.into())).collect();
        // What this pipeline need not ask at every pixel.
        let constants = [
            ("PATTERN", f64::from(kind.map_or(0, |kind| kind.pattern))),
            ("HAS_MAPS", f64::from(u8::from(kind.is_some_and(|kind| kind.maps)))),
            ("HAS_RELIEF", f64::from(u8::from(kind.is_some_and(|kind| kind.relief)))),
            ("HAS_SHADOW", f64::from(u8::from(lights.shadow))),
            ("HAS_POINT_LIGHTS", f64::from(u8::from(lights.points))),
            ("HAS_AREA_LIGHTS", f64::from(u8::from(lights.areas))),
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
