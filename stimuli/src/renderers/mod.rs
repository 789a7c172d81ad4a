//! The renderers, one Rust file and one WGSL file each; [`low_passed`] is the filter that the ring and the falloff show, and
//! [`wgsl`] makes renderers of WGSL alone. `template.rs` is one to start from: copy it and add a line to [`crate::registry`].

pub(crate) mod falloff;
pub(crate) mod layers;
pub(crate) mod low_passed;
pub(crate) mod reference;
pub(crate) mod ring;
#[cfg(test)]
pub(crate) mod template;
pub(crate) mod wgsl;
