//! The command line as a user meets it: what the commands print, what they refuse and how they say so.
//!
//! Exit codes are 0 (done), 1 (failed) and 2 (bad usage or bad input); whoever is refused finds nothing half-written.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{contents, finish, program, run, small_display, small_study, write_json};
use serde_json::{Value, json};
use std::path::Path;
use tempfile::tempdir;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number, found {value}"))
}

#[track_caller]
fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    let value = number(value);
    assert!((value / expected - 1.0).abs() <= tolerance, "expected {expected}, found {value}");
}

/// A study's text with `from` replaced by `to`, once, and the line on which that is.
fn with_mistake(text: &str, from: &str, to: &str) -> (String, usize) {
    let at = text.find(from).unwrap_or_else(|| panic!("{from} is not in the study"));
    (text.replacen(from, to, 1), text[..at].lines().count().max(1))
}

#[test]
fn the_shipped_studies_check_and_say_how_many_trials_they_have() {
    let folder = tempdir().unwrap();
    for (study, display, practice, main) in
        [("mar-demo", "demo-540p", 4, (120, 240)), ("mar-calibration", "tursun-2019-27in", 12, (160, 400))]
    {
        let text = run(folder.path(), &["check", study]).expect(0).out;
        assert!(text.contains(&format!("{}–{} trials", practice + main.0, practice + main.1)), "{text}");

        let checked = run(folder.path(), &["check", study, "--json"]).expect(0).json();
        assert_eq!(checked["study"], study);
        assert_eq!(checked["display"]["name"], display);
        assert_eq!(checked["total"]["trials_min"], practice + main.0);
        assert_eq!(checked["total"]["trials_max"], practice + main.1);
        assert_eq!(checked["blocks"][0]["trials_max"], practice);
        assert_eq!(checked["blocks"][1]["eccentricities"].as_array().unwrap().len(), 5);
        assert!(number(&checked["total"]["minutes_min"]) > 1.0);
    }
    assert!(contents(folder.path()).is_empty());
}

#[test]
fn a_new_study_checks_and_is_never_overwritten() {
    let folder = tempdir().unwrap();
    for template in ["mar-calibration", "mar-demo"] {
        let name = format!("my-{template}");
        let file = format!("{name}.json");
        let ran = run(folder.path(), &["new", &name, "--from", template]).expect(0);
        assert_eq!(ran.out.trim_end(), file);
        assert_eq!(run(folder.path(), &["check", &file, "--json"]).expect(0).json()["study"], name.as_str());
    }
    let schema: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("study.schema.json")).unwrap()).unwrap();
    assert_eq!(schema["title"], "Parafovea study");

    std::fs::write(folder.path().join("my-mar-demo.json"), "my own words").unwrap();
    std::fs::remove_file(folder.path().join("study.schema.json")).unwrap();
    let before = contents(folder.path());
    let refused = run(folder.path(), &["new", "my-mar-demo"]).expect(2);
    assert!(refused.err.contains("my-mar-demo.json exists already"), "{}", refused.err);
    assert!(contents(folder.path()) == before);
}

