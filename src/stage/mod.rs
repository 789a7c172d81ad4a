//! Where trials happen: a window in real time, or an offscreen target in virtual time.
//!
//! [`launch`] starts a session in either. Both drive the same [`Runner`], which feeds the session machine and the log; [`painter`] turns a phase into a picture
//! for both, and for replays.

pub mod frame_hash;
#[cfg(test)]
pub(crate) mod ghost;
pub mod launch;
pub mod offscreen;
pub mod painter;
mod recent;
pub mod reload;
pub mod runner;
pub mod screens;
pub mod shown;
mod watch;
pub mod window;

pub use painter::{Painter, View};
pub use runner::Runner;
