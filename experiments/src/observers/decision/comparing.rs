//! Comparisons: which of two, with or without "the same", and which way a ramp went.

use super::Dice;
use crate::observers::options::Options;
use crate::trial::{Answer, Asked, Phase, PhaseName};
use std::f64::consts::SQRT_2;

/// An answer to a comparison of two sights, the first `delta` farther from the reference than the second.
///
/// The difference of two looks in SDs of itself is normal around δ/√2. In a share 2λ of the trials the answer is any of
/// those that fit the question, each equally likely; see [`crate::observers::expected`] for what follows.
pub(super) fn compare(
    asked: Asked,
    delta: f64,
    options: &Options,
    lapse: f64,
    accepts: &[Answer],
    dice: &mut Dice,
) -> Option<Answer> {
    // Drawn first, so that answers with and without lapse use the same numbers.
    let lapsed = dice.uniform() < 2.0 * lapse;
    let first_worse = delta / SQRT_2 + dice.normal();
    let (evidence, [yes, no]) = match asked {
        Asked::WhichDegraded | Asked::ToggleDegraded => (first_worse + options.bias, [Answer::First, Answer::Second]),
        // A ramp that was worse at its start has become better; its answers have no side to be biased to.
        Asked::Direction => (first_worse, [Answer::Increased, Answer::Decreased]),
        _ => (-first_worse + options.bias, [Answer::First, Answer::Second]),
    };
    let fitting: Vec<Answer> = [yes, no, Answer::Same].into_iter().filter(|answer| accepts.contains(answer)).collect();
    let zone = if accepts.contains(&Answer::Same) { options.zone } else { 0.0 };
    let answer = match evidence {
        _ if lapsed => return dice.pick(&fitting).or(accepts.first().copied()),
        evidence if evidence.abs() < zone => Answer::Same,
        evidence if evidence > 0.0 => yes,
        _ => no,
    };
    fitting.contains(&answer).then_some(answer).or(accepts.first().copied())
}

/// Looks at each alternative before an answer, at least.
const LOOKS: u32 = 2;
/// Looks at both alternatives before an answer, at most.
const MOST_LOOKS: u32 = 6;

/// How often each alternative of a toggled comparison has been looked at.
#[derive(Debug, Clone, Default)]
pub(super) struct Toggles {
    looks: [u32; 2],
}

impl Toggles {
    /// Counts a look, and says whether it is time to answer: after two or three looks at each.
    pub(super) fn look(&mut self, phase: &Phase, dice: &mut Dice) -> bool {
        match phase.name {
            PhaseName::AlternativeA => self.looks[0] += 1,
            PhaseName::AlternativeB => self.looks[1] += 1,
            _ => {}
        }
        let sure = dice.uniform() < 0.5;
        let may = phase.accepts.contains(&Answer::First) && phase.accepts.contains(&Answer::Second);
        let stuck = !phase.accepts.contains(&Answer::Switch);
        let seen = self.looks.iter().all(|&looks| looks >= LOOKS);
        may && (stuck || (seen && (sure || self.looks.iter().sum::<u32>() >= MOST_LOOKS)))
    }
}
