//! Picture files as linear light: PNG and JPEG, which are sRGB unless somebody says otherwise, and EXR, which is linear.

use crate::display_pass::linear_from_srgb8;
use experiments::study::frames::Colour;
use image::{DynamicImage, ImageFormat, ImageReader};
use std::path::Path;

/// The largest half float.
const BRIGHTEST: f32 = 65504.0;
/// The longest side of a picture that is read.
const LONGEST_SIDE: u32 = 16_384;

/// A picture in linear light, RGBA from the top left row by row; opaque.
pub(crate) struct LinearPicture {
    pub(crate) size: [u32; 2],
    pub(crate) rgba: Vec<[f32; 4]>,
}

/// Width and height of a picture, from the file's head alone.
///
/// # Errors
/// What was expected and found, in words.
pub(crate) fn size(file: &Path) -> Result<[u32; 2], String> {
    let (width, height) = reader(file)?.0.into_dimensions().map_err(|error| unreadable(&error))?;
    if width.max(height) > LONGEST_SIDE || width.min(height) == 0 {
        return Err(format!("expected 1 to {LONGEST_SIDE} pixels on each side, found {width}×{height}"));
    }
    Ok([width, height])
}

/// A picture's light. `colour` says what its values are, where that is not what the format means.
///
/// # Errors
/// As [`size`].
pub(crate) fn read(file: &Path, colour: Option<Colour>) -> Result<LinearPicture, String> {
    size(file)?;
    let (reader, format) = reader(file)?;
    let picture = reader.decode().map_err(|error| unreadable(&error))?;
    let own = if format == ImageFormat::OpenExr { Colour::Linear } else { Colour::Srgb };
    let size = [picture.width(), picture.height()];
    let rgba = match (colour.unwrap_or(own), picture) {
        (
            Colour::Srgb,
            picture @ (DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_) | DynamicImage::ImageLuma8(_)),
        ) => {
            let table: [f32; 256] = std::array::from_fn(|value| linear_from_srgb8(value as u8));
            let light = |value: u8| table[usize::from(value)];
            picture.into_rgb8().pixels().map(|p| [light(p[0]), light(p[1]), light(p[2]), 1.0]).collect()
        }
        (colour, picture) => {
            let light = |value: f32| {
                let value = if colour == Colour::Srgb { linear_from_srgb(value) } else { value };
                // What is no number becomes black.
                if value > 0.0 { value.min(BRIGHTEST) } else { 0.0 }
            };
            picture.into_rgb32f().pixels().map(|p| [light(p[0]), light(p[1]), light(p[2]), 1.0]).collect()
        }
    };
    Ok(LinearPicture { size, rgba })
}

type Reader = ImageReader<std::io::BufReader<std::fs::File>>;

/// A decoder by what the file holds, whatever its name says.
fn reader(file: &Path) -> Result<(Reader, ImageFormat), String> {
    let opened =
        ImageReader::open(file).map_err(|error| format!("expected a file that can be read, found: {error}"))?;
    let reader = opened.with_guessed_format().map_err(|error| format!("expected a picture, found: {error}"))?;
    match reader.format() {
        Some(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::OpenExr)) => Ok((reader, format)),
        _ => Err("expected a PNG, JPEG or EXR picture, found something else".to_owned()),
    }
}

fn unreadable(error: &image::ImageError) -> String {
    format!("expected a whole picture, found: {error}")
}

/// IEC 61966-2-1, for values of any precision.
fn linear_from_srgb(value: f32) -> f32 {
    let c = f64::from(value);
    (if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
}
