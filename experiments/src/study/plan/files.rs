//! Scenes and renderers that a study brings along in files: their names, and where the files are.

use serde::{Deserialize, Serialize};

/// A scene or renderer in a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedFile {
    /// The name that conditions use.
    pub name: String,
    /// What it is and where.
    #[serde(flatten)]
    pub source: FileSource,
}

/// What a file is. Paths are relative to the study's own folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FileSource {
    /// A renderer in WGSL.
    Wgsl {
        /// The file.
        file: String,
    },
    /// A folder of frames from another engine: a scene and a renderer.
    Frames {
        /// The folder that holds `manifest.json`.
        folder: String,
    },
    /// A scene in glTF 2.0.
    Gltf {
        /// The file.
        file: String,
        /// Light from all around, if the study gives one.
        environment: Option<String>,
    },
    /// A scene of light from all around.
    Environment {
        /// The file.
        file: String,
    },
    /// A scene that is a flat picture.
    Picture {
        /// The file.
        file: String,
    },
}

impl FileSource {
    /// The file or folder that the name stands for.
    #[must_use]
    pub fn path(&self) -> &str {
        match self {
            Self::Wgsl { file } | Self::Gltf { file, .. } | Self::Environment { file } | Self::Picture { file } => file,
            Self::Frames { folder } => folder,
        }
    }

    /// What it is, in words.
    #[must_use]
    pub fn what(&self) -> &'static str {
        match self {
            Self::Wgsl { .. } => "renderer in WGSL",
            Self::Frames { .. } => "scene and renderer of frames",
            Self::Gltf { .. } => "scene in glTF",
            Self::Environment { .. } => "scene of light from all around",
            Self::Picture { .. } => "scene of one picture",
        }
    }

    /// Whether conditions may name it as a renderer.
    #[must_use]
    pub fn is_renderer(&self) -> bool {
        matches!(self, Self::Wgsl { .. } | Self::Frames { .. })
    }

    /// Whether conditions may name it as a scene.
    #[must_use]
    pub fn is_scene(&self) -> bool {
        !matches!(self, Self::Wgsl { .. })
    }
}