/// Guenter et al. 2012: the free optimum and the one with a second layer of half resolution, for both slopes.
#[test]
fn predictions_for_guenters_display_are_those_of_the_paper() {
    let folder = tempdir().unwrap();
    let predict = |arguments: &[&str]| {
        let mut all = vec!["predict", "--display", "guenter-2012", "--json"];
        all.extend(arguments);
        run(folder.path(), &all).expect(0).json()
    };
    for (m, half_rate, unweighted, restricted, radii, factors) in [
        ("0.0275", 13.29, 8.50, 13.81, [3.358, 8.123], [2.194, 4.734]),
        ("0.0220", 10.11, 6.43, 10.19, [3.822, 8.637], [2.034, 4.087]),
    ] {
        let free = predict(&["--m", m]);
        assert_near(&free["e_star_deg"], 23.374, 1e-4);
        assert_near(&free["omega_star_deg"], 0.05159, 1e-4);
        assert_near(&free["speedup_half_rate"], half_rate, 0.01);
        assert_near(&free["speedup"], unweighted, 0.01);
        assert_eq!(free["layers"].as_array().unwrap().len(), 3);
        for layer in 0..2 {
            assert_near(&free["layers"][layer]["radius_deg"], radii[layer], 0.01);
            assert_near(&free["layers"][layer + 1]["sampling_factor"], factors[layer], 0.01);
            assert!(number(&free["layers"][layer]["pixels"]) > 0.0);
        }
        let half = predict(&["--m", m, "--s2", "2"]);
        assert_near(&half["layers"][1]["sampling_factor"], 2.0, 1e-9);
        assert_near(&half["speedup_half_rate"], restricted, 0.01);
    }
    // The quality index is another name of the slope: m = 0.33 / j.
    assert_near(&predict(&["--quality", "15"])["m"], 0.022, 1e-9);
    let text = run(folder.path(), &["predict", "--display", "guenter-2012", "--m", "0.0275"]).expect(0).out;
    assert!(text.contains("8.50") && text.contains("13.29"), "{text}");
}

#[test]
fn a_rendered_picture_is_as_large_as_its_display_and_costs_what_it_says() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "small.json", &small_display());
    for (renderer, extra) in [("reference", ""), ("ring", "eccentricity_deg=3"), ("layers", "m=0.2")] {
        let file = format!("{renderer}.png");
        let mut arguments = vec!["render", "--scene", "photo", "--renderer", renderer, "--gaze", "-2.5,1", "--display"];
        arguments.extend(["small.json", "--out", &file, "--json"]);
        if !extra.is_empty() {
            arguments.extend(["--set", extra]);
        }
        let rendered = run(folder.path(), &arguments).expect(0).json();
        let keys: Vec<&String> = rendered.as_object().unwrap().keys().collect();
        let documented =
            ["scene", "renderer", "width", "height", "gaze_deg", "display_pixels", "pixels_shaded", "gpu_time_s"];
        assert_eq!(keys[..8], documented);
        assert_eq!(keys[8..], ["time_s", "frames", "triangles", "rays_traced", "layers", "file"]);
        assert_eq!(rendered["scene"], "photo");
        assert_eq!(rendered["renderer"], renderer);
        assert_eq!((&rendered["width"], &rendered["height"]), (&json!(160), &json!(90)));
        assert_eq!(rendered["gaze_deg"], json!([-2.5, 1.0]));
        assert_eq!(rendered["display_pixels"], 160 * 90);
        let shaded = rendered["pixels_shaded"].as_u64().unwrap();
        match renderer {
            "reference" => assert_eq!(shaded, 160 * 90),
            "ring" => assert!(shaded > 0),
            _ => assert!(shaded > 0 && shaded < 160 * 90, "{shaded}"),
        }
        assert!(rendered["gpu_time_s"].is_null() || number(&rendered["gpu_time_s"]) > 0.0);
        assert_eq!(rendered["file"], file.as_str());
        let picture = image::open(folder.path().join(file)).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (160, 90));
        let darkest = picture.pixels().map(|pixel| pixel.0[1]).min().unwrap();
        let brightest = picture.pixels().map(|pixel| pixel.0[1]).max().unwrap();
        assert!(brightest - darkest > 60, "a photograph has contrast, found {darkest} to {brightest}");
    }
    let bytes = |file: &str| std::fs::read(folder.path().join(file)).unwrap();
    assert_ne!(bytes("reference.png"), bytes("ring.png"));
}

