//! Studies that bring renderers and scenes along in files: checked, run, recorded, replayed and gone on with as a user does
//! it, and every way in which such files can be wrong.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{Ran, copy_folder, run, small_display, small_study, write_json};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The shipped examples, in a folder of their own.
fn examples() -> tempfile::TempDir {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/studies/own-renderers");
    let folder = tempfile::tempdir().unwrap();
    for file in ["quiet-periphery.wgsl", "quiet-periphery.json", "captures.json"] {
        std::fs::copy(from.join(file), folder.path().join(file)).unwrap();
    }
    std::fs::create_dir(folder.path().join("captures")).unwrap();
    std::fs::copy(from.join("captures/manifest.json"), folder.path().join("captures/manifest.json")).unwrap();
    for level in ["full", "half", "quarter"] {
        copy_folder(&from.join("captures").join(level), &folder.path().join("captures").join(level));
    }
    folder
}

fn header(session: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(session.join("session.json")).unwrap()).unwrap()
}

fn run_study(folder: &Path, study: &str, simulate: &str) -> PathBuf {
    let arguments =
        ["run", study, "--observer", "SIM", "--offscreen", "--simulate", simulate, "--data", "data", "--seed", "4"];
    folder.join(run(folder, &arguments).expect(0).out.trim_end())
}

#[test]
fn the_examples_check_run_and_replay() {
    let folder = examples();
    let here = folder.path();
    let checked = run(here, &["check", "captures.json"]).expect(0).out;
    assert!(checked.contains("engine: scene and renderer of frames from captures"), "{checked}");
    let checked = run(here, &["check", "quiet-periphery.json", "--json"]).expect(0).json();
    assert_eq!(checked["files"][0]["file"], "quiet-periphery.wgsl");
    let listed = run(here, &["devices", "quiet-periphery.json"]).expect(0).out;
    assert!(listed.contains("quiet ") && listed.contains("blur_rate: a number from 0 to 0.1 °/°"), "{listed}");

    let session = run_study(here, "captures.json", "omega0=0.03,m=0.05,width=0.8");
    let record = header(&session)["files"][0].clone();
    assert_eq!((&record["name"], record["contents"].as_array().unwrap().len()), (&json!("engine"), 25));
    assert_eq!(record["text"], std::fs::read_to_string(here.join("captures/manifest.json")).unwrap());
    let folder_name = session.file_name().unwrap().to_str().unwrap();
    let data = here.join("data");
    // From another working directory, and only some of the frames.
    let replayed =
        run(&data, &["replay", folder_name, "--verify", "--stimuli", "--limit", "150", "--json"]).expect(0).json();
    assert_eq!((&replayed["hashes_compared"], &replayed["hashes_different"]), (&json!(150), &json!(0)));

    // A frame that changed, and one that is gone: refused by name, both at once.
    std::fs::copy(here.join("captures/half/00.png"), here.join("captures/half/03.png")).unwrap();
    std::fs::remove_file(here.join("captures/full/05.png")).unwrap();
    let refused = run(&data, &["replay", folder_name, "--verify"]).expect(2).err;
    assert!(refused.contains("half/03.png: expected SHA-256") && refused.contains("full/05.png"), "{refused}");
}

#[test]
fn a_session_is_drawn_with_the_text_it_was_run_with() {
    let folder = examples();
    let here = folder.path();
    // A smaller display and fewer trials are enough.
    let mut study: Value =
        serde_json::from_str(&std::fs::read_to_string(here.join("quiet-periphery.json")).unwrap()).unwrap();
    study["display"] = small_display();
    study["gaze"] = json!({});
    study["blocks"][0]["procedure"]["repetitions"] = json!(1);
    study["blocks"][0]["procedure"]["levels"] = json!({ "blur_rate": [0.016, 0.03] });
    write_json(here, "small.json", &study);
    let session = run_study(here, "small.json", "pixels");
    let text = std::fs::read_to_string(here.join("quiet-periphery.wgsl")).unwrap();
    let record = header(&session)["files"][0].clone();
    assert_eq!((&record["text"], &record["source"]["kind"]), (&json!(text), &json!("wgsl")));

    // The file says something else by now, and then nothing at all.
    let name = session.display().to_string();
    std::fs::write(here.join("quiet-periphery.wgsl"), text.replace("given.grey", "0.9")).unwrap();
    let verify = ["replay", &name, "--verify", "--json"];
    assert_eq!(run(here, &verify).expect(0).json()["hashes_different"], 0);
    std::fs::remove_file(here.join("quiet-periphery.wgsl")).unwrap();
    assert_eq!(run(here, &verify).expect(0).json()["hashes_different"], 0);
    run(here, &["analyze", &name]).expect(0);
    // A new session needs the file.
    let refused = run(here, &["check", "small.json"]).expect(2).err;
    assert!(refused.contains("renderers.quiet: expected a file of text in UTF-8"), "{refused}");
    // A header whose text was changed is no header of this journal.
    let path = session.join("session.json");
    let changed = std::fs::read_to_string(&path).unwrap().replace("when it sees no hue", "when it sees no hues");
    std::fs::write(&path, changed).unwrap();
    assert!(run(here, &verify).expect(2).err.contains("does not match its seal"));
}

