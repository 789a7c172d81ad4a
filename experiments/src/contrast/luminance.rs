//! From 8-bit values sent to a display to its light.

use super::Plane;
use crate::display::Transfer;

/// The peak luminance of a display whose own is not known, cd/m²: about that of both displays of Tursun 2019, §5.
pub const DEFAULT_PEAK_CD_M2: f64 = 200.0;

/// Luminance weights of linear red, green and blue (ITU-R BT.709).
const WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The luminance of a picture in cd/m² on a display of this transfer: `rgba` is 8-bit with alpha, four bytes a pixel, row by
/// row.
///
/// Nothing if the bytes are not those of a picture of that size.
#[must_use]
pub fn luminance(size_px: [u32; 2], rgba: &[u8], transfer: &Transfer, peak_cd_m2: f64) -> Option<Plane> {
    let [width, height] = size_px.map(|extent| extent as usize);
    if width == 0 || height == 0 || rgba.len() != width * height * 4 {
        return None;
    }
    let tables: [Vec<f32>; 3] = std::array::from_fn(|channel| {
        let scale = WEIGHTS[channel] * peak_cd_m2;
        let light = |code: u8| transfer.light_from_signal(channel, f64::from(code) / 255.0);
        (0..=255).map(|code| (scale * light(code)) as f32).collect()
    });
    let light = |pixel: &[u8]| (0..3).map(|channel| tables[channel][usize::from(pixel[channel])]).sum();
    Some(Plane { width, height, data: rgba.chunks_exact(4).map(light).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_the_peak_and_middle_codes_are_dark() {
        let plane =
            luminance([2, 1], &[255, 255, 255, 255, 188, 188, 188, 255], &Transfer::Srgb, 214.6).expect("a picture");
        assert!((f64::from(plane.data[0]) - 214.6).abs() < 1e-3);
        // Code 188 is very nearly half the light: IEC 61966-2-1 gives 0.5029.
        assert!((f64::from(plane.data[1]) / 214.6 - 0.502_886).abs() < 1e-5, "{}", plane.data[1]);
        assert_eq!(luminance([2, 2], &[0; 12], &Transfer::Srgb, 200.0), None);
        // On a display of gamma 2 the same code is 0.5435 of the peak.
        let gamma = Transfer::Gamma([2.0; 3]);
        let plane = luminance([1, 1], &[188, 188, 188, 255], &gamma, 100.0).expect("a picture");
        assert!((f64::from(plane.data[0]) - 54.3545).abs() < 1e-3, "{}", plane.data[0]);
    }
}
