//! From sessions on disk to fitted numbers: what `analyze`, `export` and `demo` share.
//!
//! Sessions of one observer are fitted together; practice, aborted and unanswered trials are left out.

use crate::error::LabError;
use crate::session::SessionFolder;
use analysis::{MarFit, MarFitConfig, MarTrial, fit_mar};
use experiments::study::finest_mar_around;
use std::collections::BTreeMap;

/// One observer's sessions and what they gave.
#[derive(Debug)]
pub struct ObserverResult<'a> {
    /// The observer's code.
    pub observer: String,
    /// Their sessions, in the order given.
    pub sessions: Vec<&'a SessionFolder>,
    /// The joint fit.
    pub fit: MarFit,
}

/// The trials of a session that enter a fit.
#[must_use]
pub fn fitted_trials(session: &SessionFolder) -> Vec<MarTrial> {
    let trials = session.record.trials.iter().filter(|record| !record.trial.practice);
    trials
        .filter_map(|record| {
            Some(MarTrial {
                eccentricity_deg: record.trial.eccentricity_deg?,
                mar_deg: record.trial.mar_deg?,
                correct: record.correct()?,
            })
        })
        .collect()
}

/// Fits each observer's sessions together, observers in alphabetical order.
///
/// # Errors
/// When an observer's sessions were run on different displays, or their trials cannot be fitted at all.
pub fn fit_sessions(sessions: &[SessionFolder]) -> Result<Vec<ObserverResult<'_>>, LabError> {
    let mut by_observer: BTreeMap<&str, Vec<&SessionFolder>> = BTreeMap::new();
    for session in sessions {
        by_observer.entry(&session.header.observer).or_default().push(session);
    }
    by_observer
        .into_iter()
        .map(|(observer, sessions)| {
            let first = sessions[0];
            if let Some(other) = sessions.iter().find(|session| session.display != first.display) {
                return Err(LabError::BadInput(format!(
                    "{observer}: {} and {} were run on different displays and cannot be fitted together",
                    first.path.display(),
                    other.path.display()
                )));
            }
            let trials: Vec<MarTrial> = sessions.iter().flat_map(|session| fitted_trials(session)).collect();
            let mut eccentricities: Vec<f64> = trials.iter().map(|trial| trial.eccentricity_deg).collect();
            eccentricities.sort_by(f64::total_cmp);
            eccentricities.dedup();
            let fixation = first.fixation_deg();
            let finest_mar =
                eccentricities.iter().map(|&e| (e, finest_mar_around(&first.display, fixation, e))).collect();
            let config = MarFitConfig { finest_mar, ..MarFitConfig::default() };
            let fit = fit_mar(&trials, &config).map_err(|error| {
                LabError::Failed(format!("{observer}: the {} answered trials cannot be fitted: {error}", trials.len()))
            })?;
            Ok(ObserverResult { observer: observer.to_owned(), sessions, fit })
        })
        .collect()
}
