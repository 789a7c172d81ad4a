//! The data dictionary: every column of every exported table, with its unit and meaning.

use serde::Serialize;

/// One column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Its name in the table's first line.
    pub name: &'static str,
    /// Unit, empty for none.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: &'static str,
}

const fn column(name: &'static str, unit: &'static str, meaning: &'static str) -> Column {
    Column { name, unit, meaning }
}

const SESSION: Column = column("session", "", "name of the session's folder");
const OBSERVER: Column = column("observer", "", "the observer's code");

/// One row for each trial that ended.
pub const TRIALS: &[Column] = &[
    SESSION,
    OBSERVER,
    column("trial", "", "number within the session, from 1; aborted trials have numbers too"),
    column("block", "", "name of the block"),
    column("practice", "", "1 for practice, which no fit uses"),
    column("condition", "", "name of the condition in the study"),
    column("eccentricity_deg", "deg", "eccentricity of the tested ring"),
    column("mar_deg", "deg/cycle", "omega: detail finer than this was removed in the ring"),
    column("level", "", "all renderer parameters that the trial set, as JSON"),
    column("test_interval", "", "which interval was degraded: 1 or 2"),
    column("outcome", "", "answered, timed-out or aborted"),
    column("abort_reason", "", "gaze-left, paused or interrupted; empty unless aborted"),
    column("answer", "", "first or second; empty without an answer"),
    column("correct", "", "1 if the degraded interval was named, else 0; empty without an answer"),
    column("response_time_s", "s", "from the question to the answer"),
    column("began_s", "s", "when the trial began, seconds since the session's start"),
    column("ended_s", "s", "when it ended"),
];

/// Every gaze sample.
pub const GAZE: &[Column] = &[
    SESSION,
    OBSERVER,
    column("t_s", "s", "when the eye was there, seconds since the session's start"),
    column("arrived_s", "s", "when the program had the sample"),
    column("t_device_s", "s", "the tracker's own time"),
    column("x_px", "px", "right of the display's left edge"),
    column("y_px", "px", "below the display's top edge"),
    column("x_deg", "deg", "right of the display's centre"),
    column("y_deg", "deg", "above the display's centre"),
    column("valid", "", "1 if the tracker saw the eye; places of invalid samples are the last valid ones"),
    column("pupil_mm", "mm", "pupil diameter, where measured"),
    column("left_x_px", "px", "left eye"),
    column("left_y_px", "px", "left eye"),
    column("left_valid", "", "left eye"),
    column("left_pupil_mm", "mm", "left eye"),
    column("right_x_px", "px", "right eye"),
    column("right_y_px", "px", "right eye"),
    column("right_valid", "", "right eye"),
    column("right_pupil_mm", "mm", "right eye"),
];

/// Every presented frame.
pub const FRAMES: &[Column] = &[
    SESSION,
    OBSERVER,
    column("index", "", "number within the session, from 0"),
    column("phase_seq", "", "number of the journal's event that began the phase"),
    column("trial", "", "trial, if in one"),
    column(
        "phase",
        "",
        "what was presented: page, fixate, interval1, gap, interval2, step, sequence, alternative-a, \
        alternative-b, reference, adjust, task, marker, hidden, ask, form, consent, feedback, save or paused",
    ),
    column("scheduled_s", "s", "when the frame was due"),
    column("presented_s", "s", "when it was handed to the display (software time, not light)"),
    column("missed", "", "1 if it came later than the refresh that it was due for"),
    column("animation_s", "s", "time on the scene's clock, on which moving targets and spheres run too"),
    column("gaze_row", "", "row of the session's gaze table, from 0, that placed the stimulus"),
    column("gaze_age_s", "s", "age of that sample when the frame was presented"),
    column("pixels_shaded", "px", "pixels shaded; 0 if the picture had not changed, empty if none was drawn"),
    column("gpu_time_s", "s", "GPU time of the renderer, where known"),
    column("hash", "", "XXH3-64 of the frame's 8-bit RGBA bytes, where it was read back"),
    column(
        "target_x_deg",
        "deg",
        "where observers were to look during a stimulus: right of the display's centre; empty in free viewing",
    ),
    column("target_y_deg", "deg", "the same: above the display's centre"),
];

/// One threshold for each observer and eccentricity.
pub const THRESHOLDS: &[Column] = &[
    OBSERVER,
    column("eccentricity_deg", "deg", "eccentricity"),
    column("mar_deg", "deg/cycle", "threshold omega, where half of the unguessed answers are right"),
    column("ci95_low", "deg/cycle", "lower end of the 95 % interval"),
    column("ci95_high", "deg/cycle", "upper end of the 95 % interval"),
    column("limited", "", "1 if the display could not show the threshold: then mar_deg is an upper bound"),
    column("trials", "", "trials at this eccentricity"),
];

/// One row for each observer and fitted quantity.
pub const FITS: &[Column] = &[
    OBSERVER,
    column("quantity", "", "m (deg/cycle per deg), omega0 (deg/cycle), width (ln omega) or lapse (share)"),
    column("estimate", "", "posterior median"),
    column("ci95_low", "", "lower end of the 95 % interval"),
    column("ci95_high", "", "upper end of the 95 % interval"),
    column(
        "display_limited",
        "",
        "for omega0: 1 if it lies below everything the display could show, so is extrapolated",
    ),
    column("supported", "", "1 if the data support the fit"),
    column("trials", "", "trials in the fit"),
];

/// Every table with its columns.
pub const TABLES: [(&str, &[Column]); 5] = [
    ("trials.csv", TRIALS),
    ("gaze.csv", GAZE),
    ("frames.csv", FRAMES),
    ("thresholds.csv", THRESHOLDS),
    ("fits.csv", FITS),
];

/// The dictionary as one JSON document: table → columns.
#[must_use]
pub fn dictionary() -> serde_json::Value {
    let tables = TABLES.iter().map(|(name, columns)| {
        let columns: Vec<serde_json::Value> = columns.iter().map(|column| serde_json::json!(column)).collect();
        ((*name).to_owned(), serde_json::Value::Array(columns))
    });
    serde_json::Value::Object(tables.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::tables::{FRAME_COLUMNS, GAZE_COLUMNS};

    #[test]
    fn the_session_tables_are_described_column_by_column() {
        let names = |columns: &[Column]| columns.iter().skip(2).map(|column| column.name).collect::<Vec<_>>();
        assert_eq!(names(GAZE), GAZE_COLUMNS);
        assert_eq!(names(FRAMES), FRAME_COLUMNS);
    }
}
