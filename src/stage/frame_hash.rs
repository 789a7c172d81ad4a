//! Hashes of frames: what was on the display, in sixteen digits.
//!
//! Offscreen, pictures are brought back anyway. A window must never wait, so there a frame is drawn a second time into a
//! texture of its own and copied out; its hash arrives some frames later.

use super::painter::{Painter, View};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use stimuli::display_pass::DisplayPass;

/// The hash of a frame's 8-bit RGBA bytes, as written to `frames.csv`: XXH3-64 in hex.
#[must_use]
pub fn picture_hash(rgba: &[u8]) -> String {
    format!("{:016x}", xxhash_rust::xxh3::xxh3_64(rgba))
}

/// A frame's pixels on their way from the GPU.
#[derive(Debug)]
pub struct PendingHash {
    buffer: wgpu::Buffer,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
    row_bytes: usize,
    padded_row_bytes: usize,
}

impl PendingHash {
    /// Starts bringing back the frame that `painter` has just painted. `pass` draws into 8-bit RGBA.
    #[must_use]
    pub fn start(painter: &Painter, pass: &DisplayPass, view: &View<'_>) -> Self {
        let device = &painter.gpu.device;
        let target = painter.target(pass.format());
        let [width, height] = [target.width(), target.height()];
        let target_view = target.create_view(&wgpu::TextureViewDescriptor::default());
        painter.compose(view, pass, &target_view, [width, height]);
        let row_bytes = 4 * width;
        let padded_row_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("hashed frame"),
            size: u64::from(padded_row_bytes) * u64::from(height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row_bytes),
                    rows_per_image: None,
                },
            },
            target.size(),
        );
        painter.gpu.queue.submit([encoder.finish()]);
        let (sender, mapped) = sync_channel(1);
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver may be gone when the window closes; then nobody needs the answer.
            let _ = sender.send(result);
        });
        Self { buffer, mapped, row_bytes: row_bytes as usize, padded_row_bytes: padded_row_bytes as usize }
    }

    /// Whether the frame has come back, and then its hash, if it came back well.
    #[must_use]
    pub fn arrived(&self) -> Option<Option<String>> {
        match self.mapped.try_recv() {
            Ok(Ok(())) => Some(self.hash()),
            Ok(Err(_)) | Err(TryRecvError::Disconnected) => Some(None),
            Err(TryRecvError::Empty) => None,
        }
    }

    fn hash(&self) -> Option<String> {
        let mapped = self.buffer.get_mapped_range(..).ok()?;
        let rows = mapped.chunks_exact(self.padded_row_bytes);
        let bytes: Vec<u8> = rows.flat_map(|row| &row[..self.row_bytes]).copied().collect();
        Some(picture_hash(&bytes))
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
