//! What the answers mean: acuity fits with honest intervals, figures and a report.
//!
//! The crate is pure: trials, gaze samples and frame intervals come in as plain data, and numbers, SVG and HTML go out as
//! values. It reads no file, keeps no clock and links no graphics; the lab (the root package) feeds it and writes what it
//! returns. The acuity model itself lives in [`experiments::mar`], so that whoever asks, answers and fits agree on it.
//!
//! - [`mar`] fits `omega = m e + omega0` and a threshold for every eccentricity;
//! - [`psychometric`] fits one function on one variable, and [`answers`] sums up the answers of every protocol, block by
//!   block: shares, matches, ratings, tasks;
//! - [`rules`] are the four papers' own ways to a result, beside what they published;
//! - [`shares`] are proportions with their intervals;
//! - [`gaze`] and [`timing`] measure where the eyes were and how the frames ran, and flag trials by a stated rule;
//! - [`statistics`] are the tests of hypotheses: analysis of variance, t, rank and binomial tests, effect sizes;
//! - [`summary`] is the JSON document of `parafovea analyze --json`;
//! - [`figures`] draws the fits and summaries as SVG, and [`report`] puts everything on one HTML page.

pub mod answers;
pub mod comparison;
pub mod figures;
pub mod gaze;
pub mod mar;
mod numerics;
pub mod power;
pub mod psychometric;
pub mod report;
pub mod rules;
pub mod shares;
pub mod statistics;
pub mod summary;
mod svg;
mod text;
pub mod timing;

pub use mar::{MarFit, MarFitConfig, MarTrial, fit_mar};
