//! Files of other programs as scenes: they load, are seen whole, and are refused in one sentence where they are damaged.

use crate::common::{display, gpu, looking_at};
use experiments::catalogue::{ParameterValue, Parameters};
use std::path::{Path, PathBuf};
use stimuli::{GltfFile, make_renderer, readback};

fn model() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models/pmndrs.glb")
}

/// The reference picture of the model under a sky.
fn picture(sky: &str, exposure_ev: f64) -> (Vec<f32>, u64, f64) {
    let file = GltfFile::read(&model()).unwrap();
    let parameters = Parameters::from([
        ("environment".to_owned(), ParameterValue::Text(sky.to_owned())),
        ("exposure_ev".to_owned(), ParameterValue::Number(exposure_ev)),
        ("camera".to_owned(), ParameterValue::Text("static".to_owned())),
    ]);
    let display = display([96, 64], [300.0, 200.0], 500.0);
    let mut scene = file.make(gpu(), &display, &parameters).unwrap();
    let mut renderer = make_renderer(gpu(), &display, "reference", &Parameters::new()).unwrap();
    let cost = renderer.render(gpu(), scene.as_mut(), &looking_at([0.0; 2])).unwrap();
    (readback::linear_rgba(gpu(), renderer.output()).unwrap(), cost.triangles, scene.light().exposure)
}

/// All 1552 triangles are in view, the model is in the middle and the sky in the corners, whatever the sky.
#[test]
fn a_file_of_another_program_is_seen_whole() {
    assert_eq!(GltfFile::read(&model()).unwrap().triangles(), 1552);
    for sky in ["park", "dawn", "venice", "workshop"] {
        let (found, triangles, exposure) = picture(sky, 0.0);
        assert!(found.iter().all(|x| x.is_finite() && *x >= 0.0), "{sky}");
        let brightness = |x: usize, y: usize| found[4 * (96 * y + x)..][..3].iter().sum::<f32>() / 3.0;
        // The boxes' sides are plain: neighbours differ little. At exposure, grey in the light lies well within 0–1.
        let middle = f64::from(brightness(58, 26)) * exposure;
        println!("{sky}: {triangles} triangles, the model's side comes out at {middle:.3}");
        assert_eq!(triangles, 1552);
        assert!((0.02..1.2).contains(&middle), "{sky}: {middle}");
    }
    let (_, _, plain) = picture("park", 0.0);
    let (_, _, brighter) = picture("park", 2.0);
    assert!((brighter / plain - 4.0).abs() < 1e-9);
}

#[test]
fn a_missing_or_cut_file_is_one_sentence() {
    let text = GltfFile::read(Path::new("no such model.glb")).unwrap_err().to_string();
    assert!(text.starts_with("no such model.glb: ") && text.contains("cannot be read"), "{text}");
    let text = GltfFile::read(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err().to_string();
    assert!(text.contains("is not a file"), "{text}");
    let text = GltfFile::read(&model()).unwrap().with_environment(&model()).unwrap_err().to_string();
    assert!(text.contains("neither Radiance HDR nor OpenEXR"), "{text}");
}
