//! What holds for every figure, whatever the data: valid XML, no number that is none, everything on the page, and no text
//! over another.

use super::*;
use crate::gaze::GazeSample;
use crate::mar::Estimate;
use crate::svg::text_width;
use crate::timing::Frame;
use proptest::prelude::*;

/// Rounding, and the outer half of a stroke.
const SLACK: f64 = 1.5;

/// Left, top, right, bottom of a text as it is laid out, and the text.
struct Placed {
    sides: [f64; 4],
    text: String,
}

fn number(node: &roxmltree::Node<'_, '_>, name: &str) -> f64 {
    let text = node.attribute(name).unwrap_or_else(|| panic!("{name} is missing"));
    text.parse().unwrap_or_else(|_| panic!("{name}={text}"))
}

fn placed(node: &roxmltree::Node<'_, '_>) -> Placed {
    let text = node.text().unwrap_or_default().to_owned();
    let (x, y, size) = (number(node, "x"), number(node, "y"), number(node, "font-size"));
    let width = text_width(&text, size) * if node.attribute("font-weight").is_some() { 1.1 } else { 1.0 };
    let before = match node.attribute("text-anchor") {
        Some("middle") => 0.5 * width,
        Some("end") => width,
        _ => 0.0,
    };
    // Letters stand on y and rise about three quarters of their size.
    let sides = if node.has_attribute("transform") {
        [x - 0.75 * size, y - width + before, x + 0.2 * size, y + before]
    } else {
        [x - before, y - 0.75 * size, x - before + width, y + 0.2 * size]
    };
    Placed { sides, text }
}

/// Every number of a list or path.
fn numbers(text: &str) -> Vec<f64> {
    text.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'))
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().unwrap_or_else(|_| panic!("{part} in {text}")))
        .collect()
}

/// Holds a figure against everything that must be so, and returns its texts.
fn inspect(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap_or_else(|error| panic!("{error}\n{svg}"));
    let root = document.root_element();
    let page = [number(&root, "width"), number(&root, "height")];
    assert_eq!(root.attribute("role"), Some("img"));
    assert!(root.attribute("aria-label").is_some_and(|label| !label.is_empty()));
    for name in ["title", "desc"] {
        let element = root.children().find(|node| node.has_tag_name(("http://www.w3.org/2000/svg", name)));
        assert!(element.and_then(|node| node.text().map(str::len)).is_some_and(|length| length > 0), "{name}");
    }
    let mut texts: Vec<Placed> = Vec::new();
    for node in root.descendants().filter(|node| node.is_element()) {
        for attribute in node.attributes().filter(|a| !matches!(a.name(), "aria-label" | "font-family" | "class")) {
            let value = attribute.value();
            assert!(!value.contains("NaN") && !value.contains("inf"), "{}={value}", attribute.name());
        }
        let clipped = node.ancestors().skip(1).any(|a| a.tag_name().name() == "svg" && a != root);
        // What is cut at a panel's frame may reach out of it, but not to where a renderer loses precision.
        let bound = |axis: usize| if clipped { [-12.0 * 2000.0, 12.0 * 2000.0] } else { [-SLACK, page[axis] + SLACK] };
        let check = |value: f64, axis: usize| {
            let [low, high] = bound(axis);
            assert!((low..=high).contains(&value), "{value} of {page:?} in {node:?}");
        };
        for (names, axis) in [(["x", "x1", "x2", "cx"], 0), (["y", "y1", "y2", "cy"], 1)] {
            names.iter().filter_map(|name| node.attribute(*name)).for_each(|v| check(v.parse().unwrap(), axis));
        }
        if let Some(points) = node.attribute("points") {
            numbers(points).iter().enumerate().for_each(|(i, v)| check(*v, i % 2));
        }
        if let Some(path) = node.attribute("d") {
            numbers(path).iter().for_each(|v| check(*v, usize::from(page[1] > page[0])));
        }
        if node.tag_name().name() == "text" && !clipped {
            texts.push(placed(&node));
        }
    }
    for (i, a) in texts.iter().enumerate() {
        let [left, top, right, bottom] = a.sides;
        assert!(
            left >= -2.0 && top >= -2.0 && right <= page[0] + 2.0 && bottom <= page[1] + 2.0,
            "“{}” leaves the page: {:?} of {page:?}",
            a.text,
            a.sides
        );
        for b in &texts[..i] {
            let apart = a.sides[0] >= b.sides[2]
                || b.sides[0] >= a.sides[2]
                || a.sides[1] >= b.sides[3]
                || b.sides[1] >= a.sides[3];
            assert!(apart, "“{}” {:?} lies over “{}” {:?}", a.text, a.sides, b.text, b.sides);
        }
    }
    texts.into_iter().map(|placed| placed.text).collect()
}

