//! The Gaussian falloff against a direct sum, inside its radius, and as it follows the gaze.

use crate::common::{Setup, display, eccentricities, looking_at, named, numbers, reference};
use crate::oracle::filtered_pixel;
use experiments::catalogue::Parameters;
use experiments::display::Display;
use stimuli::foveation::low_pass::SIGMA_PER_MAR;

const ID: &str = "gaussian-falloff";

fn falloff(radius_deg: f64, rate: f64) -> Parameters {
    numbers([("radius_deg", radius_deg), ("rate", rate)])
}

/// Largest and root-mean-square difference from the direct sum over some of the blurred pixels, and the largest σ among
/// them, px.
struct Difference {
    largest: f64,
    rms: f64,
    sigma_px: f64,
}

fn difference(
    display: &Display,
    scene: (&str, &Parameters),
    gaze_deg: [f64; 2],
    [radius_deg, rate]: [f64; 2],
    samples: usize,
) -> Difference {
    let sharp = reference(display, scene);
    let (shown, _) = Setup::new(display, scene, (ID, &falloff(radius_deg, rate))).frame(&looking_at(gaze_deg));
    let sigmas: Vec<f64> =
        eccentricities(display, gaze_deg).into_iter().map(|e| (rate * (e - radius_deg)).max(0.0)).collect();
    let blurred: Vec<usize> = (0..sigmas.len()).filter(|&i| sigmas[i] > 0.0).collect();
    let pixel_deg = (display.pitch_mm()[0] / display.distance_mm()).to_degrees();
    let mut found = Difference { largest: 0.0, rms: 0.0, sigma_px: 0.0 };
    let step = (blurred.len() / samples).max(1);
    let mut count = 0.0;
    // An odd number of pixels apart, so that no column of the even display is favoured.
    for &i in blurred.iter().step_by(step | 1) {
        let expected = filtered_pixel(display, &sharp, sigmas[i] / SIGMA_PER_MAR, i);
        for c in 0..3 {
            let apart = (f64::from(shown[4 * i + c]) - expected[c]).abs();
            found.largest = found.largest.max(apart);
            found.rms += apart * apart;
            count += 1.0;
        }
        found.sigma_px = found.sigma_px.max(sigmas[i] / pixel_deg);
    }
    found.rms = (found.rms / count).sqrt();
    for i in (0..sigmas.len()).filter(|&i| sigmas[i] <= 0.0) {
        assert!(shown[4 * i..4 * i + 4] == sharp[4 * i..4 * i + 4], "pixel {i} is not the reference's");
    }
    found
}

#[test]
fn every_pixel_is_the_direct_sum_with_its_own_sigma() {
    // The first display of Tursun 2019, a part of it: 50 px per degree; and a wide one of coarse pixels.
    let fine = display([480, 270], [111.9, 62.9], 665.0);
    let wide = display([480, 270], [600.0, 337.5], 405.0);
    let images = ["gravel", "chelsea", "coffee", "grass"];
    // The paper's k near the gaze, and five times as much; its strongest over 73°, four times as much, and the most there is.
    let cases = [
        (&fine, [-4.0, 1.0], [2.0, 0.0035], 2e-3),
        (&fine, [-4.0, 2.0], [1.0, 0.0175], 2e-3),
        (&wide, [0.0, 0.0], [4.0, 0.0052], 2e-3),
        (&wide, [-30.0, 12.0], [7.0, 0.02], 2e-3),
        (&wide, [-30.0, 12.0], [0.0, 0.1], 4e-3),
    ];
    for (display, gaze_deg, [radius_deg, rate], limit) in cases {
        // The sum over the widest Gaussians is long.
        let samples = if rate < 0.1 { 1000 } else { 150 };
        for image in images {
            let d = difference(display, ("photo", &named("image", image)), gaze_deg, [radius_deg, rate], samples);
            println!(
                "{image:8} r {radius_deg}° k {rate}: σ to {:5.2} px, largest {:.2e}, rms {:.2e}",
                d.sigma_px, d.largest, d.rms
            );
            assert!(d.largest <= limit, "{image} r {radius_deg} k {rate}: {:.2e}", d.largest);
        }
        let d = difference(display, ("noise", &Parameters::new()), gaze_deg, [radius_deg, rate], samples);
        println!("noise    r {radius_deg}° k {rate}: largest {:.2e}, rms {:.2e}", d.largest, d.rms);
        assert!(d.largest <= 4e-3, "noise r {radius_deg} k {rate}: {:.2e}", d.largest);
    }
}

