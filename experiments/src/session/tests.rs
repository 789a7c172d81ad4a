//! The machine as a whole: every trial ends, every level is completed as designed, a journal folds back into itself.

use super::record::{self, Record};
use super::refold::{refold, seam_at};
use super::simulate::simulate;
use super::*;
use crate::design::assignment::Assignment;
use crate::mar::MarModel;
use crate::observers::rejoin::presented;
use crate::observers::{Observer, Options, ParametricObserver, Rejoin, Truth};
use crate::study::plan::*;
use crate::trial::{Alternative, Trouble};
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
        files: Vec::new(),
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
    let truth = Truth::Mar(MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.02 });
    ParametricObserver::new(truth, Options::default(), seed)
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

/// A study of one block as JSON, drawn by proptest.
#[derive(Debug, Clone)]
struct Drawn {
    protocol: usize,
    scenes: usize,
    nested: bool,
    repetitions: u32,
    presentation: usize,
    order: usize,
    gate: bool,
    pages: bool,
    criterion: bool,
    breaks: bool,
}

/// Protocols with the levels that they need.
const PROTOCOLS: [(&str, &str); 9] = [
    (
        r#"{ "kind": "two-interval", "fixation_s": 0.5, "interval_s": 0.3, "gap_s": 0.2, "answer_timeout_s": 4 }"#,
        LEVELS,
    ),
    (
        r#"{ "kind": "two-interval", "fixation_s": 0.5, "interval_s": 0.3, "gap_s": 0.2, "asks_for": "reference" }"#,
        LEVELS,
    ),
    (r#"{ "kind": "toggle", "fixation_s": 0.4, "switch_s": 0.2 }"#, LEVELS),
    (r#"{ "kind": "pair", "sequence_s": 2, "black_s": 0.5, "answer_timeout_s": 4 }"#, LEVELS),
    (
        r#"{ "kind": "ramp", "parameter": "mar_deg", "from": 0.3, "steps": 3, "step_s": 1, "black_s": 0.2, "finer": "down" }"#,
        LEVELS,
    ),
    (r#"{ "kind": "slider", "parameter": "mar_deg", "values": [3, 2, 1, 0.5], "reference_s": 1, "compare_s": 1 }"#, ""),
    (
        r#"{ "kind": "likert", "sequence_s": 2, "items": [
             { "kind": "scale", "name": "good", "question": "Good?" },
             { "kind": "number", "name": "many", "question": "How many?", "min": 0, "max": 99 } ] }"#,
        "",
    ),
    (
        r#"{ "kind": "adjustment", "parameters": [
             { "parameter": "mar_deg", "min": 0.3, "max": 3, "multiply": 1.3 },
             { "parameter": "width_deg", "min": 1, "max": 8, "add": 1 } ] }"#,
        LEVELS,
    ),
    (
        r#"{ "kind": "paired-task", "sequence_s": 2, "marker_s": 0.5,
             "task": { "kind": "count", "instructions": "Count.", "question": "How many?", "min": 2, "max": 5 } }"#,
        LEVELS,
    ),
];
const LEVELS: &str = r#""levels": { "mar_deg": [0.5, 1.5] },"#;

