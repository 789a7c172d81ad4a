//! Any table of counts gives finite, ordered numbers or one error, whatever the configuration.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::mar::Estimate;
use analysis::psychometric::{
    BootstrapConfig, Count, Direction, Guess, Lapse, Overdispersion, Parameter, Prior, Priors, PsychometricConfig,
    PsychometricPosterior, Resampling, Scale, Sigmoid, bootstrap, compare, goodness_of_fit, likelihood_fit,
};
use proptest::prelude::*;

fn sigmoids() -> impl Strategy<Value = Sigmoid> {
    prop_oneof![
        Just(Sigmoid::CumulativeGauss),
        Just(Sigmoid::Logistic),
        Just(Sigmoid::Gumbel),
        Just(Sigmoid::ReversedGumbel),
        Just(Sigmoid::Weibull),
        Just(Sigmoid::HyperbolicSecant),
        (0.5..50.0).prop_map(|df| Sigmoid::StudentT { df }),
    ]
}

fn configs() -> impl Strategy<Value = PsychometricConfig> {
    (
        sigmoids(),
        prop_oneof![Just(Scale::Linear), Just(Scale::Logarithmic)],
        prop_oneof![Just(Direction::Rises), Just(Direction::Falls)],
        prop_oneof![Just(Guess::Fixed(0.5)), Just(Guess::Fixed(0.0)), Just(Guess::Free), Just(Guess::EqualToLapse)],
        prop_oneof![Just(Overdispersion::None), Just(Overdispersion::Free)],
    )
        .prop_map(|(sigmoid, scale, direction, guess, overdispersion)| PsychometricConfig {
            sigmoid,
            scale,
            direction,
            guess,
            overdispersion,
            ..PsychometricConfig::TWO_ALTERNATIVES
        })
}

/// Rows with few or many answers, all right, all wrong, none at all, equal levels.
fn tables() -> impl Strategy<Value = Vec<Count>> {
    let row = (
        prop_oneof![(1u32..12).prop_map(|i| f64::from(i) * 0.25), 1e-3..1e3],
        prop_oneof![Just(0u32), Just(1), 2u32..40, Just(2000)],
        0.0..=1.0,
    );
    let share = prop_oneof![Just(None), Just(Some(0.0)), Just(Some(1.0))];
    (prop::collection::vec(row, 0..9), share).prop_map(|(rows, same)| {
        rows.into_iter()
            .map(|(level, n, share)| Count { level, n, k: (same.unwrap_or(share) * f64::from(n)).round() as u32 })
            .collect()
    })
}

fn sound(what: &str, e: &Estimate) {
    assert!(e.estimate.is_finite() && e.ci95.iter().all(|end| end.is_finite()), "{what}: {e:?}");
    let slack = 1e-12 * (1.0 + e.estimate.abs());
    assert!(e.ci95[0] <= e.estimate + slack && e.estimate <= e.ci95[1] + slack, "{what}: {e:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn posteriors_are_finite_and_ordered(counts in tables(), config in configs()) {
        let Ok(posterior) = PsychometricPosterior::new(&counts, &config) else { return Ok(()); };
        let fit = posterior.fit();
        for (what, estimate) in [
            ("threshold", &fit.threshold),
            ("width", &fit.width),
            ("lapse", &fit.lapse),
            ("guess", &fit.guess),
            ("overdispersion", &fit.overdispersion),
        ] {
            sound(what, estimate);
        }
        prop_assert!(fit.width.ci95[1] > fit.width.ci95[0] && fit.threshold.ci95[1] > fit.threshold.ci95[0]);
        prop_assert!(!fit.deviance.unwrap().is_nan());
        for level in [1e-3, 1.0, 1e3] {
            let p = fit.probability(level);
            prop_assert!((0.0..=1.0).contains(&p), "{p}");
        }
        for share in [0.6, 0.99] {
            if let Some(level) = posterior.threshold_at(share) {
                sound("level", &level);
            }
        }
        if let Some(p) = posterior.probability_at(1.0) {
            sound("probability", &p);
        }
        prop_assert!(serde_json::to_string(&fit).is_ok());
    }

    #[test]
    fn likelihoods_are_finite(counts in tables(), config in configs()) {
        let Ok(fit) = likelihood_fit(&counts, &config) else { return Ok(()); };
        prop_assert!(fit.ln_likelihood.is_finite() && fit.ln_likelihood <= 1e-6, "{}", fit.ln_likelihood);
        prop_assert!(fit.estimate.threshold.is_finite() && fit.estimate.width > 0.0);
        for profile in [fit.threshold, fit.width, fit.lapse] {
            for end in [profile.low, profile.high].into_iter().flatten() {
                prop_assert!(end.is_finite());
            }
        }
    }
}

