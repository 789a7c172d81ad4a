//! How many observers have their threshold at which level (after Guenter 2012, Fig. 9).

use super::parts::{Mark, Multiples, capped, diamond, drawable, keys, left_out, nothing, remark, sentences};
use super::{WIDTH, significant};
use crate::shares::Mean;
use crate::svg::{Axis, BLUE, Canvas, GREEN, Paint, Panel};
use serde::{Deserialize, Serialize};

/// Mean and standard deviation of a published group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// Where from, for example `Guenter 2012 (15 observers)`.
    pub source: String,
    /// Mean, in the unit of the level.
    pub mean: f64,
    /// Standard deviation over observers.
    pub sd: f64,
}

/// The thresholds of one test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ThresholdGroup {
    /// The test, for example `pair`.
    pub name: String,
    /// One threshold for each observer, in the unit of the level.
    pub values: Vec<f64>,
    /// Observers without a threshold.
    pub without: usize,
    /// A published group to compare with.
    pub published: Option<Published>,
}

/// How histograms of thresholds are shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HistogramView {
    /// Label of the level with its unit, for example `Quality index j`.
    pub label: String,
    /// Width of a bin in the unit of the level; bins are centred on its multiples. `None` chooses a round one for about
    /// twelve bins.
    pub bin: Option<f64>,
    /// Ends of the axis, if they should not follow the thresholds: what was tested.
    pub range: Option<[f64; 2]>,
}

/// Bins of one panel at most.
const MOST_BINS: f64 = 120.0;
/// Panels at most.
const MOST_PANELS: usize = 12;
const TITLE: &str = "Thresholds of observers";

/// Number of observers by threshold, one panel for each test, with mean and standard deviation above the bars.
#[must_use]
pub fn threshold_histograms(groups: &[ThresholdGroup], view: &HistogramView) -> String {
    let shown: Vec<&ThresholdGroup> = groups.iter().take(MOST_PANELS).collect();
    let all: Vec<f64> = shown.iter().flat_map(|group| &group.values).copied().filter(|v| drawable(*v)).collect();
    if all.is_empty() {
        return nothing(TITLE, "no observer has a threshold");
    }
    let bad = shown.iter().map(|group| group.values.len()).sum::<usize>() - all.len();
    let range = view.range.filter(|[a, b]| drawable(*a) && drawable(*b) && a < b);
    let (low, high) = all
        .iter()
        .copied()
        .chain(range.into_iter().flatten())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let bin = bin_width(view.bin, low, high);
    let index = |value: f64| (value / bin).round();
    let (first, last) = (index(low), index(high));
    let bins = (last - first) as usize + 1;
    let counts: Vec<Vec<u32>> = shown
        .iter()
        .map(|group| {
            let mut counts = vec![0; bins];
            for value in group.values.iter().filter(|v| drawable(**v)) {
                counts[((index(*value) - first) as usize).min(bins - 1)] += 1;
            }
            counts
        })
        .collect();
    let most = f64::from(counts.iter().flatten().copied().max().unwrap_or(1));

    let mut canvas = Canvas::default();
    let tall = 128.0;
    // Counts are whole; above them is room for the means.
    let y = |label: &str| Axis::linear(label, 0.0, 1.34 * most.max(3.0)).with_ticks(if most < 4.0 { 4 } else { 5 });
    let top = keys(&mut canvas, 54.0, &legend(&shown)) + 24.0;
    let multiples = Multiples::new(shown.len(), 1, top, tall, &y("Observers"));
    for (i, group) in shown.iter().enumerate() {
        let x = Axis::linear("", (first - 0.8) * bin, (last + 0.8) * bin).with_ticks(12);
        let panel = Panel::new(multiples.corner(i), multiples.size, x, y("Observers"));
        panel.draw_grid(&mut canvas);
        panel.draw(&mut canvas, |canvas| {
            for (j, count) in counts[i].iter().enumerate().filter(|(_, count)| **count > 0) {
                let centre = (first + j as f64) * bin;
                let [x0, y0] = panel.px(centre - 0.44 * bin, f64::from(*count));
                let [x1, y1] = panel.px(centre + 0.44 * bin, 0.0);
                canvas.rect([x0, y0], [x1 - x0, y1 - y0], &Paint::fill(BLUE).opacity(0.85));
            }
            draw_means(canvas, &panel, group);
        });
        panel.draw_axes(&mut canvas, [true, true]);
        panel.draw_heading(&mut canvas, &group.name, &note(group));
    }
    multiples.draw_label(&mut canvas, &view.label);
    let more = groups.len() - shown.len();
    let more = if more > 0 { format!("{more} further tests are not drawn.") } else { String::new() };
    let bottom = remark(&mut canvas, multiples.bottom(), &sentences(&[&left_out(bad, "threshold"), &more]));
    let described: Vec<String> = shown.iter().map(|group| format!("{}: {}.", group.name, note(group))).collect();
    canvas.finish([WIDTH, bottom], TITLE, &format!("Number of observers by {}. {}", view.label, described.join(" ")))
}