/// Puts a study's frames into the middle of a session: it stops, and goes on with the text that it began with.
#[test]
fn an_unfinished_session_goes_on_with_the_text_it_began_with() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let wgsl = |value: &str| {
        format!(
            "//! parameter mar_deg [°] 0..9 = 1: Coarse.\n//! parameter eccentricity_deg [°] 0..9 = 1: Where.\nfn colour(at: Place, given: Parameters) -> vec3f {{ return vec3f({value}); }}\n"
        )
    };
    std::fs::write(here.join("mine.wgsl"), wgsl("0.5")).unwrap();
    let mut study = small_study("goes-on", 1);
    study["renderers"] = json!({ "mine": { "wgsl": "mine.wgsl" } });
    study["conditions"]["photo"] = json!({ "scene": "photo", "renderer": "mine" });
    write_json(here, "study.json", &study);
    let whole = run_study(here, "study.json", "mar_deg=0.8,width=0.3,finer=down");
    // What a kill in the middle leaves: the journal up to a line in its middle.
    let (events, cut) = (whole.join("events.jsonl"), here.join("cut"));
    let text = std::fs::read_to_string(&events).unwrap();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    std::fs::create_dir(&cut).unwrap();
    copy_folder(&whole, &cut.join("session"));
    std::fs::write(cut.join("session/events.jsonl"), lines[..lines.len() / 2].concat()).unwrap();

    std::fs::write(here.join("mine.wgsl"), "no program").unwrap();
    let arguments = [
        "run",
        "study.json",
        "--observer",
        "SIM",
        "--offscreen",
        "--simulate",
        "mar_deg=0.8,width=0.3,finer=down",
        "--data",
        "cut",
        "--resume",
    ];
    let resumed = here.join(run(here, &arguments).expect(0).out.trim_end());
    let verified = run(here, &["replay", resumed.to_str().unwrap(), "--verify", "--json"]).expect(0).json();
    assert_eq!(verified["hashes_different"], 0);
}

/// The study of the tests with these entries, checked.
fn checked(here: &Path, entries: &[(&str, Value)]) -> Ran {
    let mut study = small_study("own", 1);
    for (key, value) in entries {
        study[*key] = value.clone();
    }
    write_json(here, "own.json", &study);
    run(here, &["check", "own.json"])
}

