//! The data dictionary: every column of every exported table, with its unit and meaning.

use crate::session::SessionFolder;
use experiments::trial::Outcome;
use serde::Serialize;
use std::collections::BTreeSet;

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

/// A column whose name is known only from the data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NamedColumn {
    /// Its name in the table's first line.
    pub name: String,
    /// Unit, empty for none.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: String,
}

impl From<&Column> for NamedColumn {
    fn from(column: &Column) -> Self {
        Self { name: column.name.to_owned(), unit: column.unit, meaning: column.meaning.to_owned() }
    }
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
    column(
        "test_interval",
        "",
        "1 if the test came first, 2 if the reference did: intervals, alternatives A and B, sequences, a ramp's first step",
    ),
    column("outcome", "", "answered, timed-out or aborted"),
    column("abort_reason", "", "gaze-left, paused or interrupted; empty unless aborted"),
    column(
        "answer",
        "",
        "first, second, same, increased, decreased or continue, or an option's number; empty without an answer",
    ),
    column(
        "correct",
        "",
        "1 if the picture asked for, the reference as the better one, or the ramp's direction was named, else 0; empty without \
         an answer or where none is right",
    ),
    column("response_time_s", "s", "from the question to the answer"),
    column("began_s", "s", "when the trial began, seconds since the session's start"),
    column("ended_s", "s", "when it ended"),
    column("repetition", "", "which repetition of its cell and level, from 1, where the design counts them"),
    column("part", "", "part of the session, from 1: a session that was ended or killed and gone on with has several"),
];

/// Every phase of every trial that ended: each move of a slider and each toggle is one.
pub const PHASES: &[Column] = &[
    SESSION,
    OBSERVER,
    column("trial", "", "number within the session"),
    column("phase", "", "which part of the trial, as in frames.csv"),
    column("began_s", "s", "when it began, seconds since the session's start"),
    column("ended_s", "s", "when the next one began or the trial ended"),
    column("shown", "", "reference or test, if a picture was shown"),
    column("at", "", "renderer parameters shown instead of the trial's level, as JSON"),
];

/// Every entry of every form that was filled in.
pub const FORMS: &[Column] = &[
    SESSION,
    OBSERVER,
    column("form", "", "participant, or the block whose questionnaire it is"),
    column("t_s", "s", "when the form was complete, seconds since the session's start"),
    column("item", "", "name of the item"),
    column("entry", "", "the number or text; a choice by its number from 1"),
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
    column(
        "signature",
        "",
        "mean red, green and blue of 6 × 3 parts of the frame, row by row from the top left, in hex, where it was read back",
    ),
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

/// Every table with its fixed columns.
pub const TABLES: [(&str, &[Column]); 7] = [
    ("trials.csv", TRIALS),
    ("phases.csv", PHASES),
    ("forms.csv", FORMS),
    ("gaze.csv", GAZE),
    ("frames.csv", FRAMES),
    ("thresholds.csv", THRESHOLDS),
    ("fits.csv", FITS),
];

/// The names that trials brought with them, each of which has a column of its own.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TrialNames {
    /// Factors of the design.
    pub factors: BTreeSet<String>,
    /// Renderer parameters that levels set.
    pub levels: BTreeSet<String>,
    /// What trials found besides their answers.
    pub found: BTreeSet<String>,
}

impl TrialNames {
    /// The names in all trials of some sessions.
    #[must_use]
    pub fn of(sessions: &[SessionFolder]) -> Self {
        let mut names = Self::default();
        for record in sessions.iter().flat_map(|session| &session.record.trials) {
            names.factors.extend(record.trial.factors.keys().cloned());
            names.levels.extend(record.trial.level.keys().cloned());
            if let Outcome::Answered { found, .. } = &record.outcome {
                names.found.extend(found.keys().cloned());
            }
        }
        names
    }

    /// Their columns, in the order in which rows are written.
    #[must_use]
    pub fn columns(&self) -> Vec<NamedColumn> {
        let factors = self.factors.iter().map(|name| NamedColumn {
            name: format!("factor_{name}"),
            unit: "",
            meaning: format!("level of the factor {name}; empty in blocks without it"),
        });
        let levels = self.levels.iter().map(|name| NamedColumn {
            name: format!("level_{name}"),
            unit: unit(name),
            meaning: format!("the renderer parameter {name} as the trial set it, in the parameter's own unit"),
        });
        let found = self.found.iter().map(|name| NamedColumn {
            name: format!("found_{name}"),
            unit: unit(name),
            meaning: format!(
                "what the trial found for {name}: a setting, a rating, a count, or how often something was done"
            ),
        });
        factors.chain(levels).chain(found).collect()
    }
}

/// The unit that a name ends with.
fn unit(name: &str) -> &'static str {
    let name = name.strip_suffix("_settled").unwrap_or(name);
    [("mar_deg", "deg/cycle"), ("_deg", "deg"), ("_px", "px"), ("_s", "s"), ("_mm", "mm")]
        .into_iter()
        .find_map(|(end, unit)| name.ends_with(end).then_some(unit))
        .unwrap_or("")
}

/// The dictionary as one JSON document: table → columns. `names` are those of the trials that were exported.
#[must_use]
pub fn dictionary(names: &TrialNames) -> serde_json::Value {
    let tables = TABLES.iter().map(|(name, columns)| {
        let mut columns: Vec<NamedColumn> = columns.iter().map(NamedColumn::from).collect();
        if *name == "trials.csv" {
            columns.extend(names.columns());
        }
        ((*name).to_owned(), serde_json::json!(columns))
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

    #[test]
    fn names_from_the_data_are_described_with_their_units() {
        let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let names = TrialNames {
            factors: set(&["scene"]),
            levels: set(&["quality_index", "radius_deg"]),
            found: set(&["mar_deg_settled", "moves"]),
        };
        let described: Vec<(String, &str)> =
            names.columns().into_iter().map(|column| (column.name, column.unit)).collect();
        let expected = [
            ("factor_scene", ""),
            ("level_quality_index", ""),
            ("level_radius_deg", "deg"),
            ("found_mar_deg_settled", "deg/cycle"),
            ("found_moves", ""),
        ];
        assert_eq!(described, expected.map(|(name, unit)| (name.to_owned(), unit)));
        let trials = dictionary(&names)["trials.csv"].as_array().map_or(0, Vec::len);
        assert_eq!(trials, TRIALS.len() + expected.len());
    }
}
