//! The pair test: two sequences with black between them, then "first better, second better, or the same?" (Guenter 2012,
//! §5: 8 s each, 0.5 s of black, in both orders).
//!
//! Both sequences run from their own beginning, so that they show the same motion. The threshold that the paper takes
//! from it, the lowest quality called equal to or better than the reference, is the analysis's to find.

use super::{
    Alternative, Answer, Asked, Found, GazeRule, Input, Outcome, Phase, PhaseName, Presentation, Protocol, Step,
};
use crate::study::plan::PairPlan;

/// One trial of the pair test.
#[derive(Debug, Clone)]
pub struct Pair {
    plan: PairPlan,
    order: [Alternative; 2],
    /// The phase being shown; none before the first call.
    showing: Option<PhaseName>,
}

impl Pair {
    /// A trial that shows the two pictures in this order.
    #[must_use]
    pub fn new(plan: &PairPlan, order: [Alternative; 2]) -> Self {
        Self { plan: plan.clone(), order, showing: None }
    }

    fn show(&mut self, name: PhaseName) -> Step {
        self.showing = Some(name);
        let plan = &self.plan;
        let sequence = |alternative| {
            Phase::new(name, Presentation::stimulus(alternative), Some(plan.sequence_s))
                .with_gaze(plan.on_gaze_left.rule())
        };
        Step::Show(match name {
            PhaseName::Fixate => Phase::new(name, Presentation::Fixation, plan.fixation_s).with_gaze(GazeRule::Hold),
            PhaseName::Interval1 => sequence(self.order[0]),
            // Black has no mark to keep to, so that gaze is free there.
            PhaseName::Gap => Phase::new(name, Presentation::Black, Some(plan.black_s)),
            PhaseName::Interval2 => sequence(self.order[1]),
            _ => Phase::new(name, Presentation::Text(plan.question.clone()), plan.answer_timeout_s)
                .asking(Asked::WhichBetter, vec![Answer::First, Answer::Second, Answer::Same]),
        })
    }
}

/// How a comparison ends: right if the reference was named as the better one. "The same" is not right, since the two
/// are not.
pub(super) fn judged(order: [Alternative; 2], answer: Answer, found: Found) -> Outcome {
    let named = match answer {
        Answer::First => Some(order[0]),
        Answer::Second => Some(order[1]),
        _ => None,
    };
    Outcome::Answered { answer, correct: Some(named == Some(Alternative::Reference)), found }
}

