//! From sessions on disk to fitted numbers: what `analyze`, `export` and `demo` share.
//!
//! Sessions of one observer are summed up together, block by block, and their ring trials fitted to the MAR line; practice,
//! aborted and unanswered trials are left out.

pub mod over_observers;
pub mod traces;

use crate::error::LabError;
use crate::session::SessionFolder;
use analysis::answers::{BlockSummary, Protocol, Row, Summary, summarise};
use analysis::summary::{Analysis, FormSummary, ObserverSummary};
use analysis::{MarFit, MarFitConfig, MarTrial, fit_mar};
use experiments::session::record::TrialRecord;
use experiments::study::finest_mar_around;
use std::collections::BTreeMap;

/// One observer's sessions and what they gave.
#[derive(Debug)]
pub struct ObserverResult<'a> {
    /// The observer's code.
    pub observer: String,
    /// Their sessions, in the order given.
    pub sessions: Vec<&'a SessionFolder>,
    /// The joint fit of the MAR line, where forced choices about rings were answered.
    pub fit: Option<MarFit>,
    /// The trials of the MAR fit.
    pub mar_trials: Vec<MarTrial>,
    /// What the answers of each block come to, in the order in which blocks were first run.
    pub blocks: Vec<BlockSummary>,
    /// The answered trials of each block, in the blocks' order.
    pub rows: Vec<Vec<Row>>,
    /// Forms that were filled in.
    pub forms: Vec<FormSummary>,
    /// Whether any of the sessions was a pilot run, which analyses and reports then say first.
    pub pilot: bool,
}

impl ObserverResult<'_> {
    /// The observer's entry in the JSON document.
    #[must_use]
    pub fn summary(&self) -> ObserverSummary {
        ObserverSummary {
            pilot: self.pilot,
            forms: self.forms.clone(),
            ..ObserverSummary::new(&self.observer, self.fit.as_ref(), self.blocks.clone())
        }
    }

    /// Whether any block holds something that can be summed up.
    #[must_use]
    pub fn says_anything(&self) -> bool {
        self.fit.is_some() || self.blocks.iter().any(|block| !matches!(block.summary, Summary::Nothing { .. }))
    }
}

/// The JSON document of some results.
#[must_use]
pub fn document(results: &[ObserverResult<'_>]) -> Analysis {
    Analysis::new(results.iter().map(ObserverResult::summary).collect())
}

/// Whether a session was a pilot run.
fn is_pilot(session: &SessionFolder) -> bool {
    session.header.assignment.pilot
}

/// How each block of a session's study asks, read from the study's text as it stands, so that it is known for protocols
/// that a later program has renamed or dropped.
fn protocols(session: &SessionFolder) -> BTreeMap<String, Protocol> {
    let study: serde_json::Value = serde_json::from_str(&session.header.study.text).unwrap_or_default();
    let blocks = study["blocks"].as_array().map(Vec::as_slice).unwrap_or_default();
    let of_block = |block: &serde_json::Value| {
        let kind = Protocol::named(block["protocol"]["kind"].as_str()?)?;
        Some((block["name"].as_str()?.to_owned(), kind))
    };
    blocks.iter().filter_map(of_block).collect()
}

/// One block's answers, over the sessions of one observer.
#[derive(Debug, Default)]
struct BlockAnswers {
    protocol: Option<Protocol>,
    rows: Vec<Row>,
    mar: Vec<MarTrial>,
}

/// The blocks of some sessions by (study, block), in the order in which they were first run. A block of which no trial was
/// answered is there, without rows.
fn blocks(sessions: &[&SessionFolder]) -> Vec<((String, String), BlockAnswers)> {
    let mut blocks: Vec<((String, String), BlockAnswers)> = Vec::new();
    for session in sessions {
        let protocols = protocols(session);
        for record in session.record.trials.iter().filter(|record| !record.trial.practice) {
            let key = (session.header.study.name.clone(), record.trial.block.clone());
            let index = blocks.iter().position(|(known, _)| *known == key).unwrap_or_else(|| {
                let protocol = protocols.get(&key.1).copied();
                blocks.push((key, BlockAnswers { protocol, ..BlockAnswers::default() }));
                blocks.len() - 1
            });
            let block = &mut blocks[index].1;
            if let Some(row) = Row::of_record(record) {
                block.mar.extend(mar_trial(record));
                block.rows.push(row);
            }
        }
    }
    for (_, block) in &mut blocks {
        // Only a choice between two has the guess rate that the fit takes for known.
        let protocol = block.protocol.or_else(|| Protocol::of_rows(&block.rows));
        if !protocol.is_some_and(Protocol::is_forced_choice) {
            block.mar.clear();
        }
    }
    blocks
}

/// An answered trial on a ring, as the MAR fit takes it.
#[must_use]
pub fn mar_trial(record: &TrialRecord) -> Option<MarTrial> {
    Some(MarTrial {
        eccentricity_deg: record.trial.eccentricity_deg?,
        mar_deg: record.trial.mar_deg?,
        correct: record.correct()?,
    })
}

/// Sums up each observer's sessions together, observers in alphabetical order.
///
/// # Errors
/// When an observer's sessions were run on different displays, or no observer's trials can be summed up at all.
pub fn fit_sessions(sessions: &[SessionFolder]) -> Result<Vec<ObserverResult<'_>>, LabError> {
    let mut by_observer: BTreeMap<&str, Vec<&SessionFolder>> = BTreeMap::new();
    for session in sessions {
        by_observer.entry(&session.header.observer).or_default().push(session);
    }
    let results = by_observer
        .into_iter()
        .map(|(observer, sessions)| observer_result(observer, sessions))
        .collect::<Result<Vec<_>, LabError>>()?;
    if !results.iter().any(ObserverResult::says_anything) {
        let reasons: Vec<String> = results.iter().map(silence).collect();
        return Err(LabError::Failed(reasons.join("; ")));
    }
    Ok(results)
}

