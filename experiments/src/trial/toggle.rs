//! The toggled 2AFC: alternatives A and B between which the observer switches freely, with uniform grey between them, until
//! one is named (Tursun 2019, §5).
//!
//! A letter stands at the centre of each alternative in place of the fixation mark; the presentation order assigns the
//! letters. An answer is taken once both have been seen. While gaze is away from the centre the stimulus is hidden, and no
//! answer is taken.

use super::{
    Alternative, Answer, Asked, Found, GazeRule, Input, Outcome, Phase, PhaseName, Presentation, Protocol, SceneClock,
    Step, Stimulus,
};
use crate::study::plan::{TogglePlan, Wanted};

/// What is shown. Alternatives are counted 0 for A, 1 for B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Showing {
    Fixation,
    Alternative(usize),
    /// Grey, before this alternative.
    Grey(usize),
    /// This alternative, hidden until gaze is back.
    Hidden(usize),
}

/// One trial of the toggled 2AFC.
#[derive(Debug, Clone)]
pub struct Toggle {
    plan: TogglePlan,
    order: [Alternative; 2],
    /// Nothing before the first call.
    showing: Option<Showing>,
    seen: [bool; 2],
    switches: u32,
}

impl Toggle {
    /// A trial in which A is the first of `order`, B the second.
    #[must_use]
    pub fn new(plan: &TogglePlan, order: [Alternative; 2]) -> Self {
        Self { plan: plan.clone(), order, showing: None, seen: [false; 2], switches: 0 }
    }

    fn may_answer(&self) -> bool {
        self.seen == [true; 2]
    }

    /// Switching is never refused before both have been seen, or no answer could follow.
    fn may_switch(&self) -> bool {
        !self.may_answer() || self.plan.most_switches.is_none_or(|most| self.switches < most)
    }

    fn show(&mut self, showing: Showing) -> Step {
        if let Showing::Alternative(index) = showing {
            self.seen[index] = true;
        }
        self.showing = Some(showing);
        let plan = &self.plan;
        Step::Show(match showing {
            Showing::Fixation => {
                Phase::new(PhaseName::Fixate, Presentation::Fixation, Some(plan.fixation_s)).with_gaze(GazeRule::Hold)
            }
            Showing::Alternative(index) => self.alternative(index),
            Showing::Grey(_) => Phase::new(PhaseName::Gap, Presentation::Grey, Some(plan.switch_s)),
            Showing::Hidden(_) => {
                Phase::new(PhaseName::Hidden, Presentation::Fixation, None).with_gaze(GazeRule::AwaitReturn)
            }
        })
    }

    fn alternative(&self, index: usize) -> Phase {
        let (name, letter) = [(PhaseName::AlternativeA, 'A'), (PhaseName::AlternativeB, 'B')][index];
        // The scene goes on moving while it is switched: both are at the same point of it.
        let stimulus = Stimulus { clock: SceneClock::Trial, letter: Some(letter), ..Stimulus::new(self.order[index]) };
        let asked = match self.plan.wanted {
            Wanted::Degraded => Asked::ToggleDegraded,
            Wanted::Reference => Asked::ToggleReference,
        };
        let answers = [Answer::First, Answer::Second].into_iter().filter(|_| self.may_answer());
        let switch = self.may_switch().then_some(Answer::Switch);
        Phase::new(name, Presentation::Stimulus(stimulus), None)
            .asking(asked, answers.chain(switch).collect())
            .with_gaze(self.plan.on_gaze_left.rule())
    }
}

