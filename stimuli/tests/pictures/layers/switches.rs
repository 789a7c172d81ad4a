//! Every part can be switched off: each switch changes what it should and nothing else, and without parts that remember a
//! picture depends on its own input alone.

use super::{STILL, settings};
use crate::common::{Setup, display, eccentricities, looking_at, numbers, pixel_centre};
use experiments::catalogue::Parameters;
use experiments::display::Display;
use stimuli::{FrameInput, optimise};

const M: f64 = 0.1;

fn small_display() -> Display {
    display([320, 180], [510.0, 286.9], 590.0)
}

/// Frames of a walk of the gaze over a moving court.
fn walk(index: u64) -> FrameInput {
    let t = index as f64;
    let gaze_deg = [4.0 * (0.3 * t).sin() + if index >= 5 { 6.0 } else { 0.0 }, 2.0 * (0.2 * t).cos()];
    FrameInput { gaze_deg, frame_index: index + 100, animation_s: t / 60.0, ..FrameInput::default() }
}

fn setup(names: &[(&str, &str)]) -> Setup {
    let mut parameters = settings([], [("m", M)]);
    for &(name, value) in names {
        parameters.extend(settings([(name, value)], []));
    }
    Setup::new(&small_display(), ("orbit", &Parameters::new()), ("layers", &parameters))
}

fn frames(setup: &mut Setup, count: u64) -> Vec<Vec<f32>> {
    (0..count).map(|index| setup.frame(&walk(index)).0).collect()
}

#[test]
fn the_same_frames_since_the_beginning_give_the_same_bytes() {
    for names in [&[][..], &[("jitter", "all"), ("layers", "4")], &[("half_rate", "off")], &[("reprojection", "off")]] {
        let mut fresh = setup(names);
        assert!(fresh.renderer.remembers());
        let expected = frames(&mut fresh, 8);
        let mut used = setup(names);
        for index in 0..5 {
            used.frame(&FrameInput { gaze_deg: [-9.0, 3.0], ..walk(3 * index) });
        }
        used.renderer.begin();
        assert!(frames(&mut used, 8) == expected, "{names:?}");
        // Going back in time, and another scene in between, are beginnings as well.
        assert!(frames(&mut used, 8) == expected, "{names:?}, back in time");
        let other = Setup::new(&small_display(), ("photo", &Parameters::new()), ("reference", &Parameters::new()));
        let mut other_scene = other.scene;
        used.renderer.render(crate::common::gpu(), other_scene.as_mut(), &walk(9)).unwrap();
        assert!(frames(&mut used, 8) == expected, "{names:?}, another scene");
    }
}

#[test]
fn without_parts_that_remember_a_picture_is_its_own_input_s() {
    let mut used = setup(&STILL);
    assert!(!used.renderer.remembers());
    for (index, expected) in frames(&mut setup(&STILL), 6).into_iter().enumerate().rev() {
        let (found, cost) = used.frame(&walk(index as u64));
        assert!(found == expected, "frame {index}");
        assert!(cost.pixels_shaded > 0);
        let (again, cost) = used.frame(&walk(index as u64));
        assert!(again == expected && cost.pixels_shaded == 0, "frame {index}, unchanged input costs nothing");
        assert!(used.renderer.layer_costs().iter().all(|layer| !layer.drawn && layer.cost.pixels_shaded == 0));
    }
}

