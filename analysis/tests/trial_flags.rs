//! Trials flagged under a rule and left out on request.
#![allow(clippy::unwrap_used)]

use analysis::gaze::{GazeError, GazeSample, Target, TrialId, TrialTrace};
use analysis::timing::Frame;
use analysis::timing::exclusion::exclude;
use analysis::timing::flags::{Criterion, FlagRule, flag_trials};

fn id(trial: u32) -> TrialId {
    TrialId { session: "P01".into(), trial }
}

/// One second: fixation until 0.2 s, a stimulus until 0.7 s; 100 Hz of frames, 250 Hz of gaze, all in order.
fn sound(trial: u32, condition: &str) -> TrialTrace {
    TrialTrace {
        id: id(trial),
        condition: condition.into(),
        samples: (0..250)
            .map(|i| GazeSample {
                t_s: f64::from(i) * 0.004,
                position_deg: [0.3, 0.4],
                deviation_deg: 0.5,
                valid: true,
            })
            .collect(),
        frames: (0..100)
            .map(|i| Frame {
                presented_s: f64::from(i) * 0.01 + 0.0005,
                missed: false,
                gaze_age_s: Some(0.012),
                after_gap: i == 0,
            })
            .collect(),
        stimulus_s: vec![[0.2, 0.7]],
        target: Some(Target::Fixed([0.0, 0.0])),
    }
}

fn changed(trial: u32, condition: &str, change: impl Fn(&mut TrialTrace)) -> TrialTrace {
    let mut trace = sound(trial, condition);
    change(&mut trace);
    trace
}

fn traces() -> Vec<TrialTrace> {
    vec![
        sound(0, "near"),
        // Missed frames before the stimulus harm nobody.
        changed(1, "near", |t| t.frames[..20].iter_mut().for_each(|f| f.missed = true)),
        // Three of 50 frames.
        changed(2, "far", |t| t.frames[30..33].iter_mut().for_each(|f| f.missed = true)),
        // Gaze that is too old in four of 50 frames: more than 5 %.
        changed(3, "far", |t| t.frames[40..44].iter_mut().for_each(|f| f.gaze_age_s = Some(0.08))),
        // 120 ms of 500 lost, half of it as invalid samples and half as none.
        changed(4, "near", |t| {
            t.samples[100..115].iter_mut().for_each(|s| s.valid = false);
            t.samples.drain(115..130);
        }),
        changed(5, "far", |t| t.samples.iter_mut().for_each(|s| s.position_deg = [3.0, 0.0])),
        changed(6, "near", |t| {
            t.target = None;
            t.frames.clear();
        }),
        changed(7, "near", |t| t.samples.clear()),
    ]
}

#[test]
fn trials_are_flagged_for_what_happened_during_the_stimulus() {
    let report = flag_trials(&traces(), &FlagRule::suggested()).unwrap();
    let found: Vec<(u32, Vec<Criterion>)> = report
        .flagged
        .iter()
        .map(|trial| (trial.id.trial, trial.reasons.iter().map(|reason| reason.criterion).collect()))
        .collect();
    assert_eq!(
        found,
        [
            (2, vec![Criterion::MissedShare]),
            (3, vec![Criterion::GazeAge]),
            (4, vec![Criterion::GazeLoss]),
            (5, vec![Criterion::Deviation]),
            (7, vec![Criterion::GazeLoss]),
        ]
    );
    let words: Vec<&str> = report.flagged.iter().map(|trial| trial.reasons[0].words.as_str()).collect();
    assert_eq!(
        words,
        [
            "3 of 50 frames (6.0 %) missed while a stimulus was shown; the limit is 5.0 %.",
            "5 % of the stimulus' frames were drawn for gaze older than 80.0 ms; the limit is 50.0 ms.",
            "No valid gaze for 24.0 % of the stimulus' time; the limit is 20.0 %.",
            "The median deviation from the target was 3.00°; the limit is 2°.",
            "No valid gaze for 100.0 % of the stimulus' time; the limit is 20.0 %.",
        ]
    );
    let missing: Vec<(Criterion, Vec<u32>)> =
        report.not_judged.iter().map(|n| (n.criterion, n.trials.iter().map(|id| id.trial).collect())).collect();
    assert_eq!(
        missing,
        [(Criterion::MissedShare, vec![6]), (Criterion::GazeAge, vec![6]), (Criterion::Deviation, vec![6, 7]),]
    );
    // Flagging keeps everything.
    assert_eq!((report.trials.len(), report.rule), (8, FlagRule::suggested()));
    assert_eq!(report.trials[1].all_frames.missed, 20);
    assert_eq!((report.trials[1].missed, report.trials[1].frames), (0, 50));
}

