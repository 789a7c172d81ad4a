//! The program is killed with SIGKILL at random moments of a run. Whatever was acknowledged must be there afterwards, and
//! a session that goes on must end as if nothing had happened but one repeated trial.
//!
//! Every moment is random; the seed is printed, and `PARAFOVEA_TEST_SEED` sets it.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{TRUTH, contents, copy_folder, only_entry, program, random, run, session, small_study, write_json};
use experiments::session::record::TrialRecord;
use experiments::session::refold::refold;
use experiments::session::{Event, Stamped, Trial};
use experiments::study::parse_study;
use experiments::trial::{Input, Outcome, PhaseName};
use parafovea::doctor::{State, examine};
use parafovea::session::SessionFolder;
use parafovea::session::header::FORMAT;
use parafovea::session::journal::{self, Damage, Journal};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::tempdir;

/// Starts a run of `study.json` in `folder` as a process of its own.
fn start(folder: &Path, more: &[&str]) -> Child {
    let arguments =
        ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--no-render", "--data", "data"];
    program(folder).args(arguments).args(more).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Waits until the journal below `data` is larger than `bytes`, or the process has ended. Returns the session's folder.
fn wait_for_journal(data: &Path, bytes: u64, child: &mut Child) -> PathBuf {
    let began = Instant::now();
    loop {
        let session = visible(data).into_iter().next();
        let size = session.as_ref().and_then(|path| Some(path.join("events.jsonl").metadata().ok()?.len()));
        if size.is_some_and(|size| size > bytes) || child.try_wait().unwrap().is_some() {
            return session.unwrap();
        }
        assert!(began.elapsed() < Duration::from_secs(60), "no journal of {bytes} bytes after a minute");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn kill(mut child: Child) {
    // SIGKILL; a process that has ended already needs none.
    let _ = child.kill();
    child.wait().unwrap();
}

fn is_answered(trial: &TrialRecord) -> bool {
    matches!(trial.outcome, Outcome::Answered { .. })
}

/// Trials that the running program was told are on disk.
fn acknowledged(events: &[Stamped]) -> usize {
    let saved = |event: &&Stamped| matches!(event.event, Event::Input { input: Input::Saved, accepted: true });
    events.iter().filter(saved).count()
}

/// Frames refer to phases and gaze samples; holds every reference against the journal and the gaze table.
fn check_tables(session: &SessionFolder) {
    let began: BTreeMap<u64, (Option<u32>, PhaseName)> = session
        .journal
        .events
        .iter()
        .filter_map(|stamped| match stamped.event {
            Event::PhaseBegan { trial, phase, .. } => Some((stamped.seq, (trial, phase))),
            _ => None,
        })
        .collect();
    let (gaze, frames) = (session.gaze().unwrap(), session.frames().unwrap());
    assert!(gaze.rows.is_sorted_by(|a, b| a.t_s < b.t_s), "gaze samples come in the order of time, each once");
    assert!(frames.rows.is_sorted_by(|a, b| a.scheduled_s < b.scheduled_s), "so do frames");
    for (number, frame) in frames.rows.iter().enumerate() {
        assert_eq!(frame.index, number as u64);
        assert_eq!(began.get(&frame.phase_seq), Some(&(frame.trial, frame.phase)), "{frame:?}");
        if let (Some(row), Some(age_s)) = (frame.gaze_row, frame.gaze_age_s) {
            let sample = &gaze.rows[usize::try_from(row).unwrap()];
            assert!((frame.scheduled_s - age_s - sample.t_s).abs() < 1e-9, "{frame:?} {sample:?}");
        }
    }
}

/// Folds the journal from its first event, so that each event is what the study and the seed give there.
fn check_journal(session: &SessionFolder) {
    // A kill may have torn the very last line, which says that the log is closed.
    let torn = matches!(session.journal.damage, Some(Damage::TornTail { .. })) && !session.is_closed();
    assert!(session.journal.damage.is_none() || torn, "{:?}", session.journal.damage);
    let text = &session.header.study.text;
    let plan = parse_study("study", text, &stimuli::registry::catalogue(), Some(&session.display)).unwrap();
    let refolded = refold(Arc::new(plan), session.header.seed, &session.journal.events, |_, _| ()).unwrap();
    assert!(refolded.missing.is_empty());
    assert_eq!(refolded.session.finished(), session.record.finished);
}

/// Each of the eighteen levels has been answered `repetitions` times.
fn check_design(session: &SessionFolder, repetitions: usize) {
    let mut answered: BTreeMap<String, usize> = BTreeMap::new();
    for trial in session.record.trials.iter().filter(|trial| is_answered(trial)) {
        *answered.entry(format!("{:?}", trial.trial.level)).or_default() += 1;
    }
    assert_eq!(answered.len(), 18);
    assert!(answered.values().all(|&count| count == repetitions), "{answered:?}");
}

/// What one process told of its session before it was killed, or ended.
struct Witness {
    /// Completed trials that it said are on disk, since it began.
    acknowledged: usize,
    finished: bool,
    /// Whether it ended by the signal; an injected error may also make it give up by itself.
    killed: bool,
}

/// Runs a process on a disk that fails, and kills it: at one operation of the disk, or at a time.
fn run_and_kill(folder: &Path, more: &[&str], random: &mut ChaCha8Rng) -> Witness {
    let mut faults = format!("seed={}", random.random_range(0..1_000_000));
    let share = |random: &mut ChaCha8Rng| ["0", "0.01", "0.05", "0.2"][random.random_range(0..4)];
    faults += &format!(",short={}", share(random));
    faults += &format!(",no-space={}", share(random));
    // Every twentieth operation at most: with more, no trial would ever end.
    faults += &format!(",device-error={}", ["0", "0.01", "0.05"][random.random_range(0..3)]);
    let by_operation = random.random_bool(0.6);
    if by_operation {
        faults += &format!(",kill-at={}", random.random_range(1..220));
    }
    let arguments =
        ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--no-render", "--data", "data"];
    let mut child = program(folder)
        .args(arguments)
        .args(more)
        .args(["--faults", &faults])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let told = child.stderr.take().unwrap();
    let reader = std::thread::Builder::new().name("reader".to_owned());
    let reader = reader.spawn(move || std::io::read_to_string(told).unwrap()).unwrap();
    if !by_operation {
        std::thread::sleep(Duration::from_micros(random.random_range(0..400_000)));
        // SIGKILL; a process that has ended already needs none.
        let _ = child.kill();
    }
    let status = child.wait().unwrap();
    let told = reader.join().unwrap();
    assert!(!told.contains("panicked"), "{faults}: {told}");
    let number = |line: &str| line.split("on disk: ").nth(1)?.split(' ').next()?.parse().ok();
    Witness {
        acknowledged: told.lines().filter_map(number).max().unwrap_or(0),
        finished: status.success(),
        killed: status.code().is_none(),
    }
}

/// Sessions are run on a disk that writes short, is full and fails, and are killed in the middle of writes, syncs and
/// renames or at any time, until they are finished. What a process had said to be on disk is there, every journal
/// verifies, and each session ends with the trials, levels and answers of one that was never disturbed.
#[test]
fn sessions_that_are_killed_anywhere_lose_nothing_and_end_like_unbroken_ones() {
    const KILLS: usize = 200;
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 1));
    let data = folder.path().join("data");
    let mut random = random();
    let (mut kills, mut gave_up, mut sessions, mut acknowledged, mut repeated, mut torn) = (0, 0, 0, 0, 0, 0);
    while kills < KILLS {
        let seed = random.random_range(0..1_000_000).to_string();
        let unbroken = session(folder.path(), "study.json", "unbroken", seed.parse().unwrap(), &["--no-render"]);
        let unbroken = SessionFolder::open(&unbroken).unwrap();
        let mut known = 0;
        loop {
            let begun = data.is_dir() && !visible(&data).is_empty();
            let more = if begun { vec!["--resume"] } else { vec!["--seed", &seed] };
            let Witness { acknowledged: now, finished, killed } = run_and_kill(folder.path(), &more, &mut random);
            known += now;
            kills += usize::from(killed);
            gave_up += usize::from(!killed && !finished);
            let Some(path) = visible(&data).into_iter().next() else {
                assert_eq!(known, 0, "a session that never began had nothing to say");
                continue;
            };
            let diagnosis = examine(&path).unwrap();
            let expected = if finished { State::Complete } else { State::Unfinished };
            let over = diagnosis.state == State::Complete && !finished;
            assert!(diagnosis.state == expected || over, "{diagnosis:#?}");
            torn += usize::from(diagnosis.findings.iter().any(|finding| finding.what.contains("torn")));
            let session = SessionFolder::open(&path).unwrap();
            let answered = session.record.trials.iter().filter(|trial| is_answered(trial)).count();
            assert!(answered >= known, "{answered} answers are there of {known} that were acknowledged");
            // What was there and not acknowledged counts from here on too.
            known = answered;
            if session.record.is_over() {
                check_journal(&session);
                check_tables(&session);
                assert_eq!(answers(&session), answers(&unbroken), "seed {seed}");
                acknowledged += known;
                repeated += session.record.trials.len() - answered;
                break;
            }
        }
        sessions += 1;
        std::fs::remove_dir_all(&data).unwrap();
        std::fs::remove_dir_all(folder.path().join("unbroken")).unwrap();
    }
    println!(
        "{kills} kills and {gave_up} starts that the disk refused in {sessions} sessions, {torn} torn ends; 0 lost of {acknowledged} acknowledged answers, {repeated} \
         interrupted trials repeated"
    );
}

/// The sessions in a folder: a hidden name is one that never began.
fn visible(data: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(data) else { return Vec::new() };
    let paths = entries.map(|entry| entry.unwrap().path());
    paths.filter(|path| !path.file_name().unwrap().to_str().unwrap().starts_with('.')).collect()
}

/// What was asked and answered, without numbers and times, and without trials that were interrupted.
fn answers(session: &SessionFolder) -> Vec<(Trial, Outcome)> {
    let answered = session.record.trials.iter().filter(|trial| is_answered(trial));
    answered.map(|record| (Trial { trial: 0, ..record.trial.clone() }, record.outcome.clone())).collect()
}

#[test]
fn a_killed_session_keeps_everything_that_was_acknowledged_and_says_what_was_cut() {
    let folder = tempdir().unwrap();
    // Two thousand repetitions of eighteen levels last for minutes.
    write_json(folder.path(), "study.json", &small_study("long", 2000));
    let mut random = random();
    for attempt in 0..8 {
        let data = folder.path().join("data");
        let mut child = start(folder.path(), &["--fresh"]);
        let path = wait_for_journal(&data, random.random_range(1..200_000), &mut child);
        std::thread::sleep(Duration::from_micros(random.random_range(0..20_000)));
        let seen = std::fs::read(path.join("events.jsonl")).unwrap();
        kill(child);

        let bytes = std::fs::read(path.join("events.jsonl")).unwrap();
        assert!(bytes.starts_with(&seen), "what was on disk before the kill is there after it");
        let Journal { events, damage, .. } = journal::read(&bytes, FORMAT);
        let torn = bytes.last().is_some_and(|&byte| byte != b'\n');
        assert_eq!(damage.is_some(), torn, "{damage:?}");
        let before = contents(&path);
        let analyzed = run(folder.path(), &["analyze", path.to_str().unwrap()]);
        assert!(contents(&path) == before, "analyze changes nothing");
        assert!(!analyzed.err.contains("panicked"), "{}", analyzed.err);
        {
            assert!(analyzed.err.contains("did not run to its end"), "{}", analyzed.err);
            assert_eq!(analyzed.err.contains("torn, as after a kill"), torn, "{}", analyzed.err);

            let session = SessionFolder::open(&path).unwrap();
            check_journal_of_a_killed_session(&session);
            let ended = session.record.trials.len();
            println!(
                "attempt {attempt}: {} bytes, {} events, {ended} trials, {} acknowledged, torn: {torn}, exit {}",
                bytes.len(),
                events.len(),
                acknowledged(&events),
                analyzed.code
            );
            // A trial begins only when the one before is on disk.
            assert!(acknowledged(&events) == ended || acknowledged(&events) + 1 == ended);
            assert!(session.record.trials.iter().enumerate().all(|(i, trial)| trial.trial.trial as usize == i + 1));
            if ended > 40 {
                assert_eq!(analyzed.code, 0, "{}", analyzed.err);
                let answered = session.record.trials.iter().filter(|trial| is_answered(trial)).count();
                assert!(analyzed.out.contains(&format!("{answered} trials")), "{}", analyzed.out);
            }
        }
        std::fs::remove_dir_all(data).unwrap();
    }
}

/// The journal folds as far as it goes, and gaze and frames of every acknowledged trial are there.
fn check_journal_of_a_killed_session(session: &SessionFolder) {
    let text = &session.header.study.text;
    let plan = parse_study("study", text, &stimuli::registry::catalogue(), Some(&session.display)).unwrap();
    refold(Arc::new(plan), session.header.seed, &session.journal.events, |_, _| ()).unwrap();
    let last = acknowledged(&session.journal.events).checked_sub(1).map(|index| &session.record.trials[index]);
    if let Some(last) = last {
        let gaze_s = session.gaze().unwrap().rows.last().unwrap().t_s;
        let frame_s = session.frames().unwrap().rows.last().unwrap().scheduled_s;
        // The last frame before the answer, and a sample that had arrived by then.
        assert!(frame_s > last.ended_s - 0.02, "frames end at {frame_s}, the trial at {}", last.ended_s);
        assert!(gaze_s > last.ended_s - 0.05, "gaze ends at {gaze_s}, the trial at {}", last.ended_s);
    }
}

#[test]
fn a_session_that_is_killed_again_and_again_goes_on_and_completes_its_design() {
    const REPETITIONS: u32 = 16;
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", REPETITIONS));
    let unbroken =
        SessionFolder::open(&session(folder.path(), "study.json", "unbroken", 21, &["--no-render"])).unwrap();
    let mut random = random();
    let size = std::fs::metadata(unbroken.path.join("events.jsonl")).unwrap().len();
    let data = folder.path().join("data");

    let mut whole_before_the_first_kill = None;
    let (mut reopened, mut finished) = (0, false);
    let mut path = PathBuf::new();
    for attempt in 0..4 {
        let mut child = start(folder.path(), if attempt == 0 { &["--seed", "21"] } else { &["--resume"] });
        path = wait_for_journal(&data, size * (attempt + 1) / 6 + random.random_range(0..size / 8), &mut child);
        kill(child);
        let killed = SessionFolder::open(&path).unwrap();
        reopened = killed.record.reopened_s.len();
        finished = killed.record.finished;
        if finished {
            // The machine was too busy for this test to kill it in time.
            break;
        }
        whole_before_the_first_kill.get_or_insert_with(|| killed.record.trials.clone());
        println!(
            "kill {attempt}: {} trials, reopened {reopened} times, open trial: {:?}, damage: {:?}",
            killed.record.trials.len(),
            killed.record.open_trial.as_ref().map(|trial| trial.trial),
            killed.journal.damage
        );

        // Without --resume or --fresh the program asks which.
        let before = contents(&data);
        let arguments = ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--no-render"];
        let refused = run(folder.path(), &arguments).expect(2);
        assert!(refused.err.contains("--resume") && refused.err.contains("--fresh"), "{}", refused.err);
        assert!(refused.err.contains(path.file_name().unwrap().to_str().unwrap()), "{}", refused.err);
        assert!(contents(&data) == before);
    }
    if !finished {
        let arguments = ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--no-render"];
        let ran = run(folder.path(), &[&arguments[..], &["--resume"]].concat()).expect(0);
        assert_eq!(folder.path().join(ran.out.trim_end()), path);
        reopened += 1;
    }
    assert_eq!(only_entry(&data), path, "a session goes on in its own folder");

    let whole = SessionFolder::open(&path).unwrap();
    assert!(whole.record.finished);
    assert_eq!(whole.record.reopened_s.len(), reopened, "every seam is marked");
    check_journal(&whole);
    check_tables(&whole);
    check_design(&whole, REPETITIONS as usize);

    // Before the first kill nothing differs from a run that was never killed; after it nothing of that has changed.
    let before = whole_before_the_first_kill.unwrap();
    assert!(before.len() > 10, "{} trials", before.len());
    assert_eq!(before, unbroken.record.trials[..before.len()]);
    assert_eq!(before, whole.record.trials[..before.len()]);
    // Repeated are the trials that were open at a kill, and no others.
    let aborted = whole.record.trials.iter().filter(|trial| !is_answered(trial)).count();
    assert_eq!(whole.record.trials.len(), unbroken.record.trials.len() + aborted);
    assert!(aborted <= reopened, "{aborted} aborted trials, {reopened} kills");
    assert_eq!(answers(&whole), answers(&unbroken));
}

/// A copy of a session as a kill would have left it when the journal had `bytes` bytes. Gaze and frames may have been
/// ahead of the journal or, by what was not yet acknowledged, behind it.
fn as_if_killed(whole: &SessionFolder, bytes: usize, lag_s: f64, to: &Path) {
    copy_folder(&whole.path, to);
    let events = std::fs::read(whole.path.join("events.jsonl")).unwrap();
    std::fs::write(to.join("events.jsonl"), &events[..bytes]).unwrap();
    let kept = journal::read(&events[..bytes], FORMAT).events;
    // A mark in the journal is written when the rows that it counts are on disk.
    let on_disk = kept.iter().rev().find_map(|stamped| match stamped.event {
        Event::Tables(rows) | Event::Closed(rows) => Some(rows),
        _ => None,
    });
    let on_disk = on_disk.unwrap_or_default();
    let until_s = kept.last().map_or(0.0, |last| last.t_s) + lag_s;
    for (file, time_column, least) in [("gaze.csv", 1, on_disk.gaze_rows), ("frames.csv", 4, on_disk.frame_rows)] {
        let text = std::fs::read_to_string(whole.path.join(file)).unwrap();
        let mut kept = String::new();
        for (number, line) in text.split_inclusive('\n').enumerate() {
            let time = || line.split(',').nth(time_column).unwrap().parse::<f64>().unwrap();
            if number as u64 > least && time() > until_s {
                // The last line is torn.
                kept.push_str(&line[..line.len() / 2]);
                break;
            }
            kept.push_str(line);
        }
        std::fs::write(to.join(file), kept).unwrap();
    }
}

fn resume(folder: &Path, more: &[&str]) {
    let arguments =
        ["run", "study.json", "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--data", "cut", "--resume"];
    run(folder, &[&arguments[..], more].concat()).expect(0);
}

#[test]
fn a_session_that_was_cut_at_any_byte_goes_on_and_completes_its_design() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 2));
    let unbroken = SessionFolder::open(&session(folder.path(), "study.json", "data", 33, &["--no-render"])).unwrap();
    let size = usize::try_from(std::fs::metadata(unbroken.path.join("events.jsonl")).unwrap().len()).unwrap();
    let first_line = line_bytes(&unbroken, 1);
    let mut random = random();
    for _ in 0..24 {
        let bytes = random.random_range(first_line..size - 200);
        let lag_s = random.random_range(-0.5..0.5);
        println!("cut at {bytes} of {size} bytes, tables {lag_s:+.3} s");
        let cut = folder.path().join("cut");
        as_if_killed(&unbroken, bytes, lag_s, &cut.join("session"));
        let killed = SessionFolder::open(&cut.join("session")).unwrap();
        resume(folder.path(), &["--no-render"]);
        let whole = SessionFolder::open(&cut.join("session")).unwrap();
        assert!(whole.record.finished);
        assert_eq!(whole.record.reopened_s.len(), 1);
        check_journal(&whole);
        check_tables(&whole);
        check_design(&whole, 2);
        let ended = killed.record.trials.len();
        assert_eq!(whole.record.trials[..ended], unbroken.record.trials[..ended]);
        assert_eq!(answers(&whole), answers(&unbroken));
        std::fs::remove_dir_all(cut).unwrap();
    }
}

