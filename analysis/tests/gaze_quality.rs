//! Data quality and deviation against closed forms, and what they must not depend on.
#![allow(clippy::unwrap_used)]

use analysis::gaze::deviation::{DeviationConfig, deviation_by_condition};
use analysis::gaze::quality::{QualityConfig, data_quality, quality_by_trial};
use analysis::gaze::validation::{ValidationPoint, validate};
use analysis::gaze::{GazeError, GazeSample, Target, TargetPlace, TrialId, TrialTrace};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

fn sample(t_s: f64, position_deg: [f64; 2]) -> GazeSample {
    GazeSample { t_s, position_deg, deviation_deg: 0.0, valid: true }
}

/// Noise of known standard deviations and correlation around the centre, 1000 Hz.
fn noise(n: usize, [right, up]: [f64; 2], correlation: f64, seed: u64) -> Vec<GazeSample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || {
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - u).ln()).sqrt() * (2.0 * PI * v).cos()
    };
    (0..n)
        .map(|i| {
            let (a, b) = (normal(), normal());
            let other = correlation * a + (1.0 - correlation * correlation).sqrt() * b;
            sample(i as f64 * 1e-3, [right * a, up * other])
        })
        .collect()
}

/// The check of the field's formulas: azimuth and elevation both 1, 2, 3 give an RMS of √2 and a standard deviation of
/// √(2/3) an axis (÷ n). A hundredth of it, since angles on a display are none of a plane.
#[test]
fn three_steps_have_the_textbook_figures() {
    let samples: Vec<GazeSample> = (1..4).map(|i| sample(f64::from(i) * 1e-3, [0.01 * f64::from(i); 2])).collect();
    let quality =
        data_quality(&samples, &QualityConfig { target_deg: Some([0.0; 2]), ..QualityConfig::default() }).unwrap();
    let precision = quality.precision.unwrap();
    assert!((precision.rms_s2s_deg.unwrap() - 0.014_142_136).abs() < 1e-8);
    assert!(precision.sd_axes_deg.iter().all(|sd| (sd - 0.008_164_966).abs() < 1e-8));
    // All on one line: an ellipse without area, along 45°.
    assert!(precision.bcea.area_95_deg2 < 1e-9);
    assert!((precision.bcea.orientation_deg.unwrap() - 45.0).abs() < 1e-3);
    assert!((precision.bcea.correlation.unwrap() - 1.0).abs() < 1e-6);
    let accuracy = quality.accuracy.unwrap();
    assert!((accuracy.offset_of_mean_deg - 0.02 * 2f64.sqrt()).abs() < 1e-7);
    assert!(accuracy.bias_deg.iter().all(|way| (way - 0.02).abs() < 1e-7));
    assert!((accuracy.median_offset_deg - 0.02 * 2f64.sqrt()).abs() < 1e-7);
}

/// White noise with known σ, ρ: RMS = √(2(σx² + σy²)), area = 2 k π σx σy √(1 − ρ²); and the ellipse holds its share.
#[test]
fn white_noise_has_its_expected_precision() {
    let (sd, correlation, n) = ([0.2, 0.1], 0.6, 40_000);
    let samples = noise(n, sd, correlation, 3);
    let precision = data_quality(&samples, &QualityConfig::default()).unwrap().precision.unwrap();
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 0.02, "{found}, {expected}");
    near(precision.rms_s2s_deg.unwrap(), (2.0 * (sd[0] * sd[0] + sd[1] * sd[1])).sqrt());
    near(precision.sd_deg, sd[0].hypot(sd[1]));
    near(precision.bcea.correlation.unwrap(), correlation);
    for (area, share) in [(precision.bcea.area_68_deg2, 0.6827), (precision.bcea.area_95_deg2, 0.95)] {
        near(area, -2.0 * f64::ln(1.0 - share) * PI * sd[0] * sd[1] * (1.0 - correlation * correlation).sqrt());
    }
    // The ellipse itself, from its axes and orientation.
    let [long, short] = precision.bcea.half_axes_68_deg;
    near(PI * long * short, precision.bcea.area_68_deg2);
    let (sin, cos) = precision.bcea.orientation_deg.unwrap().to_radians().sin_cos();
    let inside = samples.iter().filter(|s| {
        let [x, y] = s.position_deg;
        ((cos * x + sin * y) / long).powi(2) + ((cos * y - sin * x) / short).powi(2) <= 1.0
    });
    let share = inside.count() as f64 / n as f64;
    println!("{share} inside");
    // Four standard errors of a share of 0.6827 in 40,000.
    assert!((share - 0.6827).abs() < 4.0 * (0.6827 * 0.3173 / n as f64).sqrt());
}

