//! Truncated, corrupted and empty sessions: whoever analyses one gets one clear message or a result with a notice, never
//! a panic, and finds every file as it was.
//!
//! Where the damage falls is random; the seed is printed, and `PARAFOVEA_TEST_SEED` sets it.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{Ran, TRUTH, contents, copy_folder, csv_table, random, run, session, small_study, write_json};
use parafovea::doctor::{State, examine};
use parafovea::session::SessionFolder;
use parafovea::session::header::FORMAT;
use parafovea::session::journal;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tempfile::{TempDir, tempdir};

/// A sound session of 108 trials below a folder that also holds its study.
fn sound() -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 6));
    let session = session(folder.path(), "study.json", "data", 17, &["--no-render"]);
    (folder, session)
}

/// A copy of a session with one file replaced.
fn with_file(sound: &Path, folder: &Path, file: &str, bytes: &[u8]) -> PathBuf {
    let damaged = folder.join("damaged");
    if damaged.exists() {
        std::fs::remove_dir_all(&damaged).unwrap();
    }
    copy_folder(sound, &damaged);
    std::fs::write(damaged.join(file), bytes).unwrap();
    damaged
}

/// Analyses a session, which must not panic and must leave every file as it was.
fn analyze(folder: &Path, session: &Path) -> Ran {
    let before = contents(session);
    let ran = run(folder, &["analyze", session.to_str().unwrap(), "--json"]);
    assert!(contents(session) == before, "analyze changes nothing");
    assert!(!ran.err.contains("panicked"), "{ran:#?}");
    assert!(!ran.err.contains("RUST_BACKTRACE"), "{ran:#?}");
    match ran.code {
        0 => assert!(ran.json()["observers"].is_array()),
        // Sound as far as it goes, with too few answers left for a fit.
        1 => assert!(ran.out.is_empty() && ran.err.contains("cannot be fitted"), "{ran:#?}"),
        2 => assert!(ran.out.is_empty() && ran.err.lines().count() == 1, "{ran:#?}"),
        other => panic!("exit code {other}: {ran:#?}"),
    }
    ran
}

fn lines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}

fn ended_trials(bytes: &[u8]) -> usize {
    let text = String::from_utf8_lossy(bytes);
    text.lines().filter(|line| line.contains("\"event\":\"trial-ended\"") && line.ends_with("\"}")).count()
}

#[test]
fn a_session_truncated_anywhere_is_read_up_to_there() {
    let (folder, sound) = sound();
    let events = std::fs::read(sound.join("events.jsonl")).unwrap();
    let mut random = random();
    for attempt in 0..50 {
        // The first few lines are hit more often than by chance.
        let most = if attempt % 5 == 0 { 2_000 } else { events.len() };
        let cut = random.random_range(1..most);
        let damaged = with_file(&sound, folder.path(), "events.jsonl", &events[..cut]);
        let ran = analyze(folder.path(), &damaged);
        let whole = lines(&events[..cut]);
        let torn = events[cut - 1] != b'\n';
        assert_eq!(ran.code == 2, whole == 0, "cut at {cut}: {ran:#?}");
        assert_eq!(ran.err.contains("torn, as after a kill"), torn, "cut at {cut}: {ran:#?}");
        assert_eq!(ran.err.contains(&format!("line {}", whole + 1)), torn, "cut at {cut}: {ran:#?}");
        if ran.code == 0 {
            // The small study's trials are all answered.
            let trials = journal::read(&events[..cut], FORMAT).events.len();
            assert!(trials > 0);
            assert_eq!(ran.json()["observers"][0]["trials"], ended_trials(&events[..cut]), "cut at {cut}");
        }

        // The other tables go along with it.
        if attempt % 10 == 1 && whole > 0 {
            let before = contents(&damaged);
            let exported =
                run(folder.path(), &["export", "damaged", "--format", "csv", "--out", &format!("tables-{attempt}")]);
            let exported = exported.expect(0);
            let (_, trials) = csv_table(&folder.path().join(format!("tables-{attempt}/trials.csv")));
            assert_eq!(trials.len(), ended_trials(&events[..cut]), "{}", exported.err);
            assert!(contents(&damaged) == before);
        }
    }
}

