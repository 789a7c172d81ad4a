//! Exports as a user makes them: every format, of small sessions and of sessions of the first format, whole or not at all.
//!
//! With `PARAFOVEA_KEEP_EXPORTS` set to a folder the exports are kept there, for `tests/peers` to hold against other programs.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{contents, copy_folder, csv_table, run, small_display, small_study, write_json};
use experiments::Display;
use experiments::session::event::{Change, Seam};
use experiments::session::record::Record;
use experiments::session::{Event, Stamped};
use experiments::study::parse_study;
use experiments::trial::Input;
use flate2::read::GzDecoder;
use parafovea::export::tables::Tables;
use parafovea::export::{bids, parquet as parquet_export, psych_ds};
use parafovea::session::SessionFolder;
use parafovea::session::header::{Header, StageRecord};
use parafovea::session::journal::Journal;
use parafovea::session::tables::{FrameRow, Layout};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use tempfile::tempdir;

const FORMATS: [&str; 4] = ["csv", "parquet", "bids", "psych-ds"];

/// Runs a study file offscreen without pictures for an observer; returns the session's folder.
fn observed(folder: &Path, study: &str, observer: &str, seed: u64, more: &[&str]) -> PathBuf {
    let seed = seed.to_string();
    let mut arguments = vec!["run", study, "--observer", observer, "--offscreen", "--no-render", "--data", "data"];
    arguments.extend(["--seed", &seed]);
    if !more.contains(&"--simulate") {
        arguments.extend(["--simulate", common::TRUTH]);
    }
    arguments.extend(more);
    folder.join(run(folder, &arguments).expect(0).out.trim_end())
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/sessions")
}

fn json_of(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))).unwrap()
}

/// The rows of a tab-separated file, every cell a text; those of a compressed one have no header.
fn tsv(path: &Path) -> Vec<Vec<String>> {
    let mut text = String::new();
    let file = std::fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    if path.extension().is_some_and(|extension| extension == "gz") {
        GzDecoder::new(file).read_to_string(&mut text).unwrap();
    } else {
        let mut file = file;
        file.read_to_string(&mut text).unwrap();
    }
    text.lines().map(|line| line.split('\t').map(str::to_owned).collect()).collect()
}

/// Keeps an export for the peers, if that is asked for.
fn keep(export: &Path, name: &str) {
    if let Some(kept) = std::env::var_os("PARAFOVEA_KEEP_EXPORTS") {
        for file in contents(export).into_iter().filter_map(|(file, bytes)| bytes.map(|bytes| (file, bytes))) {
            let path = Path::new(&kept).join(name).join(file.0);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, file.1).unwrap();
        }
    }
}

/// Files of an export, and its own check.
fn exported(folder: &Path, arguments: &[&str], format: &str, out: &str) -> Vec<String> {
    let arguments = [&["export"], arguments, &["--format", format, "--out", out]].concat();
    run(folder, &arguments).expect(0);
    keep(&folder.join(out), out);
    contents(&folder.join(out))
        .into_iter()
        .filter_map(|(file, bytes)| bytes.map(|_| file.to_str().unwrap().to_owned()))
        .collect()
}

