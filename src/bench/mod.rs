//! What a frame costs under each renderer: a camera path with a gaze, rendered twice, once timed and once counted.
//!
//! In the timed pass the renderers take turns frame by frame, so that whatever else the machine does falls on all of them
//! alike, and all ratios are of the same frames of the same run. Every renderer has a scene of its own, because scenes
//! keep things from one drawing to the next (a shadow map, say) that would be free to whoever draws second. Pictures that
//! stand still are declared to move, so that none is shown once more instead of being drawn. The counted pass renders the
//! same frames again and counts on the GPU what the scene shaded. `gaze` is where the eye looks, `frames` the two
//! passes, `ratio` the arithmetic, `figure` the picture of it.

mod figure;
mod frames;
mod gaze;
mod ratio;
mod summary;

pub use figure::figure;
pub use gaze::GazePath;
pub use ratio::Ratio;
pub use summary::{Counted, LayerSums, Measured, Ratios, RendererMeasured, Sums};

use crate::error::LabError;
use experiments::Display;
use experiments::catalogue::Parameters;
use frames::Contender;
use stimuli::gpu::Gpu;

/// Frames before those that count: shaders are compiled, textures made and histories filled. Even, so that layers that
/// are drawn in turn have had theirs equally often.
pub const WARM_UP_FRAMES: u32 = 2;

/// The renderer that all others are compared with.
pub const REFERENCE: &str = "reference";

/// What is to be measured.
#[derive(Debug)]
pub struct Request {
    /// The display.
    pub display: Display,
    /// The scene's name.
    pub scene: String,
    /// What is set of it.
    pub scene_parameters: Parameters,
    /// Who takes part; the first is the [`REFERENCE`].
    pub entrants: Vec<Entrant>,
    /// Frames that count, after [`WARM_UP_FRAMES`] that do not.
    pub frames: u32,
    /// Frames in a second of the scene's clock and of the gaze.
    pub fps: f64,
    /// Where the eye looks.
    pub gaze: GazePath,
}

/// A renderer that takes part.
#[derive(Debug, Clone, PartialEq)]
pub struct Entrant {
    /// The renderer's name.
    pub renderer: String,
    /// The quality index that it runs at, where that is varied.
    pub quality_index: Option<f64>,
    /// What is set of it, the quality index included.
    pub parameters: Parameters,
}

impl Request {
    /// Frames of each renderer in each pass.
    #[must_use]
    pub fn all_frames(&self) -> u32 {
        WARM_UP_FRAMES + self.frames
    }

    /// Frames of all renderers in both passes: the steps of progress.
    #[must_use]
    pub fn steps(&self) -> u64 {
        2 * u64::from(self.all_frames()) * self.entrants.len() as u64
    }
}

/// Renders everything and sums it up; `step` is called after every frame of every renderer.
///
/// # Errors
/// When a scene or renderer cannot be made or drawn.
pub fn run(gpu: &Gpu, request: &Request, step: &dyn Fn()) -> Result<Measured, LabError> {
    let made = request.entrants.iter().map(|entrant| Contender::new(gpu, request, entrant));
    let mut contenders = made.collect::<Result<Vec<_>, LabError>>()?;
    let blocking = gpu.blocking_timing();
    gpu.set_blocking_timing(true);
    let passes = frames::timed(gpu, request, &mut contenders, step)
        .and_then(|timed| Ok((timed, frames::counted(gpu, request, &mut contenders, step)?)));
    gpu.set_blocking_timing(blocking);
    let (timed, counted) = passes?;
    Ok(summary::measured(gpu, request, &timed, &counted))
}
