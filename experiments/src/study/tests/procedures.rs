//! Adaptive procedures from the file: what good ones become, and every mistake with its line and field.

use super::{STUDY, catalogue, edited, mistakes, parse};
use crate::display::Display;
use crate::study::plan::{Harder, Precision, ProcedurePlan, QuestMethod, StepType, Stop};
use crate::study::{describe, finest_mar_around, parse_study};

const STAIRCASE: &str = r#"{
        "kind": "staircase",
        "parameter": "mar_deg",
        "harder": "down",
        "start": [2.0, 0.2],
        "fixed": { "eccentricity_deg": 8 },
        "steps": [0.3, 0.1],
        "step_type": "log",
        "n_down": 3,
        "stop": { "any": [{ "trials": 60 }, { "all": [{ "reversals": 10 }, { "trials": 30 }] }] }
      }"#;

const QUEST: &str = r#"{
        "kind": "quest",
        "parameter": "mar_deg",
        "harder": "down",
        "axis": "log",
        "start": 0.4,
        "start_sd": 0.5,
        "limits": { "min": 0.05, "max": 3 },
        "stop": { "trials": 40 }
      }"#;

const FUNCTION: &str = r#"{
        "kind": "quest-plus-function",
        "function": "weibull",
        "axis": "log",
        "parameter": "mar_deg",
        "covariate": "eccentricity_deg",
        "harder": "down",
        "stimuli": { "mar_deg": { "min": 0.05, "max": 3, "steps": 20 }, "eccentricity_deg": [0, 5, 10] },
        "prior": {
          "threshold": { "min": 0.01, "max": 0.1, "steps": 8 },
          "threshold_slope": [0.01, 0.02, 0.04],
          "width": [0.5, 1, 2]
        },
        "stop": { "any": [{ "trials": 100 }, { "quantity": "threshold_slope", "relative_sd": 0.1 }] }
      }"#;

const PSI: &str = r#"{
        "kind": "psi",
        "axis": "log",
        "parameter": "mar_deg",
        "harder": "down",
        "values": { "min": 0.05, "max": 3, "steps": 20 },
        "threshold": { "min": 0.05, "max": 2, "steps": 15 },
        "slope": [1, 2, 4, 8],
        "stop": { "any": [{ "trials": 100 }, { "quantity": "threshold", "sd": 0.02 }] }
      }"#;

/// The small study with another procedure in its main block; it begins in line 44.
fn with(procedure: &str, edits: &[(&str, &str)]) -> String {
    let start = STUDY.rfind("\"procedure\": ").expect("there") + "\"procedure\": ".len();
    let end = STUDY.rfind("\n    }\n  ]").expect("there");
    let procedure = edits.iter().fold(procedure.to_owned(), |text, (old, new)| {
        assert_eq!(text.matches(old).count(), 1, "{old} must occur once");
        text.replace(old, new)
    });
    format!("{}{procedure}{}", &STUDY[..start], &STUDY[end..])
}

fn plan(text: &str) -> ProcedurePlan {
    parse(text).unwrap_or_else(|mistakes| panic!("{mistakes}")).blocks.swap_remove(1).procedure
}

/// One mistake, `line` lines into the procedure, at this field of it, with these words.
#[track_caller]
fn refused(procedure: &str, edits: &[(&str, &str)], line: usize, field: &str, words: &[&str]) {
    let found = mistakes(&with(procedure, edits));
    assert_eq!(found.len(), 1, "{found:#?}");
    let (at, name, message) = &found[0];
    let expected = format!("blocks[1].procedure{}{field}", if field.is_empty() { "" } else { "." });
    assert_eq!((*at, name.as_str()), (44 + line, expected.as_str()), "{message}");
    assert!(message.starts_with("expected "), "{message}");
    for word in words {
        assert!(message.contains(word), "{word:?} is not in {message:?}");
    }
}

