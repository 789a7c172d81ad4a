//! What is seen: scenes and foveated renderers on wgpu, their shaders and their assets.
//!
//! [`contract`] holds the two contracts, [`registry`] makes every scene and renderer by name and describes them as data for
//! studies, [`gpu`] opens the device, [`display_pass`] and [`readback`] bring a linear picture to a display or to disk,
//! and [`foveation`] is the mathematics without a GPU. This crate opens no window, reads no clock and writes no file.

#![cfg_attr(test, allow(clippy::print_stdout, reason = "tests print what they measured"))]

pub mod contract;
pub mod display_pass;
pub mod foveation;
pub mod geometry;
pub mod gpu;
pub mod readback;
pub mod registry;
pub mod surfaces;
pub mod tally;
pub mod tone;

#[allow(dead_code, reason = "being built")]
mod mesh_scene;
mod parameters;
mod pass;
mod renderers;
mod scenes;
mod tiles;
mod timing;
#[allow(dead_code, reason = "being built")]
mod world;

pub use contract::{
    DrawCost, DrawRequest, FrameCost, FrameInput, LINEAR_FORMAT, LayerCost, MakeError, MotionRequest, RenderError,
    Renderer, Scene, SceneIdentity, SceneLight, ToneMap, View,
};
pub use display_pass::{Background, Disc, DisplayPass};
pub use foveation::plan::{LayerPlan, optimise};
pub use gpu::{Gpu, GpuError};
pub use registry::{catalogue, make_renderer, make_scene};
pub use world::gltf::{GltfFile, Mistake, Notice, WorldError};
