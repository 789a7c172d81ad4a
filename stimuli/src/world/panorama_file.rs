//! Panoramas from files: Radiance HDR and OpenEXR, twice as wide as high, radiance by direction.

use super::Panorama;
use super::gltf::{Findings, WorldError, read_file};
use glam::Vec3;
use std::io::Cursor;
use std::path::Path;

/// Panoramas wider than this are made smaller: reflections and light need no more.
const MOST_WIDTH: u32 = 2048;
const MOST_DECODED_WIDTH: u32 = 16_384;
const MOST_DECODER_BYTES: u64 = 2 << 30;
/// Brighter than any sun that a camera has taken; what exceeds it is cut.
const MOST_RADIANCE: f32 = 1e6;

/// Reads a panorama. Values that are negative or not a number count as black.
///
/// # Errors
/// When the file is no panorama that can be read.
pub(crate) fn read(file: &Path) -> Result<Panorama, WorldError> {
    let panorama = read_file(file).and_then(|bytes| decoded(&bytes));
    panorama.map_err(|message| Findings::new(file).refuse("", message))
}

fn decoded(bytes: &[u8]) -> Result<Panorama, String> {
    let about = |error: image::ImageError| format!("the panorama cannot be read: {error}");
    let mut reader = image::ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| format!("the panorama cannot be read: {error}"))?;
    if !matches!(reader.format(), Some(image::ImageFormat::Hdr | image::ImageFormat::OpenExr)) {
        return Err("the panorama is neither Radiance HDR nor OpenEXR".to_owned());
    }
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MOST_DECODED_WIDTH);
    limits.max_image_height = Some(MOST_DECODED_WIDTH / 2);
    limits.max_alloc = Some(MOST_DECODER_BYTES);
    reader.limits(limits);
    let pixels = reader.decode().map_err(about)?.into_rgb32f();
    let size = [pixels.width(), pixels.height()];
    if size[0] != 2 * size[1] || size[1] == 0 {
        return Err(format!(
            "it has {} × {} pixels; expected a panorama of all directions, twice as wide as high",
            size[0], size[1]
        ));
    }
    let sound = |x: f32| if x.is_finite() { x.clamp(0.0, MOST_RADIANCE) } else { 0.0 };
    let radiance: Vec<Vec3> = pixels.pixels().map(|p| Vec3::from_array(p.0.map(sound))).collect();
    if radiance.iter().all(|c| *c == Vec3::ZERO) {
        return Err("every pixel is black or broken".to_owned());
    }
    let mut panorama = Panorama { size, radiance };
    while panorama.size[0] > MOST_WIDTH {
        let smaller = panorama.pyramid().swap_remove(1);
        panorama = smaller;
    }
    Ok(panorama)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageFormat, Rgb32FImage};

    fn encoded(picture: &Rgb32FImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn gradient(width: u32, height: u32) -> Rgb32FImage {
        Rgb32FImage::from_fn(width, height, |x, y| image::Rgb([x as f32 + 1.0, y as f32 + 1.0, 7.5]))
    }

    /// What is written is read: OpenEXR to the bit, Radiance to its eight bits of the brightest channel.
    #[test]
    fn both_formats_are_read() {
        let picture = gradient(16, 8);
        for (format, error) in [(ImageFormat::OpenExr, 0.0), (ImageFormat::Hdr, 1.0 / 128.0)] {
            let read = decoded(&encoded(&picture, format)).unwrap();
            assert_eq!(read.size, [16, 8]);
            for (found, expected) in read.radiance.iter().zip(picture.pixels()) {
                let expected = Vec3::from_array(expected.0);
                let off = (*found - expected).abs().max_element();
                assert!(off <= error * expected.max_element(), "{format:?}: {found} is not {expected}");
            }
        }
    }

    #[test]
    fn broken_values_are_black_and_large_panoramas_shrink() {
        let mut picture = gradient(16, 8);
        picture.put_pixel(3, 2, image::Rgb([f32::NAN, -4.0, f32::INFINITY]));
        let read = decoded(&encoded(&picture, ImageFormat::OpenExr)).unwrap();
        assert_eq!(read.radiance[2 * 16 + 3], Vec3::ZERO);
        let even = Rgb32FImage::from_pixel(4096, 2048, image::Rgb([0.5, 1.0, 2.0]));
        let read = decoded(&encoded(&even, ImageFormat::OpenExr)).unwrap();
        assert_eq!(read.size, [2048, 1024]);
        assert!(read.radiance.iter().all(|c| c.distance(Vec3::new(0.5, 1.0, 2.0)) < 1e-5));
    }

    #[test]
    fn what_is_no_panorama_is_refused() {
        let said = |bytes: &[u8]| decoded(bytes).unwrap_err();
        assert!(said(&encoded(&gradient(16, 9), ImageFormat::Hdr)).contains("16 × 9"));
        assert!(said(b"what is this?").contains("neither"));
        assert!(said(&[]).contains("neither"));
        let black = Rgb32FImage::new(4, 2);
        assert!(said(&encoded(&black, ImageFormat::OpenExr)).contains("black"));
        assert!(read(Path::new("no such file.exr")).unwrap_err().to_string().starts_with("no such file.exr: "));
    }

    /// Cut anywhere or with any byte changed, a file is read or refused in a sentence.
    #[test]
    fn damaged_panoramas_never_panic() {
        let mut refused = 0;
        for format in [ImageFormat::OpenExr, ImageFormat::Hdr] {
            let whole = encoded(&gradient(16, 8), format);
            for at in 0..whole.len() {
                refused += u32::from(decoded(&whole[..at]).is_err());
                for flip in [0x01, 0x80, 0xff] {
                    let mut damaged = whole.clone();
                    damaged[at] ^= flip;
                    refused += u32::from(decoded(&damaged).is_err());
                }
            }
        }
        println!("{refused} refused");
        assert!(refused > 1000);
    }
}
