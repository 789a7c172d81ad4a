//! Every protocol on one page: simulated blocks of all families are summed up, drawn and read back from the page.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::answers::{BlockSummary, Protocol, Row, Summary, summarise};
use analysis::figures::{self, GazeView};
use analysis::psychometric::{Direction, Psychometric, PsychometricConfig};
use analysis::report::{ReportInput, SessionReport, html};
use analysis::summary::{Analysis, FormSummary};
use experiments::Display;
use experiments::trial::Answer;
use experiments::trial::form::Entry;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

fn row(answer: Answer, correct: Option<bool>) -> Row {
    Row {
        condition: "one".to_owned(),
        factors: BTreeMap::new(),
        level: BTreeMap::new(),
        answer,
        correct,
        found: BTreeMap::new(),
        response_time_s: Some(1.4),
    }
}

fn with(map: &[(&str, f64)]) -> BTreeMap<String, f64> {
    map.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

fn of(map: &[(&str, &str)]) -> BTreeMap<String, String> {
    map.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
}

fn pair(rng: &mut ChaCha8Rng) -> Vec<Row> {
    let truth = Psychometric { threshold: 14.9, width: 5.0, lapse: 0.02, guess: 0.05, overdispersion: 0.0 };
    let mut rows = Vec::new();
    for j in (8..=22).step_by(2) {
        for _ in 0..10 {
            let p = truth.probability(
                f64::from(j),
                &PsychometricConfig { direction: Direction::Falls, ..PsychometricConfig::TWO_ALTERNATIVES },
            );
            let noticed = rng.random::<f64>() < p;
            let answer = if noticed { Answer::First } else { Answer::Same };
            rows.push(Row { level: with(&[("quality_index", f64::from(j))]), ..row(answer, Some(noticed)) });
        }
    }
    rows
}

fn toggle(rng: &mut ChaCha8Rng) -> Vec<Row> {
    let mut rows = Vec::new();
    for patch in ["forest", "tiles", "noise"] {
        for radius in [4.0, 7.0, 11.0] {
            for rate in [0.0017, 0.0035, 0.0052] {
                for _ in 0..10 {
                    let correct = rng.random::<f64>() < f64::min(0.5 + 100.0 * rate - 0.01 * radius, 1.0);
                    rows.push(Row {
                        level: with(&[("radius_deg", radius), ("rate", rate)]),
                        factors: of(&[("patch", patch)]),
                        ..row(Answer::First, Some(correct))
                    });
                }
            }
        }
    }
    rows
}

fn slider(rng: &mut ChaCha8Rng) -> Vec<Row> {
    ["pan", "orbit", "dolly", "still"]
        .iter()
        .flat_map(|motion| (0..6).map(move |_| *motion))
        .map(|motion| {
            let j = (12.0 + 5.0 * rng.random::<f64>()).round();
            Row {
                factors: of(&[("motion", motion)]),
                level: with(&[("quality_index", 4.0)]),
                found: with(&[("quality_index", j), ("quality_index_settled", j + 1.0), ("moves", 9.0)]),
                ..row(Answer::Continue, None)
            }
        })
        .collect()
}

fn likert(rng: &mut ChaCha8Rng) -> Vec<Row> {
    let mut rows = Vec::new();
    for scene in ["sponza", "rungholt", "tunnel", "lucy"] {
        for (index, region) in ["small", "medium", "large", "full"].iter().enumerate() {
            for fixation in ["cross", "moving", "free"] {
                for _ in 0..2 {
                    let mut step = || ((rng.random::<f64>() * 4.0 + index as f64).floor() - 3.0).clamp(-3.0, 3.0);
                    rows.push(Row {
                        factors: of(&[("scene", scene), ("region", region), ("fixation", fixation)]),
                        found: with(&[("no_flicker", step()), ("sharp", step())]),
                        ..row(Answer::Option(1), None)
                    });
                }
            }
        }
    }
    rows
}

fn tasks(rng: &mut ChaCha8Rng) -> Vec<Row> {
    let mut rows = Vec::new();
    for task in ["count", "free viewing", "follow"] {
        for _ in 0..12 {
            let draw = rng.random::<f64>();
            let (answer, correct) = match draw {
                d if d < 0.35 => (Answer::First, true),
                d if d < 0.7 => (Answer::Same, false),
                _ => (Answer::Second, false),
            };
            let found = if task == "count" {
                let off = (rng.random::<f64>() * 3.0).floor();
                with(&[("count_1", 12.0), ("spheres_1", 12.0 + off), ("count_2", 9.0), ("spheres_2", 9.0)])
            } else {
                BTreeMap::new()
            };
            rows.push(Row { factors: of(&[("task", task)]), found, ..row(answer, Some(correct)) });
        }
    }
    rows
}

fn blocks(seed: u64) -> Vec<BlockSummary> {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    vec![
        summarise("guenter-pair", "pair", Some(Protocol::Pair), &pair(rng)),
        summarise("tursun-calibration", "toggle", Some(Protocol::Toggle), &toggle(rng)),
        summarise("guenter-slider", "slider", None, &slider(rng)),
        summarise("weier-likert", "likert", None, &likert(rng)),
        summarise("stengel-validation", "tasks", None, &tasks(rng)),
        summarise("stengel-validation", "empty", None, &[]),
    ]
}

fn session(observer: &str, blocks: Vec<BlockSummary>) -> SessionReport {
    let display = Display::named("guenter-2012").unwrap();
    SessionReport {
        observer: observer.to_owned(),
        study: "every-protocol".to_owned(),
        session: format!("every-protocol_{observer}"),
        started: None,
        gaze_source: "simulated".to_owned(),
        stimulus: "forest, renderer layers".to_owned(),
        adapter: "none".to_owned(),
        seed: 1,
        run_version: "parafovea".to_owned(),
        facts: Vec::new(),
        truth: None,
        fit: None,
        forms: vec![FormSummary {
            session: format!("every-protocol_{observer}"),
            form: "participant".to_owned(),
            entries: BTreeMap::from([
                ("age".to_owned(), Entry::Number(31.0)),
                ("notes".to_owned(), Entry::Text("</script><b>glasses".to_owned())),
            ]),
        }],
        pilot: false,
        blocks,
        track: Vec::new(),
        gaze: Vec::new(),
        gaze_view: GazeView { half_field_deg: display.half_field_deg(), fixation_deg: [0.0, 0.0], gate_deg: None },
        display,
        aborted_trials: 0,
        frames: Vec::new(),
        measured_refresh_hz: None,
        virtual_time: true,
    }
}

fn page(sessions: Vec<SessionReport>) -> ReportInput {
    ReportInput {
        title: "Every protocol".to_owned(),
        program_version: "parafovea".to_owned(),
        generated: None,
        software: Vec::new(),
        sessions,
    }
}

fn embedded(html: &str) -> Analysis {
    let start = html.find("id=\"parafovea-analysis\">").unwrap() + "id=\"parafovea-analysis\">".len();
    let end = start + html[start..].find("</script>").unwrap();
    serde_json::from_str(&html[start..end]).unwrap()
}

#[test]
fn a_page_shows_every_family_and_holds_its_numbers() {
    let sessions = vec![session("P01", blocks(1)), session("P02", blocks(2))];
    let html = html(&page(sessions.clone()));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-protocols.html");
    std::fs::write(&path, &html).unwrap();
    println!("page: {} ({} kB)", path.display(), html.len() / 1000);

    // Two observers, each with detection twice, one slider, two items and one comparison.
    assert_eq!(html.matches("<figure>").count(), 2 * 6);
    for absent in ["src=", "href=", "url(", "NaN", "inf\"", "<b>glasses", "PILOT", "MAR line"] {
        assert!(!html.contains(absent), "the page contains {absent}");
    }
    for tag in ["svg", "figure", "section", "table", "dl", "main", "aside", "tr", "ul"] {
        let opened = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag} is not balanced");
    }
    let read = embedded(&html);
    assert_eq!(read.observers.len(), 2);
    assert_eq!(read.observers[0].blocks, sessions[0].blocks);
    assert_eq!(read.observers[0].forms, sessions[0].forms);
    assert!(read.observers[0].mar.is_none());
    let threshold = read.group.iter().find(|row| row.quantity == "threshold of quality_index").unwrap();
    assert_eq!(threshold.over_observers.n, 2);
    assert!((threshold.over_observers.mean - 14.9).abs() < 1.5, "{threshold:?}");
}

