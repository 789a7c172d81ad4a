//! Noise with a spectrum, the contrast sensitivity chart and the zone plate, against the formulas that define them.

use crate::common::{Setup, display, gpu, looking_at, numbers, pixel_centre, reference};
use experiments::catalogue::Parameters;
use experiments::display::Display;
use std::f64::consts::TAU;
use stimuli::{DrawRequest, FrameInput, View, make_scene, readback};

/// Slope of a line through points by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// Amplitude of the picture's wave of `u` and `v` cycles across and down, by the sum that defines it.
fn amplitude(grey: &[f64], size: usize, [u, v]: [i64; 2]) -> f64 {
    let turn = |k: i64, i: usize| (TAU * (k * i as i64).rem_euclid(size as i64) as f64 / size as f64).sin_cos();
    let columns: Vec<(f64, f64)> = (0..size).map(|x| turn(u, x)).collect();
    let (mut re, mut im) = (0.0, 0.0);
    for (y, row) in grey.chunks_exact(size).enumerate() {
        let (sin_y, cos_y) = turn(v, y);
        let (mut a, mut b) = (0.0, 0.0);
        for (value, (sin_x, cos_x)) in row.iter().zip(&columns) {
            a += value * cos_x;
            b += value * sin_x;
        }
        re += a * cos_y - b * sin_y;
        im += a * sin_y + b * cos_y;
    }
    re.hypot(im)
}

#[test]
fn the_spectrum_of_noise_falls_as_it_is_told() {
    // The tile's own size, where waves are whole.
    let screen = display([1024, 1024], [400.0, 400.0], 800.0);
    let waves: Vec<[i64; 2]> = [3_i64, 5, 9, 16, 29, 52, 93, 167, 300]
        .iter()
        .flat_map(|&k| [[k, 0], [0, k], [k, k], [-k, 2 * k / 3], [k / 2, k]])
        .collect();
    for (exponent, seed) in [(0.5, 1.0), (1.0, 2.0), (1.0, 3.0), (1.7, 4.0)] {
        let settings = numbers([("spectrum_exponent", exponent), ("seed", seed)]);
        let rgba = reference(&screen, ("noise", &settings));
        let grey: Vec<f64> = rgba.chunks_exact(4).map(|p| f64::from(p[0])).collect();
        let mean = grey.iter().sum::<f64>() / grey.len() as f64;
        let deviation = (grey.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / grey.len() as f64).sqrt();
        let points: Vec<(f64, f64)> = waves
            .iter()
            .map(|&[u, v]| ((u as f64).hypot(v as f64).ln(), amplitude(&grey, 1024, [u, v]).ln()))
            .collect();
        let found = slope(&points);
        println!("1/f^{exponent}, seed {seed}: slope {found:.4}, mean {mean:.5}, standard deviation {deviation:.5}");
        assert!((found + exponent).abs() < 0.02, "{found}");
        assert!((mean - 0.5).abs() < 2e-3 && (deviation * 6.0 - 1.0).abs() < 0.01);
    }
    // Seeds differ, and what is white is what it was without the parameter.
    let small = display([64, 48], [40.0, 30.0], 500.0);
    let with = |exponent: f64, seed: f64| {
        reference(&small, ("noise", &numbers([("spectrum_exponent", exponent), ("seed", seed)])))
    };
    assert!(with(1.0, 1.0) != with(1.0, 2.0) && with(1.0, 1.0) == with(1.0, 1.0));
    assert_eq!(with(0.0, 5.0), reference(&small, ("noise", &numbers([("seed", 5.0)]))));
}

#[test]
fn noise_repeats_after_a_tile_and_is_averaged_when_it_is_drawn_coarsely() {
    let screen = display([1100, 40], [400.0, 14.5], 800.0);
    let settings = numbers([("spectrum_exponent", 1.0)]);
    let rgba = reference(&screen, ("noise", &settings));
    let at = |x: usize, y: usize| rgba[4 * (y * 1100 + x)];
    assert!((0..76).all(|x| (0..40).all(|y| at(x, y).to_bits() == at(x + 1024, y).to_bits())));
    assert_averages("noise", &settings, &screen, [2, 2], 3e-4);
}

