//! What every simulated observer does, driven by phases made by hand.

mod comparisons;
mod moves;
mod properties;
mod questions;

use super::*;
use crate::catalogue::DetailLaw;
use crate::display::Display;
use crate::study::plan::{Condition, FoveationCentre, Level};
use std::collections::BTreeMap;

/// A condition with a detail law and nothing else of interest.
pub(crate) fn condition(detail: DetailLaw) -> Condition {
    Condition {
        name: "c".to_owned(),
        scene: "s".to_owned(),
        scene_parameters: BTreeMap::new(),
        renderer: "r".to_owned(),
        renderer_parameters: BTreeMap::new(),
        detail,
        fixation: Fixation::Cross,
        foveation: FoveationCentre::Gaze,
    }
}

/// The law of a ring.
pub(crate) fn ring() -> DetailLaw {
    DetailLaw::Ring {
        eccentricity: "eccentricity_deg".to_owned(),
        width: "width_deg".to_owned(),
        mar: "mar_deg".to_owned(),
    }
}

/// A trial of a level.
pub(crate) fn trial(number: u32, order: [Alternative; 2], level: Level) -> Trial {
    Trial {
        trial: number,
        block: "main".to_owned(),
        practice: false,
        condition: "c".to_owned(),
        factors: BTreeMap::new(),
        level,
        order,
        eccentricity_deg: None,
        mar_deg: None,
        repetition: None,
        path_seed: None,
    }
}

/// What goes with every phase of a trial.
pub(crate) struct Met<'a> {
    pub(crate) trial: &'a Trial,
    pub(crate) condition: &'a Condition,
    pub(crate) level: &'a Level,
    pub(crate) display: &'a Display,
}

impl<'a> Met<'a> {
    pub(crate) fn phase(&self, phase: &'a Phase) -> Presented<'a>
    where
        Self: 'a,
    {
        Presented {
            phase,
            trial: Some(self.trial),
            condition: Some(self.condition),
            level: Some(self.level),
            fixation_deg: [0.0, 0.0],
            display: self.display,
            t_s: 0.0,
        }
    }
}

/// An observer without eyes: sights come from the test.
struct Driven {
    decision: Decision,
    display: Display,
    condition: Condition,
    trial: Trial,
}

impl Driven {
    fn new(options: Options, seed: u64) -> Self {
        let order = [Alternative::Test, Alternative::Reference];
        Self {
            decision: Decision::new(options, seed),
            display: Display::named("demo-540p").expect("ships"),
            condition: condition(ring()),
            trial: trial(0, order, Level::new()),
        }
    }

    fn meet(&mut self, phase: &Phase, delta: f64) -> Response {
        let level = Level::new();
        let met = Met { trial: &self.trial, condition: &self.condition, level: &level, display: &self.display };
        self.decision.meet(&met.phase(phase), Some(Sight { delta, excess: delta }))
    }

    fn say(&mut self, phase: &Phase, delta: f64) -> Answer {
        let (answer, after_s) = self.meet(phase, delta).answer.expect("asked");
        assert!(after_s > 0.0);
        assert!(phase.takes(answer), "{answer:?} is not among {:?}", phase.accepts);
        answer
    }

    fn next_trial(&mut self) {
        self.trial.trial += 1;
    }
}

fn show(name: PhaseName, alternative: Alternative) -> Phase {
    Phase::new(name, Presentation::stimulus(alternative), Some(1.0))
}

fn at(name: PhaseName, level: &[(&str, f64)]) -> Phase {
    let level = level.iter().map(|(parameter, value)| ((*parameter).to_owned(), *value)).collect();
    Phase::new(name, Presentation::Stimulus(Stimulus { level, ..Stimulus::new(Alternative::Test) }), None)
}

fn gap() -> Phase {
    Phase::new(PhaseName::Gap, Presentation::Black, Some(0.5))
}

fn ask(asked: Asked, accepts: &[Answer]) -> Phase {
    Phase::new(PhaseName::Ask, Presentation::Text("?".to_owned()), None).asking(asked, accepts.to_vec())
}

fn within(share: f64, expected: f64, n: u32, what: &str) {
    let sd = (expected * (1.0 - expected) / f64::from(n)).sqrt();
    println!("{what}: {share:.4}, expected {expected:.4} ± {sd:.4}");
    assert!((share - expected).abs() < 4.0 * sd + 1e-9, "{what}: {share} against {expected}");
}

const PAIR: [Answer; 3] = [Answer::First, Answer::Second, Answer::Same];
