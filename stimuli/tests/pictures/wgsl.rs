//! Renderers in WGSL: what the functions around them give, against closed forms and the display's own geometry.

use crate::common::{Setup, display, gpu, looking_at, pixel_centre, reference};
use experiments::catalogue::Parameters;
use stimuli::{Registry, readback};

/// A registry with one renderer, `mine`, whose function has this body.
fn with(head: &str, body: &str) -> Registry {
    let mut registry = Registry::built_in();
    let text = format!("{head}\nfn colour(at: Place, given: Parameters) -> vec3f {{ {body} }}\n");
    registry.add_wgsl("mine", &text, "mine.wgsl").unwrap_or_else(|error| panic!("{error}"));
    registry
}

/// Places, angles and conversions against [`experiments::display`], in f64.
#[test]
fn places_are_the_displays_own() {
    let display = display([163, 97], [500.0, 330.0], 300.0);
    let gaze_deg = [12.0, -7.0];
    let none = Parameters::new();
    let shown = |body: &str| {
        let registry = with("", body);
        Setup::of(&registry, &display, ("noise", &none), ("mine", &none)).frame(&looking_at(gaze_deg)).0
    };
    // All of them brought into 0–1, where a half float is within 2.5e-4.
    let deg = shown("return vec3f((deg_from_px(at.px) + 60.0) / 120.0, at.eccentricity_deg / 90.0);");
    let uv = shown("return vec3f(at.uv, pixel_deg_at(at.px));");
    let back = shown(
        "return vec3f(px_from_deg(deg_from_px(at.px)) / px_from_uv(vec2f(1.0)), eccentricity_deg_at(at.px) / 90.0);",
    );
    let gaze = shown("return vec3f((at.gaze_deg + 60.0) / 120.0, length(at.gaze_px - px_from_deg(at.gaze_deg)));");
    let mut worst: f64 = 0.0;
    for index in 0..display.pixels() as usize {
        let px = pixel_centre(&display, index);
        let [x, y] = display.deg_from_px(px);
        let e = display.eccentricity_deg(gaze_deg, [x, y]);
        let share = [px[0] / 163.0, px[1] / 97.0];
        let expected = [
            (&deg, [(x + 60.0) / 120.0, (y + 60.0) / 120.0, e / 90.0]),
            (&uv, [share[0], share[1], display.pixel_deg([x, y])]),
            (&back, [share[0], share[1], e / 90.0]),
            (&gaze, [72.0 / 120.0, 53.0 / 120.0, 0.0]),
        ];
        for (found, expected) in expected {
            for channel in 0..3 {
                worst = worst.max((f64::from(found[4 * index + channel]) - expected[channel]).abs());
            }
        }
    }
    println!("largest difference from the display's geometry: {worst:.2e}, allowed 4e-4");
    assert!(worst <= 4e-4);
}

/// The coarsest level is the mean of the picture, at a size of which no side is even for long; level 0 is the picture.
#[test]
fn the_mip_chain_averages_areas() {
    let display = display([333, 217], [500.0, 330.0], 450.0);
    let none = Parameters::new();
    for scene in ["photo", "noise"] {
        let sharp = reference(&display, (scene, &none));
        let frame = |body: &str| {
            Setup::of(&with("", body), &display, (scene, &none), ("mine", &none)).frame(&looking_at([0.0; 2])).0
        };
        let top = frame("return sample_level(at.px, 8.0);");
        let exact = frame("return picture_at(at.px);");
        assert!(exact == sharp, "picture_at is the scene's own pixel");
        let (mut worst, mut apart) = (0.0_f64, 0.0_f32);
        for channel in 0..3 {
            let mean = sharp.chunks_exact(4).map(|p| f64::from(p[channel])).sum::<f64>() / display.pixels() as f64;
            worst = worst.max((f64::from(top[channel]) - mean).abs());
        }
        for (a, b) in frame("return sample_level(at.px, 0.0);").iter().zip(&sharp) {
            apart = apart.max((a - b).abs());
        }
        println!("{scene}: mean off by {worst:.2e} (allowed 1e-3), level 0 off by {apart:.2e} (allowed 4e-3)");
        // Eight levels, each rounded to half floats; filtering hardware may weigh in 256ths.
        assert!(worst <= 1e-3 && apart <= 4e-3);
    }
}

