//! Data quality as the field reports it for an eye tracker: accuracy, precision, data loss, sampling rate and gaps.
//!
//! The terms are those of Holmqvist et al. (2011, chapter 2) and Niehorster et al. (2020). Quality is measured over a
//! window in which the eye was asked to rest on one place, as in a validation; over a window with saccades the spread
//! is that of the eye and not of the tracker. Where the gaze was relative to a moving target is [`super::deviation`]'s.

use super::direction::{Direction, Plane, angle_deg, direction_from_deg, mean_direction, squared_angle_deg2};
use super::order::{SAME_TIME_S, intervals_s, median_in_place};
use super::trace::{check_times, within};
use super::{GazeError, GazeSample, Target, TrialId, TrialTrace, setting};
use serde::{Deserialize, Serialize};

/// Intervals up to this many median intervals belong to an unbroken recording: timing jitters, and one lost sample
/// makes two.
pub(crate) const BROKEN_AFTER_INTERVALS: f64 = 1.5;

/// The share of a bivariate normal distribution within one standard deviation of a normal one, as BCEA commonly uses.
pub const ONE_SD_SHARE: f64 = 0.6827;

/// What quality is measured against.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct QualityConfig {
    /// Where the eye was asked to look, degrees right and up of the display's centre; without it there is no accuracy.
    pub target_deg: Option<[f64; 2]>,
    /// From (included) and to (not included), seconds; without it from the first sample to one interval after the last.
    pub window_s: Option<[f64; 2]>,
    /// The tracker's nominal rate, Hz; without it no loss of expected samples can be told.
    pub nominal_rate_hz: Option<f64>,
    /// Gaps longer than this are listed, seconds. The default, 75 ms, is what Tobii's I-VT filter interpolates at most
    /// (Olsen 2012).
    pub gap_over_s: f64,
}

impl Default for QualityConfig {
    fn default() -> Self {
        Self { target_deg: None, window_s: None, nominal_rate_hz: None, gap_over_s: 0.075 }
    }
}

/// The quality of the samples of one window; angles in degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataQuality {
    /// What it was measured against.
    pub config: QualityConfig,
    /// Samples in the window, valid or not.
    pub samples: usize,
    /// Samples with a valid, finite place on the display's plane.
    pub valid: usize,
    /// Length of the window, seconds.
    pub duration_s: f64,
    /// Offset from the target; `None` without target or valid samples.
    pub accuracy: Option<Accuracy>,
    /// Spread; `None` for fewer than two valid samples.
    pub precision: Option<Precision>,
    /// What was lost.
    pub loss: Loss,
    /// How often samples came.
    pub rate: Rate,
    /// When there were none.
    pub gaps: Gaps,
}

/// How far the gaze was from where it was asked to be, as true angles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Angle between the mean direction and the target: the field's accuracy (Holmqvist et al. 2011). Noise averages
    /// out of it.
    pub offset_of_mean_deg: f64,
    /// The way from the target to the mean direction: right, up. Its length is `offset_of_mean_deg`.
    pub bias_deg: [f64; 2],
    /// Mean over samples of the angle to the target; noise adds to it.
    pub mean_offset_deg: f64,
    /// Median over samples of the angle to the target.
    pub median_offset_deg: f64,
}

/// How much the gaze scattered, around its mean direction and from sample to sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Precision {
    /// Root mean square of the angle between successive samples, over pairs with no lost sample between; `None` if
    /// there is no such pair.
    pub rms_s2s_deg: Option<f64>,
    /// Root mean square distance from the mean place: `hypot` of `sd_axes_deg`.
    pub sd_deg: f64,
    /// Standard deviation right and up (÷ n), in the plane that touches the mean direction.
    pub sd_axes_deg: [f64; 2],
    /// Bivariate contour ellipse.
    pub bcea: Bcea,
}

/// The bivariate contour ellipse of some places (Steinman 1965; Crossland & Rubin 2002).
///
/// Area = 2 k π s_x s_y √(1 − ρ²) with P = 1 − exp(−k), standard deviations with n − 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bcea {
    /// Area that holds 68.27 % of a bivariate normal distribution, square degrees; k = 1.148.
    pub area_68_deg2: f64,
    /// Area that holds 95 % of it, square degrees; k = 2.996.
    pub area_95_deg2: f64,
    /// Correlation of right and up; `None` where one of them does not vary, and the ellipse is a line without area.
    pub correlation: Option<f64>,
    /// Direction of the longer axis, degrees anticlockwise from rightwards, −90 to 90; `None` for a circle or a point.
    pub orientation_deg: Option<f64>,
    /// Half the longer and half the shorter axis of the 68.27 % ellipse, degrees.
    pub half_axes_68_deg: [f64; 2],
}

