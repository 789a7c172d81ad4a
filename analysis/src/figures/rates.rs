//! Detection rates against a multiplier of the foveation, with chance and one just noticeable difference (after Tursun
//! 2019, Fig. 11).

use super::parts::{Mark, color, drawable, keys, left_out, line, nothing, remark};
use super::{WIDTH, significant};
use crate::svg::{Axis, Canvas, Paint, Panel};
use serde::{Deserialize, Serialize};

/// The rate at one multiplier.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RatePoint {
    /// What the predicted blur was multiplied by.
    pub multiplier: f64,
    /// Detection rate, 0–1, mean over observers.
    pub rate: f64,
    /// Standard error of that mean.
    pub standard_error: Option<f64>,
    /// Observers (or trials) behind it.
    pub n: usize,
}

/// The rates of one platform, scene or group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RateSeries {
    /// Its name.
    pub name: String,
    /// The points, in any order.
    pub points: Vec<RatePoint>,
}

/// How detection rates are shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RateView {
    /// Label of the horizontal axis with its unit, for example `Multiplier of σ_s`.
    pub label: String,
    /// The rate of guessing, 0–1.
    pub chance: Option<f64>,
    /// The rate that is called detected, 0–1: 0.75 is one just noticeable difference where ½ is chance.
    pub criterion: Option<f64>,
    /// A logarithmic axis of multipliers.
    pub logarithmic: bool,
}

const TITLE: &str = "Detection rate by multiplier";
const MOST: usize = 14;

/// Mean rates ± one standard error, joined within a series.
#[must_use]
pub fn detection_rates(series: &[RateSeries], view: &RateView) -> String {
    let can = |p: &&RatePoint| {
        super::parts::drawable_on(p.multiplier, view.logarithmic) && drawable(p.rate) && (-0.5..=1.5).contains(&p.rate)
    };
    let shown: Vec<(&RateSeries, Vec<&RatePoint>)> = series
        .iter()
        .take(MOST)
        .map(|one| {
            let mut points: Vec<&RatePoint> = one.points.iter().filter(can).collect();
            points.sort_by(|a, b| a.multiplier.total_cmp(&b.multiplier));
            (one, points)
        })
        .collect();
    let all: Vec<f64> = shown.iter().flat_map(|(_, points)| points).map(|p| p.multiplier).collect();
    if all.is_empty() {
        return nothing(TITLE, "no rate at any multiplier");
    }
    let bad = shown.iter().map(|(one, points)| one.points.len() - points.len()).sum();
    let mut canvas = Canvas::default();
    let tall = 290.0;
    let x = Axis::over(&view.label, all, view.logarithmic).with_ticks(8);
    let y = Axis::linear("Detection rate, mean ± SE", 0.0, 1.04).with_ticks(6).in_percent();
    let left = Panel::margin(&y, tall);
    let mut entries: Vec<(String, Mark)> = shown
        .iter()
        .enumerate()
        .map(|(i, (one, points))| {
            let (least, most) = points.iter().map(|p| p.n).fold((usize::MAX, 0), |(a, b), n| (a.min(n), b.max(n)));
            let n = match (least, most) {
                (_, 0) => String::new(),
                (a, b) if a == b => format!(" (n = {a})"),
                (a, b) => format!(" (n = {a}–{b})"),
            };
            (format!("{}{n}", one.name), Mark::LineWithDot(line(i, 1.8)))
        })
        .collect();
    let share = |value: Option<f64>| value.filter(|v| (0.0..=1.0).contains(v));
    let levels = [(share(view.chance), "chance", "2 4"), (share(view.criterion), "criterion", "8 4")];
    for (level, name, dash) in &levels {
        if let Some(level) = level {
            let text = format!("{name} ({} %)", significant(100.0 * level));
            entries.push((text, Mark::Line(Paint::muted(1.4).dashed(dash))));
        }
    }
    let top = keys(&mut canvas, left, &entries) + 6.0;
    let panel = Panel::new([left, top], [WIDTH - left - 20.0, tall], x, y);
    panel.draw_grid(&mut canvas);
    panel.draw(&mut canvas, |canvas| {
        for (level, _, dash) in &levels {
            if let Some(level) = level {
                let y = panel.px(1.0, *level)[1];
                canvas.line([left, y], [left + panel.size[0], y], &Paint::muted(1.4).dashed(dash));
            }
        }
        for (i, (_, points)) in shown.iter().enumerate() {
            // Error bars of several series stand beside each other.
            let shift = (24.0 / shown.len() as f64).min(6.0) * (i as f64 - 0.5 * (shown.len() - 1) as f64);
            let at = |p: &RatePoint, rate: f64| {
                let [x, y] = panel.px(p.multiplier, rate);
                [x + shift, y]
            };
            let joined: Vec<[f64; 2]> = points.iter().map(|p| at(p, p.rate)).collect();
            canvas.polyline(&joined, &line(i, 1.8));
            for p in points {
                if let Some(se) = p.standard_error.filter(|se| drawable(*se) && *se >= 0.0) {
                    let [low, high] = [p.rate - se, p.rate + se].map(|rate| at(p, rate));
                    super::parts::capped(canvas, low, high, 3.0, &Paint::stroke(color(i), 1.4));
                }
                canvas.circle(at(p, p.rate), 3.8, &Paint::fill(color(i)));
            }
        }
    });
    panel.draw_axes(&mut canvas, [true, true]);
    let more = series.len() - shown.len();
    let more = if more > 0 { format!("{more} further series are not drawn.") } else { String::new() };
    let note = super::parts::sentences(&[&left_out(bad, "rate"), &more]);
    let bottom = remark(&mut canvas, top + tall + 56.0, &note);
    let names: Vec<String> = shown.iter().map(|(one, _)| one.name.clone()).collect();
    let description = format!("Detection rate against {} for {}.", view.label, crate::text::listed(&names));
    canvas.finish([WIDTH, bottom], TITLE, &description)
}
