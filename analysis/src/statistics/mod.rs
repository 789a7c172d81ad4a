//! Statistical tests.
pub mod distributions;
