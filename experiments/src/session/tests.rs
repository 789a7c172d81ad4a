//! The machine as a whole: every trial ends, every level is completed as designed, a journal folds back into itself.

use super::record::Record;
use super::refold::refold;
use super::simulate::simulate;
use super::*;
use crate::mar::MarModel;
use crate::observers::{Options, ParametricObserver, Truth};
use crate::study::plan::*;
use proptest::prelude::*;
use std::collections::BTreeMap;

fn plan(gate: bool) -> Arc<Plan> {
    let level = |e: f64, omega: f64| Level::from([("eccentricity_deg".to_owned(), e), ("mar_deg".to_owned(), omega)]);
    let condition = Condition {
        name: "photo".to_owned(),
        scene: "photo".to_owned(),
        scene_parameters: BTreeMap::new(),
        renderer: "ring".to_owned(),
        renderer_parameters: BTreeMap::new(),
        detail: ring(),
        fixation: Fixation::Cross,
        foveation: FoveationCentre::Gaze,
    };
    let protocol = ProtocolPlan::TwoInterval(TwoIntervalPlan {
        fixation_s: 0.5,
        interval_s: 0.3,
        gap_s: 0.2,
        answer_timeout_s: Some(4.0),
        question: "Which?".to_owned(),
        wanted: Wanted::Degraded,
    });
    let block = |name: &str, practice, levels: Vec<Level>, repetitions| BlockPlan {
        name: name.to_owned(),
        practice,
        instructions: practice.then(|| "Practice.".to_owned()),
        criterion: None,
        cells: vec![Cell { factors: BTreeMap::new(), condition: condition.clone() }],
        protocol: protocol.clone(),
        feedback_s: 0.3,
        procedure: ProcedurePlan::Constant(ConstantPlan { levels, repetitions }),
        presentation_order: PresentationOrder::Random,
        order: OrderPlan::default(),
        breaks: BreakPlan { every_trials: (!practice).then_some(4), every_s: None },
        at_most_trials: None,
        questionnaire: Vec::new(),
    };
    Arc::new(Plan {
        name: "test".to_owned(),
        title: "Test".to_owned(),
        about: String::new(),
        display: Display::named("demo-540p").expect("ships"),
        gaze: GazePlan { fixation_deg: [0.0, 0.0], gate: gate.then_some(GatePlan { radius_deg: 2.0, grace_s: 0.1 }) },
        texts: Texts { instructions: vec!["One.".to_owned(), "Two.".to_owned()], ..Texts::default() },
        blocks: vec![
            block("practice", true, vec![level(5.0, 1.0)], 2),
            block("main", false, vec![level(2.0, 0.1), level(5.0, 0.2), level(9.0, 0.4)], 4),
        ],
        participant: Vec::new(),
        groups: Vec::new(),
        sittings: None,
        pilot: PilotPlan::default(),
    })
}

use crate::catalogue::DetailLaw;
use crate::display::Display;

fn ring() -> DetailLaw {
    DetailLaw::Ring {
        eccentricity: "eccentricity_deg".to_owned(),
        width: "width_deg".to_owned(),
        mar: "mar_deg".to_owned(),
    }
}

fn observer(seed: u64) -> ParametricObserver {
    let model = MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.02 };
    ParametricObserver::new(Truth::Mar(model), Options::default(), seed)
}

#[test]
fn a_simulated_session_runs_to_its_end_with_every_trial_answered() {
    let journal = simulate(&plan(false), 7, &mut observer(7));
    let record = Record::from_events(&journal);
    assert!(record.finished && record.open_trial.is_none());
    assert_eq!(record.trials.len(), 14);
    assert!(record.trials.iter().all(|trial| trial.correct().is_some() && trial.response_time_s.is_some()));
    assert_eq!(record.trials.iter().filter(|trial| trial.trial.practice).count(), 2);
    // Pages: two of instructions, one before practice, a break after 4 and 8 of 12, thanks.
    let pages = journal.iter().filter(|e| matches!(e.event, Event::PhaseBegan { phase: PhaseName::Page, .. })).count();
    assert_eq!(pages, 6);
}

