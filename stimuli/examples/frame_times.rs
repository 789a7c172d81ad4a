//! Milliseconds per frame of the calibration ring, brought back from the GPU as an offscreen session does, for several
//! eccentricities and detail limits, while the gaze moves about as in a fixation; and of the first frame with a new limit,
//! for which the filter has to be computed anew. Then the same for the Gaussian falloff, whose first frame is that of a
//! new picture.
//!
//! `cargo run --release -p stimuli --example frame_times -- [FRAMES [DISPLAY]]`

use experiments::catalogue::{ParameterValue, Parameters};
use experiments::display::Display;
use std::error::Error;
use std::io::Write;
use std::time::Instant;
use stimuli::{Background, DisplayPass, FrameInput, Gpu, Renderer, make_renderer, make_scene, readback};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let frames: u32 = arguments.next().map_or(Ok(12), |n| n.parse::<u32>())?;
    let name = arguments.next().unwrap_or_else(|| "demo-540p".to_owned());
    let display = Display::named(&name).ok_or("no such display")?;
    let gpu = Gpu::headless()?;
    let display_pass = DisplayPass::new(&gpu, wgpu::TextureFormat::Rgba8Unorm);
    let mut out = std::io::stdout().lock();
    writeln!(out, "{} on {}, {name}", gpu.adapter_info.name, gpu.adapter_info.backend)?;
    writeln!(out, "ms, minimum and median of {frames}; first: with a new omega, minimum of 4")?;
    writeln!(out, "  e° omega°  ring px |  render        |  with readback  |  first")?;

    let mut scene = make_scene(&gpu, &display, "photo", &Parameters::new())?;
    let mut ring = make_renderer(&gpu, &display, "ring", &Parameters::new())?;
    for e in [2.0, 4.0, 6.0, 9.0, 12.0] {
        for mar in [0.065, 0.1, 0.3, 1.0, 2.0] {
            let set_mar = |ring: &mut dyn Renderer, mar: f64| {
                let settings = [("eccentricity_deg", e), ("width_deg", 3.0), ("edge_deg", 0.5), ("mar_deg", mar)];
                let parameters: Parameters = settings
                    .into_iter()
                    .map(|(name, value)| (name.to_owned(), ParameterValue::Number(value)))
                    .collect();
                ring.set_parameters(&parameters).map_err(|errors| format!("{errors:?}"))
            };
            let mut first_ms = f64::INFINITY;
            for repeat in 0..5 {
                set_mar(ring.as_mut(), mar * (1.0 + 1e-9 * f64::from(repeat)))?;
                let begin = Instant::now();
                ring.render(&gpu, scene.as_mut(), &FrameInput::default())?;
                gpu.wait()?;
                // The very first draws the reference, makes textures and compiles.
                if repeat > 0 {
                    first_ms = first_ms.min(begin.elapsed().as_secs_f64() * 1e3);
                }
            }
            let (mut render_ms, mut all_ms, mut pixels) = (Vec::new(), Vec::new(), 0);
            for index in 0..=frames {
                let t = f64::from(index);
                let gaze_deg = [(0.7 * t).sin(), 0.6 * (1.1 * t).cos()];
                let frame = FrameInput { gaze_deg, frame_index: u64::from(index), ..FrameInput::default() };
                let begin = Instant::now();
                let cost = ring.render(&gpu, scene.as_mut(), &frame)?;
                gpu.wait()?;
                let rendered = begin.elapsed();
                let picture = Background::Picture(ring.output(), scene.light());
                readback::displayed(&gpu, &display_pass, display.resolution_px(), picture, None)?;
                // Not the way from where the gaze was before.
                if index > 0 {
                    render_ms.push(rendered.as_secs_f64() * 1e3);
                    all_ms.push(begin.elapsed().as_secs_f64() * 1e3);
                    pixels = cost.pixels_shaded;
                }
            }
            render_ms.sort_by(f64::total_cmp);
            all_ms.sort_by(f64::total_cmp);
            let middle = render_ms.len() / 2;
            writeln!(
                out,
                "{e:4} {mar:6} {pixels:8} | {:6.1} {:6.1}  | {:6.1} {:6.1}   | {first_ms:6.1}",
                render_ms[0], render_ms[middle], all_ms[0], all_ms[middle]
            )?;
        }
    }
    falloff_times(&gpu, &display, frames, &mut out)
}

/// The Gaussian falloff: the first frame of a picture, and frames in which only the gaze moves, by tenths of a degree as in
/// a fixation and by degrees.
fn falloff_times(gpu: &Gpu, display: &Display, frames: u32, out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    writeln!(out, "gaussian-falloff: ms of a picture's first frame, then of {frames} frames of a moving gaze, median")?;
    let image = |name: &str| Parameters::from([("image".to_owned(), ParameterValue::Text(name.to_owned()))]);
    for (radius_deg, rate) in [(11.0, 0.0017), (7.0, 0.0035), (4.0, 0.0052)] {
        let settings = [("radius_deg", radius_deg), ("rate", rate)];
        let parameters: Parameters =
            settings.into_iter().map(|(name, value)| (name.to_owned(), ParameterValue::Number(value))).collect();
        let mut falloff = make_renderer(gpu, display, "gaussian-falloff", &parameters)?;
        let mut milliseconds = |scene: &mut dyn stimuli::Scene, gaze_deg: [f64; 2]| -> Result<f64, Box<dyn Error>> {
            let begin = Instant::now();
            falloff.render(gpu, scene, &FrameInput { gaze_deg, ..FrameInput::default() })?;
            gpu.wait()?;
            Ok(begin.elapsed().as_secs_f64() * 1e3)
        };
        // The very first makes textures.
        milliseconds(make_scene(gpu, display, "photo", &image("grass"))?.as_mut(), [0.0; 2])?;
        let mut scene = make_scene(gpu, display, "photo", &image("gravel"))?;
        let first = milliseconds(scene.as_mut(), [0.0; 2])?;
        let mut moving = |span_deg: f64| -> Result<f64, Box<dyn Error>> {
            let gaze = |t: f64| [span_deg * (0.7 * t).sin(), 0.8 * span_deg * (1.1 * t).cos()];
            let times: Result<Vec<f64>, _> =
                (1..=frames).map(|t| milliseconds(scene.as_mut(), gaze(f64::from(t)))).collect();
            let mut times = times?;
            times.sort_by(f64::total_cmp);
            Ok(times[times.len() / 2])
        };
        let (still, wide) = (moving(0.3)?, moving(5.0)?);
        writeln!(out, "r {radius_deg:4} k {rate}: first {first:7.1} | 0.3° {still:6.1} | 5° {wide:6.1}")?;
    }
    Ok(())
}
