//! The figure of a power analysis: how error and intervals shrink with trials and with observers.

use super::{Point, Power, QuantityPower};
use crate::figures::WIDTH;
use crate::svg::{Anchor, Axis, BLUE, Canvas, GREEN, Paint, Panel, TextStyle, legend};

const PANEL_HEIGHT: f64 = 170.0;
const LEFT: f64 = 84.0;
const GAP: f64 = 96.0;

/// For each quantity, the root mean square error and half the width of the 95 % interval, by trials of one observer (left)
/// and by observers of a whole study (right), with the coverage of the intervals written at their points.
#[must_use]
pub fn power_figure(power: &Power) -> String {
    let mut canvas = Canvas::default();
    let width = 0.5 * (WIDTH - LEFT - GAP - 24.0);
    let error: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.line([x - 8.0, y], [x + 12.0, y], &Paint::stroke(BLUE, 2.0));
        canvas.circle([x + 2.0, y], 3.6, &Paint::fill(BLUE));
    };
    let interval: &dyn Fn(&mut Canvas, [f64; 2]) = &|canvas, [x, y]| {
        canvas.line([x - 8.0, y], [x + 12.0, y], &Paint::stroke(GREEN, 2.0).dashed("5 3"));
        canvas.circle([x + 2.0, y], 3.6, &Paint::hollow(GREEN, 1.6));
    };
    let entries = [
        ("root mean square error (SD where there is no truth)", error),
        ("half the 95 % interval; the number is its coverage", interval),
    ];
    let used = legend(&mut canvas, [LEFT, 22.0], WIDTH - LEFT - 24.0, &entries);
    let mut top = 22.0 + used + 26.0;
    for quantity in &power.quantities {
        let label = labelled(quantity);
        for (column, (points, x_label, x_of)) in [
            (&quantity.by_trials, "Trials of one observer", trials as fn(&Point) -> f64),
            (&quantity.by_observers, "Observers", observers as fn(&Point) -> f64),
        ]
        .into_iter()
        .enumerate()
        {
            let corner = [LEFT + column as f64 * (width + GAP), top];
            draw(&mut canvas, corner, width, points, [&label, x_label], x_of);
        }
        let heading = TextStyle::new(13.0, Anchor::Start).bold();
        canvas.text([LEFT, top - 12.0], &quantity.quantity.label, heading);
        top += PANEL_HEIGHT + 92.0;
    }
    canvas.finish(
        [WIDTH, top - 20.0],
        "What the design can be expected to give",
        "Root mean square error and half the 95 % interval of each estimate, by trials and by observers, from simulated \
         studies.",
    )
}

fn labelled(quantity: &QuantityPower) -> String {
    let unit = &quantity.quantity.unit;
    if unit.is_empty() { "Error".to_owned() } else { format!("Error ({unit})") }
}

fn trials(point: &Point) -> f64 {
    point.trials as f64
}

fn observers(point: &Point) -> f64 {
    f64::from(point.observers)
}

fn draw(
    canvas: &mut Canvas,
    corner: [f64; 2],
    width: f64,
    points: &[Point],
    labels: [&str; 2],
    x_of: fn(&Point) -> f64,
) {
    let error = |point: &Point| Some(point.rmse.unwrap_or(point.sd)).filter(|x| x.is_finite());
    let half = |point: &Point| point.ci_width.map(|width| 0.5 * width);
    // A t interval of two observers is so wide that it would hide everything else.
    let shown = |point: &&Point| point.observers != 2 || points.len() < 3;
    let high = points.iter().filter(shown).flat_map(|p| [error(p), half(p)]).flatten().fold(0.0, f64::max);
    let most = points.iter().map(x_of).fold(1.0, f64::max);
    let panel = Panel::new(
        corner,
        [width, PANEL_HEIGHT],
        Axis::linear(labels[1], 0.0, 1.12 * most).with_ticks(6),
        Axis::linear(labels[0], 0.0, 1.25 * high).with_ticks(5),
    );
    panel.draw_grid(canvas);
    panel.draw(canvas, |canvas| {
        let line = |value: &dyn Fn(&Point) -> Option<f64>| -> Vec<[f64; 2]> {
            points.iter().filter_map(|point| Some(panel.px(x_of(point), value(point)?))).collect()
        };
        let errors = line(&error);
        canvas.polyline(&errors, &Paint::stroke(BLUE, 2.0));
        let halves = line(&half);
        canvas.polyline(&halves, &Paint::stroke(GREEN, 2.0).dashed("5 3"));
        errors.iter().for_each(|&at| canvas.circle(at, 3.6, &Paint::fill(BLUE)));
        halves.iter().for_each(|&at| canvas.circle(at, 3.6, &Paint::hollow(GREEN, 1.6)));
        for point in points.iter().filter(shown) {
            if let (Some(half), Some(coverage)) = (half(point), point.coverage) {
                let [x, y] = panel.px(x_of(point), half);
                let style = TextStyle::new(11.0, Anchor::Middle).muted();
                canvas.text([x, y - 9.0], &format!("{:.0} %", 100.0 * coverage), style);
            }
        }
    });
    panel.draw_axes(canvas, [true, true]);
}
