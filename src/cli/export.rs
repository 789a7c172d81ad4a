//! `parafovea export`: sessions as files for other programs.

use super::{print, progress, say};
use crate::error::LabError;
use crate::export::tables::Tables;
use crate::export::{Written, bids, csv, find, parquet, psych_ds};
use crate::results::{ObserverResult, fit_sessions};
use crate::session::SessionFolder;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// Tidy CSV tables with a data dictionary.
    Csv,
    /// The same tables as Parquet, with typed columns.
    Parquet,
    /// A BIDS data set: events, and gaze as eye tracking (BIDS 1.11).
    Bids,
    /// A Psych-DS data set: the CSV tables by session, with their metadata (Psych-DS 1.5).
    PsychDs,
}

#[derive(Debug, Args)]
pub(super) struct ExportArgs {
    /// Session folders, or folders with sessions in them.
    #[arg(required = true, value_name = "SESSION|DATA")]
    sessions: Vec<PathBuf>,
    /// The format.
    #[arg(long, value_enum)]
    format: Format,
    /// A new or empty folder.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Take only sessions of this study.
    #[arg(long, value_name = "NAME")]
    study: Option<String>,
    /// Leave out sessions that cannot be read; without it, nothing is written if there is one.
    #[arg(long)]
    skip_unreadable: bool,
}

pub(super) fn run(args: &ExportArgs) -> Result<(), LabError> {
    let found = find::sessions(&args.sessions, args.study.as_deref())?;
    refuse_unreadable(&found, args.skip_unreadable)?;
    let sessions = found.sessions;
    sessions.iter().flat_map(SessionFolder::notices).for_each(|notice| say(&notice));

    let bar = progress::bar(2 * sessions.len() as u64, "tables");
    let progress = || bar.inc(1);
    // BIDS has the data alone; the tables of results belong to the others.
    let results = if matches!(args.format, Format::Bids) { Vec::new() } else { fits(&sessions) };
    let tables = Tables::new(&sessions, &results, &progress);
    let written: Result<Written, LabError> = match args.format {
        Format::Csv => csv::export_tables(&tables, &args.out),
        Format::Parquet => parquet::export(&tables, &args.out),
        Format::Bids => bids::export(&tables, &args.out),
        Format::PsychDs => psych_ds::export(&tables, &args.out),
    };
    bar.finish_and_clear();
    let lines: Vec<String> = written?.iter().map(|(path, rows)| format!("{} ({rows} rows)", path.display())).collect();
    print(&lines.join("\n"))
}

fn refuse_unreadable(found: &find::Found, skip: bool) -> Result<(), LabError> {
    let count = found.unreadable.len();
    let list = found.unreadable.join("\n");
    match (count, found.sessions.is_empty()) {
        (0, _) => Ok(()),
        (1, true) => Err(LabError::BadInput(list)),
        (_, true) => Err(LabError::BadInput(format!("{list}\nnone of the {count} sessions can be read"))),
        (_, false) if skip => {
            say(&format!("{list}\n{count} of {} sessions are left out", count + found.sessions.len()));
            Ok(())
        }
        (_, false) => Err(LabError::BadInput(format!(
            "{list}\n{count} of {} sessions cannot be read; give --skip-unreadable to export the others",
            count + found.sessions.len()
        ))),
    }
}

/// The fits of each observer in each study. Trials that cannot be fitted are exported all the same; the tables of fits have
/// no rows for them.
fn fits(sessions: &[SessionFolder]) -> Vec<ObserverResult<'_>> {
    let studies = sessions.chunk_by(|a, b| a.header.study.name == b.header.study.name);
    studies
        .flat_map(|of_study| {
            fit_sessions(of_study).unwrap_or_else(|error| {
                say(&format!("no fit of {}: {error}", of_study[0].header.study.name));
                Vec::new()
            })
        })
        .collect()
}
