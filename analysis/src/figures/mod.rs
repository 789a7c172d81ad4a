//! Figures as SVG text: fits of acuity and of psychometric functions, posteriors, ratings, settings, tasks, detection rates,
//! savings, the adaptive track, gaze over the display, frame timing.
//!
//! Each function takes results and returns one complete document with units on every axis, in colours that colour-blind
//! readers can tell apart (Okabe and Ito 2008). Most figures take small plain data of their own, so that whoever has the
//! numbers, from whichever fit, can draw them; beyond densities and the five numbers of a box nothing is computed here.
//! Data that cannot be drawn are left out and counted below the figure, and a figure of nothing says so.

mod boxes;
mod curves;
mod density;
mod detection;
mod frames;
mod functions;
mod gaze;
mod histograms;
mod interaction;
mod joint;
mod likert;
mod mar_group;
mod mar_line;
mod parts;
mod rates;
mod row_panel;
mod rows;
mod sigma;
mod speedup;
#[cfg(test)]
mod tests;
mod track;

pub use boxes::{BoxChart, BoxGroup, BoxStats, Whiskers, box_plots};
pub use curves::psychometric_curves;
pub use detection::detection;
pub use frames::frame_timing;
pub use functions::{BandPoint, LevelCount, PsychometricCurve, PsychometricView, psychometric_functions};
pub use gaze::{GazeView, gaze_density};
pub use histograms::{HistogramView, Published, ThresholdGroup, threshold_histograms};
pub use interaction::{CellMean, Interaction, InteractionLine, InteractionPanel, interaction, within_subject_means};
pub use joint::{JointPosterior, joint_posterior};
pub use likert::{LikertChart, LikertGroup, LikertRow, likert_bars};
pub use mar_group::{GroupLine, LineThreshold, MarGroup, ObserverLine, ReferenceLine, mar_group};
pub use mar_line::mar_line;
pub use rates::{RatePoint, RateSeries, RateView, detection_rates};
pub use rows::{ratings, settings, tasks};
pub use sigma::{PatchBlur, blur_by_eccentricity};
pub use speedup::{LayerCurve, LayerPoint, PublishedSaving, QualityMark, Speedup, SpeedupPoint, speedup};
pub use track::{TrackPoint, adaptive_track};

/// Width of every figure, in pixels.
pub(crate) const WIDTH: f64 = 720.0;

/// A number with three significant digits, for labels in figures.
fn significant(value: f64) -> String {
    crate::text::significant(value, 3)
}
