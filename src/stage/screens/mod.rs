//! Screens: pages of text, scales and marks, drawn once on the CPU and laid over a frame by the display pass.
//!
//! Sizes are in degrees, so that text is as large to the eye on every display; it only shrinks where a display is too
//! small to hold it. `lettering` sets type; what moves or is shaded is not drawn here but by the display pass.

pub(crate) mod lettering;
mod mark;
mod scale;

pub use mark::{fixation, letter};
pub use scale::scale;

use experiments::Display;
use image::{Rgba, RgbaImage};
use lettering::{Lettering, Place};

/// Height of a text line in degrees, from ascender to descender: an x-height of about half a degree, ten times the
/// smallest print that normal sight reads.
const LINE_DEG: f64 = 1.05;
/// Height of a line of hints, degrees.
const HINT_DEG: f64 = 0.68;
/// The share of the display's width and height that text may fill.
const FILL: f64 = 0.86;
/// Distance between baselines, in line heights.
const LEADING: f64 = 1.25;
/// Text on mid grey: near black has more than 5:1 contrast there.
const INK: [u8; 3] = [12, 12, 12];
/// No line is set smaller than this, px.
const SMALLEST_PX: f64 = 6.0;
/// How much smaller type is tried next when a page does not fit: a tenth of a degree less at a time is not seen.
const SHRINK: f64 = 0.93;

/// The overlay with a page of text, as large as the display, with a line in small type at its bottom if there is one.
#[must_use]
pub fn text(display: &Display, text: &str, hint: Option<&str>) -> RgbaImage {
    let mut picture = blank(display);
    let Some(lettering) = Lettering::load() else {
        return picture;
    };
    let room = room(display, draw_hint(&mut picture, &lettering, display, hint));
    let mut line_px = LINE_DEG / display.pixel_deg([0.0, 0.0]);
    let mut lines = lettering.wrap(text, line_px, room[0]);
    while (lines.len() as f64 * line_px * LEADING > room[1] || lettering.widest(&lines, line_px) > room[0])
        && line_px > SMALLEST_PX
    {
        line_px *= SHRINK;
        lines = lettering.wrap(text, line_px, room[0]);
    }
    let [width, height] = size(display);
    let top = 0.5 * (height - lines.len() as f64 * line_px * LEADING);
    lettering.block(&mut picture, &lines, line_px, Place::Middle(0.5 * width), top, INK);
    picture
}

/// Draws the hint's line at the bottom and returns how much height it takes, with the space above it.
fn draw_hint(picture: &mut RgbaImage, lettering: &Lettering<'_>, display: &Display, hint: Option<&str>) -> f64 {
    let Some(hint) = hint else {
        return 0.0;
    };
    let [width, height] = size(display);
    let mut line_px = HINT_DEG / display.pixel_deg([0.0, 0.0]);
    while lettering.width(hint, line_px) > FILL * width && line_px > SMALLEST_PX {
        line_px *= SHRINK;
    }
    let top = 0.5 * (1.0 + FILL) * height - line_px;
    lettering.line(picture, hint, line_px, Place::Middle(0.5 * width), top, INK);
    2.0 * line_px
}

/// Width and height that a page may fill, px, when `hint_px` of its height at the bottom are taken: as much is left free
/// at the top, so that the page stands in the middle.
fn room(display: &Display, hint_px: f64) -> [f64; 2] {
    let [width, height] = size(display);
    [FILL * width, FILL * height - 2.0 * hint_px]
}

fn size(display: &Display) -> [f64; 2] {
    display.resolution_px().map(f64::from)
}

fn blank(display: &Display) -> RgbaImage {
    let [width, height] = display.resolution_px();
    RgbaImage::new(width, height)
}

