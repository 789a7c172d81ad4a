//! Sessions of every protocol are summed up, reported and exported. The sessions are written by hand as records, so that
//! the numbers that must come out are known.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use analysis::answers::{Protocol, Summary};
use experiments::Display;
use experiments::session::event::Rules;
use experiments::session::record::{FormRecord, PhaseRecord, Record, TrialRecord};
use experiments::session::{Event, Stamped, Trial};
use experiments::trial::form::Entry;
use experiments::trial::{AbortReason, Alternative, Answer, Outcome, PhaseName};
use parafovea::export::csv::export;
use parafovea::results::{document, fit_sessions};
use parafovea::session::SessionFolder;
use parafovea::session::header::{DisplayRecord, FORMAT, Header, Program, StageRecord, StudyText, sha256_hex};
use parafovea::session::journal::Journal;
use parafovea::session::tables::{FrameRow, GazeRow, Layout};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn session(path: &Path, observer: &str, study: &Value, record: Record) -> SessionFolder {
    let text = study.to_string();
    let display = Display::named("guenter-2012").unwrap();
    std::fs::create_dir_all(path).unwrap();
    // Tables are read from the folder; these sessions have no rows in theirs.
    std::fs::write(path.join("gaze.csv"), Layout::<GazeRow>::new(FORMAT).1).unwrap();
    std::fs::write(path.join("frames.csv"), Layout::<FrameRow>::new(FORMAT).1).unwrap();
    let header = Header {
        format: FORMAT,
        observer: observer.to_owned(),
        started: String::new(),
        study: StudyText {
            name: "every-protocol".to_owned(),
            title: "Every protocol".to_owned(),
            file: String::new(),
            sha256: sha256_hex(text.as_bytes()),
            text,
        },
        files: Vec::new(),
        display: DisplayRecord::from(&display),
        assignment: Default::default(),
        seed: 1,
        generator: String::new(),
        gaze_source: Value::Null,
        simulated: None,
        stage: StageRecord {
            kind: "offscreen".to_owned(),
            rendered: false,
            frame_s: 0.01,
            pacing: "none".to_owned(),
            gpu: None,
        },
        program: Program::here(),
    };
    let opened =
        Stamped { seq: 0, t_s: 0.0, event: Event::Opened { header_sha256: String::new(), rules: Rules::NEWEST } };
    SessionFolder {
        path: PathBuf::from(path),
        header,
        display,
        study: serde_json::from_value(study.clone()).unwrap_or_default(),
        journal: Journal::in_memory(vec![opened]),
        record,
    }
}

fn answered(answer: Answer, correct: Option<bool>, found: &[(&str, f64)]) -> Outcome {
    let found = found.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    Outcome::Answered { answer, correct, found }
}

fn trial(block: &str, level: &[(&str, f64)], factors: &[(&str, &str)], outcome: Outcome) -> TrialRecord {
    let phase = |phase, began_s, shown, at: &[(&str, f64)]| PhaseRecord {
        phase,
        began_s,
        shown,
        at: at.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
    };
    TrialRecord {
        trial: Trial {
            trial: 0,
            block: block.to_owned(),
            practice: false,
            condition: "layers".to_owned(),
            factors: factors.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect(),
            level: level.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
            order: [Alternative::Reference, Alternative::Test],
            eccentricity_deg: None,
            mar_deg: None,
            repetition: Some(2),
            path_seed: None,
        },
        began_s: 0.0,
        ended_s: 3.0,
        outcome,
        response_time_s: Some(0.5),
        estimate: None,
        phases: vec![
            phase(PhaseName::Reference, 0.0, Some(Alternative::Reference), &[]),
            phase(PhaseName::Adjust, 1.0, Some(Alternative::Test), &[("quality_index", 4.0)]),
        ],
        part: 1,
    }
}

