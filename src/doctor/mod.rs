//! What is wrong with a session, in plain words, and what of it can still be used.
//!
//! [`examine`] looks at everything that a session's files promise: seals, chain and counts, references from one file to
//! another, the order of time, and that the journal is what the study and the seed give. It changes nothing.
//! [`repair`](repair::repair) writes a copy that ends where the original is sound.

mod design;
mod files;
pub mod repair;
mod traces;

use crate::error::LabError;
use crate::session::SessionFolder;
use experiments::session::event::Event;
use experiments::trial::Outcome;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// How a session stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// Sound, and at its end.
    Complete,
    /// Sound, but ended or killed before its end: it can go on.
    Unfinished,
    /// Something was changed, lost or cannot be read: it can be used up to there.
    Damaged,
    /// Nothing of it can be used.
    Unusable,
}

impl State {
    /// For people.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Unfinished => "sound, not at its end",
            Self::Damaged => "damaged",
            Self::Unusable => "cannot be used",
        }
    }
}

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Good to know.
    Note,
    /// The data are as they were written, but look at them before you use them.
    Warning,
    /// The data are not as they were written.
    Damage,
}

/// One thing that was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// The file, where it concerns one.
    pub file: Option<String>,
    /// What it is, and what can still be used.
    pub what: String,
}

/// What there is.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Counts {
    /// Sound events of the journal.
    pub events: usize,
    /// Trials that ended.
    pub trials: usize,
    /// Of these, answered ones.
    pub answered: usize,
    /// Parts that the session was run in.
    pub parts: usize,
    /// Sound gaze samples.
    pub gaze_samples: usize,
    /// Their median rate, Hz.
    pub gaze_rate_hz: Option<f64>,
    /// Share of them in which the eye was not seen, 0–1.
    pub gaze_lost: Option<f64>,
    /// Places where gaze samples are missing.
    pub gaze_gaps: usize,
    /// Sound frames.
    pub frames: usize,
    /// Frames that came more than half a frame late.
    pub missed_frames: usize,
}

/// All that was found out about a session.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    /// The folder.
    pub session: PathBuf,
    /// How it stands.
    pub state: State,
    /// Format of the folder, where its header can be read.
    pub format: Option<u32>,
    /// The program that wrote it.
    pub program: Option<String>,
    /// The study's name.
    pub study: Option<String>,
    /// Who answered.
    pub observer: Option<String>,
    /// What there is.
    pub counts: Counts,
    /// What was found, the gravest first.
    pub findings: Vec<Finding>,
}

/// A list of findings that is being made.
#[derive(Debug, Default)]
struct Findings(Vec<Finding>);

impl Findings {
    fn add(&mut self, severity: Severity, file: Option<&str>, what: impl Into<String>) {
        self.0.push(Finding { severity, file: file.map(str::to_owned), what: what.into() });
    }

    fn damage(&mut self, file: &str, what: impl Into<String>) {
        self.add(Severity::Damage, Some(file), what);
    }

    fn warn(&mut self, file: &str, what: impl Into<String>) {
        self.add(Severity::Warning, Some(file), what);
    }

    fn note(&mut self, what: impl Into<String>) {
        self.add(Severity::Note, None, what);
    }
}

/// Looks at a session.
///
/// # Errors
/// When `path` is not a folder with any of a session's files.
pub fn examine(path: &Path) -> Result<Diagnosis, LabError> {
    files::is_a_session(path)?;
    let mut found = Findings::default();
    let mut diagnosis = Diagnosis {
        session: path.to_owned(),
        state: State::Unusable,
        format: None,
        program: None,
        study: None,
        observer: None,
        counts: Counts::default(),
        findings: Vec::new(),
    };
    match SessionFolder::open(path) {
        Ok(session) => diagnosis.state = look_at(&session, &mut diagnosis, &mut found),
        Err(error) => found.add(Severity::Damage, None, error.to_string()),
    }
    found.0.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    diagnosis.findings = found.0;
    Ok(diagnosis)
}

fn look_at(session: &SessionFolder, diagnosis: &mut Diagnosis, found: &mut Findings) -> State {
    let header = &session.header;
    diagnosis.format = Some(header.format);
    diagnosis.program = Some(format!("{} {}", header.program.name, header.program.version));
    diagnosis.study = Some(header.study.name.clone());
    diagnosis.observer = Some(header.observer.clone());
    let record = &session.record;
    diagnosis.counts = Counts {
        events: session.journal.events.len(),
        trials: record.trials.len(),
        answered: record.trials.iter().filter(|trial| matches!(trial.outcome, Outcome::Answered { .. })).count(),
        parts: record.reopened_s.len() + 1,
        ..Counts::default()
    };
    files::look_at(session, found);
    traces::look_at(session, &mut diagnosis.counts, found);
    design::look_at(session, found);
    how_it_ended(session, found);

    if found.0.iter().any(|finding| finding.severity == Severity::Damage) {
        State::Damaged
    } else if record.is_over() && (session.is_closed() || header.format < 2) {
        State::Complete
    } else {
        State::Unfinished
    }
}

/// Ends, seams and gaps: what the journal says of the run itself.
fn how_it_ended(session: &SessionFolder, found: &mut Findings) {
    let record = &session.record;
    if let Some(trial) = &record.open_trial {
        found.note(format!(
            "trial {} had begun and has no answer; it comes again when the session goes on",
            trial.trial
        ));
    }
    match (record.is_over(), session.is_closed()) {
        (true, true) => {}
        (true, false) if session.header.format < 2 => {}
        (true, false) => found.note("the program did not end in order after the last trial; every answer is there"),
        (false, true) => found.note("the session was left before its end; run --resume goes on with it"),
        (false, false) => {
            found.note("the program was killed, or is still running; run --resume goes on with the session");
        }
    }
    for (number, seam) in record.seams.iter().enumerate() {
        let changed = seam.seam.changed.iter().map(|change| change.field.as_str()).collect::<Vec<_>>();
        let changed =
            if changed.is_empty() { "nothing changed".to_owned() } else { format!("changed: {}", changed.join(", ")) };
        let what = format!(
            "part {} began at {:.3} s ({}, {}); {changed}",
            number + 2,
            seam.t_s,
            seam.seam.wall,
            seam.seam.program
        );
        found.add(if seam.seam.changed.is_empty() { Severity::Note } else { Severity::Warning }, None, what);
    }
    let [samples, frames] = record.dropped;
    if samples + frames > 0 {
        let what = format!("{samples} gaze samples and {frames} frames could not be kept while the disk failed");
        found.add(Severity::Warning, None, what);
    }
    for stamped in &session.journal.events {
        if let Event::Repaired { left_out, .. } = &stamped.event {
            found.add(Severity::Warning, None, format!("this is a repaired copy; left out: {}", left_out.join("; ")));
        }
    }
}
