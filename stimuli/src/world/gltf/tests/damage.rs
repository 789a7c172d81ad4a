//! Files that ask for too much, and thousands of damaged ones: none panics, none is half accepted.

use super::*;
use proptest::prelude::*;

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
