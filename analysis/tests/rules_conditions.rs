//! Stengel's and Weier's rules on sessions made by hand and on the papers' own numbers; which protocol has which rule.
#![allow(clippy::unwrap_used)]

#[path = "common/rows.rs"]
mod rows;

use analysis::answers::{Protocol, Row};
use analysis::rules::{Bootstrap, ObserverRows, RuleError, RuleResult, of_block, stengel, weier};
use experiments::trial::Answer;
use rows::{clean_pair, names, near, observers, patch, row, slider, with_factors, with_found, with_level};

#[test]
fn stengels_rule_counts_recognised_pictures_only() {
    let trial = |answer, correct| row(answer, Some(correct));
    let rows = [
        vec![trial(Answer::First, true), trial(Answer::Same, false), trial(Answer::Second, false)],
        vec![trial(Answer::Same, false); 3],
        // No right or wrong: no comparison.
        vec![row(Answer::Continue, None)],
    ];
    let names = names(3);
    let of = |task, protocol| stengel::recognised(task, protocol, &observers(&names, &rows), &Bootstrap::default());
    let found = of("t2-free-viewing", Protocol::PairedTask).unwrap();
    assert_eq!((found.recognised.k, found.equal.k, found.reference_worse.k, found.recognised.n), (1, 4, 1, 6));
    assert_eq!(found.over_observers.as_ref().unwrap().values, [1.0 / 3.0, 0.0]);
    near(found.published.as_ref().unwrap().value, 0.111, 1e-12);
    assert!(found.above_guessing.is_none());
    // T3 of the shipped study is a forced choice.
    let toggled = of("t3-toggle", Protocol::Toggle).unwrap();
    assert_eq!(toggled.above_guessing, Some(0.0));
    assert!(toggled.published.unwrap().caveats.iter().any(|caveat| caveat.contains("guessing recognises half")));
    for unknown in ["t7", "main", "", "t12-x", "ü"] {
        assert!(of(unknown, Protocol::PairedTask).unwrap().published.is_none(), "{unknown}");
    }
}

/// Of the printed percentages only T1's 87.5 % can be a count of 16 observers' three comparisons each; the others have
/// some other, unprinted denominator.
#[test]
fn most_published_shares_are_no_counts_of_the_published_design() {
    assert_eq!(stengel::counts_that_print(12.5, 1, 48), [6]);
    for (percent, n) in [(11.1, 48), (26.6, 16), (12.2, 48), (6.7, 48), (20.2, 48)] {
        assert!(stengel::counts_that_print(percent, 1, n).is_empty(), "{percent} of {n}");
    }
    // 3/45 and 12/45 would do (the latter cut off), with 15 observers.
    assert_eq!(stengel::counts_that_print(6.7, 1, 45), [3]);
    assert_eq!(stengel::counts_that_print(26.6, 1, 45), [12]);
    assert!(stengel::counts_that_print(50.0, 1, 0).is_empty());
}

#[test]
fn stengels_settings_are_means_with_what_the_start_does() {
    let trial = |start: f64, scene, m: f64| {
        let found = [("m", m), ("omega0_deg", 0.02), ("moves", 9.0), ("comparisons", 2.0)];
        with_factors(with_level(with_found(row(Answer::Continue, None), &found), &[("m", start)]), &[("scene", scene)])
    };
    let rows = [
        vec![trial(0.005, "cup", 0.01), trial(0.12, "cup", 0.04)],
        vec![trial(0.005, "cup", 0.02), trial(0.12, "flight", 0.02)],
        vec![trial(0.005, "cup", 0.03)],
    ];
    let names = names(3);
    let found = stengel::settings(&observers(&names, &rows), &Bootstrap::default()).unwrap();
    let all = &found.settings[0];
    assert_eq!((all.parameter.as_str(), all.trials, all.by.len()), ("m", 5, 0));
    near(all.mean_of_trials, 0.024, 1e-12);
    // Observers' means 0.025, 0.02, 0.03; geometric means 0.02, 0.02, 0.03.
    near(all.over_observers.mean, 0.025, 1e-12);
    near(all.geometric_mean.unwrap(), (0.02f64 * 0.02 * 0.03).cbrt(), 1e-12);
    let [low, high] = all.geometric_ci95.unwrap();
    assert!(low > 0.0 && low < 0.0229 && high > 0.0229);
    assert!(found.settings.iter().all(|setting| setting.parameter != "moves"));
    let low_start =
        found.settings.iter().find(|s| s.parameter == "m" && s.by.get("start m").is_some_and(|l| l == "0.005"));
    near(low_start.unwrap().mean_of_trials, 0.02, 1e-12);
    let effect = found.start_effects.iter().find(|effect| effect.parameter == "m").unwrap();
    // P01: 0.04 − 0.01; P02: 0; P03 has no high start.
    assert_eq!(effect.starts, [0.005, 0.12]);
    near(effect.difference.mean, 0.015, 1e-12);
    assert_eq!(effect.difference.n, 2);
    // omega0 never moved: no interval of no width.
    let omega0 = found.settings.iter().find(|s| s.parameter == "omega0_deg").unwrap();
    assert!(omega0.over_observers.no_interval.is_some() && omega0.geometric_ci95.is_none());
    assert_eq!(found.published.len(), 4);
}

