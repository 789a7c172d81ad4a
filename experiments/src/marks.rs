//! What is drawn over a picture and where observers are to look: fixation cross, moving target, letters, spheres to count.
//!
//! All of it is a function of the plan, the trial and the animation time, so that a replay shows the same without a log of
//! its own.

use crate::study::plan::{Condition, Fixation, MovingTarget};
use crate::trial::{Presentation, Stimulus};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Something drawn over a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// The fixation mark.
    Fixation {
        /// Its middle, degrees from the display's centre.
        at_deg: [f64; 2],
    },
    /// A letter in place of the fixation mark.
    Letter {
        /// Its middle, degrees from the display's centre.
        at_deg: [f64; 2],
        /// The letter.
        letter: char,
    },
    /// A shaded sphere.
    Sphere {
        /// Its middle, degrees from the display's centre.
        at_deg: [f64; 2],
        /// Its diameter, degrees.
        diameter_deg: f64,
        /// Its colour, sRGB.
        colour: [u8; 3],
    },
}

/// The colour of the moving target: green, as in Weier 2016, §4.2.1.
pub const TARGET_COLOUR: [u8; 3] = [40, 200, 60];

/// The colours of spheres to count.
const SPHERE_COLOURS: [[u8; 3]; 6] =
    [[220, 50, 47], [38, 139, 210], [240, 190, 20], [133, 60, 180], [20, 160, 150], [230, 110, 20]];

/// What is drawn over a presentation, `animation_s` seconds into its scene.
///
/// `path_seed` is the trial's; `fixation_deg` the study's; `half_field_deg` half the display's width and height.
#[must_use]
pub fn marks(
    presentation: &Presentation,
    condition: Option<&Condition>,
    path_seed: Option<u64>,
    fixation_deg: [f64; 2],
    half_field_deg: [f64; 2],
    animation_s: f64,
) -> Vec<Mark> {
    let fixation = condition.map_or(Fixation::Cross, |condition| condition.fixation);
    let goal = look_at_deg(fixation, path_seed, fixation_deg, animation_s);
    match presentation {
        Presentation::Fixation => match fixation {
            // The eye is to start where the target starts.
            Fixation::Moving(target) => {
                let at_deg = look_at_deg(fixation, path_seed, fixation_deg, 0.0);
                vec![Mark::Sphere { at_deg, diameter_deg: target.diameter_deg, colour: TARGET_COLOUR }]
            }
            Fixation::Cross | Fixation::Free => vec![Mark::Fixation { at_deg: fixation_deg }],
        },
        Presentation::Stimulus(Stimulus { letter, spheres, .. }) => {
            let mut marks: Vec<Mark> = match (letter, fixation) {
                (Some(letter), _) => vec![Mark::Letter { at_deg: fixation_deg, letter: *letter }],
                (None, Fixation::Cross) => vec![Mark::Fixation { at_deg: fixation_deg }],
                (None, Fixation::Moving(target)) => {
                    vec![Mark::Sphere { at_deg: goal, diameter_deg: target.diameter_deg, colour: TARGET_COLOUR }]
                }
                (None, Fixation::Free) => Vec::new(),
            };
            marks.extend(spheres.iter().flat_map(|spheres| spheres.visible_at(animation_s, half_field_deg)));
            marks
        }
        _ => Vec::new(),
    }
}

/// Where observers are to look: the fixation mark, or the moving target. With free viewing it is the mark from which
/// viewing starts.
#[must_use]
pub fn look_at_deg(fixation: Fixation, path_seed: Option<u64>, fixation_deg: [f64; 2], animation_s: f64) -> [f64; 2] {
    match fixation {
        Fixation::Moving(target) => {
            let [x, y] = TargetPath::new(target, path_seed.unwrap_or(0)).at(animation_s);
            [fixation_deg[0] + x, fixation_deg[1] + y]
        }
        Fixation::Cross | Fixation::Free => fixation_deg,
    }
}

/// Sinusoids in each coordinate of a path.
const WAVES: usize = 3;

/// A smooth path around the fixation mark: a sum of slow sinusoids in each coordinate, different for every seed.
///
/// It never leaves `reach_deg`, has no corners, and its speed is `speed_deg_s` in the root mean square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetPath {
    /// Amplitude in degrees, angular frequency in radians per second, phase in radians.
    waves: [[(f64, f64, f64); WAVES]; 2],
}

