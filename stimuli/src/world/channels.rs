//! Motion that was recorded: place, turn and scale as separate tracks of keys, as files animate their nodes
//! (glTF 2.0, §3.11 and appendix C).

use glam::{Affine3A, Quat, Vec3};

/// How a track goes from key to key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Interpolation {
    /// Straight; turns go along the great circle.
    Linear,
    /// A value holds until the next key.
    Step,
    /// Cubic Hermite curves; every key has three values: the tangent that comes in, the value, the tangent that goes out.
    Cubic,
}

/// Values by time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Track<T> {
    /// Seconds, rising.
    pub(crate) times_s: Vec<f64>,
    /// One for each time, or three for cubic tracks.
    pub(crate) values: Vec<T>,
    pub(crate) interpolation: Interpolation,
}

/// What tracks are made of.
pub(crate) trait Keyed: Copy {
    /// Between two values, `along` from 0 to 1.
    fn between(self, other: Self, along: f32) -> Self;
    /// A sum with weights, made a value of its kind.
    fn sum(terms: [(f32, Self); 4]) -> Self;
}

impl Keyed for Vec3 {
    fn between(self, other: Self, along: f32) -> Self {
        self.lerp(other, along)
    }

    fn sum(terms: [(f32, Self); 4]) -> Self {
        terms.into_iter().map(|(weight, value)| weight * value).sum()
    }
}

impl Keyed for Quat {
    fn between(self, other: Self, along: f32) -> Self {
        self.slerp(other, along)
    }

    fn sum(terms: [(f32, Self); 4]) -> Self {
        let sum: glam::Vec4 = terms.into_iter().map(|(weight, value)| weight * glam::Vec4::from(value)).sum();
        sum.try_normalize().map_or(Self::IDENTITY, Self::from_vec4)
    }
}

impl<T: Keyed> Track<T> {
    /// The value at `time_s`: before the first key the first one's, after the last key the last one's.
    pub(crate) fn at(&self, time_s: f64) -> Option<T> {
        let value = |key: usize| match self.interpolation {
            Interpolation::Cubic => self.values.get(3 * key + 1).copied(),
            _ => self.values.get(key).copied(),
        };
        let next = self.times_s.partition_point(|&key_s| key_s <= time_s);
        if next == 0 || next == self.times_s.len() {
            return value(next.saturating_sub(1));
        }
        let (from_s, to_s) = (self.times_s[next - 1], self.times_s[next]);
        let span_s = to_s - from_s;
        let t = ((time_s - from_s) / span_s) as f32;
        let (a, b) = (value(next - 1)?, value(next)?);
        Some(match self.interpolation {
            Interpolation::Step => a,
            Interpolation::Linear => a.between(b, t),
            Interpolation::Cubic => {
                let (leaving, arriving) = (*self.values.get(3 * next - 1)?, *self.values.get(3 * next)?);
                let (t2, t3, span) = (t * t, t * t * t, span_s as f32);
                T::sum([
                    (2.0 * t3 - 3.0 * t2 + 1.0, a),
                    (span * (t3 - 2.0 * t2 + t), leaving),
                    (3.0 * t2 - 2.0 * t3, b),
                    (span * (t3 - t2), arriving),
                ])
            }
        })
    }

    /// When it ends, seconds.
    pub(crate) fn end_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or(0.0)
    }
}

/// A place that moves along tracks; what has no track keeps its rest value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Channels {
    /// Where it is without tracks, metres.
    pub(crate) rest_at: Vec3,
    pub(crate) rest_turn: Quat,
    pub(crate) rest_scale: Vec3,
    pub(crate) at: Option<Track<Vec3>>,
    pub(crate) turn: Option<Track<Quat>>,
    pub(crate) scale: Option<Track<Vec3>>,
    /// After so many seconds, counted from 0, it begins anew.
    pub(crate) span_s: f64,
}

impl Channels {
    /// Whether it ever moves.
    pub(crate) fn moves(&self) -> bool {
        fn changes<T: PartialEq>(track: Option<&Track<T>>) -> bool {
            track.is_some_and(|track| track.values.windows(2).any(|pair| pair[0] != pair[1]))
        }
        changes(self.at.as_ref()) || changes(self.turn.as_ref()) || changes(self.scale.as_ref())
    }

