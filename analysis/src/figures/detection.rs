//! Shares of right answers by level, with the fitted function; one panel for each part of a block.

use super::{WIDTH, significant};
use crate::answers::{Detection, DetectionPart, part_name};
use crate::psychometric::{PsychometricFit, Scale};
use crate::svg::{Axis, BLUE, Canvas, GREEN, PALETTE, Paint, Panel, legend};

/// Parts drawn at most; the tables hold all.
const MOST_PANELS: usize = 9;

/// Right answers by level with Wilson intervals: against the one parameter that varies, with the fitted function and its
/// threshold; against the second of several, coloured by the first.
#[must_use]
pub fn detection(detection: &Detection) -> String {
    let parts: Vec<&DetectionPart> = detection.parts.iter().take(MOST_PANELS).collect();
    let columns = match parts.len() {
        0 | 1 => 1,
        2 | 4 => 2,
        _ => 3,
    };
    let (left, gap) = (66.0, [16.0, 78.0]);
    let width = ((WIDTH - left - 18.0 - gap[0] * (columns - 1) as f64) / columns as f64).min(420.0);
    let height = 160.0;
    let parameter = detection.parameters.last().map_or("", String::as_str);
    let groups = colours(detection);

    let mut canvas = Canvas::default();
    let top = 22.0 + draw_legend(&mut canvas, left, detection, &groups) + 26.0;
    let rows = parts.len().div_ceil(columns).max(1);
    for (index, part) in parts.iter().enumerate() {
        let (row, column) = (index / columns, index % columns);
        let label = if index + columns >= parts.len() { parameter } else { "" };
        let panel = Panel::new(
            [left + column as f64 * (width + gap[0]), top + row as f64 * (height + gap[1])],
            [width, height],
            axis(label, detection, parameter),
            Axis::linear(if column == 0 { "Share right" } else { "" }, -0.05, 1.05).with_ticks(5).in_percent(),
        );
        panel.draw_grid(&mut canvas);
        panel.draw(&mut canvas, |canvas| draw_part(canvas, &panel, part, detection, &groups));
        panel.draw_axes(&mut canvas, [true, column == 0]);
        panel.draw_heading(&mut canvas, &shortened(&part_name(&part.by), width), &format!("n = {}", part.right.n));
    }
    canvas.finish(
        [WIDTH, top + rows as f64 * (height + gap[1]) - gap[1] + 56.0],
        "Right answers by level",
        "Share of right answers at each level with 95 % Wilson intervals, and the fitted psychometric function.",
    )
}

/// A heading that leaves room for the number of trials.
fn shortened(text: &str, width: f64) -> String {
    let most = ((width - 60.0) / 7.5).max(8.0) as usize;
    if text.chars().count() <= most { text.to_owned() } else { text.chars().take(most - 1).chain(['…']).collect() }
}

fn axis(label: &str, detection: &Detection, parameter: &str) -> Axis {
    let mut values: Vec<f64> = detection
        .parts
        .iter()
        .flat_map(|part| &part.cells)
        .filter_map(|cell| cell.level.get(parameter).copied())
        .collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(1.0));
    if Scale::of_levels(&values) == Scale::Logarithmic {
        let room = (high / low).powf(0.07);
        Axis::logarithmic(label, low / room, high * room).with_ticks(5)
    } else {
        let room = 0.07 * (high - low).max(1e-9);
        Axis::linear(label, low - room, high + room).with_ticks(6)
    }
}

/// The values of all parameters but the last, each with its colour; one without values where one parameter varies.
fn colours(detection: &Detection) -> Vec<(Vec<f64>, &'static str)> {
    let mut found: Vec<Vec<f64>> = Vec::new();
    for cell in detection.parts.first().iter().flat_map(|part| &part.cells) {
        let key = key(detection, cell);
        if !found.contains(&key) {
            found.push(key);
        }
    }
    found.into_iter().enumerate().map(|(i, key)| (key, PALETTE[i % PALETTE.len()])).collect()
}

fn key(detection: &Detection, cell: &crate::answers::LevelCell) -> Vec<f64> {
    let others = detection.parameters.split_last().map_or(&[][..], |(_, others)| others);
    others.iter().filter_map(|name| cell.level.get(name).copied()).collect()
}

