//! A picture of the user's: in mirrored tiles over the whole display like the shipped photographs, or unscaled in its
//! middle.

use super::centred::Centred;
use super::photo::Photograph;
use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity};
use crate::gpu::Gpu;
use crate::parameters::{number, text};
use crate::{pass, pictures};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;
use std::path::Path;

/// What studies see of a picture called `name`.
pub(crate) fn info(name: &str) -> SceneInfo {
    SceneInfo {
        id: name.to_owned(),
        version: 1,
        about: "A picture from a file.".to_owned(),
        parameters: vec![
            ParameterSchema::choice(
                "fit",
                &["tiles", "centre"],
                "Mirrored tiles over the whole display, or once in its middle, unscaled, with black around it.",
            ),
            ParameterSchema::number(
                "scale",
                "px/px",
                0.25..=16.0,
                1.0,
                "Display pixels per pixel of the picture in tiles; at 1 nothing is interpolated.",
            ),
        ],
        animated: false,
    }
}

/// Whether a file is a picture, by its head.
///
/// # Errors
/// What was expected and found.
pub(crate) fn check(file: &Path) -> Result<(), String> {
    pictures::size(file).map(|_| ())
}

pub(crate) fn make(
    gpu: &Gpu,
    display: &Display,
    file: &Path,
    parameters: &Parameters,
) -> Result<Box<dyn Scene>, MakeError> {
    let refused = |reason: String| MakeError::File { file: file.display().to_string(), reason };
    let picture = pictures::read(file, None).map_err(refused)?;
    let most = gpu.device.limits().max_texture_dimension_2d;
    let [width, height] = picture.size;
    if width.max(height) > most {
        let found = width.max(height);
        return Err(refused(format!("expected at most {most} pixels on a side on this device, found {found}")));
    }
    if text(parameters, "fit")? == "tiles" {
        let photograph = Photograph { name: "picture", size: picture.size, linear: picture.rgba };
        return Ok(photograph.in_tiles(gpu, display, number(parameters, "scale")?));
    }
    if number(parameters, "scale")? != 1.0 {
        return Err(refused("expected a scale of 1 in the middle of the display, where nothing is scaled".to_owned()));
    }
    let [across, down] = display.resolution_px();
    if width > across || height > down {
        let message = format!("expected at most the display's {across}×{down} pixels, found {width}×{height}");
        return Err(refused(message));
    }
    Ok(Box::new(Still {
        identity: SceneIdentity::new(),
        centred: Centred::new(gpu, display.resolution_px(), picture.size),
        picture: pass::view(&pass::half_texture(gpu, "picture", picture.size, &picture.rgba)),
    }))
}

struct Still {
    identity: SceneIdentity,
    centred: Centred,
    picture: wgpu::TextureView,
}

impl Scene for Still {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        Ok(self.centred.draw(gpu, encoder, request, &self.picture, target))
    }

    fn picture_changes(&self, _: f64, _: f64) -> bool {
        false
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}
