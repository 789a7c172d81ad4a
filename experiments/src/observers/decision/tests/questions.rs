//! Ratings, forms, pages, eyes, times.

use super::*;

#[test]
fn agreement_falls_with_the_difference_and_confidence_fits_its_scale() {
    let rate = |delta: f64, accepts: &[Answer]| {
        let mut driven = Driven::new(Options { lapse: 0.0, ..Options::default() }, 53);
        let (n, mut sum, mut sure) = (1000, 0.0, 0.0);
        for _ in 0..n {
            driven.meet(&show(PhaseName::Sequence, Alternative::Test), delta);
            for total in [&mut sum, &mut sure] {
                let Answer::Option(value) = driven.say(&ask(Asked::Agreement, accepts), 0.0) else { panic!("a step") };
                *total += f64::from(value) / f64::from(n);
            }
            driven.next_trial();
        }
        (sum, sure)
    };
    let seven: Vec<Answer> = (-3..=3).map(Answer::Option).collect();
    let rated = [0.0, 0.95, 2.0, 4.0, 8.0].map(|delta| rate(delta, &seven));
    println!("{rated:.2?}");
    assert!(rated.windows(2).all(|pair| pair[0].0 > pair[1].0));
    assert!(rated[0].0 > 2.3 && rated[4].0 < -2.9);
    // Far beyond the last threshold one is sure.
    assert!(rated[4].1 > 2.9 && rated[2].1 < 1.0);
    let five: Vec<Answer> = (1..=5).map(Answer::Option).collect();
    let (low, high) = (rate(8.0, &five).0, rate(0.0, &five).0);
    assert!(low < 1.1 && high > 4.5, "{low} {high}");
    // An undisturbed sequence gets full agreement from Φ(0.5) of looks.
    let mut driven = Driven::new(Options { lapse: 0.0, ..Options::default() }, 59);
    let n = 3000;
    let mut full = 0;
    for _ in 0..n {
        driven.meet(&show(PhaseName::Sequence, Alternative::Reference), 0.0);
        full += u32::from(driven.say(&ask(Asked::Agreement, &seven), 0.0) == Answer::Option(3));
        driven.next_trial();
    }
    within(f64::from(full) / f64::from(n), 0.691_462, n, "full agreement");
}

/// The lab's own form machine is filled in, whatever it asks.
#[test]
fn forms_are_filled_in() {
    use crate::study::plan::{Item, ItemKind};
    use crate::trial::form::{Entry, Form};
    let number = |min, max, whole| ItemKind::Number { min, max, unit: "years".to_owned(), whole };
    let scale = |low, high| ItemKind::Scale { low, high, low_anchor: "no".to_owned(), high_anchor: "yes".to_owned() };
    let kinds = [
        number(18.0, 99.0, true),
        number(0.31, 0.33, false),
        number(-3.0, -2.0, false),
        number(100_000.0, 100_001.0, true),
        ItemKind::Text { max_length: 3 },
        ItemKind::Choice { options: vec!["a".to_owned(), "b".to_owned()] },
        scale(-3, 3),
        scale(0, 1),
    ];
    let items: Vec<Item> = (kinds.into_iter().enumerate())
        .map(|(index, kind)| Item { name: format!("i{index}"), question: format!("Question {index}?"), kind })
        .collect();
    let mut form = Form::new(&items);
    let mut driven = Driven::new(Options::default(), 61);
    let mut keys = 0;
    while let Some(phase) = form.phase() {
        form.take(driven.say(&phase, 0.0));
        keys += 1;
        assert!(keys < 300, "{:?}", form.entries());
    }
    assert_eq!(form.entries().len(), items.len());
    assert_eq!(form.entries()["i0"], Entry::Number(59.0));
    assert_eq!(form.entries()["i4"], Entry::Text("sim".to_owned()));
    assert_eq!(form.entries()["i5"], Entry::Number(1.0));
}

