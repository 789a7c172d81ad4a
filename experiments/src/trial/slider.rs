//! The slider test: the reference first, then up and down through quality levels from the lowest, with the reference to
//! compare with at will, until both look the same (Guenter 2012, §5).
//!
//! The recorded value is the paper's: the first at which the observer compares instead of going further up. Where they
//! settled in the end is found beside it. Moves that would leave the list, or exceed the limit, are not accepted.

use super::{
    Alternative, Answer, Asked, Found, Input, Outcome, Phase, PhaseName, Presentation, Protocol, SceneClock, Step,
    Stimulus,
};
use crate::study::plan::{Level, SliderPlan};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Showing {
    /// The reference, before anything can be moved.
    FirstReference,
    Test,
    /// The reference, to compare with.
    Comparison,
}

/// One trial of the slider test.
#[derive(Debug, Clone)]
pub struct Slider {
    plan: SliderPlan,
    /// Nothing before the first call.
    showing: Option<Showing>,
    /// Which of the values is set.
    at: usize,
    moves: u32,
    /// The value at the first comparison.
    recorded: Option<f64>,
}

impl Slider {
    /// A trial that starts at the lowest quality.
    #[must_use]
    pub fn new(plan: &SliderPlan) -> Self {
        Self { plan: plan.clone(), showing: None, at: 0, moves: 0, recorded: None }
    }

    fn value(&self) -> f64 {
        self.plan.values.get(self.at).copied().unwrap_or(0.0)
    }

    /// Where a move leads, if it is accepted.
    fn moved(&self, answer: Answer) -> Option<usize> {
        let at = match answer {
            Answer::Up => self.at.checked_add(1)?,
            Answer::Down => self.at.checked_sub(1)?,
            _ => return None,
        };
        let is_left = self.plan.most_moves.is_none_or(|most| self.moves < most);
        (is_left && at < self.plan.values.len()).then_some(at)
    }

    fn show(&mut self, showing: Showing) -> Step {
        self.showing = Some(showing);
        let plan = &self.plan;
        let stimulus = |alternative, level| {
            Presentation::Stimulus(Stimulus { level, clock: SceneClock::Trial, ..Stimulus::new(alternative) })
        };
        let reference = || stimulus(Alternative::Reference, Level::new());
        Step::Show(match showing {
            Showing::FirstReference => Phase::new(PhaseName::Reference, reference(), Some(plan.reference_s)),
            Showing::Test => {
                let level = Level::from([(plan.parameter.clone(), self.value())]);
                let moves = [Answer::Up, Answer::Down].into_iter().filter(|&answer| self.moved(answer).is_some());
                let accepts = moves.chain([Answer::Compare, Answer::Continue]).collect();
                Phase::new(PhaseName::Adjust, stimulus(Alternative::Test, level), None).asking(Asked::Match, accepts)
            }
            // Nothing is asked about the reference: either key only leads back.
            Showing::Comparison => Phase {
                accepts: vec![Answer::Compare, Answer::Continue],
                ..Phase::new(PhaseName::Reference, reference(), plan.compare_s)
            },
        })
    }

    fn end(&self) -> Step {
        let (name, settled) = (&self.plan.parameter, self.value());
        let found = Found::from([
            (name.clone(), self.recorded.unwrap_or(settled)),
            (format!("{name}_settled"), settled),
            ("moves".to_owned(), f64::from(self.moves)),
        ]);
        Step::End(Outcome::Answered { answer: Answer::Continue, correct: None, found })
    }
}

