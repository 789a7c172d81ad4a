//! Ratings as diverging stacked bars (after Weier 2016, Fig. 7): disagreement to the left of zero, agreement to the right,
//! and what is neutral half on either side.

use super::WIDTH;
use super::parts::{Mark, keys, nothing, remark};
use super::row_panel::{Label, ROW, Rows};
use crate::svg::{Anchor, Axis, Canvas, Paint, TextStyle};
use serde::{Deserialize, Serialize};

/// The ratings of one condition.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LikertRow {
    /// Its name.
    pub name: String,
    /// How often each step was chosen, from the chart's lowest step on; steps that are missing at the end were not chosen.
    pub counts: Vec<usize>,
}

/// Conditions under one heading.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LikertGroup {
    /// The heading; none if empty.
    pub heading: String,
    /// The conditions.
    pub rows: Vec<LikertRow>,
}

/// What [`likert_bars`] draws.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LikertChart {
    /// Name of the figure: the item that was rated.
    pub title: String,
    /// Lowest and highest step, for example −3 and 3; 0 is neutral.
    pub steps: [i32; 2],
    /// What the lowest and the highest step mean, for example `strongly disagree` and `strongly agree`; may be empty.
    pub ends: [String; 2],
    /// The conditions.
    pub groups: Vec<LikertGroup>,
}

/// Rows at most, headings included; tables hold all.
const MOST_ROWS: usize = 60;
/// Steps on either side of neutral at most.
const MOST_STEPS: i32 = 10;

/// Disagreement to agreement, from blue over grey to vermilion: apart under every common colour blindness.
const DISAGREE: [&str; 3] = ["#9ecae9", "#4292c6", "#08519c"];
const AGREE: [&str; 3] = ["#fdbe85", "#ee7b32", "#a63603"];
const NEUTRAL: &str = "#c4c8cd";

/// Width of a column of percentages.
const COLUMN: f64 = 46.0;

/// One bar for each condition with the percentages of disagreement, neutral and agreement, and the number of ratings.
#[must_use]
pub fn likert_bars(chart: &LikertChart) -> String {
    let [lowest, highest] = chart.steps;
    let span = highest.checked_sub(lowest).filter(|span| *span > 0);
    if span.is_none() || lowest < -MOST_STEPS || highest > MOST_STEPS || lowest > 0 || highest < 0 {
        return nothing(&chart.title, "the scale has no steps on both sides of zero that could be drawn");
    }
    let steps: Vec<i32> = (lowest..=highest).collect();
    let mut labels = Vec::new();
    let mut bars: Vec<Option<Vec<usize>>> = Vec::new();
    for group in &chart.groups {
        if !group.heading.is_empty() {
            labels.push(Label::bold(group.heading.clone()));
            bars.push(None);
        }
        for row in &group.rows {
            let counts: Vec<usize> = (0..steps.len()).map(|i| row.counts.get(i).copied().unwrap_or(0)).collect();
            let n = counts.iter().fold(0usize, |sum, n| sum.saturating_add(*n));
            labels.push(Label::plain(format!("{} ({n})", row.name)));
            bars.push(Some(counts));
        }
    }
    let total = bars.iter().flatten().flatten().fold(0usize, |sum, n| sum.saturating_add(*n));
    if total == 0 {
        return nothing(&chart.title, "there are no ratings");
    }
    let more = labels.len().saturating_sub(MOST_ROWS);
    labels.truncate(MOST_ROWS);
    bars.truncate(MOST_ROWS);

    let mut canvas = Canvas::default();
    let meaning = |step: i32| match step {
        step if step == lowest => &chart.ends[0],
        step if step == highest => &chart.ends[1],
        _ => "",
    };
    let entries: Vec<(String, Mark)> = steps
        .iter()
        .map(|&step| {
            let number = step.to_string().replace('-', "−");
            let text = if meaning(step).is_empty() { number } else { format!("{number} {}", meaning(step)) };
            (text, Mark::Patch(Paint::fill(color(step, chart.steps))))
        })
        .collect();
    let top = keys(&mut canvas, 24.0, &entries) + 16.0;
    let axis =
        Axis::linear("Share of ratings: disagreement left, agreement right", -1.0, 1.0).with_ticks(5).in_percent();
    let figure = Rows::new(labels, top, ROW, axis).with_columns(COLUMN, 2.0 * COLUMN - 14.0).mirrored();
    let height = figure.draw_inset(&mut canvas, COLUMN);

    let right = figure.left() + figure.width();
    let columns = [figure.left() - 6.0, right + COLUMN - 4.0, right + 2.0 * COLUMN - 2.0];
    let small = TextStyle::new(11.5, Anchor::End).muted();
    for (x, text) in columns.into_iter().zip(["below", "neutral", "above"]) {
        canvas.text([x, top - 5.0], text, small);
    }
    let mut described = String::new();
    for (row, counts) in bars.iter().enumerate().filter_map(|(row, counts)| Some((row, counts.as_ref()?))) {
        let n: f64 = counts.iter().map(|n| *n as f64).sum();
        if n == 0.0 {
            continue;
        }
        let share = |of: &dyn Fn(i32) -> bool| -> f64 {
            steps.iter().zip(counts).filter(|(step, _)| of(**step)).map(|(_, count)| *count as f64).sum::<f64>() / n
        };
        let parts = [share(&|step| step < 0), share(&|step| step == 0), share(&|step| step > 0)];
        for (x, part) in columns.into_iter().zip(parts) {
            canvas.text([x, figure.y(row) + 4.0], &format!("{:.0} %", 100.0 * part), small);
        }
        let mut from = -(parts[0] + 0.5 * parts[1]);
        for (&step, &count) in steps.iter().zip(counts).filter(|(_, count)| **count > 0) {
            let to = from + count as f64 / n;
            let (x0, x1) = (figure.x(from), figure.x(to));
            canvas.rect([x0, figure.y(row) - 9.0], [x1 - x0, 18.0], &Paint::fill(color(step, chart.steps)));
            from = to;
        }
        if row < 12 {
            described.push_str(&format!(" {:.0} % below, {:.0} % above neutral;", 100.0 * parts[0], 100.0 * parts[2]));
        }
    }
    let zero = figure.x(0.0);
    canvas.line([zero, figure.top], [zero, figure.bottom()], &Paint::ink(1.0));
    let more = if more > 0 { format!("{more} further rows are not drawn.") } else { String::new() };
    let height = remark(&mut canvas, height, &more);
    let description = format!(
        "Share of each rating, disagreement to the left of zero and agreement to the right, one row for each condition:{}",
        described.trim_end_matches(';')
    );
    canvas.finish([WIDTH, height], &chart.title, &format!("{description}."))
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
