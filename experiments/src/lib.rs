//! What is asked of an observer, and what was answered.
//!
//! This crate is pure: it knows display geometry, study files, designs, protocols, adaptive procedures, simulated
//! observers and the record of a session, but no GPU, no disk, no clock and no renderer by name. `stimuli` draws what a
//! [`trial::Phase`] presents, `analysis` fits what the [`session::record`] holds, and the lab (the root package) connects
//! them to the world.

pub mod catalogue;
pub mod contrast;
pub mod design;
pub mod display;
pub mod gate;
pub mod mar;
pub mod marks;
pub mod observers;
pub mod procedures;
pub mod session;
pub mod streams;
pub mod study;
pub mod trial;

pub use catalogue::Catalogue;
pub use display::Display;
pub use session::Session;
