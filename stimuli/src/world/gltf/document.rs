//! The JSON of a file as types: the part of glTF 2.0 (Khronos, version 2.0.1) that is shown. Every element is read by
//! itself, so that all that do not fit their type are told at once.

use super::errors::{Findings, WorldError};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Extensions without which a file may say it cannot be shown, and which are shown.
const UNDERSTOOD: [&str; 5] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// A file's elements; an index of one counts into the list of its kind.
#[derive(Debug, Default)]
pub(crate) struct Document {
    pub(crate) scene: Option<usize>,
    pub(crate) extensions_used: Vec<String>,
    pub(crate) buffers: Vec<Buffer>,
    pub(crate) buffer_views: Vec<BufferView>,
    pub(crate) accessors: Vec<Accessor>,
    pub(crate) images: Vec<Image>,
    pub(crate) samplers: Vec<Sampler>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) materials: Vec<Material>,
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) scenes: Vec<Scene>,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) animations: Vec<Animation>,
    pub(crate) lights: Vec<Light>,
}

impl Document {
    /// Reads the JSON text.
    pub(crate) fn parse(json: &[u8], findings: &mut Findings) -> Result<Self, WorldError> {
        // A byte order mark is not allowed, but harmless.
        let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
        let value: Value =
            serde_json::from_slice(json).map_err(|error| findings.refuse("", format!("this is not JSON: {error}")))?;
        let Value::Object(mut root) = value else {
            return Err(findings.refuse("", "the JSON is not an object"));
        };
        let asset: Option<Asset> = single(&mut root, "asset", findings);
        match asset.as_ref().and_then(|asset| asset.version.split('.').next()) {
            Some("2") => {}
            Some(_) => {
                let version = asset.map(|asset| asset.version).unwrap_or_default();
                return Err(findings.refuse("asset.version", format!("this is glTF {version}; glTF 2.0 is read")));
            }
            None => {
                findings.check()?;
                return Err(findings.refuse("asset", "there is no version; glTF 2.0 is read"));
            }
        }
        let required: Vec<String> = single(&mut root, "extensionsRequired", findings).unwrap_or_default();
        for name in required.iter().filter(|name| !UNDERSTOOD.contains(&name.as_str())) {
            let shown: String = name.chars().take(80).collect();
            findings.wrong(
                "extensionsRequired",
                format!("the file cannot be shown without {shown}, which is not supported"),
            );
        }
        let mut extensions = root.remove("extensions").and_then(into_object).unwrap_or_default();
        let mut punctual = extensions.remove("KHR_lights_punctual").and_then(into_object).unwrap_or_default();
        let document = Self {
            scene: single(&mut root, "scene", findings),
            extensions_used: single(&mut root, "extensionsUsed", findings).unwrap_or_default(),
            buffers: list(&mut root, "buffers", findings),
            buffer_views: list(&mut root, "bufferViews", findings),
            accessors: list(&mut root, "accessors", findings),
            images: list(&mut root, "images", findings),
            samplers: list(&mut root, "samplers", findings),
            textures: list(&mut root, "textures", findings),
            materials: list(&mut root, "materials", findings),
            meshes: list(&mut root, "meshes", findings),
            nodes: list(&mut root, "nodes", findings),
            scenes: list(&mut root, "scenes", findings),
            cameras: list(&mut root, "cameras", findings),
            animations: list(&mut root, "animations", findings),
            lights: list(&mut punctual, "lights", findings),
        };
        findings.check()?;
        Ok(document)
    }

    /// Whether the file says that it uses an extension.
    pub(crate) fn uses(&self, extension: &str) -> bool {
        self.extensions_used.iter().any(|name| name == extension)
    }
}

fn into_object(value: Value) -> Option<Map<String, Value>> {
    if let Value::Object(map) = value { Some(map) } else { None }
}

fn single<T: DeserializeOwned>(root: &mut Map<String, Value>, name: &str, findings: &mut Findings) -> Option<T> {
    typed(root.remove(name)?, name, findings)
}

/// The elements of a list; incomplete where some do not fit, which is then among the mistakes.
fn list<T: DeserializeOwned>(root: &mut Map<String, Value>, name: &str, findings: &mut Findings) -> Vec<T> {
    match root.remove(name) {
        None => Vec::new(),
        Some(Value::Array(values)) => {
            let typed =
                values.into_iter().enumerate().map(|(i, value)| typed(value, &format!("{name}[{i}]"), findings));
            typed.collect::<Vec<_>>().into_iter().flatten().collect()
        }
        Some(_) => {
            findings.wrong(name, "expected a list");
            Vec::new()
        }
    }
}

fn typed<T: DeserializeOwned>(value: Value, place: &str, findings: &mut Findings) -> Option<T> {
    match serde_path_to_error::deserialize(value) {
        Ok(typed) => Some(typed),
        Err(error) => {
            let within = error.path().to_string();
            let dot = if within.starts_with('[') { "" } else { "." };
            let place = if within == "." { place.to_owned() } else { format!("{place}{dot}{within}") };
            findings.wrong(place, error.inner().to_string());
            None
        }
    }
}

