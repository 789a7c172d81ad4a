//! `parafovea render`: one picture of a scene under a renderer, as the display would show it or as linear light, and a
//! heat map of where its shading ran.

mod colours;
mod files;
mod heat_map;

use super::{inputs, print, print_json, resources, settings};
use crate::error::LabError;
use clap::Args;
use experiments::Display;
use experiments::catalogue::ParameterValue;
use files::PictureFormat;
use heat_map::HeatMap;
use serde::Serialize;
use std::path::PathBuf;
use stimuli::contract::{FrameCost, FrameInput, LayerCost, Renderer, Scene};
use stimuli::display_pass::{Background, DisplayPass};
use stimuli::gpu::Gpu;
use stimuli::readback::{self, ReadbackError};
use stimuli::tally::{Counts, Tallied, Tally};

/// Pixels of the largest picture: its linear light fills half a gigabyte.
const MOST_PIXELS: u64 = 1 << 26;

#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    /// The scene (see `parafovea devices`), a picture, or a folder of frames.
    #[arg(long)]
    scene: String,
    /// The renderer (see `parafovea devices`), a WGSL file, or a folder of frames.
    #[arg(long)]
    renderer: String,
    /// Where the eye looks, degrees from the display's centre, x right, y up.
    #[arg(long, value_name = "X,Y", default_value = "0,0", allow_hyphen_values = true, value_parser = pair)]
    gaze: [f64; 2],
    /// The picture to write: a PNG file as the display would show it, or an EXR file of the renderer's linear light before
    /// exposure and tone map.
    #[arg(long, value_name = "FILE.png|FILE.exr")]
    out: PathBuf,
    /// A picture to write of how often shading ran for each display pixel, counted on the GPU in the last frame.
    #[arg(long, value_name = "FILE.png")]
    heatmap: Option<PathBuf>,
    /// The display, by name or file.
    #[arg(long, value_name = "NAME|FILE", default_value = "demo-540p")]
    display: String,
    /// Width and height in pixels; the display stays as large and as far away as it is.
    #[arg(long, value_name = "WxH", value_parser = settings::size)]
    size: Option<[u32; 2]>,
    /// A parameter of the renderer, or of the scene as scene.NAME; may be given again.
    #[arg(long, value_name = "NAME=VALUE", value_parser = settings::assignment)]
    set: Vec<(String, ParameterValue)>,
    /// Time on the scene's clock, seconds.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = seconds)]
    time: f64,
    /// How many frames to render, the last one at --time: renderers that use older frames again have settled then.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Frames a second.
    #[arg(long, default_value_t = 60.0, value_parser = rate)]
    fps: f64,
    /// Draw again whenever the scene's or renderer's file changes, until the program is ended.
    #[arg(long)]
    watch: bool,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let wrong = || "expected two numbers of degrees, as 5,-3".to_owned();
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.abs() < 90.0).ok_or_else(wrong);
    Ok([number(x)?, number(y)?])
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|x| x.abs() <= 1e6);
    number.ok_or_else(|| "expected a number of seconds, at most a million".to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|x| (0.01..=10_000.0).contains(x));
    number.ok_or_else(|| "expected a number of frames a second, from 0.01 to 10000".to_owned())
}

#[derive(Debug, Serialize)]
struct Rendered {
    scene: String,
    renderer: String,
    width: u32,
    height: u32,
    gaze_deg: [f64; 2],
    display_pixels: u64,
    pixels_shaded: u64,
    gpu_time_s: Option<f64>,
    time_s: f64,
    frames: u32,
    triangles: u64,
    rays_traced: u64,
    layers: Vec<LayerRow>,
    #[serde(skip_serializing_if = "Option::is_none")]
    counted: Option<Counted>,
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    heatmap: Option<String>,
}

/// One layer of the last frame.
#[derive(Debug, Serialize)]
struct LayerRow {
    name: &'static str,
    width: u32,
    height: u32,
    /// Pixels of its target, shaded in this frame or not.
    pixels: u64,
    drawn: bool,
    pixels_shaded: u64,
    triangles: u64,
    gpu_time_s: Option<f64>,
}

