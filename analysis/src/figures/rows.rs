//! Figures of one row for each part of a block: dots of settings, diverging bars of ratings, shares with intervals.

use super::WIDTH;
use crate::answers::{Item, Matches, Ratings, Tasks, part_name};
use crate::shares::{Mean, Share};
use crate::svg::{Anchor, Axis, BLUE, Canvas, GREEN, Paint, TextStyle, VERMILION, legend, text_width};
use std::collections::BTreeMap;

/// Height of a row.
const ROW: f64 = 26.0;
/// Height of a row of several marks.
const TALL_ROW: f64 = 40.0;
const TEXT: f64 = 12.5;
/// Rows drawn at most; the tables hold all.
const MOST_ROWS: usize = 40;

/// Disagreement to agreement, from blue over grey to vermilion: apart under every common colour blindness.
const DISAGREE: [&str; 3] = ["#9ecae9", "#4292c6", "#08519c"];
const AGREE: [&str; 3] = ["#fdbe85", "#ee7b32", "#a63603"];
const NEUTRAL: &str = "#c4c8cd";

/// A column of labelled rows over one axis.
struct Rows {
    left: f64,
    top: f64,
    row: f64,
    axis: Axis,
    labels: Vec<String>,
}

impl Rows {
    fn new(labels: Vec<String>, top: f64, axis: Axis) -> Self {
        let widest = labels.iter().map(|label| text_width(label, TEXT)).fold(60.0, f64::max);
        // The first label is bold, which is wider.
        Self { left: (1.12 * widest + 26.0).min(0.45 * WIDTH), top, row: ROW, axis, labels }
    }

    fn width(&self) -> f64 {
        WIDTH - self.left - 28.0
    }

    fn x(&self, value: f64) -> f64 {
        self.left + self.width() * self.axis.place(value).clamp(0.0, 1.0)
    }

    fn y(&self, row: usize) -> f64 {
        self.top + (row as f64 + 0.5) * self.row
    }

    fn bottom(&self) -> f64 {
        self.top + self.labels.len() as f64 * self.row
    }

    /// Grid, axis and labels; the figure's height.
    fn draw(&self, canvas: &mut Canvas) -> f64 {
        let bottom = self.bottom();
        for (value, text) in self.axis.ticks() {
            let x = self.x(value);
            canvas.line([x, self.top], [x, bottom], &Paint::grid());
            canvas.line([x, bottom], [x, bottom + 4.0], &Paint::ink(1.0));
            // Shares to the left are shares all the same; minus signs of other axes are true ones and stay.
            canvas.text([x, bottom + 18.0], text.trim_start_matches('-'), TextStyle::new(12.0, Anchor::Middle).muted());
        }
        canvas.line([self.left, bottom], [self.left + self.width(), bottom], &Paint::ink(1.0));
        let middle = self.left + 0.5 * self.width();
        canvas.text([middle, bottom + 39.0], &self.axis.label, TextStyle::new(13.0, Anchor::Middle));
        for (row, label) in self.labels.iter().enumerate() {
            let mut text = label.clone();
            while 1.12 * text_width(&text, TEXT) > self.left - 16.0 && text.chars().count() > 2 {
                text = text.chars().take(text.chars().count() - 2).chain(['…']).collect();
            }
            let style = TextStyle::new(TEXT, Anchor::End);
            canvas.text([self.left - 10.0, self.y(row) + 4.0], &text, if row == 0 { style.bold() } else { style });
        }
        bottom + 54.0
    }

    /// A mean with its interval.
    fn mean(&self, canvas: &mut Canvas, row: usize, mean: &Mean) {
        let y = self.y(row);
        if let Some([low, high]) = mean.ci95 {
            canvas.line([self.x(low), y], [self.x(high), y], &Paint::stroke(BLUE, 2.4));
        }
        canvas.circle([self.x(mean.mean), y], 4.6, &Paint::fill(BLUE));
    }
}

