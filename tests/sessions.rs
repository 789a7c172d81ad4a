//! One session from its run to its tables: what is written, that the same seed writes the same, and that a replay shows
//! what the run showed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{TRUTH, contents, csv_table, run, session, small_study, write_json};
use parafovea::session::header::FORMAT;
use parafovea::session::tables::{GazeRow, Layout};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use tempfile::{TempDir, tempdir};

const GAZE: &str = "t_s,arrived_s,t_device_s,x_px,y_px,x_deg,y_deg,valid,pupil_mm,left_x_px,left_y_px,left_valid,\
    left_pupil_mm,right_x_px,right_y_px,right_valid,right_pupil_mm";
const FRAMES: &str = "index,phase_seq,trial,phase,scheduled_s,presented_s,missed,animation_s,gaze_row,gaze_age_s,\
    pixels_shaded,gpu_time_s,hash,target_x_deg,target_y_deg,signature";

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn lines(path: &Path) -> usize {
    read(path).iter().filter(|&&byte| byte == b'\n').count()
}

fn events(folder: &Path) -> Vec<Value> {
    let text = String::from_utf8(read(&folder.join("events.jsonl"))).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// A folder with a small study of eighteen levels in it.
fn with_study(repetitions: u32) -> TempDir {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", repetitions));
    folder
}

#[test]
fn a_run_writes_the_four_files_of_a_session() {
    let folder = with_study(1);
    let session = session(folder.path(), "study.json", "data", 7, &["--no-render"]);
    let name = session.file_name().unwrap().to_str().unwrap();
    assert!(name.starts_with("small_P01_2"), "{name}");
    let files: Vec<_> = contents(&session).into_keys().collect();
    assert_eq!(files, ["events.jsonl", "frames.csv", "gaze.csv", "session.json"].map(std::path::PathBuf::from));

    let header: Value = serde_json::from_slice(&read(&session.join("session.json"))).unwrap();
    let study = read(&folder.path().join("study.json"));
    assert_eq!(header["format"], FORMAT);
    assert_eq!(header["observer"], "P01");
    assert_eq!(header["seed"], 7);
    assert_eq!(header["study"]["text"].as_str().unwrap().as_bytes(), study);
    assert_eq!(header["study"]["sha256"], parafovea::session::header::sha256_hex(&study).as_str());
    assert_eq!(header["display"]["resolution_px"], json!([160, 90]));
    assert_eq!(header["simulated"]["truth"]["m"], 0.15);
    assert_eq!(header["stage"]["kind"], "offscreen");
    assert_eq!(header["stage"]["rendered"], false);
    assert_eq!(header["stage"]["gpu"], Value::Null);
    assert_eq!(header["gaze_source"]["id"], "simulated");
    assert_eq!(header["program"]["version"], env!("CARGO_PKG_VERSION"));
    assert!(header["generator"].as_str().unwrap().contains("ChaCha"), "{}", header["generator"]);

    let events = events(&session);
    for (number, event) in events.iter().enumerate() {
        assert_eq!(event["seq"], number);
        assert!(event["t_s"].is_f64() && event["event"].is_string());
        assert_eq!(event["crc"].as_str().unwrap().len(), 8);
    }
    assert_eq!(events.iter().filter(|event| event["event"] == "finished").count(), 1);
    assert_eq!(events.iter().filter(|event| event["event"] == "trial-ended").count(), 18);

    let (columns, gaze) = csv_table(&session.join("gaze.csv"));
    assert_eq!(columns.join(","), format!("{GAZE},crc"));
    let (columns, frames) = csv_table(&session.join("frames.csv"));
    assert_eq!(columns.join(","), format!("{FRAMES},crc"));
    assert!(gaze.len() > 100 && frames.len() > 100);
    for (number, frame) in frames.iter().enumerate() {
        assert_eq!(frame[0], number.to_string());
        assert!(frame[8].is_empty() || frame[8].parse::<usize>().unwrap() < gaze.len(), "{frame:?}");
        assert_eq!((frame[10].as_str(), frame[12].as_str()), ("", ""), "nothing was drawn");
    }
}

#[test]
fn the_same_seed_writes_the_same_bytes_and_another_seed_does_not() {
    let folder = with_study(1);
    let again = [("a", 11), ("b", 11), ("c", 12)]
        .map(|(data, seed)| session(folder.path(), "study.json", data, seed, &["--no-render"]));
    for file in ["events.jsonl", "gaze.csv", "frames.csv"] {
        let bytes = again.each_ref().map(|session| read(&session.join(file)));
        assert!(bytes[0] == bytes[1], "{file} differs between two runs of one seed");
        assert!(bytes[0] != bytes[2], "{file} is the same for two seeds");
    }
}

#[test]
fn a_recorded_gaze_is_played_back_sample_by_sample() {
    let folder = with_study(1);
    let first = session(folder.path(), "study.json", "a", 5, &["--no-render"]);
    std::fs::copy(first.join("gaze.csv"), folder.path().join("eyes.csv")).unwrap();
    let more = ["--no-render", "--gaze", "recorded:eyes.csv"];
    let second = session(folder.path(), "study.json", "b", 5, &more);
    let header: Value = serde_json::from_slice(&read(&second.join("session.json"))).unwrap();
    assert_eq!(header["gaze_source"]["id"], "recorded");
    let (recorded, played) = (csv_table(&first.join("gaze.csv")).1, csv_table(&second.join("gaze.csv")).1);
    assert!(played.len() > 100);
    for (recorded, played) in recorded.iter().zip(&played).take(played.len() - 5) {
        assert_eq!(recorded[3..8], played[3..8]);
    }
}

#[test]
fn an_analysis_has_the_documented_keys_and_recovers_what_the_observer_was() {
    let folder = with_study(12);
    let sessions = [3, 4].map(|seed| session(folder.path(), "study.json", &format!("{seed}"), seed, &["--no-render"]));
    let paths = sessions.each_ref().map(|session| session.to_str().unwrap());
    let before = contents(folder.path());
    let analysis = run(folder.path(), &["analyze", paths[0], paths[1], "--json"]).expect(0).json();
    assert!(contents(folder.path()) == before, "analyze writes nothing");

    let observer = &analysis["observers"][0];
    assert_eq!(analysis["observers"].as_array().unwrap().len(), 1);
    assert_eq!(observer["observer"], "P01");
    assert_eq!(observer["trials"], 2 * 12 * 18);
    for (quantity, truth) in [("m", 0.15), ("omega0", 0.35), ("width", 0.8), ("lapse", 0.02)] {
        let estimate = observer["mar"][quantity]["estimate"].as_f64().unwrap();
        let [low, high] = [0, 1].map(|end| observer["mar"][quantity]["ci95"][end].as_f64().unwrap());
        assert!(low < estimate && estimate < high, "{quantity}: {low} {estimate} {high}");
        assert!((low..=high).contains(&truth), "{quantity}: {low} – {high} misses {truth}");
    }
    assert_eq!(observer["mar"]["display_limited"], false);
    let thresholds = observer["thresholds"].as_array().unwrap();
    let eccentricities: Vec<f64> = thresholds.iter().map(|one| one["eccentricity_deg"].as_f64().unwrap()).collect();
    assert_eq!(eccentricities, [1.5, 3.0, 4.5]);
    for threshold in thresholds {
        let omega = threshold["mar_deg"].as_f64().unwrap();
        assert!((threshold["ci95"][0].as_f64().unwrap()..threshold["ci95"][1].as_f64().unwrap()).contains(&omega));
        assert_eq!(threshold["limited"], false);
        assert_eq!(threshold["trials"], 2 * 12 * 6);
    }
    assert_eq!(observer["support"]["supported"], true, "{observer}");

    let table = run(folder.path(), &["analyze", paths[0]]).expect(0).out;
    assert!(table.contains("omega0") && table.contains("95 % interval"), "{table}");
}

#[test]
fn a_report_is_one_page_that_loads_nothing() {
    let folder = with_study(6);
    let session = session(folder.path(), "study.json", "data", 3, &["--no-render"]);
    run(folder.path(), &["analyze", session.to_str().unwrap(), "--report", "report.html"]).expect(0);
    let page = String::from_utf8(read(&folder.path().join("report.html"))).unwrap();
    let lower = page.to_lowercase();
    assert!(lower.trim_start().starts_with("<!doctype html>") && lower.trim_end().ends_with("</html>"));
    assert!(page.matches("<svg").count() >= 4, "{} figures", page.matches("<svg").count());
    assert!(page.contains("P01") && page.contains("A study for tests"));
    for attribute in ["src=", "href=", "url(", "@import", "<script src", "<link"] {
        for (at, _) in lower.match_indices(attribute) {
            let target = lower[at + attribute.len()..].trim_start_matches(['"', '\'']);
            assert!(target.starts_with(['#']) || target.starts_with("data:"), "{}", &target[..target.len().min(60)]);
        }
    }
}

#[test]
fn an_export_holds_every_row_and_describes_every_column() {
    let folder = with_study(3);
    let sessions = [4, 5].map(|seed| session(folder.path(), "study.json", &format!("{seed}"), seed, &["--no-render"]));
    let paths = sessions.each_ref().map(|session| session.to_str().unwrap());
    let arguments = ["export", paths[0], paths[1], "--format", "csv", "--out", "tables"];
    let ran = run(folder.path(), &arguments).expect(0);

    let tables = folder.path().join("tables");
    let dictionary: BTreeMap<String, Vec<Value>> = serde_json::from_slice(&read(&tables.join("columns.json"))).unwrap();
    let rows = |file: &str| sessions.iter().map(|session| lines(&session.join(file)) - 1).sum::<usize>();
    let expected = [
        ("sessions.csv", 2),
        ("seams.csv", 0),
        ("trials.csv", 2 * 3 * 18),
        ("phases.csv", 2 * 3 * 18 * 5),
        ("forms.csv", 0),
        ("gaze.csv", rows("gaze.csv")),
        ("frames.csv", rows("frames.csv")),
        ("thresholds.csv", 3),
        ("fits.csv", 4),
    ];
    assert_eq!(dictionary.len(), expected.len());
    for (file, count) in expected {
        let (columns, table) = csv_table(&tables.join(file));
        let described: Vec<&str> = dictionary[file].iter().map(|column| column["name"].as_str().unwrap()).collect();
        assert_eq!(columns, described, "{file}");
        assert!(dictionary[file].iter().all(|column| !column["meaning"].as_str().unwrap().is_empty()), "{file}");
        assert_eq!(table.len(), count, "{file}");
        assert!(ran.out.contains(&format!("{file} ({count} rows)")), "{}", ran.out);
    }
    let (columns, trials) = csv_table(&tables.join("trials.csv"));
    let column = |name: &str| columns.iter().position(|column| column == name).unwrap();
    for trial in &trials {
        let named_test = (trial[column("answer")] == "first") == (trial[column("test_interval")] == "1");
        assert_eq!(trial[column("correct")], u8::from(named_test).to_string(), "{trial:?}");
        assert_eq!(trial[column("practice")], "0");
    }

    // The second export finds the folder occupied and leaves it as it is.
    let before = contents(folder.path());
    let refused = run(folder.path(), &arguments).expect(2);
    assert!(refused.err.contains("new or empty folder"), "{}", refused.err);
    assert!(contents(folder.path()) == before);
}

/// A session with pictures: two trials at a coarse limit.
fn rendered(folder: &Path) -> std::path::PathBuf {
    let mut study = small_study("small", 1);
    study["blocks"][0]["procedure"]["levels"] = json!({ "eccentricity_deg": [2.5, 4], "mar_deg": [1.6] });
    write_json(folder, "rendered.json", &study);
    session(folder, "rendered.json", "data", 9, &[])
}

#[test]
fn a_replay_draws_what_the_run_showed_and_notices_a_changed_log() {
    let folder = tempdir().unwrap();
    let session = rendered(folder.path());
    let path = session.to_str().unwrap();
    let (_, frames) = csv_table(&session.join("frames.csv"));
    assert!(frames.iter().all(|frame| frame[12].len() == 16), "every frame has its hash");

    let verified = run(folder.path(), &["replay", path, "--verify", "--json"]).expect(0).json();
    assert_eq!(verified["hashes_compared"], frames.len());
    assert_eq!(verified["hashes_different"], 0);
    assert_eq!(verified["first_different"], Value::Null);

    let arguments = ["replay", path, "--frames", "pictures", "--trial", "2", "--stimuli", "--limit", "3"];
    run(folder.path(), &arguments).expect(0);
    let pictures = contents(&folder.path().join("pictures"));
    assert_eq!(pictures.len(), 3, "{:?}", pictures.keys());
    for file in pictures.keys() {
        let picture = image::open(folder.path().join("pictures").join(file)).unwrap().to_rgba8();
        assert_eq!(picture.dimensions(), (160, 90));
        let index: usize = file.to_str().unwrap()["frame-".len()..][..6].parse().unwrap();
        assert_eq!(frames[index][2], "2");
        let hash = format!("{:016x}", xxhash_rust::xxh3::xxh3_64(picture.as_raw()));
        assert_eq!(frames[index][12], hash, "{}", file.display());
    }

    // One sample that placed the ring, moved by two degrees.
    let began = events(&session).into_iter().find(|event| event["event"] == "trial-began").unwrap();
    let test_interval = if began["order"][0] == "test" { "interval1" } else { "interval2" };
    let used = frames.iter().find(|frame| frame[2] == "1" && frame[3] == test_interval).unwrap();
    let mut rows = parafovea::session::SessionFolder::open(&session).unwrap().gaze().unwrap().rows;
    rows[used[8].parse::<usize>().unwrap()].x_deg += 2.0;
    let (mut layout, mut changed) = Layout::<GazeRow>::new(FORMAT);
    rows.iter().for_each(|row| changed += &layout.line(row));
    // With its CRCs made right again only the pictures can tell; without, the table itself does.
    let sealed = String::from_utf8(read(&session.join("gaze.csv"))).unwrap();
    let line = used[8].parse::<usize>().unwrap() + 1;
    let unsealed = sealed.lines().enumerate().map(|(number, text)| {
        let crc = text.rsplit(',').next().unwrap();
        let wrong = if number == line { "1" } else { crc };
        format!("{},{wrong}\n", &text[..text.len() - crc.len() - 1])
    });
    std::fs::write(session.join("gaze.csv"), unsealed.collect::<String>()).unwrap();
    let failed = run(folder.path(), &["replay", path, "--verify"]).expect(1);
    assert!(failed.err.contains(&format!("gaze.csv: line {}", line + 1)), "{}", failed.err);
    std::fs::write(session.join("gaze.csv"), changed).unwrap();
    let failed = run(folder.path(), &["replay", path, "--verify", "--json"]).expect(1);
    assert!(failed.json()["hashes_different"].as_u64().unwrap() >= 1);
    assert_eq!(failed.json()["first_different"].to_string(), used[0]);
    assert!(failed.err.contains(&format!("first frame {}", used[0])), "{}", failed.err);
}

#[test]
fn a_run_without_pictures_has_nothing_to_verify_and_says_so() {
    let folder = with_study(1);
    let session = session(folder.path(), "study.json", "data", 7, &["--no-render"]);
    let ran = run(folder.path(), &["replay", session.to_str().unwrap(), "--verify"]).expect(1);
    assert!(ran.err.contains("--no-render"), "{}", ran.err);
}

/// Sessions of the first format, written by a program of that time, are read, exported, replayed and gone on with.
#[test]
fn sessions_of_the_first_format_are_still_good() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/sessions/format-1");
    let folder = tempdir().unwrap();
    for (name, trials, state) in [("finished", 4, "complete"), ("torn", 2, "unfinished"), ("resumed", 5, "complete")] {
        let copy = folder.path().join("data").join(name);
        common::copy_folder(&fixtures.join(name), &copy);
        let path = format!("data/{name}");
        let seen = run(folder.path(), &["doctor", &path, "--json"]).expect(0).json();
        assert_eq!((seen[0]["state"].as_str(), seen[0]["format"].as_u64()), (Some(state), Some(1)), "{seen}");
        assert_eq!(seen[0]["counts"]["trials"], trials, "{seen}");
        let verified = run(folder.path(), &["replay", &path, "--verify", "--json"]).expect(0).json();
        assert!(verified["hashes_compared"].as_u64().unwrap() > 30, "{verified}");
        let tables = format!("tables-{name}");
        run(folder.path(), &["export", &path, "--format", "csv", "--out", &tables]).expect(0);
        assert_eq!(csv_table(&folder.path().join(tables).join("trials.csv")).1.len(), trials);
    }
    // The torn one goes on, in its own format, to its end.
    std::fs::remove_dir_all(folder.path().join("data/finished")).unwrap();
    std::fs::remove_dir_all(folder.path().join("data/resumed")).unwrap();
    for file in ["study.json", "gaze20.csv"] {
        std::fs::copy(fixtures.with_file_name(file), folder.path().join(file)).unwrap();
    }
    let arguments = ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", "omega0=0.021,m=0.022"];
    run(folder.path(), &[&arguments[..], &["--gaze", "recorded:gaze20.csv", "--resume"]].concat()).expect(0);
    let seen = run(folder.path(), &["doctor", "data/torn", "--json"]).expect(0).json();
    assert_eq!((seen[0]["state"].as_str(), seen[0]["format"].as_u64()), (Some("complete"), Some(1)), "{seen}");
    assert_eq!(seen[0]["counts"]["parts"], 2);
    run(folder.path(), &["replay", "data/torn", "--verify"]).expect(0);
}

