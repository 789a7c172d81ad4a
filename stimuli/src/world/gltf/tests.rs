//! A cube made here, byte by byte: what it must load as, every way in which it can be wrong, and thousands of damages.

use super::*;
use crate::world::camera::CameraMotion;
use crate::world::{MeshLevel, Sky, Vertex};
use experiments::catalogue::complete_parameters;
use glam::{DVec3, Quat, Vec2};
use proptest::prelude::*;
use serde_json::{Value, json};

/// A binary container.
pub(super) fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
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

const CHOICES: Choices = Choices {
    camera: Some(0),
    motion: CameraMotion::Fly(1.0),
    animation: Some(0),
    sky: Some(Sky::Park),
    exposure_ev: 1.0,
};

const HALF_VIEW_DEG: f64 = 20.0;

#[test]
fn the_cube_loads_with_its_numbers() {
    let file = cube().load().unwrap();
    assert_eq!((file.triangles(), file.cameras(), file.animations()), (12, 1, 1));
    let notices: Vec<String> = file.notices().iter().map(ToString::to_string).collect();
    assert_eq!(
        notices,
        ["extensions.KHR_lights_punctual: the first directional light takes the place of the sky's sun"]
    );
    let world = file.chosen(&CHOICES, HALF_VIEW_DEG).unwrap();

    // Every triangle faces outwards, every vertex is where the face puts it.
    let level: &MeshLevel = &world.meshes[0].levels[0];
    assert_eq!((level.vertices.len(), level.indices.len()), (24, 36));
    for triangle in level.indices.chunks_exact(3) {
        let corner = |i: usize| level.vertices[triangle[i] as usize];
        let place = |i: usize| Vec3::from(corner(i).position);
        let facing = (place(1) - place(0)).cross(place(2) - place(0)).normalize();
        assert_eq!(facing, Vec3::from(corner(0).normal));
        assert!(facing.dot(place(0)) > 0.99);
    }
    assert_eq!(level.vertices[2].position, [1.0, 1.0, 1.0]);
    assert_eq!(level.vertices[2].uv, [1.0, 0.0]);

    let material = &world.materials[world.objects[0].material];
    assert_eq!(material.albedo, Vec3::new(0.9, 0.8, 0.7));
    assert_eq!((material.roughness, material.metalness), (0.5, 0.25));
    assert_eq!((material.emission, material.two_sided), (Vec3::new(0.1, 0.2, 0.3), true));
    let map = &world.colour_maps[material.albedo_map.unwrap()];
    assert_eq!((map.size, &map.rgba[..8]), ([2, 2], &[255, 0, 0, 255, 0, 255, 0, 255][..]));

    // Within a node that is turned by 90° about y and moved by 10 along x, half as large. At 1.0 s the cube is halfway up
    // to 3 metres, not turned yet; at 1.75 s halfway down again, turned by 90°; at 2.5 s it is where it was at 0.5 s.
    let motion = &world.objects[0].motion;
    assert!(motion.moves());
    let outer = Affine3A::from_rotation_translation(Quat::from_rotation_y(90_f32.to_radians()), Vec3::X * 10.0);
    for (time_s, height, degrees) in
        [(0.0, 1.0, 0.0), (1.0, 2.0, 0.0), (1.75, 2.0, 90.0), (2.5, 1.0, 0.0), (3.0, 2.0, 0.0)]
    {
        let turn = Quat::from_rotation_y(f32::to_radians(degrees));
        let inner = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), turn, Vec3::Y * height);
        let corner = Vec3::new(1.0, -1.0, 1.0);
        let (found, expected) = (motion.at(time_s).transform_point3(corner), (outer * inner).transform_point3(corner));
        assert!(found.distance(expected) < 1e-5, "{time_s} s: {found}, not {expected}");
    }

    let pose = world.camera.pose(0.0);
    assert_eq!((pose.eye, pose.forward, pose.up), (DVec3::new(0.0, 1.5, 6.0), DVec3::NEG_Z, DVec3::Y));
    // One factor of two brighter than white at 1 in the lamp's mean of 1.75/π and the sky's light from above.
    let lamp = 1.75 / std::f64::consts::PI;
    let sky = f64::from(world.environment.on_white(Vec3::Y).element_sum()) / 3.0;
    assert!((world.light.exposure * (lamp + sky) / 2.0 - 1.0).abs() < 1e-5);
    // A light shines along −z of its node, which is turned to look down; 3 lux on white send out 3/π.
    let [crate::world::Light::Directional { towards, colour }] = world.lights[..] else { panic!("{:?}", world.lights) };
    assert!(towards.distance(Vec3::Y) < 1e-6);
    assert!(colour.distance(Vec3::new(1.0, 0.5, 0.25) * 3.0 / std::f32::consts::PI) < 1e-6);
}

