//! QUEST+ (Watson 2017) for two outcomes: the next stimulus is the one that is expected to leave the least entropy.
//!
//! This file is the engine over tables; it knows no psychometric function. Its neighbour [`super::mar_quest_plus`] makes
//! the tables for the MAR model.
//!
//! With ψ(s, θ) the probability of success, p the posterior and h(x) = −x ln x − (1 − x) ln(1 − x), the entropy that is
//! expected after showing s is H(p) + Σ p(θ) h(ψ(s, θ)) − h(Σ p(θ) ψ(s, θ)), where h(ψ) is tabulated once. So a choice
//! needs two multiply-adds for each cell of the table and one logarithm pair for each stimulus, none for each cell.

/// Tables, posterior and choice.
#[derive(Debug, Clone)]
pub struct QuestPlus {
    /// ψ, row by row: one row a stimulus, one column a parameter value.
    success: Vec<f64>,
    /// h(ψ), laid out like `success`.
    outcome_entropy: Vec<f64>,
    posterior: Vec<f64>,
}

/// The entropy of a coin with probability `x`, in nats.
fn coin_entropy(x: f64) -> f64 {
    let part = |x: f64| if x > 0.0 { -x * x.ln() } else { 0.0 };
    part(x) + part(1.0 - x)
}

impl QuestPlus {
    /// An engine for `stimuli` stimuli and as many parameter values as `prior` has.
    ///
    /// `success(s, t)` is the probability of success for stimulus `s` under parameter value `t`. The prior is normalised
    /// here; a prior without any mass becomes uniform.
    #[must_use]
    pub fn new(stimuli: usize, prior: Vec<f64>, success: impl Fn(usize, usize) -> f64) -> Self {
        let parameters = prior.len();
        let mut table = Vec::with_capacity(stimuli * parameters);
        for s in 0..stimuli {
            table.extend((0..parameters).map(|t| success(s, t).clamp(0.0, 1.0)));
        }
        let outcome_entropy = table.iter().map(|&psi| coin_entropy(psi)).collect();
        let mut engine = Self { success: table, outcome_entropy, posterior: prior };
        engine.normalise();
        engine
    }

    /// The posterior, in the order of the prior; sums to 1.
    #[must_use]
    pub fn posterior(&self) -> &[f64] {
        &self.posterior
    }

    /// The entropy of the posterior, in nats.
    #[must_use]
    pub fn entropy(&self) -> f64 {
        self.posterior.iter().filter(|&&p| p > 0.0).map(|&p| -p * p.ln()).sum()
    }

    /// The entropy that is expected after showing `stimulus`, less the present entropy, in nats; never above zero but
    /// for rounding.
    #[must_use]
    pub fn expected_change(&self, stimulus: usize) -> f64 {
        let parameters = self.posterior.len();
        let row = stimulus * parameters..(stimulus + 1) * parameters;
        let dot = |table: &[f64]| table[row.clone()].iter().zip(&self.posterior).map(|(a, p)| a * p).sum::<f64>();
        dot(&self.outcome_entropy) - coin_entropy(dot(&self.success).clamp(0.0, 1.0))
    }

    /// Of some stimuli, the one with the least expected entropy, the first of equals; nothing of none.
    #[must_use]
    pub fn best_among(&self, stimuli: impl IntoIterator<Item = usize>) -> Option<usize> {
        let changes = stimuli.into_iter().map(|stimulus| (stimulus, self.expected_change(stimulus)));
        changes.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(stimulus, _)| stimulus)
    }

    /// Takes in one answer.
    pub fn update(&mut self, stimulus: usize, success: bool) {
        let parameters = self.posterior.len();
        let row = &self.success[stimulus * parameters..(stimulus + 1) * parameters];
        for (p, &psi) in self.posterior.iter_mut().zip(row) {
            *p *= if success { psi } else { 1.0 - psi };
        }
        self.normalise();
    }

    /// Divides by the sum. An answer that every parameter value excludes leaves no mass; then all are equal again.
    fn normalise(&mut self) {
        let sum: f64 = self.posterior.iter().sum();
        if sum > 0.0 && sum.is_finite() {
            self.posterior.iter_mut().for_each(|p| *p /= sum);
        } else {
            let share = 1.0 / self.posterior.len().max(1) as f64;
            self.posterior.fill(share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let engine = QuestPlus::new(stimuli.len(), vec![1.0; parameters.len()], |s, t| {
            let (threshold, slope, lapse) = parameters[t];
            let miss = (-10f64.powf(slope * (stimuli[s] - threshold) / 20.0)).exp();
            1.0 - lapse - (0.5 - lapse) * miss
        });
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

    /// The expansion equals the definition: expected entropy by updating a copy with each outcome.
    #[test]
    fn expected_entropy_equals_its_definition() {
        let mut engine = QuestPlus::new(3, vec![0.2, 0.5, 0.3], |s, t| 0.1 + 0.25 * s as f64 + 0.1 * t as f64);
        engine.update(1, true);
        for s in 0..3 {
            let p_success: f64 = (0..3).map(|t| engine.posterior[t] * engine.success[s * 3 + t]).sum();
            let after = |success| {
                let mut copy = engine.clone();
                copy.update(s, success);
                copy.entropy()
            };
            let direct = p_success * after(true) + (1.0 - p_success) * after(false);
            assert!((engine.entropy() + engine.expected_change(s) - direct).abs() < 1e-12);
        }
    }

    #[test]
    fn an_impossible_answer_does_not_poison_the_posterior() {
        let mut engine = QuestPlus::new(1, vec![1.0, 1.0], |_, _| 1.0);
        engine.update(0, false);
        assert!(engine.posterior().iter().all(|p| (p - 0.5).abs() < 1e-12));
    }
}