/// Linear light in full floats: what the display's transfer makes of it is the PNG, and exposure has not touched it.
#[test]
fn an_exr_holds_the_linear_light_of_the_png() {
    let folder = tempdir().unwrap();
    let mut gamma = small_display();
    gamma["transfer"] = json!({ "gamma": [2.2, 2.2, 1.0] });
    write_json(folder.path(), "gamma.json", &gamma);
    for (file, size) in [("a.png", "96x54"), ("a.exr", "96x54")] {
        let arguments = ["render", "--scene", "photo", "--renderer", "layers", "--set", "m=0.2", "--display"];
        let more = ["gamma.json", "--size", size, "--out", file, "--json"];
        let rendered = run(folder.path(), &[&arguments[..], &more].concat()).expect(0).json();
        assert_eq!((&rendered["width"], &rendered["height"]), (&json!(96), &json!(54)));
    }
    let shown = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
    let linear = image::open(folder.path().join("a.exr")).unwrap().to_rgb32f();
    assert_eq!(linear.dimensions(), (96, 54));
    for (shown, linear) in shown.pixels().zip(linear.pixels()) {
        for (channel, gamma) in [2.2, 2.2, 1.0].into_iter().enumerate() {
            let expected = 255.0 * f64::from(linear[channel]).clamp(0.0, 1.0).powf(1.0 / gamma);
            assert!((f64::from(shown[channel]) - expected).abs() <= 0.51, "{shown:?} is not {linear:?}");
        }
    }
    let mut files: Vec<String> = contents(folder.path()).keys().map(|path| path.display().to_string()).collect();
    files.sort();
    assert_eq!(files, ["a.exr", "a.png", "gamma.json"], "nothing unfinished is left");
}

#[test]
fn a_heat_map_counts_what_was_shaded_in_the_last_frame() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "small.json", &small_display());
    let rendered = |scene: &str, renderer: &str, more: &[&str]| {
        let fixed = ["render", "--display", "small.json", "--out", "a.png", "--heatmap", "h.png", "--json"];
        let named = ["--scene", scene, "--renderer", renderer, "--gaze", "3,1"];
        run(folder.path(), &[&fixed[..], &named, more].concat()).expect(0).json()
    };
    // Once everywhere: one colour in the whole map, but for the gaze.
    let full = rendered("zone-plate", "reference", &[]);
    assert_eq!(full["counted"], json!({ "pixels": 160 * 90, "runs": 160 * 90 }));
    assert_eq!(full["pixels_shaded"], 160 * 90);
    let map = image::open(folder.path().join("h.png")).unwrap().to_rgb8();
    assert!(map.width() > 160 && map.height() > 90);
    let corner = *map.get_pixel(0, 0);
    let even = (0..90).flat_map(|y| (0..160).map(move |x| (x, y))).filter(|&(x, y)| *map.get_pixel(x, y) == corner);
    assert!(even.count() > 160 * 90 - 200);

    // Layers cost less, and less is darker: the corner far from the gaze against the place of the gaze.
    let layers = rendered("zone-plate", "layers", &["--set", "m=0.3"]);
    let counted = layers["counted"]["pixels"].as_u64().unwrap();
    assert_eq!(layers["pixels_shaded"], counted);
    assert!(counted < 160 * 90 / 2);
    let map = image::open(folder.path().join("h.png")).unwrap().to_rgb8();
    let brightness = |x: u32, y: u32| map.get_pixel(x, y).0.iter().map(|&c| u32::from(c)).sum::<u32>();
    let display = experiments::Display::new("small", [160, 90], [100.0, 56.0], 300.0).unwrap();
    let [x, y] = display.px_from_deg([3.0, 1.0]).map(|x| x as u32);
    assert!(brightness(x + 14, y) > brightness(0, 89) + 60, "{} {}", brightness(x + 14, y), brightness(0, 89));

    // A picture that stands still is drawn in the first frame and in no other; one that moves, in all of them.
    let still = rendered("photo", "reference", &["--frames", "3", "--time", "1"]);
    assert_eq!(still["counted"], json!({ "pixels": 0, "runs": 0 }));
    let moving = rendered("zone-plate", "reference", &["--frames", "3", "--fps", "30", "--set", "scene.drift_hz=2"]);
    assert_eq!(moving["counted"]["pixels"], 160 * 90);
    assert_eq!(moving["frames"], 3);
}

