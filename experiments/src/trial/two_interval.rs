//! The two-interval forced choice of the calibration: fixation, interval 1, grey, interval 2, "which was degraded?".
//!
//! One interval shows the full-resolution reference, the other the condition's renderer at the trial's level. With
//! [`Wanted::Reference`] the question is which was *not* degraded (Tursun 2019, §5, shown in sequence).

use super::{
    Alternative, Answer, Asked, Found, GazeRule, Input, Outcome, Phase, PhaseName, Presentation, Protocol, Step,
};
use crate::study::plan::{TwoIntervalPlan, Wanted};

/// One trial of the two-interval 2AFC.
#[derive(Debug, Clone)]
pub struct TwoInterval {
    plan: TwoIntervalPlan,
    order: [Alternative; 2],
    /// The phase being shown; none before the first call.
    showing: Option<PhaseName>,
}

impl TwoInterval {
    /// A trial that shows the two pictures in this order.
    #[must_use]
    pub fn new(plan: &TwoIntervalPlan, order: [Alternative; 2]) -> Self {
        Self { plan: plan.clone(), order, showing: None }
    }

    fn show(&mut self, name: PhaseName) -> Step {
        self.showing = Some(name);
        let plan = &self.plan;
        let interval = |alternative| {
            Phase::new(name, Presentation::stimulus(alternative), Some(plan.interval_s)).with_gaze(GazeRule::Abort)
        };
        Step::Show(match name {
            PhaseName::Fixate => {
                Phase::new(name, Presentation::Fixation, Some(plan.fixation_s)).with_gaze(GazeRule::Hold)
            }
            PhaseName::Interval1 => interval(self.order[0]),
            PhaseName::Gap => Phase::new(name, Presentation::Fixation, Some(plan.gap_s)).with_gaze(GazeRule::Abort),
            PhaseName::Interval2 => interval(self.order[1]),
            _ => {
                let asked = match plan.wanted {
                    Wanted::Degraded => Asked::WhichDegraded,
                    Wanted::Reference => Asked::WhichReference,
                };
                Phase::new(name, Presentation::Text(plan.question.clone()), plan.answer_timeout_s)
                    .asking(asked, vec![Answer::First, Answer::Second])
            }
        })
    }
}

impl Protocol for TwoInterval {
    fn next(&mut self, input: Option<&Input>) -> Step {
        match (self.showing, input) {
            (None, _) => self.show(PhaseName::Fixate),
            (Some(PhaseName::Fixate), Some(Input::Elapsed)) => self.show(PhaseName::Interval1),
            (Some(PhaseName::Interval1), Some(Input::Elapsed)) => self.show(PhaseName::Gap),
            (Some(PhaseName::Gap), Some(Input::Elapsed)) => self.show(PhaseName::Interval2),
            (Some(PhaseName::Interval2), Some(Input::Elapsed)) => self.show(PhaseName::Ask),
            (Some(PhaseName::Ask), Some(Input::Elapsed)) => Step::End(Outcome::TimedOut),
            (Some(PhaseName::Ask), Some(&Input::Answered { answer: answer @ (Answer::First | Answer::Second) })) => {
                let named = self.order[usize::from(answer == Answer::Second)];
                let correct = Some(self.plan.wanted.is(named));
                Step::End(Outcome::Answered { answer, correct, found: Found::new() })
            }
            // Anything else changes nothing: the same phase goes on.
            (Some(name), _) => self.show(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDERS: [[Alternative; 2]; 2] =
        [[Alternative::Test, Alternative::Reference], [Alternative::Reference, Alternative::Test]];

    fn plan(wanted: Wanted) -> TwoIntervalPlan {
        TwoIntervalPlan {
            fixation_s: 0.5,
            interval_s: 0.3,
            gap_s: 0.2,
            answer_timeout_s: Some(5.0),
            question: "Which?".to_owned(),
            wanted,
        }
    }

    fn phases_until_asked(trial: &mut TwoInterval) -> Vec<Phase> {
        let mut phases = Vec::new();
        let mut step = trial.next(None);
        while let Step::Show(phase) = step {
            let asked = phase.name == PhaseName::Ask;
            phases.push(phase);
            if asked {
                break;
            }
            step = trial.next(Some(&Input::Elapsed));
        }
        phases
    }

    #[test]
    fn the_phases_come_in_order_with_their_times_and_pictures() {
        for order in ORDERS {
            let phases = phases_until_asked(&mut TwoInterval::new(&plan(Wanted::Degraded), order));
            let seen: Vec<_> = phases.iter().map(|p| (p.name.as_str(), p.duration_s, p.gaze)).collect();
            assert_eq!(
                seen,
                [
                    ("fixate", Some(0.5), GazeRule::Hold),
                    ("interval1", Some(0.3), GazeRule::Abort),
                    ("gap", Some(0.2), GazeRule::Abort),
                    ("interval2", Some(0.3), GazeRule::Abort),
                    ("ask", Some(5.0), GazeRule::Free),
                ]
            );
            assert_eq!(phases[1].presentation, Presentation::stimulus(order[0]));
            assert_eq!(phases[3].presentation, Presentation::stimulus(order[1]));
        }
    }

    #[test]
    fn answers_are_scored_against_the_picture_that_was_asked_for() {
        for wanted in [Wanted::Degraded, Wanted::Reference] {
            for order in ORDERS {
                for answer in [Answer::First, Answer::Second] {
                    let mut trial = TwoInterval::new(&plan(wanted), order);
                    phases_until_asked(&mut trial);
                    let named = order[usize::from(answer == Answer::Second)];
                    let correct = (named == Alternative::Test) == (wanted == Wanted::Degraded);
                    assert_eq!(
                        trial.next(Some(&Input::Answered { answer })),
                        Step::End(Outcome::Answered { answer, correct: Some(correct), found: Found::new() })
                    );
                }
            }
        }
    }

    #[test]
    fn silence_times_out() {
        let mut trial = TwoInterval::new(&plan(Wanted::Degraded), ORDERS[0]);
        phases_until_asked(&mut trial);
        assert_eq!(trial.next(Some(&Input::Elapsed)), Step::End(Outcome::TimedOut));
    }

    #[test]
    fn a_key_at_the_wrong_time_changes_nothing() {
        let mut trial = TwoInterval::new(&plan(Wanted::Degraded), ORDERS[0]);
        let first = trial.next(None);
        assert_eq!(trial.next(Some(&Input::Answered { answer: Answer::First })), first);
        assert!(matches!(trial.next(Some(&Input::Elapsed)), Step::Show(p) if p.name == PhaseName::Interval1));
    }
}
