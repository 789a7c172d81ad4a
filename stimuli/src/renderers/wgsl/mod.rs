//! Renderers that are a WGSL file and nothing else: a head that declares the parameters ([`head`]) and a function
//!
//! ```wgsl
//! fn colour(at: Place, given: Parameters) -> vec3f
//! ```
//!
//! that gives every display pixel its linear colour. `given` has a member for each parameter. `frame.wgsl` stands around it:
//! `Place`, conversions between pixels, shares of the display and degrees, and the scene's full-resolution picture with
//! its mip chain (`picture_at`, `sample_level`, `sample_sigma`, `sample_mar`). The picture depends on nothing else, so that
//! the same scene, gaze and parameters give the same picture.
//!
//! A frame costs the scene at every display pixel, unless its picture stands still, and the function at every display
//! pixel; the mip chain, a third of the display's pixels, is not counted.

mod check;
mod head;

use crate::contract::{DrawCost, FrameCost, FrameInput, LINEAR_FORMAT, MakeError, RenderError, Renderer, Scene};
use crate::geometry::{GEOMETRY_WGSL, GeometryUniform};
use crate::gpu::Gpu;
use crate::mips::Mips;
use crate::parameters::number;
use crate::pass::{self, Extent};
use crate::renderers::reference::ReferencePicture;
use crate::timing::GpuTimer;
use check::{Faults, check};
use experiments::catalogue::{ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters};
use experiments::display::Display;
use experiments::study::Mistakes;
use head::Head;
use std::fmt::Write as _;
use wgpu::util::DeviceExt;

/// What stands around the user's function.
pub(crate) const FRAME_WGSL: &str = include_str!("frame.wgsl");
/// The longest text that is read, bytes.
const LONGEST_TEXT: usize = 1 << 20;

/// A renderer's text that has been read and checked.
#[derive(Debug)]
pub(crate) struct WgslProgram {
    info: RendererInfo,
    source: String,
    file: String,
}

impl WgslProgram {
    /// Reads and checks a text; `file` is its name in messages.
    ///
    /// # Errors
    /// Every mistake of the head and, where the head has none, the compiler's first one, at the text's own line.
    pub(crate) fn compile(name: &str, text: &str, file: &str) -> Result<Self, Mistakes> {
        let mut faults = Faults::of(text);
        let head = if text.len() > LONGEST_TEXT {
            faults.at(0..0, format!("expected at most {LONGEST_TEXT} bytes, found {}", text.len()));
            Head::default()
        } else {
            head::read(text, &mut faults)
        };
        let source = format!("{text}\n{GEOMETRY_WGSL}\n{FRAME_WGSL}\n{}", parameters_struct(&head.parameters));
        if faults.count() == 0 {
            check(text, &source, &mut faults);
        }
        if faults.count() > 0 {
            return Err(faults.into_mistakes(file));
        }
        let about = if head.about.is_empty() { format!("A renderer from {file}.") } else { head.about };
        let info = RendererInfo {
            id: name.to_owned(),
            version: head.version,
            about,
            source: head.source,
            parameters: head.parameters,
            detail: head.detail,
        };
        Ok(Self { info, source, file: file.to_owned() })
    }

    /// What studies see of it.
    pub(crate) fn info(&self) -> &RendererInfo {
        &self.info
    }

    /// The renderer for a display.
    ///
    /// # Errors
    /// When the device refuses the program.
    pub(crate) fn make(
        &self,
        gpu: &Gpu,
        display: &Display,
        parameters: &Parameters,
    ) -> Result<Box<dyn Renderer>, MakeError> {
        let schemas = self.info.parameters.clone();
        let output = pass::linear_texture(gpu, "WGSL output", display.resolution_px());
        let (pipeline, layout) = self.pipeline(gpu)?;
        Ok(Box::new(WgslRenderer {
            display: display.clone(),
            values: values(&schemas, parameters)?,
            schemas,
            reference: ReferencePicture::new(gpu, display),
            mips: Mips::new(gpu, display.resolution_px()),
            sampler: sampler(gpu),
            output_view: pass::view(&output),
            output,
            pipeline,
            layout,
            shown: None,
            timer: GpuTimer::new(gpu),
        }))
    }

