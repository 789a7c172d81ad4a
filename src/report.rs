//! The report of an analysis: gathers from sessions on disk what `analysis::report` puts on its page.

use crate::error::LabError;
use crate::results::ObserverResult;
use crate::results::over_observers::OverObservers;
use crate::results::traces::{Quality, stimulus_windows_s};
use crate::session::SessionFolder;
use analysis::MarFit;
use analysis::answers::{BlockSummary, Summary};
use analysis::figures::{self, GazeView, TrackPoint};
use analysis::gaze::GazeSample;
use analysis::mar::Estimate;
use analysis::mar::linearity::Linearity;
use analysis::report::results::{self as sections, BlockVariance, SessionGaze};
use analysis::report::{Extra, ReportInput, SessionReport, html_with};
use analysis::rules::RuleResult;
use analysis::timing::Frame;
use experiments::mar::MarModel;
use experiments::procedures::Belief;
use experiments::study::draft::StudyDraft;
use experiments::trial::{Outcome, PhaseName};
use std::path::Path;

/// A 95 % interval of a normal posterior, in standard deviations.
const NORMAL_95: f64 = 1.959_964;

/// Writes the report of some results as one HTML page.
///
/// # Errors
/// When a session's tables cannot be read or the page cannot be written.
pub fn write(
    results: &[ObserverResult<'_>],
    together: &OverObservers,
    quality: &Quality,
    path: &Path,
) -> Result<(), LabError> {
    let sessions = results.iter().map(session_report).collect::<Result<Vec<_>, _>>()?;
    let title = results
        .first()
        .and_then(|result| result.sessions.first())
        .map_or_else(|| "Analysis".to_owned(), |session| session.header.study.title.clone());
    let input = ReportInput {
        title,
        program_version: format!("parafovea {}", env!("CARGO_PKG_VERSION")),
        generated: Some(chrono::Local::now().format("%Y-%m-%d %H:%M").to_string()),
        software: Vec::new(),
        sessions,
    };
    let page = html_with(&input, &extra(results, together, quality));
    std::fs::write(path, page).map_err(|error| LabError::io("write", path, &error))
}

/// What the page says beyond single observers' fits.
fn extra(results: &[ObserverResult<'_>], together: &OverObservers, quality: &Quality) -> Extra {
    let fits: Vec<(String, &MarFit)> =
        results.iter().filter_map(|result| Some((result.observer.clone(), result.fit.as_ref()?))).collect();
    let lines: Vec<(String, &Linearity)> =
        together.linearity.iter().map(|(observer, test)| (observer.clone(), test)).collect();
    let mut page = Vec::new();
    if let Some(group) = &together.group_mar {
        page.push(sections::pooled_section(group, &fits));
    }
    if !lines.is_empty() {
        page.push(sections::linearity_section(&lines));
    }
    if !together.anovas.is_empty() {
        let analyses: Vec<BlockVariance<'_>> = together
            .anovas
            .iter()
            .map(|one| BlockVariance {
                block: &one.block,
                measure: &one.measure,
                anova: one.anova.as_ref().ok_or(one.refused.as_deref().unwrap_or("there were no values")),
                p_holm: &one.p_holm,
                pairwise: &one.pairwise,
            })
            .collect();
        page.push(sections::variance_section(&analyses));
    }
    if !together.rules.is_empty() {
        let rules: Vec<(&str, &RuleResult)> =
            together.rules.iter().map(|rule| (rule.block.as_str(), &rule.result)).collect();
        page.push(sections::rules_section(&rules));
    }
    let gaze: Vec<SessionGaze<'_>> = quality
        .sessions
        .iter()
        .map(|one| SessionGaze {
            session: &one.session,
            quality: &one.quality,
            events: one.events.as_ref(),
            deviation: one.deviation.as_ref(),
        })
        .collect();
    if !gaze.is_empty() {
        page.push(sections::gaze_quality_section(&gaze));
    }
    page.extend(quality.flags.as_ref().map(sections::flags_section));
    let mut json = serde_json::Map::new();
    json.insert("over_observers".to_owned(), serde_json::to_value(together).unwrap_or_default());
    json.insert("quality".to_owned(), serde_json::to_value(quality).unwrap_or_default());
    Extra { sections: page, json, ..Extra::default() }
}

/// Writes the figures of some results as SVG files into a folder, each named after its observer.
///
/// # Errors
/// When a session's tables cannot be read or a file cannot be written.
pub fn write_figures(results: &[ObserverResult<'_>], folder: &Path) -> Result<(), LabError> {
    std::fs::create_dir_all(folder).map_err(|error| LabError::io("make", folder, &error))?;
    for result in results {
        let session = session_report(result)?;
        let mut figures: Vec<(String, String)> = Vec::new();
        let mut add = |name: &str, svg: String| figures.push((name.to_owned(), svg));
        if let Some(fit) = &session.fit {
            add("mar-line", figures::mar_line(fit));
            add("psychometric-curves", figures::psychometric_curves(fit));
            add("track", figures::adaptive_track(&session.track));
        }
        for block in session.blocks.iter().filter(|block| !block.in_mar_fit) {
            block_figures(block).into_iter().for_each(|(name, svg)| add(&name, svg));
        }
        add("gaze", figures::gaze_density(&session.gaze, &session.gaze_view));
        add("frame-timing", figures::frame_timing(&session.frames, session.measured_refresh_hz));
        for (name, svg) in figures {
            let path = folder.join(format!("{}-{name}.svg", result.observer));
            std::fs::write(&path, svg).map_err(|error| LabError::io("write", &path, &error))?;
        }
    }
    Ok(())
}

/// The figures of one block with their names, each the block's and what it shows.
fn block_figures(block: &BlockSummary) -> Vec<(String, String)> {
    // Names of blocks and items are the study's; a file's name takes their letters, digits and dashes.
    let safe = |text: &str| {
        text.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '-' }).collect::<String>()
    };
    let named = |what: &str, svg: String| (format!("{}-{}", safe(&block.block), safe(what)), svg);
    match &block.summary {
        Summary::Detection(detection) => vec![named("shares", figures::detection(detection))],
        Summary::Matches(matches) => {
            let quantities = matches.parts.first().map(|all| all.quantities.as_slice()).unwrap_or_default();
            let settings = quantities.iter().filter(|quantity| quantity.is_setting());
            settings.map(|q| named(&q.quantity, figures::settings(matches, &q.quantity))).collect()
        }
        Summary::Ratings(ratings) => {
            ratings.items.iter().map(|item| named(&item.item, figures::ratings(ratings, item))).collect()
        }
        Summary::Tasks(tasks) => vec![named("comparisons", figures::tasks(tasks))],
        Summary::Nothing { .. } => Vec::new(),
    }
}

fn session_report(result: &ObserverResult<'_>) -> Result<SessionReport, LabError> {
    let first = result.sessions[0];
    let header = &first.header;
    let (mut gaze, mut frames) = (Vec::new(), Vec::new());
    for session in &result.sessions {
        gaze.extend(gaze_during_stimuli(session)?);
        frames.extend(frames_of(session)?);
    }
    let names: Vec<String> = result.sessions.iter().map(|session| session.name()).collect();
    Ok(SessionReport {
        observer: result.observer.clone(),
        study: header.study.name.clone(),
        session: names.join(", "),
        started: Some(header.started.clone()),
        display: first.display.clone(),
        gaze_source: header.gaze_source["id"].as_str().unwrap_or("unknown").to_owned(),
        stimulus: stimulus(&first.study),
        adapter: header.stage.gpu.clone().unwrap_or_else(|| "no pictures were drawn".to_owned()),
        seed: header.seed,
        run_version: format!("{} {}", header.program.name, header.program.version),
        facts: vec![("Frame pacing".to_owned(), header.stage.pacing.clone())],
        truth: header
            .simulated
            .as_ref()
            .and_then(|simulated| serde_json::from_value::<MarModel>(simulated["truth"].clone()).ok()),
        fit: result.fit.clone(),
        blocks: result.blocks.clone(),
        forms: result.forms.clone(),
        pilot: result.pilot,
        track: result.sessions.iter().flat_map(|session| track(session)).collect(),
        gaze,
        gaze_view: GazeView {
            half_field_deg: first.display.half_field_deg(),
            fixation_deg: first.fixation_deg(),
            gate_deg: first.study.gaze.as_ref().and_then(|gaze| gaze.gate_deg),
        },
        aborted_trials: result
            .sessions
            .iter()
            .flat_map(|session| &session.record.trials)
            .filter(|trial| !matches!(trial.outcome, Outcome::Answered { .. }))
            .count(),
        frames,
        measured_refresh_hz: (header.stage.kind == "window").then(|| 1.0 / header.stage.frame_s),
        virtual_time: header.stage.kind == "offscreen",
    })
}

/// The scenes and renderers of a study's conditions, in words.
fn stimulus(study: &StudyDraft) -> String {
    let described: Vec<String> = study
        .conditions
        .iter()
        .flatten()
        .filter_map(|(name, condition)| {
            let condition = condition.as_ref()?;
            let or_unknown = |id: &Option<String>| id.clone().unwrap_or_else(|| "?".to_owned());
            Some(format!(
                "{name}: scene {}, renderer {}",
                or_unknown(&condition.scene),
                or_unknown(&condition.renderer)
            ))
        })
        .collect();
    described.join("; ")
}

fn track(session: &SessionFolder) -> Vec<TrackPoint> {
    let interval = |belief: &Belief| Estimate {
        estimate: belief.mean,
        ci95: [(belief.mean - NORMAL_95 * belief.sd).max(0.0), belief.mean + NORMAL_95 * belief.sd],
    };
    session
        .record
        .trials
        .iter()
        .filter(|record| !record.trial.practice)
        .filter_map(|record| {
            let belief = |name: &str| record.estimate.as_ref()?.get(name).map(interval);
            Some(TrackPoint {
                trial: record.trial.trial,
                eccentricity_deg: record.trial.eccentricity_deg?,
                mar_deg: record.trial.mar_deg?,
                correct: record.correct()?,
                m: belief("m"),
                omega0: belief("omega0_deg"),
            })
        })
        .collect()
}

/// Gaze samples that fell into a stimulus interval, both tables read once in order of time.
fn gaze_during_stimuli(session: &SessionFolder) -> Result<Vec<GazeSample>, LabError> {
    let fixation = session.fixation_deg();
    let intervals: Vec<[f64; 2]> = session.record.trials.iter().flat_map(stimulus_windows_s).collect();
    let mut next = 0;
    let table = session.gaze()?;
    Ok(table
        .rows
        .into_iter()
        .filter_map(|row| {
            while intervals.get(next).is_some_and(|&[_, ended_s]| ended_s <= row.t_s) {
                next += 1;
            }
            let &[began_s, _] = intervals.get(next)?;
            (row.t_s >= began_s).then(|| GazeSample {
                t_s: row.t_s,
                position_deg: [row.x_deg, row.y_deg],
                deviation_deg: session.display.eccentricity_deg(fixation, [row.x_deg, row.y_deg]),
                valid: row.valid,
            })
        })
        .collect())
}

fn frames_of(session: &SessionFolder) -> Result<Vec<Frame>, LabError> {
    let mut before = None;
    let rows = session.frames()?.rows.into_iter();
    Ok(rows
        .map(|row| {
            let paused = row.phase == PhaseName::Paused;
            Frame {
                presented_s: row.presented_s,
                missed: row.missed,
                gaze_age_s: row.gaze_age_s,
                // Nothing is measured across a pause or a resumed session.
                after_gap: before.replace(paused) != Some(paused),
            }
        })
        .collect())
}