#[test]
fn without_an_animation_nodes_are_at_rest_and_without_a_camera_the_view_circles() {
    let file = cube().load().unwrap();
    let world = file.chosen(&Choices { camera: None, animation: None, ..CHOICES }, HALF_VIEW_DEG).unwrap();
    assert!(!world.has_moving_objects() && world.camera.moves());
    let middle = DVec3::new(10.0, 1.0, 0.0);
    let mut distances = Vec::new();
    for i in 0..60 {
        let pose = world.camera.pose(f64::from(i));
        distances.push(pose.eye.distance(middle));
        assert!(pose.forward.angle_between(middle - pose.eye) < 1e-3);
    }
    // The sphere around the cube of one metre, seen as 23° to either side.
    let expected = 0.75_f64.sqrt() / 23_f64.to_radians().sin();
    assert!(distances.iter().all(|d| (d / expected - 1.0).abs() < 0.01), "{distances:?}");
}

#[test]
fn parameters_choose() {
    let file = cube().load().unwrap();
    let info = file.info("cube");
    let world = |given: &[(&str, f64)]| {
        let given =
            given.iter().map(|&(name, value)| (name.to_owned(), experiments::catalogue::ParameterValue::Number(value)));
        let display = experiments::display::Display::new("test", [64, 64], [300.0, 300.0], 600.0).unwrap();
        file.world(&display, &complete_parameters(&info.parameters, &given.collect()).unwrap()).unwrap()
    };
    assert!(world(&[]).camera.carrier.is_some() && world(&[]).has_moving_objects());
    assert!(world(&[("camera_index", -1.0)]).camera.carrier.is_none());
    assert!(!world(&[("animation_index", -1.0)]).has_moving_objects());
    let brighter = world(&[("exposure_ev", 3.0)]).light.exposure / world(&[]).light.exposure;
    assert!((brighter - 8.0).abs() < 1e-12);
    assert!(
        complete_parameters(
            &info.parameters,
            &[("camera_index".to_owned(), experiments::catalogue::ParameterValue::Number(1.0))].into()
        )
        .is_err()
    );
    // Another content, another version.
    assert_eq!(info.version, cube().load().unwrap().info("cube").version);
    let moved = cube().accepted(|m| m.json["nodes"][1]["translation"] = json!([0.0, 1.5, 0.0]));
    assert_ne!(info.version, moved.info("cube").version);
}