#[test]
fn a_changed_bit_in_the_journal_is_found_and_its_line_named() {
    let (folder, sound) = sound();
    let events = std::fs::read(sound.join("events.jsonl")).unwrap();
    let mut random = random();
    for attempt in 0..40 {
        let most = if attempt % 5 == 0 { 2_000 } else { events.len() };
        let (at, bit) = (random.random_range(0..most), random.random_range(0..8));
        let mut changed = events.clone();
        changed[at] ^= 1 << bit;
        let damaged = with_file(&sound, folder.path(), "events.jsonl", &changed);
        let ran = analyze(folder.path(), &damaged);
        let line = lines(&events[..at]) + 1;
        assert!(ran.err.contains(&format!("line {line}")), "byte {at} bit {bit}, line {line}: {ran:#?}");
        assert!(ran.err.contains("events.jsonl"), "{ran:#?}");
        assert_eq!(ran.code == 2, line == 1, "{ran:#?}");
        if ran.code == 0 {
            let sound_part: usize = events.split_inclusive(|&byte| byte == b'\n').take(line - 1).map(<[u8]>::len).sum();
            assert_eq!(ran.json()["observers"][0]["trials"], ended_trials(&events[..sound_part]));
        }
    }
}

#[test]
fn a_changed_header_is_refused() {
    let (folder, sound) = sound();
    let header = std::fs::read(sound.join("session.json")).unwrap();
    let text_at = header.windows(8).position(|window| window == b"\"text\": ").unwrap() + 9;
    let text_end = text_at + header[text_at..].iter().position(|&byte| byte == b'\n').unwrap() - 1;
    let mut random = random();
    for attempt in 0..40 {
        let at = match attempt % 2 {
            0 => random.random_range(text_at..text_end),
            _ => random.random_range(0..header.len()),
        };
        let mut changed = header.clone();
        changed[at] ^= 1 << random.random_range(0..8);
        let damaged = with_file(&sound, folder.path(), "session.json", &changed);
        let ran = analyze(folder.path(), &damaged);
        assert!(ran.code == 2 && ran.err.contains("session.json"), "byte {at} was changed unnoticed: {ran:#?}");
    }
}

#[test]
fn empty_and_missing_files_give_one_message_each() {
    let (folder, sound) = sound();
    for (file, says) in [("session.json", "expected a session header"), ("events.jsonl", "it is empty")] {
        let ran = analyze(folder.path(), &with_file(&sound, folder.path(), file, b""));
        assert_eq!(ran.code, 2, "{ran:#?}");
        assert!(ran.err.contains(file) && ran.err.contains(says), "{ran:#?}");

        let damaged = with_file(&sound, folder.path(), file, b"");
        std::fs::remove_file(damaged.join(file)).unwrap();
        let ran = analyze(folder.path(), &damaged);
        assert_eq!(ran.code, 2, "{ran:#?}");
        assert!(ran.err.contains(file), "{ran:#?}");
    }
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    let ran = analyze(folder.path(), &empty);
    assert!(ran.code == 2 && ran.err.contains("session.json"), "{ran:#?}");
    for command in [
        ["analyze", "study.json"].as_slice(),
        &["replay", "study.json", "--verify"],
        &["export", "study.json", "--format", "csv", "--out", "tables"],
    ] {
        let ran = run(folder.path(), command).expect(2);
        assert!(ran.err.contains("study.json: expected a session's folder"), "{ran:#?}");
    }
    // A fit needs neither gaze nor frames.
    for file in ["gaze.csv", "frames.csv"] {
        let damaged = with_file(&sound, folder.path(), file, b"");
        assert_eq!(analyze(folder.path(), &damaged).code, 0);
        std::fs::remove_file(damaged.join(file)).unwrap();
        assert_eq!(analyze(folder.path(), &damaged).code, 0);
        for arguments in [
            ["analyze", "damaged", "--report", "report.html"].as_slice(),
            &["export", "damaged", "--format", "csv", "--out", "tables"],
        ] {
            let before = contents(folder.path());
            let ran = run(folder.path(), arguments).expect(2);
            assert!(ran.err.contains(file), "{ran:#?}");
            assert!(contents(folder.path()) == before, "{arguments:?} left something behind");
        }
    }
}