#[test]
fn devices_lists_what_there_is_as_one_document() {
    let folder = tempdir().unwrap();
    let devices = run(folder.path(), &["devices", "--json"]).expect(0).json();
    let ids = |key: &str| -> Vec<String> {
        devices[key].as_array().unwrap().iter().map(|entry| entry["id"].as_str().unwrap().to_owned()).collect()
    };
    assert!(ids("renderers").iter().any(|id| id == "ring"));
    assert!(ids("scenes").iter().any(|id| id == "photo"));
    assert!(devices["displays"].as_array().unwrap().iter().any(|display| display["name"] == "guenter-2012"));
    assert!(devices["adapter"].is_string() != devices["adapter_error"].is_string());
}

#[test]
fn what_cannot_be_used_is_refused_with_exit_code_2_and_nothing_is_written() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 1));
    write_json(folder.path(), "small.json", &small_display());
    std::fs::write(folder.path().join("gaze.csv"), "t_s,x_px\n0,zero\n").unwrap();
    std::fs::write(folder.path().join("latin.json"), b"{\n\"name\": \"caf\xe9\"}").unwrap();
    let run_it = ["run", "study.json", "--observer", "P01", "--offscreen", "--no-render"];
    let truth = ["--simulate", "omega0=0.021,m=0.022"];
    let picture = ["--out", "a.png", "--scene", "photo", "--renderer", "ring"];
    let refused: &[(&[&[&str]], &str)] = &[
        (&[&[]], "Usage"),
        (&[&["dance"]], "dance"),
        (&[&["check"]], "STUDY"),
        (&[&["check", "nowhere.json"]], "mar-demo"),
        (&[&["check", "latin.json"]], "latin.json:2"),
        (&[&["check", "mar-demo", "--display", "nowhere"]], "guenter-2012"),
        (&[&["new", "My Study"]], "a-z"),
        (&[&["new", "my--study"]], "a-z"),
        (&[&["new", "mine", "--from", "nothing"]], "mar-calibration"),
        (&[&["predict", "--m=-1", "--display", "small.json"]], "expected a number"),
        (&[&["predict", "--m", "0.02"]], "--display"),
        (&[&["predict", "--display", "small.json"]], "--m"),
        (&[&["run", "study.json"]], "--observer"),
        (&[&["run", "study.json", "--observer", "Jane Doe"]], "letters, digits"),
        (&[&["run", "study.json", "--observer", "P01", "--offscreen"]], "--simulate"),
        (&[&["run", "study.json", "--observer", "P01", "--no-render"]], "--offscreen"),
        (&[&run_it, &["--simulate", "omega0=far,m=0.022"]], "omega0"),
        (&[&run_it, &["--simulate", "m=0.022"]], "omega0 is missing"),
        (&[&run_it, &truth, &["--gaze", "mouse"]], "recorded:SESSION|FILE"),
        (&[&run_it, &truth, &["--gaze", "recorded:."]], "expected a session's folder"),
        (&[&run_it, &truth, &["--gaze", "simulated:rate=1000"]], "rate_hz"),
        (&[&run_it, &truth, &["--gaze", "simulated:rate_hz=fast"]], "expected a number"),
        (&[&run_it, &truth, &["--gaze", "simulated:rate_hz=-3"]], "rate_hz"),
        (&[&run_it, &truth, &["--faults", "short=2"]], "a share from 0 to 1"),
        (&[&run_it, &truth, &["--faults", "rain=2"]], "slow-sync-ms"),
        (&[&run_it, &truth, &["--force"]], "--resume"),
        (&[&run_it, &truth, &["--gaze", "recorded:nowhere.csv"]], "nowhere.csv"),
        (&[&run_it, &truth, &["--gaze", "recorded:gaze.csv"]], "gaze.csv"),
        (&[&run_it, &truth, &["--display", "guenter-2013"]], "guenter-2012"),
        (&[&run_it, &truth, &["--resume"]], "no unfinished session"),
        (&[&run_it, &truth, &["--resume", "--seed", "3"]], "--seed"),
        (&[&["doctor"]], "SESSION"),
        (&[&["doctor", "nowhere"]], "expected a session's folder"),
        (&[&["doctor", "a", "b", "--repair", "--out", "c"]], "expected one session"),
        (&[&["analyze"]], "SESSION"),
        (&[&["analyze", "nowhere"]], "expected a session's folder"),
        (&[&["analyze", "study.json"]], "expected a session's folder"),
        (&[&["replay", "nowhere"]], "expected a session's folder"),
        (&[&["replay", "nowhere", "--verify"]], "expected a session's folder"),
        (&[&["export", "nowhere", "--format", "csv", "--out", "tables"]], "expected a session's folder"),
        (&[&["export", "nowhere", "--format", "spss", "--out", "tables"]], "csv"),
        (&[&["render"], &picture, &["--gaze", "5"]], "two numbers"),
        (&[&["render"], &picture, &["--display", "nowhere"]], "guenter-2012"),
        (&[&["render"], &picture, &["--set", "mar_deg=-3"]], "mar_deg"),
        (&[&["render"], &picture, &["--set", "colour=3"]], "colour"),
        (&[&["render"], &picture, &["--size", "0x540"]], "from 16 to 16384"),
        (&[&["render"], &picture, &["--size", "99999x540"]], "from 16 to 16384"),
        (&[&["render"], &picture, &["--size", "wide"]], "1920x1080"),
        (&[&["render"], &picture, &["--size", "16384x16384"]], "at most 67108864 pixels"),
        (&[&["render"], &picture, &["--time", "NaN"]], "number of seconds"),
        (&[&["render"], &picture, &["--time", "1e300"]], "number of seconds"),
        (&[&["render"], &picture, &["--frames", "0"]], "--frames"),
        (&[&["render"], &picture, &["--frames", "3", "--fps", "0"]], "frames a second"),
        (&[&["render"], &picture, &["--heatmap", "a.exr"]], "ends in .png"),
        (&[&["render"], &picture, &["--heatmap", "a.png"]], "the same file"),
        (&[&["render"], &picture, &["--heatmap", "nowhere/b.png"]], "a folder that exists"),
        (&[&["render", "--out", "a.jpg", "--scene", "photo", "--renderer", "ring"]], "ends in .png, or in .exr"),
        (&[&["render", "--out", "b/a.png", "--scene", "photo", "--renderer", "ring"]], "a folder that exists"),
        (&[&["render", "--out", "a.png", "--scene", "moon", "--renderer", "ring"]], "photo"),
        (&[&["render", "--out", "a.png", "--scene", "photo", "--renderer", "magic"]], "ring"),
    ];
    let before = contents(folder.path());
    for (arguments, says) in refused {
        let ran = run(folder.path(), &arguments.concat()).expect(2);
        assert!(ran.err.contains(says), "{arguments:?} should mention {says}\n{}", ran.err);
        assert!(ran.out.is_empty(), "{arguments:?} printed {}", ran.out);
        assert!(contents(folder.path()) == before, "{arguments:?} wrote something");
    }
}