/// What was counted on the GPU in the last frame.
#[derive(Debug, Serialize)]
struct Counted {
    pixels: u64,
    runs: u64,
}

impl From<&LayerCost> for LayerRow {
    fn from(layer: &LayerCost) -> Self {
        let [width, height] = layer.view.map_or([0; 2], |view| view.target_px);
        Self {
            name: layer.name,
            width,
            height,
            pixels: layer.view.map_or(0, |view| view.pixels()),
            drawn: layer.drawn,
            pixels_shaded: layer.cost.pixels_shaded,
            triangles: layer.cost.triangles,
            gpu_time_s: layer.gpu_time_s,
        }
    }
}

pub(super) fn run(args: &RenderArgs) -> Result<(), LabError> {
    if args.watch {
        return resources::watch(&resources::watchable(&[&args.scene, &args.renderer]), || draw(args));
    }
    draw(args)
}

fn draw(args: &RenderArgs) -> Result<(), LabError> {
    let display = display_of(args)?;
    let format = PictureFormat::of(&args.out)?;
    files::check_place("--out", &args.out)?;
    if let Some(heat_map) = &args.heatmap {
        files::check_heat_map(heat_map)?;
        files::check_place("--heatmap", heat_map)?;
        if *heat_map == args.out {
            return Err(LabError::BadInput("--heatmap and --out name the same file".to_owned()));
        }
    }
    let (registry, [scene_id, renderer_id]) = resources::registry_for(&args.scene, &args.renderer)?;
    let known = registry.catalogue();
    let (mut of_scene, mut of_renderer) = settings::of_scene_and_renderer(&args.set);
    if let (Some(scene), Some(renderer)) = (known.scene(&scene_id), known.renderer(&renderer_id)) {
        settings::name_choices(&mut of_scene, &scene.parameters);
        settings::name_choices(&mut of_renderer, &renderer.parameters);
    }
    if let Some(mismatch) = known.mismatch(&scene_id, &renderer_id, Some(display.resolution_px())) {
        return Err(LabError::BadInput(format!("--scene {}: {mismatch}", args.scene)));
    }
    let gpu = Gpu::headless()?;
    gpu.set_blocking_timing(true);
    let mut scene = registry.make_scene(&gpu, &display, &scene_id, &of_scene)?;
    let mut renderer = registry.make_renderer(&gpu, &display, &renderer_id, &of_renderer)?;
    let cost = presented(&gpu, renderer.as_mut(), scene.as_mut(), args)?;
    let layers = renderer.layer_costs().iter().map(LayerRow::from).collect();
    write_picture(&gpu, renderer.as_ref(), scene.as_ref(), &display, format, args)?;
    let counted = match &args.heatmap {
        Some(file) => {
            let counts = counted(&gpu, renderer.as_mut(), scene.as_mut(), &display, args)?;
            let [x, y] = args.gaze;
            let caption = format!("{} under {}, gaze {x}°, {y}°", args.scene, args.renderer);
            let heat_map = HeatMap { display: &display, runs: &counts.runs, gaze_deg: args.gaze, caption: &caption };
            files::write_png(file, &heat_map.draw())?;
            let runs = counts.draws.iter().map(|draw| u64::from(draw.runs)).sum();
            Some(Counted { pixels: counts.pixels(), runs })
        }
        None => None,
    };
    let [width, height] = display.resolution_px();
    let rendered = Rendered {
        scene: args.scene.clone(),
        renderer: args.renderer.clone(),
        width,
        height,
        gaze_deg: args.gaze,
        display_pixels: display.pixels(),
        pixels_shaded: cost.pixels_shaded,
        gpu_time_s: cost.gpu_time_s,
        time_s: args.time,
        frames: args.frames,
        triangles: cost.triangles,
        rays_traced: cost.rays_traced,
        layers,
        counted,
        file: args.out.display().to_string(),
        heatmap: args.heatmap.as_ref().map(|file| file.display().to_string()),
    };
    if args.json { print_json(&rendered) } else { print(&in_words(&rendered)) }
}

