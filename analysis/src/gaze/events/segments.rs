//! The valid samples of a recording as directions at times, cut wherever the eye was out of sight for too long.

use super::GazeError;
use crate::gaze::GazeSample;
use crate::gaze::direction::Direction;
use crate::gaze::order::{SAME_TIME_S, intervals_s, median_in_place};
use crate::gaze::quality::{BROKEN_AFTER_INTERVALS, direction_of};
use crate::gaze::trace::check_times;
use std::ops::Range;

/// Valid samples in order of time, no two at the same time.
#[derive(Debug)]
pub(super) struct Track {
    pub(super) t_s: Vec<f64>,
    pub(super) direction: Vec<Direction>,
    /// Runs of samples, each no farther from the next than `bridged_up_to_s`.
    pub(super) segments: Vec<Range<usize>>,
    /// Median interval of all samples, valid or not.
    pub(super) interval_s: Option<f64>,
    pub(super) bridged_up_to_s: f64,
    pub(super) repeated_times: usize,
}

impl Track {
    pub(super) fn new(samples: &[GazeSample], max_gap_s: f64) -> Result<Self, GazeError> {
        check_times(samples.iter().map(|sample| sample.t_s))?;
        let mut intervals = intervals_s(samples);
        let interval_s = median_in_place(&mut intervals);
        let bridged_up_to_s = max_gap_s.max(interval_s.map_or(0.0, |s| BROKEN_AFTER_INTERVALS * s));
        let mut track = Self {
            t_s: Vec::with_capacity(samples.len()),
            direction: Vec::with_capacity(samples.len()),
            segments: Vec::new(),
            interval_s,
            bridged_up_to_s,
            repeated_times: 0,
        };
        let mut begin = 0;
        for sample in samples {
            let Some(direction) = direction_of(sample) else { continue };
            let at = track.t_s.len();
            match track.t_s.last() {
                Some(&before_s) if sample.t_s - before_s <= SAME_TIME_S => {
                    track.repeated_times += 1;
                    continue;
                }
                Some(&before_s) if sample.t_s - before_s > bridged_up_to_s => {
                    track.segments.push(begin..at);
                    begin = at;
                }
                _ => {}
            }
            track.t_s.push(sample.t_s);
            track.direction.push(direction);
        }
        if begin < track.t_s.len() {
            track.segments.push(begin..track.t_s.len());
        }
        Ok(track)
    }

    /// How long the segments are together, seconds.
    pub(super) fn searched_s(&self) -> f64 {
        self.segments.iter().map(|segment| self.t_s[segment.end - 1] - self.t_s[segment.start]).sum()
    }

    /// Time from a run's first sample to its last, seconds.
    pub(super) fn duration_s(&self, run: &Range<usize>) -> f64 {
        self.t_s[run.end - 1] - self.t_s[run.start]
    }
}

/// The longest runs within `range` over which `class` does not change, in order.
pub(super) fn runs<C: PartialEq + Copy>(
    range: Range<usize>,
    class: impl Fn(usize) -> C,
) -> impl Iterator<Item = (C, Range<usize>)> {
    let mut next = range.start;
    std::iter::from_fn(move || {
        let begin = next;
        if begin >= range.end {
            return None;
        }
        let of = class(begin);
        next = (begin + 1..range.end).find(|&i| class(i) != of).unwrap_or(range.end);
        Some((of, begin..next))
    })
}
