//! Hashes of frames: what was on the display, in sixteen digits.
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

/// A frame's pixels on their way from the GPU.
#[derive(Debug)]
pub struct PendingHash(PendingBytes);

impl PendingHash {
    /// Starts bringing back the frame that `painter` has just painted. `pass` draws into 8-bit RGBA.
    #[must_use]
    pub fn start(painter: &Painter, pass: &DisplayPass, view: &View<'_>) -> Self {
        let target = painter.target(pass.format());
        let target_view = target.create_view(&wgpu::TextureViewDescriptor::default());
        painter.compose(view, pass, &target_view, [target.width(), target.height()]);
        Self(PendingBytes::start(&painter.gpu, &target, 4))
    }

    /// Whether the frame has come back, and then its hash, if it came back well.
    #[must_use]
    pub fn arrived(&self) -> Option<Option<String>> {
        Some(self.0.arrived()?.ok().map(|bytes| picture_hash(&bytes)))
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
}
