//! From what was seen to what is said: the part that all simulated observers share.
//!
//! An observer turns each stimulus into a [`Sight`]; [`Decision`] remembers the sights of a trial and answers whatever is
//! asked. The noise belongs to the decision, not to the look: however often two alternatives are toggled, a comparison
//! has the same two units of variance, so that one truth means the same in every protocol.
//!
//! Every phase that asks draws one number from the observer's stream, whatever it asks and whatever was seen, and seeds
//! with it the `Dice` of that answer. So an observer that is led through a journal again is where it was.

mod adjusting;
mod comparing;
mod entering;
mod matching;
mod memory;
mod rating;
#[cfg(test)]
pub(crate) mod tests;

use super::options::Options;
use super::{Look, Presented, Response};
use crate::session::Trial;
use crate::streams::Stream;
use crate::study::plan::Fixation;
use crate::trial::{Alternative, Answer, Asked, Phase, PhaseName, Presentation, Stimulus};
use entering::Entering;
use memory::{Glimpse, Memory};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::function::erf::erf_inv;

/// Spread of response times in ln s (our choice; typical of 2AFC answers).
const RESPONSE_SPREAD: f64 = 0.3;
/// How long a page of text is read, seconds.
const PAGE_S: f64 = 1.0;
/// How long a keystroke takes, seconds.
const KEYSTROKE_S: f64 = 0.25;

/// What a look at a picture gave, before any noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// How far the picture is from the reference, in SDs of one look.
    pub delta: f64,
    /// Anything that grows with the degradation, also where `delta` is as good as zero or has stopped growing.
    pub excess: f64,
}

impl Sight {
    /// The reference itself.
    pub const REFERENCE: Self = Self { delta: 0.0, excess: f64::NEG_INFINITY };
}

/// Decides and answers for an observer.
#[derive(Debug, Clone)]
pub struct Decision {
    options: Options,
    rng: ChaCha8Rng,
    memory: Memory,
    entering: Entering,
}

impl Decision {
    /// A decision maker with the `observer` stream of `seed`.
    #[must_use]
    pub fn new(options: Options, seed: u64) -> Self {
        Self {
            options,
            rng: Stream::Observer.generator(seed),
            memory: Memory::default(),
            entering: Entering::default(),
        }
    }

    /// How it decides.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Meets a phase. `sight` is what a test stimulus gave; the reference, and a test of which nothing is known, look like
    /// the reference.
    pub fn meet(&mut self, presented: &Presented<'_>, sight: Option<Sight>) -> Response {
        self.memory.turn_to(presented.trial.map(|trial: &Trial| trial.trial));
        self.memory.phase(presented, sight.unwrap_or(Sight::REFERENCE));
        let typing = matches!(presented.phase.asked, Some(Asked::Count | Asked::Entry));
        if !typing && presented.phase.name != PhaseName::Paused {
            self.entering = Entering::default();
        }
        let answer = match presented.phase.asked {
            Some(asked) => {
                let mut dice = Dice(ChaCha8Rng::seed_from_u64(self.rng.next_u64()));
                self.answer(asked, presented, &mut dice)
            }
            None => {
                let page = matches!(presented.phase.name, PhaseName::Page | PhaseName::Paused);
                let waits = page || presented.phase.accepts.contains(&Answer::Continue);
                waits.then_some((Answer::Continue, PAGE_S))
            }
        };
        Response { look: look(presented), answer }
    }

    /// Corrects what the last stimulus gave, once its pictures have been seen. Whether there was one.
    pub fn see_again(&mut self, sight: Sight) -> bool {
        self.memory.last_mut().map(|glimpse| glimpse.sight = sight).is_some()
    }

