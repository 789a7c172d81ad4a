//! Where the gaze was over the display.

use super::WIDTH;
use crate::gaze::GazeSample;
use crate::svg::{Anchor, Axis, BLUE, Canvas, Paint, Panel, TextStyle, VERMILION, legend};
use serde::{Deserialize, Serialize};

/// What the gaze is seen against; degrees from the display's centre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GazeView {
    /// Half the display's width and height, degrees.
    pub half_field_deg: [f64; 2],
    /// The fixation point.
    pub fixation_deg: [f64; 2],
    /// Radius of the fixation gate, if the study has one.
    pub gate_deg: Option<f64>,
}

/// Cells along the display's width.
const CELLS: usize = 144;

/// Density of valid gaze samples over the display, with the fixation point and its gate; on the right, the same within
/// twice the gate, where nearly everything lies.
#[must_use]
pub fn gaze_density(samples: &[GazeSample], view: &GazeView) -> String {
    let valid: Vec<[f64; 2]> = samples
        .iter()
        .filter(|s| s.valid && s.position_deg.iter().all(|v| v.is_finite()))
        .map(|s| s.position_deg)
        .collect();
    let half = view.half_field_deg.map(|v| if v.is_finite() && v > 0.0 { v } else { 10.0 });
    let (left, top, width) = (62.0, 58.0, 330.0);
    let tall = (width * half[1] / half[0]).clamp(120.0, 400.0);
    let side = 214.0;
    let height = top + tall.max(side) + 60.0;

    let mut canvas = Canvas::default();
    draw_legend(&mut canvas, left, view.gate_deg.is_some());
    let display = Panel::new(
        [left, top],
        [width, tall],
        Axis::linear("Horizontal (degrees)", -half[0], half[0]).with_ticks(6),
        Axis::linear("Vertical (degrees)", -half[1], half[1]).with_ticks(5),
    );
    draw(&mut canvas, &display, &valid, view, 2.0 * half[0] / CELLS as f64, "Whole display");

    let reach = 2.0 * view.gate_deg.filter(|g| *g > 0.0).unwrap_or(2.0);
    let [x, y] = view.fixation_deg;
    let close = Panel::new(
        [WIDTH - side - 20.0, top],
        [side, side],
        Axis::linear("Horizontal (degrees)", x - reach, x + reach).with_ticks(5),
        Axis::linear("", y - reach, y + reach).with_ticks(5),
    );
    draw(&mut canvas, &close, &valid, view, reach / 32.0, "Around fixation");
    canvas.finish(
        [WIDTH, height],
        "Gaze during stimulus phases",
        &format!("Density of {} valid gaze samples over the display and around the fixation point.", valid.len()),
    )
}

fn draw(canvas: &mut Canvas, panel: &Panel, points: &[[f64; 2]], view: &GazeView, cell_deg: f64, heading: &str) {
    panel.draw_grid(canvas);
    let ([x0, x1], [y0, y1]) = (panel.x.range(), panel.y.range());
    let columns = ((x1 - x0) / cell_deg).ceil().clamp(1.0, 512.0) as usize;
    let rows = ((y1 - y0) / cell_deg).ceil().clamp(1.0, 512.0) as usize;
    let mut counts = vec![0u32; columns * rows];
    let mut inside = 0usize;
    for [x, y] in points {
        let (column, row) = ((x - x0) / cell_deg, (y - y0) / cell_deg);
        if column >= 0.0 && row >= 0.0 && column < columns as f64 && row < rows as f64 {
            counts[row as usize * columns + column as usize] += 1;
            inside += 1;
        }
    }
    let most = f64::from(counts.iter().copied().max().unwrap_or(0).max(1));
    panel.draw(canvas, |canvas| {
        for (index, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let (column, row) = ((index % columns) as f64, (index / columns) as f64);
            let a = panel.px(x0 + column * cell_deg, y0 + (row + 1.0) * cell_deg);
            let b = panel.px(x0 + (column + 1.0) * cell_deg, y0 + row * cell_deg);
            // A square root keeps single samples visible beside the peak.
            let opacity = 0.12 + 0.88 * (f64::from(*count) / most).sqrt();
            canvas.rect(a, [b[0] - a[0] + 0.2, b[1] - a[1] + 0.2], &Paint::fill(BLUE).opacity(opacity));
        }
        if let Some(gate) = view.gate_deg {
            let circle: Vec<[f64; 2]> = (0..=72)
                .map(|i| {
                    let (sin, cos) = (f64::from(i) * 5f64.to_radians()).sin_cos();
                    panel.px(view.fixation_deg[0] + gate * cos, view.fixation_deg[1] + gate * sin)
                })
                .collect();
            canvas.polyline(&circle, &Paint::stroke(VERMILION, 1.6).dashed("5 3"));
        }
        cross(canvas, panel.px(view.fixation_deg[0], view.fixation_deg[1]));
    });
    panel.draw_axes(canvas, [true, true]);
    let share =
        if points.is_empty() { String::new() } else { format!("{:.1} %", 100.0 * inside as f64 / points.len() as f64) };
    panel.draw_heading(canvas, heading, &share);
    if points.is_empty() {
        let middle = [panel.corner[0] + 0.5 * panel.size[0], panel.corner[1] + 0.5 * panel.size[1] - 14.0];
        canvas.text(middle, "no valid samples", TextStyle::new(12.0, Anchor::Middle).muted());
    }
}

fn cross(canvas: &mut Canvas, [x, y]: [f64; 2]) {
    canvas.line([x - 6.0, y], [x + 6.0, y], &Paint::ink(1.6));
    canvas.line([x, y - 6.0], [x, y + 6.0], &Paint::ink(1.6));
}

fn draw_legend(canvas: &mut Canvas, left: f64, gated: bool) {
    let density: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        for i in 0..4 {
            let step = f64::from(i);
            canvas.rect([x - 11.0 + 5.5 * step, y - 6.0], [5.5, 12.0], &Paint::fill(BLUE).opacity(0.15 + 0.28 * step));
        }
    };
    let fixation: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, at| cross(canvas, at);
    let gate: &dyn Fn(&mut Canvas, [f64; 2]) =
        &|canvas, at| canvas.circle(at, 7.0, &Paint::stroke(VERMILION, 1.6).dashed("5 3"));
    let mut entries = vec![("few to many samples", density), ("fixation point", fixation)];
    if gated {
        entries.push(("fixation gate", gate));
    }
    legend(canvas, [left, 18.0], WIDTH - left - 20.0, &entries);
}
