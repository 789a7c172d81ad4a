//! The mathematics of foveation without a GPU: which layers save most ([`plan`]), and the low-pass filter that the
//! calibration ring applies ([`low_pass`]).

pub mod low_pass;
pub mod plan;
