//! The filters computed another way: a direct two-dimensional sum in f64 over the mirrored reference, out to five standard
//! deviations, with the covariance of the pixel that is shown.

use crate::common::pixel_centre;
use experiments::display::Display;
use stimuli::foveation::low_pass::{Covariance, ring_mask};

/// The ring's settings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RingSettings {
    pub(crate) eccentricity_deg: f64,
    pub(crate) width_deg: f64,
    pub(crate) edge_deg: f64,
    pub(crate) mar_deg: f64,
}

const REACH: f64 = 5.0;

fn mirrored(index: i64, n: i64) -> usize {
    let wrapped = index.rem_euclid(2 * n);
    wrapped.min(2 * n - 1 - wrapped) as usize
}

/// RGB of pixel `index` of the ring's picture.
pub(crate) fn ring_pixel(
    display: &Display,
    reference: &[f32],
    gaze_deg: [f64; 2],
    settings: &RingSettings,
    index: usize,
) -> [f64; 3] {
    let centre = pixel_centre(display, index);
    let sharp: [f64; 3] = std::array::from_fn(|c| f64::from(reference[4 * index + c]));
    let e = display.eccentricity_deg(gaze_deg, display.deg_from_px(centre));
    let mask = ring_mask(e, settings.eccentricity_deg, settings.width_deg, settings.edge_deg);
    if mask <= 0.0 {
        return sharp;
    }
    let filtered = filtered_pixel(display, reference, settings.mar_deg, index);
    std::array::from_fn(|channel| sharp[channel] * (1.0 - mask) + mask * filtered[channel])
}

/// RGB of pixel `index` of the reference without detail finer than `mar_deg`.
pub(crate) fn filtered_pixel(display: &Display, reference: &[f32], mar_deg: f64, index: usize) -> [f64; 3] {
    let c = Covariance::at(display, pixel_centre(display, index), mar_deg);
    let det = c.xx * c.yy - c.xy * c.xy;
    let [width, height] = display.resolution_px().map(i64::from);
    let (column, row) = (index as i64 % width, index as i64 / width);
    let reach = [c.xx, c.yy].map(|variance| (REACH * variance.sqrt()).ceil() as i64);
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for dy in -reach[1]..=reach[1] {
        for dx in -reach[0]..=reach[0] {
            let (x, y) = (dx as f64, dy as f64);
            let weight = (-0.5 * (c.yy * x * x - 2.0 * c.xy * x * y + c.xx * y * y) / det).exp();
            let at = mirrored(row + dy, height) * width as usize + mirrored(column + dx, width);
            for (channel, sum) in sum.iter_mut().enumerate() {
                *sum += weight * f64::from(reference[4 * at + channel]);
            }
            total += weight;
        }
    }
    sum.map(|sum| sum / total)
}
