//! Ratings: agreement with "the sequence was free of artifacts", and how sure of it.
//!
//! The first item after a sequence is the agreement. Its evidence is one look, x = δ + ε, cut by equally spaced
//! thresholds into the steps of the scale, the highest step for the smallest x. Any further item is taken as the
//! confidence in that rating: the farther x lies from the nearest threshold, the higher.

use super::Dice;
use crate::observers::options::Options;
use crate::trial::Answer;

/// The threshold between full agreement and the next step, in SDs of one look (our choice): an undisturbed sequence gets
/// full agreement from 69 % of looks.
pub(super) const FIRST_THRESHOLD: f64 = 0.5;
/// Steps of the scale for which the spacing of thresholds is meant; scales of other lengths span the same range.
pub(super) const STEPS: u32 = 7;

/// What was felt about the last sequence.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rating {
    evidence: Option<f64>,
}

impl Rating {
    pub(super) fn rate(
        &mut self,
        delta: f64,
        options: &Options,
        lapse: f64,
        accepts: &[Answer],
        dice: &mut Dice,
    ) -> Option<Answer> {
        let lapsed = dice.uniform() < 2.0 * lapse;
        let noise = dice.normal();
        let mut steps = accepts.to_vec();
        steps.sort_by_key(|answer| if let Answer::Option(value) = answer { *value } else { i32::MIN });
        let thresholds = thresholds(steps.len(), options.spacing);
        let step = match self.evidence {
            None => {
                let evidence = delta + noise;
                self.evidence = Some(evidence);
                (steps.len().checked_sub(1)?) - thresholds.iter().filter(|&&threshold| evidence > threshold).count()
            }
            Some(evidence) => {
                let nearest = thresholds.iter().map(|t| (evidence - t).abs()).fold(f64::INFINITY, f64::min);
                // In the middle between two thresholds one can be as sure as one can be.
                let sure = (nearest / (0.5 * options.spacing)).min(1.0);
                ((steps.len().checked_sub(1)?) as f64 * sure).round() as usize
            }
        };
        if lapsed { dice.pick(&steps) } else { steps.get(step).copied() }
    }
}

/// The thresholds of a scale of `steps` steps, ascending: one fewer than steps, over the range of the seven-step scale.
fn thresholds(steps: usize, spacing: f64) -> Vec<f64> {
    let range = spacing * f64::from(STEPS - 2);
    match steps {
        0 | 1 => Vec::new(),
        2 => vec![FIRST_THRESHOLD + 0.5 * range],
        _ => (0..steps - 1).map(|k| FIRST_THRESHOLD + range * k as f64 / (steps - 2) as f64).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seven_steps_have_six_thresholds_and_other_scales_span_the_same_range() {
        let seven = thresholds(7, 0.75);
        assert_eq!(seven, [0.5, 1.25, 2.0, 2.75, 3.5, 4.25]);
        assert_eq!(thresholds(5, 0.75), [0.5, 1.75, 3.0, 4.25]);
        assert_eq!(thresholds(2, 0.75), [2.375]);
    }
}
