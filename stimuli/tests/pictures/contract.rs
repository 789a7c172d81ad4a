//! What every scene and renderer owes, whatever its kind: any size, any gaze, the same bytes again, a plausible cost.

use crate::common::{Setup, display, gpu, looking_at, numbers};
use experiments::catalogue::{ParameterValue, Parameters};
use stimuli::{FrameInput, MakeError, RenderError, catalogue, make_renderer, make_scene};

fn every_pair() -> Vec<(String, String)> {
    let catalogue = catalogue();
    let scenes = catalogue.scenes.iter().map(|s| s.id.clone());
    scenes
        .flat_map(|s| catalogue.renderers.iter().map(move |r| (s.clone(), r.id.clone())).collect::<Vec<_>>())
        .collect()
}

#[test]
fn every_scene_works_under_every_renderer() {
    let none = Parameters::new();
    for display in [display([333, 217], [500.0, 330.0], 450.0), display([16, 16], [40.0, 30.0], 300.0)] {
        for (scene, renderer) in every_pair() {
            let mut setup = Setup::new(&display, (&scene, &none), (&renderer, &none));
            for gaze_deg in [[0.0, 0.0], [28.0, -19.0], [-70.0, 45.0], [200.0, -1e4]] {
                let frame = FrameInput { gaze_deg, animation_s: gaze_deg[0], ..FrameInput::default() };
                let (rgba, cost) = setup.frame(&frame);
                let label = format!("{scene} under {renderer} at {:?}, gaze {gaze_deg:?}", display.resolution_px());
                assert!(rgba.iter().all(|x| x.is_finite() && (0.0..=1.0).contains(x)), "{label}");
                assert!(rgba.chunks_exact(4).all(|p| p[3] > 0.999), "{label}: alpha");
                assert!(cost.pixels_shaded <= 3 * display.pixels() + 64, "{label}: {cost:?}");
                assert!(cost.rays_traced <= cost.pixels_shaded, "{label}: {cost:?}");
                let brightness = rgba.chunks_exact(4).map(|p| p[1]).sum::<f32>() / display.pixels() as f32;
                assert!(brightness > 0.02, "{label}: all but black, {brightness}");
            }
        }
    }
}

#[test]
fn the_same_input_gives_the_same_bytes_whatever_came_before() {
    let display = display([160, 90], [500.0, 281.0], 600.0);
    let none = Parameters::new();
    let frame = FrameInput { gaze_deg: [3.0, 2.0], animation_s: 1.25, ..FrameInput::default() };
    for (scene, renderer) in every_pair() {
        let (fresh, _) = Setup::new(&display, (&scene, &none), (&renderer, &none)).frame(&frame);
        let mut used = Setup::new(&display, (&scene, &none), (&renderer, &none));
        used.frame(&looking_at([-7.0, 4.0]));
        used.renderer.set_parameters(&none).unwrap();
        used.frame(&FrameInput { animation_s: 9.0, ..frame });
        used.renderer.begin();
        assert_eq!(used.frame(&frame).0, fresh, "{scene} under {renderer}");
        // Another scene through the same renderer, and back.
        let mut other = make_scene(gpu(), &display, "noise", &numbers([("seed", 77.0)])).unwrap();
        used.renderer.render(gpu(), other.as_mut(), &frame).unwrap();
        used.renderer.begin();
        assert_eq!(used.frame(&frame).0, fresh, "{scene} under {renderer}, after another scene");
    }
}

