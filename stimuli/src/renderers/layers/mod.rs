//! Guenter's system (Guenter et al. 2012): two to four nested targets around the gaze, each sampled as coarsely as the
//! acuity line allows ([`crate::foveation::plan`], §4.3), the outer ones drawn in turn at half rate (§4), smoothed by
//! multisampling, jitter and temporal reprojection (§4.2), magnified and blended into the display's picture. Every part
//! can be switched off.
//!
//! Within 0.6 of the innermost radius the picture equals the reference exactly, because the inner layer is by default
//! neither jittered nor reprojected; the paper jitters every layer, as `jitter: all` does.

mod composite;
mod history;
mod jitter;
mod settings;
mod views;

use crate::contract::{
    DrawCost, DrawRequest, FrameCost, FrameInput, LINEAR_FORMAT, LayerCost, MakeError, MotionRequest, RenderError,
    Renderer, Scene, SceneIdentity, View,
};
use crate::gpu::Gpu;
use crate::pass;
use crate::timing::GpuTimer;
use composite::Composite;
use experiments::catalogue::{ParameterError, Parameters, complete_parameters};
use experiments::display::Display;
use history::History;
use settings::Settings;

pub(crate) use settings::info;

/// The shaders, for the test of all shaders.
#[cfg(test)]
pub(crate) const SHADERS: [(&str, &str); 2] =
    [("layers/accumulate", history::WGSL), ("layers/composite", composite::WGSL)];

/// Seconds on the scene's clock between two frames after which the earlier one is too old to be used again.
const LONGEST_GAP_S: f64 = 0.5;

/// One layer, from frame to frame.
#[derive(Debug, Default)]
struct LayerState {
    /// Its last drawing, in the corner.
    drawn: Option<wgpu::Texture>,
    history: History,
    /// What its picture shows, without the jitter; `None` where that is not to be used.
    shown: Option<View>,
    /// How often it was drawn since the beginning.
    updates: u64,
}

impl LayerState {
    fn forget(&mut self) {
        self.history.forget();
        self.shown = None;
        self.updates = 0;
    }

    /// Its view, and the picture to be shown: the accumulated one where `reprojected`.
    fn picture(&self, reprojected: bool) -> Option<(View, &wgpu::Texture)> {
        let texture = if reprojected { self.history.picture() } else { self.drawn.as_ref() };
        Some((self.shown?, texture?))
    }
}

/// What is known of the frame before.
#[derive(Debug, Clone, Copy)]
struct Before {
    scene: SceneIdentity,
    animation_s: f64,
    gaze_deg: [f64; 2],
    /// Frames since the beginning, this one included.
    frames: u64,
}

struct Layers {
    display: Display,
    settings: Settings,
    layers: Vec<LayerState>,
    /// Where scenes write motion; one for all layers, which are drawn one after the other.
    motion: Option<wgpu::Texture>,
    output: wgpu::Texture,
    output_view: wgpu::TextureView,
    composite: Composite,
    accumulate: wgpu::RenderPipeline,
    /// `None` at the beginning, after parameters have changed, and where a frame has failed.
    before: Option<Before>,
    costs: Vec<LayerCost>,
    timer: GpuTimer,
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Renderer>, MakeError> {
    let output = pass::linear_texture(gpu, "layers output", display.resolution_px());
    Ok(Box::new(Layers {
        display: display.clone(),
        settings: Settings::read(display, parameters)?,
        layers: std::iter::repeat_with(LayerState::default).take(composite::MOST_LAYERS).collect(),
        motion: None,
        output_view: pass::view(&output),
        output,
        composite: Composite::new(gpu),
        accumulate: history::pipeline(gpu),
        before: None,
        costs: Vec::new(),
        timer: GpuTimer::new(gpu),
    }))
}

/// The size to make a texture that must hold `size_px`, so that a moving gaze seldom needs a larger one.
fn roomy(gpu: &Gpu, size_px: [u32; 2]) -> [u32; 2] {
    let most = gpu.device.limits().max_texture_dimension_2d;
    size_px.map(|x| x.next_multiple_of(64).min(most).max(x))
}

impl Layers {
    /// Draws layer `index` where it is its turn, or where what it shows is not enough, and says what that cost.
    fn update_layer(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        scene: &mut dyn Scene,
        frame: &FrameInput,
        (index, turn): (usize, bool),
    ) -> Result<LayerCost, RenderError> {
        let settings = &self.settings;
        let name = views::names(settings.layers()).get(index).copied().unwrap_or_default();
        let layer = &mut self.layers[index];
        let gpu_time_s = self.timer.section_s(name);
        let resting = |view| LayerCost { name, view, drawn: false, cost: DrawCost::default(), gpu_time_s };

        // Nothing of it is on the display.
        let Some(needed) = views::needed(&self.display, settings, index, frame.gaze_deg) else {
            layer.forget();
            return Ok(resting(None));
        };
        // A saccade has left what a resting layer shows: then it is drawn all the same.
        let enough = layer.shown.is_some_and(|shown| views::covers(&shown, needed));
        if enough && !turn {
            return Ok(resting(layer.shown));
        }

        // Draw it, shifted by its jitter.
        let view = views::view(&self.display, settings, index, needed);
        let shift = if settings.jitters(index) { jitter::offset(layer.updates) } else { [0.0; 2] };
        let step = view.step_px();
        let shifted =
            View { origin_px: std::array::from_fn(|axis| view.origin_px[axis] + shift[axis] * step[axis]), ..view };
        let size = roomy(gpu, view.target_px);
        let target = pass::view(pass::at_least(gpu, &mut layer.drawn, "layer", size, LINEAR_FORMAT));
        let motion = settings
            .reprojects(index)
            .then(|| pass::view(pass::at_least(gpu, &mut self.motion, "motion", size, LINEAR_FORMAT)));
        let since_s = layer.history.since_s(frame.animation_s);
        let request = DrawRequest {
            multisampled: settings.msaa,
            detail: settings.detail(index),
            motion: motion.as_ref().map(|target| MotionRequest { since_s, target }),
            ..DrawRequest::of(shifted, frame.animation_s)
        };
        let cost = scene.draw(gpu, encoder, &request, &target)?;

        // Average it with what it was.
        if let Some(motion) = &motion {
            let pictures = (&target, motion);
            layer.history.accumulate(gpu, encoder, &self.accumulate, settings, pictures, &view, frame.animation_s);
        }
        layer.shown = Some(view);
        layer.updates += 1;
        self.timer.end_section(encoder, name);
        Ok(LayerCost { name, view: Some(view), drawn: true, cost, gpu_time_s })
    }

