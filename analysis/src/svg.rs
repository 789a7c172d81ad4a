//! A small SVG writer for figures: shapes, text, and panels with axes.
//!
//! Colours are presentation attributes, so that a figure saved on its own is complete; the classes `ink`, `muted`, `grid`
//! and `paper` let a page restyle them, as the report does for dark screens. Everything is deterministic text.

mod axis;
mod panel;

pub(crate) use axis::{Axis, LARGEST, ROOM, inward};
pub(crate) use panel::{Entry, Panel, legend};

use std::fmt::Write;

/// The colours of Okabe and Ito (2008), which stay apart under every common colour blindness, ordered for contrast.
pub(crate) const PALETTE: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8C7A00"];
/// Blue, for what was fitted.
pub(crate) const BLUE: &str = PALETTE[0];
/// Vermilion, for what needs attention.
pub(crate) const VERMILION: &str = PALETTE[1];
/// Green, for a second quantity.
pub(crate) const GREEN: &str = PALETTE[2];

const INK: &str = "#1b1f24";
const MUTED: &str = "#59616b";
const GRID: &str = "#e3e6ea";
const PAPER: &str = "#ffffff";
const FONT: &str = "system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', 'Liberation Sans', Arial, sans-serif";

/// Text made safe for XML and HTML, in content and in quoted attributes; control characters become spaces.
pub(crate) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\n' | '\t' => safe.push(c),
            c if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}

/// A coordinate with at most two decimals; what is not finite is drawn at 0.
pub(crate) fn coordinate(value: f64) -> String {
    if !value.is_finite() {
        return "0".to_owned();
    }
    let text = format!("{:.2}", value.clamp(-1e6, 1e6));
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// How a shape is painted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paint<'a> {
    pub(crate) fill: &'a str,
    pub(crate) stroke: &'a str,
    pub(crate) width: f64,
    pub(crate) opacity: f64,
    pub(crate) dash: &'a str,
    pub(crate) class: &'a str,
}

impl<'a> Paint<'a> {
    pub(crate) fn stroke(color: &'a str, width: f64) -> Self {
        Self { fill: "none", stroke: color, width, opacity: 1.0, dash: "", class: "" }
    }

    pub(crate) fn fill(color: &'a str) -> Self {
        Self { fill: color, stroke: "none", width: 0.0, opacity: 1.0, dash: "", class: "" }
    }

    /// Lines in the colour of text.
    pub(crate) fn ink(width: f64) -> Self {
        Self { class: "ink-line", ..Self::stroke(INK, width) }
    }

    /// Lines in the colour of secondary text.
    pub(crate) fn muted(width: f64) -> Self {
        Self { class: "muted-line", ..Self::stroke(MUTED, width) }
    }

    pub(crate) fn grid() -> Self {
        Self { class: "grid", ..Self::stroke(GRID, 1.0) }
    }

    /// A stroked shape with the page's colour inside.
    pub(crate) fn hollow(color: &'a str, width: f64) -> Self {
        Self { fill: PAPER, class: "paper", ..Self::stroke(color, width) }
    }

    pub(crate) fn opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    pub(crate) fn dashed(self, dash: &'a str) -> Self {
        Self { dash, ..self }
    }

    pub(crate) fn outlined(self, color: &'a str, width: f64) -> Self {
        Self { stroke: color, width, ..self }
    }

    fn attributes(&self) -> String {
        let mut text = format!(" fill=\"{}\"", self.fill);
        if self.stroke != "none" {
            let _ = write!(text, " stroke=\"{}\" stroke-width=\"{}\"", self.stroke, coordinate(self.width));
        }
        if self.opacity < 1.0 {
            let _ = write!(text, " opacity=\"{}\"", coordinate(self.opacity));
        }
        if !self.dash.is_empty() {
            let _ = write!(text, " stroke-dasharray=\"{}\"", self.dash);
        }
        if !self.class.is_empty() {
            let _ = write!(text, " class=\"{}\"", self.class);
        }
        text
    }
}

/// Where a text stands relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text looks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TextStyle {
    pub(crate) size: f64,
    pub(crate) anchor: Anchor,
    pub(crate) bold: bool,
    pub(crate) muted: bool,
    /// Turned a quarter to the left.
    pub(crate) vertical: bool,
}

impl TextStyle {
    pub(crate) fn new(size: f64, anchor: Anchor) -> Self {
        Self { size, anchor, bold: false, muted: false, vertical: false }
    }

    pub(crate) fn muted(self) -> Self {
        Self { muted: true, ..self }
    }

    pub(crate) fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
}

/// About how wide a text is drawn, in pixels.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    text.chars()
        .map(|c| match c {
            'i' | 'l' | 'j' | '.' | ',' | ':' | '\'' | '|' | ' ' => 0.3,
            'm' | 'w' | 'M' | 'W' | '%' | 'ω' => 0.85,
            c if c.is_uppercase() => 0.68,
            _ => 0.56,
        })
        .sum::<f64>()
        * size
}

/// A text cut with an ellipsis where it would be drawn wider than `width` pixels.
pub(crate) fn shortened(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut kept = String::new();
    for c in text.chars() {
        kept.push(c);
        if text_width(&kept, size) + size > width {
            kept.pop();
            break;
        }
    }
    kept.trim_end().to_owned() + "…"
}

/// Shapes in the order in which they are painted.
#[derive(Debug, Default)]
pub(crate) struct Canvas {
    body: String,
}