#[test]
fn five_mistakes_in_a_study_are_all_reported_with_their_lines() {
    let folder = tempdir().unwrap();
    run(folder.path(), &["new", "mine", "--from", "mar-demo"]).expect(0);
    let mut text = std::fs::read_to_string(folder.path().join("mine.json")).unwrap();
    let mut expected = Vec::new();
    // None of them adds or removes a line.
    for (from, to, field) in [
        ("\"gate_deg\": 2.0", "\"gate_deg\": \"wide\"", "gaze.gate_deg"),
        ("\"scene\": \"photo\"", "\"scene\": \"foto\"", "conditions.photo.scene"),
        ("\"interval_s\": 0.2", "\"interval_s\": -0.2", "blocks[0].protocol.interval_s"),
        ("\"break_every_trials\"", "\"break_every_trial\"", "blocks[1].break_every_trial"),
        ("\"max_trials\": 240, ", "", "blocks[1].procedure.stop"),
    ] {
        let (changed, line) = with_mistake(&text, from, to);
        text = changed;
        expected.push((line, field));
    }
    std::fs::write(folder.path().join("mine.json"), &text).unwrap();
    let before = contents(folder.path());
    let simulate = ["run", "mine.json", "--observer", "P01", "--offscreen", "--simulate", "m=0.02,omega0=0.02"];
    for arguments in [["check", "mine.json"].as_slice(), &["check", "mine.json", "--json"], &simulate] {
        let ran = run(folder.path(), arguments).expect(2);
        assert!(ran.out.is_empty(), "{}", ran.out);
        let found: Vec<&str> =
            ran.err.lines().filter(|line| line.starts_with("mine.json:") && line.contains("expected")).collect();
        assert_eq!(found.len(), 5, "{}", ran.err);
        for (line, field) in &expected {
            let start = format!("mine.json:{line}:");
            assert!(
                found.iter().any(|one| one.starts_with(&start) && one.contains(field)),
                "{start} {field}\n{}",
                ran.err
            );
        }
        assert!(ran.err.contains("5 mistakes"), "{}", ran.err);
        assert!(contents(folder.path()) == before);
    }
}