/// Ordinary numbers, and everything that can go wrong with numbers.
fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -3.0..30.0f64,
        2 => Just(0.02),
        1 => prop_oneof![
            Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY), Just(0.0), Just(-0.0), Just(1e300), Just(-1e300),
            Just(1e-300), Just(4.2e9), Just(-1e12), Just(1e11), Just(3e-9),
        ],
    ]
}

fn values(most: usize) -> impl Strategy<Value = Vec<f64>> {
    prop_oneof![
        Just(Vec::new()),
        value().prop_map(|v| vec![v]),
        (value(), 2..9usize).prop_map(|(v, n)| vec![v; n]),
        prop::collection::vec(value(), 0..most),
    ]
}

fn name() -> impl Strategy<Value = String> {
    prop_oneof![
        Just(String::new()),
        Just("P01".to_owned()),
        Just("<b>&\"'\u{1}".to_owned()),
        Just(
            "a condition whose name goes on and on, as names in studies may well do when they are generated".to_owned()
        ),
    ]
}

fn estimate() -> impl Strategy<Value = Estimate> {
    (value(), value(), value()).prop_map(|(estimate, low, high)| Estimate { estimate, ci95: [low, high] })
}

fn curve() -> impl Strategy<Value = PsychometricCurve> {
    let point = (value(), 0..30usize, 0..30usize).prop_map(|(level, k, n)| LevelCount { level, k, n });
    let band = (value(), value(), value(), value()).prop_map(|(x, low, mid, high)| BandPoint { x, low, mid, high });
    (
        name(),
        prop::collection::vec(point, 0..9),
        prop::collection::vec(band, 0..9),
        prop::option::of(estimate()),
        prop::option::of(value()),
        prop::option::of(value()),
        any::<bool>(),
    )
        .prop_map(|(name, points, band, threshold, guess, lapse, supported)| PsychometricCurve {
            name,
            points,
            band,
            threshold,
            guess,
            lapse,
            supported,
        })
}