impl TargetPath {
    /// The path of a seed.
    #[must_use]
    pub fn new(target: MovingTarget, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut waves = [[(0.0, 0.0, 0.0); WAVES]; 2];
        for (axis, waves) in waves.iter_mut().enumerate() {
            let weights: [f64; WAVES] = std::array::from_fn(|_| rng.random_range(0.5..1.0));
            let sum: f64 = weights.iter().sum();
            for (index, (wave, weight)) in waves.iter_mut().zip(weights).enumerate() {
                // Frequencies near 1, 2 and 3, none a multiple of another, so that the path does not close.
                let frequency = (index as f64 + 1.0) * rng.random_range(0.8..1.2);
                *wave = (target.reach_deg[axis] * weight / sum, frequency, rng.random_range(0.0..TAU));
            }
        }
        // Each sinusoid adds (a w)² / 2 to the mean square speed.
        let mean_square: f64 = waves.iter().flatten().map(|(a, w, _)| 0.5 * (a * w).powi(2)).sum();
        let scale = if mean_square > 0.0 { target.speed_deg_s / mean_square.sqrt() } else { 0.0 };
        waves.iter_mut().flatten().for_each(|(_, frequency, _)| *frequency *= scale);
        Self { waves }
    }

    /// Where the target is, degrees from the fixation mark.
    #[must_use]
    pub fn at(&self, t_s: f64) -> [f64; 2] {
        self.waves.map(|waves| waves.iter().map(|(a, w, phase)| a * (w * t_s + phase).sin()).sum())
    }
}

/// Spheres that come and go while a sequence is shown, to be counted (the task of Stengel 2016, §6.2, T1).
///
/// They are drawn over the picture, each at its own place and time, so that the observer has to look around; as many are
/// shown as are to be counted, and the count is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spheres {
    /// Decides places, times and colours.
    pub seed: u64,
    /// How many there are in all.
    pub count: u32,
    /// How long the sequence is, seconds.
    pub sequence_s: f64,
}

/// How long a sphere is there, as a share of the sequence.
const SPHERE_SHARE: f64 = 0.2;
/// The diameter of a sphere, degrees.
const SPHERE_DEG: f64 = 1.2;
/// The share of the display's width and height in which spheres stand.
const SPHERE_FIELD: f64 = 0.8;

impl Spheres {
    /// The spheres that are there at a time.
    #[must_use]
    pub fn visible_at(&self, t_s: f64, half_field_deg: [f64; 2]) -> Vec<Mark> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let length_s = SPHERE_SHARE * self.sequence_s;
        (0..self.count)
            .filter_map(|_| {
                let from_s = rng.random_range(0.0..1.0) * (self.sequence_s - length_s);
                let at_deg = half_field_deg.map(|half| SPHERE_FIELD * half * rng.random_range(-1.0..1.0));
                let colour = SPHERE_COLOURS[rng.random_range(0..SPHERE_COLOURS.len())];
                (t_s >= from_s && t_s < from_s + length_s).then_some(Mark::Sphere {
                    at_deg,
                    diameter_deg: SPHERE_DEG,
                    colour,
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGET: MovingTarget = MovingTarget { speed_deg_s: 5.0, reach_deg: [12.0, 6.0], diameter_deg: 0.8 };

    #[test]
    fn paths_are_smooth_stay_within_reach_and_have_the_speed_that_was_asked_for() {
        for seed in 0..50 {
            let path = TargetPath::new(TARGET, seed);
            let (step_s, n) = (0.01, 100_000);
            let (mut square, mut bend): (f64, f64) = (0.0, 0.0);
            for i in 0..n {
                let [a, b, c] = [0.0, 1.0, 2.0].map(|k| path.at((f64::from(i) + k) * step_s));
                assert!(a[0].abs() <= 12.0 && a[1].abs() <= 6.0, "seed {seed}: {a:?}");
                let v = [0, 1].map(|axis| (b[axis] - a[axis]) / step_s);
                let w = [0, 1].map(|axis| (c[axis] - b[axis]) / step_s);
                square += v[0].powi(2) + v[1].powi(2);
                bend = bend.max((w[0] - v[0]).hypot(w[1] - v[1]) / step_s);
            }
            let rms = (square / f64::from(n)).sqrt();
            assert!((rms - 5.0).abs() < 0.25, "seed {seed}: {rms}");
            // No corners: the acceleration is bounded by amplitude times the square of the fastest frequency.
            assert!(bend < 120.0, "seed {seed}: {bend} degrees per second squared");
        }
    }

    #[test]
    fn another_seed_is_another_path() {
        let at = |seed| TargetPath::new(TARGET, seed).at(1.0);
        assert_eq!(at(3), at(3));
        let mut places: Vec<[f64; 2]> = (0..100).map(at).collect();
        places.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(places.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn every_sphere_comes_and_goes_on_the_display() {
        for seed in 0..20 {
            let spheres = Spheres { seed, count: 7, sequence_s: 20.0 };
            let mut seen: Vec<Mark> = Vec::new();
            for step in 0..=2000 {
                for mark in spheres.visible_at(f64::from(step) * 0.01, [24.0, 14.0]) {
                    let Mark::Sphere { at_deg, .. } = mark else { panic!("spheres only") };
                    assert!(at_deg[0].abs() <= 19.2 && at_deg[1].abs() <= 11.2);
                    if !seen.contains(&mark) {
                        seen.push(mark);
                    }
                }
            }
            assert_eq!(seen.len(), 7, "seed {seed}");
            assert!(spheres.visible_at(20.0, [24.0, 14.0]).is_empty());
        }
    }
}