#[test]
fn mistakes_of_a_study_and_of_its_files_are_said_together() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("bad.wgsl"), "//! parameter r [°] 5..1 = 2: R.\n\nfn colour() {}\n").unwrap();
    std::fs::write(
        here.join("late.wgsl"),
        "fn colour(at: Place, given: Parameters) -> vec3f {\n    return nothing;\n}\n",
    )
    .unwrap();
    std::fs::create_dir(here.join("torn")).unwrap();
    std::fs::write(here.join("torn/manifest.json"), "{ \"format\": 1,").unwrap();
    std::fs::write(here.join("text.png"), "no picture").unwrap();
    let said = checked(
        here,
        &[
            ("title", json!(7)),
            (
                "renderers",
                json!({
                    "bad": { "wgsl": "bad.wgsl" }, "late": { "wgsl": "late.wgsl" }, "torn": { "frames": "torn" },
                    "gone": { "wgsl": "gone.wgsl" }, "ring": { "wgsl": "bad.wgsl" }, "none": {},
                    "two": { "wgsl": "a", "frames": "b" }, "wrong": { "glsl": "c" }, "Big": { "wgsl": "late.wgsl" }
                }),
            ),
            (
                "scenes",
                json!({
                    "paper": { "picture": "text.png" }, "room": { "gltf": "room.glb", "environment": "sky.exr" },
                    "sky": { "environment": "sky.hdr" }, "both": { "picture": "a.png", "gltf": "b.glb" }, "photo": { "picture": "text.png" }
                }),
            ),
        ],
    )
    .expect(2)
    .err;
    println!("{said}");
    for words in [
        "own.json:4:",
        "title: expected",
        "renderers.bad: expected a file without mistakes, found 1 mistake in bad.wgsl",
        "bad.wgsl:1:21: expected a range from its smaller to its larger end, found 5..1",
        "late.wgsl:2:12: expected valid WGSL",
        "torn/manifest.json:1:",
        "renderers.gone: expected a file of text in UTF-8",
        "renderers.none: expected the key wgsl or frames, found neither",
        "renderers.two: expected one of the keys wgsl and frames, found both",
        "renderers.wrong.glsl",
        "renderers.Big: expected a name",
        "scenes.paper: expected a",
        "scenes.both: expected a picture alone",
        "scenes.room:",
        "scenes.sky:",
    ] {
        assert!(said.contains(words), "{words:?} is not in it");
    }
}

#[test]
fn frames_go_with_their_own_scene_and_fit_the_display() {
    let folder = examples();
    let here = folder.path();
    let entries = |scene: &str, renderer: &str| {
        [
            ("renderers", json!({ "engine": { "frames": "captures" } })),
            ("conditions", json!({ "photo": { "scene": scene, "renderer": renderer } })),
            (
                "blocks",
                json!([{
                    "name": "main", "condition": "photo",
                    "protocol": { "kind": "two-interval", "fixation_s": 0.1, "interval_s": 0.1, "gap_s": 0.05 },
                    "procedure": { "kind": "constant", "levels": { "m": [0.05, 0.1] }, "repetitions": 1 }
                }]),
            ),
        ]
    };
    let said = checked(here, &entries("photo", "engine")).expect(2).err;
    assert!(said.contains("conditions.photo.scene: expected the scene \"engine\""), "{said}");
    // 192 × 108 frames on 160 × 90 pixels.
    let said = checked(here, &entries("engine", "engine")).expect(2).err;
    assert!(said.contains("at most 160×90 pixels") && said.contains("found frames of 192×108"), "{said}");
}

#[test]
fn render_takes_files() {
    let folder = examples();
    let here = folder.path();
    let display = json!({ "name": "window", "resolution_px": [320, 180], "size_mm": [200, 112.5], "distance_mm": 300 });
    write_json(here, "window.json", &display);
    let render = |scene: &str, renderer: &str| {
        run(
            here,
            &[
                "render",
                "--display",
                "window.json",
                "--scene",
                scene,
                "--renderer",
                renderer,
                "--out",
                "out.png",
                "--json",
            ],
        )
    };
    let rendered = render("captures", "captures").expect(0).json();
    assert_eq!(rendered["pixels_shaded"], 320 * 180);
    let rendered = render("captures/full/00.png", "quiet-periphery.wgsl").expect(0).json();
    assert_eq!(rendered["pixels_shaded"], 2 * 320 * 180);
    for (scene, renderer, words) in [
        ("photo", "captures", "whose frames the renderer"),
        ("photo", "captures.json", "expected a .wgsl file or a folder of frames"),
        ("quiet-periphery.wgsl", "ring", "expected a folder of frames, a .png"),
        ("nowhere", "ring", "there is no scene \"nowhere\""),
    ] {
        let said = render(scene, renderer).expect(2).err;
        assert!(said.contains(words), "{words:?} is not in {said}");
    }
    std::fs::write(here.join("bad.wgsl"), "fn colour(at: Place) {}\n").unwrap();
    assert!(
        render("photo", "bad.wgsl")
            .expect(2)
            .err
            .contains("bad.wgsl:1:4: expected `fn colour(at: Place, given: Parameters) -> vec3f`")
    );
    let said =
        run(here, &["render", "--scene", "photo", "--renderer", "ring", "--out", "o.png", "--watch"]).expect(2).err;
    assert!(said.contains("--watch: expected a scene or renderer from a file"), "{said}");
}
