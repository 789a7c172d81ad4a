//! `_events.tsv`: trials, their phases, forms and the places where the session went on, in the order of their onsets; and
//! `_events.json`, which says what the columns are and what the display was.

use super::tsv::{cell, duration, line, number, plain};
use super::{Place, Written};
use crate::error::LabError;
use crate::export::cells::{Cell, Kind};
use crate::export::columns::{NamedColumn, PHASE_LEVELS, SESSION_CLOCK, TRIALS};
use crate::export::staging;
use crate::export::tables::{Tables, answer_text, entry_text, gaze_source, kebab, seams};
use crate::session::SessionFolder;
use experiments::session::Event;
use experiments::session::record::TrialRecord;
use experiments::trial::{Alternative, Outcome};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// The columns that a trial's row has from the trials table, by their names there.
const OF_TRIALS: [&str; 13] = [
    "trial",
    "block",
    "practice",
    "condition",
    "eccentricity_deg",
    "mar_deg",
    "test_interval",
    "outcome",
    "abort_reason",
    "answer",
    "correct",
    "repetition",
    "part",
];

/// What an event is, besides the phases of trials.
const EVENT_LEVELS: [(&str, &str); 4] = [
    ("trial", "a trial, from its beginning to its end; its phases follow as events of their own"),
    ("resumed", "the session went on here after an end or a kill"),
    ("form", "a form was complete; what was entered is the message"),
    ("log-gap", "the disk failed: what the message counts is in no file"),
];

/// One event.
struct Row {
    onset_s: f64,
    /// What comes first among events of one onset.
    rank: u8,
    duration_s: f64,
    trial_type: String,
    response_time_s: Option<f64>,
    /// Cells by the names of their columns; the others are `n/a`.
    cells: BTreeMap<String, String>,
}

impl Row {
    fn new(onset_s: f64, rank: u8, duration_s: f64, trial_type: &str) -> Self {
        let (trial_type, cells) = (trial_type.to_owned(), BTreeMap::new());
        Self { onset_s, rank, duration_s, trial_type, response_time_s: None, cells }
    }

    fn with<'a>(mut self, column: &str, value: impl Into<Cell<'a>>) -> Self {
        self.cells.insert(column.to_owned(), cell(&value.into()));
        self
    }
}

pub(super) fn write(tables: &Tables<'_>, index: usize, place: &Place, root: &Path) -> Result<Written, LabError> {
    let session = &tables.sessions[index];
    let mut rows: Vec<Row> = session.record.trials.iter().flat_map(of_trial).collect();
    rows.extend(of_forms(session));
    rows.extend(of_log(session));
    rows.sort_by(|a, b| a.onset_s.total_cmp(&b.onset_s).then(a.rank.cmp(&b.rank)));

    let extra = columns(tables);
    let mut names = vec!["onset", "duration", "trial_type", "response_time"];
    names.extend(extra.iter().map(|column| column.name.as_str()));
    let mut text = line(&names);
    for row in &rows {
        let mut cells = vec![
            number(row.onset_s),
            duration(row.duration_s),
            plain(&row.trial_type),
            row.response_time_s.map_or_else(|| "n/a".to_owned(), number),
        ];
        cells.extend(extra.iter().map(|column| row.cells.get(&column.name).map_or("n/a", String::as_str).to_owned()));
        text += &line(&cells);
    }
    let file = place.file("events.tsv");
    staging::text(&root.join(&file), &text)?;
    staging::json(&root.join(place.file("events.json")), &description(session, place, &rows, &extra))?;
    Ok(vec![(file, rows.len())])
}

