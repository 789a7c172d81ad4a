//! Whatever comes: one clear error or finite numbers, never a panic.
#![allow(clippy::unwrap_used)]

use analysis::gaze::deviation::{DeviationConfig, deviation_by_condition};
use analysis::gaze::events::{EventConfig, EventSummary, Events, detect, detect_binocular};
use analysis::gaze::quality::{DataQuality, QualityConfig, data_quality, quality_by_trial};
use analysis::gaze::{GazeError, GazeSample, Target, TargetPlace, TrialId, TrialTrace, sorted_by_time, summarise};
use analysis::timing::Frame;
use analysis::timing::flags::{FlagReport, FlagRule, flag_trials};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use serde::{Serialize, de::DeserializeOwned};

/// JSON knows neither NaN nor infinity: what comes back the same had none.
fn assert_finite<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    let back: T = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error} in {text}"));
    assert_eq!(&back, value);
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        10 => -30.0..30.0f64,
        3 => Just(0.0),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(1e300),
        1 => Just(-90.0),
    ]
}

/// Steps of time: regular, none, gaps, tiny.
fn step() -> impl Strategy<Value = f64> {
    prop_oneof![8 => Just(0.002), 2 => Just(0.0), 1 => 0.0..2.0f64, 1 => Just(1e-12)]
}

fn samples() -> impl Strategy<Value = Vec<GazeSample>> {
    // Some recordings stay at one place, which leaves no spread to scale anything by.
    let place = prop_oneof![(number(), number()), Just((1.0, -2.0))];
    prop::collection::vec((step(), place, prop::bool::weighted(0.85)), 0..60).prop_map(|rows| {
        let mut t_s = 0.0;
        rows.into_iter()
            .map(|(step, (x, y), valid)| {
                t_s += step;
                GazeSample { t_s, position_deg: [x, y], deviation_deg: x.abs(), valid }
            })
            .collect()
    })
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 400,
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn any_samples_give_finite_numbers(left in samples(), right in samples(), window in 0.0..1.0f64) {
        assert_finite(&summarise(&left));
        let with_target = QualityConfig { target_deg: Some([1.0, -2.0]), nominal_rate_hz: Some(500.0), ..QualityConfig::default() };
        for window_s in [None, Some([window, window + 0.1])] {
            let quality: DataQuality = data_quality(&left, &QualityConfig { window_s, ..with_target }).unwrap();
            assert_finite(&quality);
            prop_assert!(quality.valid <= quality.samples && (0.0..=1.0).contains(&quality.gaps.time_share));
        }
        for config in [EventConfig::velocity_threshold(), EventConfig::engbert_kliegl()] {
            let events: Events = detect(&left, &config).unwrap();
            assert_finite(&events);
            assert_finite(&EventSummary::new(&events));
            for saccade in &events.saccades {
                prop_assert!(saccade.onset_s <= saccade.offset_s && saccade.amplitude_deg >= 0.0);
            }
            for pair in events.saccades.windows(2) {
                prop_assert!(pair[0].offset_s < pair[1].onset_s);
            }
            // No event holds a stretch without valid samples above the limit.
            let seen: Vec<f64> = left.iter().filter(|s| s.valid && s.position_deg.iter().all(|v| v.abs() < 89.0)).map(|s| s.t_s).collect();
            for pair in seen.windows(2).filter(|pair| pair[1] - pair[0] > events.bridged_up_to_s) {
                let spans = |on: f64, off: f64| on <= pair[0] && off >= pair[1];
                prop_assert!(!events.saccades.iter().any(|s| spans(s.onset_s, s.offset_s)));
                prop_assert!(!events.fixations.iter().any(|f| spans(f.onset_s, f.offset_s)));
            }
            let (_, both) = detect_binocular(&left, &right, &config).unwrap();
            assert_finite(&both);
        }
    }

    #[test]
    fn any_trials_give_finite_numbers(
        gaze in prop::collection::vec(samples(), 0..5),
        frames in prop::collection::vec((step(), any::<bool>(), prop::option::of(number())), 0..20),
        moving in any::<bool>(),
    ) {
        let mut t_s = 0.0;
        let frames: Vec<Frame> = frames.into_iter().map(|(step, missed, gaze_age_s)| {
            t_s += step;
            Frame { presented_s: t_s, missed, gaze_age_s, after_gap: missed }
        }).collect();
        let places = || frames.iter().map(|f| TargetPlace { t_s: f.presented_s, position_deg: [f.presented_s; 2] }).collect();
        let traces: Vec<TrialTrace> = (0u32..).zip(gaze).map(|(trial, samples)| TrialTrace {
            id: TrialId { session: String::new(), trial },
            condition: (trial % 2).to_string(),
            samples,
            frames: frames.clone(),
            stimulus_s: if trial == 3 { Vec::new() } else { vec![[0.0, 0.05], [0.05, 0.2]] },
            target: Some(if moving { Target::Moving(places()) } else { Target::Fixed([f64::NAN, 0.0]) }),
        }).collect();
        assert_finite(&deviation_by_condition(&traces, &DeviationConfig::default()).unwrap());
        if moving {
            assert_finite(&quality_by_trial(&traces, &QualityConfig::default()).unwrap());
        } else if !traces.is_empty() {
            let named = matches!(quality_by_trial(&traces, &QualityConfig::default()), Err(GazeError::Trial { .. }));
            prop_assert!(named, "a target that is no place has to be an error");
        }
        let all = FlagRule { max_missed_frames: Some(1), max_interval_s: Some(0.01), max_outside_share: Some(0.1), ..FlagRule::suggested() };
        let report: FlagReport = flag_trials(&traces, &all).unwrap();
        assert_finite(&report);
        prop_assert_eq!(report.trials.len(), traces.len());
    }

    #[test]
    fn any_order_of_time_is_refused_or_sorted(samples in samples(), seed in any::<u64>()) {
        let mut shuffled = samples;
        let n = shuffled.len() as u64;
        (1..n).for_each(|i| shuffled.swap(i as usize, (seed.rotate_left(i as u32) % (i + 1)) as usize));
        let ordered = shuffled.windows(2).all(|pair| pair[0].t_s <= pair[1].t_s);
        prop_assert_eq!(data_quality(&shuffled, &QualityConfig::default()).is_ok(), ordered);
        prop_assert_eq!(detect(&shuffled, &EventConfig::engbert_kliegl()).is_ok(), ordered);
        let (sorted, moved) = sorted_by_time(&shuffled).unwrap();
        prop_assert_eq!(moved == 0, ordered);
        prop_assert!(detect(&sorted, &EventConfig::velocity_threshold()).is_ok());
        assert_finite(&summarise(&shuffled));
    }
}
