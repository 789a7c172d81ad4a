//! The files themselves: whether they are there, whole, and agree with each other.

use super::{Findings, Severity};
use crate::error::LabError;
use crate::session::journal::Damage;
use crate::session::tables::TableDamage;
use crate::session::{SessionFolder, header, names};
use experiments::session::event::{Event, Rows};
use std::path::Path;

const FILES: [&str; 4] = [names::HEADER, names::EVENTS, names::GAZE, names::FRAMES];

/// Anything with one of the files may be a session.
pub(super) fn is_a_session(path: &Path) -> Result<(), LabError> {
    if FILES.iter().any(|name| path.join(name).is_file()) {
        return Ok(());
    }
    Err(LabError::BadInput(format!(
        "{}: expected a session's folder, found none of {}",
        path.display(),
        FILES.join(", ")
    )))
}

pub(super) fn look_at(session: &SessionFolder, found: &mut Findings) {
    let events = session.journal.events.len();
    match &session.journal.damage {
        Some(damage @ Damage::TornTail { .. }) => {
            found.add(
                Severity::Note,
                Some(names::EVENTS),
                format!("{damage}. All {events} events before it are sound."),
            );
        }
        Some(damage @ Damage::Corrupt { .. }) => found.damage(
            names::EVENTS,
            format!(
                "{damage}. {events} events before it are sound, and {} trials with them.",
                session.record.trials.len()
            ),
        ),
        None => {}
    }
    if let Some(pair) = session.journal.events.windows(2).find(|pair| pair[1].t_s < pair[0].t_s) {
        found.damage(names::EVENTS, format!("event {} is earlier than the one before it", pair[1].seq));
    }
    if session.header.format < header::FORMAT {
        found.note(format!(
            "format {} of an earlier version: changes to single rows of its tables cannot be found",
            session.header.format
        ));
    }
    leftovers(&session.path, found);
}

/// What a table's damage means; whether it is one that a kill explains.
pub(super) fn table(name: &str, damage: Option<&TableDamage>, rows: usize, marked: &Marked, found: &mut Findings) {
    match damage {
        Some(damage @ TableDamage::Torn(_)) if !marked.closed => {
            found.add(
                Severity::Note,
                Some(name),
                format!("{damage}, as after a kill. All {rows} rows before it are sound."),
            );
        }
        Some(damage) => found.damage(name, format!("{damage}. {rows} rows before it are sound.")),
        None if marked.closed && rows as u64 != marked.rows => found.damage(
            name,
            format!("expected the {} rows of the end of the session, found {rows}: rows were added later", marked.rows),
        ),
        None => {}
    }
}

/// What the journal says of a table.
pub(super) struct Marked {
    /// Whether nothing was written after that.
    pub(super) closed: bool,
    /// How many rows it had.
    pub(super) rows: u64,
}

/// What the journal says of both tables: gaze, frames.
pub(super) fn marked(session: &SessionFolder) -> [Marked; 2] {
    let last = session.journal.events.last().map(|last| &last.event);
    // A journal whose end is gone says nothing of how many rows there may be.
    let closed = session.journal.damage.is_none() && matches!(last, Some(Event::Closed(_) | Event::Repaired { .. }));
    let Rows { gaze_rows, frame_rows } = session.rows_on_disk();
    [gaze_rows, frame_rows].map(|rows| Marked { closed, rows })
}

fn leftovers(path: &Path, found: &mut Findings) {
    let entries = std::fs::read_dir(path).into_iter().flatten().filter_map(Result::ok);
    let mut others: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| !FILES.contains(&name.as_str()))
        .collect();
    others.sort();
    let (torn, strange): (Vec<String>, Vec<String>) = others.into_iter().partition(|name| name.contains(".torn"));
    if !torn.is_empty() {
        found.note(format!("torn ends of earlier kills are kept in {}", torn.join(", ")));
    }
    if !strange.is_empty() {
        found.note(format!("files that are not the session's: {}", strange.join(", ")));
    }
}