impl Drawn {
    fn text(&self) -> String {
        let (protocol, levels) = PROTOCOLS[self.protocol];
        let scenes = [
            r#"{ "name": "coffee", "scene_parameters": { "image": "coffee" } }"#,
            r#"{ "name": "grass", "scene_parameters": { "image": "grass" }, "fixation": { "kind": "moving" } }"#,
            r#"{ "name": "noise", "scene": "noise", "fixation": { "kind": "free" } }"#,
        ];
        let mut factors = format!(r#"{{ "name": "scene", "levels": [{}] }}"#, scenes[..self.scenes].join(","));
        if self.nested {
            factors += r#", { "name": "size", "levels": [
                { "name": "small", "within": { "scene": ["coffee"] }, "scene_parameters": { "scale": 1 } },
                { "name": "large", "within": { "scene": ["coffee"] }, "scene_parameters": { "scale": 2 } } ] }"#;
        }
        // Sliders, ratings and adjustments have no order.
        let ordered = !matches!(self.protocol, 5..=7);
        let presentation =
            ["random", "both", "reference-first", "test-first"][if ordered { self.presentation } else { 0 }];
        let order = [
            "{}",
            r#"{ "grouped_by": ["scene"] }"#,
            r#"{ "shuffled": false }"#,
            r#"{ "grouped_by": ["scene"], "groups": "latin-square", "shuffled": false }"#,
        ][self.order];
        let gate = if self.gate { r#""gaze": { "gate_deg": 2 },"# } else { "" };
        let (consent, participant, questionnaire) = if self.pages {
            (
                r#""consent": "Do you agree?","#,
                r#""participant": [{ "kind": "text", "name": "hand", "question": "Which hand?", "max_length": 9 }],"#,
                r#", "questionnaire": [{ "kind": "scale", "name": "tired", "question": "Tired?" }]"#,
            )
        } else {
            ("", "", "")
        };
        let practice = if self.criterion {
            format!(
                r#"{{ "name": "practice", "practice": true, "criterion": {{ "share_correct": 0.6, "max_rounds": 2 }},
                     "condition": "photo", "protocol": {},
                     "procedure": {{ "kind": "constant", {LEVELS} "repetitions": 1 }} }},"#,
                PROTOCOLS[0].0
            )
        } else {
            String::new()
        };
        let breaks = if self.breaks { r#""break_every_trials": 2, "break_every_minutes": 0.2,"# } else { "" };
        format!(
            r#"{{ "format": 1, "name": "drawn", "title": "Drawn", "display": "tursun-2019-27in", {gate} {participant}
                 "texts": {{ {consent} "instructions": ["One."] }},
                 "conditions": {{ "photo": {{ "scene": "photo", "renderer": "ring" }} }},
                 "blocks": [ {practice}
                   {{ "name": "main", "condition": "photo", "factors": [{factors}], "unbalanced": true, {breaks}
                     "presentation": "{presentation}", "order": {order}, "protocol": {protocol},
                     "procedure": {{ "kind": "constant", {levels} "repetitions": {} }} {questionnaire} }} ] }}"#,
            self.repetitions
        )
    }

    fn plan(&self, number: u32) -> Plan {
        let plan = crate::study::tests::parse(&self.text()).unwrap_or_else(|mistakes| panic!("{mistakes}"));
        plan.assigned(&Assignment { number, ..Assignment::default() }).expect("fits")
    }
}

fn studies() -> impl Strategy<Value = Drawn> {
    let design = (0..PROTOCOLS.len(), 1usize..4, any::<bool>(), 1u32..3, 0usize..4, 0usize..4);
    let frame = (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>());
    (design, frame).prop_map(
        |((protocol, scenes, nested, repetitions, presentation, order), (gate, pages, criterion, breaks))| Drawn {
            protocol,
            scenes,
            nested,
            repetitions,
            presentation,
            order,
            gate,
            pages,
            criterion,
            breaks,
        },
    )
}

/// What a disturbing world may do next: keys at any time, time that is up, gaze that leaves and returns, pauses, restarts.
fn disturbances() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(0u8..33, 0..300)
}

fn disturbance(choice: u8) -> Input {
    let answered = |answer| Input::Answered { answer };
    match choice {
        0..=7 => Input::Elapsed,
        8 | 9 => answered(Answer::First),
        10 => answered(Answer::Second),
        11 => answered(Answer::Same),
        12 => answered(Answer::Increased),
        13 => answered(Answer::Decreased),
        14 | 15 => answered(Answer::Continue),
        16 => answered(Answer::Up),
        17 => answered(Answer::Down),
        18 | 19 => answered(Answer::Compare),
        20 | 21 => answered(Answer::Switch),
        22 => answered(Answer::Select),
        23 => answered(Answer::Option(1)),
        24 => answered(Answer::Typed('4')),
        25 => answered(Answer::Erase),
        26 => Input::GazeLeft,
        27 => Input::GazeReturned,
        28 => Input::Pause,
        29 => Input::Reopened,
        30 => Input::Resume,
        31 => Input::Unsaved { trouble: Trouble::Full },
        _ => Input::Saved,
    }
}

/// Somebody who does what is asked, one thing after the other.
fn patiently(phase: &Phase, turn: usize) -> Input {
    let answered = |answer| Input::Answered { answer };
    if phase.name == PhaseName::Save {
        return Input::Saved;
    }
    if phase.gaze == GazeRule::AwaitReturn {
        return Input::GazeReturned;
    }
    if phase.typing.is_some() {
        return answered(if turn.is_multiple_of(2) { Answer::Typed('4') } else { Answer::Continue });
    }
    if phase.asked == Some(Asked::Consent) {
        return answered(Answer::First);
    }
    let ends = |answer: &Answer| !matches!(answer, Answer::Switch | Answer::Compare | Answer::Select);
    let fitting: Vec<Answer> = phase.accepts.iter().copied().filter(ends).collect();
    match (fitting.len(), phase.accepts.first()) {
        (0, Some(&only)) => answered(only),
        (0, None) => Input::Elapsed,
        // Reference and hidden phases go on by themselves; everything else takes one of its answers in turn.
        (n, _) => answered(fitting[turn % n]),
    }
}