#[test]
fn damaged_tables_never_make_a_command_panic() {
    let (folder, sound) = sound();
    let mut random = random();
    for attempt in 0..12 {
        let file = ["gaze.csv", "frames.csv"][attempt % 2];
        let mut bytes = std::fs::read(sound.join(file)).unwrap();
        if attempt % 3 == 0 {
            bytes.truncate(random.random_range(0..bytes.len()));
        } else {
            let at = random.random_range(0..bytes.len());
            bytes[at] ^= 1 << random.random_range(0..8);
        }
        let damaged = with_file(&sound, folder.path(), file, &bytes);
        let before = contents(&damaged);
        for arguments in [
            ["analyze", "damaged", "--report", "report.html"].as_slice(),
            &["export", "damaged", "--format", "csv", "--out", &format!("tables-{attempt}")],
            &["replay", "damaged", "--verify"],
        ] {
            let ran = run(folder.path(), arguments);
            assert!((0..=2).contains(&ran.code) && !ran.err.contains("panicked"), "{arguments:?}: {ran:#?}");
            assert!(ran.code == 0 || !ran.err.trim().is_empty());
        }
        assert!(contents(&damaged) == before);
    }
}

#[test]
fn a_corrupt_session_does_not_go_on_and_stays_as_it_is() {
    let (folder, sound) = sound();
    let path = sound.join("events.jsonl");
    let mut events = std::fs::read(&path).unwrap();
    let middle = events.len() / 2;
    events[middle] ^= 1;
    std::fs::write(&path, &events).unwrap();
    let before = contents(folder.path());
    let arguments = ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--no-render"];
    let ran = run(folder.path(), &[&arguments[..], &["--resume"]].concat()).expect(2);
    assert!(ran.err.contains("A damaged session can be analysed up to there, but not go on"), "{ran:#?}");
    assert!(ran.err.contains(&format!("line {}", lines(&events[..middle]) + 1)), "{ran:#?}");
    assert!(contents(folder.path()) == before);
}

