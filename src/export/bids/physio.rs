//! `_physio.tsv.gz`: gaze as it was sampled, one file an eye, and `_physioevents.tsv.gz`: what was found in it.
//!
//! Where the tracker tells the eyes apart there is a recording of each, and always one of the gaze of both together, since that
//! is what placed the stimuli. Samples are in order of their time; those that the tracker lost are `n/a`.

use super::tsv::{duration, line, number, plain};
use super::{Place, Written};
use crate::error::LabError;
use crate::export::columns::{DEVICE_CLOCK, DISPLAY_PX, SESSION_CLOCK};
use crate::export::staging;
use crate::export::tables::{Tables, gaze_rows, gaze_source, program, seams};
use crate::gaze::EyeSample;
use crate::session::SessionFolder;
use crate::session::tables::GazeRow;
use analysis::gaze::GazeSample;
use analysis::gaze::events::{EventConfig, detect};
use flate2::write::GzEncoder;
use flate2::{Compression, GzBuilder};
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Whose gaze a recording is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Eye {
    Left,
    Right,
    Cyclopean,
}

impl Eye {
    fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Cyclopean => "cyclopean",
        }
    }

    /// The eye's part of a sample; a sample without one is lost to it.
    fn sample(self, row: &GazeRow) -> EyeSample {
        let both = EyeSample { px: [row.x_px, row.y_px], valid: row.valid, pupil_mm: row.pupil_mm };
        let lost = EyeSample { valid: false, pupil_mm: None, ..both };
        match self {
            Self::Left => row.left.unwrap_or(lost),
            Self::Right => row.right.unwrap_or(lost),
            Self::Cyclopean => both,
        }
    }
}

pub(super) fn write(tables: &Tables<'_>, index: usize, place: &Place, root: &Path) -> Result<Written, LabError> {
    let session = &tables.sessions[index];
    let mut rows = gaze_rows(session)?;
    (tables.progress)();
    // The log has samples in the order in which they arrived.
    rows.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    let eyes = [
        (Eye::Left, rows.iter().any(|row| row.left.is_some())),
        (Eye::Right, rows.iter().any(|row| row.right.is_some())),
        (Eye::Cyclopean, !rows.is_empty()),
    ];
    let mut written = Written::new();
    for (number, (eye, _)) in eyes.into_iter().filter(|(_, recorded)| *recorded).enumerate() {
        let end = |suffix: &str| place.file(&format!("recording-eye{}_{suffix}", number + 1));
        let recording = Recording { session, rows: &rows, eye, task: &place.task };
        let file = end("physio.tsv.gz");
        recording.samples(&root.join(&file))?;
        staging::json(&root.join(end("physio.json")), &recording.description())?;
        written.push((file, rows.len()));

        let (events, limits) = recording.events();
        if !events.is_empty() {
            let file = end("physioevents.tsv.gz");
            let mut gz = Gz::create(&root.join(&file))?;
            events.iter().try_for_each(|event| gz.line(&event.cells()))?;
            gz.finish()?;
            staging::json(&root.join(end("physioevents.json")), &events_description(&place.task, &limits))?;
            written.push((file, events.len()));
        }
    }
    (tables.progress)();
    Ok(written)
}

/// One eye's gaze in one session.
struct Recording<'a> {
    session: &'a SessionFolder,
    /// At least one, in order of time.
    rows: &'a [GazeRow],
    eye: Eye,
    /// The task's name.
    task: &'a str,
}