#[test]
fn csv_and_parquet_hold_the_same_cells() {
    let folder = tempdir().unwrap();
    let mut study = small_study("small", 2);
    study["participant"] =
        json!([{ "name": "age", "question": "How old are you?", "kind": "number", "min": 18, "max": 99 }]);
    write_json(folder.path(), "small.json", &study);
    observed(folder.path(), "small.json", "P01", 4, &[]);
    observed(folder.path(), "small.json", "P02", 5, &[]);
    copy_folder(&fixtures().join("format-1/resumed"), &folder.path().join("data/resumed"));
    exported(folder.path(), &["data"], "csv", "tables-csv");
    exported(folder.path(), &["data"], "parquet", "tables-parquet");
    let (csv, parquet) = (folder.path().join("tables-csv"), folder.path().join("tables-parquet"));
    let dictionary = json_of(&csv.join("columns.json"));
    let mut cells = BTreeMap::new();
    for (file, described) in dictionary.as_object().unwrap() {
        let (columns, rows) = csv_table(&csv.join(file));
        let name = file.replace(".csv", ".parquet");
        assert_eq!(json_of(&parquet.join("columns.json"))[&name], *described, "{name}");
        let reader = SerializedFileReader::new(std::fs::File::open(parquet.join(&name)).unwrap()).unwrap();
        let metadata = reader.metadata().file_metadata().key_value_metadata().unwrap();
        for (column, entry) in columns.iter().zip(described.as_array().unwrap()) {
            let key = format!("column:{column}");
            let stored = metadata.iter().find(|pair| pair.key == key).unwrap().value.as_ref().unwrap();
            assert_eq!(serde_json::from_str::<Value>(stored).unwrap(), *entry, "{name}: {column}");
        }
        let read: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(read.len(), rows.len(), "{name}");
        for (texts, row) in rows.iter().zip(read) {
            for ((text, (column, field)), entry) in
                texts.iter().zip(row.get_column_iter()).zip(described.as_array().unwrap())
            {
                assert_eq!(entry["name"], column.as_str(), "{name}");
                let (kind, same) = match field {
                    Field::Null => (entry["type"].as_str().unwrap(), text.is_empty()),
                    Field::Long(value) => ("integer", text.parse() == Ok(*value)),
                    Field::Double(value) => ("real", text.parse::<f64>().unwrap().to_bits() == value.to_bits()),
                    Field::Bool(value) => ("boolean", text == if *value { "1" } else { "0" }),
                    Field::Str(value) => ("text", text == value),
                    other => panic!("{name}: {column} is {other:?}"),
                };
                assert!(same && entry["type"] == kind, "{name}: {column}: {text:?} and {field:?}");
                *cells.entry(kind.to_owned()).or_insert(0) += 1;
            }
        }
    }
    for kind in ["integer", "real", "boolean", "text"] {
        assert!(cells[kind] > 500, "{cells:?}");
    }

    // What the tables say of the sessions themselves.
    let (columns, sessions) = csv_table(&csv.join("sessions.csv"));
    let value = |row: &[String], name: &str| row[columns.iter().position(|column| column == name).unwrap()].clone();
    assert_eq!(sessions.len(), 3);
    assert_eq!(value(&sessions[0], "session"), "resumed");
    assert_eq!(
        ["parts", "finished", "display_width_px", "distance_mm"].map(|name| value(&sessions[0], name)),
        ["2", "1", "64", "300"]
    );
    assert_eq!(
        ["study", "seed", "gaze_source", "parts"].map(|name| value(&sessions[1], name)),
        ["small", "4", "simulated", "1"]
    );
    let (_, seams) = csv_table(&csv.join("seams.csv"));
    assert_eq!(seams.len(), 1);
    assert_eq!(seams[0][..3], ["resumed", "P01", "2"]);
    let (_, forms) = csv_table(&csv.join("forms.csv"));
    assert_eq!(forms.iter().map(|row| row[4].as_str()).collect::<Vec<_>>(), ["age", "age"]);
}

#[test]
fn a_data_folder_is_exported_at_once_and_what_cannot_be_read_is_named() {
    let folder = tempdir().unwrap();
    for name in ["one", "other"] {
        let mut study = small_study(name, 1);
        study["blocks"][0]["procedure"]["levels"] = json!({ "eccentricity_deg": [3], "mar_deg": [0.6, 1.1] });
        write_json(folder.path(), &format!("{name}.json"), &study);
        observed(folder.path(), &format!("{name}.json"), "P01", 1, &[]);
    }
    let rows = |out: &str, file: &str| csv_table(&folder.path().join(out).join(file)).1;
    exported(folder.path(), &["data"], "csv", "all");
    assert_eq!((rows("all", "sessions.csv").len(), rows("all", "trials.csv").len()), (2, 4));
    exported(folder.path(), &["data", "--study", "other"], "csv", "chosen");
    let chosen = rows("chosen", "sessions.csv");
    assert_eq!(chosen.iter().map(|row| row[2].as_str()).collect::<Vec<_>>(), ["other"]);
    // A session that is named twice, by its data folder and by itself, is one session.
    let session = format!("data/{}", chosen[0][0]);
    exported(folder.path(), &["data", &session], "csv", "twice");
    assert_eq!(rows("twice", "sessions.csv").len(), 2);

    std::fs::create_dir(folder.path().join("data/broken")).unwrap();
    std::fs::write(folder.path().join("data/broken/session.json"), "{").unwrap();
    std::fs::create_dir(folder.path().join("data/headless")).unwrap();
    std::fs::write(folder.path().join("data/headless/events.jsonl"), "").unwrap();
    std::fs::create_dir(folder.path().join("data/notes")).unwrap();
    std::fs::create_dir(folder.path().join("nothing")).unwrap();
    let before = contents(folder.path());
    for format in FORMATS {
        let refused = run(folder.path(), &["export", "data", "--format", format, "--out", "more"]).expect(2).err;
        assert!(refused.contains("broken/session.json:1:") && refused.contains("headless"), "{refused}");
        assert!(refused.contains("2 of 4 sessions cannot be read; give --skip-unreadable"), "{refused}");
        for (arguments, expected) in [
            (["export", "missing", "--format", format, "--out", "more"], "missing: expected a session's folder"),
            (["export", "nothing", "--format", format, "--out", "more"], "a folder with sessions in it, found neither"),
            (["export", &session, "--format", format, "--out", "all"], "expected a new or empty folder"),
            (["export", &session, "--format", format, "--out", "one.json"], "expected a new or empty folder"),
        ] {
            let refused = run(folder.path(), &arguments).expect(2).err;
            assert!(refused.contains(expected), "{refused}");
        }
    }
    let unknown = ["export", &session, "--study", "third", "--format", "csv", "--out", "more"];
    let refused = run(folder.path(), &unknown).expect(2).err;
    assert!(
        refused.contains("none of the 1 sessions is of this study; there are one")
            || refused.contains("there are other"),
        "{refused}"
    );
    assert!(contents(folder.path()) == before, "a refused export writes nothing");

    exported(folder.path(), &["data", "--skip-unreadable"], "csv", "skipped");
    assert_eq!(rows("skipped", "sessions.csv").len(), 2);
}