/// Samples that are missing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Loss {
    /// Share of the window's samples that are not valid, 0–1; `None` without samples.
    pub invalid_share: Option<f64>,
    /// Share of the samples that the nominal rate promises for the window and that did not come or are not valid. It
    /// is below zero where more came than promised. `None` without a nominal rate or for a window without length.
    pub missing_of_expected_share: Option<f64>,
}

/// How often samples came, valid or not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// One over the median interval between samples, Hz; pauses do not lower it.
    pub from_median_hz: Option<f64>,
    /// Valid samples per second of the window, Hz.
    pub effective_hz: Option<f64>,
    /// Standard deviation (÷ n) of the intervals that are no more than 1.5 median ones: the jitter, seconds.
    pub interval_sd_s: Option<f64>,
    /// Samples with the same time as the one before, to a nanosecond.
    pub repeated_times: usize,
}

/// A stretch without a valid sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// The last valid sample before it, or the window's start, seconds.
    pub start_s: f64,
    /// From there to the next valid sample or the window's end, seconds.
    pub duration_s: f64,
}

/// Stretches without a valid sample: longer than 1.5 median intervals from one valid sample (or the window's start) to
/// the next (or its end).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gaps {
    /// All of them, however short.
    pub count: usize,
    /// The longest, however short.
    pub longest: Option<Gap>,
    /// Those longer than the configured length, in order of time.
    pub long: Vec<Gap>,
    /// Time in all gaps beyond the one interval that would have been there anyway, as a share of the window, 0–1.
    pub time_share: f64,
}

/// The quality of the samples in a window.
///
/// ```
/// use analysis::gaze::GazeSample;
/// use analysis::gaze::quality::{QualityConfig, data_quality};
///
/// // A thousandth of a second apart, one degree to the right of the target.
/// let samples: Vec<GazeSample> = (0..500)
///     .map(|i| GazeSample {
///         t_s: f64::from(i) * 0.001,
///         position_deg: [1.0, 0.0],
///         deviation_deg: 1.0,
///         valid: i % 10 != 0,
///     })
///     .collect();
/// let config = QualityConfig { target_deg: Some([0.0, 0.0]), ..QualityConfig::default() };
/// let quality = data_quality(&samples, &config)?;
/// assert!((quality.accuracy.unwrap().offset_of_mean_deg - 1.0).abs() < 1e-9);
/// assert_eq!(quality.loss.invalid_share, Some(0.1));
/// # Ok::<(), analysis::gaze::GazeError>(())
/// ```
///
/// # Errors
/// When times are not finite or go back, or the configuration is out of range.
pub fn data_quality(samples: &[GazeSample], config: &QualityConfig) -> Result<DataQuality, GazeError> {
    check_times(samples.iter().map(|sample| sample.t_s))?;
    check_config(config)?;
    let samples = config.window_s.map_or(samples, |window_s| within(samples, window_s));

    // One pass for what needs directions, in the order of the samples.
    let directions: Vec<Option<Direction>> = samples.iter().map(direction_of).collect();
    let valid = directions.iter().flatten().count();
    let mut intervals = intervals_s(samples);
    let interval_s = median_in_place(&mut intervals);
    let window_s = config.window_s.or_else(|| {
        let (first, last) = (samples.first()?, samples.last()?);
        Some([first.t_s, last.t_s + interval_s.unwrap_or(0.0)])
    });
    let duration_s = window_s.map_or(0.0, |[from_s, to_s]| to_s - from_s);
    let promised = config.nominal_rate_hz.map(|rate| rate * duration_s).filter(|n| *n > 0.0);
    let mean = mean_direction(directions.iter().copied().flatten());

    Ok(DataQuality {
        config: *config,
        samples: samples.len(),
        valid,
        duration_s,
        accuracy: mean
            .zip(config.target_deg.and_then(direction_from_deg))
            .map(|(m, target)| accuracy(&directions, m, target)),
        precision: mean.and_then(|mean| precision(samples, &directions, mean, interval_s)),
        loss: Loss {
            invalid_share: (!samples.is_empty()).then(|| (samples.len() - valid) as f64 / samples.len() as f64),
            missing_of_expected_share: promised.map(|promised| 1.0 - valid as f64 / promised),
        },
        rate: Rate {
            from_median_hz: interval_s.map(f64::recip),
            effective_hz: (duration_s > 0.0).then(|| valid as f64 / duration_s),
            interval_sd_s: interval_s.and_then(|median_s| jitter_s(&intervals, median_s)),
            repeated_times: samples.windows(2).filter(|pair| pair[1].t_s - pair[0].t_s <= SAME_TIME_S).count(),
        },
        gaps: window_s.map_or_else(Gaps::none, |window_s| {
            let seen = samples.iter().zip(&directions).filter(|(_, d)| d.is_some()).map(|(sample, _)| sample.t_s);
            gaps(seen, window_s, interval_s.unwrap_or(0.0), config.gap_over_s)
        }),
    })
}

