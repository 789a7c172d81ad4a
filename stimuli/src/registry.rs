//! Every scene and renderer by name: one line each. Studies are checked against [`catalogue`], and pictures come from
//! what [`make_scene`] and [`make_renderer`] return.

use crate::contract::{MakeError, Renderer, Scene};
use crate::gpu::Gpu;
use crate::{renderers, scenes};
use experiments::catalogue::{Catalogue, ParameterSchema, Parameters, RendererInfo, SceneInfo, complete_parameters};
use experiments::display::Display;

/// Makes a scene from completed parameters.
type MakeScene = fn(&Gpu, &Display, &Parameters) -> Result<Box<dyn Scene>, MakeError>;
/// Makes a renderer from completed parameters.
type MakeRenderer = fn(&Gpu, &Display, &Parameters) -> Result<Box<dyn Renderer>, MakeError>;

/// A scene or renderer described as data, and how it is made.
type Entry<Info, Make> = (fn() -> Info, Make);

const SCENES: &[Entry<SceneInfo, MakeScene>] = &[
    (scenes::photo::info, scenes::photo::make),
    (scenes::patch::info, scenes::patch::make),
    (scenes::orbit::info, scenes::orbit::make),
    (scenes::noise::info, scenes::noise::make),
    (scenes::campbell_robson::info, scenes::campbell_robson::make),
    (scenes::zone_plate::info, scenes::zone_plate::make),
    (scenes::grid_world::info, scenes::grid_world::make),
    (scenes::atrium::info, scenes::atrium::make),
    (scenes::tunnel::geom::info, scenes::tunnel::geom::make),
    (scenes::tunnel::maps::info, scenes::tunnel::maps::make),
    (scenes::voxel_town::info, scenes::voxel_town::make),
    (scenes::engine_room::info, scenes::engine_room::make),
];

const RENDERERS: &[Entry<RendererInfo, MakeRenderer>] = &[
    (renderers::reference::info, renderers::reference::make),
    (renderers::ring::info, renderers::ring::make),
    (renderers::layers::info, renderers::layers::make),
    (renderers::falloff::info, renderers::falloff::make),
];

/// Everything that a study may name. Needs no GPU.
#[must_use]
pub fn catalogue() -> Catalogue {
    Catalogue {
        scenes: SCENES.iter().map(|(info, _)| info()).collect(),
        renderers: RENDERERS.iter().map(|(info, _)| info()).collect(),
    }
}

/// Makes the scene `id` for `display`; parameters that are not given take their defaults.
///
/// # Errors
/// When the name or a parameter is refused, the display is too large for the device, or the device fails.
pub fn make_scene(
    gpu: &Gpu,
    display: &Display,
    id: &str,
    parameters: &Parameters,
) -> Result<Box<dyn Scene>, MakeError> {
    let found = SCENES.iter().map(|(info, make)| (info(), make)).find(|(info, _)| info.id == id);
    let (info, make) = found.ok_or_else(|| unknown("scene", id, catalogue().scenes.into_iter().map(|s| s.id)))?;
    make(gpu, display, &prepared(gpu, display, &info.parameters, parameters)?)
}

/// Makes the renderer `id` for `display`; parameters that are not given take their defaults.
///
/// # Errors
/// As [`make_scene`].
pub fn make_renderer(
    gpu: &Gpu,
    display: &Display,
    id: &str,
    parameters: &Parameters,
) -> Result<Box<dyn Renderer>, MakeError> {
    let found = RENDERERS.iter().map(|(info, make)| (info(), make)).find(|(info, _)| info.id == id);
    let (info, make) = found.ok_or_else(|| unknown("renderer", id, catalogue().renderers.into_iter().map(|r| r.id)))?;
    make(gpu, display, &prepared(gpu, display, &info.parameters, parameters)?)
}

fn prepared(
    gpu: &Gpu,
    display: &Display,
    schemas: &[ParameterSchema],
    given: &Parameters,
) -> Result<Parameters, MakeError> {
    let [width, height] = display.resolution_px();
    let (found, most) = (width.max(height), gpu.device.limits().max_texture_dimension_2d);
    if found > most {
        return Err(MakeError::TooLarge { found, most, adapter: gpu.adapter_info.name.clone() });
    }
    gpu.check()?;
    Ok(complete_parameters(schemas, given)?)
}

fn unknown(kind: &'static str, id: &str, known: impl Iterator<Item = String>) -> MakeError {
    MakeError::Unknown { kind, id: id.to_owned(), known: known.collect::<Vec<_>>().join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_defaults_are_accepted() {
        let catalogue = catalogue();
        let mut ids: Vec<_> = catalogue.scenes.iter().map(|s| s.id.clone()).collect();
        ids.extend(catalogue.renderers.iter().map(|r| r.id.clone()));
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), SCENES.len() + RENDERERS.len());
        let schemas =
            catalogue.scenes.iter().map(|s| &s.parameters).chain(catalogue.renderers.iter().map(|r| &r.parameters));
        for schema in schemas.flatten() {
            schema.check(&schema.default_value()).expect("a default is within its own bounds");
        }
    }
}
