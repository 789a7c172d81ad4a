//! Where an object is at a time.

use super::channels::Channels;
use glam::{Affine3A, Quat, Vec3};
use std::sync::Arc;

/// A place at every time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Motion {
    /// Always here.
    Still(Affine3A),
    /// Turning at a place.
    Spin {
        /// Where, before it turns.
        at: Affine3A,
        /// The axis in the mesh's space, a unit vector.
        axis: Vec3,
        /// Degrees per second.
        speed_deg_s: f64,
    },
    /// Along keys that repeat, moved by a fixed parent.
    Keys {
        /// Rising times with places; the last is also the first of the next round.
        keys: Vec<Key>,
        /// Smooth between keys, or in steps.
        stepped: bool,
        /// Applied after the keys.
        parent: Affine3A,
    },
    /// Along separate tracks of place, turn and scale.
    Channels(Arc<Channels>),
    /// One motion within another. Many may share the outer one.
    Within(Arc<Motion>, Arc<Motion>),
}

/// A place at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Key {
    pub(crate) time_s: f64,
    pub(crate) at: Vec3,
    pub(crate) turn: Quat,
    pub(crate) scale: Vec3,
}

impl Default for Motion {
    fn default() -> Self {
        Self::Still(Affine3A::IDENTITY)
    }
}

impl Motion {
    /// `inner` within `outer`; as one place where neither moves.
    pub(crate) fn within(outer: &Arc<Self>, inner: Self) -> Self {
        match (outer.as_ref(), &inner) {
            (Self::Still(outer), Self::Still(inner)) => Self::Still(*outer * *inner),
            (Self::Still(outer), _) if *outer == Affine3A::IDENTITY => inner,
            (_, Self::Still(at)) if *at == Affine3A::IDENTITY => outer.as_ref().clone(),
            _ => Self::Within(Arc::clone(outer), Arc::new(inner)),
        }
    }

    /// Whether it ever moves.
    pub(crate) fn moves(&self) -> bool {
        match self {
            Self::Still(_) => false,
            Self::Spin { speed_deg_s, .. } => speed_deg_s.abs() > 0.0,
            Self::Keys { keys, .. } => keys.len() > 1,
            Self::Channels(channels) => channels.moves(),
            Self::Within(outer, inner) => outer.moves() || inner.moves(),
        }
    }

    /// From the mesh's space to the world's at `time_s`.
    pub(crate) fn at(&self, time_s: f64) -> Affine3A {
        match self {
            Self::Still(at) => *at,
            Self::Spin { at, axis, speed_deg_s } => {
                let angle = (speed_deg_s * time_s).rem_euclid(360.0).to_radians() as f32;
                *at * Affine3A::from_quat(Quat::from_axis_angle(*axis, angle))
            }
            Self::Keys { keys, stepped, parent } => *parent * at_keys(keys, *stepped, time_s),
            Self::Channels(channels) => channels.place(time_s),
            Self::Within(outer, inner) => outer.at(time_s) * inner.at(time_s),
        }
    }
}

fn at_keys(keys: &[Key], stepped: bool, time_s: f64) -> Affine3A {
    let (Some(first), Some(last)) = (keys.first(), keys.last()) else { return Affine3A::IDENTITY };
    let span_s = last.time_s - first.time_s;
    let time_s = if span_s > 0.0 { first.time_s + (time_s - first.time_s).rem_euclid(span_s) } else { first.time_s };
    let next = keys.partition_point(|key| key.time_s <= time_s).clamp(1, keys.len().max(2) - 1).min(keys.len() - 1);
    let (a, b) = (&keys[next.saturating_sub(1)], &keys[next]);
    let along = ((time_s - a.time_s) / (b.time_s - a.time_s).max(1e-12)).clamp(0.0, 1.0) as f32;
    let along = if stepped { 0.0 } else { along };
    Affine3A::from_scale_rotation_translation(
        a.scale.lerp(b.scale, along),
        a.turn.slerp(b.turn, along),
        a.at.lerp(b.at, along),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_interpolated_and_repeat() {
        let key =
            |time_s: f64, x: f32| Key { time_s, at: Vec3::new(x, 0.0, 0.0), turn: Quat::IDENTITY, scale: Vec3::ONE };
        let keys = vec![key(0.0, 0.0), key(1.0, 2.0), key(3.0, -2.0)];
        for (stepped, cases) in [
            (false, [(0.0, 0.0), (0.5, 1.0), (2.0, 0.0), (3.5, 1.0), (-1.0, 0.0)]),
            (true, [(0.0, 0.0), (0.5, 0.0), (2.0, 2.0), (3.5, 0.0), (-1.0, 2.0)]),
        ] {
            let motion = Motion::Keys { keys: keys.clone(), stepped, parent: Affine3A::IDENTITY };
            for (time_s, x) in cases {
                let found = motion.at(time_s).translation.x;
                assert!((found - x).abs() < 1e-6, "{time_s} s, stepped {stepped}: {found}, not {x}");
            }
        }
        assert_eq!(
            Motion::Keys { keys: Vec::new(), stepped: false, parent: Affine3A::IDENTITY }.at(1.0),
            Affine3A::IDENTITY
        );
    }
}
