//! QUEST+ (Watson 2017): the next stimulus is the one that is expected to leave the least entropy.
//!
//! This file is the engine over tables, for any number of outcomes; it knows no psychometric function, and stimuli and
//! parameter values are only numbers to it, whatever dimensions they come from. Its neighbour [`super::tabulation`] makes
//! the tables.
//!
//! With ψ_o(s, θ) the probability of outcome o, p the posterior and h(s, θ) = −Σ_o ψ_o ln ψ_o, the entropy that is
//! expected after showing s is H(p) + Σ p(θ) h(s, θ) − h(Σ p(θ) ψ(s, θ)), where h(s, θ) is tabulated once. So a choice
//! needs a multiply-add for each outcome and cell of the table, and logarithms for each stimulus but none for each cell.
//!
//! After some trials nearly all parameter values are excluded. Runs of `CHUNK` values that together hold less than
//! `NEGLIGIBLE` of the posterior are left out of the sums; they are still updated, so that they can come back.

use std::sync::Arc;

/// Parameter values that are summed, or left out, together.
const CHUNK: usize = 16;
/// Sums that run side by side, so that the processor need not wait for one addition before the next.
const LANES: usize = 8;
/// The posterior mass below which a chunk is left out. All chunks of a table of 10⁶ parameter values together are then
/// worth less than 10⁻⁸ nats.
const NEGLIGIBLE: f64 = 1e-13;

/// What does not change from trial to trial: outcome probabilities and their entropies.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    stimuli: usize,
    outcomes: usize,
    /// Length of a row: the number of parameter values, filled up with zeros to whole chunks.
    row: usize,
    /// ψ for outcomes 1 and up, a row for each stimulus and outcome; outcome 0 is what they leave.
    probability: Vec<f64>,
    /// h, a row for each stimulus, in nats.
    entropy: Vec<f64>,
    /// Sums to 1.
    prior: Vec<f64>,
}

/// −x ln x, which is 0 at 0.
fn entropy_part(x: f64) -> f64 {
    if x > 0.0 { -x * x.ln() } else { 0.0 }
}

impl Tables {
    /// Tables for `stimuli` stimuli, `outcomes` outcomes (2 or more) and as many parameter values as `prior` has.
    ///
    /// `fill(s, t, p)` sets `p[o - 1]` to the probability of outcome `o` (from 1) for stimulus `s` under parameter value
    /// `t`; outcome 0 has what is left of 1. Negative probabilities count as 0, and such that sum to more than 1 are
    /// divided by their sum. The prior is normalised; one without any mass becomes uniform.
    #[must_use]
    pub fn new(
        stimuli: usize,
        outcomes: usize,
        mut prior: Vec<f64>,
        mut fill: impl FnMut(usize, usize, &mut [f64]),
    ) -> Self {
        let parameters = prior.len();
        normalise(&mut prior, parameters);
        let row = parameters.next_multiple_of(CHUNK);
        let stored = outcomes.max(2) - 1;
        let mut probability = vec![0.0; stimuli * stored * row];
        let mut entropy = vec![0.0; stimuli * row];
        let mut cell = vec![0.0; stored];
        for s in 0..stimuli {
            for t in 0..parameters {
                cell.fill(0.0);
                fill(s, t, &mut cell);
                cell.iter_mut().for_each(|p| *p = p.max(0.0));
                let sum: f64 = cell.iter().sum();
                if sum > 1.0 {
                    cell.iter_mut().for_each(|p| *p /= sum);
                }
                entropy[s * row + t] =
                    entropy_part((1.0 - sum).max(0.0)) + cell.iter().copied().map(entropy_part).sum::<f64>();
                for (o, &p) in cell.iter().enumerate() {
                    probability[(s * stored + o) * row + t] = p;
                }
            }
        }
        prior.resize(row, 0.0);
        Self { stimuli, outcomes: stored + 1, row, probability, entropy, prior }
    }

    /// Tables for two outcomes, failure (0) and success (1); `success(s, t)` is the probability of success.
    #[must_use]
    pub fn of_success(stimuli: usize, prior: Vec<f64>, success: impl Fn(usize, usize) -> f64) -> Self {
        Self::new(stimuli, 2, prior, |s, t, p| p.fill(success(s, t)))
    }

    /// How many stimuli there are.
    #[must_use]
    pub fn stimuli(&self) -> usize {
        self.stimuli
    }

