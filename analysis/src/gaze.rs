//! Where the eyes were: deviation from the fixation point, lost samples, sampling rate.
//!
//! Samples come as plain numbers; which of them belong to a stimulus phase, and where fixation was, the caller knows.
//! Saccade and fixation detection is not here.

use crate::numerics::{quantile_of_sorted, sorted_finite};
use serde::{Deserialize, Serialize};

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
/// Invalid samples, and samples whose deviation is not finite, count as lost and enter no angle.
#[must_use]
pub fn summarise(samples: &[GazeSample]) -> GazeSummary {
    let deviations = sorted_finite(samples.iter().filter(|s| s.valid).map(|s| s.deviation_deg));
    let n = deviations.len() as f64;
    let some = !deviations.is_empty();
    let valid_share = (!samples.is_empty()).then(|| n / samples.len() as f64);
    let intervals = sorted_finite(samples.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).filter(|dt| *dt > 0.0));
    GazeSummary {
        samples: samples.len(),
        valid_share,
        loss_share: valid_share.map(|share| 1.0 - share),
        rms_deviation_deg: some.then(|| (deviations.iter().map(|d| d * d).sum::<f64>() / n).sqrt()),
        mean_deviation_deg: some.then(|| deviations.iter().sum::<f64>() / n),
        median_deviation_deg: quantile_of_sorted(&deviations, 0.5),
        p95_deviation_deg: quantile_of_sorted(&deviations, 0.95),
        sampling_rate_hz: quantile_of_sorted(&intervals, 0.5).map(f64::recip),
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
