//! What a good study becomes, and what is foretold of it.

use super::{STUDY, catalogue, edited, parse};
use crate::catalogue::ParameterValue;
use crate::display::Display;
use crate::study::plan::{ProcedurePlan, ProtocolPlan};
use crate::study::{DEFAULT_FEEDBACK_S, DEFAULT_QUESTION, describe, finest_mar_around, parse_study};

#[test]
fn a_study_becomes_a_plan() {
    let plan = parse(STUDY).expect("no mistake");
    assert_eq!(plan.display.name(), "tursun-2019-27in");
    assert_eq!(plan.gaze.gate.map(|gate| gate.radius_deg), Some(2.0));

    let practice = &plan.blocks[0];
    assert!(practice.practice);
    assert_eq!(practice.cells[0].condition.renderer_parameters["width_deg"], ParameterValue::Number(4.0));
    assert_eq!(practice.cells[0].condition.renderer_parameters["mar_deg"], ParameterValue::Number(0.5), "the default");
    let ProtocolPlan::TwoInterval(timing) = &practice.protocol else { panic!("two intervals") };
    assert_eq!((timing.question.as_str(), practice.feedback_s), (DEFAULT_QUESTION, DEFAULT_FEEDBACK_S));
    // 2 eccentricities × 3 MARs × 4 repetitions.
    assert_eq!(practice.procedure.levels().len(), 6);
    assert_eq!(practice.procedure.max_trials(), 24);
    assert!(practice.procedure.levels().iter().any(|l| l["eccentricity_deg"] > 9.0 && l["mar_deg"] > 2.9));

    let ProcedurePlan::QuestPlus(quest) = &plan.blocks[1].procedure else { panic!("QUEST+") };
    assert_eq!((quest.levels.len(), quest.levels_beyond_display), (3 * 24, 0));
    assert_eq!((quest.m.len(), quest.omega0_deg.len(), quest.width.len(), quest.lapse.len()), (10, 20, 7, 2));
    assert_eq!((quest.m[0], quest.m[9]), (0.005, 0.08));
    let ratios: Vec<f64> = quest.m.windows(2).map(|pair| pair[1] / pair[0]).collect();
    assert!(ratios.iter().all(|ratio| (ratio - ratios[0]).abs() < 1e-12), "equal ratios {ratios:?}");
}

#[test]
fn what_a_constant_block_does_not_vary_comes_from_its_condition() {
    let text = edited(&[
        ("\"eccentricity_deg\": [5, 10],\n", ""),
        (r#"{ "width_deg": 4 }"#, r#"{ "width_deg": 4, "eccentricity_deg": 7.5 }"#),
    ]);
    let plan = parse(&text).expect("no mistake");
    let levels = plan.blocks[0].procedure.levels();
    assert_eq!(levels.len(), 3);
    let condition = &plan.blocks[0].cells[0].condition;
    assert!(levels.iter().all(|level| (condition.tested_at(level)[0].expect("a ring") - 7.5).abs() < 1e-12));
}

#[test]
fn pairs_that_the_display_cannot_show_are_left_out_and_counted() {
    let text = edited(&[(r#""min": 0.05, "max": 3.0"#, r#""min": 0.01, "max": 1.0"#)]);
    let plan = parse(&text).expect("no mistake");
    let ProcedurePlan::QuestPlus(quest) = &plan.blocks[1].procedure else { panic!("QUEST+") };
    assert_eq!(quest.levels.len() + quest.levels_beyond_display, 3 * 24);
    assert!(quest.levels_beyond_display > 0);
    for level in &quest.levels {
        assert!(level["mar_deg"] >= finest_mar_around(&plan.display, [0.0, 0.0], level["eccentricity_deg"]));
    }
    assert!(describe(&plan).to_string().contains("finer than the display can show are left out"));
}

#[test]
fn an_override_is_the_display_that_counts() {
    let demo = Display::named("demo-540p").expect("ships");
    let plan = parse_study("s", STUDY, &catalogue(), Some(&demo)).expect("fits there too");
    assert_eq!(plan.display, demo);
    // Needed where the study states none, and where it names one that only the lab knows.
    for display in ["", "\"display\": \"our-lab\","] {
        let text = edited(&[("\"display\": \"tursun-2019-27in\",", display)]);
        assert!(parse(&text).is_err());
        assert!(parse_study("s", &text, &catalogue(), Some(&demo)).is_ok());
    }
    // Rings and MARs are held against it.
    let text = edited(&[("[5, 10]", "[5, 17]")]);
    assert!(parse(&text).is_ok());
    assert!(parse_study("s", &text, &catalogue(), Some(&demo)).is_err());
}

#[test]
fn the_description_counts_right() {
    let plan = parse(STUDY).expect("no mistake");
    let description = describe(&plan);
    // Tursun 2019, §5.1: 48.3° × 28.3°.
    assert!((description.display.size_deg[0] - 48.3).abs() < 0.05);
    assert!((description.display.finest_mar_deg * description.display.px_per_deg - 2.0).abs() < 1e-3, "two pixels");
    let [practice, main] = description.blocks.as_slice() else { panic!("two blocks") };
    assert_eq!((practice.effort.trials_min, practice.effort.trials_max, practice.levels), (24, 24, 6));
    // 0.5 + 2 × 0.3 + 0.3 s, an answer of 1 s, feedback of 0.5 s.
    assert!((practice.trial_s - 2.9).abs() < 1e-12);
    assert!((practice.effort.minutes_max - 24.0 * 2.9 / 60.0).abs() < 1e-12);
    assert_eq!((main.effort.trials_min, main.effort.trials_max, main.levels), (80, 240, 72));
    assert_eq!(main.mar_deg, Some([0.05, 3.0]));
    assert_eq!(main.eccentricities.len(), 3);
    assert!((main.eccentricities[2].visible_share - 1.0).abs() < 1e-12);
    assert!(main.eccentricities[2].finest_mar_deg < main.eccentricities[0].finest_mar_deg);
    assert_eq!((description.total.trials_min, description.total.trials_max), (104, 264));

    let text = description.to_string();
    assert!(text.contains("In all    2 blocks, 104–264 trials"), "{text}");
    assert!(text.contains("ring (edge_deg 0.5, width_deg 4)"), "{text}");
    let widest = text.lines().map(|line| line.chars().count()).max();
    assert!(widest.is_some_and(|columns| columns <= 100), "{widest:?}\n{text}");
    let json = serde_json::to_value(&description).expect("plain data");
    assert_eq!(json["blocks"][0]["trials_max"], 24);
}
