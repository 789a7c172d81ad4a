//! Opening a session's folder: after an orderly end, after a kill, or long afterwards on another machine.
//!
//! Every acknowledged event is recovered. A torn tail is left out and reported; it is cut from the file only when the
//! session goes on, and is kept beside it then.

use super::header::{FORMAT, Header, sha256_hex};
use super::journal::{self, Damage, Journal};
use super::names;
use super::tables::{self, FrameRow, GazeRow, Table, TableDamage};
use crate::error::LabError;
use experiments::Display;
use experiments::session::Event;
use experiments::session::record::Record;
use experiments::study::draft::StudyDraft;
use std::fs;
use std::path::{Path, PathBuf};

/// A session that was read back.
#[derive(Debug)]
pub struct SessionFolder {
    /// Where it is.
    pub path: PathBuf,
    /// Its header.
    pub header: Header,
    /// Its display, from the header.
    pub display: Display,
    /// Its study as written, for readers that need no plan and so no renderer; empty if it cannot be read any more.
    pub study: StudyDraft,
    /// Its journal, up to any damage.
    pub journal: Journal,
    /// The journal's trials.
    pub record: Record,
}

impl SessionFolder {
    /// Reads header and journal; gaze and frames are read when asked for, since they may be large.
    ///
    /// # Errors
    /// One message when the folder is not a session, its header cannot be used, or its journal holds no event.
    pub fn open(path: &Path) -> Result<Self, LabError> {
        if !path.is_dir() {
            return Err(LabError::BadInput(format!("{}: expected a session's folder", path.display())));
        }
        let header_path = path.join(names::HEADER);
        if !header_path.exists() {
            return Err(LabError::BadInput(format!(
                "{}: expected a session's folder, found none of its files ({} is missing)",
                path.display(),
                names::HEADER
            )));
        }
        let bytes = read(&header_path)?;
        let header: Header = serde_json::from_slice(&bytes).map_err(|error| {
            LabError::BadInput(format!(
                "{}:{}:{}: expected a session header: {error}",
                header_path.display(),
                error.line(),
                error.column()
            ))
        })?;
        if header.format != FORMAT {
            return Err(LabError::BadInput(format!(
                "{}: expected session format {FORMAT}, found {}; a newer program wrote it",
                header_path.display(),
                header.format
            )));
        }
        if sha256_hex(header.study.text.as_bytes()) != header.study.sha256 {
            return Err(LabError::BadInput(format!(
                "{}: study.text does not match study.sha256; the header was changed",
                header_path.display()
            )));
        }
        let display = header
            .display
            .display()
            .map_err(|problem| LabError::BadInput(format!("{}: display.{problem}", header_path.display())))?;
        let events_path = path.join(names::EVENTS);
        let journal = journal::read(&read(&events_path)?);
        if journal.events.is_empty() {
            let why = journal.damage.as_ref().map_or_else(|| "it is empty".to_owned(), ToString::to_string);
            return Err(LabError::BadInput(format!("{}: no event can be read: {why}", events_path.display())));
        }
        if let Some(Event::Opened { header_sha256 }) = journal.events.first().map(|first| &first.event)
            && header.fingerprint().is_ok_and(|fingerprint| fingerprint != *header_sha256)
        {
            return Err(LabError::BadInput(format!(
                "{}: expected the header that the journal was begun with, found a changed one",
                header_path.display()
            )));
        }
        let record = Record::from_events(&journal.events);
        let study = serde_json::from_str(&header.study.text).unwrap_or_default();
        Ok(Self { path: path.to_owned(), header, display, study, journal, record })
    }

    /// The folder's own name, without the path to it.
    #[must_use]
    pub fn name(&self) -> String {
        let whole = self.path.canonicalize().unwrap_or_else(|_| self.path.clone());
        whole.file_name().map_or_else(|| whole.display().to_string(), |name| name.to_string_lossy().into_owned())
    }

    /// Where the fixation mark stood, degrees; the display's centre if the study says nothing.
    #[must_use]
    pub fn fixation_deg(&self) -> [f64; 2] {
        self.study.gaze.as_ref().and_then(|gaze| gaze.fixation_deg).unwrap_or_default()
    }

