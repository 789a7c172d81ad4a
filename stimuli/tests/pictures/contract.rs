//! What every scene and renderer owes, whatever its kind: any size, any gaze, the same bytes again, a plausible cost.
//!
//! All of it runs on a registry with everything that is built in, a renderer in WGSL, two folders of frames and a picture,
//! so that whatever is added there is tested without another line here.

use crate::common::{Setup, display, eccentricities, gpu, looking_at, numbers, write_frames};
use experiments::catalogue::{Catalogue, DetailLaw, ParameterKind, ParameterValue, Parameters, RendererInfo};
use experiments::display::Display;
use std::sync::OnceLock;
use stimuli::tally::{Tallied, Tally};
use stimuli::{FrameInput, MakeError, Registry, RenderError, Scene, make_renderer, make_scene, readback};

/// The shipped example of a renderer in WGSL.
const QUIET: &str = include_str!("../../../experiments/studies/own-renderers/quiet-periphery.wgsl");
/// Scenes whose picture is the same everywhere, each with the parameters that make it so, and its value.
const FLAT: [(&str, &str, f64, f32); 2] = [("noise", "contrast", 0.0, 0.5), ("flat-frames", "", 0.0, 0.215_860_5)];

/// The world on which tests of many frames run.
const ONE_WORLD: &str = "tunnel-maps";

/// Everything that is built in, and one of each kind that users add.
fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<(Registry, tempfile::TempDir)> = OnceLock::new();
    let (registry, _) = REGISTRY.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(&path).unwrap();
            path
        };
        let mut registry = Registry::built_in();
        registry.add_wgsl("quiet", QUIET, "quiet-periphery.wgsl").unwrap();
        // Frames as small as the smallest display of these tests.
        write_frames(&at("moving"), [16, 16], 5, None, 3, |level, frame, x, y| {
            let cell = (x >> level) * 37 + (y >> level) * 91 + frame * 53;
            [(cell * 29 % 200) as u8 + 40, (cell * 17 % 160) as u8 + 60, (cell * 7 % 120) as u8 + 80]
        });
        registry.add_frames("frames", &at("moving")).unwrap();
        // sRGB 128 is 0.21586 of the peak.
        write_frames(&at("flat"), [16, 16], 2, Some(&[0.1, 0.3, 0.9]), 3, |_, _, _, _| [128; 3]);
        registry.add_frames("flat-frames", &at("flat")).unwrap();
        let file = folder.path().join("picture.png");
        image::RgbImage::from_fn(30, 21, |x, y| image::Rgb([(x * 8) as u8, (y * 12) as u8, 90])).save(&file).unwrap();
        registry.add_picture("picture", &file).unwrap();
        (registry, folder)
    });
    registry
}

fn catalogue() -> Catalogue {
    registry().catalogue()
}

/// Every scene and renderer that go together.
fn every_pair() -> Vec<(String, String)> {
    let catalogue = catalogue();
    let pairs = catalogue.scenes.iter().flat_map(|s| catalogue.renderers.iter().map(move |r| (&s.id, &r.id)));
    let fits = |(scene, renderer): &(&String, &String)| catalogue.mismatch(scene, renderer, None).is_none();
    pairs.filter(fits).map(|(scene, renderer)| (scene.clone(), renderer.clone())).collect()
}

/// The same by scene, each scene with the renderers it goes with: a world of meshes takes long to make.
fn renderers_by_scene() -> Vec<(String, Vec<String>)> {
    let mut grouped: Vec<(String, Vec<String>)> = Vec::new();
    for (scene, renderer) in every_pair() {
        match grouped.last_mut().filter(|(last, _)| *last == scene) {
            Some((_, renderers)) => renderers.push(renderer),
            None => grouped.push((scene, vec![renderer])),
        }
    }
    grouped
}

/// Whether a scene is a world of meshes: hundreds of thousands of triangles for every frame, however small.
fn is_world(scene: &mut dyn Scene) -> bool {
    scene.surfaces().is_some()
}

