//! `parafovea bench renderers` at a tiny size: what it counts, that its ratios are those of its own counts, its figure,
//! and what it refuses. Times are not asserted: they are the machine's.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{contents, run, write_json};
use serde_json::{Value, json};
use tempfile::tempdir;

const TINY: [&str; 6] = ["bench", "renderers", "--size", "64x36", "--frames", "4"];

fn bench(folder: &std::path::Path, more: &[&str]) -> common::Ran {
    run(folder, &[&TINY, more].concat())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number, found {value}"))
}

fn whole(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("a whole number, found {value}"))
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap_or_else(|| panic!("a list, found {value}"))
}

#[track_caller]
fn assert_near(value: &Value, expected: f64) {
    assert!((number(value) / expected - 1.0).abs() < 1e-9, "expected {expected}, found {value}");
}

#[test]
fn every_renderer_is_measured_and_the_reference_is_one_times_itself() {
    let folder = tempdir().unwrap();
    let ran = bench(folder.path(), &["--json"]).expect(0);
    assert_eq!(ran.err, "", "no warning: everything counted is as computed");
    let measured = ran.json();
    let devices = run(folder.path(), &["devices", "--json"]).expect(0).json();
    let mut known: Vec<&str> = list(&devices["renderers"]).iter().map(|r| r["id"].as_str().unwrap()).collect();
    let renderers = list(&measured["renderers"]);
    let mut found: Vec<&str> = renderers.iter().map(|r| r["renderer"].as_str().unwrap()).collect();
    assert_eq!(found[0], "reference");
    known.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, known);

    let reference = &renderers[0];
    assert_eq!(whole(&reference["sums"]["pixels_shaded"]), 4 * 64 * 36);
    for quantity in ["pixels", "gpu_time", "wall_time"] {
        let ratio = &reference["ratios"][quantity];
        if !ratio.is_null() {
            assert_eq!((number(&ratio["of_sums"]), number(&ratio["median"])), (1.0, 1.0), "{quantity}");
        }
    }
    for renderer in renderers {
        let sums = &renderer["sums"];
        assert_eq!(renderer["counted"]["pixels"], sums["pixels_drawn"], "{renderer}");
        assert!(whole(&sums["pixels_shaded"]) >= whole(&sums["pixels_drawn"]));
        assert!(number(&sums["wall_time_s"]) > 0.0);
        let ratio = &renderer["ratios"]["pixels"]["of_sums"];
        assert_near(ratio, f64::from(4 * 64 * 36) / whole(&sums["pixels_shaded"]) as f64);
    }
}

/// A still picture is drawn in every frame too: otherwise whoever keeps it would cost nothing.
#[test]
fn a_still_picture_is_drawn_in_every_frame() {
    let folder = tempdir().unwrap();
    let more = ["--scene", "photo", "--renderer", "layers", "--gaze", "centre", "--set", "half_rate=off", "--json"];
    let measured = bench(folder.path(), &more).expect(0).json();
    let [reference, layers] = &list(&measured["renderers"])[..] else { panic!("two renderers: {measured}") };
    assert_eq!(whole(&reference["sums"]["pixels_shaded"]), 4 * 64 * 36);
    // So few pixels need no finer layer than the outer one.
    let drawn: Vec<u64> = list(&layers["layers"]).iter().map(|layer| whole(&layer["drawn_in_frames"])).collect();
    assert_eq!(drawn, [0, 0, 4], "{layers}");
}

