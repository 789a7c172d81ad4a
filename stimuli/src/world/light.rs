//! Lights other than the sky.

use glam::Vec3;

/// A light. Colours are linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Light {
    /// From infinitely far, as the sun; the first one of a world casts shadows.
    Directional {
        /// Unit vector towards the light.
        towards: Vec3,
        /// What a white matt surface that faces it sends out.
        colour: Vec3,
    },
    /// From a point.
    Point {
        /// Metres.
        at: Vec3,
        /// What a white matt surface that faces it at one metre sends out.
        colour: Vec3,
        /// Distance at which it has faded to nothing, metres.
        reach_m: f32,
    },
    /// From a rectangle that shines to one side.
    Area {
        /// The middle, metres.
        at: Vec3,
        /// From the middle to the edge to the right, seen from the lit side.
        half_right: Vec3,
        /// From the middle to the upper edge; it shines along `half_right` × `half_up`.
        half_up: Vec3,
        /// Its radiance.
        colour: Vec3,
    },
}
