//! The files at a data set's root: what it is, who took part, and when their sessions were.

use super::tsv::{line, plain};
use super::{BIDS_VERSION, Written};
use crate::error::LabError;
use crate::export::labels::{Labels, begun_utc};
use crate::export::staging;
use crate::export::tables::Tables;
use experiments::trial::form::Entry;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

pub(super) fn write(
    tables: &Tables<'_>,
    labels: &[Labels],
    with_sessions: bool,
    root: &Path,
) -> Result<Written, LabError> {
    let studies: BTreeSet<(&str, &str)> = tables
        .sessions
        .iter()
        .map(|session| (session.header.study.name.as_str(), session.header.study.title.as_str()))
        .collect();
    let names: Vec<&str> = studies.iter().map(|(name, _)| *name).collect();
    staging::json(
        &root.join("dataset_description.json"),
        &json!({
            "Name": names.join(", "),
            "BIDSVersion": BIDS_VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [{ "Name": "Parafovea", "Version": env!("CARGO_PKG_VERSION"),
                "Description": "Exported from the sessions' own logs" }],
        }),
    )?;
    staging::text(&root.join("README.md"), &readme(&studies))?;
    let mut written = vec![participants(tables, labels, root)?];
    if with_sessions {
        written.extend(sessions(tables, labels, root)?);
    }
    Ok(written)
}

fn readme(studies: &BTreeSet<(&str, &str)>) -> String {
    let mut text = "# Gaze-contingent psychophysics, run with Parafovea\n\n".to_owned();
    for (name, title) in studies {
        text += &format!("- {name}: {title}\n");
    }
    text += "\nWhat happened is in `_events.tsv`: trials with their answers, the phases of every trial, forms that were filled \
             in, and the places where a session was resumed. Gaze is in `_physio.tsv.gz`, one file an eye; the one whose \
             `RecordedEye` is `cyclopean` is the gaze that placed the stimuli. Saccades, fixations and losses are in \
             `_physioevents.tsv.gz`.\n\n\
             All onsets, timestamps and durations are seconds on the session's clock, 0 at the session's start. Places of gaze \
             are pixels of the display, origin at its top left corner, x to the right, y down. The display's size, resolution \
             and distance are in `_events.json`.\n\n\
             Authors, licence, ethics approval and funding are not known to the program: please add them to \
             `dataset_description.json` before sharing.\n";
    text
}

/// One row for each observer.
fn participants(tables: &Tables<'_>, labels: &[Labels], root: &Path) -> Result<(PathBuf, usize), LabError> {
    // The first session of an observer that knows something says it.
    let mut rows: BTreeMap<&str, Participant> = BTreeMap::new();
    for (session, label) in tables.sessions.iter().zip(labels) {
        let row = rows
            .entry(&label.subject)
            .or_insert_with(|| Participant { observer: session.header.observer.clone(), ..Participant::default() });
        row.simulated |= session.header.simulated.is_some();
        row.group = row.group.take().or_else(|| session.header.assignment.group.clone());
        let entries = session.record.forms.iter().filter(|form| form.form == "participant");
        for entry in entries.filter_map(|form| form.entries.get("age")) {
            match entry {
                Entry::Number(age) if row.age.is_none() => row.age = Some(*age),
                _ => {}
            }
        }
    }
    let has_age = rows.values().any(|row| row.age.is_some());
    let has_group = rows.values().any(|row| row.group.is_some());

    let mut description = json!({
        "participant_id": { "Description": "observer, by the letters and digits of the code" },
        "species": { "Description": "species of the observer; n/a for a simulated one" },
        "observer": { "Description": "the observer's code in the laboratory's own files" },
        "simulated": {
            "Description": "whether the answers are a simulation's",
            "Levels": { "0": "a person answered", "1": "a simulated observer answered" },
        },
    });
    let mut columns = vec!["participant_id", "species", "observer", "simulated"];
    if has_age {
        columns.push("age");
        description["age"] = json!({ "Description": "age as entered", "Units": "year" });
    }
    if has_group {
        columns.push("group");
        description["group"] = json!({ "Description": "group of a between-subject design" });
    }
    let mut text = line(&columns);
    for (subject, row) in &rows {
        let species = if row.simulated { "n/a" } else { "homo sapiens" };
        let mut cells = vec![
            format!("sub-{subject}"),
            species.to_owned(),
            plain(&row.observer),
            u8::from(row.simulated).to_string(),
        ];
        if has_age {
            cells.push(row.age.map_or_else(|| "n/a".to_owned(), |age| age.to_string()));
        }
        if has_group {
            cells.push(plain(row.group.as_deref().unwrap_or_default()));
        }
        text += &line(&cells);
    }
    staging::text(&root.join("participants.tsv"), &text)?;
    staging::json(&root.join("participants.json"), &description)?;
    Ok((PathBuf::from("participants.tsv"), rows.len()))
}

#[derive(Debug, Default)]
struct Participant {
    observer: String,
    simulated: bool,
    group: Option<String>,
    age: Option<f64>,
}

/// `sub-XX_sessions.tsv`, one row for each session of an observer.
fn sessions(tables: &Tables<'_>, labels: &[Labels], root: &Path) -> Result<Written, LabError> {
    let mut of_subject: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
    for (index, label) in labels.iter().enumerate() {
        of_subject.entry(&label.subject).or_default().insert(&label.session, index);
    }
    let description = json!({
        "session_id": { "Description": "number of the session, in the order in which the observer's sessions were begun" },
        "acq_time": { "Description": "wall-clock time of the session's start, UTC" },
        "study": { "Description": "name of the study" },
        "source": { "Description": "name of the session's folder in the laboratory's own files" },
        "parts": { "Description": "parts it was run in: 1, and one more for each time it was gone on with" },
        "finished": {
            "Description": "whether it ran to its end",
            "Levels": { "0": "it did not", "1": "it did" },
        },
    });
    let mut written = Written::new();
    for (subject, sessions) in of_subject {
        let mut text = line(&["session_id", "acq_time", "study", "source", "parts", "finished"]);
        for (session_label, &index) in &sessions {
            let session = &tables.sessions[index];
            let begun = begun_utc(session).map(|time| time.format("%Y-%m-%dT%H:%M:%SZ").to_string());
            text += &line(&[
                format!("ses-{session_label}"),
                begun.unwrap_or_else(|| "n/a".to_owned()),
                plain(&session.header.study.name),
                plain(&tables.session_names[index]),
                (session.record.reopened_s.len() + 1).to_string(),
                u8::from(session.record.finished).to_string(),
            ]);
        }
        let file = PathBuf::from(format!("sub-{subject}/sub-{subject}_sessions.tsv"));
        staging::text(&root.join(&file), &text)?;
        staging::json(&root.join(file.with_extension("json")), &description)?;
        written.push((file, sessions.len()));
    }
    Ok(written)
}
