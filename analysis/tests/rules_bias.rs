//! How far the papers' rules lie from a known truth: exact distributions against simulation, and the coverage of the
//! intervals over observers.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "common/rows.rs"]
mod rows;

use analysis::answers::Row;
use analysis::psychometric::{Direction, Psychometric, PsychometricConfig};
use analysis::rules::guenter::{Options, Test, Thresholds, thresholds};
use analysis::rules::tursun::{self, PairChance};
use analysis::rules::{Bootstrap, FirstPassed, OverObservers};
use experiments::trial::Answer;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rows::{names, observers, pair, row, with_level};

const J: std::ops::RangeInclusive<i32> = 8..=22;

/// An observer who calls the reference better half of the time at this index.
fn noticed(threshold: f64, width: f64, lapse: f64) -> impl Fn(f64) -> f64 {
    let truth = Psychometric { threshold, width, lapse, guess: 0.0, overdispersion: 0.0 };
    move |j| {
        truth
            .probability(j, &PsychometricConfig { direction: Direction::Falls, ..PsychometricConfig::TWO_ALTERNATIVES })
    }
}

fn expected(trials: u32, noticed: impl Fn(f64) -> f64) -> FirstPassed {
    let levels: Vec<f64> = J.map(f64::from).collect();
    Thresholds::expected(&levels, trials, Direction::Falls, noticed)
}

fn session(rng: &mut ChaCha8Rng, trials: usize, noticed: &impl Fn(f64) -> f64) -> Vec<Row> {
    let levels = J.flat_map(|j| vec![f64::from(j); trials]);
    levels.map(|j| pair(j, (rng.random::<f64>() < noticed(j)).then_some(true))).collect()
}

/// The paper's design (15 indices, two orders) with an observer whose threshold is 15 and whose function is 6 wide: the
/// closed form and 4000 simulated sessions agree, and both lie almost two indices below 15.
#[test]
fn the_pair_rule_is_biased_towards_coarse_and_by_how_much_is_exact() {
    let truth = noticed(15.0, 6.0, 0.02);
    let exact = expected(2, &truth);
    let (mean, sd) = (exact.mean.unwrap(), exact.sd.unwrap());
    let names = names(4000);
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let rows: Vec<Vec<Row>> = names.iter().map(|_| session(&mut rng, 2, &truth)).collect();
    let options = Options { bootstrap: Bootstrap { replicates: 0, seed: 1 }, ..Options::default() };
    let found = thresholds(Test::Pair, &observers(&names, &rows), &options).unwrap();
    let over = found.over_observers.unwrap();
    println!("exact {mean:.3} ± {sd:.3}, simulated {:.3} ± {:.3}", over.mean, over.sd.unwrap());
    // Four standard errors of a mean of 4000.
    assert!((over.mean - mean).abs() < 4.0 * sd / 4000f64.sqrt(), "{} against {mean}", over.mean);
    assert!((over.sd.unwrap() / sd - 1.0).abs() < 0.06);
    assert!((-1.95..-1.85).contains(&(mean - 15.0)) && over.mean < 15.0 - 1.7);
}

/// More trials make the rule worse, not better: it goes to the coarsest index.
#[test]
fn the_pair_rule_does_not_converge() {
    let means: Vec<f64> =
        [1, 2, 8, 32, 1000].map(|trials| expected(trials, noticed(15.0, 6.0, 0.02)).mean.unwrap()).into();
    println!("{means:.2?}");
    assert!(means.windows(2).all(|pair| pair[1] < pair[0]), "{means:?}");
    assert!(means[4] < 8.01 && means[0] > 13.0);
}

/// Lapses alone: one answer in twenty without regard to the picture costs most of the range.
#[test]
fn lapses_alone_move_the_pair_rule() {
    let [without, with] = [0.0, 0.05].map(|lapse| expected(2, noticed(20.0, 2.0, lapse)).mean.unwrap());
    println!("{without:.2} without lapses, {with:.2} with 5 %");
    assert!(without > 18.5 && with < 15.5);
}

fn nine(n: usize, detected: impl Fn(f64) -> f64) -> Vec<PairChance> {
    let pairs = [4.0, 7.0, 11.0].into_iter().flat_map(|r| [0.0017, 0.0035, 0.0052].map(|k| (r, k)));
    let chance = |(radius_deg, rate)| {
        let detected = detected(tursun::sigma_deg(radius_deg, rate, 20.0));
        PairChance { radius_deg, rate, n, detected }
    };
    pairs.map(chance).collect()
}

