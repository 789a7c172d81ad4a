//! Saccades and fixations against closed forms and simulated recordings with known truth.
#![allow(clippy::unwrap_used)]

use analysis::gaze::events::{
    Detector, EventConfig, EventSummary, VelocityThreshold, VelocityWindow, detect, detect_binocular, main_sequence,
};
use analysis::gaze::{GazeError, GazeSample, sorted_by_time};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn sample(t_s: f64, position_deg: [f64; 2]) -> GazeSample {
    GazeSample { t_s, position_deg, deviation_deg: 0.0, valid: true }
}

/// Share of the way of a minimum-jerk movement (Flash & Hogan 1985) after the share `u` of its time; its velocity is
/// 30 u² (1 − u)² times the mean one, at most 1.875.
fn minimum_jerk(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

/// Horizontal saccades (onset s, duration s, degrees) one after the other from `start_deg`.
fn horizontal(rate_hz: f64, duration_s: f64, start_deg: f64, saccades: &[[f64; 3]]) -> Vec<GazeSample> {
    (0..(rate_hz * duration_s) as u32)
        .map(|i| f64::from(i) / rate_hz)
        .map(|t| {
            let moved: f64 = saccades.iter().map(|[on, lasts, by]| by * minimum_jerk((t - on) / lasts)).sum();
            sample(t, [start_deg + moved, 0.0])
        })
        .collect()
}

fn neighbours() -> EventConfig {
    let detector =
        VelocityThreshold { window: VelocityWindow::Neighbours, merge_within_s: 0.0, ..VelocityThreshold::default() };
    EventConfig { detector: Detector::VelocityThreshold(detector), ..EventConfig::velocity_threshold() }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Where the velocity 30 A/D u² (1 − u)² crosses the threshold: u (1 − u) = √(threshold · D / 30 A).
#[test]
fn a_minimum_jerk_saccade_has_its_closed_form_boundaries() {
    for rate_hz in [250.0, 500.0, 1000.0, 2000.0] {
        for amplitude in [1.0, 4.0, 10.0, -20.0] {
            let (onset_s, lasts_s) = (0.3011, 0.021 + 0.0022 * f64::abs(amplitude));
            let samples = horizontal(rate_hz, 0.7, 2.0, &[[onset_s, lasts_s, amplitude]]);
            let events = detect(&samples, &neighbours()).unwrap();
            let [saccade] = events.saccades[..] else { panic!("{rate_hz} Hz, {amplitude}°: {:?}", events.saccades) };
            let root = (30.0 * lasts_s / (30.0 * amplitude.abs())).sqrt();
            let u = 0.5 * (1.0 - (1.0 - 4.0 * root).sqrt());
            let interval_s = 1.0 / rate_hz;
            let late_s = saccade.onset_s - (onset_s + u * lasts_s);
            let early_s = onset_s + (1.0 - u) * lasts_s - saccade.offset_s;
            // A central difference sees an interval further than the sample itself.
            assert!(late_s.abs() < 1.5 * interval_s && early_s.abs() < 1.5 * interval_s, "{late_s}, {early_s}");
            let missed = 2.0 * amplitude.abs() * minimum_jerk(u);
            assert!(saccade.amplitude_deg <= amplitude.abs() + 1e-9);
            assert!(saccade.amplitude_deg >= amplitude.abs() - missed - 1e-6, "{saccade:?}");
            if rate_hz >= 1000.0 {
                let peak = 1.875 * amplitude.abs() / lasts_s;
                assert!((saccade.peak_velocity_deg_s / peak - 1.0).abs() < 0.02, "{saccade:?}, peak {peak}");
            }
            let heading = if amplitude > 0.0 { 0.0 } else { 180.0 };
            assert!((saccade.direction_deg.abs() - heading).abs() < 1e-6 && saccade.complete);
            assert_eq!(events.fixations.len(), 2);
            assert!((events.fixations[1].centroid_deg[0] - 2.0 - amplitude).abs() < 0.02);
        }
    }
}

/// A threshold cuts off the slow ends of a movement, of small ones the more; at 2°/s that is hardly anything.
///
/// Durations chosen so that the peak velocities of minimum-jerk movements, 1.875 A/D, follow V = 80 A^0.6 exactly.
#[test]
fn the_main_sequence_is_recovered() {
    let amplitudes = [0.5, 1.0, 2.0, 4.0, 6.0, 9.0, 12.0];
    let mut plan = Vec::new();
    for (i, amplitude) in amplitudes.into_iter().enumerate() {
        let lasts_s = 1.875 * amplitude / (80.0 * f64::powf(amplitude, 0.6));
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        plan.push([0.3 + 0.5 * i as f64, lasts_s, sign * amplitude]);
    }
    let samples = horizontal(2000.0, 4.0, 0.0, &plan);
    let detector = VelocityThreshold {
        threshold_deg_s: 2.0,
        window: VelocityWindow::Neighbours,
        merge_within_s: 0.0,
        ..VelocityThreshold::default()
    };
    let config = EventConfig { detector: Detector::VelocityThreshold(detector), ..neighbours() };
    let events = detect(&samples, &config).unwrap();
    let fit = main_sequence(&events.saccades).unwrap();
    println!("{fit:?}");
    assert_eq!(fit.n, amplitudes.len());
    assert!((fit.exponent - 0.6).abs() < 0.004 && (fit.k_deg_s / 80.0 - 1.0).abs() < 0.01, "{fit:?}");
    let summary = EventSummary::new(&events);
    assert!((summary.saccades_per_s.unwrap() - 7.0 / 4.0).abs() < 1e-3);
    assert_eq!(summary.main_sequence, Some(fit));
}

/// The recording's generator (`tests/peers/gaze_peer.py`) wrote down what it did: 32 saccades and microsaccades.
#[test]
fn a_noisy_recording_gives_back_its_saccades() {
    let place = |line: &str| line.split_once(',').map(|(x, y)| [x, y].map(|v| v.parse::<f64>().unwrap() / 1000.0));
    let samples: Vec<GazeSample> = include_str!("data/gaze_500hz.csv")
        .lines()
        .enumerate()
        .map(|(i, line)| GazeSample {
            valid: !line.is_empty(),
            ..sample(i as f64 * 0.002, place(line).unwrap_or([f64::NAN; 2]))
        })
        .collect();
    let truth: Vec<[f64; 4]> = include_str!("data/gaze_500hz_truth.csv")
        .lines()
        .skip(1)
        .map(|line| std::array::from_fn(|i| line.split(',').nth(i).unwrap().parse().unwrap()))
        .collect();
    let events = detect(&samples, &EventConfig::engbert_kliegl()).unwrap();
    assert_eq!((events.saccades.len(), truth.len()), (32, 32));
    for (found, [onset_s, lasts_s, right, up]) in events.saccades.iter().zip(truth) {
        // A velocity of five samples sees 4 ms ahead and behind; six spreads take some milliseconds to exceed.
        assert!((found.onset_s - onset_s).abs() < 0.007, "{found:?} began at {onset_s}");
        assert!((found.offset_s - onset_s - lasts_s).abs() < 0.007, "{found:?} lasted {lasts_s}");
        // The ends of a slow movement are below threshold, and noise is 0.008° an axis.
        assert!((found.amplitude_deg - right.hypot(up)).abs() < 0.06, "{found:?}: {right}, {up}");
        let turn = (found.direction_deg - up.atan2(right).to_degrees() + 540.0).rem_euclid(360.0) - 180.0;
        assert!(turn.abs() < 8.0, "{found:?}: {right}, {up}");
    }
    // The blink of 150 ms cuts the recording; lost single samples are bridged.
    assert_eq!((events.segments, events.limits.len()), (2, 0));
}

/// A saccade that nobody saw is none, whether the samples came as invalid or never came.
#[test]
fn no_event_spans_a_gap_above_the_limit() {
    let whole = horizontal(1000.0, 1.0, 0.0, &[[0.5, 0.04, 8.0]]);
    let hidden = |s: &GazeSample| (0.49..0.55).contains(&s.t_s);
    let invalid: Vec<GazeSample> = whole.iter().map(|s| GazeSample { valid: !hidden(s), ..*s }).collect();
    let absent: Vec<GazeSample> = whole.iter().filter(|s| !hidden(s)).copied().collect();
    for samples in [&invalid, &absent] {
        for config in [EventConfig::velocity_threshold(), EventConfig::engbert_kliegl(), neighbours()] {
            let events = detect(samples, &config).unwrap();
            assert!(events.saccades.is_empty(), "{:?}", events.saccades);
            assert_eq!((events.segments, events.fixations.len()), (2, 2));
            assert!(events.fixations.iter().all(|f| f.offset_s < 0.5 || f.onset_s > 0.54));
            assert!(events.fixations.iter().all(|f| !f.complete));
            assert!((events.searched_s - 0.938).abs() < 1e-9, "{}", events.searched_s);
        }
    }
    // A limit that allows it bridges the gap, and then the movement is one: the choice is the caller's.
    let bridged = detect(&invalid, &EventConfig { max_gap_s: 0.1, ..neighbours() }).unwrap();
    assert_eq!((bridged.segments, bridged.saccades.len()), (1, 1));
}

#[test]
fn a_saccade_cut_by_a_gap_is_incomplete() {
    let samples: Vec<GazeSample> = horizontal(1000.0, 1.0, 0.0, &[[0.5, 0.04, 8.0]])
        .into_iter()
        .filter(|s| !(0.52..0.56).contains(&s.t_s))
        .collect();
    let events = detect(&samples, &neighbours()).unwrap();
    assert_eq!(events.saccades.len(), 1);
    assert!(!events.saccades[0].complete && events.saccades[0].offset_s < 0.52);
    assert!(EventSummary::new(&events).amplitude_deg.is_none());
}

/// Microsaccade-sized noise bursts in one eye are no binocular saccades; what both eyes do is.
#[test]
fn binocular_saccades_are_those_of_both_eyes() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut eye = |extra: f64| -> Vec<GazeSample> {
        horizontal(500.0, 3.0, 0.0, &[[0.5, 0.022, 0.4], [1.5, 0.03, 4.0], [2.2, 0.022, extra]])
            .into_iter()
            .map(|s| {
                let noise = [0.006 * normal(&mut rng), 0.006 * normal(&mut rng)];
                sample(s.t_s, [s.position_deg[0] + noise[0], noise[1]])
            })
            .collect()
    };
    let (left, right) = (eye(0.5), eye(0.0));
    let ([of_left, of_right], both) = detect_binocular(&left, &right, &EventConfig::engbert_kliegl()).unwrap();
    assert_eq!((of_left.saccades.len(), of_right.saccades.len(), both.len()), (3, 2, 2));
    assert!(both.iter().all(|b| b.onset_s <= b.left.onset_s.min(b.right.onset_s) && b.offset_s >= b.left.offset_s));
}

/// Rotating all directions about the line of sight, or moving a recording in time, changes no event.
#[test]
fn events_do_not_depend_on_orientation_or_origin_of_time() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let samples: Vec<GazeSample> =
        horizontal(500.0, 4.0, -3.0, &[[0.6, 0.03, 5.0], [1.9, 0.025, 1.5], [3.0, 0.03, -4.0]])
            .into_iter()
            .map(|s| sample(s.t_s, [s.position_deg[0] + 0.01 * normal(&mut rng), 2.0 + 0.01 * normal(&mut rng)]))
            .collect();
    let (sin, cos) = 0.7f64.sin_cos();
    let turned: Vec<GazeSample> = samples
        .iter()
        .map(|s| {
            let [x, y] = s.position_deg.map(|v| v.to_radians().tan());
            sample(s.t_s, [cos * x - sin * y, sin * x + cos * y].map(|v| v.atan().to_degrees()))
        })
        .collect();
    let later: Vec<GazeSample> = samples.iter().map(|s| GazeSample { t_s: s.t_s + 1024.0, ..*s }).collect();
    let plain = detect(&samples, &EventConfig::velocity_threshold()).unwrap();
    assert_eq!(plain.saccades.len(), 3);
    for (other, shift_s) in [(turned, 0.0), (later, 1024.0)] {
        let other = detect(&other, &EventConfig::velocity_threshold()).unwrap();
        assert_eq!((other.saccades.len(), other.fixations.len()), (plain.saccades.len(), plain.fixations.len()));
        for (a, b) in plain.saccades.iter().zip(&other.saccades) {
            assert!((a.onset_s + shift_s - b.onset_s).abs() < 1e-9 && (a.duration_s - b.duration_s).abs() < 1e-9);
            assert!((a.amplitude_deg - b.amplitude_deg).abs() < 1e-9);
            assert!((a.peak_velocity_deg_s - b.peak_velocity_deg_s).abs() < 1e-4 * a.peak_velocity_deg_s);
        }
    }
}

