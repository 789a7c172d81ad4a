//! Where the eye is: gaze samples and the sources that deliver them.
//!
//! A source runs on its device's own clock and hands over what has arrived; it neither filters, predicts nor judges.
//! The fixation gate is pure and lives in `experiments`, the session's journal writes the samples, and degrees are
//! derived from pixels by [`Display::deg_from_px`](experiments::Display::deg_from_px).

pub mod mouse;
pub mod recorded;
pub mod simulated;

pub use mouse::Mouse;
pub use recorded::Recorded;
pub use simulated::{Simulated, SimulatedEye};

use serde::Serialize;

/// What a tracker says of one eye at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EyeSample {
    /// Where the eye looks, in display pixels (origin top left). Always finite: where `valid` is false it repeats the
    /// last valid place, or the display's centre before there was one.
    pub px: [f64; 2],
    /// Whether the tracker saw this eye.
    pub valid: bool,
    /// Pupil diameter in millimetres, where the tracker measured one.
    pub pupil_mm: Option<f64>,
}

/// What a tracker says of the gaze at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GazeSample {
    /// When the eye was there, in seconds of the session clock.
    pub t_s: f64,
    /// When the program could first use the sample, in seconds of the session clock; never before `t_s`.
    pub arrived_s: f64,
    /// The device's own timestamp, in seconds of a clock whose zero only the device knows.
    pub t_device_s: f64,
    /// Where both eyes together look, in display pixels (origin top left). Always finite: where `valid` is false it
    /// repeats the last valid place, or the display's centre before there was one.
    pub px: [f64; 2],
    /// Whether the tracker saw the gaze: false in blinks and losses.
    pub valid: bool,
    /// Pupil diameter in millimetres, where the tracker measured one.
    pub pupil_mm: Option<f64>,
    /// The left eye, where the tracker tells the eyes apart.
    pub left: Option<EyeSample>,
    /// The right eye, where the tracker tells the eyes apart.
    pub right: Option<EyeSample>,
}

/// An eye tracker, or what stands in for one.
///
/// To write a new one, implement the three required methods in a file of its own. The promises that callers rest on:
/// samples come in the order of `arrived_s`, each once, none before it has arrived; `px` is always finite; memory stays
/// bounded however long a session lasts.
pub trait GazeSource {
    /// The source's name, as studies and session headers write it.
    fn id(&self) -> &'static str;

    /// Every parameter of the source, for the session header.
    fn describe(&self) -> serde_json::Value;

    /// Appends to `out` every sample that has arrived by `now_s` (seconds of the session clock, not decreasing from
    /// call to call) and was not handed over before. A `now_s` that is not finite adds nothing.
    fn poll(&mut self, now_s: f64, out: &mut Vec<GazeSample>);

    /// Tells a simulated eye at `now_s` (session seconds) to look at a place in degrees; real ones look where they
    /// like.
    fn look_at(&mut self, _now_s: f64, _target_deg: [f64; 2]) {}

    /// Tells a simulated eye at `now_s` that what it is to follow is at a place in degrees now; called again whenever it
    /// has moved, until the eye is told something else. Real eyes follow what they like.
    fn pursue(&mut self, _now_s: f64, _target_deg: [f64; 2]) {}

    /// Tells a simulated eye at `now_s` to look around as it likes, until it is told something else. Real ones do anyway.
    fn look_around(&mut self, _now_s: f64) {}
}
