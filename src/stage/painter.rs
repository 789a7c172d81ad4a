//! The painter: turns what a phase presents into a picture on the GPU, the same for a window, an offscreen stage and a
//! replay.
//!
//! A study may have many conditions, and each picture is as large as the display, so little is kept: one reference
//! renderer, one renderer for each of the study's renderer names (set to the condition's parameters when it is its turn),
//! the scenes used last and the overlays used last. [`View`] says what a frame shows.

use super::recent::Recent;
use super::screens;
use crate::error::LabError;
use experiments::Display;
use experiments::catalogue::Parameters;
use experiments::marks::Mark;
use experiments::study::plan::{Condition, Level};
use experiments::trial::{Alternative, Presentation, Scale};
use image::RgbaImage;
use std::collections::BTreeMap;
use stimuli::contract::{FrameCost, FrameInput, Renderer, Scene, SceneLight};
use stimuli::display_pass::{Background, Disc, DisplayPass, linear_from_srgb8, overlay_texture};
use stimuli::gpu::Gpu;
use stimuli::registry;

/// The full-resolution renderer's name.
const REFERENCE: &str = "reference";
/// The grey of pages, gaps and fixation, as an 8-bit display value.
const GREY: u8 = 128;
/// Scenes that are kept: a scene may hold a picture larger than the display.
const SCENES: usize = 4;
/// Overlays that are kept: the fixation mark, two letters, a page and one more.
const OVERLAYS: usize = 5;

/// What one frame shows.
#[derive(Debug, Clone, PartialEq)]
pub struct View<'a> {
    /// What is presented.
    pub presentation: &'a Presentation,
    /// The trial's condition, for stimuli.
    pub condition: Option<&'a Condition>,
    /// The level that is shown, for stimuli.
    pub level: Option<&'a Level>,
    /// What is drawn over the picture.
    pub marks: Vec<Mark>,
    /// A line in small type at the bottom of a page.
    pub hint: Option<&'a str>,
    /// Where the renderer takes the gaze to be, degrees.
    pub gaze_deg: [f64; 2],
    /// How fast it moves, degrees per second.
    pub gaze_motion_deg_s: [f64; 2],
    /// How long the scene has been moving, seconds; 0 for what does not move.
    pub animation_s: f64,
    /// Number of the frame within the session.
    pub frame_index: u64,
}

impl View<'_> {
    /// A frame without anything to look at.
    #[must_use]
    pub fn blank(presentation: &Presentation) -> View<'_> {
        View {
            presentation,
            condition: None,
            level: None,
            marks: Vec::new(),
            hint: None,
            gaze_deg: [0.0; 2],
            gaze_motion_deg_s: [0.0; 2],
            animation_s: 0.0,
            frame_index: 0,
        }
    }
}

/// What an overlay shows.
#[derive(Debug, Clone, PartialEq)]
enum OverlayKey {
    Fixation([f64; 2]),
    Letter([f64; 2], char),
    Text(String, Option<String>),
    Scale(Scale, Option<String>),
}

impl OverlayKey {
    /// The overlay of a frame: a page, or the mark to look at. There is never more than one.
    fn of(view: &View<'_>) -> Option<Self> {
        let hint = view.hint.map(str::to_owned);
        match view.presentation {
            Presentation::Text(text) => Some(Self::Text(text.clone(), hint)),
            Presentation::Scale(scale) => Some(Self::Scale(scale.clone(), hint)),
            Presentation::Grey | Presentation::Black | Presentation::Fixation | Presentation::Stimulus(_) => {
                view.marks.iter().find_map(|mark| match *mark {
                    Mark::Fixation { at_deg } => Some(Self::Fixation(at_deg)),
                    Mark::Letter { at_deg, letter } => Some(Self::Letter(at_deg, letter)),
                    Mark::Sphere { .. } => None,
                })
            }
        }
    }

    fn draw(&self, display: &Display) -> RgbaImage {
        match self {
            Self::Fixation(at_deg) => screens::fixation(display, *at_deg),
            Self::Letter(at_deg, letter) => screens::letter(display, *at_deg, *letter),
            Self::Text(text, hint) => screens::text(display, text, hint.as_deref()),
            Self::Scale(scale, hint) => screens::scale(display, scale, hint.as_deref()),
        }
    }
}

