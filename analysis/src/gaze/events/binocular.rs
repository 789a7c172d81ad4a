//! Saccades that both eyes made at the same time (Engbert & Kliegl 2003): noise of one eye's signal makes none.

use super::{EventConfig, Events, Saccade, detect};
use crate::gaze::{GazeError, GazeSample};
use serde::{Deserialize, Serialize};

/// A saccade of both eyes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BinocularSaccade {
    /// Of the left eye; the one with the largest excursion, where several overlap.
    pub left: Saccade,
    /// Of the right eye, likewise.
    pub right: Saccade,
    /// The earlier onset, seconds.
    pub onset_s: f64,
    /// The later offset, seconds.
    pub offset_s: f64,
}

/// Events of each eye, and the saccades that overlap in time in both.
///
/// Saccades of either eye that overlap, directly or through one another, are one movement; it counts if both eyes
/// take part.
///
/// # Errors
/// As [`detect`].
pub fn detect_binocular(
    left: &[GazeSample],
    right: &[GazeSample],
    config: &EventConfig,
) -> Result<([Events; 2], Vec<BinocularSaccade>), GazeError> {
    let [left, right] = [detect(left, config)?, detect(right, config)?];
    let both = overlapping(&left.saccades, &right.saccades);
    Ok(([left, right], both))
}

/// Both lists are in order of time, and within one of them no two overlap.
fn overlapping(left: &[Saccade], right: &[Saccade]) -> Vec<BinocularSaccade> {
    let mut found = Vec::new();
    let (mut l, mut r) = (0, 0);
    let larger = |best: Option<Saccade>, next: Saccade| match best {
        Some(best) if best.excursion_deg >= next.excursion_deg => Some(best),
        _ => Some(next),
    };
    while l < left.len() || r < right.len() {
        let (mut best_left, mut best_right) = (None, None);
        let onset_s =
            [left.get(l), right.get(r)].into_iter().flatten().map(|s| s.onset_s).fold(f64::INFINITY, f64::min);
        let mut until_s = onset_s;
        // Take in whatever begins before what has been taken in ends.
        loop {
            if let Some(next) = left.get(l).filter(|next| next.onset_s <= until_s) {
                (best_left, until_s, l) = (larger(best_left, *next), until_s.max(next.offset_s), l + 1);
            } else if let Some(next) = right.get(r).filter(|next| next.onset_s <= until_s) {
                (best_right, until_s, r) = (larger(best_right, *next), until_s.max(next.offset_s), r + 1);
            } else {
                break;
            }
        }
        if let (Some(left), Some(right)) = (best_left, best_right) {
            found.push(BinocularSaccade { left, right, onset_s, offset_s: until_s });
        }
    }
    found
}