/// A run that stops in the middle, as after a kill.
fn unfinished(folder: &Path) -> std::path::PathBuf {
    let path = session(folder, "study.json", "data", 5, &["--no-render"]);
    let events = String::from_utf8(read(&path.join("events.jsonl"))).unwrap();
    let trial = events.match_indices("\"event\":\"trial-began\"").nth(4).unwrap().0;
    let line = events[..trial].rfind('\n').unwrap();
    std::fs::write(path.join("events.jsonl"), &events[..line + 1]).unwrap();
    path
}

/// What was run with one study or display goes on with another only when somebody insists, and says so for ever.
#[test]
fn a_changed_study_or_display_is_refused_with_the_difference_or_forced_and_marked() {
    let folder = tempdir().unwrap();
    let mut study = small_study("small", 1);
    write_json(folder.path(), "study.json", &study);
    let path = unfinished(folder.path());
    let resume = |more: &[&str]| {
        let arguments = ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--no-render"];
        run(folder.path(), &[&arguments[..], &["--resume"], more].concat())
    };

    study["blocks"][0]["protocol"]["interval_s"] = json!(0.2);
    study["display"]["distance_mm"] = json!(320);
    write_json(folder.path(), "study.json", &study);
    let before = contents(folder.path());
    let refused = resume(&[]).expect(2);
    for says in ["blocks[0].protocol.interval_s: 0.1, now 0.2", "display: distance_mm: ", "now 320", "--force"] {
        assert!(refused.err.contains(says), "{says}: {refused:#?}");
    }
    assert!(contents(folder.path()) == before, "a refusal changes nothing");

    // What concerns trials that were run already cannot be forced.
    let mut other = study.clone();
    other["blocks"][0]["procedure"]["levels"]["mar_deg"] = json!([0.5, 0.9]);
    write_json(folder.path(), "study.json", &other);
    let refused = resume(&["--force"]).expect(2);
    assert!(refused.err.contains("concerns what was run already"), "{refused:#?}");
    assert!(!refused.err.contains("panicked"));

    write_json(folder.path(), "study.json", &study);
    resume(&["--force"]).expect(0);
    let seen = run(folder.path(), &["doctor", path.to_str().unwrap(), "--json"]).expect(0).json();
    assert_eq!(seen[0]["state"], "complete", "{seen}");
    assert!(seen[0]["findings"].to_string().contains("blocks[0].protocol.interval_s"), "{seen}");
    let session = parafovea::session::SessionFolder::open(&path).unwrap();
    let seam = &session.record.seams[0].seam;
    assert!(seam.changed.iter().any(|change| change.field == "study: blocks[0].protocol.interval_s"));
    assert!(seam.study.is_some() && seam.display.is_some());

    // A session that is over has nothing to go on with.
    let refused = resume(&[]).expect(2);
    assert!(refused.err.contains("is over") && refused.err.contains("--fresh"), "{refused:#?}");
}

