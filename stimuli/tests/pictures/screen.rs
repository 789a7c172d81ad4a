//! The display pass: sRGB encoding, target formats, overlays and centring.

use crate::common::gpu;
use image::{Rgba, RgbaImage};
use stimuli::display_pass::{linear_from_srgb8, overlay_texture};
use stimuli::readback::{displayed, linear_texture_from, rgba8};
use stimuli::{Background, Disc, DisplayPass, SceneLight};

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
        let shown =
            displayed(gpu(), &pass, [7, 1], Background::Picture(&picture, SceneLight::default()), None).unwrap();
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
    let shown = displayed(gpu(), &pass, [256, 1], Background::Picture(&picture, SceneLight::default()), None).unwrap();
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
    let shown = displayed(gpu(), &pass, [6, 4], Background::Picture(&picture, SceneLight::default()), None).unwrap();
    for (x, y, pixel) in shown.enumerate_pixels() {
        let inside = (2..4).contains(&x) && (1..3).contains(&y);
        assert_eq!(pixel[0], if inside { 255 } else { 0 }, "({x}, {y})");
    }
    let small = displayed(gpu(), &pass, [1, 1], Background::Picture(&picture, SceneLight::default()), None).unwrap();
    assert_eq!(small.get_pixel(0, 0)[0], 255);
}

/// What a display of `size_px` shows with discs on it.
fn with_discs(
    size_px: [u32; 2],
    background: Background<'_>,
    discs: &[Disc],
    overlay: Option<&wgpu::Texture>,
    format: wgpu::TextureFormat,
) -> RgbaImage {
    let target = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut encoder = gpu().device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    DisplayPass::new(gpu(), format).draw(gpu(), &mut encoder, &view, size_px, background, discs, overlay);
    gpu().queue.submit([encoder.finish()]);
    rgba8(gpu(), &target).unwrap()
}

const GREY: Background<'_> = Background::Uniform([0.2; 3]);

#[test]
fn a_disc_is_a_ball_with_a_soft_edge_and_nothing_changes_around_it() {
    let disc = Disc { centre_px: [30.25, 20.5], radius_px: 9.0, colour: [230, 30, 20] };
    for format in FORMATS {
        let shown = with_discs([64, 48], GREY, &[disc], None, format);
        let (mut soft, mut brightest) = (0, (0_u32, [0_u32; 2]));
        for (x, y, pixel) in shown.enumerate_pixels() {
            let distance = (f64::from(x) + 0.5 - 30.25).hypot(f64::from(y) + 0.5 - 20.5);
            if distance >= 9.5 {
                assert_eq!(pixel.0[..3], [124; 3], "({x}, {y})");
            } else if distance > 8.5 {
                soft += 1;
            } else {
                assert!(pixel[0] > pixel[1].saturating_add(20) || pixel[0] > 200, "({x}, {y}): {pixel:?}");
            }
            let sum = pixel.0[..3].iter().map(|&c| u32::from(c)).sum();
            if distance < 8.5 && sum > brightest.0 {
                brightest = (sum, [x, y]);
            }
        }
        // A ring one pixel wide: 2π · 9 pixels.
        assert!((45..70).contains(&soft), "{soft}");
        // Lit from above on the left: the highlight stands where the ball faces halfway to the light, (−0.22, −0.33) r.
        let [x, y] = brightest.1.map(f64::from);
        assert!(
            (x + 0.5 - (30.25 - 0.217 * 9.0)).abs() < 1.1 && (y + 0.5 - (20.5 - 0.326 * 9.0)).abs() < 1.1,
            "{brightest:?}"
        );
        assert!(shown.get_pixel(25, 14)[0] > shown.get_pixel(35, 27)[0], "{format:?}");
    }
}

