//! Box plots: what a box says of its values, boxes by condition (after Weier 2016, Fig. 6), and boxes over eccentricity
//! (after Tursun 2019, Fig. 7).

use super::parts::{Mark, diamond, drawable, keys, left_out, nothing, remark};
use super::row_panel::{Label, Rows};
use super::{WIDTH, significant};
use crate::numerics::{quantile_of_sorted, sorted_finite};
use crate::svg::{Axis, BLUE, Canvas, Paint, VERMILION};
use serde::{Deserialize, Serialize};

/// How far the whiskers of a box go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Whiskers {
    /// To the last value within 1.5 quartile ranges of the box (Tukey 1977); what is beyond is an outlier.
    Tukey,
    /// To the smallest and the largest value.
    Range,
}

/// Five numbers, mean and outliers of some values; all in the unit of the values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoxStats {
    /// How many values.
    pub n: usize,
    /// The median.
    pub median: f64,
    /// First and third quartile (Hyndman and Fan's type 7).
    pub quartiles: [f64; 2],
    /// Ends of the whiskers.
    pub whiskers: [f64; 2],
    /// Values beyond the whiskers, ascending.
    pub outliers: Vec<f64>,
    /// The arithmetic mean.
    pub mean: f64,
    /// Median ± 1.57 quartile ranges / √n: notches that do not overlap speak for different medians (McGill, Tukey and
    /// Larsen 1978).
    pub notch: [f64; 2],
}

impl BoxStats {
    /// The statistics of the finite values; nothing for none.
    ///
    /// ```
    /// use analysis::figures::{BoxStats, Whiskers};
    /// let stats = BoxStats::new(&[1.0, 2.0, 3.0, 4.0, 100.0], Whiskers::Tukey).unwrap();
    /// assert_eq!((stats.quartiles, stats.whiskers, stats.outliers), ([2.0, 4.0], [1.0, 4.0], vec![100.0]));
    /// ```
    #[must_use]
    pub fn new(values: &[f64], whiskers: Whiskers) -> Option<Self> {
        let sorted = sorted_finite(values.iter().copied());
        let quantile = |q| quantile_of_sorted(&sorted, q);
        let quartiles = [quantile(0.25)?, quantile(0.75)?];
        let median = quantile(0.5)?;
        let range = quartiles[1] - quartiles[0];
        let fences = match whiskers {
            Whiskers::Tukey => [quartiles[0] - 1.5 * range, quartiles[1] + 1.5 * range],
            Whiskers::Range => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let inside = || sorted.iter().copied().filter(|v| (fences[0]..=fences[1]).contains(v));
        let n = sorted.len();
        let half = 1.57 * range / (n as f64).sqrt();
        Some(Self {
            n,
            median,
            quartiles,
            // A box without values within its own fences does not exist: the quartiles lie among them.
            whiskers: [inside().next().unwrap_or(quartiles[0]), inside().next_back().unwrap_or(quartiles[1])],
            outliers: sorted.iter().copied().filter(|v| !(fences[0]..=fences[1]).contains(v)).collect(),
            mean: sorted.iter().sum::<f64>() / n as f64,
            notch: [median - half, median + half],
        })
    }
}

/// The values of one condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoxGroup {
    /// Its name.
    pub name: String,
    /// The values, in the unit of the chart's label.
    pub values: Vec<f64>,
}

/// What [`box_plots`] draws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoxChart {
    /// Name of the figure.
    pub title: String,
    /// Label of the values with their unit.
    pub label: String,
    /// One row for each.
    pub groups: Vec<BoxGroup>,
    /// How far the whiskers go.
    pub whiskers: Whiskers,
    /// Draw notches about the medians.
    pub notches: bool,
    /// Ends of the axis, if they should not follow the values: the ends of a rating scale.
    pub range: Option<[f64; 2]>,
}

/// Rows at most; tables hold all.
const MOST_ROWS: usize = 40;

