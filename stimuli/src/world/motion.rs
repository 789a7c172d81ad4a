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
    /// Along separate tracks of place, turn and scale.
    Channels(Arc<Channels>),
    /// One motion within another. Many may share the outer one.
    Within(Arc<Motion>, Arc<Motion>),
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
            Self::Channels(channels) => channels.place(time_s),
            Self::Within(outer, inner) => outer.at(time_s) * inner.at(time_s),
        }
    }
}