#[test]
fn a_flat_grey_stays_flat() {
    let display = display([320, 200], [600.0, 375.0], 450.0);
    let flat = numbers([("contrast", 0.0)]);
    let settings = [
        ("reference", Parameters::new()),
        ("layers", Parameters::new()),
        ("layers", numbers([("m", 0.2)])),
        ("ring", numbers([("mar_deg", 0.3)])),
        ("ring", numbers([("mar_deg", 1.5)])),
        ("ring", numbers([("mar_deg", 20.0), ("width_deg", 20.0)])),
        ("gaussian-falloff", numbers([("radius_deg", 2.0)])),
        ("gaussian-falloff", numbers([("radius_deg", 0.0), ("rate", 0.1)])),
    ];
    let mut worst: f32 = 0.0;
    for (renderer, parameters) in settings {
        let (rgba, _) =
            Setup::new(&display, ("noise", &flat), (renderer, &parameters)).frame(&looking_at([11.0, -6.0]));
        worst = rgba.chunks_exact(4).flat_map(|p| &p[..3]).map(|x| (x - 0.5).abs()).fold(worst, f32::max);
    }
    println!("largest departure from a flat 0.5: {worst:.2e}");
    // One step of half floats below 0.5.
    assert!(worst <= 2.5e-4);
}

#[test]
fn parameters_can_change_between_frames() {
    let display = display([160, 90], [500.0, 281.0], 600.0);
    let none = Parameters::new();
    let frame = looking_at([0.0, 0.0]);
    for (renderer, name, value) in [("ring", "mar_deg", 3.0), ("layers", "m", 0.1), ("gaussian-falloff", "rate", 0.05)]
    {
        let changed = numbers([(name, value)]);
        let (fresh, _) = Setup::new(&display, ("photo", &none), (renderer, &changed)).frame(&frame);
        let mut setup = Setup::new(&display, ("photo", &none), (renderer, &none));
        let (first, _) = setup.frame(&frame);
        setup.renderer.set_parameters(&changed).unwrap();
        assert_eq!(setup.frame(&frame).0, fresh);
        let wrong = Parameters::from([(name.to_owned(), ParameterValue::Number(-1.0))]);
        assert_eq!(setup.renderer.set_parameters(&wrong).unwrap_err().len(), 1);
        setup.renderer.begin();
        assert_eq!(setup.frame(&frame).0, fresh, "a refused parameter changes nothing");
        setup.renderer.set_parameters(&none).unwrap();
        assert_eq!(setup.frame(&frame).0, first);
    }
}

#[test]
fn refusals_say_what_was_wrong() {
    let display = display([64, 64], [100.0, 100.0], 500.0);
    let none = Parameters::new();
    let unknown = make_scene(gpu(), &display, "nowhere", &none).err().unwrap();
    assert!(unknown.to_string().contains("photo"), "{unknown}");
    let unknown = make_renderer(gpu(), &display, "magic", &none).err().unwrap();
    assert!(unknown.to_string().contains("ring"), "{unknown}");
    let parameters = numbers([("mar_deg", 1e9), ("wrong", 1.0)]);
    match make_renderer(gpu(), &display, "ring", &parameters).err() {
        Some(MakeError::Parameters(errors)) => assert_eq!(errors.len(), 2),
        other => panic!("{other:?}"),
    }
    let mut setup = Setup::new(&display, ("noise", &none), ("ring", &none));
    let refused = setup.renderer.render(gpu(), setup.scene.as_mut(), &looking_at([f64::NAN, 0.0]));
    assert!(matches!(refused, Err(RenderError::NotFinite { .. })), "{refused:?}");
}

#[test]
fn gpu_time_arrives_where_it_can_be_measured() {
    let display = display([64, 64], [100.0, 100.0], 500.0);
    let none = Parameters::new();
    let mut setup = Setup::new(&display, ("noise", &none), ("ring", &none));
    let mut known = None;
    for step in 0..10 {
        let (_, cost) = setup.frame(&looking_at([0.1 * f64::from(step), 0.0]));
        known = known.or(cost.gpu_time_s);
    }
    println!("GPU time {known:?} s, measurable: {}", gpu().timestamps);
    assert_eq!(known.is_some(), gpu().timestamps);
    assert!(known.is_none_or(|s| s > 0.0 && s < 60.0));
}