/// So few pixels are so coarse that the study's qualities ask for nothing less; on a wide display lower ones do.
#[test]
fn layers_by_quality_have_ratios_of_their_own_counts_and_a_figure() {
    let folder = tempdir().unwrap();
    let wide = json!({ "name": "wide", "resolution_px": [64, 36], "size_mm": [600, 337], "distance_mm": 200 });
    write_json(folder.path(), "wide.json", &wide);
    let more =
        ["--display", "wide.json", "--quality", "0.6,0.2,0.6,13", "--figure", "savings.svg", "--set", "layers=3"];
    let measured = bench(folder.path(), &[&more[..], &["--json"]].concat()).expect(0).json();
    let [reference, coarse, fine, _] = &list(&measured["renderers"])[..] else { panic!("four runs: {measured}") };
    assert_eq!((&reference["renderer"], &reference["quality_index"]), (&"reference".into(), &Value::Null));
    for (layers, quality) in [(coarse, 0.2), (fine, 0.6)] {
        assert_eq!(number(&layers["quality_index"]), quality);
        assert_eq!(number(&layers["parameters"]["quality_index"]), quality);
        assert_eq!(layers["parameters"]["layers"], "3");
        let own = list(&layers["layers"]);
        let names: Vec<&str> = own.iter().map(|layer| layer["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["inner", "middle", "outer"]);
        // At half rate the inner layer is drawn always, the others in turn.
        assert_eq!(whole(&own[0]["drawn_in_frames"]), 4);
        let pixels = |name: &str| own.iter().map(|layer| whole(&layer[name])).sum::<u64>();
        assert_eq!(pixels("pixels"), pixels("pixels_counted"));
        assert_eq!(pixels("pixels"), whole(&layers["counted"]["pixels"]));
        let counted = [reference, layers].map(|renderer| whole(&renderer["counted"]["pixels"]) as f64);
        assert_near(&layers["ratios"]["pixels"]["of_sums"], counted[0] / counted[1]);
    }
    let pixels = [coarse, fine].map(|layers| whole(&layers["sums"]["pixels_shaded"]));
    println!("pixels at j = 0.2 and 0.6: {pixels:?} of {}", reference["sums"]["pixels_shaded"]);
    assert!(pixels[0] < pixels[1]);

    let svg = std::fs::read_to_string(folder.path().join("savings.svg")).unwrap();
    let figure = roxmltree::Document::parse(&svg).unwrap();
    let count = |name: &str| figure.descendants().filter(|node| node.tag_name().name() == name).count();
    let texts: Vec<&str> =
        figure.descendants().filter(|node| node.tag_name().name() == "text").filter_map(|node| node.text()).collect();
    for text in ["pixels", "time", "inner", "middle", "outer", "S: whole frame", "A: j = 12"] {
        assert!(texts.contains(&text), "{text} in {texts:?}");
    }
    // The other quality of Guenter's study lies beyond what was measured.
    assert!(!texts.contains(&"B: j = 15"));
    // Ratios of pixels and time; pixels of three layers and their sum, and the same of time where the GPU tells it.
    let timed = if coarse["sums"]["gpu_time_s"].is_null() { 0 } else { 4 };
    assert_eq!(count("polyline"), 2 + 4 + timed);
    // What was published is of another display.
    assert!(!texts.iter().any(|text| text.contains("on their GPU")), "{texts:?}");
}

#[test]
fn a_recorded_gaze_is_looked_along() {
    let folder = tempdir().unwrap();
    let rows = (0..60).map(|i| format!("{},{},{}\n", f64::from(i) * 0.01, 2.0, -1.0)).collect::<String>();
    std::fs::write(folder.path().join("eye.csv"), format!("t_s,x_deg,y_deg\n{rows}")).unwrap();
    let more = ["--renderer", "layers", "--gaze", "recorded:eye.csv", "--json"];
    let measured = bench(folder.path(), &more).expect(0).json();
    assert_eq!(measured["gaze"], "recorded:eye.csv");
    assert_eq!(list(&measured["renderers"]).len(), 2);
    let table = bench(folder.path(), &more[..4]).expect(0).out;
    println!("{table}");
    for word in ["reference", "layers", "inner", "means of one frame", "quartiles"] {
        assert!(table.contains(word), "{word}\n{table}");
    }
}

#[test]
fn every_mistake_is_named_at_once_and_nothing_is_written() {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("eye.csv"), "t_s,x_deg,y_deg\n0,a,1\n1,1,b\n").unwrap();
    let before = contents(folder.path());
    let wrong = [
        ("--scene", "nowhere", "--scene nowhere: expected one of photo"),
        ("--renderer", "nobody", "--renderer nobody: expected one of reference"),
        ("--frames", "0", "--frames 0: expected a whole number from 1 to 10000"),
        ("--fps", "fast", "--fps fast: expected a number from 1 to 1000"),
        ("--gaze", "recorded:eye.csv", "eye.csv:3: y_deg"),
        ("--quality", "12,-3,1000", "--quality -3: expected a number from 0 to 100, above 0"),
        ("--set", "m", "--set m: expected NAME=VALUE"),
        ("--figure", "nowhere/savings.svg", "--figure nowhere/savings.svg: expected a file in a folder that exists"),
    ];
    let mut arguments = vec!["bench", "renderers", "--renderer", "layers"];
    arguments.extend(wrong.iter().flat_map(|(option, value, _)| [*option, *value]));
    let ran = run(folder.path(), &arguments).expect(2);
    for (_, _, message) in wrong {
        assert!(ran.err.contains(message), "{message}\n{}", ran.err);
    }
    assert!(ran.err.contains("eye.csv:2: x_deg") && ran.err.contains("--quality 1000"), "{}", ran.err);
    assert!(ran.err.contains("10 mistakes, nothing was done") && ran.out.is_empty(), "{}", ran.err);

    let alone: [(&[&str], &str); 8] = [
        (&["--size", "64"], "--size 64: expected WIDTHxHEIGHT"),
        (&["--size", "1x1"], "expected whole pixels from 16 to 16384"),
        (&["--display", "nothing"], "--display nothing: expected a display file"),
        (&["--gaze", "recorded:missing.csv"], "cannot read missing.csv"),
        (&["--gaze", "up"], "--gaze up: expected sweep, centre or recorded:SESSION|FILE"),
        (&["--set", "nothing=1"], "--set nothing: expected a parameter"),
        (&["--figure", "savings.svg"], "--figure: expected --quality too"),
        (&["--renderer", "ring", "--quality", "12"], "expected a renderer with a quality index, found ring"),
    ];
    for (more, message) in alone {
        let ran = run(folder.path(), &[&["bench", "renderers"], more].concat()).expect(2);
        assert!(ran.err.contains(message), "{message}\n{}", ran.err);
    }
    assert!(contents(folder.path()) == before);
}
