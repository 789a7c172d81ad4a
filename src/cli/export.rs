//! `parafovea export`: sessions as tables for other programs.

use super::{print, say};
use crate::error::LabError;
use crate::results::fit_sessions;
use crate::session::SessionFolder;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// Tidy CSV tables with a data dictionary.
    Csv,
}

#[derive(Debug, Args)]
pub(super) struct ExportArgs {
    /// Session folders.
    #[arg(required = true)]
    sessions: Vec<PathBuf>,
    /// The format.
    #[arg(long, value_enum)]
    format: Format,
    /// A new or empty folder.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn run(args: &ExportArgs) -> Result<(), LabError> {
    let sessions: Vec<SessionFolder> =
        args.sessions.iter().map(|path| SessionFolder::open(path)).collect::<Result<_, _>>()?;
    sessions.iter().flat_map(SessionFolder::notices).for_each(|notice| say(&notice));
    // Trials that cannot be fitted are exported all the same; the tables of fits stay empty then.
    let results = fit_sessions(&sessions).unwrap_or_else(|error| {
        say(&format!("no fit: {error}"));
        Vec::new()
    });
    let written = match args.format {
        Format::Csv => crate::export::csv::export(&sessions, &results, &args.out)?,
    };
    let lines: Vec<String> = written.iter().map(|(path, rows)| format!("{} ({rows} rows)", path.display())).collect();
    print(&lines.join("\n"))
}
