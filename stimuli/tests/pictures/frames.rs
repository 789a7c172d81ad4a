//! Frames of another engine: the right frame at the right time, the right level at the right place, and folders with faults.

use crate::common::{Setup, display, eccentricities, gpu, looking_at, numbers, write_frames};
use experiments::catalogue::{ParameterValue, Parameters};
use std::path::Path;
use stimuli::{AddError, FrameInput, Registry};

/// A grey that tells level and frame.
fn grey(level: usize, frame: u32) -> u8 {
    40 + 60 * level as u8 + 5 * frame as u8
}

/// IEC 61966-2-1.
fn light(value: u8) -> f64 {
    let c = f64::from(value) / 255.0;
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn registry(folder: &Path, mars_deg: Option<&[f64]>) -> Registry {
    write_frames(folder, [120, 80], 4, mars_deg, 3, |level, frame, _, _| [grey(level, frame); 3]);
    let mut registry = Registry::built_in();
    let added = registry.add_frames("engine", folder).unwrap();
    assert_eq!(added.files.len(), 12);
    registry
}

#[test]
fn frames_follow_the_clock_in_the_middle_of_the_display() {
    let folder = tempfile::tempdir().unwrap();
    let registry = registry(folder.path(), None);
    let display = display([161, 91], [500.0, 281.0], 600.0);
    let none = Parameters::new();
    for renderer in ["reference", "engine"] {
        let mut setup = Setup::of(&registry, &display, ("engine", &none), (renderer, &none));
        setup.renderer.set_parameters(&none).unwrap();
        for (animation_s, frame) in [(0.0, 0), (0.05, 0), (0.1, 1), (0.35, 3), (0.4, 0), (1.25, 0), (0.25, 2)] {
            let (rgba, _) = setup.frame(&FrameInput { animation_s, ..FrameInput::default() });
            let at = |x: usize, y: usize| f64::from(rgba[4 * (y * 161 + x)]);
            // 120 × 80 of 161 × 91: 20 pixels to the left, 5 above.
            assert!((at(80, 45) - light(grey(0, frame))).abs() < 3e-4, "{renderer} at {animation_s} s: {}", at(80, 45));
            assert!(at(20, 5) > 0.0 && at(139, 84) > 0.0);
            assert_eq!([at(19, 45), at(140, 45), at(80, 4), at(80, 85)], [0.0; 4]);
        }
    }
}

/// Pixel by pixel: levels laid over each other from their radii on, with a smoothstep as wide as the edge (closed form).
#[test]
fn levels_are_blended_around_the_gaze() {
    let folder = tempfile::tempdir().unwrap();
    let registry = registry(folder.path(), None);
    let display = display([120, 80], [500.0, 333.0], 600.0);
    let none = Parameters::new();
    let given = numbers([("radius_1_deg", 6.0), ("radius_2_deg", 15.0), ("edge_deg", 4.0)]);
    let mut setup = Setup::of(&registry, &display, ("engine", &none), ("engine", &given));
    for gaze_deg in [[0.0, 0.0], [-14.0, 6.0], [50.0, 0.0]] {
        let (rgba, _) = setup.frame(&looking_at(gaze_deg));
        let mut worst: f64 = 0.0;
        for (index, e) in eccentricities(&display, gaze_deg).into_iter().enumerate() {
            let share = |radius: f64| {
                let t = ((e - radius) / 4.0).clamp(0.0, 1.0);
                t * t * (3.0 - 2.0 * t)
            };
            let mut expected = light(grey(0, 0));
            for (level, radius) in [(1, 6.0), (2, 15.0)] {
                expected += share(radius) * (light(grey(level, 0)) - expected);
            }
            worst = worst.max((f64::from(rgba[4 * index]) - expected).abs());
            if e < 6.0 {
                assert!((f64::from(rgba[4 * index]) - light(grey(0, 0))).abs() < 3e-5, "the reference within");
            }
        }
        println!("gaze {gaze_deg:?}: off by at most {worst:.2e}, allowed 5e-4");
        assert!(worst <= 5e-4);
    }
    // One level alone, wherever the gaze is.
    for (level, name) in ["reference", "level-1", "level-2"].into_iter().enumerate() {
        let show = Parameters::from([("show".to_owned(), ParameterValue::Text(name.to_owned()))]);
        setup.renderer.set_parameters(&show).unwrap();
        let (rgba, _) = setup.frame(&FrameInput { animation_s: 0.21, ..looking_at([3.0, 3.0]) });
        assert!(rgba.chunks_exact(4).all(|p| (f64::from(p[1]) - light(grey(level, 2))).abs() < 5e-4), "{name}");
    }
}

/// omega = m e + omega0 reaches 0.3 and 0.9° per cycle at 7° and 22° for m = 0.04 and omega0 = 0.02.
#[test]
fn an_acuity_line_decides_where_levels_begin() {
    let folder = tempfile::tempdir().unwrap();
    let registry = registry(folder.path(), Some(&[0.1, 0.3, 0.9]));
    let display = display([120, 80], [500.0, 333.0], 400.0);
    let none = Parameters::new();
    let given = numbers([("m", 0.04), ("omega0_deg", 0.02), ("edge_deg", 0.0)]);
    let mut setup = Setup::of(&registry, &display, ("engine", &none), ("engine", &given));
    let (rgba, _) = setup.frame(&looking_at([0.0; 2]));
    let law = registry.catalogue().renderer("engine").unwrap().detail.clone();
    let mut complete = given.clone();
    complete.insert("show".to_owned(), ParameterValue::Text("foveated".to_owned()));
    for (index, e) in eccentricities(&display, [0.0; 2]).into_iter().enumerate() {
        let level = usize::from(e >= 7.0) + usize::from(e >= 22.0);
        if (e - 7.0).abs() > 1e-3 && (e - 22.0).abs() > 1e-3 {
            assert!((f64::from(rgba[4 * index]) - light(grey(level, 0))).abs() < 5e-4, "{e}°");
            assert_eq!(law.mar_deg(&complete, e), Some([0.0, 0.3, 0.9][level]), "the law says what is shown");
        }
    }
    // A flat line below every level shows the reference alone.
    setup.renderer.set_parameters(&numbers([("m", 0.0)])).unwrap();
    let (rgba, _) = setup.frame(&looking_at([0.0; 2]));
    assert!(rgba.chunks_exact(4).all(|p| (f64::from(p[0]) - light(grey(0, 0))).abs() < 5e-4));
}

fn refusal(folder: &Path) -> String {
    match Registry::built_in().add_frames("engine", folder) {
        Err(error) => error.to_string(),
        Ok(added) => panic!("accepted: {added:?}"),
    }
}

#[test]
fn folders_with_faults_are_refused_all_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let _ = registry(folder.path(), None);
    let path = |file: &str| folder.path().join(file);
    std::fs::remove_file(path("reference/001.png")).unwrap();
    std::fs::remove_file(path("level-2/003.png")).unwrap();
    image::RgbImage::new(119, 80).save(path("level-1/000.png")).unwrap();
    std::fs::write(path("level-1/002.png"), b"no picture").unwrap();
    let said = refusal(folder.path());
    println!("{said}");
    assert_eq!(said.lines().count(), 3, "one line for each level");
    for words in [
        "manifest.json:2:",
        "reference.files: expected 4 files, found no reference/001.png",
        "levels[0].files: expected pictures of 120×80 pixels, found level-1/000.png with 119×80, level-1/002.png: expected",
        "levels[1].files: expected 4 files, found no level-2/003.png",
    ] {
        assert!(said.contains(words), "{words} is not in {said}");
    }
    // A manifest that is no manifest, and none at all.
    std::fs::write(path("manifest.json"), "{ \"format\": 1").unwrap();
    assert!(refusal(folder.path()).contains("manifest.json:1:"));
    std::fs::remove_file(path("manifest.json")).unwrap();
    let none = refusal(folder.path());
    assert!(none.contains("manifest.json") && none.contains("expected a manifest"), "{none}");
}