/// What the rule gives to an observer with chosen detection probabilities, against 3000 simulated sessions.
#[test]
fn what_tursuns_rule_gives_is_exact() {
    let options = tursun::Options {
        eccentricities_deg: vec![20.0],
        bootstrap: Bootstrap { replicates: 0, seed: 1 },
        ..tursun::Options::default()
    };
    // 75 % at σ = 0.035°.
    let pairs = nine(10, |sigma| 0.5 + 0.5 / (1.0 + (-120.0 * (sigma - 0.035)).exp()));
    let exact = tursun::expected_sigma(&pairs, 20.0, &options);
    let (mean, sd) = (exact.mean.unwrap(), exact.sd.unwrap());
    assert!(exact.none < 1e-12);
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    let names = names(3000);
    let rows: Vec<Vec<Row>> = names
        .iter()
        .map(|_| {
            pairs
                .iter()
                .flat_map(|pair| std::iter::repeat_n(pair, pair.n))
                .map(|pair| {
                    let right = rng.random::<f64>() < pair.detected;
                    let level = [("radius_deg", pair.radius_deg), ("rate", pair.rate)];
                    with_level(row(Answer::First, Some(right)), &level)
                })
                .collect()
        })
        .collect();
    let found = tursun::tolerances(&observers(&names, &rows), &options).unwrap();
    let over = &found.patches[0].over_observers[0].sigma_deg;
    println!("exact {mean:.4} ± {sd:.4}, simulated {:.4} ± {:.4}", over.mean, over.sd.unwrap());
    assert!((over.mean - mean).abs() < 4.0 * sd / 3000f64.sqrt());
    assert!((over.sd.unwrap() / sd - 1.0).abs() < 0.06);
}

/// An observer who detects every blur in 80 % of the looks tolerates none by the paper's criterion. Ten repetitions of nine
/// pairs give them a tolerance in 97 % of the patches, of more than half of the strongest blur on average; only with very
/// many repetitions does the rule find the truth.
#[test]
fn tursuns_rule_takes_chance_for_tolerance_until_repetitions_are_many() {
    let options = tursun::Options::default();
    let [ten, hundred, thousands] = [10, 100, 4000].map(|n| tursun::expected_sigma(&nine(n, |_| 0.8), 20.0, &options));
    let any = |first: &FirstPassed| 1.0 - first.outcomes.last().unwrap().probability;
    let strongest = tursun::sigma_deg(4.0, 0.0052, 20.0);
    println!("{:.3} of {strongest:.3}° at n = 10, {:.3} at 100", ten.mean.unwrap(), hundred.mean.unwrap());
    // P(at most 7 of 10 at p = .8) = 1 − 45 · .8⁸ · .2² − 10 · .8⁹ · .2 − .8¹⁰ = .3222005.
    assert!((ten.outcomes[0].probability - 0.322_200).abs() < 1e-6);
    assert!((any(&ten) - (1.0 - 0.677_800f64.powi(9))).abs() < 1e-5);
    assert!(ten.mean.unwrap() > 0.5 * strongest && any(&hundred) < 0.6 && any(&thousands) < 1e-6);
}

/// Means of 15 observers' pair thresholds, 2000 times: how often each interval has the rule's own expectation, and how
/// seldom the truth, which lies 1.4 indices higher. Two lapses in a hundred make the thresholds so skewed that even
/// Student's interval covers 92 % only.
#[test]
fn intervals_over_observers_cover_the_rules_mean_and_not_the_truth() {
    let truth = noticed(15.0, 4.0, 0.02);
    let exact = expected(2, &truth);
    let (mean, levels) = (exact.mean.unwrap(), &exact.outcomes);
    let mut rng = ChaCha8Rng::seed_from_u64(33);
    let draw = |rng: &mut ChaCha8Rng| {
        let mut left = rng.random::<f64>() * (1.0 - exact.none);
        levels.iter().find(|passed| {
            left -= passed.probability;
            left <= 0.0
        })
    };
    let bootstrap = Bootstrap { replicates: 400, seed: 5 };
    let (mut by_t, mut by_bootstrap, mut truth_in, n) = (0u32, 0u32, 0u32, 2000);
    for _ in 0..n {
        let values: Vec<f64> = (0..15).filter_map(|_| draw(&mut rng)).map(|passed| passed.value).collect();
        let over = OverObservers::new(values, &bootstrap).unwrap();
        let has = |ends: Option<[f64; 2]>, value: f64| ends.is_some_and(|[low, high]| (low..=high).contains(&value));
        by_t += u32::from(has(over.ci95, mean));
        by_bootstrap += u32::from(has(over.bootstrap95, mean));
        truth_in += u32::from(has(over.ci95, 15.0));
    }
    let share = |k: u32| f64::from(k) / f64::from(n);
    println!("t {:.3}, bootstrap {:.3}, truth {:.3}", share(by_t), share(by_bootstrap), share(truth_in));
    // Four standard errors of a share of 2000 around what was measured.
    assert!((share(by_t) - 0.92).abs() < 0.025);
    assert!((share(by_bootstrap) - 0.89).abs() < 0.029);
    assert!(share(truth_in) < 0.3);
}