/// A scene's name and parameters.
type SceneKey = (String, Parameters);

/// A renderer and what it is set to.
struct Tuned {
    renderer: Box<dyn Renderer>,
    parameters: Parameters,
}

impl Tuned {
    fn tune(&mut self, parameters: Parameters) -> Result<&mut Box<dyn Renderer>, LabError> {
        if self.parameters != parameters {
            self.renderer.set_parameters(&parameters).map_err(|errors| {
                let all: Vec<String> = errors.iter().map(ToString::to_string).collect();
                LabError::BadInput(all.join("; "))
            })?;
            self.parameters = parameters;
        }
        Ok(&mut self.renderer)
    }
}

/// Everything that is needed to draw.
pub struct Painter {
    /// The device.
    pub gpu: Gpu,
    display: Display,
    pass: DisplayPass,
    reference: Option<Box<dyn Renderer>>,
    tests: BTreeMap<String, Tuned>,
    scenes: Recent<SceneKey, Box<dyn Scene>>,
    overlays: Recent<OverlayKey, wgpu::Texture>,
}

impl Painter {
    /// A painter for one display; frames go into targets of `format`. The fixation mark is made at once.
    #[must_use]
    pub fn new(gpu: Gpu, display: &Display, fixation_deg: [f64; 2], format: wgpu::TextureFormat) -> Self {
        let mut painter = Self {
            display: display.clone(),
            pass: DisplayPass::for_display(&gpu, format, display),
            reference: None,
            tests: BTreeMap::new(),
            scenes: Recent::new(SCENES),
            overlays: Recent::new(OVERLAYS),
            gpu,
        };
        painter.lay_out(OverlayKey::Fixation(fixation_deg));
        painter
    }

    /// Makes what a condition needs and can be kept, so that its first frame is not late: the renderers, and the scene
    /// while there is room for one more.
    ///
    /// # Errors
    /// When the scene or the renderer cannot be made.
    pub fn prepare(&mut self, condition: &Condition) -> Result<(), LabError> {
        self.prepare_renderers(condition)?;
        if !self.scenes.is_full() {
            self.load_scene(condition)?;
        }
        Ok(())
    }

    fn prepare_renderers(&mut self, condition: &Condition) -> Result<(), LabError> {
        let (gpu, display) = (&self.gpu, &self.display);
        if self.reference.is_none() {
            self.reference = Some(registry::make_renderer(gpu, display, REFERENCE, &Parameters::new())?);
        }
        if !self.tests.contains_key(&condition.renderer) {
            let parameters = condition.renderer_parameters.clone();
            let renderer = registry::make_renderer(gpu, display, &condition.renderer, &parameters)?;
            self.tests.insert(condition.renderer.clone(), Tuned { renderer, parameters });
        }
        Ok(())
    }

    /// Makes a condition's scene the one used last.
    fn load_scene(&mut self, condition: &Condition) -> Result<(), LabError> {
        let is_its = |key: &SceneKey| key.0 == condition.scene && key.1 == condition.scene_parameters;
        if !self.scenes.touch(is_its) {
            let (id, parameters) = (condition.scene.clone(), condition.scene_parameters.clone());
            let scene = registry::make_scene(&self.gpu, &self.display, &id, &parameters)?;
            self.scenes.insert((id, parameters), scene);
        }
        Ok(())
    }

    /// Draws a frame into `target`, with the display in the middle of its `target_px` pixels. The work is submitted, not
    /// waited for. A frame without a stimulus costs nothing.
    ///
    /// # Errors
    /// When the device fails.
    pub fn paint(
        &mut self,
        view: &View<'_>,
        target: &wgpu::TextureView,
        target_px: [u32; 2],
    ) -> Result<Option<FrameCost>, LabError> {
        let cost = self.render_stimulus(view)?;
        if let Some(key) = OverlayKey::of(view) {
            self.lay_out(key);
        }
        self.compose(view, &self.pass, target, target_px);
        Ok(cost)
    }

