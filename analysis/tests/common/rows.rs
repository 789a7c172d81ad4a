//! Answered trials made by hand, for the tests of the papers' rules.
#![allow(dead_code, unreachable_pub)]

use analysis::answers::Row;
use analysis::rules::ObserverRows;
use experiments::trial::Answer;
use std::collections::BTreeMap;

pub fn row(answer: Answer, correct: Option<bool>) -> Row {
    Row {
        condition: "one".to_owned(),
        factors: BTreeMap::new(),
        level: BTreeMap::new(),
        answer,
        correct,
        found: BTreeMap::new(),
        response_time_s: Some(1.0),
    }
}

pub fn with_level(mut row: Row, level: &[(&str, f64)]) -> Row {
    row.level.extend(level.iter().map(|(name, value)| ((*name).to_owned(), *value)));
    row
}

pub fn with_found(mut row: Row, found: &[(&str, f64)]) -> Row {
    row.found.extend(found.iter().map(|(name, value)| ((*name).to_owned(), *value)));
    row
}

pub fn with_factors(mut row: Row, factors: &[(&str, &str)]) -> Row {
    row.factors.extend(factors.iter().map(|(name, level)| ((*name).to_owned(), (*level).to_owned())));
    row
}

/// A pair trial: the reference was called better (`Some(true)`), the test was (`Some(false)`), or neither.
pub fn pair(j: f64, noticed: Option<bool>) -> Row {
    let (answer, correct) = match noticed {
        Some(right) => (if right { Answer::First } else { Answer::Second }, right),
        None => (Answer::Same, false),
    };
    with_level(row(answer, Some(correct)), &[("quality_index", j)])
}

/// A ramp trial from 22 down to j, as the protocol logs it.
pub fn ramp(j: f64, answer: Answer) -> Row {
    let truth = if j < 22.0 { Answer::Decreased } else { Answer::Same };
    let row = with_level(row(answer, Some(answer == truth)), &[("quality_index", j)]);
    with_found(row, &[("from", 22.0), ("to", j)])
}

pub fn slider(first: f64, settled: f64) -> Row {
    with_found(
        row(Answer::Continue, None),
        &[("quality_index", first), ("quality_index_settled", settled), ("moves", settled)],
    )
}

/// Observers P1, P2, … with their rows.
pub fn observers<'a>(names: &'a [String], rows: &'a [Vec<Row>]) -> Vec<ObserverRows<'a>> {
    names.iter().zip(rows).map(|(observer, rows)| ObserverRows { observer, rows }).collect()
}

pub fn names(n: usize) -> Vec<String> {
    (1..=n).map(|i| format!("P{i:02}")).collect()
}

pub fn near(a: f64, b: f64, error: f64) {
    assert!((a - b).abs() <= error, "{a} against {b}");
}

/// Both orders at j = 8 … 22, noticed below `fooled` and called the same from there on.
pub fn clean_pair(fooled: f64) -> Vec<Row> {
    (8..=22).flat_map(|j| [f64::from(j); 2]).map(|j| pair(j, (j < fooled).then_some(true))).collect()
}

/// One observer's 2AFC trials on one patch: (r, k, right answers of 10).
pub fn patch(name: &str, pairs: &[(f64, f64, usize)]) -> Vec<Row> {
    pairs
        .iter()
        .flat_map(|&(r, k, right)| (0..10).map(move |i| (r, k, i < right)))
        .map(|(r, k, right)| {
            let row = with_level(row(Answer::First, Some(right)), &[("radius_deg", r), ("rate", k)]);
            with_factors(row, &[("patch", name)])
        })
        .collect()
}