/// The same question after each of two sequences gets each sequence's own count.
#[test]
fn spheres_are_counted_in_the_sequence_before_the_question() {
    use crate::marks::Spheres;
    use crate::study::plan::{Item, ItemKind};
    use crate::trial::form::{Entry, Form};
    let mut driven = Driven::new(Options::default(), 67);
    for count in [12, 7] {
        let spheres = Some(Spheres { seed: 1, count, sequence_s: 8.0 });
        let stimulus = Stimulus { spheres, ..Stimulus::new(Alternative::Test) };
        driven.meet(&Phase::new(PhaseName::Sequence, Presentation::Stimulus(stimulus), Some(8.0)), 0.0);
        driven.meet(&Phase::new(PhaseName::Marker, Presentation::Fixation, Some(1.0)), 0.0);
        let kind = ItemKind::Number { min: 0.0, max: 99.0, unit: String::new(), whole: true };
        let mut form = Form::new(&[Item { name: "n".to_owned(), question: "How many?".to_owned(), kind }]);
        while let Some(phase) = form.phase() {
            form.take(driven.say(&phase, 0.0));
        }
        assert_eq!(form.entries()["n"], Entry::Number(f64::from(count)));
    }
}

#[test]
fn consent_is_given_and_pages_are_turned() {
    let mut driven = Driven::new(Options::default(), 71);
    let consent = Phase::new(PhaseName::Consent, Presentation::Text("Do you?".to_owned()), None)
        .asking(Asked::Consent, vec![Answer::First, Answer::Second]);
    assert_eq!(driven.say(&consent, 0.0), Answer::First);
    let page = Phase::new(PhaseName::Page, Presentation::Text("Read.".to_owned()), None);
    assert_eq!(driven.meet(&page, 0.0).answer, Some((Answer::Continue, 1.0)));
    let task = Phase {
        accepts: vec![Answer::Continue],
        ..Phase::new(PhaseName::Task, Presentation::Text("Count.".to_owned()), None)
    };
    assert_eq!(driven.meet(&task, 0.0).answer, Some((Answer::Continue, 1.0)));
    assert_eq!(driven.meet(&gap(), 0.0).answer, None);
}

#[test]
fn eyes_go_where_the_condition_lets_them() {
    use crate::study::plan::MovingTarget;
    let target = MovingTarget { speed_deg_s: 5.0, reach_deg: [10.0, 5.0], diameter_deg: 1.0 };
    let mut driven = Driven::new(Options::default(), 73);
    let shown = show(PhaseName::Sequence, Alternative::Test);
    for (fixation, expected) in [
        (Fixation::Cross, Look::At([0.0; 2])),
        (Fixation::Moving(target), Look::Target),
        (Fixation::Free, Look::Around),
    ] {
        driven.condition.fixation = fixation;
        assert_eq!(driven.meet(&shown, 0.0).look, expected);
        assert_eq!(driven.meet(&gap(), 0.0).look, Look::At([0.0; 2]));
    }
}

#[test]
fn hard_decisions_take_longer_and_tired_observers_lapse_more() {
    let mean_s = |delta: f64| {
        let mut driven = Driven::new(Options::default(), 79);
        let mut sum = 0.0;
        for _ in 0..500 {
            driven.meet(&show(PhaseName::Interval1, Alternative::Test), delta);
            driven.meet(&show(PhaseName::Interval2, Alternative::Reference), 0.0);
            sum += driven.meet(&ask(Asked::WhichDegraded, &PAIR[..2]), 0.0).answer.expect("asked").1;
            driven.next_trial();
        }
        sum / 500.0
    };
    let (hard, easy) = (mean_s(0.0), mean_s(6.0));
    // The mean of a log-normal is its median times exp(σ²/2) = 1.046.
    assert!((hard / 1.1 / 1.046 - 1.0).abs() < 0.08 && (easy / 0.55 / 1.046 - 1.0).abs() < 0.08, "{hard} {easy}");
    let options = Options { lapse: 0.02, fatigue: 0.1, ..Options::default() };
    assert!((options.lapse_at(1800.0) - 0.07).abs() < 1e-12);
    assert!((options.lapse_at(1e9) - 0.5).abs() < 1e-12);
}

/// A journal is folded again without pictures: what was seen must not change how many numbers are drawn.
#[test]
fn what_was_seen_does_not_shift_later_answers() {
    let run = |delta: f64| {
        let mut driven = Driven::new(Options::default(), 83);
        for _ in 0..50 {
            driven.meet(&show(PhaseName::Interval1, Alternative::Test), delta);
            driven.say(&ask(Asked::WhichBetter, &PAIR), 0.0);
            let adjust = at(PhaseName::Adjust, &[("a", 1.0)]).asking(Asked::Adjust, vec![Answer::Up, Answer::Continue]);
            driven.say(&adjust, delta);
            driven.next_trial();
        }
        driven.decision.rng.next_u64()
    };
    assert_eq!(run(0.0), run(7.0));
}
