//! An observer who sees exactly as a chosen truth says: what a study is tried out against.
//!
//! It reads what is shown by its parameters, not the pixels; it is a model of answers, not of seeing.

use super::decision::{Decision, Sight};
use super::expected::delta_from_visibility;
use super::options::Options;
use super::truth::{Truth, View};
use super::{Observer, Presented, Response};
use crate::mar::standard_normal_cdf;
use crate::trial::{Alternative, Presentation};

/// A simulated observer with a known truth.
///
/// In a forced choice against the reference its answers follow ψ = ½ + (½ − λ) F exactly; see
/// [`super::expected`] for that and for what follows in other comparisons.
#[derive(Debug, Clone)]
pub struct ParametricObserver {
    truth: Truth,
    decision: Decision,
}

impl ParametricObserver {
    /// An observer with this truth and the `observer` stream of `seed`. The lapse rate is the truth's.
    #[must_use]
    pub fn new(truth: Truth, options: Options, seed: u64) -> Self {
        let options = Options { lapse: truth.lapse(), ..options };
        Self { truth, decision: Decision::new(options, seed) }
    }

    /// The truth.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// How it decides.
    #[must_use]
    pub fn options(&self) -> &Options {
        self.decision.options()
    }

    fn sight(&self, presented: &Presented<'_>) -> Option<Sight> {
        let Presentation::Stimulus(stimulus) = &presented.phase.presentation else { return None };
        if stimulus.alternative == Alternative::Reference {
            return Some(Sight::REFERENCE);
        }
        let view = View { display: presented.display, fixation_deg: presented.fixation_deg };
        let excess = self.truth.excess(presented.condition?, presented.level?, view)?;
        Some(Sight { delta: delta_from_visibility(standard_normal_cdf(excess)), excess })
    }
}

impl Observer for ParametricObserver {
    fn meet(&mut self, presented: &Presented<'_>) -> Response {
        let sight = self.sight(presented);
        self.decision.meet(presented, sight)
    }

    /// `truth` holds the MAR model or the parameter's threshold. What the truth cannot place (a renderer that does not say
    /// what it removes, a level without the parameter) looks like the reference to this observer.
    fn describe(&self) -> serde_json::Value {
        let kind = match self.truth {
            Truth::Mar(_) => "mar-model",
            Truth::Parameter(_) => "parameter-threshold",
        };
        serde_json::json!({
            "kind": kind,
            "truth": self.truth,
            "options": self.decision.options(),
            "unknown": "looks like the reference",
        })
    }

    fn fork(&self) -> Box<dyn Observer> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::Display;
    use crate::mar::MarModel;
    use crate::observers::decision::tests::{condition, ring, trial};
    use crate::procedures::mar_quest_plus::GUESS;
    use crate::study::plan::{Level, TwoIntervalPlan, Wanted};
    use crate::trial::two_interval::TwoInterval;
    use crate::trial::{Answer, Input, PhaseName, Protocol, Step};

    #[test]
    fn answers_follow_the_model() {
        let model = MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.04 };
        let plan = TwoIntervalPlan {
            fixation_s: 0.5,
            interval_s: 0.3,
            gap_s: 0.2,
            answer_timeout_s: None,
            question: String::new(),
            wanted: Wanted::Degraded,
        };
        let display = Display::named("demo-540p").expect("ships");
        let condition = condition(ring());
        for (seed, factor) in [(1, 0.5), (2, 1.0), (3, 1.4), (4, 5.0)] {
            let mut observer = ParametricObserver::new(Truth::Mar(model), Options::default(), seed);
            let omega = factor * model.threshold_deg(8.0);
            let expected = model.probability_correct(8.0, omega, GUESS);
            let mut right = 0;
            let n = 4000;
            for index in 0..n {
                let test_first = index % 3 == 0;
                let order = if test_first {
                    [Alternative::Test, Alternative::Reference]
                } else {
                    [Alternative::Reference, Alternative::Test]
                };
                let level = Level::from([("eccentricity_deg".to_owned(), 8.0), ("mar_deg".to_owned(), omega)]);
                let trial = trial(index, order, level.clone());
                let mut protocol = TwoInterval::new(&plan, order);
                let mut step = protocol.next(None);
                let answer = loop {
                    let Step::Show(phase) = &step else { panic!("asked before it ends") };
                    let presented = Presented {
                        phase,
                        trial: Some(&trial),
                        condition: Some(&condition),
                        level: Some(&level),
                        fixation_deg: [0.0, 0.0],
                        display: &display,
                        t_s: 0.0,
                    };
                    let response = observer.meet(&presented);
                    if phase.name == PhaseName::Ask {
                        let (answer, after_s) = response.answer.expect("answers");
                        assert!(after_s > 0.0);
                        break answer;
                    }
                    assert_eq!(response.answer, None);
                    step = protocol.next(Some(&Input::Elapsed));
                };
                right += u32::from((answer == Answer::First) == test_first);
            }
            let share = f64::from(right) / f64::from(n);
            let sd = (expected * (1.0 - expected) / f64::from(n)).sqrt();
            println!("seed {seed}: {share:.4} right, model {expected:.4} ± {sd:.4}");
            assert!((share - expected).abs() < 4.0 * sd, "seed {seed}");
        }
    }

    /// Reports read the planted truth from a session's header as a MAR model.
    #[test]
    fn a_mar_truth_is_described_as_its_model() {
        let model = MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.02 };
        let described = ParametricObserver::new(Truth::Mar(model), Options::default(), 1).describe();
        assert_eq!(serde_json::from_value::<MarModel>(described["truth"].clone()).expect("a model"), model);
        assert_eq!(described["options"]["zone"], crate::observers::options::DEFAULT_ZONE);
    }
}
