//! `parafovea fit`: any table of levels, answers and right answers.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{contents, run};
use serde_json::Value;
use tempfile::tempdir;

/// The reference data of one function: seven levels of 40 answers, two alternatives.
const REFERENCE: &str = "level,n,k\n1,40,19\n2,40,22\n3,40,27\n4,40,32\n5,40,37\n6,40,39\n7,40,39\n";

#[track_caller]
fn near(value: &Value, expected: f64, within: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("a number, found {value}"));
    assert!((value - expected).abs() < within, "expected {expected}, found {value}");
}

/// Mode by psignifit 4.3; intervals by dense sums over threshold, width, λ and η.
#[test]
fn the_reference_data_give_psignifits_function() {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("data.csv"), REFERENCE).unwrap();
    let document = run(folder.path(), &["fit", "data.csv", "--json"]).expect(0).json();
    let fit = &document["fits"][0];
    assert_eq!(fit["group"], Value::Null);
    assert_eq!(fit["n_trials"], 280);
    for (parameter, expected) in [("threshold", 3.5482), ("width", 4.0521), ("lapse", 0.0175), ("guess", 0.5)] {
        near(&fit["map"][parameter], expected, 6e-5);
    }
    near(&fit["map"]["overdispersion"], 0.0, 1e-3);
    let ends = [("threshold", [2.7407, 4.1386]), ("width", [2.0990, 7.6116])];
    for (parameter, [low, high]) in ends {
        near(&fit["ci95"][parameter][0], low, 0.01 * (high - low));
        near(&fit["ci95"][parameter][1], high, 0.01 * (high - low));
    }
    near(&fit["mean"]["threshold"], 3.4735, 0.01);
    assert!(fit["deviance"].as_f64().unwrap() < 1.0 && fit["deviance_p"].as_f64().unwrap() > 0.5);
    assert_eq!(fit["supported"], true);

    let text = run(folder.path(), &["fit", "data.csv", "--at", "0.75"]).expect(0).out;
    assert!(text.contains("280 answers at 7 levels") && text.contains("75 % right: level 3.5"), "{text}");
}

#[test]
fn groups_names_and_single_answers() {
    let folder = tempdir().unwrap();
    let mut single = String::from("who;x;correct\n");
    let mut counted = String::from("who,x,shown,seen\n");
    for (who, rights) in [("near", [11, 14, 18, 20]), ("far", [10, 10, 12, 17])] {
        for (x, right) in (1..).zip(rights) {
            counted.push_str(&format!("{who},{x},20,{right}\n"));
            for answer in 0..20 {
                single.push_str(&format!("{who};{x};{}\n", u8::from(answer < right)));
            }
        }
    }
    std::fs::write(folder.path().join("single.csv"), single).unwrap();
    std::fs::write(folder.path().join("counted.csv"), counted).unwrap();
    let base = ["fit", "counted.csv", "--level", "x", "--n", "shown", "--k", "seen", "--group", "who", "--json"];
    let independent = |more: &[&str]| {
        let all: Vec<&str> = base.iter().chain(more).copied().collect();
        run(folder.path(), &all).expect(0).json()
    };
    let counted = independent(&["--independent", "--compare", "threshold"]);
    let single = ["fit", "single.csv", "--level", "x", "--group", "who", "--json"];
    let single = run(folder.path(), &single).expect(0).json();
    for (index, who) in ["near", "far"].iter().enumerate() {
        assert_eq!(counted["fits"][index]["group"], *who);
        // Single answers are independent ones.
        assert_eq!(counted["fits"][index]["ci95"], single["fits"][index]["ci95"]);
    }
    assert_eq!(counted["comparison"]["df"], 1);
    assert!(counted["comparison"]["p"].as_f64().unwrap() < 0.05);
}

#[test]
fn a_falling_table_is_seen_to_fall() {
    let folder = tempdir().unwrap();
    let table = "level,n,k\n4,20,20\n8,20,19\n12,20,15\n16,20,6\n20,20,2\n24,20,1\n";
    std::fs::write(folder.path().join("data.csv"), table).unwrap();
    let fit = run(folder.path(), &["fit", "data.csv", "--yes-no", "--json"]).expect(0).json()["fits"][0].clone();
    assert_eq!(fit["config"]["direction"], "falls");
    near(&fit["map"]["threshold"], 14.0, 1.0);
    let forced =
        run(folder.path(), &["fit", "data.csv", "--yes-no", "--direction", "rises", "--json"]).expect(0).json();
    assert_eq!(forced["fits"][0]["supported"], false);
}

#[test]
fn bad_tables_are_refused_with_every_mistake() {
    let folder = tempdir().unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("data.csv"), text).unwrap();
    let refused = |arguments: &[&str]| {
        let all: Vec<&str> = ["fit", "data.csv"].iter().chain(arguments).copied().collect();
        let ran = run(folder.path(), &all).expect(2);
        assert_eq!(ran.out, "", "nothing is printed beside a refusal");
        ran.err
    };
    write("level,n,k\n1,40,41\ntwo,40,3\n3,-1,0\n");
    let found = refused(&[]);
    for expected in ["data.csv:2: k: expected at most 40", "data.csv:3: level", "data.csv:4: n: expected a whole"] {
        assert!(found.contains(expected), "{expected} in {found}");
    }
    write("x,y\n1,2\n");
    assert!(refused(&["--group", "who"]).lines().count() >= 4);
    write("");
    assert!(refused(&[]).contains("column names"));
    write("level,n,k\n1,10,5\n1,10,6\n");
    assert!(refused(&[]).contains("at least 2"));
    write("who,level,n,k\na,1,10,5\na,2,10,9\nb,1,10,5\n");
    assert!(refused(&["--group", "who"]).contains("group b"));
    write("level,n,k\n0,10,5\n1,10,6\n2,10,9\n");
    assert!(refused(&["--axis", "log"]).contains("above zero"));
    for bad in [["--guess", "1.5"], ["--lapse", "x"], ["--alternatives", "1"], ["--at", "2"], ["--compare", "width"]] {
        refused(&bad);
    }
    assert_eq!(contents(folder.path()).len(), 1);
}
