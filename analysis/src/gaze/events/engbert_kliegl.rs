//! Saccades and microsaccades by a threshold from the velocities' own spread (Engbert & Kliegl 2003).

use super::segments::{Track, runs};
use super::velocity::velocities_deg_s;
use super::{Found, GazeError, setting, shape};
use crate::gaze::order::median_in_place;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The settings of Engbert & Kliegl's detector.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EngbertKliegl {
    /// The threshold in units of the velocity's spread, λ; 6 by default.
    pub lambda: f64,
    /// How the spread is estimated.
    pub noise_scale: NoiseScale,
    /// Fewest samples above threshold; 3 by default (12 ms of the paper's 250 Hz).
    pub min_samples: usize,
    /// Shortest time from the first to the last of them, seconds; 6 ms by default, our choice, so that three samples
    /// of a fast tracker are no saccade.
    pub min_duration_s: f64,
}

/// How the spread of velocities is estimated from medians, which saccades hardly move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseScale {
    /// σ² = median(v²) − median(v)², as the paper has it.
    MedianOfSquares,
    /// σ² = median((v − median v)²), which is never negative: later versions of the authors' toolbox.
    MedianDeviation,
    /// σ² = mean(v²) − mean(v)²: where more than half of the samples do not move at all and both others are zero.
    StandardDeviation,
}

/// The noise that thresholds were set from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VelocityNoise {
    /// Spread of velocities right and up, deg/s.
    pub sd_deg_s: [f64; 2],
    /// How each was estimated: as configured, or the next one that is not zero.
    pub noise_scale: [NoiseScale; 2],
    /// Thresholds: λ times the spread, deg/s.
    pub threshold_deg_s: [f64; 2],
}

impl Default for EngbertKliegl {
    fn default() -> Self {
        Self { lambda: 6.0, noise_scale: NoiseScale::MedianOfSquares, min_samples: 3, min_duration_s: 0.006 }
    }
}

/// Spreads below this, deg/s, are rounding of an eye that does not move.
const NO_SPREAD_DEG_S: f64 = 1e-9;

impl EngbertKliegl {
    pub(super) fn check(&self) -> Result<(), GazeError> {
        setting("lambda", "a factor from 1 to 100", self.lambda, [1.0, 100.0])?;
        setting("min_samples", "samples from 1 to 1000", self.min_samples as f64, [1.0, 1000.0])?;
        setting("min_duration_s", "seconds from 0 to 1", self.min_duration_s, [0.0, 1.0])
    }

    /// Saccades of all segments under one threshold, and the fixations between them; the noise where any velocity
    /// exists.
    pub(super) fn detect(&self, track: &Track, min_fixation_s: f64) -> (Found, Option<VelocityNoise>) {
        let mut velocities = vec![[f64::NAN; 2]; track.t_s.len()];
        for segment in &track.segments {
            velocities_deg_s(track, segment, &mut velocities);
        }
        let Some(noise) = self.noise(&velocities) else { return (Found::default(), None) };
        // A sample without velocity is within any ellipse; an axis that never moves takes no part.
        let per_threshold =
            noise.threshold_deg_s.map(|threshold| if threshold > 0.0 { threshold.recip() } else { 0.0 });
        let outside = |i: usize| {
            let [right, up] = [0, 1].map(|axis| velocities[i][axis] * per_threshold[axis]);
            right * right + up * up > 1.0
        };
        let speed = |i: usize| velocities[i][0].hypot(velocities[i][1]);

        let mut found = Found::default();
        for segment in track.segments.iter().filter(|segment| segment.len() >= 5) {
            let mut slow = segment.start;
            let fixate = |found: &mut Found, slow: Range<usize>| {
                if slow.len() > 1 && track.duration_s(&slow) >= min_fixation_s {
                    found.fixations.extend(shape::fixation(track, segment, &slow));
                }
            };
            for (is_outside, run) in runs(segment.clone(), outside) {
                if !is_outside || run.len() < self.min_samples || track.duration_s(&run) < self.min_duration_s - 1e-9 {
                    continue;
                }
                found.saccades.push(self.measured(track, segment, &run, speed));
                fixate(&mut found, slow..run.start);
                slow = run.end;
            }
            fixate(&mut found, slow..segment.end);
        }
        (found, Some(noise))
    }

    /// A saccade; it is complete only if it keeps away from the samples at a segment's ends, which have no velocity.
    fn measured(
        &self,
        track: &Track,
        segment: &Range<usize>,
        run: &Range<usize>,
        speed: impl Fn(usize) -> f64,
    ) -> super::Saccade {
        let seen = run.start > segment.start + 2 && run.end + 2 < segment.end;
        super::Saccade { complete: seen, ..shape::saccade(track, segment, run, speed) }
    }

    fn noise(&self, velocities: &[[f64; 2]]) -> Option<VelocityNoise> {
        let [right, up] = [0, 1].map(|axis| {
            let mut values: Vec<f64> = velocities.iter().map(|v| v[axis]).filter(|v| v.is_finite()).collect();
            spread(&mut values, self.noise_scale)
        });
        let (right, up) = (right?, up?);
        let sd_deg_s = [right.0, up.0];
        Some(VelocityNoise {
            sd_deg_s,
            noise_scale: [right.1, up.1],
            threshold_deg_s: sd_deg_s.map(|sd| self.lambda * sd),
        })
    }
}

/// The spread by the first estimator, from `wanted` on, that is not zero; zero for velocities that are all the same.
/// `None` without values.
fn spread(values: &mut [f64], wanted: NoiseScale) -> Option<(f64, NoiseScale)> {
    let centre = median_in_place(values)?;
    let median_square_from = |from: f64| {
        let mut squares: Vec<f64> = values.iter().map(|v| (v - from).powi(2)).collect();
        median_in_place(&mut squares).unwrap_or(0.0)
    };
    let variance_by = |scale: NoiseScale| match scale {
        NoiseScale::MedianOfSquares => median_square_from(0.0) - centre * centre,
        NoiseScale::MedianDeviation => median_square_from(centre),
        NoiseScale::StandardDeviation => {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
        }
    };
    let scales = [NoiseScale::MedianOfSquares, NoiseScale::MedianDeviation, NoiseScale::StandardDeviation];
    let first = scales.iter().position(|scale| *scale == wanted).unwrap_or(0);
    let mut spreads = scales[first..].iter().map(|&scale| (variance_by(scale).max(0.0).sqrt(), scale));
    Some(spreads.find(|(sd, _)| *sd > NO_SPREAD_DEG_S).unwrap_or((0.0, NoiseScale::StandardDeviation)))
}
