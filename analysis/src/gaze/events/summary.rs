//! Events in numbers: rates, durations, amplitudes, and the main sequence.

use super::{Events, Saccade};
use crate::gaze::order::median_in_place;
use crate::shares::Mean;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Saccades and fixations in numbers; angles in degrees, times in seconds.
///
/// Rates are per second of the time that was searched. Means are over events, whose intervals take them for
/// independent; events that were cut by a gap count in rates and in no mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EventSummary {
    /// Time that was searched.
    pub searched_s: f64,
    /// Saccades found.
    pub saccades: usize,
    /// Saccades per second.
    pub saccades_per_s: Option<f64>,
    /// Amplitude.
    pub amplitude_deg: Option<Mean>,
    /// Median amplitude.
    pub amplitude_median_deg: Option<f64>,
    /// Duration of saccades.
    pub saccade_duration_s: Option<Mean>,
    /// Peak velocity over amplitude.
    pub main_sequence: Option<MainSequence>,
    /// Fixations found.
    pub fixations: usize,
    /// Fixations per second.
    pub fixations_per_s: Option<f64>,
    /// Duration of fixations.
    pub fixation_duration_s: Option<Mean>,
    /// Median duration of fixations.
    pub fixation_duration_median_s: Option<f64>,
    /// Root mean square distance of a fixation's samples from its centroid.
    pub fixation_sd_deg: Option<Mean>,
    /// Share of the searched time in fixations, 0–1.
    pub fixating_share: Option<f64>,
}

/// The main sequence (Bahill, Clark & Stark 1975) as a power law, V = k A^b, fitted as a line through ln V and ln A.
///
/// Amplitudes are measured too, and their error flattens the slope where they are small beside it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MainSequence {
    /// Complete saccades with an amplitude and a velocity above zero.
    pub n: usize,
    /// Peak velocity of a saccade of one degree, deg/s.
    pub k_deg_s: f64,
    /// Its 95 % interval.
    pub k_ci95_deg_s: [f64; 2],
    /// The exponent b.
    pub exponent: f64,
    /// Its 95 % interval.
    pub exponent_ci95: [f64; 2],
    /// Share of the variance of ln V that the line explains, 0–1; `None` where velocities are all equal.
    pub r2: Option<f64>,
    /// Standard deviation of ln V about the line.
    pub residual_sd: f64,
    /// Smallest and largest amplitude, degrees: the line says nothing beyond.
    pub amplitudes_deg: [f64; 2],
}

impl EventSummary {
    /// The summary of what was found.
    #[must_use]
    pub fn new(events: &Events) -> Self {
        let whole = || events.saccades.iter().filter(|saccade| saccade.complete);
        let rested = || events.fixations.iter().filter(|fixation| fixation.complete);
        let searched_s = events.searched_s;
        let per_s = |n: usize| (searched_s > 0.0).then(|| n as f64 / searched_s);
        let fixating_s: f64 = events.fixations.iter().map(|fixation| fixation.duration_s).sum();
        Self {
            searched_s,
            saccades: events.saccades.len(),
            saccades_per_s: per_s(events.saccades.len()),
            amplitude_deg: Mean::new(whole().map(|s| s.amplitude_deg)),
            amplitude_median_deg: median_in_place(&mut whole().map(|s| s.amplitude_deg).collect::<Vec<_>>()),
            saccade_duration_s: Mean::new(whole().map(|s| s.duration_s)),
            main_sequence: main_sequence(&events.saccades),
            fixations: events.fixations.len(),
            fixations_per_s: per_s(events.fixations.len()),
            fixation_duration_s: Mean::new(rested().map(|f| f.duration_s)),
            fixation_duration_median_s: median_in_place(&mut rested().map(|f| f.duration_s).collect::<Vec<_>>()),
            fixation_sd_deg: Mean::new(rested().map(|f| f.sd_deg)),
            fixating_share: (searched_s > 0.0).then(|| (fixating_s / searched_s).clamp(0.0, 1.0)),
        }
    }
}

/// The main sequence of the complete saccades; `None` for fewer than three, or if all are of one size.
#[must_use]
pub fn main_sequence(saccades: &[Saccade]) -> Option<MainSequence> {
    let points: Vec<[f64; 2]> = saccades
        .iter()
        .filter(|s| s.complete && s.amplitude_deg > 0.0 && s.peak_velocity_deg_s > 0.0)
        .map(|s| [s.amplitude_deg.ln(), s.peak_velocity_deg_s.ln()])
        .collect();
    if points.len() < 3 {
        return None;
    }
    let n = points.len() as f64;
    let [x, y] = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / n);
    let sum = |a: usize, b: usize| points.iter().map(|p| (p[a] - [x, y][a]) * (p[b] - [x, y][b])).sum::<f64>();
    let (xx, xy, yy) = (sum(0, 0), sum(0, 1), sum(1, 1));
    if xx <= 1e-12 * n {
        return None;
    }
    let slope = xy / xx;
    let intercept = y - slope * x;
    let residual2 = points.iter().map(|p| (p[1] - intercept - slope * p[0]).powi(2)).sum::<f64>();
    let residual_sd = (residual2 / (n - 2.0)).sqrt();
    let t = StudentsT::new(0.0, 1.0, n - 2.0).ok()?.inverse_cdf(0.975);
    let half_slope = t * residual_sd / xx.sqrt();
    let half_intercept = t * residual_sd * (1.0 / n + x * x / xx).sqrt();
    let ends = points.iter().map(|p| p[0]).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    Some(MainSequence {
        n: points.len(),
        k_deg_s: intercept.exp(),
        k_ci95_deg_s: [(intercept - half_intercept).exp(), (intercept + half_intercept).exp()],
        exponent: slope,
        exponent_ci95: [slope - half_slope, slope + half_slope],
        r2: (yy > 1e-12 * n).then(|| (1.0 - residual2 / yy).clamp(0.0, 1.0)),
        residual_sd,
        amplitudes_deg: ends.map(f64::exp),
    })
}
