//! A column of labelled rows over one axis: the frame of figures that compare many conditions, whose names must be read.

use super::WIDTH;
use crate::shares::Mean;
use crate::svg::{Anchor, Axis, BLUE, Canvas, Paint, ROOM, TextStyle, inward, shortened, text_width};

/// Height of a row.
pub(super) const ROW: f64 = 26.0;
const TEXT: f64 = 12.5;

/// A row's label.
pub(super) struct Label {
    text: String,
    bold: bool,
}

impl Label {
    pub(super) fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), bold: false }
    }

    pub(super) fn bold(text: impl Into<String>) -> Self {
        Self { text: text.into(), bold: true }
    }

    /// Labels of parts: the first is all trials.
    pub(super) fn of_parts(names: impl IntoIterator<Item = String>) -> Vec<Self> {
        names.into_iter().enumerate().map(|(i, text)| Self { text, bold: i == 0 }).collect()
    }
}

/// A column of labelled rows over one axis.
pub(super) struct Rows {
    left: f64,
    right: f64,
    pub(super) top: f64,
    row: f64,
    axis: Axis,
    labels: Vec<Label>,
    mirrored: bool,
}

impl Rows {
    pub(super) fn new(labels: Vec<Label>, top: f64, row: f64, axis: Axis) -> Self {
        let widest = labels.iter().map(|label| text_width(&label.text, TEXT)).fold(60.0, f64::max);
        // Bold labels are wider.
        let left = (1.12 * widest + 26.0).min(0.45 * WIDTH);
        let axis = axis.fitting(WIDTH - left - 28.0, |text| text_width(text, 12.0) + ROOM);
        Self { left, right: 28.0, top, row, axis, labels, mirrored: false }
    }

    /// Leaves room for columns of text beside the axis.
    pub(super) fn with_columns(mut self, left: f64, right: f64) -> Self {
        self.left += left;
        self.right += right;
        let width = self.width();
        self.axis = self.axis.fitting(width, |text| text_width(text, 12.0) + ROOM);
        self
    }

    /// Values to the left of 0 are written without their sign: shares to the left are shares all the same.
    pub(super) fn mirrored(self) -> Self {
        Self { mirrored: true, ..self }
    }

    pub(super) fn left(&self) -> f64 {
        self.left
    }

    pub(super) fn width(&self) -> f64 {
        WIDTH - self.left - self.right
    }

    pub(super) fn x(&self, value: f64) -> f64 {
        self.left + self.width() * self.axis.place(value).clamp(0.0, 1.0)
    }

    /// The middle of a row.
    pub(super) fn y(&self, row: usize) -> f64 {
        self.top + (row as f64 + 0.5) * self.row
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.labels.len() as f64 * self.row
    }

    /// Grid, axis and labels, the labels ending `inset` pixels before the axis; returns the figure's height.
    pub(super) fn draw_inset(&self, canvas: &mut Canvas, inset: f64) -> f64 {
        let bottom = self.bottom();
        for (value, text) in self.axis.ticks() {
            let x = self.x(value);
            canvas.line([x, self.top], [x, bottom], &Paint::grid());
            canvas.line([x, bottom], [x, bottom + 4.0], &Paint::ink(1.0));
            let text = if self.mirrored { text.trim_start_matches('−') } else { &text };
            let middle = self.left + inward(x - self.left, text_width(text, 12.0), self.width());
            canvas.text([middle, bottom + 18.0], text, TextStyle::new(12.0, Anchor::Middle).muted());
        }
        canvas.line([self.left, bottom], [self.left + self.width(), bottom], &Paint::ink(1.0));
        // A long label of a narrow axis stays on the page.
        let reach = 0.5 * text_width(&self.axis.label, 13.0) + 8.0;
        let middle = (self.left + 0.5 * self.width()).min(WIDTH - reach);
        canvas.text([middle, bottom + 39.0], &self.axis.label, TextStyle::new(13.0, Anchor::Middle));
        for (row, label) in self.labels.iter().enumerate() {
            let room = self.left - inset - 16.0;
            let text = shortened(&label.text, TEXT, if label.bold { room / 1.12 } else { room });
            let style = TextStyle::new(TEXT, Anchor::End);
            let at = [self.left - inset - 10.0, self.y(row) + 4.0];
            canvas.text(at, &text, if label.bold { style.bold() } else { style });
        }
        bottom + 54.0
    }

    /// Grid, axis and labels; returns the figure's height.
    pub(super) fn draw(&self, canvas: &mut Canvas) -> f64 {
        self.draw_inset(canvas, 0.0)
    }

    /// A mean with its interval.
    pub(super) fn mean(&self, canvas: &mut Canvas, row: usize, mean: &Mean) {
        let y = self.y(row);
        if let Some([low, high]) = mean.ci95 {
            canvas.line([self.x(low), y], [self.x(high), y], &Paint::stroke(BLUE, 2.4));
        }
        canvas.circle([self.x(mean.mean), y], 4.6, &Paint::fill(BLUE));
    }
}
