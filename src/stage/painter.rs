//! The painter: turns what a phase presents into a picture on the GPU, the same for a window, an offscreen stage and a
//! replay.
//!
//! It keeps one scene and two renderers (the reference and the test) for each condition, and one overlay for each text,
//! so that a frame only costs its drawing.

use super::screens;
use crate::error::LabError;
use experiments::Display;
use experiments::catalogue::Parameters;
use experiments::study::plan::{Condition, Level};
use experiments::trial::{Alternative, Presentation};
use image::RgbaImage;
use std::collections::HashMap;
use stimuli::contract::{FrameCost, FrameInput, Renderer, Scene};
use stimuli::display_pass::{Background, DisplayPass, linear_from_srgb8, overlay_texture};
use stimuli::gpu::Gpu;
use stimuli::registry;

/// The full-resolution renderer's name.
const REFERENCE: &str = "reference";
/// The grey of pages, gaps and fixation, as an 8-bit display value.
const GREY: u8 = 128;

/// What one frame shows.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// What is presented.
    pub presentation: &'a Presentation,
    /// The block's condition, for stimuli.
    pub condition: Option<&'a Condition>,
    /// The trial's level, for stimuli.
    pub level: Option<&'a Level>,
    /// Where the eye looks, degrees.
    pub gaze_deg: [f64; 2],
    /// How fast it moves, degrees per second.
    pub gaze_motion_deg_s: [f64; 2],
    /// Time since the phase began, seconds; 0 for what does not move.
    pub animation_s: f64,
    /// Number of the frame within the session.
    pub frame_index: u64,
}

/// Everything that is needed to draw.
pub struct Painter {
    /// The device.
    pub gpu: Gpu,
    display: Display,
    fixation: wgpu::Texture,
    page: Option<(String, wgpu::Texture)>,
    sets: HashMap<String, Set>,
    pass: DisplayPass,
}

/// A condition's scene with its two renderers.
struct Set {
    scene: Box<dyn Scene>,
    reference: Box<dyn Renderer>,
    test: Box<dyn Renderer>,
    test_parameters: Option<Parameters>,
}

impl Painter {
    /// A painter for one display; frames go into targets of `format`.
    #[must_use]
    pub fn new(gpu: Gpu, display: &Display, fixation_deg: [f64; 2], format: wgpu::TextureFormat) -> Self {
        let fixation = overlay_texture(&gpu, &screens::fixation(display, fixation_deg));
        let pass = DisplayPass::new(&gpu, format);
        Self { display: display.clone(), fixation, page: None, sets: HashMap::new(), pass, gpu }
    }

