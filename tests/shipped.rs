//! Every study that ships: its counts and durations are the papers', it runs to its end with a simulated observer, and
//! its session analyses.

mod common;

use common::{run, small_display};
use experiments::study::shipped;
use serde_json::Value;

/// Study, trials of its main blocks, minutes of one sitting (from, to), and where the papers say so.
const DESIGNS: [(&str, u64, [f64; 2]); 7] = [
    // Guenter 2012, §5: j = 8 … 22 in both orders; 16.5 s and an answer each.
    ("guenter-pair", 30, [8.0, 12.0]),
    // 8 levels in both directions; five steps of 5 s.
    ("guenter-ramp", 16, [6.5, 9.0]),
    // 8 camera motions, each twice.
    ("guenter-slider", 16, [5.0, 15.0]),
    // Tursun 2019, §5: 324 comparisons × 10 over six sittings of 40 minutes.
    ("tursun-calibration", 3240, [35.0, 45.0]),
    // Weier 2016, §4.2.1: 4 × 4 × 3, each twice; sequences of 8 s.
    ("weier-likert", 96, [13.0, 20.0]),
    // Three scenes from two starting points.
    ("stengel-calibration", 6, [1.0, 10.0]),
    // Stengel 2016, §6.2: three pairs in each of five tasks, and one toggled comparison.
    ("stengel-validation", 16, [5.0, 10.0]),
];

fn described(study: &str) -> Value {
    run(std::path::Path::new("."), &["check", study, "--json"]).expect(0).json()
}

#[test]
fn counts_and_durations_are_the_papers() {
    for (study, trials, [from, to]) in DESIGNS {
        let description = described(study);
        let blocks = description["blocks"].as_array().unwrap();
        let main = blocks.iter().filter(|block| block["practice"] == false);
        assert_eq!(main.map(|block| block["trials_max"].as_u64().unwrap()).sum::<u64>(), trials, "{study}");
        let sittings = description["sittings"].as_array().unwrap();
        let one = sittings.first().unwrap_or(&description["total"]);
        let minutes = one["minutes_max"].as_f64().unwrap();
        assert!((from..=to).contains(&minutes), "{study}: {minutes} min");
        if study == "tursun-calibration" {
            assert_eq!(sittings.len(), 6);
            assert!(
                sittings.iter().all(|sitting| sitting == one && sitting["trials_max"] == 544),
                "540 and 4 practice"
            );
        }
    }
}

#[test]
fn every_study_runs_to_its_end_and_analyses() {
    let folder = tempfile::tempdir().unwrap();
    for study in shipped() {
        let name = study.name;
        let truth = ["--simulate", "omega0=0.021,m=0.022", "--seed", "7"];
        let common = ["run", name, "--observer", "S1", "--offscreen", "--no-render"];
        let session = run(folder.path(), &[&common[..], &truth[..]].concat()).expect(0).out.trim().to_owned();
        let analysis = run(folder.path(), &["analyze", &session, "--report", "report.html", "--json"]).expect(0).json();
        let blocks = analysis["observers"][0]["blocks"].as_array().unwrap();
        let trials: u64 = blocks.iter().map(|block| block["trials"].as_u64().unwrap()).sum();
        match DESIGNS.iter().find(|design| design.0 == name) {
            Some((.., designed, _)) if name == "tursun-calibration" => assert_eq!(6 * trials, *designed),
            Some((.., designed, _)) => assert_eq!(trials, *designed, "{name}"),
            None => assert!(analysis["observers"][0]["mar"]["m"]["estimate"].as_f64().unwrap() > 0.0, "{name}"),
        }
        assert!(blocks.iter().all(|block| block["summary"]["family"] != "nothing"), "{name}: {blocks:#?}");
        assert!(std::fs::read_to_string(folder.path().join("report.html")).unwrap().contains("<svg"), "{name}");
    }
}

/// A study of several sittings goes on with the next one, and ends after the last; a pilot run is short and marked.
#[test]
fn sittings_follow_one_another_and_pilots_are_marked() {
    let folder = tempfile::tempdir().unwrap();
    let again = |more: &[&str]| {
        let common = ["run", "tursun-calibration", "--observer", "P01", "--offscreen", "--no-render"];
        run(folder.path(), &[&common[..], &["--simulate", "omega0=0.021,m=0.022"], more].concat())
    };
    let header = |session: &str| -> Value {
        let path = folder.path().join(session.trim()).join("session.json");
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    };
    for sitting in [1, 2] {
        let ran = again(&["--seed", &sitting.to_string()]).expect(0);
        assert_eq!(header(&ran.out)["assignment"]["sitting"], sitting);
        assert!(ran.err.contains(&format!("sitting {sitting} of 6")), "{ran:?}");
    }
    let beyond = again(&["--sitting", "7", "--seed", "3"]).expect(2);
    assert!(beyond.err.contains("6 sitting"), "{beyond:?}");
    let pilot = again(&["--pilot", "--seed", "4"]).expect(0);
    assert_eq!(header(&pilot.out)["assignment"]["pilot"], true);
    let analysed = run(folder.path(), &["analyze", pilot.out.trim()]).expect(0);
    assert!(analysed.out.contains("PILOT DATA"), "{}", analysed.out);
}

/// One trial of every protocol, drawn on a small display, by an observer who knows the parameters and by one who looks at
/// the pixels; the log alone gives the same pictures again.
#[test]
fn one_trial_of_every_protocol_is_drawn_and_drawn_again() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.json"), small_display().to_string()).unwrap();
    let tour = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/window/tour.json");
    for (observer, truth) in [("S1", "omega0=0.3,m=0.1"), ("S2", "pixels")] {
        let ran = run(
            folder.path(),
            &[
                "run",
                tour,
                "--display",
                "small.json",
                "--observer",
                observer,
                "--offscreen",
                "--simulate",
                truth,
                "--seed",
                "5",
            ],
        )
        .expect(0);
        let session = ran.out.trim();
        let journal = std::fs::read_to_string(folder.path().join(session).join("events.jsonl")).unwrap();
        assert_eq!(journal.matches("\"outcome\":\"answered\"").count(), 8, "{truth}");
        assert!(journal.contains("\"form\":\"participant\"") && journal.contains("\"form\":\"paired-task\""));
        let verified = run(folder.path(), &["replay", session, "--verify"]).expect(0);
        assert!(verified.out.contains(" 0 different"), "{truth}: {}", verified.out);
        run(folder.path(), &["analyze", session]).expect(0);
    }
}