impl Recording<'_> {
    fn has_pupil(&self) -> bool {
        self.rows.iter().any(|row| self.eye.sample(row).pupil_mm.is_some())
    }

    fn columns(&self) -> Vec<&'static str> {
        let mut columns = vec!["timestamp", "x_coordinate", "y_coordinate"];
        if self.has_pupil() {
            columns.push("pupil_size");
        }
        columns.extend(["device_timestamp", "arrival_time"]);
        columns
    }

    fn samples(&self, path: &Path) -> Result<(), LabError> {
        let mut gz = Gz::create(path)?;
        let has_pupil = self.has_pupil();
        for row in self.rows {
            let sample = self.eye.sample(row);
            let seen = |value: Option<f64>| number(value.filter(|_| sample.valid).unwrap_or(f64::NAN));
            let mut cells = vec![number(row.t_s), seen(Some(sample.px[0])), seen(Some(sample.px[1]))];
            if has_pupil {
                cells.push(seen(sample.pupil_mm));
            }
            cells.extend([number(row.t_device_s), number(row.arrived_s)]);
            gz.line(&cells)?;
        }
        gz.finish()
    }

    /// One over the median time between samples; a recording of one sample has the frame rate, since any will do.
    fn rate_hz(&self) -> f64 {
        let mut steps_s: Vec<f64> =
            self.rows.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).filter(|&step_s| step_s > 0.0).collect();
        let middle = steps_s.len() / 2;
        if steps_s.is_empty() {
            return self.session.display.refresh_hz();
        }
        let (_, median_s, _) = steps_s.select_nth_unstable_by(middle, f64::total_cmp);
        // To a microhertz: the times are differences of doubles.
        (1e6 / *median_s).round() / 1e6
    }

    fn description(&self) -> Value {
        let source = gaze_source(self.session);
        let whose = match (self.eye, source) {
            (Eye::Cyclopean, "mouse") => "place of the mouse pointer, which stood for the gaze",
            (Eye::Cyclopean, _) => "place where both eyes together look, which placed the stimuli",
            (Eye::Left | Eye::Right, _) => "place where the eye looks",
        };
        let axis = |axis: &str| {
            json!({
                "LongName": format!("Gaze position ({axis})"),
                "Description": format!("{whose}; {DISPLAY_PX}; n/a where the tracker lost it"),
                "Units": "pixel",
            })
        };
        let mut description = json!({
            "TaskName": self.task,
            "PhysioType": "eyetrack",
            "RecordedEye": self.eye.name(),
            "SampleCoordinateSystem": "gaze-on-screen",
            "SamplingFrequency": self.rate_hz(),
            "StartTime": self.rows[0].t_s,
            "Columns": self.columns(),
            "SoftwareVersions": program(self.session),
            "GazeSource": self.session.header.gaze_source,
            "timestamp": {
                "LongName": "Time of the sample",
                "Description": format!("when the eye was there: the device's time on {SESSION_CLOCK}; as onsets in the events"),
                "Units": "s",
                "Origin": "the session's start",
            },
            "x_coordinate": axis("x"),
            "y_coordinate": axis("y"),
            "device_timestamp": { "Description": format!("the sample's time on {DEVICE_CLOCK}"), "Units": "s" },
            "arrival_time": {
                "Description": format!("when the program had the sample; measured on {SESSION_CLOCK}"),
                "Units": "s",
            },
        });
        if self.has_pupil() {
            description["pupil_size"] = json!({ "Description": "diameter of the pupil", "Units": "mm" });
        }
        description
    }

    /// Saccades, fixations, losses, and where trials and parts begin, in order; and what the detector cannot show at this
    /// rate.
    fn events(&self) -> (Vec<PhysioEvent>, Vec<String>) {
        let mut events = self.losses();
        let mut limits = Vec::new();
        // A mouse makes no saccades.
        if gaze_source(self.session) != "mouse"
            && let Ok(found) = detect(&self.in_degrees(), &EventConfig::velocity_threshold())
        {
            let of =
                |kind, onset_s, duration_s| PhysioEvent { onset_s, duration_s: Some(duration_s), kind, message: None };
            events.extend(found.saccades.iter().map(|one| of("saccade", one.onset_s, one.duration_s)));
            events.extend(found.fixations.iter().map(|one| of("fixation", one.onset_s, one.duration_s)));
            limits = found.limits;
        }
        let message =
            |onset_s, kind, text: String| PhysioEvent { onset_s, duration_s: None, kind, message: Some(text) };
        events.extend(self.session.record.trials.iter().map(|trial| {
            message(trial.began_s, "n/a", format!("trial {} of block {} begins", trial.trial.trial, trial.trial.block))
        }));
        events.extend(
            seams(self.session).iter().map(|join| message(join.t_s, "n/a", format!("part {} begins", join.part))),
        );
        events.sort_by(|a, b| a.onset_s.total_cmp(&b.onset_s));
        (events, limits)
    }

    fn in_degrees(&self) -> Vec<GazeSample> {
        let (display, fixation) = (&self.session.display, self.session.fixation_deg());
        let of = |row: &GazeRow| {
            let sample = self.eye.sample(row);
            let position_deg = display.deg_from_px(sample.px);
            let deviation_deg = display.eccentricity_deg(fixation, position_deg);
            GazeSample { t_s: row.t_s, position_deg, deviation_deg, valid: sample.valid }
        };
        self.rows.iter().map(of).collect()
    }

    /// Stretches of lost samples, from the first of them to the next one that was seen, or to the last.
    fn losses(&self) -> Vec<PhysioEvent> {
        let mut losses = Vec::new();
        let mut began_s = None;
        for row in self.rows {
            match (self.eye.sample(row).valid, began_s) {
                (false, None) => began_s = Some(row.t_s),
                (true, Some(from_s)) => {
                    losses.push((from_s, row.t_s));
                    began_s = None;
                }
                _ => {}
            }
        }
        if let (Some(from_s), Some(last)) = (began_s, self.rows.last()) {
            losses.push((from_s, last.t_s));
        }
        let of = |(from_s, to_s): (f64, f64)| PhysioEvent {
            onset_s: from_s,
            duration_s: Some(to_s - from_s),
            kind: "loss",
            message: None,
        };
        losses.into_iter().map(of).collect()
    }
}

