//! The rules on what sessions of the shipped studies really log: each study is read, run by simulated observers through the
//! same machine as in the laboratory, folded to its record, and judged by its paper's rule.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use analysis::answers::{Protocol, Row};
use analysis::rules::{Bootstrap, ObserverRows, RuleResult, guenter, of_block, weier};
use experiments::catalogue::{Catalogue, DetailLaw, ParameterSchema, RendererInfo, SceneInfo};
use experiments::design::assignment::Assignment;
use experiments::observers::{Observer, Simulation};
use experiments::session::record::Record;
use experiments::session::simulate::simulate;
use experiments::study::parse_study;
use std::collections::BTreeMap;
use std::sync::Arc;

fn number(name: &str) -> ParameterSchema {
    ParameterSchema::number(name, "", 0.0..=1e6, 1.0, "A number.")
}

/// Scenes and renderers under the names and parameters that the shipped studies use. No picture is drawn here.
fn catalogue() -> Catalogue {
    let scene = |id: &str, parameters: Vec<ParameterSchema>| SceneInfo {
        id: id.to_owned(),
        version: 1,
        about: String::new(),
        parameters,
        animated: id == "orbit",
    };
    let photos = ParameterSchema::choice("image", &["gravel", "grass", "chelsea", "coffee"], "Which.");
    let camera = ParameterSchema::choice("camera", &["fly", "pan", "static"], "How it moves.");
    let renderer = |id: &str, parameters: Vec<ParameterSchema>, detail: DetailLaw| RendererInfo {
        id: id.to_owned(),
        version: 1,
        about: String::new(),
        source: String::new(),
        parameters,
        detail,
    };
    let bounded = |name: &str, bounds, default| ParameterSchema::number(name, "", bounds, default, "A number.");
    Catalogue {
        scenes: vec![
            scene("orbit", vec![camera, number("camera_speed"), number("camera_start_deg")]),
            scene("photo", vec![photos.clone()]),
            scene("noise", vec![]),
            scene("patch", vec![photos, number("left_px"), number("top_px"), number("contrast")]),
        ],
        renderers: vec![
            renderer("reference", vec![], DetailLaw::Full),
            renderer(
                "layers",
                vec![
                    bounded("m", 0.0..=1.0, 0.0275),
                    bounded("omega0_deg", 0.001..=1.0, 1.0 / 48.0),
                    bounded("quality_index", 0.0..=100.0, 0.0),
                    ParameterSchema::choice("restrict_s2", &["free", "2"], "Which."),
                ],
                DetailLaw::Line {
                    m: "m".to_owned(),
                    omega0: "omega0_deg".to_owned(),
                    quality_index: Some("quality_index".to_owned()),
                },
            ),
            renderer(
                "gaussian-falloff",
                vec![bounded("radius_deg", 0.0..=60.0, 7.0), bounded("rate", 0.0..=1.0, 0.0035)],
                DetailLaw::Gaussian { radius: "radius_deg".to_owned(), rate: "rate".to_owned() },
            ),
        ],
        ..Catalogue::default()
    }
}

/// One observer's rows by block, over all sittings.
type Blocks = BTreeMap<String, Vec<Row>>;

fn run(study: &str, observers: usize, simulated: &str) -> Vec<(String, Blocks)> {
    let shipped = experiments::study::shipped().iter().find(|known| known.name == study).unwrap();
    let plan = parse_study(study, shipped.json, &catalogue(), None).unwrap_or_else(|mistakes| panic!("{mistakes:?}"));
    let sittings = plan.sittings.as_ref().map_or(1, |sittings| sittings.count);
    let simulation = Simulation::parse(simulated).unwrap();
    (0..observers)
        .map(|number| {
            let mut blocks = Blocks::new();
            for sitting in 1..=sittings {
                let assignment = Assignment { number: number as u32, sitting, ..Assignment::default() };
                let plan = Arc::new(plan.assigned(&assignment).unwrap());
                let seed = 100 * number as u64 + u64::from(sitting);
                let mut observer: Box<dyn Observer> = simulation.observer(seed);
                let record = Record::from_events(&simulate(&plan, seed, observer.as_mut()));
                assert!(record.finished, "{study}: {:?}", record.ended);
                for trial in record.trials.iter().filter(|trial| trial.counts()) {
                    blocks.entry(trial.trial.block.clone()).or_default().extend(Row::of_record(trial));
                }
            }
            (format!("P{number:02}"), blocks)
        })
        .collect()
}

fn judged(blocks: &[(String, Blocks)], block: &str, protocol: Protocol) -> RuleResult {
    let observers: Vec<ObserverRows<'_>> =
        blocks.iter().map(|(observer, blocks)| ObserverRows { observer, rows: &blocks[block] }).collect();
    of_block(block, protocol, &observers, Bootstrap { replicates: 200, seed: 1 }).unwrap()
}

const OBSERVER: &str = "quality_index=15,width=5,finer=up,lapse=0.01";

