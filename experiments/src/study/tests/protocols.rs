//! Every protocol as a study writes it: what it becomes, what is said of it, and its mistakes. `machines` runs what they
//! become.

use super::hostile::collect_pointers;
use super::{mistakes, parse};
use crate::study::plan::{AdjustmentStep, BlockPlan, Finer, ItemKind, OnGazeLeft, ProtocolPlan, Task, Wanted};
use crate::study::{DEFAULT_FEEDBACK_S, describe, study_schema};
use proptest::prelude::*;

/// One study for each protocol; the protocol starts at line 16. At 60 Hz a frame lasts 0.0167 s.
fn study(protocol: &str) -> String {
    format!(
        r#"{{
  "format": 1,
  "name": "asking",
  "title": "How a trial asks",
  "display": "tursun-2019-32in",
  "conditions": {{ "photo": {{ "scene": "photo", "renderer": "ring" }} }},
  "blocks": [
    {{
      "name": "main",
      "condition": "photo",
      "procedure": {{
        "kind": "constant",
        "levels": {{ "mar_deg": [1.5, 3] }}, "repetitions": 2
      }},
      "protocol":
{protocol}
    }}
  ]
}}"#
    )
}

const TWO_INTERVAL: &str = r#"{ "kind": "two-interval",
  "fixation_s": 0.5, "interval_s": 0.3, "gap_s": 0.3, "answer_timeout_s": 5,
  "asks_for": "reference" }"#;

/// Tursun 2019, §5, which gives no durations.
const TOGGLE: &str = r#"{ "kind": "toggle",
  "fixation_s": 0.5,
  "switch_s": 0.4 }"#;

/// Guenter 2012, §5: what is not written is the paper's.
const PAIR: &str = r#"{ "kind": "pair",
  "feedback_s": 0.7 }"#;

const RAMP: &str = r#"{ "kind": "ramp",
  "parameter": "mar_deg",
  "from": 0.5,
  "finer": "down" }"#;

const SLIDER: &str = r#"{ "kind": "slider",
  "parameter": "width_deg",
  "values": [30, 20, 12, 8, 5, 2],
  "reference_s": 8 }"#;

/// Weier 2016, §4.2.1: Q1 and Q2; the third is ours.
const LIKERT: &str = r#"{ "kind": "likert",
  "sequence_s": 8,
  "items": [
    { "kind": "scale", "name": "artefact-free", "question": "The sequence was free of visual artefacts." },
    { "kind": "choice", "name": "confidence", "question": "How sure?", "options": ["not", "rather", "very"] },
    { "kind": "number", "name": "artefacts_seen", "question": "How many?", "min": 1, "max": 10, "whole": true }
  ] }"#;

/// Stengel 2016, §6.1, with two of our ring's parameters.
const ADJUSTMENT: &str = r#"{ "kind": "adjustment",
  "parameters": [
    { "parameter": "mar_deg", "min": 0.5, "max": 8, "multiply": 1.25 },
    { "parameter": "width_deg", "min": 0, "max": 20, "add": 2 }
  ] }"#;

/// Stengel 2016, §6.2, T1: a track of 20 s.
const PAIRED_TASK: &str = r#"{ "kind": "paired-task",
  "task": { "kind": "count", "min": 5, "max": 12 },
  "sequence_s": 20,
  "marker_s": 2 }"#;

pub(super) const ALL: [&str; 8] = [TWO_INTERVAL, TOGGLE, PAIR, RAMP, SLIDER, LIKERT, ADJUSTMENT, PAIRED_TASK];

pub(super) fn block(protocol: &str) -> BlockPlan {
    let plan = parse(&study(protocol)).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    plan.blocks.into_iter().next().expect("a block")
}

