//! Finding the sessions that are to be exported: folders of sessions, or data folders with many of them.

use crate::error::LabError;
use crate::session::{SessionFolder, names};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Sessions that were found, in the order of their studies and within a study in the order given.
#[derive(Debug)]
pub struct Found {
    /// Those that can be read.
    pub sessions: Vec<SessionFolder>,
    /// Why others cannot, one message each.
    pub unreadable: Vec<String>,
}

/// Opens every session that `paths` name: each is a session's folder, or a folder with sessions in it. With `study` only
/// sessions of that study are taken.
///
/// # Errors
/// When a path is no folder, or no session at all is found.
pub fn sessions(paths: &[PathBuf], study: Option<&str>) -> Result<Found, LabError> {
    let mut found = Found { sessions: Vec::new(), unreadable: Vec::new() };
    let mut seen = BTreeSet::new();
    for path in paths {
        for folder in session_folders(path)? {
            // A session that is named twice is one session.
            if !seen.insert(folder.canonicalize().unwrap_or_else(|_| folder.clone())) {
                continue;
            }
            match SessionFolder::open(&folder) {
                Ok(session) => found.sessions.push(session),
                Err(error) => found.unreadable.push(error.to_string()),
            }
        }
    }
    let readable = found.sessions.len();
    if let Some(study) = study {
        let known: BTreeSet<String> = found.sessions.iter().map(|session| session.header.study.name.clone()).collect();
        found.sessions.retain(|session| session.header.study.name == study);
        if found.sessions.is_empty() && readable > 0 {
            let known: Vec<String> = known.into_iter().collect();
            return Err(LabError::BadInput(format!(
                "--study {study}: none of the {readable} sessions is of this study; there are {}",
                known.join(", ")
            )));
        }
    }
    found.sessions.sort_by(|a, b| a.header.study.name.cmp(&b.header.study.name));
    Ok(found)
}

/// The session folders that one path names: itself, or those in it, by name.
fn session_folders(path: &Path) -> Result<Vec<PathBuf>, LabError> {
    if path.join(names::HEADER).exists() || !path.is_dir() {
        // What is no folder is said by whoever opens it.
        return Ok(vec![path.to_owned()]);
    }
    let entries = fs::read_dir(path)
        .and_then(Iterator::collect::<Result<Vec<_>, _>>)
        .map_err(|error| LabError::BadInput(format!("cannot read {}: {error}", path.display())))?;
    let mut folders: Vec<PathBuf> =
        entries.into_iter().map(|entry| entry.path()).filter(|folder| is_session(folder)).collect();
    folders.sort();
    if folders.is_empty() {
        return Err(LabError::BadInput(format!(
            "{}: expected a session's folder or a folder with sessions in it, found neither ({} is nowhere)",
            path.display(),
            names::HEADER
        )));
    }
    Ok(folders)
}

/// Whether a folder is, or was, a session: one without its header is reported and not passed over.
fn is_session(folder: &Path) -> bool {
    folder.is_dir() && [names::HEADER, names::EVENTS].iter().any(|name| folder.join(name).exists())
}
