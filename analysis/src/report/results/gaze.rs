//! The quality of gaze by session, where it was by condition, and the trials that a rule flags.

use crate::gaze::deviation::DeviationReport;
use crate::gaze::events::{EventSummary, Events};
use crate::gaze::quality::DataQuality;
use crate::report::page::{Cell, Section, Table};
use crate::report::tables::{Exclusions, FlaggedTrial, GazeQuality, exclusions_section, gaze_section};
use crate::timing::flags::{Criterion, FlagReport};

/// What the gaze of one session comes to.
#[derive(Debug, Clone, Copy)]
pub struct SessionGaze<'a> {
    /// The session.
    pub session: &'a str,
    /// Samples of stimulus phases against the fixation point.
    pub quality: &'a DataQuality,
    /// Saccades and fixations, where they were looked for.
    pub events: Option<&'a Events>,
    /// Angle from the target by condition.
    pub deviation: Option<&'a DeviationReport>,
}

/// Quality by session and deviation by condition.
#[must_use]
pub fn gaze_quality_section(sessions: &[SessionGaze<'_>]) -> Section {
    let qualities: Vec<GazeQuality> = sessions
        .iter()
        .map(|one| {
            let precision = one.quality.precision.as_ref();
            let events = one.events.map(EventSummary::new);
            GazeQuality {
                session: one.session.to_owned(),
                rate_hz: one.quality.rate.effective_hz,
                loss_share: one.quality.loss.invalid_share,
                accuracy_deg: one.quality.accuracy.as_ref().map(|accuracy| accuracy.mean_offset_deg),
                precision_rms_deg: precision.and_then(|precision| precision.rms_s2s_deg),
                precision_sd_deg: precision.map(|precision| precision.sd_deg),
                fixations: events.as_ref().map(|events| events.fixations),
                saccades: events.as_ref().map(|events| events.saccades),
                blinks: None,
            }
        })
        .collect();
    let mut notes: Vec<String> = Vec::new();
    for limit in sessions.iter().filter_map(|one| one.events).flat_map(|events| &events.limits) {
        if !notes.contains(limit) {
            notes.push(limit.clone());
        }
    }
    let mut section = gaze_section(&qualities, &notes);
    let mut table = Table::new(
        "Angle between gaze and target while a stimulus was shown. The interval is over trials: samples within a trial are not \
         independent.",
        &[
            "Session",
            "Condition",
            "Trials",
            "Mean (°)",
            "2.5 %",
            "97.5 %",
            "SD (°)",
            "Median (°)",
            "95 % below (°)",
            "Inside (%)",
        ],
    );
    for one in sessions {
        let Some(report) = one.deviation else { continue };
        for condition in &report.conditions {
            let deviation = &condition.deviation;
            let percentiles = deviation.percentiles_deg.as_ref();
            let mut row: Vec<Cell> =
                vec![one.session.into(), condition.condition.as_str().into(), (deviation.trials as f64).into()];
            row.push(Cell::maybe(deviation.trial_mean_deg.map(|mean| mean.mean)));
            row.extend(Cell::interval(deviation.trial_mean_deg.and_then(|mean| mean.ci95)));
            row.extend([
                Cell::maybe(deviation.sd_deg),
                Cell::maybe(percentiles.map(|percentiles| percentiles.p50)),
                Cell::maybe(percentiles.map(|percentiles| percentiles.p95)),
                Cell::maybe(deviation.inside_share.map(|share| 100.0 * share)),
            ]);
            table.push(row);
        }
    }
    if !table.rows.is_empty() {
        section.tables.push(table);
    }
    section
}

/// The trials that a rule flags, none of them left out.
#[must_use]
pub fn flags_section(flags: &FlagReport) -> Section {
    let mut rules = vec!["Trials were held against these limits. Flagged trials are in all analyses.".to_owned()];
    rules.extend(flags.rule.in_words());
    rules.extend(flags.not_judged.iter().map(|one| one.words.clone()));
    exclusions_section(&Exclusions {
        rules,
        observers: Vec::new(),
        trials: flags
            .flagged
            .iter()
            .map(|trial| FlaggedTrial {
                session: trial.id.session.clone(),
                trial: trial.id.trial,
                reason: trial.reasons.iter().map(|reason| name(reason.criterion)).collect::<Vec<_>>().join(", "),
                excluded: false,
            })
            .collect(),
        looked_at: flags.trials.len(),
    })
}

/// A limit's name, alike for all trials, so that they can be counted by it; each trial's own numbers are in the page's data.
fn name(criterion: Criterion) -> &'static str {
    match criterion {
        Criterion::MissedFrames => "too many missed frames",
        Criterion::MissedShare => "too large a share of frames missed",
        Criterion::Interval => "too long between two frames",
        Criterion::GazeAge => "gaze too old when drawn",
        Criterion::GazeLoss => "gaze lost too long",
        Criterion::Deviation => "gaze too far from the target",
        Criterion::Outside => "gaze outside the region too often",
    }
}