/// A scene that a renderer is tested on: its own where it has one.
fn scene_for(renderer: &RendererInfo) -> String {
    catalogue().capture(&renderer.id).map_or_else(|| "photo".to_owned(), |capture| capture.id.clone())
}

/// The defaults, then every parameter alone at each of its ends or choices.
fn settings(renderer: &RendererInfo) -> Vec<Parameters> {
    let mut settings = vec![Parameters::new()];
    for schema in &renderer.parameters {
        let values = match &schema.kind {
            ParameterKind::Number { min, max, .. } => vec![ParameterValue::Number(*min), ParameterValue::Number(*max)],
            ParameterKind::Choice { options, .. } => options.iter().cloned().map(ParameterValue::Text).collect(),
        };
        settings.extend(values.into_iter().map(|value| Parameters::from([(schema.name.clone(), value)])));
    }
    settings
}

fn checked_frame(setup: &mut Setup, frame: &FrameInput, label: &str) {
    let (rgba, cost) = setup.frame(frame);
    let display = &setup.display;
    // Worlds are brighter than the display where light falls; flat pictures are relative to its peak.
    let most = if is_world(setup.scene.as_mut()) { 6.6e4 } else { 1.0 };
    assert!(rgba.iter().all(|x| x.is_finite() && (0.0..=most).contains(x)), "{label}");
    assert!(rgba.chunks_exact(4).all(|p| p[3] > 0.999), "{label}: alpha");
    assert!(cost.pixels_shaded <= 3 * display.pixels() + 64, "{label}: {cost:?}");
    assert!(cost.rays_traced <= cost.pixels_shaded, "{label}: {cost:?}");
}

#[test]
fn every_scene_works_under_every_renderer() {
    let none = Parameters::new();
    for display in [display([167, 109], [500.0, 330.0], 450.0), display([16, 16], [40.0, 30.0], 300.0)] {
        for (scene, renderers) in renderers_by_scene() {
            let mut setup = Setup::of(registry(), &display, (&scene, &none), (&renderers[0], &none));
            let gazes_deg = [[28.0, -19.0], [200.0, -1e4], [0.0, 0.0], [-70.0, 45.0]];
            let gazes_deg = if is_world(setup.scene.as_mut()) { &gazes_deg[..2] } else { &gazes_deg };
            for renderer in renderers {
                setup.renderer = registry().make_renderer(gpu(), &display, &renderer, &none).unwrap();
                for &gaze_deg in gazes_deg {
                    let frame = FrameInput { gaze_deg, animation_s: 0.01 * gaze_deg[0], ..FrameInput::default() };
                    let label = format!("{scene} under {renderer} at {:?}, gaze {gaze_deg:?}", display.resolution_px());
                    checked_frame(&mut setup, &frame, &label);
                    let rgba = readback::linear_rgba(gpu(), setup.renderer.output()).unwrap();
                    let brightness = rgba.chunks_exact(4).map(|p| p[1]).sum::<f32>();
                    // Frames fill 16 × 16 pixels of any display.
                    let lit = if catalogue().capture(&scene).is_some() { 256 } else { display.pixels() } as f32;
                    assert!(brightness / lit > 0.02, "{label}: all but black, {brightness}");
                }
            }
        }
    }
}

/// A display that is 512 times wider than high, one that is higher than wide and odd, and what is no display at all.
#[test]
fn huge_and_odd_displays_work_and_empty_ones_are_refused() {
    let none = Parameters::new();
    for display in [display([8192, 16], [9000.0, 17.0], 600.0), display([17, 2049], [20.0, 2400.0], 500.0)] {
        for renderer in &catalogue().renderers {
            let scene = match scene_for(renderer).as_str() {
                "photo" => "noise".to_owned(),
                own => own.to_owned(),
            };
            let mut setup = Setup::of(registry(), &display, (&scene, &none), (&renderer.id, &none));
            for gaze_deg in [[0.0, 0.0], [-75.0, 60.0]] {
                let label = format!("{} at {:?}", renderer.id, display.resolution_px());
                checked_frame(&mut setup, &looking_at(gaze_deg), &label);
            }
        }
    }
    for resolution_px in [[0, 0], [0, 1080], [1920, 0], [15, 1080], [16_385, 16], [u32::MAX, u32::MAX]] {
        assert!(Display::new("none", resolution_px, [500.0, 300.0], 600.0).is_err(), "{resolution_px:?}");
    }
    assert!(Display::new("none", [64, 64], [0.0, 0.0], 600.0).is_err());
    let most = gpu().device.limits().max_texture_dimension_2d;
    if most < 16_384 {
        let too_large = display([16_384, 16], [500.0, 30.0], 600.0);
        let refused = make_renderer(gpu(), &too_large, "reference", &none).err();
        assert!(matches!(refused, Some(MakeError::TooLarge { .. })), "{refused:?}");
    }
}