#[test]
fn a_table_with_a_hole_in_it_is_not_handed_on() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "small.json", &small_study("small", 1));
    let session = observed(folder.path(), "small.json", "P01", 1, &[]);
    let gaze = std::fs::read_to_string(session.join("gaze.csv")).unwrap();
    let broken: Vec<String> = gaze
        .lines()
        .enumerate()
        .map(|(line, text)| if line == 40 { "x,y\n".to_owned() } else { format!("{text}\n") })
        .collect();
    std::fs::write(session.join("gaze.csv"), broken.concat()).unwrap();
    let before = contents(folder.path());
    for format in FORMATS {
        let refused = run(folder.path(), &["export", "data", "--format", format, "--out", "out"]).expect(2).err;
        assert!(refused.contains("gaze.csv: line 41"), "{refused}");
    }
    assert!(contents(folder.path()) == before, "a refused export leaves nothing behind");
}

#[test]
fn sessions_of_the_first_format_are_exported_in_every_format() {
    for format in FORMATS {
        let folder = tempdir().unwrap();
        for session in ["finished", "torn", "resumed"] {
            copy_folder(&fixtures().join("format-1").join(session), &folder.path().join("data").join(session));
        }
        let before = contents(&folder.path().join("data"));
        let files = exported(folder.path(), &["data"], format, &format!("first-{format}"));
        assert!(contents(&folder.path().join("data")) == before, "sessions are only read");
        let out = folder.path().join(format!("first-{format}"));
        let has = |file: &str| assert!(files.iter().any(|known| known == file), "{file}: {files:?}");
        match format {
            "csv" => {
                let lines = |session: &str| {
                    let bytes = std::fs::read(fixtures().join("format-1").join(session).join("gaze.csv")).unwrap();
                    bytes.iter().filter(|&&byte| byte == b'\n').count() - 1
                };
                let rows = csv_table(&out.join("gaze.csv")).1;
                assert_eq!(rows.len(), ["finished", "torn", "resumed"].map(lines).iter().sum::<usize>());
                assert_eq!(csv_table(&out.join("trials.csv")).1.iter().filter(|row| row[0] == "resumed").count(), {
                    let text = std::fs::read_to_string(fixtures().join("format-1/resumed/events.jsonl")).unwrap();
                    text.matches("\"trial-ended\"").count()
                });
            }
            "parquet" => has("gaze.parquet"),
            "bids" => {
                assert_eq!(bids::check::problems(&out).unwrap(), Vec::<String>::new());
                has("sub-P01/ses-03/beh/sub-P01_ses-03_task-fixture_recording-eye1_physio.tsv.gz");
                has("sub-P01/sub-P01_sessions.tsv");
                let sessions = tsv(&out.join("sub-P01/sub-P01_sessions.tsv"));
                let mut names: Vec<&str> = sessions[1..].iter().map(|row| row[3].as_str()).collect();
                names.sort_unstable();
                assert_eq!(names, ["finished", "resumed", "torn"]);
                let resumed = sessions.iter().find(|row| row[3] == "resumed").unwrap();
                let label = &resumed[0];
                let events = tsv(&out.join(format!("sub-P01/{label}/beh/sub-P01_{label}_task-fixture_events.tsv")));
                assert_eq!(events.iter().filter(|row| row[2] == "resumed").count(), 1);
            }
            _ => {
                assert_eq!(psych_ds::check::problems(&out).unwrap(), Vec::<String>::new());
                has("data/study-fixture_subject-P01_session-02_description-gaze_data.csv");
            }
        }
    }
}