#[test]
fn two_fixations_that_noise_parts_are_one() {
    let mut samples = horizontal(500.0, 1.0, 0.0, &[]);
    // One sample out of place by 0.4°: 100°/s for two neighbours, and the eye is where it was.
    samples[250].position_deg = [0.4, 0.0];
    let parted = detect(&samples, &neighbours()).unwrap();
    assert!(parted.fixations.len() == 2 && !parted.saccades.is_empty());
    let merging = VelocityThreshold { window: VelocityWindow::Neighbours, ..VelocityThreshold::default() };
    let merged =
        detect(&samples, &EventConfig { detector: Detector::VelocityThreshold(merging), ..neighbours() }).unwrap();
    assert_eq!((merged.fixations.len(), merged.saccades.len()), (1, 0));
    assert!((merged.fixations[0].duration_s - 0.998).abs() < 1e-9);
}

#[test]
fn low_rates_say_what_they_cannot_show() {
    let at = |rate_hz| detect(&horizontal(rate_hz, 2.0, 0.0, &[]), &EventConfig::engbert_kliegl()).unwrap().limits;
    assert_eq!(at(1000.0), Vec::<String>::new());
    assert_eq!(at(250.0).len(), 1);
    let low = at(60.0);
    assert!(low.len() == 2 && low[1].contains("microsaccades are missed"), "{low:?}");
}

#[test]
fn time_that_goes_back_is_an_error_until_it_is_sorted() {
    let mut samples = horizontal(500.0, 1.0, 0.0, &[[0.5, 0.03, 5.0]]);
    let before = detect(&samples, &neighbours()).unwrap();
    samples.swap(100, 101);
    let error = detect(&samples, &neighbours()).unwrap_err();
    assert!(matches!(error, GazeError::TimeGoesBack { row: 101, .. }), "{error}");
    let (sorted, moved) = sorted_by_time(&samples).unwrap();
    assert_eq!((moved, detect(&sorted, &neighbours()).unwrap()), (1, before));
    samples[7].t_s = f64::NAN;
    assert_eq!(sorted_by_time(&samples), Err(GazeError::TimeNotFinite { row: 7 }));
}
