//! The display transform: exposure, tone map and the display's own transfer, against the same in f64.

use crate::common::{display, gpu};
use experiments::display::Transfer;
use stimuli::readback::{displayed, linear_texture_from};
use stimuli::{Background, DisplayPass, SceneLight, ToneMap};

const FORMATS: [wgpu::TextureFormat; 2] = [wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Bgra8UnormSrgb];

/// A display whose black is 0.3 % of its peak and whose channels differ.
fn measured() -> Transfer {
    let levels: Vec<f64> = (0..=16).map(|i| (f64::from(i) * 16.0).min(255.0)).collect();
    let of = |gamma: f64, peak: f64| levels.iter().map(|x| peak * (0.003 + (x / 255.0).powf(gamma))).collect();
    Transfer::measured(levels.clone(), [of(2.05, 42.0), of(2.3, 150.0), of(2.6, 11.0)]).unwrap()
}

/// The displayed 8-bit values of light, and the light as the half float that the picture holds.
fn shown(
    transfer: &Transfer,
    light: SceneLight,
    values: &[f32],
    format: wgpu::TextureFormat,
) -> (Vec<[u8; 3]>, Vec<f32>) {
    let screen = display([64, 64], [100.0, 100.0], 500.0).with_transfer(transfer.clone());
    let pass = DisplayPass::for_display(gpu(), format, &screen);
    let rgba: Vec<f32> = values.iter().flat_map(|&x| [x, x, x, 1.0]).collect();
    let size_px = [values.len() as u32, 1];
    let picture = linear_texture_from(gpu(), size_px, &rgba);
    let held = stimuli::readback::linear_rgba(gpu(), &picture).unwrap();
    let shown = displayed(gpu(), &pass, size_px, Background::Picture(&picture, light), None).unwrap();
    (shown.pixels().map(|p| [p[0], p[1], p[2]]).collect(), held.chunks_exact(4).map(|p| p[0]).collect())
}

/// The largest distance, in 8-bit steps, between what is shown and what should be before it is rounded.
fn worst_step(transfer: &Transfer, light: SceneLight, values: &[f32], format: wgpu::TextureFormat) -> f64 {
    let (bytes, held) = shown(transfer, light, values, format);
    let mut worst: f64 = 0.0;
    for (found, &value) in bytes.iter().zip(&held) {
        for (channel, light) in light.shown([f64::from(value); 3]).into_iter().enumerate() {
            worst = worst.max((255.0 * transfer.signal_from_light(channel, light) - f64::from(found[channel])).abs());
        }
    }
    worst
}

#[test]
fn every_transfer_is_within_half_a_step_of_its_inverse() {
    // Dark light finely, then all of it, then too much.
    let values: Vec<f32> =
        (0..400).map(|i| i as f32 * 2e-5).chain((0..=1000).map(|i| i as f32 * 1e-3)).chain([1.5, -0.5]).collect();
    for transfer in [Transfer::Srgb, Transfer::gamma([1.0, 2.2, 4.0]).unwrap(), measured()] {
        for format in FORMATS {
            let worst = worst_step(&transfer, SceneLight::default(), &values, format);
            println!("{format:?}: {worst:.4} steps");
            // The driver's own encoding is less exact than the shader's.
            assert!(worst <= if format.is_srgb() { 0.75 } else { 0.501 }, "{format:?}: {worst}");
        }
    }
}

#[test]
fn the_light_of_a_display_that_is_driven_is_the_light_that_was_wanted() {
    for transfer in [Transfer::gamma([2.2, 1.8, 2.5]).unwrap(), measured()] {
        let values: Vec<f32> = (0..=100).map(|i| i as f32 * 0.01).collect();
        let (bytes, held) = shown(&transfer, SceneLight::default(), &values, FORMATS[0]);
        for (found, &wanted) in bytes.iter().zip(&held) {
            for (channel, &found) in found.iter().enumerate() {
                let signal = f64::from(found) / 255.0;
                let [below, above] =
                    [-0.51, 0.51].map(|half| transfer.light_from_signal(channel, signal + half / 255.0));
                let black = transfer.light_from_signal(channel, 0.0);
                let wanted = f64::from(wanted).max(black);
                assert!((below..=above).contains(&wanted), "{wanted} is not within {below}–{above}");
            }
        }
    }
}

/// Half of the peak is 255 · 0.5^(1/2.2) = 186.1, and the grey of pages, 128 of sRGB, has the light 0.2159: 126.97.
#[test]
fn a_gamma_display_shows_grey_where_it_should() {
    let transfer = Transfer::gamma([2.2, 2.2, 1.0]).unwrap();
    let (bytes, _) = shown(&transfer, SceneLight::default(), &[0.5, 0.0, 1.0], FORMATS[0]);
    assert_eq!(bytes, [[186, 186, 128], [0; 3], [255; 3]]);
    let screen = display([64, 64], [100.0, 100.0], 500.0).with_transfer(transfer);
    let pass = DisplayPass::for_display(gpu(), FORMATS[0], &screen);
    let grey = Background::Uniform([f64::from(stimuli::display_pass::linear_from_srgb8(128)); 3]);
    let page = displayed(gpu(), &pass, [2, 2], grey, None).unwrap();
    assert_eq!(page.get_pixel(1, 1).0, [127, 127, 55, 255]);
}

#[test]
fn exposure_and_tone_map_are_those_of_the_processor() {
    let values: Vec<f32> = (0..2000).map(|i| i as f32 * 5e-3).chain([50.0, 6e4]).collect();
    for tone_map in [ToneMap::Clamp, ToneMap::Filmic] {
        for exposure in [0.0, 0.25, 1.0, 3.7] {
            let light = SceneLight { exposure, tone_map };
            for transfer in [Transfer::Srgb, measured()] {
                let worst = worst_step(&transfer, light, &values, FORMATS[0]);
                println!("{tone_map:?}, exposure {exposure}: {worst:.4} steps");
                assert!(worst <= 0.502, "{light:?} {transfer:?}: {worst}");
            }
        }
    }
}

/// A picture that needs neither exposure nor tone map is what it always was, and the tone map leaves the shadows alone.
#[test]
fn the_tone_map_changes_only_what_is_bright() {
    let values: Vec<f32> = (0..=1000).map(|i| i as f32 * 1e-3).collect();
    let light = |tone_map| SceneLight { exposure: 1.0, tone_map };
    let (clamped, _) = shown(&Transfer::Srgb, light(ToneMap::Clamp), &values, FORMATS[0]);
    let (filmic, held) = shown(&Transfer::Srgb, light(ToneMap::Filmic), &values, FORMATS[0]);
    for ((clamped, filmic), value) in clamped.iter().zip(&filmic).zip(&held) {
        assert!(filmic[0] <= clamped[0]);
        assert!(*value > 0.25 || clamped == filmic, "{value}");
        assert!(*value < 0.5 || clamped[0] > filmic[0], "{value}");
    }
}
