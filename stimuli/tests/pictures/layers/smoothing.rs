//! What jitter and reprojection bring: a still view converges to the box-filtered picture, and a slow pan flickers less.

use super::settings;
use crate::common::{Setup, display, eccentricities, gpu, looking_at};
use experiments::display::Display;
use stimuli::{DrawRequest, FrameInput, Scene, View, optimise, readback};

/// Guenter's display with a quarter of the pixels on each axis, so that a pixel is as large as four of his.
pub(super) fn small_display() -> Display {
    display([480, 270], [510.0, 286.9], 590.0)
}

/// The box-filtered picture of `view`: every pixel the mean of `k`² finer ones, in f64. RGB, row by row.
pub(super) fn box_filtered(scene: &mut dyn Scene, view: &View, animation_s: f64, k: u32) -> Vec<[f64; 3]> {
    let [width, height] = view.target_px;
    let fine = View { target_px: [width * k, height * k], ..*view };
    let target = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: width * k, height: height * k, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: stimuli::LINEAR_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    let target_view = target.create_view(&Default::default());
    scene.draw(gpu(), &mut encoder, &DrawRequest::of(fine, animation_s), &target_view).unwrap();
    gpu().queue.submit([encoder.finish()]);
    let rgba = readback::linear_rgba(gpu(), &target).unwrap();
    let mut sums = vec![[0.0; 3]; (width * height) as usize];
    for (index, pixel) in rgba.chunks_exact(4).enumerate() {
        let (x, y) = (index as u32 % (width * k) / k, index as u32 / (width * k) / k);
        for (sum, &value) in sums[(y * width + x) as usize].iter_mut().zip(pixel) {
            *sum += f64::from(value) / f64::from(k * k);
        }
    }
    sums
}

/// What bilinear magnification of `layer`, which shows `view`, gives at `px` of the display.
pub(super) fn magnified(layer: &[[f64; 3]], view: &View, px: [f64; 2]) -> [f64; 3] {
    let step = view.step_px();
    let at: [f64; 2] = std::array::from_fn(|axis| (px[axis] - view.origin_px[axis]) / step[axis] - 0.5);
    let texel = |dx: f64, dy: f64| {
        let x = (at[0].floor() + dx).clamp(0.0, f64::from(view.target_px[0] - 1)) as usize;
        let y = (at[1].floor() + dy).clamp(0.0, f64::from(view.target_px[1] - 1)) as usize;
        layer[y * view.target_px[0] as usize + x]
    };
    let share = at.map(|x| x - x.floor());
    std::array::from_fn(|c| {
        let top = texel(0.0, 0.0)[c] * (1.0 - share[0]) + texel(1.0, 0.0)[c] * share[0];
        let bottom = texel(0.0, 1.0)[c] * (1.0 - share[0]) + texel(1.0, 1.0)[c] * share[0];
        top * (1.0 - share[1]) + bottom * share[1]
    })
}

fn centre(display: &Display, index: usize) -> [f64; 2] {
    crate::common::pixel_centre(display, index)
}

/// Where the outermost layer alone shows: the mean distance of `shown` from the box-filtered layer.
fn outer_error(display: &Display, shown: &[f32], ideal: &[[f64; 3]], view: &View, outside: &[bool]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (index, _) in outside.iter().enumerate().filter(|(_, outside)| **outside) {
        let expected = magnified(ideal, view, centre(display, index));
        for (c, expected) in expected.into_iter().enumerate() {
            sum += (f64::from(shown[4 * index + c]) - expected).abs();
            count += 1;
        }
    }
    sum / f64::from(count)
}