fn draw_part(
    canvas: &mut Canvas,
    panel: &Panel,
    part: &DetectionPart,
    detection: &Detection,
    groups: &[(Vec<f64>, &str)],
) {
    if let Some(fit) = &part.fit {
        draw_fit(canvas, panel, fit);
    }
    let parameter = detection.parameters.last().map_or("", String::as_str);
    for (index, (group, color)) in groups.iter().enumerate() {
        // Intervals of several colours stand side by side.
        let shift = if groups.len() > 1 { 5.0 * (index as f64 - 0.5 * (groups.len() - 1) as f64) } else { 0.0 };
        let mut line = Vec::new();
        for cell in part.cells.iter().filter(|cell| key(detection, cell) == *group) {
            let x = cell.level.get(parameter).copied().unwrap_or(0.0);
            let at = |share: f64| {
                let [x, y] = panel.px(x, share);
                [x + shift, y]
            };
            let [low, high] = cell.right.wilson95.map(at);
            if groups.len() > 1 {
                canvas.line(low, high, &Paint::stroke(color, 1.6));
                canvas.circle(at(cell.right.share), 3.6, &Paint::fill(color));
                line.push(at(cell.right.share));
            } else {
                canvas.line(low, high, &Paint::ink(1.4));
                canvas.circle(at(cell.right.share), 3.8, &Paint { class: "ink-dot", ..Paint::fill("#1b1f24") });
            }
        }
        canvas.polyline(&line, &Paint::stroke(color, 1.2).opacity(0.6));
    }
}

fn draw_fit(canvas: &mut Canvas, panel: &Panel, fit: &PsychometricFit) {
    let (top, bottom) = (panel.corner[1], panel.corner[1] + panel.size[1]);
    let [low, high] = fit.threshold.ci95.map(|level| panel.px(level, 0.0)[0]);
    canvas.rect([low, top], [high - low, bottom - top], &Paint::fill(GREEN).opacity(0.14));
    let at = panel.px(fit.threshold.estimate, 0.0)[0];
    canvas.line([at, top], [at, bottom], &Paint::stroke(GREEN, 1.4));
    let curve: Vec<[f64; 2]> = panel.x.steps(60).iter().map(|&x| panel.px(x, fit.probability(x))).collect();
    // A function that the data do not support is drawn as what it is.
    let paint = Paint::stroke(BLUE, 2.0);
    canvas.polyline(&curve, &if fit.support.is_supported() { paint } else { paint.dashed("5 4") });
}

fn draw_legend(canvas: &mut Canvas, left: f64, detection: &Detection, groups: &[(Vec<f64>, &'static str)]) -> f64 {
    type Mark = Box<dyn Fn(&mut Canvas, [f64; 2])>;
    let mut entries: Vec<(String, Mark)> = Vec::new();
    if groups.len() > 1 {
        for (group, color) in groups {
            let color = *color;
            let names =
                detection.parameters.iter().zip(group).map(|(name, value)| format!("{name} {}", significant(*value)));
            let mark: Mark = Box::new(move |canvas, at| canvas.circle(at, 4.0, &Paint::fill(color)));
            entries.push((names.collect::<Vec<_>>().join(", "), mark));
        }
    } else {
        let mark: Mark = Box::new(|canvas, [x, y]| {
            canvas.line([x, y - 8.0], [x, y + 8.0], &Paint::ink(1.4));
            canvas.circle([x, y], 3.8, &Paint { class: "ink-dot", ..Paint::fill("#1b1f24") });
        });
        entries.push(("share right, 95 % (Wilson)".to_owned(), mark));
    }
    if detection.parts.iter().any(|part| part.fit.is_some()) {
        let curve: Mark =
            Box::new(|canvas, [x, y]| canvas.line([x - 11.0, y], [x + 11.0, y], &Paint::stroke(BLUE, 2.0)));
        let threshold: Mark = Box::new(|canvas, [x, y]| {
            canvas.rect([x - 7.0, y - 8.0], [14.0, 16.0], &Paint::fill(GREEN).opacity(0.2));
            canvas.line([x, y - 8.0], [x, y + 8.0], &Paint::stroke(GREEN, 1.6));
        });
        entries.push(("fitted function".to_owned(), curve));
        entries.push(("threshold, 95 %".to_owned(), threshold));
    }
    let entries: Vec<_> = entries.iter().map(|(text, mark)| (text.as_str(), mark.as_ref())).collect();
    legend(canvas, [left, 22.0], WIDTH - left - 18.0, &entries)
}