#[test]
fn every_mistake_in_a_display_file_is_reported_with_its_line() {
    let folder = tempdir().unwrap();
    let text = "{\n  \"name\": \"mine\",\n  \"resolution_px\": [160, 90.5],\n  \"distance_mm\": -300,\n  \"refresh_hz\": \"fast\"\n}\n";
    std::fs::write(folder.path().join("mine.json"), text).unwrap();
    let ran = run(folder.path(), &["check", "mar-demo", "--display", "mine.json"]).expect(2);
    for (line, field) in [(1, "size_mm"), (3, "resolution_px"), (4, "distance_mm"), (5, "refresh_hz")] {
        let start = format!("mine.json:{line}:");
        assert!(
            ran.err.lines().any(|one| one.starts_with(&start) && one.contains(field)),
            "{start} {field}\n{}",
            ran.err
        );
    }
    assert!(ran.err.contains("4 mistakes"), "{}", ran.err);
    for command in [
        ["predict", "--m", "0.02", "--display", "mine.json"].as_slice(),
        &["render", "--scene", "photo", "--renderer", "ring", "--out", "a.png", "--display", "mine.json"],
    ] {
        assert!(run(folder.path(), command).expect(2).err.contains("4 mistakes"));
    }
    assert_eq!(contents(folder.path()).len(), 1);
}

/// A Vulkan loader that is pointed at a driver that does not exist finds none.
#[cfg(target_os = "linux")]
#[test]
fn without_a_graphics_adapter_the_message_says_what_to_install_and_nothing_is_left_behind() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 1));
    write_json(folder.path(), "small.json", &small_display());
    let without_gpu = |arguments: &[&str]| {
        let nowhere = Path::new("no-such-driver.json");
        let mut command = program(folder.path());
        command.args(arguments).env("VK_DRIVER_FILES", nowhere).env("VK_ICD_FILENAMES", nowhere);
        finish(command.env_remove("VK_ADD_DRIVER_FILES"))
    };
    let before = contents(folder.path());
    let simulate = ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", "m=0.02,omega0=0.02"];
    for arguments in [
        ["render", "--scene", "photo", "--renderer", "ring", "--out", "a.png", "--display", "small.json"].as_slice(),
        &simulate,
        &["demo"],
    ] {
        let ran = without_gpu(arguments).expect(1);
        assert!(ran.err.contains("no graphics adapter found"), "{}", ran.err);
        assert!(ran.err.contains("mesa-vulkan-drivers"), "{}", ran.err);
        assert!(ran.out.is_empty(), "{}", ran.out);
        assert!(contents(folder.path()) == before, "{arguments:?} wrote something");
    }
    let devices = without_gpu(&["devices", "--json"]).expect(0).json();
    assert!(devices["adapter"].is_null());
    assert!(devices["adapter_error"].as_str().unwrap().contains("mesa-vulkan-drivers"));
    // What needs no pictures needs no adapter.
    without_gpu(&["check", "mar-demo"]).expect(0);
    let mut without_pictures = simulate.to_vec();
    without_pictures.push("--no-render");
    without_gpu(&without_pictures).expect(0);
}
