//! What foveation saves, by its quality (after Guenter 2012, Fig. 10).
//!
//! Ratios come in as `parafovea predict` computes them for one quality index after the other, or as they were measured.

use super::parts::{Mark, drawable, drawable_interval, keys, left_out, nothing, remark};
use super::{WIDTH, significant};
use crate::svg::{Anchor, Axis, BLUE, Canvas, GREEN, Paint, Panel, TextStyle, VERMILION, inward, text_width};
use serde::{Deserialize, Serialize};

/// The savings at one quality. All ratios are full resolution over foveated, so that larger saves more.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SpeedupPoint {
    /// Quality index j; larger is finer.
    pub quality: f64,
    /// Pixels of the display over pixels of all layers.
    pub pixels: Option<f64>,
    /// The same with the outer layers at half rate.
    pub pixels_half_rate: Option<f64>,
    /// Time of a full frame over time of a foveated one.
    pub time: Option<f64>,
    /// 95 % interval of the ratio of times.
    pub time_ci95: Option<[f64; 2]>,
}

/// A quality to be marked, for example the mean threshold of a test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QualityMark {
    /// Its name, for example `A: ramp, 11.9`.
    pub name: String,
    /// Quality index j.
    pub quality: f64,
}

/// What [`speedup`] draws.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Speedup {
    /// The points, in any order.
    pub points: Vec<SpeedupPoint>,
    /// Marked qualities; may be empty.
    pub marks: Vec<QualityMark>,
    /// The product m·j, if a second axis shall show the slope that a quality stands for: 0.33 after Guenter 2012.
    pub slope_times_quality: Option<f64>,
}

const TITLE: &str = "Savings by quality of foveation";
const MARK_DASHES: [&str; 4] = ["6 3", "2 3", "9 3 2 3", "12 5"];

type Ratio = fn(&SpeedupPoint) -> Option<f64>;
const SERIES: [(&str, &str, Ratio); 3] = [
    ("pixels", BLUE, |point| point.pixels),
    ("pixels, outer layers at half rate", GREEN, |point| point.pixels_half_rate),
    ("time", VERMILION, |point| point.time),
];

/// Name, colour and points of one line, each point with the ratio that the line is about.
type Drawn<'a> = (&'static str, &'static str, Vec<(&'a SpeedupPoint, f64)>);

