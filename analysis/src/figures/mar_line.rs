//! The MAR line over its thresholds.

use super::{WIDTH, significant};
use crate::mar::MarFit;
use crate::svg::{Axis, BLUE, Canvas, Paint, Panel, VERMILION, legend};

const GREY: &str = "#9aa3ad";

/// The fitted line with its 95 % band, over thresholds with their intervals (degrees per cycle by degrees).
///
/// Where the eccentricity was not tested the line is dashed. A threshold below what the display could show is a hollow
/// triangle at the display's limit with an arrow downwards; the region finer than the display can show is shaded.
#[must_use]
pub fn mar_line(fit: &MarFit) -> String {
    let height = 430.0;
    let tested: Vec<f64> = fit.thresholds.iter().map(|t| t.eccentricity_deg).collect();
    let last = tested.iter().copied().fold(0.0, f64::max);
    let first = tested.iter().copied().fold(last, f64::min);
    let span = if last > 0.0 { last * 1.06 } else { 1.0 };

    // The highest thing that must be seen; a hopelessly wide interval may leave the frame.
    let middle = fit.thresholds.iter().map(|t| t.mar_deg).fold(fit.line_at(last).estimate, f64::max);
    let upper = fit.thresholds.iter().map(|t| t.ci95[1]).fold(fit.line_at(span).ci95[1], f64::max);
    let top = upper.min(3.0 * middle) * 1.05;
    let x = Axis::linear("Eccentricity (degrees)", 0.0, span);
    let y = Axis::linear("MAR, ω (degrees per cycle)", 0.0, top).with_ticks(6);
    let panel = Panel::new([76.0, 52.0], [WIDTH - 96.0, height - 104.0], x, y);

    let mut canvas = Canvas::default();
    let limited = fit.thresholds.iter().any(|t| t.limited);
    let displayed = !fit.config.finest_mar.is_empty();
    draw_legend(&mut canvas, limited, displayed);
    panel.draw_grid(&mut canvas);
    panel.draw(&mut canvas, |canvas| {
        if displayed {
            let mut region: Vec<[f64; 2]> = panel
                .x
                .steps(60)
                .into_iter()
                .filter_map(|e| fit.config.finest_mar_at(e).map(|omega| panel.px(e, omega)))
                .collect();
            canvas.polyline(&region, &Paint::stroke(GREY, 1.2).dashed("2 3"));
            region.push(panel.px(span, 0.0));
            region.push(panel.px(0.0, 0.0));
            canvas.polygon(&region, &Paint::fill(GREY).opacity(0.22));
        }
        draw_line(canvas, &panel, fit, first, last);
        draw_thresholds(canvas, &panel, fit);
    });
    panel.draw_axes(&mut canvas, [true, true]);

    let description = format!(
        "MAR against eccentricity: slope m = {} (95 % {} to {}), intercept {} degrees per cycle (95 % {} to {}).",
        significant(fit.m.estimate),
        significant(fit.m.ci95[0]),
        significant(fit.m.ci95[1]),
        significant(fit.omega0.estimate),
        significant(fit.omega0.ci95[0]),
        significant(fit.omega0.ci95[1])
    );
    canvas.finish([WIDTH, height], "Minimum angle of resolution by eccentricity", &description)
}

fn draw_line(canvas: &mut Canvas, panel: &Panel, fit: &MarFit, first: f64, last: f64) {
    let (mut low, mut high) = (Vec::new(), Vec::new());
    let (mut before, mut tested, mut after) = (Vec::new(), Vec::new(), Vec::new());
    let mut places = panel.x.steps(40);
    places.extend([first, last]);
    places.sort_by(f64::total_cmp);
    for e in places {
        let line = fit.line_at(e);
        low.push(panel.px(e, line.ci95[0]));
        high.push(panel.px(e, line.ci95[1]));
        let at = panel.px(e, line.estimate);
        if e <= first {
            before.push(at);
        }
        if e >= first && e <= last {
            tested.push(at);
        }
        if e >= last {
            after.push(at);
        }
    }
    low.reverse();
    high.extend(low);
    canvas.polygon(&high, &Paint::fill(BLUE).opacity(0.16));
    canvas.polyline(&before, &Paint::stroke(BLUE, 2.0).dashed("5 4"));
    canvas.polyline(&after, &Paint::stroke(BLUE, 2.0).dashed("5 4"));
    canvas.polyline(&tested, &Paint::stroke(BLUE, 2.2));
}

fn draw_thresholds(canvas: &mut Canvas, panel: &Panel, fit: &MarFit) {
    for t in &fit.thresholds {
        let at = panel.px(t.eccentricity_deg, t.mar_deg);
        if t.limited {
            let tip = [at[0], (at[1] + 26.0).min(panel.corner[1] + panel.size[1] - 3.0)];
            let top = panel.px(t.eccentricity_deg, t.ci95[1]);
            canvas.line(top, [tip[0], tip[1] - 4.0], &Paint::stroke(VERMILION, 1.6));
            canvas.polygon(&[[tip[0] - 4.0, tip[1] - 6.0], [tip[0] + 4.0, tip[1] - 6.0], tip], &Paint::fill(VERMILION));
            canvas.triangle_down(at, 6.0, &Paint::hollow(VERMILION, 1.8));
        } else {
            let [low, high] = t.ci95.map(|omega| panel.px(t.eccentricity_deg, omega));
            canvas.line(low, high, &Paint::ink(1.6));
            for end in [low, high] {
                canvas.line([end[0] - 4.0, end[1]], [end[0] + 4.0, end[1]], &Paint::ink(1.6));
            }
            canvas.circle(at, 4.6, &Paint { class: "ink-dot", ..Paint::fill("#1b1f24") });
        }
    }
}

fn draw_legend(canvas: &mut Canvas, limited: bool, displayed: bool) {
    let line: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.rect([x - 11.0, y - 6.0], [22.0, 12.0], &Paint::fill(BLUE).opacity(0.16));
        canvas.line([x - 11.0, y], [x + 11.0, y], &Paint::stroke(BLUE, 2.2));
    };
    let point: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.line([x, y - 9.0], [x, y + 9.0], &Paint::ink(1.6));
        canvas.circle([x, y], 4.6, &Paint { class: "ink-dot", ..Paint::fill("#1b1f24") });
    };
    let limit: &dyn Fn(&mut Canvas, [f64; 2]) =
        &|canvas, at| canvas.triangle_down(at, 6.0, &Paint::hollow(VERMILION, 1.8));
    let region: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.rect([x - 11.0, y - 6.0], [22.0, 12.0], &Paint::fill(GREY).opacity(0.3));
    };
    let mut entries = vec![("m e + ω₀ with 95 % band", line), ("threshold, 95 %", point)];
    if limited {
        entries.push(("upper limit only", limit));
    }
    if displayed {
        entries.push(("finer than the display", region));
    }
    legend(canvas, [76.0, 24.0], WIDTH - 96.0, &entries);
}
