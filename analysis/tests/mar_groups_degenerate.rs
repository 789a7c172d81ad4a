//! Groups, conditions, bends and two-stage lines of data that say little: an answer or one clear error, never NaN, never a
//! panic.
#![allow(clippy::unwrap_used)]

use analysis::mar::conditions::{Condition, ConditionsConfig, compare_conditions};
use analysis::mar::hierarchical::{HierarchicalConfig, ObserverTrials, fit_hierarchical};
use analysis::mar::linearity::{LinearityConfig, LinearityError, test_linearity};
use analysis::mar::two_stage::{TwoStageConfig, TwoStageError, fit_two_stage, line_through};
use analysis::mar::{MarFitConfig, MarTrial, Threshold};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use serde::Serialize;

/// serde_json writes NaN and infinities as null; the only nulls allowed are those of `Option`s that are named.
fn assert_no_nan<T: Serialize>(value: &T, options: &[&str]) {
    let mut json = serde_json::to_string(value).unwrap();
    for option in options {
        json = json.replace(&format!("\"{option}\":null"), "");
    }
    assert!(!json.contains("null"), "a number is missing: {json}");
}

/// Trials at up to five eccentricities with any answers: often all right, all wrong, one level, or nothing shown.
fn any_trials() -> impl Strategy<Value = Vec<MarTrial>> {
    let free = prop::collection::vec((0usize..5, -9.0f64..4.0, any::<bool>()), 1..50);
    (free, 0u8..4, 1usize..6).prop_map(|(raw, answers, rings)| {
        raw.into_iter()
            .enumerate()
            .map(|(i, (ring, ln_omega, correct))| MarTrial {
                eccentricity_deg: (ring % rings) as f64 * 6.0,
                mar_deg: if i % 2 == 0 { 0.1 } else { ln_omega.exp() },
                correct: match answers {
                    0 => true,
                    1 => false,
                    _ => correct,
                },
            })
            .collect()
    })
}

fn observers(groups: Vec<Vec<MarTrial>>, finest: Option<f64>) -> Vec<ObserverTrials> {
    groups
        .into_iter()
        .enumerate()
        .map(|(index, trials)| ObserverTrials {
            id: format!("P{index}"),
            trials,
            finest_mar: finest.map(|omega| (0.0, omega)).into_iter().collect(),
        })
        .collect()
}

fn short() -> HierarchicalConfig {
    HierarchicalConfig { chains: 2, warmup: 60, draws: 100, ..HierarchicalConfig::default() }
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("proptest-regressions"))),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn any_group_has_a_fit(
        groups in prop::collection::vec(any_trials(), 1..4),
        finest in prop::option::of(1e-3f64..1.0),
        guess in prop::sample::select(vec![0.0, 0.25, 0.5]),
    ) {
        let fit = fit_hierarchical(&observers(groups, finest), &HierarchicalConfig { guess, ..short() }).unwrap();
        assert_no_nan(&fit, &[]);
        for group in [fit.m, fit.omega0, fit.width] {
            for e in [group.median, group.sd_ln, group.new_observer] {
                prop_assert!(e.ci95[0] > 0.0 && e.ci95[0] <= e.estimate && e.estimate <= e.ci95[1], "{e:?}");
            }
        }
    }

    #[test]
    fn any_conditions_can_be_compared(
        first in prop::collection::vec(any_trials(), 1..3),
        second in prop::collection::vec(any_trials(), 1..4),
        finest in prop::option::of(1e-3f64..1.0),
    ) {
        let conditions = [
            Condition { name: "a".to_owned(), observers: observers(first, finest) },
            Condition { name: "b".to_owned(), observers: observers(second, None) },
        ];
        let config = ConditionsConfig { hierarchical: short(), ..ConditionsConfig::default() };
        let comparison = compare_conditions(&conditions, &config).unwrap();
        assert_no_nan(&comparison, &[]);
        for test in comparison.tests.iter().chain(comparison.observers.iter().flat_map(|o| &o.tests)) {
            prop_assert!(test.deviance_difference >= 0.0 && (0.0..=1.0).contains(&test.p), "{test:?}");
        }
    }

    #[test]
    fn any_line_is_tested_or_refused(trials in any_trials(), finest in prop::option::of(1e-3f64..1.0), breaks in 1usize..6) {
        let config = LinearityConfig {
            finest_mar: finest.map(|omega| (0.0, omega)).into_iter().collect(),
            simulations: 9,
            breaks,
            ..LinearityConfig::default()
        };
        match test_linearity(&trials, &config) {
            Ok(result) => {
                assert_no_nan(&result, &["broken", "p_chi_square", "break_range_deg"]);
                prop_assert!(result.quadratic.test.p_chi_square.is_some());
                let far = result.eccentricities_deg.last().copied().unwrap();
                for i in 0..=50 {
                    let e = far * f64::from(i) / 50.0;
                    prop_assert!(result.line.omega0 + result.line.m * e > -1e-12);
                    let q = &result.quadratic;
                    let bent = q.omega0 + q.m * e + q.q * e * e;
                    let scale = q.omega0 + (q.m * e).abs() + (q.q * e * e).abs();
                    prop_assert!(bent > -1e-9 * scale, "{q:?} at {e}: {bent}");
                }
            }
            Err(error) => prop_assert!(matches!(error, LinearityError::TooFewEccentricities { .. }), "{error}"),
        }
    }

    #[test]
    fn any_trials_have_a_two_stage_line_or_too_few_thresholds(
        trials in any_trials(),
        finest in prop::option::of(1e-3f64..1.0),
    ) {
        let finest_mar = finest.map(|omega| (0.0, omega)).into_iter().collect();
        let first = MarFitConfig { finest_mar, draws: 512, ..MarFitConfig::default() };
        match fit_two_stage(&trials, &TwoStageConfig { first }) {
            Ok(fit) => {
                assert_no_nan(&fit, &[]);
                for e in [fit.m, fit.omega0] {
                    prop_assert!(e.ci95[0] < e.estimate && e.estimate < e.ci95[1], "{e:?}");
                }
            }
            Err(error) => prop_assert!(matches!(error, TwoStageError::TooFewThresholds { .. }), "{error}"),
        }
    }

    #[test]
    fn any_thresholds_have_a_line_or_are_refused(
        raw in prop::collection::vec((0.0f64..180.0, -30.0f64..30.0, -30.0f64..30.0, any::<bool>()), 0..7),
    ) {
        let thresholds: Vec<Threshold> = raw
            .iter()
            .map(|&(eccentricity_deg, ln_mar, ln_se, limited)| Threshold {
                eccentricity_deg,
                mar_deg: ln_mar.exp(),
                ci95: [ln_mar.exp() - ln_se.exp(), ln_mar.exp() + ln_se.exp()],
                limited,
                finest_mar_deg: None,
                trials: 10,
            })
            .collect();
        match line_through(&thresholds) {
            Ok(fit) => assert_no_nan(&fit, &[]),
            Err(error) => prop_assert!(
                matches!(error, TwoStageError::TooFewThresholds { .. } | TwoStageError::BadThreshold { field: "ci95", .. }),
                "{error}"
            ),
        }
    }
}
