//! Ratings of items on a scale of whole numbers, by factor level and by cell of the design.

use super::Row;
use super::strata::{Parts, strata};
use crate::shares::Mean;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// The steps of a 7-point item, strongly disagree to strongly agree (Weier 2016, §4.2.1).
const SEVEN_POINT: [i32; 2] = [-3, 3];

/// Ratings of items.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ratings {
    /// The items, by name.
    pub items: Vec<Item>,
    /// All trials, then the trials of each level of each factor, then those of each cell.
    pub parts: Vec<RatingsPart>,
}

/// One item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Item {
    /// Its name.
    pub item: String,
    /// Lowest and highest step that its figure shows: −3 and 3, or what was answered where that goes beyond.
    pub steps: [i32; 2],
}

/// Ratings in a part of a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RatingsPart {
    /// The factor levels that the part is about; empty for all trials.
    pub by: BTreeMap<String, String>,
    /// One entry for each item.
    pub items: Vec<ItemRating>,
}

/// How an item was rated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ItemRating {
    /// The item.
    pub item: String,
    /// How often each step between the item's lowest and highest was chosen, ascending.
    pub counts: Vec<StepCount>,
    /// Mean, SD and 95 % t interval; steps are taken for equal distances.
    pub mean: Mean,
}

/// How often a step was chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepCount {
    /// The step.
    pub step: i32,
    /// How often.
    pub n: usize,
}

impl ItemRating {
    /// How often a step was chosen.
    #[must_use]
    pub fn count(&self, step: i32) -> usize {
        self.counts.iter().filter(|count| count.step == step).map(|count| count.n).sum()
    }

    /// The share of ratings above the middle of a scale that has 0 in its middle.
    #[must_use]
    pub fn share_agreeing(&self) -> f64 {
        let above: usize = self.counts.iter().filter(|count| count.step > 0).map(|count| count.n).sum();
        above as f64 / self.mean.n as f64
    }
}

impl Ratings {
    /// Nothing if no item was rated by a whole number.
    pub(super) fn new(rows: &[Row]) -> Option<Self> {
        let names: BTreeSet<&String> = rows.iter().flat_map(|row| row.found.keys()).collect();
        let items: Vec<Item> = names
            .into_iter()
            .filter_map(|name| {
                let steps: Vec<i32> = rows.iter().filter_map(|row| step(*row.found.get(name)?)).collect();
                let [low, high] = [*steps.iter().min()?, *steps.iter().max()?];
                Some(Item { item: name.clone(), steps: [low.min(SEVEN_POINT[0]), high.max(SEVEN_POINT[1])] })
            })
            .collect();
        let parts: Vec<RatingsPart> = strata(rows, Parts { cells: true, level_prefix: Some("") })
            .into_iter()
            .map(|stratum| {
                let items = items.iter().filter_map(|item| rating(item, &stratum.rows)).collect();
                RatingsPart { by: stratum.by, items }
            })
            .filter(|part| !part.items.is_empty())
            .collect();
        (!parts.is_empty()).then_some(Self { items, parts })
    }
}

/// A rating as a step; nothing for what is no whole number of a scale.
fn step(value: f64) -> Option<i32> {
    ((value - value.round()).abs() < 1e-9 && value.abs() <= 100.0).then(|| value.round() as i32)
}

fn rating(item: &Item, rows: &[&Row]) -> Option<ItemRating> {
    let steps: Vec<i32> = rows.iter().filter_map(|row| step(*row.found.get(&item.item)?)).collect();
    let counts = (item.steps[0]..=item.steps[1])
        .map(|step| StepCount { step, n: steps.iter().filter(|rated| **rated == step).count() })
        .collect();
    let mean = Mean::new(steps.into_iter().map(f64::from))?;
    Some(ItemRating { item: item.item.clone(), counts, mean })
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::*;
    use experiments::trial::Answer;

    #[test]
    fn steps_are_counted_by_level_and_cell() {
        let trial = |region, fixation, noise, sharp| {
            let row = row(Answer::Option(sharp), None).in_cell("region", region).in_cell("fixation", fixation);
            row.found("noise", f64::from(noise)).found("sharp", f64::from(sharp))
        };
        let rows = [
            trial("small", "cross", -3, 2),
            trial("small", "free", -1, 2),
            trial("full", "cross", 2, 3),
            trial("full", "free", 3, 3),
        ];
        let ratings = Ratings::new(&rows).unwrap();
        assert_eq!(ratings.items[0], Item { item: "noise".to_owned(), steps: [-3, 3] });
        assert_eq!(ratings.parts.len(), 1 + 4 + 4);
        let all = &ratings.parts[0].items[0];
        let counts: Vec<(i32, usize)> = all.counts.iter().map(|count| (count.step, count.n)).collect();
        assert_eq!(counts, [(-3, 1), (-2, 0), (-1, 1), (0, 0), (1, 0), (2, 1), (3, 1)]);
        assert_eq!((all.mean.mean, all.share_agreeing()), (0.25, 0.5));
        let full = ratings.parts.iter().find(|part| part.by.get("region").is_some_and(|r| r == "full")).unwrap();
        assert_eq!((full.items[0].mean.mean, full.items[1].mean.mean), (2.5, 3.0));
    }

    #[test]
    fn what_is_no_step_is_no_rating() {
        assert_eq!(step(2.0), Some(2));
        assert_eq!([step(2.5), step(1e9), step(f64::NAN)], [None; 3]);
        assert!(Ratings::new(&[row(Answer::Option(1), None).found("speed", 0.5)]).is_none());
    }
}
