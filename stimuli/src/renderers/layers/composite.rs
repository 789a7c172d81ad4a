//! Magnifies the layers onto the display's pixels and blends them (Guenter et al. 2012, §4, Fig. 3).

use super::settings::Settings;
use crate::contract::{LINEAR_FORMAT, View};
use crate::geometry::{Cone, GeometryUniform};
use crate::gpu::Gpu;
use crate::pass::{self, Extent};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("composite.wgsl");

/// The most layers there can be.
pub(super) const MOST_LAYERS: usize = 4;

/// r1 / r2 of the blend between two layers (Fig. 3: the transition is 40 % of the layer's radius).
const BLEND_FROM: f64 = 0.6;

/// A radius that nothing lies beyond, radians.
const EVERYWHERE_RAD: f32 = 10.0;

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    geometry: GeometryUniform,
    radii_rad: [f32; MOST_LAYERS],
    places: [[f32; 4]; MOST_LAYERS],
    sizes: [[i32; 4]; MOST_LAYERS],
    blend_from: f32,
    nearest: u32,
    reserved: [u32; 2],
}

/// The passes that put layers together.
#[derive(Debug)]
pub(super) struct Composite {
    blend: wgpu::RenderPipeline,
    outermost: wgpu::RenderPipeline,
    nothing: wgpu::TextureView,
}

/// What a layer shows, and its picture; nothing where its circle does not touch the display.
pub(super) type Shown<'a> = Option<(View, &'a wgpu::Texture)>;

impl Composite {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let pipeline = |entry| pass::pipeline(gpu, "layers", WGSL, entry, LINEAR_FORMAT);
        Self {
            blend: pipeline("blend"),
            outermost: pipeline("outermost"),
            nothing: pass::view(&pass::linear_texture(gpu, "no layer", [1, 1])),
        }
    }

    /// Records the blending of `layers`, innermost first, into `target`.
    #[expect(clippy::too_many_arguments, reason = "a frame is these things")]
    pub(super) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        display: &Display,
        settings: &Settings,
        gaze_deg: [f64; 2],
        layers: &[Shown<'_>],
        target: &wgpu::TextureView,
    ) {
        // The outermost alone around the circle of the layer inside it, then what is in that circle. Boxes of the first
        // reach into the second, which is why it comes after.
        let last = settings.layers() - 1;
        let circle_deg = settings.plan.layers.get(last - 1).map_or(0.0, |layer| layer.radius_deg);
        let circle = Cone::new(display, gaze_deg, circle_deg);
        let around = Cone::everything(display).boxes_around(Some(&circle));
        let uniform = Uniform::new(display, settings, gaze_deg, layers.get(last..).unwrap_or_default());
        let picture = self.picture(layers, last);
        let bind_group = pass::bind(gpu, &self.outermost, &pass::uniform(gpu, &uniform), &[&picture]);
        pass::draw(encoder, &self.outermost, &bind_group, target, Extent::Boxes(&around));

        let inside = circle.boxes_around(None);
        if !inside.is_empty() {
            let uniform = Uniform::new(display, settings, gaze_deg, layers);
            let pictures: [_; MOST_LAYERS] = std::array::from_fn(|index| self.picture(layers, index));
            let pictures: Vec<_> = pictures.iter().collect();
            let bind_group = pass::bind(gpu, &self.blend, &pass::uniform(gpu, &uniform), &pictures);
            pass::draw(encoder, &self.blend, &bind_group, target, Extent::Boxes(&inside));
        }
    }

    fn picture(&self, layers: &[Shown<'_>], index: usize) -> wgpu::TextureView {
        let shown = layers.get(index).copied().flatten();
        shown.map_or_else(|| self.nothing.clone(), |(_, picture)| pass::view(picture))
    }
}

impl Uniform {
    fn new(display: &Display, settings: &Settings, gaze_deg: [f64; 2], layers: &[Shown<'_>]) -> Self {
        let layer = |index: usize| layers.get(index).copied().flatten();
        let place = |index| {
            layer(index).map_or([0.0, 0.0, 1.0, 1.0], |(view, _)| {
                let step = view.step_px();
                let corner = |axis: usize| (view.origin_px[axis] / step[axis]).round();
                [corner(0), corner(1), step[0], step[1]].map(|x| x as f32)
            })
        };
        let size = |index| {
            let [width, height] = layer(index).map_or([1, 1], |(view, _)| view.target_px.map(|x| x as i32));
            [width, height, 0, 0]
        };
        let radius_rad = |index: usize| match settings.plan.layers.get(index) {
            Some(planned) if index + 1 < settings.layers() => {
                layer(index).map_or(0.0, |_| planned.radius_deg.to_radians() as f32)
            }
            _ => EVERYWHERE_RAD,
        };
        Self {
            geometry: GeometryUniform::new(display, gaze_deg),
            radii_rad: std::array::from_fn(radius_rad),
            places: std::array::from_fn(place),
            sizes: std::array::from_fn(size),
            blend_from: if settings.smooth { BLEND_FROM as f32 } else { 1.0 },
            nearest: u32::from(!settings.bilinear),
            reserved: [0; 2],
        }
    }
}