#[test]
fn pilot_data_are_called_so_before_anything_else() {
    let html = html(&page(vec![SessionReport { pilot: true, ..session("P01", blocks(3)) }]));
    assert!(html.find("PILOT DATA").unwrap() < html.find("<h2>").unwrap());
    assert!(embedded(&html).observers[0].pilot);
}

#[test]
fn figures_have_units_on_their_axes_and_draw_degenerate_blocks() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("protocol-figures");
    std::fs::create_dir_all(&folder).unwrap();
    let save = |name: &str, svg: &str| {
        assert!(!svg.contains("NaN") && svg.trim_end().ends_with("</svg>"), "{name}");
        std::fs::write(folder.join(format!("{name}.svg")), svg).unwrap();
    };
    for block in blocks(1) {
        match &block.summary {
            Summary::Detection(detection) => {
                let svg = figures::detection(detection);
                assert!(svg.contains("Share right") && svg.contains(detection.parameters.last().unwrap()));
                save(&block.block, &svg);
            }
            Summary::Matches(matches) => {
                let svg = figures::settings(matches, "quality_index");
                assert!(svg.contains(">quality_index</text>"));
                save(&block.block, &svg);
            }
            Summary::Ratings(ratings) => {
                let svg = figures::ratings(ratings, &ratings.items[0]);
                assert!(svg.contains("Share of ratings") && svg.matches("<rect").count() > 11 * 3);
                save(&block.block, &svg);
            }
            Summary::Tasks(tasks) => {
                let svg = figures::tasks(tasks);
                assert!(svg.contains("Share of answers"));
                save(&block.block, &svg);
            }
            Summary::Nothing { reason } => assert_eq!(reason, "no trial was answered"),
        }
    }
    // One trial of each.
    let rng = &mut ChaCha8Rng::seed_from_u64(9);
    let one = [pair(rng), slider(rng), likert(rng), tasks(rng)].map(|rows| summarise("s", "b", None, &rows[..1]));
    let page = html(&page(vec![session("P01", one.to_vec())]));
    assert!(!page.contains("NaN"));
    std::fs::write(std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-one-trial.html"), &page).unwrap();
}
