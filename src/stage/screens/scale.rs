//! A scale: a statement or question over a row of boxes, one for each step, with the digit that chooses it inside, its
//! value beneath, and what the ends mean below.

use super::lettering::{Lettering, Place};
use super::{INK, LEADING, LINE_DEG, SHRINK, SMALLEST_PX, blank, cover, draw_hint, room, size};
use experiments::Display;
use experiments::trial::Scale;
use image::RgbaImage;

/// Side of a box, and between two of them at least, in line heights.
const BOX: f64 = 1.9;
const GAP: f64 = 0.7;
/// The widest that values are set before they are broken into lines, and the space between them, in line heights.
const VALUE_WIDTH: f64 = 5.0;
const VALUE_GAP: f64 = 0.6;
/// Thickness of a box's border and radius of its corners, in line heights.
const BORDER: f64 = 0.07;
const CORNER: f64 = 0.3;
/// Space between question and boxes, between boxes and values, between values and anchors, in line heights.
const UNDER_QUESTION: f64 = 1.1;
const UNDER_BOXES: f64 = 0.25;
const UNDER_VALUES: f64 = 0.3;
/// Height of values and anchors, in line heights.
const VALUE: f64 = 0.8;
const ANCHOR: f64 = 0.85;
/// The share of the row's width that each end's words may take.
const ANCHOR_SHARE: f64 = 0.46;
/// A box is a little lighter than the page.
const BOX_FILL: ([u8; 3], f64) = ([255, 255, 255], 0.28);

/// Everything placed for one size of type, px.
struct Layout {
    line_px: f64,
    question: Vec<String>,
    /// Values under the boxes, if any says more than its digit, and the size of their type.
    values: Option<(Vec<Vec<String>>, f64)>,
    anchors: [Vec<String>; 2],
    /// From the middle of a box to the next one's.
    pitch: f64,
    row_width: f64,
    height: f64,
}

impl Layout {
    fn new(lettering: &Lettering<'_>, scale: &Scale, line_px: f64, room_px: f64) -> Self {
        let steps = scale.steps.len().max(1) as f64;
        let question = lettering.wrap(&scale.question, line_px, room_px);
        let says_more = scale.steps.iter().zip(1..).any(|(step, digit)| !step.is_empty() && *step != digit.to_string());

        // Boxes stand as far apart as their values and the words at the ends need, if there is room.
        let (mut value_px, anchor_px) = (VALUE * line_px, ANCHOR * line_px);
        let labels: Vec<String> = scale.steps.iter().map(|step| with_minus(step)).collect();
        let widest_word =
            |text: &str, px: f64| text.split_whitespace().map(|word| lettering.width(word, px)).fold(0.0, f64::max);
        let longest = labels.iter().map(|label| widest_word(label, value_px)).fold(0.0, f64::max);
        let wanted = lettering.widest(&labels, value_px).min(VALUE_WIDTH * line_px).max(longest);
        let for_values = if says_more { wanted + VALUE_GAP * line_px } else { 0.0 };
        let anchor_word = widest_word(&scale.low, anchor_px).max(widest_word(&scale.high, anchor_px));
        let for_anchors = (anchor_word / ANCHOR_SHARE - BOX * line_px) / (steps - 1.0).max(1.0);
        let least = (BOX + GAP) * line_px;
        let pitch = for_values.max(for_anchors).min(room_px / steps).max(least);
        let row_width = (steps - 1.0) * pitch + BOX * line_px;
        let values = says_more.then(|| {
            let value_room_px = pitch - 0.5 * VALUE_GAP * line_px;
            let wrap = |value_px: f64| -> Vec<Vec<String>> {
                labels.iter().map(|label| lettering.wrap(label, value_px, value_room_px)).collect()
            };
            while wrap(value_px).iter().any(|lines| lettering.widest(lines, value_px) > value_room_px)
                && value_px > SMALLEST_PX
            {
                value_px *= SHRINK;
            }
            (wrap(value_px), value_px)
        });
        let anchors = [&scale.low, &scale.high].map(|anchor| {
            if anchor.is_empty() { Vec::new() } else { lettering.wrap(anchor, anchor_px, ANCHOR_SHARE * row_width) }
        });
        let mut layout = Self { line_px, question, values, anchors, pitch, row_width, height: 0.0 };
        layout.height = layout.question_px() + (UNDER_QUESTION + BOX) * line_px + layout.below_boxes_px();
        layout
    }

    fn question_px(&self) -> f64 {
        self.question.len() as f64 * self.line_px * LEADING
    }

    fn values_px(&self) -> f64 {
        self.values.as_ref().map_or(0.0, |(values, value_px)| {
            let lines = values.iter().map(Vec::len).max().unwrap_or(0);
            UNDER_BOXES * self.line_px + lines as f64 * value_px * LEADING
        })
    }

    fn below_boxes_px(&self) -> f64 {
        let lines = self.anchors.iter().map(Vec::len).max().unwrap_or(0);
        let anchors_px = if lines == 0 { 0.0 } else { (UNDER_VALUES + lines as f64 * ANCHOR * LEADING) * self.line_px };
        self.values_px() + anchors_px
    }