/// Where pictures with and without a part may differ: (the part, whether the first frame may, whether later ones may).
#[test]
fn each_switch_changes_its_own_part() {
    let all_off = |extra: &[(&'static str, &'static str)]| {
        let mut names = STILL.to_vec();
        names.extend(extra);
        frames(&mut setup(&names), 6)
    };
    let plain = all_off(&[]);
    let display = small_display();
    let plan = optimise(&display, M, 1.0 / 48.0, 3, None);
    // Farthest out, and nearest the gaze, that a frame differs, degrees.
    let difference = |frames: &[Vec<f32>], index: usize| {
        let angles = eccentricities(&display, walk(index as u64).gaze_deg);
        let apart = |i: &usize| frames[index][4 * i..4 * i + 3] != plain[index][4 * i..4 * i + 3];
        let differing: Vec<f64> = (0..angles.len()).filter(apart).map(|i| angles[i]).collect();
        (!differing.is_empty()).then(|| {
            (
                differing.iter().copied().fold(f64::MAX, f64::min),
                differing.iter().copied().fold(0.0, f64::max),
                differing.len(),
            )
        })
    };
    let [e1, e2] = [plan.layers[0].radius_deg, plan.layers[1].radius_deg];

    // A scene without triangles has neither their edges nor their number.
    for part in [("msaa", "off"), ("lod", "off")] {
        assert!(all_off(&[part]) == plain, "{part:?}");
    }
    // Parts of time leave the first frame as it was. A layer that rests reaches further, so that places in it come from
    // another corner: that is another rounding, which a ray at an edge may feel.
    for (part, most_rounded) in [(("half_rate", "on"), 200), (("reprojection", "on"), 0)] {
        let shown = all_off(&[part]);
        println!("{part:?}: {:?}, then {:?}", difference(&shown, 0), difference(&shown, 2));
        assert!(difference(&shown, 0).is_none_or(|(.., count)| count <= most_rounded), "{part:?}");
        let (nearest, _, count) = difference(&shown, 2).unwrap();
        assert!(nearest > 0.6 * e1 - 1e-3, "{part:?} reaches the fovea: {nearest}");
        assert!(count > 2000, "{part:?}: {count} px of a later frame differ");
    }
    // Jitter moves what is outside the fovea, or all.
    let (nearest, ..) = difference(&all_off(&[("jitter", "outer")]), 0).unwrap();
    assert!(nearest > 0.6 * e1 - 1e-3);
    let (nearest, ..) = difference(&all_off(&[("jitter", "all")]), 0).unwrap();
    assert!(nearest < 0.3 * e1);
    // Magnification: outside the fovea alone, everywhere there.
    let (nearest, farthest, count) = difference(&all_off(&[("magnification", "nearest")]), 0).unwrap();
    println!("nearest pixels: {count} px from {nearest:.2}° to {farthest:.2}°");
    assert!(nearest > 0.6 * e1 - 1e-3 && farthest > e2);
    // The blend: only where it lies.
    let hard = all_off(&[("blend", "hard")]);
    let angles = eccentricities(&display, walk(0).gaze_deg);
    for (i, &e) in angles.iter().enumerate() {
        let outside_blends = e < 0.6 * e1 - 1e-3 || (e > e1 + 1e-3 && e < 0.6 * e2 - 1e-3) || e > e2 + 1e-3;
        if outside_blends {
            assert!(hard[0][4 * i..4 * i + 3] == plain[0][4 * i..4 * i + 3], "{e}° at {:?}", pixel_centre(&display, i));
        }
    }
    assert!(hard[0] != plain[0]);
    // Other numbers of layers are other pictures, with the same fovea.
    for layers in ["2", "4"] {
        let e1 = optimise(&display, M, 1.0 / 48.0, layers.parse().unwrap(), None).layers[0].radius_deg.min(e1);
        let (nearest, ..) = difference(&all_off(&[("layers", layers)]), 0).unwrap();
        println!("{layers} layers: differs from {nearest:.2}° on");
        assert!(nearest > 0.6 * e1 - 1e-3);
    }
}

/// Whatever the display and the gaze, with every part on: a picture.
#[test]
fn odd_displays_and_gazes_give_pictures() {
    for resolution_px in [[16, 16], [17, 16], [16, 77], [131, 17], [67, 41]] {
        let size_mm = resolution_px.map(|x| f64::from(x) * 2.0);
        let display = display(resolution_px, size_mm, 300.0);
        for layers in ["2", "3", "4"] {
            for jitter in ["outer", "all"] {
                let parameters = settings([("layers", layers), ("jitter", jitter)], [("m", 0.3)]);
                let mut setup = Setup::new(&display, ("orbit", &Parameters::new()), ("layers", &parameters));
                for (index, gaze_deg) in [[0.0, 0.0], [0.5, 0.5], [85.0, 0.0], [-12.0, 8.0], [0.0, -400.0], [0.0, 0.1]]
                    .into_iter()
                    .enumerate()
                {
                    let frame = FrameInput { gaze_deg, animation_s: index as f64 / 60.0, ..looking_at(gaze_deg) };
                    let (rgba, cost) = setup.frame(&frame);
                    assert!(
                        rgba.iter().all(|x| x.is_finite() && (0.0..=1.0).contains(x)),
                        "{resolution_px:?} {gaze_deg:?}"
                    );
                    assert!(rgba.chunks_exact(4).any(|p| p[1] > 0.0));
                    assert!(cost.pixels_shaded <= 4 * display.pixels() + 64);
                }
            }
        }
    }
}

/// On a display so coarse that the fovea falls to the second layer, that one is drawn in every frame and neither jittered
/// nor averaged: the gaze's surroundings are the reference in every frame.
#[test]
fn the_layer_that_the_fovea_sees_never_rests() {
    let display = display([120, 68], [531.0, 299.0], 600.0);
    for quality_index in [6.0, 12.0, 22.0] {
        let parameters = numbers([("quality_index", quality_index)]);
        let mut setup = Setup::new(&display, ("orbit", &Parameters::new()), ("layers", &parameters));
        let mut reference = Setup::new(&display, ("orbit", &Parameters::new()), ("reference", &Parameters::new()));
        setup.renderer.begin();
        for frame in 0..4 {
            let input = FrameInput { animation_s: 0.1 * f64::from(frame), ..FrameInput::default() };
            let (shown, _) = setup.frame(&input);
            let (full, _) = reference.frame(&input);
            let middle = 4 * (34 * 120 + 60);
            assert_eq!(shown[middle..middle + 3], full[middle..middle + 3], "j {quality_index}, frame {frame}");
        }
    }
}
