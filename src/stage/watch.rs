//! Watching the gaze for a session: what the fixation gate says, and which input follows from it in a phase.
//!
//! It has neither clock nor log, and does not know where gaze is to be: the runner tells it the angle to that place.

use experiments::gate::Gate;
use experiments::study::plan::GatePlan;
use experiments::trial::{GazeRule, Input};

/// How long no sample may come before gaze counts as lost, seconds.
const SILENCE_S: f64 = 0.25;

/// The state of a session's gate. Without a gate, gaze is never away and nothing is ever told.
#[derive(Debug)]
pub(super) struct Watch {
    gate: Option<Gate>,
    away: bool,
    /// Whether the present phase has been told that gaze left.
    told_left: bool,
    /// Since when gaze has been inside the gate without a break.
    inside_since_s: f64,
    /// When the last sample came, valid or not.
    last_sample_s: f64,
}

impl Watch {
    pub(super) fn new(gate: Option<GatePlan>, now_s: f64) -> Self {
        Self { gate: gate.map(Gate::new), away: false, told_left: false, inside_since_s: now_s, last_sample_s: now_s }
    }

    /// Takes in a sample of `t_s` that arrived at `now_s`: the angle between gaze and the place to look at, nothing where
    /// gaze was lost.
    pub(super) fn sample(&mut self, t_s: f64, now_s: f64, angle_deg: Option<f64>) {
        self.last_sample_s = now_s;
        self.update(t_s, angle_deg);
    }

    /// Whether the tracker has fallen silent; that is a lost gaze, not a steady one.
    pub(super) fn is_silent(&self, now_s: f64) -> bool {
        now_s - self.last_sample_s > SILENCE_S
    }

    /// Takes in that gaze is there, or nowhere, without a sample.
    pub(super) fn update(&mut self, t_s: f64, angle_deg: Option<f64>) {
        if let Some(gate) = &mut self.gate {
            self.away = gate.update(t_s, angle_deg);
        }
    }

    /// What the session is to be told in a phase with this rule.
    pub(super) fn tells(&mut self, rule: GazeRule, now_s: f64) -> Option<Input> {
        if self.away {
            self.inside_since_s = now_s;
        } else {
            self.told_left = false;
        }
        match rule {
            GazeRule::Abort | GazeRule::Hide if self.away && !self.told_left => {
                self.told_left = true;
                Some(Input::GazeLeft)
            }
            GazeRule::AwaitReturn if self.gate.is_some() && !self.away => Some(Input::GazeReturned),
            _ => None,
        }
    }

    /// A phase has begun. One that watches the gaze after one that did not gives it the gate's grace to arrive: nobody has
    /// to look at the mark while answering.
    pub(super) fn phase_began(&mut self, before: GazeRule, now: GazeRule) {
        self.told_left = false;
        if before == GazeRule::Free
            && matches!(now, GazeRule::Abort | GazeRule::Hide)
            && let Some(gate) = &mut self.gate
        {
            gate.reset();
            self.away = false;
        }
    }

