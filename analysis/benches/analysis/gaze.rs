//! An hour of binocular gaze at 1000 Hz.

use analysis::gaze::GazeSample;
use analysis::gaze::events::{EventConfig, EventSummary, detect};
use analysis::gaze::quality::{QualityConfig, data_quality};
use criterion::Criterion;
use std::hint::black_box;

/// Steps of 5° three times a second, noise, one sample in two hundred lost.
fn hour(phase: f64) -> Vec<GazeSample> {
    (0..3_600_000u32)
        .map(|i| {
            let t_s = f64::from(i) * 1e-3;
            let (steps, within) = ((t_s * 3.0 + phase).floor(), (t_s * 3.0 + phase).fract() / 3.0);
            let moved = (within / 0.03).min(1.0);
            let u = moved * moved * (3.0 - 2.0 * moved);
            let noise = |salt: u64| {
                let mixed = (u64::from(i) + salt).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
                (mixed >> 40) as f64 / f64::from(1u32 << 24) - 0.5
            };
            let place = |step: f64| 2.5 * if step.rem_euclid(2.0) < 1.0 { -1.0 } else { 1.0 };
            let x = place(steps - 1.0) * (1.0 - u) + place(steps) * u;
            let position_deg = [x + 0.02 * noise(0), 0.02 * noise(1 << 33)];
            GazeSample { t_s, position_deg, deviation_deg: position_deg[0].abs(), valid: i % 200 != 0 }
        })
        .collect()
}

/// Both eyes, one after the other: each benchmark at most 1 s.
pub(crate) fn bench(criterion: &mut Criterion) {
    let eyes = [hour(0.0), hour(0.001)];
    let mut of_both = |name: &str, of_one: &dyn Fn(&[GazeSample])| {
        criterion.bench_function(name, |bencher| bencher.iter(|| eyes.iter().for_each(|eye| of_one(black_box(eye)))));
    };
    of_both("summary of an hour of gaze, 1000 Hz, two eyes", &|eye| {
        black_box(analysis::gaze::summarise(eye));
    });
    let config = QualityConfig { target_deg: Some([0.0, 0.0]), ..QualityConfig::default() };
    of_both("data quality of it", &|eye| {
        black_box(data_quality(eye, &config).ok());
    });
    let saccades = |config: EventConfig| {
        move |eye: &[GazeSample]| {
            black_box(detect(eye, &config).ok().map(|events| EventSummary::new(&events)));
        }
    };
    of_both("saccades and fixations of it by velocity threshold", &saccades(EventConfig::velocity_threshold()));
    of_both("saccades and fixations of it by Engbert & Kliegl", &saccades(EventConfig::engbert_kliegl()));
}
