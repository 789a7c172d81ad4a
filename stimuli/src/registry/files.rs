//! Scenes and renderers from files: WGSL, folders of frames, pictures, glTF models and panoramas.

use super::Registry;
use crate::frames::{self, FrameStore};
use crate::renderers::wgsl::WgslProgram;
use crate::scenes::{environment, picture};
use crate::world::gltf::{GltfFile, Notice, WorldError};
use crate::world::panorama_file;
use experiments::catalogue::CaptureInfo;
use experiments::study::Mistakes;
use std::path::Path;
use std::sync::Arc;

/// Why a file is no scene or renderer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AddError {
    /// The name is in use.
    #[error("expected a name of its own, found \"{name}\", which is the name of another {kind}")]
    Taken {
        /// `scene` or `renderer`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// The text of a file has mistakes.
    #[error(transparent)]
    Mistakes(#[from] Box<Mistakes>),
    /// A model or panorama is not what it should be.
    #[error(transparent)]
    World(#[from] Box<WorldError>),
    /// A file cannot be used.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What was expected and found.
        reason: String,
    },
}

impl From<WorldError> for AddError {
    fn from(error: WorldError) -> Self {
        Self::World(Box::new(error))
    }
}

impl Registry {
    /// Adds a renderer written in WGSL. `file` is its name in messages; what it may say is told beside the
    /// examples in `experiments/studies/own-renderers`. The text is compiled for no device here, but checked as far as that goes.
    ///
    /// # Errors
    /// Every mistake at the file's own line and column, or a name that is in use.
    pub fn add_wgsl(&mut self, name: &str, text: &str, file: &str) -> Result<(), AddError> {
        let program = WgslProgram::compile(name, text, file).map_err(Box::new)?;
        let info = program.info().clone();
        let program = Arc::new(program);
        self.add_renderer(info, Arc::new(move |gpu, display, set| program.make(gpu, display, set)))
    }

    /// Puts another version in the place of a renderer in WGSL. It must have the same parameters, since studies have been
    /// checked against them.
    ///
    /// # Errors
    /// As [`Registry::add_wgsl`]; then nothing was changed.
    pub fn replace_wgsl(&mut self, name: &str, text: &str, file: &str) -> Result<(), AddError> {
        let program = WgslProgram::compile(name, text, file).map_err(Box::new)?;
        let reason = |reason: &str| AddError::File { file: file.to_owned(), reason: reason.to_owned() };
        let Some((info, make)) = self.renderers.iter_mut().find(|(info, _)| info.id == name) else {
            return Err(reason("expected a renderer to put another version in the place of, found none"));
        };
        if info.parameters != program.info().parameters {
            return Err(reason("expected the same parameters as in the version before, found others; start again"));
        }
        *info = program.info().clone();
        *make = Arc::new(move |gpu, display, set| program.make(gpu, display, set));
        Ok(())
    }

    /// Adds a folder of frames that another engine rendered, as a scene and as a renderer of one name. Says which files
    /// it consists of, relative to the folder, and what its manifest says.
    ///
    /// # Errors
    /// Every mistake of `manifest.json`, and every file that is missing or of another size.
    pub fn add_frames(&mut self, name: &str, folder: &Path) -> Result<FramesAdded, AddError> {
        let store = Arc::new(FrameStore::open(folder)?);
        let (scene, renderer) = (frames::scene_info(name, store.frames()), frames::renderer_info(name, store.frames()));
        let added = FramesAdded { manifest: store.manifest().to_owned(), files: store.files() };
        let capture = CaptureInfo { id: name.to_owned(), size_px: store.frames().size_px };
        // Neither without the other.
        let mut with = self.clone();
        let of_scene = Arc::clone(&store);
        with.add_scene(scene, Arc::new(move |gpu, display, _| frames::make_scene(gpu, display, &of_scene)))?;
        let info = renderer.clone();
        with.add_renderer(
            renderer,
            Arc::new(move |gpu, display, set| frames::make_renderer(gpu, display, &store, &info, set)),
        )?;
        with.captures.push(capture);
        *self = with;
        Ok(added)
    }

    /// Adds a PNG, JPEG or EXR picture as a scene.
    ///
    /// # Errors
    /// When the file is no such picture or the name is in use.
    pub fn add_picture(&mut self, name: &str, file: &Path) -> Result<(), AddError> {
        let reason = |reason| AddError::File { file: file.display().to_string(), reason };
        picture::check(file).map_err(reason)?;
        let file = file.to_owned();
        self.add_scene(
            picture::info(name),
            Arc::new(move |gpu, display, parameters| picture::make(gpu, display, &file, parameters)),
        )
    }

    /// Adds a glTF 2.0 model as a scene, lit by the panorama in `environment` if there is one. Says what of the file is
    /// left out.
    ///
    /// # Errors
    /// Everything that is wrong with either file, or a name that is in use.
    pub fn add_gltf(&mut self, name: &str, file: &Path, environment: Option<&Path>) -> Result<Vec<Notice>, AddError> {
        let mut model = GltfFile::read(file)?;
        if let Some(environment) = environment {
            model = model.with_environment(environment)?;
        }
        let notices = model.notices().to_vec();
        let info = model.info(name);
        self.add_scene(info, Arc::new(move |gpu, display, parameters| model.make(gpu, display, parameters)))?;
        Ok(notices)
    }

    /// Adds light from all around, an HDR or EXR panorama, as a scene of its own.
    ///
    /// # Errors
    /// When the file is no panorama or the name is in use.
    pub fn add_environment(&mut self, name: &str, file: &Path) -> Result<(), AddError> {
        let panorama = panorama_file::read(file)?;
        self.add_scene(
            environment::info(name),
            Arc::new(move |gpu, display, parameters| environment::make(gpu, display, &panorama, parameters)),
        )
    }
}

/// What a folder of frames consists of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FramesAdded {
    /// The manifest's text.
    pub manifest: String,
    /// Every frame's file, relative to the folder, level by level.
    pub files: Vec<String>,
}
