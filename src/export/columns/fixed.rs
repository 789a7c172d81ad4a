//! The columns that tables have whatever the data, and the clocks and axes that they are measured on.

use super::{Column, Levels};
use crate::export::cells::Kind;

const fn column(name: &'static str, kind: Kind, unit: &'static str, meaning: &'static str) -> Column {
    Column { name, kind, unit, meaning, reference: "", levels: &[] }
}

const fn text(name: &'static str, meaning: &'static str) -> Column {
    column(name, Kind::Text, "", meaning)
}

const fn integer(name: &'static str, meaning: &'static str) -> Column {
    column(name, Kind::Integer, "", meaning)
}

const fn real(name: &'static str, unit: &'static str, meaning: &'static str) -> Column {
    column(name, Kind::Real, unit, meaning)
}

const fn flag(name: &'static str, meaning: &'static str) -> Column {
    column(name, Kind::Boolean, "", meaning)
}

/// A time on the session's clock.
const fn time(name: &'static str, meaning: &'static str) -> Column {
    real(name, "s", meaning).on(SESSION_CLOCK)
}

/// The clock of everything that happened.
pub const SESSION_CLOCK: &str = "the session's own clock: monotonic, 0 at the session's start; it goes on where it stood when a \
    session is resumed";
/// The clock of a tracker.
pub const DEVICE_CLOCK: &str = "the tracker's own clock, whose zero only the tracker knows";
/// The clock of a scene.
pub const SCENE_CLOCK: &str = "the scene's clock: 0 when the scene's animation begins";
/// Places in pixels.
pub const DISPLAY_PX: &str = "display pixels: origin at the top left corner of the display, x to the right, y down; pixel (0, 0) \
    reaches from 0 to 1";
/// Places in degrees.
pub const DISPLAY_DEG: &str = "visual angle from the display's centre, x to the right, y up; each coordinate is the angle of its own \
    axis, atan(millimetres / viewing distance)";
/// Eccentricities.
pub const FROM_GAZE: &str = "true angle between the direction to the point of fixation and the direction to the ring";

const SESSION: Column =
    text("session", "name of the session's folder; where several have one name, _2, _3 … follow it");
const OBSERVER: Column = text("observer", "the observer's code");

const OUTCOMES: Levels = &[
    ("answered", "the observer answered"),
    ("timed-out", "no answer in time; the trial was queued again"),
    ("aborted", "the trial was broken off and queued again"),
];
const ABORTS: Levels = &[
    ("gaze-left", "gaze left the fixation gate"),
    ("paused", "the session was paused in the middle of the trial"),
    ("interrupted", "the program ended in the middle of the trial"),
];
const INTERVALS: Levels = &[("1", "the test came first"), ("2", "the reference came first")];
const PICTURES: Levels = &[("reference", "the reference"), ("test", "the test")];

/// What can be presented; see `frames.phase`.
pub const PHASE_LEVELS: Levels = &[
    ("page", "a page of text"),
    ("fixate", "the fixation mark"),
    ("interval1", "the first interval"),
    ("gap", "grey or black between intervals, steps or alternatives"),
    ("interval2", "the second interval"),
    ("step", "one step of a ramp"),
    ("sequence", "a sequence that is rated afterwards"),
    ("alternative-a", "alternative A of a toggled comparison"),
    ("alternative-b", "alternative B of a toggled comparison"),
    ("reference", "the reference, to compare with"),
    ("adjust", "the test, to be adjusted"),
    ("task", "a task is explained"),
    ("marker", "grey with the mark after a sequence"),
    ("hidden", "the stimulus is hidden until gaze is back"),
    ("ask", "the question"),
    ("form", "an item of a form"),
    ("consent", "the consent page"),
    ("feedback", "right or wrong, in practice"),
    ("save", "grey between trials, while the last one is being saved"),
    ("paused", "the session is paused"),
];

