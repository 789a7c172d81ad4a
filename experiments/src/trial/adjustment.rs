//! The method of adjustment: several parameters of the renderer are set at will, with the reference to toggle to at will,
//! until no difference is seen (Stengel 2016, §6.1).
//!
//! A trial starts at its level, so that a study can have several starting points. Up and Down move the selected parameter,
//! whose number stands at the centre; Select goes on to the next. Moves that would change nothing, or exceed the limit, are
//! not accepted.

use super::{
    Alternative, Answer, Asked, Found, Input, Outcome, Phase, PhaseName, Presentation, Protocol, SceneClock, Step,
    Stimulus,
};
use crate::study::plan::{AdjustmentPlan, Level};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Showing {
    Test,
    /// The reference, to compare with.
    Comparison,
}

/// One adjustment.
#[derive(Debug, Clone)]
pub struct Adjustment {
    plan: AdjustmentPlan,
    /// One for each parameter.
    values: Vec<f64>,
    selected: usize,
    moves: u32,
    comparisons: u32,
    /// Nothing before the first call.
    showing: Option<Showing>,
}

impl Adjustment {
    /// An adjustment that starts at a level, kept within the ranges; what the level does not say starts in the middle of
    /// its range.
    #[must_use]
    pub fn new(plan: &AdjustmentPlan, level: &Level) -> Self {
        let starts = plan.parameters.iter().map(|adjusted| match level.get(&adjusted.parameter) {
            Some(value) => value.max(adjusted.min).min(adjusted.max),
            None => adjusted.middle(),
        });
        Self { values: starts.collect(), plan: plan.clone(), selected: 0, moves: 0, comparisons: 0, showing: None }
    }

    fn level(&self) -> Level {
        let names = self.plan.parameters.iter().map(|adjusted| adjusted.parameter.clone());
        names.zip(self.values.iter().copied()).collect()
    }

    /// The value that a move gives to the selected parameter, if it is accepted.
    fn moved(&self, answer: Answer) -> Option<f64> {
        let up = match answer {
            Answer::Up => true,
            Answer::Down => false,
            _ => return None,
        };
        let (adjusted, &value) = self.plan.parameters.get(self.selected).zip(self.values.get(self.selected))?;
        let moved = adjusted.moved(value, up);
        let is_left = self.plan.most_moves.is_none_or(|most| self.moves < most);
        (is_left && moved.total_cmp(&value).is_ne()).then_some(moved)
    }

    fn may_select(&self) -> bool {
        self.values.len() > 1
    }

    fn show(&mut self, showing: Showing) -> Step {
        self.showing = Some(showing);
        let stimulus = |alternative| Stimulus { clock: SceneClock::Trial, ..Stimulus::new(alternative) };
        Step::Show(match showing {
            Showing::Test => {
                let number = u32::try_from(self.selected + 1).ok().and_then(|number| char::from_digit(number, 10));
                let test = Stimulus { level: self.level(), letter: number, ..stimulus(Alternative::Test) };
                let moves = [Answer::Up, Answer::Down].into_iter().filter(|&answer| self.moved(answer).is_some());
                let select = self.may_select().then_some(Answer::Select);
                let accepts = moves.chain(select).chain([Answer::Compare, Answer::Continue]).collect();
                Phase::new(PhaseName::Adjust, Presentation::Stimulus(test), None).asking(Asked::Adjust, accepts)
            }
            // Nothing is asked about the reference: either key only leads back.
            Showing::Comparison => Phase {
                accepts: vec![Answer::Compare, Answer::Continue],
                ..Phase::new(PhaseName::Reference, Presentation::Stimulus(stimulus(Alternative::Reference)), None)
            },
        })
    }

    fn end(&self) -> Step {
        let mut found: Found = self.level();
        found.insert("moves".to_owned(), f64::from(self.moves));
        found.insert("comparisons".to_owned(), f64::from(self.comparisons));
        Step::End(Outcome::Answered { answer: Answer::Continue, correct: None, found })
    }
}