    /// Nothing was drawn: the frame before is the frame.
    fn shown_again(&mut self) -> FrameCost {
        for cost in &mut self.costs {
            (cost.drawn, cost.cost) = (false, DrawCost::default());
            cost.gpu_time_s = self.timer.section_s(cost.name).or(cost.gpu_time_s);
        }
        FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() }
    }
}

impl Renderer for Layers {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        // What comes from another scene, from later on or from long ago is of no use.
        let before = self.before.take().filter(|before| {
            let passed_s = frame.animation_s - before.animation_s;
            before.scene == scene.identity()
                && (!self.settings.remembers() || (0.0..=LONGEST_GAP_S).contains(&passed_s))
        });
        if let Some(before) = before
            && !self.settings.remembers()
            && before.gaze_deg == frame.gaze_deg
            && !scene.picture_changes(before.animation_s, frame.animation_s)
        {
            self.before = Some(before);
            return Ok(self.shown_again());
        }
        if before.is_none() {
            self.layers.iter_mut().for_each(LayerState::forget);
        }
        let frames = before.map_or(0, |before| before.frames);
        let layers = self.settings.layers();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);

        // Draw the layers whose turn it is; in the first frame, and at full rate, that is all of them.
        let mut drawn = DrawCost::default();
        self.costs.clear();
        for index in 0..layers {
            let turn = frames == 0 || !self.settings.rests(index) || views::due(layers, index, frames);
            let cost = self.update_layer(gpu, &mut encoder, scene, frame, (index, turn))?;
            drawn += cost.cost;
            self.costs.push(cost);
        }

        // Put them together.
        let pictures: Vec<_> = self.layers[..layers]
            .iter()
            .enumerate()
            .map(|(index, layer)| layer.picture(self.settings.reprojects(index)))
            .collect();
        let (display, settings) = (&self.display, &self.settings);
        self.composite.draw(gpu, &mut encoder, display, settings, frame.gaze_deg, &pictures, &self.output_view);
        self.timer.end_section(&mut encoder, "blend");

        let gpu_time_s = self.timer.submit(gpu, encoder);
        for cost in &mut self.costs {
            cost.gpu_time_s = self.timer.section_s(cost.name);
        }
        gpu.check()?;
        self.before = Some(Before {
            scene: scene.identity(),
            animation_s: frame.animation_s,
            gaze_deg: frame.gaze_deg,
            frames: frames + 1,
        });
        Ok(drawn.in_frame(gpu_time_s))
    }

    fn begin(&mut self) {
        // A picture that does not depend on the frames before is still the right one.
        if self.settings.remembers() {
            self.before = None;
        }
    }

    fn remembers(&self) -> bool {
        self.settings.remembers()
    }

    fn layer_costs(&self) -> &[LayerCost] {
        &self.costs
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        let settings = Settings::read(&self.display, &complete_parameters(&info().parameters, parameters)?)?;
        if settings != self.settings {
            self.settings = settings;
            self.before = None;
        }
        Ok(())
    }
}