impl Protocol for Pair {
    fn next(&mut self, input: Option<&Input>) -> Step {
        match (self.showing, input) {
            (None, _) if self.plan.fixation_s.is_some() => self.show(PhaseName::Fixate),
            (None, _) => self.show(PhaseName::Interval1),
            (Some(PhaseName::Fixate), Some(Input::Elapsed)) => self.show(PhaseName::Interval1),
            (Some(PhaseName::Interval1), Some(Input::Elapsed)) => self.show(PhaseName::Gap),
            (Some(PhaseName::Gap), Some(Input::Elapsed)) => self.show(PhaseName::Interval2),
            (Some(PhaseName::Interval2), Some(Input::Elapsed)) => self.show(PhaseName::Ask),
            (Some(PhaseName::Ask), Some(Input::Elapsed)) if self.plan.answer_timeout_s.is_some() => {
                Step::End(Outcome::TimedOut)
            }
            (
                Some(PhaseName::Ask),
                Some(&Input::Answered { answer: answer @ (Answer::First | Answer::Second | Answer::Same) }),
            ) => Step::End(judged(self.order, answer, Found::new())),
            // Anything else changes nothing: the same phase goes on.
            (Some(name), _) => self.show(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::OnGazeLeft;
    use crate::trial::SceneClock;

    const ORDERS: [[Alternative; 2]; 2] =
        [[Alternative::Test, Alternative::Reference], [Alternative::Reference, Alternative::Test]];

    /// Guenter 2012, §5: 8 s, 0.5 s of black.
    fn plan(fixation_s: Option<f64>, on_gaze_left: OnGazeLeft) -> PairPlan {
        PairPlan {
            fixation_s,
            sequence_s: 8.0,
            black_s: 0.5,
            answer_timeout_s: Some(9.0),
            question: "Which was better?".to_owned(),
            on_gaze_left,
        }
    }

    fn phases_until_asked(trial: &mut Pair) -> Vec<Phase> {
        let mut phases = Vec::new();
        let mut step = trial.next(None);
        while let Step::Show(phase) = step {
            phases.push(phase);
            if phases.last().is_some_and(|phase| phase.asked.is_some()) {
                break;
            }
            step = trial.next(Some(&Input::Elapsed));
        }
        phases
    }

    #[test]
    fn two_sequences_of_the_same_motion_with_black_between_in_both_orders() {
        for order in ORDERS {
            let phases = phases_until_asked(&mut Pair::new(&plan(None, OnGazeLeft::Ignore), order));
            let seen: Vec<_> = phases.iter().map(|p| (p.name.as_str(), p.duration_s, p.gaze)).collect();
            assert_eq!(
                seen,
                [
                    ("interval1", Some(8.0), GazeRule::Free),
                    ("gap", Some(0.5), GazeRule::Free),
                    ("interval2", Some(8.0), GazeRule::Free),
                    ("ask", Some(9.0), GazeRule::Free),
                ]
            );
            for (phase, alternative) in [(&phases[0], order[0]), (&phases[2], order[1])] {
                let Presentation::Stimulus(stimulus) = &phase.presentation else { panic!("a sequence") };
                assert_eq!((stimulus.alternative, stimulus.clock), (alternative, SceneClock::Phase));
            }
            assert_eq!(phases[1].presentation, Presentation::Black);
            assert_eq!(phases[3].accepts, [Answer::First, Answer::Second, Answer::Same]);
        }
    }

    #[test]
    fn fixation_comes_first_where_the_study_has_one_and_gaze_may_abort() {
        let mut trial = Pair::new(&plan(Some(0.7), OnGazeLeft::Abort), ORDERS[0]);
        let phases = phases_until_asked(&mut trial);
        assert_eq!(
            (phases[0].name, phases[0].duration_s, phases[0].gaze),
            (PhaseName::Fixate, Some(0.7), GazeRule::Hold)
        );
        assert_eq!([phases[1].gaze, phases[3].gaze], [GazeRule::Abort; 2]);
    }

    #[test]
    fn right_is_the_reference_named_as_better_and_the_same_is_wrong() {
        for order in ORDERS {
            for answer in [Answer::First, Answer::Second, Answer::Same] {
                let mut trial = Pair::new(&plan(None, OnGazeLeft::Ignore), order);
                phases_until_asked(&mut trial);
                let reference_first = order[0] == Alternative::Reference;
                let right =
                    (answer == Answer::First && reference_first) || (answer == Answer::Second && !reference_first);
                assert_eq!(
                    trial.next(Some(&Input::Answered { answer })),
                    Step::End(Outcome::Answered { answer, correct: Some(right), found: Found::new() })
                );
            }
        }
    }

    #[test]
    fn silence_times_out_and_early_or_foreign_keys_change_nothing() {
        let mut trial = Pair::new(&plan(None, OnGazeLeft::Ignore), ORDERS[0]);
        let first = trial.next(None);
        assert_eq!(trial.next(Some(&Input::Answered { answer: Answer::Second })), first);
        assert_eq!(trial.next(Some(&Input::GazeLeft)), first);
        let ask = phases_until_asked(&mut trial).pop().expect("asked");
        for answer in [Answer::Continue, Answer::Increased, Answer::Option(1)] {
            assert_eq!(trial.next(Some(&Input::Answered { answer })), Step::Show(ask.clone()));
        }
        assert_eq!(trial.next(Some(&Input::Elapsed)), Step::End(Outcome::TimedOut));
    }
}