#[test]
fn a_staircase_becomes_a_plan() {
    let ProcedurePlan::Staircase(stairs) = plan(&with(STAIRCASE, &[])) else { panic!("a staircase") };
    assert_eq!((stairs.harder, stairs.step_type), (Harder::Down, StepType::Log));
    assert_eq!((stairs.n_up, stairs.n_down, stairs.initial_rule), (1, 3, true));
    assert_eq!((stairs.start.as_slice(), stairs.steps.as_slice()), ([2.0, 0.2].as_slice(), [0.3, 0.1].as_slice()));
    let display = Display::named("tursun-2019-27in").expect("ships");
    let [min, max] = stairs.place.limits();
    assert!((min - finest_mar_around(&display, [0.0, 0.0], 8.0)).abs() < 1e-12, "what the display can show");
    assert!((max - 20.0).abs() < 1e-12, "the renderer's bound");
    let level = stairs.place.level(50.0);
    assert!((level["mar_deg"] - 20.0).abs() < 1e-12 && (level["eccentricity_deg"] - 8.0).abs() < 1e-12);
    let procedure = ProcedurePlan::Staircase(stairs);
    // Two tracks of at most 60 trials; ten reversals can take 2 + 5 × 1 + 4 × 3 trials, so that 30 trials count.
    assert_eq!((procedure.min_trials(), procedure.max_trials()), (60, 120));
}

