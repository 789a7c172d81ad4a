//! The pixel observer on pictures made here: textured noise, blurred more and more away from the gaze.

use super::*;
use crate::catalogue::DetailLaw;
use crate::observers::Picture;
use crate::observers::decision::tests::{Met, condition, trial};
use crate::streams::Stream;
use crate::study::plan::Level;
use crate::trial::{Answer, Asked, Phase, PhaseName};
use rand::RngExt;

const SIZE: [u32; 2] = [480, 270];

/// The demo display with fewer pixels of its size.
fn display() -> Display {
    Display::new("small", SIZE, [597.0, 335.8], 2200.0).expect("possible")
}

/// A texture with a 1/f amplitude spectrum: octaves of smoothly interpolated noise, each of half the period and half the
/// amplitude of the one before; grey, sRGB codes 20–235.
fn texture(seed: u64) -> Vec<f32> {
    let mut rng = Stream::Sampling.generator(seed);
    let [width, height] = SIZE.map(|extent| extent as usize);
    let mut sum = vec![0.0_f32; width * height];
    for octave in 0..7 {
        let period = 64 >> octave;
        let columns = width / period + 2;
        let grid: Vec<f32> = (0..columns * (height / period + 2)).map(|_| rng.random_range(-1.0..1.0)).collect();
        for (pixel, value) in sum.iter_mut().enumerate() {
            let (x, y) = (pixel % width, pixel / width);
            let [u, v] = [x, y].map(|at| (at % period) as f32 / period as f32);
            let corner = y / period * columns + x / period;
            let mix = |a: f32, b: f32, t: f32| a + (b - a) * t * t * (3.0 - 2.0 * t);
            let top = mix(grid[corner], grid[corner + 1], u);
            let bottom = mix(grid[corner + columns], grid[corner + columns + 1], u);
            *value += mix(top, bottom, v) * period as f32 / 64.0;
        }
    }
    let largest = sum.iter().fold(0.0_f32, |largest, value| largest.max(value.abs()));
    sum.iter().map(|value| 127.5 + 107.5 * value / largest).collect()
}

/// The texture blurred by a Gaussian of standard deviation `slope` degrees per degree of eccentricity.
fn foveated(texture: &[f32], display: &Display, slope: f64) -> Vec<f32> {
    let [width, height] = SIZE.map(|extent| extent as usize);
    let centre_px = SIZE.map(|extent| 0.5 * f64::from(extent));
    let pass = |from: &[f32], across: bool| -> Vec<f32> {
        (0..width * height)
            .map(|pixel| {
                let (x, y) = (pixel % width, pixel / width);
                let e = display.eccentricity_px_deg(centre_px, [x as f64 + 0.5, y as f64 + 0.5]);
                let sigma = slope * e / display.pixel_deg([0.0, 0.0]);
                let reach = (3.0 * sigma).ceil() as isize;
                let (mut sum, mut weights) = (0.0, 0.0);
                for k in -reach..=reach {
                    let (at, length) = if across { (x, width) } else { (y, height) };
                    let at = (at as isize + k).clamp(0, length as isize - 1) as usize;
                    let w = if sigma > 0.0 { (-0.5 * (k as f64 / sigma).powi(2)).exp() } else { 1.0 };
                    sum += w * f64::from(if across { from[y * width + at] } else { from[at * width + x] });
                    weights += w;
                }
                (sum / weights) as f32
            })
            .collect()
    };
    pass(&pass(texture, true), false)
}

fn rgba(grey: &[f32]) -> Vec<u8> {
    grey.iter().flat_map(|value| [value.round() as u8, value.round() as u8, value.round() as u8, 255]).collect()
}

fn seen<'a>(shown: &'a [u8], reference: &'a [u8], display: &'a Display) -> Seen<'a> {
    let picture = |rgba| Picture { size_px: SIZE, rgba };
    Seen { shown: picture(shown), reference: picture(reference), gaze_deg: [0.0, 0.0], display }
}