/// Each change makes one mistake, which must be told with its element and what was expected.
#[test]
fn each_mistake_is_told_at_its_place() {
    let cube = cube();
    let primitive = "meshes[0].primitives[0]";
    let cases: Vec<(&str, Value, String, &str)> = vec![
        ("/asset/version", json!("1.0"), "asset.version".into(), "glTF 1.0"),
        ("/scene", json!(3), "scene".into(), "there is no scene 3"),
        ("/scene", json!("hello"), "scene".into(), "invalid type: string"),
        ("/scenes/0/nodes", json!([0, 9]), "scenes[0].nodes[1]".into(), "there is no node 9"),
        ("/scenes/0/nodes", json!([0, 1]), "scenes[0].nodes[1]".into(), "child of node 0"),
        ("/nodes/1/children", json!([0]), "nodes[0]".into(), "its own ancestor"),
        ("/nodes/2/children", json!([1]), "nodes[2].children[0]".into(), "child of node 0 already"),
        ("/nodes/1/children", json!([-1]), "nodes[1].children[0]".into(), "invalid value"),
        ("/nodes/1/mesh", json!(4), "nodes[1].mesh".into(), "there is no mesh 4"),
        ("/nodes/2/camera", json!(1), "nodes[2].camera".into(), "there is no camera 1"),
        (
            "/nodes/3/extensions/KHR_lights_punctual/light",
            json!(2),
            "nodes[3].extensions.KHR_lights_punctual.light".into(),
            "no light 2",
        ),
        ("/nodes/0/translation", json!([1.0, 0.0, 0.0]), "nodes[0].matrix".into(), "one or the other"),
        ("/nodes/0/matrix/15", json!(0.5), "nodes[0].matrix".into(), "last row"),
        ("/nodes/3/rotation", json!([0, 0, 0, 0]), "nodes[3].rotation".into(), "length zero"),
        ("/nodes/1/scale/0", json!(1e39), "nodes[1].scale".into(), "it has inf"),
        ("/cameras/0/type", json!("pinhole"), "cameras[0].type".into(), "none of perspective"),
        ("/materials/0/alphaMode", json!("GLASS"), "materials[0].alphaMode".into(), "unknown variant"),
        (
            "/materials/0/pbrMetallicRoughness/metallicFactor",
            json!(2.0),
            "materials[0].pbrMetallicRoughness.metallicFactor".into(),
            "0 to 1",
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
            json!(7),
            "materials[0].pbrMetallicRoughness.baseColorTexture.index".into(),
            "no texture 7",
        ),
        ("/textures/0/source", json!(5), "images[5]".into(), "there is no image 5"),
        ("/images/0/bufferView", json!(50), "images[0]".into(), "no buffer view 50"),
        ("/images/0/bufferView", json!(0), "images[0]".into(), "neither PNG nor JPEG"),
        ("/images/0", json!({"uri": "missing.png"}), "images[0]".into(), "missing.png cannot be read"),
        ("/meshes/0/primitives", json!({}), "meshes[0].primitives".into(), "expected a sequence"),
        ("/meshes/0/primitives/0/mode", json!(9), format!("{primitive}.mode"), "no mode 9"),
        ("/meshes/0/primitives/0/material", json!(1), format!("{primitive}.material"), "no material 1"),
        ("/meshes/0/primitives/0/indices", json!(99), format!("{primitive}.indices"), "no accessor 99"),
        ("/meshes/0/primitives/0/indices", json!(0), format!("{primitive}.indices"), "unsigned whole numbers"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(2),
            format!("{primitive}.attributes.POSITION"),
            "expected VEC3 of floats",
        ),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(5),
            format!("{primitive}.attributes.NORMAL"),
            "POSITION has 24",
        ),
        ("/accessors/0/componentType", json!(5124), "accessors[0].componentType".into(), "5124"),
        ("/accessors/0/componentType", json!(5120), format!("{primitive}.attributes.POSITION"), "VEC3 of I8"),
        ("/accessors/0/type", json!("VEC5"), "accessors[0].type".into(), "VEC5"),
        ("/accessors/0/count", json!(25), "accessors[0]".into(), "leave the buffer view"),
        ("/accessors/0/count", json!(0), "accessors[0].count".into(), "at least 1"),
        ("/accessors/0/count", json!(-3), "accessors[0].count".into(), "invalid value"),
        ("/accessors/0/count", json!(u64::MAX), "accessors[0]".into(), "leave the buffer view"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessors[0]".into(), "leave the buffer view"),
        ("/accessors/0/bufferView", json!(77), "accessors[0].bufferView".into(), "no buffer view 77"),
        (
            "/accessors/0",
            json!({"componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3"}),
            "accessors[0].count".into(),
            "zeros",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 1, "indices": {"bufferView": 3, "componentType": 5126}, "values": {"bufferView": 0}}),
            "accessors[0].sparse.indices.componentType".into(),
            "unsigned",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 30, "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 0}}),
            "accessors[0].sparse.count".into(),
            "it is 30",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 6, "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 0}}),
            "accessors[0].sparse.indices".into(),
            "do not rise",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 2, "indices": {"bufferView": 3, "componentType": 5123, "byteOffset": 71}, "values": {"bufferView": 0}}),
            "accessors[0].sparse.indices".into(),
            "leave the buffer view",
        ),
        ("/bufferViews/0/byteStride", json!(0), "bufferViews[0].byteStride".into(), "it is 0"),
        ("/bufferViews/0/byteStride", json!(-12), "bufferViews[0].byteStride".into(), "invalid value"),
        ("/bufferViews/0/byteStride", json!(8), "accessors[0].bufferView".into(), "only 8 apart"),
        ("/bufferViews/0/byteOffset", json!(100_000), "bufferViews[0]".into(), "leave the buffer"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "bufferViews[0]".into(), "leave the buffer"),
        ("/bufferViews/0/buffer", json!(3), "bufferViews[0]".into(), "no buffer 3"),
        ("/buffers", json!([{"byteLength": 1_000_000}]), "buffers[0].byteLength".into(), "cut off"),
        (
            "/buffers",
            json!([{"byteLength": 4, "uri": "nowhere.bin"}]),
            "buffers[0].uri".into(),
            "nowhere.bin cannot be read",
        ),
        (
            "/buffers",
            json!([{"byteLength": 4, "uri": "https://example.org/a.bin"}]),
            "buffers[0].uri".into(),
            "not followed",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired".into(),
            "KHR_draco_mesh_compression",
        ),
        ("/animations/0/channels/0/sampler", json!(8), "animations[0].channels[0].sampler".into(), "no sampler 8"),
        (
            "/animations/0/channels/0/target/node",
            json!(88),
            "animations[0].channels[0].target.node".into(),
            "no node 88",
        ),
        ("/animations/0/channels/0/target/node", json!(0), "animations[0].channels[0]".into(), "has a matrix"),
        (
            "/animations/0/channels/0/target/path",
            json!("colour"),
            "animations[0].channels[0].target.path".into(),
            "colour",
        ),
        (
            "/animations/0/channels/0/target/path",
            json!("rotation"),
            "animations[0].channels[0].sampler.output".into(),
            "expected VEC4",
        ),
        (
            "/animations/0/channels/1",
            json!({"sampler": 0, "target": {"node": 1, "path": "translation"}}),
            "animations[0].channels[1]".into(),
            "another channel",
        ),
        (
            "/animations/0/samplers/0/interpolation",
            json!("CUBICSPLINE"),
            "animations[0].channels[0].sampler.output".into(),
            "expected 3 for each",
        ),
        (
            "/animations/0/samplers/0/interpolation",
            json!("BEZIER"),
            "animations[0].samplers[0].interpolation".into(),
            "unknown variant",
        ),
        (
            "/animations/0/samplers/0/input",
            json!(1),
            "animations[0].channels[0].sampler.input".into(),
            "expected SCALAR",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/0/intensity",
            json!(-1.0),
            "extensions.KHR_lights_punctual.lights[0]".into(),
            "out of range",
        ),
        (
            "/extensions/KHR_lights_punctual/lights/0/type",
            json!("laser"),
            "extensions.KHR_lights_punctual.lights[0].type".into(),
            "laser",
        ),
        ("/meshes", json!([{"primitives": []}]), String::new(), "nothing to show"),
    ];
    let total = cases.len();
    for (pointer, value, place, said) in cases {
        let text = cube.refused(|m| {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            let parent = if parent.is_empty() { &mut m.json } else { m.json.pointer_mut(parent).unwrap() };
            match (parent.as_array().is_some(), key.parse::<usize>()) {
                (true, Ok(index)) => parent[index] = value.clone(),
                _ => parent[key] = value.clone(),
            }
        });
        let expected = if place.is_empty() { "cube.glb: ".to_owned() } else { format!("cube.glb: {place}: ") };
        assert!(text.starts_with(&expected) && text.contains(said), "{pointer} = {value}: {text}");
    }
    println!("{total} kinds of mistakes, each told at its place");
}

