//! Thresholds of the pair, ramp and slider tests (Guenter 2012, §5).
//!
//! Pair: the lowest quality index j that the observer reported as equal to or better than the reference. Ramp: the lowest j
//! whose direction was mislabelled, or which was said not to change. Slider: the first j at which the observer stopped
//! going up and compared. Pair and ramp give one number for each observer, the slider one for each trial, of which the
//! paper prints mean and SD over all observers and speeds.
//!
//! What to know about pair and ramp: the result is the *coarsest accident*. Every trial at every level is one more chance of
//! a slip, so that the mean lies below the level that goes unnoticed half of the time (by 1.9 indices for a function 6 wide
//! with two lapses in a hundred, in the paper's design), and by more the more trials there are: an observer who answers for
//! ever ends at the coarsest level. [`Thresholds::expected`] gives the exact distribution for a
//! known function, [`super::against_fit()`] the bias for a fitted one. And since a resample of the trials can only lose the
//! accident, never find a coarser one, a bootstrap over trials is no interval for one observer, and none is given.

mod tally;

pub use tally::{LevelTally, coarsest_unnoticed, is_without_change, went_unnoticed};
pub(super) use tally::{direction_order, unnoticed_once};

use super::first_passed::FirstPassed;
use super::observers::{finite_mean, merged};
use super::{Bootstrap, ObserverRows, OverObservers, Published, Rule, RuleError};
use crate::answers::Row;
use crate::psychometric::{Count, Direction};
use crate::shares::Mean;
use experiments::mar::slope_from_quality_index;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use tally::{coarsest, tally};

/// The renderer parameter that the paper varies.
pub const QUALITY_INDEX: &str = "quality_index";

/// What keeps one observer's threshold without an interval.
pub const NO_INTERVAL: &str = "one observer's threshold is their coarsest single miss: resampled trials can lose it but never \
                               find a coarser one, so that no interval comes from them";

/// Histograms fill whole numbers up to this many bins.
const MOST_BINS: f64 = 64.0;

/// One of the three tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Reference and test one after the other.
    Pair,
    /// Quality that rises or falls.
    Ramp,
    /// Quality raised until it looks like the reference.
    Slider,
}

impl Test {
    /// The test's rule.
    #[must_use]
    pub fn rule(self) -> Rule {
        let source = "Guenter et al. 2012, §5, Study Results";
        match self {
            Self::Pair => Rule::new(
                "pair threshold",
                "The coarsest level that the observer once reported as equal to or better than the reference.",
                source,
            ),
            Self::Ramp => Rule::new(
                "ramp threshold",
                "The coarsest level whose ramp was once given the wrong direction or said not to change.",
                source,
            ),
            Self::Slider => Rule::new(
                "slider threshold",
                "The first level at which the observer stopped going up and compared with the reference.",
                "Guenter et al. 2012, §5, the slider test",
            ),
        }
    }

    /// The published group figure, quality index.
    #[must_use]
    pub fn published(self) -> Published {
        let of = |mean, sd| {
            Published::new("mean threshold, quality index", mean, "Guenter et al. 2012, §5").sd(sd).observers(15)
        };
        match self {
            Self::Pair => of(14.9, 3.07),
            Self::Ramp => of(11.9, 3.48),
            Self::Slider => of(14.5, 4.1).caveat("its SD is over all observers and speeds, not over observers' means"),
        }
    }

    /// The published slope that the group figure, rounded to a whole index, was turned into: 0.0275 from the ramp (target
    /// A), 0.0220 from the pair test (target B); none from the slider.
    #[must_use]
    pub fn published_slope(self) -> Option<Published> {
        let (what, m) = match self {
            Self::Pair => ("slope m of target B, from j = 15", 0.0220),
            Self::Ramp => ("slope m of target A, from j = 12", 0.0275),
            Self::Slider => return None,
        };
        Some(Published::new(what, m, "Guenter et al. 2012, §5, Analysis and Discussion"))
    }
}

