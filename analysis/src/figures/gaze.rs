//! Where the gaze was over the display.

use super::WIDTH;
use super::parts::{drawable, nothing};
use crate::gaze::GazeSample;
use crate::svg::{Anchor, Axis, Canvas, Paint, Panel, TextStyle, VERMILION, legend, text_width};
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
/// Steps of colour.
const SHADES: usize = 24;
/// The colour map viridis at nine places, dark to bright: even in lightness, and the same order for every colour vision.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];
const TITLE: &str = "Gaze during stimulus phases";

/// Density of valid gaze samples over the display (percent of them per square degree, on a square-root scale), with the
/// fixation point and its gate; on the right, the same within twice the gate, where nearly everything lies.
#[must_use]
pub fn gaze_density(samples: &[GazeSample], view: &GazeView) -> String {
    let valid: Vec<[f64; 2]> = samples
        .iter()
        .filter(|s| s.valid && s.position_deg.iter().all(|v| drawable(*v)))
        .map(|s| s.position_deg)
        .collect();
    if valid.is_empty() {
        return nothing(TITLE, "there are no valid gaze samples");
    }
    // Angles that no display has are not drawn against.
    let angle = |v: &f64| (0.01..=360.0).contains(v);
    let half = view.half_field_deg.map(|v| if angle(&v) { v } else { 10.0 });
    let gate = view.gate_deg.filter(angle);
    let fixation = view.fixation_deg.map(|v| if v.abs() <= 360.0 { v } else { 0.0 });
    let (left, top, width, side) = (62.0, 58.0, 316.0, 196.0);
    let tall = (width * half[1] / half[0]).clamp(120.0, 400.0);
    let reach = 2.0 * gate.unwrap_or(2.0);
    let maps = [
        Map::new(
            &valid,
            Panel::new(
                [left, top],
                [width, tall],
                Axis::linear("Horizontal (degrees)", -half[0], half[0]).with_ticks(6),
                Axis::linear("Vertical (degrees)", -half[1], half[1]).with_ticks(5),
            ),
            2.0 * half[0] / CELLS as f64,
        ),
        Map::new(
            &valid,
            Panel::new(
                [left + width + 50.0, top],
                [side, side],
                Axis::linear("Horizontal (degrees)", fixation[0] - reach, fixation[0] + reach).with_ticks(5),
                Axis::linear("", fixation[1] - reach, fixation[1] + reach).with_ticks(5),
            ),
            reach / 32.0,
        ),
    ];
    // One scale for both panels, so that one colour means one density.
    let most = maps.iter().map(Map::most).fold(0.0, f64::max);
    let mut canvas = Canvas::default();
    draw_legend(&mut canvas, left, gate.is_some());
    for (map, heading) in maps.iter().zip(["Whole display", "Around fixation"]) {
        map.draw(&mut canvas, most, fixation, gate);
        let inside = map.counts.iter().map(|n| f64::from(*n)).sum::<f64>() / valid.len() as f64;
        map.panel.draw_heading(&mut canvas, heading, &format!("{:.1} %", 100.0 * inside));
    }
    // Where every sample lies off the display there is nothing to scale.
    if most > 0.0 {
        draw_scale(&mut canvas, [WIDTH - 62.0, top], side, most);
    }
    let height = top + tall.max(side) + 56.0;
    let lost = samples.len() - valid.len();
    let description = format!(
        "Density of {} valid gaze samples over the display and around the fixation point; {lost} were not valid.",
        valid.len()
    );
    canvas.finish([WIDTH, height], TITLE, &description)
}

/// Samples counted in square cells of a panel.
struct Map {
    panel: Panel,
    cell_deg: f64,
    columns: usize,
    counts: Vec<u32>,
    /// Density of one sample in one cell, percent of all samples per square degree.
    unit: f64,
}

impl Map {
    fn new(points: &[[f64; 2]], panel: Panel, cell_deg: f64) -> Self {
        let ([x0, x1], [y0, y1]) = (panel.x.range(), panel.y.range());
        let columns = ((x1 - x0) / cell_deg).ceil().clamp(1.0, 512.0) as usize;
        let rows = ((y1 - y0) / cell_deg).ceil().clamp(1.0, 512.0) as usize;
        let mut counts = vec![0u32; columns * rows];
        for [x, y] in points {
            let (column, row) = ((x - x0) / cell_deg, (y - y0) / cell_deg);
            if column >= 0.0 && row >= 0.0 && column < columns as f64 && row < rows as f64 {
                counts[row as usize * columns + column as usize] += 1;
            }
        }
        let unit = 100.0 / (points.len() as f64 * cell_deg * cell_deg);
        Self { panel, cell_deg, columns, counts, unit }
    }

    fn most(&self) -> f64 {
        f64::from(self.counts.iter().copied().max().unwrap_or(0)) * self.unit
    }

