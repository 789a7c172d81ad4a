//! The MAR lines of several observers with the group's line over them.
//!
//! Lines and intervals come in as plain numbers; who fits the group, and how, is no concern of this figure. One observer
//! with all thresholds in detail is [`super::mar_line()`]'s.

use super::parts::{Mark, color, drawable, drawable_interval, keys, left_out, nothing, remark, sentences};
use super::{BandPoint, WIDTH, significant};
use crate::mar::Estimate;
use crate::svg::{Axis, BLUE, Canvas, Paint, Panel};
use serde::{Deserialize, Serialize};

/// One observer's threshold at one eccentricity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LineThreshold {
    /// Eccentricity, degrees.
    pub eccentricity_deg: f64,
    /// Threshold, degrees per cycle; an upper limit where `limited`.
    pub mar_deg: f64,
    /// 95 % interval, degrees per cycle.
    pub ci95: Option<[f64; 2]>,
    /// Below what the display could show.
    pub limited: bool,
}

/// One observer's fitted line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObserverLine {
    /// The observer's code.
    pub observer: String,
    /// Slope m, degrees per cycle per degree.
    pub m: f64,
    /// omega0, degrees per cycle.
    pub omega0_deg: f64,
    /// Thresholds of single eccentricities; may be empty.
    pub thresholds: Vec<LineThreshold>,
}

/// The group's line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupLine {
    /// Slope of the typical observer.
    pub m: Estimate,
    /// omega0 of the typical observer, degrees per cycle.
    pub omega0: Estimate,
    /// The line with its pointwise 95 % band: x in degrees of eccentricity, MAR in degrees per cycle. Without samples the line
    /// is drawn from `m` and `omega0`, without a band.
    pub band: Vec<BandPoint>,
}

/// A line from the literature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReferenceLine {
    /// Its name, for example `Guenter 2012, m = 0.0220`.
    pub name: String,
    /// Slope m, degrees per cycle per degree.
    pub m: f64,
    /// omega0, degrees per cycle.
    pub omega0_deg: f64,
}

/// What [`mar_group`] draws.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MarGroup {
    /// The observers.
    pub observers: Vec<ObserverLine>,
    /// The group, if it was fitted.
    pub group: Option<GroupLine>,
    /// (eccentricity in degrees, finest MAR that the display shows there in degrees per cycle), ascending; may be empty.
    pub finest_mar: Vec<(f64, f64)>,
    /// Lines from the literature; may be empty.
    pub references: Vec<ReferenceLine>,
}

/// Observers told apart by colour; more are drawn alike.
const MOST_NAMED: usize = 6;
const GREY: &str = "#9aa3ad";
const TITLE: &str = "Minimum angle of resolution by eccentricity, observers and group";