#[test]
fn a_bids_export_says_what_was_seen_and_when() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "small.json", &small_study("my-study", 1));
    let mut newest = PathBuf::new();
    for (observer, seed) in [("P-01", 1), ("P-01", 2), ("P02", 3)] {
        newest = observed(folder.path(), "small.json", observer, seed, &[]);
    }
    let files = exported(folder.path(), &["data"], "bids", "bids-binocular");
    let out = folder.path().join("bids-binocular");
    assert_eq!(bids::check::problems(&out).unwrap(), Vec::<String>::new());
    // Three sessions, each with a recording of either eye and of both, each of those with what was found in it.
    for (end, count) in [("_events.tsv", 3), ("_physio.tsv.gz", 9), ("_physio.json", 9), ("_physioevents.tsv.gz", 9)] {
        assert_eq!(files.iter().filter(|file| file.ends_with(end)).count(), count, "{end}: {files:?}");
    }
    let participants = tsv(&out.join("participants.tsv"));
    assert_eq!(participants[1..].iter().map(|row| row[0].as_str()).collect::<Vec<_>>(), ["sub-P01", "sub-P02"]);
    assert_eq!(participants[1][2], "P-01");

    // The gaze of both eyes, sample by sample, as the session has it.
    let stem = out.join("sub-P02/ses-01/beh/sub-P02_ses-01_task-mystudy");
    let beside = |end: &str| PathBuf::from(format!("{}_{end}", stem.display()));
    let (_, gaze) = csv_table(&newest.join("gaze.csv"));
    let eyes = ["eye1", "eye2", "eye3"].map(|eye| {
        let sidecar = json_of(&beside(&format!("recording-{eye}_physio.json")));
        let columns: Vec<String> = serde_json::from_value(sidecar["Columns"].clone()).unwrap();
        assert_eq!(
            columns,
            ["timestamp", "x_coordinate", "y_coordinate", "pupil_size", "device_timestamp", "arrival_time"]
        );
        assert_eq!(sidecar["SamplingFrequency"], 250.0);
        (sidecar["RecordedEye"].clone(), tsv(&beside(&format!("recording-{eye}_physio.tsv.gz"))))
    });
    assert_eq!(eyes.each_ref().map(|(eye, _)| eye.as_str().unwrap()), ["left", "right", "cyclopean"]);
    let mut lost = 0;
    for (eye, [x, valid, pupil]) in eyes.iter().map(|(_, rows)| rows).zip([[9, 11, 12], [13, 15, 16], [3, 7, 8]]) {
        assert_eq!(eye.len(), gaze.len());
        for (row, sample) in eye.iter().zip(&gaze) {
            assert_eq!([&row[0], &row[4], &row[5]], [&sample[0], &sample[2], &sample[1]]);
            let seen = [&sample[x], &sample[x + 1], &sample[pupil]].map(String::as_str);
            let expected = if sample[valid] == "1" { seen } else { ["n/a"; 3] };
            lost += u32::from(sample[valid] != "1");
            assert_eq!([&row[1], &row[2], &row[3]].map(String::as_str), expected);
        }
    }
    assert!(lost > 0, "the simulated tracker loses samples");

    let description = json_of(&beside("events.json"));
    let screen = &description["StimulusPresentation"];
    assert_eq!(description["TaskName"], "mystudy");
    assert_eq!((&screen["ScreenDistance"], &screen["ScreenResolution"]), (&json!(0.3), &json!([160, 90])));
    assert_eq!((&screen["ScreenSize"], &screen["ScreenOrigin"]), (&json!([0.1, 0.056]), &json!(["top", "left"])));
    let events = tsv(&beside("events.tsv"));
    let column = |name: &str| events[0].iter().position(|column| column == name).unwrap();
    let trials: Vec<_> = events.iter().filter(|row| row[2] == "trial").collect();
    assert_eq!(trials.len(), 18);
    assert!(trials.iter().all(|row| row[column("outcome")] == "answered" && row[3].parse::<f64>().unwrap() > 0.0));
    assert_eq!(events.iter().filter(|row| row[2] == "interval2").count(), 18);
    // A phase begins where the one before it ends.
    let first: Vec<_> = events.iter().filter(|row| row[column("trial")] == "1" && row[2] != "trial").collect();
    for pair in first.windows(2) {
        let [onset, duration, next] = [&pair[0][0], &pair[0][1], &pair[1][0]].map(|cell| cell.parse::<f64>().unwrap());
        assert!((onset + duration - next).abs() < 1e-8, "{pair:?}");
    }
    let found = tsv(&beside("recording-eye3_physioevents.tsv.gz"));
    let count = |kind: &str| found.iter().filter(|row| row[2] == kind).count();
    assert!(count("fixation") > 0 && count("loss") > 0, "{found:?}");
    assert_eq!(found.iter().filter(|row| row[3].starts_with("trial ")).count(), 18);
}