/// Lays a colour over a pixel, as far as it is covered (0–1). Parts of one drawing in one colour do not add up.
fn cover(picture: &mut RgbaImage, at: (i64, i64), colour: [u8; 3], coverage: f64) {
    let (Ok(x), Ok(y)) = (u32::try_from(at.0), u32::try_from(at.1)) else {
        return;
    };
    if x >= picture.width() || y >= picture.height() {
        return;
    }
    let Rgba([red, green, blue, before]) = *picture.get_pixel(x, y);
    let alpha = (coverage.clamp(0.0, 1.0) * 255.0).round() as u8;
    let below = [red, green, blue];
    let pixel = if before == 0 || below == colour {
        [colour[0], colour[1], colour[2], before.max(alpha)]
    } else {
        let (over, under) = (f64::from(alpha) / 255.0, f64::from(before) / 255.0);
        let left = under * (1.0 - over);
        let mixed = |c: usize| {
            ((over * f64::from(colour[c]) + left * f64::from(below[c])) / (over + left).max(1e-9)).round() as u8
        };
        [mixed(0), mixed(1), mixed(2), ((over + left) * 255.0).round() as u8]
    };
    picture.put_pixel(x, y, Rgba(pixel));
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiments::trial::Scale;

    fn inked_rows(picture: &RgbaImage) -> Vec<u32> {
        (0..picture.height()).filter(|&y| (0..picture.width()).any(|x| picture.get_pixel(x, y)[3] > 128)).collect()
    }

    fn assert_margins_are_clear(picture: &RgbaImage) {
        let margin = |extent: u32| (0.04 * f64::from(extent)) as u32;
        let (width, height) = picture.dimensions();
        for (x, y, pixel) in picture.enumerate_pixels() {
            let in_margin =
                x < margin(width) || x >= width - margin(width) || y < margin(height) || y >= height - margin(height);
            assert!(!in_margin || pixel[3] == 0, "ink at {x},{y}");
        }
    }

    #[test]
    fn a_line_is_as_high_in_degrees_as_it_says_on_every_display() {
        for name in ["guenter-2012", "tursun-2019-32in", "demo-540p"] {
            let display = Display::named(name).expect("ships");
            let rows = inked_rows(&text(&display, "Hg", None));
            let height_deg = rows.len() as f64 * display.pixel_deg([0.0, 0.0]);
            assert!(height_deg > 0.6 * LINE_DEG && height_deg < LINE_DEG, "{name}: {height_deg}°");
        }
    }

    #[test]
    fn long_text_stays_on_the_display_and_above_the_hint() {
        let display = Display::named("demo-540p").expect("ships");
        let long = "Look at the mark and keep looking at it. ".repeat(40);
        let plain = text(&display, &long, None);
        assert_margins_are_clear(&plain);
        assert!(inked_rows(&plain).len() > 100);
        let hinted = text(&display, &long, Some("1 or ←: the first     2 or →: the second"));
        assert_margins_are_clear(&hinted);
        let rows = inked_rows(&hinted);
        let widest_gap = rows.windows(2).max_by_key(|pair| pair[1] - pair[0]).expect("rows");
        assert!(widest_gap[1] > 480 && widest_gap[1] - widest_gap[0] > 8, "the hint stands apart: {widest_gap:?}");
    }

    #[test]
    fn scales_of_any_length_stay_on_every_display() {
        for name in ["demo-540p", "tursun-2019-27in"] {
            let display = Display::named(name).expect("ships");
            for steps in 2..=9 {
                let asked = Scale {
                    question: "The sequence looked sharp and natural everywhere. ".repeat(steps),
                    steps: (1..=steps).map(|step| format!("{}", step as i32 - 4)).collect(),
                    low: "strongly disagree with the statement above".to_owned(),
                    high: "strongly agree".to_owned(),
                };
                let picture = scale(&display, &asked, Some("1–7: choose"));
                assert_margins_are_clear(&picture);
                assert!(inked_rows(&picture).len() > 60, "{name}, {steps} steps");
            }
        }
    }

    /// Dumps every kind of screen for people to look at.
    #[test]
    fn screens_are_drawn_for_looking_at() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("target/tmp/screens");
        std::fs::create_dir_all(&folder).expect("writable");
        for name in ["demo-540p", "tursun-2019-27in"] {
            let display = Display::named(name).expect("ships");
            let likert = Scale {
                question: "The picture looked the same as without foveation.".to_owned(),
                steps: (-3..=3).map(|step: i32| step.to_string()).collect(),
                low: "strongly disagree".to_owned(),
                high: "strongly agree".to_owned(),
            };
            let words = Scale {
                question: "How tired are your eyes after this block of trials, compared with when it began?".to_owned(),
                steps: ["not at all", "a little", "somewhat", "rather", "very"].map(str::to_owned).to_vec(),
                low: String::new(),
                high: String::new(),
            };
            let question = "Which of the two was better?\n\nThe first, the second, or were both the same?";
            let better = "1 or ←: the first     2 or →: the second     3 or space: the same";
            let form = "How old are you?\n\n34_\n\nType a whole number from 18 to 99 years, then Enter.";
            let screens = [
                ("likert", scale(&display, &likert, Some("1–7: choose"))),
                ("words", scale(&display, &words, Some("1–5: choose"))),
                ("question", text(&display, question, Some(better))),
                ("form", text(&display, form, Some("Backspace: take back     Enter: done"))),
                ("letter", letter(&display, [0.0, 0.0], 'A')),
                ("mark", fixation(&display, [0.0, 0.0])),
            ];
            for (kind, overlay) in screens {
                let mut page = RgbaImage::from_pixel(overlay.width(), overlay.height(), Rgba([128, 128, 128, 255]));
                if kind == "letter" {
                    // Half dark, half bright, as the worst picture would be.
                    for (x, _, pixel) in page.enumerate_pixels_mut() {
                        *pixel = if x < overlay.width() / 2 { Rgba([10, 10, 10, 255]) } else { Rgba([240; 4]) };
                    }
                }
                image::imageops::overlay(&mut page, &overlay, 0, 0);
                page.save(folder.join(format!("{name}-{kind}.png"))).expect("writable");
                assert!(overlay.pixels().any(|pixel| pixel[3] > 200), "{name} {kind} is empty");
            }
        }
    }
}