    fn answer(&mut self, asked: Asked, presented: &Presented<'_>, dice: &mut Dice) -> Option<(Answer, f64)> {
        let phase = presented.phase;
        let lapse = self.options.lapse_at(presented.t_s);
        let (answer, delta) = match asked {
            Asked::WhichDegraded | Asked::WhichReference | Asked::WhichBetter | Asked::Direction => {
                let [a, b] = self.memory.first_and_last();
                let delta = a.delta - b.delta;
                (comparing::compare(asked, delta, &self.options, lapse, &phase.accepts, dice), delta)
            }
            Asked::ToggleDegraded | Asked::ToggleReference => {
                let delta = self.memory.toggled_difference();
                let done = self.memory.toggles.look(phase, dice);
                let answer = match done {
                    true => comparing::compare(asked, delta, &self.options, lapse, &phase.accepts, dice),
                    false => accepted(phase, &[Answer::Switch, Answer::First]),
                };
                (answer, delta)
            }
            Asked::Match => {
                let (stimulus, sight) = shown(phase, &self.memory);
                let evidence = sight.delta + dice.normal();
                let reference = stimulus.is_none_or(|stimulus| stimulus.alternative == Alternative::Reference);
                (self.memory.matching.act(phase, reference, evidence - self.options.criterion), sight.delta)
            }
            Asked::Adjust => {
                let (stimulus, sight) = shown(phase, &self.memory);
                let evidence = sight.delta + dice.normal();
                let above = evidence - self.options.criterion;
                (self.memory.adjusting.act(phase, stimulus, sight.excess, above), sight.delta)
            }
            Asked::Agreement => {
                let delta = self.memory.last().map_or(0.0, |glimpse| glimpse.sight.delta);
                (self.memory.rating.rate(delta, &self.options, lapse, &phase.accepts, dice), delta)
            }
            Asked::Entry | Asked::Count => {
                let known = (asked == Asked::Count).then(|| self.memory.spheres()).flatten();
                return Some((self.entering.key(phase, asked, known, presented.trial.is_some()), KEYSTROKE_S));
            }
            Asked::Choice => return accepted(phase, &[Answer::Option(1)]).map(|answer| (answer, PAGE_S)),
            Asked::Consent => return accepted(phase, &[Answer::First]).map(|answer| (answer, PAGE_S)),
        };
        let after_s = self.response_time_s(delta, dice);
        answer.map(|answer| (answer, after_s))
    }

    /// A response time: log-normal around a median that doubles from far above threshold to no difference at all,
    /// `response_s` (1 + exp(−|δ|)). Our choice: harder decisions take longer, by about as much.
    fn response_time_s(&self, delta: f64, dice: &mut Dice) -> f64 {
        self.options.response_s * (1.0 + (-delta.abs()).exp()) * (RESPONSE_SPREAD * dice.normal()).exp()
    }
}

/// Where an observer looks.
fn look(presented: &Presented<'_>) -> Look {
    let here = Look::At(presented.fixation_deg);
    match (&presented.phase.presentation, presented.condition.map(|condition| condition.fixation)) {
        (Presentation::Stimulus(Stimulus { letter: None, .. }), Some(Fixation::Free)) => Look::Around,
        (Presentation::Stimulus(Stimulus { letter: None, .. }), Some(Fixation::Moving(_))) => Look::Target,
        _ => here,
    }
}

/// The stimulus on the display and what it gave.
fn shown<'a>(phase: &'a Phase, memory: &Memory) -> (Option<&'a Stimulus>, Sight) {
    match &phase.presentation {
        Presentation::Stimulus(stimulus) => {
            (Some(stimulus), memory.last().map_or(Sight::REFERENCE, |glimpse: &Glimpse| glimpse.sight))
        }
        _ => (None, Sight::REFERENCE),
    }
}

/// The first of these answers that the phase accepts, else whatever it accepts: a trial goes on in any case.
fn accepted(phase: &Phase, wanted: &[Answer]) -> Option<Answer> {
    wanted.iter().find(|answer| phase.accepts.contains(answer)).or(phase.accepts.first()).copied()
}

/// The random numbers of one answer.
#[derive(Debug, Clone)]
struct Dice(ChaCha8Rng);

impl Dice {
    fn uniform(&mut self) -> f64 {
        self.0.random()
    }

    /// A standard normal number.
    fn normal(&mut self) -> f64 {
        let uniform: f64 = self.0.random_range(1e-12..1.0 - 1e-12);
        std::f64::consts::SQRT_2 * erf_inv(2.0 * uniform - 1.0)
    }

    /// One of a list, each equally likely.
    fn pick(&mut self, answers: &[Answer]) -> Option<Answer> {
        match answers.len() {
            0 => None,
            n => Some(answers[self.0.random_range(0..n)]),
        }
    }
}
