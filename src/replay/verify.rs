//! Whether a log shows what the run showed: pictures drawn again, held against the fingerprints that the run left.
//!
//! On the adapter and driver of the run the hashes must be equal. On another one, whose rounding differs, the mean colours
//! of the pictures' parts may differ by [`SIGNATURE_TOLERANCE`].

use super::{Drawn, Replay};
use crate::session::tables::FrameRow;
use crate::stage::frame_hash::{Fingerprint, SIGNATURE_TOLERANCE, signature_difference};
use serde::Serialize;

/// What was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// The adapter that drew.
    pub adapter: String,
    /// Frames of this adapter whose hashes were compared.
    pub hashes_compared: usize,
    /// How many of them were different.
    pub hashes_different: usize,
    /// Frames of other adapters whose signatures were compared.
    pub signatures_compared: usize,
    /// How many of them differed by more than is allowed.
    pub signatures_different: usize,
    /// The largest difference that is allowed, 8-bit levels.
    pub signature_tolerance: u8,
    /// The largest difference of two signatures of one frame, on whichever adapter, 8-bit levels.
    pub largest_signature_difference: Option<u8>,
    /// Frames of other adapters that nothing can be said of: their hash differs and the log holds no signature.
    pub unjudged: usize,
    /// The first frame that is different.
    pub first_different: Option<u64>,
    /// What is wrong with the log itself.
    pub damage: Vec<String>,
}

/// Collects a [`Verdict`].
#[derive(Debug)]
pub struct Judge {
    verdict: Verdict,
    /// The fingerprint of the picture judged last, by its serial number.
    last: Option<(u64, Fingerprint)>,
}

impl Judge {
    /// A judge of pictures that `adapter` draws of a replay.
    #[must_use]
    pub fn new(replay: &Replay, adapter: &str) -> Self {
        let verdict = Verdict {
            adapter: adapter.to_owned(),
            hashes_compared: 0,
            hashes_different: 0,
            signatures_compared: 0,
            signatures_different: 0,
            signature_tolerance: SIGNATURE_TOLERANCE,
            largest_signature_difference: None,
            unjudged: 0,
            first_different: None,
            damage: replay.damage.clone(),
        };
        Self { verdict, last: None }
    }

    /// Takes in a frame that was drawn again; one without a hash is passed over.
    pub fn judge(&mut self, replay: &Replay, frame: &FrameRow, drawn: &Drawn) {
        let Some(hash) = &frame.hash else { return };
        let print = match self.last.take().filter(|(serial, _)| *serial == drawn.serial) {
            Some((_, print)) => print,
            None => {
                let picture = &drawn.picture;
                Fingerprint::of(picture.as_raw(), [picture.width(), picture.height()])
            }
        };
        let verdict = &mut self.verdict;
        let difference =
            frame.signature.as_deref().and_then(|signature| signature_difference(signature, &print.signature));
        verdict.largest_signature_difference = verdict.largest_signature_difference.max(difference);
        let same = *hash == print.hash;
        let different = if replay.adapter(frame) == Some(verdict.adapter.as_str()) {
            verdict.hashes_compared += 1;
            verdict.hashes_different += usize::from(!same);
            !same
        } else if let Some(difference) = difference {
            verdict.signatures_compared += 1;
            let different = difference > SIGNATURE_TOLERANCE;
            verdict.signatures_different += usize::from(different);
            different
        } else if frame.signature.is_some() {
            // A signature that is none.
            verdict.signatures_compared += 1;
            verdict.signatures_different += 1;
            true
        } else {
            verdict.hashes_compared += usize::from(same);
            verdict.unjudged += usize::from(!same);
            false
        };
        if different {
            verdict.first_different.get_or_insert(frame.index);
        }
        self.last = Some((drawn.serial, print));
    }

    /// What was found.
    #[must_use]
    pub fn verdict(self) -> Verdict {
        self.verdict
    }
}

impl Verdict {
    /// What was compared, in a line.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut parts = Vec::new();
        if self.hashes_compared > 0 || self.signatures_compared == 0 {
            parts.push(format!("{} hashes compared, {} different", self.hashes_compared, self.hashes_different));
        }
        if self.signatures_compared > 0 {
            parts.push(format!(
                "{} frames of another adapter compared by mean colours, {} different; largest difference {} of 255 \
                 levels, {} allowed",
                self.signatures_compared,
                self.signatures_different,
                self.largest_signature_difference.unwrap_or_default(),
                self.signature_tolerance
            ));
        }
        if self.unjudged > 0 {
            parts.push(format!("{} frames of another adapter left no mean colours to compare with", self.unjudged));
        }
        parts.join("; ")
    }

    /// Nothing where the pictures are those of the run and the log is whole; else why not, in words.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        let mut problems = self.damage.clone();
        if let Some(first) = self.first_different {
            let levels = match self.largest_signature_difference {
                Some(levels) => format!(", by up to {levels} of 255 levels in the mean colour of a part"),
                None => String::new(),
            };
            problems.push(format!(
                "{} of {} frames are not what the run showed, first frame {first}{levels}; the log was changed, or \
                 another version of the program or driver draws differently",
                self.hashes_different + self.signatures_different,
                self.hashes_compared + self.signatures_compared
            ));
        }
        if self.unjudged > 0 {
            problems.push(format!(
                "{} frames cannot be judged: another adapter drew them, and the log holds only hashes, which rounding \
                 changes",
                self.unjudged
            ));
        } else if self.hashes_compared + self.signatures_compared == 0 {
            problems.push("the run wrote no hashes to compare with; was it run with --no-render?".to_owned());
        }
        (!problems.is_empty()).then(|| problems.join("\n"))
    }
}
