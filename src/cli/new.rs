//! `parafovea new`: a study to start from.

use super::{print, say};
use crate::error::LabError;
use clap::Args;
use experiments::study;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct NewArgs {
    /// Name of the new study (a-z, 0-9 and -); it is written to NAME.json.
    name: String,
    /// The shipped study to copy.
    #[arg(long, default_value = "mar-calibration", value_name = "TEMPLATE")]
    from: String,
}

pub(super) fn run(args: &NewArgs) -> Result<(), LabError> {
    let template = study::shipped().iter().find(|shipped| shipped.name == args.from).ok_or_else(|| {
        let names: Vec<&str> = study::shipped().iter().map(|shipped| shipped.name).collect();
        LabError::BadInput(format!("--from {}: expected one of {}", args.from, names.join(", ")))
    })?;
    // What the study format takes for a name: words of letters and digits with one hyphen between two of them.
    let word = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    if !args.name.split('-').all(word) {
        return Err(LabError::BadInput(format!("\"{}\": expected a name of a-z, 0-9 and -", args.name)));
    }
    let text =
        template.json.replacen(&format!("\"name\": \"{}\"", template.name), &format!("\"name\": \"{}\"", args.name), 1);
    let path = PathBuf::from(format!("{}.json", args.name));
    fs::File::create_new(&path).and_then(|mut file| file.write_all(text.as_bytes())).map_err(|error| {
        match error.kind() {
            std::io::ErrorKind::AlreadyExists => {
                LabError::BadInput(format!("{} exists already and is left as it is", path.display()))
            }
            _ => LabError::io("write", &path, &error),
        }
    })?;
    // The schema goes beside the study, so that editors complete and check it as it is written.
    let schema = PathBuf::from("study.schema.json");
    if !schema.exists() {
        let schema_text = serde_json::to_string_pretty(&study::study_schema())
            .map_err(|error| LabError::Failed(error.to_string()))?;
        fs::write(&schema, schema_text + "\n").map_err(|error| LabError::io("write", &schema, &error))?;
    }
    say(&format!("next: edit {0}, then `parafovea check {0}`", path.display()));
    print(&path.display().to_string())
}