fn cell_means(values: &[f64]) -> Vec<Option<CellMean>> {
    let means = values.iter().enumerate().map(|(i, &mean)| {
        let ci95 = values.get(i + 1).map(|&other| [mean - other.abs(), mean + other.abs()]);
        (i % 5 != 4).then_some(CellMean { mean, ci95 })
    });
    means.collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn functions_hold(curves in prop::collection::vec(curve(), 0..8), label in name(), logarithmic: bool, small_multiples: bool) {
        let view = PsychometricView { level_label: label.clone(), share_label: label, logarithmic, small_multiples };
        inspect(&psychometric_functions(&curves, &view));
    }

    #[test]
    fn groups_of_lines_hold(
        lines in prop::collection::vec((name(), value(), value(), values(9)), 0..9),
        group in prop::option::of((estimate(), estimate(), values(9))),
        finest in values(5),
        reference in prop::option::of((name(), value(), value())),
    ) {
        let observers = lines.into_iter().map(|(observer, m, omega0_deg, v)| ObserverLine {
            observer,
            m,
            omega0_deg,
            thresholds: v.windows(2).map(|w| LineThreshold {
                eccentricity_deg: w[0], mar_deg: w[1], ci95: Some([w[1], w[0]]), limited: w[0] > w[1],
            }).collect(),
        });
        let band = |v: Vec<f64>| v.windows(2).map(|w| BandPoint { x: w[0], low: w[1], mid: w[1], high: w[0] }).collect();
        inspect(&mar_group(&MarGroup {
            observers: observers.collect(),
            group: group.map(|(m, omega0, v)| GroupLine { m, omega0, band: band(v) }),
            finest_mar: finest.windows(2).map(|w| (w[0], w[1])).collect(),
            references: reference.map(|(name, m, omega0_deg)| ReferenceLine { name, m, omega0_deg }).into_iter().collect(),
        }));
    }

    #[test]
    fn posteriors_hold(posteriors in prop::collection::vec((name(), values(40), prop::option::of((value(), value()))), 0..5)) {
        let posteriors: Vec<JointPosterior> = posteriors.into_iter().map(|(name, v, estimate)| JointPosterior {
            name,
            draws: v.windows(2).map(|w| [w[0], w[1]]).collect(),
            estimate: estimate.map(|(m, omega0)| [m, omega0]),
        }).collect();
        inspect(&joint_posterior(&posteriors));
    }

    #[test]
    fn histograms_hold(
        groups in prop::collection::vec((name(), values(20), prop::option::of((name(), value(), value()))), 0..5),
        label in name(),
        bin in prop::option::of(value()),
        range in prop::option::of((value(), value())),
    ) {
        let groups: Vec<ThresholdGroup> = groups.into_iter().map(|(name, values, published)| ThresholdGroup {
            name,
            without: values.len() % 3,
            values,
            published: published.map(|(source, mean, sd)| Published { source, mean, sd }),
        }).collect();
        inspect(&threshold_histograms(&groups, &HistogramView { label, bin, range: range.map(|(a, b)| [a, b]) }));
    }

    #[test]
    fn savings_hold(
        v in values(20), mark in prop::option::of((name(), value())), slope_times_quality in prop::option::of(value()),
        published in prop::option::of((value(), value(), value())), publication in name(),
        layers in prop::collection::vec((name(), values(9)), 0..6),
    ) {
        let points = v.windows(3).map(|w| SpeedupPoint {
            quality: w[0], pixels: Some(w[1]), pixels_half_rate: Some(w[2]), time: Some(w[1]), time_ci95: Some([w[2], w[0]]),
        });
        inspect(&speedup(&Speedup {
            points: points.collect(),
            marks: mark.map(|(name, quality)| QualityMark { name, quality }).into_iter().collect(),
            published: published.map(|(quality, pixels, time)| PublishedSaving { quality, pixels, time }).into_iter().collect(),
            publication,
            layers: layers.into_iter().map(|(name, v)| LayerCurve {
                name,
                points: v.windows(3).map(|w| LayerPoint { quality: w[0], pixels: Some(w[1]), time_ms: Some(w[2]) }).collect(),
            }).collect(),
            slope_times_quality,
        }));
    }

    #[test]
    fn bars_of_ratings_hold(
        groups in prop::collection::vec((name(), prop::collection::vec((name(), prop::collection::vec(0..20usize, 0..9)), 0..5)), 0..4),
        steps in (-12..3i32, -3..12i32),
        ends in (name(), name()),
    ) {
        let row = |(name, counts)| LikertRow { name, counts };
        let groups = groups.into_iter().map(|(heading, rows)| LikertGroup { heading, rows: rows.into_iter().map(row).collect() });
        let chart = LikertChart { title: "Item".to_owned(), steps: [steps.0, steps.1], ends: [ends.0, ends.1], groups: groups.collect() };
        inspect(&likert_bars(&chart));
    }

    #[test]
    fn boxes_hold(
        groups in prop::collection::vec((name(), values(20)), 0..5), label in name(), tukey: bool, notches: bool,
        range in prop::option::of((value(), value())),
    ) {
        let whiskers = if tukey { Whiskers::Tukey } else { Whiskers::Range };
        inspect(&box_plots(&BoxChart {
            title: "Boxes".to_owned(),
            label,
            groups: groups.into_iter().map(|(name, values)| BoxGroup { name, values }).collect(),
            whiskers,
            notches,
            range: range.map(|(a, b)| [a, b]),
        }));
    }

    #[test]
    fn blurs_hold(patches in prop::collection::vec((name(), values(12)), 0..6)) {
        let patches: Vec<PatchBlur> = patches.into_iter().map(|(patch, v)| PatchBlur {
            patch, points: v.windows(2).map(|w| [w[0], w[1]]).collect(),
        }).collect();
        inspect(&blur_by_eccentricity(&patches, "σ_s (px)"));
    }

    #[test]
    fn rates_hold(
        series in prop::collection::vec((name(), values(9)), 0..6), label in name(),
        chance in prop::option::of(value()), criterion in prop::option::of(value()), logarithmic: bool,
    ) {
        let series: Vec<RateSeries> = series.into_iter().map(|(name, v)| RateSeries {
            name,
            points: v.windows(2).map(|w| RatePoint { multiplier: w[0], rate: w[1], standard_error: Some(w[1]), n: 3 }).collect(),
        }).collect();
        inspect(&detection_rates(&series, &RateView { label, chance, criterion, logarithmic }));
    }

    #[test]
    fn interactions_hold(
        panels in prop::collection::vec((name(), prop::collection::vec((name(), values(9)), 0..4)), 0..5),
        levels in prop::collection::vec(name(), 0..9), label in name(),
    ) {
        let panels = panels.into_iter().map(|(name, lines)| InteractionPanel {
            name,
            lines: lines.into_iter().map(|(name, v)| InteractionLine { name, cells: cell_means(&v) }).collect(),
        });
        inspect(&interaction(&Interaction {
            label: label.clone(), factor: label.clone(), levels, interval: label, panels: panels.collect(),
        }));
    }

    #[test]
    fn within_subject_means_hold(rows in prop::collection::vec(prop::collection::vec(value(), 0..4), 0..6)) {
        for mean in within_subject_means(&rows) {
            prop_assert!(!mean.mean.is_nan());
        }
    }

    #[test]
    fn gaze_and_frames_hold(
        v in values(30), half in (value(), value()), fixation in (value(), value()), gate_deg in prop::option::of(value()),
        refresh in prop::option::of(value()),
    ) {
        let samples: Vec<GazeSample> = v.windows(2).enumerate().map(|(i, w)| GazeSample {
            t_s: i as f64, position_deg: [w[0], w[1]], deviation_deg: w[0], valid: i % 4 != 3,
        }).collect();
        let view = GazeView { half_field_deg: [half.0, half.1], fixation_deg: [fixation.0, fixation.1], gate_deg };
        inspect(&gaze_density(&samples, &view));
        let frames: Vec<Frame> = v.iter().enumerate().map(|(i, t)| Frame {
            presented_s: *t, missed: i % 3 == 2, gaze_age_s: Some(*t), after_gap: i % 7 == 0,
        }).collect();
        inspect(&frame_timing(&frames, refresh));
    }

    #[test]
    fn tracks_hold(v in values(20), estimates in prop::collection::vec(prop::option::of(estimate()), 20)) {
        let track: Vec<TrackPoint> = v.windows(2).zip(&estimates).enumerate().map(|(i, (w, estimate))| TrackPoint {
            trial: i as u32 + 1, eccentricity_deg: w[0], mar_deg: w[1], correct: i % 2 == 0, m: *estimate, omega0: *estimate,
        }).collect();
        inspect(&adaptive_track(&track));
    }
}