/// The quality of one trial's stimulus windows, joined.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialQuality {
    /// Which trial.
    pub id: TrialId,
    /// Its condition.
    pub condition: String,
    /// One for each stimulus window, in order.
    pub windows: Vec<DataQuality>,
}

/// Data quality of every stimulus window of every trial; a fixed target is the trial's, a moving one gives no accuracy.
///
/// # Errors
/// As [`data_quality`], naming the trial; and for windows that overlap or are empty.
pub fn quality_by_trial(trials: &[TrialTrace], config: &QualityConfig) -> Result<Vec<TrialQuality>, GazeError> {
    trials
        .iter()
        .map(|trial| {
            trial.check()?;
            let target_deg = match trial.target {
                Some(Target::Fixed(place)) => Some(place),
                _ => None,
            };
            let windows = trial
                .windows()
                .map(|(window_s, samples)| {
                    data_quality(samples, &QualityConfig { target_deg, window_s: Some(window_s), ..*config })
                })
                .collect::<Result<_, _>>()
                .map_err(|error| GazeError::Trial { trial: trial.id.to_string(), error: Box::new(error) })?;
            Ok(TrialQuality { id: trial.id.clone(), condition: trial.condition.clone(), windows })
        })
        .collect()
}

fn check_config(config: &QualityConfig) -> Result<(), GazeError> {
    setting("gap_over_s", "seconds from 0 to 3600", config.gap_over_s, [0.0, 3600.0])?;
    if let Some(rate) = config.nominal_rate_hz {
        setting("nominal_rate_hz", "hertz from 1 to 100000", rate, [1.0, 1e5])?;
    }
    for axis in config.target_deg.iter().flatten() {
        setting("target_deg", "degrees from -89 to 89", *axis, [-89.0, 89.0])?;
    }
    match config.window_s {
        Some([from_s, to_s]) if !(from_s.is_finite() && to_s.is_finite() && from_s < to_s) => {
            Err(GazeError::Window { from_s, to_s })
        }
        _ => Ok(()),
    }
}

/// Where a sample points; `None` when it is lost.
pub(crate) fn direction_of(sample: &GazeSample) -> Option<Direction> {
    if sample.valid { direction_from_deg(sample.position_deg) } else { None }
}

fn accuracy(directions: &[Option<Direction>], mean: Direction, target: Direction) -> Accuracy {
    let mut offsets: Vec<f64> = directions.iter().flatten().map(|&direction| angle_deg(direction, target)).collect();
    Accuracy {
        offset_of_mean_deg: angle_deg(mean, target),
        bias_deg: Plane::new(target).step_deg(mean),
        mean_offset_deg: offsets.iter().sum::<f64>() / offsets.len() as f64,
        median_offset_deg: median_in_place(&mut offsets).unwrap_or(0.0),
    }
}

