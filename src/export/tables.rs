//! What every table holds, row by row, as typed cells: the one definition from which all formats are written.
//!
//! Tables of a session are filled one session at a time, so that the gaze of only one is in memory.

use super::cells::{Cell, Sink};
use super::columns::{self, Column, NamedColumn, TrialNames};
use crate::error::LabError;
use crate::results::ObserverResult;
use crate::session::tables::{FrameRow, GazeRow, TableDamage};
use crate::session::{SessionFolder, names, tables};
use experiments::session::Event;
use experiments::session::event::Seam;
use experiments::trial::form::Entry;
use experiments::trial::{Alternative, Answer, Input, Outcome};
use std::collections::BTreeMap;
use std::path::Path;

/// A table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Table {
    /// Sessions.
    Sessions,
    /// Trials.
    Trials,
    /// Phases of trials.
    Phases,
    /// Entries of forms.
    Forms,
    /// Places where sessions went on.
    Seams,
    /// Gaze samples.
    Gaze,
    /// Frames.
    Frames,
    /// Thresholds by eccentricity.
    Thresholds,
    /// Fits of the MAR line.
    Fits,
}

impl Table {
    /// Every table.
    pub const ALL: [Self; 9] = [
        Self::Sessions,
        Self::Trials,
        Self::Phases,
        Self::Forms,
        Self::Seams,
        Self::Gaze,
        Self::Frames,
        Self::Thresholds,
        Self::Fits,
    ];

    /// Its name: that of its file without the extension.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sessions => "sessions",
            Self::Trials => "trials",
            Self::Phases => "phases",
            Self::Forms => "forms",
            Self::Seams => "seams",
            Self::Gaze => "gaze",
            Self::Frames => "frames",
            Self::Thresholds => "thresholds",
            Self::Fits => "fits",
        }
    }

    /// The columns that it has whatever the data.
    #[must_use]
    pub fn fixed(self) -> &'static [Column] {
        match self {
            Self::Sessions => columns::SESSIONS,
            Self::Trials => columns::TRIALS,
            Self::Phases => columns::PHASES,
            Self::Forms => columns::FORMS,
            Self::Seams => columns::SEAMS,
            Self::Gaze => columns::GAZE,
            Self::Frames => columns::FRAMES,
            Self::Thresholds => columns::THRESHOLDS,
            Self::Fits => columns::FITS,
        }
    }

    /// All its columns, where trials brought these names with them.
    #[must_use]
    pub fn columns(self, names: &TrialNames) -> Vec<NamedColumn> {
        let own = if self == Self::Trials { names.columns() } else { Vec::new() };
        self.fixed().iter().map(NamedColumn::from).chain(own).collect()
    }

    /// Whether its rows come from results over sessions, and not from one session each.
    #[must_use]
    pub fn is_over_sessions(self) -> bool {
        matches!(self, Self::Thresholds | Self::Fits)
    }

    /// Whether it is long enough for its rows to be worth a step of progress.
    #[must_use]
    pub fn is_long(self) -> bool {
        matches!(self, Self::Gaze | Self::Frames)
    }
}

/// Sessions and results that are being exported.
pub struct Tables<'a> {
    /// The sessions.
    pub sessions: &'a [SessionFolder],
    /// What they came to, by study and observer.
    pub results: &'a [ObserverResult<'a>],
    /// The names that their trials brought with them.
    pub trial_names: TrialNames,
    /// A name for each session that no other has.
    pub session_names: Vec<String>,
    /// Called after each long table of each session.
    pub progress: &'a dyn Fn(),
}