    /// Loads what a condition needs, so that its first frame is not late.
    ///
    /// # Errors
    /// When the scene or the renderer cannot be made.
    pub fn prepare(&mut self, condition: &Condition) -> Result<(), LabError> {
        if !self.sets.contains_key(&condition.name) {
            let (gpu, display) = (&self.gpu, &self.display);
            let set = Set {
                scene: registry::make_scene(gpu, display, &condition.scene, &condition.scene_parameters)?,
                reference: registry::make_renderer(gpu, display, REFERENCE, &Parameters::new())?,
                test: registry::make_renderer(gpu, display, &condition.renderer, &condition.renderer_parameters)?,
                test_parameters: None,
            };
            self.sets.insert(condition.name.clone(), set);
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
        self.compose(view, &self.pass, target, target_px);
        Ok(cost)
    }

    /// Renders what a trial is about to show, without showing it, so that its first frame is not late: renderers keep what
    /// does not depend on the gaze. Pictures are the same with it and without.
    ///
    /// # Errors
    /// When the device fails.
    pub fn warm_up(&mut self, view: &View<'_>) -> Result<(), LabError> {
        for alternative in [Alternative::Reference, Alternative::Test] {
            let presentation = Presentation::stimulus(alternative);
            self.render_stimulus(&View { presentation: &presentation, ..*view })?;
        }
        Ok(())
    }

    /// Draws the stimulus of a frame again into a target of another format, for example to bring it back from the GPU.
    /// Only the display pass runs; the stimulus is the one that [`Painter::paint`] rendered last.
    pub fn compose(&self, view: &View<'_>, pass: &DisplayPass, target: &wgpu::TextureView, target_px: [u32; 2]) {
        let grey = f64::from(linear_from_srgb8(GREY));
        let background = match self.rendered(view) {
            Some(renderer) => Background::Picture(renderer.output()),
            None => Background::Uniform([grey; 3]),
        };
        let overlay = match view.presentation {
            Presentation::Grey | Presentation::Black | Presentation::Scale(_) => None,
            Presentation::Fixation | Presentation::Stimulus(_) => Some(&self.fixation),
            Presentation::Text(_) => self.page.as_ref().map(|(_, texture)| texture),
        };
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        pass.draw(&self.gpu, &mut encoder, target, target_px, background, &[], overlay);
        self.gpu.queue.submit([encoder.finish()]);
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
        let still = |condition: &str| {
            self.sets.get(condition).is_some_and(|set| !set.scene.picture_changes(a.animation_s, b.animation_s))
        };
        match (&a.presentation, &b.presentation) {
            (Presentation::Stimulus(before), Presentation::Stimulus(now)) => {
                before == now
                    && a.condition == b.condition
                    && still(&a.condition)
                    && (now.alternative == Alternative::Reference || (a.level == b.level && a.gaze_deg == b.gaze_deg))
            }
            (before, now) => before == now,
        }
    }

    fn render_stimulus(&mut self, view: &View<'_>) -> Result<Option<FrameCost>, LabError> {
        match (view.presentation, view.condition) {
            (Presentation::Text(text), _) => {
                if self.page.as_ref().is_none_or(|(shown, _)| shown != text) {
                    let overlay = overlay_texture(&self.gpu, &screens::text(&self.display, text));
                    self.page = Some((text.clone(), overlay));
                }
                Ok(None)
            }
            (Presentation::Stimulus(alternative), Some(condition)) => {
                self.prepare(condition)?;
                let Some(set) = self.sets.get_mut(&condition.name) else {
                    return Ok(None);
                };
                let frame = FrameInput {
                    gaze_deg: view.gaze_deg,
                    gaze_motion_deg_s: view.gaze_motion_deg_s,
                    frame_index: view.frame_index,
                    animation_s: view.animation_s,
                };
                let renderer = match alternative.alternative {
                    Alternative::Reference => &mut set.reference,
                    Alternative::Test => {
                        let parameters = view.level.map_or_else(
                            || condition.renderer_parameters.clone(),
                            |level| condition.parameters_at(level),
                        );
                        if set.test_parameters.as_ref() != Some(&parameters) {
                            set.test.set_parameters(&parameters).map_err(|errors| {
                                let all: Vec<String> = errors.iter().map(ToString::to_string).collect();
                                LabError::BadInput(all.join("; "))
                            })?;
                            set.test_parameters = Some(parameters);
                        }
                        &mut set.test
                    }
                };
                Ok(Some(renderer.render(&self.gpu, set.scene.as_mut(), &frame)?))
            }
            _ => Ok(None),
        }
    }

    fn rendered(&self, view: &View<'_>) -> Option<&dyn Renderer> {
        let (Presentation::Stimulus(alternative), Some(condition)) = (view.presentation, view.condition) else {
            return None;
        };
        let set = self.sets.get(&condition.name)?;
        Some(match alternative.alternative {
            Alternative::Reference => set.reference.as_ref(),
            Alternative::Test => set.test.as_ref(),
        })
    }
}

/// What decides a frame's picture.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameKey {
    presentation: Presentation,
    condition: String,
    level: Level,
    gaze_deg: [f64; 2],
    animation_s: f64,
}

impl From<&View<'_>> for FrameKey {
    fn from(view: &View<'_>) -> Self {
        Self {
            presentation: view.presentation.clone(),
            condition: view.condition.map_or_else(String::new, |condition| condition.name.clone()),
            level: view.level.cloned().unwrap_or_default(),
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
