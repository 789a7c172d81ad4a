//! Good trees pass, and each way to break one is found.

use super::names::name_problems;
use super::problems;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::Path;

const STEM: &str = "sub-P01/beh/sub-P01_task-x";

fn put(root: &Path, file: &str, text: &str) {
    let path = root.join(file);
    fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    fs::write(path, text).expect("written");
}

fn put_gz(root: &Path, file: &str, text: &str) {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(text.as_bytes()).expect("compressed");
    fs::write(root.join(file), encoder.finish().expect("compressed")).expect("written");
}

fn change(root: &Path, file: &str, change: impl FnOnce(&mut Value)) {
    let path = root.join(file);
    let mut value: Value = serde_json::from_slice(&fs::read(&path).expect("read")).expect("JSON");
    change(&mut value);
    fs::write(path, value.to_string()).expect("written");
}

/// A small data set written from the standard's text, not by our export.
fn good(root: &Path) {
    put(root, "dataset_description.json", r#"{"Name": "x", "BIDSVersion": "1.11.1"}"#);
    put(root, "README.md", "Words.\n");
    put(root, "participants.tsv", "participant_id\nsub-P01\n");
    put(root, "participants.json", r#"{"participant_id": {"Description": "who"}}"#);
    put(root, &format!("{STEM}_events.tsv"), "onset\tduration\ttrial_type\n0.5\t1\ttrial\n0.5\tn/a\tgo\n");
    let described = json!({ "Description": "words" });
    let events = json!({
        "TaskName": "x", "onset": described, "duration": described,
        "trial_type": { "Description": "what", "Levels": { "trial": "a trial", "go": "go" } },
        "StimulusPresentation": { "ScreenDistance": 0.6, "ScreenOrigin": ["top", "left"], "ScreenResolution": [1920, 1080],
            "ScreenSize": [0.5, 0.3] },
    });
    put(root, &format!("{STEM}_events.json"), &events.to_string());
    let place = json!({ "Description": "where", "Units": "pixel" });
    let physio = json!({
        "PhysioType": "eyetrack", "RecordedEye": "left", "SampleCoordinateSystem": "gaze-on-screen", "SamplingFrequency": 2,
        "StartTime": 0.25, "Columns": ["timestamp", "x_coordinate", "y_coordinate"], "timestamp": described,
        "x_coordinate": place, "y_coordinate": place,
    });
    put(root, &format!("{STEM}_recording-eye1_physio.json"), &physio.to_string());
    put_gz(root, &format!("{STEM}_recording-eye1_physio.tsv.gz"), "0.25\t1\t2\n0.75\tn/a\tn/a\n0.75\t1\t2\n");
    let found = json!({ "Columns": ["onset", "duration"], "OnsetSource": "timestamp", "onset": described, "duration": described });
    put(root, &format!("{STEM}_recording-eye1_physioevents.json"), &found.to_string());
    put_gz(root, &format!("{STEM}_recording-eye1_physioevents.tsv.gz"), "0.25\t0\n0.5\tn/a\n");
}

/// What is said of the good tree after it was broken.
fn said(broken: impl FnOnce(&Path)) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    good(folder.path());
    broken(folder.path());
    problems(folder.path()).expect("read")
}

#[test]
fn a_good_tree_passes() {
    assert_eq!(said(|_| ()), Vec::<String>::new());
}

/// Each of these is one change. bids-validator-deno 3.0.2 reports no missing ScreenDistance, ScreenSize or ScreenResolution, no
/// missing Units or `recording`, no timestamps that go back and no wrong StartTime, and stops where there are no events
/// (`tests/peers/bids_peer.py`).
#[test]
fn every_break_is_found() {
    type Break = Box<dyn FnOnce(&Path)>;
    let set = |file: &str, key: &'static str, inner: &'static str, value: Value| -> Break {
        let file = file.to_owned();
        Box::new(move |root| {
            change(root, &file, |json| {
                let object = if inner.is_empty() { json } else { &mut json[key] };
                let name = if inner.is_empty() { key } else { inner };
                object[name] = value;
            });
        })
    };
    let (events, physio) = (format!("{STEM}_events.json"), format!("{STEM}_recording-eye1_physio.json"));
    let found = format!("{STEM}_recording-eye1_physioevents.json");
    let screen = "StimulusPresentation";
    let text = |file: &'static str, text: &'static str| -> Break { Box::new(move |root| put(root, file, text)) };
    let events_tsv = "sub-P01/beh/sub-P01_task-x_events.tsv";
    let samples = |text: &'static str| -> Break {
        Box::new(move |root| put_gz(root, &format!("{STEM}_recording-eye1_physio.tsv.gz"), text))
    };
    let remove = |file: String| -> Break { Box::new(move |root| fs::remove_file(root.join(file)).expect("removed")) };
    let breaks: Vec<(Break, &str)> = vec![
        (set(&events, screen, "ScreenDistance", Value::Null), "ScreenDistance"),
        (set(&events, screen, "ScreenSize", Value::Null), "ScreenSize"),
        (set(&physio, "x_coordinate", "Units", Value::Null), "x_coordinate has no Units"),
        (set(&physio, "y_coordinate", "Units", json!("")), "y_coordinate has no Units"),
        (set(&events, screen, "ScreenDistance", json!(600)), ""),
        (set(&events, screen, "ScreenDistance", json!(6000)), "ScreenDistance"),
        (set(&physio, "StartTime", "", json!(3)), "StartTime 3 is not the first timestamp"),
        (samples("0.25\t1\t2\n0.1\t1\t2\n"), "row 2 goes back in time"),
        (set(&events, screen, "ScreenResolution", json!([1920.5, 1080])), "ScreenResolution"),
        (set(&events, screen, "ScreenOrigin", json!(["left", "top"])), "ScreenOrigin"),
        (set(&events, "TaskName", "", json!("y")), "TaskName"),
        (set(&events, "other", "", json!({})), "other is no column"),
        (set(&physio, "RecordedEye", "", json!("both")), "RecordedEye"),
        (set(&physio, "SampleCoordinateSystem", "", json!("screen")), "SampleCoordinateSystem"),
        (set(&physio, "SamplingFrequency", "", json!(0)), "SamplingFrequency"),
        (set(&physio, "PhysioType", "", json!("generic")), "PhysioType"),
        (set(&physio, "Columns", "", json!(["timestamp", "y_coordinate", "x_coordinate"])), "Columns does not begin"),
        (set(&physio, "timestamp", "", Value::Null), "timestamp is not described"),
        (set(&found, "OnsetSource", "", json!("time")), "OnsetSource"),
        (samples("0.25\t1\n"), "row 1 has 2 cells"),
        (samples("0.25\t1\t\n"), "row 1 has an empty cell"),
        (samples("0.25\tx\t2\n"), "neither a number nor n/a"),
        (samples("n/a\t1\t2\n"), "does not begin with a time"),
        (text(events_tsv, "onset\tduration\ttrial_type\n1\t1\ttrial\n0.5\t1\ttrial\n"), "row 2 begins before"),
        (text(events_tsv, "onset\tduration\ttrial_type\n1\t-1\ttrial\n"), "duration of row 1"),
        (text(events_tsv, "onset\tduration\ttrial_type\n1\t1\tother\n"), "none of its Levels"),
        (text(events_tsv, "onset\tduration\ttrial_type\n1\t1\n"), "row 1 has 2 cells"),
        (text(events_tsv, "onset\tduration\ttrial_type\n1\t1\t\n"), "empty cell"),
        (text(events_tsv, "duration\tonset\ttrial_type\n"), "first columns"),
        (text(events_tsv, "onset\tduration\ttrial_type\tx\n"), "the column x is not described"),
        (text("participants.tsv", "participant_id\nsub-P02\n"), "sub-P02 has a row or a folder"),
        (text("participants.tsv", "participant_id\nsub-P01\nsub-P01\n"), "two rows"),
        (text("dataset_description.json", r#"{"Name": "x"}"#), "BIDSVersion"),
        (text("dataset_description.json", "{"), "no JSON"),
        (text("README.md", " \n"), "is empty"),
        (remove("README.md".to_owned()), "README: is missing"),
        (remove(format!("{STEM}_events.tsv")), "_events.tsv is missing"),
        (remove(events.clone()), "events.json"),
        (remove(physio.clone()), "physio.json: is missing"),
        (
            Box::new(|root: &Path| {
                for end in ["json", "tsv.gz"] {
                    let of = |eye: &str| root.join(format!("{STEM}_recording-{eye}_physio.{end}"));
                    fs::copy(of("eye1"), of("eye2")).expect("copied");
                }
            }),
            "another recording is of the same eye",
        ),
        (
            Box::new(|root: &Path| {
                let whole = fs::read(root.join(format!("{STEM}_recording-eye1_physio.tsv.gz"))).expect("read");
                fs::write(root.join(format!("{STEM}_recording-eye1_physio.tsv.gz")), &whole[..12]).expect("written");
            }),
            "cannot be uncompressed",
        ),
    ];
    for (index, (broken, expected)) in breaks.into_iter().enumerate() {
        let problems = said(broken);
        if expected.is_empty() {
            // Six hundred metres: a cinema, perhaps; what is possible is not refused.
            assert_eq!(problems, Vec::<String>::new());
        } else {
            assert!(problems.iter().any(|problem| problem.contains(expected)), "{index} {expected}: {problems:?}");
        }
    }
}

#[test]
fn names_of_files() {
    for good in [
        "sub-01/beh/sub-01_task-x_events.tsv",
        "sub-01/ses-02/beh/sub-01_ses-02_task-x_recording-eye1_physio.tsv.gz",
        "sub-01/sub-01_sessions.tsv",
    ] {
        assert_eq!(name_problems(good), Vec::<String>::new(), "{good}");
    }
    for (bad, expected) in [
        ("sub-01/beh/sub-01_task-x_physio.tsv.gz", "the entity recording is missing"),
        ("sub-01/beh/sub-01_task-x_recording-eye1_events.tsv", "recording does not belong here"),
        ("sub-01/beh/sub-02_task-x_events.tsv", "is not in sub-02/beh"),
        ("sub-01/sub-01_task-x_events.tsv", "is not in sub-01/beh"),
        ("sub-01/beh/task-x_sub-01_events.tsv", "out of order"),
        ("sub-01/beh/sub-01_events.tsv", "task is missing"),
        ("sub-0-1/beh/sub-0-1_task-x_events.tsv", "more than letters and digits"),
        ("sub-01/beh/sub-01_task-x_notes.txt", "no kind of file"),
    ] {
        let problems = name_problems(bad);
        assert!(problems.iter().any(|problem| problem.contains(expected)), "{bad}: {problems:?}");
    }
}
