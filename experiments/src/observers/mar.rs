//! An observer who sees exactly as the MAR model says: the truth against which a study is tried out.
//!
//! It reads the trial's eccentricity and omega, not the pixels; it is a model of answers, not of seeing.

use super::{Observer, Presented, Response};
use crate::mar::MarModel;
use crate::procedures::mar_quest_plus::GUESS;
use crate::streams::Stream;
use crate::trial::{Alternative, Answer, PhaseName};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use statrs::function::erf::erf_inv;

/// A simulated observer with a known MAR line.
#[derive(Debug, Clone)]
pub struct MarObserver {
    model: MarModel,
    rng: ChaCha8Rng,
}

/// Width in ln omega when a simulation names none.
pub const DEFAULT_WIDTH: f64 = 0.6;
/// Lapse rate when a simulation names none.
pub const DEFAULT_LAPSE: f64 = 0.02;

/// Why a `--simulate` text was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", .0.join("; "))]
pub struct SimulationError(pub Vec<String>);

impl MarObserver {
    /// An observer with this truth and the `observer` stream of `seed`.
    #[must_use]
    pub fn new(model: MarModel, seed: u64) -> Self {
        Self { model, rng: Stream::Observer.generator(seed) }
    }

    /// Reads a truth such as `omega0=0.021,m=0.022,width=0.6,lapse=0.02`; the last two may be left out.
    ///
    /// # Errors
    /// One sentence for every unknown, repeated, missing or impossible entry.
    pub fn parse_model(text: &str) -> Result<MarModel, SimulationError> {
        let mut problems = Vec::new();
        let mut values: [Option<f64>; 4] = [None; 4];
        let fields = [("m", 0.0, 1.0), ("omega0", 1e-4, 10.0), ("width", 0.01, 10.0), ("lapse", 0.0, 0.5)];
        for entry in text.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
            let (name, value) = entry.split_once('=').map_or((entry, ""), |(n, v)| (n.trim(), v.trim()));
            let Some(index) = fields.iter().position(|field| field.0 == name) else {
                problems.push(format!("\"{name}\": expected one of m, omega0, width, lapse"));
                continue;
            };
            let (_, min, max) = fields[index];
            match value.parse::<f64>() {
                Ok(value) if (min..=max).contains(&value) => {
                    if values[index].replace(value).is_some() {
                        problems.push(format!("{name} is given twice"));
                    }
                }
                _ => problems.push(format!("{name}: expected a number from {min} to {max}, found \"{value}\"")),
            }
        }
        for (index, name) in [(0, "m"), (1, "omega0")] {
            if values[index].is_none() && !problems.iter().any(|problem| problem.starts_with(name)) {
                problems.push(format!("{name} is missing; expected for example omega0=0.021,m=0.022"));
            }
        }
        match values {
            [Some(m), Some(omega0_deg), width, lapse] if problems.is_empty() => Ok(MarModel {
                m,
                omega0_deg,
                width: width.unwrap_or(DEFAULT_WIDTH),
                lapse: lapse.unwrap_or(DEFAULT_LAPSE),
            }),
            _ => Err(SimulationError(problems)),
        }
    }

    /// The truth.
    #[must_use]
    pub fn model(&self) -> MarModel {
        self.model
    }

    /// A response time: log-normal around 0.55 s with a spread of 0.3 in ln s (our choice; typical of 2AFC answers).
    fn response_time_s(&mut self) -> f64 {
        let uniform: f64 = self.rng.random_range(1e-6..1.0 - 1e-6);
        let normal = std::f64::consts::SQRT_2 * erf_inv(2.0 * uniform - 1.0);
        0.55 * (0.3 * normal).exp()
    }

    fn choose(&mut self, presented: &Presented<'_>) -> Option<Answer> {
        let trial = presented.trial?;
        let probability = match (trial.eccentricity_deg, trial.mar_deg) {
            (Some(e), Some(omega)) => self.model.probability_correct(e, omega, GUESS),
            _ => GUESS,
        };
        let right = self.rng.random::<f64>() < probability;
        let test_first = trial.order[0] == Alternative::Test;
        Some(if right == test_first { Answer::First } else { Answer::Second })
    }
}

impl Observer for MarObserver {
    fn meet(&mut self, presented: &Presented<'_>) -> Response {
        let answer = match presented.phase.name {
            PhaseName::Page | PhaseName::Paused => Some((Answer::Continue, 1.0)),
            PhaseName::Ask => {
                let choice = self.choose(presented);
                let after_s = self.response_time_s();
                choice.map(|choice| (choice, after_s))
            }
            _ => None,
        };
        Response { look_at_deg: presented.fixation_deg, answer }
    }

    fn describe(&self) -> serde_json::Value {
        serde_json::json!({ "kind": "mar-model", "truth": self.model })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Trial;
    use crate::study::plan::TwoIntervalPlan;
    use crate::trial::two_interval::TwoInterval;
    use crate::trial::{Input, Protocol, Step};

    #[test]
    fn answers_follow_the_model() {
        let model = MarModel { m: 0.022, omega0_deg: 0.021, width: 0.6, lapse: 0.04 };
        let plan = TwoIntervalPlan {
            fixation_s: 0.5,
            interval_s: 0.3,
            gap_s: 0.2,
            answer_timeout_s: None,
            question: String::new(),
            wanted: crate::study::plan::Wanted::Degraded,
        };
        for (seed, factor) in [(1, 0.5), (2, 1.0), (3, 1.4), (4, 5.0)] {
            let mut observer = MarObserver::new(model, seed);
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
                let mut protocol = TwoInterval::new(&plan, order);
                let mut step = protocol.next(None);
                while let Step::Show(phase) = &step
                    && phase.name != PhaseName::Ask
                {
                    step = protocol.next(Some(&Input::Elapsed));
                }
                let Step::Show(phase) = step else { panic!("asked") };
                let trial = Trial {
                    trial: index,
                    block: "main".to_owned(),
                    practice: false,
                    condition: "c".to_owned(),
                    level: Default::default(),
                    order,
                    eccentricity_deg: Some(8.0),
                    mar_deg: Some(omega),
                    factors: Default::default(),
                    repetition: None,
                    path_seed: None,
                };
                let presented = Presented { phase: &phase, trial: Some(&trial), fixation_deg: [0.0, 0.0] };
                let (answer, after_s) = observer.meet(&presented).answer.expect("answers");
                assert!(after_s > 0.0);
                right += u32::from((answer == Answer::First) == test_first);
            }
            let share = f64::from(right) / f64::from(n);
            let sd = (expected * (1.0 - expected) / f64::from(n)).sqrt();
            println!("seed {seed}: {share:.4} right, model {expected:.4} ± {sd:.4}");
            assert!((share - expected).abs() < 4.0 * sd, "seed {seed}");
        }
    }

    #[test]
    fn the_truth_is_read_with_all_its_mistakes() {
        let model = MarObserver::parse_model("omega0=0.021, m=0.022").expect("valid");
        assert_eq!(model, MarModel { m: 0.022, omega0_deg: 0.021, width: DEFAULT_WIDTH, lapse: DEFAULT_LAPSE });
        let error = MarObserver::parse_model("omega0=x,slope=2,lapse=0.9").expect_err("four faults");
        assert_eq!(error.0.len(), 4, "{error}");
    }
}
