//! Draws every scene under every renderer into a folder, one picture each and all of them on one sheet: a look at the
//! whole crate, and the README's contact sheet.
//!
//! `cargo run --release -p stimuli --example gallery -- FOLDER [DISPLAY [SCENE]]`
//!
//! Rows of the sheet are scenes, columns renderers, in the order of the lines that are printed. Renderers that remember
//! show their last frame of several, as an observer would see it.

use experiments::catalogue::{ParameterValue, Parameters};
use experiments::display::Display;
use image::RgbaImage;
use image::imageops::{FilterType, overlay, resize};
use std::error::Error;
use std::io::Write;
use std::time::Instant;
use stimuli::{Background, DisplayPass, FrameInput, Gpu, catalogue, make_renderer, make_scene, readback};

/// Width and height of a picture on the sheet, and the white between them.
const TILE_PX: [u32; 2] = [320, 180];
const GAP_PX: u32 = 6;
/// Where the eye looks, and how many frames a renderer that remembers is given.
const GAZE_DEG: [f64; 2] = [3.0, -1.5];
const SETTLING_FRAMES: u32 = 6;

/// Parameters that show what a renderer does on a small picture.
fn telling(renderer: &str) -> Parameters {
    let numbers: &[(&str, f64)] = match renderer {
        "ring" => &[("mar_deg", 0.6), ("eccentricity_deg", 8.0)],
        "gaussian-falloff" => &[("radius_deg", 3.0), ("rate", 0.02)],
        "layers" => &[("m", 0.06)],
        _ => &[],
    };
    numbers.iter().map(|&(name, value)| (name.to_owned(), ParameterValue::Number(value))).collect()
}

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

    let catalogue = catalogue();
    let scenes: Vec<_> = catalogue.scenes.iter().filter(|scene| scene.id.contains(&only)).collect();
    let size = |count: usize, tile: u32| count as u32 * (tile + GAP_PX) + GAP_PX;
    let sheet_px = [size(catalogue.renderers.len(), TILE_PX[0]), size(scenes.len(), TILE_PX[1])];
    let mut sheet = RgbaImage::from_pixel(sheet_px[0], sheet_px[1], image::Rgba([255; 4]));
    for (row, scene_info) in scenes.iter().enumerate() {
        for (column, renderer_info) in catalogue.renderers.iter().enumerate() {
            let mut scene = make_scene(&gpu, &display, &scene_info.id, &Parameters::new())?;
            let mut renderer = make_renderer(&gpu, &display, &renderer_info.id, &telling(&renderer_info.id))?;
            renderer.begin();
            let frames = if renderer.remembers() { SETTLING_FRAMES } else { 2 };
            let mut first = None;
            let mut last = None;
            for index in 0..frames {
                // The last frame is at the same moment under every renderer.
                let animation_s = 0.2 - f64::from(frames - 1 - index) / 60.0;
                let input = FrameInput { gaze_deg: GAZE_DEG, animation_s, ..FrameInput::default() };
                let begin = Instant::now();
                let cost = renderer.render(&gpu, scene.as_mut(), &input)?;
                gpu.wait()?;
                last = Some((cost, begin.elapsed().as_secs_f64() * 1e3));
                first = first.or(last);
            }
            let picture = Background::Picture(renderer.output(), scene.light());
            let picture = readback::displayed(&gpu, &display_pass, display.resolution_px(), picture, None)?;
            picture.save(folder.join(format!("{}-{}.png", scene_info.id, renderer_info.id)))?;
            let tile = resize(&picture, TILE_PX[0], TILE_PX[1], FilterType::Triangle);
            let corner = [size(column, TILE_PX[0]), size(row, TILE_PX[1])].map(i64::from);
            overlay(&mut sheet, &tile, corner[0], corner[1]);
            if let (Some((first, first_ms)), Some((last, last_ms))) = (first, last) {
                writeln!(
                    out,
                    "{:14} {:17} first frame {:9} px {first_ms:8.1} ms, then {:9} px {:7} triangles {last_ms:7.1} ms",
                    scene_info.id, renderer_info.id, first.pixels_shaded, last.pixels_shaded, last.triangles,
                )?;
            }
        }
    }
    sheet.save(folder.join("sheet.png"))?;
    Ok(())
}
