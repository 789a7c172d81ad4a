//! Tidy CSV: one file for each table of any number of sessions, and `columns.json` to describe them.

use super::Written;
use super::cells::{Cell, Sink};
use super::columns::dictionary;
use super::staging;
use super::tables::{Table, Tables};
use crate::error::LabError;
use crate::results::ObserverResult;
use crate::session::SessionFolder;
use ::csv::Writer;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes the tables into `out`, a folder that must not exist or be empty. Returns the files and their numbers of rows.
///
/// # Errors
/// When `out` holds something already, a session's table cannot be read, or a file cannot be written.
pub fn export(sessions: &[SessionFolder], results: &[ObserverResult<'_>], out: &Path) -> Result<Written, LabError> {
    export_tables(&Tables::new(sessions, results, &|| ()), out)
}

/// The same for tables that are gathered already.
///
/// # Errors
/// As [`export`].
pub fn export_tables(tables: &Tables<'_>, out: &Path) -> Result<Written, LabError> {
    let written = staging::whole(out, |folder| {
        let mut written = Written::new();
        for table in Table::ALL {
            let file = PathBuf::from(format!("{}.csv", table.name()));
            let columns = table.columns(&tables.trial_names);
            let mut sink = CsvTable::create(folder.join(&file), columns.iter().map(|column| column.name.as_str()))?;
            tables.fill(table, &mut sink)?;
            written.push((file, sink.finish()?));
        }
        staging::json(&folder.join("columns.json"), &dictionary(&tables.trial_names, "csv"))?;
        Ok(written)
    })?;
    Ok(staging::moved(written, out))
}

/// A CSV file being written.
#[derive(Debug)]
pub(super) struct CsvTable {
    path: PathBuf,
    writer: Writer<fs::File>,
    rows: usize,
}

impl CsvTable {
    /// Makes a new file with a header line.
    pub(super) fn create<'a>(path: PathBuf, columns: impl IntoIterator<Item = &'a str>) -> Result<Self, LabError> {
        let file = fs::File::create_new(&path).map_err(|error| LabError::io("write", &path, &error))?;
        let mut table = Self { path, writer: Writer::from_writer(file), rows: 0 };
        let written = table.writer.write_record(columns);
        table.check(written)?;
        Ok(table)
    }

    fn check(&self, written: Result<(), ::csv::Error>) -> Result<(), LabError> {
        written.map_err(|error| LabError::Failed(format!("cannot write {}: {error}", self.path.display())))
    }

    /// Ends the file and says how many rows it has.
    pub(super) fn finish(mut self) -> Result<usize, LabError> {
        self.writer.flush().map_err(|error| LabError::io("write", &self.path, &error))?;
        Ok(self.rows)
    }
}

impl Sink for CsvTable {
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), LabError> {
        self.rows += 1;
        let written = cells
            .iter()
            .try_for_each(|cell| self.writer.write_field(cell.text().as_bytes()))
            .and_then(|()| self.writer.write_record(None::<&[u8]>));
        self.check(written)
    }
}