/// The length, in bytes, of a journal's first lines.
fn line_bytes(session: &SessionFolder, lines: usize) -> usize {
    let bytes = std::fs::read(session.path.join("events.jsonl")).unwrap();
    bytes.split_inclusive(|&byte| byte == b'\n').take(lines).map(<[u8]>::len).sum()
}

#[test]
fn a_session_that_was_cut_between_two_trials_goes_on_exactly_as_if_it_had_not_been() {
    let folder = tempdir().unwrap();
    write_json(folder.path(), "study.json", &small_study("small", 2));
    let unbroken = SessionFolder::open(&session(folder.path(), "study.json", "data", 34, &["--no-render"])).unwrap();
    let mut random = random();
    for _ in 0..6 {
        let trial = random.random_range(1..36);
        // Behind the consequences of the answer: the trial's end and the wait for the disk.
        let ended = |stamped: &Stamped| matches!(stamped.event, Event::TrialEnded { trial: one, .. } if one == trial);
        let at = unbroken.journal.events.iter().position(ended).unwrap() + random.random_range(1..3);
        let bytes = line_bytes(&unbroken, at);
        println!("cut behind trial {trial}, event {at}");
        let cut = folder.path().join("cut");
        as_if_killed(&unbroken, bytes, 0.1, &cut.join("session"));
        resume(folder.path(), &["--no-render"]);
        let whole = SessionFolder::open(&cut.join("session")).unwrap();
        check_journal(&whole);
        check_tables(&whole);
        assert_eq!(whole.record.reopened_s.len(), 1);
        assert_eq!(answers(&whole), answers(&unbroken));
        assert_eq!(whole.record.trials.len(), unbroken.record.trials.len());
        std::fs::remove_dir_all(cut).unwrap();
    }
}