/// One lying box for each condition: median, quartiles, whiskers, outliers (hollow) and mean (diamond).
#[must_use]
pub fn box_plots(chart: &BoxChart) -> String {
    let shown: Vec<(&BoxGroup, Option<BoxStats>)> = chart
        .groups
        .iter()
        .take(MOST_ROWS)
        .map(|group| {
            let good: Vec<f64> = group.values.iter().copied().filter(|v| drawable(*v)).collect();
            (group, BoxStats::new(&good, chart.whiskers))
        })
        .collect();
    let stats = || shown.iter().filter_map(|(_, stats)| stats.as_ref());
    if stats().next().is_none() {
        return nothing(&chart.title, "no condition has a value");
    }
    let drawn: usize = stats().map(|stats| stats.n).sum();
    let bad = shown.iter().map(|(group, _)| group.values.len()).sum::<usize>() - drawn;
    let ends = stats().flat_map(|s| [s.whiskers[0], s.whiskers[1]].into_iter().chain(s.outliers.iter().copied()));
    let range = chart.range.filter(|[a, b]| drawable(*a) && drawable(*b) && a < b);
    let axis =
        Axis::over(&chart.label, ends.chain(range.into_iter().flatten()).collect::<Vec<_>>(), false).with_ticks(9);

    let mut canvas = Canvas::default();
    let mut entries = vec![
        ("median, quartiles".to_owned(), Mark::Patch(Paint::fill(BLUE).opacity(0.35))),
        ("mean".to_owned(), Mark::Diamond),
    ];
    match chart.whiskers {
        Whiskers::Tukey => {
            entries.push(("whiskers: within 1.5 quartile ranges".to_owned(), Mark::Line(Paint::stroke(BLUE, 1.4))));
            if stats().any(|s| !s.outliers.is_empty()) {
                entries.push(("beyond".to_owned(), Mark::Dot(outlier())));
            }
        }
        Whiskers::Range => entries.push(("whiskers: all values".to_owned(), Mark::Line(Paint::stroke(BLUE, 1.4)))),
    }
    if chart.notches {
        entries.push(("notch: about 95 % of the median".to_owned(), Mark::Line(Paint::muted(1.4))));
    }
    let top = keys(&mut canvas, 24.0, &entries);
    let labels = shown
        .iter()
        .map(|(group, stats)| Label::plain(format!("{} ({})", group.name, stats.as_ref().map_or(0, |stats| stats.n))));
    let rows = Rows::new(labels.collect(), top, 34.0, axis);
    let height = rows.draw(&mut canvas);
    for (row, stats) in shown.iter().enumerate().filter_map(|(row, (_, stats))| Some((row, stats.as_ref()?))) {
        let at = |value: f64, across: f64| [rows.x(value), rows.y(row) + across];
        draw_box(&mut canvas, stats, 9.0, BLUE, chart.notches, &at);
        diamond(&mut canvas, at(stats.mean, 0.0), 4.6);
    }
    let more = chart.groups.len() - shown.len();
    let more = if more > 0 { format!("{more} further conditions are not drawn.") } else { String::new() };
    let bottom = remark(&mut canvas, height, &super::parts::sentences(&[&left_out(bad, "value"), &more]));
    let medians: Vec<String> = shown
        .iter()
        .filter_map(|(group, stats)| Some(format!("{} {}", group.name, significant(stats.as_ref()?.median))))
        .collect();
    let description = format!("Box plots of {}. Medians: {}.", chart.label, medians.join(", "));
    canvas.finish([WIDTH, bottom], &chart.title, &description)
}

fn outlier() -> Paint<'static> {
    Paint { class: "paper", ..Paint::hollow(VERMILION, 1.4) }
}

/// A box; `at` maps a value and a distance across to a pixel, so that boxes lie or stand.
pub(super) fn draw_box(
    canvas: &mut Canvas,
    stats: &BoxStats,
    half: f64,
    color: &'static str,
    notched: bool,
    at: &dyn Fn(f64, f64) -> [f64; 2],
) {
    let line = Paint::stroke(color, 1.4);
    let [low, high] = stats.quartiles;
    for (end, from) in [(stats.whiskers[0], low), (stats.whiskers[1], high)] {
        canvas.line(at(from, 0.0), at(end, 0.0), &line);
        canvas.line(at(end, -0.5 * half), at(end, 0.5 * half), &line);
    }
    let waist = 0.5 * half;
    let outline = if notched {
        // A notch may reach beyond its box; the outline then folds back, as everywhere.
        let [from, to] = stats.notch;
        let middle = stats.median;
        vec![
            at(low, -half),
            at(from, -half),
            at(middle, -waist),
            at(to, -half),
            at(high, -half),
            at(high, half),
            at(to, half),
            at(middle, waist),
            at(from, half),
            at(low, half),
        ]
    } else {
        vec![at(low, -half), at(high, -half), at(high, half), at(low, half)]
    };
    canvas.polygon(&outline, &Paint::fill(color).opacity(0.3));
    canvas.polygon(&outline, &line);
    let across = if notched { waist } else { half };
    canvas.line(at(stats.median, -across), at(stats.median, across), &Paint::ink(2.4));
    // Equal outliers stand beside each other.
    let mut before = f64::NAN;
    let mut repeated = 0.0_f64;
    for value in &stats.outliers {
        repeated = if (value - before).abs() > 0.0 || before.is_nan() { 0.0 } else { repeated + 1.0 };
        before = *value;
        let side = if repeated % 2.0 < 0.5 { 1.0 } else { -1.0 };
        let shift = (side * 4.0 * (0.5 * (repeated + 1.0)).floor()).clamp(-half, half);
        canvas.circle(at(*value, shift), 3.0, &outlier());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `tests/peers/figures_peer.py`: matplotlib 3.11.2, `boxplot_stats`.
    #[test]
    fn boxes_are_those_of_other_programs() {
        let values = [2.1, 3.4, 3.9, 4.4, 4.6, 5.0, 5.3, 5.9, 6.2, 7.7, 12.5, -4.0];
        let stats = BoxStats::new(&values, Whiskers::Tukey).unwrap();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} against {b}");
        near(stats.quartiles[0], 3.775);
        near(stats.quartiles[1], 5.975);
        near(stats.median, 4.8);
        assert_eq!(stats.whiskers, [2.1, 7.7]);
        assert_eq!(stats.outliers, [-4.0, 12.5]);
        near(stats.mean, 4.75);
        near(stats.notch[0], 3.802_916_085_109_515_6);
        near(stats.notch[1], 5.797_083_914_890_484);
        let range = BoxStats::new(&values, Whiskers::Range).unwrap();
        assert_eq!((range.whiskers, range.outliers.len()), ([-4.0, 12.5], 0));
        assert_eq!(BoxStats::new(&[f64::NAN], Whiskers::Tukey), None);
    }
}
