//! Angular velocity at each sample of a segment, from the samples' own times.

use super::segments::Track;
use crate::gaze::direction::{angle_deg, projected_deg};
use std::ops::Range;

/// Speeds, deg/s, over a window of half-length `half_s` around each sample of a segment, or over its two neighbours
/// where the window holds no more: the angle between the window's outermost samples over the time between them.
///
/// At a segment's ends the window is cut. A segment of one sample has speed 0.
pub(super) fn speeds_deg_s(track: &Track, segment: &Range<usize>, half_s: f64, out: &mut [f64]) {
    let t = &track.t_s;
    // Times that are equal but for rounding belong to the window.
    let half_s = half_s + 1e-9 + 1e-3 * track.interval_s.unwrap_or(0.0);
    let (mut left, mut right) = (segment.start, segment.start);
    let last = segment.end - 1;
    for i in segment.clone() {
        while t[i] - t[left] > half_s {
            left += 1;
        }
        while right < last && t[right + 1] - t[i] <= half_s {
            right += 1;
        }
        let a = left.min(i.saturating_sub(1).max(segment.start));
        let b = right.max((i + 1).min(last));
        out[i] = if b > a { angle_deg(track.direction[a], track.direction[b]) / (t[b] - t[a]) } else { 0.0 };
    }
}

/// Velocities right and up, deg/s, of Engbert & Kliegl (2003, Eq. 1): from the two samples before and the two after.
///
/// With equal intervals Δt this is (x₊₂ + x₊₁ − x₋₁ − x₋₂) / 6Δt; the samples' own times take the place of 6Δt. The two
/// samples at either end of a segment have no velocity (NaN).
pub(super) fn velocities_deg_s(track: &Track, segment: &Range<usize>, out: &mut [[f64; 2]]) {
    out[segment.clone()].fill([f64::NAN; 2]);
    let (t, d) = (&track.t_s, &track.direction);
    for i in segment.start + 2..segment.end.saturating_sub(2) {
        let time_s = t[i + 2] + t[i + 1] - t[i - 1] - t[i - 2];
        let difference = std::array::from_fn(|axis| d[i + 2][axis] + d[i + 1][axis] - d[i - 1][axis] - d[i - 2][axis]);
        out[i] = projected_deg(d[i], difference).map(|x| x / time_s);
    }
}
