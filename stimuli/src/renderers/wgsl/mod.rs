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

mod head;

use crate::contract::{DrawCost, FrameCost, FrameInput, LINEAR_FORMAT, MakeError, RenderError, Renderer, Scene};
use crate::geometry::{GEOMETRY_WGSL, GeometryUniform};
use crate::gpu::Gpu;
use crate::mips::Mips;
use crate::parameters::number;
use crate::pass::{self, Extent};
use crate::renderers::reference::ReferencePicture;
use crate::timing::GpuTimer;
use experiments::catalogue::{ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters};
use experiments::display::Display;
use experiments::study::{Mistake, Mistakes};
use head::Head;
use std::fmt::Write as _;
use std::ops::Range;
use wgpu::naga;
use wgpu::util::DeviceExt;

/// What stands around the user's function.
pub(crate) const FRAME_WGSL: &str = include_str!("frame.wgsl");
/// How the function is declared.
const FUNCTION: &str = "fn colour(at: Place, given: Parameters) -> vec3f";
/// Names that begin so are the frame's own.
const OWN_PREFIX: &str = "parafovea_";
/// The longest text that is read, bytes.
const LONGEST_TEXT: usize = 1 << 20;

/// Collects what is wrong with a text.
pub(super) struct Faults<'t> {
    text: &'t str,
    list: Vec<Mistake>,
}

impl Faults<'_> {
    /// Notes a mistake at bytes of the text.
    pub(super) fn at(&mut self, span: Range<usize>, message: impl Into<String>) {
        let start = self.text.floor_char_boundary(span.start.min(self.text.len()));
        let before = &self.text[..start];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        self.list.push(Mistake {
            span: start..span.end.clamp(start, self.text.len()),
            line: 1 + before.matches('\n').count(),
            column: 1 + before[line_start..].chars().count(),
            field: String::new(),
            message: message.into(),
        });
    }

    pub(super) fn count(&self) -> usize {
        self.list.len()
    }
}

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
        let mut faults = Faults { text, list: Vec::new() };
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
            let mut list = faults.list;
            list.sort_by_key(|mistake| mistake.span.start);
            return Err(Mistakes { file: file.to_owned(), text: text.to_owned(), list });
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

/// Parses and validates the whole program, and reports the compiler's first error where the user's text caused it.
fn check(text: &str, source: &str, faults: &mut Faults<'_>) {
    let within = |span: &Range<usize>| span.start < text.len() && span.end <= text.len() + 1;
    let module = match naga::front::wgsl::parse_str(source) {
        Ok(module) => module,
        Err(error) => {
            let labels: Vec<(Range<usize>, String)> =
                error.labels().filter_map(|(span, label)| Some((span.to_range()?, label.to_owned()))).collect();
            let message = with_notes(error.message(), error.notes());
            return blame(text, source, &labels, &message, faults);
        }
    };
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    if let Err(error) = validator.validate(&module) {
        let labels: Vec<(Range<usize>, String)> =
            error.spans().filter_map(|(span, label)| Some((span.to_range()?, label.clone()))).collect();
        let mut message = error.as_inner().to_string();
        let mut cause = std::error::Error::source(error.as_inner());
        while let Some(error) = cause {
            let _ = write!(message, ": {error}");
            cause = error.source();
        }
        return blame(text, source, &labels, &message, faults);
    }

    // What the frame does not provide for.
    for (handle, variable) in module.global_variables.iter() {
        let span = module.global_variables.get_span(handle).to_range().unwrap_or_default();
        if variable.binding.is_some() && within(&span) {
            faults.at(span, "expected no bindings, which belong to the frame around the function, found one");
        }
    }
    for (handle, _) in module.overrides.iter() {
        let span = module.overrides.get_span(handle).to_range().unwrap_or_default();
        faults.at(span, "expected a parameter in the head, found an override, which nobody sets");
    }
    for (handle, function) in module.functions.iter() {
        let span = module.functions.get_span(handle).to_range().unwrap_or_default();
        let name = function.name.as_deref().unwrap_or_default();
        if name.starts_with(OWN_PREFIX) && within(&span) {
            faults.at(span, format!("expected a name that does not begin with {OWN_PREFIX}, found {name}"));
        }
    }
}

fn with_notes<'n>(message: &str, notes: impl Iterator<Item = &'n str>) -> String {
    notes.fold(message.to_owned(), |all, note| format!("{all} ({note})"))
}

/// Puts a compiler's error where the user can do something about it.
fn blame(text: &str, source: &str, labels: &[(Range<usize>, String)], message: &str, faults: &mut Faults<'_>) {
    let own = labels.iter().find(|(span, _)| span.start < text.len());
    let elsewhere = labels.iter().find(|(span, _)| span.start >= text.len());
    match (own, elsewhere) {
        // Two things of one name: the compiler sees the frame's as the second one.
        (Some((span, _)), Some(_)) if message.contains("redefinition") => {
            let name = text.get(span.clone()).unwrap_or_default();
            faults.at(
                span.clone(),
                format!("expected a name of its own, found \"{name}\", which the frame around the function uses"),
            );
        }
        (Some((span, label)), _) => {
            let label =
                if label.is_empty() || message.contains(label.as_str()) { String::new() } else { format!(": {label}") };
            faults.at(span.clone(), format!("expected valid WGSL: {message}{label}"));
        }
        (None, _) => {
            // The frame's call failed, so the function is missing or is another one.
            match function_name(text) {
                None => faults.at(0..0, format!("expected a function `{FUNCTION}`, found none called colour")),
                Some(span) => {
                    let calls = elsewhere.and_then(|(span, _)| source.get(span.clone())).unwrap_or_default();
                    let hint = if calls.is_empty() {
                        String::new()
                    } else {
                        format!(" (at `{calls}` of the frame around it)")
                    };
                    faults.at(span, format!("expected `{FUNCTION}`, found another declaration: {message}{hint}"));
                }
            }
        }
    }
}

/// Where the text declares a function called `colour`.
fn function_name(text: &str) -> Option<Range<usize>> {
    text.match_indices("colour").map(|(at, name)| at..at + name.len()).find(|span| {
        let before = text[..span.start].trim_end();
        let after = text[span.end..].trim_start();
        before.ends_with("fn") && after.starts_with('(') && before.len() < span.start
    })
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
