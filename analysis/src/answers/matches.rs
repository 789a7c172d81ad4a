//! Values that observers set: a slider's first level that looked like the reference, adjusted parameters.

use super::Row;
use super::strata::{Parts, strata};
use crate::numerics::{quantile_of_sorted, sorted_finite};
use crate::shares::Mean;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Values that were set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Matches {
    /// All trials, then the trials of each level of each factor; where a trial started counts as one (`start <name>`).
    pub parts: Vec<MatchesPart>,
}

/// Values that were set in a part of a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MatchesPart {
    /// The factor levels that the part is about; empty for all trials.
    pub by: BTreeMap<String, String>,
    /// One entry for each parameter, then where a slider was left (`<name>_settled`), then moves and comparisons.
    pub quantities: Vec<Quantity>,
}

/// One quantity over the trials of a part, in its parameter's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// Its name.
    pub quantity: String,
    /// Mean, SD and 95 % t interval of the mean.
    pub mean: Mean,
    /// The median.
    pub median: f64,
    /// Every trial's value, in order.
    pub values: Vec<f64>,
}

impl Quantity {
    /// Whether it is what the trial measured, not how it was done.
    #[must_use]
    pub fn is_setting(&self) -> bool {
        rank(&self.quantity) == 0
    }
}

/// Parameters first, then where the slider was left, then how much was done.
fn rank(name: &str) -> u8 {
    match name {
        "moves" | "comparisons" => 2,
        name if name.ends_with("_settled") => 1,
        _ => 0,
    }
}

impl Matches {
    /// Nothing if no trial found anything.
    pub(super) fn new(rows: &[Row]) -> Option<Self> {
        let names: BTreeSet<&String> = rows.iter().flat_map(|row| row.found.keys()).collect();
        let mut names: Vec<&String> = names.into_iter().collect();
        names.sort_by_key(|name| rank(name));
        let parts: Vec<MatchesPart> = strata(rows, Parts { cells: true, level_prefix: Some("start ") })
            .into_iter()
            .map(|stratum| {
                let quantities = names.iter().filter_map(|name| quantity(name, &stratum.rows)).collect();
                MatchesPart { by: stratum.by, quantities }
            })
            .filter(|part| !part.quantities.is_empty())
            .collect();
        (!parts.is_empty()).then_some(Self { parts })
    }
}

fn quantity(name: &str, rows: &[&Row]) -> Option<Quantity> {
    let values: Vec<f64> =
        rows.iter().filter_map(|row| row.found.get(name).copied()).filter(|value| value.is_finite()).collect();
    let mean = Mean::new(values.iter().copied())?;
    let median = quantile_of_sorted(&sorted_finite(values.iter().copied()), 0.5)?;
    Some(Quantity { quantity: name.to_owned(), mean, median, values })
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::*;
    use experiments::trial::Answer;

    #[test]
    fn values_are_summed_up_by_factor_and_start() {
        let trial = |motion, start, j: f64| {
            let row = row(Answer::Continue, None).in_cell("motion", motion).at("quality_index", start);
            row.found("quality_index", j).found("quality_index_settled", j + 1.0).found("moves", 2.0 * j)
        };
        let rows =
            [trial("pan", 4.0, 10.0), trial("pan", 4.0, 12.0), trial("orbit", 4.0, 14.0), trial("orbit", 8.0, 16.0)];
        let matches = Matches::new(&rows).unwrap();
        let all = &matches.parts[0];
        let names: Vec<&str> = all.quantities.iter().map(|quantity| quantity.quantity.as_str()).collect();
        assert_eq!(names, ["quality_index", "quality_index_settled", "moves"]);
        assert_eq!(all.quantities.iter().map(Quantity::is_setting).collect::<Vec<_>>(), [true, false, false]);
        // 10, 12, 14, 16: mean 13, SD √(20/3), by hand.
        let j = &all.quantities[0];
        assert_eq!((j.mean.n, j.mean.mean, j.median), (4, 13.0, 13.0));
        assert!((j.mean.sd.unwrap() - (20.0f64 / 3.0).sqrt()).abs() < 1e-12);
        let part = |factor: &str, level: &str| {
            let by = BTreeMap::from([(factor.to_owned(), level.to_owned())]);
            matches.parts.iter().find(|part| part.by == by).unwrap().quantities[0].clone()
        };
        assert_eq!(part("motion", "pan").mean.mean, 11.0);
        assert_eq!(part("start quality_index", "4").values, [10.0, 12.0, 14.0]);
        assert_eq!(matches.parts.len(), 1 + 2 + 2 + 3);
    }
}
