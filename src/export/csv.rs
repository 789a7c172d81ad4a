//! Tidy CSV: trials, phases, forms, gaze, frames, thresholds and fits of any number of sessions, with `columns.json` to
//! describe them.
//!
//! Everything is written to a new folder beside the target first and moved there at the end, so that an export is whole
//! or not there.

use super::columns::{self, Column, TrialNames};
use crate::error::LabError;
use crate::results::ObserverResult;
use crate::session::{SessionFolder, names};
use csv::Writer;
use experiments::trial::form::Entry;
use experiments::trial::{Alternative, Answer, Outcome};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes the tables into `out`, a folder that must not exist or be empty. Returns the files and their numbers of rows.
///
/// # Errors
/// When `out` holds something already, or a file cannot be written.
pub fn export(
    sessions: &[SessionFolder],
    results: &[ObserverResult<'_>],
    out: &Path,
) -> Result<Vec<(PathBuf, usize)>, LabError> {
    let occupied = fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_some());
    if occupied || out.is_file() {
        return Err(LabError::BadInput(format!("--out {}: expected a new or empty folder", out.display())));
    }
    let partial = out.with_file_name(format!(
        ".{}.partial-{}",
        out.file_name().map_or_else(|| "export".into(), |name| name.to_string_lossy()),
        std::process::id()
    ));
    fs::create_dir_all(&partial).map_err(|error| LabError::io("make", &partial, &error))?;
    let written = write_tables(sessions, results, &partial).and_then(|rows| {
        if out.exists() {
            fs::remove_dir(out).map_err(|error| LabError::io("replace", out, &error))?;
        }
        fs::rename(&partial, out).map_err(|error| LabError::io("make", out, &error))?;
        Ok(rows)
    });
    if written.is_err() {
        // The error that is returned says what went wrong; a leftover folder is only untidy.
        let _ = fs::remove_dir_all(&partial);
    }
    Ok(written?.into_iter().map(|(name, rows)| (out.join(name), rows)).collect())
}

fn write_tables(
    sessions: &[SessionFolder],
    results: &[ObserverResult<'_>],
    folder: &Path,
) -> Result<Vec<(&'static str, usize)>, LabError> {
    let mut rows = Vec::new();
    let trial_names = TrialNames::of(sessions);
    let mut table =
        |name: &'static str, columns: &[Column], fill: &mut dyn FnMut(&mut Table) -> Result<(), LabError>| {
            let mut names: Vec<String> = columns.iter().map(|column| column.name.to_owned()).collect();
            if name == "trials.csv" {
                names.extend(trial_names.columns().into_iter().map(|column| column.name));
            }
            let mut table = Table::create(folder.join(name), &names)?;
            fill(&mut table)?;
            rows.push((name, table.finish()?));
            Ok::<(), LabError>(())
        };
    table("trials.csv", columns::TRIALS, &mut |table| trials(sessions, &trial_names, table))?;
    table("phases.csv", columns::PHASES, &mut |table| phases(sessions, table))?;
    table("forms.csv", columns::FORMS, &mut |table| forms(sessions, table))?;
    table("gaze.csv", columns::GAZE, &mut |table| copy(sessions, names::GAZE, table))?;
    table("frames.csv", columns::FRAMES, &mut |table| copy(sessions, names::FRAMES, table))?;
    table("thresholds.csv", columns::THRESHOLDS, &mut |table| thresholds(results, table))?;
    table("fits.csv", columns::FITS, &mut |table| fits(results, table))?;
    let path = folder.join("columns.json");
    let dictionary = serde_json::to_string_pretty(&columns::dictionary(&trial_names))
        .map_err(|error| LabError::Failed(error.to_string()))?;
    fs::write(&path, dictionary + "\n").map_err(|error| LabError::io("write", &path, &error))?;
    Ok(rows)
}

/// A CSV file being written.
struct Table {
    path: PathBuf,
    writer: Writer<fs::File>,
    columns: usize,
    rows: usize,
}

impl Table {
    fn create(path: PathBuf, columns: &[String]) -> Result<Self, LabError> {
        let file = fs::File::create_new(&path).map_err(|error| LabError::io("write", &path, &error))?;
        let mut table = Self { path, writer: Writer::from_writer(file), columns: columns.len(), rows: 0 };
        table.write(columns)?;
        Ok(table)
    }

    fn row<T: AsRef<[u8]>>(&mut self, cells: impl IntoIterator<Item = T>) -> Result<(), LabError> {
        self.rows += 1;
        self.write(cells)
    }

    fn write<T: AsRef<[u8]>>(&mut self, cells: impl IntoIterator<Item = T>) -> Result<(), LabError> {
        self.writer
            .write_record(cells)
            .map_err(|error| LabError::Failed(format!("cannot write {}: {error}", self.path.display())))
    }

    fn finish(mut self) -> Result<usize, LabError> {
        self.writer.flush().map_err(|error| LabError::io("write", &self.path, &error))?;
        Ok(self.rows)
    }
}