#[test]
fn labels_that_would_be_the_same_are_refused() {
    let folder = tempdir().unwrap();
    let mut study = small_study("small", 1);
    study["blocks"][0]["procedure"]["levels"] = json!({ "eccentricity_deg": [3], "mar_deg": [1.1] });
    write_json(folder.path(), "small.json", &study);
    for observer in ["P-1", "p1"] {
        observed(folder.path(), "small.json", observer, 1, &[]);
    }
    let before = contents(folder.path());
    for format in ["bids", "psych-ds"] {
        let refused = run(folder.path(), &["export", "data", "--format", format, "--out", "out"]).expect(2).err;
        assert!(refused.contains("observers: \"P-1\", \"p1\" would all be called \"p1\""), "{refused}");
    }
    assert!(contents(folder.path()) == before);
    // Tables have the codes themselves, so there is nothing to confuse.
    exported(folder.path(), &["data"], "csv", "codes");
}

#[test]
fn ratings_and_settings_are_exported() {
    let folder = tempdir().unwrap();
    let slider = ["--simulate", "quality_index=14,width=3,finer=up", "--pilot"];
    observed(folder.path(), "guenter-slider", "P01", 1, &slider);
    let likert = ["--simulate", "quality_index=14,width=3,finer=up", "--pilot"];
    observed(folder.path(), "weier-likert", "P02", 2, &likert);
    let files = exported(folder.path(), &["data"], "bids", "bids-ratings");
    let out = folder.path().join("bids-ratings");
    assert_eq!(bids::check::problems(&out).unwrap(), Vec::<String>::new());
    assert!(files.iter().any(|file| file.ends_with("sub-P01_task-guenterslider_events.tsv")), "{files:?}");
    for (file, found) in [
        ("sub-P01/beh/sub-P01_task-guenterslider_events.tsv", "level_quality_index"),
        ("sub-P02/beh/sub-P02_task-weierlikert_events.tsv", "found_"),
    ] {
        let events = tsv(&out.join(file));
        let index = events[0].iter().position(|column| column.starts_with(found)).unwrap();
        let values = events[1..].iter().filter(|row| row[index].parse::<f64>().is_ok()).count();
        assert!(values > 0, "{file}: {found}");
    }
    exported(folder.path(), &["data"], "psych-ds", "psych-ds-ratings");
    let out = folder.path().join("psych-ds-ratings");
    assert_eq!(psych_ds::check::problems(&out).unwrap(), Vec::<String>::new());
    // Cell for cell what the CSV export has, behind the rows' numbers.
    exported(folder.path(), &["data", "--study", "guenter-slider"], "csv", "csv-slider");
    let numbered = csv_table(&out.join("data/study-guenterslider_subject-P01_session-01_description-phases_data.csv"));
    let plain = csv_table(&folder.path().join("csv-slider/phases.csv"));
    assert!(!plain.1.is_empty());
    assert_eq!(numbered.0[1..], plain.0);
    for (number, (with, without)) in numbered.1.iter().zip(&plain.1).enumerate() {
        assert_eq!((with[0].as_str(), &with[1..]), ((number + 1).to_string().as_str(), without.as_slice()));
    }
}

