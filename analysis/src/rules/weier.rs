//! Ratings by condition, and the long table of their analysis of variance (Weier 2016, §4.2).
//!
//! Observers rate sequences from −3 (strongly disagree) to 3: "free of visual artifacts" (Q1) and how sure they were (Q2).
//! The paper prints M and SD over all trials of a condition, draws the shares that tend to disagree and to agree (Fig. 7),
//! and tests scene × foveal region × fixation (4 × 4 × 3, each twice, within subjects). Steps are taken for equal distances,
//! as there; the tests themselves are not here ([`long_table`] feeds them).

use super::observers::merged;
use super::{Bootstrap, LongRow, LongTable, ObserverRows, OverObservers, Published, Rule, RuleError};
use crate::answers::strata::{Parts, strata_indices};
use crate::answers::{Row, StepCount};
use crate::numerics::{quantile_of_sorted, sorted_finite};
use crate::shares::{Mean, Share};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

const NAME: &str = "mean rating";
const SOURCE: &str = "Weier et al. 2016, §4.2.2";
/// The names of Q1 and Q2 in the shipped study.
const FREE_OF_ARTIFACTS: &str = "free-of-artifacts";
const CONFIDENT: &str = "confident";
/// Ratings beyond this are no steps of a scale.
const LARGEST_STEP: f64 = 100.0;

/// How an item was rated in a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// The factor levels that it is about; empty for all trials.
    pub by: BTreeMap<String, String>,
    /// Ratings.
    pub n: usize,
    /// M, over all trials.
    pub mean: f64,
    /// SD over all trials (n − 1): within and between observers together, as the paper prints it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<f64>,
    /// The median over all trials.
    pub median: f64,
    /// How often each step was chosen, those chosen at least once, ascending.
    pub counts: Vec<StepCount>,
    /// Ratings below the middle (0): "a tendency towards disagree". Intervals take ratings of one observer for independent.
    pub disagree: Share,
    /// Ratings in the middle, which the paper counts to neither side.
    pub neutral: Share,
    /// Ratings above the middle.
    pub agree: Share,
    /// Observers' means: each observer counts once, and this interval is the one to report.
    pub over_observers: OverObservers,
    /// The published mean and SD of the condition.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<Published>,
}

/// How an item was rated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ItemRatings {
    /// The item.
    pub item: String,
    /// All trials, then each level of each factor, then each cell of the design.
    pub conditions: Vec<Condition>,
}

/// The ratings of a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ratings {
    /// The rule.
    pub rule: Rule,
    /// The items, in alphabetical order.
    pub items: Vec<ItemRatings>,
    /// What the paper's analysis of variance says of Q1.
    pub published_effects: Vec<PublishedEffect>,
}

/// A rating as a step of a scale.
fn step(value: f64) -> Option<i32> {
    ((value - value.round()).abs() < 1e-9 && value.abs() <= LARGEST_STEP).then(|| value.round() as i32)
}

/// The observers' rows one after another, with their codes.
fn listed<'a>(observers: &[ObserverRows<'a>]) -> Vec<(&'a str, &'a Row)> {
    let merged = merged(observers).into_iter();
    merged.flat_map(|(observer, rows)| rows.into_iter().map(move |row| (observer, row))).collect()
}