    /// Whether all of it stands within so much room.
    fn fits(&self, lettering: &Lettering<'_>, room: [f64; 2]) -> bool {
        let widths = [
            // A value at the end may be wider than its box.
            self.row_width - BOX * self.line_px + self.pitch.max(BOX * self.line_px),
            lettering.widest(&self.question, self.line_px),
            // Words too long for half the row would meet in the middle.
            2.0 * lettering.widest(&self.anchors[0], ANCHOR * self.line_px),
            2.0 * lettering.widest(&self.anchors[1], ANCHOR * self.line_px),
        ];
        self.height <= room[1]
            && widths[..2].iter().all(|width| *width <= room[0])
            && widths[2..].iter().all(|width| *width <= self.row_width.max(1.0))
    }
}

/// Negative numbers with a minus sign in place of a hyphen.
fn with_minus(step: &str) -> String {
    match step.strip_prefix('-') {
        Some(rest) if step.parse::<f64>().is_ok() => format!("\u{2212}{rest}"),
        _ => step.to_owned(),
    }
}

/// The overlay with a scale, as large as the display, with a line in small type at its bottom if there is one.
#[must_use]
pub fn scale(display: &Display, scale: &Scale, hint: Option<&str>) -> RgbaImage {
    let mut picture = blank(display);
    let Some(lettering) = Lettering::load() else {
        return picture;
    };
    let room = room(display, draw_hint(&mut picture, &lettering, display, hint));
    let mut line_px = LINE_DEG / display.pixel_deg([0.0, 0.0]);
    let mut layout = Layout::new(&lettering, scale, line_px, room[0]);
    while !layout.fits(&lettering, room) && line_px > SMALLEST_PX {
        line_px *= SHRINK;
        layout = Layout::new(&lettering, scale, line_px, room[0]);
    }

    // The question, the boxes, their values, the ends.
    let [width, height] = size(display);
    let middle = 0.5 * width;
    let mut top = 0.5 * (height - layout.height);
    lettering.block(&mut picture, &layout.question, line_px, Place::Middle(middle), top, INK);
    top += layout.question_px() + UNDER_QUESTION * line_px;
    let left = middle - 0.5 * layout.row_width;
    let side = BOX * line_px;
    let centre_of = |index: usize| left + index as f64 * layout.pitch + 0.5 * side;
    for index in 0..scale.steps.len() {
        let centre = [centre_of(index), top + 0.5 * side];
        draw_box(&mut picture, centre, side, line_px);
        let digit = (index + 1).to_string();
        lettering.line(&mut picture, &digit, line_px, Place::Middle(centre[0]), centre[1] - 0.5 * line_px, INK);
    }
    top += side;
    if let Some((values, value_px)) = &layout.values {
        for (index, lines) in values.iter().enumerate() {
            let place = Place::Middle(centre_of(index));
            lettering.block(&mut picture, lines, *value_px, place, top + UNDER_BOXES * line_px, INK);
        }
    }
    top += layout.values_px() + UNDER_VALUES * line_px;
    let ends = [Place::Left(left), Place::Right(left + layout.row_width)];
    for (lines, place) in layout.anchors.iter().zip(ends) {
        lettering.block(&mut picture, lines, ANCHOR * line_px, place, top, INK);
    }
    picture
}

/// A rounded square with a border.
fn draw_box(picture: &mut RgbaImage, centre: [f64; 2], side: f64, line_px: f64) {
    let (corner, border) = (CORNER * line_px, (BORDER * line_px).max(1.0));
    let reach = (0.5 * side).ceil() as i64 + 1;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let at = (centre[0] as i64 + dx, centre[1] as i64 + dy);
            let offset = [at.0 as f64 + 0.5 - centre[0], at.1 as f64 + 0.5 - centre[1]];
            // Distance to the border, negative inside.
            let beyond = offset.map(|x| x.abs() - (0.5 * side - corner));
            let distance = beyond[0].max(0.0).hypot(beyond[1].max(0.0)) + beyond[0].max(beyond[1]).min(0.0) - corner;
            let inside = (0.5 - distance).clamp(0.0, 1.0);
            if inside > 0.0 {
                cover(picture, at, BOX_FILL.0, BOX_FILL.1 * inside);
                cover(picture, at, INK, inside * (distance + border + 0.5).clamp(0.0, 1.0));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_numbers_get_a_minus_sign() {
        assert_eq!(with_minus("-3"), "\u{2212}3");
        assert_eq!(with_minus("-ish"), "-ish");
        assert_eq!(with_minus("3"), "3");
    }

    #[test]
    fn there_is_a_box_for_every_step() {
        let display = Display::named("guenter-2012").expect("ships");
        for steps in 2..=9usize {
            let asked = Scale {
                question: String::new(),
                steps: (1..=steps).map(|step| step.to_string()).collect(),
                low: String::new(),
                high: String::new(),
            };
            let picture = scale(&display, &asked, None);
            // Along a line just inside the boxes' upper borders: light runs between pairs of dark borders.
            let top = (0..picture.height()).find(|&y| (0..picture.width()).any(|x| picture.get_pixel(x, y)[3] > 128));
            let y = top.expect("boxes") + 12;
            let filled: Vec<bool> = (0..picture.width()).map(|x| picture.get_pixel(x, y)[3] > 0).collect();
            let runs = filled.windows(2).filter(|pair| !pair[0] && pair[1]).count();
            assert_eq!(runs, steps);
        }
    }
}