    /// Makes an overlay the one used last.
    fn lay_out(&mut self, key: OverlayKey) {
        if !self.overlays.touch(|kept| *kept == key) {
            let overlay = overlay_texture(&self.gpu, &key.draw(&self.display));
            self.overlays.insert(key, overlay);
        }
    }

    /// Renders what a trial is about to show, at the view's level and without showing it, so that its first frame is not
    /// late: renderers keep what does not depend on the gaze. Pictures are the same with it and without.
    ///
    /// # Errors
    /// When the device fails.
    pub fn warm_up(&mut self, view: &View<'_>) -> Result<(), LabError> {
        for alternative in [Alternative::Reference, Alternative::Test] {
            let presentation = Presentation::stimulus(alternative);
            self.render_stimulus(&View { presentation: &presentation, ..view.clone() })?;
        }
        Ok(())
    }

    /// Draws a frame again into a target of another format, for example to bring it back from the GPU. Only the display
    /// pass runs; stimulus and overlay are the ones that [`Painter::paint`] drew last.
    pub fn compose(&self, view: &View<'_>, pass: &DisplayPass, target: &wgpu::TextureView, target_px: [u32; 2]) {
        let grey = if *view.presentation == Presentation::Black { 0 } else { GREY };
        let background = match self.rendered(view) {
            Some(renderer) => Background::Picture(renderer.output(), self.light(view)),
            None => Background::Uniform([f64::from(linear_from_srgb8(grey)); 3]),
        };
        let overlay = OverlayKey::of(view).and_then(|key| self.overlays.get(|kept| *kept == key));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let discs = self.discs(view, target_px);
        pass.draw(&self.gpu, &mut encoder, target, target_px, background, &discs, overlay);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// The spheres among a frame's marks, for a target of `target_px`, in the display's pixels; where there is no picture
    /// that says where the display stands in a larger target, in the target's own. Spheres are as large in degrees wherever
    /// they stand.
    #[must_use]
    pub fn discs(&self, view: &View<'_>, target_px: [u32; 2]) -> Vec<Disc> {
        let display_px = self.display.resolution_px();
        let margin_px: [f64; 2] = match self.rendered(view) {
            Some(_) => [0.0; 2],
            None => {
                std::array::from_fn(|axis| ((i64::from(target_px[axis]) - i64::from(display_px[axis])) >> 1) as f64)
            }
        };
        let spheres = view.marks.iter().filter_map(|mark| match *mark {
            Mark::Sphere { at_deg, diameter_deg, colour } => {
                let [x, y] = self.display.px_from_deg(at_deg);
                let radius_px = (0.5 * diameter_deg / self.display.pixel_deg(at_deg)).max(1.0);
                Some(Disc { centre_px: [x + margin_px[0], y + margin_px[1]], radius_px, colour })
            }
            Mark::Fixation { .. } | Mark::Letter { .. } => None,
        });
        spheres.collect()
    }

    /// Draws a frame as the display would show it and brings it back.
    ///
    /// # Errors
    /// When the device fails.
    pub fn picture(&mut self, view: &View<'_>) -> Result<(RgbaImage, Option<FrameCost>), LabError> {
        let target = self.target(self.pass.format());
        let target_view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let cost = self.paint(view, &target_view, self.display.resolution_px())?;
        let picture =
            stimuli::readback::rgba8(&self.gpu, &target).map_err(|error| LabError::Failed(error.to_string()))?;
        Ok((picture, cost))
    }

    /// What the reference would have looked like at the moment of a stimulus' frame, with the same marks over it; nothing
    /// where no stimulus is shown.
    ///
    /// # Errors
    /// When the device fails.
    pub fn reference_picture(&mut self, view: &View<'_>) -> Result<Option<RgbaImage>, LabError> {
        let Presentation::Stimulus(stimulus) = view.presentation else {
            return Ok(None);
        };
        let mut reference = stimulus.clone();
        reference.alternative = Alternative::Reference;
        let presentation = Presentation::Stimulus(reference);
        let (picture, _) = self.picture(&View { presentation: &presentation, ..view.clone() })?;
        Ok(Some(picture))
    }

    /// A target as large as the display that can be copied from.
    #[must_use]
    pub fn target(&self, format: wgpu::TextureFormat) -> wgpu::Texture {
        let [width, height] = self.display.resolution_px();
        self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("frame"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Whether a frame would show exactly the picture of another: then it need not be drawn again.
    #[must_use]
    pub fn same_picture(&self, a: &FrameKey, b: &FrameKey) -> bool {
        if a.marks != b.marks || a.hint != b.hint {
            return false;
        }
        match (&a.presentation, &b.presentation) {
            (Presentation::Stimulus(before), Presentation::Stimulus(now)) => {
                before.alternative == now.alternative
                    && a.condition == b.condition
                    && b.condition.as_ref().is_some_and(|condition| self.stands_still(condition, a, b))
                    && (now.alternative == Alternative::Reference || (a.level == b.level && a.gaze_deg == b.gaze_deg))
            }
            (before, now) => before == now,
        }
    }

    fn stands_still(&self, condition: &Condition, a: &FrameKey, b: &FrameKey) -> bool {
        let scene = self.scenes.get(|key| key.0 == condition.scene && key.1 == condition.scene_parameters);
        scene.is_some_and(|scene| !scene.picture_changes(a.animation_s, b.animation_s))
    }

    fn render_stimulus(&mut self, view: &View<'_>) -> Result<Option<FrameCost>, LabError> {
        let (Presentation::Stimulus(stimulus), Some(condition)) = (view.presentation, view.condition) else {
            return Ok(None);
        };
        self.prepare_renderers(condition)?;
        self.load_scene(condition)?;
        let frame = FrameInput {
            gaze_deg: view.gaze_deg,
            gaze_motion_deg_s: view.gaze_motion_deg_s,
            frame_index: view.frame_index,
            animation_s: view.animation_s,
        };
        let renderer = match stimulus.alternative {
            Alternative::Reference => self.reference.as_mut(),
            Alternative::Test => {
                let parameters = view
                    .level
                    .map_or_else(|| condition.renderer_parameters.clone(), |level| condition.parameters_at(level));
                match self.tests.get_mut(&condition.renderer) {
                    Some(tuned) => Some(tuned.tune(parameters)?),
                    None => None,
                }
            }
        };
        let (Some(renderer), Some(scene)) = (renderer, self.scenes.newest_mut()) else {
            return Ok(None);
        };
        Ok(Some(renderer.render(&self.gpu, scene.as_mut(), &frame)?))
    }

    /// How the light of a frame's scene is brought to the display.
    fn light(&self, view: &View<'_>) -> SceneLight {
        let condition = view.condition;
        let scene = condition.and_then(|of| self.scenes.get(|key| key.0 == of.scene && key.1 == of.scene_parameters));
        scene.map_or_else(SceneLight::default, |scene| scene.light())
    }

    fn rendered(&self, view: &View<'_>) -> Option<&dyn Renderer> {
        let (Presentation::Stimulus(stimulus), Some(condition)) = (view.presentation, view.condition) else {
            return None;
        };
        match stimulus.alternative {
            Alternative::Reference => self.reference.as_deref(),
            Alternative::Test => self.tests.get(&condition.renderer).map(|tuned| tuned.renderer.as_ref()),
        }
    }
}

/// What decides a frame's picture.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameKey {
    presentation: Presentation,
    condition: Option<Condition>,
    level: Level,
    marks: Vec<Mark>,
    hint: Option<String>,
    gaze_deg: [f64; 2],
    animation_s: f64,
}

impl From<&View<'_>> for FrameKey {
    fn from(view: &View<'_>) -> Self {
        Self {
            presentation: view.presentation.clone(),
            condition: view.condition.cloned(),
            level: view.level.cloned().unwrap_or_default(),
            marks: view.marks.clone(),
            hint: view.hint.map(str::to_owned),
            gaze_deg: view.gaze_deg,
            animation_s: view.animation_s,
        }
    }
}

impl std::fmt::Debug for Painter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Painter").field("display", &self.display).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
