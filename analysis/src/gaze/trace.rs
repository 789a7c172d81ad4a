//! One trial's gaze and frames as plain data: what deviation, data quality and the flagging of trials are computed from.
//!
//! Whoever has a session's `gaze.csv` and `frames.csv` fills these; nothing here reads a file.

use super::{GazeError, GazeSample};
use crate::timing::Frame;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Which trial: its session and its number there.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct TrialId {
    /// Name of the session's folder, or whatever tells sessions apart.
    pub session: String,
    /// The trial's number in that session.
    pub trial: u32,
}

impl fmt::Display for TrialId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "trial {} of {}", self.trial, self.session)
    }
}

/// Where the observer was to look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// One place, degrees right and up of the display's centre.
    Fixed([f64; 2]),
    /// A target that moves: where it was drawn with each frame, in order of time.
    ///
    /// It stays where a frame put it until the next frame, as on the display; before the first it is nowhere.
    Moving(Vec<TargetPlace>),
}

/// Where a moving target was drawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TargetPlace {
    /// When its frame was presented, seconds from the session's start.
    pub t_s: f64,
    /// Degrees right and up of the display's centre.
    pub position_deg: [f64; 2],
}

/// A trial's samples and frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialTrace {
    /// Which trial.
    pub id: TrialId,
    /// Its condition.
    pub condition: String,
    /// Gaze samples in order of time, at least those within `stimulus_s`.
    pub samples: Vec<GazeSample>,
    /// Frames in the order in which they were presented.
    pub frames: Vec<Frame>,
    /// When a stimulus was shown: from (included) and to (not included), seconds, in order and apart from each other.
    pub stimulus_s: Vec<[f64; 2]>,
    /// Where the observer was to look; `None` in free viewing.
    pub target: Option<Target>,
}

impl TrialTrace {
    /// How long stimuli were shown, seconds.
    #[must_use]
    pub fn stimulus_duration_s(&self) -> f64 {
        self.stimulus_s.iter().map(|[from_s, to_s]| to_s - from_s).sum()
    }

    /// The samples within stimulus windows, window by window.
    pub(crate) fn windows(&self) -> impl Iterator<Item = ([f64; 2], &[GazeSample])> {
        self.stimulus_s.iter().map(|&window_s| (window_s, within(&self.samples, window_s)))
    }

    /// Whether times are numbers in order and windows are windows.
    pub(crate) fn check(&self) -> Result<(), GazeError> {
        let named = |error: GazeError| GazeError::Trial { trial: self.id.to_string(), error: Box::new(error) };
        check_times(self.samples.iter().map(|s| s.t_s)).map_err(named)?;
        check_times(self.frames.iter().map(|frame| frame.presented_s)).map_err(named)?;
        let mut last_s = f64::NEG_INFINITY;
        for &[from_s, to_s] in &self.stimulus_s {
            if !(from_s.is_finite() && to_s.is_finite() && from_s < to_s && last_s <= from_s) {
                return Err(named(GazeError::Window { from_s, to_s }));
            }
            last_s = to_s;
        }
        if let Some(Target::Moving(places)) = &self.target {
            check_times(places.iter().map(|place| place.t_s)).map_err(named)?;
        }
        Ok(())
    }
}

/// The samples of a window (its end not included); samples are in order of time.
pub(crate) fn within(samples: &[GazeSample], [from_s, to_s]: [f64; 2]) -> &[GazeSample] {
    let begin = samples.partition_point(|sample| sample.t_s < from_s);
    let end = samples.partition_point(|sample| sample.t_s < to_s);
    &samples[begin..end.max(begin)]
}

/// Whether times are finite and never go back.
pub(crate) fn check_times(times_s: impl IntoIterator<Item = f64>) -> Result<(), GazeError> {
    let mut before_s = f64::NEG_INFINITY;
    for (row, t_s) in times_s.into_iter().enumerate() {
        if !t_s.is_finite() {
            return Err(GazeError::TimeNotFinite { row });
        }
        if t_s < before_s {
            return Err(GazeError::TimeGoesBack { row, t_s, before_s });
        }
        before_s = t_s;
    }
    Ok(())
}
