//! Paints an overlay into a picture that goes to a file: smooth lines with a dark edge, so that they are seen on any scene.

use super::overlay::{Line, Overlay};
use crate::stage::screens::lettering::{Lettering, Place};
use image::{Rgba, RgbaImage};

/// Colour of the gaze, its trail and, paler, of the rings.
pub const ACCENT: [u8; 3] = [255, 176, 64];
/// Colour of the rings.
pub const RING: [u8; 3] = [235, 238, 244];
/// Colour of what gives lines an edge.
const EDGE: [u8; 3] = [0, 0, 0];
/// Darkness of the grey between two pictures.
const BETWEEN: Rgba<u8> = Rgba([24, 25, 27, 255]);
/// Pixels between two pictures.
const GUTTER_PX: u32 = 8;

/// A stroke's width and how much it covers.
#[derive(Debug, Clone, Copy)]
struct Stroke {
    width_px: f64,
    colour: [u8; 3],
    opacity: f64,
}

/// Paints an overlay.
pub fn paint(picture: &mut RgbaImage, overlay: &Overlay) {
    // Widths that are as easy to see on a small picture as on a large one.
    let unit_px = (f64::from(picture.height()) / 540.0).clamp(0.5, 4.0);
    let lettering = Lettering::load();
    for ring in &overlay.rings {
        for line in &ring.lines {
            edged(picture, line, 1.2 * unit_px, RING, 0.55);
        }
        if let (Some([x, y]), Some(lettering)) = (ring.label_px, &lettering) {
            let (size_px, text) = (14.0 * unit_px, format!("{}°", ring.eccentricity_deg));
            let place = Place::Left(x + 3.0 * unit_px);
            lettering.line(picture, &text, size_px, place, y - 0.5 * size_px, RING);
        }
    }
    for line in &overlay.trail {
        for (index, pair) in line.windows(2).enumerate() {
            // The trail fades towards where gaze was longest ago.
            let age = 1.0 - index as f64 / line.len() as f64;
            let stroke = Stroke { width_px: 2.0 * unit_px, colour: ACCENT, opacity: 0.9 - 0.75 * age };
            draw(picture, pair, stroke);
        }
    }
    if let Some(gaze_px) = overlay.gaze_px {
        let circle = circle(gaze_px, 9.0 * unit_px);
        edged(picture, &circle, 2.5 * unit_px, ACCENT, if overlay.lost { 0.4 } else { 1.0 });
        let dot = [gaze_px, gaze_px];
        draw(picture, &dot, Stroke { width_px: 3.5 * unit_px, colour: ACCENT, opacity: 1.0 });
    }
}

/// Two pictures side by side, as high as the higher one.
#[must_use]
pub fn side_by_side(left: &RgbaImage, right: &RgbaImage) -> RgbaImage {
    let width = left.width() + GUTTER_PX + right.width();
    let mut both = RgbaImage::from_pixel(width, left.height().max(right.height()), BETWEEN);
    image::imageops::replace(&mut both, left, 0, 0);
    image::imageops::replace(&mut both, right, i64::from(left.width() + GUTTER_PX), 0);
    both
}

/// A picture in the middle of a larger one.
#[must_use]
pub fn centred(picture: &RgbaImage, [width, height]: [u32; 2]) -> RgbaImage {
    let mut larger = RgbaImage::from_pixel(width, height, BETWEEN);
    let margin = |room: u32, size: u32| (i64::from(room) - i64::from(size)) / 2;
    image::imageops::replace(&mut larger, picture, margin(width, picture.width()), margin(height, picture.height()));
    larger
}

fn circle([x, y]: [f64; 2], radius_px: f64) -> Line {
    let place = |step: u32| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(step) / 48.0).sin_cos();
        [x + radius_px * cosine, y + radius_px * sine]
    };
    (0..=48).map(place).collect()
}

/// A line over a wider dark one.
fn edged(picture: &mut RgbaImage, line: &[[f64; 2]], width_px: f64, colour: [u8; 3], opacity: f64) {
    draw(picture, line, Stroke { width_px: 2.0 * width_px, colour: EDGE, opacity: 0.35 * opacity });
    draw(picture, line, Stroke { width_px, colour, opacity });
}

