//! The eccentricity layers: the fovea is the reference, the periphery is coarser, and fewer pixels are drawn. The other
//! files hold what is counted, what time brings, what is newly uncovered, and what each switch does.

mod counted;
mod smoothing;
mod switches;
mod uncovered;

use crate::common::{Setup, display, eccentricities, looking_at, named, numbers, reference};
use experiments::catalogue::{ParameterValue, Parameters};
use experiments::display::Display;
use stimuli::optimise;

/// Parameters that are names and numbers.
fn settings<const N: usize, const M: usize>(names: [(&str, &str); N], values: [(&str, f64); M]) -> Parameters {
    let names = names.into_iter().map(|(name, value)| (name.to_owned(), ParameterValue::Text(value.to_owned())));
    names.chain(numbers(values)).collect()
}

/// Every part that remembers is off.
const STILL: [(&str, &str); 3] = [("half_rate", "off"), ("jitter", "off"), ("reprojection", "off")];

#[test]
fn the_fovea_equals_the_reference() {
    let display = display([480, 270], [597.0, 335.8], 400.0);
    let none = Parameters::new();
    for scene in ["photo", "noise", "orbit"] {
        let sharp = reference(&display, (scene, &none));
        let parameters = numbers([("m", 0.1), ("omega0_deg", 0.02)]);
        let plan = optimise(&display, 0.1, 0.02, 3, None);
        let mut setup = Setup::new(&display, (scene, &none), ("layers", &parameters));
        for gaze_deg in [[0.0, 0.0], [13.3, -8.1], [-36.0, 22.0], [38.0, 0.0]] {
            let (shown, cost) = setup.frame(&looking_at(gaze_deg));
            let angles = eccentricities(&display, gaze_deg);
            let limit = 0.599 * plan.layers[0].radius_deg;
            let (mut worst, mut beyond) = (0.0_f32, 0.0_f32);
            for (i, &e) in angles.iter().enumerate() {
                let apart = (0..3).map(|c| (shown[4 * i + c] - sharp[4 * i + c]).abs()).fold(0.0, f32::max);
                if e < limit {
                    worst = worst.max(apart);
                } else {
                    beyond = beyond.max(apart);
                }
            }
            println!("{scene} gaze {gaze_deg:?}: fovea {worst:.2e}, beyond {beyond:.2e}, {} px", cost.pixels_shaded);
            assert!(worst <= 0.0, "{scene} {gaze_deg:?}");
            assert!(beyond > 0.0, "{scene} {gaze_deg:?}: nothing was foveated");
        }
    }
}

/// With the gaze at the centre the counted pixels are the plan's, but for whole pixels and the display's upper and lower edge.
#[test]
fn the_cost_is_what_the_plan_predicts() {
    let display = Display::named("guenter-2012").unwrap();
    let plan = optimise(&display, 0.0275, 1.0 / 48.0, 3, None);
    let none = Parameters::new();
    let mut setup = Setup::new(&display, ("noise", &none), ("layers", &settings(STILL, [("m", 0.0275)])));
    let cost = setup.renderer.render(crate::common::gpu(), setup.scene.as_mut(), &looking_at([0.0; 2])).unwrap();
    let predicted = plan.pixels();
    println!("counted {} px, predicted {predicted:.0}", cost.pixels_shaded);
    assert!((cost.pixels_shaded as f64 / predicted - 1.0).abs() < 0.02);
}

#[test]
fn a_photograph_keeps_its_mean_in_every_layer() {
    let display = display([480, 270], [597.0, 335.8], 400.0);
    let gravel = named("image", "gravel");
    let sharp = reference(&display, ("photo", &gravel));
    let (shown, _) =
        Setup::new(&display, ("photo", &gravel), ("layers", &numbers([("m", 0.1)]))).frame(&looking_at([0.0; 2]));
    let mean = |rgba: &[f32]| rgba.chunks_exact(4).map(|p| f64::from(p[1])).sum::<f64>() / (rgba.len() / 4) as f64;
    let (sharp, shown) = (mean(&sharp), mean(&shown));
    println!("mean {sharp:.5}, in layers {shown:.5}");
    assert!((shown / sharp - 1.0).abs() < 5e-3);
}

/// Guenter 2012, §5: quality index 12 is the slope 0.0275, and 15 is 0.0220.
#[test]
fn the_quality_index_sets_the_slope_in_place_of_m() {
    let display = display([160, 90], [597.0, 335.8], 400.0);
    let none = Parameters::new();
    let frame =
        |values: &Parameters| Setup::new(&display, ("photo", &none), ("layers", values)).frame(&looking_at([3.0, 1.0]));
    for (quality_index, m) in [(12.0, 0.0275), (15.0, 0.022)] {
        assert!(frame(&numbers([("quality_index", quality_index), ("m", 0.5)])) == frame(&numbers([("m", m)])));
    }
    assert!(frame(&numbers([("quality_index", 0.0), ("m", 0.5)])) == frame(&numbers([("m", 0.5)])));
    assert!(frame(&numbers([("quality_index", 4.0)])).0 != frame(&numbers([("quality_index", 22.0)])).0);
    // However coarse, it is still a picture.
    assert!(frame(&numbers([("quality_index", 1e-6)])).0.iter().all(|x| x.is_finite()));
}
