//! How evenly the frames came.

use super::WIDTH;
use crate::svg::{Axis, BLUE, Canvas, Paint, Panel, VERMILION, legend};
use crate::timing::{Frame, intervals_s};

/// Histogram of frame intervals (left) and missed frames over the session (right).
///
/// `refresh_hz` draws the nominal interval; counts are on a logarithmic axis, so that one late frame in ten thousand shows.
#[must_use]
pub fn frame_timing(frames: &[Frame], refresh_hz: Option<f64>) -> String {
    let height = 290.0;
    let (left, top, tall) = (70.0, 58.0, 172.0);
    let mut canvas = Canvas::default();
    draw_legend(&mut canvas, left, refresh_hz.is_some());
    draw_histogram(&mut canvas, [left, top], [296.0, tall], &intervals_s(frames), refresh_hz);
    draw_missed(&mut canvas, [left + 296.0 + 64.0, top], [WIDTH - left - 296.0 - 64.0 - 20.0, tall], frames);
    let missed = frames.iter().filter(|frame| frame.missed).count();
    canvas.finish(
        [WIDTH, height],
        "Frame timing",
        &format!("Intervals of {} frames, of which {missed} were missed, and when they were missed.", frames.len()),
    )
}

fn draw_histogram(canvas: &mut Canvas, corner: [f64; 2], size: [f64; 2], intervals_s: &[f64], refresh_hz: Option<f64>) {
    let nominal_ms = refresh_hz.filter(|hz| *hz > 0.0).map(|hz| 1000.0 / hz);
    let longest = intervals_s.iter().map(|dt| 1000.0 * dt).fold(nominal_ms.unwrap_or(1.0), f64::max);
    let high = if longest.is_finite() { longest * 1.06 } else { 100.0 };
    const BINS: usize = 48;
    let mut counts = [0u32; BINS];
    for dt in intervals_s {
        let bin = (1000.0 * dt / high * BINS as f64) as usize;
        counts[bin.min(BINS - 1)] += 1;
    }
    let most = f64::from(counts.iter().copied().max().unwrap_or(1).max(1));
    let panel = Panel::new(
        corner,
        size,
        Axis::linear("Frame interval (ms)", 0.0, high).with_ticks(6),
        Axis::logarithmic("Frames", 0.7, (most * 1.6).max(10.0)).with_ticks(5),
    );
    panel.draw_grid(canvas);
    panel.draw(canvas, |canvas| {
        for (bin, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let from = high * bin as f64 / BINS as f64;
            let a = panel.px(from, f64::from(*count));
            let b = panel.px(from + high / BINS as f64, 0.7);
            canvas.rect(a, [b[0] - a[0] - 0.6, b[1] - a[1]], &Paint::fill(BLUE).opacity(0.85));
        }
        if let Some(nominal) = nominal_ms {
            let [x, _] = panel.px(nominal, 1.0);
            canvas.line([x, corner[1]], [x, corner[1] + size[1]], &Paint::ink(1.2).dashed("4 3"));
        }
    });
    panel.draw_axes(canvas, [true, true]);
    panel.draw_heading(canvas, "Intervals", &format!("{} intervals", intervals_s.len()));
}

fn draw_missed(canvas: &mut Canvas, corner: [f64; 2], size: [f64; 2], frames: &[Frame]) {
    let times = frames.iter().map(|frame| frame.presented_s).filter(|t| t.is_finite());
    let (from, to) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    let (from, to) = if from < to { (from, to) } else { (0.0, 1.0) };
    // Long sessions are read in minutes.
    let (unit, scale) = if to - from > 180.0 { ("min", 1.0 / 60.0) } else { ("s", 1.0) };
    const BINS: usize = 40;
    let mut counts = [0u32; BINS];
    for frame in frames.iter().filter(|frame| frame.missed && frame.presented_s.is_finite()) {
        let bin = ((frame.presented_s - from) / (to - from) * BINS as f64) as usize;
        counts[bin.min(BINS - 1)] += 1;
    }
    let most = f64::from(counts.iter().copied().max().unwrap_or(0)).max(4.0);
    let panel = Panel::new(
        corner,
        size,
        Axis::linear(format!("Time in session ({unit})"), from * scale, to * scale).with_ticks(5),
        Axis::linear("Missed frames", 0.0, most * 1.1).with_ticks(4),
    );
    panel.draw_grid(canvas);
    panel.draw(canvas, |canvas| {
        let step = (to - from) * scale / BINS as f64;
        for (bin, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let start = from * scale + step * bin as f64;
            let a = panel.px(start, f64::from(*count));
            let b = panel.px(start + step, 0.0);
            canvas.rect(a, [b[0] - a[0] - 0.6, b[1] - a[1]], &Paint::fill(VERMILION).opacity(0.9));
        }
    });
    panel.draw_axes(canvas, [true, true]);
    let missed = frames.iter().filter(|frame| frame.missed).count();
    panel.draw_heading(canvas, "Missed", &format!("{missed} of {}", frames.len()));
}

fn draw_legend(canvas: &mut Canvas, left: f64, nominal: bool) {
    let bars: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.rect([x - 8.0, y - 6.0], [16.0, 12.0], &Paint::fill(BLUE).opacity(0.85));
    };
    let missed: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.rect([x - 8.0, y - 6.0], [16.0, 12.0], &Paint::fill(VERMILION).opacity(0.9));
    };
    let line: &dyn Fn(&mut Canvas, [f64; 2]) =
        &|canvas, [x, y]| canvas.line([x, y - 8.0], [x, y + 8.0], &Paint::ink(1.2).dashed("4 3"));
    let mut entries = vec![("intervals (logarithmic count)", bars), ("missed frames", missed)];
    if nominal {
        entries.push(("display's refresh interval", line));
    }
    legend(canvas, [left, 18.0], WIDTH - left - 20.0, &entries);
}