/// Why there is nothing to say about an observer, in one line.
pub fn silence(result: &ObserverResult<'_>) -> String {
    let trials: usize = result.blocks.iter().map(|block| block.trials).sum();
    format!("{}: the {trials} answered trials cannot be fitted or summed up", result.observer)
}

fn observer_result<'a>(observer: &str, sessions: Vec<&'a SessionFolder>) -> Result<ObserverResult<'a>, LabError> {
    let first = sessions[0];
    if let Some(other) = sessions.iter().find(|session| session.display != first.display) {
        return Err(LabError::BadInput(format!(
            "{observer}: {} and {} were run on different displays and cannot be fitted together",
            first.path.display(),
            other.path.display()
        )));
    }
    let answers = blocks(&sessions);
    let trials: Vec<MarTrial> = answers.iter().flat_map(|(_, block)| block.mar.iter().copied()).collect();
    let fit = if trials.is_empty() { None } else { Some(mar_fit(observer, first, &trials)?) };
    let (blocks, rows) = answers
        .into_iter()
        .map(|((study, block), answers)| {
            let summary = BlockSummary {
                in_mar_fit: fit.is_some() && !answers.mar.is_empty(),
                ..summarise(&study, &block, answers.protocol, &answers.rows)
            };
            (summary, answers.rows)
        })
        .unzip();
    let forms = sessions.iter().flat_map(|session| {
        session.record.forms.iter().map(|form| FormSummary {
            session: session.name(),
            form: form.form.clone(),
            entries: form.entries.clone(),
        })
    });
    Ok(ObserverResult {
        observer: observer.to_owned(),
        forms: forms.collect(),
        pilot: sessions.iter().any(|session| is_pilot(session)),
        sessions,
        mar_trials: if fit.is_some() { trials } else { Vec::new() },
        fit,
        blocks,
        rows,
    })
}

fn mar_fit(observer: &str, session: &SessionFolder, trials: &[MarTrial]) -> Result<MarFit, LabError> {
    let mut eccentricities: Vec<f64> = trials.iter().map(|trial| trial.eccentricity_deg).collect();
    eccentricities.sort_by(f64::total_cmp);
    eccentricities.dedup();
    let fixation = session.fixation_deg();
    let finest_mar = eccentricities.iter().map(|&e| (e, finest_mar_around(&session.display, fixation, e))).collect();
    let config = MarFitConfig { finest_mar, ..MarFitConfig::default() };
    fit_mar(trials, &config).map_err(|error| {
        LabError::Failed(format!("{observer}: the {} answered trials cannot be fitted: {error}", trials.len()))
    })
}
