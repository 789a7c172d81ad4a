//! The display pass: sRGB encoding, target formats, overlays and centring.

use crate::common::gpu;
use image::{Rgba, RgbaImage};
use stimuli::display_pass::{linear_from_srgb8, overlay_texture};
use stimuli::readback::{displayed, linear_texture_from};
use stimuli::{Background, DisplayPass};

const FORMATS: [wgpu::TextureFormat; 4] = [
    wgpu::TextureFormat::Rgba8Unorm,
    wgpu::TextureFormat::Rgba8UnormSrgb,
    wgpu::TextureFormat::Bgra8Unorm,
    wgpu::TextureFormat::Bgra8UnormSrgb,
];

/// IEC 61966-2-1: a half is 188, a fifth of the peak's code value 124; beyond 0–1 is clamped.
#[test]
fn linear_light_is_encoded_alike_in_every_format() {
    let values = [0.0, 0.002, 0.2, 0.5, 1.0, 7.0, -3.0];
    let expected = [0, 7, 124, 188, 255, 255, 0];
    let rgba: Vec<f32> = values.iter().flat_map(|&x| [x, 0.2, 0.0, 1.0]).collect();
    let picture = linear_texture_from(gpu(), [7, 1], &rgba);
    for format in FORMATS {
        let pass = DisplayPass::new(gpu(), format);
        let shown = displayed(gpu(), &pass, [7, 1], Background::Picture(&picture), None).unwrap();
        for (pixel, expected) in shown.pixels().zip(expected) {
            assert!(pixel[0].abs_diff(expected) <= 1, "{format:?}: {pixel:?} is not {expected}");
            assert!(pixel[1].abs_diff(124) <= 1 && pixel[2] == 0 && pixel[3] == 255, "{format:?}: {pixel:?}");
        }
    }
}

#[test]
fn every_code_value_survives_the_round_trip() {
    let rgba: Vec<f32> = (0..=255).flat_map(|v| [linear_from_srgb8(v), 0.0, 0.0, 1.0]).collect();
    let picture = linear_texture_from(gpu(), [256, 1], &rgba);
    let pass = DisplayPass::new(gpu(), wgpu::TextureFormat::Rgba8Unorm);
    let shown = displayed(gpu(), &pass, [256, 1], Background::Picture(&picture), None).unwrap();
    for (pixel, value) in shown.pixels().zip(0..=255) {
        assert_eq!(pixel[0], value);
    }
}

#[test]
fn overlays_are_mixed_in_linear_light_and_centred() {
    let mut overlay = RgbaImage::new(2, 1);
    overlay.put_pixel(0, 0, Rgba([255, 255, 255, 255]));
    overlay.put_pixel(1, 0, Rgba([255, 0, 0, 128]));
    let overlay = overlay_texture(gpu(), &overlay);
    for format in FORMATS {
        let pass = DisplayPass::new(gpu(), format);
        let shown = displayed(gpu(), &pass, [6, 3], Background::Uniform([0.2; 3]), Some(&overlay)).unwrap();
        let near = |x: u32, y: u32, expected: [u8; 3]| {
            let found = shown.get_pixel(x, y);
            assert!((0..3).all(|c| found[c].abs_diff(expected[c]) <= 1), "{format:?} ({x}, {y}): {found:?}");
        };
        near(0, 0, [124; 3]);
        near(2, 1, [255; 3]);
        // Half of the peak and half of a fifth: 0.602 and 0.0996.
        near(3, 1, [203, 89, 89]);
        near(4, 1, [124; 3]);
    }
}

/// Clear margins are not kept, which must not show: marks on even and odd overlays, on targets of either parity.
#[test]
fn an_overlay_stays_in_its_place_whatever_is_clear_around_it() {
    let pass = DisplayPass::new(gpu(), wgpu::TextureFormat::Rgba8Unorm);
    for (size, target) in [([9, 7], [9, 7]), ([8, 6], [8, 6]), ([8, 7], [11, 4]), ([5, 5], [12, 12])] {
        for mark in [[4, 3], [0, 0], [size[0] - 2, 1], [2, size[1] - 1]] {
            let mut picture = RgbaImage::new(size[0], size[1]);
            picture.put_pixel(mark[0], mark[1], Rgba([255, 255, 255, 255]));
            let overlay = overlay_texture(gpu(), &picture);
            let shown = displayed(gpu(), &pass, target, Background::Uniform([0.2; 3]), Some(&overlay)).unwrap();
            let place =
                |axis: usize| i64::from(mark[axis]) + (i64::from(target[axis]) - i64::from(size[axis])).div_euclid(2);
            for (x, y, pixel) in shown.enumerate_pixels() {
                let marked = [i64::from(x), i64::from(y)] == [place(0), place(1)];
                assert_eq!(pixel[0], if marked { 255 } else { 124 }, "{size:?} {target:?} {mark:?} at ({x}, {y})");
            }
        }
    }
    // Nothing but clear pixels is a picture, too.
    let clear = overlay_texture(gpu(), &RgbaImage::new(4, 4));
    let shown = displayed(gpu(), &pass, [4, 4], Background::Uniform([0.2; 3]), Some(&clear)).unwrap();
    assert!(shown.pixels().all(|pixel| pixel[0] == 124));
}

#[test]
fn a_picture_of_another_size_is_centred_on_black() {
    let picture = linear_texture_from(gpu(), [2, 2], &[1.0; 16]);
    let pass = DisplayPass::new(gpu(), wgpu::TextureFormat::Rgba8Unorm);
    let shown = displayed(gpu(), &pass, [6, 4], Background::Picture(&picture), None).unwrap();
    for (x, y, pixel) in shown.enumerate_pixels() {
        let inside = (2..4).contains(&x) && (1..3).contains(&y);
        assert_eq!(pixel[0], if inside { 255 } else { 0 }, "({x}, {y})");
    }
    let small = displayed(gpu(), &pass, [1, 1], Background::Picture(&picture), None).unwrap();
    assert_eq!(small.get_pixel(0, 0)[0], 255);
}
