//! The ramp test: quality rises or falls in steps with black between them, then "increased, decreased, or the same?"
//! (Guenter 2012, §5: five steps of 5 s from j0 = 22 to j1 or back).
//!
//! The end that stays is in the plan, the other is the trial's level; the order says where the ramp starts. The scene's
//! clock runs on from step to step, through the black too. The paper's threshold, the lowest j1 whose direction was
//! mislabelled or called "the same", is the analysis's to find.

use super::{
    Alternative, Answer, Asked, Found, Input, Outcome, Phase, PhaseName, Presentation, Protocol, SceneClock, Step,
    Stimulus,
};
use crate::study::plan::{Finer, Level, RampPlan};

/// What is shown; steps are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Showing {
    Step(u32),
    /// Black, before this step.
    Black(u32),
    Question,
}

/// One trial of the ramp test.
#[derive(Debug, Clone)]
pub struct Ramp {
    plan: RampPlan,
    first: f64,
    last: f64,
    /// Nothing before the first call.
    showing: Option<Showing>,
}

impl Ramp {
    /// A trial between the plan's quality and the level's: from the plan's if the reference comes first in `order`.
    ///
    /// A level without the parameter, which no checked study has, makes a ramp that stays where it is.
    #[must_use]
    pub fn new(plan: &RampPlan, level: &Level, order: [Alternative; 2]) -> Self {
        let goal = level.get(&plan.parameter).copied().unwrap_or(plan.from);
        let (first, last) = if order[0] == Alternative::Reference { (plan.from, goal) } else { (goal, plan.from) };
        Self { plan: plan.clone(), first, last, showing: None }
    }

    /// The value at a step: equally spaced, both ends exact.
    fn value(&self, step: u32) -> f64 {
        let intervals = self.plan.steps.saturating_sub(1).max(1);
        if step >= intervals && self.plan.steps > 1 {
            return self.last;
        }
        self.first + (self.last - self.first) * f64::from(step) / f64::from(intervals)
    }

    fn truth(&self) -> Answer {
        let rise = match self.plan.finer {
            Finer::Up => self.last - self.first,
            Finer::Down => self.first - self.last,
        };
        if rise > 0.0 {
            Answer::Increased
        } else if rise < 0.0 {
            Answer::Decreased
        } else {
            Answer::Same
        }
    }

    fn show(&mut self, showing: Showing) -> Step {
        self.showing = Some(showing);
        let plan = &self.plan;
        Step::Show(match showing {
            Showing::Step(step) => {
                let stimulus = Stimulus {
                    level: Level::from([(plan.parameter.clone(), self.value(step))]),
                    clock: SceneClock::Trial,
                    ..Stimulus::new(Alternative::Test)
                };
                Phase::new(PhaseName::Step, Presentation::Stimulus(stimulus), Some(plan.step_s))
                    .with_gaze(plan.on_gaze_left.rule())
            }
            Showing::Black(_) => Phase::new(PhaseName::Gap, Presentation::Black, Some(plan.black_s)),
            Showing::Question => {
                Phase::new(PhaseName::Ask, Presentation::Text(plan.question.clone()), plan.answer_timeout_s)
                    .asking(Asked::Direction, vec![Answer::Increased, Answer::Decreased, Answer::Same])
            }
        })
    }
}

