//! A cube made here, byte by byte: what it must load as, every way in which it can be wrong, and thousands of damages.

mod damage;
mod mistakes;
mod shown;

use super::*;
use serde_json::{Value, json};

/// A binary container.
pub(in crate::world::gltf) fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut bytes = b"glTF".to_vec();
    let padded = |length: usize| length.next_multiple_of(4);
    let total = 12 + 8 + padded(json.len()) + if binary.is_empty() { 0 } else { 8 + padded(binary.len()) };
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((total as u32).to_le_bytes());
    for (kind, chunk, filler) in [(0x4E4F_534A_u32, json, b' '), (0x004E_4942, binary, 0)] {
        if !chunk.is_empty() {
            bytes.extend((padded(chunk.len()) as u32).to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            bytes.extend(chunk);
            bytes.resize(bytes.len().next_multiple_of(4), filler);
        }
    }
    bytes
}

/// A file under construction.
#[derive(Clone)]
struct Model {
    json: Value,
    binary: Vec<u8>,
}

impl Model {
    /// Adds bytes as a buffer view and returns its index.
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()}));
        self.binary.extend(bytes);
        self.json["bufferViews"].as_array().unwrap().len() - 1
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(kind, 5126, values.len(), &bytes)
    }

    fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() {
            json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        }
        glb(json.to_string().as_bytes(), &self.binary)
    }

    fn load(&self) -> Result<GltfFile, WorldError> {
        read(self.bytes(), Path::new("cube.glb"))
    }

    /// The message when this change is made to the JSON.
    fn refused(&self, change: impl FnOnce(&mut Self)) -> String {
        let mut changed = self.clone();
        change(&mut changed);
        match changed.load() {
            Ok(_) => panic!("it was accepted: {}", changed.json),
            Err(error) => error.to_string(),
        }
    }

    fn accepted(&self, change: impl FnOnce(&mut Self)) -> GltfFile {
        let mut changed = self.clone();
        change(&mut changed);
        changed.load().unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Two red and two green pixels.
fn picture() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = [[255, 0, 0], [0, 255, 0], [0, 255, 0], [255, 0, 0]].concat();
    image::RgbImage::from_raw(2, 2, pixels).unwrap().write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn read(bytes: Vec<u8>, file: &Path) -> Result<GltfFile, WorldError> {
    GltfFile::of_bytes(bytes, file, accessors::MOST_ITEMS)
}

/// The cube's faces: outward normal, and the directions in which u grows and v falls.
const FACES: [(Vec3, Vec3, Vec3); 6] = [
    (Vec3::Z, Vec3::X, Vec3::Y),
    (Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y),
    (Vec3::X, Vec3::NEG_Z, Vec3::Y),
    (Vec3::NEG_X, Vec3::Z, Vec3::Y),
    (Vec3::Y, Vec3::X, Vec3::NEG_Z),
    (Vec3::NEG_Y, Vec3::X, Vec3::Z),
];

/// A cube of two metres, textured, on a moving node within a turned one; a camera; a lamp.
fn cube() -> Model {
    let mut model = Model {
        json: json!({
            "asset": {"version": "2.0"},
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3.0, "color": [1.0, 0.5, 0.25]}]}},
            "scene": 0,
            "scenes": [{"nodes": [0, 2, 3]}],
            "nodes": [
                {"children": [1], "matrix": [0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 1.0]},
                {"mesh": 0, "translation": [0.0, 1.0, 0.0], "scale": [0.5, 0.5, 0.5]},
                {"camera": 0, "translation": [0.0, 1.5, 6.0]},
                {"rotation": [-0.707_106_77, 0.0, 0.0, 0.707_106_77], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            ],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
            "meshes": [], "bufferViews": [], "accessors": [],
            "textures": [{"source": 0}],
            "materials": [{
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.9, 0.8, 0.7, 1.0], "metallicFactor": 0.25, "roughnessFactor": 0.5,
                    "baseColorTexture": {"index": 0},
                },
                "emissiveFactor": [0.1, 0.2, 0.3],
                "doubleSided": true,
            }],
        }),
        binary: Vec::new(),
    };
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let faces = || FACES.into_iter().flat_map(|face| corners.map(|corner| (face, corner)));
    let positions: Vec<[f32; 3]> = faces().map(|((n, u, v), (x, y))| (n + u * x + v * y).into()).collect();
    let normals: Vec<[f32; 3]> = faces().map(|((n, ..), _)| n.into()).collect();
    let coordinates: Vec<[f32; 2]> = faces().map(|(_, (x, y))| [0.5 + 0.5 * x, 0.5 - 0.5 * y]).collect();
    let indices: Vec<u8> =
        (0..6_u16).flat_map(|f| [0, 1, 2, 0, 2, 3].map(|i| 4 * f + i)).flat_map(u16::to_le_bytes).collect();
    let positions = model.floats("VEC3", &positions);
    let normals = model.floats("VEC3", &normals);
    let coordinates = model.floats("VEC2", &coordinates);
    let indices = model.accessor("SCALAR", 5123, 36, &indices);
    model.json["meshes"] = json!([{"primitives": [{
        "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": coordinates},
        "indices": indices, "material": 0,
    }]}]);
    let picture = model.view(&picture());
    model.json["images"] = json!([{"bufferView": picture, "mimeType": "image/png"}]);
    let times = model.floats("SCALAR", &[[0.5], [1.5], [2.0]]);
    let places = model.floats("VEC3", &[[0.0, 1.0, 0.0], [0.0, 3.0, 0.0], [0.0, 1.0, 0.0]]);
    let turns =
        model.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0], [0.0, 0.707_106_77, 0.0, 0.707_106_77], [0.0, 0.0, 0.0, 1.0]]);
    model.json["animations"] = json!([{
        "channels": [
            {"sampler": 0, "target": {"node": 1, "path": "translation"}},
            {"sampler": 1, "target": {"node": 1, "path": "rotation"}},
        ],
        "samplers": [{"input": times, "output": places}, {"input": times, "output": turns, "interpolation": "STEP"}],
    }]);
    model
}