/// The spread of a single bright pixel: its light is kept, and its variance is sigma squared along both axes, on average over
/// where the pixel stands in the grids of the coarser levels.
#[test]
fn a_blur_has_the_variance_it_is_asked_for() {
    const SPACING: u32 = 128;
    let display = display([512, 512], [500.0, 500.0], 450.0);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("dots.png");
    // Sixteen dots, each at another place of its tile.
    let place = |tile: u32| 64 + (tile * 5) % 16;
    let is_dot = |x: u32, y: u32| {
        let tile = (y / SPACING) * 4 + x / SPACING;
        x % SPACING == place(tile) && y % SPACING == place(tile * 3 + 1)
    };
    image::RgbImage::from_fn(512, 512, |x, y| image::Rgb([255 * u8::from(is_dot(x, y)); 3])).save(&file).unwrap();
    let mut registry =
        with("//! parameter sigma_px [px] 0..100 = 1: Width.", "return 256.0 * sample_sigma(at.px, given.sigma_px);");
    registry.add_picture("dots", &file).unwrap();
    let none = Parameters::new();
    let mut setup = Setup::of(&registry, &display, ("dots", &none), ("mine", &none));
    for sigma_px in [0.3, 1.0, 2.0, 3.0, 5.0, 8.0, 10.0] {
        setup.renderer.set_parameters(&crate::common::numbers([("sigma_px", sigma_px)])).unwrap();
        let frame = setup.frame(&looking_at([0.0; 2])).0;
        let (mut light, mut variance) = (0.0, [0.0; 2]);
        for tile in 0..16_u32 {
            let corner = [(tile % 4) * SPACING, (tile / 4) * SPACING];
            let dot = [place(tile), place(tile * 3 + 1)];
            let (mut sum, mut second) = (0.0, [0.0; 2]);
            for y in 0..SPACING {
                for x in 0..SPACING {
                    let value = f64::from(frame[4 * ((corner[1] + y) * 512 + corner[0] + x) as usize]) / 256.0;
                    sum += value;
                    for (axis, at) in [x, y].into_iter().enumerate() {
                        second[axis] += value * (f64::from(at) - f64::from(dot[axis])).powi(2);
                    }
                }
            }
            light += sum / 16.0;
            for axis in 0..2 {
                variance[axis] += second[axis] / sum / 16.0;
            }
        }
        let ratios = variance.map(|v| (v / (sigma_px * sigma_px)).sqrt());
        println!("sigma {sigma_px} px: light {light:.4}, found sigma / asked sigma {:.4} {:.4}", ratios[0], ratios[1]);
        assert!((light - 1.0).abs() < 0.01, "the light of a dot is kept");
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.03), "{sigma_px}: {ratios:?}");
    }
}

/// A grating of the period that is asked for keeps half its amplitude, as in the ring.
#[test]
fn a_mar_halves_the_grating_at_its_limit() {
    let display = display([512, 64], [200.0, 25.0], 2000.0);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grating.exr");
    let period_px = 16.0_f32;
    let value = |x: u32| 0.5 + 0.4 * (std::f32::consts::TAU * (x as f32 + 0.5) / period_px).sin();
    image::Rgb32FImage::from_fn(512, 64, |x, _| image::Rgb([value(x); 3])).save(&file).unwrap();
    let mar_deg = f64::from(period_px) * display.pixel_deg([0.0; 2]);
    let mut registry = with("", &format!("return sample_mar(at.px, {mar_deg:.9});"));
    registry.add_picture("grating", &file).unwrap();
    let none = Parameters::new();
    let frame = Setup::of(&registry, &display, ("grating", &none), ("mine", &none)).frame(&looking_at([0.0; 2])).0;
    let amplitude = |row: &[f32]| {
        let (mut re, mut im) = (0.0_f64, 0.0_f64);
        for x in 128..384 {
            let angle = std::f64::consts::TAU * (x as f64 + 0.5) / f64::from(period_px);
            re += f64::from(row[4 * x]) * angle.cos();
            im += f64::from(row[4 * x]) * angle.sin();
        }
        2.0 * re.hypot(im) / 256.0
    };
    let kept = amplitude(&frame[4 * 512 * 32..4 * 512 * 33]) / 0.4;
    println!("amplitude kept at the limit: {kept:.4}, asked 0.5");
    // Two splines mixed are not quite a Gaussian: 0.53 by their transfer functions, ± 0.013 by what aliases.
    assert!((kept - 0.5).abs() < 0.06);
}

#[test]
fn what_is_no_colour_is_black_and_what_is_too_bright_is_finite() {
    let display = display([16, 16], [40.0, 40.0], 300.0);
    let none = Parameters::new();
    let body = "let zero = at.px.x - at.px.x; return vec3f(zero / zero, -1.0, 1e30);";
    let registry = with("", body);
    let mut setup = Setup::of(&registry, &display, ("noise", &none), ("mine", &none));
    setup.renderer.render(gpu(), setup.scene.as_mut(), &looking_at([0.0; 2])).unwrap();
    let rgba = readback::linear_rgba(gpu(), setup.renderer.output()).unwrap();
    assert!(rgba.chunks_exact(4).all(|p| p[0].is_finite() && p[1] == 0.0 && p[2] == 65504.0), "{:?}", &rgba[..4]);
}