fn rated(scene: &str, region: &str, fixation: &str, steps: [f64; 2]) -> Row {
    let found = [("free-of-artifacts", steps[0]), ("confident", steps[1])];
    let row = with_found(row(Answer::Option(1), None), &found);
    with_factors(row, &[("scene", scene), ("region", region), ("fixation", fixation)])
}

#[test]
fn weiers_rule_gives_mean_sd_median_and_tendencies_by_condition() {
    let rows = [
        vec![
            rated("flight", "small", "free", [-2.0, 1.0]),
            rated("flight", "full", "free", [3.0, 1.0]),
            rated("flight", "small", "moving", [0.0, 2.0]),
            // A questionnaire's fraction is no rating.
            rated("noise", "full", "moving", [0.5, 2.0]),
        ],
        vec![rated("flight", "small", "free", [1.0, 3.0])],
    ];
    let names = names(2);
    let observers = observers(&names, &rows);
    let found = weier::ratings(&observers, &Bootstrap::default()).unwrap();
    let item = |name: &str| found.items.iter().find(|item| item.item == name).unwrap();
    let condition = |name: &str, by: &[(&str, &str)]| {
        let is = |c: &&weier::Condition| {
            c.by.len() == by.len() && by.iter().all(|(f, l)| c.by.get(*f).is_some_and(|x| x == l))
        };
        item(name).conditions.iter().find(is).unwrap().clone()
    };
    let all = condition("free-of-artifacts", &[]);
    // −2, 3, 0, 1: mean ½, SD √(13/3), median ½.
    assert_eq!((all.n, all.mean, all.median), (4, 0.5, 0.5));
    near(all.sd.unwrap(), (13.0f64 / 3.0).sqrt(), 1e-12);
    assert_eq!((all.disagree.k, all.neutral.k, all.agree.k), (1, 1, 2));
    // Observers' means 1/3 and 1.
    near(all.over_observers.mean, 2.0 / 3.0, 1e-12);
    let free = condition("free-of-artifacts", &[("fixation", "free")]);
    let published = free.published.unwrap();
    assert_eq!((free.n, published.value, published.sd), (3, 0.43, Some(1.89)));
    assert_eq!(condition("free-of-artifacts", &[("fixation", "moving")]).published.unwrap().value, 0.99);
    assert_eq!(condition("confident", &[]).published.unwrap().sd, Some(1.14));
    let cell = condition("free-of-artifacts", &[("scene", "flight"), ("region", "small"), ("fixation", "free")]);
    assert_eq!((cell.n, cell.mean, cell.published), (2, -0.5, None));

    let table = weier::long_table("free-of-artifacts", &observers).unwrap();
    assert_eq!((table.rows.len(), table.subjects()), (4, vec!["P01", "P02"]));
    // All ratings that count are of one scene, which is then no factor.
    assert_eq!(table.levels().keys().copied().collect::<Vec<_>>(), ["fixation", "region"]);
    assert_eq!(table.missing(99).len(), 8 - 4);
    assert!(weier::long_table("loud", &observers).is_err());
}