    /// The largest difference between the cells of two tables of the same size.
    #[cfg(test)]
    pub(crate) fn largest_difference(&self, other: &Self) -> f64 {
        assert_eq!((self.stimuli, self.outcomes, self.row), (other.stimuli, other.outcomes, other.row));
        self.probability.iter().zip(&other.probability).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    fn probabilities(&self, stimulus: usize, outcome: usize) -> &[f64] {
        let start = (stimulus * (self.outcomes - 1) + outcome - 1) * self.row;
        &self.probability[start..start + self.row]
    }
}

/// Tables, posterior and choice.
#[derive(Debug, Clone)]
pub struct QuestPlus {
    tables: Arc<Tables>,
    /// Filled up with zeros like the tables' rows.
    posterior: Vec<f64>,
    parameters: usize,
    /// The chunks that are worth summing, in order.
    active: Vec<usize>,
}

impl QuestPlus {
    /// An engine that has seen no answer, over tables for `parameters` parameter values, which others may share.
    #[must_use]
    pub fn new(tables: Arc<Tables>, parameters: usize) -> Self {
        let posterior = tables.prior.clone();
        let mut engine = Self { parameters: parameters.min(posterior.len()), posterior, tables, active: Vec::new() };
        engine.find_active();
        engine
    }

    /// The posterior, in the order of the prior; sums to 1.
    #[must_use]
    pub fn posterior(&self) -> &[f64] {
        &self.posterior[..self.parameters]
    }

    /// The entropy of the posterior, in nats.
    #[must_use]
    pub fn entropy(&self) -> f64 {
        self.posterior.iter().copied().map(entropy_part).sum()
    }

    /// The entropy that is expected after showing `stimulus`, less the present entropy, in nats; never above zero but
    /// for rounding.
    #[must_use]
    pub fn expected_change(&self, stimulus: usize) -> f64 {
        let start = stimulus * self.tables.row;
        let expected = self.mean_of(&self.tables.entropy[start..start + self.tables.row]);
        let mut left = 1.0;
        let mut marginal = 0.0;
        for outcome in 1..self.tables.outcomes {
            let share = self.mean_of(self.tables.probabilities(stimulus, outcome));
            left -= share;
            marginal += entropy_part(share);
        }
        expected - marginal - entropy_part(left.max(0.0))
    }

    /// Of some stimuli, the one with the least expected entropy, the first of equals; nothing of none.
    #[must_use]
    pub fn best_among(&self, stimuli: impl IntoIterator<Item = usize>) -> Option<usize> {
        let changes = stimuli.into_iter().map(|stimulus| (stimulus, self.expected_change(stimulus)));
        changes.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(stimulus, _)| stimulus)
    }

    /// Takes in one answer: outcome 0 is failure of two.
    pub fn update(&mut self, stimulus: usize, outcome: usize) {
        if outcome > 0 {
            for (p, psi) in self.posterior.iter_mut().zip(self.tables.probabilities(stimulus, outcome)) {
                *p *= psi;
            }
        } else if self.tables.outcomes == 2 {
            for (p, psi) in self.posterior.iter_mut().zip(self.tables.probabilities(stimulus, 1)) {
                *p *= 1.0 - psi;
            }
        } else {
            for (t, p) in self.posterior.iter_mut().enumerate() {
                let others = |outcome| self.tables.probabilities(stimulus, outcome)[t];
                *p *= (1.0 - (1..self.tables.outcomes).map(others).sum::<f64>()).max(0.0);
            }
        }
        normalise(&mut self.posterior, self.parameters);
        self.find_active();
    }

    /// The posterior mean of a row.
    fn mean_of(&self, row: &[f64]) -> f64 {
        let mut sums = [0.0; LANES];
        let (row, _) = row.as_chunks::<CHUNK>();
        let (posterior, _) = self.posterior.as_chunks::<CHUNK>();
        for &chunk in &self.active {
            let (row, posterior) = (&row[chunk], &posterior[chunk]);
            for part in (0..CHUNK).step_by(LANES) {
                for lane in 0..LANES {
                    sums[lane] += row[part + lane] * posterior[part + lane];
                }
            }
        }
        sums.iter().sum()
    }

    fn find_active(&mut self) {
        let (chunks, _) = self.posterior.as_chunks::<CHUNK>();
        let counts = chunks.iter().enumerate().filter(|(_, chunk)| chunk.iter().sum::<f64>() >= NEGLIGIBLE);
        self.active.clear();
        self.active.extend(counts.map(|(index, _)| index));
    }
}