/// Every observer's line (thin) and thresholds, the group's line with its 95 % band (thick), what the display cannot show
/// (shaded), and lines from the literature (dotted).
#[must_use]
pub fn mar_group(data: &MarGroup) -> String {
    let good_line = |m: f64, omega0: f64| drawable(m) && drawable(omega0);
    let observers: Vec<&ObserverLine> = data.observers.iter().filter(|o| good_line(o.m, o.omega0_deg)).collect();
    let group = data.group.as_ref().filter(|group| good_line(group.m.estimate, group.omega0.estimate));
    if observers.is_empty() && group.is_none() {
        return nothing(TITLE, "no observer has a line");
    }
    let good = |t: &&LineThreshold| drawable(t.eccentricity_deg) && drawable(t.mar_deg) && t.eccentricity_deg >= 0.0;
    let thresholds = || observers.iter().flat_map(|o| &o.thresholds).filter(good);
    let farthest = thresholds().map(|t| t.eccentricity_deg).fold(0.0, f64::max);
    let sampled = group.iter().flat_map(|group| &group.band).map(|p| p.x).filter(|x| drawable(*x)).fold(0.0, f64::max);
    let span = if farthest > 0.0 {
        1.06 * farthest
    } else if sampled > 0.0 {
        sampled
    } else {
        30.0
    };

    let lines = observers.iter().map(|o| (o.m, o.omega0_deg)).chain(group.map(|g| (g.m.estimate, g.omega0.estimate)));
    let highest_line = lines.map(|(m, omega0)| m * span + omega0).fold(0.0, f64::max);
    let highest = thresholds().map(|t| t.mar_deg).fold(highest_line, f64::max);
    let interval = thresholds().filter_map(|t| drawable_interval(t.ci95?)).map(|ci| ci[1]).fold(highest, f64::max);
    let y = Axis::linear("MAR, ω (degrees per cycle)", 0.0, 1.05 * interval.min(2.0 * highest)).with_ticks(7);

    let mut canvas = Canvas::default();
    let left = Panel::margin(&y, 330.0);
    let top = keys(&mut canvas, left, &legend(data, &observers, group.is_some())) + 6.0;
    let x = Axis::linear("Eccentricity (degrees)", 0.0, span).with_ticks(8);
    let panel = Panel::new([left, top], [WIDTH - left - 20.0, 330.0], x, y);
    panel.draw_grid(&mut canvas);
    panel.draw(&mut canvas, |canvas| {
        draw_limit(canvas, &panel, &data.finest_mar);
        if let Some(group) = group {
            draw_band(canvas, &panel, group);
        }
        for (index, observer) in observers.iter().enumerate() {
            draw_observer(canvas, &panel, observer, index, observers.len());
        }
        for (index, reference) in data.references.iter().enumerate() {
            let ends = [0.0, span].map(|e| panel.px(e, reference.m * e + reference.omega0_deg));
            if good_line(reference.m, reference.omega0_deg) {
                canvas.polyline(&ends, &Paint::ink(1.5).dashed(REFERENCE_DASHES[index % 3]));
            }
        }
        if let Some(group) = group {
            draw_group(canvas, &panel, group, span);
        }
    });
    panel.draw_axes(&mut canvas, [true, true]);
    let bad = data.observers.len() - observers.len() + usize::from(data.group.is_some() && group.is_none());
    let bottom = remark(&mut canvas, top + 330.0 + 56.0, &left_out(bad, "line"));
    canvas.finish([WIDTH, bottom], TITLE, &described(&observers, group))
}

const REFERENCE_DASHES: [&str; 3] = ["2 4", "8 3 2 3", "10 5"];

fn described(observers: &[&ObserverLine], group: Option<&GroupLine>) -> String {
    let group = group.map_or_else(String::new, |group| {
        let text = |e: &Estimate| {
            format!("{} (95 % {} to {})", significant(e.estimate), significant(e.ci95[0]), significant(e.ci95[1]))
        };
        format!("Group: slope m = {}, intercept {} degrees per cycle.", text(&group.m), text(&group.omega0))
    });
    sentences(&[&format!("MAR against eccentricity of {} observers.", observers.len()), &group])
}

fn draw_limit(canvas: &mut Canvas, panel: &Panel, finest_mar: &[(f64, f64)]) {
    let good: Vec<(f64, f64)> =
        finest_mar.iter().copied().filter(|(e, omega)| drawable(*e) && drawable(*omega)).collect();
    let (Some(first), Some(last)) = (good.first(), good.last()) else { return };
    // Beyond what was given, the nearest value holds, as in the fit.
    let [low, high] = panel.x.range();
    let mut edge = vec![panel.px(low.min(first.0), first.1)];
    edge.extend(good.iter().map(|(e, omega)| panel.px(*e, *omega)));
    edge.push(panel.px(high.max(last.0), last.1));
    canvas.polyline(&edge, &Paint::stroke(GREY, 1.2).dashed("2 3"));
    edge.extend([panel.px(high.max(last.0), 0.0), panel.px(low.min(first.0), 0.0)]);
    canvas.polygon(&edge, &Paint::fill(GREY).opacity(0.22));
}

