//! Factors, orders, groups and sittings: what a file says, what the plan has, and every mistake by name.

use super::{assert_only, edited, mistakes, parse};
use crate::design::assignment::{Assignment, AssignmentError};
use crate::study::plan::*;

/// The main block with factors, in place of its QUEST+ procedure.
const CROSSED: (&str, &str) = (
    r#""procedure": {
        "kind": "quest-plus",
        "eccentricity": { "values": [0, 5, 10] },
        "mar": { "min": 0.05, "max": 3.0, "steps": 24 },
        "prior": {
          "m": { "min": 0.005, "max": 0.08, "steps": 10 },
          "lapse": [0, 0.02]
        },
        "stop": { "max_trials": 240, "min_trials": 80, "m_relative_sd": 0.08 }
      }"#,
    r#""factors": [
        { "name": "image", "levels": [
          { "name": "coffee", "scene_parameters": { "image": "coffee" } },
          { "name": "grass", "scene_parameters": { "image": "grass" } },
          { "name": "noise", "scene": "noise" } ] },
        { "name": "gaze", "levels": [
          { "name": "fixed", "fixation": { "kind": "cross" } },
          { "name": "moving", "fixation": { "kind": "moving", "reach_deg": [10, 5] }, "foveate": "target" } ] }
      ],
      "procedure": { "kind": "constant", "levels": { "mar_deg": [0.5, 1] }, "repetitions": 6 }"#,
);

/// The crossed study with further edits.
fn crossed(edits: &[(&str, &str)]) -> String {
    let mut all = vec![CROSSED];
    all.extend_from_slice(edits);
    edited(&all)
}

fn main_block(plan: &Plan) -> &BlockPlan {
    plan.blocks.iter().find(|block| block.name == "main").expect("there")
}

#[test]
fn factors_are_crossed_into_cells_that_set_what_their_levels_say() {
    let plan = parse(&crossed(&[])).expect("valid");
    let block = main_block(&plan);
    let names: Vec<&str> = block.cells.iter().map(|cell| cell.condition.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "photo:coffee,fixed",
            "photo:coffee,moving",
            "photo:grass,fixed",
            "photo:grass,moving",
            "photo:noise,fixed",
            "photo:noise,moving"
        ]
    );
    assert_eq!(block.max_trials(), 6 * 2 * 6);
    let cell = &block.cells[3];
    assert_eq!((cell.factors["image"].as_str(), cell.factors["gaze"].as_str()), ("grass", "moving"));
    assert_eq!(cell.condition.foveation, FoveationCentre::Target);
    let Fixation::Moving(target) = cell.condition.fixation else { panic!("moves") };
    assert_eq!(target.reach_deg, [10.0, 5.0]);
    // Another scene begins with its own defaults, not with the photograph's parameters.
    assert!(block.cells[4].condition.scene_parameters.is_empty());
}

#[test]
fn both_orders_double_the_trials() {
    let text = crossed(&[("\"break_every_trials\": 60,", "\"presentation\": \"both\",")]);
    assert_eq!(main_block(&parse(&text).expect("valid")).max_trials(), 2 * 72);
}

