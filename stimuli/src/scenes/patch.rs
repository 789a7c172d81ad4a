//! A square patch of a photograph that covers the whole display in mirrored tiles, so that one patch and its contrast can be
//! measured at every eccentricity at once (Tursun et al. 2019, §5 and Fig. 6; their patches were 128 pixels wide).
//!
//! The patch is cut out here; tiles and sampling are those of the scene `photo`.

use super::photo::{Photograph, names};
use crate::contract::{MakeError, Scene};
use crate::gpu::Gpu;
use crate::parameters::{number, text};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;

/// Width of the widest shipped photograph, px.
const WIDEST_PX: f64 = 600.0;

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "patch".to_owned(),
        version: 1,
        about: "A square patch of a photograph in mirrored tiles over the whole display.".to_owned(),
        parameters: vec![
            ParameterSchema::choice("image", &names(), "Which photograph the patch is cut from."),
            ParameterSchema::number(
                "left_px",
                "px",
                0.0..=WIDEST_PX,
                0.0,
                "Left edge of the patch in the photograph; whole pixels, moved left as far as the patch would stick out.",
            ),
            ParameterSchema::number(
                "top_px",
                "px",
                0.0..=WIDEST_PX,
                0.0,
                "Top edge of the patch in the photograph; whole pixels, moved up as far as the patch would stick out.",
            ),
            ParameterSchema::number(
                "size_px",
                "px",
                16.0..=512.0,
                128.0,
                "Side of the patch, pixels of the photograph; whole pixels, at most the photograph's shorter side.",
            ),
            ParameterSchema::number(
                "contrast",
                "",
                0.0..=1.0,
                1.0,
                "Contrast about the patch's mean in linear light, each colour channel about its own; 0 is the mean alone.",
            ),
            ParameterSchema::number(
                "scale",
                "px/px",
                0.25..=16.0,
                1.0,
                "Display pixels per pixel of the patch; at 1 nothing is interpolated.",
            ),
        ],
        animated: false,
    }
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    let photograph = Photograph::decode(text(parameters, "image")?)?;
    let place = [number(parameters, "left_px")?, number(parameters, "top_px")?];
    let mut patch = cut(&photograph, place.map(|x| x.round() as u32), number(parameters, "size_px")?.round() as u32);
    reduce_contrast(&mut patch, number(parameters, "contrast")? as f32);
    Ok(patch.in_tiles(gpu, display, number(parameters, "scale")?))
}

/// The square of side `size_px` whose top left corner is at `place_px`, moved and shrunk as far as needed to lie inside.
fn cut(photograph: &Photograph, place_px: [u32; 2], size_px: u32) -> Photograph {
    let [width, height] = photograph.size;
    let side = size_px.min(width).min(height);
    let [left, top] = [place_px[0].min(width - side), place_px[1].min(height - side)];
    let at = |x: u32, y: u32| (y * width + x) as usize;
    let rows = (top..top + side).flat_map(|y| &photograph.linear[at(left, y)..at(left, y) + side as usize]);
    Photograph { name: photograph.name, size: [side; 2], linear: rows.copied().collect() }
}

/// Draws every pixel towards the mean of its channel.
fn reduce_contrast(patch: &mut Photograph, contrast: f32) {
    // At full contrast the photograph's own values, without a rounding.
    if contrast >= 1.0 {
        return;
    }
    let count = patch.linear.len().max(1) as f64;
    let mean: [f32; 3] =
        std::array::from_fn(|c| (patch.linear.iter().map(|p| f64::from(p[c])).sum::<f64>() / count) as f32);
    for pixel in &mut patch.linear {
        for (value, mean) in pixel.iter_mut().zip(mean) {
            *value = mean + contrast * (*value - mean);
        }
    }
}
