//! Where the eyes were: deviation from a target, data quality, saccades and fixations.
//!
//! Samples come as plain numbers; which of them belong to a stimulus phase, and where fixation was, the caller knows.
//! Nothing here leaves a trial out: [`crate::timing`] flags trials, and excluding them is a step of its own there.
//!
//! - [`summarise`] is the short summary that a report prints;
//! - [`quality`] is accuracy, precision, data loss, rate and gaps, as trackers are described with;
//! - [`deviation`] is the angle from a fixed or moving target by condition, with the trial as the unit;
//! - [`events`] finds saccades and fixations;
//! - [`validation`] is data quality at the points of a validation;
//! - [`trace`] is one trial's gaze and frames.
//!
//! Samples are in order of time, as a log has them. Functions that need the order refuse samples that go back in time
//! ([`GazeError::TimeGoesBack`]); [`sorted_by_time`] puts them in order and says how many were moved.

pub mod deviation;
pub(crate) mod direction;
pub mod events;
pub(crate) mod order;
pub mod quality;
pub mod trace;
pub mod validation;

use order::{intervals_s, quantile_in_place};
use serde::{Deserialize, Serialize};
pub use trace::{Target, TargetPlace, TrialId, TrialTrace};

/// Why gaze data or a configuration cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GazeError {
    /// A time is not a number.
    #[error("row {row} (from 0): its time is not a finite number")]
    TimeNotFinite {
        /// The sample's, frame's or target place's number in the data, from 0.
        row: usize,
    },
    /// Samples are not in order of time.
    #[error("row {row} (from 0) at {t_s} s comes after one at {before_s} s; sort the rows by time first")]
    TimeGoesBack {
        /// The sample's, frame's or target place's number in the data, from 0.
        row: usize,
        /// Its time, seconds.
        t_s: f64,
        /// The time of the sample before it, seconds.
        before_s: f64,
    },
    /// A window that ends before it begins, overlaps the one before it or has no finite ends.
    #[error("the window from {from_s} s to {to_s} s is empty, has no finite ends or begins before the last one ended")]
    Window {
        /// Where it begins, seconds.
        from_s: f64,
        /// Where it ends, seconds.
        to_s: f64,
    },
    /// A setting out of its range.
    #[error("{field}: expected {expected}, found {found}")]
    Setting {
        /// Its name.
        field: &'static str,
        /// What would have been accepted, with its unit.
        expected: &'static str,
        /// What was there.
        found: f64,
    },
    /// Two traces of one trial: what is flagged would not be clear.
    #[error("{trial} is there more than once")]
    RepeatedTrial {
        /// Which trial.
        trial: String,
    },
    /// Something is wrong with one trial.
    #[error("{trial}: {error}")]
    Trial {
        /// Which trial.
        trial: String,
        /// What is wrong.
        error: Box<GazeError>,
    },
}

/// `found` where it lies within `min..=max`, else the error that names it.
pub(crate) fn setting(
    field: &'static str,
    expected: &'static str,
    found: f64,
    [min, max]: [f64; 2],
) -> Result<(), GazeError> {
    if (min..=max).contains(&found) { Ok(()) } else { Err(GazeError::Setting { field, expected, found }) }
}

/// The samples in order of time, and how many of them were out of place (stood after a later one).
///
/// Samples at the same time keep their order.
///
/// # Errors
/// When a time is not finite.
pub fn sorted_by_time(samples: &[GazeSample]) -> Result<(Vec<GazeSample>, usize), GazeError> {
    if let Some(row) = samples.iter().position(|sample| !sample.t_s.is_finite()) {
        return Err(GazeError::TimeNotFinite { row });
    }
    let mut latest_s = f64::NEG_INFINITY;
    let late = |sample: &&GazeSample| {
        let late = sample.t_s < latest_s;
        latest_s = latest_s.max(sample.t_s);
        late
    };
    let moved = samples.iter().filter(late).count();
    let mut sorted = samples.to_vec();
    sorted.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    Ok((sorted, moved))
}

/// One gaze sample during a stimulus phase.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GazeSample {
    /// Seconds from the session's start.
    pub t_s: f64,
    /// Degrees right and up of the display's centre.
    pub position_deg: [f64; 2],
    /// True angle between the gaze direction and the fixation point, degrees (`Display::eccentricity_deg`).
    pub deviation_deg: f64,
    /// False when the tracker lost the eye.
    pub valid: bool,
}

/// A summary of gaze during stimulus phases; angles in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GazeSummary {
    /// Samples, valid or not.
    pub samples: usize,
    /// Share of samples that were valid, 0–1; `None` without samples.
    pub valid_share: Option<f64>,
    /// Share of samples that were lost, 0–1.
    pub loss_share: Option<f64>,
    /// Root mean square deviation from fixation.
    pub rms_deviation_deg: Option<f64>,
    /// Mean deviation.
    pub mean_deviation_deg: Option<f64>,
    /// Median deviation.
    pub median_deviation_deg: Option<f64>,
    /// Deviation that 95 % of samples stay below.
    pub p95_deviation_deg: Option<f64>,
    /// Samples per second, from the median interval between samples; pauses do not lower it.
    pub sampling_rate_hz: Option<f64>,
}

/// Summarise samples in order of time.
///
/// Invalid samples, and samples whose deviation is no angle from 0° to 180°, count as lost and enter no angle.
#[must_use]
pub fn summarise(samples: &[GazeSample]) -> GazeSummary {
    let mut deviations: Vec<f64> = samples
        .iter()
        .filter(|s| s.valid && (0.0..=180.0).contains(&s.deviation_deg))
        .map(|s| s.deviation_deg)
        .collect();
    let n = deviations.len() as f64;
    let some = !deviations.is_empty();
    let valid_share = (!samples.is_empty()).then(|| n / samples.len() as f64);
    let mut intervals = intervals_s(samples);
    GazeSummary {
        samples: samples.len(),
        valid_share,
        loss_share: valid_share.map(|share| 1.0 - share),
        rms_deviation_deg: some.then(|| (deviations.iter().map(|d| d * d).sum::<f64>() / n).sqrt()),
        mean_deviation_deg: some.then(|| deviations.iter().sum::<f64>() / n),
        median_deviation_deg: quantile_in_place(&mut deviations, 0.5),
        p95_deviation_deg: quantile_in_place(&mut deviations, 0.95),
        sampling_rate_hz: quantile_in_place(&mut intervals, 0.5).map(f64::recip),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(t_s: f64, deviation_deg: f64, valid: bool) -> GazeSample {
        GazeSample { t_s, position_deg: [deviation_deg, 0.0], deviation_deg, valid }
    }

    #[test]
    fn deviations_of_three_and_four_degrees() {
        let summary = summarise(&[
            sample(0.0, 3.0, true),
            sample(0.004, 4.0, true),
            sample(0.008, 90.0, false),
            sample(0.012, f64::NAN, true),
        ]);
        assert_eq!(summary.samples, 4);
        assert_eq!(summary.loss_share, Some(0.5));
        assert_eq!(summary.mean_deviation_deg, Some(3.5));
        assert_eq!(summary.median_deviation_deg, Some(3.5));
        assert!((summary.rms_deviation_deg.unwrap_or(0.0) - 12.5f64.sqrt()).abs() < 1e-12);
        assert!((summary.sampling_rate_hz.unwrap_or(0.0) - 250.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_gives_no_numbers() {
        let summary = summarise(&[]);
        assert_eq!((summary.samples, summary.valid_share, summary.rms_deviation_deg), (0, None, None));
    }
}
