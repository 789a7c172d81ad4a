//! A paired comparison with a task: the task is explained, two sequences are shown with grey and the mark after each, then
//! "first better, equal, or second better?" (Stengel 2016, §6.2, T1, T2, T4–T6).
//!
//! Where spheres are to be counted, the number is asked after each sequence, and the two sequences have spheres of their
//! own. Right is the reference named as the better one, which is what the paper counts against a renderer (§7.2).

use super::form::Form;
use super::likert::numbers;
use super::pair::judged;
use super::{
    Alternative, Answer, Asked, Found, Input, Outcome, Phase, PhaseName, Presentation, Protocol, Step, Stimulus,
};
use crate::marks::Spheres;
use crate::study::plan::{Item, ItemKind, PairedTaskPlan, Task};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The largest number that may be typed for a count.
const LARGEST_COUNT: f64 = 9999.0;
/// The name of the count within its form.
const COUNT: &str = "count";

/// What is shown. Sequences are counted 0 and 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Showing {
    Instructions,
    Sequence(usize),
    Marker(usize),
    Count(usize),
    Question,
}

/// One paired comparison with a task.
#[derive(Debug, Clone)]
pub struct PairedTask {
    plan: PairedTaskPlan,
    order: [Alternative; 2],
    /// The spheres of both sequences, if they are to be counted.
    spheres: Option<[Spheres; 2]>,
    /// The question how many there were.
    form: Form,
    found: Found,
    /// Nothing before the first call.
    showing: Option<Showing>,
}

impl PairedTask {
    /// A trial that shows the two pictures in this order; `path_seed` decides the spheres of the first sequence, its
    /// successor those of the second.
    #[must_use]
    pub fn new(plan: &PairedTaskPlan, order: [Alternative; 2], path_seed: u64) -> Self {
        let spheres = match &plan.task {
            Task::Count { min, max, .. } => Some([path_seed, path_seed.wrapping_add(1)].map(|seed| Spheres {
                seed,
                count: sphere_count(seed, *min, *max),
                sequence_s: plan.sequence_s,
            })),
            Task::FreeViewing { .. } | Task::Follow { .. } => None,
        };
        Self { form: count_form(&plan.task), plan: plan.clone(), order, spheres, found: Found::new(), showing: None }
    }

    fn show(&mut self, showing: Showing) -> Step {
        self.showing = Some(showing);
        let plan = &self.plan;
        Step::Show(match showing {
            Showing::Instructions => Phase {
                accepts: vec![Answer::Continue],
                ..Phase::new(PhaseName::Task, Presentation::Text(plan.task.instructions().to_owned()), None)
            },
            Showing::Sequence(index) => {
                let name = [PhaseName::Interval1, PhaseName::Interval2][index];
                let spheres = self.spheres.map(|spheres| spheres[index]);
                let stimulus = Stimulus { spheres, ..Stimulus::new(self.order[index]) };
                Phase::new(name, Presentation::Stimulus(stimulus), Some(plan.sequence_s))
                    .with_gaze(plan.on_gaze_left.rule())
            }
            Showing::Marker(_) => Phase::new(PhaseName::Marker, Presentation::Fixation, Some(plan.marker_s)),
            Showing::Count(index) => match self.form.phase() {
                Some(phase) => phase,
                None => return self.after(index),
            },
            Showing::Question => {
                Phase::new(PhaseName::Ask, Presentation::Text(plan.question.clone()), plan.answer_timeout_s)
                    .asking(Asked::WhichBetter, vec![Answer::First, Answer::Second, Answer::Same])
            }
        })
    }

    /// After a sequence, its marker and its count.
    fn after(&mut self, index: usize) -> Step {
        self.show(if index == 0 { Showing::Sequence(1) } else { Showing::Question })
    }

    fn after_marker(&mut self, index: usize) -> Step {
        if self.spheres.is_none() {
            return self.after(index);
        }
        self.form = count_form(&self.plan.task);
        self.show(Showing::Count(index))
    }

    /// Notes the count, once it has been given, beside the truth.
    fn note_count(&mut self, index: usize) {
        let count = numbers(&self.form).get(COUNT).copied();
        if let Some((count, spheres)) = count.zip(self.spheres) {
            self.found.insert(format!("count_{}", index + 1), count);
            self.found.insert(format!("spheres_{}", index + 1), f64::from(spheres[index].count));
        }
    }
}

