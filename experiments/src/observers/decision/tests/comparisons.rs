//! Comparisons against their closed forms.

use super::*;

/// Shares of "reference", "same" and "test" in a simulated pair comparison.
fn pair_shares(options: Options, visibility: f64, accepts: &[Answer], n: u32) -> [f64; 3] {
    let mut driven = Driven::new(options, 11);
    let delta = crate::observers::expected::delta_from_visibility(visibility);
    let mut counts = [0_u32; 3];
    for index in 0..n {
        let mut order = [Alternative::Reference, Alternative::Test];
        if index % 2 == 0 {
            order.reverse();
        }
        driven.meet(&show(PhaseName::Interval1, order[0]), delta);
        driven.meet(&gap(), 0.0);
        driven.meet(&show(PhaseName::Interval2, order[1]), delta);
        let answer = driven.say(&ask(Asked::WhichBetter, accepts), 0.0);
        let which = match answer {
            Answer::Same => 1,
            answer if order[usize::from(answer == Answer::Second)] == Alternative::Reference => 0,
            _ => 2,
        };
        counts[which] += 1;
        driven.next_trial();
    }
    counts.map(|count| f64::from(count) / f64::from(n))
}

#[test]
fn pair_comparisons_follow_their_closed_form() {
    let n = 6000;
    for (visibility, bias, lapse) in [(0.0, 0.0, 0.02), (0.3, 0.4, 0.0), (0.5, 0.0, 0.05), (0.9, -0.3, 0.1)] {
        let options = Options { bias, lapse, ..Options::default() };
        let expected = options.comparison_shares(visibility);
        let found = pair_shares(options, visibility, &PAIR, n);
        for (share, expected) in found.into_iter().zip([expected.reference, expected.same, expected.test]) {
            within(share, expected, n, &format!("F {visibility} bias {bias} lapse {lapse}"));
        }
        let forced = pair_shares(options, visibility, &PAIR[..2], n);
        within(forced[0], options.probability_correct(visibility), n, "forced");
    }
}

/// A bias for "first" shows in which side is named, whatever was there.
#[test]
fn a_biased_observer_names_the_first_more_often() {
    let mut driven = Driven::new(Options { bias: 0.5, lapse: 0.0, ..Options::default() }, 3);
    let n = 4000;
    let mut first = 0;
    for _ in 0..n {
        driven.meet(&show(PhaseName::Interval1, Alternative::Reference), 0.0);
        driven.meet(&show(PhaseName::Interval2, Alternative::Test), 0.0);
        first += u32::from(driven.say(&ask(Asked::WhichReference, &PAIR[..2]), 0.0) == Answer::First);
        driven.next_trial();
    }
    // Φ(0.5).
    within(f64::from(first) / f64::from(n), 0.691_462, n, "first");
}

#[test]
fn ramps_are_named_by_their_ends() {
    let accepts = [Answer::Increased, Answer::Decreased, Answer::Same];
    let options = Options { bias: 1.0, lapse: 0.04, ..Options::default() };
    let (coarse, fine) = (0.8, 0.2);
    let [right, same, wrong] = options.direction_shares(coarse, fine);
    let delta = crate::observers::expected::delta_from_visibility;
    for rising in [true, false] {
        let mut driven = Driven::new(options, 17);
        let (mut counts, n) = ([0_u32; 3], 4000);
        for _ in 0..n {
            for step in 0..5 {
                let share = f64::from(if rising { step } else { 4 - step }) / 4.0;
                driven
                    .meet(&at(PhaseName::Step, &[("j", share)]), delta(coarse) + share * (delta(fine) - delta(coarse)));
                driven.meet(&gap(), 0.0);
            }
            let answer = driven.say(&ask(Asked::Direction, &accepts), 0.0);
            let which = match answer {
                Answer::Same => 1,
                answer if (answer == Answer::Increased) == rising => 0,
                _ => 2,
            };
            counts[which] += 1;
            driven.next_trial();
        }
        for (count, expected) in counts.into_iter().zip([right, same, wrong]) {
            within(f64::from(count) / f64::from(n), expected, n, "ramp");
        }
    }
}

/// What is hidden for a while and shown again is one stimulus, not two.
#[test]
fn an_interrupted_interval_is_still_the_first() {
    let mut driven = Driven::new(Options { lapse: 0.0, ..Options::default() }, 5);
    for _ in 0..20 {
        for _ in 0..3 {
            driven.meet(&show(PhaseName::Interval1, Alternative::Test), 10.0);
            driven.meet(&Phase::new(PhaseName::Hidden, Presentation::Grey, None), 0.0);
        }
        driven.meet(&show(PhaseName::Interval1, Alternative::Test), 10.0);
        driven.meet(&gap(), 0.0);
        driven.meet(&show(PhaseName::Interval2, Alternative::Reference), 0.0);
        assert_eq!(driven.say(&ask(Asked::WhichDegraded, &PAIR[..2]), 0.0), Answer::First);
        driven.next_trial();
    }
}

#[test]
fn toggled_alternatives_are_looked_at_two_or_three_times_each() {
    let options = Options { lapse: 0.0, ..Options::default() };
    let mut driven = Driven::new(options, 23);
    let (n, delta) = (3000, crate::observers::expected::delta_from_visibility(0.5));
    let mut right = 0;
    for index in 0..n {
        let test_is_a = index % 2 == 0;
        let mut looks = [0_u32; 2];
        let answer = loop {
            let on_b = usize::from(looks[0] > looks[1]);
            let name = [PhaseName::AlternativeA, PhaseName::AlternativeB][on_b];
            let alternative = if (on_b == 0) == test_is_a { Alternative::Test } else { Alternative::Reference };
            looks[on_b] += 1;
            let accepts =
                if looks[1] == 0 { vec![Answer::Switch] } else { vec![Answer::First, Answer::Second, Answer::Switch] };
            let phase = show(name, alternative).asking(Asked::ToggleReference, accepts);
            match driven.say(&phase, delta) {
                Answer::Switch => driven.meet(&gap(), 0.0),
                answer => break answer,
            };
        };
        assert!(looks.iter().all(|looks| (2..=3).contains(looks)), "{looks:?}");
        right += u32::from((answer == Answer::Second) == test_is_a);
        driven.next_trial();
    }
    within(f64::from(right) / f64::from(n), options.probability_correct(0.5), n, "toggled");
}