#[test]
fn quest_psi_and_a_function_become_plans() {
    let ProcedurePlan::Quest(quest) = plan(&with(QUEST, &[])) else { panic!("QUEST") };
    assert_eq!((quest.method, quest.place.limits()), (QuestMethod::Quantile, [0.05, 3.0]));
    assert!((quest.range - 5.0).abs() < 1e-12 && (quest.p_threshold - 0.82).abs() < 1e-12);

    let procedure = plan(&with(FUNCTION, &[]));
    assert_eq!((procedure.min_trials(), procedure.max_trials()), (1, 100));
    let ProcedurePlan::QuestPlusFunction(function) = procedure else { panic!("QUEST+") };
    assert_eq!((function.levels.len(), function.levels_beyond_display), (60, 0));
    assert_eq!((function.lapse.as_slice(), function.guess.as_slice()), ([0.02].as_slice(), [0.5].as_slice()));
    let ratio = function.threshold[1] / function.threshold[0];
    assert!((ratio - 10_f64.powf(1.0 / 7.0)).abs() < 1e-12);

    let ProcedurePlan::Psi(psi) = plan(&with(PSI, &[(r#""min": 0.05, "max": 3"#, r#""min": 0.01, "max": 3"#)])) else {
        panic!("Psi")
    };
    assert_eq!(psi.levels.len() + psi.levels_beyond_display, 20);
    assert!(psi.levels_beyond_display > 0);

    let linear = [("\"axis\": \"log\"", "\"axis\": \"linear\"")];
    let ProcedurePlan::Psi(psi) = plan(&with(PSI, &linear)) else { panic!("Psi") };
    assert!((psi.threshold[1] - psi.threshold[0] - 1.95 / 14.0).abs() < 1e-12);
}

#[test]
fn the_short_stop_rule_is_a_tree() {
    let ProcedurePlan::QuestPlus(quest) = plan(STUDY) else { panic!("QUEST+") };
    let narrow = Stop::Narrow { quantity: "m".to_owned(), limit: Precision::RelativeSd(0.08) };
    assert_eq!(quest.stop, Stop::Any(vec![Stop::Trials(240), Stop::All(vec![Stop::Trials(80), narrow])]));
    let stop = r#"{ "max_trials": 240, "min_trials": 80, "m_relative_sd": 0.08 }"#;
    let tree = r#"{ "any": [{ "trials": 240 },
        { "all": [{ "trials": 80 }, { "quantity": "m", "relative_sd": 0.08 }] }] }"#;
    assert_eq!(plan(&edited(&[(stop, tree)])), ProcedurePlan::QuestPlus(quest));

    let found = mistakes(&edited(&[(stop, r#"{ "trials": 240, "m_relative_sd": 0.08 }"#)]));
    assert_eq!((found[0].1.as_str(), found.len()), ("blocks[1].procedure.stop.m_relative_sd", 1));
    let found = mistakes(&edited(&[(stop, "{}")]));
    assert_eq!((found[0].1.as_str(), found.len()), ("blocks[1].procedure.stop.max_trials", 1));
    let found = mistakes(&edited(&[(stop, r#"{ "any": [{ "trials": 240 }, { "reversals": 4 }] }"#)]));
    assert_eq!((found[0].1.as_str(), found.len()), ("blocks[1].procedure.stop.any[1].reversals", 1));
    assert!(found[0].2.contains("QUEST+ over the MAR model, which has no reversals"), "{}", found[0].2);
}

#[test]
fn names_of_a_list_are_checked_and_suggested() {
    refused(
        STAIRCASE,
        &[("\"harder\": \"down\"", "\"harder\": \"dwon\"")],
        3,
        "harder",
        &[r#"expected "down" or "up", found "dwon"; did you mean "down"?"#],
    );
    refused(
        STAIRCASE,
        &[("\"step_type\": \"log\"", "\"step_type\": 1")],
        7,
        "step_type",
        &[r#""linear" or "log" or "db", found 1"#],
    );
    refused(
        STAIRCASE,
        &[("        \"harder\": \"down\",\n", "")],
        0,
        "harder",
        &[r#""down" or "up", found no such key"#],
    );
    refused(FUNCTION, &[("\"weibull\"", "\"weibul\"")], 2, "function", &[r#"did you mean "weibull"?"#]);
}

#[test]
fn a_staircase_is_held_against_renderer_and_display() {
    refused(STAIRCASE, &[("\"mar_deg\"", "\"mra_deg\"")], 2, "parameter", &["numeric parameter", "\"mar_deg\"?"]);
    refused(STAIRCASE, &[("[2.0, 0.2]", "[2.0, 25]")], 4, "start[1]", &["within the limits", "to 20.0000", "found 25"]);
    refused(STAIRCASE, &[("[2.0, 0.2]", "0.01")], 4, "start", &["within the limits", "found 0.01"]);
    refused(STAIRCASE, &[("[2.0, 0.2]", "[]")], 4, "start", &["empty list"]);
    refused(STAIRCASE, &[("[2.0, 0.2]", "[0, 0.2]")], 4, "start[0]", &["above 0", "logarithm"]);
    refused(STAIRCASE, &[("[2.0, 0.2]", "\"x\"")], 4, "start", &["a number or a list of numbers"]);
    refused(STAIRCASE, &[("_deg\": 8", "_deg\": 80")], 5, "fixed.eccentricity_deg", &["0 to 60", "found 80"]);
    refused(STAIRCASE, &[("_deg\": 8", "_deg\": 40")], 5, "fixed.eccentricity_deg", &["on the display", "40°"]);
    refused(STAIRCASE, &[("\"eccentricity_deg\": 8", "\"mar_deg\": 8")], 5, "fixed.mar_deg", &["which moves"]);
    refused(STAIRCASE, &[("\"eccentricity_deg\": 8", "\"ecc_deg\": 8")], 5, "fixed.ecc_deg", &["numeric parameter"]);
    refused(STAIRCASE, &[("[0.3, 0.1]", "[]")], 6, "steps", &["at least one step"]);
    refused(STAIRCASE, &[("[0.3, 0.1]", "[0.3, 0]")], 6, "steps[1]", &["above 0", "found 0"]);
    refused(STAIRCASE, &[("\"n_down\": 3", "\"n_down\": 0")], 8, "n_down", &["from 1", "found 0"]);
    refused(STAIRCASE, &[("\"n_down\": 3", "\"n_up\": 0, \"n_down\": 3")], 8, "n_up", &["from 1", "found 0"]);
    let limits = |limits: &str| format!("\"limits\": {limits}, \"n_down\": 3");
    let with_limits = |text: &str, line, field: &str, words: &[&str]| {
        refused(STAIRCASE, &[("\"n_down\": 3", &limits(text))], line, field, words);
    };
    with_limits(r#"{ "min": 0.01 }"#, 8, "limits.min", &["can show at 8°", "found 0.01"]);
    with_limits(r#"{ "max": 30 }"#, 8, "limits.max", &["0.005 to 20", "found 30"]);
    with_limits(r#"{ "min": 2, "max": 1 }"#, 8, "limits.max", &["lower limit (2.0000)", "found 1"]);
    refused(
        STAIRCASE,
        &[("\"mar_deg\"", "\"eccentricity_deg\""), ("{ \"eccentricity_deg\": 8 }", "{}"), ("[2.0, 0.2]", "5")],
        0,
        "limits.max",
        &["on the display", "found 60°"],
    );
}

#[test]
fn stop_rules_are_one_each_known_and_bounded() {
    const RULE: &str = r#"{ "any": [{ "trials": 60 }, { "all": [{ "reversals": 10 }, { "trials": 30 }] }] }"#;
    let stop = |rule: &str, field: &str, words: &[&str]| refused(STAIRCASE, &[(RULE, rule)], 9, field, words);
    stop(r#"{ "reversals": 10 }"#, "stop", &["whatever is answered", "may never hold"]);
    stop(r#"{ "all": [{ "trials": 10 }, { "reversals": 4 }] }"#, "stop", &["may never hold"]);
    stop(r#"{ "any": [] }"#, "stop.any", &["at least one rule"]);
    stop("{}", "stop", &["one of trials, reversals, quantity, all or any, found none"]);
    stop(r#"{ "trials": 10, "reversals": 4 }"#, "stop", &["found trials and reversals"]);
    stop(r#"{ "trials": 0 }"#, "stop.trials", &["from 1"]);
    stop(r#"{ "any": [{ "trials": 10 }, { "quantity": "mar_deg" }] }"#, "stop.any[1]", &["sd or relative_sd"]);
    stop(
        r#"{ "any": [{ "trials": 10 }, { "quantity": "m", "sd": 0.1 }] }"#,
        "stop.any[1].quantity",
        &["a staircase estimates (mar_deg)", "found \"m\""],
    );
    stop(
        r#"{ "any": [{ "trials": 10 }, { "quantity": "mar_deg", "sd": 0.1, "relative_sd": 0.1 }] }"#,
        "stop.any[1].relative_sd",
        &["found both"],
    );
    stop(r#"{ "trials": 10, "sd": 0.1 }"#, "stop.sd", &["a quantity beside it"]);
    stop(r#"{ "trials": 60000 }"#, "stop", &["at most 100000 trials", "120000 in 2 tracks"]);
    refused(
        QUEST,
        &[(r#"{ "trials": 40 }"#, r#"{ "any": [{ "trials": 9 }, { "reversals": 9 }] }"#)],
        8,
        "stop.any[1].reversals",
        &["QUEST, which has no reversals"],
    );
    refused(
        FUNCTION,
        &[("\"quantity\": \"threshold_slope\"", "\"quantity\": \"slope\"")],
        13,
        "stop.any[1].quantity",
        &["threshold, width, lapse, guess, threshold_slope"],
    );
    // All of them at once.
    let many = r#"{ "any": [{}, { "reversals": 0 }, { "quantity": "m" }, { "all": [] }] }"#;
    assert_eq!(
        mistakes(&with(STAIRCASE, &[(RULE, many)])).len(),
        5,
        "{:#?}",
        mistakes(&with(STAIRCASE, &[(RULE, many)]))
    );
}

#[test]
fn quest_has_a_threshold_within_its_tables() {
    let more = |text: &str| format!("\"start_sd\": 0.5, {text}");
    let quest = |text: &str, field: &str, words: &[&str]| {
        refused(QUEST, &[("\"start_sd\": 0.5", &more(text))], 6, field, words);
    };
    quest("\"p_threshold\": 0.5", "p_threshold", &["more than gamma (0.5)", "0.9950"]);
    quest("\"p_threshold\": 0.996", "p_threshold", &["less than 0.9950"]);
    quest("\"grain\": 1e-6, \"range\": 5", "range", &["1 to 100000 grains"]);
    quest("\"p_threshold\": 0.95, \"range\": 0.02", "range", &["passes p_threshold"]);
    quest("\"method\": \"median\"", "method", &[r#""quantile" or "mean" or "mode""#]);
    refused(QUEST, &[("\"start\": 0.4", "\"start\": 4")], 5, "start", &["0.0500 to 3.0000", "found 4"]);
    refused(QUEST, &[("\"start\": 0.4", "\"start\": -4")], 5, "start", &["above 0"]);
}

#[test]
fn functions_have_their_stimuli_and_priors() {
    refused(
        FUNCTION,
        &[("\"axis\": \"log\"", "\"axis\": \"linear\"")],
        3,
        "axis",
        &["\"log\" for a Weibull", "gumbel"],
    );
    refused(
        FUNCTION,
        &[(", \"eccentricity_deg\": [0, 5, 10]", "")],
        7,
        "stimuli.eccentricity_deg",
        &["found no such key"],
    );
    refused(FUNCTION, &[("[0, 5, 10]", "[0, 5, 40]")], 7, "stimuli.eccentricity_deg[2]", &["on the display"]);
    refused(FUNCTION, &[("[0, 5, 10]", "[0, 5, 10], \"edge_deg\": [1]")], 7, "stimuli.edge_deg", &["function reads"]);
    refused(FUNCTION, &[("\"max\": 3,", "\"max\": 30,")], 7, "stimuli.mar_deg.max", &["0.005 to 20"]);
    refused(FUNCTION, &[("\"min\": 0.05", "\"min\": 0")], 7, "stimuli.mar_deg.min", &["above 0"]);
    refused(FUNCTION, &[("\"min\": 0.01,", "\"min\": 0.2,")], 9, "prior.threshold.max", &["more than min (0.2)"]);
    refused(
        FUNCTION,
        &[("          \"threshold_slope\": [0.01, 0.02, 0.04],\n", "")],
        8,
        "prior.threshold_slope",
        &["eccentricity_deg", "no such key"],
    );
    refused(FUNCTION, &[("[0.01, 0.02, 0.04]", "[0.01, -0.02]")], 10, "prior.threshold_slope", &["above 0 at every"]);
    refused(FUNCTION, &[("[0.5, 1, 2]", "[0.5, 0]")], 11, "prior.width[1]", &["found 0"]);
    refused(FUNCTION, &[("[0.5, 1, 2]", "[]")], 11, "prior.width", &["empty list"]);
    refused(FUNCTION, &[("[0.5, 1, 2]", "[1], \"lapse\": [0.7]")], 11, "prior.lapse[0]", &["0 to 0.5"]);
    let same = with(FUNCTION, &[("\"covariate\": \"eccentricity_deg\"", "\"covariate\": \"mar_deg\"")]);
    assert!(mistakes(&same).iter().any(|(line, field, message)| {
        (*line, field.as_str()) == (49, "blocks[1].procedure.covariate") && message.contains("another parameter")
    }));
}

#[test]
fn psi_has_two_shapes() {
    refused(PSI, &[("\"axis\": \"log\"", "\"function\": \"gumbel\", \"axis\": \"log\"")], 2, "function", &["logistic"]);
    refused(PSI, &[("[1, 2, 4, 8]", "[1, 0]")], 7, "slope[1]", &["above 0"]);
    refused(
        PSI,
        &[("\"min\": 0.05, \"max\": 3", "\"min\": 0.005, \"max\": 0.03")],
        5,
        "values",
        &["at least two levels"],
    );
    let huge = r#"{ "min": 0.001, "max": 2, "steps": 1000 }"#;
    let many = [
        (r#"{ "min": 0.05, "max": 2, "steps": 15 }"#, huge),
        ("[1, 2, 4, 8]", huge),
        ("\"steps\": 20", "\"steps\": 1000"),
    ];
    refused(PSI, &many, 0, "", &["20000000 cells"]);
}

#[test]
fn descriptions_say_what_is_done_and_when_it_ends() {
    for (procedure, words) in [
        (
            STAIRCASE,
            [
                "staircase on mar_deg, 1-up-3-down, smaller is harder, from 2, 0.2 in 2 tracks, steps 0.3, 0.1 log10",
                "each track when 60 trials are done or (10 reversals are reached and 30 trials are done)",
            ],
        ),
        (
            QUEST,
            [
                "QUEST on mar_deg on a log axis, first 0.4, then at the best quantile of the threshold for 82 % right",
                "after 40 trials",
            ],
        ),
        (
            FUNCTION,
            [
                "QUEST+ over a Weibull function of mar_deg on a log axis, threshold linear in eccentricity_deg, 72",
                "when 100 trials are done or threshold_slope is known to 10 %",
            ],
        ),
        (
            PSI,
            [
                "Psi over threshold and slope of a cumulative Gauss of mar_deg on a log axis, 60 grid points",
                "when 100 trials are done or the SD of threshold is at most 0.02",
            ],
        ),
    ] {
        let plan = parse_study("s", &with(procedure, &[]), &catalogue(), None).expect("valid");
        let block = &describe(&plan).blocks[1];
        assert!(block.procedure.starts_with(words[0]), "{}", block.procedure);
        assert_eq!(block.stop, words[1]);
        // What moves freely has limits, not a number of levels.
        let free = matches!(plan.blocks[1].procedure, ProcedurePlan::Staircase(_) | ProcedurePlan::Quest(_));
        assert_eq!(describe(&plan).to_string().contains("levels  any between two limits, MAR 0.0"), free);
    }
}
