//! How far the gaze was from where it should have been, by condition, with the trial as the unit.
//!
//! Samples of one trial are anything but independent: at 1000 Hz the eye is now where it was a millisecond ago, and an
//! interval computed from thousands of samples would be far too narrow. So moments and percentiles describe the pooled
//! samples, and the only interval given is that of the mean of per-trial means, by Student's t over trials.

use super::direction::{Direction, angle_deg, direction_from_deg};
use super::order::quantile_in_place;
use super::quality::direction_of;
use super::{GazeError, GazeSample, Target, TrialTrace, setting};
use crate::shares::Mean;
use serde::{Deserialize, Serialize};

/// What counts as close to the target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DeviationConfig {
    /// Radius of the region around the target whose share of samples is counted, degrees. The default, 2°, is our
    /// choice: the fixation gate of the studies that ship.
    pub region_deg: f64,
}

impl Default for DeviationConfig {
    fn default() -> Self {
        Self { region_deg: 2.0 }
    }
}

/// Deviation from the target over some trials; angles in degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// Trials with at least one usable sample.
    pub trials: usize,
    /// Trials of the condition without any: free viewing, or gaze lost throughout.
    pub trials_without: usize,
    /// Usable samples: valid, within a stimulus window, while a target was shown.
    pub samples: usize,
    /// Mean over samples.
    pub mean_deg: Option<f64>,
    /// Standard deviation over samples (n − 1); it describes them and gives no error of the mean.
    pub sd_deg: Option<f64>,
    /// Root mean square over samples.
    pub rms_deg: Option<f64>,
    /// Percentiles over samples: 5, 25, 50, 75, 95.
    pub percentiles_deg: Option<Percentiles>,
    /// Mean over trials of each trial's mean, every trial counting once, with its 95 % interval by Student's t.
    pub trial_mean_deg: Option<Mean>,
    /// Share of samples within the region, 0–1.
    pub inside_share: Option<f64>,
    /// Mean over trials of each trial's share; the interval by Student's t is cut to 0–1.
    pub trial_inside_share: Option<Mean>,
}

/// Percentiles (Hyndman and Fan's type 7), degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// 5 % of samples are below.
    pub p5: f64,
    /// 25 %.
    pub p25: f64,
    /// The median.
    pub p50: f64,
    /// 75 %.
    pub p75: f64,
    /// 95 %.
    pub p95: f64,
}

/// The deviation of one condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionDeviation {
    /// The condition.
    pub condition: String,
    /// Its deviation.
    pub deviation: Deviation,
}

/// Deviation from the target by condition and over all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeviationReport {
    /// What counted as close.
    pub config: DeviationConfig,
    /// In the order in which conditions first appear.
    pub conditions: Vec<ConditionDeviation>,
    /// All trials together.
    pub all: Deviation,
}

/// The angle between gaze and target by condition, over the trials' stimulus windows.
///
/// # Errors
/// When a trial's times go back or are not finite, its windows overlap, or the region is not 0–180°.
pub fn deviation_by_condition(trials: &[TrialTrace], config: &DeviationConfig) -> Result<DeviationReport, GazeError> {
    setting("region_deg", "degrees from 0 to 180", config.region_deg, [0.0, 180.0])?;
    let of_trials: Vec<Vec<f64>> = trials.iter().map(deviations_deg).collect::<Result<_, _>>()?;
    let mut order: Vec<(&str, Vec<&[f64]>)> = Vec::new();
    for (trial, deviations) in trials.iter().zip(&of_trials) {
        match order.iter_mut().find(|(condition, _)| *condition == trial.condition) {
            Some((_, of_condition)) => of_condition.push(deviations),
            None => order.push((&trial.condition, vec![deviations])),
        }
    }
    let all: Vec<&[f64]> = of_trials.iter().map(Vec::as_slice).collect();
    Ok(DeviationReport {
        config: *config,
        conditions: order
            .into_iter()
            .map(|(condition, of_trials)| ConditionDeviation {
                condition: condition.to_owned(),
                deviation: summed_up(&of_trials, config.region_deg),
            })
            .collect(),
        all: summed_up(&all, config.region_deg),
    })
}

/// The angle between gaze and target of every usable sample of a trial: valid, within a stimulus window, while a target
/// was shown. Empty without a target.
///
/// # Errors
/// When the trial's times go back or are not finite, or its windows overlap.
pub fn deviations_deg(trial: &TrialTrace) -> Result<Vec<f64>, GazeError> {
    trial.check()?;
    let Some(target) = &trial.target else { return Ok(Vec::new()) };
    let mut follower = Follower::new(target);
    let angle = |sample: &GazeSample| Some(angle_deg(direction_of(sample)?, follower.at(sample.t_s)?));
    Ok(trial.windows().flat_map(|(_, samples)| samples).filter_map(angle).collect())
}

/// Walks along a target's path as time goes on, so that all samples together cost one pass.
struct Follower<'a> {
    target: &'a Target,
    next: usize,
    here: Option<Direction>,
}

impl<'a> Follower<'a> {
    fn new(target: &'a Target) -> Self {
        let here = if let Target::Fixed(place) = target { direction_from_deg(*place) } else { None };
        Self { target, next: 0, here }
    }

    /// Where the target is at a time no earlier than the last one asked for.
    fn at(&mut self, t_s: f64) -> Option<Direction> {
        if let Target::Moving(places) = self.target {
            let passed = places[self.next..].iter().take_while(|place| place.t_s <= t_s).count();
            if passed > 0 {
                self.next += passed;
                self.here = direction_from_deg(places[self.next - 1].position_deg);
            }
        }
        self.here
    }
}

fn summed_up(of_trials: &[&[f64]], region_deg: f64) -> Deviation {
    let inside = |deviations: &[f64]| deviations.iter().filter(|d| **d <= region_deg).count() as f64;
    let usable: Vec<&[f64]> = of_trials.iter().copied().filter(|deviations| !deviations.is_empty()).collect();
    let mut pooled: Vec<f64> = usable.concat();
    let n = pooled.len() as f64;
    let some = !pooled.is_empty();
    let mean = some.then(|| pooled.iter().sum::<f64>() / n);
    let inside_share = some.then(|| inside(&pooled) / n);
    let squares = |from: f64| pooled.iter().map(|d| (d - from).powi(2)).sum::<f64>();
    let sd_deg = mean.filter(|_| n > 1.0).map(|mean| (squares(mean) / (n - 1.0)).sqrt());
    let rms_deg = some.then(|| (squares(0.0) / n).sqrt());
    Deviation {
        trials: usable.len(),
        trials_without: of_trials.len() - usable.len(),
        samples: pooled.len(),
        mean_deg: mean,
        sd_deg,
        rms_deg,
        percentiles_deg: percentiles(&mut pooled),
        trial_mean_deg: Mean::new(usable.iter().map(|d| d.iter().sum::<f64>() / d.len() as f64)),
        inside_share,
        trial_inside_share: Mean::new(usable.iter().map(|d| inside(d) / d.len() as f64))
            .map(|mean| Mean { ci95: mean.ci95.map(|ci| ci.map(|end| end.clamp(0.0, 1.0))), ..mean }),
    }
}

fn percentiles(values: &mut [f64]) -> Option<Percentiles> {
    let mut at = |q| quantile_in_place(values, q);
    Some(Percentiles { p5: at(0.05)?, p25: at(0.25)?, p50: at(0.5)?, p75: at(0.75)?, p95: at(0.95)? })
}