impl Canvas {
    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], paint: &Paint<'_>) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(coordinate);
        let _ = writeln!(self.body, "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"{}/>", paint.attributes());
    }

    pub(crate) fn polyline(&mut self, points: &[[f64; 2]], paint: &Paint<'_>) {
        self.points("polyline", points, paint);
    }

    pub(crate) fn polygon(&mut self, points: &[[f64; 2]], paint: &Paint<'_>) {
        self.points("polygon", points, paint);
    }

    /// Closed rings as one shape, filled by the even-odd rule, so that a ring within another is a hole.
    pub(crate) fn rings(&mut self, rings: &[Vec<[f64; 2]>], paint: &Paint<'_>) {
        let mut path = String::new();
        for ring in rings.iter().filter(|ring| ring.len() > 2) {
            for (i, p) in ring.iter().enumerate() {
                let _ = write!(path, "{}{} {}", if i == 0 { 'M' } else { 'L' }, coordinate(p[0]), coordinate(p[1]));
            }
            path.push('Z');
        }
        self.path(&path, "evenodd", paint);
    }

    /// Rectangles (corner, size) of one colour as one shape.
    pub(crate) fn rects(&mut self, rects: &[([f64; 2], [f64; 2])], paint: &Paint<'_>) {
        let mut path = String::new();
        for ([x, y], [w, h]) in rects {
            let [x, y, w, h] = [*x, *y, w.max(0.0), h.max(0.0)].map(coordinate);
            let _ = write!(path, "M{x} {y}h{w}v{h}h-{w}z");
        }
        self.path(&path, "nonzero", paint);
    }

    fn path(&mut self, path: &str, rule: &str, paint: &Paint<'_>) {
        if !path.is_empty() {
            let _ = writeln!(self.body, "<path d=\"{path}\" fill-rule=\"{rule}\"{}/>", paint.attributes());
        }
    }

    fn points(&mut self, element: &str, points: &[[f64; 2]], paint: &Paint<'_>) {
        if points.is_empty() {
            return;
        }
        let list: Vec<String> = points.iter().map(|p| format!("{},{}", coordinate(p[0]), coordinate(p[1]))).collect();
        let _ = writeln!(
            self.body,
            "<{element} points=\"{}\" stroke-linejoin=\"round\"{}/>",
            list.join(" "),
            paint.attributes()
        );
    }

    pub(crate) fn circle(&mut self, centre: [f64; 2], radius: f64, paint: &Paint<'_>) {
        let [x, y, r] = [centre[0], centre[1], radius].map(coordinate);
        let _ = writeln!(self.body, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"{}/>", paint.attributes());
    }

    pub(crate) fn rect(&mut self, corner: [f64; 2], size: [f64; 2], paint: &Paint<'_>) {
        let [x, y] = corner.map(coordinate);
        let [w, h] = size.map(|extent| coordinate(extent.max(0.0)));
        let _ = writeln!(self.body, "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"{}/>", paint.attributes());
    }

    /// A triangle that points down, centred on a point: the mark of an upper limit.
    pub(crate) fn triangle_down(&mut self, centre: [f64; 2], radius: f64, paint: &Paint<'_>) {
        let [x, y] = centre;
        self.polygon(&[[x - radius, y - 0.6 * radius], [x + radius, y - 0.6 * radius], [x, y + 1.1 * radius]], paint);
    }

    pub(crate) fn text(&mut self, at: [f64; 2], text: &str, style: TextStyle) {
        let [x, y, size] = [at[0], at[1], style.size].map(coordinate);
        let anchor = match style.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (class, color) = if style.muted { ("muted", MUTED) } else { ("ink", INK) };
        let weight = if style.bold { " font-weight=\"600\"" } else { "" };
        let turn = if style.vertical { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let _ = writeln!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{color}\" \
             class=\"{class}\"{weight}{turn}>{}</text>",
            escape(text)
        );
    }

    /// Shapes drawn by `draw` in the same coordinates, cut at a rectangle.
    pub(crate) fn clipped(&mut self, corner: [f64; 2], size: [f64; 2], draw: impl FnOnce(&mut Canvas)) {
        let mut inner = Canvas::default();
        draw(&mut inner);
        let [x, y] = corner.map(coordinate);
        let [w, h] = size.map(|extent| coordinate(extent.max(0.0)));
        let _ = writeln!(
            self.body,
            "<svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" viewBox=\"{x} {y} {w} {h}\">\n{}</svg>",
            inner.body
        );
    }

    /// The finished document: `title` names it for screen readers, `description` says what it shows.
    pub(crate) fn finish(self, size: [f64; 2], title: &str, description: &str) -> String {
        let [w, h] = size.map(coordinate);
        let [title, description] = [title, description].map(escape);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" role=\"img\" \
             aria-label=\"{title}. {description}\" font-family=\"{FONT}\">\n<title>{title}</title>\n\
             <desc>{description}</desc>\n<rect width=\"{w}\" height=\"{h}\" fill=\"{PAPER}\" class=\"paper\"/>\n{}</svg>\n",
            self.body
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_cannot_escape_from_text() {
        assert_eq!(escape("<b a=\"1\">&'\u{0}"), "&lt;b a=&quot;1&quot;&gt;&amp;&#39; ");
    }

    #[test]
    fn texts_are_cut_to_their_room() {
        assert_eq!(shortened("short", 12.0, 200.0), "short");
        let cut = shortened("a text that goes on and on", 12.0, 80.0);
        assert!(cut.ends_with('…') && text_width(&cut, 12.0) <= 84.0, "{cut}");
    }

    #[test]
    fn coordinates_are_short_and_always_numbers() {
        assert_eq!(coordinate(1.0), "1");
        assert_eq!(coordinate(-0.001), "0");
        assert_eq!(coordinate(12.3456), "12.35");
        assert_eq!(coordinate(f64::NAN), "0");
        assert_eq!(coordinate(f64::INFINITY), "0");
    }
}