/// Runs a disturbed session to its end and returns its journal.
fn disturbed(plan: &Arc<Plan>, seed: u64, choices: &[u8]) -> (bool, Vec<Stamped>) {
    let (mut session, first) = Session::begin(Arc::clone(plan), seed);
    let mut journal: Vec<Stamped> = Vec::new();
    let mut log = |t_s: f64, events: Vec<Event>| {
        for event in events {
            journal.push(Stamped { seq: journal.len() as u64, t_s, event });
        }
    };
    log(0.0, first);
    let mut t_s = 0.0;
    for &choice in choices {
        // Who declines ends the session, which is tested elsewhere.
        let asked_consent = session.phase().is_some_and(|phase| phase.asked == Some(Asked::Consent));
        let input = disturbance(choice);
        if asked_consent && input == (Input::Answered { answer: Answer::Second }) {
            continue;
        }
        t_s += 0.05;
        log(t_s, session.handle(t_s, input));
    }
    for turn in 0..20_000 {
        let Some(phase) = session.phase() else { break };
        let input = patiently(phase, turn);
        t_s += 0.5;
        log(t_s, session.handle(t_s, input));
    }
    (session.finished(), journal)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    /// Whatever the study, and however its session is disturbed (early, late and double keys, gaze that leaves, pauses,
    /// restarts), a patient observer brings it to its end; each condition is completed exactly as often as designed; the
    /// same inputs give the same journal, byte for byte; and the journal folds back into the same session, cut anywhere.
    #[test]
    fn disturbed_sessions_of_any_study_complete_their_design(
        drawn in studies(), choices in disturbances(), seed in 0u64..1000, number in 0u32..4,
    ) {
        let plan = Arc::new(drawn.plan(number));
        let (finished, journal) = disturbed(&plan, seed, &choices);
        prop_assert!(finished, "{}", drawn.text());

        let record = Record::from_events(&journal);
        prop_assert!(record.finished && record.open_trial.is_none());
        let block = plan.blocks.last().expect("a block");
        let answered = |record: &&record::TrialRecord| {
            matches!(record.outcome, Outcome::Answered { .. }) && !record.trial.practice
        };
        let mut counts: BTreeMap<(String, String), (u32, u32)> = BTreeMap::new();
        for trial in record.trials.iter().filter(answered) {
            let count = counts.entry((trial.trial.condition.clone(), format!("{:?}", trial.trial.level))).or_default();
            count.0 += 1;
            count.1 += u32::from(trial.trial.order[0] == Alternative::Test);
        }
        let ProcedurePlan::Constant(constant) = &block.procedure else { panic!("constant") };
        let designed = constant.repetitions * block.orders();
        prop_assert_eq!(counts.len(), block.cells.len() * constant.levels.len());
        for ((condition, level), (count, test_first)) in &counts {
            prop_assert_eq!(*count, designed, "{} {}", condition, level);
            if block.presentation_order == PresentationOrder::Both {
                prop_assert_eq!(2 * test_first, *count, "{} {}", condition, level);
            }
        }

        let bytes = |journal: &[Stamped]| serde_json::to_string(journal).expect("a journal");
        let (_, again) = disturbed(&plan, seed, &choices);
        prop_assert_eq!(bytes(&journal), bytes(&again));

        let whole = refold(Arc::clone(&plan), seed, &journal, |_, _| {}).expect("agrees");
        prop_assert!(whole.session.finished() && whole.missing.is_empty());
        let cut = journal.len() * (seed as usize % 7) / 7;
        let part = refold(plan, seed, &journal[..cut], |_, _| {}).expect("agrees");
        let rest: Vec<_> = journal[cut..].iter().map(|e| e.event.clone()).take(part.missing.len()).collect();
        prop_assert_eq!(rest, part.missing);
    }
}

#[test]
fn who_does_not_agree_is_asked_nothing() {
    let drawn = Drawn {
        protocol: 0,
        scenes: 1,
        nested: false,
        repetitions: 1,
        presentation: 0,
        order: 0,
        gate: false,
        pages: true,
        criterion: false,
        breaks: false,
    };
    let (mut session, _) = Session::begin(Arc::new(drawn.plan(0)), 1);
    let asked = session.phase().expect("a page").asked;
    assert_eq!(asked, Some(Asked::Consent));
    let events = session.handle(1.0, Input::Answered { answer: Answer::Second });
    assert!(session.finished());
    assert_eq!(events.last(), Some(&Event::Ended { reason: EndReason::Declined }));
}