/// Every value of one quantity as a dot, with the mean and its 95 % interval, one row for each part.
#[must_use]
pub fn settings(matches: &Matches, quantity: &str) -> String {
    let rows: Vec<_> = matches
        .parts
        .iter()
        .filter_map(|part| Some((part_name(&part.by), part.quantities.iter().find(|q| q.quantity == quantity)?)))
        .take(MOST_ROWS)
        .collect();
    let values = || rows.iter().flat_map(|(_, q)| &q.values).copied();
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
        rows.iter().map(|(name, _)| name.clone()).collect(),
        22.0 + used,
        Axis::linear(quantity, low - room, high + room),
    );
    let height = figure.draw(&mut canvas);
    for (row, (_, q)) in rows.iter().enumerate() {
        // Equal values stand above each other, within the row.
        let mut seen: BTreeMap<u64, u32> = BTreeMap::new();
        for value in &q.values {
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
    let rows: Vec<_> = ratings
        .parts
        .iter()
        // Single cells of the design have a few ratings each and stand in the data.
        .filter(|part| part.by.len() < 2)
        .filter_map(|part| Some((part_name(&part.by), part.items.iter().find(|rating| rating.item == item.item)?)))
        .take(MOST_ROWS)
        .collect();
    let mut canvas = Canvas::default();
    let steps: Vec<i32> = (item.steps[0]..=item.steps[1]).collect();
    let marks: Vec<_> = steps
        .iter()
        .map(|&step| {
            let color = color(step, item.steps);
            move |canvas: &mut Canvas, [x, y]: [f64; 2]| {
                canvas.rect([x - 6.0, y - 6.0], [12.0, 12.0], &Paint::fill(color));
            }
        })
        .collect();
    let texts: Vec<String> = steps.iter().map(|step| step.to_string().replace('-', "−")).collect();
    let entries: Vec<crate::svg::Entry<'_>> =
        texts.iter().zip(&marks).map(|(text, mark)| (text.as_str(), mark as &dyn Fn(&mut Canvas, [f64; 2]))).collect();
    let used = legend(&mut canvas, [24.0, 22.0], WIDTH - 48.0, &entries);
    let figure = Rows::new(
        rows.iter().map(|(name, rating)| format!("{name} ({})", rating.mean.n)).collect(),
        22.0 + used,
        Axis::linear("Share of ratings: disagreement to the left, agreement to the right", -1.0, 1.0)
            .with_ticks(5)
            .in_percent(),
    );
    let height = figure.draw(&mut canvas);
    for (row, (_, rating)) in rows.iter().enumerate() {
        let n = rating.mean.n.max(1) as f64;
        let share = |step: i32| rating.count(step) as f64 / n;
        // What is neutral lies half on either side of zero.
        let below: f64 = steps.iter().filter(|step| **step < 0).map(|step| share(*step)).sum();
        let mut from = -(below + 0.5 * share(0));
        for &step in &steps {
            let to = from + share(step);
            let (x0, x1) = (figure.x(from), figure.x(to));
            if to > from {
                canvas.rect([x0, figure.y(row) - 9.0], [x1 - x0, 18.0], &Paint::fill(color(step, item.steps)));
            }
            from = to;
        }
    }
    let zero = figure.x(0.0);
    canvas.line([zero, figure.top], [zero, figure.bottom()], &Paint::ink(1.0));
    canvas.finish(
        [WIDTH, height],
        &format!("Ratings of {}", item.item),
        "Share of each rating, disagreement to the left of zero and agreement to the right, one row for each part.",
    )
}

/// The colour of a step: darker the further from the middle.
fn color(step: i32, [low, high]: [i32; 2]) -> &'static str {
    let shade = |distance: i32, most: i32| ((distance * 3 + most - 1) / most.max(1)).clamp(1, 3) as usize - 1;
    match step {
        0 => NEUTRAL,
        step if step < 0 => DISAGREE[shade(-step, -low)],
        step => AGREE[shade(step, high)],
    }
}

/// How often the reference was recognised, both were called equal, and the test was named, with Wilson intervals.
#[must_use]
pub fn tasks(tasks: &Tasks) -> String {
    let rows: Vec<_> = tasks.parts.iter().take(MOST_ROWS).collect();
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
    let mut figure = Rows::new(
        rows.iter().map(|part| format!("{} ({})", part_name(&part.by), part.recognised.n)).collect(),
        22.0 + used,
        Axis::linear("Share of answers, 95 % (Wilson)", 0.0, 1.0).with_ticks(5).in_percent(),
    );
    figure.row = TALL_ROW;
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
