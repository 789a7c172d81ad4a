//! A panel: a rectangle with two axes, into which marks are drawn in data units, and the legend above it.

use super::{Anchor, Axis, Canvas, Paint, ROOM, TextStyle, inward, shortened, text_width};

const TICK: f64 = 12.0;
const LABEL: f64 = 13.0;

/// A plotting area on a canvas; pixels of the figure, origin at its top left.
#[derive(Debug, Clone)]
pub(crate) struct Panel {
    pub(crate) corner: [f64; 2],
    pub(crate) size: [f64; 2],
    pub(crate) x: Axis,
    pub(crate) y: Axis,
}

impl Panel {
    /// A panel whose axes have as many ticks as there is room for.
    pub(crate) fn new(corner: [f64; 2], size: [f64; 2], x: Axis, y: Axis) -> Self {
        let x = x.fitting(size[0], |text| text_width(text, TICK) + ROOM);
        let y = y.fitting(size[1], |_| 1.4 * TICK);
        Self { corner, size, x, y }
    }

    /// How far the numbers and the label of the vertical axis reach to the left of the panel.
    pub(crate) fn margin(y: &Axis, height: f64) -> f64 {
        let y = y.clone().fitting(height, |_| 1.4 * TICK);
        let widest = y.ticks().iter().map(|(_, text)| text_width(text, TICK)).fold(0.0, f64::max);
        widest + if y.label.is_empty() { 14.0 } else { 36.0 }
    }

    /// The pixel of a data point.
    pub(crate) fn px(&self, x: f64, y: f64) -> [f64; 2] {
        [self.corner[0] + self.size[0] * self.x.place(x), self.corner[1] + self.size[1] * (1.0 - self.y.place(y))]
    }

    /// Grid lines, behind everything.
    pub(crate) fn draw_grid(&self, canvas: &mut Canvas) {
        let [x, y] = self.corner;
        let [w, h] = self.size;
        for (value, _) in self.x.ticks() {
            let at = x + w * self.x.place(value);
            canvas.line([at, y], [at, y + h], &Paint::grid());
        }
        for (value, _) in self.y.ticks() {
            let at = y + h * (1.0 - self.y.place(value));
            canvas.line([x, at], [x + w, at], &Paint::grid());
        }
    }

    /// Marks in data units, cut at the frame.
    pub(crate) fn draw(&self, canvas: &mut Canvas, draw: impl FnOnce(&mut Canvas)) {
        canvas.clipped(self.corner, self.size, draw);
    }

    /// Axis lines, ticks, numbers and labels. `numbers` switches the numbers of each axis, for inner small multiples.
    pub(crate) fn draw_axes(&self, canvas: &mut Canvas, numbers: [bool; 2]) {
        let [x, y] = self.corner;
        let [w, h] = self.size;
        for (value, text) in self.x.ticks() {
            let at = x + w * self.x.place(value);
            canvas.line([at, y + h], [at, y + h + 4.0], &Paint::ink(1.0));
            if numbers[0] {
                let middle = x + inward(at - x, text_width(&text, TICK), w);
                canvas.text([middle, y + h + 18.0], &text, TextStyle::new(TICK, Anchor::Middle).muted());
            }
        }
        if numbers[0] && !self.x.label.is_empty() {
            let label = shortened(&self.x.label, LABEL, w + 14.0);
            canvas.text([x + 0.5 * w, y + h + 39.0], &label, TextStyle::new(LABEL, Anchor::Middle));
        }
        self.draw_frame(canvas, numbers[1]);
    }

    /// Both axis lines, and the ticks, numbers and label of the vertical one.
    pub(crate) fn draw_frame(&self, canvas: &mut Canvas, numbers: bool) {
        let [x, y] = self.corner;
        let [w, h] = self.size;
        canvas.line([x, y + h], [x + w, y + h], &Paint::ink(1.0));
        canvas.line([x, y], [x, y + h], &Paint::ink(1.0));
        let mut widest: f64 = 0.0;
        for (value, text) in self.y.ticks() {
            let at = y + h * (1.0 - self.y.place(value));
            canvas.line([x - 4.0, at], [x, at], &Paint::ink(1.0));
            if numbers {
                widest = widest.max(text_width(&text, TICK));
                canvas.text([x - 8.0, at + 4.0], &text, TextStyle::new(TICK, Anchor::End).muted());
            }
        }
        if numbers && !self.y.label.is_empty() {
            let style = TextStyle { vertical: true, ..TextStyle::new(LABEL, Anchor::Middle) };
            let label = shortened(&self.y.label, LABEL, h + 10.0);
            canvas.text([(x - 18.0 - widest).max(12.0), y + 0.5 * h], &label, style);
        }
    }

    /// A heading inside the top left of the panel's upper margin.
    pub(crate) fn draw_heading(&self, canvas: &mut Canvas, heading: &str, note: &str) {
        let at = [self.corner[0], self.corner[1] - 8.0];
        // Bold is wider.
        let room = (self.size[0] - text_width(note, TICK) - 12.0) / 1.2;
        canvas.text(at, &shortened(heading, LABEL, room), TextStyle::new(LABEL, Anchor::Start).bold());
        if !note.is_empty() {
            let note_at = [at[0] + self.size[0], at[1]];
            canvas.text(note_at, note, TextStyle::new(TICK, Anchor::End).muted());
        }
    }
}

/// A legend's text, and the mark that draws itself around a point.
pub(crate) type Entry<'a> = (&'a str, &'a dyn Fn(&mut Canvas, [f64; 2]));

/// A row of legend entries from `at` on, wrapping at `width`; each `mark` draws itself around its point.
///
/// Returns the height used.
pub(crate) fn legend(canvas: &mut Canvas, at: [f64; 2], width: f64, entries: &[Entry<'_>]) -> f64 {
    let [mut x, mut y] = at;
    for (text, mark) in entries {
        let text = shortened(text, TICK, width - 32.0);
        let needed = 30.0 + text_width(&text, TICK) + 14.0;
        if x > at[0] && x + needed > at[0] + width + 14.0 {
            (x, y) = (at[0], y + 20.0);
        }
        mark(canvas, [x + 11.0, y]);
        canvas.text([x + 28.0, y + 4.0], &text, TextStyle::new(TICK, Anchor::Start));
        x += needed;
    }
    y - at[1] + 20.0
}