/// A session made by hand: gaze from `source`, its table as given.
fn by_hand(path: &Path, observer: &str, source: Value, gaze: &str, events: Vec<Event>) -> SessionFolder {
    std::fs::create_dir_all(path).unwrap();
    let columns = "t_s,arrived_s,t_device_s,x_px,y_px,x_deg,y_deg,valid,pupil_mm,left_x_px,left_y_px,left_valid,\
                   left_pupil_mm,right_x_px,right_y_px,right_valid,right_pupil_mm\n";
    std::fs::write(path.join("gaze.csv"), columns.to_owned() + gaze).unwrap();
    std::fs::write(path.join("frames.csv"), Layout::<FrameRow>::new(1).1).unwrap();
    let text = small_study("by-hand", 1).to_string();
    let display = Display::new("small", [160, 90], [100.0, 56.0], 300.0).unwrap();
    assert_eq!(small_display()["resolution_px"], json!(display.resolution_px()));
    let opened = Event::Opened { header_sha256: String::new(), rules: Default::default() };
    let events: Vec<Stamped> = std::iter::once(opened)
        .chain(events)
        .enumerate()
        .map(|(seq, event)| Stamped { seq: seq as u64, t_s: seq as f64, event })
        .collect();
    let record = Record::from_events(&events);
    let plan = parse_study("study", &text, &stimuli::catalogue(), Some(&display)).unwrap();
    let gpu = Some("an adapter".to_owned());
    let stage = StageRecord { kind: "window".to_owned(), gpu, ..StageRecord::offscreen(&display, true) };
    let mut header = Header::new(&plan, &text, observer, u64::MAX, stage);
    // Tables made by hand have no CRC.
    header.format = 1;
    header.started = "2026-11-22T10:00:00+01:00".to_owned();
    header.gaze_source = source;
    SessionFolder {
        path: path.to_owned(),
        header,
        display,
        study: Default::default(),
        journal: Journal::in_memory(events),
        record,
    }
}

fn bids_of(sessions: &[SessionFolder], out: &Path, name: &str) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    bids::export(&Tables::new(sessions, &[], &|| ()), out).unwrap();
    assert_eq!(bids::check::problems(out).unwrap(), Vec::<String>::new());
    keep(out, name);
    contents(out)
}