    fn draw(&self, canvas: &mut Canvas, most: f64, fixation: [f64; 2], gate: Option<f64>) {
        let panel = &self.panel;
        let ([x0, _], [y0, _]) = (panel.x.range(), panel.y.range());
        // Cells of one colour are one shape, and neighbours in a row one rectangle.
        let mut shapes: Vec<Vec<([f64; 2], [f64; 2])>> = vec![Vec::new(); SHADES];
        for (row, counts) in self.counts.chunks(self.columns).enumerate() {
            let shade_of =
                |column: usize| (counts[column] > 0).then(|| shade(f64::from(counts[column]) * self.unit / most));
            let mut column = 0;
            while column < counts.len() {
                let from = column;
                let shade = shade_of(column);
                while column < counts.len() && shade_of(column) == shade {
                    column += 1;
                }
                if let Some(shade) = shade {
                    let a = panel.px(x0 + from as f64 * self.cell_deg, y0 + (row + 1) as f64 * self.cell_deg);
                    let b = panel.px(x0 + column as f64 * self.cell_deg, y0 + row as f64 * self.cell_deg);
                    shapes[shade].push((a, [b[0] - a[0] + 0.15, b[1] - a[1] + 0.15]));
                }
            }
        }
        panel.draw_grid(canvas);
        panel.draw(canvas, |canvas| {
            for (shade, rects) in shapes.iter().enumerate() {
                canvas.rects(rects, &Paint::fill(&color(shade)));
            }
            if let Some(gate) = gate {
                let circle: Vec<[f64; 2]> = (0..=72)
                    .map(|i| {
                        let (sin, cos) = (f64::from(i) * 5f64.to_radians()).sin_cos();
                        panel.px(fixation[0] + gate * cos, fixation[1] + gate * sin)
                    })
                    .collect();
                canvas.polyline(&circle, &Paint::stroke(VERMILION, 1.8).dashed("5 3"));
            }
            cross(canvas, panel.px(fixation[0], fixation[1]));
        });
        panel.draw_axes(canvas, [true, true]);
    }
}

/// The step of colour for a share of the highest density. A square root keeps single samples apart from nothing at all
/// and from each other, beside the peak.
fn shade(share: f64) -> usize {
    ((share.clamp(0.0, 1.0).sqrt() * SHADES as f64) as usize).min(SHADES - 1)
}

fn color(shade: usize) -> String {
    let place = shade as f64 / (SHADES - 1) as f64 * (VIRIDIS.len() - 1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let share = place - below as f64;
    let [r, g, b] =
        [0, 1, 2].map(|i| (VIRIDIS[below][i] + (VIRIDIS[below + 1][i] - VIRIDIS[below][i]) * share).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The scale of densities: a bar with numbers to its right.
fn draw_scale(canvas: &mut Canvas, [x, y]: [f64; 2], tall: f64, most: f64) {
    let place = |density: f64| y + tall * (1.0 - (density / most).clamp(0.0, 1.0).sqrt());
    let step = tall / SHADES as f64;
    for shade in 0..SHADES {
        let top = y + tall - step * (shade + 1) as f64;
        canvas.rect([x, top], [12.0, step + 0.3], &Paint::fill(&color(shade)));
    }
    let mut before = f64::INFINITY;
    for (density, text) in Axis::linear("", 0.0, most).with_ticks(6).ticks() {
        let at = place(density);
        // On a square-root scale the first steps are the widest; the last ones may have no room.
        if before - at > 14.0 {
            canvas.line([x + 12.0, at], [x + 16.0, at], &Paint::ink(1.0));
            let left = (x + 19.0).min(WIDTH - 3.0 - text_width(&text, 11.0));
            canvas.text([left, at + 4.0], &text, TextStyle::new(11.0, Anchor::Start).muted());
            before = at;
        }
    }
    canvas.text([WIDTH - 8.0, y - 8.0], "% / deg²", TextStyle::new(11.0, Anchor::End).muted());
}

fn cross(canvas: &mut Canvas, [x, y]: [f64; 2]) {
    // A light edge around a dark mark is seen on every colour of the map.
    for (color, width) in [("#ffffff", 4.4), ("#000000", 1.8)] {
        // The middle stays open for what lies there.
        for [dx, dy] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
            canvas.line([x + 5.0 * dx, y + 5.0 * dy], [x + 11.0 * dx, y + 11.0 * dy], &Paint::stroke(color, width));
        }
    }
}

fn draw_legend(canvas: &mut Canvas, left: f64, gated: bool) {
    let fixation: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, at| cross(canvas, at);
    let gate: &dyn Fn(&mut Canvas, [f64; 2]) =
        &|canvas, at| canvas.circle(at, 7.0, &Paint::stroke(VERMILION, 1.6).dashed("5 3"));
    let mut entries = vec![("fixation point", fixation)];
    if gated {
        entries.push(("fixation gate", gate));
    }
    legend(canvas, [left, 18.0], WIDTH - left - 20.0, &entries);
}
