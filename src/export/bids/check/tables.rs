//! Tables with a header: participants and events, and the descriptions of their columns.

use super::{Check, entities};
use crate::error::LabError;
use serde_json::Value;
use std::collections::BTreeSet;

/// Keys of `_events.json` that are no columns.
const NO_COLUMNS: [&str; 7] =
    ["TaskName", "TaskDescription", "Instructions", "StimulusPresentation", "Study", "GazeSource", "GraphicsAdapter"];

impl Check<'_> {
    /// Reads a table, holds its form and that its first columns are `first`, and gives its rows.
    pub(super) fn table(&mut self, file: &str, first: &[&str]) -> Result<Vec<Vec<String>>, LabError> {
        let Some(text) = self.text(file)? else { return Ok(Vec::new()) };
        if !text.is_empty() && !text.ends_with('\n') {
            self.problem(file, "the last line is cut");
        }
        let mut lines = text.lines().map(|line| line.split('\t').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().unwrap_or_default();
        if header.len() < first.len() || header.iter().zip(first).any(|(column, expected)| column != expected) {
            self.problem(file, format!("the first columns are not {}", first.join(", ")));
        }
        if header.iter().collect::<BTreeSet<_>>().len() < header.len() {
            self.problem(file, "a column's name is there twice");
        }
        let rows: Vec<Vec<String>> = lines.collect();
        for (index, row) in rows.iter().enumerate() {
            if row.len() != header.len() {
                self.problem(file, format!("row {} has {} cells, the header {}", index + 1, row.len(), header.len()));
            }
            if row.iter().any(|cell| cell.trim().is_empty()) {
                self.problem(file, format!("row {} has an empty cell; what is not there is n/a", index + 1));
            }
        }
        self.described(file, &header)?;
        Ok(rows)
    }

    /// Every column has its description and every description its column.
    fn described(&mut self, file: &str, header: &[String]) -> Result<(), LabError> {
        let sidecar = file.replace(".tsv", ".json");
        let Some(Value::Object(description)) = self.json(&sidecar)? else { return Ok(()) };
        for column in header {
            if description.get(column).is_none_or(|entry| entry["Description"].as_str().is_none_or(str::is_empty)) {
                self.problem(&sidecar, format!("the column {column} is not described"));
            }
        }
        for key in description.keys() {
            if !header.contains(key) && !NO_COLUMNS.contains(&key.as_str()) {
                self.problem(&sidecar, format!("{key} is no column"));
            }
        }
        Ok(())
    }

    pub(super) fn events(&mut self) -> Result<(), LabError> {
        let files: Vec<String> = self.files.iter().filter(|file| file.ends_with("_events.tsv")).cloned().collect();
        for file in files {
            let rows = self.table(&file, &["onset", "duration"])?;
            let mut last = f64::NEG_INFINITY;
            for (index, row) in rows.iter().enumerate() {
                let onset = row.first().and_then(|cell| cell.parse::<f64>().ok()).filter(|onset| onset.is_finite());
                match onset {
                    Some(onset) if onset < last => {
                        self.problem(&file, format!("row {} begins before the one above", index + 1));
                    }
                    Some(onset) => last = onset,
                    None => self.problem(&file, format!("the onset of row {} is no number", index + 1)),
                }
                let duration = row.get(1).map_or("", String::as_str);
                if duration != "n/a"
                    && duration.parse::<f64>().map_or(true, |seconds| seconds.is_nan() || seconds < 0.0)
                {
                    self.problem(&file, format!("the duration of row {} is no number from 0", index + 1));
                }
            }
            let sidecar = file.replace(".tsv", ".json");
            let Some(description) = self.json(&sidecar)? else { continue };
            self.levels(&file, &rows, &description)?;
            let task = description["TaskName"].as_str().unwrap_or_default();
            let letters: String = task.chars().filter(char::is_ascii_alphanumeric).collect();
            if entities(&file).get("task").is_none_or(|label| *label != letters) {
                self.problem(&sidecar, format!("TaskName \"{task}\" is not the task of the file's name"));
            }
            self.screen(&sidecar, &description["StimulusPresentation"]);
        }
        Ok(())
    }

    /// Every value of a column with levels is one of them.
    fn levels(&mut self, file: &str, rows: &[Vec<String>], description: &Value) -> Result<(), LabError> {
        let header: Vec<String> = self
            .text(file)?
            .unwrap_or_default()
            .lines()
            .next()
            .unwrap_or_default()
            .split('\t')
            .map(str::to_owned)
            .collect();
        for (index, column) in header.iter().enumerate() {
            let Some(levels) = description[column]["Levels"].as_object() else { continue };
            let unknown: BTreeSet<&str> = rows
                .iter()
                .filter_map(|row| row.get(index).map(String::as_str))
                .filter(|value| *value != "n/a" && !levels.contains_key(*value))
                .collect();
            for value in unknown {
                self.problem(file, format!("{column} has the value {value}, which is none of its Levels"));
            }
        }
        Ok(())
    }

    /// The four facts of the screen that gaze on it means nothing without.
    fn screen(&mut self, file: &str, screen: &Value) {
        let is_length = |value: &Value| value.as_f64().is_some_and(|metres| (0.01..1000.0).contains(&metres));
        let two = |value: &Value, good: &dyn Fn(&Value) -> bool| {
            value.as_array().is_some_and(|pair| pair.len() == 2 && pair.iter().all(good))
        };
        if !is_length(&screen["ScreenDistance"]) {
            self.problem(file, "StimulusPresentation.ScreenDistance is no distance in metres");
        }
        if !two(&screen["ScreenSize"], &is_length) {
            self.problem(file, "StimulusPresentation.ScreenSize is no width and height in metres");
        }
        if !two(&screen["ScreenResolution"], &|value| value.as_u64().is_some_and(|pixels| pixels > 0)) {
            self.problem(file, "StimulusPresentation.ScreenResolution is no width and height in pixels");
        }
        let origin = screen["ScreenOrigin"].as_array().map(Vec::as_slice).unwrap_or_default();
        let word = |index: usize| origin.get(index).and_then(Value::as_str).unwrap_or_default();
        let good = ["top", "bottom", "center"].contains(&word(0)) && ["left", "right", "center"].contains(&word(1));
        if !good || origin.len() != 2 {
            self.problem(file, "StimulusPresentation.ScreenOrigin is no place like [\"top\", \"left\"]");
        }
    }
}