/// A pair block that is fooled from j = 16 on, a slider, and one Likert item; an aborted and a practice trial between.
fn record(shift: f64) -> Record {
    let mut trials = Vec::new();
    for j in [8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0] {
        for _ in 0..2 {
            let noticed = j < 15.0;
            let answer = if noticed { Answer::First } else { Answer::Same };
            trials.push(trial("pair", &[("quality_index", j)], &[], answered(answer, Some(noticed), &[])));
        }
    }
    trials.push(trial("pair", &[("quality_index", 8.0)], &[], Outcome::Aborted { reason: AbortReason::GazeLeft }));
    let mut practice = trial("pair", &[("quality_index", 22.0)], &[], answered(Answer::Same, Some(true), &[]));
    practice.trial.practice = true;
    trials.push(practice);
    for (motion, j) in [("pan", 12.0 + shift), ("orbit", 16.0 + shift)] {
        let found = [("quality_index", j), ("quality_index_settled", j), ("moves", 7.0)];
        let level = [("quality_index", 4.0)];
        trials.push(trial("slider", &level, &[("motion", motion)], answered(Answer::Continue, None, &found)));
    }
    for (region, value) in [("small", -2), ("full", 3)] {
        let outcome = answered(Answer::Option(value), None, &[("no_flicker", f64::from(value))]);
        trials.push(trial("likert", &[], &[("region", region)], outcome));
    }
    trials.iter_mut().zip(1..).for_each(|(record, number)| record.trial.trial = number);
    let entries =
        BTreeMap::from([("age".to_owned(), Entry::Number(31.0)), ("eyes".to_owned(), Entry::Text("good".into()))]);
    Record {
        trials,
        forms: vec![FormRecord { form: "participant".to_owned(), t_s: 1.5, entries }],
        finished: true,
        ..Record::default()
    }
}

fn study() -> Value {
    let block = |name: &str, kind: &str| json!({ "name": name, "protocol": { "kind": kind } });
    json!({ "blocks": [block("pair", "pair"), block("slider", "slider"), block("likert", "likert")] })
}

#[test]
fn two_observers_of_every_kind_of_answer() {
    let folder = tempfile::tempdir().unwrap();
    let sessions = [("P01", 0.0), ("P02", 2.0)]
        .map(|(observer, shift)| session(&folder.path().join(observer), observer, &study(), record(shift)));
    let results = fit_sessions(&sessions).unwrap();
    let first = &results[0];
    assert!(first.fit.is_none() && first.says_anything() && !first.pilot);
    let kinds: Vec<_> = first.blocks.iter().map(|block| (block.protocol.unwrap(), block.trials)).collect();
    assert_eq!(kinds, [(Protocol::Pair, 16), (Protocol::Slider, 2), (Protocol::Likert, 2)]);
    let Summary::Detection(detection) = &first.blocks[0].summary else { panic!("{first:?}") };
    let part = &detection.parts[0];
    assert_eq!((part.right.k, part.right.n, part.coarsest_unnoticed), (8, 16, Some(16.0)));
    // Always noticed up to 14, never from 16 on: half-way, by symmetry.
    assert!((part.fit.as_ref().unwrap().threshold.estimate - 15.0).abs() < 0.2);

    let analysis = document(&results);
    let slider = analysis.group.iter().find(|row| row.block == "slider" && row.by.is_empty()).unwrap();
    assert_eq!((slider.over_observers.n, slider.over_observers.mean), (2, 15.0));
    assert_eq!(analysis.observers[0].forms[0].entries["age"], Entry::Number(31.0));

    let report = folder.path().join("report.html");
    let together = parafovea::results::over_observers::over_observers(&results);
    let quality = parafovea::results::traces::quality(&sessions).unwrap();
    parafovea::report::write(&results, &together, &quality, &report).unwrap();
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(page.contains("Block slider") && page.contains("no_flicker") && !page.contains("MAR line"));
    let figures = folder.path().join("figures");
    parafovea::report::write_figures(&results, &figures).unwrap();
    for name in ["P01-pair-shares.svg", "P02-slider-quality_index.svg", "P01-likert-no_flicker.svg", "P01-gaze.svg"] {
        assert!(figures.join(name).exists(), "{name}");
    }
    assert!(!figures.join("P01-mar-line.svg").exists());
}

