//! Smooth pursuit: the velocity with which an eye follows a target, a little later and a little slower than the target.
//!
//! It knows the target from places at instants, as an eye is shown them, and holds a velocity until the next place is
//! known. Where the eye is, and when a saccade has to help, is [`super::motion`]'s.

use super::sphere::{Direction, step_deg, stepped};
use std::collections::VecDeque;

/// Places closer in time than this say nothing about velocity, s.
const SHORTEST_STEP_S: f64 = 1e-4;
/// A target that jumps faster than this is not pursued, deg/s: pursuit gives way to saccades well below. Our choice.
const FASTEST_DEG_S: f64 = 100.0;

/// An eye that pursues.
#[derive(Debug, Clone, Default)]
pub(super) struct Pursuit {
    /// When the target was where last.
    seen: Option<(f64, Direction)>,
    /// The target's velocity then, deg/s.
    target_deg_s: [f64; 2],
    /// The eye's velocity now, deg/s, and the velocities that it will take on when.
    eye_deg_s: [f64; 2],
    coming: VecDeque<(f64, [f64; 2])>,
}

impl Pursuit {
    /// The target is here at `t_s`; the eye takes on its velocity, times `gain`, after `lag_s`.
    pub(super) fn target_at(&mut self, t_s: f64, target: Direction, lag_s: f64, gain: f64) {
        if let Some((before_s, before)) = self.seen {
            if t_s - before_s < SHORTEST_STEP_S {
                return;
            }
            let velocity = step_deg(before, target).map(|x| x / (t_s - before_s));
            if velocity[0].hypot(velocity[1]) <= FASTEST_DEG_S {
                self.target_deg_s = velocity;
                self.coming.push_back((t_s + lag_s, velocity.map(|x| gain * x)));
            }
        }
        self.seen = Some((t_s, target));
    }

    /// How far the eye goes from one instant to a later one, deg.
    pub(super) fn way_deg(&mut self, from_s: f64, to_s: f64) -> [f64; 2] {
        let (mut way_deg, mut at_s) = ([0.0; 2], from_s);
        let mut go = |velocity: [f64; 2], until_s: f64| {
            let step_s = (until_s - at_s).max(0.0);
            way_deg = std::array::from_fn(|axis| way_deg[axis] + velocity[axis] * step_s);
            at_s = at_s.max(until_s);
        };
        while let Some((change_s, velocity)) = self.coming.pop_front_if(|(change_s, _)| *change_s <= to_s) {
            go(self.eye_deg_s, change_s);
            self.eye_deg_s = velocity;
        }
        go(self.eye_deg_s, to_s);
        way_deg
    }

    /// Where the target will be if it goes on as it did; `known` before it has moved.
    pub(super) fn target_expected_at(&self, t_s: f64, known: Direction) -> Direction {
        self.seen.map_or(known, |(seen_s, seen)| stepped(seen, self.target_deg_s.map(|x| x * (t_s - seen_s).max(0.0))))
    }
}
