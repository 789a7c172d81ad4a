//! The papers' rules over whole studies.

use analysis::answers::{Protocol, Row};
use analysis::rules::{Bootstrap, ObserverRows, of_block};
use criterion::Criterion;
use experiments::trial::Answer;
use std::collections::BTreeMap;
use std::hint::black_box;

/// Tursun's calibration: 36 patches × 9 pairs × 10 answers of 8 observers, intervals at 27 eccentricities.
pub(crate) fn bench(criterion: &mut Criterion) {
    let observer = |number: u32| -> Vec<Row> {
        let cells = (0..36).flat_map(|patch| [4.0, 7.0, 11.0].map(|r| (patch, r)));
        let cells = cells.flat_map(|(patch, r)| [0.0017, 0.0035, 0.0052].map(|k| (patch, r, k)));
        cells
            .flat_map(|cell| (0..10u32).map(move |i| (cell, i)))
            .map(|((patch, r, k), i)| Row {
                condition: "patch".to_owned(),
                factors: BTreeMap::from([("patch".to_owned(), format!("patch {patch}"))]),
                level: BTreeMap::from([("radius_deg".to_owned(), r), ("rate".to_owned(), k)]),
                answer: Answer::First,
                correct: Some((i * 7 + number * 3 + patch) % 10 < 7),
                found: BTreeMap::new(),
                response_time_s: None,
            })
            .collect()
    };
    let sessions: Vec<(String, Vec<Row>)> = (0..8).map(|number| (format!("P{number}"), observer(number))).collect();
    let observers: Vec<ObserverRows<'_>> =
        sessions.iter().map(|(observer, rows)| ObserverRows { observer, rows }).collect();
    criterion.bench_function("Tursun's rule, 36 patches and 8 observers", |bencher| {
        bencher.iter(|| of_block("main", Protocol::Toggle, black_box(&observers), Bootstrap::default()));
    });
}
