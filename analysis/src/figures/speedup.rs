//! What foveation saves, by its quality (after Guenter 2012, Fig. 10), and what each layer of it costs (Fig. 11).
//!
//! Ratios come in as `parafovea predict` computes them for one quality index after the other, or as
//! `parafovea bench renderers` measures them.

use super::parts::{Mark, RIGHT, drawable, drawable_interval, ink_dot, keys, left_out, nothing, remark};
use super::{WIDTH, significant};
use crate::svg::{
    Anchor, Axis, BLUE, Canvas, GREEN, PALETTE, Paint, Panel, ROOM, TextStyle, VERMILION, inward, text_width,
};
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

/// What others measured at one quality.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PublishedSaving {
    /// Quality index j.
    pub quality: f64,
    /// Ratio of pixels.
    pub pixels: f64,
    /// Ratio of time.
    pub time: f64,
}

/// What one layer costs, by quality.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LayerCurve {
    /// The layer's name.
    pub name: String,
    /// Its points, in any order.
    pub points: Vec<LayerPoint>,
}

/// What one layer costs at one quality, on average over frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LayerPoint {
    /// Quality index j.
    pub quality: f64,
    /// Pixels shaded in a frame.
    pub pixels: Option<f64>,
    /// Milliseconds of a frame.
    pub time_ms: Option<f64>,
}

/// What [`speedup`] draws.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Speedup {
    /// The points, in any order.
    pub points: Vec<SpeedupPoint>,
    /// Marked qualities; may be empty.
    pub marks: Vec<QualityMark>,
    /// What others measured, for comparison; may be empty.
    pub published: Vec<PublishedSaving>,
    /// Who those were.
    pub publication: String,
    /// Layers, innermost first, and after them their sum if that is to be drawn. Without any there are no panels for them.
    pub layers: Vec<LayerCurve>,
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

/// Height of the panels.
const TALL: f64 = 300.0;

/// Name, colour and points of one line, each point with the ratio that the line is about.
type Drawn<'a> = (&'static str, &'static str, Vec<(&'a SpeedupPoint, f64)>);

/// Ratios of pixels and of time by quality index, with marked qualities and, above, the slope m; where there are layers,
/// beside it their pixels and their time.
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
    let published: Vec<&PublishedSaving> =
        data.published.iter().filter(|p| [p.quality, p.pixels, p.time].into_iter().all(drawable)).collect();
    let ratios = drawn().map(|(_, ratio)| *ratio).chain(intervals().map(|ci| ci[1]));
    let highest = ratios.chain(published.iter().flat_map(|p| [p.pixels, p.time])).fold(1.0, f64::max);
    let qualities = drawn().map(|(point, _)| point.quality).chain(marks.iter().map(|mark| mark.quality));
    let qualities: Vec<f64> = qualities.chain(published.iter().map(|p| p.quality)).collect();
    let x = Axis::over("Quality index j (coarse to fine)", qualities, false).with_ticks(11);
    let y = Axis::linear("Full resolution / foveated (ratio)", 0.0, 1.08 * highest).with_ticks(7);
    let costs = Costs::of(&data.layers);

    let mut canvas = Canvas::default();
    let left = Panel::margin(&y, TALL);
    let mut entries: Vec<(String, Mark)> = series
        .iter()
        .map(|(name, color, _)| ((*name).to_owned(), Mark::LineWithDot(Paint::stroke(color, 2.0))))
        .collect();
    entries.push(("no saving".to_owned(), Mark::Line(Paint::muted(1.2))));
    for (i, mark) in marks.iter().enumerate() {
        entries.push((mark.name.clone(), Mark::Line(Paint::ink(1.4).dashed(MARK_DASHES[i % 4]))));
    }
    if !published.is_empty() {
        entries.push((data.publication.clone(), Mark::Diamond));
    }
    entries.extend(costs.iter().flat_map(Costs::keys));
    let slope = data.slope_times_quality.filter(|product| drawable(*product) && *product > 0.0);
    let top = keys(&mut canvas, left, &entries) + if slope.is_some() { 38.0 } else { 6.0 };
    // With layers the page is shared by both halves.
    let right = if costs.is_some() { 0.5 * WIDTH } else { WIDTH - RIGHT };
    let panel = Panel::new([left, top], [right - left, TALL], x.clone(), y);
    panel.draw_grid(&mut canvas);
    panel.draw(&mut canvas, |canvas| {
        let [from, to] = panel.x.range();
        canvas.line(panel.px(from, 1.0), panel.px(to, 1.0), &Paint::muted(1.2));
        draw_marks(canvas, &panel, &marks);
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
        for saving in &published {
            for (ratio, color) in [(saving.pixels, BLUE), (saving.time, VERMILION)] {
                let [x, y] = panel.px(saving.quality, ratio);
                let diamond = [[x - 5.0, y], [x, y - 5.0], [x + 5.0, y], [x, y + 5.0]];
                canvas.polygon(&diamond, &Paint::hollow(color, 1.8));
            }
        }
    });
    panel.draw_axes(&mut canvas, [true, true]);
    if let Some(product) = slope {
        draw_slopes(&mut canvas, &panel, product);
    }
    if let Some(costs) = &costs {
        costs.draw(&mut canvas, [right, top], &x, &marks);
    }
    let bad = data.points.iter().filter(|point| !drawable(point.quality)).count() + data.marks.len() - marks.len();
    let bad = bad + data.published.len() - published.len();
    let bottom = remark(&mut canvas, top + TALL + 56.0, &left_out(bad, "quality value"));
    canvas.finish([WIDTH, bottom], TITLE, &described(&series))
}

