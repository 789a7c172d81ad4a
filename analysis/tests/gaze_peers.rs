//! Events and data quality against pymovements 0.28.0 and ETDQualitizer 1.2.0, on the recording and with the numbers
//! that `tests/peers/gaze_peer.py` wrote.
#![allow(clippy::unwrap_used)]

use analysis::gaze::GazeSample;
use analysis::gaze::events::{
    Detector, EngbertKliegl, EventConfig, NoiseScale, Saccade, VelocityThreshold, VelocityWindow, detect, main_sequence,
};
use analysis::gaze::quality::{QualityConfig, data_quality};
use serde_json::Value;

const RECORDING: &str = include_str!("data/gaze_500hz.csv");
const PEER: &str = include_str!("data/gaze_peer.json");
const INTERVAL_S: f64 = 0.002;

fn sample(i: usize, place_deg: Option<[f64; 2]>) -> GazeSample {
    GazeSample {
        t_s: i as f64 * INTERVAL_S,
        position_deg: place_deg.unwrap_or([f64::NAN; 2]),
        deviation_deg: 0.0,
        valid: place_deg.is_some(),
    }
}

fn recording() -> Vec<GazeSample> {
    let place = |line: &str| {
        let (x, y) = line.split_once(',')?;
        Some([x, y].map(|v| v.parse::<f64>().unwrap() / 1000.0))
    };
    RECORDING.lines().enumerate().map(|(i, line)| sample(i, place(line))).collect()
}

fn peer() -> Value {
    serde_json::from_str(PEER).unwrap()
}

fn spans_s(value: &Value) -> Vec<[f64; 2]> {
    let spans: Vec<[f64; 2]> = serde_json::from_value(value.clone()).unwrap();
    spans.into_iter().map(|span| span.map(|ms| 1e-3 * ms)).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Nothing but the peer's own rule: no merging, no bridged gap.
fn plain(detector: Detector) -> EventConfig {
    EventConfig { detector, max_gap_s: 0.0, min_fixation_s: 0.06 }
}

#[test]
fn fixations_by_velocity_threshold_are_those_of_pymovements() {
    let detector =
        VelocityThreshold { window: VelocityWindow::Neighbours, merge_within_s: 0.0, ..VelocityThreshold::default() };
    let events = detect(&recording(), &plain(Detector::VelocityThreshold(detector))).unwrap();
    let peer = &peer()["ivt"];
    let expected = spans_s(&peer["fixations_ms"]);
    assert_eq!(events.fixations.len(), expected.len());
    let samples = recording();
    let beside_loss = |t_s: f64| {
        let i = (t_s / INTERVAL_S).round() as i64;
        (i - 2..=i + 2).any(|near| usize::try_from(near).ok().and_then(|n| samples.get(n)).is_none_or(|s| !s.valid))
    };
    let mut exact = 0;
    for (i, (found, [onset_s, offset_s])) in events.fixations.iter().zip(expected).enumerate() {
        let (early, late) = (found.onset_s - onset_s, found.offset_s - offset_s);
        // They have no velocity beside a lost sample or at the recording's ends, where we have a one-sided one.
        for (off_s, at_s) in [(early, onset_s), (late, offset_s)] {
            let allowed = if beside_loss(at_s) { 1.01 * INTERVAL_S } else { 1e-9 };
            assert!(off_s.abs() < allowed, "{found:?}");
        }
        if early.abs() + late.abs() < 1e-9 {
            exact += 1;
            // Planar degrees of theirs, true angles of ours: up to 1 % at 8°.
            let dispersion = number(&peer["measures"][i][2]);
            assert!((found.dispersion_deg / dispersion - 1.0).abs() < 0.02, "{found:?}, {dispersion}");
        }
    }
    println!("{exact} of {} fixations at the very same samples", events.fixations.len());
    assert!(exact >= 20);
}

#[test]
fn microsaccades_and_their_thresholds_are_those_of_pymovements() {
    for (name, noise_scale) in
        [("engbert2003", NoiseScale::MedianOfSquares), ("engbert2015", NoiseScale::MedianDeviation)]
    {
        let detector = EngbertKliegl { noise_scale, ..EngbertKliegl::default() };
        let events = detect(&recording(), &plain(Detector::EngbertKliegl(detector))).unwrap();
        let peer = &peer()[name];
        for axis in 0..2 {
            let (found, expected) = (events.noise.unwrap().sd_deg_s[axis], number(&peer["sd_deg_s"][axis]));
            assert!((found / expected - 1.0).abs() < 0.01, "{name}: spread {found}, {expected}");
        }
        let expected = spans_s(&peer["saccades_ms"]);
        assert_eq!(events.saccades.len(), expected.len(), "{name}");
        let mut exact = 0;
        for (i, (found, [onset_s, offset_s])) in events.saccades.iter().zip(expected).enumerate() {
            let (early, late) = (found.onset_s - onset_s, found.offset_s - offset_s);
            assert!(early.abs() < 1.01 * INTERVAL_S && late.abs() < 1.01 * INTERVAL_S, "{name}: {found:?}");
            if early.abs() + late.abs() < 1e-9 {
                exact += 1;
                let [amplitude, peak] = [0, 1].map(|column| number(&peer["measures"][i][column]));
                assert!((found.excursion_deg / amplitude - 1.0).abs() < 0.02, "{found:?}, {amplitude}");
                assert!((found.peak_velocity_deg_s / peak - 1.0).abs() < 0.02, "{found:?}, {peak}");
            }
        }
        println!("{name}: {exact} of {} saccades at the very same samples", events.saccades.len());
        assert!(exact >= 28);
    }
}

#[test]
fn data_quality_is_that_of_etdqualitizer() {
    for case in peer()["quality"].as_array().unwrap() {
        let places: Vec<Option<[f64; 2]>> = serde_json::from_value(case["position_mdeg"].clone()).unwrap();
        let samples: Vec<GazeSample> =
            places.iter().enumerate().map(|(i, place)| sample(i, place.map(|p| p.map(|v| 1e-3 * v)))).collect();
        let target_deg: [f64; 2] = serde_json::from_value(case["target_deg"].clone()).unwrap();
        let config = QualityConfig {
            target_deg: Some(target_deg),
            window_s: Some([0.0, samples.len() as f64 * INTERVAL_S]),
            nominal_rate_hz: Some(500.0),
            ..QualityConfig::default()
        };
        let quality = data_quality(&samples, &config).unwrap();
        let (accuracy, precision) = (quality.accuracy.unwrap(), quality.precision.unwrap());
        // Fick's azimuth is no true angle off the horizon: at 8° up it is 1 % more. The centre has no such excuse.
        let tolerance = if target_deg == [0.0, 0.0] { 2e-4 } else { 0.02 };
        let near = |name: &str, found: f64, expected: f64, tolerance: f64| {
            println!("{target_deg:?} {name}: {found} against {expected}");
            assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found} against {expected}");
        };
        near("offset", accuracy.offset_of_mean_deg, number(&case["offset_deg"]), 1e-6);
        near("rms", precision.rms_s2s_deg.unwrap(), number(&case["rms_s2s_deg"]), tolerance);
        near("sd", precision.sd_deg, number(&case["sd_deg"]), tolerance);
        for axis in 0..2 {
            near("sd of an axis", precision.sd_axes_deg[axis], number(&case["sd_axes_deg"][axis]), tolerance);
        }
        near("BCEA 68", precision.bcea.area_68_deg2, number(&case["bcea_68_deg2"]), 2.0 * tolerance);
        near("BCEA 95", precision.bcea.area_95_deg2, number(&case["bcea_95_deg2"]), 2.0 * tolerance);
        let turned = precision.bcea.orientation_deg.unwrap() - number(&case["orientation_deg"]);
        assert!(turned.abs() < 100.0 * tolerance, "orientation off by {turned}°");
        assert!((100.0 * quality.loss.invalid_share.unwrap() - number(&case["invalid_percent"])).abs() < 1e-9);
        let missing = 100.0 * quality.loss.missing_of_expected_share.unwrap();
        assert!((missing - number(&case["missing_percent"])).abs() < 1e-9);
        near("rate", quality.rate.effective_hz.unwrap(), number(&case["effective_hz"]), 1e-9);
    }
}