/// The same frames since the presentation began, on a renderer that has seen nothing and on one that has seen other frames,
/// parameters and scenes.
#[test]
fn the_same_frames_give_the_same_bytes_whatever_came_before() {
    let display = display([160, 90], [500.0, 281.0], 600.0);
    let none = Parameters::new();
    let frames: Vec<FrameInput> = (0..3_u32)
        .map(|index| FrameInput {
            gaze_deg: [3.0 - f64::from(index), 2.0],
            frame_index: u64::from(index),
            animation_s: 1.25 + 0.05 * f64::from(index),
            ..FrameInput::default()
        })
        .collect();
    let presentation = |setup: &mut Setup| -> Vec<Vec<f32>> {
        setup.renderer.begin();
        frames.iter().map(|frame| setup.frame(frame).0).collect()
    };
    for (scene, renderer) in every_pair() {
        // One world stands for all: they differ in what they hold, not in how they are drawn.
        let mut first = Setup::of(registry(), &display, (&scene, &none), (&renderer, &none));
        if is_world(first.scene.as_mut()) && scene != ONE_WORLD {
            continue;
        }
        let fresh = presentation(&mut first);
        let mut used = Setup::of(registry(), &display, (&scene, &none), (&renderer, &none));
        used.frame(&looking_at([-7.0, 4.0]));
        used.renderer.set_parameters(&none).unwrap();
        used.frame(&FrameInput { animation_s: 9.0, ..frames[0] });
        assert!(presentation(&mut used) == fresh, "{scene} under {renderer}");
        // Another scene through the same renderer, and back.
        let mut other = make_scene(gpu(), &display, "noise", &numbers([("seed", 77.0)])).unwrap();
        used.renderer.render(gpu(), other.as_mut(), &frames[0]).unwrap();
        assert!(presentation(&mut used) == fresh, "{scene} under {renderer}, after another scene");
        // What does not remember owes each frame alone.
        if !used.renderer.remembers() {
            assert!(used.frame(&frames[1]).0 == fresh[1], "{scene} under {renderer}, one frame");
        }
    }
}

/// Under every renderer at its defaults and at both ends of every parameter.
#[test]
fn a_uniform_scene_stays_uniform() {
    let display = display([160, 100], [600.0, 375.0], 450.0);
    let mut worst: f32 = 0.0;
    for renderer in &catalogue().renderers {
        for (scene, name, value, expected) in FLAT {
            if catalogue().mismatch(scene, &renderer.id, None).is_some() {
                continue;
            }
            let flat = if name.is_empty() { Parameters::new() } else { numbers([(name, value)]) };
            let mut setup = Setup::of(registry(), &display, (scene, &flat), (&renderer.id, &Parameters::new()));
            // Frames fill the middle alone, and a filter mixes in the black beside them.
            let framed = catalogue().capture(scene).is_some();
            if framed && renderer.id != "reference" && renderer.id != scene {
                continue;
            }
            for given in settings(renderer) {
                setup.renderer.set_parameters(&given).unwrap();
                setup.renderer.begin();
                let (rgba, _) = setup.frame(&looking_at([11.0, -6.0]));
                for (index, pixel) in rgba.chunks_exact(4).enumerate() {
                    let inside = (72..88).contains(&(index % 160)) && (42..58).contains(&(index / 160));
                    let expected = if framed && !inside { 0.0 } else { expected };
                    let apart = pixel[..3].iter().map(|x| (x - expected).abs()).fold(0.0, f32::max);
                    assert!(apart <= 2.5e-4, "{} {given:?} pixel {index}: {apart:.2e}", renderer.id);
                    worst = worst.max(apart);
                }
            }
        }
    }
    // One step of half floats below 0.5.
    println!("largest departure from a uniform scene: {worst:.2e}, allowed 2.5e-4");
}

