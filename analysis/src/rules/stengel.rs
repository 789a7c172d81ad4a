//! Recognised pictures, task by task, and adjusted parameters (Stengel 2016, §§6.1, 6.2, 7.2).
//!
//! The paper counts against its renderer every comparison in which the subsampled picture was *correctly recognised*; "equal"
//! and "the reference is worse" count for it. Of the adjusted parameters it prints means. It gives no interval, no SD and no
//! denominators; ours have all three.

use super::observers::{finite_mean, merged};
use super::{Bootstrap, ObserverRows, OverObservers, Published, Rule, RuleError};
use crate::answers::strata::{Parts, strata_indices};
use crate::answers::{Protocol, Row};
use crate::shares::Share;
use experiments::trial::Answer;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

const RECOGNISED: &str = "share correctly recognised";
const SETTINGS: &str = "mean setting";
const RESULTS: &str = "Stengel et al. 2016, §7.2";

/// One observer's comparisons.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverRecognised {
    /// The observer's code.
    pub observer: String,
    /// Comparisons in which the subsampled picture was recognised.
    pub recognised: usize,
    /// Comparisons.
    pub n: usize,
}

/// How often the subsampled picture was recognised in a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recognised {
    /// The rule.
    pub rule: Rule,
    /// The block, which is the task.
    pub task: String,
    /// Of all comparisons, those in which it was recognised. The share is the paper's; the intervals take comparisons of
    /// one observer for independent and are too narrow where observers differ.
    pub recognised: Share,
    /// Both were called equal.
    pub equal: Share,
    /// The reference was called the worse one.
    pub reference_worse: Share,
    /// Each observer.
    pub observers: Vec<ObserverRecognised>,
    /// The observers' shares: each observer counts once, and this interval is the one to report.
    pub over_observers: Option<OverObservers>,
    /// Whether "equal" could not be said, so that guessing alone recognises half.
    pub is_forced_choice: bool,
    /// In a forced choice, the share above guessing, max(0, 2p − 1) (Abbott's correction): what is nearest to the share of
    /// an observer who might have said "equal".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above_guessing: Option<f64>,
    /// The published share.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<Published>,
}

