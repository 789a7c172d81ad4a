//! One device for all tests, short names for displays and parameters, and one call that renders a frame to floats.

use experiments::catalogue::{ParameterValue, Parameters};
use experiments::display::Display;
use std::path::Path;
use std::sync::OnceLock;
use stimuli::{FrameCost, FrameInput, Gpu, Registry, Renderer, Scene, readback};

/// The device that all tests share.
pub(crate) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::headless().unwrap_or_else(|error| panic!("{error}")))
}

/// A display of this size, seen from this far.
pub(crate) fn display(resolution_px: [u32; 2], size_mm: [f64; 2], distance_mm: f64) -> Display {
    Display::new("test", resolution_px, size_mm, distance_mm).unwrap()
}

/// Parameters that are all numbers.
pub(crate) fn numbers<const N: usize>(values: [(&str, f64); N]) -> Parameters {
    values.into_iter().map(|(name, value)| (name.to_owned(), ParameterValue::Number(value))).collect()
}

/// One parameter that is a name.
pub(crate) fn named(name: &str, value: &str) -> Parameters {
    Parameters::from([(name.to_owned(), ParameterValue::Text(value.to_owned()))])
}

/// A frame with the gaze at a place.
pub(crate) fn looking_at(gaze_deg: [f64; 2]) -> FrameInput {
    FrameInput { gaze_deg, ..FrameInput::default() }
}

/// A scene and a renderer on a display.
pub(crate) struct Setup {
    pub(crate) display: Display,
    pub(crate) scene: Box<dyn Scene>,
    pub(crate) renderer: Box<dyn Renderer>,
}

impl Setup {
    pub(crate) fn new(display: &Display, scene: (&str, &Parameters), renderer: (&str, &Parameters)) -> Self {
        Self::of(&Registry::built_in(), display, scene, renderer)
    }

    /// Of what a registry holds.
    pub(crate) fn of(
        registry: &Registry,
        display: &Display,
        scene: (&str, &Parameters),
        renderer: (&str, &Parameters),
    ) -> Self {
        Self {
            display: display.clone(),
            scene: registry.make_scene(gpu(), display, scene.0, scene.1).unwrap(),
            renderer: registry.make_renderer(gpu(), display, renderer.0, renderer.1).unwrap(),
        }
    }

    /// Renders a frame and brings it back: RGBA, row by row.
    pub(crate) fn frame(&mut self, frame: &FrameInput) -> (Vec<f32>, FrameCost) {
        let cost = self.renderer.render(gpu(), self.scene.as_mut(), frame).unwrap();
        let rgba = readback::linear_rgba(gpu(), self.renderer.output()).unwrap();
        let [width, height] = self.display.resolution_px();
        assert_eq!(rgba.len(), 4 * width as usize * height as usize);
        (rgba, cost)
    }
}

/// The reference picture of a scene.
pub(crate) fn reference(display: &Display, scene: (&str, &Parameters)) -> Vec<f32> {
    Setup::new(display, scene, ("reference", &Parameters::new())).frame(&looking_at([0.0; 2])).0
}

/// The centre of pixel `index`, counted row by row.
pub(crate) fn pixel_centre(display: &Display, index: usize) -> [f64; 2] {
    let width = display.resolution_px()[0] as usize;
    [(index % width) as f64 + 0.5, (index / width) as f64 + 0.5]
}

/// True eccentricity of every pixel, in degrees.
pub(crate) fn eccentricities(display: &Display, gaze_deg: [f64; 2]) -> Vec<f64> {
    let pixels = display.pixels() as usize;
    (0..pixels).map(|i| display.eccentricity_deg(gaze_deg, display.deg_from_px(pixel_centre(display, i)))).collect()
}

/// Writes a folder of frames with its manifest: `colour(level, frame, x, y)` in sRGB values, level 0 is the reference.
pub(crate) fn write_frames(
    folder: &Path,
    size: [u32; 2],
    frames: u32,
    mars_deg: Option<&[f64]>,
    levels: usize,
    colour: impl Fn(usize, u32, u32, u32) -> [u8; 3],
) {
    let name = |level: usize| if level == 0 { "reference".to_owned() } else { format!("level-{level}") };
    let entry = |level: usize| {
        let mar = mars_deg.map_or_else(String::new, |mars| format!(", \"mar_deg\": {}", mars[level]));
        format!("\"files\": \"{}/{{frame:03}}.png\"{mar}", name(level))
    };
    for level in 0..levels {
        std::fs::create_dir_all(folder.join(name(level))).unwrap();
        for frame in 0..frames {
            let picture = image::RgbImage::from_fn(size[0], size[1], |x, y| image::Rgb(colour(level, frame, x, y)));
            picture.save(folder.join(name(level)).join(format!("{frame:03}.png"))).unwrap();
        }
    }
    let coarser: Vec<String> =
        (1..levels).map(|level| format!("{{ \"name\": \"{}\", {} }}", name(level), entry(level))).collect();
    let manifest = format!(
        "{{ \"format\": 1, \"size_px\": [{}, {}], \"fps\": 10, \"frames\": {frames},\n\"reference\": {{ {} }},\n\"levels\": [\n{}\n] }}\n",
        size[0],
        size[1],
        entry(0),
        coarser.join(",\n")
    );
    std::fs::write(folder.join("manifest.json"), manifest).unwrap();
}
