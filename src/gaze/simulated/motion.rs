//! How a simulated eye moves: drift, microsaccades, saccades and blinks in continuous time, without a tracker.
//!
//! Events (onsets, landings) fall where chance puts them, between samples too, and drift is stepped exactly from one
//! instant to the next. The tracker in front of the eye, with its rate, noise and delay, is the parent module.

use super::eye::SimulatedEye;
use super::pursuit::Pursuit;
use super::random::Random;
use super::sphere::{Direction, step_deg, stepped};
use rand_chacha::ChaCha8Rng;

/// Saccade latencies are kept within these, in seconds; express saccades begin at about 80 ms (Fischer & Weber 1993).
const LATENCY_BOUNDS_S: (f64, f64) = (0.08, 1.0);

/// The share of a saccade's way that is covered after the share `u` of its time.
///
/// A mixture of a parabolic velocity profile (peak over mean 1.5) and the minimum-jerk one (1.875; Flash & Hogan 1985)
/// that has the wanted ratio; both peak half way, so the ratio of the mixture is exact.
pub(super) fn saccade_progress(u: f64, peak_to_mean: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    let parabolic = (1.875 - peak_to_mean) / 0.375;
    let cubic = u * u * (3.0 - 2.0 * u);
    let quintic = u * u * u * (10.0 + u * (6.0 * u - 15.0));
    parabolic * cubic + (1.0 - parabolic) * quintic
}

/// A ballistic movement along a great circle.
#[derive(Debug, Clone, Copy)]
struct Movement {
    from: Direction,
    way_deg: [f64; 2],
    onset_s: f64,
    landing_s: f64,
    micro: bool,
}

/// A saccade that has been decided and waits for its latency to pass.
#[derive(Debug, Clone, Copy)]
struct Planned {
    onset_s: f64,
    corrective: bool,
}

/// The oculomotor state at one instant.
#[derive(Debug)]
pub(super) struct Motion {
    eye: SimulatedEye,
    now_s: f64,
    /// Where the observer wants to look.
    goal: Direction,
    /// Where the eye is held: the goal, or where a saccade has fallen short of it.
    anchor: Direction,
    /// Step from the anchor to the eye, in degrees, between movements.
    offset_deg: [f64; 2],
    moving: Option<Movement>,
    planned: Option<Planned>,
    pursuit: Option<Pursuit>,
    next_microsaccade_s: f64,
    blink_s: (f64, f64),
    drift: Random,
    micro: Random,
    saccade: Random,
    blink: Random,
}

impl Motion {
    /// An eye at rest on `goal` at time 0.
    pub(super) fn new(eye: SimulatedEye, goal: Direction, generator: &mut ChaCha8Rng) -> Self {
        let mut motion = Self {
            eye,
            now_s: 0.0,
            goal,
            anchor: goal,
            offset_deg: [0.0; 2],
            moving: None,
            planned: None,
            pursuit: None,
            next_microsaccade_s: 0.0,
            blink_s: (0.0, 0.0),
            drift: Random::split_from(generator),
            micro: Random::split_from(generator),
            saccade: Random::split_from(generator),
            blink: Random::split_from(generator),
        };
        motion.next_microsaccade_s = motion.microsaccade_interval_s();
        motion.plan_blink();
        motion
    }

    /// The observer turns to `goal` at `t_s`; the eye follows after a latency.
    ///
    /// A goal that changes while a saccade to the last one is being prepared redirects that saccade without delaying
    /// it, so that a target in steady motion is followed in steps (Becker & Jürgens 1979, without their dead time).
    pub(super) fn look_at(&mut self, t_s: f64, goal: Direction) {
        self.advance(t_s);
        let pursued = self.pursuit.take().is_some();
        if goal == self.goal && !pursued {
            return;
        }
        self.goal = goal;
        if self.planned.is_none_or(|planned| planned.corrective) {
            let onset_s = self.now_s + self.saccade_latency_s();
            self.planned = Some(Planned { onset_s, corrective: false });
        }
    }