impl Protocol for Adjustment {
    fn next(&mut self, input: Option<&Input>) -> Step {
        let Some(showing) = self.showing else { return self.show(Showing::Test) };
        match (showing, input) {
            (Showing::Test, Some(&Input::Answered { answer })) => match (answer, self.moved(answer)) {
                (_, Some(value)) => {
                    self.values[self.selected] = value;
                    self.moves = self.moves.saturating_add(1);
                    self.show(Showing::Test)
                }
                (Answer::Select, _) if self.may_select() => {
                    self.selected = (self.selected + 1) % self.values.len();
                    self.show(Showing::Test)
                }
                (Answer::Compare, _) => {
                    self.comparisons = self.comparisons.saturating_add(1);
                    self.show(Showing::Comparison)
                }
                (Answer::Continue, _) => self.end(),
                _ => self.show(Showing::Test),
            },
            (Showing::Comparison, Some(Input::Answered { answer: Answer::Compare | Answer::Continue })) => {
                self.show(Showing::Test)
            }
            // Anything else changes nothing: the same phase goes on.
            (showing, _) => self.show(showing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::{Adjusted, AdjustmentStep};

    /// The slope and the acuity limit of Stengel 2016, §6.1, with ranges around what was found there.
    fn plan() -> AdjustmentPlan {
        AdjustmentPlan {
            parameters: vec![
                Adjusted { parameter: "m".to_owned(), min: -4.0, max: 0.0, step: AdjustmentStep::Add(0.5) },
                Adjusted { parameter: "omega0".to_owned(), min: 0.5, max: 2.0, step: AdjustmentStep::Multiply(1.1) },
            ],
            most_moves: None,
        }
    }

    fn shown(step: Step) -> Phase {
        match step {
            Step::Show(phase) => phase,
            Step::End(outcome) => panic!("ended with {outcome:?}"),
        }
    }

    fn test(phase: &Phase) -> &Stimulus {
        let Presentation::Stimulus(stimulus) = &phase.presentation else { panic!("a stimulus") };
        assert_eq!((stimulus.alternative, stimulus.clock), (Alternative::Test, SceneClock::Trial));
        stimulus
    }

    fn press(trial: &mut Adjustment, answer: Answer) -> Step {
        trial.next(Some(&Input::Answered { answer }))
    }

    #[test]
    fn it_starts_at_the_level_or_in_the_middle() {
        let first = shown(Adjustment::new(&plan(), &Level::new()).next(None));
        let level = &test(&first).level;
        // (−4 + 0) / 2, and sqrt(0.5 · 2).
        assert!((level["m"] + 2.0).abs() < 1e-12 && (level["omega0"] - 1.0).abs() < 1e-12);

        let start = Level::from([("m".to_owned(), -3.5), ("omega0".to_owned(), 7.0), ("other".to_owned(), 1.0)]);
        let first = shown(Adjustment::new(&plan(), &start).next(None));
        assert_eq!(test(&first).level, Level::from([("m".to_owned(), -3.5), ("omega0".to_owned(), 2.0)]));
    }

    #[test]
    fn the_selected_parameter_moves_by_its_own_step_and_its_number_stands_at_the_centre() {
        let mut trial = Adjustment::new(&plan(), &Level::from([("omega0".to_owned(), 1.0)]));
        let first = shown(trial.next(None));
        assert_eq!((test(&first).letter, first.asked), (Some('1'), Some(Asked::Adjust)));
        let up = shown(press(&mut trial, Answer::Up));
        assert!((test(&up).level["m"] + 1.5).abs() < 1e-12 && (test(&up).level["omega0"] - 1.0).abs() < 1e-12);
        let second = shown(press(&mut trial, Answer::Select));
        assert_eq!(test(&second).letter, Some('2'));
        let up = shown(press(&mut trial, Answer::Up));
        assert!((test(&up).level["omega0"] - 1.1).abs() < 1e-12);
        let down = shown(press(&mut trial, Answer::Down));
        assert!((test(&down).level["omega0"] - 1.0).abs() < 1e-12);
        assert_eq!(test(&shown(press(&mut trial, Answer::Select))).letter, Some('1'));
    }

    #[test]
    fn what_was_set_is_found_with_moves_and_comparisons() {
        let mut trial = Adjustment::new(&plan(), &Level::from([("omega0".to_owned(), 1.0)]));
        trial.next(None);
        for answer in [Answer::Up, Answer::Down, Answer::Down] {
            shown(press(&mut trial, answer));
        }
        let reference = shown(press(&mut trial, Answer::Compare));
        let Presentation::Stimulus(stimulus) = &reference.presentation else { panic!("the reference") };
        assert_eq!((reference.name, stimulus.alternative), (PhaseName::Reference, Alternative::Reference));
        assert!(stimulus.level.is_empty() && reference.asked.is_none() && reference.duration_s.is_none());
        for input in [Input::Elapsed, Input::GazeLeft, Input::Answered { answer: Answer::Up }] {
            assert_eq!(shown(trial.next(Some(&input))), reference);
        }
        shown(press(&mut trial, Answer::Compare));
        shown(press(&mut trial, Answer::Compare));
        // "Go on" from the reference leads back, it does not end.
        shown(press(&mut trial, Answer::Continue));
        let step = press(&mut trial, Answer::Continue);
        let Step::End(Outcome::Answered { answer: Answer::Continue, correct: None, found }) = step else {
            panic!("{step:?}")
        };
        assert_eq!((found["moves"], found["comparisons"]), (3.0, 2.0));
        assert!((found["m"] + 2.5).abs() < 1e-12 && (found["omega0"] - 1.0).abs() < 1e-12);
        assert_eq!(found.len(), 4);
    }

    #[test]
    fn values_stay_in_their_ranges_and_rounding_leaves_no_sliver() {
        let adjusted = Adjusted { parameter: "x".to_owned(), min: 0.0, max: 1.0, step: AdjustmentStep::Add(0.1) };
        let plan = AdjustmentPlan { parameters: vec![adjusted], most_moves: None };
        let mut trial = Adjustment::new(&plan, &Level::from([("x".to_owned(), 0.7)]));
        let mut phase = shown(trial.next(None));
        assert!(!phase.takes(Answer::Select), "there is only one");
        let mut moves = 0;
        // 0.7 + 0.1 + 0.1 + 0.1 is one unit in the last place short of 1.
        while phase.takes(Answer::Up) {
            phase = shown(press(&mut trial, Answer::Up));
            moves += 1;
        }
        assert_eq!((moves, test(&phase).level["x"]), (3, 1.0));
        assert_eq!(shown(press(&mut trial, Answer::Up)), phase);
        assert_eq!(shown(press(&mut trial, Answer::Select)), phase);
    }

    #[test]
    fn at_the_limit_only_comparing_selecting_and_ending_are_left() {
        let mut trial = Adjustment::new(&AdjustmentPlan { most_moves: Some(1), ..plan() }, &Level::new());
        trial.next(None);
        let last = shown(press(&mut trial, Answer::Down));
        assert_eq!(last.accepts, [Answer::Select, Answer::Compare, Answer::Continue]);
        assert_eq!(shown(press(&mut trial, Answer::Up)), last);
    }
}