/// Something in a recording.
struct PhysioEvent {
    onset_s: f64,
    duration_s: Option<f64>,
    kind: &'static str,
    message: Option<String>,
}

impl PhysioEvent {
    fn cells(&self) -> [String; 4] {
        [
            number(self.onset_s),
            self.duration_s.map_or_else(|| "n/a".to_owned(), duration),
            self.kind.to_owned(),
            plain(self.message.as_deref().unwrap_or_default()),
        ]
    }
}

fn events_description(task: &str, limits: &[String]) -> Value {
    let mut how =
        "saccades and fixations by velocity threshold (30 deg/s over 20 ms; Olsen 2012) on the angle of gaze; losses \
                   are runs of samples without the eye, blinks among them; messages say where trials and parts begin"
            .to_owned();
    for limit in limits {
        how += &format!(". {limit}");
    }
    json!({
        "TaskName": task,
        "Columns": ["onset", "duration", "trial_type", "message"],
        "Description": how,
        "OnsetSource": "timestamp",
        "onset": { "Description": "when it began, as the timestamps of the recording", "Units": "s" },
        "duration": { "Description": "how long it lasted", "Units": "s" },
        "trial_type": {
            "Description": "what was found; n/a for messages",
            "Levels": {
                "saccade": "a saccade, from its first to its last fast sample",
                "fixation": "a fixation, from its first to its last sample",
                "loss": "the tracker did not see the eye: blinks and losses",
            },
        },
        "message": { "Description": "what happened in the session at this time" },
    })
}

/// How hard rows are compressed: twice as fast as the usual 6, and hardly larger.
const LEVEL: u32 = 4;

/// A compressed table without a header, being written. No name and no time go into its first bytes, so that the same data
/// give the same file.
struct Gz {
    path: std::path::PathBuf,
    encoder: GzEncoder<BufWriter<File>>,
}

impl Gz {
    fn create(path: &Path) -> Result<Self, LabError> {
        let file = File::create_new(path).map_err(|error| LabError::io("write", path, &error))?;
        let encoder = GzBuilder::new().mtime(0).write(BufWriter::new(file), Compression::new(LEVEL));
        Ok(Self { path: path.to_owned(), encoder })
    }

    fn line(&mut self, cells: &[String]) -> Result<(), LabError> {
        let written = self.encoder.write_all(line(cells).as_bytes());
        written.map_err(|error| LabError::io("write", &self.path, &error))
    }

    fn finish(self) -> Result<(), LabError> {
        let Self { path, encoder } = self;
        let written = encoder.finish().and_then(|mut file| file.flush());
        written.map_err(|error| LabError::io("write", &path, &error))
    }
}
