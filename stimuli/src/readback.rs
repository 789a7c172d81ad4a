//! Brings pictures back from the GPU: linear floats for comparison, 8-bit pictures for files and hashes.

use crate::contract::LINEAR_FORMAT;
use crate::display_pass::{Background, DisplayPass};
use crate::gpu::{Gpu, GpuError};
use crate::pass;
use image::RgbaImage;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

/// Why a picture could not be brought back.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReadbackError {
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The texture holds something else.
    #[error("a texture of format {0:?} cannot be read back here")]
    Format(wgpu::TextureFormat),
}

/// The RGBA values of a linear picture (half or full floats), row by row from the top; `4 · width · height` values.
///
/// # Errors
/// When the texture holds something else, or the device fails.
pub fn linear_rgba(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<f32>, ReadbackError> {
    match texture.format() {
        wgpu::TextureFormat::Rgba16Float => {
            let bytes = raw_bytes(gpu, texture, 8)?;
            let halves = bytes.chunks_exact(2).map(|b| half::f16::from_le_bytes([b[0], b[1]]).to_f32());
            Ok(halves.collect())
        }
        wgpu::TextureFormat::Rgba32Float => {
            let bytes = raw_bytes(gpu, texture, 16)?;
            Ok(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
        }
        other => Err(ReadbackError::Format(other)),
    }
}

/// An 8-bit picture, red first whatever the order in the texture.
///
/// # Errors
/// When the texture is not RGBA8 or BGRA8, or the device fails.
pub fn rgba8(gpu: &Gpu, texture: &wgpu::Texture) -> Result<RgbaImage, ReadbackError> {
    let format = texture.format();
    let swap = match format.remove_srgb_suffix() {
        wgpu::TextureFormat::Rgba8Unorm => false,
        wgpu::TextureFormat::Bgra8Unorm => true,
        _ => return Err(ReadbackError::Format(format)),
    };
    let mut bytes = raw_bytes(gpu, texture, 4)?;
    if swap {
        for pixel in bytes.chunks_exact_mut(4) {
            pixel.swap(0, 2);
        }
    }
    RgbaImage::from_raw(texture.width(), texture.height(), bytes).ok_or(ReadbackError::Format(format))
}

/// A picture of what a display of `size_px` pixels would show: the display pass into a fresh target, brought back.
///
/// # Errors
/// When the device fails.
pub fn displayed(
    gpu: &Gpu,
    display_pass: &DisplayPass,
    size_px: [u32; 2],
    background: Background<'_>,
    overlay: Option<&wgpu::Texture>,
) -> Result<RgbaImage, ReadbackError> {
    let target = pass::texture(gpu, "displayed", size_px, display_pass.format());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    display_pass.draw(gpu, &mut encoder, &pass::view(&target), size_px, background, &[], overlay);
    gpu.queue.submit([encoder.finish()]);
    rgba8(gpu, &target)
}

/// The texture's bytes without padding between rows.
fn raw_bytes(gpu: &Gpu, texture: &wgpu::Texture, bytes_per_pixel: u32) -> Result<Vec<u8>, ReadbackError> {
    let pending = PendingBytes::start(gpu, texture, bytes_per_pixel);
    gpu.wait()?;
    // Another thread that polls the same device may be the one that delivers the answer, a moment later.
    match pending.mapped.recv() {
        Ok(Ok(())) => pending.bytes(),
        Ok(Err(error)) => Err(fault(&error)),
        Err(gone) => Err(fault(&gone)),
    }
}

/// A texture's bytes on their way from the GPU, for those who must not wait: a window asks now and then.
#[derive(Debug)]
pub struct PendingBytes {
    buffer: wgpu::Buffer,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
    row_bytes: usize,
    padded_row_bytes: usize,
    rows: usize,
}

impl PendingBytes {
    /// Submits the copy of a whole texture. Its bytes arrive while the device is polled.
    #[must_use]
    pub fn start(gpu: &Gpu, texture: &wgpu::Texture, bytes_per_pixel: u32) -> Self {
        let row_bytes = texture.width() * bytes_per_pixel;
        let padded_row_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: u64::from(padded_row_bytes) * u64::from(texture.height()),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row_bytes),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let (sender, mapped) = sync_channel(1);
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone when nobody needs the answer any more.
            let _ = sender.send(result);
        });
        Self {
            buffer,
            mapped,
            row_bytes: row_bytes as usize,
            padded_row_bytes: padded_row_bytes as usize,
            rows: texture.height() as usize,
        }
    }

    /// The bytes without padding between rows, once they are there; nothing while they are on their way.
    ///
    /// # Errors
    /// When the device failed in between.
    #[must_use]
    pub fn arrived(&self) -> Option<Result<Vec<u8>, ReadbackError>> {
        match self.mapped.try_recv() {
            Ok(Ok(())) => Some(self.bytes()),
            Ok(Err(error)) => Some(Err(fault(&error))),
            Err(TryRecvError::Disconnected) => Some(Err(fault(&"the device is gone"))),
            Err(TryRecvError::Empty) => None,
        }
    }

    fn bytes(&self) -> Result<Vec<u8>, ReadbackError> {
        let mapped = self.buffer.get_mapped_range(..).map_err(|error| fault(&error))?;
        let mut bytes = Vec::with_capacity(self.row_bytes * self.rows);
        for row in mapped.chunks_exact(self.padded_row_bytes) {
            bytes.extend_from_slice(&row[..self.row_bytes]);
        }
        Ok(bytes)
    }
}

/// The bytes of a buffer that can be copied from, waiting for the GPU.
pub(crate) fn buffer_bytes(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: buffer.size(),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    // Whether it worked shows when the bytes are taken.
    copy.map_async(wgpu::MapMode::Read, .., |_| {});
    gpu.wait()?;
    let mapped = copy.get_mapped_range(..).map_err(|error| GpuError::Fault(error.to_string()))?;
    Ok(mapped.to_vec())
}

fn fault(reason: &impl ToString) -> ReadbackError {
    ReadbackError::Gpu(GpuError::Fault(reason.to_string()))
}

/// A linear picture on the GPU from RGBA values, row by row from the top; for tests and for pictures made elsewhere.
///
/// Missing values are black, surplus ones are ignored.
#[must_use]
pub fn linear_texture_from(gpu: &Gpu, size_px: [u32; 2], rgba: &[f32]) -> wgpu::Texture {
    debug_assert_eq!(LINEAR_FORMAT, wgpu::TextureFormat::Rgba16Float);
    let mut pixels: Vec<[f32; 4]> = rgba.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    pixels.resize(size_px[0] as usize * size_px[1] as usize, [0.0, 0.0, 0.0, 1.0]);
    pass::half_texture(gpu, "from values", size_px, &pixels)
}