/// Practice that is not passed comes again, at most as often as the study says.
#[test]
fn practice_is_repeated_until_it_is_passed() {
    let drawn = Drawn {
        protocol: 0,
        scenes: 1,
        nested: false,
        repetitions: 1,
        presentation: 2,
        order: 0,
        gate: false,
        pages: false,
        criterion: true,
        breaks: false,
    };
    for (says, rounds, passed) in [(Answer::Second, 1, true), (Answer::First, 2, false)] {
        let mut plan = drawn.plan(0);
        // The reference comes first, so that "the second" is always right.
        plan.blocks[0].presentation_order = PresentationOrder::ReferenceFirst;
        let (mut session, _) = Session::begin(Arc::new(plan), 1);
        let (mut t_s, mut judged) = (0.0, Vec::new());
        for turn in 0..2000 {
            let Some(phase) = session.phase() else { break };
            let input = match phase.asked {
                Some(Asked::WhichDegraded) => Input::Answered { answer: says },
                _ => patiently(phase, turn),
            };
            t_s += 0.5;
            for event in session.handle(t_s, input) {
                if let Event::PracticeJudged { round, passed, .. } = event {
                    judged.push((round, passed));
                }
            }
        }
        assert_eq!(judged.len(), rounds, "{judged:?}");
        assert_eq!(judged.last(), Some(&(rounds as u32, passed)));
        assert!(session.finished());
    }
}

/// Runs a session in which the program ends at the inputs `ends` (counted from the first one) and is started again.
fn interrupted(plan: &Arc<Plan>, seed: u64, ends: &[usize]) -> Vec<Stamped> {
    let (mut session, first) = Session::begin(Arc::clone(plan), seed);
    let mut journal: Vec<Stamped> = Vec::new();
    let log = |t_s: f64, events: Vec<Event>, journal: &mut Vec<Stamped>| {
        for event in events {
            journal.push(Stamped { seq: journal.len() as u64, t_s, event });
        }
    };
    log(0.0, first, &mut journal);
    let mut observer: Box<dyn Observer> = Box::new(observer(seed));
    let mut t_s = 0.0;
    for input in 0..20_000 {
        if ends.contains(&input) {
            // All that is left is the journal.
            let mut rejoin = Rejoin::new(Box::new(self::observer(seed)));
            let refolded = refold(Arc::clone(plan), seed, &journal, |session, seq| {
                rejoin.meet(session, seam_at(&journal, seq));
            });
            session = refolded.expect("agrees").session;
            observer = rejoin.into_observer();
            log(t_s, session.handle(t_s, Input::Reopened), &mut journal);
        }
        let Some(phase) = session.phase() else { break };
        let level = session.shown_level();
        let (input, after_s) = match phase.name {
            PhaseName::Save => (Input::Saved, 0.0),
            PhaseName::Paused => (Input::Answered { answer: Answer::Continue }, 1.0),
            _ => match (observer.meet(&presented(&session, phase, level.as_ref())).answer, phase.duration_s) {
                (Some((answer, after_s)), None) => (Input::Answered { answer }, after_s),
                (Some((answer, after_s)), Some(limit_s)) if after_s < limit_s => (Input::Answered { answer }, after_s),
                (_, limit_s) => (Input::Elapsed, limit_s.unwrap_or(0.0)),
            },
        };
        t_s += after_s;
        log(t_s, session.handle(t_s, input), &mut journal);
    }
    journal
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Wherever a session is interrupted, in a trial, on a page, in a form or between them, it goes on with the trials,
    /// levels and answers of an unbroken one.
    #[test]
    fn an_interrupted_session_goes_on_like_an_unbroken_one(
        drawn in studies(), ends in prop::collection::vec(0usize..250, 0..5), seed in 0u64..1000, number in 0u32..4,
    ) {
        let plan = Arc::new(drawn.plan(number));
        let unbroken = Record::from_events(&interrupted(&plan, seed, &[]));
        let broken = Record::from_events(&interrupted(&plan, seed, &ends));
        prop_assert!(unbroken.finished && broken.finished, "{}", drawn.text());
        let asked_and_answered = |record: &Record| {
            let trials = record.trials.iter().filter(|trial| !is_interrupted(trial));
            trials.map(|trial| (Trial { trial: 0, ..trial.trial.clone() }, trial.outcome.clone(), trial.estimate.clone()))
                .collect::<Vec<_>>()
        };
        prop_assert_eq!(asked_and_answered(&unbroken), asked_and_answered(&broken), "{:?}", ends);
        let forms = |record: &Record| record.forms.iter().map(|form| form.entries.clone()).collect::<Vec<_>>();
        prop_assert_eq!(forms(&unbroken), forms(&broken));
    }
}

fn is_interrupted(trial: &record::TrialRecord) -> bool {
    trial.outcome == Outcome::Aborted { reason: AbortReason::Interrupted }
}
