//! Data that say little or nothing: always an answer with an honest width or one clear error, never NaN, never a panic.
#![allow(clippy::unwrap_used)]

mod common;

use analysis::mar::{Estimate, FitError, MarFit, MarFitConfig, MarTrial, fit_mar};
use analysis::{figures, summary::ObserverSummary};
use common::{ECCENTRICITIES, TRUTH, constant_stimuli};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn sound(estimate: &Estimate) -> bool {
    let [low, high] = estimate.ci95;
    low.is_finite() && high.is_finite() && low <= estimate.estimate && estimate.estimate <= high && low < high
}

/// Every number finite, every interval around its estimate.
fn assert_sound(fit: &MarFit) {
    for estimate in [&fit.m, &fit.omega0, &fit.width, &fit.lapse] {
        assert!(sound(estimate), "{estimate:?}");
    }
    for t in &fit.thresholds {
        assert!(sound(&Estimate { estimate: t.mar_deg, ci95: t.ci95 }), "{t:?}");
    }
    assert!(fit.ess.is_finite() && fit.ess > 50.0, "ESS {}", fit.ess);
    assert!(fit.goodness.deviance.is_finite() && (0.0..=1.0).contains(&fit.goodness.p));
    for value in [fit.map.m, fit.map.omega0_deg, fit.map.width, fit.map.lapse] {
        assert!(value.is_finite(), "{:?}", fit.map);
    }
    let json = serde_json::to_string(&ObserverSummary::new("P01", Some(fit), Vec::new())).unwrap();
    assert!(!json.contains("null"), "a number is missing: {json}");
    assert!(!figures::mar_line(fit).contains("NaN"));
    assert!(!figures::psychometric_curves(fit).contains("NaN"));
}

fn fit(trials: &[MarTrial]) -> MarFit {
    let fit = fit_mar(trials, &MarFitConfig::default()).unwrap();
    assert_sound(&fit);
    fit
}

fn with_answers(correct: impl Fn(usize) -> bool) -> Vec<MarTrial> {
    let mut trials = constant_stimuli(&TRUTH, &ECCENTRICITIES, 42, 1);
    for (index, trial) in trials.iter_mut().enumerate() {
        trial.correct = correct(index);
    }
    trials
}

#[test]
fn all_correct_all_wrong_and_coin_flips_are_unsupported() {
    let all_correct = fit(&with_answers(|_| true));
    assert!(all_correct.support.reasons().iter().any(|r| r.contains("No level was hard")), "{:?}", all_correct.support);
    let all_wrong = fit(&with_answers(|_| false));
    assert!(all_wrong.support.reasons().iter().any(|r| r.contains("No level was clearly seen")));
    let coin = fit(&with_answers(|i| (i * 7919) % 13 < 6));
    assert!(!coin.support.is_supported(), "coin flips: {coin:?}");
}

#[test]
fn one_trial_one_level_one_eccentricity() {
    let one = fit(&[MarTrial { eccentricity_deg: 10.0, mar_deg: 0.2, correct: true }]);
    assert!(one.support.reasons()[0].contains("Only 1 trials"));
    assert!(one.m.ci95[1] / one.m.ci95[0] > 50.0, "one trial leaves the prior: {:?}", one.m);
    let level: Vec<MarTrial> =
        (0..200).map(|i| MarTrial { eccentricity_deg: 10.0, mar_deg: 0.2, correct: i % 4 != 0 }).collect();
    assert!(fit(&level).support.reasons().iter().any(|r| r.contains("one eccentricity")));
    let fovea: Vec<MarTrial> = constant_stimuli(&TRUTH, &[0.0], 200, 3);
    let fovea = fit(&fovea);
    assert!(fovea.support.reasons().iter().any(|r| r.contains("slope m")), "{:?}", fovea.support);
}

