//! Text pages and the fixation mark, drawn once on the CPU and laid over a frame by the display pass.
//!
//! Sizes are in degrees, so that text is as large to the eye on every display; it only shrinks where a display is too
//! small to hold it.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use experiments::Display;
use image::{Rgba, RgbaImage};

/// Height of a text line in degrees, from ascender to descender: an x-height of about half a degree, ten times the
/// smallest print that normal sight reads.
const LINE_DEG: f64 = 1.05;
/// The share of the display's width and height that text may fill.
const FILL: f64 = 0.86;
/// Text on mid grey: near black has more than 5:1 contrast there.
const INK: [u8; 3] = [12, 12, 12];

/// Outer diameter of the fixation mark in degrees: a disc with a cross cut out and a central dot, the shape that holds
/// fixation steadiest (Thaler et al. 2013, their ABC).
const MARK_OUTER_DEG: f64 = 0.6;
/// Diameter of its central dot, degrees.
const MARK_INNER_DEG: f64 = 0.2;

/// The overlay with a page of text, as large as the display.
#[must_use]
pub fn text(display: &Display, text: &str) -> RgbaImage {
    let [width, height] = display.resolution_px();
    let mut picture = RgbaImage::new(width, height);
    let Ok(font) = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT) else {
        return picture;
    };
    let room = [FILL * f64::from(width), FILL * f64::from(height)];
    let mut line_px = LINE_DEG / display.pixel_deg([0.0, 0.0]);
    let mut lines = wrap(&font, text, line_px, room[0]);
    // Shrink until the page fits; a tenth of a degree less at a time is not seen.
    while (lines.len() as f64 * line_px * LEADING > room[1] || widest(&font, &lines, line_px) > room[0])
        && line_px > 6.0
    {
        line_px *= 0.93;
        lines = wrap(&font, text, line_px, room[0]);
    }
    let scaled = font.as_scaled(PxScale::from(line_px as f32));
    let block_px = lines.len() as f64 * line_px * LEADING;
    for (index, line) in lines.iter().enumerate() {
        let baseline =
            0.5 * (f64::from(height) - block_px) + index as f64 * line_px * LEADING + f64::from(scaled.ascent());
        let left = 0.5 * (f64::from(width) - line_width(&font, line, line_px));
        for glyph in glyphs(&font, line, line_px, left, baseline) {
            if let Some(outlined) = font.outline_glyph(glyph) {
                let bounds = outlined.px_bounds();
                outlined.draw(|x, y, coverage| {
                    let at = (bounds.min.x as i64 + i64::from(x), bounds.min.y as i64 + i64::from(y));
                    cover(&mut picture, at, coverage);
                });
            }
        }
    }
    picture
}

/// Distance between baselines, in line heights.
const LEADING: f64 = 1.25;

/// The overlay with the fixation mark at `at_deg`, as large as the display.
#[must_use]
pub fn fixation(display: &Display, at_deg: [f64; 2]) -> RgbaImage {
    let [width, height] = display.resolution_px();
    let mut picture = RgbaImage::new(width, height);
    let centre = display.px_from_deg(at_deg);
    let px_per_deg = 1.0 / display.pixel_deg(at_deg);
    // At least a few pixels, so that the mark does not vanish on a coarse display.
    let outer = (0.5 * MARK_OUTER_DEG * px_per_deg).max(3.0);
    let inner = (0.5 * MARK_INNER_DEG * px_per_deg).max(1.0);
    let reach = outer.ceil() as i64 + 1;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let at = (centre[0] as i64 + dx, centre[1] as i64 + dy);
            let offset = [at.0 as f64 + 0.5 - centre[0], at.1 as f64 + 0.5 - centre[1]];
            let radius = offset[0].hypot(offset[1]);
            // Coverage falls over one pixel at each edge.
            let within = |edge: f64, value: f64| (edge - value + 0.5).clamp(0.0, 1.0);
            let arms = within(inner, offset[0].abs()).max(within(inner, offset[1].abs()));
            let dot = within(inner, radius);
            cover(&mut picture, at, ((within(outer, radius) * (1.0 - arms)).max(dot)) as f32);
        }
    }
    picture
}

fn cover(picture: &mut RgbaImage, at: (i64, i64), coverage: f32) {
    let (Ok(x), Ok(y)) = (u32::try_from(at.0), u32::try_from(at.1)) else {
        return;
    };
    if x < picture.width() && y < picture.height() {
        let before = picture.get_pixel(x, y)[3];
        let alpha = (coverage.clamp(0.0, 1.0) * 255.0).round() as u8;
        picture.put_pixel(x, y, Rgba([INK[0], INK[1], INK[2], before.max(alpha)]));
    }
}