#[cfg(unix)]
#[test]
fn a_link_that_leaves_the_folder_is_refused() {
    let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let _ = registry(folder.path(), None);
    let (inside, outside) = (folder.path().join("level-1/000.png"), elsewhere.path().join("secret.png"));
    std::fs::rename(&inside, &outside).unwrap();
    std::os::unix::fs::symlink(&outside, &inside).unwrap();
    let said = refusal(folder.path());
    assert!(said.contains("expected files within the folder, found level-1/000.png"), "{said}");
}

#[test]
fn frames_larger_than_the_display_are_refused_and_nothing_is_half_added() {
    let folder = tempfile::tempdir().unwrap();
    let mut registry = registry(folder.path(), None);
    let small = display([119, 80], [500.0, 333.0], 600.0);
    let none = Parameters::new();
    let scene = registry.make_scene(gpu(), &small, "engine", &none).err().map(|error| error.to_string());
    let renderer = registry.make_renderer(gpu(), &small, "engine", &none).err().map(|error| error.to_string());
    for said in [scene, renderer].map(Option::unwrap) {
        assert!(said.contains("at most 119×80") && said.contains("found 120×80"), "{said}");
    }
    let catalogue = registry.catalogue();
    assert!(catalogue.mismatch("engine", "engine", Some([119, 80])).is_some());
    assert!(
        catalogue.mismatch("photo", "engine", None).is_some() && catalogue.mismatch("engine", "ring", None).is_none()
    );
    // The scene's name is free and the renderer's is not.
    let before = catalogue.scenes.len();
    let taken = registry.add_frames("ring", folder.path());
    assert!(matches!(taken, Err(AddError::Taken { kind: "renderer", .. })), "{taken:?}");
    assert_eq!(registry.catalogue().scenes.len(), before);
}