/// A unit variant of an enum as it is written to logs.
fn kebab(value: impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// An answer by its name, an option by its number.
fn answer_text(answer: Answer) -> String {
    match answer {
        Answer::Option(number) => number.to_string(),
        Answer::Typed(character) => character.to_string(),
        named => kebab(named),
    }
}

fn trials(sessions: &[SessionFolder], names: &TrialNames, table: &mut Table) -> Result<(), LabError> {
    let bit = |value: bool| u8::from(value).to_string();
    let real = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    for session in sessions {
        for record in &session.record.trials {
            let trial = &record.trial;
            let nothing = BTreeMap::new();
            let (outcome, reason, answer, found) = match &record.outcome {
                Outcome::Answered { answer, found, .. } => ("answered", String::new(), answer_text(*answer), found),
                Outcome::TimedOut => ("timed-out", String::new(), String::new(), &nothing),
                Outcome::Aborted { reason } => ("aborted", kebab(reason), String::new(), &nothing),
            };
            let fixed = [
                session.name(),
                session.header.observer.clone(),
                trial.trial.to_string(),
                trial.block.clone(),
                bit(trial.practice),
                trial.condition.clone(),
                real(trial.eccentricity_deg),
                real(trial.mar_deg),
                serde_json::json!(trial.level).to_string(),
                (if trial.order[0] == Alternative::Test { "1" } else { "2" }).to_owned(),
                outcome.to_owned(),
                reason,
                answer,
                record.correct().map_or_else(String::new, bit),
                real(record.response_time_s),
                record.began_s.to_string(),
                record.ended_s.to_string(),
                trial.repetition.map_or_else(String::new, |repetition| repetition.to_string()),
                record.part.to_string(),
            ];
            let factors = names.factors.iter().map(|name| trial.factors.get(name).cloned().unwrap_or_default());
            let levels = names.levels.iter().map(|name| real(trial.level.get(name).copied()));
            let found = names.found.iter().map(|name| real(found.get(name).copied()));
            table.row(fixed.into_iter().chain(factors).chain(levels).chain(found))?;
        }
    }
    Ok(())
}

fn phases(sessions: &[SessionFolder], table: &mut Table) -> Result<(), LabError> {
    for session in sessions {
        for record in &session.record.trials {
            for (index, phase) in record.phases.iter().enumerate() {
                let ended_s = record.phases.get(index + 1).map_or(record.ended_s, |next| next.began_s);
                table.row([
                    session.name(),
                    session.header.observer.clone(),
                    record.trial.trial.to_string(),
                    phase.phase.as_str().to_owned(),
                    phase.began_s.to_string(),
                    ended_s.to_string(),
                    phase.shown.map_or_else(String::new, kebab),
                    if phase.at.is_empty() { String::new() } else { serde_json::json!(phase.at).to_string() },
                ])?;
            }
        }
    }
    Ok(())
}

fn forms(sessions: &[SessionFolder], table: &mut Table) -> Result<(), LabError> {
    for session in sessions {
        for form in &session.record.forms {
            for (item, entry) in &form.entries {
                let entry = match entry {
                    Entry::Number(number) => number.to_string(),
                    Entry::Text(text) => text.clone(),
                };
                table.row([
                    session.name(),
                    session.header.observer.clone(),
                    form.form.clone(),
                    form.t_s.to_string(),
                    item.clone(),
                    entry,
                ])?;
            }
        }
    }
    Ok(())
}

/// Copies a session's own table row by row, with the session and observer in front; a torn last row is left out.
fn copy(sessions: &[SessionFolder], name: &str, table: &mut Table) -> Result<(), LabError> {
    for session in sessions {
        let path = session.path.join(name);
        let bytes =
            fs::read(&path).map_err(|error| LabError::BadInput(format!("cannot read {}: {error}", path.display())))?;
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        let (session_name, observer) = (session.name(), session.header.observer.as_str());
        for row in csv::Reader::from_reader(&bytes[..whole]).byte_records() {
            let row = row.map_err(|error| LabError::BadInput(format!("{}: {error}", path.display())))?;
            // Sessions of earlier versions lack the last columns; the exported table has them all.
            let missing = std::iter::repeat_n([].as_slice(), table.columns.saturating_sub(row.len() + 2));
            table.row([session_name.as_bytes(), observer.as_bytes()].into_iter().chain(row.iter()).chain(missing))?;
        }
    }
    Ok(())
}

fn thresholds(results: &[ObserverResult<'_>], table: &mut Table) -> Result<(), LabError> {
    for result in results {
        for threshold in result.fit.iter().flat_map(|fit| &fit.thresholds) {
            table.row([
                result.observer.clone(),
                threshold.eccentricity_deg.to_string(),
                threshold.mar_deg.to_string(),
                threshold.ci95[0].to_string(),
                threshold.ci95[1].to_string(),
                u8::from(threshold.limited).to_string(),
                threshold.trials.to_string(),
            ])?;
        }
    }
    Ok(())
}

fn fits(results: &[ObserverResult<'_>], table: &mut Table) -> Result<(), LabError> {
    for result in results {
        let Some(fit) = &result.fit else { continue };
        let supported = matches!(fit.support, analysis::mar::Support::Supported);
        for (quantity, estimate) in [("m", fit.m), ("omega0", fit.omega0), ("width", fit.width), ("lapse", fit.lapse)] {
            table.row([
                result.observer.clone(),
                quantity.to_owned(),
                estimate.estimate.to_string(),
                estimate.ci95[0].to_string(),
                estimate.ci95[1].to_string(),
                u8::from(quantity == "omega0" && fit.display_limited).to_string(),
                u8::from(supported).to_string(),
                fit.trials.to_string(),
            ])?;
        }
    }
    Ok(())
}