/// Divides the first `count` values by their sum. An answer that every parameter value excludes leaves no mass; then all
/// are equal again.
fn normalise(values: &mut [f64], count: usize) {
    let values = &mut values[..count];
    let sum: f64 = values.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        values.iter_mut().for_each(|p| *p /= sum);
    } else {
        values.fill(1.0 / count.max(1) as f64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn engine(tables: Tables, parameters: usize) -> QuestPlus {
        QuestPlus::new(Arc::new(tables), parameters)
    }

    /// Watson 2017's examples: a Weibull in dB, stimuli −40…0, γ = ½; first stimulus and expected entropy in nats.
    fn watson(slopes: &[f64], lapses: &[f64]) -> (f64, f64) {
        let stimuli: Vec<f64> = (0..=40).map(|i| f64::from(i) - 40.0).collect();
        let mut parameters = Vec::new();
        for &threshold in &stimuli {
            for &slope in slopes {
                for &lapse in lapses {
                    parameters.push((threshold, slope, lapse));
                }
            }
        }
        let tables = Tables::of_success(stimuli.len(), vec![1.0; parameters.len()], |s, t| {
            let (threshold, slope, lapse) = parameters[t];
            let miss = (-10f64.powf(slope * (stimuli[s] - threshold) / 20.0)).exp();
            1.0 - lapse - (0.5 - lapse) * miss
        });
        let engine = engine(tables, parameters.len());
        let best = engine.best_among(0..stimuli.len()).expect("stimuli");
        (stimuli[best], engine.entropy() + engine.expected_change(best))
    }

    #[test]
    fn first_choices_are_watsons() {
        for (slopes, lapses, stimulus, entropy) in [
            (vec![3.5], vec![0.02], -18.0, 3.562_727),
            (vec![2.0, 3.0, 4.0, 5.0], vec![0.02], -18.0, 4.952_561),
            (vec![2.0, 3.0, 4.0, 5.0], vec![0.0, 0.01, 0.02, 0.03, 0.04], -18.0, 6.558_884),
        ] {
            let found = watson(&slopes, &lapses);
            println!("slopes {slopes:?} lapses {lapses:?}: {found:?}, published {stimulus} {entropy}");
            assert!((found.0 - stimulus).abs() < 1e-12);
            assert!((found.1 - entropy).abs() < 1e-5);
        }
    }

    /// The expansion equals the definition: expected entropy by updating a copy with each outcome. Two to five outcomes,
    /// parameter counts that fill their chunks and that do not.
    #[test]
    fn expected_entropy_equals_its_definition() {
        for outcomes in 2..=5_usize {
            for parameters in [3, 16, 45] {
                let weight = |s: usize, t: usize, o: usize| 1.0 + ((3 * s + 5 * t + 7 * o) % 11) as f64;
                let prior = (0..parameters).map(|t| 1.0 + (t % 4) as f64).collect();
                let tables = Tables::new(4, outcomes, prior, |s, t, p| {
                    let sum: f64 = (0..outcomes).map(|o| weight(s, t, o)).sum();
                    p.iter_mut().zip(1..).for_each(|(p, o)| *p = weight(s, t, o) / sum);
                });
                let mut engine = engine(tables, parameters);
                engine.update(1, outcomes - 1);
                engine.update(2, 0);
                for s in 0..4 {
                    let direct: f64 = (0..outcomes)
                        .map(|o| {
                            let sum = |t| (0..outcomes).map(|o| weight(s, t, o)).sum::<f64>();
                            let p: f64 =
                                engine.posterior().iter().enumerate().map(|(t, p)| p * weight(s, t, o) / sum(t)).sum();
                            let mut copy = engine.clone();
                            copy.update(s, o);
                            p * copy.entropy()
                        })
                        .sum();
                    let found = engine.entropy() + engine.expected_change(s);
                    assert!((found - direct).abs() < 1e-12, "{outcomes} outcomes: {found} {direct}");
                }
            }
        }
    }

    #[test]
    fn outcome_probabilities_are_made_a_distribution() {
        let tables = Tables::new(1, 3, vec![1.0, 1.0], |_, t, p| p.copy_from_slice(&[[0.9, 0.6], [-0.5, 0.5]][t]));
        let [first, second] = [1, 2].map(|outcome| tables.probabilities(0, outcome)[..2].to_vec());
        for (found, expected) in first.iter().chain(&second).zip([0.6, 0.0, 0.4, 0.5]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn an_impossible_answer_does_not_poison_the_posterior() {
        let mut engine = engine(Tables::of_success(1, vec![1.0, 1.0], |_, _| 1.0), 2);
        engine.update(0, 0);
        assert!(engine.posterior().iter().all(|p| (p - 0.5).abs() < 1e-12));
    }
}