fn line_width(font: &FontRef<'_>, line: &str, line_px: f64) -> f64 {
    let scaled = font.as_scaled(PxScale::from(line_px as f32));
    let mut width = 0.0;
    let mut before = None;
    for character in line.chars() {
        let id = scaled.glyph_id(character);
        width += scaled.h_advance(id) + before.map_or(0.0, |before| scaled.kern(before, id));
        before = Some(id);
    }
    f64::from(width)
}

fn widest(font: &FontRef<'_>, lines: &[String], line_px: f64) -> f64 {
    lines.iter().map(|line| line_width(font, line, line_px)).fold(0.0, f64::max)
}

fn glyphs(font: &FontRef<'_>, line: &str, line_px: f64, left: f64, baseline: f64) -> Vec<Glyph> {
    let scale = PxScale::from(line_px as f32);
    let scaled = font.as_scaled(scale);
    let mut x = left as f32;
    let mut before = None;
    let mut glyphs = Vec::new();
    for character in line.chars() {
        let id = scaled.glyph_id(character);
        x += before.map_or(0.0, |before| scaled.kern(before, id));
        glyphs.push(id.with_scale_and_position(scale, point(x, baseline as f32)));
        x += scaled.h_advance(id);
        before = Some(id);
    }
    glyphs
}

/// Breaks text into lines no wider than `room_px` where words allow; its own line breaks stay.
fn wrap(font: &FontRef<'_>, text: &str, line_px: f64, room_px: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in text.split('\n') {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if line.is_empty() || line_width(font, &longer, line_px) <= room_px {
                line = longer;
            } else {
                lines.push(std::mem::replace(&mut line, word.to_owned()));
            }
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inked_rows(picture: &RgbaImage) -> Vec<u32> {
        (0..picture.height()).filter(|&y| (0..picture.width()).any(|x| picture.get_pixel(x, y)[3] > 128)).collect()
    }

    #[test]
    fn a_line_is_as_high_in_degrees_as_it_says_on_every_display() {
        for name in ["guenter-2012", "tursun-2019-32in", "demo-540p"] {
            let display = Display::named(name).expect("ships");
            let rows = inked_rows(&text(&display, "Hg"));
            let height_deg = rows.len() as f64 * display.pixel_deg([0.0, 0.0]);
            assert!(height_deg > 0.6 * LINE_DEG && height_deg < LINE_DEG, "{name}: {height_deg}°");
        }
    }

    #[test]
    fn long_text_stays_on_the_display() {
        let display = Display::named("demo-540p").expect("ships");
        let picture = text(&display, &"Look at the mark and keep looking at it. ".repeat(40));
        let [width, height] = display.resolution_px();
        let margin = |extent: u32| (0.04 * f64::from(extent)) as u32;
        for (x, y, pixel) in picture.enumerate_pixels() {
            let in_margin =
                x < margin(width) || x >= width - margin(width) || y < margin(height) || y >= height - margin(height);
            assert!(!in_margin || pixel[3] == 0, "ink at {x},{y}");
        }
        assert!(inked_rows(&picture).len() > 100);
    }

    #[test]
    fn the_mark_stands_where_it_should_and_is_as_large_as_it_says() {
        let display = Display::named("tursun-2019-27in").expect("ships");
        let at_deg = [5.0, -3.0];
        let picture = fixation(&display, at_deg);
        let (mut sum, mut weighted, mut right) = (0.0, [0.0; 2], 0u32);
        for (x, y, pixel) in picture.enumerate_pixels() {
            let alpha = f64::from(pixel[3]);
            sum += alpha;
            weighted[0] += alpha * (f64::from(x) + 0.5);
            weighted[1] += alpha * (f64::from(y) + 0.5);
            if pixel[3] > 128 {
                right = right.max(x);
            }
        }
        let centre = display.deg_from_px([weighted[0] / sum, weighted[1] / sum]);
        assert!(display.eccentricity_deg(centre, at_deg) < 0.02, "{centre:?}");
        let radius = display.eccentricity_deg(at_deg, [display.deg_from_px([f64::from(right), 0.0])[0], at_deg[1]]);
        assert!((radius - 0.5 * MARK_OUTER_DEG).abs() < 0.06, "{radius}");
    }
}
