//! Several observers together: the mean and spread over observers of what each one's block came to.
//!
//! Each observer counts once, however many trials they answered. These are descriptions; tests and models over observers
//! are not here.

use super::{BlockSummary, Summary, part_name};
use crate::shares::Mean;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One quantity over observers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupRow {
    /// The study's name.
    pub study: String,
    /// The block's name.
    pub block: String,
    /// What is averaged, such as `threshold of quality_index`.
    pub quantity: String,
    /// The factor levels that it is about; empty for all trials.
    pub by: BTreeMap<String, String>,
    /// Mean, SD and 95 % t interval over observers.
    pub over_observers: Mean,
}

/// Sums up blocks over observers; one item for each observer. Only what at least two observers have is kept, and only
/// thresholds that their data support.
#[must_use]
pub fn over_observers<'a>(observers: impl IntoIterator<Item = &'a [BlockSummary]>) -> Vec<GroupRow> {
    // In the order in which quantities first occur.
    let mut rows: Vec<(GroupRow, Vec<f64>)> = Vec::new();
    for blocks in observers {
        for block in blocks {
            for (quantity, by, value) in quantities(block) {
                let known = rows.iter_mut().find(|(row, _)| {
                    row.study == block.study && row.block == block.block && row.quantity == quantity && row.by == *by
                });
                if let Some((_, values)) = known {
                    values.push(value);
                } else if let Some(over_observers) = Mean::new([value]) {
                    let (study, block) = (block.study.clone(), block.block.clone());
                    rows.push((GroupRow { study, block, quantity, by: by.clone(), over_observers }, vec![value]));
                }
            }
        }
    }
    rows.into_iter()
        .filter(|(_, values)| values.len() > 1)
        .filter_map(|(row, values)| Some(GroupRow { over_observers: Mean::new(values)?, ..row }))
        .collect()
}

/// The numbers of one observer's block that are averaged over observers.
fn quantities(block: &BlockSummary) -> Vec<(String, &BTreeMap<String, String>, f64)> {
    let mut found = Vec::new();
    match &block.summary {
        Summary::Detection(detection) => {
            let parameter = detection.parameter().unwrap_or("level");
            for part in &detection.parts {
                if let Some(fit) = part.fit.as_ref().filter(|fit| fit.support.is_supported()) {
                    found.push((format!("threshold of {parameter}"), &part.by, fit.threshold.estimate));
                }
                if let Some(level) = part.coarsest_unnoticed {
                    found.push((format!("coarsest unnoticed {parameter}"), &part.by, level));
                }
                found.push(("share right".to_owned(), &part.by, part.right.share));
                // An adaptive block's levels differ between observers, and its fit is what it is for.
                if detection.parameters.len() > 1 && !block.in_mar_fit {
                    for cell in &part.cells {
                        let level = cell.level.iter().map(|(name, value)| (name.clone(), value.to_string())).collect();
                        found.push((format!("share right at {}", part_name(&level)), &part.by, cell.right.share));
                    }
                }
            }
        }
        Summary::Matches(matches) => {
            for part in &matches.parts {
                found.extend(part.quantities.iter().map(|q| (q.quantity.clone(), &part.by, q.mean.mean)));
            }
        }
        Summary::Ratings(ratings) => {
            for part in &ratings.parts {
                found.extend(part.items.iter().map(|item| (item.item.clone(), &part.by, item.mean.mean)));
            }
        }
        Summary::Tasks(tasks) => {
            for part in &tasks.parts {
                found.push(("share recognised".to_owned(), &part.by, part.recognised.share));
                if let Some(counting) = &part.counting {
                    found.push(("share counted exactly".to_owned(), &part.by, counting.exact.share));
                }
            }
        }
        Summary::Nothing { .. } => {}
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::super::{Protocol, summarise};
    use super::*;
    use experiments::trial::Answer;

    #[test]
    fn every_observer_counts_once() {
        let block = |values: &[f64]| {
            let rows: Vec<_> =
                values.iter().map(|&value| row(Answer::Continue, None).found("quality_index", value)).collect();
            vec![summarise("guenter", "slider", Some(Protocol::Slider), &rows)]
        };
        let observers = [block(&[10.0, 14.0]), block(&[16.0; 8]), block(&[])];
        let group = over_observers(observers.iter().map(Vec::as_slice));
        let [row] = group.as_slice() else { panic!("{group:?}") };
        // Means 12 and 16: their mean is 14, their SD √8.
        assert_eq!((row.over_observers.n, row.over_observers.mean), (2, 14.0));
        assert!((row.over_observers.sd.unwrap() - 8f64.sqrt()).abs() < 1e-12);
        assert!(over_observers([observers[0].as_slice()]).is_empty());
    }
}
