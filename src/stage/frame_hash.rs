//! Fingerprints of frames: what was on the display, exactly in sixteen digits and roughly in 108.
//!
//! The hash says whether a frame is the same bit for bit, which holds on one graphics adapter and driver. The signature
//! says how far it is from being the same: mean colours of 6 × 3 parts of the picture, which another adapter's rounding
//! moves by less than one 8-bit level ([`SIGNATURE_TOLERANCE`]).
//!
//! Offscreen, pictures are brought back anyway. A window must never wait, so there a frame is drawn a second time into a
//! texture of its own and copied out; its hash arrives some frames later.

use super::painter::{Painter, View};
use stimuli::display_pass::DisplayPass;
use stimuli::readback::PendingBytes;

/// The hash of a frame's 8-bit RGBA bytes, as written to `frames.csv`: XXH3-64 in hex.
#[must_use]
pub fn picture_hash(rgba: &[u8]) -> String {
    format!("{:016x}", xxhash_rust::xxh3::xxh3_64(rgba))
}

/// Columns and rows of a signature.
pub const SIGNATURE_PARTS: [usize; 2] = [6, 3];
/// How far the means of a part may differ, 8-bit levels, for two pictures to count as the same on different adapters.
/// Rounding differs by one level at most, and means are written to the nearest level.
pub const SIGNATURE_TOLERANCE: u8 = 1;

/// The signature of a frame's 8-bit RGBA bytes: the mean red, green and blue of each part, row by row from the top left,
/// in hex, two digits each. Pictures smaller than the parts leave parts without pixels at 0.
#[must_use]
pub fn picture_signature(rgba: &[u8], size_px: [u32; 2]) -> String {
    use std::fmt::Write as _;
    let [columns, rows] = SIGNATURE_PARTS;
    let [width, height] = size_px.map(|size| (size as usize).max(1));
    let mut sums = vec![[0u64; 4]; columns * rows];
    for (y, line) in rgba.chunks_exact(4 * width).enumerate() {
        let row = (y * rows / height).min(rows - 1) * columns;
        for (x, pixel) in line.chunks_exact(4).enumerate() {
            let sum = &mut sums[row + x * columns / width];
            for channel in 0..3 {
                sum[channel] += u64::from(pixel[channel]);
            }
            sum[3] += 1;
        }
    }
    let mut text = String::with_capacity(6 * sums.len());
    for [red, green, blue, pixels] in sums {
        for channel in [red, green, blue] {
            let count = pixels.max(1);
            // Writing to a string cannot fail.
            let _ = write!(text, "{:02x}", (channel + count / 2) / count);
        }
    }
    text
}

/// The largest difference between two signatures, 8-bit levels; nothing if one of them is none.
#[must_use]
pub fn signature_difference(a: &str, b: &str) -> Option<u8> {
    let levels = |text: &str| {
        let pairs = text.as_bytes().chunks(2);
        pairs.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect::<Option<Vec<u8>>>()
    };
    let (a, b) = (levels(a)?, levels(b)?);
    (a.len() == b.len() && !a.is_empty())
        .then(|| a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or_default())
}

/// Both fingerprints of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fingerprint {
    /// [`picture_hash`].
    pub hash: String,
    /// [`picture_signature`].
    pub signature: String,
}

impl Fingerprint {
    /// Of a frame's 8-bit RGBA bytes.
    #[must_use]
    pub fn of(rgba: &[u8], size_px: [u32; 2]) -> Self {
        Self { hash: picture_hash(rgba), signature: picture_signature(rgba, size_px) }
    }
}

/// A frame's pixels on their way from the GPU.
#[derive(Debug)]
pub struct PendingHash(PendingBytes, [u32; 2]);

impl PendingHash {
    /// Starts bringing back the frame that `painter` has just painted. `pass` draws into 8-bit RGBA.
    #[must_use]
    pub fn start(painter: &Painter, pass: &DisplayPass, view: &View<'_>) -> Self {
        let target = painter.target(pass.format());
        let target_view = target.create_view(&wgpu::TextureViewDescriptor::default());
        painter.compose(view, pass, &target_view, [target.width(), target.height()]);
        Self(PendingBytes::start(&painter.gpu, &target, 4), [target.width(), target.height()])
    }

    /// Whether the frame has come back, and then its fingerprint, if it came back well.
    #[must_use]
    pub fn arrived(&self) -> Option<Option<Fingerprint>> {
        Some(self.0.arrived()?.ok().map(|bytes| Fingerprint::of(&bytes, self.1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published XXH3-64 value of the empty input with seed 0.
    #[test]
    fn the_hash_is_xxh3() {
        assert_eq!(picture_hash(&[]), "2d06800538d394c2");
    }

    #[test]
    fn a_signature_is_the_mean_colour_of_each_part() {
        // Twelve by six pixels: red grows by 10 a column, green by 20 a row, blue alternates between 0 and 3.
        let mut rgba = Vec::new();
        for y in 0..6u8 {
            for x in 0..12u8 {
                rgba.extend([10 * x, 20 * y, 3 * ((x + y) % 2), 255]);
            }
        }
        let signature = picture_signature(&rgba, [12, 6]);
        assert_eq!(signature.len(), 6 * 18);
        // Columns 0 and 1 mean 5, rows 0 and 1 mean 10, blue means 1.5, written as 2.
        assert_eq!(&signature[..6], "050a02");
        // The last part: columns 10 and 11 mean 105, rows 4 and 5 mean 90.
        assert_eq!(&signature[102..], "695a02");
        let brighter: Vec<u8> = rgba.iter().map(|value| value.saturating_add(1)).collect();
        assert_eq!(signature_difference(&signature, &picture_signature(&brighter, [12, 6])), Some(1));
        assert_eq!(signature_difference(&signature, "00"), None);
        assert_eq!(signature_difference("0g", "00"), None);
        assert_eq!(picture_signature(&[9, 9, 9, 255], [1, 1]).len(), 6 * 18);
    }
}