fn bin_width(wanted: Option<f64>, low: f64, high: f64) -> f64 {
    let span = (high - low).max(1e-6 * low.abs().max(high.abs())).max(1e-9);
    let rough = span / 12.0;
    let decade = 10f64.powf(rough.log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0].map(|f| f * decade).into_iter().find(|w| *w >= rough).unwrap_or(rough);
    wanted.filter(|w| drawable(*w) && *w > 0.0 && span / w <= MOST_BINS).unwrap_or(round)
}

fn note(group: &ThresholdGroup) -> String {
    let without = if group.without > 0 { format!(", {} without", group.without) } else { String::new() };
    match Mean::new(group.values.iter().copied().filter(|v| drawable(*v))) {
        Some(Mean { n, mean, sd: Some(sd), .. }) => {
            format!("n = {n}{without}, mean {}, SD {}", significant(mean), significant(sd))
        }
        Some(Mean { n, mean, .. }) => format!("n = {n}{without}, mean {}", significant(mean)),
        None => format!("n = 0{without}"),
    }
}

fn draw_means(canvas: &mut Canvas, panel: &Panel, group: &ThresholdGroup) {
    let y = |row: f64| panel.corner[1] + 9.0 + 13.0 * row;
    let at = |value: f64, row: f64| [panel.px(value, 0.0)[0], y(row)];
    if let Some(mean) = Mean::new(group.values.iter().copied().filter(|v| drawable(*v))) {
        if let Some(sd) = mean.sd {
            capped(canvas, at(mean.mean - sd, 0.0), at(mean.mean + sd, 0.0), 3.0, &Paint::ink(1.6));
        }
        diamond(canvas, at(mean.mean, 0.0), 4.6);
    }
    if let Some(Published { mean, sd, .. }) = group.published.as_ref().filter(|p| drawable(p.mean) && drawable(p.sd)) {
        capped(canvas, at(mean - sd, 1.0), at(mean + sd, 1.0), 3.0, &Paint::stroke(GREEN, 1.8));
        canvas.circle(at(*mean, 1.0), 3.8, &Paint::fill(GREEN));
    }
}

fn legend(shown: &[&ThresholdGroup]) -> Vec<(String, Mark)> {
    let mut entries = vec![
        ("observers".to_owned(), Mark::Patch(Paint::fill(BLUE).opacity(0.85))),
        ("mean ± SD".to_owned(), Mark::Diamond),
    ];
    let mut sources: Vec<&str> =
        shown.iter().filter_map(|group| group.published.as_ref()).map(|p| p.source.as_str()).collect();
    sources.dedup();
    if !sources.is_empty() {
        entries.push((format!("{}, mean ± SD", sources.join("; ")), Mark::Lying(Paint::stroke(GREEN, 1.8))));
    }
    entries
}
