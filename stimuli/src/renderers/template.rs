//! A renderer to start from: full resolution within a radius around the gaze, every second pixel beyond.
//!
//! To make one of your own, copy this file and its WGSL, give them a name, and add
//! `(renderers::yours::info, renderers::yours::make)` to `RENDERERS` in [`crate::registry`]. The tests in
//! `tests/pictures/contract.rs` then hold it to what every renderer owes. This one is compiled for tests alone, which add
//! it to a registry and hold it to the same.

use crate::contract::{
    DrawRequest, FrameCost, FrameInput, LINEAR_FORMAT, MakeError, RenderError, Renderer, Scene, View,
};
use crate::geometry::GeometryUniform;
use crate::gpu::Gpu;
use crate::parameters::number;
use crate::pass::{self, Extent};
use crate::timing::GpuTimer;
use experiments::catalogue::{
    DetailLaw, ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters,
};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("template.wgsl");

/// What studies see: the name, the parameters with their units and bounds, and what they do to detail.
pub(crate) fn info() -> RendererInfo {
    RendererInfo {
        id: "template".to_owned(),
        version: 1,
        about: "Full resolution around the gaze, every second pixel beyond.".to_owned(),
        source: String::new(),
        parameters: vec![ParameterSchema::number("radius_deg", "°", 0.0..=60.0, 5.0, "Radius of the full resolution.")],
        detail: DetailLaw::Unknown,
    }
}

/// What the shader is told: the same members, in the same order, at the same places.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    geometry: GeometryUniform,
    radius_rad: f32,
    reserved: [f32; 3],
}

struct Template {
    display: Display,
    radius_deg: f64,
    fine: wgpu::TextureView,
    coarse: wgpu::TextureView,
    output: wgpu::Texture,
    pipeline: wgpu::RenderPipeline,
    timer: GpuTimer,
}

/// Makes it from completed parameters. Pipelines are built here, never while frames are shown.
pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Renderer>, MakeError> {
    let picture = || pass::view(&pass::linear_texture(gpu, "template", display.resolution_px()));
    Ok(Box::new(Template {
        display: display.clone(),
        radius_deg: number(parameters, "radius_deg")?,
        fine: picture(),
        coarse: picture(),
        output: pass::linear_texture(gpu, "template output", display.resolution_px()),
        pipeline: pass::pipeline(gpu, "template", WGSL, "fine_or_coarse", LINEAR_FORMAT),
        timer: GpuTimer::new(gpu),
    }))
}

impl Renderer for Template {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);

        // Have the scene drawn, as often and as finely as you like.
        let full = View::full(self.display.resolution_px());
        let half = View { target_px: full.target_px.map(|x| x.div_ceil(2)), ..full };
        let mut drawn = scene.draw(gpu, &mut encoder, &DrawRequest::of(full, frame.animation_s), &self.fine)?;
        drawn += scene.draw(gpu, &mut encoder, &DrawRequest::of(half, frame.animation_s), &self.coarse)?;

        // Put it together.
        let uniform = Uniform {
            geometry: GeometryUniform::new(&self.display, frame.gaze_deg),
            radius_rad: self.radius_deg.to_radians() as f32,
            reserved: [0.0; 3],
        };
        let views = [&self.fine, &self.coarse];
        let bind_group = pass::bind(gpu, &self.pipeline, &pass::uniform(gpu, &uniform), &views);
        pass::draw(&mut encoder, &self.pipeline, &bind_group, &pass::view(&self.output), Extent::All);

        // Submit without waiting, and say what it cost: what the scene drew, and what was filtered, which is nothing here.
        let gpu_time_s = self.timer.submit(gpu, encoder);
        gpu.check()?;
        Ok(drawn.in_frame(gpu_time_s))
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        self.radius_deg = number(&complete_parameters(&info().parameters, parameters)?, "radius_deg")?;
        Ok(())
    }
}

/// The same promises that `tests/pictures/contract.rs` asks of what is in the registry.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::Registry;
    use experiments::catalogue::ParameterValue;
    use std::sync::Arc;

    #[test]
    fn the_template_is_a_renderer() {
        let gpu = Gpu::headless().expect("a device");
        let mut registry = Registry::built_in();
        registry.add_renderer(info(), Arc::new(make)).expect("a name of its own");
        let display = Display::new("odd", [161, 91], [500.0, 281.0], 600.0).expect("in range");
        let number = |name: &str, value| Parameters::from([(name.to_owned(), ParameterValue::Number(value))]);
        let mut renderer = registry.make_renderer(&gpu, &display, "template", &Parameters::new()).expect("made");
        let mut flat = registry.make_scene(&gpu, &display, "noise", &number("contrast", 0.0)).expect("made");
        let mut noise = registry.make_scene(&gpu, &display, "noise", &Parameters::new()).expect("made");
        let mut reference = registry.make_renderer(&gpu, &display, "reference", &Parameters::new()).expect("made");
        let frame = FrameInput { gaze_deg: [3.0, 2.0], ..FrameInput::default() };
        let pixels = |renderer: &mut dyn Renderer, scene: &mut dyn Scene| {
            let cost = renderer.render(&gpu, scene, &frame).expect("rendered");
            (crate::readback::linear_rgba(&gpu, renderer.output()).expect("read"), cost)
        };

        let (uniform, cost) = pixels(renderer.as_mut(), flat.as_mut());
        assert!(uniform.chunks_exact(4).all(|p| p[..3].iter().all(|x| (x - 0.5).abs() <= 2.5e-4)));
        assert_eq!(cost.pixels_shaded, 161 * 91 + 81 * 46);
        let (shown, _) = pixels(renderer.as_mut(), noise.as_mut());
        let (sharp, _) = pixels(reference.as_mut(), noise.as_mut());
        let mut differing = 0;
        for (index, (a, b)) in shown.chunks_exact(4).zip(sharp.chunks_exact(4)).enumerate() {
            let px = [(index % 161) as f64 + 0.5, (index / 161) as f64 + 0.5];
            let e = display.eccentricity_deg(frame.gaze_deg, display.deg_from_px(px));
            assert!(a == b || e > 4.99, "{e}");
            differing += usize::from(a != b);
        }
        assert!(differing > 1000, "{differing}");
        assert_eq!(pixels(renderer.as_mut(), noise.as_mut()).0, shown, "the same again");
    }
}
