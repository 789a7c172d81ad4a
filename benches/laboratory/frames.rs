//! Milliseconds and shaded pixels of a frame, for each renderer on two displays, beside the full-resolution picture.
//!
//! Criterion is not used here: a frame takes long, and the ratios matter more than any one number. The renderers take
//! turns, so that whatever else the machine does falls on all of them alike, and their minima are compared.
//!
//! The gaze moves at every frame. The full-resolution picture does not follow the gaze and is drawn once for a still
//! scene; to measure its drawing, two scenes that look alike take turns under every renderer but the ring. The ring keeps
//! what it filtered of a still picture, and is measured both ways: its frames while only the gaze moves, and with another
//! detail limit at each frame, for which all is filtered anew. The moving scene defeats every cache by itself.

use experiments::Display;
use experiments::catalogue::{ParameterValue, Parameters};
use std::error::Error;
use std::time::Instant;
use stimuli::{FrameInput, Gpu, Renderer, Scene, make_renderer, make_scene};

/// Displays of 960×540 and 1920×1080 pixels.
const DISPLAYS: [&str; 2] = ["demo-540p", "guenter-2012"];
/// Middle of the measured rings and their detail limit, °.
const RING_DEG: (f64, f64) = (9.0, 0.3);

/// One row of the table.
struct Contender {
    label: &'static str,
    renderer: Box<dyn Renderer>,
    scenes: Vec<Box<dyn Scene>>,
    /// Whether every frame asks for another detail limit.
    new_limits: bool,
    ms: Vec<f64>,
    pixels: Vec<u64>,
}

fn ring_parameters(mar_deg: f64) -> Parameters {
    [("eccentricity_deg", RING_DEG.0), ("width_deg", 3.0), ("edge_deg", 0.5), ("mar_deg", mar_deg)]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), ParameterValue::Number(value)))
        .collect()
}

impl Contender {
    /// A renderer and what it draws: `scenes` of a kind that take turns.
    fn new(
        gpu: &Gpu,
        display: &Display,
        label: &'static str,
        renderer: &str,
        (scene, scenes): (&str, usize),
    ) -> Result<Self, Box<dyn Error>> {
        let none = Parameters::new();
        let parameters = if renderer == "ring" { ring_parameters(RING_DEG.1) } else { none.clone() };
        let scenes = (0..scenes).map(|_| make_scene(gpu, display, scene, &none)).collect::<Result<_, _>>()?;
        let renderer = make_renderer(gpu, display, renderer, &parameters)?;
        Ok(Self { label, renderer, scenes, new_limits: false, ms: Vec::new(), pixels: Vec::new() })
    }

    /// Renders and measures frame `index`, whose gaze wanders by about a degree.
    fn frame(&mut self, gpu: &Gpu, index: u32) -> Result<(), Box<dyn Error>> {
        let t = f64::from(index);
        if self.new_limits {
            let parameters = ring_parameters(RING_DEG.1 * (1.0 + 1e-9 * t));
            self.renderer.set_parameters(&parameters).map_err(|errors| format!("{errors:?}"))?;
        }
        let turn = index as usize % self.scenes.len();
        let frame = FrameInput {
            gaze_deg: [(0.7 * t).sin(), 0.6 * (1.1 * t).cos()],
            frame_index: u64::from(index),
            animation_s: t / 60.0,
            ..FrameInput::default()
        };
        let begin = Instant::now();
        let cost = self.renderer.render(gpu, self.scenes[turn].as_mut(), &frame)?;
        gpu.wait()?;
        self.ms.push(begin.elapsed().as_secs_f64() * 1e3);
        self.pixels.push(cost.pixels_shaded);
        Ok(())
    }
}

/// The smallest and the middle one.
fn minimum_and_median(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (sorted.first().copied().unwrap_or(f64::NAN), sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN))
}

/// Measures `frames` frames of each renderer and prints the table.
pub(crate) fn print_table(frames: u32) -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::headless()?;
    println!("\nframes on {}, {}", gpu.adapter_info.name, gpu.adapter_info.backend);
    println!("ms: minimum and median of {frames}, waited for; ratio: of minima to the reference of the same scene");
    println!(
        "{:12} {:6} {:22} {:>8} {:>8} {:>12} {:>7} {:>7}",
        "display", "scene", "renderer", "min ms", "median", "pixels", "ms", "pixels"
    );
    for name in DISPLAYS {
        let display = Display::named(name).ok_or("a display that ships is missing")?;
        for scene in ["photo", "orbit"] {
            let still = if scene == "photo" { (scene, 2) } else { (scene, 1) };
            let contender = |label, renderer, scenes| Contender::new(&gpu, &display, label, renderer, scenes);
            let mut contenders = vec![contender("reference", "reference", still)?];
            if scene == "photo" {
                contenders.push(contender("ring, gaze moves", "ring", (scene, 1))?);
                let anew = contender("ring, another omega", "ring", (scene, 1))?;
                contenders.push(Contender { new_limits: true, ..anew });
            } else {
                contenders.push(contender("ring", "ring", (scene, 1))?);
            }
            contenders.push(contender("layers", "layers", still)?);

            // The first three frames make textures, compile shaders and fill the ring's tiles.
            let frames = if scene == "photo" { frames } else { frames.div_ceil(3) };
            for index in 0..frames + 3 {
                for contender in &mut contenders {
                    contender.frame(&gpu, index)?;
                }
            }
            let mut reference = None;
            for contender in &contenders {
                let (min_ms, median_ms) = minimum_and_median(&contender.ms[3..]);
                let pixels: Vec<f64> = contender.pixels[3..].iter().map(|&pixels| pixels as f64).collect();
                let (_, pixels) = minimum_and_median(&pixels);
                let (reference_ms, reference_pixels) = *reference.get_or_insert((min_ms, pixels));
                println!(
                    "{name:12} {scene:6} {:22} {min_ms:8.1} {median_ms:8.1} {pixels:12} {:7.2} {:7.2}",
                    contender.label,
                    min_ms / reference_ms,
                    pixels / reference_pixels,
                );
            }
        }
    }
    Ok(())
}