/// How a rule is applied.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// The parameter of the level.
    pub parameter: String,
    /// `Falls` where a larger value is finer (the quality index), `Rises` where it is coarser (a slope).
    pub direction: Direction,
    /// For the intervals over observers.
    pub bootstrap: Bootstrap,
}

impl Default for Options {
    fn default() -> Self {
        Self { parameter: QUALITY_INDEX.to_owned(), direction: Direction::Falls, bootstrap: Bootstrap::default() }
    }
}

impl Options {
    /// The options for some trials: the quality index if they have it, or else the first parameter that varies, with the
    /// direction that the answers take.
    #[must_use]
    pub fn of_rows(test: Test, observers: &[ObserverRows<'_>]) -> Self {
        let rows: Vec<&Row> = observers.iter().flat_map(|observer| observer.rows).collect();
        let values = |name: &str| -> BTreeSet<u64> {
            let of = |row: &&Row| if test == Test::Slider { row.found.get(name) } else { row.level.get(name) }.copied();
            rows.iter().filter_map(of).map(f64::to_bits).collect()
        };
        let names: BTreeSet<&str> = match test {
            Test::Slider => {
                rows.iter().flat_map(|row| row.found.keys()).filter_map(|k| k.strip_suffix("_settled")).collect()
            }
            Test::Pair | Test::Ramp => rows.iter().flat_map(|row| row.level.keys()).map(String::as_str).collect(),
        };
        if names.contains(QUALITY_INDEX) {
            return Self::default();
        }
        let varying = names.iter().find(|name| values(name).len() > 1).or_else(|| names.first());
        let Some(parameter) = varying.map(|name| (*name).to_owned()) else { return Self::default() };
        let counts: Vec<Count> = tally(&parameter, rows.iter().copied())
            .iter()
            .map(|level| Count { level: level.level, n: level.n, k: level.n - level.unnoticed })
            .collect();
        let direction = if counts.is_empty() { Direction::Rises } else { Direction::of_counts(&counts) };
        Self { parameter, direction, bootstrap: Bootstrap::default() }
    }
}

/// Where a threshold lies among the levels that were tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// Between coarser levels that were always noticed and finer ones.
    Within,
    /// At the coarsest level that was tried: it might lie beyond.
    Coarsest,
    /// Only a ramp without change was called so: every change was noticed.
    WithoutChange,
    /// Nowhere: every level was always noticed.
    Beyond,
}

/// One observer's threshold by a rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverThreshold {
    /// The observer's code.
    pub observer: String,
    /// The threshold in the parameter's unit: of a slider the mean over its trials.
    pub threshold: Option<f64>,
    /// The slope m that it stands for, degrees per cycle per degree, where the parameter is the quality index (m = 0.33/j).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope: Option<f64>,
    /// Where it lies; nothing for a slider.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<Place>,
    /// Pair and ramp: the answers by level.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tally: Vec<LevelTally>,
    /// Slider: the value of every trial, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<f64>,
    /// Slider: mean, SD and t interval over this observer's trials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_trials: Option<Mean>,
    /// Why there is no interval, if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_interval: Option<String>,
}

/// How many thresholds there are at a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// The level.
    pub level: f64,
    /// Thresholds.
    pub n: usize,
}

/// The slope that a mean threshold stands for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SlopeOfMean {
    /// m, degrees per cycle per degree.
    pub m: f64,
    /// The mean's 95 % t interval through the same law, if it lies above zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
}

/// The thresholds of some observers by one of the rules.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// The test.
    pub test: Test,
    /// Its rule.
    pub rule: Rule,
    /// How it was applied.
    pub options: Options,
    /// Every observer, in alphabetical order.
    pub observers: Vec<ObserverThreshold>,
    /// Over observers; those without a threshold are left out, as they must be, and counted in `without`.
    pub over_observers: Option<OverObservers>,
    /// Slider: over all trials of all observers, which is how the paper prints it. No interval, since trials of one
    /// observer are not independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_trials: Option<MeanSd>,
    /// The slope of the mean, as the paper gets it (its mean is rounded to a whole index first, ours is not). Not the mean
    /// of the slopes, since 0.33/j is not linear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope_of_mean: Option<SlopeOfMean>,
    /// The data of the paper's Figure 9: thresholds of observers, for the slider of trials, by level. Levels that were
    /// tried and are nobody's threshold are there with 0.
    pub histogram: Vec<Bin>,
    /// Observers without a threshold: they noticed everything.
    pub without: usize,
    /// Observers whose threshold is the coarsest level tried, and might lie beyond.
    pub at_coarsest: usize,
    /// The published figure of the quality index; nothing for another parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<Published>,
    /// The published slope.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_slope: Option<Published>,
}

