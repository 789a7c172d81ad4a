//! Sliders and adjustments: they end, and near the threshold.

use super::*;

/// A slider from 4 to 22 with its reference; returns the level of the first comparison and the one agreed to.
fn slide(driven: &mut Driven, threshold: f64) -> (f64, f64) {
    let seen =
        |j: f64| crate::observers::expected::delta_from_visibility(standard_normal(-3.2897 * (j - threshold) / 6.0));
    let reference = show(PhaseName::Reference, Alternative::Reference).asking(Asked::Match, vec![Answer::Compare]);
    let (mut j, mut first, mut on_reference) = (4.0, None, true);
    for _ in 0..500 {
        if on_reference {
            assert_eq!(driven.say(&reference, 0.0), Answer::Compare);
            on_reference = false;
            continue;
        }
        let mut accepts = vec![Answer::Compare, Answer::Continue];
        if j < 22.0 {
            accepts.push(Answer::Up);
        }
        if j > 4.0 {
            accepts.push(Answer::Down);
        }
        let phase = at(PhaseName::Adjust, &[("j", j)]).asking(Asked::Match, accepts);
        match driven.say(&phase, seen(j)) {
            Answer::Up => j += 1.0,
            Answer::Down => j -= 1.0,
            Answer::Compare => {
                first.get_or_insert(j);
                on_reference = true;
            }
            _ => return (first.expect("compared before agreeing"), j),
        }
    }
    panic!("the slider never ended");
}

fn standard_normal(x: f64) -> f64 {
    crate::mar::standard_normal_cdf(x)
}

#[test]
fn sliders_end_and_follow_the_threshold() {
    let mut means = Vec::new();
    for threshold in [9.0, 13.0, 17.0] {
        let mut driven = Driven::new(Options::default(), 31);
        let n = 300;
        let (mut firsts, mut lasts) = (0.0, 0.0);
        for _ in 0..n {
            let (first, last) = slide(&mut driven, threshold);
            firsts += first / f64::from(n);
            lasts += last / f64::from(n);
            driven.next_trial();
        }
        println!("threshold {threshold}: first comparison at {firsts:.2}, agreed at {lasts:.2}");
        assert!((firsts - threshold).abs() < 3.0, "{threshold}: {firsts}");
        means.push(firsts);
    }
    // Moving the truth by four steps moves the slider by as much.
    for pair in means.windows(2) {
        assert!((pair[1] - pair[0] - 4.0).abs() < 0.7, "{means:?}");
    }
}

/// An observer who sees a difference always, or never, ends all the same.
#[test]
fn sliders_of_extreme_observers_end() {
    for (criterion, j) in [(-5.0, 22.0), (10.0, 4.0)] {
        let mut driven = Driven::new(Options { criterion, ..Options::default() }, 2);
        for _ in 0..20 {
            let (first, _) = slide(&mut driven, 13.0);
            assert!((first - j).abs() < 1.5, "{criterion}: {first}");
            driven.next_trial();
        }
    }
}

/// Adjusts `a` (larger is coarser) and `b` (larger is finer), both 0–20; the difference is the coarser of the two, at
/// threshold at a = 8 and b = 12. Returns where it ended.
fn adjust(driven: &mut Driven, start: [f64; 2]) -> [f64; 2] {
    let excess = |[a, b]: [f64; 2]| (a - 8.0).max(12.0 - b) / 1.5;
    let reference = show(PhaseName::Reference, Alternative::Reference).asking(Asked::Adjust, vec![Answer::Compare]);
    let (mut values, mut selected, mut on_reference) = (start, 0, false);
    for _ in 0..2000 {
        if on_reference {
            assert_eq!(driven.say(&reference, 0.0), Answer::Compare);
            on_reference = false;
            continue;
        }
        let accepts = vec![Answer::Up, Answer::Down, Answer::Select, Answer::Compare, Answer::Continue];
        let phase = at(PhaseName::Adjust, &[("a", values[0]), ("b", values[1])]).asking(Asked::Adjust, accepts);
        let e = excess(values);
        let order = [Alternative::Test, Alternative::Reference];
        let sight = Sight { delta: crate::observers::expected::delta_from_visibility(standard_normal(e)), excess: e };
        let (trial, level) = (trial(driven.trial.trial, order, Level::new()), Level::new());
        let met = Met { trial: &trial, condition: &driven.condition, level: &level, display: &driven.display };
        let (answer, _) = driven.decision.meet(&met.phase(&phase), Some(sight)).answer.expect("asked");
        match answer {
            Answer::Up => values[selected] = (values[selected] + 1.0).min(20.0),
            Answer::Down => values[selected] = (values[selected] - 1.0).max(0.0),
            Answer::Select => selected = 1 - selected,
            Answer::Compare => on_reference = true,
            _ => return values,
        }
    }
    panic!("the adjustment never ended");
}

#[test]
fn adjustments_end_near_the_threshold_from_either_side() {
    for start in [[20.0, 0.0], [0.0, 20.0], [20.0, 20.0], [8.0, 12.0]] {
        let mut driven = Driven::new(Options::default(), 41);
        let (n, mut mean) = (200, [0.0; 2]);
        for _ in 0..n {
            let end = adjust(&mut driven, start);
            mean = [mean[0] + end[0] / f64::from(n), mean[1] + end[1] / f64::from(n)];
            driven.next_trial();
        }
        println!("from {start:?} to {mean:.2?}");
        // No plain difference is left.
        assert!(mean[0] < 10.0 && mean[1] > 10.0, "{start:?}: {mean:?}");
        // What was needlessly fine has become coarser. The second parameter less so: by then the first is near threshold,
        // and what is seen of it keeps the second from going on.
        assert!(mean[0] > 3.0 && mean[1] < 19.0, "{start:?}: {mean:?}");
    }
}
