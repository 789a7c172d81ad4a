//! The heat map: how often shading ran for each display pixel, as a picture with a scale.
//!
//! A pixel that stands for sixteen of the display ran once, at one of them; what it costs is a sixteenth for each. So
//! counts are averaged with a Gaussian of 6 px before they are coloured: wide enough that layers of up to about ten
//! display pixels to one of theirs read evenly, narrow enough to show where layers end.

use super::colours::ColourMap;
use crate::stage::screens::lettering::{Lettering, Place};
use experiments::Display;
use image::{Rgba, RgbaImage};

/// Standard deviation of the averaging, pixels.
const SIGMA_PX: f64 = 6.0;
/// The least that the scale tells apart; what is below an eighth of it counts as nothing.
const LOWEST: f64 = 1.0 / 64.0;
/// The scale reaches at least so far up, so that pictures can be compared.
const HIGHEST: f64 = 4.0;
const PAPER: [u8; 3] = [24, 24, 24];
const INK: [u8; 3] = [235, 235, 235];
const NOTHING: [u8; 3] = [0, 0, 0];

/// What is drawn.
#[derive(Debug)]
pub(super) struct HeatMap<'a> {
    pub(super) display: &'a Display,
    /// Of each display pixel, row by row from the top: runs of shading that fell on it.
    pub(super) runs: &'a [u32],
    pub(super) gaze_deg: [f64; 2],
    /// What was rendered, for the caption.
    pub(super) caption: &'a str,
}

impl HeatMap<'_> {
    /// The picture: the map in the top left corner, pixel for pixel, its scale on the right and a caption below.
    pub(super) fn draw(&self) -> RgbaImage {
        let [width, height] = self.display.resolution_px();
        let density = averaged(self.runs, [width as usize, height as usize]);
        let most = density.iter().copied().fold(0.0, f64::max);
        let scale = Scale { top: highest(most), colours: ColourMap::new() };
        let lettering = Lettering::load();
        let line_px = (f64::from(height) / 30.0).clamp(11.0, 30.0);
        let panel_px = (6.5 * line_px).ceil() as u32;
        let room_px = f64::from(width + panel_px) - line_px;
        let total: u64 = self.runs.iter().map(|&runs| u64::from(runs)).sum();
        let mean = total as f64 / self.display.pixels() as f64;
        let text = format!("shading runs per display pixel, mean {mean:.3}\n{}", self.caption);
        let lines = lettering.as_ref().map_or_else(Vec::new, |lettering| lettering.wrap(&text, line_px, room_px));
        let foot_px = ((lines.len() as f64 * 1.25 + 1.0) * line_px).ceil() as u32;
        let body_px = height.max((8.0 * line_px).ceil() as u32);
        let [r, g, b] = PAPER;
        let mut picture = RgbaImage::from_pixel(width + panel_px, body_px + foot_px, Rgba([r, g, b, 255]));
        for (i, &value) in density.iter().enumerate() {
            let at = [i as u32 % width, i as u32 / width];
            put(&mut picture, at, scale.colour(value));
        }
        self.draw_gaze(&mut picture, line_px);
        let bar = Bar { left: f64::from(width) + 0.8 * line_px, height: f64::from(body_px), line_px };
        bar.draw(&mut picture, &scale, lettering.as_ref());
        if let Some(lettering) = &lettering {
            let top = f64::from(body_px) + 0.5 * line_px;
            lettering.block(&mut picture, &lines, line_px, Place::Left(0.5 * line_px), top, INK);
        }
        picture
    }

    /// A white cross with a black border where the gaze is, if that is on the display.
    fn draw_gaze(&self, picture: &mut RgbaImage, line_px: f64) {
        let size = self.display.resolution_px().map(i64::from);
        let [x, y] = self.display.px_from_deg(self.gaze_deg).map(|x| x.floor() as i64);
        if !(0..size[0]).contains(&x) || !(0..size[1]).contains(&y) {
            return;
        }
        let reach = (0.8 * line_px) as i64;
        for (colour, border) in [(NOTHING, 1), (INK, 0)] {
            for along in -reach - border..=reach + border {
                for across in -border..=border {
                    for [dx, dy] in [[along, across], [across, along]] {
                        let at = [x + dx, y + dy];
                        if (0..2).all(|axis| (0..size[axis]).contains(&at[axis])) {
                            put(picture, at.map(|v| v as u32), colour);
                        }
                    }
                }
            }
        }
    }
}

/// The scale's upper end: [`HIGHEST`], or the power of 4 that holds everything.
fn highest(most: f64) -> f64 {
    let mut top = HIGHEST;
    while top < most && top < 1e9 {
        top *= 4.0;
    }
    top
}

struct Scale {
    top: f64,
    colours: ColourMap,
}

impl Scale {
    fn colour(&self, value: f64) -> [u8; 3] {
        if value < LOWEST / 8.0 { NOTHING } else { self.colours.at(self.share(value)) }
    }

    /// Where a value stands on the scale, 0–1: its logarithm.
    fn share(&self, value: f64) -> f64 {
        (value / LOWEST).ln() / (self.top / LOWEST).ln()
    }

