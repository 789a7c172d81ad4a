//! Every way in which a file can be wrong, each told at its element.

use super::*;

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