#[test]
fn guenters_studies_log_what_their_rules_take() {
    for (study, protocol, trials) in [
        ("guenter-pair", Protocol::Pair, 30),
        ("guenter-ramp", Protocol::Ramp, 16),
        ("guenter-slider", Protocol::Slider, 16),
    ] {
        let blocks = run(study, 4, OBSERVER);
        let RuleResult::Guenter(found) = judged(&blocks, "main", protocol) else { panic!("{study}") };
        println!("{study}: {:?}", found.over_observers.as_ref().map(|over| (over.mean, over.sd)));
        assert_eq!((found.observers.len(), found.options.parameter.as_str()), (4, guenter::QUALITY_INDEX));
        for one in &found.observers {
            let n = one.tally.iter().map(|at| at.n as usize).sum::<usize>() + one.values.len();
            assert_eq!(n, trials, "{study}");
            assert!((4.0..=22.0).contains(&one.threshold.unwrap()), "{study}: {one:?}");
        }
        if protocol == Protocol::Ramp {
            let flat: Vec<f64> =
                found.observers[0].tally.iter().filter(|at| at.without_change).map(|at| at.level).collect();
            assert_eq!(flat, [22.0]);
        }
    }
}

/// 36 patches × 9 pairs × 10 in six sittings; what is visible of Tursun's blur depends on the acuity line.
#[test]
fn tursuns_study_logs_what_its_rule_takes() {
    let blocks = run("tursun-calibration", 2, "omega0=0.021,m=0.0275,width=0.6,lapse=0.01");
    assert!(blocks.iter().all(|(_, blocks)| blocks["main"].len() == 3240));
    let RuleResult::Tursun(found) = judged(&blocks, "main", Protocol::Toggle) else { panic!("{blocks:?}") };
    assert_eq!((found.patches.len(), found.over_patches.len()), (36, 27));
    for patch in &found.patches {
        assert_eq!((patch.observers.len(), patch.over_observers.len()), (2, 27));
        for one in &patch.observers {
            assert_eq!((one.pairs.len(), one.missing_pairs), (9, 0));
            assert!(one.pairs.iter().all(|pair| pair.n == 10));
        }
    }
    let at_30 = found.over_patches.last().unwrap();
    println!("{:?}", at_30.five_numbers_deg);
    assert!(at_30.five_numbers_deg[4] <= 0.1352 + 1e-12);
}

#[test]
fn stengels_studies_log_what_their_rules_take() {
    let blocks = run("stengel-validation", 4, "omega0=0.021,m=0.022,width=0.6,lapse=0.02");
    for (block, protocol, each, percent) in [
        ("t1-cognitive-load", Protocol::PairedTask, 3, 12.5),
        ("t2-free-viewing", Protocol::PairedTask, 3, 11.1),
        ("t3-toggle", Protocol::Toggle, 1, 26.6),
        ("t4-brightness", Protocol::PairedTask, 3, 12.2),
        ("t5-eye-motion", Protocol::PairedTask, 3, 6.7),
        ("t6-texture", Protocol::PairedTask, 3, 20.2),
    ] {
        let RuleResult::StengelTask(found) = judged(&blocks, block, protocol) else { panic!("{block}") };
        assert!(found.observers.iter().all(|one| one.n == each), "{block}: {found:?}");
        assert!((100.0 * found.published.unwrap().value - percent).abs() < 1e-9);
        assert_eq!(found.is_forced_choice, protocol == Protocol::Toggle);
    }
    let blocks = run("stengel-calibration", 3, "omega0=0.021,m=0.022,width=0.6,lapse=0.02");
    let RuleResult::StengelSettings(found) = judged(&blocks, "main", Protocol::Adjustment) else { panic!() };
    let parameters: Vec<&str> =
        found.settings.iter().filter(|s| s.by.is_empty()).map(|setting| setting.parameter.as_str()).collect();
    assert_eq!(parameters, ["m", "omega0_deg"]);
    // Three scenes and two starts.
    let by: Vec<String> = found.settings.iter().filter(|s| s.parameter == "m").map(|s| format!("{:?}", s.by)).collect();
    assert_eq!(by.len(), 1 + 3 + 2, "{by:?}");
    assert_eq!(found.start_effects.len(), 2);
}

#[test]
fn weiers_study_logs_what_its_rule_takes() {
    let blocks = run("weier-likert", 2, "omega0=0.021,m=0.022,width=0.6,lapse=0.02");
    let RuleResult::Weier(found) = judged(&blocks, "main", Protocol::Likert) else { panic!() };
    let items: Vec<&str> = found.items.iter().map(|item| item.item.as_str()).collect();
    assert_eq!(items, ["confident", "free-of-artifacts"]);
    // All, 4 + 4 + 3 levels, 48 cells; 96 trials of each observer.
    assert_eq!(found.items[1].conditions.len(), 1 + 11 + 48);
    assert_eq!(found.items[1].conditions[0].n, 192);
    let published = found.items[1].conditions.iter().filter(|condition| condition.published.is_some()).count();
    assert_eq!(published, 3);
    let observers: Vec<ObserverRows<'_>> =
        blocks.iter().map(|(observer, blocks)| ObserverRows { observer, rows: &blocks["main"] }).collect();
    let table = weier::long_table("free-of-artifacts", &observers).unwrap();
    assert_eq!((table.rows.len(), table.cell_means().rows.len()), (192, 96));
    assert!(table.missing(1).is_empty());
    let levels: Vec<usize> = table.levels().values().map(Vec::len).collect();
    assert_eq!(levels, [3, 4, 4]);
}
