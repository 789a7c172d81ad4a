//! The report page: complete, self-contained, safe against hostile text; and an example page to look at.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod common;

use analysis::figures::{GazeView, TrackPoint};
use analysis::gaze::GazeSample;
use analysis::mar::{Estimate, MarFit, MarFitConfig, fit_mar};
use analysis::report::{
    AnovaRow, AnovaTable, Extra, MethodsFacts, ReportInput, SessionReport, anova_section, html, html_with,
};
use analysis::summary::Analysis;
use analysis::timing::Frame;
use common::{TRUTH, constant_stimuli, staircase};
use experiments::Display;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn finest(display: &Display, eccentricities: &[f64]) -> Vec<(f64, f64)> {
    eccentricities.iter().map(|&e| (e, display.finest_mar_deg([e, 0.0]))).collect()
}

fn example(observer: &str, seed: u64, display_name: &str, eccentricities: &[f64]) -> SessionReport {
    let display = Display::named(display_name).unwrap();
    let config = MarFitConfig { seed, finest_mar: finest(&display, eccentricities), ..MarFitConfig::default() };
    let mut trials = staircase(&TRUTH, eccentricities, 48, seed);
    // Staircases run one after the other; a session interleaves them.
    let per_ring = trials.len() / eccentricities.len();
    trials = (0..trials.len())
        .map(|i| trials[i % eccentricities.len() * per_ring + i / eccentricities.len()])
        .filter(|t| t.mar_deg > 0.03)
        .collect();
    let fit = fit_mar(&trials, &config).unwrap();
    let track = trials.iter().enumerate().map(|(i, t)| {
        let shrink = 1.0 + 12.0 / (i as f64 + 2.0);
        let estimate = |e: &Estimate| Estimate {
            estimate: e.estimate * shrink.powf(0.3),
            ci95: [e.ci95[0] / shrink, e.ci95[1] * shrink],
        };
        TrackPoint {
            trial: i as u32 + 1,
            eccentricity_deg: t.eccentricity_deg,
            mar_deg: t.mar_deg,
            correct: t.correct,
            m: Some(estimate(&fit.m)),
            omega0: Some(estimate(&fit.omega0)),
        }
    });
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drift = [0.0f64; 2];
    let gaze = (0..20_000)
        .map(|i| {
            drift = drift.map(|d| 0.995 * d + 0.08 * (rng.random::<f64>() - 0.5));
            GazeSample {
                t_s: f64::from(i) * 0.004,
                position_deg: drift,
                deviation_deg: drift[0].hypot(drift[1]),
                valid: i % 400 > 6,
            }
        })
        .collect();
    let mut presented_s = 0.0;
    let frames = (0..12_000)
        .map(|i| {
            let missed = i % 1571 == 1570 || (4000..4005).contains(&i);
            presented_s += if missed { 2.0 } else { 1.0 + 0.02 * (rng.random::<f64>() - 0.5) } / 120.0;
            Frame {
                presented_s,
                missed,
                gaze_age_s: Some(0.004 + 0.006 * rng.random::<f64>()),
                after_gap: i % 300 == 0,
            }
        })
        .collect();
    SessionReport {
        observer: observer.to_owned(),
        study: "mar-calibration".to_owned(),
        session: format!("mar-calibration_{observer}_2026-11-21T101500"),
        started: Some("21 November 2026, 10:15".to_owned()),
        display: display.clone(),
        gaze_source: "simulated: drift, microsaccades, 250 Hz".to_owned(),
        stimulus: "photograph, renderer ring".to_owned(),
        adapter: "llvmpipe (Vulkan)".to_owned(),
        seed,
        run_version: "parafovea 0.1.0".to_owned(),
        facts: vec![("Scene of practice".to_owned(), "photograph".to_owned())],
        truth: Some(TRUTH),
        track: track.collect(),
        fit: Some(fit),
        blocks: Vec::new(),
        forms: Vec::new(),
        pilot: false,
        gaze,
        gaze_view: GazeView { half_field_deg: display.half_field_deg(), fixation_deg: [0.0, 0.0], gate_deg: Some(2.0) },
        aborted_trials: 7,
        frames,
        measured_refresh_hz: Some(119.98),
        virtual_time: false,
    }
}

