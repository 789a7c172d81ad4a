//! Writing and reading the log: a gaze sample as a sealed line, a table of them back, an event as a chained line.

use criterion::{Criterion, Throughput};
use experiments::Display;
use experiments::session::{Event, Stamped};
use experiments::trial::PhaseName;
use parafovea::gaze::{EyeSample, GazeSample};
use parafovea::session::header::FORMAT;
use parafovea::session::journal::{Chain, line_from_event};
use parafovea::session::tables::{GazeRow, Layout, read_rows};
use std::hint::black_box;

/// Samples of a binocular tracker with all digits that doubles have.
fn samples() -> Vec<GazeSample> {
    (0..100_000u32)
        .map(|number| {
            let t_s = f64::from(number) * 1e-3;
            let place = |shift: f64| [960.0 + 100.0 * (t_s + shift).sin(), 540.0 + 100.0 * (t_s + shift).cos()];
            let eye = |shift| Some(EyeSample { px: place(shift), valid: true, pupil_mm: Some(3.0 + 0.1 * t_s.sin()) });
            GazeSample {
                t_s,
                arrived_s: t_s + 0.003,
                t_device_s: t_s,
                px: place(0.0),
                valid: true,
                pupil_mm: Some(3.0),
                left: eye(0.01),
                right: eye(-0.01),
            }
        })
        .collect()
}

pub(crate) fn measure(criterion: &mut Criterion) {
    let Some(display) = Display::named("guenter-2012") else { return };
    let samples = samples();
    let mut group = criterion.benchmark_group("log");
    group.sample_size(10).throughput(Throughput::Elements(samples.len() as u64));
    group.bench_function("gaze samples written", |bencher| {
        bencher.iter(|| {
            let (mut layout, mut text) = Layout::<GazeRow>::new(FORMAT);
            for sample in &samples {
                text.push_str(&layout.line(&GazeRow::of(sample, &display)));
            }
            black_box(text)
        });
    });
    let (mut layout, mut text) = Layout::<GazeRow>::new(FORMAT);
    samples.iter().for_each(|sample| text.push_str(&layout.line(&GazeRow::of(sample, &display))));
    group.bench_function("gaze samples read", |bencher| {
        bencher.iter(|| black_box(read_rows::<GazeRow>(text.as_bytes(), FORMAT).rows.len()));
    });
    group.throughput(Throughput::Elements(1));
    let event = Event::PhaseBegan { trial: Some(7), phase: PhaseName::Interval1, shown: None, at: Default::default() };
    let stamped = Stamped { seq: 1, t_s: 1.0 / 3.0, event };
    let mut chain = Chain::start(FORMAT);
    group.bench_function("event written", |bencher| {
        bencher.iter(|| black_box(line_from_event(&stamped, &mut chain)));
    });
    group.finish();
}