/// How many spheres a seed stands for.
fn sphere_count(seed: u64, min: u32, max: u32) -> u32 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Places and times come from the same seed's first stream; the number must not foretell them.
    rng.set_stream(1);
    if min < max { rng.random_range(min..=max) } else { min }
}

/// "How many?", or a form without items where nothing is counted.
fn count_form(task: &Task) -> Form {
    match task {
        Task::Count { question, .. } => Form::new(&[Item {
            name: COUNT.to_owned(),
            question: question.clone(),
            kind: ItemKind::Number { min: 0.0, max: LARGEST_COUNT, unit: String::new(), whole: true },
        }]),
        Task::FreeViewing { .. } | Task::Follow { .. } => Form::new(&[]),
    }
}

impl Protocol for PairedTask {
    fn next(&mut self, input: Option<&Input>) -> Step {
        let Some(showing) = self.showing else { return self.show(Showing::Instructions) };
        match (showing, input) {
            (Showing::Instructions, Some(Input::Answered { answer: Answer::Continue })) => {
                self.show(Showing::Sequence(0))
            }
            (Showing::Sequence(index), Some(Input::Elapsed)) => self.show(Showing::Marker(index)),
            (Showing::Marker(index), Some(Input::Elapsed)) => self.after_marker(index),
            (Showing::Count(index), Some(&Input::Answered { answer }))
                if self.form.phase().is_some_and(|phase| phase.takes(answer)) =>
            {
                self.form.take(answer);
                self.note_count(index);
                self.show(showing)
            }
            (Showing::Question, Some(Input::Elapsed)) if self.plan.answer_timeout_s.is_some() => {
                Step::End(Outcome::TimedOut)
            }
            (
                Showing::Question,
                Some(&Input::Answered { answer: answer @ (Answer::First | Answer::Second | Answer::Same) }),
            ) => Step::End(judged(self.order, answer, self.found.clone())),
            // Anything else changes nothing: the same phase goes on.
            (showing, _) => self.show(showing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::OnGazeLeft;
    use crate::trial::{GazeRule, SceneClock};

    const ORDERS: [[Alternative; 2]; 2] =
        [[Alternative::Test, Alternative::Reference], [Alternative::Reference, Alternative::Test]];
    const CONTINUE: Input = Input::Answered { answer: Answer::Continue };

    /// T1 of Stengel 2016, §6.2: 20 s.
    fn counting() -> PairedTaskPlan {
        PairedTaskPlan {
            task: Task::Count {
                instructions: "Count the coloured spheres.".to_owned(),
                question: "How many were there?".to_owned(),
                min: 5,
                max: 12,
            },
            sequence_s: 20.0,
            marker_s: 2.0,
            question: "Which looked better?".to_owned(),
            answer_timeout_s: Some(30.0),
            on_gaze_left: OnGazeLeft::Ignore,
        }
    }

    /// T2: 8 s of free viewing.
    fn viewing() -> PairedTaskPlan {
        let task = Task::FreeViewing { instructions: "Look around.".to_owned() };
        PairedTaskPlan { task, sequence_s: 8.0, ..counting() }
    }

    fn shown(step: Step) -> Phase {
        match step {
            Step::Show(phase) => phase,
            Step::End(outcome) => panic!("ended with {outcome:?}"),
        }
    }

    fn type_in(trial: &mut PairedTask, text: &str) -> Step {
        for character in text.chars() {
            shown(trial.next(Some(&Input::Answered { answer: Answer::Typed(character) })));
        }
        trial.next(Some(&CONTINUE))
    }

    fn spheres(phase: &Phase) -> Option<Spheres> {
        let Presentation::Stimulus(stimulus) = &phase.presentation else { panic!("a stimulus") };
        assert_eq!(stimulus.clock, SceneClock::Phase);
        stimulus.spheres
    }

    #[test]
    fn the_task_is_explained_and_each_sequence_followed_by_the_mark() {
        for order in ORDERS {
            let mut trial = PairedTask::new(&viewing(), order, 7);
            let mut phases = vec![shown(trial.next(None)), shown(trial.next(Some(&CONTINUE)))];
            for _ in 0..4 {
                phases.push(shown(trial.next(Some(&Input::Elapsed))));
            }
            let seen: Vec<_> = phases.iter().map(|p| (p.name.as_str(), p.duration_s, p.gaze)).collect();
            assert_eq!(
                seen,
                [
                    ("task", None, GazeRule::Free),
                    ("interval1", Some(8.0), GazeRule::Free),
                    ("marker", Some(2.0), GazeRule::Free),
                    ("interval2", Some(8.0), GazeRule::Free),
                    ("marker", Some(2.0), GazeRule::Free),
                    ("ask", Some(30.0), GazeRule::Free),
                ]
            );
            assert_eq!(phases[0].presentation, Presentation::Text("Look around.".to_owned()));
            assert_eq!(phases[1].presentation, Presentation::stimulus(order[0]));
            assert_eq!(phases[3].presentation, Presentation::stimulus(order[1]));
            assert_eq!(phases[2].presentation, Presentation::Fixation);
        }
    }

    #[test]
    fn counts_are_asked_after_each_sequence_and_found_beside_the_truth() {
        for order in ORDERS {
            let mut trial = PairedTask::new(&counting(), order, 40);
            trial.next(None);
            let first = spheres(&shown(trial.next(Some(&CONTINUE)))).expect("spheres");
            trial.next(Some(&Input::Elapsed));
            let asked = shown(trial.next(Some(&Input::Elapsed)));
            assert_eq!((asked.name, asked.asked), (PhaseName::Form, Some(Asked::Count)));
            // What is no count is asked again.
            assert_eq!(shown(type_in(&mut trial, "x")).name, PhaseName::Form);
            assert_eq!(shown(type_in(&mut trial, "3.5")).name, PhaseName::Form);
            let second = shown(type_in(&mut trial, "7"));
            assert_eq!(second.name, PhaseName::Interval2);
            let second = spheres(&second).expect("spheres");
            assert_eq!((first.seed, second.seed), (40, 41));
            trial.next(Some(&Input::Elapsed));
            assert_eq!(shown(trial.next(Some(&Input::Elapsed))).name, PhaseName::Form);
            assert_eq!(shown(type_in(&mut trial, "11")).name, PhaseName::Ask);
            let step = trial.next(Some(&Input::Answered { answer: Answer::First }));
            let Step::End(Outcome::Answered { answer: Answer::First, correct, found }) = step else {
                panic!("{step:?}")
            };
            assert_eq!(correct, Some(order[0] == Alternative::Reference));
            let expected = [
                ("count_1", 7.0),
                ("count_2", 11.0),
                ("spheres_1", f64::from(first.count)),
                ("spheres_2", f64::from(second.count)),
            ];
            assert_eq!(found, expected.map(|(name, value)| (name.to_owned(), value)).into());
        }
    }

    #[test]
    fn every_number_of_spheres_comes_about_equally_often() {
        let mut counts = [0_u32; 8];
        for seed in 0..4000 {
            counts[sphere_count(seed, 5, 12) as usize - 5] += 1;
        }
        // 500 expected each, with a standard deviation of sqrt(4000 · 1/8 · 7/8) = 20.9; five of them.
        assert!(counts.iter().all(|&count| count.abs_diff(500) < 105), "{counts:?}");
        assert_eq!([sphere_count(3, 6, 6), sphere_count(3, 6, 2)], [6, 6]);
    }

    #[test]
    fn equal_is_not_right_and_silence_times_out() {
        for (answer, right) in [(Answer::First, false), (Answer::Second, true), (Answer::Same, false)] {
            let mut trial = PairedTask::new(&viewing(), ORDERS[0], 1);
            trial.next(None);
            trial.next(Some(&CONTINUE));
            for _ in 0..4 {
                trial.next(Some(&Input::Elapsed));
            }
            let mut silent = trial.clone();
            let outcome = Outcome::Answered { answer, correct: Some(right), found: Found::new() };
            assert_eq!(trial.next(Some(&Input::Answered { answer })), Step::End(outcome));
            assert_eq!(silent.next(Some(&Input::Elapsed)), Step::End(Outcome::TimedOut));
        }
    }

    #[test]
    fn early_keys_change_nothing_and_a_study_may_abort_when_gaze_leaves() {
        let mut trial =
            PairedTask::new(&PairedTaskPlan { on_gaze_left: OnGazeLeft::Abort, ..counting() }, ORDERS[0], 1);
        let task = shown(trial.next(None));
        for input in [Input::Elapsed, Input::GazeLeft, Input::Answered { answer: Answer::First }] {
            assert_eq!(shown(trial.next(Some(&input))), task);
        }
        let sequence = shown(trial.next(Some(&CONTINUE)));
        assert_eq!(sequence.gaze, GazeRule::Abort);
        // A second press of the same key, and a count that comes too early.
        for answer in [Answer::Continue, Answer::Typed('4'), Answer::First] {
            assert_eq!(shown(trial.next(Some(&Input::Answered { answer }))), sequence);
        }
    }
}