/// Ratios of pixels and of time by quality index, with marked qualities and, above, the slope m.
#[must_use]
pub fn speedup(data: &Speedup) -> String {
    let series: Vec<Drawn<'_>> = SERIES
        .iter()
        .map(|(name, color, ratio)| {
            let good = data.points.iter().filter(|point| drawable(point.quality));
            let mut points: Vec<(&SpeedupPoint, f64)> =
                good.filter_map(|point| Some((point, ratio(point)?))).filter(|(_, r)| drawable(*r)).collect();
            points.sort_by(|a, b| a.0.quality.total_cmp(&b.0.quality));
            (*name, *color, points)
        })
        .filter(|(_, _, points)| !points.is_empty())
        .collect();
    if series.is_empty() {
        return nothing(TITLE, "no ratio at any quality");
    }
    let marks: Vec<&QualityMark> = data.marks.iter().filter(|mark| drawable(mark.quality)).collect();
    let drawn = || series.iter().flat_map(|(_, _, points)| points);
    let intervals = || drawn().filter_map(|(point, _)| drawable_interval(point.time_ci95?));
    let highest = drawn().map(|(_, ratio)| *ratio).chain(intervals().map(|ci| ci[1])).fold(1.0, f64::max);
    let qualities = drawn().map(|(point, _)| point.quality).chain(marks.iter().map(|mark| mark.quality));
    let x = Axis::over("Quality index j (coarse to fine)", qualities.collect::<Vec<_>>(), false).with_ticks(11);
    let y = Axis::linear("Full resolution / foveated (ratio)", 0.0, 1.08 * highest).with_ticks(7);

    let mut canvas = Canvas::default();
    let tall = 300.0;
    let left = Panel::margin(&y, tall);
    let mut entries: Vec<(String, Mark)> = series
        .iter()
        .map(|(name, color, _)| ((*name).to_owned(), Mark::LineWithDot(Paint::stroke(color, 2.0))))
        .collect();
    entries.push(("no saving".to_owned(), Mark::Line(Paint::muted(1.2))));
    for (i, mark) in marks.iter().enumerate() {
        entries.push((mark.name.clone(), Mark::Line(Paint::ink(1.4).dashed(MARK_DASHES[i % 4]))));
    }
    let slope = data.slope_times_quality.filter(|product| drawable(*product) && *product > 0.0);
    let top = keys(&mut canvas, left, &entries) + if slope.is_some() { 38.0 } else { 6.0 };
    let panel = Panel::new([left, top], [WIDTH - left - 20.0, tall], x, y);
    panel.draw_grid(&mut canvas);
    panel.draw(&mut canvas, |canvas| {
        let [from, to] = panel.x.range();
        canvas.line(panel.px(from, 1.0), panel.px(to, 1.0), &Paint::muted(1.2));
        for (i, mark) in marks.iter().enumerate() {
            let x = panel.px(mark.quality, 0.0)[0];
            canvas.line([x, top], [x, top + tall], &Paint::ink(1.4).dashed(MARK_DASHES[i % 4]));
        }
        for (name, color, points) in &series {
            let line: Vec<[f64; 2]> = points.iter().map(|(point, ratio)| panel.px(point.quality, *ratio)).collect();
            for (point, _) in points.iter().filter(|_| *name == "time") {
                if let Some([low, high]) = point.time_ci95.and_then(drawable_interval) {
                    let ends = [low, high].map(|ratio| panel.px(point.quality, ratio));
                    canvas.line(ends[0], ends[1], &Paint::stroke(color, 1.4).opacity(0.7));
                }
            }
            canvas.polyline(&line, &Paint::stroke(color, 2.0));
            line.iter().for_each(|at| canvas.circle(*at, 3.2, &Paint::fill(color)));
        }
    });
    panel.draw_axes(&mut canvas, [true, true]);
    if let Some(product) = slope {
        draw_slopes(&mut canvas, &panel, product);
    }
    let bad = data.points.iter().filter(|point| !drawable(point.quality)).count() + data.marks.len() - marks.len();
    let bottom = remark(&mut canvas, top + tall + 56.0, &left_out(bad, "quality value"));
    canvas.finish([WIDTH, bottom], TITLE, &described(&series))
}

fn draw_slopes(canvas: &mut Canvas, panel: &Panel, product: f64) {
    let [x, y] = panel.corner;
    let axis = panel.x.clone().fitting(panel.size[0], |_| 52.0);
    for (quality, _) in axis.ticks().into_iter().filter(|(quality, _)| *quality > 0.0) {
        let at = panel.px(quality, 0.0)[0];
        canvas.line([at, y - 4.0], [at, y], &Paint::ink(1.0));
        let style = TextStyle::new(12.0, Anchor::Middle).muted();
        let text = crate::text::significant(product / quality, 2);
        let middle = x + inward(at - x, text_width(&text, 12.0), panel.size[0]);
        canvas.text([middle, y - 9.0], &text, style);
    }
    let label = format!("Slope m = {}/j (degrees per cycle per degree)", significant(product).trim_end_matches('0'));
    canvas.text([x + 0.5 * panel.size[0], y - 27.0], &label, TextStyle::new(13.0, Anchor::Middle));
}

fn described(series: &[Drawn<'_>]) -> String {
    let mut text = "Ratio of full resolution to foveated rendering by quality index.".to_owned();
    for (name, _, points) in series {
        if let [(first, from), .., (last, to)] = points.as_slice() {
            text.push_str(&format!(
                " {name}: {} at {} to {} at {}.",
                significant(*from),
                significant(first.quality),
                significant(*to),
                significant(last.quality)
            ));
        }
    }
    text
}
