//! Observers: who answers. A person sits before a window; the observers here are models that answer in their place.
//!
//! A simulated observer meets the same phases and gives the same inputs as a person: it knows what a phase shows, asks and
//! accepts, never which protocol it is in. [`ParametricObserver`] knows what is shown by its parameters and sees as a
//! chosen truth says; [`PixelObserver`] looks at the pictures. What either of them then does about what it saw is one
//! piece of code, [`decision`]. All of them are models: they say what follows from their assumptions, not what people see.

pub mod decision;
pub mod expected;
pub mod options;
pub mod parametric;
mod parse;
pub mod pixels;
pub mod rejoin;
pub mod truth;

pub use options::Options;
pub use parametric::ParametricObserver;
pub use parse::{Simulation, SimulationError};
pub use pixels::PixelObserver;
pub use rejoin::Rejoin;
pub use truth::{ParameterTruth, Truth};

use crate::display::Display;
use crate::session::Trial;
use crate::study::plan::{Condition, Level};
use crate::trial::{Answer, Phase};

/// What an observer meets.
#[derive(Debug, Clone, Copy)]
pub struct Presented<'a> {
    /// The phase that has just begun.
    pub phase: &'a Phase,
    /// The trial it belongs to, if any.
    pub trial: Option<&'a Trial>,
    /// The trial's condition, if it belongs to one.
    pub condition: Option<&'a Condition>,
    /// What the phase shows: the trial's level, with the phase's own on top.
    pub level: Option<&'a Level>,
    /// Where to look: the fixation mark, or the moving target at the phase's start; degrees.
    pub fixation_deg: [f64; 2],
    /// The display.
    pub display: &'a Display,
    /// When the phase began, seconds since the session's start.
    pub t_s: f64,
}

/// Where an observer looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Look {
    /// At a place, degrees.
    At([f64; 2]),
    /// At the moving target, wherever it goes.
    Target,
    /// Around, wherever they like.
    Around,
}

/// What an observer does about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Where they look.
    pub look: Look,
    /// What they say and how long after the phase began, seconds; nothing if they stay silent.
    pub answer: Option<(Answer, f64)>,
}

/// Somebody who can be asked.
pub trait Observer {
    /// Called once at the start of every phase.
    fn meet(&mut self, presented: &Presented<'_>) -> Response;

    /// What the observer is, with all its parameters, for the session's header.
    fn describe(&self) -> serde_json::Value;

    /// Whether the observer judges pictures, and [`Observer::see`] is to be called.
    fn wants_pixels(&self) -> bool {
        false
    }

    /// Shows pictures of a stimulus phase, before the call of [`Observer::meet`] that presents it.
    ///
    /// An adjusting observer answers while the picture is on the display, so it has to have seen it when it is asked. A
    /// stage in virtual time draws one or more moments of the phase ahead. Pictures that come after their phase's `meet`
    /// count for that phase as long as another phase without a stimulus lies between it and the next stimulus.
    fn see(&mut self, _seen: &Seen<'_>) {}

    /// The observer as it is now, to go back to.
    fn fork(&self) -> Box<dyn Observer>;
}

/// Pictures as they reach the eye.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// The picture on the display.
    pub shown: Picture<'a>,
    /// The full-resolution reference at the same moment.
    pub reference: Picture<'a>,
    /// Where the observer looks, degrees.
    pub gaze_deg: [f64; 2],
    /// The display.
    pub display: &'a Display,
}

/// A picture of the whole display.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// 8-bit values as sent to the display, with alpha, row by row from the top, four bytes a pixel.
    pub rgba: &'a [u8],
}
