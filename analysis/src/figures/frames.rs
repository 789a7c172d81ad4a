//! How evenly the frames came.

use super::WIDTH;
use super::parts::{drawable, nothing};
use crate::svg::{Axis, BLUE, Canvas, Paint, Panel, VERMILION, legend};
use crate::timing::{Frame, intervals_s};

/// Histogram of frame intervals (left), and the shortest and longest interval over the session with missed frames marked
/// (right).
///
/// `refresh_hz` draws the nominal interval; counts are on a logarithmic axis, so that one late frame in ten thousand shows.
#[must_use]
pub fn frame_timing(frames: &[Frame], refresh_hz: Option<f64>) -> String {
    if frames.is_empty() {
        return nothing("Frame timing", "no frames were presented");
    }
    let height = 290.0;
    let (left, top, tall) = (70.0, 58.0, 172.0);
    let mut canvas = Canvas::default();
    draw_legend(&mut canvas, left, refresh_hz.is_some());
    let intervals: Vec<f64> = intervals_s(frames).into_iter().filter(|dt| drawable(1000.0 * dt)).collect();
    draw_histogram(&mut canvas, [left, top], [266.0, tall], &intervals, refresh_hz);
    draw_timeline(
        &mut canvas,
        [left + 266.0 + 74.0, top],
        [WIDTH - left - 266.0 - 74.0 - 20.0, tall],
        frames,
        refresh_hz,
    );
    let missed = frames.iter().filter(|frame| frame.missed).count();
    canvas.finish(
        [WIDTH, height],
        "Frame timing",
        &format!("Intervals of {} frames, of which {missed} were missed, and when they were missed.", frames.len()),
    )
}

fn draw_histogram(canvas: &mut Canvas, corner: [f64; 2], size: [f64; 2], intervals_s: &[f64], refresh_hz: Option<f64>) {
    let nominal_ms = nominal_ms(refresh_hz);
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

/// Columns of the timeline: about one for every two pixels.
const COLUMNS: usize = 150;

/// The longest and shortest interval over time; missed frames stand out at their own intervals.
fn draw_timeline(canvas: &mut Canvas, corner: [f64; 2], size: [f64; 2], frames: &[Frame], refresh_hz: Option<f64>) {
    let times = frames.iter().map(|frame| frame.presented_s).filter(|t| drawable(*t));
    let (from, to) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
    let (from, to) = if from < to { (from, to) } else { (0.0, 1.0) };
    // Long sessions are read in minutes.
    let (unit, scale) = if to - from > 180.0 { ("min", 1.0 / 60.0) } else { ("s", 1.0) };
    let column = |t: f64| (((t - from) / (to - from) * COLUMNS as f64) as usize).min(COLUMNS - 1);
    let mut extremes = vec![[f64::INFINITY, f64::NEG_INFINITY]; COLUMNS];
    // The longest interval that ended in a missed frame, and whether there was any missed frame.
    let mut missed: Vec<Option<f64>> = vec![None; COLUMNS];
    for (index, frame) in frames.iter().enumerate().filter(|(_, frame)| drawable(frame.presented_s)) {
        let before = index.checked_sub(1).map(|before| frames[before].presented_s);
        let interval = before.filter(|_| !frame.after_gap).map(|t| 1000.0 * (frame.presented_s - t));
        let interval = interval.filter(|dt| drawable(*dt) && *dt > 0.0);
        let at = column(frame.presented_s);
        if let Some(dt) = interval {
            extremes[at] = [extremes[at][0].min(dt), extremes[at][1].max(dt)];
        }
        if frame.missed {
            missed[at] = Some(missed[at].unwrap_or(0.0).max(interval.unwrap_or(0.0)));
        }
    }
    let nominal = nominal_ms(refresh_hz);
    let longest = extremes.iter().map(|e| e[1]).fold(nominal.unwrap_or(1.0), f64::max);
    let panel = Panel::new(
        corner,
        size,
        Axis::linear(format!("Time in session ({unit})"), from * scale, to * scale).with_ticks(5),
        Axis::linear("Interval (ms)", 0.0, 1.1 * longest).with_ticks(5),
    );
    panel.draw_grid(canvas);
    panel.draw(canvas, |canvas| {
        let wide = size[0] / COLUMNS as f64;
        let x = |column: usize| corner[0] + wide * column as f64;
        let bars: Vec<([f64; 2], [f64; 2])> = extremes
            .iter()
            .enumerate()
            .filter(|(_, [low, high])| low <= high)
            .map(|(i, [low, high])| {
                let [top, bottom] = [high, low].map(|dt| panel.px(0.0, *dt)[1]);
                ([x(i), top - 0.6], [wide, bottom - top + 1.2])
            })
            .collect();
        canvas.rects(&bars, &Paint::fill(BLUE).opacity(0.85));
        if let Some(nominal) = nominal {
            let y = panel.px(0.0, nominal)[1];
            canvas.line([corner[0], y], [corner[0] + size[0], y], &Paint::ink(1.0).dashed("4 3"));
        }
        for (i, longest) in missed.iter().enumerate().filter_map(|(i, dt)| Some((i, (*dt)?))) {
            canvas.circle(
                [x(i) + 0.5 * wide, panel.px(0.0, longest)[1].min(corner[1] + size[1] - 3.0)],
                2.6,
                &Paint::fill(VERMILION),
            );
        }
    });
    panel.draw_axes(canvas, [true, true]);
    let missed = frames.iter().filter(|frame| frame.missed).count();
    panel.draw_heading(canvas, "Timeline", &format!("{missed} of {} missed", frames.len()));
}

fn nominal_ms(refresh_hz: Option<f64>) -> Option<f64> {
    refresh_hz.filter(|hz| drawable(*hz) && *hz > 1e-6).map(|hz| 1000.0 / hz)
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