#[test]
fn every_protocol_parses_and_describes_itself() {
    let schema = jsonschema::validator_for(&study_schema()).expect("a schema");
    // Seconds of a trial with answers of one second, by hand; words that its description must have.
    let expected: [(f64, &[&str]); 8] = [
        (0.5 + 2.0 * 0.3 + 0.3 + 1.0, &["two intervals", "which is the reference", "within 5 s"]),
        (0.5 + 3.0 * 1.4 + 1.0, &["toggled", "\"Which one is not degraded: A or B?\"", "0.4 s of grey", "hidden"]),
        (2.0 * 8.0 + 0.5 + 1.0, &["pair", "8 s each", "black 0.5 s", "without limit"]),
        (5.0 * 5.0 + 4.0 * 0.5 + 1.0, &["ramp of mar_deg", "smaller is finer", "5 steps of 5 s"]),
        (8.0 + 3.0 + 2.0 * 2.0 + 1.0, &["slider over 6 values of width_deg from 30 to 2", "reference 8 s"]),
        (8.0 + 3.0, &["artefact-free (-3 to 3)", "confidence (3 options)", "artefacts_seen (a number from 1 to 10)"]),
        (20.0, &["mar_deg from 0.5 to 8 in factors of 1.25", "width_deg from 0 to 20 in steps of 2"]),
        (1.0 + 2.0 * 22.0 + 2.0 + 1.0, &["count 5 to 12 spheres", "20 s each", "mark 2 s"]),
    ];
    for (protocol, (trial_s, words)) in ALL.into_iter().zip(expected) {
        let text = study(protocol);
        let plan = parse(&text).unwrap_or_else(|mistakes| panic!("{mistakes}"));
        assert!(schema.is_valid(&serde_json::from_str(&text).expect("JSON")), "{protocol}");
        let description = describe(&plan);
        let (kind, words_found) = (plan.blocks[0].protocol.kind(), &description.blocks[0].protocol);
        println!("{kind:<13} {trial_s:>5.1} s  {words_found}");
        assert!(protocol.contains(&format!("\"kind\": \"{kind}\"")));
        assert!((description.blocks[0].trial_s - trial_s).abs() < 1e-9, "{kind}: {}", description.blocks[0].trial_s);
        for word in words {
            assert!(words_found.contains(word), "{kind}: {word:?} is not in {words_found:?}");
        }
        let text = description.to_string();
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    }
}