/// One row for each session.
pub const SESSIONS: &[Column] = &[
    SESSION,
    OBSERVER,
    text("study", "name of the study"),
    text("study_title", "its title"),
    text("study_sha256", "SHA-256 of the study's text at the start, in hex"),
    text("started", "wall-clock time of the start, RFC 3339"),
    text("group", "the observer's group in a between-subject design"),
    integer("sitting", "which sitting of the study it was, from 1"),
    flag("pilot", "1 for pilot runs, which are shortened and no results"),
    text("display", "name of the display"),
    column("display_width_px", Kind::Integer, "px", "pixels across"),
    column("display_height_px", Kind::Integer, "px", "pixels down"),
    real("display_width_mm", "mm", "width of the lit area"),
    real("display_height_mm", "mm", "height of the lit area"),
    real("distance_mm", "mm", "from the eye to the display's centre"),
    real("refresh_hz", "Hz", "refresh rate as declared"),
    real("peak_cd_m2", "cd/m²", "peak luminance, where it was measured"),
    real("fixation_x_deg", "deg", "where the fixation mark stood").on(DISPLAY_DEG),
    real("fixation_y_deg", "deg", "where the fixation mark stood").on(DISPLAY_DEG),
    text("gaze_source", "where gaze came from: mouse, simulated, recorded or a tracker"),
    text("simulated", "who answered, if that was a simulation: model and truth, as JSON; empty for people"),
    text("stage", "how frames were shown")
        .of(&[("window", "in a window, in real time"), ("offscreen", "without a window, in virtual time")]),
    flag("rendered", "0 if no pictures were drawn"),
    real("frame_s", "s", "time between frames: measured in a window, declared offscreen"),
    text("pacing", "how frames were paced"),
    text("gpu", "graphics adapter and driver"),
    text(
        "seed",
        "seed of every random stream: a whole number of up to 64 bits, as text because doubles cannot hold all of them",
    ),
    text("generator", "generator of the random streams"),
    text("program", "program that ran it, with its version"),
    text("host", "operating system and processor"),
    integer("trials", "trials that ended, practice and aborted ones included"),
    integer("parts", "parts it was run in: 1, and one more for each time it was gone on with"),
    flag("finished", "1 if it ran to its end"),
    text("ended", "why it ended before its design was complete, if it did")
        .of(&[("declined", "the participant did not consent"), ("practice-failed", "practice was not passed")]),
    integer("dropped_gaze_samples", "gaze samples that could not be kept while the disk failed"),
    integer("dropped_frames", "frames whose record could not be kept while the disk failed"),
];

/// One row for each place where a session went on.
pub const SEAMS: &[Column] = &[
    SESSION,
    OBSERVER,
    integer("part", "the part of the session that begins here, from 2"),
    time("t_s", "when it went on"),
    text("wall", "wall-clock time, RFC 3339; empty in logs of format 1"),
    text("program", "name and version of the program that went on; empty in logs of format 1"),
    text("gpu", "graphics adapter and driver from here on, where pictures are drawn"),
    text(
        "changed",
        "what is different from here on and was accepted with --force: a JSON list of field, from and to; empty for nothing",
    ),
];

/// One row for each trial that ended.
pub const TRIALS: &[Column] = &[
    SESSION,
    OBSERVER,
    integer("trial", "number within the session, from 1; aborted trials have numbers too"),
    text("block", "name of the block"),
    flag("practice", "1 for practice, which no fit uses"),
    text("condition", "name of the condition in the study"),
    real("eccentricity_deg", "deg", "eccentricity of the tested ring").on(FROM_GAZE),
    real("mar_deg", "deg/cycle", "omega: detail finer than this was removed in the ring"),
    text("level", "all renderer parameters that the trial set, as JSON"),
    integer(
        "test_interval",
        "1 if the test came first, 2 if the reference did: intervals, alternatives A and B, sequences, a ramp's first step",
    )
    .of(INTERVALS),
    text("outcome", "how it ended").of(OUTCOMES),
    text("abort_reason", "why it was broken off; empty unless aborted").of(ABORTS),
    text(
        "answer",
        "first, second, same, increased, decreased or continue, or an option's number; empty without an answer",
    ),
    flag(
        "correct",
        "1 if the picture asked for, the reference as the better one, or the ramp's direction was named, else 0; empty without \
         an answer or where none is right",
    ),
    real("response_time_s", "s", "from the question to the answer"),
    time("began_s", "when it began"),
    time("ended_s", "when it ended"),
    integer("repetition", "which repetition of its cell and level, from 1, where the design counts them"),
    integer("part", "part of the session, from 1: a session that was ended or killed and gone on with has several"),
];

/// Every phase of every trial that ended: each move of a slider and each toggle is one.
pub const PHASES: &[Column] = &[
    SESSION,
    OBSERVER,
    integer("trial", "number within the session"),
    text("phase", "which part of the trial, as in frames").of(PHASE_LEVELS),
    time("began_s", "when it began"),
    time("ended_s", "when the next one began or the trial ended"),
    text("shown", "which picture was shown, if one was").of(PICTURES),
    text("at", "renderer parameters shown instead of the trial's level, as JSON"),
];

/// Every entry of every form that was filled in.
pub const FORMS: &[Column] = &[
    SESSION,
    OBSERVER,
    text("form", "participant, or the block whose questionnaire it is"),
    time("t_s", "when the form was complete"),
    text("item", "name of the item"),
    text("entry", "the number or text; a choice by its number from 1"),
];

