//! Maximum likelihood and profile intervals against scipy 1.17.1 (`tests/peers/likelihood_peer.py`), the bootstrap against the
//! profile, and the level of the test of shared parameters.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::psychometric::{
    BootstrapConfig, Count, Guess, Parameter, Psychometric, PsychometricConfig, Resampling, Scale, Sigmoid, bootstrap,
    compare, likelihood_fit,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const BASE: PsychometricConfig = PsychometricConfig::TWO_ALTERNATIVES;

fn counts(levels: &[f64], n: u32, k: &[u32]) -> Vec<Count> {
    levels.iter().zip(k).map(|(&level, &k)| Count { level, n, k }).collect()
}

const SEVEN: [f64; 7] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

#[test]
fn maxima_and_profiles_are_scipys() {
    let near = |what: &str, ours: f64, peer: f64, within: f64| {
        println!("{what}: {ours:.7} {peer:.7}");
        assert!((ours - peer).abs() < within, "{what}: {ours} against {peer}");
    };
    let yes_no = PsychometricConfig { sigmoid: Sigmoid::Logistic, guess: Guess::Free, ..BASE };
    let weibull = PsychometricConfig {
        sigmoid: Sigmoid::Weibull,
        scale: Scale::Logarithmic,
        guess: Guess::of_alternatives(4),
        ..BASE
    };
    let octaves = [0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
    let cases = [
        (
            counts(&SEVEN, 40, &[19, 22, 27, 32, 37, 39, 39]),
            BASE,
            [3.532512, 3.952485, 0.02096349, 0.5],
            [-11.61548670, 29.230973],
            [2.910229, 4.109668],
        ),
        (
            counts(&SEVEN, 30, &[2, 3, 6, 12, 22, 27, 28]),
            yes_no,
            [4.268855, 3.98399, 0.04610593, 0.06597458],
            [-10.97273089, 29.945462],
            [3.7599, 4.774503],
        ),
        (
            counts(&octaves, 24, &[6, 8, 11, 17, 22, 23]),
            weibull,
            [-1.164321, 2.610898, 0.04343271, 0.25],
            [-9.30680278, 24.613606],
            [-1.579567, -0.7932013],
        ),
    ];
    for (counts, config, [threshold, width, lapse, guess], [ln_likelihood, aic], profile) in cases {
        let fit = likelihood_fit(&counts, &config).unwrap();
        let coordinate = |level: f64| config.scale.coordinate(level);
        near("threshold", coordinate(fit.estimate.threshold), threshold, 2e-4);
        near("width", fit.estimate.width, width, 1e-3);
        near("lapse", fit.estimate.lapse, lapse, 1e-4);
        near("guess", fit.estimate.guess, guess, 1e-4);
        // The likelihood itself is flat at its top, and ours must not be lower.
        near("ln likelihood", fit.ln_likelihood, ln_likelihood, 1e-6);
        near("AIC", fit.aic, aic, 2e-6);
        near("low", coordinate(fit.threshold.low.unwrap()), profile[0], 1e-4);
        near("high", coordinate(fit.threshold.high.unwrap()), profile[1], 1e-4);
    }
}

/// With many answers both bootstraps and the profile agree about the threshold's interval.
#[test]
fn bootstraps_agree_with_the_profile() {
    let data = counts(&SEVEN, 400, &[204, 222, 271, 322, 371, 389, 391]);
    let fit = likelihood_fit(&data, &BASE).unwrap();
    let [low, high] = [fit.threshold.low.unwrap(), fit.threshold.high.unwrap()];
    for resampling in [Resampling::Parametric, Resampling::NonParametric] {
        let config = BootstrapConfig { resampling, samples: 800, seed: 11 };
        let interval = bootstrap(&data, &BASE, &config).unwrap().interval(|f| Some(f.threshold), 0.95).unwrap();
        println!("{resampling:?}: {interval:?}, profile {low} – {high}");
        // 800 draws know an end to about 5 % of the width (two standard errors).
        for (end, expected) in interval.iter().zip([low, high]) {
            assert!(
                (end - expected).abs() < 0.08 * (high - low),
                "{resampling:?}: {interval:?} against {low} – {high}"
            );
        }
    }
}

/// Where two groups have one function, the test says otherwise in one of twenty data sets; where thresholds are an eighth of the
/// range apart, in nearly all.
#[test]
fn the_test_of_shared_thresholds_keeps_its_level() {
    let truth = Psychometric { threshold: 4.0, width: 3.0, lapse: 0.02, guess: 0.5, overdispersion: 0.0 };
    let mut rejected = [0, 0];
    let sets = 200;
    for set in 0..sets {
        let mut rng = ChaCha8Rng::seed_from_u64(set);
        let mut draw = |threshold: f64| -> Vec<Count> {
            let truth = Psychometric { threshold, ..truth };
            SEVEN
                .iter()
                .map(|&level| {
                    let p = truth.probability(level, &BASE);
                    let k = (0..60).filter(|_| rng.random::<f64>() < p).count();
                    Count { level, n: 60, k: u32::try_from(k).unwrap() }
                })
                .collect()
        };
        let (first, same, other) = (draw(4.0), draw(4.0), draw(5.5));
        for (count, second) in rejected.iter_mut().zip([same, other]) {
            let test = compare(&[&first, &second], &BASE, &[Parameter::Threshold], &[Parameter::Lapse]).unwrap();
            assert_eq!(test.df, 1);
            *count += u32::from(test.p < 0.05);
        }
    }
    println!("rejected of {sets}: {rejected:?}");
    // A binomial with p = .05 and n = 200 is from 2 to 19 but once in 500.
    assert!((2..=19).contains(&rejected[0]) && rejected[1] > 190, "{rejected:?}");
}
