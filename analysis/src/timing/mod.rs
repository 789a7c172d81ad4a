//! How the frames ran: intervals, missed frames, and how old the gaze was when it was drawn.
//!
//! Frames come as plain numbers from the session's log. A frame is missed when the stage says so; nothing is guessed here.
//! Ages are software times, from a sample's own time to the frame's hand-over: light comes later.
//!
//! - [`summarise`] sums up a session's frames;
//! - [`trials`] measures every trial: frames, gaze age, gaze loss, deviation;
//! - [`flags`] holds trials against a rule and says which fail it and why, and leaves none out;
//! - [`exclusion`] leaves flagged trials out, and reports which.

pub mod exclusion;
pub mod flags;
pub mod trials;

use crate::numerics::{quantile_of_sorted, sorted_finite};
use serde::{Deserialize, Serialize};

/// One presented frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// When it was presented, seconds from the session's start.
    pub presented_s: f64,
    /// Whether it came later than it was scheduled for.
    pub missed: bool,
    /// Age of the gaze sample that it was drawn for, seconds; `None` where no gaze was used.
    pub gaze_age_s: Option<f64>,
    /// True for the first frame of a phase, trial or resumed session: the time before it is no frame interval.
    pub after_gap: bool,
}

/// A summary of frame timing; times in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimingSummary {
    /// Frames presented.
    pub frames: usize,
    /// Frames missed.
    pub missed: usize,
    /// Share of frames missed, 0–1; `None` without frames.
    pub missed_share: Option<f64>,
    /// Mean interval between frames.
    pub interval_mean_s: Option<f64>,
    /// Standard deviation of the intervals (n − 1).
    pub interval_sd_s: Option<f64>,
    /// Longest interval.
    pub interval_max_s: Option<f64>,
    /// Median age of the gaze drawn.
    pub gaze_age_median_s: Option<f64>,
    /// Age that 95 % of frames stay below.
    pub gaze_age_p95_s: Option<f64>,
}

/// Intervals between successive frames, seconds, leaving out those that span a gap or do not advance.
#[must_use]
pub fn intervals_s(frames: &[Frame]) -> Vec<f64> {
    frames
        .windows(2)
        .filter(|pair| !pair[1].after_gap)
        .map(|pair| pair[1].presented_s - pair[0].presented_s)
        .filter(|dt| dt.is_finite() && *dt > 0.0)
        .collect()
}

/// Summarise frames in the order in which they were presented.
#[must_use]
pub fn summarise(frames: &[Frame]) -> TimingSummary {
    let intervals = intervals_s(frames);
    let n = intervals.len() as f64;
    let mean = (n > 0.0).then(|| intervals.iter().sum::<f64>() / n);
    let sd = mean
        .filter(|_| n > 1.0)
        .map(|mean| (intervals.iter().map(|dt| (dt - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt());
    let ages = sorted_finite(frames.iter().filter_map(|frame| frame.gaze_age_s));
    let missed = frames.iter().filter(|frame| frame.missed).count();
    TimingSummary {
        frames: frames.len(),
        missed,
        missed_share: (!frames.is_empty()).then(|| missed as f64 / frames.len() as f64),
        interval_mean_s: mean,
        interval_sd_s: sd,
        interval_max_s: intervals.iter().copied().reduce(f64::max),
        gaze_age_median_s: quantile_of_sorted(&ages, 0.5),
        gaze_age_p95_s: quantile_of_sorted(&ages, 0.95),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_no_intervals() {
        let frame = |presented_s, after_gap| Frame { presented_s, missed: false, gaze_age_s: Some(0.01), after_gap };
        let summary = summarise(&[frame(0.0, true), frame(0.1, false), frame(5.0, true), frame(5.3, false)]);
        assert!((summary.interval_mean_s.unwrap_or(0.0) - 0.2).abs() < 1e-12);
        assert!((summary.interval_sd_s.unwrap_or(0.0) - 0.02f64.sqrt()).abs() < 1e-12);
        assert!((summary.interval_max_s.unwrap_or(0.0) - 0.3).abs() < 1e-12);
        assert_eq!(summary.gaze_age_median_s, Some(0.01));
    }

    #[test]
    fn no_frames_give_no_numbers() {
        let summary = summarise(&[]);
        assert_eq!((summary.frames, summary.missed_share, summary.interval_mean_s), (0, None, None));
    }
}
