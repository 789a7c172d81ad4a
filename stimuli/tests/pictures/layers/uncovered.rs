//! A bright board moves over a dark ground, both of known depth: what it uncovers must not keep its light, what stays must be
//! kept, and values that are none must not live on.

use super::settings;
use crate::common::{display, gpu, looking_at, pixel_centre};
use experiments::display::Display;
use stimuli::{
    DrawCost, DrawRequest, FrameInput, Gpu, RenderError, Renderer, Scene, SceneIdentity, make_renderer, readback,
};

const WGSL: &str = "
struct Board { origin: vec2f, step: vec2f, edges: vec2f, moved: f32, depth: f32, broken: f32, light: f32, pad: vec2f }
@group(0) @binding(0) var<uniform> u: Board;
struct Out { @location(0) colour: vec4f, @location(1) motion: vec4f }
@vertex fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(f32((i << 1u) & 2u), f32(i & 2u)) * 2.0 - 1.0, 0.0, 1.0);
}
@fragment fn board(@builtin(position) p: vec4f) -> Out {
    let px = u.origin + p.xy * u.step;
    let on = px.x >= u.edges.x && px.x < u.edges.y;
    // Not a number where it is broken; the zero comes from outside so that nobody computes it beforehand.
    let light = select(0.0, u.light, on);
    let bad = select(light, (u.pad.x / u.pad.x), px.y < u.broken);
    return Out(vec4f(vec3f(bad), 1.0), select(vec4f(0.0, 0.0, 0.1, 0.1), vec4f(-u.moved, 0.0, u.depth, u.depth), on));
}";

/// The board: from `from_px` on at time 0, `wide_px` wide, at `speed_px_s`.
struct Board {
    identity: SceneIdentity,
    pipeline: wgpu::RenderPipeline,
    spare: Option<wgpu::Texture>,
    from_px: f64,
    wide_px: f64,
    speed_px_s: f64,
    /// Rows above this one are not numbers.
    broken_px: f64,
}

impl Board {
    fn new(from_px: f64, wide_px: f64, speed_px_s: f64) -> Self {
        let device = &gpu().device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(WGSL.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cover"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("board"),
                compilation_options: Default::default(),
                targets: &[Some(stimuli::LINEAR_FORMAT.into()), Some(stimuli::LINEAR_FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { identity: SceneIdentity::new(), pipeline, spare: None, from_px, wide_px, speed_px_s, broken_px: -1e6 }
    }

    fn left_px(&self, animation_s: f64) -> f64 {
        self.from_px + self.speed_px_s * animation_s
    }
}

impl Scene for Board {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let view = &request.view;
        let since_s = request.motion.map_or(request.animation_s, |motion| motion.since_s);
        let left = self.left_px(request.animation_s);
        let step = view.step_px();
        let values = [
            view.origin_px[0],
            view.origin_px[1],
            step[0],
            step[1],
            left,
            left + self.wide_px,
            self.speed_px_s * (request.animation_s - since_s),
            0.5,
            self.broken_px,
            1.0,
            0.0,
            0.0,
        ]
        .map(|x| x as f32);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 48,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&values));
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        // Both attachments of a pass have one size.
        let size = target.texture().size();
        let spare = self.spare.insert(gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: stimuli::LINEAR_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        }));
        let moved = spare.create_view(&Default::default());
        let attachment = |view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })
        };
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[attachment(target), attachment(&moved)],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.set_scissor_rect(0, 0, view.target_px[0], view.target_px[1]);
            pass.draw(0..3, 0..1);
        }
        if let Some(motion) = request.motion {
            let to = motion.target.texture().as_image_copy();
            let extent =
                wgpu::Extent3d { width: view.target_px[0], height: view.target_px[1], depth_or_array_layers: 1 };
            encoder.copy_texture_to_texture(spare.as_image_copy(), to, extent);
        }
        Ok(DrawCost::of_pixels(view))
    }

    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
        self.speed_px_s != 0.0 && from_s != to_s
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}

const RATE_HZ: f64 = 60.0;

fn shown(renderer: &mut dyn Renderer, board: &mut Board, index: u64) -> Vec<f32> {
    let frame = FrameInput { animation_s: index as f64 / RATE_HZ, ..looking_at([-14.0, 0.0]) };
    renderer.render(gpu(), board, &frame).unwrap();
    readback::linear_rgba(gpu(), renderer.output()).unwrap()
}

/// The gaze is at the left, the board in the outermost layer.
fn small() -> (Display, Box<dyn Renderer>) {
    let display = display([480, 60], [510.0, 63.75], 590.0);
    let parameters = settings([("half_rate", "off"), ("restrict_s2", "2")], [("m", 0.2)]);
    let renderer = make_renderer(gpu(), &display, "layers", &parameters).unwrap();
    (display, renderer)
}

