//! The data dictionary: every column of every exported table, with its type, unit, meaning, levels and frame of reference.

use super::cells::Kind;
use super::tables::Table;
use crate::session::SessionFolder;
use experiments::trial::Outcome;
use serde::Serialize;
use serde::ser::SerializeMap;
use serde::ser::Serializer;
use std::collections::BTreeSet;

/// Values that a column can have, each with its meaning.
pub type Levels = &'static [(&'static str, &'static str)];

/// One column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Its name in the table's first line.
    pub name: &'static str,
    /// What its cells are.
    pub kind: Kind,
    /// Unit, empty for none.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: &'static str,
    /// For times and places: the clock or the axes that they are measured on. Empty for everything else.
    pub reference: &'static str,
    /// The values it can have, where they are few; empty if they are not.
    pub levels: Levels,
}

impl Column {
    const fn on(self, reference: &'static str) -> Self {
        Self { reference, ..self }
    }

    const fn of(self, levels: Levels) -> Self {
        Self { levels, ..self }
    }
}

/// A column whose name may be known only from the data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NamedColumn {
    /// Its name in the table's first line.
    pub name: String,
    /// What its cells are.
    #[serde(rename = "type")]
    pub kind: Kind,
    /// Unit, empty for none.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: String,
    /// For times and places: the clock or the axes that they are measured on.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub reference: &'static str,
    /// The values it can have, where they are few.
    #[serde(skip_serializing_if = "<[_]>::is_empty", serialize_with = "as_object")]
    pub levels: Levels,
}

fn as_object<S: Serializer>(levels: &Levels, serializer: S) -> Result<S::Ok, S::Error> {
    let mut object = serializer.serialize_map(Some(levels.len()))?;
    for (value, meaning) in *levels {
        object.serialize_entry(value, meaning)?;
    }
    object.end()
}

impl From<&Column> for NamedColumn {
    fn from(column: &Column) -> Self {
        Self {
            name: column.name.to_owned(),
            kind: column.kind,
            unit: column.unit,
            meaning: column.meaning.to_owned(),
            reference: column.reference,
            levels: column.levels,
        }
    }
}

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
        let named =
            |name: String, kind, unit, meaning| NamedColumn { name, kind, unit, meaning, reference: "", levels: &[] };
        let factors = self.factors.iter().map(|name| {
            let meaning = format!("level of the factor {name}; empty in blocks without it");
            named(format!("factor_{name}"), Kind::Text, "", meaning)
        });
        let levels = self.levels.iter().map(|name| {
            let meaning = format!("the renderer parameter {name} as the trial set it, in the parameter's own unit");
            named(format!("level_{name}"), Kind::Real, unit(name), meaning)
        });
        let found = self.found.iter().map(|name| {
            let meaning = format!(
                "what the trial found for {name}: a setting, a rating, a count, or how often something was done"
            );
            named(format!("found_{name}"), Kind::Real, unit(name), meaning)
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

/// The dictionary as one JSON document: file → columns. `names` are those of the trials that were exported, `extension` is that
/// of the tables' files.
#[must_use]
pub fn dictionary(names: &TrialNames, extension: &str) -> serde_json::Value {
    let tables =
        Table::ALL.map(|table| (format!("{}.{extension}", table.name()), serde_json::json!(table.columns(names))));
    serde_json::Value::Object(tables.into_iter().collect())
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
        let trials = dictionary(&names, "csv")["trials.csv"].as_array().map_or(0, Vec::len);
        assert_eq!(trials, TRIALS.len() + expected.len());
    }

    /// Nobody should have to guess what a time or a place is measured from.
    #[test]
    fn every_time_and_place_says_what_it_is_measured_from_and_every_unit_is_in_the_name() {
        let durations = ["response_time_s", "gaze_age_s", "gpu_time_s", "frame_s"];
        for (table, column) in
            Table::ALL.iter().flat_map(|table| table.fixed().iter().map(move |column| (table, column)))
        {
            let name = column.name;
            let is_time = name.ends_with("_s") && !durations.contains(&name);
            let is_place = ["x_px", "y_px", "x_deg", "y_deg"].iter().any(|end| name.ends_with(end))
                || name.contains("eccentricity");
            assert_eq!(!column.reference.is_empty(), is_time || is_place, "{table:?}: {name}");
            for (end, unit) in [("_s", "s"), ("_px", "px"), ("_mm", "mm"), ("_hz", "Hz")] {
                assert!(!name.ends_with(end) || column.unit == unit, "{table:?}: {name} in {}", column.unit);
            }
            assert!(!name.ends_with("_deg") || column.unit.starts_with("deg"), "{table:?}: {name} in {}", column.unit);
            assert!(!column.meaning.is_empty(), "{table:?}: {name}");
        }
    }

    #[test]
    fn every_phase_is_a_level() {
        use experiments::trial::PhaseName;
        for (name, _) in PHASE_LEVELS {
            let phase: PhaseName = serde_json::from_value(serde_json::json!(name)).expect("a phase");
            assert_eq!(phase.as_str(), *name);
        }
    }
}