/// A trial and its phases.
fn of_trial(record: &TrialRecord) -> Vec<Row> {
    let trial = &record.trial;
    let common = |row: Row| {
        let mut row = row
            .with("trial", trial.trial)
            .with("block", trial.block.as_str())
            .with("practice", trial.practice)
            .with("condition", trial.condition.as_str())
            .with("part", record.part);
        for (factor, level) in &trial.factors {
            row = row.with(&format!("factor_{factor}"), level.as_str());
        }
        row
    };
    let mut whole = common(Row::new(record.began_s, 1, record.ended_s - record.began_s, "trial"))
        .with("eccentricity_deg", trial.eccentricity_deg)
        .with("mar_deg", trial.mar_deg)
        .with("test_interval", if trial.order[0] == Alternative::Test { 1_u32 } else { 2 })
        .with("repetition", trial.repetition)
        .with("correct", record.correct());
    whole.response_time_s = record.response_time_s;
    whole = match &record.outcome {
        Outcome::Answered { answer, found, .. } => {
            let answered = whole.with("outcome", "answered").with("answer", answer_text(*answer));
            found.iter().fold(answered, |row, (name, value)| row.with(&format!("found_{name}"), *value))
        }
        Outcome::TimedOut => whole.with("outcome", "timed-out"),
        Outcome::Aborted { reason } => whole.with("outcome", "aborted").with("abort_reason", kebab(reason)),
    };
    for (name, value) in &trial.level {
        whole = whole.with(&format!("level_{name}"), *value);
    }

    let mut rows = vec![whole];
    for (index, phase) in record.phases.iter().enumerate() {
        let ended_s = record.phases.get(index + 1).map_or(record.ended_s, |next| next.began_s);
        let mut row = common(Row::new(phase.began_s, 2, ended_s - phase.began_s, phase.phase.as_str()))
            .with("shown", phase.shown.map(kebab));
        for (name, value) in &phase.at {
            row = row.with(&format!("level_{name}"), *value);
        }
        rows.push(row);
    }
    rows
}

fn of_forms(session: &SessionFolder) -> Vec<Row> {
    let entries = |form: &experiments::session::record::FormRecord| {
        let entries: Vec<String> =
            form.entries.iter().map(|(item, entry)| format!("{item} = {}", entry_text(entry))).collect();
        format!("{}: {}", form.form, entries.join("; "))
    };
    session.record.forms.iter().map(|form| Row::new(form.t_s, 3, 0.0, "form").with("message", entries(form))).collect()
}

/// What the log says of itself: where the session went on, and what could not be kept.
fn of_log(session: &SessionFolder) -> Vec<Row> {
    let resumed = seams(session).into_iter().map(|join| {
        let seam = join.seam;
        let mut words = vec![format!("part {}", join.part)];
        words.extend(seam.map(|seam| format!("on {} by {}", seam.wall, seam.program)));
        words.extend(seam.into_iter().flat_map(|seam| &seam.changed).map(|change| {
            let or_nothing = |text: &str| if text.is_empty() { "nothing".to_owned() } else { text.to_owned() };
            format!("changed {}: {} to {}", change.field, or_nothing(&change.from), or_nothing(&change.to))
        }));
        Row::new(join.t_s, 0, 0.0, "resumed").with("message", words.join("; ")).with("part", join.part)
    });
    let gaps = session.journal.events.iter().filter_map(|stamped| match &stamped.event {
        Event::Gap { gaze_samples, frames } => Some(
            Row::new(stamped.t_s, 0, 0.0, "log-gap")
                .with("message", format!("{gaze_samples} gaze samples and {frames} frames are not recorded")),
        ),
        _ => None,
    });
    resumed.chain(gaps).collect()
}

/// The columns after the first four.
fn columns(tables: &Tables<'_>) -> Vec<NamedColumn> {
    let own = |name: &str, meaning: &str, levels| NamedColumn {
        name: name.to_owned(),
        kind: Kind::Text,
        unit: "",
        meaning: meaning.to_owned(),
        reference: "",
        levels,
    };
    let of_trials = OF_TRIALS.iter().filter_map(|name| TRIALS.iter().find(|column| column.name == *name));
    let mut columns: Vec<NamedColumn> = of_trials.map(NamedColumn::from).collect();
    columns.push(own("shown", "picture that a phase showed", &[("reference", "the reference"), ("test", "the test")]));
    columns.extend(tables.trial_names.columns());
    // A phase may show other parameters than its trial's level: a slider's, a ramp's.
    let known: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    let shown = tables.sessions.iter().flat_map(|session| &session.record.trials).flat_map(|trial| &trial.phases);
    let mut others: Vec<&String> = shown.flat_map(|phase| phase.at.keys()).collect();
    others.sort();
    others.dedup();
    for name in others.into_iter().filter(|name| !known.contains(&format!("level_{name}"))) {
        let meaning = format!("the renderer parameter {name} as a phase showed it, in the parameter's own unit");
        columns.push(NamedColumn { kind: Kind::Real, ..own(&format!("level_{name}"), &meaning, &[]) });
    }
    columns.push(own("message", "what was entered, resumed or lost, in words", &[]));
    columns
}