/// Slow, by fractions of a layer's pixel, and fast: light that the board left behind on ground which it has uncovered.
///
/// The edge itself lies within a layer pixel of its place, and bilinear magnification carries it one further. One more is
/// where an edge has just been.
#[test]
fn what_is_uncovered_keeps_no_light() {
    let (mut worst_of_all, mut worst_kept) = (0.0_f32, 1.0_f32);
    for pixels_per_frame in [0.2, 0.5, 1.0, 2.5, 7.0, 20.0] {
        let (display, mut renderer) = small();
        let mut board = Board::new(260.0, 60.0, pixels_per_frame * RATE_HZ);
        let (mut ghost, mut kept) = (0.0_f32, f32::MAX);
        for index in 0..24 {
            let rgba = shown(renderer.as_mut(), &mut board, index);
            let left = board.left_px(index as f64 / RATE_HZ);
            let step = renderer.layer_costs()[2].view.unwrap().step_px()[0];
            for (i, pixel) in rgba.chunks_exact(4).enumerate() {
                let [x, _] = pixel_centre(&display, i);
                if x > 220.0 && (x < left - 3.0 * step || x > left + 60.0 + 3.0 * step) {
                    ghost = ghost.max(pixel[0]);
                }
                if x > left + 3.0 * step && x < left + 60.0 - 3.0 * step {
                    kept = kept.min(pixel[0]);
                }
            }
        }
        println!("{pixels_per_frame} px a frame: ghost {ghost:.5}, inside at least {kept:.5}");
        worst_kept = worst_kept.min(kept);
        worst_of_all = worst_of_all.max(ghost);
    }
    assert!(worst_of_all < 0.01 && worst_kept > 0.95);
}

/// A still board's edge through the middle of pixels converges to its coverage: jitter shows now one surface and now the
/// other, and both belong to the pixel.
#[test]
fn a_still_edge_is_averaged_and_not_taken_for_uncovered() {
    let (display, mut renderer) = small();
    for from_px in [300.0, 300.9, 301.7, 302.6] {
        let mut board = Board::new(from_px, 60.0, 0.0);
        let (mut rgba, mut first) = (Vec::new(), Vec::new());
        for index in 0..16 {
            rgba = shown(renderer.as_mut(), &mut board, index);
            if index == 0 {
                first.clone_from(&rgba);
            }
        }
        let view = renderer.layer_costs()[2].view.unwrap();
        // Coverage of each layer pixel by the board, magnified.
        let step = view.step_px()[0];
        let covered = |cell: f64| {
            let (low, high) = (view.origin_px[0] + cell * step, view.origin_px[0] + (cell + 1.0) * step);
            ((high.min(from_px + 60.0) - low.max(from_px)) / step).clamp(0.0, 1.0)
        };
        let (mut error, mut first_error) = (0.0_f64, 0.0_f64);
        let row = 30 * 480;
        for x in 280..400 {
            let at = (pixel_centre(&display, x)[0] - view.origin_px[0]) / step - 0.5;
            let expected = covered(at.floor()) * (1.0 - at.fract()) + covered(at.floor() + 1.0) * at.fract();
            error = error.max((f64::from(rgba[4 * (row + x)]) - expected).abs());
            first_error = first_error.max((f64::from(first[4 * (row + x)]) - expected).abs());
        }
        println!("edge at {from_px}: largest error of one drawing {first_error:.3}, after sixteen {error:.3}");
        // The newest sample weighs a tenth.
        assert!(error < 0.15);
    }
}

#[test]
fn what_is_not_a_number_does_not_live_on() {
    let (_, mut renderer) = small();
    let mut board = Board::new(300.0, 60.0, 30.0);
    for index in 0..12 {
        board.broken_px = if (3..6).contains(&index) { 1e6 } else { -1e6 };
        let rgba = shown(renderer.as_mut(), &mut board, index);
        // The inner and middle of the picture show what the scene draws; the outermost what was there before.
        let outer: Vec<f32> =
            rgba.chunks_exact(4).enumerate().filter(|(i, _)| i % 480 > 220).map(|(_, p)| p[0]).collect();
        assert!(outer.iter().all(|x| x.is_finite()), "frame {index}");
        assert!(outer.iter().any(|&x| x > 0.9), "frame {index}: the board is gone");
        if index >= 7 {
            assert!(rgba.iter().all(|x| x.is_finite()), "frame {index}: it lived on");
        }
    }
    // From the first frame on.
    renderer.begin();
    board.broken_px = 1e6;
    assert!(shown(renderer.as_mut(), &mut board, 20).chunks_exact(4).skip(221).take(200).all(|p| p[0].is_finite()));
    board.broken_px = -1e6;
    let (_, mut fresh) = small();
    shown(renderer.as_mut(), &mut board, 21);
    assert!(shown(renderer.as_mut(), &mut board, 22).iter().all(|x| x.is_finite()));
    assert!(shown(fresh.as_mut(), &mut board, 22).iter().all(|x| x.is_finite()));
}