#[test]
fn an_export_has_a_column_for_every_factor_level_and_finding() {
    let folder = tempfile::tempdir().unwrap();
    let sessions = [session(&folder.path().join("P01"), "P01", &study(), record(0.0))];
    let out = folder.path().join("tables");
    export(&sessions, &fit_sessions(&sessions).unwrap(), &out).unwrap();
    let read = |file: &str| {
        let mut reader = csv::Reader::from_path(out.join(file)).unwrap();
        let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let rows: Vec<BTreeMap<String, String>> = reader
            .records()
            .map(|row| header.iter().cloned().zip(row.unwrap().iter().map(str::to_owned)).collect())
            .collect();
        (header, rows)
    };
    let dictionary: BTreeMap<String, Vec<Value>> =
        serde_json::from_slice(&std::fs::read(out.join("columns.json")).unwrap()).unwrap();
    for file in ["trials.csv", "phases.csv", "forms.csv"] {
        let described: Vec<&str> = dictionary[file].iter().map(|column| column["name"].as_str().unwrap()).collect();
        assert_eq!(read(file).0, described, "{file}");
    }
    let (_, trials) = read("trials.csv");
    assert_eq!(trials.len(), 22);
    let cell = |row: usize, column: &str| trials[row][column].as_str();
    assert_eq!([cell(0, "answer"), cell(0, "correct"), cell(0, "level_quality_index")], ["first", "1", "8"]);
    assert_eq!([cell(16, "outcome"), cell(16, "answer"), cell(16, "correct")], ["aborted", "", ""]);
    assert_eq!([cell(18, "answer"), cell(18, "correct"), cell(18, "factor_motion")], ["continue", "", "pan"]);
    assert_eq!([cell(18, "found_quality_index"), cell(18, "found_moves"), cell(18, "repetition")], ["12", "7", "2"]);
    assert_eq!([cell(20, "answer"), cell(20, "found_no_flicker"), cell(20, "factor_motion")], ["-2", "-2", ""]);
    let (_, phases) = read("phases.csv");
    assert_eq!(phases.len(), 2 * 22);
    assert_eq!([&phases[0]["ended_s"], &phases[0]["shown"], &phases[0]["at"]], ["1", "reference", ""]);
    assert_eq!([&phases[1]["phase"], &phases[1]["ended_s"]], ["adjust", "3"]);
    assert_eq!(phases[1]["at"], "{\"quality_index\":4.0}");
    let (_, forms) = read("forms.csv");
    assert_eq!([&forms[0]["item"], &forms[0]["entry"], &forms[1]["entry"]], ["age", "31", "good"]);
}

/// A study whose text no longer says how its blocks ask: the answers do.
#[test]
fn protocols_are_told_from_answers_where_the_study_does_not_say() {
    let folder = tempfile::tempdir().unwrap();
    let sessions = [session(&folder.path().join("P01"), "P01", &json!({}), record(0.0))];
    let results = fit_sessions(&sessions).unwrap();
    let kinds: Vec<Protocol> = results[0].blocks.iter().map(|block| block.protocol.unwrap()).collect();
    assert_eq!(kinds, [Protocol::Pair, Protocol::Slider, Protocol::Likert]);
}

/// A pair comparison about rings: its answers do not have the guess rate that the MAR fit takes for known.
#[test]
fn only_forced_choices_enter_the_mar_fit() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = record(0.0);
    for trial in &mut record.trials {
        (trial.trial.eccentricity_deg, trial.trial.mar_deg) = (Some(10.0), Some(0.3));
    }
    let sessions = [session(&folder.path().join("P01"), "P01", &study(), record)];
    assert!(fit_sessions(&sessions).unwrap()[0].fit.is_none());
}

#[test]
fn sessions_without_answers_fail_only_if_there_is_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let empty = || session(&folder.path().join("P02"), "P02", &study(), Record::default());
    let only = [empty()];
    let error = fit_sessions(&only).unwrap_err().to_string();
    assert!(error.contains("P02: the 0 answered trials cannot be fitted"), "{error}");
    let both = [empty(), session(&folder.path().join("P01"), "P01", &study(), record(0.0))];
    let results = fit_sessions(&both).unwrap();
    assert_eq!(results.iter().map(|result| result.says_anything()).collect::<Vec<_>>(), [true, false]);
}
