//! What every table holds, row by row, as typed cells: the one definition from which all formats are written.
//!
//! Tables of a session are filled one session at a time, so that the gaze of only one is in memory.

mod of_session;

use super::cells::Sink;
use super::columns::{self, Column, NamedColumn, TrialNames};
use crate::error::LabError;
use crate::results::ObserverResult;
use crate::session::SessionFolder;
use of_session::OfSession;
pub(super) use of_session::{answer_text, entry_text, gaze_rows, gaze_source, kebab, program, seams};
use std::collections::BTreeMap;

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
