//! Our own check of a BIDS tree: what the standard asks of events and eye tracking, where the official validator (3.0.2) does not
//! look: fields of the screen, units of places, the `recording` entity, whose eye it is, order and form of every row, and that
//! tables and their descriptions name the same columns.
//!
//! It reads the files themselves and nothing of what wrote them.

mod names;
mod recordings;
mod tables;
#[cfg(test)]
mod tests;

use crate::error::LabError;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Files of a tree, by path below its root with `/` between folders.
type Files = BTreeSet<String>;

/// What is wrong, as it is found.
struct Check<'a> {
    root: &'a Path,
    files: Files,
    problems: Vec<String>,
}

/// Everything in the data set at `root` that breaks the standard, a sentence each.
///
/// # Errors
/// When a folder or file cannot be read.
pub fn problems(root: &Path) -> Result<Vec<String>, LabError> {
    let mut check = Check { root, files: files(root)?, problems: Vec::new() };
    check.dataset()?;
    check.names();
    check.events()?;
    check.recordings()?;
    Ok(check.problems)
}

impl Check<'_> {
    fn problem(&mut self, file: &str, what: impl std::fmt::Display) {
        self.problems.push(format!("{file}: {what}"));
    }

    /// A JSON object; nothing, and a problem, where there is none.
    fn json(&mut self, file: &str) -> Result<Option<Value>, LabError> {
        if !self.files.contains(file) {
            self.problem(file, "is missing");
            return Ok(None);
        }
        let path = self.root.join(file);
        let bytes = fs::read(&path).map_err(|error| LabError::io("read", &path, &error))?;
        match serde_json::from_slice::<Value>(&bytes) {
            Ok(value) if value.is_object() => Ok(Some(value)),
            _ => {
                self.problem(file, "is no JSON object");
                Ok(None)
            }
        }
    }

    /// The text of a file; nothing, and a problem, where there is none.
    fn text(&mut self, file: &str) -> Result<Option<String>, LabError> {
        if !self.files.contains(file) {
            self.problem(file, "is missing");
            return Ok(None);
        }
        let path = self.root.join(file);
        let bytes = fs::read(&path).map_err(|error| LabError::io("read", &path, &error))?;
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Some(text)),
            Err(_) => {
                self.problem(file, "is not UTF-8");
                Ok(None)
            }
        }
    }

    /// The root: what the data set is, and that every observer's folder has its row and every row its folder.
    fn dataset(&mut self) -> Result<(), LabError> {
        if let Some(description) = self.json("dataset_description.json")? {
            for key in ["Name", "BIDSVersion"] {
                if description[key].as_str().is_none_or(|text| text.trim().is_empty()) {
                    self.problem("dataset_description.json", format!("{key} is missing"));
                }
            }
        }
        let readme =
            ["README.md", "README", "README.txt", "README.rst"].into_iter().find(|name| self.files.contains(*name));
        match readme {
            None => self.problem("README", "is missing"),
            Some(name) if self.text(name)?.is_some_and(|text| text.trim().is_empty()) => self.problem(name, "is empty"),
            Some(_) => {}
        }
        let folders: BTreeSet<String> = self.files.iter().filter_map(|file| subject_folder(file)).collect();
        if folders.is_empty() {
            self.problem("sub-*", "there is no observer");
        }
        let rows = self.table("participants.tsv", &["participant_id"])?;
        let mut ids = BTreeSet::new();
        for row in rows {
            let id = row.into_iter().next().unwrap_or_default();
            if !ids.insert(id.clone()) {
                self.problem("participants.tsv", format!("{id} has two rows"));
            }
        }
        for id in ids.symmetric_difference(&folders).cloned().collect::<Vec<_>>() {
            self.problem("participants.tsv", format!("{id} has a row or a folder, and not both"));
        }
        Ok(())
    }
}

/// The observer's folder that a file is in.
fn subject_folder(file: &str) -> Option<String> {
    let (folder, _) = file.split_once('/')?;
    folder.starts_with("sub-").then(|| folder.to_owned())
}

/// Every file below a folder.
fn files(root: &Path) -> Result<Files, LabError> {
    let mut files = Files::new();
    let mut left = vec![String::new()];
    while let Some(folder) = left.pop() {
        let path = root.join(&folder);
        for entry in fs::read_dir(&path).map_err(|error| LabError::io("read", &path, &error))? {
            let entry = entry.map_err(|error| LabError::io("read", &path, &error))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let below = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            if entry.path().is_dir() {
                left.push(below);
            } else {
                files.insert(below);
            }
        }
    }
    Ok(files)
}

/// The entities of a file's name: `sub-01_task-x_events.tsv` → sub, task.
fn entities(file: &str) -> BTreeMap<String, String> {
    let name = file.rsplit('/').next().unwrap_or_default();
    name.split('_')
        .filter_map(|part| part.split_once('-'))
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect()
}
