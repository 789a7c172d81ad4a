//! The display transform, the only step that is not linear: a scene's picture is exposed and tone mapped
//! ([`crate::tone`]), discs and the text screen are laid over it, and everything is encoded with the display's own
//! transfer, sRGB (IEC 61966-2-1) or what was measured. The window and the offscreen stage both use it, so that a picture
//! on disk is the picture that was seen.

use crate::contract::{SceneLight, ToneMap};
use crate::geometry::PixelBox;
use crate::gpu::Gpu;
use crate::pass::{self, Extent};
use crate::tone::{KNEE, WHITE};
use experiments::display::{Display, Transfer};
use image::RgbaImage;
use wgpu::util::DeviceExt;

pub(crate) const WGSL: &str = include_str!("display_pass.wgsl");

/// What stands behind the overlay.
#[derive(Debug, Clone, Copy)]
pub enum Background<'a> {
    /// A linear picture, such as [`crate::contract::Renderer::output`], and how its light is brought to a display, which is
    /// its scene's [`crate::contract::Scene::light`]. It stands in the target's middle, never scaled, with black around it.
    Picture(&'a wgpu::Texture, SceneLight),
    /// One linear colour all over, 0–1. A grey of half the display's luminance is `[0.5; 3]`.
    Uniform([f64; 3]),
}

/// How many discs a frame can show.
pub const MOST_DISCS: usize = 16;

/// A disc over the picture, shaded as a ball that is lit from above on the left: a target to follow or to count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Its centre, display pixels from the top left corner of the display. May lie off the display.
    pub centre_px: [f64; 2],
    /// Its radius, display pixels. What is not a positive number is not shown.
    pub radius_px: f64,
    /// Its colour in full light, sRGB.
    pub colour: [u8; 3],
}

/// Entries of the table that a transfer is looked up in. At even steps of the fourth root of the light above black, so that
/// powers of light up to the display's gamma of 4, and curves that leave black flat, are smooth in it: linear between
/// entries, the signal of a gamma is off by at most 12/8 · 4095⁻² = 9e-8.
const TABLE_ENTRIES: u32 = 4096;

/// The display pass for targets of one format on displays of one transfer.
#[derive(Debug)]
pub struct DisplayPass {
    clamped: Pipelines,
    filmic: Pipelines,
    format: wgpu::TextureFormat,
    signals: wgpu::TextureView,
    /// Light of each channel at signal 0.
    black: [f64; 3],
    nothing: wgpu::TextureView,
}

/// The pass under one tone map. Apart, because software devices run every branch for every pixel.
#[derive(Debug)]
struct Pipelines {
    plain: wgpu::RenderPipeline,
    overlay: wgpu::RenderPipeline,
    discs: wgpu::RenderPipeline,
    overlay_on_discs: wgpu::RenderPipeline,
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    colour: [f32; 4],
    picture_size: [i32; 2],
    overlay_size: [i32; 2],
    target_size: [i32; 2],
    flags: u32,
    disc_count: u32,
    exposure: f32,
    knee: f32,
    white: f32,
    shoulder_end: f32,
    black: [f32; 4],
    discs: [DiscUniform; MOST_DISCS],
}

#[derive(Debug, Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct DiscUniform {
    place: [f32; 4],
    colour: [f32; 4],
}