#[test]
fn nested_levels_stand_only_within_their_own() {
    let text = crossed(&[
        (r#"{ "name": "gaze", "#, r#"{ "name": "size", "#),
        (
            r#"{ "name": "fixed", "fixation": { "kind": "cross" } },"#,
            r#"{ "name": "small", "within": { "image": ["coffee"] }, "scene_parameters": { "scale": 1 } },"#,
        ),
        (
            r#"{ "name": "moving", "fixation": { "kind": "moving", "reach_deg": [10, 5] }, "foveate": "target" }"#,
            r#"{ "name": "large", "within": { "image": ["coffee"] }, "scene_parameters": { "scale": 2 } }"#,
        ),
        (r#""break_every_trials": 60,"#, r#""unbalanced": true,"#),
    ]);
    let plan = parse(&text).expect("valid");
    let names: Vec<&str> = main_block(&plan).cells.iter().map(|cell| cell.condition.name.as_str()).collect();
    assert_eq!(names, ["photo:coffee,small", "photo:coffee,large", "photo:grass", "photo:noise"]);
    // Without that word the same design is a mistake.
    let found = mistakes(&text.replace(r#""unbalanced": true,"#, ""));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].2.contains("coffee in 2, grass in 1, noise in 1"), "{found:?}");
}

#[test]
fn bad_designs_are_named_at_their_lines() {
    let only = |edits: &[(&str, &str)], field: &str, words: &[&str]| {
        let text = crossed(edits);
        let found = mistakes(&text);
        assert_eq!(found.len(), 1, "{found:#?}");
        assert_eq!(found[0].1, field, "{found:?}");
        assert!(found[0].2.starts_with("expected "), "{found:?}");
        words.iter().for_each(|word| assert!(found[0].2.contains(word), "{word}: {found:?}"));
    };
    only(
        &[(r#""name": "gaze", "levels""#, r#""name": "image", "levels""#)],
        "blocks[1].factors[1].name",
        &["a name of its own", "image"],
    );
    only(
        &[(r#"{ "name": "fixed", "fixation""#, r#"{ "name": "fixed", "within": { "imag": ["grass"] }, "fixation""#)],
        "blocks[1].factors[1].levels[0].within.imag",
        &["listed before", "did you mean \"image\""],
    );
    only(
        &[(r#"{ "name": "fixed", "fixation""#, r#"{ "name": "fixed", "within": { "image": ["tree"] }, "fixation""#)],
        "blocks[1].factors[1].levels[0]",
        &["some trial uses"],
    );
    only(
        &[(r#""reach_deg": [10, 5]"#, r#""reach_deg": [40, 5]"#)],
        "blocks[1].factors[1].levels[1].fixation.reach_deg",
        &["on the display", "40"],
    );
    only(
        &[(r#""scene_parameters": { "image": "grass" }"#, r#""scene_parameters": { "image": "gras" }"#)],
        "blocks[1].factors[0].levels[1].scene_parameters.image",
        &["grass", "gras"],
    );
    only(
        &[(r#""break_every_trials": 60,"#, r#""order": { "no_repeat": ["images"] },"#)],
        "blocks[1].order.no_repeat[0]",
        &["one of the block's factors", "gaze, image"],
    );
    only(
        &[(r#""break_every_trials": 60,"#, r#""order": { "groups": "latin-square" },"#)],
        "blocks[1].order.groups",
        &["grouped_by"],
    );
    only(
        &[(r#""break_every_trials": 60,"#, r#""order": { "grouped_by": ["image"], "groups": "latin" },"#)],
        "blocks[1].order.groups",
        &["\"shuffled\" or \"listed\" or \"latin-square\""],
    );
    only(
        &[(r#""break_every_trials": 60,"#, r#""presentation": "either","#)],
        "blocks[1].presentation",
        &["random", "both"],
    );
    only(
        &[(r#""break_every_trials": 60,"#, r#""criterion": { "share_correct": 0.8 },"#)],
        "blocks[1].criterion",
        &["practice"],
    );
    only(
        &[(
            r#"{ "name": "fixed", "fixation": { "kind": "cross" } },
          { "name": "moving", "fixation": { "kind": "moving", "reach_deg": [10, 5] }, "foveate": "target" }"#,
            r#"{ "name": "fixed" }, { "name": "moving" }"#,
        )],
        "blocks[1].factors[1].levels",
        &["no trial would use them"],
    );
}

#[test]
fn a_constraint_that_no_order_keeps_is_refused() {
    let text = crossed(&[
        (r#""break_every_trials": 60,"#, r#""order": { "no_repeat": ["gaze"] }, "unbalanced": true,"#),
        (r#"{ "name": "fixed", "fixation""#, r#"{ "name": "fixed", "within": { "image": ["grass"] }, "fixation""#),
    ]);
    let found = mistakes(&text);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!(found[0].1, "blocks[1].order.no_repeat");
}

#[test]
fn groups_run_their_own_blocks() {
    let groups = r#""groups": [ { "name": "a", "blocks": ["practice", "main"] }, { "name": "b", "blocks": ["main"] } ],
  "blocks": ["#;
    let plan = parse(&edited(&[("\"blocks\": [", groups)])).expect("valid");
    let blocks = |group: &str| -> Vec<String> {
        let assignment = Assignment { group: Some(group.to_owned()), ..Assignment::default() };
        plan.assigned(&assignment).expect("fits").blocks.into_iter().map(|block| block.name).collect()
    };
    assert_eq!(blocks("a"), ["practice", "main"]);
    assert_eq!(blocks("b"), ["main"]);
    let none = plan.assigned(&Assignment::default()).expect_err("needs a group");
    assert_eq!(none, AssignmentError::NoGroup { known: "a, b".to_owned() });
    let unknown = plan.assigned(&Assignment { group: Some("c".to_owned()), ..Assignment::default() });
    assert!(matches!(unknown, Err(AssignmentError::Group { .. })));
}

#[test]
fn bad_groups_are_named() {
    let with = |groups: &str| format!("\"groups\": {groups},\n  \"blocks\": [");
    let one = with(r#"[ { "name": "a", "blocks": ["practice", "main"] } ]"#);
    assert_only(&[("\"blocks\": [", &one)], 19, "groups", &["at least two groups"]);
    let unknown = with(r#"[ { "name": "a", "blocks": ["practice", "mian"] }, { "name": "b", "blocks": ["main"] } ]"#);
    assert_only(&[("\"blocks\": [", &unknown)], 19, "groups[0].blocks[1]", &["did you mean \"main\""]);
    let unused = with(r#"[ { "name": "a", "blocks": ["main"] }, { "name": "b", "blocks": ["main"] } ]"#);
    assert_only(&[("\"blocks\": [", &unused)], 21, "blocks[0]", &["some group runs", "practice"]);
}

#[test]
fn sittings_share_repetitions_or_the_levels_of_a_factor() {
    let with = |sittings: &str| format!("\"sittings\": {sittings},\n  \"blocks\": [");
    let plan = parse(&crossed(&[("\"blocks\": [", &with(r#"{ "count": 3 }"#))])).expect("valid");
    let mut trials = 0;
    for sitting in 1..=3 {
        let part = plan.assigned(&Assignment { sitting, ..Assignment::default() }).expect("fits");
        assert_eq!(part.blocks.len(), 2, "practice comes in every sitting");
        trials += main_block(&part).max_trials();
    }
    assert_eq!(trials, 72);
    assert!(plan.assigned(&Assignment { sitting: 4, ..Assignment::default() }).is_err());

    let split = with(r#"{ "count": 3, "split_by": "image" }"#);
    let plan = parse(&crossed(&[("\"blocks\": [", &split)])).expect("valid");
    let mut seen = Vec::new();
    for sitting in 1..=3 {
        let part = plan.assigned(&Assignment { sitting, number: 1, ..Assignment::default() }).expect("fits");
        let mut images: Vec<String> = main_block(&part).cells.iter().map(|c| c.factors["image"].clone()).collect();
        images.dedup();
        assert_eq!(images.len(), 1);
        seen.extend(images);
    }
    // Observer number 1 begins one further.
    assert_eq!(seen, ["grass", "noise", "coffee"]);
}

#[test]
fn uneven_sittings_are_refused() {
    let with = |sittings: &str| format!("\"sittings\": {sittings},\n  \"blocks\": [");
    let found = mistakes(&crossed(&[("\"blocks\": [", &with(r#"{ "count": 4 }"#))]));
    assert_eq!(found[0].1, "sittings.count");
    assert!(found[0].2.contains("6 repetitions"), "{found:?}");
    let found = mistakes(&crossed(&[("\"blocks\": [", &with(r#"{ "count": 2, "split_by": "image" }"#))]));
    assert_eq!(found[0].1, "sittings.split_by");
    let found = mistakes(&edited(&[("\"blocks\": [", &with(r#"{ "count": 2 }"#))]));
    assert!(found[0].2.contains("adaptive"), "{found:?}");
}

#[test]
fn a_latin_square_lists_groups_in_the_observers_row() {
    let order = r#""order": { "grouped_by": ["image"], "groups": "latin-square" },"#;
    let plan = parse(&crossed(&[(r#""break_every_trials": 60,"#, order)])).expect("valid");
    let mut rows = Vec::new();
    for number in 0..6 {
        let part = plan.assigned(&Assignment { number, ..Assignment::default() }).expect("fits");
        let block = main_block(&part);
        assert_eq!(block.order.groups, GroupOrder::Listed);
        let mut images: Vec<String> = block.cells.iter().map(|cell| cell.factors["image"].clone()).collect();
        images.dedup();
        assert_eq!(images.len(), 3);
        rows.push(images);
    }
    for place in 0..3 {
        for image in ["coffee", "grass", "noise"] {
            assert_eq!(rows.iter().filter(|row| row[place] == image).count(), 2);
        }
    }
}

#[test]
fn a_pilot_run_is_short() {
    let plan = parse(&crossed(&[("\"blocks\": [", "\"pilot\": { \"trials\": 4 },\n  \"blocks\": [")])).expect("valid");
    let part = plan.assigned(&Assignment { pilot: true, ..Assignment::default() }).expect("fits");
    assert_eq!(main_block(&part).max_trials(), 4);
    assert_eq!(part.blocks[0].max_trials(), 4);
}
