//! The rows of one session's tables.

use crate::error::LabError;
use crate::export::cells::{Cell, Sink};
use crate::export::columns::TrialNames;
use crate::session::tables::{FrameRow, GazeRow, TableDamage};
use crate::session::{SessionFolder, names, tables};
use experiments::session::Event;
use experiments::session::event::Seam;
use experiments::trial::form::Entry;
use experiments::trial::{Alternative, Answer, Input, Outcome};
use std::collections::BTreeMap;
use std::path::Path;

/// One session, and where its rows go.
pub(super) struct OfSession<'a> {
    pub(super) session: &'a SessionFolder,
    pub(super) name: &'a str,
    pub(super) sink: &'a mut dyn Sink,
}

impl OfSession<'_> {
    fn row<const N: usize>(&mut self, cells: [Cell<'_>; N]) -> Result<(), LabError> {
        let [session, observer] = [self.name.into(), self.session.header.observer.as_str().into()];
        let row: Vec<Cell<'_>> = [session, observer].into_iter().chain(cells).collect();
        self.sink.row(&row)
    }

    pub(super) fn itself(&mut self) -> Result<(), LabError> {
        let SessionFolder { header, record, display, .. } = self.session;
        let fixation = self.session.fixation_deg();
        self.row([
            header.study.name.as_str().into(),
            header.study.title.as_str().into(),
            header.study.sha256.as_str().into(),
            header.started.as_str().into(),
            header.assignment.group.as_deref().into(),
            header.assignment.sitting.into(),
            header.assignment.pilot.into(),
            display.name().into(),
            display.resolution_px()[0].into(),
            display.resolution_px()[1].into(),
            display.size_mm()[0].into(),
            display.size_mm()[1].into(),
            display.distance_mm().into(),
            display.refresh_hz().into(),
            display.peak_cd_m2().into(),
            fixation[0].into(),
            fixation[1].into(),
            gaze_source(self.session).into(),
            header.simulated.as_ref().map(ToString::to_string).into(),
            header.stage.kind.as_str().into(),
            header.stage.rendered.into(),
            header.stage.frame_s.into(),
            header.stage.pacing.as_str().into(),
            header.stage.gpu.as_deref().into(),
            header.seed.to_string().into(),
            header.generator.as_str().into(),
            program(self.session).into(),
            header.program.host.as_str().into(),
            record.trials.len().into(),
            (record.reopened_s.len() + 1).into(),
            record.finished.into(),
            record.ended.map(kebab).into(),
            record.dropped[0].into(),
            record.dropped[1].into(),
        ])
    }

    pub(super) fn trials(&mut self, names: &TrialNames) -> Result<(), LabError> {
        let session = self.session;
        for record in &session.record.trials {
            let trial = &record.trial;
            let nothing = BTreeMap::new();
            let (outcome, reason, answer, found) = match &record.outcome {
                Outcome::Answered { answer, found, .. } => {
                    ("answered", Cell::Empty, answer_text(*answer).into(), found)
                }
                Outcome::TimedOut => ("timed-out", Cell::Empty, Cell::Empty, &nothing),
                Outcome::Aborted { reason } => ("aborted", kebab(reason).into(), Cell::Empty, &nothing),
            };
            let fixed: [Cell<'_>; 19] = [
                self.name.into(),
                session.header.observer.as_str().into(),
                trial.trial.into(),
                trial.block.as_str().into(),
                trial.practice.into(),
                trial.condition.as_str().into(),
                trial.eccentricity_deg.into(),
                trial.mar_deg.into(),
                serde_json::json!(trial.level).to_string().into(),
                Cell::Integer(if trial.order[0] == Alternative::Test { 1 } else { 2 }),
                outcome.into(),
                reason,
                answer,
                record.correct().into(),
                record.response_time_s.into(),
                record.began_s.into(),
                record.ended_s.into(),
                trial.repetition.into(),
                record.part.into(),
            ];
            let factors = names.factors.iter().map(|name| trial.factors.get(name).map(String::as_str).into());
            let levels = names.levels.iter().map(|name| trial.level.get(name).copied().into());
            let found = names.found.iter().map(|name| found.get(name).copied().into());
            let row: Vec<Cell<'_>> = fixed.into_iter().chain(factors).chain(levels).chain(found).collect();
            self.sink.row(&row)?;
        }
        Ok(())
    }

    pub(super) fn phases(&mut self) -> Result<(), LabError> {
        for record in &self.session.record.trials {
            for (index, phase) in record.phases.iter().enumerate() {
                let ended_s = record.phases.get(index + 1).map_or(record.ended_s, |next| next.began_s);
                let at = (!phase.at.is_empty()).then(|| serde_json::json!(phase.at).to_string());
                self.row([
                    record.trial.trial.into(),
                    phase.phase.as_str().into(),
                    phase.began_s.into(),
                    ended_s.into(),
                    phase.shown.map(kebab).into(),
                    at.into(),
                ])?;
            }
        }
        Ok(())
    }

    pub(super) fn forms(&mut self) -> Result<(), LabError> {
        for form in &self.session.record.forms {
            for (item, entry) in &form.entries {
                let entry = entry_text(entry);
                self.row([form.form.as_str().into(), form.t_s.into(), item.as_str().into(), entry.into()])?;
            }
        }
        Ok(())
    }

    pub(super) fn seams(&mut self) -> Result<(), LabError> {
        for seam in seams(self.session) {
            let changed = seam.seam.filter(|seam| !seam.changed.is_empty());
            self.row([
                seam.part.into(),
                seam.t_s.into(),
                seam.seam.map(|seam| seam.wall.as_str()).into(),
                seam.seam.map(|seam| seam.program.as_str()).into(),
                seam.seam.and_then(|seam| seam.gpu.as_deref()).into(),
                changed.map(|seam| serde_json::json!(seam.changed).to_string()).into(),
            ])?;
        }
        Ok(())
    }

    pub(super) fn gaze(&mut self) -> Result<(), LabError> {
        for row in gaze_rows(self.session)? {
            let eye = |eye: Option<crate::gaze::EyeSample>| {
                [
                    eye.map(|eye| eye.px[0]).into(),
                    eye.map(|eye| eye.px[1]).into(),
                    eye.map(|eye| eye.valid).into(),
                    eye.and_then(|eye| eye.pupil_mm).into(),
                ]
            };
            let [left_x, left_y, left_valid, left_pupil] = eye(row.left);
            let [right_x, right_y, right_valid, right_pupil] = eye(row.right);
            self.row([
                row.t_s.into(),
                row.arrived_s.into(),
                row.t_device_s.into(),
                row.x_px.into(),
                row.y_px.into(),
                row.x_deg.into(),
                row.y_deg.into(),
                row.valid.into(),
                row.pupil_mm.into(),
                left_x,
                left_y,
                left_valid,
                left_pupil,
                right_x,
                right_y,
                right_valid,
                right_pupil,
            ])?;
        }
        Ok(())
    }

    pub(super) fn frames(&mut self) -> Result<(), LabError> {
        for row in frame_rows(self.session)? {
            self.row([
                row.index.into(),
                row.phase_seq.into(),
                row.trial.into(),
                row.phase.as_str().into(),
                row.scheduled_s.into(),
                row.presented_s.into(),
                row.missed.into(),
                row.animation_s.into(),
                row.gaze_row.into(),
                row.gaze_age_s.into(),
                row.pixels_shaded.into(),
                row.gpu_time_s.into(),
                row.hash.as_deref().into(),
                row.target_x_deg.into(),
                row.target_y_deg.into(),
                row.signature.as_deref().into(),
            ])?;
        }
        Ok(())
    }
}

