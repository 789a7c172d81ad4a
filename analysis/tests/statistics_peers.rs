//! `analysis::statistics` against mpmath, scipy, statsmodels, pingouin and R's car; script, versions and how each number was
//! made are in `tests/peers/README.md`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::statistics::anova::{Effect, Factor, Mauchly, Table};
use analysis::statistics::binomial::{binomial_test, clopper_pearson, wilson};
use analysis::statistics::distributions as d;
use analysis::statistics::effect_size::{EffectSize, Standardizer};
use analysis::statistics::multiple::{Adjustment, adjust};
use analysis::statistics::ranks::{Method, Zeros, friedman, mann_whitney, wilcoxon};
use analysis::statistics::{Alternative, t_tests};
use serde_json::Value;

fn numbers() -> Value {
    serde_json::from_str(include_str!("statistics_numbers.json")).unwrap()
}

fn entries<'a>(numbers: &'a Value, key: &str) -> &'a [Value] {
    let entries = numbers[key].as_array().unwrap();
    assert!(!entries.is_empty());
    entries
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn alternative(entry: &Value) -> Alternative {
    match entry["alternative"].as_str().unwrap() {
        "two-sided" => Alternative::TwoSided,
        "greater" => Alternative::Greater,
        "less" => Alternative::Less,
        other => panic!("{other}"),
    }
}

/// Keeps the largest relative error of a kind of number, and holds each below its limit.
struct Errors {
    limit: f64,
    largest: f64,
    count: usize,
}

impl Errors {
    fn below(limit: f64) -> Self {
        Self { limit, largest: 0.0, count: 0 }
    }

    fn hold(&mut self, what: &str, ours: f64, peer: f64) {
        let error = if peer == 0.0 { ours.abs() } else { (ours / peer - 1.0).abs() };
        assert!(error <= self.limit, "{what}: {ours:e} against {peer:e}, off by {error:.1e}");
        self.largest = self.largest.max(error);
        self.count += 1;
    }

    fn report(&self, what: &str) {
        println!("{what}: {} numbers, the largest relative error {:.1e}", self.count, self.largest);
        assert!(self.count > 0);
    }
}

#[test]
fn tails_agree_with_mpmath() {
    let numbers = numbers();
    let mut errors = Errors::below(1e-10);
    for entry in entries(&numbers, "distributions") {
        let (name, x, peer) = (entry["name"].as_str().unwrap(), floats(&entry["arguments"]), floats(&entry["tails"]));
        let tails = match name {
            "t" => d::student_t(x[0], x[1]),
            "f" => d::f(x[0], x[1], x[2]),
            "chi_square" => d::chi_square(x[0], x[1]),
            "binomial" => d::binomial(x[0] as u64, x[1] as u64, x[2]),
            "noncentral_t" => d::noncentral_t(x[0], x[1], x[2]),
            "noncentral_f" => d::noncentral_f(x[0], x[1], x[2], x[3]),
            other => panic!("{other}"),
        }
        .unwrap();
        errors.hold(&format!("{name}{x:?} lower"), tails.lower, peer[0]);
        errors.hold(&format!("{name}{x:?} upper"), tails.upper, peer[1]);
    }
    errors.report("tails");
}

#[test]
fn binomial_tests_and_intervals_agree_with_scipy() {
    let numbers = numbers();
    let mut errors = Errors::below(1e-9);
    for entry in entries(&numbers, "binomial_tests") {
        let (k, n) = (entry["k"].as_u64().unwrap(), entry["n"].as_u64().unwrap());
        let test = binomial_test(k, n, entry["null"].as_f64().unwrap(), alternative(entry)).unwrap();
        errors.hold(&entry.to_string(), test.p, entry["p"].as_f64().unwrap());
    }
    for entry in entries(&numbers, "binomial_intervals") {
        let (k, n) = (entry["k"].as_u64().unwrap(), entry["n"].as_u64().unwrap());
        let confidence = entry["confidence"].as_f64().unwrap();
        for (ours, peer) in [
            (clopper_pearson(k, n, confidence).unwrap(), floats(&entry["exact"])),
            (wilson(k, n, confidence).unwrap(), floats(&entry["wilson"])),
        ] {
            errors.hold(&format!("{entry} low"), ours[0], peer[0]);
            errors.hold(&format!("{entry} high"), ours[1], peer[1]);
        }
    }
    errors.report("binomial");
    // The brief's figures: scipy 1.17.1.
    for (k, null, p) in [(31, 0.5, 0.000_679_548_3), (9, 0.25, 0.855_635_653_6)] {
        assert!((binomial_test(k, 40, null, Alternative::TwoSided).unwrap().p - p).abs() < 1e-10);
    }
}

#[test]
fn adjusted_values_agree_with_statsmodels() {
    let numbers = numbers();
    let mut errors = Errors::below(1e-14);
    for entry in entries(&numbers, "adjusted") {
        let method: Adjustment = serde_json::from_value(entry["method"].clone()).unwrap();
        let ours = adjust(&floats(&entry["p"]), method).unwrap();
        let peer = floats(&entry["adjusted"]);
        assert_eq!(ours.len(), peer.len());
        ours.iter().zip(peer).for_each(|(ours, peer)| errors.hold(&entry.to_string(), *ours, peer));
    }
    errors.report("adjusted p");
}