/// The paper prints no degrees of freedom; its p of fixation tells the error term.
#[test]
fn the_published_p_of_fixation_is_that_of_independent_trials() {
    use statrs::distribution::{ContinuousCDF, FisherSnedecor};
    let effects = weier::published_effects();
    let fixation = effects.iter().find(|effect| effect.effect == "fixation").unwrap();
    let p = |error| FisherSnedecor::new(f64::from(fixation.df), error).unwrap().sf(fixation.f);
    // 1440 trials less 48 cells; 2 × 14 for 15 subjects.
    near(p(1392.0), 0.0317, 1e-4);
    near(p(28.0), 0.0454, 1e-4);
    let interaction = effects.iter().find(|effect| effect.df == 9).unwrap();
    assert!(FisherSnedecor::new(9.0, 126.0).unwrap().sf(interaction.f) < 0.005);
}

#[test]
fn each_protocol_has_its_papers_rule_and_what_fits_none_says_so() {
    let pairs = clean_pair(15.0);
    let toggled = patch("a", &[(4.0, 0.0017, 5)]);
    let plain = vec![row(Answer::First, Some(true))];
    let adjusted = vec![with_found(row(Answer::Continue, None), &[("m", 0.02)])];
    let ratings = vec![rated("a", "b", "c", [1.0, 2.0])];
    let of = |protocol, rows: &[Row]| {
        of_block("t1", protocol, &[ObserverRows { observer: "P1", rows }], Bootstrap::default())
    };
    assert!(matches!(of(Protocol::Pair, &pairs), Ok(RuleResult::Guenter(_))));
    assert!(matches!(of(Protocol::Ramp, &pairs), Ok(RuleResult::Guenter(_))));
    assert!(matches!(of(Protocol::Slider, &[slider(9.0, 9.0)]), Ok(RuleResult::Guenter(_))));
    assert!(matches!(of(Protocol::Toggle, &toggled), Ok(RuleResult::Tursun(_))));
    assert!(matches!(of(Protocol::Toggle, &plain), Ok(RuleResult::StengelTask(_))));
    assert!(matches!(of(Protocol::PairedTask, &plain), Ok(RuleResult::StengelTask(_))));
    assert!(matches!(of(Protocol::Adjustment, &adjusted), Ok(RuleResult::StengelSettings(_))));
    assert!(matches!(of(Protocol::Likert, &ratings), Ok(RuleResult::Weier(_))));
    assert!(matches!(of(Protocol::TwoInterval, &plain), Err(RuleError::NoRule { .. })));
    for protocol in [
        Protocol::Pair,
        Protocol::Slider,
        Protocol::Toggle,
        Protocol::PairedTask,
        Protocol::Adjustment,
        Protocol::Likert,
    ] {
        let nothing = of(protocol, &[]);
        assert!(matches!(&nothing, Err(RuleError::NothingToJudge { trials: 0, observers: 1, .. })), "{nothing:?}");
        let text = nothing.unwrap_err().to_string();
        assert!(text.contains("expected trials with") && text.contains("0 trial(s)"), "{text}");
    }
}

#[test]
fn results_survive_json() {
    let names = names(2);
    let pairs = [clean_pair(15.0), clean_pair(99.0)];
    let toggled = [patch("a", &[(4.0, 0.0017, 5)]), patch("b", &[(4.0, 0.0052, 9)])];
    let ratings = [vec![rated("a", "b", "c", [1.0, 2.0])], vec![rated("a", "b", "d", [-1.0, 2.0])]];
    let adjusted = [
        vec![with_found(row(Answer::Continue, None), &[("m", 0.02)])],
        vec![with_found(row(Answer::Continue, None), &[("m", 0.03)])],
    ];
    for (protocol, rows) in [
        (Protocol::Pair, &pairs),
        (Protocol::PairedTask, &pairs),
        (Protocol::Toggle, &toggled),
        (Protocol::Likert, &ratings),
        (Protocol::Adjustment, &adjusted),
    ] {
        let result = of_block("t1", protocol, &observers(&names, rows), Bootstrap::default()).unwrap();
        let text = serde_json::to_string(&result).unwrap();
        let again: RuleResult = serde_json::from_str(&text).unwrap();
        assert_eq!(serde_json::to_value(&again).unwrap(), serde_json::to_value(&result).unwrap(), "{protocol:?}");
    }
}
