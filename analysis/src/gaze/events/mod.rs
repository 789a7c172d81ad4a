//! Saccades and fixations, found by one of two detectors.
//!
//! - [`Detector::VelocityThreshold`] (I-VT; Salvucci & Goldberg 2000) calls every sample faster than a fixed velocity
//!   saccadic; fixations lie between. It finds saccades, not microsaccades.
//! - [`Detector::EngbertKliegl`] (2003) takes its threshold from the recording's own noise and finds microsaccades too.
//!
//! A recording is cut into segments wherever there was no valid sample for longer than a stated time. Velocities are
//! taken within a segment with the samples' own times, and no event reaches beyond its segment. An event that touches an
//! end of its segment is marked incomplete, since nobody saw it begin or end. Neither detector knows blinks, pursuit or
//! post-saccadic oscillations: what a lid does to the signal next to a gap may look like a saccade.

mod binocular;
mod engbert_kliegl;
mod ivt;
mod segments;
mod shape;
mod summary;
mod velocity;

pub use binocular::{BinocularSaccade, detect_binocular};
pub use engbert_kliegl::{EngbertKliegl, NoiseScale, VelocityNoise};
pub use ivt::{VelocityThreshold, VelocityWindow};
pub use summary::{EventSummary, MainSequence, main_sequence};

use super::{GazeError, GazeSample, setting};
use segments::Track;
use serde::{Deserialize, Serialize};

/// How events are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Detector {
    /// A fixed velocity threshold.
    VelocityThreshold(VelocityThreshold),
    /// A threshold from the velocities' own spread.
    EngbertKliegl(EngbertKliegl),
}

/// How events are found, and what is left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventConfig {
    /// The detector.
    pub detector: Detector,
    /// No event spans a time without valid samples that is longer than this, seconds, or than one and a half median
    /// intervals where that is more.
    ///
    /// The default, 20 ms, is our choice: shorter than a saccade of any size (Carpenter 1988: 21 ms and 2.2 ms/deg), so
    /// that none hides whole in what is bridged.
    pub max_gap_s: f64,
    /// Fixations shorter than this are dropped, seconds. The default, 60 ms, is that of Tobii's I-VT filter (Olsen 2012).
    pub min_fixation_s: f64,
}

impl EventConfig {
    /// I-VT with its defaults: 30°/s over 20 ms, fixations within 75 ms and 0.5° merged.
    #[must_use]
    pub fn velocity_threshold() -> Self {
        Self::new(Detector::VelocityThreshold(VelocityThreshold::default()))
    }

    /// Engbert & Kliegl with its defaults: λ = 6, at least 3 samples and 6 ms.
    #[must_use]
    pub fn engbert_kliegl() -> Self {
        Self::new(Detector::EngbertKliegl(EngbertKliegl::default()))
    }

    fn new(detector: Detector) -> Self {
        Self { detector, max_gap_s: 0.02, min_fixation_s: 0.06 }
    }

    fn check(&self) -> Result<(), GazeError> {
        setting("max_gap_s", "seconds from 0 to 1", self.max_gap_s, [0.0, 1.0])?;
        setting("min_fixation_s", "seconds from 0 to 10", self.min_fixation_s, [0.0, 10.0])?;
        match &self.detector {
            Detector::VelocityThreshold(detector) => detector.check(),
            Detector::EngbertKliegl(detector) => detector.check(),
        }
    }
}

/// A saccade; angles in degrees, times in seconds from the session's start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Saccade {
    /// First sample above threshold.
    pub onset_s: f64,
    /// Last sample above threshold.
    pub offset_s: f64,
    /// From onset to offset; zero for one sample.
    pub duration_s: f64,
    /// True angle from the last sample before the onset to the first one after the offset. What a movement covers
    /// below the threshold is not in it: at 30°/s a saccade of half a degree comes out a sixth too small.
    pub amplitude_deg: f64,
    /// The largest extent of the samples from onset to offset, `hypot` of right and up: Engbert & Kliegl's amplitude,
    /// which an overshoot does not shorten.
    pub excursion_deg: f64,
    /// The largest velocity, deg/s, as smooth as the detector's velocities are.
    pub peak_velocity_deg_s: f64,
    /// Direction of the amplitude, degrees anticlockwise from rightwards, −180 to 180.
    pub direction_deg: f64,
    /// Where it began, degrees right and up of the display's centre.
    pub from_deg: [f64; 2],
    /// Where it ended.
    pub to_deg: [f64; 2],
    /// Whether its begin and end were both seen: false next to a gap or to the recording's ends.
    pub complete: bool,
}

