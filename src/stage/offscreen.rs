//! The offscreen stage: virtual time, a simulated observer, real frames or none.
//!
//! A frame lasts exactly one refresh interval of the study's display, however long it takes to draw, so that a slow
//! machine gives the same session as a fast one. Frames whose picture has not changed are logged and not drawn again. A
//! simulated eye is told at every frame what it is to do, since what it looks at may move.

use super::frame_hash::picture_hash;
use super::painter::{FrameKey, Painter};
use super::runner::Runner;
use crate::error::LabError;
use crate::gaze::GazeSource;
use experiments::observers::{Observer, Presented};
use experiments::study::plan::Fixation;
use experiments::trial::{Answer, Input, Presentation};

/// What an observer does with the eyes while a phase lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Look {
    /// Looks at a place, degrees.
    At([f64; 2]),
    /// Looks at the fixation mark, or follows the moving target.
    Target,
    /// Looks around.
    Around,
}

impl Look {
    /// What is asked of an observer who would look at `otherwise_deg`.
    fn asked(runner: &Runner, otherwise_deg: [f64; 2]) -> Self {
        let session = runner.session();
        let stimulus = session.phase().is_some_and(|phase| matches!(phase.presentation, Presentation::Stimulus(_)));
        match session.condition().map(|condition| condition.fixation) {
            Some(Fixation::Moving(_)) => Self::Target,
            Some(Fixation::Free) if stimulus => Self::Around,
            _ => Self::At(otherwise_deg),
        }
    }

    /// Tells the eye, at a frame's time.
    fn direct(self, gaze: &mut dyn GazeSource, runner: &Runner, t_s: f64) {
        let session = runner.session();
        let moves = session.phase().is_some_and(|phase| matches!(phase.presentation, Presentation::Stimulus(_)))
            && session.condition().is_some_and(|condition| matches!(condition.fixation, Fixation::Moving(_)));
        let target_deg = session.look_at_deg(session.animation_s(t_s));
        match self {
            Self::At(deg) => gaze.look_at(t_s, deg),
            Self::Target if moves => gaze.pursue(t_s, target_deg),
            Self::Target => gaze.look_at(t_s, target_deg),
            Self::Around => gaze.look_around(t_s),
        }
    }
}

/// Runs a session to its end.
///
/// `start_s` is the session time of the first frame (0 for a new session). `progress` is told the completed trials of the
/// session after every frame.
///
/// # Errors
/// When a frame cannot be drawn or the log cannot be written.
pub fn run(
    mut runner: Runner,
    observer: &mut dyn Observer,
    gaze: &mut dyn GazeSource,
    mut painter: Option<&mut Painter>,
    start_s: f64,
    mut progress: impl FnMut(&Runner),
) -> Result<(), LabError> {
    let frame_s = 1.0 / runner.session().plan().display.refresh_hz();
    let fixation_deg = runner.session().plan().gaze.fixation_deg;
    let mut met_phase = None;
    let mut look = Look::At(fixation_deg);
    let mut answer: Option<(Answer, f64)> = None;
    let mut samples = Vec::new();
    let mut last: Option<(FrameKey, String)> = None;
    for frame in 0u64.. {
        let t_s = start_s + frame as f64 * frame_s;

        // Answers come at their own time, between frames.
        if let Some((said, at_s)) = answer.take_if(|(_, at_s)| *at_s <= t_s) {
            runner.input(at_s, Input::Answered { answer: said })?;
        }
        samples.clear();
        gaze.poll(t_s, &mut samples);
        for sample in samples.drain(..) {
            runner.gaze_sample(t_s, sample)?;
        }
        runner.tick(t_s, frame_s, true)?;

        // A new phase: the observer looks, and may answer later.
        let Some(phase) = runner.phase() else {
            break;
        };
        if met_phase != Some(runner.phase_seq()) {
            met_phase = Some(runner.phase_seq());
            let response = observer.meet(&Presented { phase, trial: runner.session().trial(), fixation_deg });
            look = Look::asked(&runner, response.look_at_deg);
            answer = response.answer.map(|(said, after_s)| (said, t_s + after_s));
        }

        look.direct(gaze, &runner, t_s);

        // Draw the frame, unless its picture is the one before, and log it.
        let Some(view) = runner.view(t_s) else {
            break;
        };
        let Some(mut row) = runner.frame_row(t_s, view.animation_s) else {
            break;
        };
        if let Some(painter) = painter.as_deref_mut() {
            let key = FrameKey::from(&view);
            let unchanged = last.take().filter(|(before, _)| painter.same_picture(before, &key));
            let hash = match unchanged {
                Some((_, hash)) => {
                    row.pixels_shaded = Some(0);
                    hash
                }
                None => {
                    let (picture, cost) = painter.picture(&view)?;
                    row.pixels_shaded = Some(cost.map_or(0, |cost| cost.pixels_shaded));
                    row.gpu_time_s = cost.and_then(|cost| cost.gpu_time_s);
                    picture_hash(picture.as_raw())
                }
            };
            row.hash = Some(hash.clone());
            last = Some((key, hash));
        }
        runner.log_frame(row)?;
        runner.count_frame();
        progress(&runner);
    }
    progress(&runner);
    runner.close()
}
