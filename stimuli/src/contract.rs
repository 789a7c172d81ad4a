//! The two contracts of this crate: a [`Scene`] draws any part of its picture at any sampling, a [`Renderer`] decides
//! which parts are drawn how finely and puts them together. Neither knows the other's kind, so every scene works under
//! every renderer.

use crate::gpu::{Gpu, GpuError};
use crate::surfaces::Surfaces;
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
    /// Triangles that were handed to the rasteriser, those outside the view among them; 0 for scenes without any.
    pub triangles: u64,
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
    /// Triangles handed to the rasteriser.
    pub triangles: u64,
}

impl DrawCost {
    /// What it costs to shade every pixel of `view` once.
    #[must_use]
    pub fn of_pixels(view: &View) -> Self {
        Self { pixels_shaded: view.pixels(), ..Self::default() }
    }

    /// The same as a frame's cost.
    #[must_use]
    pub fn in_frame(self, gpu_time_s: Option<f64>) -> FrameCost {
        let Self { pixels_shaded, rays_traced, triangles } = self;
        FrameCost { pixels_shaded, rays_traced, triangles, gpu_time_s }
    }
}

impl std::ops::AddAssign for DrawCost {
    fn add_assign(&mut self, other: Self) {
        self.pixels_shaded += other.pixels_shaded;
        self.rays_traced += other.rays_traced;
        self.triangles += other.triangles;
    }
}

/// What is to be drawn, and how finely.
#[derive(Debug, Clone, Copy)]
pub struct DrawRequest<'a> {
    /// The part of the display, and the target's pixels.
    pub view: View,
    /// Time on the scene's clock, seconds.
    pub animation_s: f64,
    /// Whether the edges of geometry are sampled four times a pixel (hardware multisampling). Scenes without geometry
    /// have no such edges and leave it out.
    pub multisampled: bool,
    /// Share of the full number of triangles that curved surfaces are divided into, 0–1.
    pub detail: f64,
    /// Where to write how everything has moved, for renderers that use older pictures again.
    pub motion: Option<MotionRequest<'a>>,
    /// Where to count what is shaded; see [`crate::tally`].
    pub tally: Option<&'a crate::tally::Tally>,
}

/// Asks for the motion of everything in view since an earlier picture.
///
/// A texel of the target holds, for the surface in its pixel's middle: how many display pixels further right and further
/// down it stood at `since_s`; one over its distance along the viewing axis then, and one over that distance now (0 for
/// what is infinitely far). A flat picture that is fixed to the display has (0, 0, 1, 1).
#[derive(Debug, Clone, Copy)]
pub struct MotionRequest<'a> {
    /// Time on the scene's clock of the earlier picture, seconds.
    pub since_s: f64,
    /// Has [`LINEAR_FORMAT`] and at least as many pixels as the view's target.
    pub target: &'a wgpu::TextureView,
}

impl DrawRequest<'_> {
    /// `view` at `animation_s` as the reference shows it: smooth edges, every triangle.
    #[must_use]
    pub fn of(view: View, animation_s: f64) -> Self {
        Self { view, animation_s, multisampled: true, detail: 1.0, motion: None, tally: None }
    }
}

/// A picture of something, at any sampling.
///
/// A scene is made for one display, so that a degree in the scene is a degree on the display. Its light is linear: 0 is
/// black, and what [`Scene::light`] makes of it is shown. Flat pictures are relative to the display's peak, so that 1 is
/// the most it can show; scenes of light and surfaces may be brighter, up to what is shown as white.
pub trait Scene: Send {
    /// Records the drawing of `request` into `target`.
    ///
    /// `target` has [`LINEAR_FORMAT`] and at least `request.view.target_px` pixels; the top left `target_px` of them are
    /// overwritten, alpha with 1. At a step of one display pixel every pixel is sampled at its centre; at larger steps
    /// the scene filters what it can (a photograph is averaged over the footprint).
    ///
    /// # Errors
    /// When the scene cannot be drawn.
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError>;

    /// The scene's surfaces, for renderers that shade or trace by themselves; `None` for flat pictures and for scenes that
    /// are more than surfaces.
    fn surfaces(&mut self) -> Option<&mut dyn Surfaces> {
        None
    }

    /// How the scene's light is brought to a display.
    fn light(&self) -> SceneLight {
        SceneLight::default()
    }

    /// Whether the picture at `to_s` may differ from the one at `from_s`. A static picture is drawn once.
    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool;

    /// Which scene this is: two scenes of one process never share it, so that a renderer knows when its cache is stale.
    fn identity(&self) -> SceneIdentity;
}

/// How a scene's light is brought into the range of a display: the first two steps of the display transform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneLight {
    /// What every value is multiplied with, at least 0.
    pub exposure: f64,
    /// How what is too bright is compressed.
    pub tone_map: ToneMap,
}

impl Default for SceneLight {
    /// For pictures that are relative to the display's peak already.
    fn default() -> Self {
        Self { exposure: 1.0, tone_map: ToneMap::Clamp }
    }
}

/// How light is compressed into 0–1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ToneMap {
    /// What is brighter than 1 is shown as 1; the rest is unchanged.
    #[default]
    Clamp,
    /// A filmic curve: linear in the shadows, with a shoulder that ends at 1.
    Filmic,
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

/// What one layer of a frame cost, for renderers that draw in layers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerCost {
    /// The layer's name: `inner`, `middle`, `outer`; of four layers the third is the `far middle`.
    pub name: &'static str,
    /// What it shows of the display, and at how many pixels; `None` where it does not touch the display.
    pub view: Option<View>,
    /// Whether it was drawn in this frame, or shown once more.
    pub drawn: bool,
    /// What its drawing cost; nothing where it was not drawn.
    pub cost: DrawCost,
    /// GPU time of its last drawing that was measured, seconds.
    pub gpu_time_s: Option<f64>,
}

/// A way to turn a scene into a frame.
///
/// To write one: one Rust file and one WGSL file in `renderers/`, and one line in [`crate::registry`].
pub trait Renderer: Send {
    /// Renders one frame into [`Renderer::output`]. The work is submitted, not waited for.
    ///
    /// The same scene, parameters and input give the same picture, whatever was rendered before; for a renderer that
    /// [remembers](Renderer::remembers), the same frames since [`Renderer::begin`] do.
    ///
    /// # Errors
    /// When the scene cannot be drawn or the device has failed.
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError>;

    /// Begins a presentation: nothing of the frames before is used again.
    fn begin(&mut self) {}

    /// Whether a picture may depend on the frames since [`Renderer::begin`], so that even a still scene under a still
    /// gaze must be drawn at every frame.
    fn remembers(&self) -> bool {
        false
    }

    /// What the layers of the last frame cost, innermost first; empty for renderers without layers.
    fn layer_costs(&self) -> &[LayerCost] {
        &[]
    }

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
    /// A file of the user's cannot be used.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What was expected and found.
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
    /// A picture that the frame needs can no longer be read.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What was expected and found.
        reason: String,
    },
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
