//! Comparisons after a task: how often the reference was recognised, and how well spheres were counted.

use super::Row;
use super::strata::{Parts, strata};
use crate::shares::{Mean, Share};
use experiments::trial::Answer;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Comparisons after a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tasks {
    /// All trials, then the trials of each level of each factor, then those of each cell.
    pub parts: Vec<TasksPart>,
}

/// Comparisons in a part of a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TasksPart {
    /// The factor levels that the part is about; empty for all trials.
    pub by: BTreeMap<String, String>,
    /// How often the reference was named as the better one (Stengel 2016, §7.2: "correctly recognised").
    pub recognised: Share,
    /// How often both were called equal.
    pub equal: Share,
    /// How often the test was named as the better one.
    pub test_better: Share,
    /// The counts, where spheres were counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counting: Option<Counting>,
}

/// How well spheres were counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Counting {
    /// Counts that were exact, of all counts.
    pub exact: Share,
    /// How far counts were off, either way, spheres.
    pub absolute_error: Mean,
}

impl Tasks {
    /// Nothing if no trial has a right or wrong answer.
    pub(super) fn new(rows: &[Row]) -> Option<Self> {
        let rows: Vec<Row> = rows.iter().filter(|row| row.correct.is_some()).cloned().collect();
        let parts: Vec<TasksPart> = strata(&rows, Parts { cells: true, level_prefix: Some("") })
            .into_iter()
            .filter_map(|stratum| part(stratum.by, &stratum.rows))
            .collect();
        (!parts.is_empty()).then_some(Self { parts })
    }
}

fn part(by: BTreeMap<String, String>, rows: &[&Row]) -> Option<TasksPart> {
    let errors: Vec<f64> = rows
        .iter()
        .flat_map(|row| {
            [("count_1", "spheres_1"), ("count_2", "spheres_2")]
                .into_iter()
                .filter_map(|(count, spheres)| Some((row.found.get(count)? - row.found.get(spheres)?).abs()))
        })
        .collect();
    let counting = Share::of(&errors, |error| *error < 0.5)
        .zip(Mean::new(errors.iter().copied()))
        .map(|(exact, absolute_error)| Counting { exact, absolute_error });
    Some(TasksPart {
        by,
        recognised: Share::of(rows, |row| row.correct == Some(true))?,
        equal: Share::of(rows, |row| row.answer == Answer::Same)?,
        test_better: Share::of(rows, |row| row.correct == Some(false) && row.answer != Answer::Same)?,
        counting,
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::*;

    #[test]
    fn answers_split_three_ways_and_counts_are_held_against_the_truth() {
        let trial = |task, answer, correct, counted: [f64; 2]| {
            let row = row(answer, Some(correct)).in_cell("task", task);
            row.found("count_1", counted[0])
                .found("spheres_1", 12.0)
                .found("count_2", counted[1])
                .found("spheres_2", 9.0)
        };
        let mut rows = vec![
            trial("count", Answer::First, true, [12.0, 9.0]),
            trial("count", Answer::Same, false, [11.0, 9.0]),
            trial("count", Answer::Second, false, [12.0, 12.0]),
            trial("count", Answer::Same, false, [12.0, 9.0]),
        ];
        rows.push(row(Answer::Second, Some(true)).in_cell("task", "free"));
        let tasks = Tasks::new(&rows).unwrap();
        let [all, count, free] = tasks.parts.as_slice() else { panic!("{tasks:?}") };
        assert_eq!((all.recognised.k, all.equal.k, all.test_better.k, all.recognised.n), (2, 2, 1, 5));
        let counting = count.counting.as_ref().unwrap();
        // Six of eight counts are exact; the others are off by 1 and 3.
        assert_eq!((counting.exact.k, counting.exact.n, counting.absolute_error.mean), (6, 8, 0.5));
        assert_eq!((free.recognised.share, free.counting.as_ref()), (1.0, None));
    }
}
