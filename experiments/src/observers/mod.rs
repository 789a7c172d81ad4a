//! Observers: who answers. A person sits before a window; the observers here are models that answer in their place.
//!
//! A simulated observer meets the same phases and gives the same inputs as a person. One file for each kind.

pub mod mar;

pub use mar::MarObserver;

use crate::session::Trial;
use crate::trial::{Answer, Phase};

/// What an observer meets.
#[derive(Debug, Clone, Copy)]
pub struct Presented<'a> {
    /// The phase that has just begun.
    pub phase: &'a Phase,
    /// The trial it belongs to, if any.
    pub trial: Option<&'a Trial>,
    /// Where the fixation mark stands, degrees.
    pub fixation_deg: [f64; 2],
}

/// What an observer does about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Where they look, degrees.
    pub look_at_deg: [f64; 2],
    /// What they say and how long after the phase began, seconds; nothing if they stay silent.
    pub answer: Option<(Answer, f64)>,
}

/// Somebody who can be asked.
pub trait Observer {
    /// Called once at the start of every phase.
    fn meet(&mut self, presented: &Presented<'_>) -> Response;

    /// What the observer is, with all its parameters, for the session's header.
    fn describe(&self) -> serde_json::Value;
}
