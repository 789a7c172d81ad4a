//! Trials held against a rule: which of them fail it, and why, in words.
//!
//! Flagging leaves nothing out and changes no number; [`super::exclusion`] does that, on request and with a report. A
//! limit that a trial has no data for is not met silently: the report says what could not be judged.

use super::trials::{TrialTiming, measure_trials};
use crate::gaze::{GazeError, TrialId, TrialTrace, setting};
use serde::{Deserialize, Serialize};

/// The limits that a trial must keep; a limit of `None` is not applied.
///
/// Everything but `max_missed_frames` is a ratio, time or angle that does not depend on how long a trial is. The default
/// is [`FlagRule::suggested`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlagRule {
    /// At most so many missed frames while a stimulus was shown.
    pub max_missed_frames: Option<usize>,
    /// At most this share of the frames that showed a stimulus missed, 0–1.
    pub max_missed_share: Option<f64>,
    /// No longer interval between two frames of a stimulus, seconds.
    pub max_interval_s: Option<f64>,
    /// 95 % of the frames that showed a stimulus were drawn for gaze no older than this, seconds of software time.
    pub max_gaze_age_p95_s: Option<f64>,
    /// At most this share of the stimulus time without a valid gaze sample, 0–1.
    pub max_lost_share: Option<f64>,
    /// The median angle between gaze and target is no larger, degrees.
    pub max_median_deviation_deg: Option<f64>,
    /// At most this share of the samples farther than `region_deg` from the target, 0–1.
    pub max_outside_share: Option<f64>,
    /// The radius that `max_outside_share` speaks of, degrees.
    pub region_deg: f64,
}

impl Default for FlagRule {
    fn default() -> Self {
        Self::suggested()
    }
}

/// One of a rule's limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Missed frames.
    MissedFrames,
    /// Share of frames missed.
    MissedShare,
    /// Longest interval between frames.
    Interval,
    /// Age of the gaze.
    GazeAge,
    /// Gaze lost.
    GazeLoss,
    /// Median deviation from the target.
    Deviation,
    /// Share of samples away from the target.
    Outside,
}

/// Why a trial is flagged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reason {
    /// Which limit.
    pub criterion: Criterion,
    /// What was found, in the limit's unit.
    pub found: f64,
    /// The limit.
    pub limit: f64,
    /// The same in words.
    pub words: String,
}

/// A trial that fails a rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlaggedTrial {
    /// Which trial.
    pub id: TrialId,
    /// Its condition.
    pub condition: String,
    /// Every limit that it breaks.
    pub reasons: Vec<Reason>,
}

/// A limit for which some trials had no data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NotJudged {
    /// Which limit.
    pub criterion: Criterion,
    /// The trials.
    pub trials: Vec<TrialId>,
    /// Why, in words.
    pub words: String,
}

/// Trials held against a rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlagReport {
    /// The rule.
    pub rule: FlagRule,
    /// Every trial in numbers, flagged or not, in the order given.
    pub trials: Vec<TrialTiming>,
    /// Those that fail, in the order given.
    pub flagged: Vec<FlaggedTrial>,
    /// What could not be judged.
    pub not_judged: Vec<NotJudged>,
}

impl FlagRule {
    /// No limits at all.
    #[must_use]
    pub fn without_limits() -> Self {
        Self {
            max_missed_frames: None,
            max_missed_share: None,
            max_interval_s: None,
            max_gaze_age_p95_s: None,
            max_lost_share: None,
            max_median_deviation_deg: None,
            max_outside_share: None,
            region_deg: 2.0,
        }
    }

    /// The limits that we suggest.
    ///
    /// - 5 % of the stimulus' frames missed: our choice.
    /// - Gaze no older than 50 ms in 95 % of frames. Albert et al. (2017) found 50–70 ms from eye to light tolerable for
    ///   foveated rendering, and 80–150 ms harmful; Loschky & Wolverton (2007) that a change up to 60 ms after a
    ///   saccade goes unnoticed. The age here is without the display's own delay, so the lower end is taken.
    /// - 20 % of the stimulus' time without gaze: our choice.
    /// - A median deviation of 2°, the fixation gate of the studies that ship: our choice.
    #[must_use]
    pub fn suggested() -> Self {
        Self {
            max_missed_share: Some(0.05),
            max_gaze_age_p95_s: Some(0.05),
            max_lost_share: Some(0.2),
            max_median_deviation_deg: Some(2.0),
            ..Self::without_limits()
        }
    }

