//! Texts that no editor wrote: broken, doubled, deep, huge, mutated. Nothing may panic, and the place must be right.

use super::{STUDY, assert_only, edited, mistakes, parse};
use crate::study::{parse_display, shipped, study_schema};
use proptest::prelude::*;

#[test]
fn syntax_errors_name_line_and_expectation() {
    for (old, new, line, words) in [
        (r#""format": 1,"#, r#""format": 1"#, 2, "a comma between two entries"),
        (r#""format": 1,"#, r#""format" 1,"#, 2, "a colon after the key"),
        (r#""format": 1,"#, r#"format: 1,"#, 2, "a key in double quotes"),
        (r#""format": 1,"#, r#""format": ,"#, 2, "a value"),
        (r#""format": 1,"#, r#"'format': 1,"#, 2, "double quotes"),
        (r#""format": 1,"#, r#""format": 0x1,"#, 2, "a decimal number"),
        (r#""format": 1,"#, r#""format": NaN,"#, 2, "expected"),
        (r#""format": 1,"#, r#""format": yes,"#, 2, "a value"),
        (r#""title": "A small study""#, r#""title": "A small study"#, 4, "the closing quote of a string on its line"),
        ("[0, 5, 10]", "[0, 5, 10", 46, "expected"),
    ] {
        let found = mistakes(&edited(&[(old, new)]));
        assert_eq!(found.len(), 1, "{new}: {found:?}");
        assert_eq!(found[0].0, line, "{new}: {found:?}");
        assert!(found[0].2.contains(words), "{new}: {found:?}");
        assert!(found[0].1.is_empty());
    }
}

#[test]
fn comments_and_trailing_commas_are_mistakes_beside_others() {
    let text = edited(&[
        (r#""format": 1,"#, r#""format": 1, // the first"#),
        ("[0, 5, 10]", "[0, 5, 10,]"),
        (r#""renderer": "ring""#, r#""renderer": "rng""#),
    ]);
    let lines: Vec<usize> = mistakes(&text).iter().map(|m| m.0).collect();
    assert_eq!(lines, [2, 15, 46]);
}

#[test]
fn a_key_that_occurs_twice_is_a_mistake_and_the_first_counts() {
    assert_only(&[(r#""format": 1,"#, "\"format\": 1,\n  \"format\": 7,")], 3, "format", &["once", "\"format\" again"]);
    assert_only(
        &[(r#""image": "coffee""#, r#""image": "coffee", "image": "tea""#)],
        14,
        "conditions.photo.scene_parameters.image",
        &["again"],
    );
}

#[test]
fn files_that_are_no_study_at_all() {
    for (text, words) in [
        ("", "empty"),
        ("  \n\n ", "empty"),
        ("[]", "found a list"),
        ("7", "found 7"),
        ("null", "found null"),
        ("\"study\"", "found \"study\""),
        ("{} {}", "end of the file"),
        ("{", "closing brace"),
        ("\u{feff}", "expected"),
    ] {
        let found = mistakes(text);
        assert_eq!((found.len(), found[0].0), (1, 1), "{text:?}: {found:?}");
        assert!(found[0].2.contains(words), "{text:?}: {found:?}");
    }
    // An empty object lacks everything, and says so for each key.
    let fields: Vec<String> = mistakes("{}").into_iter().map(|m| m.1).collect();
    assert_eq!(fields, ["blocks", "conditions", "display", "format", "name", "title"]);
}

#[test]
fn what_strict_json_forbids_is_a_mistake() {
    for (old, new, line, words) in [
        ("A small study", "A small\nstudy", 4, "the closing quote of a string on its line"),
        ("A small study", "A small\tstudy", 4, "the closing quote of a string on its line"),
        (r#""steps": 24"#, r#""steps": 024"#, 47, "a comma"),
        ("A small study", "A \\q study", 4, "expected"),
        ("A small study", "A \\ud800 study", 4, "expected"),
    ] {
        let found = mistakes(&edited(&[(old, new)]));
        assert_eq!((found.len(), found[0].0), (1, line), "{new:?}: {found:?}");
        assert!(found[0].2.contains(words), "{new:?}: {found:?}");
    }
}

#[test]
fn depth_and_size_do_no_harm() {
    let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(mistakes(&deep)[0].2.contains("nesting"));
    let deep_objects = "{\"a\":".repeat(100_000);
    assert_eq!(mistakes(&deep_objects).len(), 1);
    for number in ["1e400", "-1e400", "123456789012345678901234567890", "1e-400", "-0", "01", "4294967296"] {
        let _ = parse(&edited(&[(r#""max_trials": 240"#, &format!("\"max_trials\": {number}"))]));
        let _ = parse(&edited(&[(r#""gate_deg": 2.0"#, &format!("\"gate_deg\": {number}"))]));
    }
    let many: Vec<String> = (0..20_000).map(|i| format!("{}", 0.1 + f64::from(i) * 1e-4)).collect();
    let text = edited(&[("[1.5, 2.5, 3]", &format!("[{}]", many.join(",")))]);
    assert!(mistakes(&text).iter().any(|m| m.2.contains("at most 10000 combinations")));
}

#[test]
fn columns_count_characters() {
    let text = edited(&[(r#""title": "A small study","#, r#""title": "Größe µ", "extra": 1,"#)]);
    let error = parse(&text).expect_err("one mistake");
    assert_eq!((error.list[0].line, error.list[0].column), (4, 23));
}

#[test]
fn a_study_is_read_fast() {
    let start = std::time::Instant::now();
    for _ in 0..20 {
        parse(STUDY).expect("a study");
    }
    // A millisecond each on any machine; the limit is for one that is busy.
    assert!(start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
}

/// Some bytes of a text deleted, doubled or replaced by what JSON is made of.
fn mutated(text: &str, edits: &[(usize, usize, u8)]) -> String {
    const PIECES: [&str; 16] =
        ["", "{", "}", "[", "]", ",", ":", "\"", "null", "1e309", "-1", "0", "\"x\"", "\\u00", "//", "é"];
    let mut bytes = text.as_bytes().to_vec();
    for &(at, length, piece) in edits {
        let start = at % (bytes.len() + 1);
        let end = (start + length).min(bytes.len());
        bytes.splice(start..end, PIECES[usize::from(piece) % PIECES.len()].bytes());
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn mutated_studies_never_panic(
        which in 0usize..2,
        edits in prop::collection::vec((any::<usize>(), 0usize..12, any::<u8>()), 1..4),
    ) {
        let text = mutated(shipped()[which].json, &edits);
        if let Err(error) = parse(&text) {
            prop_assert!(!error.list.is_empty());
            let lines = text.lines().count().max(1) + 1;
            for mistake in &error.list {
                prop_assert!((1..=lines).contains(&mistake.line));
                prop_assert!(mistake.span.start <= mistake.span.end && mistake.span.end <= text.len());
                prop_assert!(text.get(mistake.span.clone()).is_some(), "a span splits a character");
            }
        }
        prop_assert!(parse(&text).is_err() || serde_json::from_str::<serde_json::Value>(&text).is_ok());
        let _ = parse_display("display.json", &text);
    }

    /// A number or key anywhere in the tree replaced: whatever an independent validator of the committed schema
    /// refuses, we refuse.
    #[test]
    fn what_the_schema_refuses_is_refused(
        which in 0usize..2,
        at in any::<prop::sample::Index>(),
        new in prop::sample::select(vec!["null", "-1", "1e6", "\"x\"", "[]", "{}", "true", "0.5", "[1]", "0"]),
    ) {
        let mut value: serde_json::Value = serde_json::from_str(shipped()[which].json).expect("JSON");
        let mut pointers = Vec::new();
        collect_pointers(&value, String::new(), &mut pointers);
        let pointer = at.get(&pointers).clone();
        *value.pointer_mut(&pointer).expect("collected") = serde_json::from_str(new).expect("JSON");
        let accepted = jsonschema::validator_for(&study_schema()).expect("a schema").is_valid(&value);
        let parsed = parse(&value.to_string());
        prop_assert!(accepted || parsed.is_err(), "{pointer} = {new}");
    }
}

pub(super) fn collect_pointers(value: &serde_json::Value, here: String, pointers: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(map) => {
            for (key, value) in map {
                collect_pointers(value, format!("{here}/{key}"), pointers);
            }
        }
        serde_json::Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                collect_pointers(value, format!("{here}/{index}"), pointers);
            }
        }
        _ => {}
    }
    pointers.push(here);
}

/// The files of a study are known before it is checked, however much else is wrong with it.
#[test]
fn files_are_named_whatever_else_is_wrong() {
    let text = r#"{ "renderers": { "mine": { "wgsl": "a.wgsl" }, "worse": { "wgsl": 7 }, "frames": { "frames": "dir" } },
        "scenes": { "room": { "gltf": "r.glb", "environment": "e.exr" }, "sky": { "environment": "s.hdr" }, "none": {} },
        "blocks": "none", "colour": 1 }"#;
    let names: Vec<String> = crate::study::named_files(text).into_iter().map(|file| file.name).collect();
    assert_eq!(names, ["frames", "mine", "room", "sky"]);
    assert!(crate::study::named_files("{").is_empty());
    assert!(crate::study::named_files("").is_empty());
    assert!(crate::study::named_files(STUDY).is_empty());
}
