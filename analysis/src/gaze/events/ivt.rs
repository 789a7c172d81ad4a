//! Identification by velocity threshold (I-VT; Salvucci & Goldberg 2000), with the windowed velocity, the merging of
//! fixations and the shortest fixation of Tobii's filter (Olsen 2012).

use super::segments::{Track, runs};
use super::velocity::speeds_deg_s;
use super::{Found, GazeError, setting, shape};
use crate::gaze::direction::angle_deg;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The settings of I-VT.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VelocityThreshold {
    /// Samples at least this fast are saccadic, deg/s. The default, 30°/s, is Olsen's (2012).
    pub threshold_deg_s: f64,
    /// What a velocity is computed over; 20 ms by default (Olsen 2012).
    pub window: VelocityWindow,
    /// Two fixations of a segment no farther apart in time than this, seconds, and in place than `merge_within_deg`
    /// are one, and what lies between is no saccade. 75 ms by default (Olsen 2012); 0 merges none.
    pub merge_within_s: f64,
    /// The same, degrees between the samples next to the interruption; 0.5° by default (Olsen 2012).
    pub merge_within_deg: f64,
}

/// What a velocity is computed over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityWindow {
    /// The samples before and after.
    Neighbours,
    /// So many milliseconds around the sample, and never less than the samples before and after.
    Milliseconds(f64),
}

impl VelocityWindow {
    /// Length of the window at a sampling interval, seconds.
    pub(super) fn length_s(self, interval_s: f64) -> f64 {
        match self {
            Self::Neighbours => 2.0 * interval_s,
            Self::Milliseconds(ms) => (1e-3 * ms).max(2.0 * interval_s),
        }
    }
}

impl Default for VelocityThreshold {
    fn default() -> Self {
        Self {
            threshold_deg_s: 30.0,
            window: VelocityWindow::Milliseconds(20.0),
            merge_within_s: 0.075,
            merge_within_deg: 0.5,
        }
    }
}

impl VelocityThreshold {
    pub(super) fn check(&self) -> Result<(), GazeError> {
        setting("threshold_deg_s", "degrees per second from 0.1 to 2000", self.threshold_deg_s, [0.1, 2000.0])?;
        if let VelocityWindow::Milliseconds(ms) = self.window {
            setting("window", "milliseconds from 0 to 1000", ms, [0.0, 1000.0])?;
        }
        setting("merge_within_s", "seconds from 0 to 1", self.merge_within_s, [0.0, 1.0])?;
        setting("merge_within_deg", "degrees from 0 to 10", self.merge_within_deg, [0.0, 10.0])
    }

    pub(super) fn detect(&self, track: &Track, min_fixation_s: f64) -> Found {
        let half_s = match self.window {
            VelocityWindow::Neighbours => 0.0,
            VelocityWindow::Milliseconds(ms) => 0.5e-3 * ms,
        };
        let mut found = Found::default();
        let mut speeds = vec![0.0; track.t_s.len()];
        // One sample has no velocity, and a fixation or saccade is nothing that it could show.
        for segment in track.segments.iter().filter(|segment| segment.len() > 1) {
            speeds_deg_s(track, segment, half_s, &mut speeds);
            let (fast, slow) = self.merged(track, runs(segment.clone(), |i| speeds[i] >= self.threshold_deg_s));
            found.saccades.extend(fast.iter().map(|run| shape::saccade(track, segment, run, |i| speeds[i])));
            let long_enough = slow.iter().filter(|run| track.duration_s(run) >= min_fixation_s);
            found.fixations.extend(long_enough.filter_map(|run| shape::fixation(track, segment, run)));
        }
        found
    }

    /// Fast and slow runs, after slow ones that are close to each other have been made one.
    fn merged(
        &self,
        track: &Track,
        runs: impl Iterator<Item = (bool, Range<usize>)>,
    ) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let (mut fast, mut slow): (Vec<Range<usize>>, Vec<Range<usize>>) = (Vec::new(), Vec::new());
        for (is_fast, run) in runs {
            if is_fast {
                fast.push(run);
                continue;
            }
            match slow.last_mut() {
                Some(before) if self.belong_together(track, before, &run) => {
                    before.end = run.end;
                    fast.pop();
                }
                _ => slow.push(run),
            }
        }
        (fast, slow)
    }

    fn belong_together(&self, track: &Track, before: &Range<usize>, after: &Range<usize>) -> bool {
        let (left, right) = (before.end - 1, after.start);
        track.t_s[right] - track.t_s[left] <= self.merge_within_s
            && angle_deg(track.direction[left], track.direction[right]) <= self.merge_within_deg
    }
}