/// All gaze samples of a session. A torn last line is left out.
///
/// # Errors
/// When the table cannot be read or is damaged.
pub(in crate::export) fn gaze_rows(session: &SessionFolder) -> Result<Vec<GazeRow>, LabError> {
    sound(session.gaze()?, &session.path.join(names::GAZE))
}

/// All frames of a session. A torn last line is left out.
///
/// # Errors
/// When the table cannot be read or is damaged.
pub(in crate::export) fn frame_rows(session: &SessionFolder) -> Result<Vec<FrameRow>, LabError> {
    sound(session.frames()?, &session.path.join(names::FRAMES))
}

fn sound<T>(table: tables::Table<T>, path: &Path) -> Result<Vec<T>, LabError> {
    match table.damage {
        Some(damage @ (TableDamage::Corrupt(_) | TableDamage::Missing { .. })) => Err(LabError::BadInput(format!(
            "{}: {damage}. A damaged table is not handed on as if it were whole; doctor --repair writes a copy up to there.",
            path.display()
        ))),
        _ => Ok(table.rows),
    }
}

/// A place where a session went on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::export) struct Join<'a> {
    /// The part that begins, from 2.
    pub(in crate::export) part: usize,
    /// When, seconds.
    pub(in crate::export) t_s: f64,
    /// What the journal says of it; logs of format 1 say only when.
    pub(in crate::export) seam: Option<&'a Seam>,
}

/// The places where a session went on, in order. A mark and the input that follows it are one place.
pub(in crate::export) fn seams(session: &SessionFolder) -> Vec<Join<'_>> {
    let mut joins: Vec<Join<'_>> = Vec::new();
    let mut open = false;
    for stamped in &session.journal.events {
        match &stamped.event {
            Event::Continued(seam) => {
                // Nothing happened after a mark that another mark follows: it began no part of its own.
                if open {
                    joins.pop();
                }
                joins.push(Join { part: joins.len() + 2, t_s: stamped.t_s, seam: Some(seam) });
                open = true;
            }
            Event::Input { input: Input::Reopened, .. } => {
                if !open {
                    joins.push(Join { part: joins.len() + 2, t_s: stamped.t_s, seam: None });
                }
                open = false;
            }
            _ => {}
        }
    }
    joins
}

/// Where a session's gaze came from, in a word.
pub(in crate::export) fn gaze_source(session: &SessionFolder) -> &str {
    session.header.gaze_source.get("id").and_then(serde_json::Value::as_str).unwrap_or("")
}

/// The program that ran a session, with its version.
pub(in crate::export) fn program(session: &SessionFolder) -> String {
    format!("{} {}", session.header.program.name, session.header.program.version)
}

/// A unit variant of an enum as it is written to logs.
pub(in crate::export) fn kebab(value: impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// An answer by its name, an option by its number.
pub(in crate::export) fn answer_text(answer: Answer) -> String {
    match answer {
        Answer::Option(number) => number.to_string(),
        Answer::Typed(character) => character.to_string(),
        named => kebab(named),
    }
}

/// An entry as text.
pub(in crate::export) fn entry_text(entry: &Entry) -> String {
    match entry {
        Entry::Number(number) => number.to_string(),
        Entry::Text(text) => text.clone(),
    }
}