fn observer_paint(index: usize, observers: usize) -> Paint<'static> {
    // Blue is the group's.
    if observers <= MOST_NAMED { Paint::stroke(color(index + 1), 1.3) } else { Paint::muted(1.0).opacity(0.7) }
}

fn draw_observer(canvas: &mut Canvas, panel: &Panel, observer: &ObserverLine, index: usize, observers: usize) {
    let paint = observer_paint(index, observers);
    let [_, span] = panel.x.range();
    let ends = [0.0, span].map(|e| panel.px(e, observer.m * e + observer.omega0_deg));
    canvas.polyline(&ends, &paint);
    // Observers at the same eccentricity stand beside each other.
    let step = (24.0 / observers.max(1) as f64).min(5.0);
    let shift = step * (index as f64 - 0.5 * (observers as f64 - 1.0));
    let at = |t: &LineThreshold, omega: f64| {
        let [x, y] = panel.px(t.eccentricity_deg, omega);
        [x + shift, y]
    };
    for t in observer.thresholds.iter().filter(|t| drawable(t.eccentricity_deg) && drawable(t.mar_deg)) {
        if let Some([low, high]) = t.ci95.and_then(drawable_interval) {
            canvas.line(at(t, low), at(t, high), &paint.opacity(0.6));
        }
        if t.limited {
            canvas.triangle_down(at(t, t.mar_deg), 4.2, &Paint { class: "paper", ..Paint::hollow(paint.stroke, 1.4) });
        } else {
            canvas.circle(at(t, t.mar_deg), 2.8, &Paint::fill(paint.stroke));
        }
    }
}

fn draw_band(canvas: &mut Canvas, panel: &Panel, group: &GroupLine) {
    let good = |p: &&BandPoint| [p.x, p.low, p.high].into_iter().all(drawable);
    let mut region: Vec<[f64; 2]> = group.band.iter().filter(good).map(|p| panel.px(p.x, p.high)).collect();
    region.extend(group.band.iter().rev().filter(good).map(|p| panel.px(p.x, p.low)));
    canvas.polygon(&region, &Paint::fill(BLUE).opacity(0.2));
}

fn draw_group(canvas: &mut Canvas, panel: &Panel, group: &GroupLine, span: f64) {
    let good = |p: &&BandPoint| drawable(p.x) && drawable(p.mid);
    let mut line: Vec<[f64; 2]> = group.band.iter().filter(good).map(|p| panel.px(p.x, p.mid)).collect();
    if line.len() < 2 {
        line = [0.0, span].map(|e| panel.px(e, group.m.estimate * e + group.omega0.estimate)).to_vec();
    }
    canvas.polyline(&line, &Paint::stroke(BLUE, 3.0));
}

fn legend(data: &MarGroup, observers: &[&ObserverLine], group: bool) -> Vec<(String, Mark)> {
    let mut entries: Vec<(String, Mark)> = Vec::new();
    if group {
        entries.push(("group, 95 % band".to_owned(), Mark::LineInBand(Paint::stroke(BLUE, 3.0))));
    }
    if observers.len() <= MOST_NAMED {
        let named = observers.iter().enumerate();
        entries.extend(named.map(|(i, o)| (o.observer.clone(), Mark::LineWithDot(observer_paint(i, observers.len())))));
    } else {
        let text = format!("{} observers, threshold 95 %", observers.len());
        entries.push((text, Mark::LineWithDot(observer_paint(0, observers.len()))));
    }
    for (index, reference) in data.references.iter().enumerate() {
        entries.push((reference.name.clone(), Mark::Line(Paint::ink(1.5).dashed(REFERENCE_DASHES[index % 3]))));
    }
    if observers.iter().flat_map(|o| &o.thresholds).any(|t| t.limited) {
        entries.push((
            "hollow: upper limit".to_owned(),
            Mark::Dot(Paint { class: "paper muted-line", ..Paint::hollow("#59616b", 1.4) }),
        ));
    }
    if !data.finest_mar.is_empty() {
        entries.push(("finer than the display".to_owned(), Mark::Patch(Paint::fill(GREY).opacity(0.3))));
    }
    entries
}