fn page(sessions: Vec<SessionReport>) -> ReportInput {
    ReportInput {
        title: "Acuity by eccentricity: MAR calibration".to_owned(),
        program_version: "parafovea 0.1.0".to_owned(),
        generated: Some("21 November 2026".to_owned()),
        software: vec![("Graphics".to_owned(), "wgpu 30, Vulkan".to_owned())],
        sessions,
    }
}

fn embedded(html: &str) -> Analysis {
    let start = html.find("id=\"parafovea-analysis\">").unwrap() + "id=\"parafovea-analysis\">".len();
    let end = start + html[start..].find("</script>").unwrap();
    serde_json::from_str(&html[start..end]).unwrap()
}

#[test]
fn an_example_page_is_complete_and_self_contained() {
    let input = page(vec![example("P01", 3, "demo-540p", &[2.0, 6.0, 10.0, 14.0])]);
    let html = html(&input);
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report.html");
    std::fs::write(&path, &html).unwrap();
    println!("example page: {} ({} kB)", path.display(), html.len() / 1000);

    assert_eq!(html.matches("<figure>").count(), 5);
    for absent in ["src=", "href=", "url(", "NaN", "inf\"", "@import"] {
        assert!(!html.contains(absent), "the page contains {absent}");
    }
    for tag in ["svg", "figure", "section", "table", "dl", "main", "aside", "tr", "ul"] {
        let opened = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag} is not balanced");
    }
    let fit: &MarFit = input.sessions[0].fit.as_ref().unwrap();
    let analysis = embedded(&html);
    assert_eq!(analysis.observers[0].mar.unwrap().m, fit.m);
    assert_eq!(analysis.observers[0].thresholds.len(), 4);
}

#[test]
fn several_observers_share_a_page() {
    let input = page(vec![
        example("P01", 3, "guenter-2012", &[5.0, 10.0, 15.0, 20.0, 25.0]),
        example("P02", 5, "guenter-2012", &[5.0, 10.0, 15.0, 20.0, 25.0]),
    ]);
    let html = html(&input);
    std::fs::write(std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-two.html"), &html).unwrap();
    assert_eq!(html.matches("class=\"observer\"").count(), 2);
    assert_eq!(embedded(&html).observers.len(), 2);
}

#[test]
fn hostile_text_stays_text() {
    let mut session = example("P01", 3, "demo-540p", &[5.0, 10.0]);
    let hostile = "</script><script>alert(1)</script>\"'&";
    session.observer = hostile.to_owned();
    session.gaze_source = hostile.to_owned();
    session.facts = vec![(hostile.to_owned(), hostile.to_owned())];
    let mut input = page(vec![session]);
    input.title = hostile.to_owned();
    let html = html(&input);
    assert!(!html.contains("<script>alert"));
    assert_eq!(html.matches("</script>").count(), 2);
    assert_eq!(embedded(&html).observers[0].observer, hostile);
}

#[test]
fn an_unsupported_fit_says_so_first_and_empty_records_draw() {
    let mut session = example("P01", 3, "demo-540p", &[5.0, 10.0]);
    let trials = constant_stimuli(&TRUTH, &[10.0], 9, 1);
    session.fit = Some(fit_mar(&trials, &MarFitConfig::default()).unwrap());
    session.track.clear();
    session.gaze.iter_mut().for_each(|s| s.valid = false);
    session.frames.clear();
    let html = html(&page(vec![session]));
    std::fs::write(std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-unsupported.html"), &html).unwrap();
    let warning = html.find("The data do not support this fit").unwrap();
    assert!(warning < html.find("<var>m</var> = ").unwrap());
    assert!(!html.contains("NaN"));
}

#[test]
fn no_sessions_give_a_page_that_says_so() {
    assert!(html(&page(Vec::new())).contains("nothing to report"));
}

/// The text between two marks, first occurrence after `from`.
fn between<'a>(html: &'a str, from: &str, to: &str) -> &'a str {
    let start = html.find(from).unwrap_or_else(|| panic!("{from} is missing")) + from.len();
    &html[start..start + html[start..].find(to).unwrap()]
}