    fn pipeline(&self, gpu: &Gpu) -> Result<(wgpu::RenderPipeline, wgpu::BindGroupLayout), MakeError> {
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&self.info.id),
            source: wgpu::ShaderSource::Wgsl(self.source.as_str().into()),
        });
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        // Given in full, because a function need not use all that it is offered.
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("WGSL renderer"),
            entries: &[entry(0, uniform), entry(1, uniform), entry(2, texture), entry(3, filtering)],
        });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("WGSL renderer"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(&self.info.id),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cover"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("parafovea_pixel"),
                compilation_options: Default::default(),
                targets: &[Some(LINEAR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        match pollster::block_on(scope.pop()) {
            None => Ok((pipeline, layout)),
            Some(error) => Err(MakeError::File {
                file: self.file.clone(),
                reason: format!("expected a program that the graphics device takes, found: {error}"),
            }),
        }
    }
}

/// `Parameters`, a number for each; never empty, since WGSL has no empty structures.
fn parameters_struct(schemas: &[ParameterSchema]) -> String {
    let mut text = "struct Parameters {\n".to_owned();
    for schema in schemas {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "    {}: f32,", schema.name);
    }
    text + "    parafovea_end: f32,\n}\n"
}

/// The parameters' values in the order of the structure.
fn values(schemas: &[ParameterSchema], parameters: &Parameters) -> Result<Vec<f32>, Vec<ParameterError>> {
    schemas.iter().map(|schema| Ok(number(parameters, &schema.name)? as f32)).collect()
}

fn sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("mip chain"),
        address_mode_u: wgpu::AddressMode::MirrorRepeat,
        address_mode_v: wgpu::AddressMode::MirrorRepeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct FrameUniform {
    geometry: GeometryUniform,
    gaze_deg: [f32; 2],
    size: [f32; 2],
}

struct WgslRenderer {
    display: Display,
    schemas: Vec<ParameterSchema>,
    values: Vec<f32>,
    reference: ReferencePicture,
    mips: Mips,
    sampler: wgpu::Sampler,
    output: wgpu::Texture,
    output_view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    /// What the output shows.
    shown: Option<(Vec<f32>, [f64; 2])>,
    timer: GpuTimer,
}

impl WgslRenderer {
    fn bind(&self, gpu: &Gpu, gaze_deg: [f64; 2]) -> wgpu::BindGroup {
        let frame = pass::uniform(
            gpu,
            &FrameUniform {
                geometry: GeometryUniform::new(&self.display, gaze_deg),
                gaze_deg: gaze_deg.map(|x| x as f32),
                size: self.display.resolution_px().map(|x| x as f32),
            },
        );
        // The structure's end, and whole rows of four.
        let mut values = self.values.clone();
        values.resize((values.len() + 1).next_multiple_of(4), 0.0);
        let parameters = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("parameters"),
            contents: bytemuck::cast_slice(&values),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let resources = [
            frame.as_entire_binding(),
            parameters.as_entire_binding(),
            wgpu::BindingResource::TextureView(&self.mips.view),
            wgpu::BindingResource::Sampler(&self.sampler),
        ];
        let entries: Vec<_> = resources
            .into_iter()
            .zip(0..)
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("WGSL renderer"),
            layout: &self.layout,
            entries: &entries,
        })
    }
}

impl Renderer for WgslRenderer {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        let stale = self.reference.is_stale(scene, frame.animation_s);
        let unchanged =
            self.shown.as_ref().is_some_and(|(values, gaze_deg)| *values == self.values && *gaze_deg == frame.gaze_deg);
        if unchanged && !stale {
            return Ok(FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() });
        }
        self.shown = None;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);
        let drawn = self.reference.update(gpu, &mut encoder, scene, frame.animation_s)?;
        if stale {
            self.mips.update(gpu, &mut encoder, &self.reference.texture);
        }
        let bind_group = self.bind(gpu, frame.gaze_deg);
        pass::draw(&mut encoder, &self.pipeline, &bind_group, &self.output_view, Extent::All);
        let gpu_time_s = self.timer.submit(gpu, encoder);
        gpu.check()?;
        self.shown = Some((self.values.clone(), frame.gaze_deg));
        let pixels_shaded = drawn.pixels_shaded + self.display.pixels();
        Ok(DrawCost { pixels_shaded, ..drawn }.in_frame(gpu_time_s))
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        self.values = values(&self.schemas, &complete_parameters(&self.schemas, parameters)?)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