#[test]
fn a_still_view_converges_to_the_box_filtered_picture() {
    let display = small_display();
    let still = settings([("camera", "static")], []);
    let m = 0.2;
    let parameters = settings([("half_rate", "off"), ("restrict_s2", "2")], [("m", m), ("history_weight", 0.05)]);
    let mut setup = Setup::new(&display, ("orbit", &still), ("layers", &parameters));
    let plan = optimise(&display, m, 1.0 / 48.0, 3, Some(2.0));
    let angles = eccentricities(&display, [0.0; 2]);
    let outside: Vec<bool> = angles.iter().map(|&e| e > plan.layers[1].radius_deg).collect();

    let mut errors = Vec::new();
    let mut ideal = Vec::new();
    for update in 0..32_u64 {
        let frame = FrameInput { animation_s: update as f64 / 60.0, ..looking_at([0.0; 2]) };
        let (shown, _) = setup.frame(&frame);
        let view = setup.renderer.layer_costs()[2].view.unwrap();
        if ideal.is_empty() {
            ideal = box_filtered(setup.scene.as_mut(), &view, 0.0, 8);
        }
        errors.push(outer_error(&display, &shown, &ideal, &view, &outside));
    }
    // Drawings that are jittered but not averaged are as far off at every time.
    let mut alone = parameters;
    alone.extend(settings([("reprojection", "off")], []));
    let mut setup = Setup::new(&display, ("orbit", &still), ("layers", &alone));
    let mut single = 0.0;
    for update in 0..16_u64 {
        let (shown, _) = setup.frame(&FrameInput { animation_s: update as f64 / 60.0, ..looking_at([0.0; 2]) });
        let view = setup.renderer.layer_costs()[2].view.unwrap();
        single += outer_error(&display, &shown, &ideal, &view, &outside) / 16.0;
    }
    println!(
        "outermost layer, s = {:.2}: mean error of a single drawing {single:.5} (first {:.5}), after 4 {:.5}, 16 {:.5}, 32 {:.5}; ratio {:.2}",
        plan.layers[2].sampling_factor,
        errors[0],
        errors[3],
        errors[15],
        errors[31],
        single / errors[15]
    );
    assert!(errors[15] < 0.5 * errors[0] && errors[15] < 0.5 * single);
    assert!(errors[31] < 1.1 * errors[15], "and it stays");
}

/// Mean absolute change from frame to frame in the periphery, raw: what the pan itself changes is in both.
#[test]
fn a_slow_pan_flickers_less() {
    let display = small_display();
    let pan = settings([("camera", "pan")], [("camera_speed", 2.0)]);
    let plan = optimise(&display, 0.2, 1.0 / 48.0, 3, Some(2.0));
    let angles = eccentricities(&display, [0.0; 2]);
    let flicker = |names: [(&str, &str); 3]| {
        let mut parameters = settings(names, [("m", 0.2)]);
        parameters.extend(settings([("restrict_s2", "2")], []));
        let mut setup = Setup::new(&display, ("orbit", &pan), ("layers", &parameters));
        let frames: Vec<_> = (0..40)
            .map(|i| setup.frame(&FrameInput { animation_s: f64::from(i) / 60.0, ..looking_at([0.0; 2]) }).0)
            .collect();
        let (mut sum, mut count) = (0.0, 0);
        for pair in frames[16..].windows(2) {
            for (index, _) in angles.iter().enumerate().filter(|(_, e)| **e > plan.layers[0].radius_deg) {
                for c in 0..3 {
                    sum += f64::from((pair[1][4 * index + c] - pair[0][4 * index + c]).abs());
                    count += 1;
                }
            }
        }
        sum / f64::from(count)
    };
    let full_rate = ("half_rate", "off");
    let with = flicker([full_rate, ("jitter", "outer"), ("reprojection", "on")]);
    let without = flicker([full_rate, ("jitter", "off"), ("reprojection", "off")]);
    let jitter_alone = flicker([full_rate, ("jitter", "outer"), ("reprojection", "off")]);
    println!(
        "change per frame: with both {with:.5}, without {without:.5} (ratio {:.2}), jitter alone {jitter_alone:.5}",
        without / with
    );
    assert!(with < 0.8 * without && without < jitter_alone);
}