/// A scene drawn at a step of whole display pixels holds the means of the pixels of its full picture, to `most`.
fn assert_averages(scene: &str, settings: &Parameters, screen: &Display, step: [u32; 2], most: f64) {
    let full = reference(screen, (scene, settings));
    let [width, height] = screen.resolution_px();
    let target_px = [width / step[0], height / step[1]];
    let target = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: target_px[0], height: target_px[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: stimuli::LINEAR_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut encoder = gpu().device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let size_px = [0, 1].map(|axis| f64::from(target_px[axis] * step[axis]));
    let view = View { origin_px: [0.0; 2], size_px, target_px };
    let mut drawn = make_scene(gpu(), screen, scene, settings).unwrap();
    let target_view = target.create_view(&wgpu::TextureViewDescriptor::default());
    drawn.draw(gpu(), &mut encoder, &DrawRequest::of(view, 0.0), &target_view).unwrap();
    gpu().queue.submit([encoder.finish()]);
    let coarse = readback::linear_rgba(gpu(), &target).unwrap();
    let mut worst: f64 = 0.0;
    for (i, pixel) in coarse.chunks_exact(4).enumerate() {
        let (x, y) = (i as u32 % target_px[0] * step[0], i as u32 / target_px[0] * step[1]);
        let under = (0..step[1]).flat_map(|dy| (0..step[0]).map(move |dx| (y + dy) * width + x + dx));
        let mean = under.map(|at| f64::from(full[4 * at as usize])).sum::<f64>() / f64::from(step[0] * step[1]);
        worst = worst.max((f64::from(pixel[0]) - mean).abs());
    }
    println!("{scene} at steps of {step:?} px: at most {worst:.2e} from the mean of its pixels");
    assert!(worst <= most, "{worst}");
}

#[test]
fn the_chart_is_the_formula() {
    let screen = display([480, 270], [597.0, 335.8], 700.0);
    let [cpd, contrast] = [[0.3, 9.0], [0.9, 0.005]];
    let settings = numbers([
        ("lowest_cpd", cpd[0]),
        ("highest_cpd", cpd[1]),
        ("highest_contrast", contrast[0]),
        ("lowest_contrast", contrast[1]),
    ]);
    let rgba = reference(&screen, ("campbell-robson", &settings));
    let half_deg = screen.half_field_deg()[0];
    let frequency = |x_px: f64| {
        let share = (screen.deg_from_px([x_px, 0.0])[0] + half_deg) / (2.0 * half_deg);
        cpd[0] * (cpd[1] / cpd[0]).powf(share)
    };
    let px_deg = |x_px: f64| screen.deg_from_px([x_px + 0.5, 0.0])[0] - screen.deg_from_px([x_px - 0.5, 0.0])[0];

    // The phase by the trapezoidal rule over the frequency, a hundred steps a pixel.
    let mut phases = vec![0.0];
    let mut cycles = 0.0;
    for step in 0..48_000 {
        let [a, b] = [f64::from(step), f64::from(step + 1)].map(|i| i * 0.01);
        let deg = screen.deg_from_px([b, 0.0])[0] - screen.deg_from_px([a, 0.0])[0];
        cycles += 0.5 * (frequency(a) + frequency(b)) * deg;
        phases.push(cycles);
    }
    let mut worst: f64 = 0.0;
    let mut grey = 0;
    for (i, pixel) in rgba.chunks_exact(4).enumerate() {
        let [x, y] = pixel_centre(&screen, i);
        let level = contrast[0] * (contrast[1] / contrast[0]).powf(1.0 - y / 270.0);
        let per_px = frequency(x) * px_deg(x);
        let expected = if per_px >= 0.5 {
            grey += 1;
            0.5
        } else {
            0.5 + 0.5 * level * (TAU * phases[(x * 100.0).round() as usize]).sin()
        };
        // Next to the limit either is right.
        if (per_px - 0.5).abs() > 0.01 {
            worst = worst.max((f64::from(pixel[0]) - expected).abs());
        }
    }
    println!("chart: at most {worst:.2e} from the formula, {grey} pixels too fine for the display");
    assert!(worst < 5e-4 && grey > 0);

    // Frequencies by counting: crossings of the mean in the lowest row between two columns.
    let row = &rgba[4 * 480 * 269..];
    let crossings = (0..300).filter(|&x| (row[4 * x] > 0.5) != (row[4 * (x + 1)] > 0.5)).count();
    let counted = 2.0 * (phases[30_050] - phases[50]);
    assert!((crossings as f64 - counted).abs() <= 1.0, "{crossings} crossings, {counted:.1} expected");
    // A wave shortens within a coarse pixel, and may end in it, which the closed form leaves out.
    assert_averages("campbell-robson", &settings, &screen, [3, 1], 0.04);
}

#[test]
fn the_zone_plate_has_its_frequencies_in_true_degrees() {
    let screen = display([480, 300], [600.0, 375.0], 500.0);
    let (highest, radius_deg) = (4.0, 14.0);
    let settings = numbers([("highest_cpd", highest), ("radius_deg", radius_deg), ("drift_hz", 2.5)]);
    let mut setup = Setup::new(&screen, ("zone-plate", &settings), ("reference", &Parameters::new()));
    for animation_s in [0.0, 0.37, -3.1, 1e4 + 0.1] {
        let (rgba, _) = setup.frame(&FrameInput { animation_s, ..looking_at([0.0; 2]) });
        let phase = |x: f64, y: f64| {
            let r = screen.eccentricity_px_deg([240.0, 150.0], [x, y]);
            let inside = r.min(radius_deg);
            highest * (0.5 * inside * inside / radius_deg + (r - inside)) - 2.5 * animation_s
        };
        let (mut worst, mut compared): (f64, usize) = (0.0, 0);
        for (i, pixel) in rgba.chunks_exact(4).enumerate() {
            let [x, y] = pixel_centre(&screen, i);
            // Local frequencies by differences, cycles per pixel.
            let fx = (phase(x + 0.01, y) - phase(x - 0.01, y)).abs() / 0.02;
            let fy = (phase(x, y + 0.01) - phase(x, y - 0.01)).abs() / 0.02;
            let finest = fx.max(fy);
            let expected = if finest >= 0.5 { 0.5 } else { 0.5 + 0.5 * (TAU * phase(x, y)).cos() };
            if (finest - 0.5).abs() > 0.01 {
                worst = worst.max((f64::from(pixel[0]) - expected).abs());
                compared += 1;
            }
        }
        println!("zone plate at {animation_s} s: at most {worst:.2e} from the formula over {compared} pixels");
        assert!(worst < 2e-3 && compared > 130_000);
    }
    // Rings counted outward along the horizontal, beyond the radius as well: two crossings a cycle.
    let highest = 2.0;
    let still = numbers([("highest_cpd", highest), ("radius_deg", radius_deg)]);
    let rgba = reference(&screen, ("zone-plate", &still));
    let row = &rgba[4 * 480 * 150..];
    let crossings = (240..440).filter(|&x| (row[4 * x] > 0.5) != (row[4 * (x + 1)] > 0.5)).count();
    let r = screen.eccentricity_px_deg([240.0, 150.5], [440.5, 150.5]);
    let counted = 2.0 * highest * (r - 0.5 * radius_deg);
    println!("zone plate: {crossings} crossings out to {r:.2}°, {counted:.1} expected");
    assert!((crossings as f64 - counted).abs() <= 1.5);
    // Rings bend within a coarse pixel, which the closed form leaves out.
    assert_averages("zone-plate", &still, &screen, [2, 2], 0.08);
    assert_averages("zone-plate", &still, &screen, [4, 2], 0.15);
}