#[test]
fn figures_of_nothing_say_so() {
    let view = PsychometricView {
        level_label: String::new(),
        share_label: String::new(),
        logarithmic: true,
        small_multiples: false,
    };
    let below_zero = PsychometricCurve {
        name: String::new(),
        points: vec![LevelCount { level: -1.0, k: 1, n: 2 }],
        band: Vec::new(),
        threshold: None,
        guess: None,
        lapse: None,
        supported: true,
    };
    let view_of_gaze = GazeView { half_field_deg: [20.0, 10.0], fixation_deg: [0.0; 2], gate_deg: None };
    for svg in [
        psychometric_functions(&[below_zero], &view),
        mar_group(&MarGroup::default()),
        joint_posterior(&[]),
        threshold_histograms(&[], &HistogramView { label: String::new(), bin: None, range: None }),
        speedup(&Speedup::default()),
        blur_by_eccentricity(&[], "σ_s (px)"),
        gaze_density(&[], &view_of_gaze),
        frame_timing(&[], None),
        adaptive_track(&[]),
    ] {
        let texts = inspect(&svg);
        assert!(texts.iter().any(|text| text.starts_with("Nothing to draw: ")), "{texts:?}");
    }
}

#[test]
fn what_is_left_out_is_counted() {
    let groups = [ThresholdGroup {
        name: "pair".to_owned(),
        values: vec![12.0, f64::NAN, 14.0, 1e300],
        without: 1,
        published: None,
    }];
    let texts =
        inspect(&threshold_histograms(&groups, &HistogramView { label: "j".to_owned(), bin: Some(1.0), range: None }));
    assert!(texts.iter().any(|text| text == "n = 2, 1 without, mean 13, SD 1.41"), "{texts:?}");
    assert!(texts.iter().any(|text| text == "2 thresholds that are no drawable numbers are left out."), "{texts:?}");
}

/// A curve's Wilson interval, threshold and point stand where the axes say: checked against the pixels of the ticks.
#[test]
fn a_point_is_drawn_at_its_share() {
    let curve = PsychometricCurve {
        name: String::new(),
        points: vec![LevelCount { level: 2.0, k: 15, n: 20 }, LevelCount { level: 4.0, k: 20, n: 20 }],
        band: Vec::new(),
        threshold: None,
        guess: None,
        lapse: None,
        supported: true,
    };
    let view = PsychometricView {
        level_label: "Level".to_owned(),
        share_label: "Share".to_owned(),
        logarithmic: false,
        small_multiples: false,
    };
    let svg = psychometric_functions(&[curve], &view);
    let document = roxmltree::Document::parse(&svg).unwrap();
    let tick = |text: &str, axis: &str| {
        let node = document.descendants().find(|node| node.tag_name().name() == "text" && node.text() == Some(text));
        number(&node.unwrap_or_else(|| panic!("{text} in {svg}")), axis)
    };
    let circles: Vec<[f64; 2]> = document
        .descendants()
        .filter(|node| {
            node.tag_name().name() == "circle" && node.ancestors().filter(|a| a.tag_name().name() == "svg").count() == 2
        })
        .map(|node| [number(&node, "cx"), number(&node, "cy")])
        .collect();
    assert_eq!(circles.len(), 2);
    let share = (circles[0][1] - tick("0 %", "y") + 4.0) / (tick("100 %", "y") - tick("0 %", "y"));
    assert!((share - 0.75).abs() < 0.002, "{share}");
    assert!((circles[1][0] - tick("4.0", "x")).abs() < 0.02 && (circles[0][0] - tick("2.0", "x")).abs() < 0.02);
}