#[test]
fn broken_numbers_in_the_data_are_told() {
    let cube = cube();
    let offset = |m: &Model, view: usize| m.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
    let put = |m: &mut Model, view: usize, at: usize, bytes: &[u8]| {
        let from = offset(m, view) + at;
        m.binary[from..from + bytes.len()].copy_from_slice(bytes);
    };
    for (value, said) in
        [(f32::NAN, "item 2 of accessor 0 is [NaN"), (f32::NEG_INFINITY, "[-inf"), (3e30, "at most 1000000000 metres")]
    {
        let text = cube.refused(|m| put(m, 0, 24, &value.to_le_bytes()));
        assert!(
            text.starts_with("cube.glb: meshes[0].primitives[0].attributes.POSITION: ") && text.contains(said),
            "{text}"
        );
    }
    let text = cube.refused(|m| put(m, 3, 10, &24_u16.to_le_bytes()));
    assert!(text.contains("primitives[0].indices: index 5 of accessor 3 is 24, but there are 24 vertices"), "{text}");
    let text = cube.refused(|m| put(m, 5, 4, &0.25_f32.to_le_bytes()));
    assert!(text.contains("times must rise") && text.contains("animations[0].channels[1].sampler.input"), "{text}");
    let text = cube.refused(|m| put(m, 7, 12, &[0; 4]));
    assert!(text.contains("animations[0].channels[1].sampler.output: item 0 is a quaternion of length zero"), "{text}");
    let text = cube.refused(|m| put(m, 4, 20, &[9; 8]));
    assert!(text.starts_with("cube.glb: images[0]: the picture cannot be read"), "{text}");
}

