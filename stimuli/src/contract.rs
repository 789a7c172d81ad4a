//! The two contracts of this crate: a [`Scene`] draws any part of its picture at any sampling, a [`Renderer`] decides
//! which parts are drawn how finely and puts them together. Neither knows the other's kind, so every scene works under
//! every renderer.

use crate::gpu::{Gpu, GpuError};
use experiments::catalogue::{ParameterError, Parameters};
use std::sync::atomic::{AtomicU64, Ordering};

/// The format of every linear-light picture.
///
/// Half floats round values in 0.5–1 by at most 2⁻¹² = 2.44e-4, a quarter of the 1e-3 to which pictures are compared and
/// less than a tenth of the step of an 8-bit display there. Shaders round to the nearest half themselves, because some
/// drivers cut the digits off; passes that add up many values keep full floats in between.
pub const LINEAR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// What a renderer needs to know about one frame. The camera comes from the scene's own path at `animation_s`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameInput {
    /// Where the eye looks: degrees from the display's centre, x right, y up. May lie off the display.
    pub gaze_deg: [f64; 2],
    /// How fast the gaze moves, degrees per second on the same axes.
    pub gaze_motion_deg_s: [f64; 2],
    /// Frames since the presentation began.
    pub frame_index: u64,
    /// Time on the scene's own clock, in seconds.
    pub animation_s: f64,
}

/// What a frame cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameCost {
    /// Pixels whose colour was computed in this frame: every pixel of every target that the scene drew, plus every
    /// display pixel that the renderer filtered. Copies, and the blending of layers into the display, are not counted.
    /// A picture that had not changed was not drawn, and counts nothing.
    pub pixels_shaded: u64,
    /// Camera rays of ray-casting scenes; the reflections and shadows that follow from them are not counted.
    pub rays_traced: u64,
    /// GPU time in seconds of the last frame of this renderer whose measurement has arrived, usually the previous one
    /// (with [`Gpu::set_blocking_timing`], this one). `None` where it is not measurable or not known yet.
    pub gpu_time_s: Option<f64>,
}

/// A rectangle of the display, drawn into a target of `target_px` pixels.
///
/// Pixel `(i, j)` of the target shows the place `origin_px + (i + ½, j + ½) · step_px` of the display. The rectangle may be
/// fractional and may reach past the display's edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Top left corner, display pixels from the display's top left corner.
    pub origin_px: [f64; 2],
    /// Width and height of the rectangle, display pixels.
    pub size_px: [f64; 2],
    /// Width and height of the target, in its own pixels.
    pub target_px: [u32; 2],
}

impl View {
    /// The whole display at its own resolution.
    #[must_use]
    pub fn full(resolution_px: [u32; 2]) -> Self {
        Self { origin_px: [0.0; 2], size_px: resolution_px.map(f64::from), target_px: resolution_px }
    }

    /// Display pixels per target pixel, on each axis: Guenter's sampling factor.
    #[must_use]
    pub fn step_px(&self) -> [f64; 2] {
        std::array::from_fn(|axis| self.size_px[axis] / f64::from(self.target_px[axis]))
    }

    /// The number of pixels in the target.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        u64::from(self.target_px[0]) * u64::from(self.target_px[1])
    }
}

/// What drawing one view of a scene cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DrawCost {
    /// Pixels shaded.
    pub pixels_shaded: u64,
    /// Camera rays traced.
    pub rays_traced: u64,
}

impl std::ops::AddAssign for DrawCost {
    fn add_assign(&mut self, other: Self) {
        self.pixels_shaded += other.pixels_shaded;
        self.rays_traced += other.rays_traced;
    }
}

/// A picture of something, at any sampling.
///
/// A scene is made for one display, so that a degree in the scene is a degree on the display. Its light is linear and
/// relative to the display's peak: 0 is black, 1 is what the display can show at most. A scene with brighter things
/// brings them into that range itself, because only then does a filter act on what the observer would have seen.
pub trait Scene: Send {
    /// Records the drawing of `view` at `animation_s` into `target`.
    ///
    /// `target` has [`LINEAR_FORMAT`] and at least `view.target_px` pixels; the top left `view.target_px` of them are
    /// overwritten, alpha with 1. At a step of one display pixel every pixel is sampled at its centre; at larger steps
    /// the scene filters what it can (a photograph is averaged over the footprint).
    ///
    /// # Errors
    /// When the scene cannot be drawn.
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        animation_s: f64,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError>;

    /// Whether the picture at `to_s` may differ from the one at `from_s`. A static picture is drawn once.
    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool;

    /// Which scene this is: two scenes of one process never share it, so that a renderer knows when its cache is stale.
    fn identity(&self) -> SceneIdentity;
}

/// Tells scenes of one process apart. See [`Scene::identity`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SceneIdentity(u64);

impl SceneIdentity {
    /// An identity that no other scene has.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "a default that differs each time would surprise")]
    pub fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// A way to turn a scene into a frame.
///
/// To write one: one Rust file and one WGSL file in `renderers/`, and one line in [`crate::registry`].
pub trait Renderer: Send {
    /// Renders one frame into [`Renderer::output`]. The work is submitted, not waited for.
    ///
    /// The same scene, parameters and input give the same picture, whatever was rendered before.
    ///
    /// # Errors
    /// When the scene cannot be drawn or the device has failed.
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError>;

    /// The last frame: linear light, [`LINEAR_FORMAT`], as many pixels as the display. Black before the first frame.
    fn output(&self) -> &wgpu::Texture;

    /// Sets the parameters, without building pipelines anew; what is not given goes back to its default.
    ///
    /// # Errors
    /// Every parameter that is unknown or out of its bounds; then nothing was changed.
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>>;
}

/// Why a scene or renderer could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MakeError {
    /// Nothing of this name exists.
    #[error("there is no {kind} \"{id}\"; there are {known}")]
    Unknown {
        /// `scene` or `renderer`.
        kind: &'static str,
        /// What was asked for.
        id: String,
        /// What there is.
        known: String,
    },
    /// Parameters were refused.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Parameters(Vec<ParameterError>),
    /// The display has more pixels on an axis than the device can draw.
    #[error("the display has {found} pixels on one axis, the graphics device \"{adapter}\" draws at most {most}")]
    TooLarge {
        /// Pixels on the display's longer axis.
        found: u32,
        /// What the device allows.
        most: u32,
        /// The device.
        adapter: String,
    },
    /// A picture that ships with this crate does not decode.
    #[error("the shipped picture {name} cannot be read: {reason}")]
    Asset {
        /// Its name.
        name: &'static str,
        /// What the decoder said.
        reason: String,
    },
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl From<Vec<ParameterError>> for MakeError {
    fn from(errors: Vec<ParameterError>) -> Self {
        Self::Parameters(errors)
    }
}

/// Why a frame could not be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The input of a frame is not finite.
    #[error("{what} of frame {frame_index} is not a finite number")]
    NotFinite {
        /// What was not finite.
        what: &'static str,
        /// Which frame.
        frame_index: u64,
    },
}

impl FrameInput {
    /// Refuses input that is not finite.
    ///
    /// # Errors
    /// [`RenderError::NotFinite`].
    pub fn check(&self) -> Result<(), RenderError> {
        let fault = |what| Err(RenderError::NotFinite { what, frame_index: self.frame_index });
        if !self.gaze_deg.iter().all(|x| x.is_finite()) {
            return fault("the gaze");
        }
        if !self.animation_s.is_finite() {
            return fault("the animation time");
        }
        Ok(())
    }
}
