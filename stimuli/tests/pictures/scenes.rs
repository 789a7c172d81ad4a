//! Scenes against what they are made of: the texels of the photograph, the statistics of the noise, the light of the court.

use crate::common::{Setup, display, looking_at, named, numbers, reference};
use experiments::catalogue::Parameters;
use stimuli::FrameInput;
use stimuli::display_pass::linear_from_srgb8;

const COFFEE: &[u8] = include_bytes!("../../assets/photographs/coffee.png");

/// By hand: the photograph is centred, unscaled, and beyond its edge runs backwards from the last texel.
#[test]
fn tiles_are_mirrored_and_texels_exact() {
    let photograph = image::load_from_memory(COFFEE).unwrap().into_rgb8();
    let (w, h) = (photograph.width(), photograph.height());
    let display = display([1501, 901], [600.0, 360.0], 600.0);
    let shown = reference(&display, ("photo", &named("image", "coffee")));
    // (1501 − 600) / 2 and (901 − 400) / 2, rounded down.
    let (left, top) = (450, 250);
    let cases = [
        ((left, top), (0, 0)),
        ((left + w - 1, top + h - 1), (w - 1, h - 1)),
        ((left - 1, top), (0, 0)),
        ((left - 3, top - 2), (2, 1)),
        ((left + w, top + 7), (w - 1, 7)),
        ((left + w + 5, top + h + 9), (w - 6, h - 10)),
        ((0, 0), (449, 249)),
        ((1500, 900), (149, 149)),
    ];
    for ((x, y), (u, v)) in cases {
        let texel = photograph.get_pixel(u, v);
        for c in 0..3 {
            let expected = linear_from_srgb8(texel[c]);
            let found = shown[4 * (y as usize * 1501 + x as usize) + c];
            // Half floats: eleven bits.
            assert!((found - expected).abs() <= expected / 2048.0 + 1e-7, "({x}, {y}): {found} is not {expected}");
        }
    }
}

#[test]
fn a_scaled_photograph_is_mixed_linearly() {
    let photograph = image::load_from_memory(COFFEE).unwrap().into_rgb8();
    let display = display([1200, 800], [600.0, 400.0], 600.0);
    let mut parameters = named("image", "coffee");
    parameters.extend(numbers([("scale", 2.0)]));
    let shown = reference(&display, ("photo", &parameters));
    let at = |u: u32, v: u32| linear_from_srgb8(photograph.get_pixel(u, v)[0]);
    for (x, y) in [(101_u32, 57_u32), (600, 400), (33, 790)] {
        // Pixel centre x + ½ is texel coordinate (x + ½) / 2, so a quarter of a texel off a texel's centre.
        let place = |p: u32| (f64::from(p) + 0.5) / 2.0 - 0.5;
        let (u, v) = (place(x), place(y));
        let (fu, fv) = ((u - u.floor()) as f32, (v - v.floor()) as f32);
        let (iu, iv) = (u as u32, v as u32);
        let top = at(iu, iv) * (1.0 - fu) + at(iu + 1, iv) * fu;
        let bottom = at(iu, iv + 1) * (1.0 - fu) + at(iu + 1, iv + 1) * fu;
        let expected = top * (1.0 - fv) + bottom * fv;
        let found = shown[4 * (y as usize * 1200 + x as usize)];
        assert!((found - expected).abs() < 1e-3, "({x}, {y}): {found} is not {expected}");
    }
}

/// Mean ½, variance 1/12, neighbours uncorrelated: each within five standard errors of 65536 draws.
#[test]
fn noise_is_white_and_uniform() {
    let display = display([256, 256], [100.0, 100.0], 500.0);
    for seed in [1.0, 2.0, 4_294_967_295.0] {
        let rgba = reference(&display, ("noise", &numbers([("seed", seed)])));
        let values: Vec<f64> = rgba.chunks_exact(4).map(|p| f64::from(p[0]) - 0.5).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| x * x).sum::<f64>() / n;
        let right = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n / variance;
        let below = values.iter().zip(&values[256..]).map(|(a, b)| a * b).sum::<f64>() / n / variance;
        println!("seed {seed}: mean {mean:+.5}, variance {variance:.5}, neighbours {right:+.4} {below:+.4}");
        assert!(mean.abs() < 5.0 * (1.0_f64 / 12.0 / n).sqrt());
        assert!((variance * 12.0 - 1.0).abs() < 0.02);
        assert!(right.abs() < 5.0 / n.sqrt() && below.abs() < 5.0 / n.sqrt());
    }
    let (one, two) = (numbers([("seed", 1.0)]), numbers([("seed", 2.0)]));
    assert_ne!(reference(&display, ("noise", &one)), reference(&display, ("noise", &two)));
}

#[test]
fn the_court_moves_with_time_unless_it_stands_still() {
    let display = display([160, 90], [597.0, 335.8], 1100.0);
    let none = Parameters::new();
    let still = numbers([("camera_speed", 0.0)]);
    for (parameters, moves) in [(&none, true), (&still, false)] {
        let mut setup = Setup::new(&display, ("orbit", parameters), ("reference", &none));
        let (first, cost) = setup.frame(&looking_at([0.0; 2]));
        assert_eq!(cost.rays_traced, display.pixels());
        let (later, cost) = setup.frame(&FrameInput { animation_s: 0.5, ..FrameInput::default() });
        assert_eq!(first != later, moves);
        assert_eq!(cost.rays_traced > 0, moves);
        assert_eq!(setup.scene.picture_changes(0.0, 0.5), moves);
    }
}