#[test]
fn all_mistakes_are_told_at_once() {
    let text = cube().refused(|m| {
        m.json["nodes"][1]["mesh"] = json!(4);
        m.json["nodes"][2]["camera"] = json!(5);
        m.json["materials"][0]["emissiveFactor"] = json!([2.0, 0.0, 0.0]);
        m.json["meshes"][0]["primitives"][0]["mode"] = json!(12);
    });
    for place in ["nodes[1].mesh", "nodes[2].camera", "materials[0].emissiveFactor", "meshes[0].primitives[0].mode"] {
        assert!(text.contains(place), "{place} is not in {text}");
    }
    assert!(text.starts_with("cube.glb: 4 mistakes\n"), "{text}");
}

#[test]
fn quantised_and_sparse_vertices_are_read() {
    // A triangle at (±1, 0), (0, 1) in signed bytes, normalised; the third corner is moved by a sparse accessor.
    let quantised = |extension: &str| {
        let mut model = cube();
        model.json["extensionsUsed"] = json!([extension]);
        let positions = model.accessor("VEC3", 5120, 3, &[129, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0, 0]);
        let view = model.json["accessors"][positions]["bufferView"].as_u64().unwrap() as usize;
        model.json["bufferViews"][view]["byteStride"] = json!(4);
        model.json["accessors"][positions]["normalized"] = json!(true);
        let (indices, values) = (model.view(&[2, 0]), model.view(&[0, 0, 127]));
        model.json["accessors"][positions]["sparse"] = json!({"count": 1, "indices": {"bufferView": indices, "componentType": 5123}, "values": {"bufferView": values}});
        model.json["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": positions}});
        model
    };
    let file = quantised("KHR_mesh_quantization").load().unwrap();
    let level = &file.parts.meshes[0].levels[0];
    let places: Vec<[f32; 3]> = level.vertices.iter().map(|v| v.position).collect();
    assert_eq!(places, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    // Counter-clockwise from below; a flat normal.
    assert_eq!(level.vertices[0].normal, [0.0, -1.0, 0.0]);
    let text = quantised("none").load().unwrap_err().to_string();
    assert!(text.contains("accessor 7 has VEC3 of normalised I8; expected VEC3 of floats"), "{text}");
}

#[test]
fn what_is_not_shown_is_noticed() {
    let cube = cube();
    let noticed = |said: &str, change: &dyn Fn(&mut Model)| {
        let file = cube.accepted(change);
        let all: Vec<String> = file.notices().iter().map(ToString::to_string).collect();
        assert!(all.iter().any(|notice| notice.contains(said)), "{said} is not in {all:?}");
        file
    };
    noticed("points and lines", &|m| {
        let primitives = m.json["meshes"][0]["primitives"].as_array_mut().unwrap();
        let mut lines = primitives[0].clone();
        lines["mode"] = json!(1);
        primitives.push(lines);
    });
    noticed("skins do not bend", &|m| m.json["nodes"][1]["skin"] = json!(0));
    noticed("morph targets", &|m| m.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}]));
    noticed("KHR_materials_clearcoat", &|m| {
        m.json["materials"][0]["extensions"] = json!({"KHR_materials_clearcoat": {}})
    });
    noticed("colours of vertices", &|m| m.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(0));
    noticed("times as bright", &|m| m.json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(1e5));
    let file = noticed("half opaque", &|m| {
        m.json["materials"][0]["alphaMode"] = json!("BLEND");
        m.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1.0, 1.0, 1.0, 0.8]);
    });
    // The map's alpha times 0.8 must reach ½.
    assert_eq!(file.parts.materials[0].cutout, Some(0.625));
    let masked = cube.accepted(|m| m.json["materials"][0]["alphaMode"] = json!("MASK"));
    assert_eq!((masked.parts.materials[0].cutout, masked.notices().len()), (Some(0.5), 1));
}

