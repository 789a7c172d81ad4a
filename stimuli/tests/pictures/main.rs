//! What the pictures must look like: by closed forms, by direct sums on the CPU, and by what must not change. All of it
//! runs on whatever Vulkan, Metal or Direct3D device there is, Mesa's software one included.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "tests print what they measured")]

mod charts;
mod common;
mod contract;
mod falloff;
mod layers;
mod light;
mod models;
mod oracle;
mod ring;
mod scenes;
mod screen;
mod spectrum;
