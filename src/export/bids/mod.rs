//! BIDS 1.11: what happened as `events`, gaze as eye tracking, one file an eye, under `sub-XX[/ses-YY]/beh/`.
//!
//! - `events`: `_events.tsv` and what its columns and the display are;
//! - `physio`: `_physio.tsv.gz` and `_physioevents.tsv.gz`;
//! - `dataset`: the files at the root;
//! - [`check`]: our own check of the whole tree, which every export passes before it is handed over. It covers what the official
//!   validator lets pass.
//!
//! All times, onsets and timestamps are seconds on the session's clock; 0 is the session's start. Data sets for BIDS have no
//! fits: those belong to derivatives.

pub mod check;
mod dataset;
mod events;
mod physio;
mod tsv;

use super::Written;
use super::labels::{Labels, labels};
use super::staging;
use super::tables::Tables;
use crate::error::LabError;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The version of the standard that is written.
pub const BIDS_VERSION: &str = "1.11.1";

/// Writes the data set into `out`, a folder that must not exist or be empty. Returns the files and their numbers of rows.
///
/// # Errors
/// When `out` holds something already, two observers or studies would have one label, a session's table cannot be read, or a
/// file cannot be written.
pub fn export(tables: &Tables<'_>, out: &Path) -> Result<Written, LabError> {
    let labels = labels(tables.sessions)?;
    let subjects: BTreeSet<&str> = labels.iter().map(|label| label.subject.as_str()).collect();
    // Sessions have folders of their own as soon as anybody has two, so that all observers look alike.
    let with_sessions = subjects.len() < labels.len();
    let written = staging::whole(out, |root| {
        let mut written = dataset::write(tables, &labels, with_sessions, root)?;
        for (index, label) in labels.iter().enumerate() {
            let place = Place::new(label, with_sessions);
            let folder = root.join(&place.folder);
            fs::create_dir_all(&folder).map_err(|error| LabError::io("make", &folder, &error))?;
            written.extend(events::write(tables, index, &place, root)?);
            written.extend(physio::write(tables, index, &place, root)?);
        }
        let problems = check::problems(root)?;
        if problems.is_empty() {
            Ok(written)
        } else {
            Err(LabError::Failed(format!("the export would break BIDS: {}", problems.join("; "))))
        }
    })?;
    Ok(staging::moved(written, out))
}

/// Where a session's files go.
struct Place {
    /// `sub-XX/beh` or `sub-XX/ses-YY/beh`.
    folder: PathBuf,
    /// What all its files' names begin with: `sub-XX[_ses-YY]_task-ZZ`.
    stem: String,
    /// The task's label.
    task: String,
}

impl Place {
    fn new(labels: &Labels, with_sessions: bool) -> Self {
        let Labels { subject, session, task } = labels;
        let (folder, stem) = if with_sessions {
            (format!("sub-{subject}/ses-{session}/beh"), format!("sub-{subject}_ses-{session}_task-{task}"))
        } else {
            (format!("sub-{subject}/beh"), format!("sub-{subject}_task-{task}"))
        };
        Self { folder: PathBuf::from(folder), stem, task: task.clone() }
    }

    /// A file of the session by the end of its name.
    fn file(&self, end: &str) -> PathBuf {
        self.folder.join(format!("{}_{end}", self.stem))
    }
}
