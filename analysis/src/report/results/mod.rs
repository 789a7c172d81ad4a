//! Sections of a report from results themselves: the pooled MAR line, analyses of variance, the papers' rules, the quality of
//! gaze and flagged trials, single functions.
//!
//! Each function takes what another module computed and gives a [`super::Section`] of tables and figures; nothing is computed
//! here that is not for showing.

mod function;
mod gaze;
mod group;
mod paper_rules;
mod variance;

pub use function::{FunctionFit, functions_section};
pub use gaze::{SessionGaze, flags_section, gaze_quality_section};
pub use group::{linearity_section, pooled_section};
pub use paper_rules::rules_section;
pub use variance::{BlockVariance, variance_section};
