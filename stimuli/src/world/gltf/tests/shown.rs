//! What a sound file is shown as, number by number.

use super::*;
use crate::world::camera::CameraMotion;
use crate::world::gltf::scene::Choices;
use crate::world::{MeshLevel, Sky, Vertex};
use experiments::catalogue::complete_parameters;
use glam::{DVec3, Quat, Vec2};

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
        m.json["materials"][0]["extensions"] = json!({"KHR_materials_clearcoat": {}});
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
        m.json["materials"][0]["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 10.0}});
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