/// How often the subsampled picture was recognised in a block. `task` is the block's name; one that begins with `t1` … `t6`
/// gets the published share of that test beside it.
///
/// # Errors
/// If no trial has a right or wrong answer.
pub fn recognised(
    task: &str,
    protocol: Protocol,
    observers: &[ObserverRows<'_>],
    bootstrap: &Bootstrap,
) -> Result<Recognised, RuleError> {
    let nothing = || RuleError::nothing(RECOGNISED, "a right or wrong answer", observers);
    let merged = merged(observers);
    let judged = || merged.iter().flat_map(|(_, rows)| rows).filter(|row| row.correct.is_some());
    let is_recognised = |row: &Row| row.correct == Some(true);
    let share = |is: &dyn Fn(&Row) -> bool| Share::of(judged(), |row| is(row)).ok_or_else(nothing);
    let recognised = share(&is_recognised)?;
    let observers: Vec<ObserverRecognised> = merged
        .iter()
        .map(|(observer, rows)| ObserverRecognised {
            observer: (*observer).to_owned(),
            recognised: rows.iter().filter(|row| is_recognised(row)).count(),
            n: rows.iter().filter(|row| row.correct.is_some()).count(),
        })
        .filter(|one| one.n > 0)
        .collect();
    let is_forced_choice = protocol.is_forced_choice();
    Ok(Recognised {
        rule: Rule::new(
            RECOGNISED,
            "The share of comparisons in which the subsampled picture was named as the worse one; all others count for the \
             renderer.",
            "Stengel et al. 2016, §§6.2, 7.2",
        ),
        task: task.to_owned(),
        equal: share(&|row| row.answer == Answer::Same)?,
        reference_worse: share(&|row| !is_recognised(row) && row.answer != Answer::Same)?,
        over_observers: OverObservers::new(observers.iter().map(|one| one.recognised as f64 / one.n as f64), bootstrap),
        observers,
        above_guessing: is_forced_choice.then(|| (2.0 * recognised.share - 1.0).max(0.0)),
        is_forced_choice,
        published: published(task, is_forced_choice),
        recognised,
    })
}

/// The published share of recognised pictures, 0–1, of the test whose number a block's name begins with.
fn published(task: &str, is_forced_choice: bool) -> Option<Published> {
    let mut start = task.chars();
    let number = match (start.next(), start.next(), start.next()) {
        (Some('t' | 'T'), Some(number), next) if !next.is_some_and(|c| c.is_ascii_digit()) => number.to_digit(10)?,
        _ => return None,
    };
    let (percent, about) = match number {
        1 => (12.5, "printed as 87.5 % who perceived no difference"),
        2 => (11.1, "printed as 88.9 % who perceived no difference"),
        3 => (26.6, "toggled by hand, once for each observer"),
        4 => (12.2, "printed as a negative rating of the sample reduction in over- and under-exposed regions alone"),
        5 => (6.7, "against sampling without the motion-based reduction, not against full resolution"),
        6 => (20.2, "the texture adaptation switched on and off"),
        _ => return None,
    };
    let published = Published::new(&format!("share recognised in T{number}"), percent / 100.0, RESULTS)
        .observers(16)
        .caveat(about)
        .caveat("printed without a denominator");
    let pairs = if number == 3 { 16 } else { 48 };
    let published = if counts_that_print(percent, 1, pairs).is_empty() {
        published.caveat(&format!(
            "no whole number of {pairs} comparisons (16 observers, {} each) gives this percentage",
            pairs / 16
        ))
    } else {
        published
    };
    Some(if is_forced_choice {
        published.caveat("ours is a forced choice, in which guessing recognises half; compare the share above guessing")
    } else {
        published
    })
}

/// The counts k of n that are printed as a percentage with so many decimals, rounded or cut off: which counts can stand
/// behind a published share (Brown & Heathers 2017, for proportions).
#[must_use]
pub fn counts_that_print(percent: f64, decimals: u32, n: u32) -> Vec<u32> {
    let scale = 10f64.powi(i32::try_from(decimals.min(9)).unwrap_or(9));
    let printed = (percent * scale).round();
    (0..=n)
        .filter(|&k| {
            let exact = 100.0 * scale * f64::from(k) / f64::from(n.max(1));
            let is = |value: f64| (value - printed).abs() < 0.5;
            is(exact.round()) || is((exact + 1e-9).floor())
        })
        .collect()
}

/// An adjusted parameter over the observers, in a part of the trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The parameter.
    pub parameter: String,
    /// The factor levels, and where the trial started (`start <parameter>`), that it is about; empty for all trials.
    pub by: BTreeMap<String, String>,
    /// Trials.
    pub trials: usize,
    /// Mean over all trials, which is what the paper prints as "average".
    pub mean_of_trials: f64,
    /// SD over all trials (n − 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd_of_trials: Option<f64>,
    /// Observers' means: each observer counts once.
    pub over_observers: OverObservers,
    /// The geometric mean of the observers' geometric means, where all settings are above zero: settings that move by
    /// factors spread by factors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometric_mean: Option<f64>,
    /// The interval of the geometric mean, by Student's t on logarithms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometric_ci95: Option<[f64; 2]>,
}

/// How much a setting depends on where the trial started.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StartEffect {
    /// The adjusted parameter.
    pub parameter: String,
    /// The parameter whose start differs.
    pub start: String,
    /// Its lowest and highest start.
    pub starts: [f64; 2],
    /// Each observer's mean from the highest start less that from the lowest, over observers with both: an interval that
    /// leaves 0 out says that settings stop before they have lost their start.
    pub difference: OverObservers,
}

/// The adjusted parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The rule.
    pub rule: Rule,
    /// Each parameter over all trials, then by the levels of each factor and start.
    pub settings: Vec<Setting>,
    /// What starting low or high does.
    pub start_effects: Vec<StartEffect>,
    /// The published averages.
    pub published: Vec<Published>,
}