    /// Values that get a number, from the lowest, each four times the one before.
    fn ticks(&self) -> Vec<f64> {
        let ticks = std::iter::successors(Some(LOWEST), |tick| Some(4.0 * tick));
        ticks.take_while(|&tick| tick <= 1.001 * self.top).collect()
    }
}

/// The colour bar, in pixels of the whole picture.
struct Bar {
    left: f64,
    height: f64,
    line_px: f64,
}

impl Bar {
    fn draw(&self, picture: &mut RgbaImage, scale: &Scale, lettering: Option<&Lettering<'_>>) {
        let [top, bottom] = [0.8 * self.line_px, self.height - 2.4 * self.line_px];
        let (left, right) = (self.left as u32, (self.left + 1.2 * self.line_px) as u32);
        let y_of = |share: f64| bottom - (bottom - top) * share;
        for y in top as u32..bottom as u32 {
            let share = (bottom - f64::from(y)) / (bottom - top);
            (left..right).for_each(|x| put(picture, [x, y], scale.colours.at(share)));
        }
        // Nothing has a box of its own below.
        let zero_top = bottom + 0.7 * self.line_px;
        for y in zero_top as u32..(zero_top + self.line_px) as u32 {
            (left..right).for_each(|x| put(picture, [x, y], NOTHING));
        }
        let Some(lettering) = lettering else {
            return;
        };
        let number_left = Place::Left(f64::from(right) + 0.5 * self.line_px);
        for tick in scale.ticks() {
            let y = y_of(scale.share(tick));
            (right..right + (0.3 * self.line_px) as u32).for_each(|x| put(picture, [x, y as u32], INK));
            lettering.line(picture, &label(tick), self.line_px, number_left, y - 0.5 * self.line_px, INK);
        }
        lettering.line(picture, "0", self.line_px, number_left, zero_top, INK);
    }
}

/// A power of four as people write it: 16, 1, 1/16.
fn label(value: f64) -> String {
    if value >= 1.0 { format!("{value:.0}") } else { format!("1/{:.0}", 1.0 / value) }
}

fn put(picture: &mut RgbaImage, [x, y]: [u32; 2], [r, g, b]: [u8; 3]) {
    if x < picture.width() && y < picture.height() {
        picture.put_pixel(x, y, Rgba([r, g, b, 255]));
    }
}

/// Counts averaged around each pixel; near the edges over what is on the display.
fn averaged(runs: &[u32], [width, height]: [usize; 2]) -> Vec<f64> {
    let reach = (3.5 * SIGMA_PX).ceil() as usize;
    let weights: Vec<f64> = (0..=reach).map(|d| (-0.5 * (d as f64 / SIGMA_PX).powi(2)).exp()).collect();
    let along = |values: &[f64], n: usize, stride: usize, start: usize, out: &mut [f64]| {
        for i in 0..n {
            let span = i.saturating_sub(reach)..(i + reach + 1).min(n);
            let (mut sum, mut total) = (0.0, 0.0);
            for j in span {
                let weight = weights[i.abs_diff(j)];
                sum += weight * values[start + j * stride];
                total += weight;
            }
            out[start + i * stride] = sum / total;
        }
    };
    let counts: Vec<f64> = runs.iter().map(|&runs| f64::from(runs)).collect();
    let mut rows = vec![0.0; counts.len()];
    (0..height).for_each(|y| along(&counts, width, 1, y * width, &mut rows));
    let mut both = vec![0.0; counts.len()];
    (0..width).for_each(|x| along(&rows, height, width, x, &mut both));
    both
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One run in sixteen pixels, on a grid, is a sixteenth everywhere away from the edges, and so for steps that are no
    /// whole pixels.
    #[test]
    fn sparse_counts_read_as_their_density() {
        let size = [200_usize, 120];
        for step in [1.0, 2.0, 4.0, 4.7, 8.0] {
            let mut runs = vec![0_u32; size[0] * size[1]];
            let (columns, rows) = ((200.0 / step) as usize, (120.0 / step) as usize);
            for j in 0..rows {
                for i in 0..columns {
                    let [x, y] = [i, j].map(|k| ((k as f64 + 0.5) * step) as usize);
                    runs[y * size[0] + x] += 1;
                }
            }
            let density = averaged(&runs, size);
            let expected = 1.0 / (step * step);
            let worst = (30..90)
                .flat_map(|y| (30..170).map(move |x| y * 200 + x))
                .map(|at| (density[at] / expected - 1.0).abs())
                .fold(0.0, f64::max);
            // A grid that is no whole pixels puts its runs on uneven ones.
            let most = if step == 4.7 { 0.06 } else { 0.03 };
            assert!(worst < most, "step {step}: {worst}");
        }
    }

    #[test]
    fn the_scale_has_its_numbers_and_holds_everything() {
        assert_eq!([0.0, 4.0, 4.1, 70.0].map(highest), [4.0, 4.0, 16.0, 256.0]);
        let scale = Scale { top: 4.0, colours: ColourMap::new() };
        let labels: Vec<String> = scale.ticks().into_iter().map(label).collect();
        assert_eq!(labels, ["1/64", "1/16", "1/4", "1", "4"]);
        assert!((scale.share(0.25) - 0.5).abs() < 1e-12);
        assert_eq!(scale.colour(0.0), NOTHING);
        assert_ne!(scale.colour(LOWEST), NOTHING);
    }
}