/// How every item was rated, by condition. What is no whole number of a scale is no rating.
///
/// # Errors
/// If no trial has a rating.
pub fn ratings(observers: &[ObserverRows<'_>], bootstrap: &Bootstrap) -> Result<Ratings, RuleError> {
    let rows = listed(observers);
    let names: BTreeSet<&String> = rows.iter().flat_map(|(_, row)| row.found.keys()).collect();
    let plain: Vec<&Row> = rows.iter().map(|(_, row)| *row).collect();
    let parts = strata_indices(&plain, Parts { cells: true, level_prefix: Some("") });
    let of_item = |item: &String| {
        let conditions = parts.iter().filter_map(|(by, indices)| {
            let rated = indices.iter().filter_map(|&index| {
                let (observer, row) = rows[index];
                Some((observer, step(*row.found.get(item)?)?))
            });
            condition(item, by, &rated.collect::<Vec<_>>(), bootstrap)
        });
        ItemRatings { item: item.clone(), conditions: conditions.collect() }
    };
    let items: Vec<ItemRatings> = names.into_iter().map(of_item).filter(|item| !item.conditions.is_empty()).collect();
    if items.is_empty() {
        return Err(RuleError::nothing(NAME, "a rating on a scale of whole numbers", observers));
    }
    let rule = Rule::new(
        NAME,
        "Mean and SD of the ratings of a condition over all its trials, and the shares that tend to disagree and to agree.",
        "Weier et al. 2016, §4.2, Figs. 6 and 7",
    );
    Ok(Ratings { rule, items, published_effects: published_effects() })
}

fn condition(
    item: &str,
    by: &BTreeMap<String, String>,
    rated: &[(&str, i32)],
    bootstrap: &Bootstrap,
) -> Option<Condition> {
    let steps = || rated.iter().map(|(_, step)| *step);
    let all = Mean::new(steps().map(f64::from))?;
    let mut by_observer = BTreeMap::<&str, (i32, i32)>::new();
    let mut counts = BTreeMap::<i32, usize>::new();
    for (observer, step) in rated {
        let sum = by_observer.entry(observer).or_default();
        *sum = (sum.0 + step, sum.1 + 1);
        *counts.entry(*step).or_default() += 1;
    }
    Some(Condition {
        by: by.clone(),
        n: all.n,
        mean: all.mean,
        sd: all.sd,
        median: quantile_of_sorted(&sorted_finite(steps().map(f64::from)), 0.5)?,
        counts: counts.into_iter().map(|(step, n)| StepCount { step, n }).collect(),
        disagree: Share::of(steps(), |step| step < 0)?,
        neutral: Share::of(steps(), |step| step == 0)?,
        agree: Share::of(steps(), |step| step > 0)?,
        over_observers: OverObservers::new(
            by_observer.values().map(|(sum, n)| f64::from(*sum) / f64::from(*n)),
            bootstrap,
        )?,
        published: published(item, by),
    })
}

/// An item's ratings in long form, one row for each trial: the data of the paper's 4 × 4 × 3 analysis, which
/// [`LongTable::cell_means`] turns into one value for each subject and cell. Factors are those of the design, and the
/// parameters of the level, as far as more than one of their levels occurs.
///
/// # Errors
/// If no trial has a rating of the item.
pub fn long_table(item: &str, observers: &[ObserverRows<'_>]) -> Result<LongTable, RuleError> {
    let labelled: Vec<LongRow> = listed(observers)
        .into_iter()
        .filter_map(|(observer, row)| {
            let value = f64::from(step(*row.found.get(item)?)?);
            let levels = row.level.iter().map(|(name, value)| (name.clone(), value.to_string()));
            let factors = row.factors.clone().into_iter().chain(levels).collect();
            Some(LongRow { subject: observer.to_owned(), factors, value })
        })
        .collect();
    let mut table = LongTable { measure: item.to_owned(), rows: labelled };
    let varying: BTreeSet<String> = table
        .levels()
        .into_iter()
        .filter(|(_, levels)| levels.len() > 1)
        .map(|(factor, _)| factor.to_owned())
        .collect();
    for row in &mut table.rows {
        row.factors.retain(|factor, _| varying.contains(factor));
    }
    if table.rows.is_empty() {
        return Err(RuleError::nothing(NAME, &format!("a rating of {item}"), observers));
    }
    Ok(table)
}

/// The published mean and SD of a condition of the shipped study.
fn published(item: &str, by: &BTreeMap<String, String>) -> Option<Published> {
    let of = |what: &str, mean, sd| Some(Published::new(what, mean, SOURCE).sd(sd).observers(15));
    let factors: Vec<(&str, &str)> = by.iter().map(|(factor, level)| (factor.as_str(), level.as_str())).collect();
    match (item, factors.as_slice()) {
        (FREE_OF_ARTIFACTS, [("fixation", "free")]) => of("rating of Q1, free fixation", 0.43, 1.89),
        (FREE_OF_ARTIFACTS, [("fixation", "fixed")]) => of("rating of Q1, fixed focus", 0.43, 1.81),
        (FREE_OF_ARTIFACTS, [("fixation", "moving")]) => of("rating of Q1, moving target", 0.99, 1.63),
        (CONFIDENT, []) => of("rating of Q2, all trials", 1.62, 1.14),
        _ => None,
    }
}

/// An effect of the paper's analysis of variance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PublishedEffect {
    /// Which effect.
    pub effect: String,
    /// F as printed.
    pub f: f64,
    /// p as printed.
    pub printed_p: String,
    /// Degrees of freedom of the effect; the paper prints none.
    pub df: u32,
    /// What to know.
    pub caveat: String,
    /// Paper and section.
    pub source: String,
}

/// The effects that the paper prints.
///
/// It prints no degrees of freedom. Of fixation, F = 3.46 with p = .03 fits 2 and some 1392 of them (p = .032), that is all
/// 1440 trials taken for independent, and not the 2 and 28 of a repeated-measures analysis of 15 subjects (p = .045).
#[must_use]
pub fn published_effects() -> Vec<PublishedEffect> {
    let of = |effect: &str, f, printed_p: &str, df, caveat: &str| PublishedEffect {
        effect: effect.to_owned(),
        f,
        printed_p: printed_p.to_owned(),
        df,
        caveat: caveat.to_owned(),
        source: SOURCE.to_owned(),
    };
    vec![
        of("region", 30.54, "p = 0 (approximately)", 3, "error degrees of freedom are not printed"),
        of("region x scene", 3.09, "p < 0.005", 9, "error degrees of freedom are not printed"),
        of(
            "fixation",
            3.46,
            "p = 0.03",
            2,
            "this p goes with an error term over trials (about 1392 degrees of freedom); with the 28 of a repeated-measures \
             analysis the same F has p = 0.045",
        ),
    ]
}
