//! Writes a picture of every scene under every renderer into a folder, with what each cost: a look at the whole crate.
//!
//! `cargo run --release -p stimuli --example gallery -- FOLDER [DISPLAY [SCENE]]`

use experiments::catalogue::{ParameterValue, Parameters};
use experiments::display::Display;
use std::error::Error;
use std::io::Write;
use std::time::Instant;
use stimuli::{Background, DisplayPass, FrameInput, Gpu, catalogue, make_renderer, make_scene, readback};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = std::path::PathBuf::from(arguments.next().ok_or("name a folder")?);
    let name = arguments.next().unwrap_or_else(|| "demo-540p".to_owned());
    let only = arguments.next().unwrap_or_default();
    let display = Display::named(&name).ok_or("no such display")?;
    std::fs::create_dir_all(&folder)?;
    let gpu = Gpu::headless()?;
    gpu.set_blocking_timing(true);
    let display_pass = DisplayPass::new(&gpu, wgpu::TextureFormat::Rgba8Unorm);
    let mut out = std::io::stdout().lock();
    writeln!(out, "{} on {}", gpu.adapter_info.name, gpu.adapter_info.backend)?;

    let image = |name: &str| Parameters::from([("image".to_owned(), ParameterValue::Text(name.to_owned()))]);
    let mar = |deg: f64| {
        Parameters::from([
            ("mar_deg".to_owned(), ParameterValue::Number(deg)),
            ("eccentricity_deg".to_owned(), ParameterValue::Number(8.0)),
        ])
    };
    let mut patch = image("coffee");
    for (name, value) in [("left_px", 240.0), ("top_px", 60.0), ("contrast", 0.8)] {
        patch.insert(name.to_owned(), ParameterValue::Number(value));
    }
    let falloff = |radius_deg: f64, rate: f64| {
        Parameters::from([
            ("radius_deg".to_owned(), ParameterValue::Number(radius_deg)),
            ("rate".to_owned(), ParameterValue::Number(rate)),
        ])
    };
    let spectrum = Parameters::from([("spectrum_exponent".to_owned(), ParameterValue::Number(1.0))]);
    let still = Parameters::new();
    let scenes = [
        ("orbit", "orbit", still.clone()),
        ("noise", "noise", still.clone()),
        ("noise-1-f", "noise", spectrum),
        ("chart", "campbell-robson", still.clone()),
        ("zone-plate", "zone-plate", still.clone()),
        ("gravel", "photo", image("gravel")),
        ("chelsea", "photo", image("chelsea")),
        ("coffee", "photo", image("coffee")),
        ("grass", "photo", image("grass")),
        ("patch", "patch", patch),
    ];
    let renderers = [
        ("reference", "reference", still.clone()),
        ("ring-0.1", "ring", mar(0.1)),
        ("ring-0.5", "ring", mar(0.5)),
        ("ring-2", "ring", mar(2.0)),
        ("falloff", "gaussian-falloff", falloff(4.0, 0.0052)),
        ("falloff-strong", "gaussian-falloff", falloff(3.0, 0.05)),
        ("layers", "layers", still),
    ];
    writeln!(out, "{} scenes, {} renderers known", catalogue().scenes.len(), catalogue().renderers.len())?;
    for (scene_name, scene_id, scene_parameters) in scenes.iter().filter(|(name, ..)| name.contains(&only)) {
        for (renderer_name, renderer_id, parameters) in &renderers {
            let mut scene = make_scene(&gpu, &display, scene_id, scene_parameters)?;
            let mut renderer = make_renderer(&gpu, &display, renderer_id, parameters)?;
            let mut frame = FrameInput { gaze_deg: [2.0, -0.5], ..FrameInput::default() };
            let cost = renderer.render(&gpu, scene.as_mut(), &frame)?;
            // Again elsewhere, for the time of a frame in the middle of a presentation.
            frame.gaze_deg = [1.9, -0.4];
            frame.animation_s = 0.01;
            let begin = Instant::now();
            let moving = renderer.render(&gpu, scene.as_mut(), &frame)?;
            gpu.wait()?;
            let wall_ms = begin.elapsed().as_secs_f64() * 1e3;
            let picture = Background::Picture(renderer.output(), scene.light());
            let file = folder.join(format!("stimuli-{scene_name}-{renderer_name}.png"));
            readback::displayed(&gpu, &display_pass, display.resolution_px(), picture, None)?.save(&file)?;
            writeln!(
                out,
                "{scene_name:8} {renderer_name:10} first frame {:9} px {:6.1} ms GPU, then {:9} px {:6.1} ms GPU {wall_ms:6.1} ms wall",
                cost.pixels_shaded,
                cost.gpu_time_s.unwrap_or(f64::NAN) * 1e3,
                moving.pixels_shaded,
                moving.gpu_time_s.unwrap_or(f64::NAN) * 1e3,
            )?;
        }
    }
    Ok(())
}