/// Ten thousand times a session's files are damaged at random: bytes changed, files cut, lines swapped, left out and
/// doubled. The doctor finds each, and all that stood before the damage is there.
#[test]
fn every_damage_is_found_and_everything_before_it_is_kept() {
    const CASES: u64 = 10_000;
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 1));
    let sound = session(folder.path(), "study.json", "data", 17, &["--no-render", "--gaze", "simulated:rate_hz=60"]);
    assert_eq!(examine(&sound).unwrap().state, State::Complete);
    let whole = SessionFolder::open(&sound).unwrap();
    let (gaze, frames) = (whole.gaze().unwrap().rows, whole.frames().unwrap().rows);
    let files: Vec<(&str, Vec<u8>)> = ["session.json", "events.jsonl", "gaze.csv", "frames.csv"]
        .map(|name| (name, std::fs::read(sound.join(name)).unwrap()))
        .into();
    let seed: u64 = random().random();
    println!("seed {seed}");
    let counts = (0..CASES)
        .into_par_iter()
        .map_init(
            || tempdir().unwrap(),
            |copy, case| {
                let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_add(case));
                let (name, bytes) = &files[random.random_range(0..files.len())];
                let (kind, damaged, at) = damaged(bytes, &mut random);
                for (file, bytes) in &files {
                    std::fs::write(copy.path().join(file), if file == name { &damaged } else { bytes }).unwrap();
                }
                let what = format!("case {case}: {kind} in {name} from byte {at}");
                let diagnosis = examine(copy.path()).unwrap();
                assert_ne!(diagnosis.state, State::Complete, "{what}: {diagnosis:#?}");
                let before = lines(&bytes[..at]);
                match SessionFolder::open(copy.path()) {
                    // Without a header nothing can be said, nor without the event that the journal begins with.
                    Err(_) => assert!(*name == "session.json" || (*name == "events.jsonl" && before == 0), "{what}"),
                    Ok(session) => match *name {
                        "gaze.csv" => kept(&session.gaze().unwrap().rows, &gaze, before, &what),
                        "frames.csv" => kept(&session.frames().unwrap().rows, &frames, before, &what),
                        _ => kept(&session.journal.events, &whole.journal.events, before + 1, &what),
                    },
                }
                (kind, usize::from(diagnosis.state == State::Damaged))
            },
        )
        .fold(BTreeMap::new, |mut counts: BTreeMap<&str, (u32, usize)>, (kind, damaged)| {
            let count = counts.entry(kind).or_default();
            *count = (count.0 + 1, count.1 + damaged);
            counts
        })
        .reduce(BTreeMap::new, |mut all, some| {
            for (kind, (cases, damaged)) in some {
                let count = all.entry(kind).or_default();
                *count = (count.0 + cases, count.1 + damaged);
            }
            all
        });
    for (kind, (cases, damaged)) in &counts {
        println!("{kind}: {cases} cases, all found; {damaged} called damaged, the rest ended early or without header");
    }
    assert_eq!(counts.values().map(|count| u64::from(count.0)).sum::<u64>(), CASES);
}

/// Rows that stood whole before the damage; `lines` counts the first line too.
fn kept<T: PartialEq + std::fmt::Debug>(found: &[T], sound: &[T], lines: usize, what: &str) {
    let rows = lines.saturating_sub(1);
    assert!(found.len() >= rows, "{what}: {} of {rows} rows are left", found.len());
    assert!(found.iter().zip(sound).take(rows).all(|(a, b)| a == b), "{what}");
}

/// Damages a file; says how, and from which byte on it is not what it was.
fn damaged(bytes: &[u8], random: &mut ChaCha8Rng) -> (&'static str, Vec<u8>, usize) {
    let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let start = |line: usize| lines[..line].iter().map(|line| line.len()).sum::<usize>();
    let mut changed = bytes.to_vec();
    match random.random_range(0..6) {
        0 => {
            let at = random.random_range(0..bytes.len());
            changed[at] ^= 1 << random.random_range(0..8);
            ("flipped bit", changed, at)
        }
        1 => {
            let at = random.random_range(0..bytes.len());
            changed[at] = changed[at].wrapping_add(random.random_range(1..=255));
            ("changed byte", changed, at)
        }
        2 => {
            let at = random.random_range(0..bytes.len());
            ("cut", bytes[..at].to_vec(), at)
        }
        3 => {
            // Lines that are the same change nothing when they are swapped.
            let (a, b) = loop {
                let (a, b) = (random.random_range(0..lines.len()), random.random_range(0..lines.len()));
                if lines[a] != lines[b] {
                    break (a.min(b), a.max(b));
                }
            };
            let mut order = lines.clone();
            order.swap(a, b);
            ("swapped lines", order.concat(), start(a))
        }
        4 => {
            let at = random.random_range(0..lines.len());
            let mut rest = lines.clone();
            rest.remove(at);
            ("line left out", rest.concat(), start(at))
        }
        _ => {
            let at = random.random_range(0..lines.len());
            let mut more = lines.clone();
            more.insert(at, lines[at]);
            ("line doubled", more.concat(), start(at + 1))
        }
    }
}