#[test]
fn every_limit_flags_and_none_flags_nothing() {
    let slow = changed(0, "a", |t| {
        t.frames.drain(50..55);
    });
    let nothing = flag_trials(std::slice::from_ref(&slow), &FlagRule::without_limits()).unwrap();
    assert!(nothing.flagged.is_empty() && nothing.not_judged.is_empty() && nothing.rule.in_words().is_empty());
    let rule = FlagRule {
        max_missed_frames: Some(0),
        max_interval_s: Some(0.02),
        max_outside_share: Some(0.5),
        region_deg: 0.4,
        ..FlagRule::without_limits()
    };
    let report = flag_trials(&[slow], &rule).unwrap();
    let criteria: Vec<Criterion> = report.flagged[0].reasons.iter().map(|r| r.criterion).collect();
    assert_eq!(criteria, [Criterion::Interval, Criterion::Outside]);
    assert!((report.flagged[0].reasons[0].found - 0.06).abs() < 1e-9);
    assert_eq!(rule.in_words().len(), 3);
    // At the limit is within it.
    let exact = FlagRule { max_missed_frames: Some(3), ..FlagRule::without_limits() };
    assert!(flag_trials(&traces(), &exact).unwrap().flagged.is_empty());
    let one_less = FlagRule { max_missed_frames: Some(2), ..exact };
    assert_eq!(flag_trials(&traces(), &one_less).unwrap().flagged.len(), 1);
}

#[test]
fn leaving_out_is_a_step_of_its_own_with_a_report() {
    let flags = flag_trials(&traces(), &FlagRule::suggested()).unwrap();
    let answers: Vec<u32> = (0..10).collect();
    let (kept, exclusion) = exclude(answers, |&trial| id(trial), &flags);
    assert_eq!(kept, [0, 1, 6, 8, 9]);
    assert_eq!((exclusion.before, exclusion.kept, exclusion.never_judged), (10, 5, 2));
    assert_eq!(exclusion.words, "5 of 10 trials (50.0 %) were left out. 2 were kept without having been judged.");
    let conditions: Vec<(&str, usize, usize)> =
        exclusion.conditions.iter().map(|c| (c.condition.as_str(), c.before, c.excluded)).collect();
    assert_eq!(conditions, [("near", 5, 2), ("far", 3, 3)]);
    assert_eq!(exclusion.excluded, flags.flagged);
    let text = serde_json::to_string(&exclusion).unwrap();
    assert_eq!(serde_json::from_str::<analysis::timing::exclusion::Exclusion>(&text).unwrap(), exclusion);
}

#[test]
fn a_trial_twice_or_out_of_order_is_an_error() {
    let twice = [sound(3, "a"), sound(3, "a")];
    assert_eq!(
        flag_trials(&twice, &FlagRule::suggested()),
        Err(GazeError::RepeatedTrial { trial: "trial 3 of P01".into() })
    );
    let back = changed(4, "a", |t| t.frames.swap(3, 4));
    let error = flag_trials(&[back], &FlagRule::suggested()).unwrap_err();
    assert!(error.to_string().starts_with("trial 4 of P01: row 4 (from 0)"), "{error}");
    let rule = FlagRule { max_lost_share: Some(f64::NAN), ..FlagRule::suggested() };
    assert!(flag_trials(&[], &rule).unwrap_err().to_string().starts_with("max_lost_share: expected a share"));
}
