//! The renderers, one Rust file and one WGSL file each; [`low_passed`] is the filter that the ring and the falloff show. Add a line to
//! [`crate::registry`] for a new one.

pub(crate) mod falloff;
pub(crate) mod layers;
pub(crate) mod low_passed;
pub(crate) mod reference;
pub(crate) mod ring;
pub(crate) mod wgsl;