/// Where a renderer says that it removes nothing, with a degree to spare, the picture is the reference, bit by bit. Renderers
/// whose law is a line remove something everywhere in principle; `layers.rs` holds theirs.
#[test]
fn where_nothing_is_removed_the_picture_is_the_reference() {
    let display = display([240, 135], [597.0, 335.8], 400.0);
    let none = Parameters::new();
    let mut checked = Vec::new();
    for renderer in &catalogue().renderers {
        let scene = scene_for(renderer);
        let defaults = renderer.parameters.iter().map(|schema| (schema.name.clone(), schema.default_value())).collect();
        let nothing =
            |e: f64| [-1.0, 0.0, 1.0].iter().all(|d| renderer.detail.mar_deg(&defaults, (e + d).max(0.0)) == Some(0.0));
        let by_line = matches!(renderer.detail, DetailLaw::Line { .. });
        for gaze_deg in [[0.0, 0.0], [13.3, -8.1], [-36.0, 22.0]] {
            let reference =
                Setup::of(registry(), &display, (&scene, &none), ("reference", &none)).frame(&looking_at(gaze_deg)).0;
            let shown =
                Setup::of(registry(), &display, (&scene, &none), (&renderer.id, &none)).frame(&looking_at(gaze_deg)).0;
            let mut same = 0_u64;
            for (index, e) in eccentricities(&display, gaze_deg).into_iter().enumerate() {
                if nothing(e) {
                    let at = 4 * index..4 * index + 4;
                    assert_eq!(shown[at.clone()], reference[at], "{} at {e:.2}°, gaze {gaze_deg:?}", renderer.id);
                    same += 1;
                }
            }
            assert!(
                same > 0 || by_line || renderer.detail == DetailLaw::Unknown || gaze_deg[0] < -30.0,
                "{}",
                renderer.id
            );
            println!("{} gaze {gaze_deg:?}: {same} pixels are the reference", renderer.id);
            checked.push(same);
        }
    }
    assert!(checked.iter().filter(|&&same| same > 1000).count() >= 6, "{checked:?}");
}

/// What the scene was made to draw, counted on the GPU, is at most what the renderer reports; what it reports beyond is
/// filtering, of each display pixel at most once. Frames that show an unchanged picture again cost nothing, unless the
/// renderer remembers.
#[test]
fn the_cost_is_what_was_drawn() {
    let display = display([320, 181], [597.0, 335.8], 500.0);
    let none = Parameters::new();
    for (scene, renderer) in every_pair() {
        let mut setup = Setup::of(registry(), &display, (&scene, &none), (&renderer, &none));
        if is_world(setup.scene.as_mut()) && scene != ONE_WORLD {
            continue;
        }
        setup.renderer.begin();
        for gaze_deg in [[0.0, 0.0], [9.0, -4.0], [60.0, 50.0]] {
            let tally = Tally::new(gpu(), display.resolution_px());
            let mut counted = Tallied::new(setup.scene.as_mut(), &tally);
            let cost = setup.renderer.render(gpu(), &mut counted, &looking_at(gaze_deg)).unwrap();
            let drawn = tally.counts(gpu()).unwrap().pixels();
            let filtered = cost.pixels_shaded.checked_sub(drawn);
            let label = format!("{scene} under {renderer}, gaze {gaze_deg:?}: counted {drawn}, reported {cost:?}");
            assert!(filtered.is_some_and(|filtered| filtered <= display.pixels()), "{label}");
            let layers = setup.renderer.layer_costs();
            let in_layers: u64 = layers.iter().filter(|layer| layer.drawn).map(|layer| layer.cost.pixels_shaded).sum();
            assert!(layers.is_empty() || in_layers == drawn, "{label}: {layers:?}");
        }
        if !setup.renderer.remembers() {
            let (_, cost) = setup.frame(&looking_at([1.0, 1.0]));
            assert!(cost.pixels_shaded > 0, "{scene} under {renderer}");
            let (_, again) = setup.frame(&looking_at([1.0, 1.0]));
            assert_eq!((again.pixels_shaded, again.triangles), (0, 0), "{scene} under {renderer}");
        }
    }
}

