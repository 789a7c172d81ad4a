//! An observer that looks at the pictures, so that a renderer can be piloted without people and without a law of its own.
//!
//! It compares the picture on the display with the full-resolution reference by perceptual contrast
//! ([`crate::contrast`]), pools the difference to one visibility V ([`difference`]) and decides about it as every other
//! simulated observer does, with δ = 0.954 V, so that V = 1 is F = ½. It sees single pictures: flicker, popping and other
//! things that only happen in time are invisible to it. It is a model, calibrated on still patches, not a person.

pub mod difference;

use super::decision::{Decision, Sight};
use super::options::{DEFAULT_CRITERION, Options};
use super::{Observer, Presented, Response, Seen};
use crate::contrast::{BANDS, FULL_RESOLUTION, Sensitivity};
use crate::display::Display;
use crate::trial::{Alternative, Presentation};

/// δ of a difference of V = 1: that of F = ½.
const DELTA_PER_VISIBILITY: f64 = DEFAULT_CRITERION;

/// An observer that judges pictures.
#[derive(Debug, Clone)]
pub struct PixelObserver {
    decision: Decision,
    /// The largest visibility of the pictures seen since the last phase began.
    pending: Option<f64>,
    /// The visibility of the last stimulus.
    last: f64,
    /// What the eye is sensitive to, for the display, gaze and picture size it was computed for.
    sensitivity: Option<(Display, [f64; 2], [u32; 2], Sensitivity)>,
}

impl PixelObserver {
    /// An observer with the `observer` stream of `seed`.
    #[must_use]
    pub fn new(options: Options, seed: u64) -> Self {
        Self { decision: Decision::new(options, seed), pending: None, last: 0.0, sensitivity: None }
    }

    fn sight(visibility: f64) -> Sight {
        Sight { delta: DELTA_PER_VISIBILITY * visibility, excess: visibility }
    }
}

impl Observer for PixelObserver {
    fn fork(&self) -> Box<dyn Observer> {
        Box::new(self.clone())
    }

    fn meet(&mut self, presented: &Presented<'_>) -> Response {
        let pending = self.pending.take();
        let sight = match &presented.phase.presentation {
            Presentation::Stimulus(stimulus) if stimulus.alternative == Alternative::Test => {
                self.last = pending.unwrap_or(0.0);
                Some(Self::sight(self.last))
            }
            Presentation::Stimulus(_) => {
                self.last = 0.0;
                Some(Sight::REFERENCE)
            }
            _ => {
                // Pictures that came while the last stimulus was already there.
                if let Some(visibility) = pending {
                    self.last = self.last.max(visibility);
                    self.decision.see_again(Self::sight(self.last));
                }
                None
            }
        };
        self.decision.meet(presented, sight)
    }

    fn describe(&self) -> serde_json::Value {
        let parameters = FULL_RESOLUTION;
        serde_json::json!({
            "kind": "perceptual-contrast",
            "model": "Tursun 2019, Eqs. 1-4, full-resolution parameters",
            "alpha": parameters.alpha,
            "beta": parameters.beta,
            "c_a": parameters.c_a,
            "log10_sensitivity": parameters.log10_sensitivity,
            "pooling_exponent": difference::EXPONENT,
            "pooling_patch_deg": difference::PATCH_DEG,
            "delta_per_visibility": DELTA_PER_VISIBILITY,
            "options": self.decision.options(),
        })
    }

    fn wants_pixels(&self) -> bool {
        true
    }

    /// Pictures that are not of the same size, or whose bytes do not fit their size, are not seen.
    fn see(&mut self, seen: &Seen<'_>) {
        let size_px = seen.shown.size_px;
        let known = self.sensitivity.take().filter(|(display, gaze_deg, size, _)| {
            display == seen.display
                && *size == size_px
                && gaze_deg.iter().zip(seen.gaze_deg).all(|(a, b)| a.total_cmp(&b).is_eq())
        });
        let known = known.unwrap_or_else(|| {
            let sensitivity = Sensitivity::of_display(&FULL_RESOLUTION, seen.display, seen.gaze_deg, size_px, BANDS);
            (seen.display.clone(), seen.gaze_deg, size_px, sensitivity)
        });
        if let Some(visibility) = difference::visibility(seen, &known.3) {
            self.pending = Some(self.pending.map_or(visibility, |before| before.max(visibility)));
        }
        self.sensitivity = Some(known);
    }
}

#[cfg(test)]
mod tests;
