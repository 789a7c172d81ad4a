//! The ring against its oracle, outside itself, and as it follows the gaze.

use crate::common::{Setup, display, eccentricities, looking_at, named, numbers, reference};
use crate::oracle::{RingSettings, ring_pixel};
use experiments::catalogue::Parameters;
use experiments::display::Display;
use stimuli::foveation::low_pass::ring_mask;

fn ring_parameters(s: &RingSettings) -> Parameters {
    numbers([
        ("eccentricity_deg", s.eccentricity_deg),
        ("width_deg", s.width_deg),
        ("edge_deg", s.edge_deg),
        ("mar_deg", s.mar_deg),
    ])
}

/// Largest difference from the oracle over about `samples` pixels of the ring, and over all pixels outside it.
fn differences(
    display: &Display,
    scene: (&str, &Parameters),
    gaze_deg: [f64; 2],
    s: &RingSettings,
    samples: usize,
) -> (f64, f64) {
    let sharp = reference(display, scene);
    let (shown, _) = Setup::new(display, scene, ("ring", &ring_parameters(s))).frame(&looking_at(gaze_deg));
    let masks: Vec<f64> = eccentricities(display, gaze_deg)
        .into_iter()
        .map(|e| ring_mask(e, s.eccentricity_deg, s.width_deg, s.edge_deg))
        .collect();
    let inside: Vec<usize> = (0..masks.len()).filter(|&i| masks[i] > 0.0).collect();
    let outside = (0..masks.len()).filter(|&i| masks[i] <= 0.0);
    let apart = |i: usize| (0..3).map(move |c| 4 * i + c);
    let outside_max = outside.flat_map(apart).map(|at| f64::from((shown[at] - sharp[at]).abs())).fold(0.0, f64::max);
    let stride = (inside.len() / samples).max(1);
    let inside_max = inside
        .iter()
        .step_by(stride)
        .map(|&i| {
            let expected = ring_pixel(display, &sharp, gaze_deg, s, i);
            (0..3).map(|c| (f64::from(shown[4 * i + c]) - expected[c]).abs()).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max);
    (inside_max, outside_max)
}

/// The stated maximum error: 1e-3 of the display's peak, for filters up to 4°/cycle on displays up to 73° wide.
#[test]
fn ring_equals_the_oracle() {
    let narrow = display([480, 270], [597.0, 335.8], 1100.0);
    let wide = display([480, 270], [597.0, 335.8], 400.0);
    let noise = numbers([("seed", 7.0)]);
    let coffee = named("image", "coffee");
    let mut worst: f64 = 0.0;
    for (display, label) in [(&narrow, "30°"), (&wide, "73°")] {
        for (scene, scene_label) in [(("noise", &noise), "noise seed 7"), (("photo", &coffee), "coffee")] {
            for (gaze_deg, e, width, mar) in [
                ([0.0, 0.0], 0.0, 4.0, 0.05),
                ([0.0, 0.0], 0.0, 6.0, 0.5),
                ([3.0, -2.0], 8.0, 4.0, 0.15),
                ([3.0, -2.0], 8.0, 4.0, 0.7),
                ([-12.0, 6.0], 10.0, 6.0, 1.5),
                ([14.5, 8.0], 5.0, 4.0, 0.9),
                ([30.0, -15.0], 20.0, 8.0, 2.0),
                ([-34.0, 20.0], 6.0, 8.0, 4.0),
                ([20.0, 12.0], 10.0, 10.0, 3.0),
            ] {
                let s = RingSettings { eccentricity_deg: e, width_deg: width, edge_deg: 0.5, mar_deg: mar };
                let (inside, outside) = differences(display, scene, gaze_deg, &s, 250);
                println!(
                    "{label:4} {scene_label:12} gaze {gaze_deg:?} e {e} omega {mar}: inside {inside:.2e}, outside {outside:.2e}"
                );
                worst = worst.max(inside);
                assert!(inside < 1e-3 && outside <= 0.0, "{label} {scene_label} {gaze_deg:?} {s:?}");
            }
        }
    }
    println!("largest difference from the oracle: {worst:.2e}");
}

/// The widest filters far off the axis of a wide display, where the factored passes depart most.
#[test]
fn widest_filters_stay_near_the_oracle() {
    let wide = display([240, 135], [597.0, 335.8], 400.0);
    let coffee = named("image", "coffee");
    for (mar, limit) in [(8.0, 2e-3), (20.0, 6e-3)] {
        let s = RingSettings { eccentricity_deg: 30.0, width_deg: 40.0, edge_deg: 2.0, mar_deg: mar };
        let (inside, _) = differences(&wide, ("photo", &coffee), [10.0, 5.0], &s, 200);
        println!("73°, coffee, omega {mar}: {inside:.2e}");
        assert!(inside < limit, "{mar}");
    }
}

#[test]
fn finest_ring_is_the_reference() {
    let display = display([320, 200], [597.0, 335.8], 1100.0);
    let noise = numbers([("seed", 3.0)]);
    let sharp = reference(&display, ("noise", &noise));
    let fine = numbers([("mar_deg", 0.005), ("eccentricity_deg", 5.0)]);
    let (shown, _) = Setup::new(&display, ("noise", &noise), ("ring", &fine)).frame(&looking_at([1.0, 1.0]));
    let worst = shown.iter().zip(&sharp).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("omega 0.005° on pixels of 0.1°: {worst:.2e}");
    assert!(worst <= 0.0);
}

/// On noise every filtered pixel changes, so the changed pixels are the ring: their angles from the gaze lie in it, and the
/// mean of their directions, weighted by solid angle, is the gaze.
#[test]
fn the_ring_moves_by_the_same_angle_as_the_gaze() {
    let display = display([480, 400], [600.0, 500.0], 500.0);
    let noise = numbers([("seed", 11.0)]);
    let sharp = reference(&display, ("noise", &noise));
    let s = RingSettings { eccentricity_deg: 6.0, width_deg: 2.0, edge_deg: 0.5, mar_deg: 2.0 };
    let mut setup = Setup::new(&display, ("noise", &noise), ("ring", &ring_parameters(&s)));
    for gaze_deg in [[0.0, 0.0], [8.0, 0.0], [0.0, -11.0], [-17.0, 9.0], [21.5, 14.25]] {
        let (shown, _) = setup.frame(&looking_at(gaze_deg));
        let angles = eccentricities(&display, gaze_deg);
        let changed = |i: usize| (shown[4 * i] - sharp[4 * i]).abs() > 1e-4;
        let mut direction = [0.0; 3];
        let mut mean_radius = (0.0, 0.0);
        let mut on_plateau = (0_u32, 0_u32);
        for (i, &e) in angles.iter().enumerate() {
            if (e - s.eccentricity_deg).abs() <= 0.5 * s.width_deg {
                on_plateau.0 += 1;
                on_plateau.1 += u32::from(changed(i));
            }
            if changed(i) {
                assert!((e - s.eccentricity_deg).abs() <= 0.5 * s.width_deg + s.edge_deg + 1e-3, "{e}");
                let mm = display.mm_from_px(crate::common::pixel_centre(&display, i));
                let v = display.direction_from_mm(mm);
                let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
                let solid_angle = (display.distance_mm() / length).powi(3);
                for axis in 0..3 {
                    direction[axis] += v[axis] / length * solid_angle;
                }
                mean_radius.0 += e * solid_angle;
                mean_radius.1 += solid_angle;
            }
        }
        let centre_deg = display.deg_from_mm([0, 1].map(|axis| direction[axis] / direction[2] * display.distance_mm()));
        let off_deg = display.eccentricity_deg(gaze_deg, centre_deg);
        let radius_deg = mean_radius.0 / mean_radius.1;
        println!(
            "seed 11, gaze {gaze_deg:?}: centre off by {off_deg:.4}°, mean radius {radius_deg:.4}°, {on_plateau:?}"
        );
        // Over the solid angle between 4.5° and 7.5° the mean radius is ⅔ (b³ − a³) / (b² − a²) = 6.125°.
        assert!(off_deg < 0.02 && (radius_deg - 6.125).abs() < 0.02);
        assert!(f64::from(on_plateau.1) > 0.99 * f64::from(on_plateau.0));
    }
}

#[test]
fn cost_counts_the_scene_once_and_the_filtered_pixels() {
    let display = display([320, 200], [500.0, 312.5], 600.0);
    let noise = Parameters::new();
    let s = RingSettings { eccentricity_deg: 7.0, width_deg: 3.0, edge_deg: 0.5, mar_deg: 1.0 };
    let mut setup = Setup::new(&display, ("noise", &noise), ("ring", &ring_parameters(&s)));
    for (frame, gaze_deg) in [[2.0, 1.0], [-9.0, 3.0], [60.0, 0.0]].into_iter().enumerate() {
        let filtered = eccentricities(&display, gaze_deg).into_iter().filter(|e| (e - 7.0).abs() <= 2.0).count() as u64;
        let (_, cost) = setup.frame(&looking_at(gaze_deg));
        let expected = filtered + if frame == 0 { display.pixels() } else { 0 };
        // A pixel exactly on the rim may fall either way.
        assert!(cost.pixels_shaded.abs_diff(expected) <= 2, "{} {expected}", cost.pixels_shaded);
        let (_, again) = setup.frame(&looking_at(gaze_deg));
        assert_eq!(again.pixels_shaded, 0, "nothing changed");
    }
}

/// What the ring keeps from earlier frames must not show: a wandering gaze and changing limits give the bytes of a
/// renderer that has seen nothing before.
#[test]
fn a_ring_that_wandered_equals_a_fresh_one() {
    let display = display([333, 217], [597.0, 335.8], 700.0);
    let photo = named("image", "coffee");
    let settings = |e, mar_deg| RingSettings { eccentricity_deg: e, width_deg: 3.0, edge_deg: 0.5, mar_deg };
    let mut wandering = Setup::new(&display, ("photo", &photo), ("ring", &ring_parameters(&settings(9.0, 2.0))));
    for (step, mar_deg) in [0.3, 0.3, 0.3, 3.0, 3.0, 3.0, 0.8, 0.8, 3.0, 12.0, 12.0, 0.3].into_iter().enumerate() {
        let t = step as f64;
        let parameters = ring_parameters(&settings(4.0 + t, mar_deg));
        let gaze = looking_at([14.0 * (0.9 * t).sin(), 6.0 * (1.7 * t).cos()]);
        wandering.renderer.set_parameters(&parameters).unwrap();
        let (shown, _) = wandering.frame(&gaze);
        let (fresh, _) = Setup::new(&display, ("photo", &photo), ("ring", &parameters)).frame(&gaze);
        assert!(shown == fresh, "step {step}, omega {mar_deg}");
    }
}
