//! The amplitude spectrum of the ring on white noise: one half at 1/omega cycles per degree, the Gaussian around it.

use crate::common::{Setup, display, looking_at, numbers, reference};
use experiments::display::Display;

/// A square part of the picture, in pixels, that is weighted by a Hann window on both axes.
struct Window {
    left: usize,
    top: usize,
    size: usize,
}

/// Ratio of amplitudes, filtered over reference: the root of the ratio of powers summed over windows and directions.
fn amplitude_ratio(display: &Display, windows: &[Window], sharp: &[f32], shown: &[f32], cycles_per_deg: f64) -> f64 {
    const DIRECTIONS: usize = 48;
    let width = display.resolution_px()[0] as usize;
    let mut power = [0.0; 2];
    for window in windows {
        let centre = [window.left, window.top].map(|x| x as f64 + 0.5 * window.size as f64);
        // Degrees of a pixel along each axis at the window's middle.
        let step = |dx: f64, dy: f64| display.eccentricity_px_deg(centre, [centre[0] + dx, centre[1] + dy]);
        let deg_px = [step(1.0, 0.0), step(0.0, 1.0)];
        let hann: Vec<f64> = (0..window.size)
            .map(|i| 0.5 - 0.5 * ((i as f64 + 0.5) / window.size as f64 * std::f64::consts::TAU).cos())
            .collect();
        for direction in 0..DIRECTIONS {
            let (sin, cos) = (direction as f64 / DIRECTIONS as f64 * std::f64::consts::PI).sin_cos();
            let k = [cos * deg_px[0], sin * deg_px[1]].map(|x| x * cycles_per_deg * std::f64::consts::TAU);
            let wave = |k: f64| (0..window.size).map(move |i| (k * i as f64).sin_cos()).collect::<Vec<_>>();
            let (columns, rows) = (wave(k[0]), wave(k[1]));
            for (picture, power) in [sharp, shown].iter().zip(&mut power) {
                let (mut re, mut im) = (0.0, 0.0);
                for y in 0..window.size {
                    let (mut row_re, mut row_im) = (0.0, 0.0);
                    for x in 0..window.size {
                        let at = 4 * ((window.top + y) * width + window.left + x);
                        let value = (f64::from(picture[at]) - 0.5) * hann[x];
                        row_re += value * columns[x].1;
                        row_im += value * columns[x].0;
                    }
                    re += hann[y] * (row_re * rows[y].1 - row_im * rows[y].0);
                    im += hann[y] * (row_re * rows[y].0 + row_im * rows[y].1);
                }
                *power += re * re + im * im;
            }
        }
    }
    (power[1] / power[0]).sqrt()
}

fn grid(left: usize, top: usize, size: usize, count: usize) -> Vec<Window> {
    (0..count * count)
        .map(|i| Window { left: left + size * (i % count), top: top + size * (i / count), size })
        .collect()
}

#[test]
fn a_disc_on_noise_halves_the_amplitude_at_one_over_omega() {
    // Pixels of 0.0229° over 11.7°, so that angles are even to 1 %.
    let display = display([512, 512], [204.8, 204.8], 1000.0);
    for seed in [1.0, 2.0] {
        let noise = numbers([("seed", seed)]);
        let sharp = reference(&display, ("noise", &noise));
        // From 2.6 px to 44 px per cycle: direct, separate, and on coarser grids.
        for mar_deg in [0.06, 0.1, 0.2, 0.3, 0.5, 1.0] {
            let disc = numbers([("eccentricity_deg", 0.0), ("width_deg", 30.0), ("mar_deg", mar_deg)]);
            let (shown, _) = Setup::new(&display, ("noise", &noise), ("ring", &disc)).frame(&looking_at([0.0; 2]));
            // Windows of at least four cycles.
            let windows = if mar_deg < 0.3 { grid(64, 64, 128, 3) } else { grid(64, 64, 384, 1) };
            let ratio = amplitude_ratio(&display, &windows, &sharp, &shown, 1.0 / mar_deg);
            println!("seed {seed} omega {mar_deg}: amplitude {ratio:.4} at 1/omega");
            assert!((ratio / 0.5 - 1.0).abs() < 0.05, "{ratio}");
            if mar_deg >= 0.2 {
                for share in [0.5, 1.5] {
                    let ratio = amplitude_ratio(&display, &windows, &sharp, &shown, share / mar_deg);
                    let expected = 0.5_f64.powf(share * share);
                    println!("    {share} / omega: {ratio:.4}, Gaussian {expected:.4}");
                    assert!((ratio / expected - 1.0).abs() < 0.06);
                }
            }
        }
    }
}

#[test]
fn a_ring_off_the_axis_halves_the_amplitude_in_its_own_degrees() {
    // 62° wide: at 22° a pixel has shrunk by 7 % and 14 %, which the filter must follow.
    let display = display([640, 400], [600.0, 375.0], 500.0);
    let noise = numbers([("seed", 5.0)]);
    let sharp = reference(&display, ("noise", &noise));
    for mar_deg in [0.4, 0.8] {
        let ring = numbers([("eccentricity_deg", 22.0), ("width_deg", 12.0), ("mar_deg", mar_deg)]);
        let (shown, _) = Setup::new(&display, ("noise", &noise), ("ring", &ring)).frame(&looking_at([0.0; 2]));
        // Left and right of the middle, within the plateau of 16°–28°.
        let windows: Vec<Window> = [64, 496]
            .iter()
            .flat_map(|&left| (0..3).map(move |i| Window { left, top: 104 + 64 * i, size: 64 }))
            .collect();
        let ratio = amplitude_ratio(&display, &windows, &sharp, &shown, 1.0 / mar_deg);
        println!("seed 5, e 22°, omega {mar_deg}: amplitude {ratio:.4} at 1/omega");
        assert!((ratio / 0.5 - 1.0).abs() < 0.05, "{ratio}");
    }
}