/// Means of adjusted parameters.
///
/// # Errors
/// If no trial has an adjusted parameter.
pub fn settings(observers: &[ObserverRows<'_>], bootstrap: &Bootstrap) -> Result<Settings, RuleError> {
    let rows: Vec<(&str, &Row)> = merged(observers)
        .into_iter()
        .flat_map(|(observer, rows)| rows.into_iter().map(move |row| (observer, row)))
        .filter(|(_, row)| row.found.keys().any(|name| is_parameter(name)))
        .collect();
    let plain: Vec<&Row> = rows.iter().map(|(_, row)| *row).collect();
    let parameters: BTreeSet<&String> =
        plain.iter().flat_map(|row| row.found.keys()).filter(|name| is_parameter(name)).collect();
    let mut found = Vec::new();
    for (by, indices) in strata_indices(&plain, Parts { cells: false, level_prefix: Some("start ") }) {
        let part: Vec<(&str, &Row)> = indices.into_iter().map(|index| rows[index]).collect();
        found.extend(parameters.iter().filter_map(|parameter| setting(parameter, &by, &part, bootstrap)));
    }
    if found.is_empty() {
        return Err(RuleError::nothing(SETTINGS, "an adjusted parameter", observers));
    }
    let starts: BTreeSet<&String> = plain.iter().flat_map(|row| row.level.keys()).collect();
    let start_effects = parameters
        .iter()
        .flat_map(|parameter| starts.iter().map(move |start| (parameter, start)))
        .filter_map(|(parameter, start)| start_effect(parameter, start, &rows, bootstrap))
        .collect();
    Ok(Settings {
        rule: Rule::new(
            SETTINGS,
            "The mean of the values at which observers, who could toggle to the full rendering, saw no difference.",
            "Stengel et al. 2016, §6.1",
        ),
        settings: found,
        start_effects,
        published: published_settings(),
    })
}

/// Not how much was done.
fn is_parameter(name: &str) -> bool {
    !matches!(name, "moves" | "comparisons")
}

/// A parameter's finite values, by observer in alphabetical order.
fn by_observer<'a>(parameter: &str, rows: &[(&'a str, &Row)]) -> BTreeMap<&'a str, Vec<f64>> {
    let mut values = BTreeMap::<&str, Vec<f64>>::new();
    for (observer, row) in rows {
        if let Some(&value) = row.found.get(parameter).filter(|value| value.is_finite()) {
            values.entry(observer).or_default().push(value);
        }
    }
    values
}

fn mean(values: &[f64]) -> Option<f64> {
    finite_mean(values.iter().copied()).map(|mean| mean.mean)
}

fn setting(
    parameter: &str,
    by: &BTreeMap<String, String>,
    rows: &[(&str, &Row)],
    bootstrap: &Bootstrap,
) -> Option<Setting> {
    let values = by_observer(parameter, rows);
    let all = finite_mean(values.values().flatten().copied())?;
    let is_positive = values.values().flatten().all(|value| *value > 0.0);
    let logarithms = values.values().filter_map(|values| mean(&values.iter().map(|v| v.ln()).collect::<Vec<f64>>()));
    let geometric = if is_positive { OverObservers::new(logarithms, bootstrap) } else { None };
    Some(Setting {
        parameter: parameter.to_owned(),
        by: by.clone(),
        trials: all.n,
        mean_of_trials: all.mean,
        sd_of_trials: all.sd,
        over_observers: OverObservers::new(values.values().filter_map(|values| mean(values)), bootstrap)?,
        geometric_mean: geometric.as_ref().map(|over| over.mean.exp()),
        geometric_ci95: (geometric.and_then(|over| over.ci95).map(|ends| ends.map(f64::exp)))
            .filter(|ends| ends.iter().all(|end| end.is_finite())),
    })
}

fn start_effect(parameter: &str, start: &str, rows: &[(&str, &Row)], bootstrap: &Bootstrap) -> Option<StartEffect> {
    let starts = rows.iter().filter_map(|(_, row)| row.level.get(start).copied());
    let starts = crate::numerics::sorted_finite(starts);
    let (low, high) = (*starts.first()?, *starts.last()?);
    let from = |value: f64| {
        let is = |row: &Row| row.level.get(start).is_some_and(|level| level.total_cmp(&value).is_eq());
        let part: Vec<(&str, &Row)> = rows.iter().filter(|(_, row)| is(row)).copied().collect();
        by_observer(parameter, &part)
    };
    if low.total_cmp(&high).is_eq() {
        return None;
    }
    let (lows, highs) = (from(low), from(high));
    let differences = highs.iter().filter_map(|(observer, values)| Some(mean(values)? - mean(lows.get(observer)?)?));
    Some(StartEffect {
        parameter: parameter.to_owned(),
        start: start.to_owned(),
        starts: [low, high],
        difference: OverObservers::new(differences, bootstrap)?,
    })
}

/// The published averages. They are shares of samples over a distance in screen heights, not angles, so that they stand
/// beside a study of the layers' slope for reading only.
fn published_settings() -> Vec<Published> {
    let of = |what: &str, value| {
        Published::new(what, value, "Stengel et al. 2016, §6.1")
            .observers(6)
            .caveat("in shares of samples over distance from the gaze in screen heights, not in degrees")
    };
    vec![
        of("acuity limit omega0", 1.1715),
        of("acuity slope m", -2.45),
        of("size of the fully shaded region f", 0.07),
        of("least acuity in the wide periphery omega_p", 0.02),
    ]
}
