//! The psychometric function of every eccentricity, as small multiples.

use super::{WIDTH, significant};
use crate::mar::{Cell, MarFit, Threshold};
use crate::svg::{Axis, BLUE, Canvas, Paint, Panel, VERMILION, legend};

/// Columns of panels: two for two or four, otherwise three.
fn columns(panels: usize) -> usize {
    match panels {
        0 | 1 => 1,
        2 | 4 => 2,
        _ => 3,
    }
}

/// Share correct by omega at each eccentricity, with the curve of the joint fit and its 95 % band.
///
/// The area of a point grows with its trials; levels that the display could not show are hollow. A vertical line marks
/// the eccentricity's own threshold, shaded over its 95 % interval; where it is a limit, it is drawn in vermilion. All
/// panels share their axes.
#[must_use]
pub fn psychometric_curves(fit: &MarFit) -> String {
    let panels = fit.thresholds.len();
    let columns = columns(panels);
    let rows = panels.div_ceil(columns).max(1);
    let (left, gap) = (66.0, [16.0, 74.0]);
    // One panel alone is not stretched over the whole page.
    let panel_width = ((WIDTH - left - 18.0 - gap[0] * (columns - 1) as f64) / columns as f64).min(420.0);
    let panel_height = 150.0;

    let low = fit.cells.iter().map(|cell| cell.mar_deg).fold(f64::INFINITY, f64::min);
    let high = fit.cells.iter().map(|cell| cell.mar_deg).fold(0.0, f64::max);
    let most = fit.cells.iter().map(|cell| cell.n).max().unwrap_or(1);

    let mut canvas = Canvas::default();
    let top = 22.0 + draw_legend(&mut canvas, left, fit) + 26.0;
    let height = top + rows as f64 * panel_height + (rows - 1) as f64 * gap[1] + 56.0;
    for (index, threshold) in fit.thresholds.iter().enumerate() {
        let (row, column) = (index / columns, index % columns);
        let corner = [left + column as f64 * (panel_width + gap[0]), top + row as f64 * (panel_height + gap[1])];
        // A label stands where no panel lies below, or none to the left.
        let bottom = index + columns >= panels;
        let x_label = if bottom { "ω (degrees per cycle)" } else { "" };
        let y_label = if column == 0 { "Share correct" } else { "" };
        let panel = Panel::new(
            corner,
            [panel_width, panel_height],
            Axis::logarithmic(x_label, low / 1.25, high * 1.25).with_ticks(4),
            Axis::linear(y_label, -0.05, 1.05).with_ticks(5).in_percent(),
        );
        let cells: Vec<&Cell> =
            fit.cells.iter().filter(|cell| cell.eccentricity_deg == threshold.eccentricity_deg).collect();
        panel.draw_grid(&mut canvas);
        panel.draw(&mut canvas, |canvas| {
            draw_panel(canvas, &panel, fit, threshold, &cells, most);
        });
        panel.draw_axes(&mut canvas, [true, column == 0]);
        panel.draw_heading(
            &mut canvas,
            &format!("{}°", significant(threshold.eccentricity_deg)),
            &format!("{} trials", threshold.trials),
        );
    }
    canvas.finish(
        [WIDTH, height],
        "Psychometric functions by eccentricity",
        "Share of correct answers against the detail limit shown, one panel per eccentricity.",
    )
}

fn draw_panel(canvas: &mut Canvas, panel: &Panel, fit: &MarFit, threshold: &Threshold, cells: &[&Cell], most: u32) {
    let color = if threshold.limited { VERMILION } else { "#009E73" };
    let [low, high] = threshold.ci95.map(|omega| panel.px(omega, 0.0)[0]);
    let (top, bottom) = (panel.corner[1], panel.corner[1] + panel.size[1]);
    canvas.rect([low, top], [high - low, bottom - top], &Paint::fill(color).opacity(0.14));
    let at = panel.px(threshold.mar_deg, 0.0)[0];
    canvas.line([at, top], [at, bottom], &Paint::stroke(color, 1.4));

    let guess = fit.config.guess;
    let [from, to] = panel.x.range();
    canvas.line(panel.px(from, guess), panel.px(to, guess), &Paint::muted(1.0).dashed("3 3"));

    let (mut lower, mut upper, mut middle) = (Vec::new(), Vec::new(), Vec::new());
    for omega in panel.x.steps(48) {
        let p = fit.probability_correct_at(threshold.eccentricity_deg, omega);
        lower.push(panel.px(omega, p.ci95[0]));
        upper.push(panel.px(omega, p.ci95[1]));
        middle.push(panel.px(omega, p.estimate));
    }
    lower.reverse();
    upper.extend(lower);
    canvas.polygon(&upper, &Paint::fill(BLUE).opacity(0.18));
    canvas.polyline(&middle, &Paint::stroke(BLUE, 2.0));

    for cell in cells {
        let share = f64::from(cell.k) / f64::from(cell.n);
        let radius = 1.8 + 5.2 * (f64::from(cell.n) / f64::from(most.max(6))).sqrt();
        let at = panel.px(cell.mar_deg, share);
        if cell.shown {
            let paint = Paint { class: "ink-dot", ..Paint::fill("#1b1f24") }.opacity(0.72);
            canvas.circle(at, radius, &paint);
        } else {
            canvas.circle(at, radius, &Paint { class: "muted-line", ..Paint::stroke("#59616b", 1.2) });
        }
    }
}

fn draw_legend(canvas: &mut Canvas, left: f64, fit: &MarFit) -> f64 {
    let points: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        let paint = Paint { class: "ink-dot", ..Paint::fill("#1b1f24") }.opacity(0.72);
        canvas.circle([x - 6.0, y], 2.6, &paint);
        canvas.circle([x + 4.0, y], 5.0, &paint);
    };
    let curve: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.rect([x - 11.0, y - 6.0], [22.0, 12.0], &Paint::fill(BLUE).opacity(0.18));
        canvas.line([x - 11.0, y], [x + 11.0, y], &Paint::stroke(BLUE, 2.0));
    };
    let own: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.rect([x - 7.0, y - 8.0], [14.0, 16.0], &Paint::fill("#009E73").opacity(0.2));
        canvas.line([x, y - 8.0], [x, y + 8.0], &Paint::stroke("#009E73", 1.6));
    };
    let limit: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.rect([x - 10.0, y - 8.0], [14.0, 16.0], &Paint::fill(VERMILION).opacity(0.2));
        canvas.line([x + 4.0, y - 8.0], [x + 4.0, y + 8.0], &Paint::stroke(VERMILION, 1.6));
    };
    let mut entries =
        vec![("answers (area: trials)", points), ("joint fit, 95 %", curve), ("own threshold, 95 %", own)];
    if fit.thresholds.iter().any(|t| t.limited) {
        entries.push(("upper limit", limit));
    }
    legend(canvas, [left, 22.0], WIDTH - left - 18.0, &entries)
}