/// A repaired copy ends where the original is sound, can be analysed, and goes on to its end.
#[test]
fn a_damaged_session_is_repaired_in_a_copy_that_goes_on() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 1));
    let path = session(folder.path(), "study.json", "data", 5, &["--no-render"]);
    let mut events = read(&path.join("events.jsonl"));
    let middle = events.len() / 2;
    events[middle] ^= 1;
    std::fs::write(path.join("events.jsonl"), &events).unwrap();
    let before = contents(&path);
    let damaged = run(folder.path(), &["doctor", path.to_str().unwrap()]).expect(1);
    assert!(damaged.out.contains("damage: events.jsonl: line "), "{damaged:#?}");
    run(folder.path(), &["doctor", path.to_str().unwrap(), "--repair"]).expect(0);
    assert!(contents(&path) == before, "the original stays as it is");
    let copy = path.with_file_name(format!("{}-repaired", path.file_name().unwrap().to_str().unwrap()));
    let seen = run(folder.path(), &["doctor", copy.to_str().unwrap(), "--json"]).expect(0).json();
    assert_eq!(seen[0]["state"], "unfinished", "{seen}");
    let arguments = ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--no-render"];
    run(folder.path(), &[&arguments[..], &["--resume"]].concat()).expect(0);
    let seen = run(folder.path(), &["doctor", copy.to_str().unwrap(), "--json"]).expect(0).json();
    assert_eq!(seen[0]["state"], "complete", "{seen}");
    assert!(seen[0]["findings"].to_string().contains("repaired copy"), "{seen}");
    run(folder.path(), &["analyze", copy.to_str().unwrap()]).expect(0);
    let again = run(folder.path(), &["doctor", path.to_str().unwrap(), "--repair"]).expect(2);
    assert!(again.err.contains("does not exist yet"), "{again:#?}");
}
