//! How an adaptive procedure closed in: the level of every trial, and its running estimates.

use super::parts::{drawable, drawable_on, nothing};
use super::{WIDTH, significant};
use crate::mar::Estimate;
use crate::svg::{Axis, BLUE, Canvas, Entry, GREEN, PALETTE, Paint, Panel, legend};
use serde::{Deserialize, Serialize};

/// One trial as the procedure saw it, with its estimates after the answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TrackPoint {
    /// Trial number, from 1.
    pub trial: u32,
    /// Eccentricity, degrees.
    pub eccentricity_deg: f64,
    /// Detail limit shown, degrees per cycle.
    pub mar_deg: f64,
    /// Whether the answer was correct.
    pub correct: bool,
    /// The procedure's estimate of m, if it makes one.
    pub m: Option<Estimate>,
    /// The procedure's estimate of omega0, degrees per cycle, if it makes one.
    pub omega0: Option<Estimate>,
}

/// The level by trial, coloured by eccentricity and filled where correct, above the running estimates of m and omega0.
#[must_use]
pub fn adaptive_track(track: &[TrackPoint]) -> String {
    let good = |point: &TrackPoint| drawable(point.eccentricity_deg) && drawable_on(point.mar_deg, true);
    let track: Vec<TrackPoint> = track.iter().copied().filter(good).collect();
    if track.is_empty() {
        return nothing("The adaptive track", "no trial has a level");
    }
    let track = track.as_slice();
    let last = track.iter().map(|p| f64::from(p.trial)).fold(1.0, f64::max);
    let first = track.iter().map(|p| f64::from(p.trial)).fold(last, f64::min);
    let estimated = track.iter().any(|p| p.m.is_some() || p.omega0.is_some());
    let mut eccentricities: Vec<f64> = track.iter().map(|p| p.eccentricity_deg).collect();
    eccentricities.sort_by(f64::total_cmp);
    eccentricities.dedup();

    let whole = |e: &Estimate| [e.estimate, e.ci95[0], e.ci95[1]].into_iter().all(drawable);
    let mut canvas = Canvas::default();
    let (left, width) = (76.0, WIDTH - 96.0);
    let used = draw_legend(&mut canvas, [left, 22.0], width, &eccentricities);
    let top = 22.0 + used + 6.0;
    let low = track.iter().map(|p| p.mar_deg).fold(f64::INFINITY, f64::min) / 1.2;
    let high = track.iter().map(|p| p.mar_deg).fold(0.0, f64::max) * 1.2;
    let x_axis = |label: &str| Axis::linear(label, first - 1.0, last + 1.0).with_ticks(9);
    let levels = Panel::new(
        [left, top],
        [width, 210.0],
        x_axis(if estimated { "" } else { "Trial" }),
        Axis::logarithmic("Level, ω (°/cycle)", low, high).with_ticks(6),
    );
    levels.draw_grid(&mut canvas);
    levels.draw(&mut canvas, |canvas| {
        for point in track {
            let at = levels.px(f64::from(point.trial), point.mar_deg);
            let color = color(&eccentricities, point.eccentricity_deg);
            let radius = if track.len() > 300 { 2.4 } else { 3.4 };
            let paint = if point.correct { Paint::fill(color).outlined(color, 1.4) } else { Paint::hollow(color, 1.4) };
            canvas.circle(at, radius, &paint);
        }
    });
    levels.draw_axes(&mut canvas, [true, true]);
    let mut height = top + 210.0 + 56.0;

    if estimated {
        height -= 14.0;
        let draw_estimate = |canvas: &mut Canvas,
                             top: f64,
                             label: [&str; 2],
                             color: &str,
                             of: &dyn Fn(&TrackPoint) -> Option<Estimate>| {
            let values: Vec<(f64, Estimate)> =
                track.iter().filter_map(|p| of(p).map(|e| (f64::from(p.trial), e))).filter(|(_, e)| whole(e)).collect();
            // Early intervals are as wide as the prior; the scale follows the later half.
            let settled = &values[values.len() / 4..];
            let high = settled.iter().map(|(_, e)| e.ci95[1]).fold(0.0, f64::max);
            let panel = Panel::new(
                [left, top],
                [width, 110.0],
                x_axis(label[1]),
                // Numbers too small for any acuity would have labels too long for the page.
                Axis::linear(label[0], 0.0, high.max(1e-5) * 1.08).with_ticks(4),
            );
            panel.draw_grid(canvas);
            panel.draw(canvas, |canvas| {
                let mut band: Vec<[f64; 2]> = values.iter().map(|(t, e)| panel.px(*t, e.ci95[1])).collect();
                band.extend(values.iter().rev().map(|(t, e)| panel.px(*t, e.ci95[0])));
                canvas.polygon(&band, &Paint::fill(color).opacity(0.18));
                let line: Vec<[f64; 2]> = values.iter().map(|(t, e)| panel.px(*t, e.estimate)).collect();
                canvas.polyline(&line, &Paint::stroke(color, 2.0));
            });
            panel.draw_axes(canvas, [true, true]);
        };
        draw_estimate(&mut canvas, height, ["m", ""], BLUE, &|p| p.m);
        draw_estimate(&mut canvas, height + 148.0, ["ω₀ (°/cycle)", "Trial"], GREEN, &|p| p.omega0);
        height += 148.0 + 110.0 + 56.0;
    }
    canvas.finish(
        [WIDTH, height],
        "The adaptive track",
        "Level of each trial, coloured by eccentricity, filled where correct; below, the running estimates with 95 % intervals.",
    )
}

fn color(eccentricities: &[f64], eccentricity_deg: f64) -> &'static str {
    let index = eccentricities.iter().position(|e| *e == eccentricity_deg).unwrap_or(0);
    PALETTE[index % PALETTE.len()]
}

/// The coloured mark of one eccentricity.
type Dot = Box<dyn Fn(&mut Canvas, [f64; 2])>;

fn draw_legend(canvas: &mut Canvas, at: [f64; 2], width: f64, eccentricities: &[f64]) -> f64 {
    let labels: Vec<String> = eccentricities.iter().map(|e| format!("{}°", significant(*e))).collect();
    // More eccentricities than colours are told apart by the curves figure.
    let dots: Vec<Dot> = eccentricities
        .iter()
        .take(PALETTE.len())
        .map(|e| {
            let color = color(eccentricities, *e);
            Box::new(move |canvas: &mut Canvas, [x, y]: [f64; 2]| {
                canvas.circle([x + 6.0, y], 4.0, &Paint::fill(color));
            }) as Dot
        })
        .collect();
    let wrong: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.circle([x + 6.0, y], 4.0, &Paint { class: "paper muted-line", ..Paint::hollow("#59616b", 1.4) });
    };
    let mut entries: Vec<Entry<'_>> =
        labels.iter().zip(&dots).map(|(label, dot)| (label.as_str(), dot.as_ref())).collect();
    entries.push(("hollow: wrong answer", wrong));
    legend(canvas, at, width, &entries)
}
