//! Every trial with its gaze and its frames, for what is said about the quality of both.

use crate::error::LabError;
use crate::session::SessionFolder;
use analysis::gaze::deviation::{DeviationConfig, DeviationReport, deviation_by_condition};
use analysis::gaze::events::{EventConfig, Events, detect};
use analysis::gaze::quality::{DataQuality, QualityConfig, data_quality};
use analysis::gaze::{GazeSample, Target, TargetPlace, TrialId, TrialTrace};
use analysis::timing::Frame;
use analysis::timing::flags::{FlagReport, FlagRule, flag_trials};
use experiments::session::record::TrialRecord;
use serde::Serialize;

/// What the gaze of one session comes to.
#[derive(Debug, Clone, Serialize)]
pub struct SessionGaze {
    /// The session's name.
    pub session: String,
    /// Samples of stimulus phases against the fixation point.
    pub quality: DataQuality,
    /// Angle from the target by condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<DeviationReport>,
    /// Saccades and fixations of the whole session.
    #[serde(skip)]
    pub events: Option<Events>,
}

/// Gaze and frames of some sessions, trial by trial.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Quality {
    /// By session.
    pub sessions: Vec<SessionGaze>,
    /// Trials that the suggested rule flags.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flags: Option<FlagReport>,
    /// What could not be judged, in plain words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// Judges the gaze and the frames of sessions.
///
/// # Errors
/// When a table cannot be read.
pub fn quality<'a>(sessions: impl IntoIterator<Item = &'a SessionFolder>) -> Result<Quality, LabError> {
    let mut result = Quality::default();
    let mut traces = Vec::new();
    for session in sessions {
        let (samples, own) = session_traces(session)?;
        let name = session.name();
        let during: Vec<GazeSample> = own.iter().flat_map(|trace| trace.samples.iter().copied()).collect();
        let config = QualityConfig { target_deg: Some(session.fixation_deg()), ..QualityConfig::default() };
        match data_quality(&during, &config) {
            Ok(quality) => result.sessions.push(SessionGaze {
                deviation: deviation_by_condition(&own, &DeviationConfig::default()).ok(),
                events: detect(&samples, &EventConfig::velocity_threshold()).ok(),
                session: name,
                quality,
            }),
            Err(error) => result.notes.push(format!("{name}: gaze could not be judged: {error}")),
        }
        traces.extend(own);
    }
    match flag_trials(&traces, &FlagRule::suggested()) {
        Ok(flags) => result.flags = Some(flags),
        Err(error) => result.notes.push(format!("trials could not be held against a rule: {error}")),
    }
    Ok(result)
}

/// When a trial showed a stimulus: each phase's beginning and end, seconds.
pub fn stimulus_windows_s(trial: &TrialRecord) -> impl Iterator<Item = [f64; 2]> {
    trial.phases.iter().enumerate().filter(|(_, phase)| phase.shown.is_some()).map(|(index, phase)| {
        let ended_s = trial.phases.get(index + 1).map_or(trial.ended_s, |next| next.began_s);
        [phase.began_s, ended_s]
    })
}

/// All samples of a session, and its trials with theirs.
fn session_traces(session: &SessionFolder) -> Result<(Vec<GazeSample>, Vec<TrialTrace>), LabError> {
    let fixation = session.fixation_deg();
    let samples: Vec<GazeSample> = session
        .gaze()?
        .rows
        .into_iter()
        .map(|row| GazeSample {
            t_s: row.t_s,
            position_deg: [row.x_deg, row.y_deg],
            deviation_deg: session.display.eccentricity_deg(fixation, [row.x_deg, row.y_deg]),
            valid: row.valid,
        })
        .collect();
    let frames = session.frames()?.rows;
    // Logs from before there were moving targets name none; then everybody looked at the mark.
    let targets_are_logged = frames.iter().any(|row| row.target_x_deg.is_some());
    let mut traces = Vec::new();
    for trial in session.record.trials.iter().filter(|trial| !trial.trial.practice) {
        let stimulus_s: Vec<[f64; 2]> = stimulus_windows_s(trial).filter(|[began, ended]| ended > began).collect();
        if stimulus_s.is_empty() {
            continue;
        }
        let shown = |t: f64| stimulus_s.iter().any(|&[from, to]| (from..to).contains(&t));
        let within = |from: usize, to: usize| &frames[from..to];
        let first = frames.partition_point(|row| row.presented_s < trial.began_s);
        let last = frames.partition_point(|row| row.presented_s < trial.ended_s);
        let own = within(first, last.max(first));
        let mut before = None;
        let drawn: Vec<Frame> = own
            .iter()
            .filter(|row| shown(row.presented_s))
            .map(|row| Frame {
                presented_s: row.presented_s,
                missed: row.missed,
                gaze_age_s: row.gaze_age_s,
                after_gap: before.replace(row.phase_seq) != Some(row.phase_seq),
            })
            .collect();
        let places: Vec<TargetPlace> = own
            .iter()
            .filter_map(|row| {
                Some(TargetPlace { t_s: row.presented_s, position_deg: [row.target_x_deg?, row.target_y_deg?] })
            })
            .collect();
        let target = match (targets_are_logged, places.is_empty()) {
            (true, true) => None,
            (true, false) => Some(Target::Moving(places)),
            (false, _) => Some(Target::Fixed(fixation)),
        };
        let begin = samples.partition_point(|sample| sample.t_s < stimulus_s[0][0]);
        let inside = samples[begin..].iter().take_while(|sample| sample.t_s < trial.ended_s);
        traces.push(TrialTrace {
            id: TrialId { session: session.name(), trial: trial.trial.trial },
            condition: trial.trial.condition.clone(),
            samples: inside.filter(|sample| shown(sample.t_s)).copied().collect(),
            frames: drawn,
            stimulus_s,
            target,
        });
    }
    Ok((samples, traces))
}