#[test]
fn a_step_function_and_a_reversed_one_are_fitted() {
    let mut trials = constant_stimuli(&TRUTH, &ECCENTRICITIES, 140, 1);
    for trial in &mut trials {
        trial.correct = trial.mar_deg > TRUTH.threshold_deg(trial.eccentricity_deg);
    }
    // Perfect separation, all wrong below: impossible by guessing, but a number must come out.
    fit(&trials);
    for trial in &mut trials {
        trial.correct = !trial.correct;
    }
    let reversed = fit(&trials);
    assert!(!reversed.support.is_supported());
    assert!(reversed.goodness.p < 0.01);
}

#[test]
fn extreme_but_possible_numbers_are_fitted() {
    for mar_deg in [1e-300, 1e-12, 1e12, 1e300] {
        fit(&[
            MarTrial { eccentricity_deg: 0.0, mar_deg, correct: true },
            MarTrial { eccentricity_deg: 180.0, mar_deg, correct: false },
        ]);
    }
}

#[test]
fn impossible_input_is_named() {
    let config = MarFitConfig::default();
    assert_eq!(fit_mar(&[], &config), Err(FitError::NoTrials));
    let good = MarTrial { eccentricity_deg: 5.0, mar_deg: 0.1, correct: true };
    for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let trials = [good, good, MarTrial { mar_deg: bad, ..good }];
        let error = fit_mar(&trials, &config).unwrap_err();
        assert!(matches!(error, FitError::BadTrial { index: 2, field: "mar_deg", .. }), "{error}");
    }
    let error = fit_mar(&[MarTrial { eccentricity_deg: -1.0, ..good }], &config).unwrap_err();
    assert!(error.to_string().contains("eccentricity_deg must be degrees from 0 to 180, found -1"), "{error}");
    let error = fit_mar(&[good], &MarFitConfig { guess: 1.0, ..config }).unwrap_err();
    assert!(matches!(error, FitError::BadConfig { field: "guess", .. }));
}

#[test]
fn the_same_configuration_gives_the_same_fit() {
    let trials = constant_stimuli(&TRUTH, &ECCENTRICITIES, 60, 5);
    let config = MarFitConfig { seed: 9, ..MarFitConfig::default() };
    let first = fit_mar(&trials, &config).unwrap();
    assert_eq!(first, fit_mar(&trials, &config).unwrap());
    // The order of trials does not matter either.
    let reversed: Vec<MarTrial> = trials.iter().rev().copied().collect();
    assert_eq!(first, fit_mar(&reversed, &config).unwrap());
    // Another seed moves the numbers by far less than their intervals.
    let other = fit_mar(&trials, &MarFitConfig { seed: 10, ..config }).unwrap();
    let width = first.m.ci95[1] - first.m.ci95[0];
    assert!((first.m.estimate - other.m.estimate).abs() < 0.03 * width);
}

#[test]
fn a_fit_survives_json() {
    let fit = fit(&constant_stimuli(&TRUTH, &ECCENTRICITIES, 60, 5));
    let text = serde_json::to_string(&fit).unwrap();
    assert_eq!(serde_json::from_str::<MarFit>(&text).unwrap(), fit);
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 96,
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("proptest-regressions"))),
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_trials_give_a_sound_fit(
        raw in prop::collection::vec((0.0f64..180.0, -14.0f64..6.0, any::<bool>()), 1..60),
        rings in 1usize..6,
        finest in prop::option::of(1e-4f64..1.0),
        guess in prop::sample::select(vec![0.0, 0.25, 0.5]),
    ) {
        let trials: Vec<MarTrial> = raw
            .iter()
            .enumerate()
            .map(|(i, &(e, ln_omega, correct))| MarTrial {
                eccentricity_deg: if i % 3 == 0 { e } else { (i % rings) as f64 * 5.0 },
                mar_deg: ln_omega.exp(),
                correct,
            })
            .collect();
        let config = MarFitConfig {
            guess,
            finest_mar: finest.map(|omega| (0.0, omega)).into_iter().collect(),
            draws: 1024,
            ..MarFitConfig::default()
        };
        assert_sound(&fit_mar(&trials, &config).unwrap());
    }
}