/// A fixation; angles in degrees, times in seconds from the session's start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fixation {
    /// First sample.
    pub onset_s: f64,
    /// Last sample.
    pub offset_s: f64,
    /// From onset to offset.
    pub duration_s: f64,
    /// Direction of the mean of its samples, degrees right and up of the display's centre.
    pub centroid_deg: [f64; 2],
    /// Extent right plus extent up (the dispersion of Salvucci & Goldberg 2000).
    pub dispersion_deg: f64,
    /// Root mean square distance of its samples from the centroid.
    pub sd_deg: f64,
    /// Samples.
    pub samples: usize,
    /// Whether its begin and end were both seen.
    pub complete: bool,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Events {
    /// How.
    pub config: EventConfig,
    /// In order of time.
    pub saccades: Vec<Saccade>,
    /// In order of time.
    pub fixations: Vec<Fixation>,
    /// Stretches that were searched: valid samples without a gap above the limit.
    pub segments: usize,
    /// Their length together, seconds.
    pub searched_s: f64,
    /// One over the median interval between samples, Hz.
    pub rate_hz: Option<f64>,
    /// The longest time between valid samples that was bridged at all: the configured one, or more at low rates, seconds.
    pub bridged_up_to_s: f64,
    /// Valid samples that were passed over because the one before has the same time, to a nanosecond.
    pub repeated_times: usize,
    /// The noise that Engbert & Kliegl's thresholds come from.
    pub noise: Option<VelocityNoise>,
    /// What these data cannot show, in plain words.
    pub limits: Vec<String>,
}

/// Saccades and fixations of one eye's samples (or of both eyes' combined).
///
/// ```
/// use analysis::gaze::GazeSample;
/// use analysis::gaze::events::{EventConfig, detect};
///
/// // Half a second at rest, 10° to the right within 42 ms by a minimum-jerk movement, half a second at rest.
/// let place = |t: f64| {
///     let u = ((t - 0.5) / 0.042).clamp(0.0, 1.0);
///     [10.0 * u * u * u * (10.0 + u * (6.0 * u - 15.0)), 0.0]
/// };
/// let samples: Vec<GazeSample> = (0..1042)
///     .map(|i| f64::from(i) * 0.001)
///     .map(|t_s| GazeSample { t_s, position_deg: place(t_s), deviation_deg: 0.0, valid: true })
///     .collect();
/// let events = detect(&samples, &EventConfig::velocity_threshold())?;
/// assert_eq!((events.saccades.len(), events.fixations.len()), (1, 2));
/// assert!((events.saccades[0].amplitude_deg - 10.0).abs() < 0.1);
/// # Ok::<(), analysis::gaze::GazeError>(())
/// ```
///
/// # Errors
/// When times are not finite or go back, or a setting is out of its range. Too few samples give no events.
pub fn detect(samples: &[GazeSample], config: &EventConfig) -> Result<Events, GazeError> {
    config.check()?;
    let track = Track::new(samples, config.max_gap_s)?;
    let (found, noise) = match &config.detector {
        Detector::VelocityThreshold(detector) => (detector.detect(&track, config.min_fixation_s), None),
        Detector::EngbertKliegl(detector) => detector.detect(&track, config.min_fixation_s),
    };
    let rate_hz = track.interval_s.map(f64::recip);
    Ok(Events {
        config: *config,
        saccades: found.saccades,
        fixations: found.fixations,
        segments: track.segments.len(),
        searched_s: track.searched_s(),
        rate_hz,
        bridged_up_to_s: track.bridged_up_to_s,
        repeated_times: track.repeated_times,
        noise,
        limits: rate_hz.map_or_else(Vec::new, |rate| limits(rate, &config.detector)),
    })
}

/// What a detector found.
#[derive(Debug, Default)]
struct Found {
    saccades: Vec<Saccade>,
    fixations: Vec<Fixation>,
}

/// What a sampling rate cannot show. The bounds: a microsaccade of 25 ms needs the five samples of a velocity within
/// it, about 200 Hz; peak velocities need some 300 Hz (Juhola, Jäntti & Pyykkö 1985).
fn limits(rate_hz: f64, detector: &Detector) -> Vec<String> {
    let mut limits = Vec::new();
    let interval_ms = 1e3 / rate_hz;
    let (is_engbert_kliegl, smoothed_ms) = match detector {
        Detector::EngbertKliegl(_) => (true, 4.0 * interval_ms),
        Detector::VelocityThreshold(detector) => (false, detector.window.length_s(1.0 / rate_hz) * 1e3),
    };
    if rate_hz < 300.0 {
        limits.push(format!(
            "At {rate_hz:.0} Hz onsets and offsets are known to about {interval_ms:.0} ms; velocities are averages over \
             {smoothed_ms:.0} ms, so peak velocities come out too low, most of all those of small saccades."
        ));
    }
    if is_engbert_kliegl && rate_hz < 200.0 {
        limits.push(format!(
            "At {rate_hz:.0} Hz a velocity of five samples spans {smoothed_ms:.0} ms, as long as a microsaccade or \
             longer: microsaccades are missed, and a count of them is no result."
        ));
    }
    limits
}