#[test]
fn the_same_seed_gives_the_same_journal_and_another_seed_another() {
    let run = |seed| simulate(&plan(false), seed, &mut observer(seed));
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn a_changed_answer_in_a_journal_is_noticed() {
    let plan = plan(false);
    let mut journal = simulate(&plan, 3, &mut observer(3));
    let at = journal.iter().position(|e| matches!(e.event, Event::TrialEnded { .. })).expect("a trial ends");
    if let Event::TrialEnded { outcome, .. } = &mut journal[at].event {
        *outcome = Outcome::TimedOut;
    }
    let disagreement = refold(plan, 3, &journal, |_, _| {}).expect_err("changed");
    assert_eq!(disagreement.seq, at as u64);
}

/// What a fuzzing world may do next.
fn inputs() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(0u8..16, 0..400)
}

fn input_from(choice: u8) -> Input {
    match choice {
        0..=5 => Input::Elapsed,
        6 | 7 => Input::Answered { answer: Answer::First },
        8 | 9 => Input::Answered { answer: Answer::Second },
        10 => Input::Answered { answer: Answer::Continue },
        11 => Input::GazeLeft,
        12 => Input::Pause,
        13 => Input::Reopened,
        14 => Input::Resume,
        _ => Input::Saved,
    }
}

proptest! {
    /// Early, late and double keys, lost gaze, pauses and restarts: however a session is disturbed, a patient observer
    /// brings it to its end, and each level is completed exactly as often as designed.
    #[test]
    fn disturbed_sessions_still_complete_their_design(choices in inputs(), seed in 0u64..1000) {
        let plan = plan(true);
        let (mut session, first) = Session::begin(Arc::clone(&plan), seed);
        let mut journal = Vec::new();
        let mut t_s = 0.0;
        let mut log = |t_s: f64, events: Vec<Event>| {
            for event in events {
                journal.push(Stamped { seq: journal.len() as u64, t_s, event });
            }
        };
        log(t_s, first);
        for choice in choices {
            t_s += 0.05;
            log(t_s, session.handle(t_s, input_from(choice)));
        }
        let mut patient = observer(seed);
        for _ in 0..2000 {
            let Some(phase) = session.phase() else { break };
            let level = session.shown_level();
            let presented = crate::observers::Presented {
                phase,
                trial: session.trial(),
                condition: session.condition(),
                level: level.as_ref(),
                fixation_deg: [0.0; 2],
                display: &plan.display,
                t_s: session.phase_began_s(),
            };
            let answer = crate::observers::Observer::meet(&mut patient, &presented).answer;
            let input = match answer {
                _ if phase.name == PhaseName::Save => Input::Saved,
                Some((answer, _)) => Input::Answered { answer },
                None => Input::Elapsed,
            };
            t_s += 0.5;
            log(t_s, session.handle(t_s, input));
        }
        prop_assert!(session.finished());

        let record = Record::from_events(&journal);
        prop_assert!(record.finished && record.open_trial.is_none());
        let mut completed: BTreeMap<(String, String), u32> = BTreeMap::new();
        for trial in record.trials.iter().filter(|trial| trial.correct().is_some()) {
            *completed.entry((trial.trial.block.clone(), format!("{:?}", trial.trial.level))).or_default() += 1;
        }
        for ((block, level), n) in &completed {
            let designed = if block == "practice" { 2 } else { 4 };
            prop_assert_eq!(*n, designed, "{} {}", block, level);
        }
        prop_assert_eq!(completed.len(), 4);

        // The journal folds back into the same session, also when it was cut anywhere.
        let whole = refold(Arc::clone(&plan), seed, &journal, |_, _| {}).expect("agrees");
        prop_assert!(whole.session.finished() && whole.missing.is_empty());
        let cut = journal.len() / 2;
        let half = refold(plan, seed, &journal[..cut], |_, _| {}).expect("agrees");
        let resumed: Vec<_> = journal[cut..].iter().map(|e| e.event.clone()).take(half.missing.len()).collect();
        prop_assert_eq!(resumed, half.missing);
    }
}
