//! A new session's folder: made under a hidden name and given its own at the end, so that it is whole or not there.

use super::disk::{Disk, write_all};
use super::header::Header;
use super::journal::{Chain, line_from_event};
use super::names;
use super::tables::Layout;
use super::writer::Ends;
use crate::error::LabError;
use experiments::session::event::Rules;
use experiments::session::{Event, Stamped};
use std::io;
use std::path::{Path, PathBuf};

/// Makes `DATA/STUDY_OBSERVER_TIME` with its header, event 0 and empty tables.
pub(super) fn new_session(disk: &dyn Disk, data: &Path, header: &Header) -> Result<(PathBuf, Ends), LabError> {
    disk.make_folders(data).map_err(|error| LabError::io("make", data, &error))?;
    let stamp: String = header.started.chars().take(19).filter(|c| *c != ':').collect();
    let base = format!("{}_{}_{stamp}", header.study.name, header.observer);
    let (partial, folder) = new_folder(disk, data, &base)?;

    let mut chain = Chain::start(header.format);
    let rules = if header.format < 2 { Rules::First } else { Rules::NEWEST };
    let unwritable = |error: serde_json::Error| LabError::Failed(error.to_string());
    let header_sha256 = header.fingerprint().map_err(unwritable)?;
    let opened =
        line_from_event(&Stamped { seq: 0, t_s: 0.0, event: Event::Opened { header_sha256, rules } }, &mut chain);
    let (gaze, gaze_line) = Layout::new(header.format);
    let (frames, frame_line) = Layout::new(header.format);
    let ends = Ends {
        events: (opened.len() as u64, chain),
        gaze: (gaze_line.len() as u64, gaze),
        frames: (frame_line.len() as u64, frames),
    };
    let write = || -> io::Result<()> {
        let text = header.to_text()?;
        for (name, text) in
            [(names::HEADER, &text), (names::EVENTS, &opened), (names::GAZE, &gaze_line), (names::FRAMES, &frame_line)]
        {
            let mut file = disk.create(&partial.join(name))?;
            write_all(file.as_mut(), 0, text.as_bytes())?;
            file.sync()?;
        }
        disk.sync_folder(&partial)?;
        disk.rename(&partial, &folder)?;
        // Not every file system can sync a folder, and the session is there already.
        let _ = disk.sync_folder(data);
        Ok(())
    };
    match write() {
        Ok(()) => Ok((folder, ends)),
        Err(error) => {
            // The error that is returned says what went wrong; a leftover folder is only untidy.
            let _ = std::fs::remove_dir_all(&partial);
            Err(LabError::io("make", &folder, &error))
        }
    }
}

/// Takes a name that is not in use; a number is added if two sessions start in one second. Returns the hidden folder and
/// what it is to be called.
fn new_folder(disk: &dyn Disk, data: &Path, base: &str) -> Result<(PathBuf, PathBuf), LabError> {
    for attempt in 1..1000 {
        let name = if attempt == 1 { base.to_owned() } else { format!("{base}-{attempt}") };
        let (partial, folder) = (data.join(format!(".{name}.partial")), data.join(name));
        if folder.exists() {
            continue;
        }
        match disk.make_folder(&partial) {
            Ok(()) => return Ok((partial, folder)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(LabError::io("make", &partial, &error)),
        }
    }
    Err(LabError::Failed(format!("{}: a thousand sessions started at once", data.join(base).display())))
}