    /// From its own space to the one around it at `time_s`.
    pub(crate) fn place(&self, time_s: f64) -> Affine3A {
        let time_s = if self.span_s > 0.0 { time_s.rem_euclid(self.span_s) } else { 0.0 };
        let at = self.at.as_ref().and_then(|track| track.at(time_s)).unwrap_or(self.rest_at);
        let turn = self.turn.as_ref().and_then(|track| track.at(time_s)).unwrap_or(self.rest_turn);
        let scale = self.scale.as_ref().and_then(|track| track.at(time_s)).unwrap_or(self.rest_scale);
        Affine3A::from_scale_rotation_translation(scale, turn, at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halfway between two turns about one axis lies half their angle; a quarter of the way, a quarter.
    #[test]
    fn turns_are_interpolated_on_the_great_circle() {
        let axis = Vec3::new(1.0, -2.0, 0.5).normalize();
        let turn = |degrees: f32| Quat::from_axis_angle(axis, degrees.to_radians());
        let track = Track {
            times_s: vec![1.0, 3.0],
            values: vec![turn(20.0), turn(140.0)],
            interpolation: Interpolation::Linear,
        };
        for (time_s, degrees) in [(0.0, 20.0), (1.0, 20.0), (1.5, 50.0), (2.0, 80.0), (3.0, 140.0), (9.0, 140.0)] {
            let off = (track.at(time_s).unwrap() * Vec3::X).distance(turn(degrees) * Vec3::X);
            assert!(off < 1e-5, "{time_s} s: {off} off");
        }
        // The shorter way round, also where the second quaternion has the other sign.
        let track = Track {
            times_s: vec![0.0, 1.0],
            values: vec![turn(10.0), -turn(50.0)],
            interpolation: Interpolation::Linear,
        };
        assert!((track.at(0.5).unwrap() * Vec3::X).distance(turn(30.0) * Vec3::X) < 1e-5);
    }

    /// A cubic Hermite curve reproduces every polynomial of third degree from its values and slopes: x(t) = t³ − 2t + 1.
    #[test]
    fn cubic_tracks_reproduce_cubics() {
        let x = |t: f32| Vec3::new(t * t * t - 2.0 * t + 1.0, 0.0, 3.0);
        let slope = |t: f32| Vec3::new(3.0 * t * t - 2.0, 0.0, 0.0);
        let keys = [0.5_f32, 1.0, 2.75];
        let track = Track {
            times_s: keys.map(f64::from).to_vec(),
            values: keys.iter().flat_map(|&t| [slope(t), x(t), slope(t)]).collect(),
            interpolation: Interpolation::Cubic,
        };
        let mut worst: f32 = 0.0;
        for i in 0..=90 {
            let t = 0.5 + 0.025 * i as f32;
            worst = worst.max(track.at(f64::from(t)).unwrap().distance(x(t)));
        }
        println!("largest error against the polynomial: {worst:.2e}");
        assert!(worst < 1e-5);
    }

    #[test]
    fn steps_hold_and_motion_begins_anew() {
        let channels = Channels {
            rest_at: Vec3::ZERO,
            rest_turn: Quat::IDENTITY,
            rest_scale: Vec3::splat(2.0),
            at: Some(Track {
                times_s: vec![0.0, 1.0, 2.0],
                values: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                interpolation: Interpolation::Step,
            }),
            turn: None,
            scale: None,
            span_s: 4.0,
        };
        assert!(channels.moves());
        for (time_s, at) in
            [(0.5, Vec3::ZERO), (1.0, Vec3::X), (1.9, Vec3::X), (3.9, Vec3::Y), (4.5, Vec3::ZERO), (-2.5, Vec3::X)]
        {
            let place = channels.place(time_s);
            assert_eq!(Vec3::from(place.translation), at, "{time_s} s");
            assert_eq!(place.transform_vector3(Vec3::X), Vec3::X * 2.0);
        }
    }
}