/// Half covered is half the light: the edge of a large disc through a pixel's middle.
#[test]
fn the_edge_of_a_disc_is_mixed_in_linear_light() {
    let disc = |radius_px: f64| [Disc { centre_px: [20.0, 20.5], radius_px, colour: [0, 0, 0] }];
    let format = wgpu::TextureFormat::Rgba8Unorm;
    // Far from the highlight, at the lower right, a black ball is black.
    let shown = with_discs([48, 40], GREY, &disc(15.5), None, format);
    // Pixel 35 has its middle at 15.5 from the centre: 0.1 is code value 89.
    assert!(shown.get_pixel(35, 20)[0].abs_diff(89) <= 1, "{:?}", shown.get_pixel(35, 20));
    assert_eq!(shown.get_pixel(36, 20)[0], 124);
    assert!(shown.get_pixel(34, 20)[0] <= 3);
}

#[test]
fn discs_lie_under_the_overlay_in_display_pixels_and_in_order() {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let ball = |centre_px: [f64; 2], colour: [u8; 3]| Disc { centre_px, radius_px: 6.0, colour };
    let mut mark = RgbaImage::new(4, 4);
    mark.pixels_mut().for_each(|pixel| *pixel = Rgba([0, 0, 255, 255]));
    let mark = overlay_texture(gpu(), &mark);

    // The display is the picture in the target's middle: its (10, 8) is the target's (20, 16).
    let picture = linear_texture_from(gpu(), [20, 16], &[0.2; 4 * 20 * 16].map(|x: f32| x));
    let background = Background::Picture(&picture, SceneLight::default());
    let discs = [ball([10.0, 8.0], [0, 255, 0]), ball([14.0, 8.0], [255, 0, 0])];
    let shown = with_discs([40, 32], background, &discs, Some(&mark), format);
    assert_eq!(shown.get_pixel(19, 15).0, [0, 0, 255, 255], "the overlay is on top");
    assert_eq!(shown.get_pixel(21, 17).0, [0, 0, 255, 255]);
    let (first, both, none) = (shown.get_pixel(16, 16), shown.get_pixel(23, 16), shown.get_pixel(4, 4));
    assert!(first[1] > first[0] && both[0] > both[1] && none[0] == 0, "{first:?} {both:?} {none:?}");
    // Half an overlay lets the disc through.
    let half = overlay_texture(gpu(), &RgbaImage::from_pixel(4, 4, Rgba([0, 0, 255, 128])));
    let shown = with_discs([40, 32], background, &[ball([10.0, 8.0], [255, 0, 0])], Some(&half), format);
    let mixed = shown.get_pixel(20, 17);
    assert!(mixed[0] > 120 && mixed[2] > 120 && mixed[1] < 160, "{mixed:?}");
}

#[test]
fn no_disc_that_shows_is_no_disc() {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let at = |centre_px: [f64; 2], radius_px: f64| Disc { centre_px, radius_px, colour: [255; 3] };
    let plain = with_discs([32, 24], GREY, &[], None, format);
    let pass = DisplayPass::new(gpu(), format);
    assert!(plain == displayed(gpu(), &pass, [32, 24], GREY, None).unwrap());
    let hidden = [
        at([-50.0, 5.0], 10.0),
        at([5.0, 1e300], 10.0),
        at([f64::NAN, 5.0], 10.0),
        at([5.0, 5.0], 0.0),
        at([5.0, 5.0], -3.0),
        at([5.0, 5.0], f64::INFINITY),
    ];
    assert!(with_discs([32, 24], GREY, &hidden, None, format) == plain);
    // The seventeenth is not shown.
    let mut many = vec![at([-50.0, 5.0], 1.0); 16];
    many.push(at([16.0, 12.0], 5.0));
    assert!(with_discs([32, 24], GREY, &many, None, format) == plain);
    assert!(with_discs([32, 24], GREY, &many[1..], None, format) != plain);
    // A corner is enough.
    assert!(with_discs([32, 24], GREY, &[at([-3.0, -3.0], 6.0)], None, format) != plain);
}
