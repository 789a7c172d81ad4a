//! Every scene and renderer by name: those that are built in, one line each, and those that were added from files. Studies
//! are checked against [`Registry::catalogue`], and pictures come from what [`Registry::make_scene`] and
//! [`Registry::make_renderer`] return.
//!
//! `files` adds what users bring along; [`Registry::add_scene`] and [`Registry::add_renderer`] are all that it needs.

mod files;

pub use files::{AddError, FramesAdded};

use crate::contract::{MakeError, Renderer, Scene};
use crate::gpu::Gpu;
use crate::{renderers, scenes};
use experiments::catalogue::{
    CaptureInfo, Catalogue, ParameterSchema, Parameters, RefusedFile, RendererInfo, SceneInfo, complete_parameters,
};
use experiments::display::Display;
use std::sync::Arc;

/// Makes a scene from completed parameters.
pub type MakeScene = Arc<dyn Fn(&Gpu, &Display, &Parameters) -> Result<Box<dyn Scene>, MakeError> + Send + Sync>;
/// Makes a renderer from completed parameters.
pub type MakeRenderer = Arc<dyn Fn(&Gpu, &Display, &Parameters) -> Result<Box<dyn Renderer>, MakeError> + Send + Sync>;

/// A scene or renderer described as data, and how it is made.
type BuiltIn<Info, Made> = (fn() -> Info, fn(&Gpu, &Display, &Parameters) -> Result<Box<Made>, MakeError>);

const SCENES: &[BuiltIn<SceneInfo, dyn Scene>] = &[
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

const RENDERERS: &[BuiltIn<RendererInfo, dyn Renderer>] = &[
    (renderers::reference::info, renderers::reference::make),
    (renderers::ring::info, renderers::ring::make),
    (renderers::layers::info, renderers::layers::make),
    (renderers::falloff::info, renderers::falloff::make),
];

/// Scenes and renderers by name.
#[derive(Clone)]
pub struct Registry {
    scenes: Vec<(SceneInfo, MakeScene)>,
    renderers: Vec<(RendererInfo, MakeRenderer)>,
    captures: Vec<CaptureInfo>,
    refused: Vec<RefusedFile>,
}

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Registry").field("catalogue", &self.catalogue()).finish()
    }
}

impl Default for Registry {
    fn default() -> Self {
        Self::built_in()
    }
}

impl Registry {
    /// What this crate brings along.
    #[must_use]
    pub fn built_in() -> Self {
        Self {
            scenes: SCENES.iter().map(|&(info, make)| (info(), Arc::new(make) as MakeScene)).collect(),
            renderers: RENDERERS.iter().map(|&(info, make)| (info(), Arc::new(make) as MakeRenderer)).collect(),
            captures: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// Everything that a study may name. Needs no GPU.
    #[must_use]
    pub fn catalogue(&self) -> Catalogue {
        Catalogue {
            scenes: self.scenes.iter().map(|(info, _)| info.clone()).collect(),
            renderers: self.renderers.iter().map(|(info, _)| info.clone()).collect(),
            captures: self.captures.clone(),
            refused: self.refused.clone(),
        }
    }

    /// Adds a scene. `make` is given completed parameters, for a display that the device can draw.
    ///
    /// # Errors
    /// [`AddError::Taken`] when there is a scene of this name.
    pub fn add_scene(&mut self, info: SceneInfo, make: MakeScene) -> Result<(), AddError> {
        if self.scenes.iter().any(|(known, _)| known.id == info.id) {
            return Err(AddError::Taken { kind: "scene", name: info.id });
        }
        self.scenes.push((info, make));
        Ok(())
    }

    /// Adds a renderer; as [`Registry::add_scene`].
    ///
    /// # Errors
    /// [`AddError::Taken`] when there is a renderer of this name.
    pub fn add_renderer(&mut self, info: RendererInfo, make: MakeRenderer) -> Result<(), AddError> {
        if self.renderers.iter().any(|(known, _)| known.id == info.id) {
            return Err(AddError::Taken { kind: "renderer", name: info.id });
        }
        self.renderers.push((info, make));
        Ok(())
    }

    /// Notes that a study's file cannot be used, so that the study's check says so where the file is named.
    pub fn refuse(&mut self, file: RefusedFile) {
        self.refused.push(file);
    }

    /// Makes the scene `id` for `display`; parameters that are not given take their defaults.
    ///
    /// # Errors
    /// When the name or a parameter is refused, the display is too large for the device, or the device fails.
    pub fn make_scene(
        &self,
        gpu: &Gpu,
        display: &Display,
        id: &str,
        parameters: &Parameters,
    ) -> Result<Box<dyn Scene>, MakeError> {
        let found = self.scenes.iter().find(|(info, _)| info.id == id);
        let (info, make) = found.ok_or_else(|| unknown("scene", id, self.scenes.iter().map(|(s, _)| s.id.as_str())))?;
        make(gpu, display, &prepared(gpu, display, &info.parameters, parameters)?)
    }

    /// Makes the renderer `id` for `display`; parameters that are not given take their defaults.
    ///
    /// # Errors
    /// As [`Registry::make_scene`].
    pub fn make_renderer(
        &self,
        gpu: &Gpu,
        display: &Display,
        id: &str,
        parameters: &Parameters,
    ) -> Result<Box<dyn Renderer>, MakeError> {
        let found = self.renderers.iter().find(|(info, _)| info.id == id);
        let known = || self.renderers.iter().map(|(renderer, _)| renderer.id.as_str());
        let (info, make) = found.ok_or_else(|| unknown("renderer", id, known()))?;
        make(gpu, display, &prepared(gpu, display, &info.parameters, parameters)?)
    }
}

/// What is built in, as data: [`Registry::catalogue`] of [`Registry::built_in`].
#[must_use]
pub fn catalogue() -> Catalogue {
    Registry::built_in().catalogue()
}

/// Makes a scene that is built in.
///
/// # Errors
/// As [`Registry::make_scene`].
pub fn make_scene(
    gpu: &Gpu,
    display: &Display,
    id: &str,
    parameters: &Parameters,
) -> Result<Box<dyn Scene>, MakeError> {
    Registry::built_in().make_scene(gpu, display, id, parameters)
}

/// Makes a renderer that is built in.
///
/// # Errors
/// As [`Registry::make_scene`].
pub fn make_renderer(
    gpu: &Gpu,
    display: &Display,
    id: &str,
    parameters: &Parameters,
) -> Result<Box<dyn Renderer>, MakeError> {
    Registry::built_in().make_renderer(gpu, display, id, parameters)
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

fn unknown<'a>(kind: &'static str, id: &str, known: impl Iterator<Item = &'a str>) -> MakeError {
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

    #[test]
    fn a_name_is_given_once() {
        let mut registry = Registry::built_in();
        let info = renderers::ring::info();
        let taken = registry.add_renderer(info, Arc::new(renderers::ring::make)).expect_err("ring is built in");
        assert!(taken.to_string().contains("\"ring\""), "{taken}");
        let taken = registry.add_scene(scenes::noise::info(), Arc::new(scenes::noise::make)).expect_err("built in");
        assert_eq!(taken, AddError::Taken { kind: "scene", name: "noise".to_owned() });
    }
}
