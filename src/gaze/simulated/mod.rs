//! A simulated eye behind a simulated tracker: what a gaze-contingent program must withstand, with known truth.
//!
//! The eye ([`SimulatedEye`] has every parameter and its source) drifts, jerks, jumps to new targets and blinks; the
//! tracker samples it on its own clock with noise, loss and delay. Samples depend on the parameters, the generator and
//! what the eye was told to look at and when, never on how often anyone polls. It is no model of attention: it looks
//! where [`GazeSource::look_at`] says, follows what [`GazeSource::pursue`] shows it, and in free viewing goes anywhere.

mod eye;
mod motion;
mod pursuit;
mod random;
mod sphere;
#[cfg(test)]
mod tests;

pub use eye::{EyeMistake, SimulatedEye};

use super::{EyeSample, GazeSample, GazeSource};
use experiments::Display;
use motion::Motion;
use rand_chacha::ChaCha8Rng;
use random::Random;
use serde_json::json;
use sphere::{Direction, direction_from_deg, px_from_direction, stepped};
use std::collections::VecDeque;

/// Instructions kept until the tracker's clock passes them; beyond this the newest replaces the last.
const MAX_WAITING: usize = 4096;

/// What an eye is told.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Told {
    /// Look there.
    LookAt(Direction),
    /// Follow what is there now.
    Pursue(Direction),
    /// Look around.
    LookAround,
}

/// A simulated eye and tracker.
///
/// The tracker's first sample is taken at session time 0, sample k at k / `rate_hz`, and each arrives `latency_s`
/// later.
#[derive(Debug)]
pub struct Simulated {
    eye: SimulatedEye,
    display: Display,
    start_deg: [f64; 2],
    motion: Motion,
    noise: Random,
    loss: Random,
    pupil: Random,
    next_sample: u64,
    /// When the eye was told what, oldest first.
    waiting: VecDeque<(f64, Told)>,
    last_told: Told,
    around: Random,
    /// In free viewing, when the eye wants to look somewhere else, s.
    next_goal_s: Option<f64>,
    last_px: [[f64; 2]; 3],
}

impl Simulated {
    /// An eye that looks at `start_deg` (degrees on `display`) at session time 0, drawing from `generator`: the
    /// session's stream named `gaze`.
    ///
    /// # Errors
    /// Every field of `eye` that is out of its bounds, and `start_deg` when it is not finite.
    pub fn new(
        eye: SimulatedEye,
        display: &Display,
        start_deg: [f64; 2],
        mut generator: ChaCha8Rng,
    ) -> Result<Self, Vec<EyeMistake>> {
        let mut mistakes = eye.mistakes();
        mistakes.extend(start_deg.into_iter().filter(|x| !x.is_finite()).map(|found| EyeMistake {
            field: "start_deg",
            expected: "finite degrees".to_owned(),
            found,
        }));
        if !mistakes.is_empty() {
            return Err(mistakes);
        }
        let start = direction_from_deg(display, start_deg);
        Ok(Self {
            eye,
            display: display.clone(),
            start_deg,
            motion: Motion::new(eye, start, &mut generator),
            noise: Random::split_from(&mut generator),
            loss: Random::split_from(&mut generator),
            pupil: Random::split_from(&mut generator),
            next_sample: 0,
            waiting: VecDeque::new(),
            last_told: Told::LookAt(start),
            // Last, so that eyes which never look around are what they were before there was free viewing.
            around: Random::split_from(&mut generator),
            next_goal_s: None,
            last_px: [display.resolution_px().map(|extent| 0.5 * f64::from(extent)); 3],
        })
    }

    /// The eye's and the tracker's parameters.
    #[must_use]
    pub fn eye(&self) -> &SimulatedEye {
        &self.eye
    }

    /// Turns to one goal after the other, while viewing is free.
    fn look_around_until(&mut self, t_s: f64) {
        while let Some(goal_s) = self.next_goal_s.filter(|&goal_s| goal_s <= t_s) {
            let half_deg = self.display.half_field_deg();
            let goal_deg =
                half_deg.map(|half| half * self.eye.free_viewing_share * (2.0 * self.around.uniform() - 1.0));
            self.motion.look_at(goal_s, direction_from_deg(&self.display, goal_deg));
            let [shortest_s, longest_s] = self.eye.free_viewing_s;
            self.next_goal_s = Some(goal_s + shortest_s + (longest_s - shortest_s) * self.around.uniform());
        }
    }