    /// The rule in words, one sentence for each limit.
    #[must_use]
    pub fn in_words(&self) -> Vec<String> {
        self.limits().map(|(criterion, limit)| self.sentence(criterion, limit)).collect()
    }

    fn sentence(&self, criterion: Criterion, limit: f64) -> String {
        match criterion {
            Criterion::MissedFrames => format!("At most {limit} frames missed while a stimulus is shown."),
            Criterion::MissedShare => {
                format!("At most {} of a stimulus' frames missed.", percent(limit))
            }
            Criterion::Interval => format!("No interval between a stimulus' frames longer than {}.", ms(limit)),
            Criterion::GazeAge => {
                format!("Gaze no older than {} (software time) in 95 % of a stimulus' frames.", ms(limit))
            }
            Criterion::GazeLoss => format!("At most {} of a stimulus' time without valid gaze.", percent(limit)),
            Criterion::Deviation => format!("A median deviation from the target of at most {limit}°."),
            Criterion::Outside => {
                format!("At most {} of samples farther than {}° from the target.", percent(limit), self.region_deg)
            }
        }
    }

    /// The limits that apply.
    fn limits(&self) -> impl Iterator<Item = (Criterion, f64)> {
        [
            (Criterion::MissedFrames, self.max_missed_frames.map(|n| n as f64)),
            (Criterion::MissedShare, self.max_missed_share),
            (Criterion::Interval, self.max_interval_s),
            (Criterion::GazeAge, self.max_gaze_age_p95_s),
            (Criterion::GazeLoss, self.max_lost_share),
            (Criterion::Deviation, self.max_median_deviation_deg),
            (Criterion::Outside, self.max_outside_share),
        ]
        .into_iter()
        .filter_map(|(criterion, limit)| Some((criterion, limit?)))
    }

    fn check(&self) -> Result<(), GazeError> {
        for (criterion, limit) in self.limits() {
            match criterion {
                Criterion::MissedFrames => Ok(()),
                Criterion::MissedShare => setting("max_missed_share", "a share from 0 to 1", limit, [0.0, 1.0]),
                Criterion::Interval => setting("max_interval_s", "seconds from 0 to 1000", limit, [0.0, 1e3]),
                Criterion::GazeAge => setting("max_gaze_age_p95_s", "seconds from 0 to 10", limit, [0.0, 10.0]),
                Criterion::GazeLoss => setting("max_lost_share", "a share from 0 to 1", limit, [0.0, 1.0]),
                Criterion::Deviation => {
                    setting("max_median_deviation_deg", "degrees from 0 to 180", limit, [0.0, 180.0])
                }
                Criterion::Outside => setting("max_outside_share", "a share from 0 to 1", limit, [0.0, 1.0]),
            }?;
        }
        Ok(())
    }
}

