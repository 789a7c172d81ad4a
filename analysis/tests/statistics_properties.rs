//! What must hold of tests whatever the data: invariances, sums, degenerate input, and what their intervals cover.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::statistics::anova::{
    Anova, AnovaConfig, AnovaError, Factor, Mauchly, Missing, Observations, Replicates, Table, pairwise, rm_anova,
};
use analysis::statistics::effect_size::Standardizer;
use analysis::statistics::multiple::Adjustment;
use analysis::statistics::ranks::{Method, Zeros, friedman, mann_whitney, wilcoxon};
use analysis::statistics::{Alternative, TestError, t_tests};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn factor(name: &str, levels: usize) -> Factor {
    Factor { name: name.to_owned(), levels: (0..levels).map(|level| format!("{name}{level}")).collect() }
}

fn table(lengths: &[usize], values: Vec<f64>) -> Table {
    let factors: Vec<Factor> = lengths.iter().zip(["A", "B", "C", "D"]).map(|(n, name)| factor(name, *n)).collect();
    let subjects = values.len() / lengths.iter().product::<usize>();
    Table::new(factors, (0..subjects).map(|subject| format!("P{subject}")).collect(), values).unwrap()
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Every number of the result, through its JSON: no NaN gets past it, since it would be null where a number must be.
fn json(anova: &Anova) -> String {
    let text = serde_json::to_string(anova).unwrap();
    let again: Anova = serde_json::from_str(&text).unwrap();
    assert_eq!(&again, anova);
    text
}

/// F, p, ε, W and η² of every effect, by name.
fn essence(anova: &Anova) -> Vec<(String, Vec<f64>)> {
    let mut essence: Vec<(String, Vec<f64>)> = anova
        .effects
        .iter()
        .map(|effect| {
            let mut factors = effect.factors.clone();
            factors.sort();
            let mut numbers =
                vec![effect.df as f64, effect.df_error as f64, effect.generalised_eta_squared.unwrap_or(-1.0)];
            if let Some(test) = &effect.test {
                numbers.extend([test.f, test.p, test.greenhouse_geisser.epsilon, test.greenhouse_geisser.p]);
                numbers.push(test.huynh_feldt.map_or(-1.0, |corrected| corrected.epsilon));
                numbers.extend(test.mauchly.test().map(|mauchly| mauchly.chi_square));
            }
            (factors.join(":"), numbers)
        })
        .collect();
    essence.sort_by(|a, b| a.0.cmp(&b.0));
    essence
}

fn assert_same(a: &Anova, b: &Anova, error: f64) {
    for ((name, ours), (other, theirs)) in essence(a).iter().zip(&essence(b)) {
        assert_eq!((name, ours.len()), (other, theirs.len()));
        for (x, y) in ours.iter().zip(theirs) {
            assert!((x - y).abs() <= error * (1.0 + x.abs()), "{name}: {ours:?} {theirs:?}");
        }
    }
}

prop_compose! {
    /// Designs of one to three factors with values on a grid of thousandths.
    fn designs()(lengths in prop::collection::vec(2usize..5, 1..4), subjects in 2usize..8)
        (values in prop::collection::vec(-5000i32..5000, subjects * lengths.iter().product::<usize>()), lengths in Just(lengths))
        -> (Vec<usize>, Vec<f64>)
    {
        (lengths, values.into_iter().map(|value| f64::from(value) / 1000.0).collect())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn sums_of_squares_add_up((lengths, values) in designs()) {
        let anova = table(&lengths, values).analyse(0.95).unwrap();
        let parts: f64 = anova.effects.iter().map(|effect| effect.ss + effect.ss_error).sum();
        prop_assert!(((parts + anova.ss_subjects) / anova.ss_total - 1.0).abs() < 1e-10);
        let df: usize = anova.effects.iter().map(|effect| effect.df + effect.df_error).sum();
        prop_assert_eq!(df + anova.df_subjects + 1, anova.table.values().len());
        prop_assert_eq!(anova.effects.len(), (1 << lengths.len()) - 1);
        for effect in &anova.effects {
            let Some(test) = &effect.test else { continue };
            let lowest = 1.0 / effect.df as f64;
            prop_assert!((lowest..=1.0).contains(&test.greenhouse_geisser.epsilon));
            // A smaller ε never makes a p smaller where F is above 1, and Huynh–Feldt is never the stricter one.
            if let Some(corrected) = test.huynh_feldt {
                prop_assert!(corrected.epsilon >= test.greenhouse_geisser.epsilon - 1e-12);
            }
            let [low, high] = test.partial_eta_squared.ci;
            prop_assert!((0.0..=1.0).contains(&low) && low <= high && high <= 1.0);
        }
    }

    #[test]
    fn constants_units_subjects_and_the_order_of_levels_change_nothing((lengths, values) in designs(), shift in -1e3..1e3f64, unit in 1e-6..1e6f64, turn in 0usize..100) {
        let plain = table(&lengths, values.clone()).analyse(0.95).unwrap();
        let cells: usize = lengths.iter().product();
        let moved = table(&lengths, values.iter().map(|value| (value + shift) * unit).collect()).analyse(0.95).unwrap();
        // Differences of a thousandth on top of a shift of a thousand leave ten digits.
        assert_same(&plain, &moved, 1e-7);

        let mut rows: Vec<&[f64]> = values.chunks(cells).collect();
        let by = turn % rows.len();
        rows.rotate_left(by);
        assert_same(&plain, &table(&lengths, rows.concat()).analyse(0.95).unwrap(), 1e-9);

        // Blocks of the first factor's levels, turned within every subject.
        let block = cells / lengths[0];
        let turned: Vec<f64> = values.chunks(cells).flat_map(|row| {
            let mut row = row.to_vec();
            row.rotate_left(block * (turn % lengths[0]));
            row
        }).collect();
        assert_same(&plain, &table(&lengths, turned).analyse(0.95).unwrap(), 1e-7);
    }

    #[test]
    fn two_levels_are_a_paired_t_test((values, subjects) in (3usize..12).prop_flat_map(|n| (prop::collection::vec(-100i32..100, 2 * n), Just(n)))) {
        let values: Vec<f64> = values.into_iter().map(f64::from).collect();
        let (first, second): (Vec<f64>, Vec<f64>) = values.chunks(2).map(|pair| (pair[0], pair[1])).unzip();
        let anova = table(&[2], values.clone()).analyse(0.95).unwrap();
        match t_tests::paired(&first, &second, Alternative::TwoSided, 0.95) {
            Ok(t) => {
                let test = anova.effects[0].test.as_ref().unwrap();
                prop_assert!((test.f - t.t * t.t).abs() <= 1e-9 * (1.0 + test.f));
                prop_assert!((test.p - t.p).abs() <= 1e-9);
                prop_assert_eq!(test.mauchly, Mauchly::OneContrast);
                prop_assert_eq!(test.greenhouse_geisser.epsilon, 1.0);
                prop_assert_eq!(anova.effects[0].df_error, subjects - 1);
                // λ = δ², and so their limits where d's interval does not hold 0.
                let d = t.effect_size(Standardizer::Differences).unwrap();
                prop_assert!((d.d - t.t / (subjects as f64).sqrt()).abs() < 1e-12);
                prop_assert!(d.ci[0] <= d.d && d.d <= d.ci[1]);
            }
            Err(TestError::NoVariance { .. }) => prop_assert!(anova.effects[0].test.is_none()),
            Err(other) => prop_assert!(false, "{}", other),
        }
    }

    /// Values from a handful of numbers, huge and tiny ones among them: an answer without NaN, or an error.
    #[test]
    fn degenerate_values_give_answers_or_errors(lengths in prop::collection::vec(2usize..4, 1..3), picks in prop::collection::vec(0usize..7, 200), pool in 1usize..7, subjects in 2usize..6) {
        let pools = [0.0, 1.0, -1.0, 1e-160, 1e149, 0.1, -1e149];
        let values: Vec<f64> = picks.iter().map(|pick| pools[pick % pool]).take(subjects * lengths.iter().product::<usize>()).collect();
        let anova = table(&lengths, values.clone()).analyse(0.95).unwrap();
        json(&anova);
        let pairs = pairwise(&anova.table, "A", Adjustment::Holm, 0.95).unwrap();
        let text = serde_json::to_string(&pairs).unwrap();
        prop_assert_eq!(serde_json::from_str::<analysis::statistics::anova::Pairwise>(&text).unwrap(), pairs);

        let (first, second) = values.split_at(values.len() / 2);
        for result in [
            t_tests::paired(first, &second[..first.len()], Alternative::Greater, 0.95),
            t_tests::welch(first, second, Alternative::TwoSided, 0.95),
            t_tests::one_sample(&values, 0.1, Alternative::Less, 0.95),
        ].into_iter().flatten() {
            let text = serde_json::to_string(&result).unwrap();
            prop_assert_eq!(serde_json::from_str::<t_tests::TTest>(&text).unwrap(), result);
        }
        for method in [Method::Exact, Method::Normal { continuity: true }] {
            for zeros in [Zeros::Pratt, Zeros::Wilcoxon] {
                if let Ok(test) = wilcoxon(first, &second[..first.len()], zeros, method, Alternative::TwoSided) {
                    prop_assert!((0.0..=1.0).contains(&test.p) && test.rank_biserial.abs() <= 1.0);
                }
            }
            if let Ok(test) = mann_whitney(first, second, method, Alternative::TwoSided) {
                prop_assert!((0.0..=1.0).contains(&test.p) && test.rank_biserial.abs() <= 1.0);
            }
        }
        let rows: Vec<Vec<f64>> = values.chunks(lengths[0]).map(<[f64]>::to_vec).collect();
        if let Ok(test) = friedman(&rows) {
            prop_assert!((0.0..=1.0).contains(&test.p) && (0.0..=1.0).contains(&test.kendall_w));
        }
    }
}

#[test]
fn constant_data_have_no_test_and_say_so() {
    // Every subject shows the same effect exactly: 0.1 and 0.3 are not exact in binary.
    let values: Vec<f64> =
        (0..6).flat_map(|subject| [0.1, 0.3, 0.7].map(|effect| effect + f64::from(subject) * 1.1)).collect();
    let anova = table(&[3], values).analyse(0.95).unwrap();
    assert!(anova.effects[0].test.is_none() && anova.effects[0].ss > 1.0);
    json(&anova);
    let anova = table(&[2, 3], vec![5.0; 24]).analyse(0.95).unwrap();
    assert!(anova.effects.iter().all(|effect| effect.test.is_none() && effect.generalised_eta_squared.is_none()));
    let pairs = pairwise(&anova.table, "B", Adjustment::Holm, 0.95).unwrap();
    assert!(pairs.comparisons.len() == 3 && pairs.comparisons.iter().all(|pair| pair.p_adjusted.is_none()));
}

#[test]
fn too_few_subjects_for_mauchly_leave_greenhouse_and_geisser() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let anova = table(&[4], (0..12).map(|_| normal(&mut rng)).collect()).analyse(0.95).unwrap();
    let test = anova.effects[0].test.as_ref().unwrap();
    assert_eq!(test.mauchly, Mauchly::TooFewSubjects { subjects: 3, contrasts: 3 });
    assert!((1.0 / 3.0..=2.0 / 3.0 + 1e-12).contains(&test.greenhouse_geisser.epsilon));
    // Two subjects: one direction of variance, so ε is 1/3 and Huynh and Feldt's ratio is 0/0.
    let anova = table(&[4], (0..8).map(|_| normal(&mut rng)).collect()).analyse(0.95).unwrap();
    let test = anova.effects[0].test.as_ref().unwrap();
    assert!((test.greenhouse_geisser.epsilon - 1.0 / 3.0).abs() < 1e-12);
    assert_eq!(test.huynh_feldt, None);
    // A condition that is the mean of two others.
    let values = (0..10).flat_map(|_| {
        let (a, b, c) = (normal(&mut rng), normal(&mut rng), normal(&mut rng));
        [a, b, 0.5 * (a + b), c]
    });
    let anova = table(&[4], values.collect()).analyse(0.95).unwrap();
    assert_eq!(anova.effects[0].test.as_ref().unwrap().mauchly, Mauchly::Singular);
}

fn observed() -> Observations {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut observations = Observations::new(["scene", "frc"]);
    for subject in ["P1", "P2", "P3", "P4"] {
        for scene in ["car", "tunnel"] {
            for frc in ["small", "medium", "large"] {
                observations.push(subject, [scene, frc], normal(&mut rng));
            }
        }
    }
    observations
}

#[test]
fn missing_cells_are_all_named_or_their_subjects_left_out() {
    let mut observations = observed();
    observations.rows.retain(|row| !(row.subject == "P2" && row.levels[1] == "large"));
    observations.rows.retain(|row| !(row.subject == "P4" && row.levels == ["car", "small"]));
    let error = rm_anova(&observations, &AnovaConfig::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "3 missing: subject P2 at scene=car, frc=large; subject P2 at scene=tunnel, frc=large; \
         subject P4 at scene=car, frc=small"
    );
    let config = AnovaConfig { missing: Missing::DropSubjects, ..AnovaConfig::default() };
    let anova = rm_anova(&observations, &config).unwrap();
    assert_eq!(anova.table.subjects(), ["P1", "P3"]);
    assert_eq!(anova.table.dropped(), ["P2", "P4"]);
    assert_eq!(anova.table.missing().len(), 3);
    assert_eq!(anova.effect(&["frc", "scene"]).unwrap().df_error, 2);
    json(&anova);

    observations.rows.retain(|row| row.subject != "P1");
    let error = rm_anova(&observations, &config).unwrap_err();
    assert_eq!(error, AnovaError::TooFewSubjects { kept: 1, dropped: 2 });
}

#[test]
fn replicates_are_refused_or_averaged() {
    let mut observations = observed();
    let value = observations.rows[7].value;
    let again = observations.rows[7].clone();
    observations.push(again.subject, again.levels, value + 1.0);
    let error = rm_anova(&observations, &AnovaConfig::default()).unwrap_err().to_string();
    assert!(error.starts_with("subject \"P2\" has more than one value at scene=car, frc=medium"), "{error}");
    let config = AnovaConfig { replicates: Replicates::Mean, ..AnovaConfig::default() };
    let averaged = rm_anova(&observations, &config).unwrap();
    assert!((averaged.table.values()[7] - (value + 0.5)).abs() < 1e-15);
}

#[test]
fn other_mistakes_are_named_too() {
    let analyse = |observations: &Observations| rm_anova(observations, &AnovaConfig::default()).unwrap_err();
    let edited = |edit: &dyn Fn(&mut Observations)| {
        let mut observations = observed();
        edit(&mut observations);
        analyse(&observations)
    };
    assert_eq!(analyse(&Observations::new(["a"])), AnovaError::NoObservations);
    assert_eq!(analyse(&Observations::default()), AnovaError::NoFactors);
    assert_eq!(edited(&|o| o.factors[1] = "scene".to_owned()), AnovaError::DuplicateFactor("scene".to_owned()));
    assert_eq!(
        edited(&|o| o.rows.retain(|row| row.subject == "P3")),
        AnovaError::TooFewSubjects { kept: 1, dropped: 0 }
    );
    assert!(
        matches!(edited(&|o| o.rows.retain(|row| row.levels[0] == "car")), AnovaError::OneLevel { factor, .. } if factor == "scene")
    );
    assert!(matches!(
        edited(&|o| {
            o.rows[3].levels.pop();
        }),
        AnovaError::LevelCount { index: 3, expected: 2, found: 1, .. }
    ));
    for value in [f64::NAN, f64::INFINITY, 1e200] {
        assert!(matches!(edited(&|o| o.rows[0].value = value), AnovaError::Value { .. }));
    }
    // Forty factors of two levels from two observations would be 2⁴⁰ missing cells.
    let mut many = Observations::new((0..40).map(|i| i.to_string()));
    for level in ["a", "b"] {
        many.push(level, vec![level; 40], 1.0);
    }
    assert!(matches!(analyse(&many), AnovaError::TooLarge { subjects: 2, .. }));
    let config = AnovaConfig { confidence: 1.0, ..AnovaConfig::default() };
    assert_eq!(rm_anova(&observed(), &config), Err(AnovaError::Test(TestError::Confidence(1.0))));
}

#[test]
fn pairs_are_tested_on_means_over_the_other_factors_and_adjusted() {
    let anova = rm_anova(&observed(), &AnovaConfig::default()).unwrap();
    let pairs = pairwise(&anova.table, "frc", Adjustment::Holm, 0.95).unwrap();
    let names: Vec<(&str, &str)> =
        pairs.comparisons.iter().map(|pair| (pair.first.as_str(), pair.second.as_str())).collect();
    assert_eq!(names, [("small", "medium"), ("small", "large"), ("medium", "large")]);
    let margins = anova.table.margins("frc").unwrap();
    let values = anova.table.values();
    assert!((margins[1][2] - 0.5 * (values[13] + values[16])).abs() < 1e-15);
    let direct = t_tests::paired(&margins[0], &margins[2], Alternative::TwoSided, 0.95).unwrap();
    assert_eq!(pairs.comparisons[1].test.as_ref(), Some(&direct));
    for pair in &pairs.comparisons {
        assert!(pair.p_adjusted.unwrap() >= pair.test.as_ref().unwrap().p);
    }
    assert_eq!(pairwise(&anova.table, "x", Adjustment::Holm, 0.95), Err(AnovaError::UnknownFactor("x".to_owned())));
    // Within one scene: the table without that factor.
    let tunnel = anova.table.at("scene", "tunnel").unwrap();
    assert_eq!((tunnel.cells(), tunnel.values()[1]), (3, values[4]));
    assert!(matches!(tunnel.at("frc", "huge"), Err(AnovaError::UnknownLevel { .. })));
}

/// Twelve subjects, d_z = 0.8 (and d_av = 0.8 √(2 (1 − ρ)) with ρ = ½, which is 0.8 as well), 1000 samples: 95 % intervals by
/// the noncentral t hold the truth in 95 % ± 1.5 %; Welch's with unequal variances within 2 %.
#[test]
fn intervals_of_effect_sizes_hold_the_truth_as_often_as_they_say() {
    let seed = 20_031_121;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let samples = 1000;
    let mut held = [0; 4];
    let within = |ci: [f64; 2], truth: f64| usize::from((ci[0]..=ci[1]).contains(&truth));
    for _ in 0..samples {
        let pairs: Vec<(f64, f64)> = (0..12)
            .map(|_| {
                let common = normal(&mut rng);
                (common + normal(&mut rng) + 0.8 * 2f64.sqrt(), common + normal(&mut rng))
            })
            .collect();
        let (first, second): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let test = t_tests::paired(&first, &second, Alternative::TwoSided, 0.95).unwrap();
        held[0] += within(test.effect_size(Standardizer::Differences).unwrap().ci, 0.8);
        held[1] += within(test.effect_size(Standardizer::Average).unwrap().ci, 0.8);

        let first: Vec<f64> = (0..14).map(|_| 2.0 * normal(&mut rng) + 1.0).collect();
        let second: Vec<f64> = (0..14).map(|_| normal(&mut rng)).collect();
        let test = t_tests::welch(&first, &second, Alternative::TwoSided, 0.95).unwrap();
        held[2] += within(test.effect_size(Standardizer::Average).unwrap().ci, 1.0 / 2.5f64.sqrt());
        let first: Vec<f64> = second.iter().take(9).map(|_| normal(&mut rng) + 0.6).collect();
        let test = t_tests::welch(&first, &second, Alternative::TwoSided, 0.95).unwrap();
        held[3] += within(test.effect_size(Standardizer::Pooled).unwrap().ci, 0.6);
    }
    let coverage = held.map(|held| held as f64 / f64::from(samples));
    println!(
        "seed {seed}: d_z {}, d_av of pairs {}, d_av of Welch {}, d_s {}",
        coverage[0], coverage[1], coverage[2], coverage[3]
    );
    for (found, allowed) in coverage.into_iter().zip([0.015, 0.03, 0.02, 0.015]) {
        assert!((found - 0.95).abs() < allowed, "{coverage:?}");
    }
}

/// Under sphericity, λ of a 12 × 4 design with effects ±a is n Σα²/σ²; its interval holds it in 95 % ± 1.5 %.
#[test]
fn intervals_of_eta_squared_hold_the_truth_as_often_as_they_say() {
    let (seed, samples, n) = (19_590_401, 2000, 12);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let effects = [0.6, 0.1, -0.2, -0.5];
    let lambda = n as f64 * effects.iter().map(|a| a * a).sum::<f64>();
    let (mut held, mut rejected, mut corrected) = (0, 0, 0);
    for _ in 0..samples {
        let values: Vec<f64> = (0..n)
            .flat_map(|_| {
                let subject = 3.0 * normal(&mut rng);
                effects.map(|effect| effect + subject + normal(&mut rng))
            })
            .collect();
        let anova = table(&[4], values.clone()).analyse(0.95).unwrap();
        let eta = anova.effects[0].test.as_ref().unwrap().partial_eta_squared;
        held += usize::from((eta.noncentrality_ci[0]..=eta.noncentrality_ci[1]).contains(&lambda));

        // Without an effect, but with one condition four times as variable: sphericity fails.
        let values: Vec<f64> = values
            .chunks(4)
            .flat_map(|row| [4.0 * (row[0] - row[1] - 0.5), normal(&mut rng), normal(&mut rng), normal(&mut rng)])
            .collect();
        let anova = table(&[4], values).analyse(0.95).unwrap();
        let test = anova.effects[0].test.as_ref().unwrap();
        rejected += usize::from(test.p < 0.05);
        corrected += usize::from(test.greenhouse_geisser.p < 0.05);
    }
    let [held, rejected, corrected] = [held, rejected, corrected].map(|count| count as f64 / f64::from(samples));
    println!("seed {seed}: λ held {held}; without sphericity p < .05 in {rejected}, corrected {corrected}");
    assert!((held - 0.95).abs() < 0.015, "{held}");
    assert!(rejected > 0.08 && (corrected - 0.05).abs() < 0.02, "{rejected} {corrected}");
}

/// The Wilcoxon, Mann–Whitney and Friedman approximations must know of ties: by hand from the textbook formulas.
#[test]
fn ties_are_corrected_for() {
    // |d| = 1, 1, 1, 1, 2, 2, 3, 3: Var W = n(n+1)(2n+1)/24 − (60 + 6 + 6)/48 = 51 − 1.5.
    let differences = [1.0, 1.0, -1.0, 1.0, 2.0, -2.0, 3.0, 3.0];
    let zero = [0.0; 8];
    let test =
        wilcoxon(&differences, &zero, Zeros::Wilcoxon, Method::Normal { continuity: false }, Alternative::TwoSided)
            .unwrap();
    // Ranks 2.5 ×4, 5.5 ×2, 7.5 ×2.
    assert_eq!((test.w_plus, test.w_minus), (28.0, 8.0));
    assert!((test.z.unwrap() - 10.0 / 49.5f64.sqrt()).abs() < 1e-14);

    // Friedman: rows (1, 2, 2) give ranks 1, 2.5, 2.5 four times: complete agreement although ties shrink the ranks.
    let test = friedman(&vec![vec![1.0, 2.0, 2.0]; 4]).unwrap();
    assert!((test.kendall_w - 1.0).abs() < 1e-14 && (test.chi_square - 8.0).abs() < 1e-13);
    assert_eq!(test.iman_davenport, None);

    // Mann–Whitney: 1 1 2 against 1 2 2: U = 2.5, Var U = 9/12 (7 − 48/30).
    let test =
        mann_whitney(&[1.0, 1.0, 2.0], &[1.0, 2.0, 2.0], Method::Normal { continuity: false }, Alternative::TwoSided)
            .unwrap();
    assert_eq!(test.u, 3.0);
    assert!((test.z.unwrap() - (3.0 - 4.5) / (0.75f64 * (7.0 - 1.6)).sqrt()).abs() < 1e-14);
}

#[test]
fn rank_tests_refuse_what_cannot_be_ranked() {
    let same = [1.0, 2.0];
    let auto = |a: &[f64], b: &[f64]| wilcoxon(a, b, Zeros::Pratt, Method::Auto, Alternative::TwoSided).unwrap_err();
    assert!(matches!(auto(&same, &same), TestError::NoVariance { .. }));
    assert!(matches!(auto(&[], &[]), TestError::NoVariance { .. }));
    assert!(matches!(auto(&[1.0], &same), TestError::UnequalLengths { .. }));
    assert!(matches!(auto(&[f64::NAN], &[1.0]), TestError::NotFinite { index: 0, .. }));
    let long: Vec<f64> = (0..1001).map(f64::from).collect();
    let zero = vec![-1.0; 1001];
    assert!(matches!(
        wilcoxon(&long, &zero, Zeros::Pratt, Method::Exact, Alternative::Less),
        Err(TestError::TooManyForExact { n: 1001, .. })
    ));
    assert!(matches!(friedman(&[vec![1.0, 1.0], vec![2.0, 2.0]]), Err(TestError::NoVariance { .. })));
    assert!(matches!(friedman(&[vec![1.0, 2.0], vec![2.0]]), Err(TestError::Ragged { row: 1, .. })));
    assert!(matches!(friedman(&[vec![1.0, 2.0]]), Err(TestError::TooFew { .. })));
    assert!(matches!(
        mann_whitney(&[], &[1.0], Method::Auto, Alternative::Less),
        Err(TestError::TooFew { what: "the first sample", .. })
    ));
}