#[test]
fn t_tests_and_their_effect_sizes_agree_with_scipy() {
    let numbers = numbers();
    let (mut errors, mut limits) = (Errors::below(1e-9), Errors::below(1e-8));
    for entry in entries(&numbers, "t_tests") {
        let (first, second) = (floats(&entry["first"]), floats(&entry["second"]));
        let run = |alternative| match entry["design"].as_str().unwrap() {
            "one_sample" => t_tests::one_sample(&first, 0.25, alternative, 0.95).unwrap(),
            "paired" => t_tests::paired(&first, &second, alternative, 0.95).unwrap(),
            "welch" => t_tests::welch(&first, &second, alternative, 0.95).unwrap(),
            other => panic!("{other}"),
        };
        let test = run(Alternative::TwoSided);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        // The peer's interval is of the mean itself for one sample.
        let shift = if entry["design"] == "one_sample" { 0.25 } else { 0.0 };
        let ci = floats(&entry["ci"]);
        for (what, ours, peer) in [
            ("t", test.t, entry["t"].as_f64().unwrap()),
            ("df", test.df, entry["df"].as_f64().unwrap()),
            ("p", test.p, entry["p"].as_f64().unwrap()),
            ("greater", run(Alternative::Greater).p, entry["greater"].as_f64().unwrap()),
            ("less", run(Alternative::Less).p, entry["less"].as_f64().unwrap()),
            ("low", test.ci[0] + shift, ci[0]),
            ("high", test.ci[1] + shift, ci[1]),
        ] {
            errors.hold(&format!("{} {} {what}", entry["design"], mean(&first)), ours, peer);
        }
        let mut checked = 0;
        for (key, standardizer) in [
            ("differences", Standardizer::Differences),
            ("average", Standardizer::Average),
            ("pooled", Standardizer::Pooled),
        ] {
            let ours: Option<&EffectSize> = test.effect_size(standardizer);
            assert_eq!(ours.is_some(), entry.get(key).is_some(), "{} {key}", entry["design"]);
            let Some(ours) = ours else { continue };
            let peer = floats(&entry[key]);
            errors.hold(key, ours.d, peer[0]);
            limits.hold(&format!("{key} low"), ours.ci[0], peer[1]);
            limits.hold(&format!("{key} high"), ours.ci[1], peer[2]);
            if let Some(g) = entry[format!("{key}_g")].as_f64() {
                errors.hold("g", ours.g.unwrap(), g);
                checked += 1;
            }
        }
        assert!(checked > 0 || test.df <= 1.0);
    }
    errors.report("t tests");
    limits.report("limits of effect sizes");
}

fn method(entry: &Value) -> Method {
    match entry["method"].as_str().unwrap() {
        "exact" => Method::Exact,
        "normal" => Method::Normal { continuity: false },
        "continuity" => Method::Normal { continuity: true },
        other => panic!("{other}"),
    }
}

#[test]
fn rank_tests_agree_with_scipy_and_pingouin() {
    let numbers = numbers();
    let mut errors = Errors::below(1e-10);
    for entry in entries(&numbers, "signed_ranks") {
        let zeros = if entry["zeros"] == "pratt" { Zeros::Pratt } else { Zeros::Wilcoxon };
        let (first, second) = (floats(&entry["first"]), floats(&entry["second"]));
        let test = wilcoxon(&first, &second, zeros, method(entry), alternative(entry)).unwrap();
        errors.hold(&format!("signed ranks {entry}"), test.p, entry["p"].as_f64().unwrap());
        if let Some(statistic) = entry["statistic"].as_f64() {
            let ours = if entry["alternative"] == "two-sided" { test.w_plus.min(test.w_minus) } else { test.w_plus };
            errors.hold("W", ours, statistic);
        }
        if let Some(correlation) = entry["rank_biserial"].as_f64() {
            errors.hold("rank-biserial", test.rank_biserial, correlation);
        }
    }
    for entry in entries(&numbers, "mann_whitney") {
        let (first, second) = (floats(&entry["first"]), floats(&entry["second"]));
        let test = mann_whitney(&first, &second, method(entry), alternative(entry)).unwrap();
        errors.hold("U", test.u, entry["u"].as_f64().unwrap());
        errors.hold(&format!("Mann–Whitney {entry}"), test.p, entry["p"].as_f64().unwrap());
    }
    for entry in entries(&numbers, "friedman") {
        let rows: Vec<Vec<f64>> = entry["rows"].as_array().unwrap().iter().map(floats).collect();
        let test = friedman(&rows).unwrap();
        for (key, ours) in [
            ("chi_square", test.chi_square),
            ("p", test.p),
            ("w", test.kendall_w),
            ("f", test.iman_davenport.unwrap().f),
        ] {
            errors.hold(key, ours, entry[key].as_f64().unwrap());
        }
    }
    errors.report("ranks");
}