#[test]
fn a_mouse_one_eye_or_no_gaze_at_all_are_said_to_be_what_they_are() {
    let folder = tempdir().unwrap();
    // The samples of a mouse; the third is late and stands behind the fourth, as it arrived.
    let mouse = "0.5,0.5,0.5,80,45,0,0,1,,,,,,,,,\n0.6,0.6,0.6,81,45,0,0,1,,,,,,,,,\n\
                 0.8,0.8,0.8,82,45,0,0,0,,,,,,,,,\n0.7,0.8,0.7,83,45,0,0,1,,,,,,,,,\n";
    let one = "0,0,7,80,45,0,0,1,3.5,80,45,1,3.5,,,,\n0.01,0.01,7.01,80,45,0,0,0,,80,45,0,,,,,\n";
    let lost = "0,0,0,80,45,0,0,0,,,,,,,,,\n0.01,0.01,0.01,80,45,0,0,0,,,,,,,,,\n";
    let sessions = [
        ("mouse", "P1", "mouse", mouse),
        ("one", "P2", "tracker", one),
        ("lost", "P3", "tracker", lost),
        ("none", "P4", "tracker", ""),
    ]
    .map(|(name, observer, source, gaze)| {
        by_hand(&folder.path().join(name), observer, json!({ "id": source }), gaze, Vec::new())
    });
    let out = folder.path().join("out");
    let files = bids_of(&sessions, &out, "bids-eyes");
    let eyes = |subject: &str| -> Vec<String> {
        let sidecars = files.keys().filter(|file| file.to_str().unwrap().ends_with("_physio.json"));
        let own = sidecars.filter(|file| file.starts_with(format!("sub-{subject}")));
        own.map(|file| json_of(&out.join(file))["RecordedEye"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(eyes("P1"), ["cyclopean"]);
    assert_eq!(eyes("P2"), ["left", "cyclopean"]);
    assert_eq!(eyes("P3"), ["cyclopean"]);
    assert_eq!(eyes("P4"), Vec::<String>::new());
    let rows = |subject: &str, end: &str| {
        tsv(&out.join(format!("sub-{subject}/beh/sub-{subject}_task-byhand_recording-eye1_{end}.tsv.gz")))
    };
    let first: Vec<[String; 2]> =
        rows("P1", "physio").into_iter().map(|row| [row[0].clone(), row[1].clone()]).collect();
    assert_eq!(first, [["0.5", "80"], ["0.6", "81"], ["0.7", "83"], ["0.8", "n/a"]].map(|row| row.map(str::to_owned)));
    let description = json_of(&out.join("sub-P1/beh/sub-P1_task-byhand_recording-eye1_physio.json"));
    assert!(description["x_coordinate"]["Description"].as_str().unwrap().contains("mouse pointer"));
    assert_eq!((&description["StartTime"], &description["SamplingFrequency"]), (&json!(0.5), &json!(10.0)));
    assert!(rows("P1", "physioevents").iter().all(|row| row[2] == "loss"), "a mouse makes no saccades");
    assert_eq!(rows("P3", "physioevents"), [["0", "0.01", "loss", "n/a"].map(str::to_owned)]);
}

#[test]
fn where_a_session_went_on_and_what_was_different_is_in_every_export() {
    let folder = tempdir().unwrap();
    let seam = |changed: &[Change]| Seam {
        wall: "2026-11-22T11:00:00+01:00".to_owned(),
        program: "parafovea 0.1.0".to_owned(),
        gpu: None,
        changed: changed.to_vec(),
        ..Seam::default()
    };
    let change = Change { field: "display: distance_mm".to_owned(), from: "300".to_owned(), to: "310".to_owned() };
    let reopened = || Event::Input { input: Input::Reopened, accepted: true };
    let events = vec![
        Event::Continued(Box::new(seam(&[]))),
        // Killed again before anything happened: no part began here.
        Event::Continued(Box::new(seam(&[]))),
        reopened(),
        Event::Gap { gaze_samples: 12, frames: 3 },
        Event::Continued(Box::new(seam(&[change]))),
        reopened(),
        reopened(),
    ];
    let session = by_hand(&folder.path().join("seams"), "P1", json!({ "id": "mouse" }), "", events);
    let sessions = [session];
    let tables = Tables::new(&sessions, &[], &|| ());
    let out = folder.path().join("csv");
    parafovea::export::csv::export_tables(&tables, &out).unwrap();
    let (columns, rows) = csv_table(&out.join("seams.csv"));
    let cell = |row: usize, name: &str| rows[row][columns.iter().position(|column| column == name).unwrap()].as_str();
    assert_eq!(
        (0..rows.len()).map(|row| [cell(row, "part"), cell(row, "t_s")]).collect::<Vec<_>>(),
        [["2", "2"], ["3", "5"], ["4", "7"]]
    );
    assert_eq!(cell(0, "changed"), "");
    let changed: Value = serde_json::from_str(cell(1, "changed")).unwrap();
    assert_eq!(changed, json!([{ "field": "display: distance_mm", "from": "300", "to": "310" }]));
    assert_eq!((cell(2, "wall"), cell(1, "program")), ("", "parafovea 0.1.0"));
    let (columns, rows) = csv_table(&out.join("sessions.csv"));
    let cell = |name: &str| rows[0][columns.iter().position(|column| column == name).unwrap()].as_str();
    assert_eq!(
        ["parts", "dropped_gaze_samples", "dropped_frames", "seed"].map(cell),
        ["4", "12", "3", "18446744073709551615"]
    );

    parquet_export::export(&tables, &folder.path().join("parquet")).unwrap();
    psych_ds::export(&tables, &folder.path().join("psych-ds")).unwrap();
    bids_of(&sessions, &folder.path().join("bids"), "bids-seams");
    let events = tsv(&folder.path().join("bids/sub-P1/beh/sub-P1_task-byhand_events.tsv"));
    let kinds: Vec<[&str; 2]> = events[1..].iter().map(|row| [row[0].as_str(), row[2].as_str()]).collect();
    assert_eq!(kinds, [["2", "resumed"], ["4", "log-gap"], ["5", "resumed"], ["7", "resumed"]]);
    let message = events[0].iter().position(|column| column == "message").unwrap();
    assert!(events[3][message].contains("changed display: distance_mm: 300 to 310"), "{events:?}");
    assert!(events[2][message].contains("12 gaze samples and 3 frames"), "{events:?}");
}