    /// Every gaze sample, up to any damage.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn gaze(&self) -> Result<Table<GazeRow>, LabError> {
        Ok(tables::read_rows(&read(&self.path.join(names::GAZE))?))
    }

    /// Every frame, up to any damage.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn frames(&self) -> Result<Table<FrameRow>, LabError> {
        Ok(tables::read_rows(&read(&self.path.join(names::FRAMES))?))
    }

    /// What a reader should know about the session's state; nothing for a complete, sound one.
    #[must_use]
    pub fn notices(&self) -> Vec<String> {
        let mut notices = Vec::new();
        let path = self.path.display();
        if let Some(damage) = &self.journal.damage {
            notices.push(format!(
                "{path}/{}: {damage}. {} events before it are sound and are used.",
                names::EVENTS,
                self.journal.events.len()
            ));
        }
        if !self.record.is_over() {
            let open = self
                .record
                .open_trial
                .as_ref()
                .map_or_else(String::new, |trial| format!("; trial {} had begun and is left out", trial.trial));
            notices.push(format!("{path}: the session did not run to its end{open}."));
        }
        notices
    }

    /// Cuts torn tails from the session's files so that it can go on, and frames that rest on what was torn; what is cut
    /// is kept in files beside them.
    ///
    /// # Errors
    /// When the journal is corrupt (and not merely torn), or a file cannot be written.
    pub fn cut_torn_tails(&self) -> Result<(), LabError> {
        if let Some(damage @ Damage::Corrupt { .. }) = &self.journal.damage {
            return Err(LabError::BadInput(format!(
                "{}: {damage}. A corrupt session can be analysed up to there, but not go on.",
                self.path.join(names::EVENTS).display()
            )));
        }
        let (gaze, frames) = (self.gaze()?, self.frames()?);
        for (name, damage) in [(names::GAZE, &gaze.damage), (names::FRAMES, &frames.damage)] {
            if let Some(TableDamage::Corrupt(problem)) = damage {
                return Err(LabError::BadInput(format!(
                    "{}: {problem}. A corrupt session can be analysed up to there, but not go on.",
                    self.path.join(name).display()
                )));
            }
        }
        let frames = self.sound_frames(&frames.rows, gaze.rows.len());
        for name in [names::EVENTS, names::GAZE, names::FRAMES] {
            let path = self.path.join(name);
            let bytes = read(&path)?;
            let most_lines = if name == names::FRAMES { frames + 1 } else { usize::MAX };
            let sound: usize = bytes
                .split_inclusive(|&byte| byte == b'\n')
                .take(most_lines)
                .filter(|line| line.ends_with(b"\n"))
                .map(<[u8]>::len)
                .sum();
            if sound == bytes.len() {
                continue;
            }
            let kept = (1..)
                .map(|n| self.path.join(format!("{name}.torn-{n}")))
                .find(|candidate| !candidate.exists())
                .unwrap_or_else(|| self.path.join(format!("{name}.torn")));
            fs::write(&kept, &bytes[sound..]).map_err(|error| LabError::io("write", &kept, &error))?;
            fs::OpenOptions::new()
                .write(true)
                .open(&path)
                .and_then(|file| file.set_len(sound as u64).and_then(|()| file.sync_all()))
                .map_err(|error| LabError::io("cut", &path, &error))?;
        }
        Ok(())
    }

    /// How many frames, from the first, refer only to events and gaze samples that are there. The tables are not
    /// synced with each other within a trial, so a kill may leave frames whose phase or sample it took; their numbers
    /// will be given to others when the session goes on.
    fn sound_frames(&self, frames: &[FrameRow], gaze_rows: usize) -> usize {
        let (events, gaze_rows) = (self.journal.events.len() as u64, gaze_rows as u64);
        frames
            .iter()
            .position(|frame| frame.phase_seq >= events || frame.gaze_row.is_some_and(|row| row >= gaze_rows))
            .unwrap_or(frames.len())
    }
}

fn read(path: &Path) -> Result<Vec<u8>, LabError> {
    fs::read(path).map_err(|error| LabError::BadInput(format!("cannot read {}: {error}", path.display())))
}
