//! Whatever the rows hold, the papers' rules neither panic nor give a number that is none.
#![allow(clippy::unwrap_used)]

#[path = "common/rows.rs"]
mod rows;

use analysis::answers::{Protocol, Row};
use analysis::psychometric::Direction;
use analysis::rules::guenter::coarsest_unnoticed;
use analysis::rules::{Bootstrap, FirstPassed, ObserverRows, of_block, stengel, tursun, weier};
use experiments::trial::Answer;
use proptest::prelude::*;
use rows::row;

/// Numbers as a careless table has them.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-4i32..24).prop_map(f64::from),
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY), Just(-0.0), Just(0.0)],
        1 => prop_oneof![Just(f64::MAX), Just(f64::MIN), Just(1e-308), Just(0.5)],
    ]
}

fn some_row() -> impl Strategy<Value = Row> {
    let answer = prop_oneof![
        Just(Answer::First),
        Just(Answer::Second),
        Just(Answer::Same),
        Just(Answer::Increased),
        Just(Answer::Continue),
        Just(Answer::Option(2)),
    ];
    let name = prop_oneof![
        Just("quality_index"),
        Just("quality_index_settled"),
        Just("radius_deg"),
        Just("rate"),
        Just("m"),
        Just("moves"),
        Just("from"),
        Just("to"),
        Just("free-of-artifacts"),
    ];
    let numbers = || proptest::collection::btree_map(name.clone().prop_map(str::to_owned), number(), 0..5);
    let factors = proptest::collection::btree_map(
        prop_oneof![Just("patch"), Just("fixation"), Just("scene")].prop_map(str::to_owned),
        prop_oneof![Just("a"), Just("b"), Just("free")].prop_map(str::to_owned),
        0..3,
    );
    (answer, proptest::option::of(any::<bool>()), numbers(), numbers(), factors)
        .prop_map(|(answer, correct, level, found, factors)| Row { level, found, factors, ..row(answer, correct) })
}

/// JSON writes what is no number as null, and a field that has none is left out: so no null is allowed but where the type
/// has an optional number.
fn numbers_are_finite(value: &serde_json::Value) -> bool {
    match value {
        serde_json::Value::Array(items) => items.iter().all(|item| !item.is_null() && numbers_are_finite(item)),
        serde_json::Value::Object(fields) => fields.values().all(numbers_are_finite),
        _ => true,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn every_rule_survives_any_rows(
        sessions in proptest::collection::vec((0u8..4, proptest::collection::vec(some_row(), 0..25)), 0..5),
        replicates in 0u32..20,
    ) {
        let codes: Vec<String> = sessions.iter().map(|(code, _)| format!("P{code}")).collect();
        let observers: Vec<ObserverRows<'_>> =
            codes.iter().zip(&sessions).map(|(observer, (_, rows))| ObserverRows { observer, rows }).collect();
        let bootstrap = Bootstrap { replicates, seed: 3 };
        for protocol in [
            Protocol::TwoInterval,
            Protocol::Toggle,
            Protocol::Pair,
            Protocol::Ramp,
            Protocol::Slider,
            Protocol::Likert,
            Protocol::Adjustment,
            Protocol::PairedTask,
        ] {
            match of_block("t3-any", protocol, &observers, bootstrap) {
                Ok(result) => {
                    let value = serde_json::to_value(&result).unwrap();
                    prop_assert!(numbers_are_finite(&value), "{protocol:?}: {value}");
                    // What cannot be read back was no number.
                    let again: Result<analysis::rules::RuleResult, _> = serde_json::from_value(value.clone());
                    prop_assert!(again.is_ok(), "{protocol:?}: {again:?} from {value}");
                }
                Err(error) => prop_assert!(!error.to_string().is_empty()),
            }
        }
        if let Ok(table) = weier::long_table("free-of-artifacts", &observers) {
            prop_assert!(table.rows.iter().chain(&table.cell_means().rows).all(|row| row.value.is_finite()));
            prop_assert!(table.missing(5).len() <= 5);
        }
    }

    #[test]
    fn the_rules_threshold_is_a_level_that_was_missed_and_none_coarser_was(
        rows in proptest::collection::vec(some_row(), 0..60),
        falls in any::<bool>(),
    ) {
        let direction = if falls { Direction::Falls } else { Direction::Rises };
        let missed: Vec<f64> = rows
            .iter()
            .filter(|row| row.correct == Some(false) || (row.correct == Some(true) && row.answer == Answer::Same))
            .filter_map(|row| row.level.get("quality_index").copied())
            .filter(|level| level.is_finite())
            .collect();
        let coarsest = if falls {
            missed.iter().copied().min_by(f64::total_cmp)
        } else {
            missed.iter().copied().max_by(f64::total_cmp)
        };
        prop_assert_eq!(coarsest_unnoticed("quality_index", direction, &rows), coarsest);
    }

    #[test]
    fn chances_add_up_to_one(levels in proptest::collection::vec((number(), -0.5f64..1.5), 0..40)) {
        let first = FirstPassed::new(levels);
        let sum: f64 = first.outcomes.iter().map(|passed| passed.probability).sum();
        prop_assert!((sum + first.none - 1.0).abs() < 1e-12);
        prop_assert!(first.outcomes.iter().all(|passed| (0.0..=1.0).contains(&passed.probability)));
    }

    #[test]
    fn tolerated_blur_never_falls_with_eccentricity_and_never_exceeds_what_was_shown(
        detected in proptest::collection::vec(0usize..=10, 9),
    ) {
        let mut rows = Vec::new();
        let pairs = [4.0, 7.0, 11.0].into_iter().flat_map(|r| [0.0017, 0.0035, 0.0052].map(|k| (r, k)));
        for ((radius, rate), k) in pairs.zip(&detected) {
            for i in 0..10 {
                rows.push(rows::with_level(
                    row(Answer::First, Some(i < *k)),
                    &[("radius_deg", radius), ("rate", rate)],
                ));
            }
        }
        let observers = [ObserverRows { observer: "P1", rows: &rows }];
        let found = tursun::tolerances(&observers, &tursun::Options::default()).unwrap();
        let sigma = &found.patches[0].observers[0].sigma_deg;
        prop_assert!(sigma.windows(2).all(|pair| pair[0] <= pair[1]));
        for (sigma, e) in sigma.iter().zip(&found.options.eccentricities_deg) {
            prop_assert!((0.0..=tursun::sigma_deg(4.0, 0.0052, *e)).contains(sigma));
        }
    }

    #[test]
    fn counts_that_print_do_print(percent in 0.0f64..100.0, decimals in 0u32..3, n in 0u32..200) {
        let scale = 10f64.powi(i32::try_from(decimals).unwrap());
        for k in stengel::counts_that_print(percent, decimals, n) {
            let exact = 100.0 * f64::from(k) / f64::from(n.max(1));
            prop_assert!((exact - percent).abs() <= 1.5 / scale + 1e-9);
        }
    }
}

#[test]
fn absurd_values_are_described_as_far_as_they_are_numbers() {
    let rows = [f64::MAX, f64::MAX, f64::MIN].map(|m| rows::with_found(row(Answer::Continue, None), &[("m", m)]));
    for rows in [&rows[..2], &rows[1..], &rows[..1]] {
        let observers = [ObserverRows { observer: "P1", rows }];
        if let Ok(found) = stengel::settings(&observers, &Bootstrap::default()) {
            assert!(found.settings.iter().all(|setting| setting.mean_of_trials.is_finite()));
        }
    }
}