/// A rotation of the sphere of directions changes no angle, so no precision; time only scales rates.
#[test]
fn precision_does_not_depend_on_place_roll_or_speed() {
    let samples = noise(3000, [0.2, 0.1], 0.6, 8);
    let plain = data_quality(&samples, &QualityConfig::default()).unwrap();
    let precision = plain.precision.unwrap();
    for (roll, yaw) in [(0.9f64, 0.0f64), (0.0, 0.2), (-0.4, 0.3)] {
        let turned: Vec<GazeSample> = samples
            .iter()
            .map(|s| {
                let [x, y] = s.position_deg.map(|v| v.to_radians().tan());
                let [x, y] = [x * roll.cos() - y * roll.sin(), x * roll.sin() + y * roll.cos()];
                let [x, z] = [x * yaw.cos() + yaw.sin(), yaw.cos() - x * yaw.sin()];
                sample(s.t_s, [x, y].map(|v| v.atan2(z).to_degrees()))
            })
            .collect();
        let other = data_quality(&turned, &QualityConfig::default()).unwrap().precision.unwrap();
        let same = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} and {b}, rolled {roll}, turned {yaw}");
        same(other.rms_s2s_deg.unwrap(), precision.rms_s2s_deg.unwrap());
        same(other.sd_deg, precision.sd_deg);
        same(other.bcea.area_95_deg2, precision.bcea.area_95_deg2);
        same(other.bcea.half_axes_68_deg[0], precision.bcea.half_axes_68_deg[0]);
    }
    let slow: Vec<GazeSample> = samples.iter().map(|s| GazeSample { t_s: 4.0 * s.t_s, ..*s }).collect();
    let slow = data_quality(&slow, &QualityConfig::default()).unwrap();
    assert_eq!(slow.precision, plain.precision);
    assert!((4.0 * slow.rate.from_median_hz.unwrap() / plain.rate.from_median_hz.unwrap() - 1.0).abs() < 1e-9);
}

#[test]
fn lost_and_absent_samples_are_counted_by_time() {
    // 250 Hz for 2 s; 25 samples invalid from 0.4 s on, 50 never came from 1 s on.
    let samples: Vec<GazeSample> = (0..500)
        .filter(|i| !(250..300).contains(i))
        .map(|i| GazeSample { valid: !(100..125).contains(&i), ..sample(f64::from(i) * 0.004, [0.0; 2]) })
        .collect();
    let config = QualityConfig { window_s: Some([0.0, 2.0]), nominal_rate_hz: Some(250.0), ..QualityConfig::default() };
    let quality = data_quality(&samples, &config).unwrap();
    assert!((quality.loss.invalid_share.unwrap() - 25.0 / 450.0).abs() < 1e-12);
    assert!((quality.loss.missing_of_expected_share.unwrap() - 75.0 / 500.0).abs() < 1e-12);
    assert!((quality.rate.from_median_hz.unwrap() - 250.0).abs() < 1e-6);
    assert!((quality.rate.effective_hz.unwrap() - 212.5).abs() < 1e-9);
    let gaps = &quality.gaps;
    assert_eq!((gaps.count, gaps.long.len()), (2, 2));
    assert!((gaps.long[0].start_s - 0.396).abs() < 1e-9 && (gaps.long[0].duration_s - 0.104).abs() < 1e-9);
    assert_eq!(gaps.longest, Some(gaps.long[1]));
    assert!((gaps.long[1].duration_s - 0.204).abs() < 1e-9);
    assert!((gaps.time_share - 0.15).abs() < 1e-9);
    // A window that gaze never reached is lost whole.
    let nothing = data_quality(&samples, &QualityConfig { window_s: Some([5.0, 6.0]), ..config }).unwrap();
    assert_eq!(
        (nothing.gaps.count, nothing.gaps.time_share, nothing.loss.missing_of_expected_share),
        (1, 1.0, Some(1.0))
    );
}

fn trace(trial: u32, condition: &str, offset_deg: &[f64], target: Option<Target>) -> TrialTrace {
    TrialTrace {
        id: TrialId { session: "P01".into(), trial },
        condition: condition.into(),
        samples: offset_deg.iter().enumerate().map(|(i, &x)| sample(i as f64 * 0.01, [x, 0.0])).collect(),
        frames: Vec::new(),
        stimulus_s: vec![[0.0, 10.0]],
        target,
    }
}