/// The display, with the pixels that were asked for.
fn display_of(args: &RenderArgs) -> Result<Display, LabError> {
    let named =
        inputs::display(Some(&args.display))?.ok_or_else(|| LabError::BadInput("--display is required".to_owned()))?;
    let display = match args.size {
        Some(size_px) => named.with_resolution_px(size_px).map_err(|errors| {
            let all: Vec<String> = errors.iter().map(ToString::to_string).collect();
            LabError::BadInput(format!("--size: {}", all.join("; ")))
        })?,
        None => named,
    };
    if display.pixels() > MOST_PIXELS {
        let [width, height] = display.resolution_px();
        return Err(LabError::BadInput(format!(
            "expected at most {MOST_PIXELS} pixels, found {width}×{height}, which are {}",
            display.pixels()
        )));
    }
    Ok(display)
}

/// The frames of a presentation, the last of them at `--time`.
fn frames(args: &RenderArgs) -> impl Iterator<Item = FrameInput> + '_ {
    (0..args.frames).map(|index| FrameInput {
        gaze_deg: args.gaze,
        frame_index: u64::from(index),
        animation_s: args.time - f64::from(args.frames - 1 - index) / args.fps,
        ..FrameInput::default()
    })
}

/// Presents all frames and returns the last one's cost.
fn presented(
    gpu: &Gpu,
    renderer: &mut dyn Renderer,
    scene: &mut dyn Scene,
    args: &RenderArgs,
) -> Result<FrameCost, LabError> {
    renderer.begin();
    let mut cost = FrameCost::default();
    for frame in frames(args) {
        cost = renderer.render(gpu, scene, &frame)?;
    }
    Ok(cost)
}

/// Presents all frames once more and returns what was counted in the last one. Frames that are counted are not timed.
fn counted(
    gpu: &Gpu,
    renderer: &mut dyn Renderer,
    scene: &mut dyn Scene,
    display: &Display,
    args: &RenderArgs,
) -> Result<Counts, LabError> {
    let tally = Tally::new(gpu, display.resolution_px());
    let mut scene = Tallied::new(scene, &tally);
    renderer.begin();
    let mut before = tally.counts(gpu)?;
    for frame in frames(args) {
        if frame.frame_index + 1 == u64::from(args.frames) {
            before = tally.counts(gpu)?;
        }
        renderer.render(gpu, &mut scene, &frame)?;
    }
    Ok(tally.counts(gpu)?.since(&before))
}

fn write_picture(
    gpu: &Gpu,
    renderer: &dyn Renderer,
    scene: &dyn Scene,
    display: &Display,
    format: PictureFormat,
    args: &RenderArgs,
) -> Result<(), LabError> {
    let failed = |error: ReadbackError| LabError::Failed(error.to_string());
    let size_px = display.resolution_px();
    match format {
        PictureFormat::Png => {
            let pass = DisplayPass::for_display(gpu, wgpu::TextureFormat::Rgba8Unorm, display);
            let background = Background::Picture(renderer.output(), scene.light());
            let picture = readback::displayed(gpu, &pass, size_px, background, None).map_err(failed)?;
            files::write_png(&args.out, &picture)
        }
        PictureFormat::Exr => {
            let rgba = readback::linear_rgba(gpu, renderer.output()).map_err(failed)?;
            files::write_exr(&args.out, size_px, &rgba)
        }
    }
}

fn in_words(rendered: &Rendered) -> String {
    let time = rendered.gpu_time_s.map_or_else(String::new, |s| format!(", GPU {:.1} ms", s * 1e3));
    let Rendered { file, width, height, pixels_shaded, display_pixels, .. } = rendered;
    let mut text = format!("{file}: {width}×{height}, {pixels_shaded} pixels shaded of {display_pixels}{time}");
    for layer in &rendered.layers {
        let state = if layer.drawn { "drawn" } else { "shown again" };
        text.push_str(&format!("\n  {}: {}×{}, {state}", layer.name, layer.width, layer.height));
    }
    if let (Some(counted), Some(file)) = (&rendered.counted, &rendered.heatmap) {
        text.push_str(&format!("\n{file}: {} pixels counted, {} shading runs", counted.pixels, counted.runs));
    }
    text
}
