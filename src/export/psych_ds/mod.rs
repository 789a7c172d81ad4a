//! Psych-DS 1.5.0: the CSV tables of each session under `data/`, and one `dataset_description.json` with every variable.
//!
//! The data are those of the CSV export, cell for cell; what differs is the names of files and that every row has a `row_id`.
//! [`check`] holds an export against the standard's rules before it is handed over.

pub mod check;
mod description;

use super::Written;
use super::cells::{Cell, Kind, Sink};
use super::columns::NamedColumn;
use super::csv::CsvTable;
use super::labels::labels;
use super::staging;
use super::tables::{Table, Tables};
use crate::error::LabError;
use description::Variables;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes the data set into `out`, a folder that must not exist or be empty. Returns the files and their numbers of rows.
///
/// # Errors
/// When `out` holds something already, two observers or studies would have one name, a session's table cannot be read, or a
/// file cannot be written.
pub fn export(tables: &Tables<'_>, out: &Path) -> Result<Written, LabError> {
    let labels = labels(tables.sessions)?;
    let written = staging::whole(out, |root| {
        let data = root.join("data");
        fs::create_dir_all(&data).map_err(|error| LabError::io("make", &data, &error))?;
        let mut written = Written::new();
        let mut variables = Variables::default();
        for table in Table::ALL {
            // One file for all sessions, where each has a row at most or none of its own; else one file a session.
            let whole = table == Table::Sessions || table.is_over_sessions();
            if whole {
                let name = format!("description-{}_data.csv", table.name());
                let mut sink = Numbered::new(root, name, table.columns(&tables.trial_names));
                tables.fill(table, &mut sink)?;
                sink.finish(table, &mut variables, &mut written)?;
                continue;
            }
            for (index, label) in labels.iter().enumerate() {
                let name = format!(
                    "study-{}_subject-{}_session-{}_description-{}_data.csv",
                    label.task,
                    label.subject,
                    label.session,
                    table.name()
                );
                let mut sink = Numbered::new(root, name, table.columns(&tables.trial_names));
                tables.fill_session(table, index, &mut sink)?;
                sink.finish(table, &mut variables, &mut written)?;
            }
        }
        staging::json(&root.join("dataset_description.json"), &description::description(tables, &variables))?;
        staging::text(&root.join("README.md"), &description::readme(tables))?;
        staging::text(&root.join("CHANGES.md"), &description::changes())?;
        let problems = check::problems(root)?;
        if problems.is_empty() {
            Ok(written)
        } else {
            Err(LabError::Failed(format!("the export would break Psych-DS: {}", problems.join("; "))))
        }
    })?;
    Ok(staging::moved(written, out))
}

/// A data file whose rows are numbered; it is made when its first row comes, since empty tables say nothing.
struct Numbered<'a> {
    root: &'a Path,
    file: PathBuf,
    columns: Vec<NamedColumn>,
    table: Option<CsvTable>,
    rows: usize,
}

/// The column that numbers rows.
fn row_id() -> NamedColumn {
    NamedColumn {
        name: "row_id".to_owned(),
        kind: Kind::Integer,
        unit: "",
        meaning: "number of the row within its file, from 1".to_owned(),
        reference: "",
        levels: &[],
    }
}

impl<'a> Numbered<'a> {
    fn new(root: &'a Path, name: String, columns: Vec<NamedColumn>) -> Self {
        let columns = std::iter::once(row_id()).chain(columns).collect();
        Self { root, file: Path::new("data").join(name), columns, table: None, rows: 0 }
    }

    fn finish(self, table: Table, variables: &mut Variables, written: &mut Written) -> Result<(), LabError> {
        if let Some(csv) = self.table {
            written.push((self.file, csv.finish()?));
            variables.add(table, &self.columns);
        }
        Ok(())
    }
}

impl Sink for Numbered<'_> {
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), LabError> {
        let table = match &mut self.table {
            Some(table) => table,
            None => {
                let names = self.columns.iter().map(|column| column.name.as_str());
                self.table.insert(CsvTable::create(self.root.join(&self.file), names)?)
            }
        };
        self.rows += 1;
        let row: Vec<Cell<'_>> = std::iter::once(Cell::from(self.rows)).chain(cells.iter().cloned()).collect();
        table.row(&row)
    }
}
