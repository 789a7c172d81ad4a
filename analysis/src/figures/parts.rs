//! What several figures share: colours of series, legend marks, small multiples, and the figure for nothing at all.
//!
//! Which data a figure takes and what it draws of them stands with the figure; axes and shapes are [`crate::svg`]'s.

use super::WIDTH;
use crate::svg::{Anchor, Axis, Canvas, LARGEST, PALETTE, Paint, Panel, TextStyle, legend, shortened};

/// Dashes that tell series of the same colour apart.
const DASHES: [&str; 3] = ["", "7 4", "2 3"];
/// Room to the right of the last panel.
pub(crate) const RIGHT: f64 = 20.0;

/// Whether a number can be drawn: finite, and not beyond every quantity of this field.
pub(crate) fn drawable(value: f64) -> bool {
    value.is_finite() && value.abs() <= LARGEST
}

/// Whether a number can be drawn on an axis.
pub(crate) fn drawable_on(value: f64, logarithmic: bool) -> bool {
    drawable(value) && (!logarithmic || value > 1.0 / LARGEST)
}

/// An interval if both its ends can be drawn, the lower one first.
pub(crate) fn drawable_interval(interval: [f64; 2]) -> Option<[f64; 2]> {
    let [a, b] = interval;
    (drawable(a) && drawable(b)).then(|| [a.min(b), a.max(b)])
}

/// The colour of the `index`th series.
pub(crate) fn color(index: usize) -> &'static str {
    PALETTE[index % PALETTE.len()]
}

/// The line of the `index`th series: as many colours as there are, then the same ones dashed.
pub(crate) fn line(index: usize, width: f64) -> Paint<'static> {
    Paint::stroke(color(index), width).dashed(DASHES[index / PALETTE.len() % DASHES.len()])
}

/// Points in the colour of text.
pub(crate) fn ink_dot() -> Paint<'static> {
    Paint { class: "ink-dot", ..Paint::fill("#1b1f24") }
}

