//! The heat map's colours: from a dark violet over green-blue to a light yellow, in even steps of perceived difference.
//!
//! The path runs through OKLab (Ottosson, "A perceptual color space for image processing", 2020): lightness rises evenly
//! while the hue turns, with as much chroma as sRGB has room for, and is then cut into pieces of equal length.

/// Colours of the map.
const STEPS: usize = 256;
/// Points of the path before it is cut.
const POINTS: usize = 4096;
const LIGHTNESS: [f64; 2] = [0.22, 0.95];
const HUE_DEG: [f64; 2] = [300.0, 100.0];
const CHROMA: f64 = 0.13;

/// Colours for 0–1.
#[derive(Debug, Clone)]
pub(super) struct ColourMap(Vec<[u8; 3]>);

impl ColourMap {
    pub(super) fn new() -> Self {
        Self(even_path().into_iter().map(srgb8).collect())
    }

    /// The colour at a share of the map, held within 0–1.
    pub(super) fn at(&self, share: f64) -> [u8; 3] {
        let index = (share.clamp(0.0, 1.0) * (STEPS - 1) as f64).round() as usize;
        self.0[index.min(STEPS - 1)]
    }
}

/// Points in OKLab (lightness, a, b), each as far from the next as all others.
fn even_path() -> Vec<[f64; 3]> {
    let path: Vec<[f64; 3]> = (0..POINTS).map(|i| on_path(i as f64 / (POINTS - 1) as f64)).collect();
    let mut along = vec![0.0];
    for pair in path.windows(2) {
        along.push(along[along.len() - 1] + distance(pair[0], pair[1]));
    }
    let whole = along[along.len() - 1];
    (0..STEPS)
        .map(|step| {
            let wanted = whole * step as f64 / (STEPS - 1) as f64;
            path[along.partition_point(|&length| length < wanted).min(POINTS - 1)]
        })
        .collect()
}

fn on_path(share: f64) -> [f64; 3] {
    let lightness = LIGHTNESS[0] + (LIGHTNESS[1] - LIGHTNESS[0]) * share;
    let (sin, cos) = (HUE_DEG[0] + (HUE_DEG[1] - HUE_DEG[0]) * share).to_radians().sin_cos();
    let colour = |chroma: f64| [lightness, chroma * cos, chroma * sin];
    // The largest chroma that sRGB can show, by halving.
    let (mut low, mut high) = (0.0, CHROMA);
    if is_shown(colour(high)) {
        return colour(high);
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if is_shown(colour(middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    colour(low)
}

fn is_shown(oklab: [f64; 3]) -> bool {
    linear_srgb(oklab).iter().all(|x| (0.0..=1.0).contains(x))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Linear sRGB of an OKLab colour.
fn linear_srgb([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
}

fn srgb8(oklab: [f64; 3]) -> [u8; 3] {
    let transfer = experiments::display::Transfer::Srgb;
    linear_srgb(oklab).map(|light| (255.0 * transfer.signal_from_light(0, light)).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_even_and_lightness_rises() {
        let path = even_path();
        let steps: Vec<f64> = path.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        assert!(steps.iter().all(|step| (step / mean - 1.0).abs() < 0.2), "{steps:?}");
        assert!(path.windows(2).all(|pair| pair[1][0] > pair[0][0]));
        assert!(path.iter().all(|&colour| is_shown(colour)));
        let map = ColourMap::new();
        assert_ne!(map.at(0.0), map.at(1.0));
        assert_eq!(map.at(f64::INFINITY), map.at(1.0));
    }

    /// Ottosson's white: lightness 1 without colour.
    #[test]
    fn white_is_white() {
        assert!(linear_srgb([1.0, 0.0, 0.0]).iter().all(|x| (x - 1.0).abs() < 1e-6));
    }
}