#[test]
fn without_a_rate_or_beyond_the_display_it_is_the_reference() {
    let display = display([160, 90], [600.0, 337.5], 600.0);
    let none = Parameters::new();
    let sharp = reference(&display, ("photo", &none));
    for parameters in [falloff(0.0, 0.0), falloff(60.0, 0.1)] {
        let mut setup = Setup::new(&display, ("photo", &none), (ID, &parameters));
        let (shown, cost) = setup.frame(&looking_at([1.0, 2.0]));
        assert!(shown == sharp);
        assert_eq!(cost.pixels_shaded, display.pixels());
    }
}

/// On white noise of variance s² a Gaussian of σ pixels leaves s² / (4πσ²).
#[test]
fn blur_grows_with_eccentricity_as_it_should() {
    let display = display([480, 270], [600.0, 337.5], 800.0);
    let [radius_deg, rate] = [3.0, 0.02];
    let noise = numbers([("seed", 9.0)]);
    let (shown, _) =
        Setup::new(&display, ("noise", &noise), (ID, &falloff(radius_deg, rate))).frame(&looking_at([0.0; 2]));
    let angles = eccentricities(&display, [0.0; 2]);
    let pixel_deg = (display.pitch_mm()[0] / display.distance_mm()).to_degrees();
    let mut before = f64::INFINITY;
    for from_deg in [3.0, 6.0, 9.0, 12.0, 15.0, 18.0] {
        let (mut power, mut predicted, mut count) = (0.0, 0.0, 0.0);
        for (i, &e) in angles.iter().enumerate().filter(|(_, e)| (from_deg..from_deg + 3.0).contains(*e)) {
            let sigma_px = rate * (e - radius_deg) / pixel_deg * (1.0 + e.to_radians().tan().powi(2)).powf(0.75);
            power += (f64::from(shown[4 * i]) - 0.5).powi(2);
            predicted += 1.0 / 12.0 / (4.0 * std::f64::consts::PI * sigma_px * sigma_px);
            count += 1.0;
        }
        let (power, predicted) = (power / count, predicted / count);
        println!("{from_deg}°: variance {power:.3e}, predicted {predicted:.3e} of {count} pixels");
        assert!(power < before);
        before = power;
        // Wide enough for the pixels not to matter, and within what few independent values allow.
        if from_deg >= 9.0 {
            assert!((power / predicted - 1.0).abs() < 0.1, "{from_deg}: {power} is not {predicted}");
        }
    }
}

/// Eq. 14 takes σ from the true angle, wherever the gaze is.
#[test]
fn what_was_made_for_another_gaze_or_rate_is_right_for_this_one() {
    let display = display([200, 120], [600.0, 360.0], 450.0);
    let photo = named("image", "coffee");
    let mut wandering = Setup::new(&display, ("photo", &photo), (ID, &falloff(7.0, 0.0035)));
    for (step, rate) in [0.0035, 0.02, 0.0, 0.005, 0.1, 0.0035, 0.03].into_iter().enumerate() {
        let t = step as f64;
        let parameters = falloff(4.0 + t, rate);
        let gaze = looking_at([30.0 * (0.9 * t).sin(), 16.0 * (1.7 * t).cos()]);
        wandering.renderer.set_parameters(&parameters).unwrap();
        let (shown, cost) = wandering.frame(&gaze);
        let (fresh, _) = Setup::new(&display, ("photo", &photo), (ID, &parameters)).frame(&gaze);
        assert!(shown == fresh, "step {step}, rate {rate}");

        // What it says it filtered is what has a σ; the photograph was drawn once.
        let blurred =
            eccentricities(&display, gaze.gaze_deg).into_iter().filter(|&e| rate > 0.0 && e > 4.0 + t).count();
        let drawn = if step == 0 { display.pixels() } else { 0 };
        assert_eq!(cost.pixels_shaded, drawn + blurred as u64, "step {step}");
    }
}
