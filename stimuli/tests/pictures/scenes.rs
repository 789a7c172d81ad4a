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
    let stopped = numbers([("camera_speed", 0.0)]);
    let (panning, still) = (named("camera", "pan"), named("camera", "static"));
    for (parameters, moves) in [(&none, true), (&panning, true), (&stopped, false), (&still, false)] {
        let mut setup = Setup::new(&display, ("orbit", parameters), ("reference", &none));
        let (first, cost) = setup.frame(&looking_at([0.0; 2]));
        assert_eq!(cost.rays_traced, display.pixels());
        let (later, cost) = setup.frame(&FrameInput { animation_s: 0.5, ..FrameInput::default() });
        assert_eq!(first != later, moves);
        assert_eq!(cost.rays_traced > 0, moves);
        assert_eq!(setup.scene.picture_changes(0.0, 0.5), moves);
    }
}

/// Eight camera motions (Guenter 2012, §6): they begin with the same picture, flying and panning at any speed differ later,
/// and a pan comes back to where it began: after a whole sweep of ±15° at 6°/s at most, 2π · 15 / 6 s.
#[test]
fn the_camera_flies_pans_or_stands() {
    let display = display([160, 90], [597.0, 335.8], 1100.0);
    let motion = |camera: &str, speed: f64| {
        let mut parameters = named("camera", camera);
        parameters.extend(numbers([("camera_speed", speed)]));
        parameters
    };
    let at = |parameters: &Parameters, animation_s: f64| {
        let mut setup = Setup::new(&display, ("orbit", parameters), ("reference", &Parameters::new()));
        setup.frame(&FrameInput { animation_s, ..FrameInput::default() }).0
    };
    let start = at(&motion("static", 6.0), 0.0);
    let mut later = vec![at(&motion("static", 6.0), 2.0)];
    assert!(later[0] == start);
    for (camera, speed) in [("fly", 2.0), ("fly", 6.0), ("fly", 18.0), ("pan", 6.0), ("pan", -6.0)] {
        assert!(at(&motion(camera, speed), 0.0) == start, "{camera} {speed}");
        let picture = at(&motion(camera, speed), 2.0);
        assert!(!later.contains(&picture), "{camera} {speed}");
        later.push(picture);
    }
    let sweep_s = std::f64::consts::TAU * 15.0 / 6.0;
    let apart =
        |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / a.len() as f64;
    let back = at(&motion("pan", 6.0), sweep_s);
    let aside = at(&motion("pan", 6.0), 0.25 * sweep_s);
    println!("after a sweep {:.2e} from the start, in its middle {:.2e}", apart(&back, &start), apart(&aside, &start));
    assert!(apart(&back, &start) < 1e-3 && apart(&aside, &start) > 0.02);
}

fn patch(image: &str, values: &[(&str, f64)]) -> Parameters {
    let mut parameters = named("image", image);
    parameters.extend(
        values.iter().map(|&(name, value)| (name.to_owned(), experiments::catalogue::ParameterValue::Number(value))),
    );
    parameters
}

/// By hand: texel of the photograph under every pixel of the display, with the unmirrored patch in the middle.
#[test]
fn a_patch_is_tiled_in_mirrors() {
    let photograph = image::load_from_memory(COFFEE).unwrap().into_rgb8();
    let display = display([301, 200], [300.0, 200.0], 600.0);
    let (left, top, side) = (210_i64, 97_i64, 40_i64);
    let values = [("left_px", left as f64), ("top_px", top as f64), ("size_px", side as f64)];
    let shown = reference(&display, ("patch", &patch("coffee", &values)));
    let colour = |x: i64, y: i64| &shown[4 * (y * 301 + x) as usize..][..3];
    // (301 − 40) / 2 and (200 − 40) / 2, rounded down.
    let first = [130, 80];
    // Counted forwards in even tiles, backwards in odd ones.
    let texel = |px: i64, first: i64| {
        let (tile, within) = ((px - first).div_euclid(side), (px - first).rem_euclid(side));
        if tile.rem_euclid(2) == 0 { within } else { side - 1 - within }
    };
    for y in 0..200 {
        for x in 0..301 {
            let source = photograph.get_pixel((left + texel(x, first[0])) as u32, (top + texel(y, first[1])) as u32);
            for c in 0..3 {
                let (expected, found) = (linear_from_srgb8(source[c]), colour(x, y)[c]);
                assert!((found - expected).abs() <= expected / 2048.0 + 1e-7, "({x}, {y}): {found} is not {expected}");
            }
        }
    }
    // Neighbouring tiles are mirror images about the seam between them, so that the two pixels at a seam are the same.
    for seam in [first[0] - side, first[0], first[0] + side] {
        for k in 0..side {
            for y in 0..200 {
                assert_eq!(colour(seam + k, y), colour(seam - 1 - k, y), "column {k} from the seam at {seam}");
            }
        }
    }
    for seam in [first[1] - side, first[1], first[1] + side] {
        for k in 0..side {
            for x in 0..301 {
                assert_eq!(colour(x, seam + k), colour(x, seam - 1 - k), "row {k} from the seam at {seam}");
            }
        }
    }
}

#[test]
fn contrast_is_about_the_patch_s_own_mean() {
    // One whole tile and no more.
    let display = display([64, 64], [60.0, 60.0], 600.0);
    let at = |contrast: f64| {
        let values = [("left_px", 300.0), ("top_px", 120.0), ("size_px", 64.0), ("contrast", contrast)];
        reference(&display, ("patch", &patch("coffee", &values)))
    };
    let full = at(1.0);
    for c in 0..3 {
        let channel = |rgba: &[f32]| rgba.chunks_exact(4).map(|p| f64::from(p[c])).collect::<Vec<_>>();
        let full = channel(&full);
        let mean = full.iter().sum::<f64>() / full.len() as f64;
        for contrast in [0.0, 0.25, 0.6] {
            for (found, full) in channel(&at(contrast)).into_iter().zip(&full) {
                let expected = mean + contrast * (full - mean);
                assert!((found - expected).abs() < 5e-4, "{found} is not {expected}");
            }
        }
    }
}

#[test]
fn a_patch_that_would_stick_out_is_moved_and_shrunk() {
    let display = display([320, 310], [300.0, 290.0], 600.0);
    let shown = |values: &[(&str, f64)]| reference(&display, ("patch", &patch("chelsea", values)));
    // 451×300: at most 300 wide, and then at most 151 from the left.
    let inside = shown(&[("left_px", 151.0), ("top_px", 0.0), ("size_px", 300.0)]);
    assert!(shown(&[("left_px", 600.0), ("top_px", 600.0), ("size_px", 512.0)]) == inside);
    assert!(shown(&[("left_px", 150.0), ("size_px", 300.0)]) != inside);
}