impl<'a> Tables<'a> {
    /// Gathers what is common to all tables.
    #[must_use]
    pub fn new(sessions: &'a [SessionFolder], results: &'a [ObserverResult<'a>], progress: &'a dyn Fn()) -> Self {
        let mut seen: BTreeMap<String, u32> = BTreeMap::new();
        let session_names = sessions
            .iter()
            .map(|session| {
                let name = session.name();
                let times = seen.entry(name.clone()).or_default();
                *times += 1;
                if *times == 1 { name } else { format!("{name}_{times}") }
            })
            .collect();
        Self { sessions, results, trial_names: TrialNames::of(sessions), session_names, progress }
    }

    /// Puts all rows of a table into a sink.
    ///
    /// # Errors
    /// When a session's table cannot be read, or the sink fails.
    pub fn fill(&self, table: Table, sink: &mut dyn Sink) -> Result<(), LabError> {
        match table {
            Table::Thresholds => self.thresholds(sink),
            Table::Fits => self.fits(sink),
            _ => (0..self.sessions.len()).try_for_each(|index| self.fill_session(table, index, sink)),
        }
    }

    /// Puts one session's rows of a table into a sink; none of a table over sessions.
    ///
    /// # Errors
    /// When the session's table cannot be read, or the sink fails.
    pub fn fill_session(&self, table: Table, index: usize, sink: &mut dyn Sink) -> Result<(), LabError> {
        let session = &self.sessions[index];
        let mut of_session = OfSession { session, name: &self.session_names[index], sink };
        match table {
            Table::Sessions => of_session.itself(),
            Table::Trials => of_session.trials(&self.trial_names),
            Table::Phases => of_session.phases(),
            Table::Forms => of_session.forms(),
            Table::Seams => of_session.seams(),
            Table::Gaze => of_session.gaze(),
            Table::Frames => of_session.frames(),
            Table::Thresholds | Table::Fits => Ok(()),
        }?;
        if table.is_long() {
            (self.progress)();
        }
        Ok(())
    }

    fn thresholds(&self, sink: &mut dyn Sink) -> Result<(), LabError> {
        for result in self.results {
            for threshold in result.fit.iter().flat_map(|fit| &fit.thresholds) {
                sink.row(&[
                    study_of(result).into(),
                    result.observer.as_str().into(),
                    threshold.eccentricity_deg.into(),
                    threshold.mar_deg.into(),
                    threshold.ci95[0].into(),
                    threshold.ci95[1].into(),
                    threshold.limited.into(),
                    threshold.finest_mar_deg.into(),
                    threshold.trials.into(),
                ])?;
            }
        }
        Ok(())
    }

    fn fits(&self, sink: &mut dyn Sink) -> Result<(), LabError> {
        for result in self.results {
            let Some(fit) = &result.fit else { continue };
            let supported = matches!(fit.support, analysis::mar::Support::Supported);
            for (quantity, estimate) in
                [("m", fit.m), ("omega0", fit.omega0), ("width", fit.width), ("lapse", fit.lapse)]
            {
                sink.row(&[
                    study_of(result).into(),
                    result.observer.as_str().into(),
                    quantity.into(),
                    estimate.estimate.into(),
                    estimate.ci95[0].into(),
                    estimate.ci95[1].into(),
                    (quantity == "omega0" && fit.display_limited).into(),
                    supported.into(),
                    fit.trials.into(),
                ])?;
            }
        }
        Ok(())
    }
}

fn study_of<'a>(result: &'a ObserverResult<'_>) -> &'a str {
    result.sessions.first().map_or("", |session| session.header.study.name.as_str())
}

/// One session, and where its rows go.
struct OfSession<'a> {
    session: &'a SessionFolder,
    name: &'a str,
    sink: &'a mut dyn Sink,
}

impl OfSession<'_> {
    fn row<const N: usize>(&mut self, cells: [Cell<'_>; N]) -> Result<(), LabError> {
        let [session, observer] = [self.name.into(), self.session.header.observer.as_str().into()];
        let row: Vec<Cell<'_>> = [session, observer].into_iter().chain(cells).collect();
        self.sink.row(&row)
    }

    fn itself(&mut self) -> Result<(), LabError> {
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

    fn trials(&mut self, names: &TrialNames) -> Result<(), LabError> {
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

    fn phases(&mut self) -> Result<(), LabError> {
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

    fn forms(&mut self) -> Result<(), LabError> {
        for form in &self.session.record.forms {
            for (item, entry) in &form.entries {
                let entry = entry_text(entry);
                self.row([form.form.as_str().into(), form.t_s.into(), item.as_str().into(), entry.into()])?;
            }
        }
        Ok(())
    }

    fn seams(&mut self) -> Result<(), LabError> {
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

    fn gaze(&mut self) -> Result<(), LabError> {
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

    fn frames(&mut self) -> Result<(), LabError> {
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
/// When the table cannot be read or is corrupt.
pub(super) fn gaze_rows(session: &SessionFolder) -> Result<Vec<GazeRow>, LabError> {
    sound(session.gaze()?, &session.path.join(names::GAZE))
}

/// All frames of a session. A torn last line is left out.
///
/// # Errors
/// When the table cannot be read or is corrupt.
pub(super) fn frame_rows(session: &SessionFolder) -> Result<Vec<FrameRow>, LabError> {
    sound(session.frames()?, &session.path.join(names::FRAMES))
}

fn sound<T>(table: tables::Table<T>, path: &Path) -> Result<Vec<T>, LabError> {
    match table.damage {
        Some(TableDamage::Corrupt(problem)) => Err(LabError::BadInput(format!(
            "{}: {problem}. A table with a hole in it is not handed on as if it were whole.",
            path.display()
        ))),
        _ => Ok(table.rows),
    }
}

/// A place where a session went on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Join<'a> {
    /// The part that begins, from 2.
    pub(super) part: usize,
    /// When, seconds.
    pub(super) t_s: f64,
    /// What the journal says of it; logs of format 1 say only when.
    pub(super) seam: Option<&'a Seam>,
}

/// The places where a session went on, in order. A mark and the input that follows it are one place.
pub(super) fn seams(session: &SessionFolder) -> Vec<Join<'_>> {
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
pub(super) fn gaze_source(session: &SessionFolder) -> &str {
    session.header.gaze_source.get("id").and_then(serde_json::Value::as_str).unwrap_or("")
}

/// The program that ran a session, with its version.
pub(super) fn program(session: &SessionFolder) -> String {
    format!("{} {}", session.header.program.name, session.header.program.version)
}

/// A unit variant of an enum as it is written to logs.
pub(super) fn kebab(value: impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// An answer by its name, an option by its number.
pub(super) fn answer_text(answer: Answer) -> String {
    match answer {
        Answer::Option(number) => number.to_string(),
        Answer::Typed(character) => character.to_string(),
        named => kebab(named),
    }
}

/// An entry as text.
pub(super) fn entry_text(entry: &Entry) -> String {
    match entry {
        Entry::Number(number) => number.to_string(),
        Entry::Text(text) => text.clone(),
    }
}