    /// Notes what the eye is told, in order.
    fn tell(&mut self, now_s: f64, told: Told) {
        self.last_told = told;
        let earliest_s = self.waiting.back().map_or(0.0, |(told_s, _)| *told_s);
        if self.waiting.len() == MAX_WAITING {
            self.waiting.pop_back();
        }
        self.waiting.push_back((now_s.max(earliest_s), told));
    }

    /// Takes the next sample off the tracker's clock.
    fn sample(&mut self, t_s: f64) -> GazeSample {
        // Bring the eye to this instant, through whatever it was told in between.
        while let Some((told_s, told)) = self.waiting.pop_front_if(|(told_s, _)| *told_s <= t_s) {
            self.look_around_until(told_s);
            match told {
                Told::LookAt(goal) => self.motion.look_at(told_s, goal),
                Told::Pursue(target) => self.motion.pursue(told_s, target),
                Told::LookAround => {}
            }
            self.next_goal_s = (told == Told::LookAround).then_some(told_s);
        }
        self.look_around_until(t_s);
        self.motion.advance(t_s);

        // Measure both eyes with independent noise. Every draw is made for every sample, valid or not, so that one
        // parameter never shifts the numbers behind another.
        let seen = stepped(self.motion.direction(), self.eye.bias_deg);
        let sd_deg = 0.5 * self.eye.noise_rms_s2s_deg * std::f64::consts::SQRT_2;
        let error_deg: [[f64; 2]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| sd_deg * self.noise.normal()));
        let pupil_mm: [f64; 2] =
            std::array::from_fn(|_| (self.eye.pupil_mm + self.eye.pupil_noise_mm * self.pupil.normal()).max(0.1));
        let lost = self.loss.uniform() < self.eye.loss_share;
        let valid = self.motion.open() && !lost;

        if valid {
            let mean_deg = std::array::from_fn(|axis| 0.5 * (error_deg[0][axis] + error_deg[1][axis]));
            self.last_px =
                [mean_deg, error_deg[0], error_deg[1]].map(|e| px_from_direction(&self.display, stepped(seen, e)));
        }
        let one_eye = |index: usize| {
            self.eye.binocular.then_some(EyeSample {
                px: self.last_px[1 + index],
                valid,
                pupil_mm: valid.then_some(pupil_mm[index]),
            })
        };
        GazeSample {
            t_s,
            arrived_s: t_s + self.eye.latency_s,
            t_device_s: t_s + self.eye.device_offset_s,
            px: self.last_px[0],
            valid,
            pupil_mm: valid.then_some(0.5 * (pupil_mm[0] + pupil_mm[1])),
            left: one_eye(0),
            right: one_eye(1),
        }
    }
}

impl GazeSource for Simulated {
    fn id(&self) -> &'static str {
        "simulated"
    }

    fn describe(&self) -> serde_json::Value {
        json!({
            "id": self.id(),
            "start_deg": self.start_deg,
            "random_stream": "gaze",
            "eye": self.eye,
        })
    }

    fn poll(&mut self, now_s: f64, out: &mut Vec<GazeSample>) {
        if !now_s.is_finite() {
            return;
        }
        loop {
            let t_s = self.next_sample as f64 / self.eye.rate_hz;
            if t_s + self.eye.latency_s > now_s {
                return;
            }
            self.next_sample += 1;
            let sample = self.sample(t_s);
            out.push(sample);
        }
    }

    /// The eye leaves for the target one saccade latency after `now_s`. Places that are not finite are ignored; those
    /// behind the eye are brought to 80° on each axis.
    fn look_at(&mut self, now_s: f64, target_deg: [f64; 2]) {
        if !now_s.is_finite() || target_deg.iter().any(|x| !x.is_finite()) {
            return;
        }
        // A stage may repeat itself at every frame; only a change reaches the eye, so that frames do not shape samples.
        let told = Told::LookAt(direction_from_deg(&self.display, target_deg));
        if told != self.last_told {
            self.tell(now_s, told);
        }
    }

    /// The eye follows smoothly after a lag, with saccades where it falls behind. Places that are not finite are ignored.
    fn pursue(&mut self, now_s: f64, target_deg: [f64; 2]) {
        if now_s.is_finite() && target_deg.iter().all(|x| x.is_finite()) {
            self.tell(now_s, Told::Pursue(direction_from_deg(&self.display, target_deg)));
        }
    }

    /// The eye turns to one place after the other, anywhere in the middle of the display.
    fn look_around(&mut self, now_s: f64) {
        if now_s.is_finite() && self.last_told != Told::LookAround {
            self.tell(now_s, Told::LookAround);
        }
    }
}
