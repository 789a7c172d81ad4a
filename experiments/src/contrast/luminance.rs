//! From 8-bit sRGB to light.

use super::Plane;

/// The peak luminance of a display whose own is not known, cd/m²: about that of both displays of Tursun 2019, §5.
pub const DEFAULT_PEAK_CD_M2: f64 = 200.0;

/// Luminance weights of linear red, green and blue (ITU-R BT.709).
const WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The luminance of a picture in cd/m²: `rgba` is 8-bit sRGB with alpha, four bytes a pixel, row by row.
///
/// Nothing if the bytes are not those of a picture of that size.
#[must_use]
pub fn luminance(size_px: [u32; 2], rgba: &[u8], peak_cd_m2: f64) -> Option<Plane> {
    let [width, height] = size_px.map(|extent| extent as usize);
    if width == 0 || height == 0 || rgba.len() != width * height * 4 {
        return None;
    }
    let tables = WEIGHTS.map(|weight| {
        let scale = weight * peak_cd_m2;
        (0..=255).map(|code| (scale * linear_from_srgb(f64::from(code) / 255.0)) as f32).collect::<Vec<f32>>()
    });
    let light = |pixel: &[u8]| (0..3).map(|channel| tables[channel][usize::from(pixel[channel])]).sum();
    Some(Plane { width, height, data: rgba.chunks_exact(4).map(light).collect() })
}

/// The sRGB decoding function (IEC 61966-2-1).
fn linear_from_srgb(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_the_peak_and_middle_codes_are_dark() {
        let plane = luminance([2, 1], &[255, 255, 255, 255, 188, 188, 188, 255], 214.6).expect("a picture");
        assert!((f64::from(plane.data[0]) - 214.6).abs() < 1e-3);
        // Code 188 is very nearly half the light: IEC 61966-2-1 gives 0.5029.
        assert!((f64::from(plane.data[1]) / 214.6 - 0.502_886).abs() < 1e-5, "{}", plane.data[1]);
        assert_eq!(luminance([2, 2], &[0; 12], 200.0), None);
    }
}