fn precision(
    samples: &[GazeSample],
    directions: &[Option<Direction>],
    mean: Direction,
    interval_s: Option<f64>,
) -> Option<Precision> {
    let plane = Plane::new(mean);
    // Moments about the mean direction, which is next to the mean place: nothing is lost by correcting afterwards.
    let (mut count, mut sums, mut squared, mut product) = (0u64, [0.0; 2], [0.0; 2], 0.0);
    for &direction in directions.iter().flatten() {
        let [right, up] = plane.step_deg(direction);
        count += 1;
        sums = [sums[0] + right, sums[1] + up];
        squared = [squared[0] + right * right, squared[1] + up * up];
        product += right * up;
    }
    if count < 2 {
        return None;
    }
    let n = count as f64;
    let [xx, yy] = [0, 1].map(|axis| (squared[axis] - sums[axis] * sums[axis] / n).max(0.0));
    let xy = product - sums[0] * sums[1] / n;

    let longest_s = interval_s.map_or(f64::INFINITY, |s| BROKEN_AFTER_INTERVALS * s);
    let (mut squares, mut pairs) = (0.0, 0u64);
    for (pair, times) in directions.windows(2).zip(samples.windows(2)) {
        if let [Some(a), Some(b)] = *pair
            && times[1].t_s - times[0].t_s <= longest_s
        {
            squares += squared_angle_deg2(a, b);
            pairs += 1;
        }
    }
    Some(Precision {
        rms_s2s_deg: (pairs > 0).then(|| (squares / pairs as f64).sqrt()),
        sd_deg: ((xx + yy) / n).sqrt(),
        sd_axes_deg: [(xx / n).sqrt(), (yy / n).sqrt()],
        bcea: bcea([xx, yy, xy].map(|sum| sum / (n - 1.0))),
    })
}

/// The ellipse of a covariance matrix: variance right, variance up, covariance.
fn bcea([xx, yy, xy]: [f64; 3]) -> Bcea {
    let k = |share: f64| -(1.0 - share).ln();
    // s_x s_y √(1 − ρ²) is the root of the determinant, which needs no correlation to exist.
    let spread = (xx * yy - xy * xy).max(0.0).sqrt();
    let area = |share: f64| 2.0 * k(share) * std::f64::consts::PI * spread;
    let (half_sum, half_difference) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let half_axis = |variance: f64| (2.0 * k(ONE_SD_SHARE) * variance.max(0.0)).sqrt();
    Bcea {
        area_68_deg2: area(ONE_SD_SHARE),
        area_95_deg2: area(0.95),
        correlation: (xx > 0.0 && yy > 0.0).then(|| (xy / (xx.sqrt() * yy.sqrt())).clamp(-1.0, 1.0)),
        orientation_deg: (half_difference > 1e-12 * half_sum).then(|| (0.5 * (2.0 * xy).atan2(xx - yy)).to_degrees()),
        half_axes_68_deg: [half_axis(half_sum + half_difference), half_axis(half_sum - half_difference)],
    }
}

fn jitter_s(intervals: &[f64], median_s: f64) -> Option<f64> {
    let unbroken = || intervals.iter().filter(|dt| **dt <= BROKEN_AFTER_INTERVALS * median_s);
    let n = unbroken().count() as f64;
    let mean = unbroken().sum::<f64>() / n;
    (n > 0.0).then(|| (unbroken().map(|dt| (dt - mean).powi(2)).sum::<f64>() / n).sqrt())
}

impl Gaps {
    fn none() -> Self {
        Self { count: 0, longest: None, long: Vec::new(), time_share: 0.0 }
    }
}

/// Gaps between the times at which the eye was seen and the window's ends.
pub(crate) fn gaps(seen_s: impl Iterator<Item = f64>, [from_s, to_s]: [f64; 2], interval_s: f64, over_s: f64) -> Gaps {
    let mut gaps = Gaps::none();
    let (mut before_s, mut lost_s) = (from_s, 0.0);
    for t_s in seen_s.chain([to_s]) {
        let gap = Gap { start_s: before_s, duration_s: t_s - before_s };
        before_s = t_s;
        if gap.duration_s <= BROKEN_AFTER_INTERVALS * interval_s || gap.duration_s <= 0.0 {
            continue;
        }
        gaps.count += 1;
        lost_s += gap.duration_s - interval_s;
        if gaps.longest.is_none_or(|longest| gap.duration_s > longest.duration_s) {
            gaps.longest = Some(gap);
        }
        if gap.duration_s > over_s {
            gaps.long.push(gap);
        }
    }
    gaps.time_share = if to_s > from_s { (lost_s / (to_s - from_s)).clamp(0.0, 1.0) } else { 0.0 };
    gaps
}