/// Every parameter of every renderer: set between frames it gives what a renderer made with it gives, and back again.
#[test]
fn parameters_can_change_between_frames() {
    let display = display([96, 54], [500.0, 281.0], 600.0);
    let none = Parameters::new();
    let frame = looking_at([0.0, 0.0]);
    for renderer in &catalogue().renderers {
        let scene = scene_for(renderer);
        let setup = |given: &Parameters| Setup::of(registry(), &display, (&scene, &none), (&renderer.id, given));
        let mut used = setup(&none);
        let shown = |setup: &mut Setup| {
            setup.renderer.begin();
            setup.frame(&frame).0
        };
        let first = shown(&mut used);
        for given in settings(renderer) {
            used.renderer.set_parameters(&given).unwrap();
            let changed = shown(&mut used);
            assert!(changed == shown(&mut setup(&given)), "{} {given:?}", renderer.id);
            for name in given.keys() {
                let wrong = Parameters::from([(name.clone(), ParameterValue::Number(f64::NAN))]);
                assert_eq!(used.renderer.set_parameters(&wrong).unwrap_err().len(), 1);
            }
            assert!(used.renderer.set_parameters(&numbers([("no_such_name", 1.0)])).is_err());
            assert!(shown(&mut used) == changed, "{}: a refused parameter changes nothing", renderer.id);
        }
        used.renderer.set_parameters(&none).unwrap();
        assert!(shown(&mut used) == first, "{}", renderer.id);
    }
}

#[test]
fn refusals_say_what_was_wrong() {
    let display = display([64, 64], [100.0, 100.0], 500.0);
    let none = Parameters::new();
    let unknown = make_scene(gpu(), &display, "nowhere", &none).err().unwrap();
    assert!(unknown.to_string().contains("photo"), "{unknown}");
    let unknown = registry().make_renderer(gpu(), &display, "magic", &none).err().unwrap();
    assert!(unknown.to_string().contains("ring") && unknown.to_string().contains("quiet"), "{unknown}");
    let parameters = numbers([("mar_deg", 1e9), ("wrong", 1.0)]);
    match make_renderer(gpu(), &display, "ring", &parameters).err() {
        Some(MakeError::Parameters(errors)) => assert_eq!(errors.len(), 2),
        other => panic!("{other:?}"),
    }
    for renderer in &catalogue().renderers {
        let mut setup = Setup::of(registry(), &display, (&scene_for(renderer), &none), (&renderer.id, &none));
        let refused = setup.renderer.render(gpu(), setup.scene.as_mut(), &looking_at([f64::NAN, 0.0]));
        assert!(matches!(refused, Err(RenderError::NotFinite { .. })), "{}: {refused:?}", renderer.id);
    }
}

#[test]
fn gpu_time_arrives_where_it_can_be_measured() {
    let display = display([64, 64], [100.0, 100.0], 500.0);
    let none = Parameters::new();
    for renderer in ["ring", "quiet"] {
        let mut setup = Setup::of(registry(), &display, ("noise", &none), (renderer, &none));
        let mut known = None;
        for step in 0..10 {
            let (_, cost) = setup.frame(&looking_at([0.1 * f64::from(step), 0.0]));
            known = known.or(cost.gpu_time_s);
        }
        println!("{renderer}: GPU time {known:?} s, measurable: {}", gpu().timestamps);
        assert_eq!(known.is_some(), gpu().timestamps);
        assert!(known.is_none_or(|s| s > 0.0 && s < 60.0));
    }
}
