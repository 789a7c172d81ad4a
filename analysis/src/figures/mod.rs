//! Figures as SVG text: the MAR line, psychometric curves, shares by level, settings, ratings, comparisons after a task,
//! the adaptive track, gaze over the display, frame timing.
//!
//! Each function takes results and returns one complete document with units on every axis, in colours that colour-blind
//! readers can tell apart (Okabe and Ito 2008). Nothing is computed here that is not already in the results.

mod curves;
mod detection;
mod frames;
mod gaze;
mod mar_line;
mod rows;
mod track;

pub use curves::psychometric_curves;
pub use detection::detection;
pub use frames::frame_timing;
pub use gaze::{GazeView, gaze_density};
pub use mar_line::mar_line;
pub use rows::{ratings, settings, tasks};
pub use track::{TrackPoint, adaptive_track};

/// Width of every figure, in pixels.
pub(crate) const WIDTH: f64 = 720.0;

/// A number with three significant digits, for labels in figures.
fn significant(value: f64) -> String {
    crate::text::significant(value, 3)
}
