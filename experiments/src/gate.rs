//! The fixation gate: has gaze left the place to look at for long enough to count?
//!
//! Pure: it is told angles and times and answers yes or no. Where the place is, a still mark or a moving target, is the
//! caller's to know. The trial machine decides what follows (the stimulus hides, the trial is aborted and queued again);
//! gaze samples come from the lab.

use crate::study::plan::GatePlan;

/// Watches the gaze during an interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    plan: GatePlan,
    away_since_s: Option<f64>,
}

impl Gate {
    /// A gate with gaze taken to be inside.
    #[must_use]
    pub fn new(plan: GatePlan) -> Self {
        Self { plan, away_since_s: None }
    }

    /// The gate's radius and grace.
    #[must_use]
    pub fn plan(&self) -> GatePlan {
        self.plan
    }

    /// Takes one gaze sample: its time in session seconds, and the angle between gaze and the place to look at in degrees,
    /// or `None` (or not a number) where gaze is lost. Answers whether gaze has left: outside the radius or lost,
    /// without a sample inside in between, for longer than the grace. Without a grace the first such sample counts.
    ///
    /// The answer is about now: a sample inside takes it back. Exactly on the radius is inside.
    pub fn update(&mut self, t_s: f64, eccentricity_deg: Option<f64>) -> bool {
        if eccentricity_deg.is_some_and(|angle_deg| angle_deg <= self.plan.radius_deg) {
            self.away_since_s = None;
            return false;
        }
        // Time that runs backwards starts the count again rather than stretching it.
        let since_s = self.away_since_s.filter(|&since_s| since_s <= t_s).unwrap_or(t_s);
        self.away_since_s = Some(since_s);
        self.plan.grace_s <= 0.0 || t_s - since_s > self.plan.grace_s
    }

    /// Forgets what came before, as at the start of an interval.
    pub fn reset(&mut self) {
        self.away_since_s = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gate(grace_s: f64) -> Gate {
        Gate::new(GatePlan { radius_deg: 2.0, grace_s })
    }

    /// Feeds samples at 100 Hz from time 0 and answers at which of them gaze had left.
    fn left_at(gate: &mut Gate, samples: impl IntoIterator<Item = Option<f64>>) -> Vec<usize> {
        let mut left = Vec::new();
        for (i, sample) in samples.into_iter().enumerate() {
            if gate.update(i as f64 * 0.01, sample) {
                left.push(i);
            }
        }
        left
    }

    #[test]
    fn steady_fixation_never_leaves() {
        let mut gate = gate(0.1);
        assert_eq!(gate.plan(), GatePlan { radius_deg: 2.0, grace_s: 0.1 });
        assert!(left_at(&mut gate, (0..100).map(|i| Some(0.02 * f64::from(i)))).is_empty());
        assert!(!gate.update(1.0, Some(2.0)), "the radius itself is inside");
    }

    #[test]
    fn one_noisy_sample_does_not_count() {
        let samples = (0..100).map(|i| Some(if i % 20 == 7 { 15.0 } else { 0.3 }));
        assert!(left_at(&mut gate(0.1), samples).is_empty());
    }

    #[test]
    fn a_blink_shorter_than_the_grace_does_not_count_and_a_longer_one_does() {
        let blink = |from: usize, to: usize| (0..100).map(move |i| (!(from..to).contains(&i)).then_some(0.3));
        // Lost at 0.20, …, 0.34 s: 0.14 s at the last lost sample.
        assert!(left_at(&mut gate(0.15), blink(20, 35)).is_empty());
        // Lost at 0.20, …, 0.39 s: longer than 0.15 s from 0.36 s on, and back inside from 0.40 s.
        assert_eq!(left_at(&mut gate(0.155), blink(20, 40)), [36, 37, 38, 39]);
    }

    #[test]
    fn a_saccade_away_counts_after_the_grace() {
        let samples = (0..20).map(|i| Some(if i < 5 { 0.3 } else { 6.0 }));
        assert_eq!(left_at(&mut gate(0.105), samples), [16, 17, 18, 19]);
    }

    #[test]
    fn outside_and_lost_add_up_and_any_sample_inside_starts_afresh() {
        let mut gate = gate(0.1);
        assert!(!gate.update(0.00, Some(5.0)));
        assert!(!gate.update(0.08, None));
        assert!(gate.update(0.11, Some(f64::NAN)), "not a number is lost");
        assert!(!gate.update(0.12, Some(0.1)));
        assert!(!gate.update(0.20, None));
        assert!(!gate.update(0.29, None));
        assert!(gate.update(0.31, Some(2.1)));
    }

    #[test]
    fn exactly_the_grace_is_allowed() {
        let mut gate = gate(0.25);
        assert!(!gate.update(1.0, None));
        assert!(!gate.update(1.25, None));
        assert!(gate.update(1.2501, None));
    }

    #[test]
    fn without_a_grace_the_first_sample_counts() {
        let mut gate = gate(0.0);
        assert!(!gate.update(0.0, Some(1.9)));
        assert!(gate.update(0.01, Some(2.1)));
        assert!(!gate.update(0.02, Some(1.9)));
        assert!(gate.update(0.03, None));
    }

    #[test]
    fn reset_and_time_running_backwards_start_the_count_again() {
        let mut gate = gate(0.1);
        assert!(!gate.update(0.0, None));
        gate.reset();
        assert!(!gate.update(0.2, None));
        assert!(gate.update(0.31, None));
        assert!(!gate.update(0.1, None), "earlier than the loss began");
        assert!(gate.update(0.21, None));
    }
}