#[test]
fn a_session_with_pictures_that_was_cut_and_went_on_replays_exactly() {
    let folder = tempdir().unwrap();
    let mut study = small_study("small", 2);
    study["blocks"][0]["procedure"]["levels"] = json!({ "eccentricity_deg": [2.5, 4], "mar_deg": [1.6] });
    write_json(folder.path(), "study.json", &study);
    let unbroken = SessionFolder::open(&session(folder.path(), "study.json", "data", 35, &[])).unwrap();
    let size = usize::try_from(std::fs::metadata(unbroken.path.join("events.jsonl")).unwrap().len()).unwrap();
    let mut random = random();
    for _ in 0..3 {
        let bytes = random.random_range(size / 4..size - 700);
        let lag_s = random.random_range(-0.3..0.3);
        println!("cut at {bytes} of {size} bytes, tables {lag_s:+.3} s");
        let cut = folder.path().join("cut");
        as_if_killed(&unbroken, bytes, lag_s, &cut.join("session"));
        resume(folder.path(), &[]);
        check_tables(&SessionFolder::open(&cut.join("session")).unwrap());
        let verified = run(folder.path(), &["replay", "cut/session", "--verify", "--json"]).expect(0).json();
        assert!(verified["hashes_compared"].as_u64().unwrap() > 50, "{verified}");
        std::fs::remove_dir_all(cut).unwrap();
    }
}
