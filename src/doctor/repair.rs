//! A repaired copy: what is sound of a session, in a folder of its own that can be analysed and gone on with.

use super::Severity;
use crate::error::LabError;
use crate::export::staging;
use crate::session::journal::line_from_event;
use crate::session::tables::{FrameRow, GazeRow, Layout, Row};
use crate::session::{SessionFolder, names};
use experiments::session::Stamped;
use experiments::session::event::{Event, Rows};
use std::fs;
use std::path::{Path, PathBuf};

/// Writes a copy of a session that ends where it is sound. The last event of its journal says what was left out. The
/// original stays as it is. Returns the copy's folder.
///
/// # Errors
/// When the header or the first event cannot be read, `to` exists, or it cannot be written.
pub fn repair(path: &Path, to: Option<&Path>) -> Result<PathBuf, LabError> {
    let session = SessionFolder::open(path)?;
    let to = to.map_or_else(|| beside(&session), Path::to_owned);
    if to.exists() {
        return Err(LabError::BadInput(format!("{}: expected a folder that does not exist yet", to.display())));
    }
    let (gaze, frames) = (session.gaze()?, session.frames()?);
    let kept = session.sound_frames(&frames.rows, gaze.rows.len());
    let rows = Rows { gaze_rows: gaze.rows.len() as u64, frame_rows: kept as u64 };
    let left_out: Vec<String> = super::examine(path)?
        .findings
        .into_iter()
        .filter(|finding| finding.severity == Severity::Damage || finding.what.contains("torn"))
        .map(|finding| finding.file.map_or_else(|| finding.what.clone(), |file| format!("{file}: {}", finding.what)))
        .collect();

    let read = |name: &str| {
        let file = path.join(name);
        fs::read(&file).map_err(|error| LabError::BadInput(format!("cannot read {}: {error}", file.display())))
    };
    let mut events = read(names::EVENTS)?;
    events.truncate(session.journal.sound_bytes);
    let last = session.journal.events.last();
    let mark = Stamped {
        seq: session.journal.events.len() as u64,
        t_s: last.map_or(0.0, |last| last.t_s),
        event: Event::Repaired { rows, left_out },
    };
    let mut chain = session.journal.chain;
    events.extend(line_from_event(&mark, &mut chain).into_bytes());

    let format = session.header.format;
    staging::whole(&to, |partial| {
        for (name, bytes) in [
            (names::HEADER, read(names::HEADER)?),
            (names::EVENTS, events),
            (names::GAZE, table::<GazeRow>(&gaze.rows, gaze.layout, format)),
            (names::FRAMES, table::<FrameRow>(&frames.rows[..kept], frames.layout, format)),
        ] {
            let file = partial.join(name);
            fs::write(&file, bytes)
                .and_then(|()| fs::File::open(&file)?.sync_all())
                .map_err(|error| LabError::io("write", &file, &error))?;
        }
        Ok(())
    })?;
    Ok(to)
}

fn beside(session: &SessionFolder) -> PathBuf {
    let name = format!("{}-repaired", session.name());
    session.path.canonicalize().unwrap_or_else(|_| session.path.clone()).with_file_name(name)
}

/// A table with these rows, in the layout of the original where that has one.
fn table<R: Row>(rows: &[R], layout: Option<Layout<R>>, format: u32) -> Vec<u8> {
    let (mut layout, first) = layout.map_or_else(|| Layout::new(format), |layout| layout.from_the_start(format));
    let mut text = first;
    for row in rows {
        text.push_str(&layout.line(row));
    }
    text.into_bytes()
}