#[test]
fn materials_extensions_are_taken() {
    let cube = cube();
    let bright = cube.accepted(|m| {
        m.json["materials"][0]["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 10.0}})
    });
    assert!(bright.parts.materials[0].emission.distance(Vec3::new(1.0, 2.0, 3.0)) < 1e-6);
    let unlit = cube.accepted(|m| m.json["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}}));
    let material = &unlit.parts.materials[0];
    assert_eq!((material.albedo, material.emission), (Vec3::ZERO, Vec3::new(0.9, 0.8, 0.7)));
    assert_eq!((material.emission_map, material.albedo_map), (Some(0), Some(0)));
    // Whatever the light, the exposure brings it back to its own values.
    let world = unlit.chosen(&Choices { exposure_ev: 0.0, ..CHOICES }, HALF_VIEW_DEG).unwrap();
    let shown = world.materials[0].emission * world.light.exposure as f32;
    assert!(shown.distance(Vec3::new(0.9, 0.8, 0.7)) < 1e-5, "{shown}");
    // Scaled by (2, 3), turned by 90°, moved: (u, v) → (v·3 + ½, ¼ − 2u), with the sense of turning of the extension.
    let turned = cube.accepted(|m| {
        let transform = json!({"offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0]});
        m.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
            json!({"KHR_texture_transform": transform});
    });
    let plain = cube.load().unwrap();
    let vertices = |file: &GltfFile| -> Vec<Vertex> { file.parts.meshes[0].levels[0].vertices.clone() };
    for (found, given) in vertices(&turned).iter().zip(vertices(&plain)) {
        let expected = Vec2::new(3.0 * given.uv[1] + 0.5, 0.25 - 2.0 * given.uv[0]);
        assert!(Vec2::from(found.uv).distance(expected) < 1e-6);
    }
}

/// A mirrored node shows the outside of its mesh: triangles still agree with their normals, places are the same.
#[test]
fn mirrored_nodes_show_their_outside() {
    let file = cube().accepted(|m| m.json["nodes"][1]["scale"] = json!([-0.5, 0.5, 0.5]));
    let world = file.chosen(&Choices { animation: None, ..CHOICES }, HALF_VIEW_DEG).unwrap();
    let object = &world.objects[0];
    let at = object.motion.at(0.0);
    assert!(at.matrix3.determinant() > 0.0);
    let level = &world.meshes[object.mesh].levels[0];
    for triangle in level.indices.chunks_exact(3) {
        let place = |i: usize| at.transform_point3(Vec3::from(level.vertices[triangle[i] as usize].position));
        let facing = (place(1) - place(0)).cross(place(2) - place(0));
        assert!(facing.dot(place(0) - Vec3::new(10.0, 1.0, 0.0)) > 0.0);
    }
}

/// The text form with its data in addresses says the same as the binary form.
#[test]
fn text_and_binary_files_are_the_same() {
    use base64::Engine;
    let model = cube();
    let mut json = model.json.clone();
    let data = base64::engine::general_purpose::STANDARD.encode(&model.binary);
    json["buffers"] =
        json!([{"byteLength": model.binary.len(), "uri": format!("data:application/octet-stream;base64,{data}")}]);
    let text = read(json.to_string().into_bytes(), Path::new("cube.gltf")).unwrap();
    let binary = model.load().unwrap();
    assert_eq!(text.parts.meshes, binary.parts.meshes);
    assert_eq!(text.parts.colour_maps, binary.parts.colour_maps);
}

/// Sharing data cannot make a small file take much memory: a thousand primitives that use the same vertices.
#[test]
fn memory_is_limited() {
    let mut model = cube();
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 3});
    model.json["meshes"][0]["primitives"] = json!(vec![primitive; 1000]);
    assert_eq!(model.load().unwrap().triangles(), 12_000);
    // 24 vertices and 36 indices each, 4 times 3 items of the animation.
    let within = |most| GltfFile::of_bytes(model.bytes(), Path::new("cube.glb"), most);
    assert!(within(60_012).is_ok());
    let text = within(59_000).unwrap_err().to_string();
    assert!(text.contains("more than 59000 items in all; that is too much"), "{text}");
    let text = within(0).unwrap_err().to_string();
    assert!(text.contains("mistakes") && text.len() < 10_000);
}

#[test]
fn deep_nesting_is_refused() {
    let text = cube().refused(|m| {
        let nodes = m.json["nodes"].as_array_mut().unwrap();
        for i in 0..5000 {
            nodes.push(json!({"children": [i + 5]}));
        }
        nodes.push(json!({"mesh": 0}));
        m.json["scenes"][0]["nodes"] = json!([4]);
    });
    assert!(text.contains("nested more than 256 deep"), "{text}");
    // JSON that nests deeper than a stack can hold.
    let deep = format!("{}{}", "[".repeat(200_000), "]".repeat(200_000));
    assert!(read(deep.into_bytes(), Path::new("a.gltf")).unwrap_err().to_string().contains("not JSON"));
}

/// Damages a file's bytes: some flipped, then perhaps cut.
fn damage(bytes: &mut Vec<u8>, flips: &[(usize, u8)], cut: Option<usize>) {
    for &(at, with) in flips {
        let at = at % bytes.len();
        bytes[at] ^= with;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut % bytes.len());
    }
}

/// What was accepted must be whole: finite vertices, indices within, unit normals, finite places.
fn sound(file: &GltfFile) {
    for level in file.parts.meshes.iter().flat_map(|mesh| &mesh.levels) {
        assert!(level.indices.iter().all(|&i| (i as usize) < level.vertices.len()));
        for vertex in &level.vertices {
            let unit = |v: [f32; 3]| (Vec3::from(v).length() - 1.0).abs() < 1e-3;
            let [x, y, z, sign] = vertex.tangent;
            assert!(vertex.position.iter().chain(&vertex.uv).all(|x| x.is_finite()));
            assert!(unit(vertex.normal) && unit([x, y, z]) && sign.abs() == 1.0, "{vertex:?}");
        }
    }
    let motions = file.motions(file.clips.first());
    assert!(motions.iter().all(|motion| motion.at(0.7).is_finite()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes anywhere in the container, JSON and data are changed, and the end is cut.
    #[test]
    fn damaged_files_never_panic(
        flips in proptest::collection::vec((any::<usize>(), 1_u8..), 1..6),
        cut in proptest::option::weighted(0.2, any::<usize>()),
    ) {
        let mut bytes = whole().clone();
        damage(&mut bytes, &flips, cut);
        match read(bytes, Path::new("damaged.glb")) {
            Ok(file) => sound(&file),
            Err(error) => prop_assert!(error.to_string().starts_with("damaged.glb: ")),
        }
    }

    /// One number of the JSON is replaced by another: indices, counts, offsets, codes and factors of all kinds.
    #[test]
    fn wrong_numbers_never_panic(which in any::<usize>(), with in prop_oneof![
        (-3_i64..40).prop_map(|x| json!(x)),
        any::<u64>().prop_map(|x| json!(x)),
        any::<f64>().prop_filter("JSON has no others", |x| x.is_finite()).prop_map(|x| json!(x)),
        prop::sample::select(vec![json!(null), json!("x"), json!([]), json!({}), json!(5120), json!(5121), json!(5125), json!(true)]),
    ]) {
        let mut model = cube();
        let mut leaves = Vec::new();
        numbers(&model.json, &mut String::new(), &mut leaves);
        *model.json.pointer_mut(&leaves[which % leaves.len()]).unwrap() = with;
        match model.load() {
            Ok(file) => sound(&file),
            Err(error) => prop_assert!(!error.mistakes.is_empty()),
        }
    }
}

fn whole() -> &'static Vec<u8> {
    static WHOLE: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
    WHOLE.get_or_init(|| cube().bytes())
}

/// The places of all numbers and texts.
fn numbers(value: &Value, at: &mut String, found: &mut Vec<String>) {
    let mut within = |key: String, value: &Value| {
        let length = at.len();
        at.push('/');
        at.push_str(&key);
        numbers(value, at, found);
        at.truncate(length);
    };
    match value {
        Value::Object(map) => map.iter().for_each(|(key, value)| within(key.clone(), value)),
        Value::Array(values) => values.iter().enumerate().for_each(|(i, value)| within(i.to_string(), value)),
        _ => found.push(at.clone()),
    }
}
