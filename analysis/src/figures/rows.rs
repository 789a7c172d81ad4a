//! Figures of one row for each part of a block: dots of settings, diverging bars of ratings, shares with intervals.

use super::WIDTH;
use super::likert::{LikertChart, LikertGroup, LikertRow, likert_bars};
use super::parts::nothing;
use super::row_panel::{Label, ROW, Rows};
use crate::answers::{Item, Matches, Ratings, Tasks, part_name};
use crate::shares::Share;
use crate::svg::{Axis, BLUE, Canvas, GREEN, Paint, VERMILION, legend};
use std::collections::BTreeMap;

/// Height of a row of several marks.
const TALL_ROW: f64 = 40.0;
/// Rows drawn at most; the tables hold all.
const MOST_ROWS: usize = 40;

/// Every value of one quantity as a dot, with the mean and its 95 % interval, one row for each part.
#[must_use]
pub fn settings(matches: &Matches, quantity: &str) -> String {
    let rows: Vec<_> = matches
        .parts
        .iter()
        .filter_map(|part| Some((part_name(&part.by), part.quantities.iter().find(|q| q.quantity == quantity)?)))
        .take(MOST_ROWS)
        .collect();
    let values = || rows.iter().flat_map(|(_, q)| &q.values).copied().filter(|v| super::parts::drawable(*v));
    if values().next().is_none() {
        return nothing("Settings", "there are no settings");
    }
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let room = 0.06 * (high - low).max(1e-3 * high.abs()).max(1e-9);
    let mut canvas = Canvas::default();
    let dot: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, at| canvas.circle(at, 3.2, &Paint::muted(1.2));
    let mean: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.line([x - 11.0, y], [x + 11.0, y], &Paint::stroke(BLUE, 2.4));
        canvas.circle([x, y], 4.6, &Paint::fill(BLUE));
    };
    let used = legend(&mut canvas, [24.0, 22.0], WIDTH - 48.0, &[("one trial", dot), ("mean, 95 % (t)", mean)]);
    let figure = Rows::new(
        Label::of_parts(rows.iter().map(|(name, _)| name.clone())),
        22.0 + used,
        ROW,
        Axis::linear(quantity, low - room, high + room),
    );
    let height = figure.draw(&mut canvas);
    for (row, (_, q)) in rows.iter().enumerate() {
        // Equal values stand above each other, within the row.
        let mut seen: BTreeMap<u64, u32> = BTreeMap::new();
        for value in q.values.iter().filter(|v| super::parts::drawable(**v)) {
            let count = seen.entry(value.to_bits()).or_insert(0);
            let side = if count.is_multiple_of(2) { 1.0 } else { -1.0 };
            let shift = (side * f64::from(count.div_ceil(2)) * 3.0).clamp(-9.0, 9.0);
            *count += 1;
            canvas.circle([figure.x(*value), figure.y(row) + shift], 3.2, &Paint::muted(1.2).opacity(0.75));
        }
        figure.mean(&mut canvas, row, &q.mean);
    }
    canvas.finish([WIDTH, height], "Settings", "Every setting, and the mean of each part with its 95 % interval.")
}

/// Ratings of one item as diverging stacked bars, one row for each part, disagreement to the left (after Weier 2016,
/// Fig. 7).
#[must_use]
pub fn ratings(ratings: &Ratings, item: &Item) -> String {
    let rows = ratings
        .parts
        .iter()
        // Single cells of the design have a few ratings each and stand in the data.
        .filter(|part| part.by.len() < 2)
        .filter_map(|part| Some((part_name(&part.by), part.items.iter().find(|rating| rating.item == item.item)?)))
        .take(MOST_ROWS)
        .map(|(name, rating)| LikertRow {
            name,
            counts: (item.steps[0]..=item.steps[1]).map(|step| rating.count(step)).collect(),
        });
    likert_bars(&LikertChart {
        title: format!("Ratings of {}", item.item),
        steps: item.steps,
        ends: [String::new(), String::new()],
        groups: vec![LikertGroup { heading: String::new(), rows: rows.collect() }],
    })
}

/// How often the reference was recognised, both were called equal, and the test was named, with Wilson intervals.
#[must_use]
pub fn tasks(tasks: &Tasks) -> String {
    let rows: Vec<_> = tasks.parts.iter().take(MOST_ROWS).collect();
    if rows.is_empty() {
        return nothing("Comparisons after a task", "there are no comparisons");
    }
    let mut canvas = Canvas::default();
    let kinds = [("reference better", BLUE), ("equal", "#8a919a"), ("test better", VERMILION)];
    let counted = rows.iter().any(|part| part.counting.is_some());
    let mark = |color: &'static str| {
        move |canvas: &mut Canvas, [x, y]: [f64; 2]| {
            canvas.line([x - 11.0, y], [x + 11.0, y], &Paint::stroke(color, 2.0));
            canvas.circle([x, y], 4.0, &Paint::fill(color));
        }
    };
    let marks = [kinds[0].1, kinds[1].1, kinds[2].1, GREEN].map(mark);
    let mut entries: Vec<crate::svg::Entry<'_>> = Vec::new();
    for ((text, _), mark) in kinds.iter().zip(&marks) {
        entries.push((text, mark));
    }
    if counted {
        entries.push(("counted exactly", &marks[3]));
    }
    let used = legend(&mut canvas, [24.0, 22.0], WIDTH - 48.0, &entries);
    let figure = Rows::new(
        Label::of_parts(rows.iter().map(|part| format!("{} ({})", part_name(&part.by), part.recognised.n))),
        22.0 + used,
        TALL_ROW,
        Axis::linear("Share of answers, 95 % (Wilson)", 0.0, 1.0).with_ticks(5).in_percent(),
    );
    let height = figure.draw(&mut canvas);
    for (row, part) in rows.iter().enumerate() {
        let mut draw = |share: &Share, shift: f64, color: &str| {
            let y = figure.y(row) + shift;
            let [low, high] = share.wilson95.map(|at| figure.x(at));
            canvas.line([low, y], [high, y], &Paint::stroke(color, 1.8));
            canvas.circle([figure.x(share.share), y], 3.4, &Paint::fill(color));
        };
        draw(&part.recognised, -10.5, kinds[0].1);
        draw(&part.equal, -3.5, kinds[1].1);
        draw(&part.test_better, 3.5, kinds[2].1);
        if let Some(counting) = &part.counting {
            draw(&counting.exact, 10.5, GREEN);
        }
    }
    canvas.finish(
        [WIDTH, height],
        "Comparisons after a task",
        "How often the reference was named as better, both were called equal, and the test was named, by part.",
    )
}