/// Mean and SD without an interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeanSd {
    /// How many.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Standard deviation (n − 1).
    pub sd: Option<f64>,
}

/// The thresholds of some observers by the rule of a test.
///
/// # Errors
/// If no trial has the parameter (and, for pair and ramp, a right or wrong answer).
pub fn thresholds(test: Test, observers: &[ObserverRows<'_>], options: &Options) -> Result<Thresholds, RuleError> {
    let found: Vec<ObserverThreshold> = merged(observers)
        .into_iter()
        .filter_map(|(observer, rows)| match test {
            Test::Slider => slider(observer, &rows, options),
            Test::Pair | Test::Ramp => detected(observer, &rows, options),
        })
        .collect();
    if found.is_empty() {
        let expected = match test {
            Test::Slider => format!("a finding {}", options.parameter),
            Test::Pair | Test::Ramp => format!("a level of {} and a right or wrong answer", options.parameter),
        };
        return Err(RuleError::nothing(&test.rule().name, &expected, observers));
    }
    let over_observers = OverObservers::new(found.iter().filter_map(|one| one.threshold), &options.bootstrap);
    let is_index = options.parameter == QUALITY_INDEX;
    let place = |at: Place| found.iter().filter(|one| one.place == Some(at)).count();
    Ok(Thresholds {
        test,
        rule: test.rule(),
        slope_of_mean: over_observers.as_ref().and_then(|over| {
            let of = |index| slope(&options.parameter, index);
            // A larger index is a smaller slope: the ends change places.
            let ends = over.ci95.and_then(|[low, high]| Some([of(high)?, of(low)?]));
            Some(SlopeOfMean { m: of(over.mean)?, ci95: ends })
        }),
        over_trials: (test == Test::Slider)
            .then(|| finite_mean(found.iter().flat_map(|one| one.values.iter().copied())))
            .flatten()
            .map(|mean| MeanSd { n: mean.n, mean: mean.mean, sd: mean.sd }),
        histogram: histogram(&found),
        without: place(Place::Beyond),
        at_coarsest: place(Place::Coarsest),
        published: is_index.then(|| test.published()),
        published_slope: test.published_slope().filter(|_| is_index),
        options: options.clone(),
        over_observers,
        observers: found,
    })
}

/// m of a quality index above zero.
fn slope(parameter: &str, level: f64) -> Option<f64> {
    (parameter == QUALITY_INDEX && level > 0.0).then(|| slope_from_quality_index(level)).filter(|m| m.is_finite())
}

fn detected(observer: &str, rows: &[&Row], options: &Options) -> Option<ObserverThreshold> {
    let tally = tally(&options.parameter, rows.iter().copied());
    let threshold = coarsest(&tally, options.direction);
    let changing = || tally.iter().filter(|level| !level.without_change).map(|level| level.level);
    let end = match options.direction {
        Direction::Falls => changing().next(),
        Direction::Rises => changing().next_back(),
    };
    let is = |level: f64, other: f64| level.total_cmp(&other).is_eq();
    let place = match (threshold, end) {
        (None, _) => Place::Beyond,
        (Some(level), _) if tally.iter().any(|at| is(at.level, level) && at.without_change) => Place::WithoutChange,
        (Some(level), Some(end)) if is(level, end) => Place::Coarsest,
        _ => Place::Within,
    };
    (!tally.is_empty()).then(|| ObserverThreshold {
        observer: observer.to_owned(),
        threshold,
        slope: threshold.and_then(|level| slope(&options.parameter, level)),
        place: Some(place),
        tally,
        values: Vec::new(),
        over_trials: None,
        no_interval: Some(NO_INTERVAL.to_owned()),
    })
}

fn slider(observer: &str, rows: &[&Row], options: &Options) -> Option<ObserverThreshold> {
    let values: Vec<f64> = rows
        .iter()
        .filter_map(|row| row.found.get(&options.parameter).copied())
        .filter(|value| value.is_finite())
        .collect();
    let over_trials = finite_mean(values.iter().copied())?;
    Some(ObserverThreshold {
        observer: observer.to_owned(),
        threshold: Some(over_trials.mean),
        slope: slope(&options.parameter, over_trials.mean),
        place: None,
        tally: Vec::new(),
        no_interval: over_trials.ci95.is_none().then(|| "one trial has no spread over trials".to_owned()),
        over_trials: Some(over_trials),
        values,
    })
}

fn histogram(observers: &[ObserverThreshold]) -> Vec<Bin> {
    let is_slider = observers.iter().any(|one| !one.values.is_empty());
    let thresholds: Vec<f64> = if is_slider {
        observers.iter().flat_map(|one| one.values.iter().copied()).collect()
    } else {
        observers.iter().filter_map(|one| one.threshold).collect()
    };
    let mut levels: Vec<f64> = observers
        .iter()
        .flat_map(|one| one.tally.iter().map(|level| level.level))
        .chain(thresholds.iter().copied())
        .collect();
    levels.sort_by(f64::total_cmp);
    // A slider does not say which levels it has: between whole numbers, all of them.
    if let (true, Some(&low), Some(&high)) = (is_slider, levels.first(), levels.last())
        && levels.iter().all(|level| level.fract().abs() < f64::EPSILON)
        && high - low < MOST_BINS
    {
        levels.extend((0..=(high - low) as u32).map(|step| low + f64::from(step)));
        levels.sort_by(f64::total_cmp);
    }
    levels.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let n = |level: f64| thresholds.iter().filter(|value| value.total_cmp(&level).is_eq()).count();
    levels.into_iter().map(|level| Bin { level, n: n(level) }).collect()
}

impl Thresholds {
    /// What the rule gives, exactly, to an observer who notices each level with the probability that `noticed` says, with
    /// `trials` answers at each of `levels`: the distribution of the threshold.
    ///
    /// ```
    /// use analysis::psychometric::Direction;
    /// use analysis::rules::guenter::Thresholds;
    /// // An observer who notices nine of ten changes whatever their size "has" a threshold at the coarsest few levels.
    /// let levels: Vec<f64> = (8..=22).map(f64::from).collect();
    /// let rule = Thresholds::expected(&levels, 2, Direction::Falls, |_| 0.9);
    /// assert!((rule.outcomes[0].probability - 0.19).abs() < 1e-12 && rule.mean.unwrap() < 12.3);
    /// ```
    #[must_use]
    pub fn expected(levels: &[f64], trials: u32, direction: Direction, noticed: impl Fn(f64) -> f64) -> FirstPassed {
        let mut levels: Vec<f64> = levels.iter().copied().filter(|level| level.is_finite()).collect();
        levels.sort_by(|a, b| direction_order(direction, *a, *b));
        FirstPassed::new(levels.into_iter().map(|level| (level, unnoticed_once(noticed(level), trials))))
    }
}

/// The difference between two tests of the same observers, such as pair − ramp: each observer's, for those with both.
/// (The paper reports that pair and ramp differ, and prints the test in its supplement.)
#[must_use]
pub fn difference(a: &Thresholds, b: &Thresholds) -> Option<OverObservers> {
    let of = |one: &ObserverThreshold| {
        let other = b.observers.iter().find(|other| other.observer == one.observer)?;
        Some(one.threshold? - other.threshold?)
    };
    OverObservers::new(a.observers.iter().filter_map(of), &a.options.bootstrap)
}
