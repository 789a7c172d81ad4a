//! Recordings of gaze: that each has what the standard asks of eye tracking, events beside it, and sound rows.

use super::Check;
use crate::error::LabError;
use flate2::read::GzDecoder;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufRead, BufReader};

const EYES: [&str; 3] = ["left", "right", "cyclopean"];
const PLACES: [&str; 4] = ["gaze-on-screen", "eye-in-head", "gaze-in-world", "custom"];

impl Check<'_> {
    pub(super) fn recordings(&mut self) -> Result<(), LabError> {
        let of = |end: &str| -> Vec<String> { self.files.iter().filter(|file| file.ends_with(end)).cloned().collect() };
        let (samples, events) = (of("_physio.tsv.gz"), of("_physioevents.tsv.gz"));
        let mut eyes = BTreeSet::new();
        for file in samples {
            self.recording(&file, &mut eyes)?;
        }
        for file in events {
            self.recording_events(&file)?;
        }
        Ok(())
    }

    fn recording(&mut self, file: &str, eyes: &mut BTreeSet<(String, String)>) -> Result<(), LabError> {
        let sidecar = file.replace(".tsv.gz", ".json");
        let Some(description) = self.json(&sidecar)? else { return Ok(()) };
        let eye = description["RecordedEye"].as_str().unwrap_or_default().to_owned();
        let place = description["SampleCoordinateSystem"].as_str().unwrap_or_default().to_owned();
        let start_s = description["StartTime"].as_f64();
        let wrong = [
            (description["PhysioType"] != "eyetrack", "PhysioType is not eyetrack"),
            (
                description["SamplingFrequency"].as_f64().is_none_or(|rate| rate <= 0.0),
                "SamplingFrequency is no rate in hertz",
            ),
            (start_s.is_none(), "StartTime is no time in seconds"),
            (!EYES.contains(&eye.as_str()), "RecordedEye is none of left, right and cyclopean"),
            (!PLACES.contains(&place.as_str()), "SampleCoordinateSystem is none that there is"),
        ];
        for (_, what) in wrong.into_iter().filter(|(wrong, _)| *wrong) {
            self.problem(&sidecar, what);
        }
        for axis in ["x_coordinate", "y_coordinate"] {
            if description[axis]["Units"].as_str().is_none_or(|unit| unit.trim().is_empty()) {
                self.problem(&sidecar, format!("{axis} has no Units"));
            }
        }
        let columns = self.columns(&sidecar, &description, &["timestamp", "x_coordinate", "y_coordinate"]);

        // What the stem of all a session's files is: everything before the recording.
        let stem = file.split("_recording-").next().unwrap_or(file).to_owned();
        if !eyes.insert((stem.clone(), eye)) {
            self.problem(&sidecar, "another recording is of the same eye");
        }
        // Without events beside it the validator stops, and gaze on a screen of unknown size means nothing.
        if place == "gaze-on-screen" {
            for end in ["events.tsv", "events.json"] {
                let beside = format!("{stem}_{end}");
                if !self.files.contains(&beside) {
                    self.problem(file, format!("{beside} is missing"));
                }
            }
        }
        let mut first_s = None;
        self.rows(file, &columns, |row, cells| {
            let numbers: Vec<Option<f64>> =
                cells.iter().map(|cell| cell.parse().ok().filter(|value: &f64| value.is_finite())).collect();
            if row == 1 {
                first_s = numbers[0];
            }
            (numbers.iter().zip(cells).any(|(number, cell)| number.is_none() && *cell != "n/a"))
                .then(|| "holds what is neither a number nor n/a".to_owned())
        })?;
        if let (Some(first_s), Some(start_s)) = (first_s, start_s)
            && (first_s - start_s).abs() > 1e-6
        {
            self.problem(&sidecar, format!("StartTime {start_s} is not the first timestamp {first_s}"));
        }
        Ok(())
    }

    fn recording_events(&mut self, file: &str) -> Result<(), LabError> {
        let sidecar = file.replace(".tsv.gz", ".json");
        let Some(description) = self.json(&sidecar)? else { return Ok(()) };
        let columns = self.columns(&sidecar, &description, &["onset"]);
        let source = description["OnsetSource"].as_str().unwrap_or_default().to_owned();
        let samples = file.replace("_physioevents.tsv.gz", "_physio.json");
        if let Some(recording) = self.json(&samples)? {
            let known = recording["Columns"]
                .as_array()
                .is_some_and(|columns| columns.iter().any(|name| *name == source.as_str()));
            if !known && source != "n/a" {
                self.problem(&sidecar, format!("OnsetSource \"{source}\" is no column of the recording"));
            }
        }
        let duration = columns.iter().position(|column| column == "duration");
        self.rows(file, &columns, |_, cells| {
            let cell = duration.and_then(|index| cells.get(index)).copied().unwrap_or("n/a");
            let good = cell == "n/a" || cell.parse::<f64>().is_ok_and(|seconds| seconds >= 0.0);
            (!good).then(|| "has a duration that is no number from 0".to_owned())
        })
    }

    /// The names in `Columns`, of which the first must be `first`; each is described.
    fn columns(&mut self, sidecar: &str, description: &Value, first: &[&str]) -> Vec<String> {
        let columns: Vec<String> = description["Columns"]
            .as_array()
            .map(|columns| columns.iter().filter_map(|name| name.as_str().map(str::to_owned)).collect())
            .unwrap_or_default();
        if columns.len() < first.len() || columns.iter().zip(first).any(|(column, expected)| column != expected) {
            self.problem(sidecar, format!("Columns does not begin with {}", first.join(", ")));
        }
        if columns.iter().collect::<BTreeSet<_>>().len() < columns.len() {
            self.problem(sidecar, "Columns has a name twice");
        }
        for column in &columns {
            if description[column]["Description"].as_str().is_none_or(str::is_empty) {
                self.problem(sidecar, format!("the column {column} is not described"));
            }
        }
        columns
    }

    /// Reads the rows of a compressed table: their number of cells, that nothing is empty, that the first column is a number
    /// that never goes back, and what `other` says of them. The first problem of a file is enough.
    fn rows(
        &mut self,
        file: &str,
        columns: &[String],
        mut other: impl FnMut(usize, &[&str]) -> Option<String>,
    ) -> Result<(), LabError> {
        let path = self.root.join(file);
        let open = File::open(&path).map_err(|error| LabError::io("read", &path, &error))?;
        let mut last = f64::NEG_INFINITY;
        for (index, line) in BufReader::new(GzDecoder::new(open)).lines().enumerate() {
            let row = index + 1;
            let Ok(line) = line else {
                self.problem(file, format!("row {row} cannot be uncompressed"));
                return Ok(());
            };
            let cells: Vec<&str> = line.split('\t').collect();
            let time = cells[0].parse::<f64>().ok().filter(|time| time.is_finite());
            let what = if cells.len() != columns.len() {
                Some(format!("has {} cells for {} columns", cells.len(), columns.len()))
            } else if cells.iter().any(|cell| cell.trim().is_empty()) {
                Some("has an empty cell".to_owned())
            } else {
                match time {
                    None => Some("does not begin with a time".to_owned()),
                    Some(time) if time < last => Some("goes back in time".to_owned()),
                    Some(time) => {
                        last = time;
                        other(row, &cells)
                    }
                }
            };
            if let Some(what) = what {
                self.problem(file, format!("row {row} {what}"));
                return Ok(());
            }
        }
        Ok(())
    }
}