/// scipy 1.17.1, `linregress` on the logarithms.
#[test]
fn the_main_sequence_is_scipys_line() {
    let amplitudes = [0.4, 0.8, 1.5, 3.0, 5.0, 8.0, 12.0, 20.0];
    let velocities = [31.0, 52.0, 95.0, 148.0, 212.0, 281.0, 350.0, 402.0];
    let saccades: Vec<Saccade> = amplitudes
        .into_iter()
        .zip(velocities)
        .map(|(amplitude_deg, peak_velocity_deg_s)| Saccade {
            onset_s: 0.0,
            offset_s: 0.0,
            duration_s: 0.0,
            amplitude_deg,
            excursion_deg: amplitude_deg,
            peak_velocity_deg_s,
            direction_deg: 0.0,
            from_deg: [0.0; 2],
            to_deg: [amplitude_deg, 0.0],
            complete: true,
        })
        .collect();
    let fit = main_sequence(&saccades).unwrap();
    let peer = &peer()["main_sequence"];
    for (found, expected) in [
        (fit.exponent, number(&peer["exponent"])),
        (fit.exponent_ci95[0], number(&peer["exponent_ci95"][0])),
        (fit.exponent_ci95[1], number(&peer["exponent_ci95"][1])),
        (fit.k_deg_s, number(&peer["k"])),
        (fit.k_ci95_deg_s[0], number(&peer["k_ci95"][0])),
        (fit.k_ci95_deg_s[1], number(&peer["k_ci95"][1])),
        (fit.r2.unwrap(), number(&peer["r2"])),
    ] {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} against {expected}");
    }
    assert!(main_sequence(&saccades[..2]).is_none());
}
