//! The machines that protocols become: no sequence of inputs gets one stuck.

use super::protocols::{ALL, block};
use crate::study::plan::BlockPlan;
use crate::trial::{self, Alternative, Answer, GazeRule, Input, Outcome, Phase, Setup, Step};
use proptest::prelude::*;

const ORDERS: [[Alternative; 2]; 2] =
    [[Alternative::Test, Alternative::Reference], [Alternative::Reference, Alternative::Test]];

/// Whether the session hands an input to the protocol during a phase.
fn is_accepted(phase: &Phase, input: Input) -> bool {
    match input {
        Input::Elapsed => phase.duration_s.is_some(),
        Input::Answered { answer } => phase.takes(answer),
        Input::GazeLeft => phase.gaze == GazeRule::Hide,
        Input::GazeReturned => phase.gaze == GazeRule::AwaitReturn,
        Input::Pause | Input::Resume | Input::Saved | Input::Unsaved { .. } | Input::Reopened => false,
    }
}

/// What a patient observer does: waits where there is something to wait for, comes back, types a number, answers.
fn patient(phase: &Phase, has_typed: &mut bool) -> Input {
    if phase.gaze == GazeRule::AwaitReturn {
        return Input::GazeReturned;
    }
    if phase.typing.is_some() && !std::mem::replace(has_typed, true) {
        return Input::Answered { answer: Answer::Typed('7') };
    }
    *has_typed = false;
    // Ends before moves: whoever never ends is not patient but lost.
    let ending = [Answer::Continue, Answer::Second, Answer::Same];
    let answer = ending.into_iter().chain(phase.accepts.iter().copied()).find(|&answer| phase.takes(answer));
    match answer {
        Some(answer) if phase.asked.is_some() || phase.duration_s.is_none() => Input::Answered { answer },
        _ => Input::Elapsed,
    }
}

fn any_input() -> impl Strategy<Value = Input> {
    let answers = [
        Answer::First,
        Answer::Second,
        Answer::Same,
        Answer::Increased,
        Answer::Decreased,
        Answer::Continue,
        Answer::Up,
        Answer::Down,
        Answer::Compare,
        Answer::Switch,
        Answer::Select,
        Answer::Option(-3),
        Answer::Option(1),
        Answer::Option(i32::MAX),
        Answer::Typed('1'),
        Answer::Typed('-'),
        Answer::Typed('x'),
        Answer::Erase,
    ];
    prop_oneof![
        4 => Just(Input::Elapsed),
        8 => prop::sample::select(answers.to_vec()).prop_map(|answer| Input::Answered { answer }),
        2 => Just(Input::GazeLeft),
        2 => Just(Input::GazeReturned),
        1 => prop::sample::select(vec![Input::Pause, Input::Resume, Input::Saved, Input::Reopened]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Early, late, doubled and foreign inputs: none panics, none that is not accepted changes anything, and from wherever
    /// they led a patient observer comes to an end.
    #[test]
    fn no_input_gets_a_protocol_stuck(
        which in 0..ALL.len(),
        inputs in prop::collection::vec(any_input(), 0..60),
        (order, practice, path_seed) in (0_usize..2, any::<bool>(), any::<u64>()),
    ) {
        let block = BlockPlan { practice, ..block(ALL[which]) };
        let level = &block.procedure.levels()[0];
        let mut protocol = trial::start(&block, Setup { level, order: ORDERS[order], path_seed });
        let mut step = protocol.next(None);
        for input in inputs {
            let Step::Show(phase) = &step else { break };
            let next = protocol.next(Some(&input));
            if !is_accepted(phase, input) {
                prop_assert_eq!(&next, &step, "{:?}", input);
            }
            step = next;
        }
        let mut has_typed = false;
        for _ in 0..60 {
            let Step::Show(phase) = &step else { break };
            // Whatever is shown can be left.
            prop_assert!(phase.duration_s.is_some() || !phase.accepts.is_empty() || phase.gaze == GazeRule::AwaitReturn);
            let input = patient(phase, &mut has_typed);
            prop_assert!(is_accepted(phase, input), "{:?} in {:?}", input, phase);
            step = protocol.next(Some(&input));
        }
        let Step::End(outcome) = step else { panic!("still going: {step:?}") };
        if let Outcome::Answered { correct, .. } = outcome {
            prop_assert_eq!(correct.is_some(), block.protocol.has_right_answers());
        }
    }
}