/// Trials held against a rule; a trial is flagged when it is beyond any limit, not when it is at it.
///
/// ```
/// use analysis::gaze::{TrialId, TrialTrace};
/// use analysis::timing::Frame;
/// use analysis::timing::flags::{FlagRule, flag_trials};
///
/// let frame = |i: u32| Frame {
///     presented_s: f64::from(i) / 60.0,
///     missed: i % 5 == 0,
///     gaze_age_s: Some(0.012),
///     after_gap: i == 0,
/// };
/// let trace = TrialTrace {
///     id: TrialId { session: "P01".into(), trial: 7 },
///     condition: "near".into(),
///     samples: Vec::new(),
///     frames: (0..30).map(frame).collect(),
///     stimulus_s: vec![[0.0, 0.5]],
///     target: None,
/// };
/// let report = flag_trials(&[trace], &FlagRule::suggested())?;
/// assert_eq!(
///     report.flagged[0].reasons[0].words,
///     "6 of 30 frames (20.0 %) missed while a stimulus was shown; the limit is 5.0 %."
/// );
/// // There was no gaze to judge: said, not passed over.
/// assert_eq!(report.not_judged.len(), 2);
/// # Ok::<(), analysis::gaze::GazeError>(())
/// ```
///
/// # Errors
/// As [`measure_trials`]; and for limits out of range.
pub fn flag_trials(traces: &[TrialTrace], rule: &FlagRule) -> Result<FlagReport, GazeError> {
    rule.check()?;
    let trials = measure_trials(traces, rule.region_deg)?;
    let mut flagged = Vec::new();
    let mut not_judged: Vec<NotJudged> = Vec::new();
    for trial in &trials {
        let mut reasons = Vec::new();
        for (criterion, limit) in rule.limits() {
            match found(trial, criterion) {
                Some(found) if found > limit => {
                    let words = words(trial, rule, criterion, found, limit);
                    reasons.push(Reason { criterion, found, limit, words });
                }
                Some(_) => {}
                None => match not_judged.iter_mut().find(|other| other.criterion == criterion) {
                    Some(other) => other.trials.push(trial.id.clone()),
                    None => {
                        not_judged.push(NotJudged { criterion, trials: vec![trial.id.clone()], words: String::new() });
                    }
                },
            }
        }
        if !reasons.is_empty() {
            flagged.push(FlaggedTrial { id: trial.id.clone(), condition: trial.condition.clone(), reasons });
        }
    }
    for unjudged in &mut not_judged {
        unjudged.words = missing(unjudged.criterion, unjudged.trials.len(), trials.len());
    }
    Ok(FlagReport { rule: *rule, trials, flagged, not_judged })
}

/// What a trial has to show for a criterion; `None` without data.
fn found(trial: &TrialTiming, criterion: Criterion) -> Option<f64> {
    let frames = (trial.frames > 0).then_some(trial.frames as f64);
    match criterion {
        Criterion::MissedFrames => frames.map(|_| trial.missed as f64),
        Criterion::MissedShare => frames.map(|frames| trial.missed as f64 / frames),
        Criterion::Interval => trial.longest_interval_s,
        Criterion::GazeAge => trial.gaze_age_p95_s,
        Criterion::GazeLoss => trial.lost_share,
        Criterion::Deviation => trial.median_deviation_deg,
        Criterion::Outside => trial.outside_share,
    }
}

fn words(trial: &TrialTiming, rule: &FlagRule, criterion: Criterion, found: f64, limit: f64) -> String {
    let (missed, frames) = (trial.missed, trial.frames);
    match criterion {
        Criterion::MissedFrames => {
            format!("{missed} of {frames} frames missed while a stimulus was shown; the limit is {limit}.")
        }
        Criterion::MissedShare => format!(
            "{missed} of {frames} frames ({}) missed while a stimulus was shown; the limit is {}.",
            percent(found),
            percent(limit)
        ),
        Criterion::Interval => {
            format!("One frame of a stimulus stayed for {}; the limit is {}.", ms(found), ms(limit))
        }
        Criterion::GazeAge => format!(
            "5 % of the stimulus' frames were drawn for gaze older than {}; the limit is {}.",
            ms(found),
            ms(limit)
        ),
        Criterion::GazeLoss => {
            format!("No valid gaze for {} of the stimulus' time; the limit is {}.", percent(found), percent(limit))
        }
        Criterion::Deviation => {
            format!("The median deviation from the target was {found:.2}°; the limit is {limit}°.")
        }
        Criterion::Outside => format!(
            "{} of samples were farther than {}° from the target; the limit is {}.",
            percent(found),
            rule.region_deg,
            percent(limit)
        ),
    }
}

fn missing(criterion: Criterion, trials: usize, of: usize) -> String {
    let lacking = match criterion {
        Criterion::MissedFrames | Criterion::MissedShare => "no frame that showed a stimulus",
        Criterion::Interval => "fewer than two frames that showed a stimulus",
        Criterion::GazeAge => "no frame that was drawn for a gaze sample",
        Criterion::GazeLoss => "no gaze at all, or no stimulus",
        Criterion::Deviation | Criterion::Outside => "no valid gaze while a target was shown",
    };
    format!("{trials} of {of} trials could not be held against this limit: {lacking}.")
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn ms(seconds: f64) -> String {
    format!("{:.1} ms", 1e3 * seconds)
}