/// Two trials of 100 and 4 samples at 1° and 3°: samples pull the pooled mean to the long trial, trials count alike.
/// With n = 2, t(0.975, 1) = 12.7062 and the interval of the mean is 2 ± 12.7062·√2/√2.
#[test]
fn the_trial_is_the_unit() {
    let target = || Some(Target::Fixed([0.0, 0.0]));
    let trials =
        [trace(0, "a", &[1.0; 100], target()), trace(1, "a", &[3.0; 4], target()), trace(2, "free", &[1.0; 4], None)];
    let report = deviation_by_condition(&trials, &DeviationConfig::default()).unwrap();
    let a = &report.conditions[0].deviation;
    assert_eq!((a.trials, a.samples), (2, 104));
    assert!((a.mean_deg.unwrap() - 112.0 / 104.0).abs() < 1e-9);
    let by_trial = a.trial_mean_deg.unwrap();
    assert!((by_trial.mean - 2.0).abs() < 1e-9);
    assert!((by_trial.ci95.unwrap()[1] - 2.0 - 12.706_204_7).abs() < 1e-5);
    assert!((a.inside_share.unwrap() - 100.0 / 104.0).abs() < 1e-12);
    assert_eq!(a.trial_inside_share.unwrap().ci95, Some([0.0, 1.0]));
    assert!((a.percentiles_deg.unwrap().p50 - 1.0).abs() < 1e-9);
    let free = &report.conditions[1].deviation;
    assert_eq!((free.trials, free.trials_without, free.mean_deg, free.trial_mean_deg), (0, 1, None, None));
    assert_eq!((report.all.trials, report.all.trials_without), (2, 1));
}

/// A target that runs at 10°/s in steps of 100 ms, and an eye that is exactly where it is drawn.
#[test]
fn a_moving_target_is_followed_frame_by_frame() {
    let place = |t: f64| [10.0 * (t * 10.0 + 1e-9).floor() / 10.0, 0.0];
    // Each frame a moment before its sample, so that rounding decides nothing.
    let places = (1..20)
        .map(|i| f64::from(i) * 0.1)
        .map(|t_s| TargetPlace { t_s: t_s - 1e-4, position_deg: place(t_s) })
        .collect();
    let mut trial = trace(0, "pursuit", &[0.0; 200], Some(Target::Moving(places)));
    for s in &mut trial.samples {
        s.position_deg = place(s.t_s);
    }
    let report = deviation_by_condition(std::slice::from_ref(&trial), &DeviationConfig::default()).unwrap();
    // Before the first frame there is no target.
    assert_eq!(report.all.samples, 190);
    assert!(report.all.mean_deg.unwrap() < 1e-9, "{:?}", report.all.mean_deg);
    // Half a second behind is five degrees.
    let late: Vec<GazeSample> = trial.samples.iter().map(|s| GazeSample { t_s: s.t_s + 0.5, ..*s }).collect();
    trial.samples = late;
    let report = deviation_by_condition(&[trial], &DeviationConfig::default()).unwrap();
    assert!((report.all.percentiles_deg.unwrap().p50 - 5.0).abs() < 0.05);
}

#[test]
fn a_validation_is_told_point_by_point() {
    let mut samples = Vec::new();
    let targets = [[0.0, 0.0], [10.0, 0.0], [0.0, -8.0], [20.0, 10.0]];
    for (i, [x, y]) in targets.into_iter().enumerate().take(3) {
        let place = if i == 0 { [x + 0.5, y] } else { [x, y + 1.0] };
        samples.extend((0..100).map(|k| sample(i as f64 + f64::from(k) * 0.01, place)));
    }
    let points: Vec<ValidationPoint> =
        (0..4).map(|i| ValidationPoint { target_deg: targets[i], window_s: [i as f64, i as f64 + 1.0] }).collect();
    let validation = validate(&samples, &points, &QualityConfig::default()).unwrap();
    assert_eq!((validation.points.len(), validation.points_without_gaze), (4, 1));
    assert!((validation.points[0].accuracy.unwrap().offset_of_mean_deg - 0.5).abs() < 1e-9);
    // Ten degrees aside, a degree up of a display's own angle is cos(10°)² less seen from the eye: arctan(tan 1° cos 10°).
    let aside = (1f64.to_radians().tan() * 10f64.to_radians().cos()).atan().to_degrees();
    assert!((validation.points[1].accuracy.unwrap().offset_of_mean_deg - aside).abs() < 1e-9);
    assert!((validation.worst_accuracy_deg.unwrap() - 1.0).abs() < 1e-9);
}

#[test]
fn what_is_wrong_is_named() {
    let mut trial = trace(7, "a", &[0.0; 4], None);
    trial.stimulus_s = vec![[1.0, 2.0], [1.5, 3.0]];
    let error = quality_by_trial(&[trial], &QualityConfig::default()).unwrap_err();
    assert!(error.to_string().starts_with("trial 7 of P01: the window from 1.5 s to 3 s"), "{error}");
    let config = QualityConfig { nominal_rate_hz: Some(0.0), ..QualityConfig::default() };
    let error = data_quality(&[], &config).unwrap_err();
    assert_eq!(error.to_string(), "nominal_rate_hz: expected hertz from 1 to 100000, found 0");
    let back = [sample(1.0, [0.0; 2]), sample(0.5, [0.0; 2])];
    assert!(matches!(data_quality(&back, &QualityConfig::default()), Err(GazeError::TimeGoesBack { row: 1, .. })));
}