    /// What the observer follows is at `target` at `t_s`. The eye moves as fast as the target did a little earlier, and
    /// catches up with a saccade where it falls too far behind.
    pub(super) fn pursue(&mut self, t_s: f64, target: Direction) {
        self.advance(t_s);
        self.goal = target;
        let began = self.pursuit.is_none();
        let (lag_s, gain) = (self.eye.pursuit_lag_s, self.eye.pursuit_gain);
        self.pursuit.get_or_insert_with(Pursuit::default).target_at(self.now_s, target, lag_s, gain);
        let behind_deg = experiments::display::angle_between_deg(self.direction(), target);
        if behind_deg > self.eye.catch_up_threshold_deg && self.moving.is_none() && self.planned.is_none() {
            let latency_s = if began { self.saccade_latency_s() } else { self.eye.corrective_latency_s };
            self.planned = Some(Planned { onset_s: self.now_s + latency_s, corrective: !began });
        }
    }

    /// Moves time forward to `t_s`; earlier times change nothing.
    pub(super) fn advance(&mut self, t_s: f64) {
        while let Some(event_s) = self.next_event_s().filter(|&event_s| event_s <= t_s) {
            self.drift_to(event_s);
            self.happen();
        }
        self.drift_to(t_s);
        while self.blink_s.1 <= self.now_s {
            self.plan_blink();
        }
    }

    /// Where the eye points now.
    pub(super) fn direction(&self) -> Direction {
        match self.moving {
            Some(movement) => {
                let u = (self.now_s - movement.onset_s) / (movement.landing_s - movement.onset_s);
                let share = saccade_progress(u, self.eye.saccade_peak_to_mean);
                stepped(movement.from, movement.way_deg.map(|x| x * share))
            }
            None => stepped(self.anchor, self.offset_deg),
        }
    }

    /// Whether the lids are open now.
    pub(super) fn open(&self) -> bool {
        !(self.blink_s.0 <= self.now_s && self.now_s < self.blink_s.1)
    }

    fn next_event_s(&self) -> Option<f64> {
        let event_s = match (self.moving, self.planned) {
            (Some(movement), _) => movement.landing_s,
            (None, Some(planned)) => planned.onset_s,
            (None, None) => self.next_microsaccade_s,
        };
        // An onset that fell into another movement waits for its landing.
        event_s.is_finite().then_some(event_s.max(self.now_s))
    }

    fn happen(&mut self) {
        match (self.moving.take(), self.planned) {
            (Some(movement), _) => self.land(movement),
            (None, Some(planned)) => self.start_saccade(planned),
            (None, None) => self.start_microsaccade(),
        }
    }

    fn start_saccade(&mut self, planned: Planned) {
        self.planned = None;
        let from = self.direction();
        let scatter = self.eye.saccade_gain_sd * self.saccade.normal();
        let gain = if planned.corrective { 1.0 } else { (self.eye.saccade_gain + scatter).clamp(0.3, 1.5) };
        // A saccade to something that moves aims at where it will be.
        let straight_deg = step_deg(from, self.goal);
        let lasting_s = self.saccade_duration_s(straight_deg);
        let landing_s = self.now_s + lasting_s;
        let aim = self.pursuit.as_ref().map_or(self.goal, |pursuit| pursuit.target_expected_at(landing_s, self.goal));
        self.start(from, step_deg(from, aim).map(|x| x * gain), false);
    }

    fn start_microsaccade(&mut self) {
        let amplitude_deg = self.microsaccade_amplitude_deg();
        let corrective = self.micro.uniform() < self.eye.microsaccade_corrective_share;
        let angle = std::f64::consts::TAU * self.micro.uniform();
        let off_deg = self.offset_deg[0].hypot(self.offset_deg[1]);
        let heading = if corrective && off_deg > 0.0 {
            self.offset_deg.map(|x| -x / off_deg)
        } else {
            [angle.cos(), angle.sin()]
        };
        self.next_microsaccade_s = self.now_s + self.microsaccade_interval_s();
        // The heading is in the anchor's frame; the movement starts at the eye, a fraction of a degree away.
        let from = self.direction();
        let to_deg = std::array::from_fn(|i| self.offset_deg[i] + amplitude_deg * heading[i]);
        let way_deg = step_deg(from, stepped(self.anchor, to_deg));
        self.start(from, way_deg, true);
    }

    fn start(&mut self, from: Direction, way_deg: [f64; 2], micro: bool) {
        let duration_s = self.saccade_duration_s(way_deg);
        self.moving = Some(Movement { from, way_deg, onset_s: self.now_s, landing_s: self.now_s + duration_s, micro });
    }