#[test]
fn every_figure_of_a_page_is_valid_xml() {
    let html = html(&page(vec![example("P01", 3, "guenter-2012", &[5.0, 10.0, 15.0])]));
    let figures: Vec<&str> =
        html.split("<figure>\n").skip(1).map(|rest| rest.split("<figcaption>").next().unwrap()).collect();
    assert_eq!(figures.len(), 5);
    for svg in figures {
        let document = roxmltree::Document::parse(svg).unwrap_or_else(|error| panic!("{error}\n{svg}"));
        let root = document.root_element();
        assert_eq!((root.tag_name().name(), root.attribute("role")), ("svg", Some("img")));
    }
}

#[test]
fn methods_are_written_from_what_the_sessions_say() {
    let input = page(vec![example("P01", 3, "guenter-2012", &[5.0, 10.0])]);
    let html = html(&input);
    let methods = between(&html, "<h2>Methods</h2>", "</section>");
    for part in [
        "1 simulated observer took part.",
        "Eccentricities were 5° and 10°.",
        "1920 × 1080 pixels",
        "It was refreshed at 119.98 Hz (measured); 12 of 12000 frames were missed (0.1 %).",
        "its samples 4.0 ms apart in the median",
        "a circle of 2° around the fixation point",
        "Beta(1, 10) for λ",
        "parafovea 0.1.0",
    ] {
        assert!(methods.contains(part), "{part} is not in {methods}");
    }
    // What no session says is not there.
    assert!(!methods.contains("excluded") && !methods.contains("offscreen"));
}

#[test]
fn further_sections_facts_and_data_come_onto_the_page() {
    let input = page(vec![example("P01", 3, "demo-540p", &[5.0, 10.0])]);
    let mut facts = MethodsFacts::of(&input);
    facts.excluded_observers = vec![("P02".to_owned(), "did not <finish>".to_owned())];
    let anova = AnovaTable {
        title: "Ratings".to_owned(),
        rows: vec![AnovaRow {
            effect: "region × scene".to_owned(),
            df: [9.0, 126.0],
            f: 5.5,
            p: 2.25e-6,
            ..AnovaRow::default()
        }],
        ..AnovaTable::default()
    };
    let mut json = serde_json::Map::new();
    json.insert("anova".to_owned(), serde_json::to_value(&anova).unwrap());
    json.insert("observers".to_owned(), serde_json::Value::Null);
    let extra = Extra { methods: Some(facts), sections: vec![anova_section(&[anova])], json };
    let html = html_with(&input, &extra);
    assert!(html.contains("2 simulated observers took part; 1 was excluded: P02 (did not &lt;finish&gt;)."));
    assert!(
        html.contains("<td data-v=\"0.00000225\">0.00000225</td>"),
        "{}",
        between(&html, "region × scene", "</tr>")
    );
    assert!(html.find("Analysis of variance").unwrap() < html.find("<h2>Methods</h2>").unwrap());
    // The analysis' own keys are not overwritten.
    assert_eq!(embedded(&html).observers.len(), 1);
    assert!(between(&html, "id=\"parafovea-analysis\">", "</script>").contains("\"anova\""));
}

/// Estimate and interval ends are three cells, each a number in full precision for whoever copies it.
#[test]
fn the_parameters_paste_as_numbers() {
    let input = page(vec![example("P01", 3, "demo-540p", &[5.0, 10.0])]);
    let html = html(&input);
    let row = between(&html, "Slope m (degrees per cycle per degree)</th>", "</tr>");
    let values: Vec<f64> =
        row.split("data-v=\"").skip(1).map(|cell| cell.split('"').next().unwrap().parse().unwrap()).collect();
    let m = input.sessions[0].fit.as_ref().unwrap().m;
    assert_eq!(values, [m.estimate, m.ci95[0], m.ci95[1], TRUTH.m]);
    for cell in row.split("</td>").filter_map(|cell| cell.rsplit('>').next()).filter(|cell| !cell.trim().is_empty()) {
        assert!(cell.parse::<f64>().is_ok(), "{cell}");
    }
}
