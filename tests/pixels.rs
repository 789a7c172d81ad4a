//! The pixel observer on pictures that the renderers draw: twenty of increasing foveation, put in order by eye.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

use experiments::Display;
use experiments::catalogue::{ParameterValue, Parameters};
use experiments::contrast::{BANDS, FULL_RESOLUTION, Sensitivity};
use experiments::observers::pixels::difference;
use experiments::observers::{Picture, Seen};
use image::RgbaImage;
use stimuli::contract::FrameInput;
use stimuli::display_pass::{Background, DisplayPass};
use stimuli::gpu::Gpu;
use stimuli::{readback, registry};

/// A third of a laboratory display, at its distance: 16° wide, 34 pixels per degree at the middle.
fn display() -> Display {
    Display::new("third", [540, 304], [185.8, 104.6], 665.0).unwrap()
}

fn picture(gpu: &Gpu, display: &Display, image: &str, renderer: &str, parameters: &Parameters) -> RgbaImage {
    let of_scene = Parameters::from([("image".to_owned(), ParameterValue::Text(image.to_owned()))]);
    let mut scene = registry::make_scene(gpu, display, "photo", &of_scene).unwrap();
    let mut renderer = registry::make_renderer(gpu, display, renderer, parameters).unwrap();
    let frame = FrameInput { gaze_deg: [0.0, 0.0], ..FrameInput::default() };
    renderer.render(gpu, scene.as_mut(), &frame).unwrap();
    let pass = DisplayPass::new(gpu, wgpu::TextureFormat::Rgba8Unorm);
    let background = Background::Picture(renderer.output(), scene.light());
    readback::displayed(gpu, &pass, display.resolution_px(), background, None).unwrap()
}

/// Spearman's rank correlation of values without ties against their places.
fn rank_correlation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let rank = |value: f64| values.iter().filter(|other| **other < value).count() as f64;
    let squares: f64 = values.iter().zip(0..).map(|(&value, place)| (rank(value) - f64::from(place)).powi(2)).sum();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

#[test]
fn twenty_pictures_are_put_in_the_order_of_their_foveation() {
    let gpu = Gpu::headless().unwrap();
    let display = display();
    let size_px = display.resolution_px();
    let sensitivity = Sensitivity::of_display(&FULL_RESOLUTION, &display, [0.0, 0.0], size_px, BANDS);
    let number = |name: &str, value: f64| (name.to_owned(), ParameterValue::Number(value));
    for image in ["gravel", "coffee"] {
        let reference = picture(&gpu, &display, image, "reference", &Parameters::new());
        for renderer in ["gaussian-falloff", "layers"] {
            // Slopes from a hair to six times that of Guenter's pair test, and blurs that go with them.
            let visible: Vec<f64> = (1..=20)
                .map(|step| {
                    let slope = 0.006 * f64::from(step);
                    let parameters = match renderer {
                        "layers" => Parameters::from([number("m", slope)]),
                        _ => Parameters::from([number("radius_deg", 1.0), number("rate", 0.1874 * slope)]),
                    };
                    let shown = picture(&gpu, &display, image, renderer, &parameters);
                    let seen = Seen {
                        shown: Picture { size_px, rgba: shown.as_raw() },
                        reference: Picture { size_px, rgba: reference.as_raw() },
                        gaze_deg: [0.0, 0.0],
                        display: &display,
                    };
                    difference::visibility(&seen, &sensitivity).unwrap()
                })
                .collect();
            let correlation = rank_correlation(&visible);
            println!("{image}, {renderer}: {correlation:.3}, V from {:.2} to {:.2}", visible[0], visible[19]);
            assert!(correlation >= 0.95, "{image}, {renderer}: {correlation}: {visible:.3?}");
        }
    }
}
