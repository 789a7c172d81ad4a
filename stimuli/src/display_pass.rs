//! The last step to a display: clamp to 0–1, lay the text screen over, encode as sRGB (IEC 61966-2-1). The window and the
//! offscreen stage both use it, so that a picture on disk is the picture that was seen.

use crate::geometry::PixelBox;
use crate::gpu::Gpu;
use crate::pass::{self, Extent};
use image::RgbaImage;
use wgpu::util::DeviceExt;

pub(crate) const WGSL: &str = include_str!("display_pass.wgsl");

/// What stands behind the overlay.
#[derive(Debug, Clone, Copy)]
pub enum Background<'a> {
    /// A linear picture, such as [`crate::contract::Renderer::output`]. It stands in the target's middle, never scaled,
    /// with black around it.
    Picture(&'a wgpu::Texture),
    /// One linear colour all over, 0–1. A grey of half the display's luminance is `[0.5; 3]`.
    Uniform([f64; 3]),
}

/// The display pass for targets of one format.
#[derive(Debug)]
pub struct DisplayPass {
    pipeline: wgpu::RenderPipeline,
    overlay_pipeline: wgpu::RenderPipeline,
    format: wgpu::TextureFormat,
    nothing: wgpu::TextureView,
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    colour: [f32; 4],
    picture_size: [i32; 2],
    overlay_size: [i32; 2],
    target_size: [i32; 2],
    flags: u32,
    reserved: u32,
}

impl DisplayPass {
    /// A pass into targets of `format`: RGBA8 or BGRA8, with the `Srgb` suffix or without. Both show the same colours:
    /// where the hardware encodes, the shader does not.
    #[must_use]
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let encodes = [("ENCODES", f64::from(u8::from(!format.is_srgb())))];
        let pipeline = |entry| pass::pipeline_with(gpu, "display pass", WGSL, entry, format, &encodes);
        Self {
            pipeline: pipeline("show"),
            overlay_pipeline: pipeline("show_overlay"),
            format,
            nothing: pass::view(&pass::linear_texture(gpu, "nothing", [1, 1])),
        }
    }

    /// The format of the targets.
    #[must_use]
    pub fn format(&self) -> wgpu::TextureFormat {
        self.format
    }

    /// Records one frame into `target`, which is `target_px` wide and high.
    ///
    /// `overlay` is a picture with straight alpha (see [`overlay_texture`]); it stands in the target's middle, unscaled,
    /// and is mixed in linear light.
    pub fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        target_px: [u32; 2],
        background: Background<'_>,
        overlay: Option<&wgpu::Texture>,
    ) {
        let size = |texture: &wgpu::Texture| [texture.width() as i32, texture.height() as i32];
        let (picture, colour) = match background {
            Background::Picture(texture) => (Some(texture), [0.0; 3]),
            Background::Uniform(colour) => (None, colour),
        };
        let overlay_is_encoded = overlay.is_some_and(|overlay| !overlay.format().is_srgb());
        let flags = [picture.is_some(), overlay_is_encoded];
        let uniform = Uniform {
            colour: [colour[0] as f32, colour[1] as f32, colour[2] as f32, 1.0],
            picture_size: picture.map_or([0; 2], size),
            overlay_size: overlay.map_or([0; 2], size),
            target_size: target_px.map(|x| x as i32),
            flags: flags.iter().zip(0..).map(|(&flag, bit)| u32::from(flag) << bit).sum(),
            reserved: 0,
        };
        let picture_view = picture.map_or_else(|| self.nothing.clone(), pass::view);
        let buffer = pass::uniform(gpu, &uniform);
        let bind_group = pass::bind(gpu, &self.pipeline, &buffer, &[&picture_view]);
        pass::draw(encoder, &self.pipeline, &bind_group, target, Extent::All);

        // The overlay's part once more, with the overlay.
        if let Some(overlay) = overlay {
            let place = centred_box([overlay.width(), overlay.height()], target_px);
            let bind_group = pass::bind(gpu, &self.overlay_pipeline, &buffer, &[&picture_view, &pass::view(overlay)]);
            pass::draw(encoder, &self.overlay_pipeline, &bind_group, target, Extent::Boxes(&[place]));
        }
    }
}

/// Where something of `size` pixels covers a target when it stands in the middle, unscaled; as `centred` in the shader.
fn centred_box(size: [u32; 2], target_px: [u32; 2]) -> PixelBox {
    let span = |axis: usize| {
        let [size, most] = [size[axis], target_px[axis]].map(i64::from);
        let first = (most - size) >> 1;
        [first, first + size].map(|edge| edge.clamp(0, most) as u32)
    };
    let ([left, right], [top, bottom]) = (span(0), span(1));
    PixelBox { left, top, right, bottom }
}

/// An overlay for [`DisplayPass::draw`] from an sRGB picture with straight alpha.
///
/// Clear margins are left out, as far as its middle stays its middle: a small mark costs little on a large display.
#[must_use]
pub fn overlay_texture(gpu: &Gpu, picture: &RgbaImage) -> wgpu::Texture {
    let [left, top] = clear_margins(picture);
    let (width, height) = (picture.width() - 2 * left, picture.height() - 2 * top);
    let seen = image::imageops::crop_imm(picture, left, top, width, height).to_image();
    gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some("overlay"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &seen,
    )
}

/// How many columns on the left and on the right, and rows above and below, are wholly transparent; at least one pixel of
/// the picture is left.
fn clear_margins(picture: &RgbaImage) -> [u32; 2] {
    let size = [picture.width(), picture.height()];
    let mut margins = size.map(|x| x.saturating_sub(1) / 2);
    for (x, y, _) in picture.enumerate_pixels().filter(|(.., pixel)| pixel[3] > 0) {
        for (axis, at) in [x, y].into_iter().enumerate() {
            margins[axis] = margins[axis].min(at).min(size[axis] - 1 - at);
        }
    }
    margins
}

/// The sRGB decoding of one 8-bit value to linear light, 0–1 (IEC 61966-2-1).
#[must_use]
pub fn linear_from_srgb8(value: u8) -> f32 {
    let c = f64::from(value) / 255.0;
    (if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
}
