//! The offscreen stage: virtual time, a simulated observer, real frames or none.
//!
//! A frame lasts exactly one refresh interval of the study's display, however long it takes to draw, so that a slow
//! machine gives the same session as a fast one. Frames whose picture has not changed are logged and not drawn again. A
//! simulated eye is told at every frame what it is to do, since what it looks at may move.

use super::frame_hash::Fingerprint;
use super::painter::{FrameKey, Painter};
use super::runner::Runner;
use crate::error::LabError;
use crate::gaze::GazeSource;
use experiments::observers::rejoin::{is_met, presented};
use experiments::observers::{Look, Observer, Picture, Seen};
use experiments::study::plan::Fixation;
use experiments::trial::{Answer, Input, Presentation};

/// How long a simulated observer rests when the session is paused, seconds.
const PAUSE_S: f64 = 1.0;

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
    let mut met_phase = None;
    let mut look = Look::At(runner.session().plan().gaze.fixation_deg);
    let mut answer: Option<(Answer, f64)> = None;
    let mut samples = Vec::new();
    let mut last: Option<(FrameKey, Fingerprint)> = None;
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
        runner.tick(t_s, frame_s)?;

        // A new phase: the observer looks, and may answer later.
        let Some(phase) = runner.phase() else {
            break;
        };
        if met_phase != Some(runner.phase_seq()) && !is_met(phase.name) {
            met_phase = Some(runner.phase_seq());
            answer = Some((Answer::Continue, t_s + PAUSE_S));
        }
        if met_phase != Some(runner.phase_seq()) {
            met_phase = Some(runner.phase_seq());
            if let Some(painter) = painter.as_deref_mut()
                && observer.wants_pixels()
            {
                show(observer, painter, &runner, t_s)?;
            }
            let level = runner.session().shown_level();
            let response = observer.meet(&presented(runner.session(), phase, level.as_ref()));
            look = response.look;
            answer = response.answer.map(|(said, after_s)| (said, t_s + after_s));
        }

        direct(look, gaze, &runner, t_s);

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
            let print = match unchanged {
                Some((_, print)) => {
                    row.pixels_shaded = Some(0);
                    print
                }
                None => {
                    let (picture, cost) = painter.picture(&view)?;
                    row.pixels_shaded = Some(cost.map_or(0, |cost| cost.pixels_shaded));
                    row.gpu_time_s = cost.and_then(|cost| cost.gpu_time_s);
                    Fingerprint::of(picture.as_raw(), [picture.width(), picture.height()])
                }
            };
            row.hash = Some(print.hash.clone());
            row.signature = Some(print.signature.clone());
            last = Some((key, print));
        }
        runner.log_frame(row)?;
        runner.count_frame();
        progress(&runner);
    }
    progress(&runner);
    runner.close()
}

/// Tells the eye what to do, at a frame's time.
fn direct(look: Look, gaze: &mut dyn GazeSource, runner: &Runner, t_s: f64) {
    let session = runner.session();
    let moves = session.phase().is_some_and(|phase| matches!(phase.presentation, Presentation::Stimulus(_)))
        && session.condition().is_some_and(|condition| matches!(condition.fixation, Fixation::Moving(_)));
    let target_deg = session.look_at_deg(session.animation_s(t_s));
    match look {
        Look::At(deg) => gaze.look_at(t_s, deg),
        Look::Target if moves => gaze.pursue(t_s, target_deg),
        Look::Target => gaze.look_at(t_s, target_deg),
        Look::Around => gaze.look_around(t_s),
    }
}

/// Shows the observer the first picture of a stimulus phase, and the reference of the same moment.
fn show(observer: &mut dyn Observer, painter: &mut Painter, runner: &Runner, t_s: f64) -> Result<(), LabError> {
    let Some(view) = runner.view(t_s) else { return Ok(()) };
    let Some(reference) = painter.reference_picture(&view)? else { return Ok(()) };
    let (shown, _) = painter.picture(&view)?;
    let size_px = [shown.width(), shown.height()];
    observer.see(&Seen {
        shown: Picture { size_px, rgba: shown.as_raw() },
        reference: Picture { size_px, rgba: reference.as_raw() },
        gaze_deg: view.gaze_deg,
        display: &runner.session().plan().display,
    });
    Ok(())
}
