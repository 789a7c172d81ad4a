//! The renderers, one Rust file and one WGSL file each. Add a line to [`crate::registry`] for a new one.

pub(crate) mod layers;
pub(crate) mod reference;
pub(crate) mod ring;