/// With a range there is an answer to no data at all: the prior's. Its 95 % of a flat stretch with raised-cosine ends is
/// symmetric about the middle of the range.
#[test]
fn no_answers_are_the_prior() {
    let config = PsychometricConfig { range: Some([2.0, 6.0]), ..PsychometricConfig::TWO_ALTERNATIVES };
    for counts in [vec![], vec![Count { level: 3.0, n: 0, k: 0 }]] {
        let fit = PsychometricPosterior::new(&counts, &config).unwrap().fit();
        assert!(!fit.support.is_supported());
        assert!((fit.threshold.estimate - 4.0).abs() < 0.01, "{:?}", fit.threshold);
        assert!(fit.threshold.ci95[0] < 2.0 && fit.threshold.ci95[1] > 6.0);
        // Beta(1, 10): median 1 − ½^{1/10}, cut at ½ by a thousandth.
        assert!((fit.lapse.estimate - (1.0 - 0.5f64.powf(0.1))).abs() < 1e-3, "{:?}", fit.lapse);
    }
    let one = PsychometricPosterior::new(&[Count { level: 3.0, n: 40, k: 38 }], &config).unwrap().fit();
    assert!(one.threshold.ci95[1] < 4.5 && !one.support.is_supported(), "{one:?}");
}

/// A prior of one's own does what it says: a narrow normal one around 3 leaves the threshold nowhere else.
#[test]
fn priors_of_choice_are_used() {
    let counts =
        [19, 22, 27, 32, 37, 39, 39].iter().zip(1..).map(|(&k, level)| Count { level: f64::from(level), n: 40, k });
    let counts: Vec<Count> = counts.collect();
    let base = PsychometricConfig::TWO_ALTERNATIVES;
    let priors = Priors { threshold: Prior::Normal { mean: 5.0, sd: 0.01 }, ..Priors::STANDARD };
    let fit = PsychometricPosterior::new(&counts, &PsychometricConfig { priors, ..base }).unwrap().fit();
    assert!((fit.threshold.estimate - 5.0).abs() < 0.02, "{:?}", fit.threshold);
    let fixed = PsychometricConfig { lapse: Lapse::Fixed(0.1), ..base };
    let fit = PsychometricPosterior::new(&counts, &fixed).unwrap().fit();
    assert_eq!(fit.lapse.ci95, [0.1, 0.1]);
    let uniform = Priors { lapse: Prior::Uniform { low: 0.08, high: 0.12 }, ..Priors::STANDARD };
    let fit = PsychometricPosterior::new(&counts, &PsychometricConfig { priors: uniform, ..base }).unwrap().fit();
    assert!(fit.lapse.ci95[0] >= 0.08 && fit.lapse.ci95[1] <= 0.12);
}

/// The same at one thread and at many: nothing depends on which thread comes first.
#[test]
fn simulations_do_not_depend_on_threads() {
    let counts: Vec<Count> =
        [9, 12, 15, 19].iter().zip(1..).map(|(&k, level)| Count { level: f64::from(level), n: 20, k }).collect();
    let config = PsychometricConfig { overdispersion: Overdispersion::Free, ..PsychometricConfig::TWO_ALTERNATIVES };
    let results: Vec<_> = [1, 3]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let boot = BootstrapConfig { resampling: Resampling::NonParametric, samples: 40, seed: 7 };
                (goodness_of_fit(&counts, &config, 60, 3).unwrap(), bootstrap(&counts, &config, &boot).unwrap())
            })
        })
        .collect();
    assert_eq!(results[0], results[1]);
}

/// Equal data share everything; the deviance is zero but for rounding, and its p is one.
#[test]
fn equal_groups_share_everything() {
    let counts: Vec<Count> =
        [10, 12, 17, 20].iter().zip(1..).map(|(&k, level)| Count { level: f64::from(level), n: 20, k }).collect();
    let config = PsychometricConfig::TWO_ALTERNATIVES;
    let tested = [Parameter::Threshold, Parameter::Width, Parameter::Lapse];
    let comparison = compare(&[&counts, &counts, &counts], &config, &tested, &[]).unwrap();
    assert_eq!(comparison.df, 6);
    assert!(comparison.deviance < 1e-6 && comparison.p > 0.999, "{comparison:?}");
}