impl Protocol for Slider {
    fn next(&mut self, input: Option<&Input>) -> Step {
        let Some(showing) = self.showing else { return self.show(Showing::FirstReference) };
        match (showing, input) {
            (Showing::FirstReference, Some(Input::Elapsed)) => self.show(Showing::Test),
            (Showing::Test, Some(&Input::Answered { answer })) => match (answer, self.moved(answer)) {
                (_, Some(at)) => {
                    self.at = at;
                    self.moves = self.moves.saturating_add(1);
                    self.show(Showing::Test)
                }
                (Answer::Compare, _) => {
                    self.recorded = self.recorded.or(Some(self.value()));
                    self.show(Showing::Comparison)
                }
                (Answer::Continue, _) => self.end(),
                _ => self.show(Showing::Test),
            },
            (Showing::Comparison, Some(Input::Answered { answer: Answer::Compare | Answer::Continue })) => {
                self.show(Showing::Test)
            }
            (Showing::Comparison, Some(Input::Elapsed)) if self.plan.compare_s.is_some() => self.show(Showing::Test),
            // Anything else changes nothing: the same phase goes on.
            (showing, _) => self.show(showing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::GazeRule;

    /// Guenter 2012, §5: from j = 4.
    fn plan() -> SliderPlan {
        SliderPlan {
            parameter: "quality_index".to_owned(),
            values: (4..=22).map(f64::from).collect(),
            reference_s: 8.0,
            compare_s: None,
            most_moves: None,
        }
    }

    fn shown(step: Step) -> Phase {
        match step {
            Step::Show(phase) => phase,
            Step::End(outcome) => panic!("ended with {outcome:?}"),
        }
    }

    fn value(phase: &Phase) -> f64 {
        let Presentation::Stimulus(stimulus) = &phase.presentation else { panic!("a stimulus") };
        assert_eq!((stimulus.alternative, stimulus.clock), (Alternative::Test, SceneClock::Trial));
        stimulus.level["quality_index"]
    }

    /// The trial at its lowest level, with that phase.
    fn begun(plan: &SliderPlan) -> (Slider, Phase) {
        let mut trial = Slider::new(plan);
        let reference = shown(trial.next(None));
        assert_eq!((reference.name, reference.duration_s), (PhaseName::Reference, Some(8.0)));
        assert!(reference.accepts.is_empty() && reference.gaze == GazeRule::Free);
        // Nothing can be moved before the reference has been seen.
        assert_eq!(shown(trial.next(Some(&Input::Answered { answer: Answer::Up }))), reference);
        let lowest = shown(trial.next(Some(&Input::Elapsed)));
        (trial, lowest)
    }

    fn press(trial: &mut Slider, answer: Answer) -> Step {
        trial.next(Some(&Input::Answered { answer }))
    }

    fn found(step: Step) -> Found {
        let Step::End(Outcome::Answered { answer: Answer::Continue, correct: None, found }) = step else {
            panic!("{step:?}")
        };
        found
    }

    #[test]
    fn the_first_level_that_is_compared_is_recorded_and_the_last_is_settled() {
        let (mut trial, lowest) = begun(&plan());
        assert_eq!(value(&lowest), 4.0);
        assert_eq!(lowest.accepts, [Answer::Up, Answer::Compare, Answer::Continue]);
        for j in 5..=14 {
            assert_eq!(value(&shown(press(&mut trial, Answer::Up))), f64::from(j));
        }
        let comparison = shown(press(&mut trial, Answer::Compare));
        let Presentation::Stimulus(reference) = &comparison.presentation else { panic!("the reference") };
        assert_eq!((reference.alternative, comparison.asked), (Alternative::Reference, None));
        // Back, on, back down, and a second comparison that no longer counts.
        assert_eq!(value(&shown(press(&mut trial, Answer::Compare))), 14.0);
        for answer in [Answer::Up, Answer::Up, Answer::Up, Answer::Down, Answer::Compare, Answer::Continue] {
            shown(press(&mut trial, answer));
        }
        let found = found(press(&mut trial, Answer::Continue));
        assert_eq!((found["quality_index"], found["quality_index_settled"], found["moves"]), (14.0, 16.0, 14.0));
    }

    #[test]
    fn without_a_comparison_the_level_at_the_end_is_recorded() {
        let (mut trial, _) = begun(&plan());
        shown(press(&mut trial, Answer::Up));
        let found = found(press(&mut trial, Answer::Continue));
        assert_eq!((found["quality_index"], found["quality_index_settled"], found["moves"]), (5.0, 5.0, 1.0));
    }

    #[test]
    fn moves_stop_at_both_ends_and_at_the_limit() {
        let short = SliderPlan { values: vec![4.0, 5.0], ..plan() };
        let (mut trial, lowest) = begun(&short);
        assert_eq!(shown(press(&mut trial, Answer::Down)), lowest);
        let highest = shown(press(&mut trial, Answer::Up));
        assert_eq!(highest.accepts, [Answer::Down, Answer::Compare, Answer::Continue]);
        assert_eq!(shown(press(&mut trial, Answer::Up)), highest);

        let (mut trial, _) = begun(&SliderPlan { most_moves: Some(2), ..plan() });
        shown(press(&mut trial, Answer::Up));
        let last = shown(press(&mut trial, Answer::Up));
        assert_eq!(last.accepts, [Answer::Compare, Answer::Continue]);
        assert_eq!(shown(press(&mut trial, Answer::Down)), last);
        assert_eq!(found(press(&mut trial, Answer::Continue))["moves"], 2.0);
    }

    #[test]
    fn a_comparison_ends_with_its_time_or_with_a_key() {
        let (mut trial, lowest) = begun(&SliderPlan { compare_s: Some(2.0), ..plan() });
        let comparison = shown(press(&mut trial, Answer::Compare));
        assert_eq!(comparison.duration_s, Some(2.0));
        assert_eq!(shown(press(&mut trial, Answer::Up)), comparison);
        assert_eq!(shown(trial.next(Some(&Input::Elapsed))), lowest);

        let (mut trial, lowest) = begun(&plan());
        let comparison = shown(press(&mut trial, Answer::Compare));
        assert_eq!(comparison.duration_s, None);
        for input in [Input::Elapsed, Input::GazeLeft, Input::GazeReturned] {
            assert_eq!(shown(trial.next(Some(&input))), comparison);
        }
        assert_eq!(shown(press(&mut trial, Answer::Continue)), lowest);
    }

    #[test]
    fn values_may_fall_towards_quality() {
        let slopes = SliderPlan { parameter: "quality_index".to_owned(), values: vec![0.08, 0.04, 0.02], ..plan() };
        let (mut trial, lowest) = begun(&slopes);
        assert_eq!(value(&lowest), 0.08);
        assert_eq!(value(&shown(press(&mut trial, Answer::Up))), 0.04);
    }
}