    fn saccade_duration_s(&self, way_deg: [f64; 2]) -> f64 {
        let amplitude_deg = way_deg[0].hypot(way_deg[1]);
        self.eye.saccade_duration_base_s + self.eye.saccade_duration_per_deg_s * amplitude_deg
    }

    fn land(&mut self, movement: Movement) {
        let landed = stepped(movement.from, movement.way_deg);
        if movement.micro {
            self.offset_deg = step_deg(self.anchor, landed);
            return;
        }
        if self.pursuit.is_some() {
            // Pursuit goes on from here; whether the target was met shows when it is seen next.
            (self.anchor, self.offset_deg) = (landed, [0.0; 2]);
            self.next_microsaccade_s = self.now_s + self.microsaccade_interval_s();
            return;
        }
        let missed_deg = step_deg(self.goal, landed);
        let short = missed_deg[0].hypot(missed_deg[1]) > self.eye.corrective_threshold_deg;
        // While another saccade is due, the eye is held where it is instead of being pulled to a goal far away.
        (self.anchor, self.offset_deg) =
            if short || self.planned.is_some() { (landed, [0.0; 2]) } else { (self.goal, missed_deg) };
        if short && self.planned.is_none() {
            let onset_s = self.now_s + self.eye.corrective_latency_s;
            self.planned = Some(Planned { onset_s, corrective: true });
        }
        self.next_microsaccade_s = self.now_s + self.microsaccade_interval_s();
    }

    /// Drifts, by the exact solution of the Ornstein–Uhlenbeck process, unless a movement is under way.
    fn drift_to(&mut self, t_s: f64) {
        let step_s = t_s - self.now_s;
        if step_s <= 0.0 {
            return;
        }
        let way_deg = self.pursuit.as_mut().map_or([0.0; 2], |pursuit| pursuit.way_deg(self.now_s, t_s));
        self.now_s = t_s;
        if self.moving.is_some() {
            return;
        }
        self.anchor = stepped(self.anchor, way_deg);
        let time_s = self.eye.drift_time_constant_s;
        let kept = (-step_s / time_s).exp();
        let variance_arcmin2 = self.eye.drift_diffusion_arcmin2_s * time_s * -(-2.0 * step_s / time_s).exp_m1();
        let sd_deg = variance_arcmin2.sqrt() / 60.0;
        for offset_deg in &mut self.offset_deg {
            *offset_deg = *offset_deg * kept + sd_deg * self.drift.normal();
        }
    }

    fn saccade_latency_s(&mut self) -> f64 {
        let promptness_hz =
            1.0 / self.eye.saccade_latency_s + self.eye.saccade_promptness_sd_hz * self.saccade.normal();
        // The floor turns the rare impossible promptness into the longest latency.
        (1.0 / promptness_hz.max(1e-3)).clamp(LATENCY_BOUNDS_S.0, LATENCY_BOUNDS_S.1)
    }

    fn microsaccade_interval_s(&mut self) -> f64 {
        if self.eye.microsaccade_rate_hz <= 0.0 {
            return f64::INFINITY;
        }
        let refractory_s = self.eye.microsaccade_refractory_s;
        refractory_s + self.micro.exponential(1.0 / self.eye.microsaccade_rate_hz - refractory_s)
    }

    /// Log-normal, drawn again until it is within bounds; at least every second draw is, so the limit is never met.
    fn microsaccade_amplitude_deg(&mut self) -> f64 {
        for _ in 0..64 {
            let amplitude_deg =
                self.eye.microsaccade_median_deg * (self.eye.microsaccade_log_sd * self.micro.normal()).exp();
            if amplitude_deg <= self.eye.microsaccade_max_deg {
                return amplitude_deg;
            }
        }
        self.eye.microsaccade_max_deg
    }

    fn plan_blink(&mut self) {
        if self.eye.blink_rate_per_min <= 0.0 {
            self.blink_s = (f64::INFINITY, f64::INFINITY);
            return;
        }
        let gap_s = self.blink.exponential(60.0 / self.eye.blink_rate_per_min - self.eye.blink_duration_s);
        let spread_s = self.eye.blink_duration_sd_s * self.blink.normal();
        let onset_s = self.blink_s.1 + gap_s;
        self.blink_s = (onset_s, onset_s + (self.eye.blink_duration_s + spread_s).max(0.05));
    }
}