/// Draws a line. Each pixel is covered once, by the part of the line that covers it most, so that joints are no darker.
fn draw(picture: &mut RgbaImage, line: &[[f64; 2]], stroke: Stroke) {
    let reach = 0.5 * stroke.width_px + 1.0;
    let size = [picture.width(), picture.height()].map(f64::from);
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
        line.iter().map(|place| place[axis]).fold(from, pick).clamp(-reach, size[axis] + reach)
    };
    let [left, top] = [0, 1].map(|axis| (bound(axis, f64::min, f64::INFINITY) - reach).floor().max(0.0));
    let [right, bottom] = [0, 1].map(|axis| (bound(axis, f64::max, f64::NEG_INFINITY) + reach).ceil().min(size[axis]));
    if left >= right || top >= bottom {
        return;
    }
    let (columns, rows) = ((right - left) as usize, (bottom - top) as usize);
    let mut coverage = vec![0.0_f32; columns * rows];
    for pair in line.windows(2) {
        cover(
            &mut coverage,
            [columns, rows],
            [[pair[0][0] - left, pair[0][1] - top], [pair[1][0] - left, pair[1][1] - top]],
            stroke.width_px,
        );
    }
    for (index, covered) in coverage.into_iter().enumerate().filter(|(_, covered)| *covered > 0.0) {
        let at = (left as u32 + (index % columns) as u32, top as u32 + (index / columns) as u32);
        let alpha = f64::from(covered) * stroke.opacity;
        let pixel = picture.get_pixel_mut(at.0, at.1);
        for (channel, ink) in stroke.colour.into_iter().enumerate() {
            let below = f64::from(pixel.0[channel]);
            pixel.0[channel] = (below + alpha * (f64::from(ink) - below)).round() as u8;
        }
    }
}

/// Raises `coverage` to how much of each pixel a straight piece covers, by the distance of the pixel's middle from it.
fn cover(coverage: &mut [f32], [columns, rows]: [usize; 2], [from, to]: [[f64; 2]; 2], width_px: f64) {
    let reach = 0.5 * width_px + 1.0;
    let range = |axis: usize, most: usize| {
        let low = (from[axis].min(to[axis]) - reach).floor().clamp(0.0, most as f64) as usize;
        let high = (from[axis].max(to[axis]) + reach).ceil().clamp(0.0, most as f64) as usize;
        low..high
    };
    let along = [to[0] - from[0], to[1] - from[1]];
    let length2 = along[0] * along[0] + along[1] * along[1];
    for row in range(1, rows) {
        for column in range(0, columns) {
            let off = [column as f64 + 0.5 - from[0], row as f64 + 0.5 - from[1]];
            let share =
                if length2 > 0.0 { ((off[0] * along[0] + off[1] * along[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (off[0] - share * along[0]).hypot(off[1] - share * along[1]);
            let covered = (0.5 * width_px + 0.5 - distance).clamp(0.0, 1.0) as f32;
            let slot = &mut coverage[row * columns + column];
            *slot = slot.max(covered);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::overlay::Ring;

    fn grey() -> RgbaImage {
        RgbaImage::from_pixel(96, 54, Rgba([100, 100, 100, 255]))
    }

    /// A horizontal stroke of width 4 between pixel rows covers four rows and no more.
    #[test]
    fn a_stroke_covers_its_width() {
        let mut picture = grey();
        let line = [[10.0, 20.0], [50.0, 20.0], [80.0, 20.0]];
        draw(&mut picture, &line, Stroke { width_px: 4.0, colour: [200, 0, 0], opacity: 1.0 });
        let column: Vec<u8> = (16..24).map(|y| picture.get_pixel(50, y).0[0]).collect();
        assert_eq!(column, [100, 100, 200, 200, 200, 200, 100, 100]);
        assert_eq!(picture.get_pixel(5, 20).0, [100, 100, 100, 255]);
    }

    #[test]
    fn an_overlay_marks_the_gaze_and_lines_may_leave_the_picture() {
        let mut picture = grey();
        let far = Ring {
            eccentricity_deg: 5.0,
            lines: vec![vec![[-500.0, 10.5], [900.0, 10.5]], vec![[1e6, 1e6], [2e6, 2e6]]],
            label_px: Some([94.0, 53.0]),
        };
        let overlay = Overlay {
            gaze_px: Some([48.5, 27.5]),
            lost: false,
            trail: vec![vec![[20.0, 40.0], [48.0, 27.0]]],
            rings: vec![far],
        };
        paint(&mut picture, &overlay);
        assert_eq!(picture.get_pixel(48, 27).0[..3], ACCENT);
        assert!(picture.get_pixel(48, 10).0[0] > 120, "the ring");
        assert_eq!(picture.get_pixel(80, 40).0, [100, 100, 100, 255]);
        let untouched = grey();
        let mut same = grey();
        paint(&mut same, &Overlay::default());
        assert_eq!(same, untouched);
    }

    #[test]
    fn pictures_stand_side_by_side() {
        let both = side_by_side(&grey(), &RgbaImage::from_pixel(10, 60, Rgba([1, 2, 3, 255])));
        assert_eq!(both.dimensions(), (96 + 8 + 10, 60));
        assert_eq!(both.get_pixel(104, 59).0, [1, 2, 3, 255]);
        assert_eq!(both.get_pixel(100, 0), &BETWEEN);
        let larger = centred(&grey(), [100, 60]);
        assert_eq!((larger.get_pixel(0, 0), larger.get_pixel(2, 3).0[0]), (&BETWEEN, 100));
    }
}