/// Every gaze sample.
pub const GAZE: &[Column] = &[
    SESSION,
    OBSERVER,
    time("t_s", "when the eye was there"),
    time("arrived_s", "when the program had the sample"),
    real("t_device_s", "s", "the tracker's own time").on(DEVICE_CLOCK),
    real("x_px", "px", "where both eyes together look").on(DISPLAY_PX),
    real("y_px", "px", "where both eyes together look").on(DISPLAY_PX),
    real("x_deg", "deg", "where both eyes together look").on(DISPLAY_DEG),
    real("y_deg", "deg", "where both eyes together look").on(DISPLAY_DEG),
    flag("valid", "1 if the tracker saw the eye; places of invalid samples are the last valid ones"),
    real("pupil_mm", "mm", "pupil diameter, where measured"),
    real("left_x_px", "px", "where the left eye looks, if the tracker tells the eyes apart").on(DISPLAY_PX),
    real("left_y_px", "px", "where the left eye looks").on(DISPLAY_PX),
    flag("left_valid", "1 if the tracker saw the left eye"),
    real("left_pupil_mm", "mm", "pupil diameter of the left eye"),
    real("right_x_px", "px", "where the right eye looks, if the tracker tells the eyes apart").on(DISPLAY_PX),
    real("right_y_px", "px", "where the right eye looks").on(DISPLAY_PX),
    flag("right_valid", "1 if the tracker saw the right eye"),
    real("right_pupil_mm", "mm", "pupil diameter of the right eye"),
];

/// Every presented frame.
pub const FRAMES: &[Column] = &[
    SESSION,
    OBSERVER,
    integer("index", "number within the session, from 0"),
    integer("phase_seq", "number of the journal's event that began the phase"),
    integer("trial", "trial, if in one"),
    text("phase", "what was presented").of(PHASE_LEVELS),
    time("scheduled_s", "when the frame was due"),
    time("presented_s", "when it was handed to the display (software time, not light)"),
    flag("missed", "1 if it came later than the refresh that it was due for"),
    real("animation_s", "s", "time of the animation, of moving targets and of spheres").on(SCENE_CLOCK),
    integer("gaze_row", "row of the session's gaze table, from 0, that placed the stimulus"),
    real("gaze_age_s", "s", "age of that sample when the frame was presented"),
    column(
        "pixels_shaded",
        Kind::Integer,
        "px",
        "pixels shaded; 0 if the picture had not changed, empty if none was drawn",
    ),
    real("gpu_time_s", "s", "GPU time of the renderer, where known"),
    text("hash", "XXH3-64 of the frame's 8-bit RGBA bytes, in hex, where it was read back"),
    real("target_x_deg", "deg", "where observers were to look during a stimulus; empty in free viewing")
        .on(DISPLAY_DEG),
    real("target_y_deg", "deg", "where observers were to look during a stimulus; empty in free viewing")
        .on(DISPLAY_DEG),
    text(
        "signature",
        "mean red, green and blue of 6 × 3 parts of the frame, row by row from the top left, in hex, where it was read back",
    ),
];

/// One threshold for each study, observer and eccentricity.
pub const THRESHOLDS: &[Column] = &[
    text("study", "name of the study"),
    OBSERVER,
    real("eccentricity_deg", "deg", "eccentricity").on(FROM_GAZE),
    real("mar_deg", "deg/cycle", "threshold omega, where half of the unguessed answers are right: posterior median"),
    real("ci95_low", "deg/cycle", "lower end of the 95 % credible interval"),
    real("ci95_high", "deg/cycle", "upper end of the 95 % credible interval"),
    flag("limited", "1 if the display could not show the threshold: then mar_deg is an upper bound"),
    real(
        "finest_mar_deg",
        "deg/cycle",
        "finest omega that the display can show there; trials at or below it are in no fit",
    ),
    integer("trials", "trials at this eccentricity"),
];

/// One row for each study, observer and fitted quantity.
pub const FITS: &[Column] = &[
    text("study", "name of the study"),
    OBSERVER,
    text("quantity", "what was fitted").of(&[
        ("m", "slope of omega over eccentricity, deg/cycle per deg"),
        ("omega0", "omega at the fovea, deg/cycle"),
        ("width", "width of the psychometric function from 5 % to 95 % of its rise, ln omega"),
        ("lapse", "share of answers given without regard to the stimulus"),
    ]),
    real("estimate", "", "posterior median, in the unit of the quantity"),
    real("ci95_low", "", "lower end of the 95 % credible interval, in the unit of the quantity"),
    real("ci95_high", "", "upper end of the 95 % credible interval, in the unit of the quantity"),
    flag("display_limited", "for omega0: 1 if it lies below everything the display could show, so is extrapolated"),
    flag("supported", "1 if the data support the fit"),
    integer("trials", "trials in the fit"),
];
