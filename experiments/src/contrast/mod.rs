//! Perceptual contrast of a luminance picture (Tursun 2019, §4.1): how strongly each detail is felt, in just noticeable
//! differences, at each place and in each band of spatial frequency, for an eye that looks somewhere.
//!
//! A picture is split into the bands of a Laplacian pyramid ([`pyramid`]); their local contrast is weighed by a sensitivity
//! that falls with eccentricity ([`csf`], [`sensitivity`]) and masked by what is around it ([`perceived`]).
//! [`resolution`] turns the same figures into the blur that a patch tolerates (§4.2). Nothing here knows a renderer or an
//! observer.

pub mod csf;
pub mod luminance;
pub mod perceived;
pub mod pyramid;
pub mod resolution;
pub mod sensitivity;

pub use luminance::DEFAULT_PEAK_CD_M2;
pub use pyramid::Plane;
pub use sensitivity::Sensitivity;

/// Bands used for a picture in full resolution.
pub const BANDS: usize = 4;

/// The calibrated parameters of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// α: the exponent of self-masking (Eq. 4).
    pub alpha: f64,
    /// β: the exponent of spatial masking (Eq. 4).
    pub beta: f64,
    /// c_a: how fast sensitivity falls with eccentricity times frequency, per degree and cycle per degree (Eq. 3).
    pub c_a: f64,
    /// log10 of the foveal sensitivity at 4, 8, 16 and 32 cycles per degree.
    pub log10_sensitivity: [f64; 4],
    /// ω: how near the pooling over a patch comes to its maximum (Eq. 12).
    pub omega: f64,
}

/// Parameters for pictures in full resolution. They are not in the paper but come with the authors' program.
pub const FULL_RESOLUTION: Parameters = Parameters {
    alpha: 0.612_33,
    beta: 0.389_99,
    c_a: 0.038_218,
    log10_sensitivity: [6.2985, 5.5486, 7.4847, 7.9453],
    omega: 2.0149,
};

/// Parameters for pictures of which every fourth pixel is given (Tursun 2019, Table 1; its sensitivities are log10).
pub const QUARTER_RESOLUTION: Parameters =
    Parameters { alpha: 0.555, beta: 0.135, c_a: 0.040, log10_sensitivity: [5.290, 6.226, 3.404, 4.011], omega: 1.919 };