fn visibilities(seed: u64, slopes: &[f64]) -> Vec<f64> {
    let display = display();
    let texture = texture(seed);
    let reference = rgba(&texture);
    let sensitivity = Sensitivity::of_display(&FULL_RESOLUTION, &display, [0.0, 0.0], SIZE, BANDS);
    let see = |&slope: &f64| {
        let shown = rgba(&foveated(&texture, &display, slope));
        difference::visibility(&seen(&shown, &reference, &display), &sensitivity).expect("of one size")
    };
    slopes.iter().map(see).collect()
}

/// Spearman's rank correlation with 0, 1, 2, ….
fn rank_correlation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let rank = |value: f64| values.iter().filter(|&&other| other < value).count() as f64;
    let squares: f64 = values.iter().enumerate().map(|(index, &value)| (rank(value) - index as f64).powi(2)).sum();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

#[test]
fn more_foveation_is_more_visible() {
    let slopes: Vec<f64> = (1..=20).map(|step| 0.0015 * f64::from(step)).collect();
    for seed in [1, 2] {
        let visibilities = visibilities(seed, &slopes);
        let rho = rank_correlation(&visibilities);
        println!("seed {seed}: rank correlation {rho:.4}, V {visibilities:.3?}");
        assert!(rho >= 0.95, "seed {seed}: {rho}");
        assert!(visibilities[19] > 1.5 * visibilities[0]);
    }
}

#[test]
fn the_reference_itself_is_not_visible_and_pictures_that_do_not_fit_are_not_seen() {
    let display = display();
    let reference = rgba(&texture(3));
    let mut observer = PixelObserver::new(Options::default(), 1);
    observer.see(&seen(&reference, &reference, &display));
    assert_eq!(observer.pending, Some(0.0));
    observer.pending = None;
    observer.see(&seen(&reference[..400], &reference, &display));
    assert_eq!(observer.pending, None);
}

/// The blurred interval is named when it is plainly blurred, and either when it is the reference; whether the pictures come
/// before the phase or during it.
#[test]
fn the_degraded_interval_is_named_by_its_pixels() {
    let display = display();
    let texture = texture(4);
    let reference = rgba(&texture);
    let blurred = rgba(&foveated(&texture, &display, 0.05));
    let condition = condition(DetailLaw::Unknown);
    for before in [true, false] {
        let mut observer = PixelObserver::new(Options { lapse: 0.0, ..Options::default() }, 5);
        for index in 0..6_u32 {
            let order = if index % 2 == 0 {
                [Alternative::Test, Alternative::Reference]
            } else {
                [Alternative::Reference, Alternative::Test]
            };
            let (trial, level) = (trial(index, order, Level::new()), Level::new());
            let met = Met { trial: &trial, condition: &condition, level: &level, display: &display };
            for (name, alternative) in [(PhaseName::Interval1, order[0]), (PhaseName::Interval2, order[1])] {
                let phase = Phase::new(name, Presentation::stimulus(alternative), Some(0.3));
                let shown = if alternative == Alternative::Test { &blurred } else { &reference };
                if before {
                    observer.see(&seen(shown, &reference, &display));
                }
                observer.meet(&met.phase(&phase));
                if !before {
                    observer.see(&seen(shown, &reference, &display));
                }
                let gap = Phase::new(PhaseName::Gap, Presentation::Grey, Some(0.2));
                observer.meet(&met.phase(&gap));
            }
            let ask = Phase::new(PhaseName::Ask, Presentation::Text("Which?".to_owned()), None)
                .asking(Asked::WhichDegraded, vec![Answer::First, Answer::Second]);
            let (answer, _) = observer.meet(&met.phase(&ask)).answer.expect("answers");
            assert_eq!(answer == Answer::First, index % 2 == 0, "trial {index}, before: {before}");
        }
    }
}