fn draw_marks(canvas: &mut Canvas, panel: &Panel, marks: &[&QualityMark]) {
    for (i, mark) in marks.iter().enumerate() {
        let x = panel.px(mark.quality, 0.0)[0];
        let [top, bottom] = [panel.corner[1], panel.corner[1] + panel.size[1]];
        canvas.line([x, top], [x, bottom], &Paint::ink(1.4).dashed(MARK_DASHES[i % 4]));
    }
}

/// What the layers cost, in two panels one above the other.
struct Costs<'a> {
    layers: &'a [LayerCurve],
    /// Label of each panel's axis, and what is drawn of a point; panels without anything to draw are left out.
    panels: Vec<(&'static str, Cost)>,
}

type Cost = fn(&LayerPoint) -> Option<f64>;
const COSTS: [(&str, Cost); 2] =
    [("Pixels (thousand)", |point| Some(1e-3 * point.pixels?)), ("GPU time (ms)", |point| point.time_ms)];

/// The points of a curve that can be drawn, by quality.
fn drawable_points(curve: &LayerCurve, cost: Cost) -> Vec<[f64; 2]> {
    let points = curve.points.iter().filter_map(|point| Some([point.quality, cost(point)?]));
    let mut points: Vec<[f64; 2]> = points.filter(|point| point.iter().all(|x| drawable(*x))).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points
}

impl<'a> Costs<'a> {
    /// Nothing where no layer has anything to draw.
    fn of(layers: &'a [LayerCurve]) -> Option<Self> {
        let any = |cost: Cost| layers.iter().any(|layer| !drawable_points(layer, cost).is_empty());
        let panels: Vec<_> = COSTS.into_iter().filter(|(_, cost)| any(*cost)).collect();
        (!panels.is_empty()).then_some(Self { layers, panels })
    }

    /// The line of a layer: colours that the ratios do not have, and that of text for the last, which is the sum.
    fn line(&self, index: usize) -> Paint<'static> {
        if index + 1 == self.layers.len() {
            Paint::ink(2.0)
        } else {
            Paint::stroke(PALETTE[3 + index % (PALETTE.len() - 3)], 2.0)
        }
    }

    fn keys(&self) -> Vec<(String, Mark)> {
        let key = |(index, layer): (usize, &LayerCurve)| (layer.name.clone(), Mark::LineWithDot(self.line(index)));
        self.layers.iter().enumerate().map(key).collect()
    }

    /// Draws the panels to the right of `corner`, over the qualities of `x`.
    fn draw(&self, canvas: &mut Canvas, corner: [f64; 2], x: &Axis, marks: &[&QualityMark]) {
        let rows = self.panels.len();
        let tall = (TALL - 18.0 * (rows - 1) as f64) / rows as f64;
        let axis = |(label, cost): &(&str, Cost)| {
            let values = self.layers.iter().flat_map(|layer| drawable_points(layer, *cost)).map(|point| point[1]);
            Axis::linear(*label, 0.0, 1.08 * values.fold(0.0, f64::max)).with_ticks(5)
        };
        let axes: Vec<Axis> = self.panels.iter().map(axis).collect();
        let margin = axes.iter().map(|y| Panel::margin(y, tall)).fold(0.0, f64::max);
        for (row, ((_, cost), y)) in self.panels.iter().zip(axes).enumerate() {
            let left = corner[0] + 14.0 + margin;
            let at = [left, corner[1] + row as f64 * (tall + 18.0)];
            let panel = Panel::new(at, [WIDTH - RIGHT - left, tall], x.clone(), y);
            panel.draw_grid(canvas);
            panel.draw(canvas, |canvas| {
                draw_marks(canvas, &panel, marks);
                for (index, layer) in self.layers.iter().enumerate() {
                    let paint = self.line(index);
                    let points =
                        drawable_points(layer, *cost).into_iter().map(|[quality, cost]| panel.px(quality, cost));
                    let points: Vec<[f64; 2]> = points.collect();
                    canvas.polyline(&points, &paint);
                    let dot = if paint.class.is_empty() { Paint::fill(paint.stroke) } else { ink_dot() };
                    points.iter().for_each(|point| canvas.circle(*point, 2.6, &dot));
                }
            });
            panel.draw_axes(canvas, [row + 1 == rows, true]);
        }
    }
}

fn draw_slopes(canvas: &mut Canvas, panel: &Panel, product: f64) {
    let [x, y] = panel.corner;
    let slope = |quality: f64| crate::text::significant(product / quality, 2);
    let widths = panel.x.ticks().into_iter().filter(|(quality, _)| *quality > 0.0);
    let widest = widths.map(|(quality, _)| text_width(&slope(quality), 12.0) + ROOM).fold(52.0, f64::max);
    let axis = panel.x.clone().fitting(panel.size[0], |_| widest);
    for (quality, _) in axis.ticks().into_iter().filter(|(quality, _)| *quality > 0.0) {
        let at = panel.px(quality, 0.0)[0];
        canvas.line([at, y - 4.0], [at, y], &Paint::ink(1.0));
        let style = TextStyle::new(12.0, Anchor::Middle).muted();
        let text = slope(quality);
        let middle = x + inward(at - x, text_width(&text, 12.0), panel.size[0]);
        canvas.text([middle, y - 9.0], &text, style);
    }
    let mut label = format!("Slope m = {}/j", significant(product).trim_end_matches('0'));
    let unit = " (degrees per cycle per degree)";
    if text_width(&label, 13.0) + text_width(unit, 13.0) < panel.size[0] {
        label.push_str(unit);
    }
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
