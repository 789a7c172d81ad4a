//! `parafovea render`: one picture of a scene under a renderer.

use super::{inputs, print, print_json, settings};
use crate::error::LabError;
use clap::Args;
use experiments::catalogue::ParameterValue;
use serde::Serialize;
use std::path::PathBuf;
use stimuli::contract::FrameInput;
use stimuli::display_pass::{Background, DisplayPass};
use stimuli::gpu::Gpu;
use stimuli::{readback, registry};

#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    /// The scene (see `parafovea devices`).
    #[arg(long)]
    scene: String,
    /// The renderer (see `parafovea devices`).
    #[arg(long)]
    renderer: String,
    /// Where the eye looks, degrees from the display's centre, x right, y up.
    #[arg(long, value_name = "X,Y", default_value = "0,0", allow_hyphen_values = true, value_parser = pair)]
    gaze: [f64; 2],
    /// The picture to write, a PNG file.
    #[arg(long, value_name = "FILE.png")]
    out: PathBuf,
    /// The display, by name or file.
    #[arg(long, value_name = "NAME|FILE", default_value = "demo-540p")]
    display: String,
    /// A parameter of the renderer, or of the scene as scene.NAME; may be given again.
    #[arg(long, value_name = "NAME=VALUE", value_parser = settings::assignment)]
    set: Vec<(String, ParameterValue)>,
    /// Time on the scene's clock, seconds.
    #[arg(long, default_value_t = 0.0)]
    time: f64,
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
    file: String,
}

pub(super) fn run(args: &RenderArgs) -> Result<(), LabError> {
    let display =
        inputs::display(Some(&args.display))?.ok_or_else(|| LabError::BadInput("--display is required".to_owned()))?;
    let (mut of_scene, mut of_renderer) = settings::of_scene_and_renderer(&args.set);
    let known = inputs::catalogue();
    if let (Some(scene), Some(renderer)) = (known.scene(&args.scene), known.renderer(&args.renderer)) {
        settings::name_choices(&mut of_scene, &scene.parameters);
        settings::name_choices(&mut of_renderer, &renderer.parameters);
    }
    let gpu = Gpu::headless()?;
    gpu.set_blocking_timing(true);
    let mut scene = registry::make_scene(&gpu, &display, &args.scene, &of_scene)?;
    let mut renderer = registry::make_renderer(&gpu, &display, &args.renderer, &of_renderer)?;
    let frame = FrameInput { gaze_deg: args.gaze, animation_s: args.time, ..FrameInput::default() };
    let cost = renderer.render(&gpu, scene.as_mut(), &frame)?;
    let pass = DisplayPass::new(&gpu, wgpu::TextureFormat::Rgba8Unorm);
    let [width, height] = display.resolution_px();
    let background = Background::Picture(renderer.output());
    let picture = readback::displayed(&gpu, &pass, [width, height], background, None)
        .map_err(|error| LabError::Failed(error.to_string()))?;
    picture
        .save_with_format(&args.out, image::ImageFormat::Png)
        .map_err(|error| LabError::Failed(format!("cannot write {}: {error}", args.out.display())))?;
    let rendered = Rendered {
        scene: args.scene.clone(),
        renderer: args.renderer.clone(),
        width,
        height,
        gaze_deg: args.gaze,
        display_pixels: display.pixels(),
        pixels_shaded: cost.pixels_shaded,
        gpu_time_s: cost.gpu_time_s,
        file: args.out.display().to_string(),
    };
    if args.json {
        return print_json(&rendered);
    }
    let time = rendered.gpu_time_s.map_or_else(String::new, |s| format!(", GPU {:.1} ms", s * 1e3));
    print(&format!(
        "{}: {width}×{height}, {} pixels shaded of {}{time}",
        rendered.file, rendered.pixels_shaded, rendered.display_pixels
    ))
}
