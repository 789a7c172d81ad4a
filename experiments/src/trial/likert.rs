//! A rated sequence: the test is shown, then items are asked, such as seven steps from "strongly disagree" (−3) to
//! "strongly agree" (3) (Weier 2016, §4.2.1).
//!
//! There is no reference beside it and no right answer. A control trial, whose level makes the renderer the reference, is a
//! trial like any other. The items are a [`Form`].

use super::form::{Entry, Form};
use super::{Alternative, Answer, Found, GazeRule, Input, Outcome, Phase, PhaseName, Presentation, Protocol, Step};
use crate::study::plan::LikertPlan;

/// What is shown; the form says itself which item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Showing {
    Fixation,
    Sequence,
    Items,
}

/// One rated sequence.
#[derive(Debug, Clone)]
pub struct Likert {
    plan: LikertPlan,
    form: Form,
    /// Nothing before the first call.
    showing: Option<Showing>,
    /// The last answer that was taken.
    answer: Answer,
}

impl Likert {
    /// A trial with nothing rated.
    #[must_use]
    pub fn new(plan: &LikertPlan) -> Self {
        Self { plan: plan.clone(), form: Form::new(&plan.items), showing: None, answer: Answer::Continue }
    }

    fn show(&mut self, showing: Showing) -> Step {
        self.showing = Some(showing);
        let plan = &self.plan;
        Step::Show(match showing {
            Showing::Fixation => {
                Phase::new(PhaseName::Fixate, Presentation::Fixation, plan.fixation_s).with_gaze(GazeRule::Hold)
            }
            Showing::Sequence => {
                let sequence = Presentation::stimulus(Alternative::Test);
                Phase::new(PhaseName::Sequence, sequence, Some(plan.sequence_s)).with_gaze(plan.on_gaze_left.rule())
            }
            Showing::Items => match self.form.phase() {
                Some(phase) => phase,
                None => {
                    let found = numbers(&self.form);
                    return Step::End(Outcome::Answered { answer: self.answer, correct: None, found });
                }
            },
        })
    }
}

/// What was entered, as far as it is numbers.
pub(super) fn numbers(form: &Form) -> Found {
    let number = |(name, entry): (&String, &Entry)| match entry {
        Entry::Number(value) => Some((name.clone(), *value)),
        Entry::Text(_) => None,
    };
    form.entries().iter().filter_map(number).collect()
}

impl Protocol for Likert {
    fn next(&mut self, input: Option<&Input>) -> Step {
        match (self.showing, input) {
            (None, _) if self.plan.fixation_s.is_some() => self.show(Showing::Fixation),
            (None, _) => self.show(Showing::Sequence),
            (Some(Showing::Fixation), Some(Input::Elapsed)) => self.show(Showing::Sequence),
            (Some(Showing::Sequence), Some(Input::Elapsed)) => self.show(Showing::Items),
            (Some(Showing::Items), Some(&Input::Answered { answer }))
                if self.form.phase().is_some_and(|phase| phase.takes(answer)) =>
            {
                self.form.take(answer);
                self.answer = answer;
                self.show(Showing::Items)
            }
            // Anything else changes nothing: the same phase goes on.
            (Some(showing), _) => self.show(showing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::{Item, ItemKind, OnGazeLeft};
    use crate::trial::Asked;

    fn scale() -> ItemKind {
        ItemKind::Scale {
            low: -3,
            high: 3,
            low_anchor: "strongly disagree".to_owned(),
            high_anchor: "strongly agree".to_owned(),
        }
    }

    fn item(name: &str, kind: ItemKind) -> Item {
        Item { name: name.to_owned(), question: format!("{name}?"), kind }
    }

    /// Weier 2016, §4.2.1: free of artefacts (Q1), and how sure (Q2).
    fn plan(fixation_s: Option<f64>) -> LikertPlan {
        LikertPlan {
            fixation_s,
            sequence_s: 8.0,
            items: vec![item("artefact-free", scale()), item("confidence", scale())],
            on_gaze_left: OnGazeLeft::Ignore,
        }
    }

    fn shown(step: Step) -> Phase {
        match step {
            Step::Show(phase) => phase,
            Step::End(outcome) => panic!("ended with {outcome:?}"),
        }
    }

    fn option(value: i32) -> Input {
        Input::Answered { answer: Answer::Option(value) }
    }

    #[test]
    fn the_test_is_shown_and_every_item_rated() {
        let mut trial = Likert::new(&plan(None));
        let sequence = shown(trial.next(None));
        assert_eq!(
            (sequence.name, sequence.duration_s, sequence.gaze),
            (PhaseName::Sequence, Some(8.0), GazeRule::Free)
        );
        assert_eq!(sequence.presentation, Presentation::stimulus(Alternative::Test));
        let first = shown(trial.next(Some(&Input::Elapsed)));
        assert_eq!((first.name, first.asked), (PhaseName::Form, Some(Asked::Agreement)));
        assert_eq!(first.accepts.len(), 7);
        assert_ne!(shown(trial.next(Some(&option(-3)))), first);
        let found = Found::from([("artefact-free".to_owned(), -3.0), ("confidence".to_owned(), 2.0)]);
        assert_eq!(
            trial.next(Some(&option(2))),
            Step::End(Outcome::Answered { answer: Answer::Option(2), correct: None, found })
        );
    }

    #[test]
    fn fixation_comes_first_where_the_study_has_one_and_gaze_may_abort() {
        let mut trial = Likert::new(&LikertPlan { on_gaze_left: OnGazeLeft::Abort, ..plan(Some(0.8)) });
        let fixation = shown(trial.next(None));
        assert_eq!((fixation.name, fixation.duration_s, fixation.gaze), (PhaseName::Fixate, Some(0.8), GazeRule::Hold));
        assert_eq!(shown(trial.next(Some(&Input::Elapsed))).gaze, GazeRule::Abort);
    }

    #[test]
    fn early_keys_and_steps_off_the_scale_change_nothing() {
        let mut trial = Likert::new(&plan(None));
        let sequence = shown(trial.next(None));
        assert_eq!(shown(trial.next(Some(&option(1)))), sequence);
        let first = shown(trial.next(Some(&Input::Elapsed)));
        for input in [option(4), option(-4), Input::Elapsed, Input::GazeLeft, Input::Answered { answer: Answer::First }]
        {
            assert_eq!(shown(trial.next(Some(&input))), first);
        }
    }

    #[test]
    fn choices_and_numbers_are_found_as_numbers() {
        let options = vec!["yes".to_owned(), "no".to_owned()];
        let number = ItemKind::Number { min: 0.0, max: 10.0, unit: String::new(), whole: false };
        let items = vec![item("seen", ItemKind::Choice { options }), item("count", number)];
        let mut trial = Likert::new(&LikertPlan { items, ..plan(None) });
        trial.next(None);
        trial.next(Some(&Input::Elapsed));
        trial.next(Some(&option(2)));
        for character in "4.5".chars() {
            shown(trial.next(Some(&Input::Answered { answer: Answer::Typed(character) })));
        }
        let Step::End(Outcome::Answered { answer, found, .. }) =
            trial.next(Some(&Input::Answered { answer: Answer::Continue }))
        else {
            panic!("ended")
        };
        assert_eq!((answer, found["seen"], found["count"]), (Answer::Continue, 2.0, 4.5));
    }
}
