//! The two-interval forced choice of the calibration: fixation, interval 1, grey, interval 2, "which was degraded?".
//!
//! One interval shows the full-resolution reference, the other the condition's renderer at the trial's level. In
//! practice, a word of feedback follows the answer.

use super::{Alternative, Answer, Input, Outcome, Phase, PhaseName, Presentation, Protocol, Step};
use crate::study::plan::TwoIntervalPlan;

/// One trial of the two-interval 2AFC.
#[derive(Debug, Clone)]
pub struct TwoInterval {
    plan: TwoIntervalPlan,
    test_first: bool,
    feedback: bool,
    /// The phase being shown; none before the first call.
    showing: Option<PhaseName>,
    outcome: Option<Outcome>,
}

impl TwoInterval {
    /// A trial whose degraded picture comes in the first interval if `test_first`.
    #[must_use]
    pub fn new(plan: &TwoIntervalPlan, test_first: bool, feedback: bool) -> Self {
        Self { plan: plan.clone(), test_first, feedback, showing: None, outcome: None }
    }

    fn show(&mut self, name: PhaseName) -> Step {
        self.showing = Some(name);
        let timed = |presentation, duration_s| Phase {
            name,
            presentation,
            duration_s: Some(duration_s),
            accepts: Vec::new(),
            gated: false,
            hold_for_gaze: false,
        };
        let alternative = |is_test| if is_test { Alternative::Test } else { Alternative::Reference };
        Step::Show(match name {
            PhaseName::Fixate => Phase { hold_for_gaze: true, ..timed(Presentation::Fixation, self.plan.fixation_s) },
            PhaseName::Interval1 => Phase {
                gated: true,
                ..timed(Presentation::Stimulus(alternative(self.test_first)), self.plan.interval_s)
            },
            PhaseName::Gap => Phase { gated: true, ..timed(Presentation::Fixation, self.plan.gap_s) },
            PhaseName::Interval2 => Phase {
                gated: true,
                ..timed(Presentation::Stimulus(alternative(!self.test_first)), self.plan.interval_s)
            },
            PhaseName::Feedback => {
                let right = matches!(self.outcome, Some(Outcome::Answered { correct: true, .. }));
                let word = if right { "Right." } else { "Wrong." };
                timed(Presentation::Text(word.to_owned()), self.plan.feedback_s)
            }
            _ => Phase {
                duration_s: self.plan.answer_timeout_s,
                accepts: vec![Answer::First, Answer::Second],
                ..timed(Presentation::Text(self.plan.question.clone()), 0.0)
            },
        })
    }

    /// What follows an answer or a timeout: feedback in practice, else the end.
    fn conclude(&mut self, outcome: Outcome) -> Step {
        self.outcome = Some(outcome);
        if self.feedback && matches!(outcome, Outcome::Answered { .. }) {
            self.show(PhaseName::Feedback)
        } else {
            Step::End(outcome)
        }
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
            (Some(PhaseName::Ask), Some(Input::Elapsed)) => self.conclude(Outcome::TimedOut),
            (Some(PhaseName::Ask), Some(&Input::Answered { answer: answer @ (Answer::First | Answer::Second) })) => {
                let correct = (answer == Answer::First) == self.test_first;
                self.conclude(Outcome::Answered { answer, correct })
            }
            (Some(PhaseName::Feedback), Some(Input::Elapsed)) => Step::End(self.outcome.unwrap_or(Outcome::TimedOut)),
            // Anything else changes nothing: the same phase goes on.
            (Some(name), _) => self.show(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> TwoIntervalPlan {
        TwoIntervalPlan {
            fixation_s: 0.5,
            interval_s: 0.3,
            gap_s: 0.2,
            answer_timeout_s: Some(5.0),
            feedback_s: 0.4,
            question: "Which?".to_owned(),
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
        for test_first in [true, false] {
            let phases = phases_until_asked(&mut TwoInterval::new(&plan(), test_first, false));
            let seen: Vec<_> = phases.iter().map(|p| (p.name.as_str(), p.duration_s, p.gated)).collect();
            assert_eq!(
                seen,
                [
                    ("fixate", Some(0.5), false),
                    ("interval1", Some(0.3), true),
                    ("gap", Some(0.2), true),
                    ("interval2", Some(0.3), true),
                    ("ask", Some(5.0), false),
                ]
            );
            let first = if test_first { Alternative::Test } else { Alternative::Reference };
            assert_eq!(phases[1].presentation, Presentation::Stimulus(first));
            assert_ne!(phases[1].presentation, phases[3].presentation);
        }
    }

    #[test]
    fn answers_are_scored_against_the_interval_of_the_test() {
        for (test_first, answer, correct) in [
            (true, Answer::First, true),
            (true, Answer::Second, false),
            (false, Answer::First, false),
            (false, Answer::Second, true),
        ] {
            let mut trial = TwoInterval::new(&plan(), test_first, false);
            phases_until_asked(&mut trial);
            assert_eq!(trial.next(Some(&Input::Answered { answer })), Step::End(Outcome::Answered { answer, correct }));
        }
    }

    #[test]
    fn silence_times_out_without_feedback() {
        let mut trial = TwoInterval::new(&plan(), true, true);
        phases_until_asked(&mut trial);
        assert_eq!(trial.next(Some(&Input::Elapsed)), Step::End(Outcome::TimedOut));
    }

    #[test]
    fn practice_says_right_or_wrong_before_it_ends() {
        for (answer, word) in [(Answer::First, "Right."), (Answer::Second, "Wrong.")] {
            let mut trial = TwoInterval::new(&plan(), true, true);
            phases_until_asked(&mut trial);
            let Step::Show(phase) = trial.next(Some(&Input::Answered { answer })) else {
                panic!("practice gives feedback");
            };
            assert_eq!(phase.presentation, Presentation::Text(word.to_owned()));
            let correct = answer == Answer::First;
            assert_eq!(trial.next(Some(&Input::Elapsed)), Step::End(Outcome::Answered { answer, correct }));
        }
    }

    #[test]
    fn a_key_at_the_wrong_time_changes_nothing() {
        let mut trial = TwoInterval::new(&plan(), true, false);
        let first = trial.next(None);
        assert_eq!(trial.next(Some(&Input::Answered { answer: Answer::First })), first);
        assert!(matches!(trial.next(Some(&Input::Elapsed)), Step::Show(p) if p.name == PhaseName::Interval1));
    }
}
