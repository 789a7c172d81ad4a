//! One case for each kind of mistake, with its exact line and field.

use super::{STUDY, assert_only, catalogue, edited, mistakes, parse};
use crate::display::{Display, Transfer};
use crate::study::{parse_display, parse_study};

#[test]
fn five_different_mistakes_come_at_once_with_their_lines() {
    let text = edited(&[
        (r#""fixation_deg": [0, 0]"#, r#""fixation_deg": [0, "abc"]"#),
        (r#""scene": "photo""#, r#""scene": "foto""#),
        (r#""gap_s": 0.3"#, r#""gab_s": 0.3"#),
        (r#""repetitions": 4"#, r#""repetitions": -4"#),
        (r#""min": 0.05, "max": 3.0"#, r#""min": 3.0, "max": 0.05"#),
    ]);
    let error = parse(&text).expect_err("six mistakes");
    // The misspelt key is one too many and one too few.
    let places: Vec<(usize, &str)> = error.list.iter().map(|m| (m.line, m.field.as_str())).collect();
    assert_eq!(
        places,
        [
            (7, "gaze.fixation_deg[1]"),
            (13, "conditions.photo.scene"),
            (24, "blocks[0].protocol.gap_s"),
            (28, "blocks[0].protocol.gab_s"),
            (36, "blocks[0].procedure.repetitions"),
            (47, "blocks[1].procedure.mar.max"),
        ]
    );
    let shown = error.to_string();
    assert_eq!(shown.lines().count(), 6);
    assert!(
        shown.starts_with(
            "study.json:7:25: gaze.fixation_deg[1]: expected a number in degrees from -80 to 80, found \"abc\"\n"
        ),
        "{shown}"
    );
    assert!(shown.contains("found \"gab_s\"; did you mean \"gap_s\"?"), "{shown}");
    assert!(shown.contains("found \"foto\"; did you mean \"photo\"?"), "{shown}");
}

#[test]
fn spans_cover_the_value_or_the_key_at_fault() {
    let text = edited(&[(r#""renderer": "ring""#, r#""renderer": "rign", "extra": 1"#)]);
    let error = parse(&text).expect_err("two mistakes");
    let spans: Vec<&str> = error.list.iter().map(|m| &text[m.span.clone()]).collect();
    assert_eq!(spans, [r#""rign""#, r#""extra""#]);
}

#[test]
fn keys_and_types() {
    assert_only(&[(r#""title": "A small study","#, "")], 1, "title", &["a string", "found no such key"]);
    assert_only(&[(r#""title": "A small study""#, r#""title": """#)], 4, "title", &["empty"]);
    assert_only(&[(r#""title": "A small study""#, r#""title": null"#)], 4, "title", &["a string", "found null"]);
    assert_only(&[(r#""format": 1"#, r#""format": 2"#)], 2, "format", &["expected 1", "found 2"]);
    assert_only(&[(r#""format": 1"#, r#""format": "1""#)], 2, "format", &["expected 1", r#"found "1""#]);
    assert_only(
        &[(r#""practice": true"#, r#""practice": "yes""#)],
        22,
        "blocks[0].practice",
        &["true or false", r#"found "yes""#],
    );
    assert_only(&[(r#""interval_s": 0.3,"#, "")], 24, "blocks[0].protocol.interval_s", &["seconds", "no such key"]);
    assert_only(
        &[(r#""steps": 24"#, r#""steps": 2.5"#)],
        47,
        "blocks[1].procedure.mar.steps",
        &["a whole number from 2 to 1000", "found 2.5"],
    );
    assert_only(&[(r#""steps": 24"#, r#""steps": 1"#)], 47, "blocks[1].procedure.mar.steps", &["from 2"]);
    assert_only(
        &[(r#"{ "width_deg": 4 }"#, "[4]")],
        16,
        "conditions.photo.renderer_parameters",
        &["an object", "found a list"],
    );
    assert_only(&[("[0, 0]", "[0, 0, 0]")], 7, "gaze.fixation_deg", &["a list of 2 numbers in degrees", "found 3"]);
    assert_only(
        &[(r#""lapse": [0, 0.02]"#, r#""lapse": 0.02"#)],
        50,
        "blocks[1].procedure.prior.lapse",
        &["a list of numbers or an object with min, max, steps", "found 0.02"],
    );
    assert_only(
        &[(r#""values": [0, 5, 10]"#, r#""values": [0, "5", 10]"#)],
        46,
        "blocks[1].procedure.eccentricity.values[1]",
        &["degrees"],
    );
}

#[test]
fn kinds_are_checked_against_the_branch_they_name() {
    assert_only(
        &[(r#""kind": "quest-plus""#, r#""kind": "quest-pls""#)],
        45,
        "blocks[1].procedure.kind",
        &[r#""constant" or "staircase" or "quest""#, r#"found "quest-pls"; did you mean "quest-plus"?"#],
    );
    assert_only(&[(r#""kind": "constant","#, "")], 30, "blocks[0].procedure.kind", &[r#""constant""#, "no such key"]);
    assert_only(
        &[(r#""repetitions": 4"#, r#""repetitions": 4, "stop": {}"#)],
        36,
        "blocks[0].procedure.stop",
        &["one of the keys", "levels, repetitions", r#"found "stop""#],
    );
}

#[test]
fn a_number_is_held_against_its_bounds() {
    assert_only(
        &[(r#""gate_deg": 2.0"#, r#""gate_deg": 0"#)],
        8,
        "gaze.gate_deg",
        &["above 0 and up to 90", "found 0"],
    );
    assert_only(&[(r#""interval_s": 0.3"#, r#""interval_s": -1"#)], 27, "blocks[0].protocol.interval_s", &["above 0"]);
    assert_only(&[(r#""gap_s": 0.3"#, r#""gap_s": 1e999"#)], 28, "blocks[0].protocol.gap_s", &["1e999", "no number"]);
    assert_only(
        &[(r#""max_trials": 240"#, r#""max_trials": 0"#)],
        52,
        "blocks[1].procedure.stop.max_trials",
        &["a whole number from 1"],
    );
    assert_only(
        &[(r#""min_trials": 80"#, r#""min_trials": 241"#)],
        52,
        "blocks[1].procedure.stop.min_trials",
        &["at most max_trials (240)"],
    );
    assert_only(
        &[(r#""lapse": [0, 0.02]"#, r#""lapse": [0, 0.6]"#)],
        50,
        "blocks[1].procedure.prior.lapse[1]",
        &["from 0 to 0.5", "found 0.6"],
    );
    assert_only(
        &[(r#""min": 0.005, "max": 0.08, "steps": 10"#, r#""min": 0.08, "max": 0.08, "steps": 10"#)],
        49,
        "blocks[1].procedure.prior.m.max",
        &["more than min (0.08)"],
    );
}

#[test]
fn names() {
    assert_only(&[(r#""name": "small""#, r#""name": "Small Study""#)], 3, "name", &["a-z", r#"found "Small Study""#]);
    assert_only(&[(r#""name": "main""#, r#""name": "practice""#)], 40, "blocks[1].name", &["as in an earlier block"]);
    assert_only(
        &[("    \"photo\": {", "    \"spare\": { \"scene\": \"noise\", \"renderer\": \"ring\" },\n    \"photo\": {")],
        12,
        "conditions.spare",
        &["a block that shows this condition"],
    );
    assert_only(
        &[(
            "\"practice\": true,\n      \"condition\": \"photo\"",
            "\"practice\": true,\n      \"condition\": \"phto\"",
        )],
        23,
        "blocks[0].condition",
        &["(photo)", "did you mean \"photo\"?"],
    );
}

#[test]
fn the_catalogue_decides_what_can_be_shown() {
    assert_only(
        &[(r#""scene": "photo""#, r#""scene": "nose""#)],
        13,
        "conditions.photo.scene",
        &["photo, noise", r#"did you mean "noise"?"#],
    );
    assert_only(
        &[(r#""renderer": "ring""#, r#""renderer": "layers""#)],
        15,
        "conditions.photo.renderer",
        &["reference, ring"],
    );
    assert_only(
        &[(r#""image": "coffee""#, r#""image": "tea""#)],
        14,
        "conditions.photo.scene_parameters.image",
        &["one of gravel, chelsea, coffee, grass", r#"found "tea""#],
    );
    assert_only(
        &[(r#""width_deg": 4"#, r#""width_deg": 400"#)],
        16,
        "conditions.photo.renderer_parameters.width_deg",
        &["from 0 to 60 °", "found 400"],
    );
    assert_only(
        &[(r#""width_deg": 4"#, r#""witdh_deg": 4"#)],
        16,
        "conditions.photo.renderer_parameters.witdh_deg",
        &["did you mean \"width_deg\"?"],
    );
}

#[test]
fn levels_are_held_against_renderer_and_display() {
    let levels = "blocks[0].procedure.levels";
    assert_only(
        &[(r#""mar_deg": ["#, r#""marr_deg": ["#)],
        34,
        &format!("{levels}.marr_deg"),
        &["numeric parameter", "mar_deg"],
    );
    assert_only(
        &[("[1.5, 2.5, 3]", "[1.5, 25, 3]")],
        34,
        &format!("{levels}.mar_deg[1]"),
        &["0.005 to 20", "found 25"],
    );
    assert_only(&[("[1.5, 2.5, 3]", "[1.5, 2.5, 1.5]")], 34, &format!("{levels}.mar_deg[2]"), &["once", "1.5 again"]);
    assert_only(&[("[1.5, 2.5, 3]", "[]")], 34, &format!("{levels}.mar_deg"), &["empty list"]);
    assert_only(
        &[("[1.5, 2.5, 3]", "[1.5, 0.03]")],
        34,
        &format!("{levels}.mar_deg[1]"),
        &["can show at 5°", "0.0400", "0.03"],
    );
    assert_only(
        &[("[5, 10]", "[5, 25]")],
        33,
        &format!("{levels}.eccentricity_deg[1]"),
        &["on the display", "found 25°"],
    );
    assert_only(
        &[(r#""repetitions": 4"#, r#""repetitions": 90000"#)],
        36,
        "blocks[0].procedure.repetitions",
        &["540000"],
    );

    let quest = "blocks[1].procedure";
    assert_only(&[("[0, 5, 10]", "[0, 5, 40]")], 46, &format!("{quest}.eccentricity.values[2]"), &["on the display"]);
    assert_only(&[("[0, 5, 10]", "[0, 5, 5]")], 46, &format!("{quest}.eccentricity.values[2]"), &["once"]);
    assert_only(
        &[(r#""values": [0"#, r#""parameter": "ecc_deg", "values": [0"#)],
        46,
        &format!("{quest}.eccentricity.parameter"),
        &["numeric parameter of the renderer \"ring\"", "found \"ecc_deg\""],
    );
    assert_only(
        &[(r#""min": 0.05, "max""#, r#""parameter": "eccentricity_deg", "min": 0.05, "max""#)],
        47,
        &format!("{quest}.mar.parameter"),
        &["another parameter"],
    );
    assert_only(&[(r#""max": 3.0"#, r#""max": 30.0"#)], 47, &format!("{quest}.mar.max"), &["0.005 to 20", "found 30"]);
    assert_only(
        &[(r#""min": 0.05, "max": 3.0"#, r#""min": 0.005, "max": 0.0401"#)],
        46,
        &format!("{quest}.eccentricity.values[0]"),
        &["some of the MARs (0.0402° per cycle or coarser)", "found 0° with none"],
    );
}

#[test]
fn a_table_that_no_memory_holds_is_refused() {
    assert_only(
        &[
            (r#""min": 0.005, "max": 0.08, "steps": 10"#, r#""min": 0.005, "max": 0.08, "steps": 1000"#),
            (r#""steps": 24"#, r#""steps": 1000"#),
        ],
        44,
        "blocks[1].procedure",
        &["20000000 cells", "1000 m"],
    );
}

#[test]
fn phases_last_a_frame_at_least() {
    assert_only(
        &[(r#""gap_s": 0.3"#, r#""gap_s": 0.005"#)],
        28,
        "blocks[0].protocol.gap_s",
        &["at least one frame (0.0069 s at 144 Hz)", "found 0.005"],
    );
    // At 60 Hz the same study has other limits.
    let slow = Display::named("tursun-2019-32in").expect("ships");
    let text = edited(&[(r#""gap_s": 0.3"#, r#""gap_s": 0.01"#)]);
    assert!(parse(&text).is_ok());
    let error = parse_study("s", &text, &catalogue(), Some(&slow)).expect_err("too short at 60 Hz");
    assert_eq!(error.list[0].field, "blocks[0].protocol.gap_s");
}

#[test]
fn blocks_there_must_be_and_not_only_practice() {
    let main = STUDY.find("    {\n      \"name\": \"main\"").expect("there");
    let only_practice = format!("{}\n  ]\n}}", STUDY[..main].trim_end().trim_end_matches(','));
    let found = mistakes(&only_practice);
    assert_eq!((found[0].0, found[0].1.as_str(), found.len()), (19, "blocks", 1));

    let blocks = STUDY.find("\"blocks\"").expect("there");
    let found = mistakes(&format!("{}\"blocks\": []\n}}", &STUDY[..blocks]));
    assert_eq!((found[0].0, found[0].1.as_str()), (19, "blocks"));
    assert!(found[0].2.contains("at least one block"));
}

#[test]
fn the_gaze_is_on_the_display() {
    assert_only(&[("[0, 0]", "[0, 15]")], 7, "gaze.fixation_deg", &["on the display", "±14.16°", "[0, 15]"]);
    assert_only(&[("    \"gate_deg\": 2.0,\n", "")], 8, "gaze.gate_grace_s", &["gate_deg"]);
}

#[test]
fn a_display_there_must_be() {
    assert_only(&[("  \"display\": \"tursun-2019-27in\",\n", "")], 1, "display", &["--display", "tursun-2019-27in"]);
    assert_only(&[(r#""tursun-2019-27in""#, r#""tursun-2019-27""#)], 5, "display", &["guenter-2012", "did you mean"]);
    assert_only(
        &[(r#""tursun-2019-27in""#, r#"{ "name": "x", "resolution_px": [2560, 1440], "distance_mm": 665 }"#)],
        5,
        "display.size_mm",
        &["a list of 2 numbers in millimetres", "no such key"],
    );
    assert_only(&[(r#""tursun-2019-27in""#, "27")], 5, "display", &["a string or an object with name", "found 27"]);
}

#[test]
fn a_display_file_reports_every_mistake() {
    let text = "{\n \"name\": \"desk\",\n \"resolution_px\": [0, 1080],\n \"size_mm\": [510, -1],\n \"refresh_hz\": \"60\",\n \"colour\": 1\n}";
    let error = parse_display("desk.json", text).expect_err("five mistakes");
    let places: Vec<(usize, &str)> = error.list.iter().map(|m| (m.line, m.field.as_str())).collect();
    assert_eq!(
        places,
        [(1, "distance_mm"), (3, "resolution_px[0]"), (4, "size_mm[1]"), (5, "refresh_hz"), (6, "colour")]
    );

    let text = "{\"name\": \"desk\", \"resolution_px\": [1920, 1080], \"size_mm\": [510, 286.9], \"distance_mm\": 590, \
                \"refresh_hz\": 120, \"peak_cd_m2\": 250}";
    let display = parse_display("desk.json", text).expect("complete");
    assert_eq!(display.resolution_px(), [1920, 1080]);
    assert!((display.refresh_hz() - 120.0).abs() < 1e-12);
    assert_eq!(display.peak_cd_m2(), Some(250.0));
}

#[test]
fn a_display_file_states_its_transfer() {
    let desk = |transfer: &str| {
        format!(
            "{{\n\"name\": \"desk\", \"resolution_px\": [1920, 1080], \"size_mm\": [510, 286.9],\n\
             \"distance_mm\": 590,\n\"transfer\": {transfer}\n}}"
        )
    };
    let read = |transfer: &str| parse_display("desk.json", &desk(transfer));
    let gamma = read("{ \"gamma\": [2.2, 2.2, 2.25] }").expect("complete");
    assert_eq!(*gamma.transfer(), Transfer::Gamma([2.2, 2.2, 2.25]));
    let table = r#"{ "levels": [0, 128, 255], "red": [0.1, 8, 40], "green": [0.2, 30, 150], "blue": [0.1, 3, 12] }"#;
    let table = read(table).expect("complete");
    assert!((table.transfer().light_from_signal(1, 128.0 / 255.0) - 0.2).abs() < 1e-12);

    for (transfer, fields) in [
        (r#"{ "gamma": [2.2, 0, 5] }"#, vec!["gamma[1]", "gamma[2]"]),
        (r#"{ "gama": [2.2, 2.2, 2.2] }"#, vec!["", "gama"]),
        (r#"{}"#, vec![""]),
        (r#"{ "gamma": [2, 2, 2], "levels": [0, 255] }"#, vec![""]),
        (r#"{ "levels": [0, 255], "red": [0, 1], "blue": [0, "1"] }"#, vec!["blue[1]", "green"]),
        (
            r#"{ "levels": [0, 9, 255], "red": [0, 1], "green": [0, 2, 1], "blue": [0, 0, 1] }"#,
            vec!["red", "green[2]", "blue[1]"],
        ),
    ] {
        let found: Vec<String> =
            read(transfer).expect_err(transfer).list.iter().map(|mistake| mistake.field.clone()).collect();
        let mut expected: Vec<String> = fields
            .iter()
            .map(|key| if key.is_empty() { "transfer".to_owned() } else { format!("transfer.{key}") })
            .collect();
        expected.sort();
        let mut sorted = found.clone();
        sorted.sort();
        assert_eq!(sorted, expected, "{transfer}");
    }
}
