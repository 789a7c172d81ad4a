//! The lab: everything of Parafovea that touches the world.
//!
//! `experiments` says what is asked, `stimuli` draws it, `analysis` fits it; this crate connects them to windows, eye
//! trackers, disks and the terminal. One folder for each side of the world: [`stage`] (where trials happen), [`gaze`]
//! (eye trackers), [`session`] (the journal on disk), [`replay`], [`export`], [`mod@bench`] (what renderers cost) and [`cli`]
//! (one file for each command).

pub mod bench;
pub mod cli;
pub mod doctor;
pub mod error;
pub mod export;
pub mod gaze;
mod mistakes;
pub mod power;
pub mod replay;
pub mod report;
pub mod resources;
pub mod results;
pub mod session;
pub mod stage;

pub use error::LabError;