/// A column as BIDS describes it.
fn described(column: &NamedColumn) -> Value {
    let mut entry = Map::new();
    let mut meaning = column.meaning.clone();
    if !column.reference.is_empty() {
        meaning += &format!("; measured on {}", column.reference);
    }
    entry.insert("Description".to_owned(), json!(meaning));
    if !column.unit.is_empty() {
        entry.insert("Units".to_owned(), json!(column.unit));
    }
    let levels: Map<String, Value> = match column.kind {
        Kind::Boolean => [("0", "no"), ("1", "yes")].iter().map(|(v, m)| ((*v).to_owned(), json!(m))).collect(),
        _ => column.levels.iter().map(|(value, meaning)| ((*value).to_owned(), json!(meaning))).collect(),
    };
    if !levels.is_empty() {
        entry.insert("Levels".to_owned(), Value::Object(levels));
    }
    Value::Object(entry)
}

fn description(session: &SessionFolder, place: &Place, rows: &[Row], extra: &[NamedColumn]) -> Value {
    let (header, display) = (&session.header, &session.display);
    let levels: Map<String, Value> = EVENT_LEVELS
        .iter()
        .chain(PHASE_LEVELS)
        .filter(|(level, _)| rows.iter().any(|row| row.trial_type == *level))
        .map(|(level, meaning)| ((*level).to_owned(), json!(meaning)))
        .collect();
    let mut description = json!({
        "TaskName": place.task,
        "TaskDescription": header.study.title,
        "Instructions": instructions(session),
        "onset": { "Description": format!("when it began; measured on {SESSION_CLOCK}"), "Units": "s" },
        "duration": { "Description": "how long it lasted; 0 for what has no duration", "Units": "s" },
        "trial_type": { "Description": "what happened: a trial, or the name of a phase of a trial", "Levels": levels },
        "response_time": { "Description": "from the question to the answer", "Units": "s" },
        "StimulusPresentation": {
            "OperatingSystem": header.program.host,
            "SoftwareName": header.program.name,
            "SoftwareVersion": header.program.version,
            "ScreenDistance": display.distance_mm() / 1000.0,
            "ScreenOrigin": ["top", "left"],
            "ScreenRefreshRate": display.refresh_hz(),
            "ScreenResolution": display.resolution_px(),
            "ScreenSize": display.size_mm().map(|mm| mm / 1000.0),
            "HeadStabilization": "not recorded",
        },
        "Study": { "Name": header.study.name, "SHA256": header.study.sha256, "Seed": header.seed.to_string() },
        "GazeSource": gaze_source(session),
        "GraphicsAdapter": header.stage.gpu.as_deref().unwrap_or("none: no pictures were drawn"),
    });
    for column in extra {
        description[&column.name] = described(column);
    }
    description
}

/// What observers were told before each block; the standard asks for `none` where there is nothing.
fn instructions(session: &SessionFolder) -> String {
    let study: Value = serde_json::from_str(&session.header.study.text).unwrap_or_default();
    let blocks = study["blocks"].as_array().map(Vec::as_slice).unwrap_or_default();
    let texts: Vec<String> = blocks
        .iter()
        .filter_map(|block| Some(format!("{}: {}", block["name"].as_str()?, block["instructions"].as_str()?)))
        .collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join("\n") }
}
