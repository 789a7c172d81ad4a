//! Draws a scene along its camera's path, as the reference shows it, into a folder, with what each frame cost: a look at
//! the scenes' composition and light.
//!
//! `cargo run --release -p stimuli --example flights -- FOLDER [DISPLAY [FRAMES [SECONDS [SCENE...]]]]`

use experiments::catalogue::{ParameterValue, Parameters};
use experiments::display::Display;
use std::error::Error;
use std::io::Write;
use std::time::Instant;
use stimuli::{FrameInput, Gpu, catalogue, make_renderer, make_scene, readback};

/// Pictures side by side on a sheet.
const COLUMNS: u32 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = std::path::PathBuf::from(arguments.next().ok_or("name a folder")?);
    let name = arguments.next().unwrap_or_else(|| "demo-540p".to_owned());
    let frames: u32 = arguments.next().map_or(Ok(8), |text| text.parse())?;
    let seconds: f64 = arguments.next().map_or(Ok(10.0), |text| text.parse())?;
    let mut ids: Vec<String> = arguments.collect();
    if ids.is_empty() {
        let flown =
            |scene: &experiments::catalogue::SceneInfo| scene.parameters.iter().any(|p| p.name == "camera_start_s");
        ids = catalogue().scenes.into_iter().filter(flown).map(|scene| scene.id).collect();
    }
    let (name, part) =
        name.split_once('/').map_or((name.as_str(), 1), |(name, part)| (name, part.parse().unwrap_or(1)));
    let display = Display::named(name).ok_or("no such display")?;
    let [width_px, height_px] = display.resolution_px();
    let display =
        Display::new("smaller", [width_px / part, height_px / part], display.size_mm(), display.distance_mm())
            .map_err(|errors| format!("{errors:?}"))?;
    std::fs::create_dir_all(&folder)?;
    let gpu = Gpu::headless()?;
    gpu.set_blocking_timing(true);
    let mut out = std::io::stdout().lock();
    for id in &ids {
        let begin = Instant::now();
        let parameters = Parameters::from([("camera_speed".to_owned(), ParameterValue::Number(1.0))]);
        let mut scene = make_scene(&gpu, &display, id, &parameters)?;
        writeln!(out, "{id}: made in {:.0} ms", begin.elapsed().as_secs_f64() * 1e3)?;
        let mut renderer = make_renderer(&gpu, &display, "reference", &Parameters::new())?;
        let mut sheet = image::RgbImage::new(
            COLUMNS * display.resolution_px()[0],
            frames.div_ceil(COLUMNS) * display.resolution_px()[1],
        );
        for index in 0..frames {
            let frame = FrameInput { animation_s: f64::from(index) * seconds, ..FrameInput::default() };
            let begin = Instant::now();
            let cost = renderer.render(&gpu, scene.as_mut(), &frame)?;
            gpu.wait()?;
            let wall_ms = begin.elapsed().as_secs_f64() * 1e3;
            let linear = readback::linear_rgba(&gpu, renderer.output())?;
            let light = scene.light();
            let byte = |x: f32| {
                let x = f64::from(x) * light.exposure;
                let knee = 0.25;
                let t = (x.min(8.0) - knee).max(0.0) / (1.0 - knee);
                let end: f64 = (8.0 - knee) / (1.0 - knee);
                let shown = x.min(knee) + (1.0 - knee) * t * (1.0 + t / (end * end)) / (1.0 + t);
                let shown = if light.tone_map == stimuli::ToneMap::Filmic { shown } else { x.min(1.0) };
                let signal = if shown < 0.003_130_8 { 12.92 * shown } else { 1.055 * shown.powf(1.0 / 2.4) - 0.055 };
                (255.0 * signal).round() as u8
            };
            let [width, height] = display.resolution_px();
            let rgb: Vec<u8> = linear.chunks_exact(4).flat_map(|p| [byte(p[0]), byte(p[1]), byte(p[2])]).collect();
            let picture = image::RgbImage::from_raw(width, height, rgb).ok_or("sizes differ")?;
            let (x, y) = (index % COLUMNS * width, index / COLUMNS * height);
            image::imageops::replace(&mut sheet, &picture, i64::from(x), i64::from(y));
            writeln!(
                out,
                "{id} after {:5.1} s: {:7} triangles {:7.1} ms GPU {wall_ms:7.1} ms wall",
                frame.animation_s,
                cost.triangles,
                cost.gpu_time_s.unwrap_or(f64::NAN) * 1e3,
            )?;
        }
        sheet.save(folder.join(format!("{id}.png")))?;
    }
    Ok(())
}