#[test]
fn what_a_study_does_not_say_is_the_papers_or_plain() {
    let ProtocolPlan::TwoInterval(plan) = block(TWO_INTERVAL).protocol else { panic!() };
    assert_eq!(plan.wanted, Wanted::Reference);
    assert_eq!(plan.question, "Which one was not degraded: the first or the second?");
    let ProtocolPlan::Toggle(plan) = block(TOGGLE).protocol else { panic!() };
    assert_eq!((plan.wanted, plan.on_gaze_left, plan.most_switches), (Wanted::Reference, OnGazeLeft::Hide, None));
    let degraded = block(&TOGGLE.replace("0.4", "0.4, \"asks_for\": \"degraded\", \"on_gaze_left\": \"abort\""));
    let ProtocolPlan::Toggle(plan) = degraded.protocol else { panic!() };
    assert_eq!((plan.wanted, plan.on_gaze_left), (Wanted::Degraded, OnGazeLeft::Abort));
    assert_eq!(plan.question, "Which one is degraded: A or B?");
    let pair = block(PAIR);
    assert!((pair.feedback_s - 0.7).abs() < 1e-12);
    let ProtocolPlan::Pair(plan) = pair.protocol else { panic!() };
    assert_eq!((plan.fixation_s, plan.sequence_s, plan.black_s), (None, 8.0, 0.5));
    assert_eq!(plan.on_gaze_left, OnGazeLeft::Ignore);
    let ramp = block(RAMP);
    assert_eq!((ramp.protocol.needs_level(), ramp.protocol.parameters()), (Some("mar_deg"), vec!["mar_deg"]));
    assert!((ramp.feedback_s - DEFAULT_FEEDBACK_S).abs() < 1e-12);
    let ProtocolPlan::Ramp(plan) = ramp.protocol else { panic!() };
    assert_eq!((plan.steps, plan.step_s, plan.black_s, plan.finer), (5, 5.0, 0.5, Finer::Down));
    let slider = block(SLIDER).protocol;
    assert_eq!((slider.needs_level(), slider.parameters()), (None, vec!["width_deg"]));
    let ProtocolPlan::Likert(plan) = block(LIKERT).protocol else { panic!() };
    let ItemKind::Scale { low, high, low_anchor, high_anchor } = &plan.items[0].kind else { panic!() };
    // Weier 2016, §4.2.1.
    assert_eq!(
        (*low, *high, low_anchor.as_str(), high_anchor.as_str()),
        (-3, 3, "strongly disagree", "strongly agree")
    );
    let adjustment = block(ADJUSTMENT).protocol;
    assert_eq!(adjustment.parameters(), ["mar_deg", "width_deg"]);
    let ProtocolPlan::Adjustment(plan) = adjustment else { panic!() };
    assert_eq!(plan.parameters[0].step, AdjustmentStep::Multiply(1.25));
    assert!((plan.parameters[0].middle() - 2.0).abs() < 1e-12 && (plan.parameters[1].middle() - 10.0).abs() < 1e-12);
    let ProtocolPlan::PairedTask(plan) = block(PAIRED_TASK).protocol else { panic!() };
    let Task::Count { question, min, max, .. } = &plan.task else { panic!() };
    assert_eq!((question.as_str(), *min, *max), ("How many spheres were there?", 5, 12));
    let follow = PAIRED_TASK.replace(r#""count", "min": 5, "max": 12"#, r#""follow""#);
    let moving =
        study(&follow).replace(r#""renderer": "ring""#, r#""renderer": "ring", "fixation": { "kind": "moving" }"#);
    let plan = parse(&moving).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    assert!(plan.blocks[0].protocol.needs_moving_target() && !block(PAIRED_TASK).protocol.needs_moving_target());
    // With a fixed mark there is nothing to follow.
    let found = parse(&study(&follow)).expect_err("nothing moves");
    assert_eq!(found.list.iter().map(|m| m.field.as_str()).collect::<Vec<_>>(), ["blocks[0].condition"]);
}

#[test]
fn a_pilot_shortens_what_lasts_and_not_what_the_observer_ends() {
    let durations = ALL.map(|protocol| {
        block(protocol).protocol.stimulus_durations_mut().into_iter().map(|duration| *duration).collect::<Vec<f64>>()
    });
    let expected: [&[f64]; 8] = [&[0.3], &[], &[8.0], &[5.0], &[8.0], &[8.0], &[], &[20.0]];
    assert_eq!(durations, expected.map(<[f64]>::to_vec));
    let mut compared = block(&SLIDER.replace("\"reference_s\": 8", "\"reference_s\": 8, \"compare_s\": 2"));
    assert_eq!(compared.protocol.stimulus_durations_mut(), [&mut 8.0, &mut 2.0]);
}

/// The only mistake of a protocol after an edit, at a line counted from the protocol's first, and at its field.
#[track_caller]
fn assert_only(protocol: &str, edit: (&str, &str), line: usize, field: &str, words: &[&str]) {
    assert_eq!(protocol.matches(edit.0).count(), 1, "{:?} must occur once", edit.0);
    let found = mistakes(&study(&protocol.replace(edit.0, edit.1)));
    let field = format!("blocks[0].protocol.{field}");
    let places: Vec<(usize, &str)> = found.iter().map(|m| (m.0, m.1.as_str())).collect();
    assert_eq!(places, [(15 + line, field.as_str())], "{found:#?}");
    for word in words {
        assert!(found[0].2.contains(word), "{word:?} is not in {:?}", found[0].2);
    }
}

#[test]
fn words_that_mean_nothing_are_reported_with_those_that_do() {
    let asks = r#""asks_for": "reference""#;
    assert_only(
        TWO_INTERVAL,
        (asks, r#""asks_for": "refrence""#),
        3,
        "asks_for",
        &["\"degraded\"", "did you mean \"reference\"?"],
    );
    let switch = "\"switch_s\": 0.4";
    let with = |rest: &str| format!("{switch}, {rest}");
    assert_only(
        TOGGLE,
        (switch, &with(r#""on_gaze_left": "hid""#)),
        3,
        "on_gaze_left",
        &["\"abort\"", "mean \"hide\""],
    );
    assert_only(RAMP, (r#""down""#, r#""sideways""#), 4, "finer", &["\"up\" or \"down\"", "\"sideways\""]);
    assert_only(PAIR, ("\"pair\"", "\"pairs\""), 1, "kind", &["\"slider\"", "did you mean \"pair\"?"]);
    assert_only(PAIRED_TASK, ("\"count\"", "\"cuont\""), 2, "task.kind", &["\"free-viewing\"", "mean \"count\"?"]);
}

#[test]
fn what_lasts_a_set_time_cannot_hide() {
    for (protocol, edit, line) in [
        (PAIR, "\"feedback_s\": 0.7", 2),
        (RAMP, "\"from\": 0.5", 3),
        (LIKERT, "\"sequence_s\": 8", 2),
        (PAIRED_TASK, "\"marker_s\": 2", 4),
    ] {
        let with = format!("{edit}, \"on_gaze_left\": \"hide\"");
        assert_only(protocol, (edit, &with), line, "on_gaze_left", &["\"ignore\"", "\"abort\"", "\"hide\""]);
        let aborting = parse(&study(&protocol.replace(edit, &with.replace("hide", "abort")))).expect("no mistake");
        assert!(describe(&aborting).blocks[0].protocol.contains("aborted when gaze leaves"));
    }
}

#[test]
fn phases_last_a_frame_at_least() {
    for (protocol, edit, new, line, field) in [
        (TOGGLE, "\"switch_s\": 0.4", "\"switch_s\": 0.01", 3, "switch_s"),
        (PAIR, "\"feedback_s\": 0.7", "\"black_s\": 0.001", 2, "black_s"),
        (RAMP, "\"from\": 0.5", "\"from\": 0.5, \"step_s\": 0.01", 3, "step_s"),
        (SLIDER, "\"reference_s\": 8", "\"reference_s\": 8, \"compare_s\": 0.01", 4, "compare_s"),
        (LIKERT, "\"sequence_s\": 8", "\"sequence_s\": 0.01", 2, "sequence_s"),
        (PAIRED_TASK, "\"marker_s\": 2", "\"marker_s\": 0.01", 4, "marker_s"),
    ] {
        assert_only(protocol, (edit, new), line, field, &["at least one frame", "60 Hz"]);
    }
}

#[test]
fn parameters_exist_and_values_are_in_their_bounds() {
    let mar = r#""parameter": "mar_deg""#;
    assert_only(RAMP, (mar, r#""parameter": "mar""#), 2, "parameter", &["numeric parameter", "mean \"mar_deg\"?"]);
    assert_only(RAMP, ("0.5", "50"), 3, "from", &["0.005 to 20", "found 50"]);
    assert_only(SLIDER, ("width_deg", "with_deg"), 2, "parameter", &["mean \"width_deg\"?"]);
    assert_only(SLIDER, ("[30,", "[70,"), 3, "values[0]", &["0 to 60", "found 70"]);
    assert_only(ADJUSTMENT, ("\"mar_deg\"", "\"mar\""), 3, "parameters[0].parameter", &["mean \"mar_deg\"?"]);
    assert_only(ADJUSTMENT, ("\"max\": 20", "\"max\": 80"), 4, "parameters[1].max", &["0 to 60"]);
}

#[test]
fn ramps_sliders_and_adjustments_have_somewhere_to_go() {
    assert_only(RAMP, ("0.5", "0.5, \"steps\": 1"), 3, "steps", &["from 2"]);
    let values = "[30, 20, 12, 8, 5, 2]";
    assert_only(SLIDER, (values, "[30]"), 3, "values", &["at least two"]);
    assert_only(SLIDER, (values, "[]"), 3, "values", &["empty"]);
    assert_only(SLIDER, (values, "[30, 20, 20]"), 3, "values[2]", &["once", "20 again"]);
    assert_only(SLIDER, (values, "[30, 20, 25, 10]"), 3, "values[2]", &["fall throughout", "less than 20", "found 25"]);
    assert_only(SLIDER, (values, "[3, 20, 10]"), 3, "values[2]", &["rise throughout", "more than 20"]);
    assert_only(ADJUSTMENT, ("1.25", "1"), 3, "parameters[0].multiply", &["above 1", "found 1"]);
    assert_only(ADJUSTMENT, ("\"add\": 2", "\"add\": 0"), 4, "parameters[1].add", &["above 0", "found 0"]);
    assert_only(ADJUSTMENT, ("\"add\": 2", "\"add\": 21"), 4, "parameters[1].add", &["from 0 to 20", "found 21"]);
    assert_only(ADJUSTMENT, ("\"add\": 2", "\"add\": 1e-9"), 4, "parameters[1].add", &["10000 moves"]);
    assert_only(ADJUSTMENT, ("1.25", "1.0000001"), 3, "parameters[0].multiply", &["10000 moves"]);
    assert_only(ADJUSTMENT, (", \"add\": 2", ""), 4, "parameters[1].add", &["\"multiply\"", "neither"]);
    assert_only(ADJUSTMENT, ("\"add\": 2", "\"add\": 2, \"multiply\": 2"), 4, "parameters[1].multiply", &["both"]);
    assert_only(ADJUSTMENT, ("\"add\": 2", "\"multiply\": 2"), 4, "parameters[1].min", &["above 0", "found 0"]);
    assert_only(ADJUSTMENT, ("\"min\": 0.5", "\"min\": 8"), 3, "parameters[0].max", &["more than min (8)"]);
    assert_only(ADJUSTMENT, ("\"mar_deg\"", "\"width_deg\""), 4, "parameters[1].parameter", &["once"]);
    assert_only(PAIRED_TASK, ("\"min\": 5", "\"min\": 12"), 2, "task.max", &["more than min (12)"]);
    assert_only(TOGGLE, ("0.4", "0.4, \"most_switches\": 0"), 3, "most_switches", &["from 1"]);
}

#[test]
fn items_have_names_of_their_own_and_a_digit_for_every_step() {
    let scale = "\"name\": \"artefact-free\"";
    let with = |rest: &str| format!("{scale}, {rest}");
    assert_only(LIKERT, (scale, "\"name\": \"Q1\""), 4, "items[0].name", &["a-z", "\"Q1\""]);
    assert_only(LIKERT, ("\"confidence\"", "\"artefact-free\""), 5, "items[1].name", &["as in an earlier item"]);
    assert_only(LIKERT, (scale, &with("\"low\": 3")), 4, "items[0].high", &["more than low (3)", "found 3"]);
    assert_only(LIKERT, (scale, &with("\"high\": 6")), 4, "items[0].high", &["at most 9 steps", "found 10"]);
    assert_only(LIKERT, (scale, &with("\"low\": \"x\"")), 4, "items[0].low", &["whole number"]);
    let options = r#"["not", "rather", "very"]"#;
    assert_only(LIKERT, (options, r#"["not"]"#), 5, "items[1].options", &["2 to 9 options", "found 1"]);
    assert_only(LIKERT, (options, r#"["not", "rather", "not"]"#), 5, "items[1].options[2]", &["once"]);
    assert_only(LIKERT, (options, r#"["not", ""]"#), 5, "items[1].options[1]", &["some text"]);
    assert_only(LIKERT, ("\"max\": 10", "\"max\": 1"), 6, "items[2].max", &["more than min (1)"]);
    assert_only(
        LIKERT,
        ("\"min\": 1, \"max\": 10", "\"min\": 1.2, \"max\": 1.8"),
        6,
        "items[2].max",
        &["a whole number between"],
    );
    let text = r#"{ "kind": "text", "name": "why", "question": "Why?" }, { "kind": "choice""#;
    assert_only(LIKERT, (r#"{ "kind": "choice""#, text), 5, "items[1].kind", &["\"number\"", "found \"text\""]);
    let start = LIKERT.find("\"items\"").expect("there");
    let empty = format!("{}\"items\": [] }}", &LIKERT[..start]);
    assert_only(&empty, ("[]", "[]"), 3, "items", &["at least one item"]);
}

#[test]
fn all_mistakes_of_a_protocol_come_at_once() {
    let text = RAMP
        .replace("\"mar_deg\"", "\"mar\"")
        .replace("\"from\": 0.5", "\"from\": 0.5, \"step_s\": 0.001, \"on_gaze_left\": \"abrot\"")
        .replace("\"down\"", "\"dwn\"");
    let fields: Vec<String> =
        mistakes(&study(&text)).into_iter().map(|m| m.1.replace("blocks[0].protocol.", "")).collect();
    assert_eq!(fields, ["parameter", "step_s", "on_gaze_left", "finer"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A value anywhere in a protocol replaced: whatever an independent validator of the committed schema refuses, we refuse.
    #[test]
    fn what_the_schema_refuses_in_a_protocol_is_refused(
        which in 0..ALL.len(),
        at in any::<prop::sample::Index>(),
        new in prop::sample::select(vec!["null", "-1", "1e6", "\"x\"", "[]", "{}", "true", "0.5", "[1]", "0", "[{}]"]),
    ) {
        let mut value: serde_json::Value = serde_json::from_str(&study(ALL[which])).expect("JSON");
        let mut pointers = Vec::new();
        let protocol = value.pointer("/blocks/0/protocol").expect("there");
        collect_pointers(protocol, "/blocks/0/protocol".to_owned(), &mut pointers);
        let pointer = at.get(&pointers).clone();
        *value.pointer_mut(&pointer).expect("collected") = serde_json::from_str(new).expect("JSON");
        let accepted = jsonschema::validator_for(&study_schema()).expect("a schema").is_valid(&value);
        let parsed = parse(&value.to_string());
        prop_assert!(accepted || parsed.is_err(), "{pointer} = {new}");
    }
}
