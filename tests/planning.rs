//! `parafovea power` on shipped studies: planted truths come back, and the same seed gives the same document.

mod common;

use common::run;
use serde_json::Value;
use std::path::Path;

fn power(arguments: &[&str]) -> Value {
    run(Path::new("."), &[&["power"], arguments, &["--json"]].concat()).expect(0).json()
}

fn quantity<'v>(power: &'v Value, name: &str) -> &'v Value {
    let quantities = power["quantities"].as_array().expect("a list");
    quantities.iter().find(|quantity| quantity["name"] == name).unwrap_or_else(|| panic!("{name}: {power:#}"))
}

#[test]
fn a_planted_pair_threshold_is_recovered_within_an_index_step() {
    let truth = ["--simulate", "quality_index=14,width=3,finer=up", "--spread", "0"];
    let power = power(&[&["guenter-pair", "--observers", "10", "--repeats", "6"], &truth[..]].concat());
    assert_eq!(power["sessions"], 60);
    let threshold = quantity(&power, "main threshold of quality_index");
    assert!((threshold["truth"].as_f64().unwrap() - 14.0).abs() < 1e-6);
    let whole = threshold["by_trials"].as_array().unwrap().last().unwrap();
    assert_eq!(whole["trials"], 30);
    let bias = whole["bias"].as_f64().unwrap();
    println!("bias {bias:.3} index steps, coverage {}", whole["coverage"]);
    assert!(bias.abs() < 1.0, "{bias}");
    assert!(whole["coverage"].as_f64().unwrap() > 0.85);
}

#[test]
fn the_calibration_has_its_coverage_and_grows_with_trials_and_observers() {
    let arguments = ["mar-demo", "--observers", "4", "--repeats", "10"];
    let first = power(&arguments);
    let m = quantity(&first, "m");
    let by_trials = m["by_trials"].as_array().unwrap();
    let rmse: Vec<f64> = by_trials.iter().map(|point| point["rmse"].as_f64().unwrap()).collect();
    println!("RMSE of m by trials {rmse:?}, coverage {}", by_trials[3]["coverage"]);
    assert!(rmse[3] < rmse[0]);
    // 40 intervals of 95 %: 35 to 40 hold.
    assert!(by_trials[3]["coverage"].as_f64().unwrap() >= 0.875);
    let observers: Vec<u64> =
        m["by_observers"].as_array().unwrap().iter().map(|point| point["observers"].as_u64().unwrap()).collect();
    assert_eq!(observers, [1, 2, 3, 4]);
    assert_eq!(first, power(&arguments), "threads do not decide the result");
}

#[test]
fn impossible_requests_are_refused() {
    for (arguments, words) in [
        (vec!["power", "mar-demo", "--observers", "0"], "1..=10000"),
        (vec!["power", "mar-demo", "--spread", "2"], "from 0 to 1"),
        (vec!["power", "mar-demo", "--simulate", "m=2"], "omega0 is missing"),
        (vec!["power", "mar-demo", "--simulate", "pixels"], "looks at pictures"),
        (vec!["power", "no-such-study"], "expected a study file"),
        (vec!["power", "mar-demo", "--observers", "10000", "--repeats", "1000"], "1000000"),
    ] {
        let ran = run(Path::new("."), &arguments).expect(2);
        assert!(ran.err.contains(words), "{arguments:?}: {}", ran.err);
    }
}
