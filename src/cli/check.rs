//! `parafovea check`: what a study will do, or everything that is wrong with it.

use super::{inputs, print, print_json};
use crate::error::LabError;
use clap::Args;
use experiments::study;

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    /// A study file, or the name of a study that ships.
    study: String,
    /// The display, by name or file; the study's own if not given.
    #[arg(long, value_name = "NAME|FILE")]
    display: Option<String>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &CheckArgs) -> Result<(), LabError> {
    let display = inputs::display(args.display.as_deref())?;
    let plan = inputs::plan(&inputs::study_file(&args.study)?, display.as_ref())?;
    let description = study::describe(&plan);
    if args.json { print_json(&description) } else { print(&description.to_string()) }
}
