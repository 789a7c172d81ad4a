//! A validation: the eye rested on several known places in turn, and the quality at each is told and summed up.
//!
//! When each target was fixated the caller knows; nothing here searches for the best window.

use super::quality::{DataQuality, QualityConfig, data_quality};
use super::{GazeError, GazeSample};
use crate::shares::Mean;
use serde::{Deserialize, Serialize};

/// A place that was looked at, and when.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ValidationPoint {
    /// Degrees right and up of the display's centre.
    pub target_deg: [f64; 2],
    /// From (included) and to (not included), seconds.
    pub window_s: [f64; 2],
}

/// The quality at each place of a validation and over them, each place counting once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// One for each point, in order.
    pub points: Vec<DataQuality>,
    /// Accuracy (offset of the mean direction), degrees.
    pub accuracy_deg: Option<Mean>,
    /// The worst of them, degrees.
    pub worst_accuracy_deg: Option<f64>,
    /// RMS from sample to sample, degrees.
    pub rms_s2s_deg: Option<Mean>,
    /// Standard deviation, degrees.
    pub sd_deg: Option<Mean>,
    /// Share of samples that are not valid, 0–1.
    pub invalid_share: Option<Mean>,
    /// Points without a valid sample; they are in no mean.
    pub points_without_gaze: usize,
}

/// Data quality at each point of a validation. `config` gives the nominal rate and the length of gaps.
///
/// # Errors
/// As [`data_quality`].
pub fn validate(
    samples: &[GazeSample],
    points: &[ValidationPoint],
    config: &QualityConfig,
) -> Result<Validation, GazeError> {
    let points: Vec<DataQuality> = points
        .iter()
        .map(|point| {
            let (target_deg, window_s) = (Some(point.target_deg), Some(point.window_s));
            data_quality(samples, &QualityConfig { target_deg, window_s, ..*config })
        })
        .collect::<Result<_, _>>()?;
    let accuracies = || points.iter().filter_map(|point| Some(point.accuracy?.offset_of_mean_deg));
    Ok(Validation {
        accuracy_deg: Mean::new(accuracies()),
        worst_accuracy_deg: accuracies().reduce(f64::max),
        rms_s2s_deg: Mean::new(points.iter().filter_map(|point| point.precision?.rms_s2s_deg)),
        sd_deg: Mean::new(points.iter().filter_map(|point| Some(point.precision?.sd_deg))),
        invalid_share: Mean::new(points.iter().filter_map(|point| point.loss.invalid_share)),
        points_without_gaze: points.iter().filter(|point| point.valid == 0).count(),
        points,
    })
}
