//! Scenes and renderers that a study brings along in files.

use schemars::JsonSchema;
use serde::Deserialize;

/// A renderer from a file; the path is relative to the study's own folder. One of the two keys.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RendererFileDraft {
    /// A WGSL file with the parameters it declares and a function that gives every pixel its colour.
    #[schemars(length(min = 1))]
    pub wgsl: Option<String>,
    /// A folder of frames from another engine, with its manifest.json. It is a scene of the same name as well.
    #[schemars(length(min = 1))]
    pub frames: Option<String>,
}

/// A scene from a file; the path is relative to the study's own folder. One of the keys, or gltf with an environment.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFileDraft {
    /// A glTF 2.0 file: .glb or .gltf.
    #[schemars(length(min = 1))]
    pub gltf: Option<String>,
    /// Light from all around, .hdr or .exr: alone a scene of its own, with gltf the light on the model.
    #[schemars(length(min = 1))]
    pub environment: Option<String>,
    /// A picture: PNG, JPEG or EXR.
    #[schemars(length(min = 1))]
    pub picture: Option<String>,
}