impl Protocol for Toggle {
    fn next(&mut self, input: Option<&Input>) -> Step {
        let Some(showing) = self.showing else { return self.show(Showing::Fixation) };
        match (showing, input) {
            (Showing::Fixation, Some(Input::Elapsed)) => self.show(Showing::Alternative(0)),
            (Showing::Grey(next), Some(Input::Elapsed)) => self.show(Showing::Alternative(next)),
            (Showing::Hidden(index), Some(Input::GazeReturned)) => self.show(Showing::Alternative(index)),
            (Showing::Alternative(index), Some(Input::GazeLeft)) if self.plan.on_gaze_left.rule() == GazeRule::Hide => {
                self.show(Showing::Hidden(index))
            }
            (Showing::Alternative(index), Some(Input::Answered { answer: Answer::Switch })) if self.may_switch() => {
                self.switches += 1;
                self.show(Showing::Grey(1 - index))
            }
            (Showing::Alternative(_), Some(&Input::Answered { answer: answer @ (Answer::First | Answer::Second) }))
                if self.may_answer() =>
            {
                let named = self.order[usize::from(answer == Answer::Second)];
                Step::End(Outcome::Answered { answer, correct: Some(self.plan.wanted.is(named)), found: Found::new() })
            }
            // Anything else changes nothing: the same phase goes on.
            (showing, _) => self.show(showing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::OnGazeLeft;

    const ORDERS: [[Alternative; 2]; 2] =
        [[Alternative::Test, Alternative::Reference], [Alternative::Reference, Alternative::Test]];
    const SWITCH: Input = Input::Answered { answer: Answer::Switch };

    fn plan() -> TogglePlan {
        TogglePlan {
            fixation_s: 0.5,
            switch_s: 0.4,
            most_switches: None,
            question: "Which one is not foveated?".to_owned(),
            wanted: Wanted::Reference,
            on_gaze_left: OnGazeLeft::Hide,
        }
    }

    fn shown(step: Step) -> Phase {
        match step {
            Step::Show(phase) => phase,
            Step::End(outcome) => panic!("ended with {outcome:?}"),
        }
    }

    /// The trial at alternative A.
    fn at_a(plan: &TogglePlan, order: [Alternative; 2]) -> (Toggle, Phase) {
        let mut trial = Toggle::new(plan, order);
        let fixation = shown(trial.next(None));
        assert_eq!((fixation.name, fixation.duration_s, fixation.gaze), (PhaseName::Fixate, Some(0.5), GazeRule::Hold));
        let a = shown(trial.next(Some(&Input::Elapsed)));
        (trial, a)
    }

    /// Switches and waits for the grey to pass.
    fn switched(trial: &mut Toggle) -> Phase {
        let grey = shown(trial.next(Some(&SWITCH)));
        assert_eq!((grey.name, &grey.presentation, grey.duration_s), (PhaseName::Gap, &Presentation::Grey, Some(0.4)));
        shown(trial.next(Some(&Input::Elapsed)))
    }

    #[test]
    fn letters_follow_the_order_and_grey_comes_between() {
        for order in ORDERS {
            let (mut trial, a) = at_a(&plan(), order);
            let b = switched(&mut trial);
            for (phase, name, letter, alternative) in
                [(&a, PhaseName::AlternativeA, 'A', order[0]), (&b, PhaseName::AlternativeB, 'B', order[1])]
            {
                let Presentation::Stimulus(stimulus) = &phase.presentation else { panic!("a stimulus") };
                assert_eq!((phase.name, phase.duration_s, phase.gaze), (name, None, GazeRule::Hide));
                assert_eq!((stimulus.letter, stimulus.alternative), (Some(letter), alternative));
                assert_eq!(stimulus.clock, SceneClock::Trial);
                assert_eq!(phase.asked, Some(Asked::ToggleReference));
            }
            assert_eq!(switched(&mut trial).name, PhaseName::AlternativeA);
        }
    }

    #[test]
    fn an_answer_is_taken_once_both_have_been_seen() {
        let (mut trial, a) = at_a(&plan(), ORDERS[0]);
        assert_eq!(a.accepts, [Answer::Switch]);
        assert_eq!(shown(trial.next(Some(&Input::Answered { answer: Answer::First }))), a);
        let b = switched(&mut trial);
        assert_eq!(b.accepts, [Answer::First, Answer::Second, Answer::Switch]);
        // A second press during the grey changes nothing, and neither does an answer.
        let grey = shown(trial.next(Some(&SWITCH)));
        assert_eq!(shown(trial.next(Some(&SWITCH))), grey);
        assert_eq!(shown(trial.next(Some(&Input::Answered { answer: Answer::First }))), grey);
        assert_eq!(shown(trial.next(Some(&Input::Elapsed))).accepts, b.accepts);
    }

    #[test]
    fn answers_are_scored_against_the_picture_that_was_asked_for() {
        for wanted in [Wanted::Degraded, Wanted::Reference] {
            for order in ORDERS {
                for answer in [Answer::First, Answer::Second] {
                    let (mut trial, _) = at_a(&TogglePlan { wanted, ..plan() }, order);
                    let b = switched(&mut trial);
                    assert_eq!(b.asked == Some(Asked::ToggleDegraded), wanted == Wanted::Degraded);
                    let is_test = order[usize::from(answer == Answer::Second)] == Alternative::Test;
                    let correct = Some(is_test == (wanted == Wanted::Degraded));
                    assert_eq!(
                        trial.next(Some(&Input::Answered { answer })),
                        Step::End(Outcome::Answered { answer, correct, found: Found::new() })
                    );
                }
            }
        }
    }

    #[test]
    fn the_stimulus_hides_until_gaze_is_back() {
        let (mut trial, a) = at_a(&plan(), ORDERS[1]);
        let hidden = shown(trial.next(Some(&Input::GazeLeft)));
        assert_eq!((hidden.name, hidden.gaze), (PhaseName::Hidden, GazeRule::AwaitReturn));
        assert_eq!((&hidden.presentation, hidden.accepts.len()), (&Presentation::Fixation, 0));
        for input in [SWITCH, Input::Elapsed, Input::GazeLeft, Input::Answered { answer: Answer::First }] {
            assert_eq!(shown(trial.next(Some(&input))), hidden);
        }
        assert_eq!(shown(trial.next(Some(&Input::GazeReturned))), a);
        // Being back again is no news.
        assert_eq!(shown(trial.next(Some(&Input::GazeReturned))), a);
        let b = switched(&mut trial);
        trial.next(Some(&Input::GazeLeft));
        assert_eq!(shown(trial.next(Some(&Input::GazeReturned))), b);
    }

    #[test]
    fn a_study_may_leave_gaze_alone() {
        for (on_gaze_left, rule) in [(OnGazeLeft::Ignore, GazeRule::Free), (OnGazeLeft::Abort, GazeRule::Abort)] {
            let (mut trial, a) = at_a(&TogglePlan { on_gaze_left, ..plan() }, ORDERS[0]);
            assert_eq!(a.gaze, rule);
            assert_eq!(shown(trial.next(Some(&Input::GazeLeft))), a);
        }
    }

    #[test]
    fn after_the_last_switch_only_an_answer_is_taken() {
        for most in [0, 1, 3] {
            let (mut trial, a) = at_a(&TogglePlan { most_switches: Some(most), ..plan() }, ORDERS[0]);
            assert_eq!(a.accepts, [Answer::Switch], "both must be seen, whatever the limit");
            let mut phase = a;
            for _ in 0..most.max(1) {
                assert!(phase.takes(Answer::Switch));
                phase = switched(&mut trial);
            }
            assert_eq!(phase.accepts, [Answer::First, Answer::Second]);
            assert_eq!(shown(trial.next(Some(&SWITCH))), phase);
            assert!(matches!(trial.next(Some(&Input::Answered { answer: Answer::Second })), Step::End(_)));
        }
    }
}