/// What stands beside a legend's text.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Mark {
    /// A filled point.
    Dot(Paint<'static>),
    /// A line.
    Line(Paint<'static>),
    /// A line in a band of its own colour.
    LineInBand(Paint<'static>),
    /// A line with a point on it.
    LineWithDot(Paint<'static>),
    /// A patch of colour.
    Patch(Paint<'static>),
    /// A point with a standing interval.
    Standing(Paint<'static>),
    /// A point with a lying interval.
    Lying(Paint<'static>),
    /// A small and a large point: area says how many.
    Area,
    /// A mean among box plots.
    Diamond,
}

impl Mark {
    fn draw(self, canvas: &mut Canvas, [x, y]: [f64; 2]) {
        let filled = |paint: Paint<'static>| match paint.class {
            "ink-line" => ink_dot(),
            class => Paint { class, ..Paint::fill(paint.stroke) },
        };
        match self {
            Self::Dot(paint) => canvas.circle([x, y], 4.4, &paint),
            Self::Line(paint) => canvas.line([x - 11.0, y], [x + 11.0, y], &paint),
            Self::LineInBand(paint) => {
                canvas.rect([x - 11.0, y - 6.0], [22.0, 12.0], &Paint::fill(paint.stroke).opacity(0.18));
                canvas.line([x - 11.0, y], [x + 11.0, y], &paint);
            }
            Self::LineWithDot(paint) => {
                canvas.line([x - 11.0, y], [x + 11.0, y], &paint);
                canvas.circle([x, y], 3.8, &filled(paint));
            }
            Self::Patch(paint) => canvas.rect([x - 8.0, y - 6.0], [16.0, 12.0], &paint),
            Self::Standing(paint) => {
                canvas.line([x, y - 8.0], [x, y + 8.0], &paint);
                canvas.circle([x, y], 3.8, &filled(paint));
            }
            Self::Lying(paint) => {
                capped(canvas, [x - 10.0, y], [x + 10.0, y], 3.0, &paint);
                canvas.circle([x, y], 3.8, &filled(paint));
            }
            Self::Area => {
                canvas.circle([x - 6.0, y], 2.4, &ink_dot().opacity(0.75));
                canvas.circle([x + 4.0, y], 5.0, &ink_dot().opacity(0.75));
            }
            Self::Diamond => diamond(canvas, [x, y], 5.0),
        }
    }
}

/// A line whose ends have caps across it, `cap` pixels to either side; lying or standing.
pub(crate) fn capped(canvas: &mut Canvas, from: [f64; 2], to: [f64; 2], cap: f64, paint: &Paint<'_>) {
    canvas.line(from, to, paint);
    let lying = (to[0] - from[0]).abs() >= (to[1] - from[1]).abs();
    let [dx, dy] = if lying { [0.0, cap] } else { [cap, 0.0] };
    for [x, y] in [from, to] {
        canvas.line([x - dx, y - dy], [x + dx, y + dy], &Paint { dash: "", ..*paint });
    }
}

/// A diamond in the page's colour with a line of text's colour around it.
pub(crate) fn diamond(canvas: &mut Canvas, [x, y]: [f64; 2], radius: f64) {
    let paint = Paint { class: "paper ink-line", ..Paint::hollow("#1b1f24", 1.5) };
    canvas.polygon(&[[x - radius, y], [x, y - radius], [x + radius, y], [x, y + radius]], &paint);
}

/// The legend above a figure; returns where the panels' headings may begin.
pub(crate) fn keys(canvas: &mut Canvas, left: f64, keys: &[(String, Mark)]) -> f64 {
    if keys.is_empty() {
        return 12.0;
    }
    type Draw = Box<dyn Fn(&mut Canvas, [f64; 2])>;
    let marks: Vec<Draw> = keys
        .iter()
        .map(|(_, mark)| {
            let mark = *mark;
            Box::new(move |canvas: &mut Canvas, at| mark.draw(canvas, at)) as Draw
        })
        .collect();
    let entries: Vec<_> = keys.iter().zip(&marks).map(|((text, _), mark)| (text.as_str(), mark.as_ref())).collect();
    22.0 + legend(canvas, [left, 22.0], WIDTH - left - RIGHT, &entries)
}

/// Equal panels in rows and columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Multiples {
    panels: usize,
    columns: usize,
    left: f64,
    top: f64,
    pub(crate) size: [f64; 2],
    gap: [f64; 2],
}

impl Multiples {
    /// Panels of a height below `top`, with headings; the vertical axis is numbered at the left of each row only.
    pub(crate) fn new(panels: usize, columns: usize, top: f64, height: f64, y: &Axis) -> Self {
        let columns = columns.clamp(1, panels.max(1));
        let left = Panel::margin(y, height).max(54.0);
        // Below each row are numbers, and the headings of the next; the label stands below the last one only.
        let gap = [18.0, 64.0];
        // One panel alone is as wide as the page; a few are not stretched.
        let room = WIDTH - left - RIGHT - gap[0] * (columns - 1) as f64;
        Self { panels: panels.max(1), columns, left, top, size: [room / columns as f64, height], gap }
    }

    /// The usual number of columns: two for two or four panels, otherwise three.
    pub(crate) fn columns(panels: usize) -> usize {
        match panels {
            0 | 1 => 1,
            2 | 4 => 2,
            _ => 3,
        }
    }

    pub(crate) fn corner(&self, index: usize) -> [f64; 2] {
        let (row, column) = (index / self.columns, index % self.columns);
        [self.left + column as f64 * (self.size[0] + self.gap[0]), self.top + row as f64 * (self.size[1] + self.gap[1])]
    }

    /// Whether no panel lies to the left.
    pub(crate) fn is_left(&self, index: usize) -> bool {
        index.is_multiple_of(self.columns)
    }

    /// One label of the horizontal axis below all panels.
    pub(crate) fn draw_label(&self, canvas: &mut Canvas, label: &str) {
        let columns = self.columns as f64;
        let width = columns * self.size[0] + (columns - 1.0) * self.gap[0];
        let at = [self.left + 0.5 * width, self.bottom() - 17.0];
        canvas.text(at, &shortened(label, 13.0, width + 14.0), TextStyle::new(13.0, Anchor::Middle));
    }

    /// Where the figure ends, axis labels included.
    pub(crate) fn bottom(&self) -> f64 {
        let rows = self.panels.div_ceil(self.columns) as f64;
        self.top + rows * (self.size[1] + self.gap[1]) - self.gap[1] + 56.0
    }
}

/// A small muted remark below a figure; returns the figure's new height. An empty one takes no room.
pub(crate) fn remark(canvas: &mut Canvas, bottom: f64, text: &str) -> f64 {
    if text.is_empty() {
        return bottom;
    }
    // About as many characters as fit at this size.
    let mut y = bottom + 8.0;
    let mut row = String::new();
    let style = TextStyle::new(12.0, Anchor::Start).muted();
    for word in text.split(' ') {
        if !row.is_empty() && crate::svg::text_width(&format!("{row} {word}"), 12.0) > 0.9 * (WIDTH - 48.0) {
            canvas.text([24.0, y], &row, style);
            y += 17.0;
            row.clear();
        }
        if !row.is_empty() {
            row.push(' ');
        }
        row.push_str(word);
    }
    canvas.text([24.0, y], &row, style);
    y + 14.0
}

/// `3 values cannot be drawn and are left out.`, or nothing.
pub(crate) fn left_out(count: usize, what: &str) -> String {
    match count {
        0 => String::new(),
        1 => format!("1 {what} that is no drawable number is left out."),
        n => format!("{n} {what}s that are no drawable numbers are left out."),
    }
}

/// Sentences with a space between, without the empty ones.
pub(crate) fn sentences(texts: &[&str]) -> String {
    texts.iter().filter(|text| !text.is_empty()).copied().collect::<Vec<_>>().join(" ")
}

/// A figure that says why there is nothing to see.
pub(crate) fn nothing(title: &str, why: &str) -> String {
    let mut canvas = Canvas::default();
    let size = [WIDTH, 120.0];
    canvas.rect([24.0, 16.0], [WIDTH - 48.0, 88.0], &Paint::muted(1.0).dashed("4 4"));
    canvas.text([0.5 * WIDTH, 56.0], title, TextStyle::new(13.0, Anchor::Middle).bold());
    canvas.text([0.5 * WIDTH, 78.0], &format!("Nothing to draw: {why}."), TextStyle::new(13.0, Anchor::Middle).muted());
    canvas.finish(size, title, &format!("Nothing to draw: {why}."))
}