impl DisplayPass {
    /// A pass into targets of `format` for sRGB displays: RGBA8 or BGRA8, with the `Srgb` suffix or without. Both show the
    /// same colours: where the hardware encodes, the shader does not.
    #[must_use]
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        Self::with_transfer(gpu, format, &Transfer::Srgb)
    }

    /// As [`DisplayPass::new`], for `display` with the transfer that it has.
    #[must_use]
    pub fn for_display(gpu: &Gpu, format: wgpu::TextureFormat, display: &Display) -> Self {
        Self::with_transfer(gpu, format, display.transfer())
    }

    fn with_transfer(gpu: &Gpu, format: wgpu::TextureFormat, transfer: &Transfer) -> Self {
        let flag = |set: bool| f64::from(u8::from(set));
        let pipelines = |filmic: bool| {
            let constants =
                [("ENCODES", flag(!format.is_srgb())), ("FILMIC", flag(filmic)), ("TABLE", flag(!transfer.is_srgb()))];
            let pipeline = |entry| pass::pipeline_with(gpu, "display pass", WGSL, entry, format, &constants);
            Pipelines {
                plain: pipeline("show"),
                overlay: pipeline("show_overlay"),
                discs: pipeline("show_discs"),
                overlay_on_discs: pipeline("show_overlay_on_discs"),
            }
        };
        Self {
            clamped: pipelines(false),
            filmic: pipelines(true),
            format,
            signals: pass::view(&signal_table(gpu, transfer)),
            black: black(transfer),
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
    /// `discs` lie over the background, the later ones on top; the first [`MOST_DISCS`] are shown. The display whose pixels
    /// they are in is the background's picture, or the whole target where there is none.
    ///
    /// `overlay` is a picture with straight alpha (see [`overlay_texture`]); it stands in the target's middle, unscaled,
    /// and is mixed in linear light.
    #[expect(clippy::too_many_arguments, reason = "a frame is these things, one over the other")]
    pub fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        target_px: [u32; 2],
        background: Background<'_>,
        discs: &[Disc],
        overlay: Option<&wgpu::Texture>,
    ) {
        let size = |texture: &wgpu::Texture| [texture.width() as i32, texture.height() as i32];
        let (picture, colour, light) = match background {
            Background::Picture(texture, light) => (Some(texture), [0.0; 3], light),
            Background::Uniform(colour) => (None, colour, SceneLight::default()),
        };
        let pipelines = match light.tone_map {
            ToneMap::Clamp => &self.clamped,
            ToneMap::Filmic => &self.filmic,
        };
        let overlay_is_encoded = overlay.is_some_and(|overlay| !overlay.format().is_srgb());
        let flags = [picture.is_some(), overlay_is_encoded];
        let display_px = picture.map_or(target_px, |picture| [picture.width(), picture.height()]);
        let discs = DiscUniform::visible(discs, display_px, target_px);
        let mut disc_slots = [DiscUniform::default(); MOST_DISCS];
        disc_slots.iter_mut().zip(&discs).for_each(|(slot, (disc, _))| *slot = *disc);
        let uniform = Uniform {
            colour: [colour[0] as f32, colour[1] as f32, colour[2] as f32, 1.0],
            picture_size: picture.map_or([0; 2], size),
            overlay_size: overlay.map_or([0; 2], size),
            target_size: target_px.map(|x| x as i32),
            flags: flags.iter().zip(0..).map(|(&flag, bit)| u32::from(flag) << bit).sum(),
            disc_count: discs.len() as u32,
            exposure: light.exposure as f32,
            knee: KNEE as f32,
            white: WHITE as f32,
            shoulder_end: ((WHITE - KNEE) / (1.0 - KNEE)) as f32,
            black: [self.black[0] as f32, self.black[1] as f32, self.black[2] as f32, 0.0],
            discs: disc_slots,
        };
        let picture_view = picture.map_or_else(|| self.nothing.clone(), pass::view);
        let buffer = pass::uniform(gpu, &uniform);
        let bind_group = pass::bind(gpu, &pipelines.plain, &buffer, &[&picture_view, &self.signals]);
        pass::draw(encoder, &pipelines.plain, &bind_group, target, Extent::All);

        // The parts of the discs once more, with the discs.
        if !discs.is_empty() {
            let places: Vec<PixelBox> = discs.iter().map(|&(_, place)| place).collect();
            let bind_group = pass::bind(gpu, &pipelines.discs, &buffer, &[&picture_view, &self.signals]);
            pass::draw(encoder, &pipelines.discs, &bind_group, target, Extent::Boxes(&places));
        }

        // The overlay's part once more, with the overlay.
        if let Some(overlay) = overlay {
            let place = centred_box([overlay.width(), overlay.height()], target_px);
            let pipeline = if discs.is_empty() { &pipelines.overlay } else { &pipelines.overlay_on_discs };
            let views = [&picture_view, &self.signals, &pass::view(overlay)];
            let bind_group = pass::bind(gpu, pipeline, &buffer, &views);
            pass::draw(encoder, pipeline, &bind_group, target, Extent::Boxes(&[place]));
        }
    }
}

fn black(transfer: &Transfer) -> [f64; 3] {
    [0, 1, 2].map(|channel| transfer.light_from_signal(channel, 0.0))
}

/// The signals of each channel from black to peak, as [`TABLE_ENTRIES`] says; a single entry that nobody reads for sRGB,
/// which is computed.
fn signal_table(gpu: &Gpu, transfer: &Transfer) -> wgpu::Texture {
    let entries = if transfer.is_srgb() { 1 } else { TABLE_ENTRIES };
    let last = f64::from(entries.max(2) - 1);
    let black = black(transfer);
    let signals: Vec<[f32; 4]> = (0..entries)
        .map(|entry| {
            let above_black = (f64::from(entry) / last).powi(4);
            let [red, green, blue] = [0, 1, 2].map(|channel| {
                let light = black[channel] + (1.0 - black[channel]) * above_black;
                transfer.signal_from_light(channel, light) as f32
            });
            [red, green, blue, 1.0]
        })
        .collect();
    pass::float_texture(gpu, "signals", [entries, 1], &signals)
}

impl DiscUniform {
    /// The discs that touch the target, each with the box of target pixels that holds it.
    fn visible(discs: &[Disc], display_px: [u32; 2], target_px: [u32; 2]) -> Vec<(Self, PixelBox)> {
        // As `centred` in the shader.
        let corner: [f64; 2] =
            std::array::from_fn(|axis| ((i64::from(target_px[axis]) - i64::from(display_px[axis])) >> 1) as f64);
        let shown = discs.iter().take(MOST_DISCS).filter_map(|disc| {
            let centre: [f64; 2] = std::array::from_fn(|axis| disc.centre_px[axis] + corner[axis]);
            if !(centre[0].is_finite() && centre[1].is_finite() && disc.radius_px.is_finite() && disc.radius_px > 0.0) {
                return None;
            }
            let edge = |axis: usize, at: f64| at.clamp(0.0, f64::from(target_px[axis])) as u32;
            let [[left, right], [top, bottom]] = [0, 1].map(|axis| {
                let reach = disc.radius_px + 1.0;
                [edge(axis, (centre[axis] - reach).floor()), edge(axis, (centre[axis] + reach).ceil())]
            });
            let uniform = Self {
                place: [centre[0] as f32, centre[1] as f32, disc.radius_px as f32, 0.0],
                colour: [disc.colour[0], disc.colour[1], disc.colour[2], 255].map(linear_from_srgb8),
            };
            (left < right && top < bottom).then_some((uniform, PixelBox { left, top, right, bottom }))
        });
        shown.collect()
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
