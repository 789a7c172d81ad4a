//! Opening a session's folder: after an orderly end, after a kill, or long afterwards on another machine.
//!
//! Every acknowledged event is recovered. A torn tail is left out and reported; it is cut from the file only when the
//! session goes on, and is kept beside it then. A damaged session is read up to the damage.

use super::header::{DisplayRecord, Header, sha256_hex};
use super::journal::{self, Damage, Journal};
use super::names;
use super::tables::{self, FrameRow, GazeRow, Layout, Row, Table, TableDamage};
use super::writer::Ends;
use crate::error::LabError;
use experiments::Display;
use experiments::session::Event;
use experiments::session::event::Rows;
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
        let header = Header::from_text(&read(&header_path)?)
            .map_err(|problem| LabError::BadInput(format!("{}:{problem}", header_path.display())))?;
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
        let journal = journal::read(&read(&events_path)?, header.format);
        if journal.events.is_empty() {
            let why = journal.damage.as_ref().map_or_else(|| "it is empty".to_owned(), ToString::to_string);
            return Err(LabError::BadInput(format!("{}: no event can be read: {why}", events_path.display())));
        }
        if let Some(Event::Opened { header_sha256, .. }) = journal.events.first().map(|first| &first.event)
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

    /// The study's text as it was run last: the header's, unless the session went on with another one.
    #[must_use]
    pub fn study_text(&self) -> &str {
        self.record.seams.iter().rev().find_map(|seam| seam.seam.study.as_deref()).unwrap_or(&self.header.study.text)
    }

    /// The display as it was used last: the header's, unless the session went on with another one.
    ///
    /// # Errors
    /// When the journal names a display that is none.
    pub fn display_now(&self) -> Result<Display, LabError> {
        match self.record.seams.iter().rev().find_map(|seam| seam.seam.display.as_ref()) {
            None => Ok(self.display.clone()),
            Some(value) => DisplayRecord::from_value(value).map_err(|problem| {
                LabError::BadInput(format!("{}: {problem}", self.path.join(names::EVENTS).display()))
            }),
        }
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
        self.table(names::GAZE, self.rows_on_disk().gaze_rows)
    }

    /// Every frame, up to any damage.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn frames(&self) -> Result<Table<FrameRow>, LabError> {
        self.table(names::FRAMES, self.rows_on_disk().frame_rows)
    }

    fn table<R: Row>(&self, name: &str, on_disk: u64) -> Result<Table<R>, LabError> {
        let mut table = tables::read_rows(&read(&self.path.join(name))?, self.header.format);
        let found = table.rows.len() as u64;
        if found < on_disk && !matches!(table.damage, Some(TableDamage::Corrupt(_))) {
            table.damage = Some(TableDamage::Missing { expected: on_disk, found });
        }
        Ok(table)
    }

    /// How many rows the journal says were on disk with it.
    #[must_use]
    pub fn rows_on_disk(&self) -> Rows {
        let marks = self.journal.events.iter().rev().filter_map(|stamped| match stamped.event {
            Event::Tables(rows) | Event::Closed(rows) | Event::Repaired { rows, .. } => Some(rows),
            _ => None,
        });
        marks.into_iter().next().unwrap_or_default()
    }

    /// Whether the program that wrote the session ended in order, with the session finished or left; or whether this is a
    /// repaired copy, whose end is known too.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        matches!(self.journal.events.last().map(|last| &last.event), Some(Event::Closed(_) | Event::Repaired { .. }))
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
        let [samples, frames] = self.record.dropped;
        if samples + frames > 0 {
            notices.push(format!(
                "{path}: {samples} gaze samples and {frames} frames are missing: the disk failed for longer than they could \
                 be kept."
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

    /// Where the session's files are sound up to, for going on: without torn tails, and without frames that rest on what
    /// was torn. What is to be cut off is copied into files beside them first; the files themselves are left as they are.
    ///
    /// # Errors
    /// When journal or tables are corrupt (and not merely torn), or a copy cannot be written.
    pub fn ends(&self, gaze: &Table<GazeRow>, frames: &Table<FrameRow>) -> Result<Ends, LabError> {
        let refused = |name: &str, problem: String| {
            LabError::BadInput(format!(
                "{}: {problem}. A damaged session can be analysed up to there, but not go on; a copy that can is made by \
                 doctor --repair.",
                self.path.join(name).display()
            ))
        };
        if let Some(damage @ Damage::Corrupt { .. }) = &self.journal.damage {
            return Err(refused(names::EVENTS, damage.to_string()));
        }
        for (name, damage) in [(names::GAZE, &gaze.damage), (names::FRAMES, &frames.damage)] {
            if let Some(damage @ (TableDamage::Corrupt(_) | TableDamage::Missing { .. })) = damage {
                return Err(refused(name, damage.to_string()));
            }
        }
        let (Some(gaze_layout), Some(_)) = (gaze.layout, frames.layout) else {
            return Err(refused(names::GAZE, "the table has no first line".to_owned()));
        };
        let path = self.path.join(names::FRAMES);
        let (frames_bytes, frame_layout) = self.sound_frames_end(&read(&path)?, frames, gaze.rows.len())?;
        let ends = Ends {
            events: (self.journal.sound_bytes as u64, self.journal.chain),
            gaze: (gaze.sound_bytes as u64, gaze_layout),
            frames: (frames_bytes, frame_layout),
        };
        for (name, sound) in
            [(names::EVENTS, ends.events.0), (names::GAZE, ends.gaze.0), (names::FRAMES, ends.frames.0)]
        {
            self.keep_beside(name, sound)?;
        }
        Ok(ends)
    }

    /// Copies what comes after the first `sound` bytes of a file into a new file beside it.
    fn keep_beside(&self, name: &str, sound: u64) -> Result<(), LabError> {
        let bytes = read(&self.path.join(name))?;
        let rest = bytes.get(usize::try_from(sound).unwrap_or(usize::MAX)..).unwrap_or_default();
        if rest.is_empty() {
            return Ok(());
        }
        let kept = (1..)
            .map(|n| self.path.join(format!("{name}.torn-{n}")))
            .find(|candidate| !candidate.exists())
            .unwrap_or_else(|| self.path.join(format!("{name}.torn")));
        fs::write(&kept, rest).map_err(|error| LabError::io("write", &kept, &error))
    }

    /// Where the frames end that refer only to what is there, and how the table goes on after them.
    fn sound_frames_end(
        &self,
        bytes: &[u8],
        frames: &Table<FrameRow>,
        gaze_rows: usize,
    ) -> Result<(u64, Layout<FrameRow>), LabError> {
        let lines = self.sound_frames(&frames.rows, gaze_rows) + 1;
        let sound = bytes.split_inclusive(|&byte| byte == b'\n').take(lines).map(<[u8]>::len).sum::<usize>();
        let kept = tables::read_rows::<FrameRow>(bytes.get(..sound).unwrap_or_default(), self.header.format);
        let layout = kept.layout.ok_or_else(|| {
            LabError::BadInput(format!("{}: the table has no first line", self.path.join(names::FRAMES).display()))
        })?;
        Ok((kept.sound_bytes as u64, layout))
    }

    /// How many frames, from the first, refer only to events and gaze samples that are there. The tables are not
    /// synced with each other within a trial, so a kill may leave frames whose phase or sample it took; their numbers
    /// will be given to others when the session goes on.
    pub(crate) fn sound_frames(&self, frames: &[FrameRow], gaze_rows: usize) -> usize {
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
