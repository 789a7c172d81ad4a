//! What makes one simulated observer differ from another, besides what they can see.

use serde::{Deserialize, Serialize};

/// Width in ln omega when a simulation names none.
pub const DEFAULT_WIDTH: f64 = 0.6;
/// Lapse rate when a simulation names none.
pub const DEFAULT_LAPSE: f64 = 0.02;
/// Zone of "same" when a simulation names none: Φ⁻¹(¾), so that two equal pictures are called the same in half of the
/// trials, and a picture at threshold (F = ½) lies at the zone's edge.
pub const DEFAULT_ZONE: f64 = 0.674_489_750_196_081_7;
/// Criterion when a simulation names none: δ at F = ½.
pub const DEFAULT_CRITERION: f64 = 0.953_872_552_416_830_3;
/// Median response time when a simulation names none, seconds (our choice; typical of 2AFC answers).
pub const DEFAULT_RESPONSE_S: f64 = 0.55;
/// Distance between the thresholds of a rating when a simulation names none, in SDs of one look (our choice).
pub const DEFAULT_SPACING: f64 = 0.75;

/// How an observer decides about what it saw.
///
/// Evidence is in SDs of the noise of one look; a comparison of two pictures has twice the variance of one look, and what
/// is said of comparisons below is in SDs of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Added to the evidence for "first" in every comparison, in SDs of the comparison.
    pub bias: f64,
    /// Half-width of the zone in which a comparison is called "same", in SDs of the comparison.
    pub zone: f64,
    /// Sliding and adjusting go on while the evidence of a look exceeds this, in SDs of one look.
    pub criterion: f64,
    /// Distance between neighbouring thresholds of a seven-step rating, in SDs of one look.
    pub spacing: f64,
    /// Lapse rate λ: an observer without regard to the stimulus answers at random in 2λ of the trials, and so ends at
    /// 1 − λ where it cannot miss. At most ½.
    pub lapse: f64,
    /// By how much the lapse rate grows in an hour of session; it ends at ½.
    pub fatigue: f64,
    /// Median response time far from threshold, seconds.
    pub response_s: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            bias: 0.0,
            zone: DEFAULT_ZONE,
            criterion: DEFAULT_CRITERION,
            spacing: DEFAULT_SPACING,
            lapse: DEFAULT_LAPSE,
            fatigue: 0.0,
            response_s: DEFAULT_RESPONSE_S,
        }
    }
}

impl Options {
    /// The lapse rate at a session time.
    #[must_use]
    pub fn lapse_at(&self, t_s: f64) -> f64 {
        (self.lapse + self.fatigue * t_s.max(0.0) / 3600.0).clamp(0.0, 0.5)
    }
}
