//! Marks that hold the gaze: the fixation mark, and a letter in its place.

use super::lettering::Lettering;
use super::{INK, blank, cover};
use ab_glyph::{Font, PxScale};
use experiments::Display;
use image::RgbaImage;

/// Outer diameter of the fixation mark in degrees: a disc with a cross cut out and a central dot, the shape that holds
/// fixation steadiest (Thaler et al. 2013, their ABC).
const MARK_OUTER_DEG: f64 = 0.6;
/// Diameter of its central dot, degrees.
const MARK_INNER_DEG: f64 = 0.2;

/// Height of a letter in degrees: as conspicuous as the mark, and easily read at the centre of gaze. Our choice.
const LETTER_DEG: f64 = 0.9;
/// Width of the light rim around it, degrees: without it a dark letter is lost on a dark picture.
const HALO_DEG: f64 = 0.12;
/// The rim's colour.
const HALO: [u8; 3] = [244, 244, 244];

/// The overlay with the fixation mark at `at_deg`, as large as the display.
#[must_use]
pub fn fixation(display: &Display, at_deg: [f64; 2]) -> RgbaImage {
    let mut picture = blank(display);
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
            cover(&mut picture, at, INK, (within(outer, radius) * (1.0 - arms)).max(dot));
        }
    }
    picture
}

/// The overlay with a dark letter in a light rim, its middle at `at_deg`, as large as the display.
#[must_use]
pub fn letter(display: &Display, at_deg: [f64; 2], letter: char) -> RgbaImage {
    let mut picture = blank(display);
    let Some(lettering) = Lettering::load() else {
        return picture;
    };
    let font = lettering.heavy();
    let px_per_deg = 1.0 / display.pixel_deg(at_deg);

    // The face's size at which this letter is as high as it should be.
    let high = |line_px: f32| {
        let outlined = font.outline_glyph(font.glyph_id(letter).with_scale(PxScale::from(line_px)))?;
        Some((outlined.px_bounds(), outlined))
    };
    let Some((bounds, _)) = high(1000.0) else {
        return picture;
    };
    let wanted_px = (LETTER_DEG * px_per_deg).max(9.0);
    let Some((bounds, outlined)) = high((1000.0 * wanted_px / f64::from(bounds.height().max(1.0))) as f32) else {
        return picture;
    };

    let centre = display.px_from_deg(at_deg);
    let corner = [
        (centre[0] - 0.5 * f64::from(bounds.width())).round() as i64,
        (centre[1] - 0.5 * f64::from(bounds.height())).round() as i64,
    ];
    let mut inked = Vec::new();
    outlined.draw(|x, y, coverage| {
        if coverage > 0.0 {
            inked.push(((corner[0] + i64::from(x), corner[1] + i64::from(y)), f64::from(coverage)));
        }
    });
    let halo_px = (HALO_DEG * px_per_deg).max(1.5);
    let reach = halo_px.ceil() as i64;
    for (at, coverage) in &inked {
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let distance = (dx as f64).hypot(dy as f64);
                let within = (halo_px - distance + 0.5).clamp(0.0, 1.0);
                cover(&mut picture, (at.0 + dx, at.1 + dy), HALO, within * coverage);
            }
        }
    }
    for (at, coverage) in inked {
        cover(&mut picture, at, INK, coverage);
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn a_letter_is_dark_in_a_light_rim_and_stands_where_it_should() {
        for name in ["demo-540p", "tursun-2019-27in"] {
            let display = Display::named(name).expect("ships");
            let at_deg = [3.0, 2.0];
            let picture = letter(&display, at_deg, 'B');
            let dark = |pixel: &image::Rgba<u8>| pixel[3] > 200 && pixel[0] < 60;
            let inked: Vec<[f64; 2]> = picture
                .enumerate_pixels()
                .filter(|(.., pixel)| dark(pixel))
                .map(|(x, y, _)| [f64::from(x) + 0.5, f64::from(y) + 0.5])
                .collect();
            let span = |axis: usize| {
                let of = |best: fn(f64, f64) -> f64, start| inked.iter().map(|at| at[axis]).fold(start, best);
                [of(f64::min, f64::INFINITY), of(f64::max, f64::NEG_INFINITY)]
            };
            let middle = [0, 1].map(|axis| 0.5 * (span(axis)[0] + span(axis)[1]));
            let pixel_deg = display.pixel_deg(at_deg);
            let off_deg = display.eccentricity_deg(display.deg_from_px(middle), at_deg);
            assert!(off_deg < 1.5 * pixel_deg, "{name}: {off_deg}° off");
            let height_deg = (span(1)[1] - span(1)[0] + 1.0) * pixel_deg;
            assert!((height_deg - LETTER_DEG).abs() < 0.12, "{name}: {height_deg}° high");
            // Around the letter there is light, all the way.
            let [left, top] = [0, 1].map(|axis| span(axis)[0] as u32);
            assert!(picture.get_pixel(left - 2, (middle[1]) as u32)[0] > 200, "{name}: left");
            assert!(picture.get_pixel(middle[0] as u32, top - 2)[0] > 200, "{name}: above");
        }
    }
}