#[derive(Debug, Deserialize)]
struct Asset {
    version: String,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub(crate) uri: Option<String>,
    pub(crate) byte_length: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct BufferView {
    pub(crate) buffer: usize,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    pub(crate) byte_length: u64,
    pub(crate) byte_stride: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub(crate) buffer_view: Option<usize>,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    pub(crate) component_type: u32,
    #[serde(default)]
    pub(crate) normalized: bool,
    pub(crate) count: u64,
    #[serde(rename = "type")]
    pub(crate) kind: String,
    pub(crate) sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Sparse {
    pub(crate) count: u64,
    pub(crate) indices: SparseIndices,
    pub(crate) values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparseIndices {
    pub(crate) buffer_view: usize,
    #[serde(default)]
    pub(crate) byte_offset: u64,
    pub(crate) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparseValues {
    pub(crate) buffer_view: usize,
    #[serde(default)]
    pub(crate) byte_offset: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Image {
    pub(crate) uri: Option<String>,
    pub(crate) buffer_view: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Sampler {
    pub(crate) wrap_s: Option<u32>,
    pub(crate) wrap_t: Option<u32>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Texture {
    pub(crate) source: Option<usize>,
    pub(crate) sampler: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Material {
    pub(crate) pbr_metallic_roughness: Metallic,
    pub(crate) normal_texture: Option<TextureInfo>,
    pub(crate) occlusion_texture: Option<TextureInfo>,
    pub(crate) emissive_texture: Option<TextureInfo>,
    pub(crate) emissive_factor: [f32; 3],
    pub(crate) alpha_mode: AlphaMode,
    pub(crate) alpha_cutoff: Option<f32>,
    pub(crate) double_sided: bool,
    pub(crate) extensions: MaterialExtensions,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Metallic {
    pub(crate) base_color_factor: [f32; 4],
    pub(crate) base_color_texture: Option<TextureInfo>,
    pub(crate) metallic_factor: f32,
    pub(crate) roughness_factor: f32,
    pub(crate) metallic_roughness_texture: Option<TextureInfo>,
}

impl Default for Metallic {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum AlphaMode {
    #[default]
    Opaque,
    Mask,
    Blend,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_unlit")]
    pub(crate) unlit: Option<Map<String, Value>>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(crate) emissive_strength: Option<EmissiveStrength>,
    /// Extensions that are not understood.
    #[serde(flatten)]
    pub(crate) others: BTreeMap<String, Value>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct EmissiveStrength {
    pub(crate) emissive_strength: f32,
}

impl Default for EmissiveStrength {
    fn default() -> Self {
        Self { emissive_strength: 1.0 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub(crate) index: usize,
    #[serde(default)]
    pub(crate) tex_coord: u32,
    /// Of normal maps only.
    pub(crate) scale: Option<f32>,
    #[serde(default)]
    pub(crate) extensions: TextureExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(crate) transform: Option<TextureTransform>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct TextureTransform {
    pub(crate) offset: [f32; 2],
    /// Radians.
    pub(crate) rotation: f32,
    pub(crate) scale: [f32; 2],
    pub(crate) tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct Mesh {
    pub(crate) primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Primitive {
    pub(crate) attributes: BTreeMap<String, usize>,
    pub(crate) indices: Option<usize>,
    pub(crate) material: Option<usize>,
    pub(crate) mode: Option<u32>,
    pub(crate) targets: Option<Vec<Value>>,
    #[serde(default)]
    pub(crate) extensions: Map<String, Value>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Node {
    #[serde(default)]
    pub(crate) children: Vec<usize>,
    pub(crate) mesh: Option<usize>,
    pub(crate) skin: Option<usize>,
    pub(crate) camera: Option<usize>,
    pub(crate) matrix: Option<[f32; 16]>,
    pub(crate) translation: Option<[f32; 3]>,
    pub(crate) rotation: Option<[f32; 4]>,
    pub(crate) scale: Option<[f32; 3]>,
    #[serde(default)]
    pub(crate) extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(crate) instancing: Option<Value>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct NodeLight {
    pub(crate) light: usize,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Scene {
    #[serde(default)]
    pub(crate) nodes: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Camera {
    #[serde(rename = "type")]
    pub(crate) kind: String,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Animation {
    pub(crate) channels: Vec<Channel>,
    pub(crate) samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Channel {
    pub(crate) sampler: usize,
    pub(crate) target: Target,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Target {
    pub(crate) node: Option<usize>,
    pub(crate) path: String,
}

#[derive(Debug, Deserialize)]
pub(crate) struct AnimationSampler {
    pub(crate) input: usize,
    pub(crate) output: usize,
    #[serde(default)]
    pub(crate) interpolation: Interpolation,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum Interpolation {
    #[default]
    Linear,
    Step,
    CubicSpline,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Light {
    #[serde(rename = "type")]
    pub(crate) kind: String,
    #[serde(default = "white")]
    pub(crate) color: [f32; 3],
    #[serde(default = "one")]
    pub(crate) intensity: f32,
    pub(crate) range: Option<f32>,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f32 {
    1.0
}