impl Protocol for Ramp {
    fn next(&mut self, input: Option<&Input>) -> Step {
        let Some(showing) = self.showing else { return self.show(Showing::Step(0)) };
        match (showing, input) {
            (Showing::Step(step), Some(Input::Elapsed)) if step + 1 < self.plan.steps => {
                self.show(Showing::Black(step + 1))
            }
            (Showing::Step(_), Some(Input::Elapsed)) => self.show(Showing::Question),
            (Showing::Black(step), Some(Input::Elapsed)) => self.show(Showing::Step(step)),
            (Showing::Question, Some(Input::Elapsed)) if self.plan.answer_timeout_s.is_some() => {
                Step::End(Outcome::TimedOut)
            }
            (
                Showing::Question,
                Some(&Input::Answered { answer: answer @ (Answer::Increased | Answer::Decreased | Answer::Same) }),
            ) => Step::End(Outcome::Answered {
                answer,
                correct: Some(answer == self.truth()),
                found: Found::from([("from".to_owned(), self.first), ("to".to_owned(), self.last)]),
            }),
            // Anything else changes nothing: the same phase goes on.
            (showing, _) => self.show(showing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::OnGazeLeft;
    use crate::trial::GazeRule;

    const UP_TO_DOWN: [Alternative; 2] = [Alternative::Reference, Alternative::Test];
    const DOWN_TO_UP: [Alternative; 2] = [Alternative::Test, Alternative::Reference];

    /// Guenter 2012, §5: from j0 = 22 in five steps of 5 s.
    fn plan() -> RampPlan {
        RampPlan {
            parameter: "quality_index".to_owned(),
            from: 22.0,
            finer: Finer::Up,
            steps: 5,
            step_s: 5.0,
            black_s: 0.5,
            answer_timeout_s: Some(8.0),
            question: "Did quality change?".to_owned(),
            on_gaze_left: OnGazeLeft::Ignore,
        }
    }

    fn level(j1: f64) -> Level {
        Level::from([("quality_index".to_owned(), j1)])
    }

    fn phases_until_asked(trial: &mut Ramp) -> Vec<Phase> {
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

    fn values(phases: &[Phase]) -> Vec<f64> {
        let value = |phase: &Phase| match &phase.presentation {
            Presentation::Stimulus(stimulus) => Some(stimulus.level["quality_index"]),
            _ => None,
        };
        phases.iter().filter_map(value).collect()
    }

    #[test]
    fn five_steps_equally_spaced_from_either_end_with_black_between() {
        for (order, expected) in
            [(UP_TO_DOWN, [22.0, 17.5, 13.0, 8.5, 4.0]), (DOWN_TO_UP, [4.0, 8.5, 13.0, 17.5, 22.0])]
        {
            let phases = phases_until_asked(&mut Ramp::new(&plan(), &level(4.0), order));
            assert_eq!(values(&phases), expected);
            let names: Vec<&str> = phases.iter().map(|phase| phase.name.as_str()).collect();
            assert_eq!(names, ["step", "gap", "step", "gap", "step", "gap", "step", "gap", "step", "ask"]);
            for phase in &phases {
                match &phase.presentation {
                    Presentation::Stimulus(stimulus) => {
                        assert_eq!((stimulus.alternative, stimulus.clock), (Alternative::Test, SceneClock::Trial));
                        assert_eq!((phase.duration_s, phase.gaze), (Some(5.0), GazeRule::Free));
                    }
                    Presentation::Black => assert_eq!(phase.duration_s, Some(0.5)),
                    _ => assert_eq!(phase.duration_s, Some(8.0)),
                }
            }
        }
    }

    #[test]
    fn the_ends_are_exact_whatever_the_spacing() {
        for steps in 1..8 {
            let ramp = Ramp::new(&RampPlan { steps, from: 0.1, ..plan() }, &level(0.7), UP_TO_DOWN);
            assert_eq!(ramp.value(0), 0.1);
            assert!(steps == 1 || ramp.value(steps - 1).total_cmp(&0.7).is_eq());
        }
    }

    #[test]
    fn the_truth_is_the_direction_of_quality() {
        use Answer::{Decreased, Increased, Same};
        for (finer, order, j1, truth) in [
            (Finer::Up, UP_TO_DOWN, 4.0, Decreased),
            (Finer::Up, DOWN_TO_UP, 4.0, Increased),
            (Finer::Up, UP_TO_DOWN, 22.0, Same),
            (Finer::Up, DOWN_TO_UP, 22.0, Same),
            (Finer::Down, UP_TO_DOWN, 4.0, Increased),
            (Finer::Down, DOWN_TO_UP, 4.0, Decreased),
        ] {
            for answer in [Increased, Decreased, Same] {
                let mut trial = Ramp::new(&RampPlan { finer, ..plan() }, &level(j1), order);
                phases_until_asked(&mut trial);
                let Step::End(Outcome::Answered { answer: said, correct, found }) =
                    trial.next(Some(&Input::Answered { answer }))
                else {
                    panic!("ended")
                };
                assert_eq!((said, correct), (answer, Some(answer == truth)), "{finer:?} {order:?} {j1}");
                let ends = if order == UP_TO_DOWN { [22.0, j1] } else { [j1, 22.0] };
                assert_eq!([found["from"], found["to"]], ends);
            }
        }
    }

    #[test]
    fn silence_times_out_and_other_inputs_change_nothing() {
        let mut trial = Ramp::new(&plan(), &level(10.0), UP_TO_DOWN);
        let first = trial.next(None);
        for answer in [Answer::Increased, Answer::First, Answer::Up] {
            assert_eq!(trial.next(Some(&Input::Answered { answer })), first);
        }
        let gap = trial.next(Some(&Input::Elapsed));
        assert_eq!(trial.next(Some(&Input::GazeLeft)), gap);
        phases_until_asked(&mut trial);
        assert!(matches!(trial.next(Some(&Input::Answered { answer: Answer::First })), Step::Show(_)));
        assert_eq!(trial.next(Some(&Input::Elapsed)), Step::End(Outcome::TimedOut));
    }

    #[test]
    fn a_level_without_the_parameter_stays_and_is_no_panic() {
        let phases = phases_until_asked(&mut Ramp::new(&plan(), &Level::new(), DOWN_TO_UP));
        assert_eq!(values(&phases), [22.0; 5]);
    }
}