    /// From when the time of a phase that holds counts, if it began at `began_s`; nothing while gaze is away.
    pub(super) fn held_since_s(&self, began_s: f64) -> Option<f64> {
        match self.gate {
            Some(_) if self.away => None,
            Some(_) => Some(began_s.max(self.inside_since_s)),
            None => Some(began_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: Option<f64> = Some(0.5);
    const OUTSIDE: Option<f64> = Some(9.0);

    fn watch() -> Watch {
        Watch::new(Some(GatePlan { radius_deg: 2.0, grace_s: 0.105 }), 0.0)
    }

    /// Feeds the same sample at 100 Hz and collects what is told, with the time in hundredths of a second.
    fn fed(
        watch: &mut Watch,
        rule: GazeRule,
        hundredths: std::ops::Range<u32>,
        angle: Option<f64>,
    ) -> Vec<(u32, Input)> {
        let mut told = Vec::new();
        for at in hundredths {
            let t_s = f64::from(at) * 0.01;
            watch.sample(t_s, t_s, angle);
            told.extend(watch.tells(rule, t_s).map(|input| (at, input)));
        }
        told
    }

    #[test]
    fn leaving_is_told_once_and_after_the_grace() {
        for rule in [GazeRule::Abort, GazeRule::Hide] {
            let mut watch = watch();
            assert_eq!(fed(&mut watch, rule, 0..50, INSIDE), []);
            assert_eq!(fed(&mut watch, rule, 50..80, OUTSIDE), [(61, Input::GazeLeft)]);
            // Back and away again is another time.
            assert_eq!(fed(&mut watch, rule, 80..90, INSIDE), []);
            assert_eq!(fed(&mut watch, rule, 90..120, None), [(101, Input::GazeLeft)]);
        }
    }

    #[test]
    fn a_hidden_stimulus_comes_back_with_the_first_sample_inside() {
        let mut watch = watch();
        assert_eq!(fed(&mut watch, GazeRule::Hide, 0..20, OUTSIDE), [(11, Input::GazeLeft)]);
        watch.phase_began(GazeRule::Hide, GazeRule::AwaitReturn);
        assert_eq!(fed(&mut watch, GazeRule::AwaitReturn, 20..60, OUTSIDE), []);
        assert_eq!(fed(&mut watch, GazeRule::AwaitReturn, 60..61, INSIDE), [(60, Input::GazeReturned)]);
        watch.phase_began(GazeRule::AwaitReturn, GazeRule::Hide);
        assert_eq!(fed(&mut watch, GazeRule::Hide, 61..90, INSIDE), []);
    }

    #[test]
    fn free_and_holding_phases_are_told_nothing() {
        let mut watch = watch();
        assert_eq!(fed(&mut watch, GazeRule::Free, 0..50, OUTSIDE), []);
        assert_eq!(fed(&mut watch, GazeRule::Hold, 50..100, OUTSIDE), []);
        assert_eq!(watch.held_since_s(0.2), None);
        fed(&mut watch, GazeRule::Hold, 100..101, INSIDE);
        let since_s = watch.held_since_s(0.2).expect("inside");
        assert!((since_s - 0.99).abs() < 1e-9, "inside since the last sample away: {since_s}");
    }

    /// Regression: a trial without fixation began while the observer still looked at the keyboard, and ended at once.
    #[test]
    fn gaze_has_the_grace_to_arrive_after_a_phase_that_did_not_watch() {
        let mut watch = watch();
        fed(&mut watch, GazeRule::Free, 0..100, OUTSIDE);
        watch.phase_began(GazeRule::Free, GazeRule::Abort);
        assert_eq!(fed(&mut watch, GazeRule::Abort, 100..109, OUTSIDE), []);
        assert_eq!(fed(&mut watch, GazeRule::Abort, 109..150, INSIDE), []);
        // From one watching phase to the next nothing is forgotten.
        assert_eq!(fed(&mut watch, GazeRule::Abort, 150..158, OUTSIDE), []);
        watch.phase_began(GazeRule::Abort, GazeRule::Abort);
        assert_eq!(fed(&mut watch, GazeRule::Abort, 158..170, OUTSIDE), [(161, Input::GazeLeft)]);
    }

    #[test]
    fn without_a_gate_nothing_is_told() {
        let mut watch = Watch::new(None, 0.0);
        for rule in [GazeRule::Free, GazeRule::Hold, GazeRule::Abort, GazeRule::Hide, GazeRule::AwaitReturn] {
            assert_eq!(fed(&mut watch, rule, 0..100, None), []);
        }
        assert_eq!(watch.held_since_s(0.2), Some(0.2));
    }

    #[test]
    fn a_tracker_is_silent_after_a_quarter_of_a_second() {
        let mut watch = watch();
        watch.sample(0.99, 1.0, INSIDE);
        assert!(!watch.is_silent(1.2) && watch.is_silent(1.26));
        watch.update(1.26, None);
        watch.update(1.4, None);
        assert_eq!(watch.tells(GazeRule::Hide, 1.4), Some(Input::GazeLeft));
    }
}
