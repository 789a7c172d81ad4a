//! Every trial measured: how its frames ran, how old the gaze was, how much of it was lost, how far it strayed.
//!
//! Only what happened while a stimulus was shown counts, except for the summary of all frames. Nothing is judged here.

use super::{Frame, TimingSummary, summarise};
use crate::gaze::deviation::deviations_deg;
use crate::gaze::order::{finite, intervals_s, median_in_place, quantile_in_place};
use crate::gaze::quality::{direction_of, gaps};
use crate::gaze::{GazeError, TrialId, TrialTrace};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// One trial's frames and gaze in numbers; times in seconds, angles in degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialTiming {
    /// Which trial.
    pub id: TrialId,
    /// Its condition.
    pub condition: String,
    /// All of its frames, whatever they showed.
    pub all_frames: TimingSummary,
    /// How long stimuli were shown.
    pub stimulus_s: f64,
    /// Frames presented while a stimulus was shown.
    pub frames: usize,
    /// Of these, missed.
    pub missed: usize,
    /// The longest interval between two of them in one stimulus window.
    pub longest_interval_s: Option<f64>,
    /// Median age of the gaze that they were drawn for.
    pub gaze_age_median_s: Option<f64>,
    /// Age that 95 % of them stay below.
    pub gaze_age_p95_s: Option<f64>,
    /// Gaze samples while a stimulus was shown, valid or not.
    pub samples: usize,
    /// Share of that time without a valid sample, 0–1: invalid samples and samples that never came alike. `None`
    /// without stimulus, and where no trial has gaze.
    pub lost_share: Option<f64>,
    /// Median angle between gaze and target.
    pub median_deviation_deg: Option<f64>,
    /// Share of usable samples farther than `region_deg` from the target, 0–1.
    pub outside_share: Option<f64>,
}

/// Every trial in numbers; samples farther than `region_deg` from the target are outside.
///
/// # Errors
/// When a trial's times go back or are not finite, its windows overlap or are empty, or a trial is there twice.
pub fn measure_trials(traces: &[TrialTrace], region_deg: f64) -> Result<Vec<TrialTiming>, GazeError> {
    crate::gaze::setting("region_deg", "degrees from 0 to 180", region_deg, [0.0, 180.0])?;
    let mut seen = HashSet::with_capacity(traces.len());
    if let Some(trace) = traces.iter().find(|trace| !seen.insert(&trace.id)) {
        return Err(GazeError::RepeatedTrial { trial: trace.id.to_string() });
    }
    let tracked = traces.iter().any(|trace| !trace.samples.is_empty());
    traces.iter().map(|trace| measure(trace, tracked, region_deg)).collect()
}

fn measure(trace: &TrialTrace, tracked: bool, region_deg: f64) -> Result<TrialTiming, GazeError> {
    let mut deviations = deviations_deg(trace)?;
    let windows: Vec<&[Frame]> =
        trace.stimulus_s.iter().map(|&window_s| frames_within(&trace.frames, window_s)).collect();
    let shown = || windows.iter().copied().flatten();
    let mut ages = finite(shown().filter_map(|frame| frame.gaze_age_s));
    let outside = deviations.iter().filter(|deviation| **deviation > region_deg).count();
    Ok(TrialTiming {
        id: trace.id.clone(),
        condition: trace.condition.clone(),
        all_frames: summarise(&trace.frames),
        stimulus_s: trace.stimulus_duration_s(),
        frames: shown().count(),
        missed: shown().filter(|frame| frame.missed).count(),
        longest_interval_s: windows.iter().flat_map(|frames| super::intervals_s(frames)).reduce(f64::max),
        gaze_age_median_s: median_in_place(&mut ages),
        gaze_age_p95_s: quantile_in_place(&mut ages, 0.95),
        samples: trace.windows().map(|(_, samples)| samples.len()).sum(),
        lost_share: if tracked { lost_share(trace) } else { None },
        outside_share: (!deviations.is_empty()).then(|| outside as f64 / deviations.len() as f64),
        median_deviation_deg: median_in_place(&mut deviations),
    })
}

/// Share of the stimulus time without a valid sample; an interval between samples is no loss.
fn lost_share(trace: &TrialTrace) -> Option<f64> {
    let interval_s = median_in_place(&mut intervals_s(&trace.samples)).unwrap_or(0.0);
    let lost_s: f64 = trace
        .windows()
        .map(|(window_s, samples)| {
            let valid = samples.iter().filter(|sample| direction_of(sample).is_some()).map(|sample| sample.t_s);
            gaps(valid, window_s, interval_s, f64::INFINITY).time_share * (window_s[1] - window_s[0])
        })
        .sum();
    let shown_s = trace.stimulus_duration_s();
    (shown_s > 0.0).then(|| (lost_s / shown_s).clamp(0.0, 1.0))
}

/// The frames of a window (its end not included); frames are in order of time.
fn frames_within(frames: &[Frame], [from_s, to_s]: [f64; 2]) -> &[Frame] {
    let begin = frames.partition_point(|frame| frame.presented_s < from_s);
    let end = frames.partition_point(|frame| frame.presented_s < to_s);
    &frames[begin..end.max(begin)]
}