fn table(entry: &Value) -> Table {
    let lengths = floats(&entry["lengths"]);
    let factors = lengths
        .iter()
        .zip(["A", "B", "C"])
        .map(|(length, name)| Factor {
            name: name.to_owned(),
            levels: (0..*length as usize).map(|level| format!("{name}{level}")).collect(),
        })
        .collect();
    let rows: Vec<Vec<f64>> = entry["values"].as_array().unwrap().iter().map(floats).collect();
    let subjects = (1..=rows.len()).map(|subject| format!("P{subject}")).collect();
    Table::new(factors, subjects, rows.concat()).unwrap()
}

/// What a peer may call an effect's number, and ours.
fn number(effect: &Effect, key: &str) -> f64 {
    let test = effect.test.as_ref().unwrap();
    let mauchly = || *test.mauchly.test().unwrap();
    match key {
        "ss" | "SS" => effect.ss,
        "ss_error" => effect.ss_error,
        "df" => effect.df as f64,
        "df_error" => effect.df_error as f64,
        "f" | "F" => test.f,
        "p" => test.p,
        "gg" | "eps" => test.greenhouse_geisser.epsilon,
        "p_gg" => test.greenhouse_geisser.p,
        "hf" => test.huynh_feldt.unwrap().uncapped,
        "p_hf" => test.huynh_feldt.unwrap().p,
        "w" | "W_spher" => mauchly().w,
        "chi_square" => mauchly().chi_square,
        "p_w" => mauchly().p,
        "p_w_second" => mauchly().p_second_order,
        "partial" => test.partial_eta_squared.estimate,
        "generalised" | "ng2" => effect.generalised_eta_squared.unwrap(),
        other => panic!("{other}"),
    }
}

#[test]
fn analyses_of_variance_agree_with_statsmodels_pingouin_and_car() {
    let numbers = numbers();
    for peer in ["projected", "statsmodels", "pingouin", "car"] {
        let (mut errors, mut limits) = (Errors::below(1e-9), Errors::below(1e-7));
        for entry in entries(&numbers, "anovas") {
            let anova = table(entry).analyse(0.95).unwrap();
            errors.hold("total", anova.ss_total, entry["ss_total"].as_f64().unwrap());
            errors.hold("subjects", anova.ss_subjects, entry["ss_subjects"].as_f64().unwrap());
            let of_peer = entry[peer].as_object().unwrap();
            for (name, theirs) in of_peer {
                let factors: Vec<&str> = name.split(':').collect();
                let effect = anova.effect(&factors).unwrap();
                for (key, value) in theirs.as_object().unwrap() {
                    if key == "lambda" {
                        let ours = effect.test.as_ref().unwrap().partial_eta_squared;
                        let dfs = (effect.df + effect.df_error + 1) as f64;
                        for (end, lambda) in floats(value).into_iter().enumerate() {
                            limits.hold(&format!("{} {name} λ", entry["name"]), ours.noncentrality_ci[end], lambda);
                            limits.hold("η²", ours.ci[end], lambda / (lambda + dfs));
                        }
                        continue;
                    }
                    let value = value.as_f64().unwrap();
                    let mauchly = effect.test.as_ref().unwrap().mauchly;
                    if key == "W_spher" && matches!(mauchly, Mauchly::TooFewSubjects { .. }) {
                        // pingouin gives the singular determinant's rounding error where we give a reason.
                        assert!(value < 1e-9, "{value}");
                        continue;
                    }
                    // pingouin caps Huynh and Feldt's ε at 1, car does not.
                    let ours = number(effect, key);
                    let ours = if peer == "pingouin" && key == "hf" { ours.min(1.0) } else { ours };
                    errors.hold(&format!("{peer}, {}: {name} {key}", entry["name"]), ours, value);
                }
            }
            if peer == "projected" {
                assert_eq!(of_peer.len(), anova.effects.len());
            }
        }
        errors.report(peer);
        if peer == "projected" {
            limits.report("noncentralities");
        }
    }
}

/// The example of pingouin's documentation (its `rm_anova_wide`, subjects with all four values): the figures that its page
/// prints.
#[test]
fn the_documented_example_of_pingouin_comes_out() {
    let numbers = numbers();
    let entry = entries(&numbers, "anovas").iter().find(|entry| entry["name"] == "pingouin's rm_anova_wide").unwrap();
    let anova = table(entry).analyse(0.95).unwrap();
    let effect = anova.effect(&["A"]).unwrap();
    let test = effect.test.as_ref().unwrap();
    assert_eq!((effect.df, effect.df_error), (3, 24));
    assert!((test.f - 5.200_652).abs() < 5e-7, "{}", test.f);
    assert!((test.p - 0.006_557).abs() < 5e-7, "{}", test.p);
    assert!((effect.generalised_eta_squared.unwrap() - 0.346_392).abs() < 5e-7);
    assert!((test.greenhouse_geisser.epsilon - 0.694_329).abs() < 5e-7);
    assert!((test.mauchly.test().unwrap().w - 0.306_78).abs() < 5e-6);
}
