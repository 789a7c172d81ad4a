//! Tolerable blur by eccentricity: how far it depends on what is seen (after Tursun 2019, Fig. 7).

use super::boxes::{BoxStats, Whiskers, draw_box};
use super::parts::{Mark, drawable, keys, left_out, nothing, remark, sentences};
use super::{WIDTH, significant};
use crate::svg::{Axis, BLUE, Canvas, GREEN, PALETTE, Paint, Panel, VERMILION, shortened};
use serde::{Deserialize, Serialize};

/// The blur of one patch by eccentricity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PatchBlur {
    /// The patch.
    pub patch: String,
    /// (eccentricity in degrees, blur in the unit of the view's label), in any order.
    pub points: Vec<[f64; 2]>,
}

const TITLE: &str = "Tolerable blur by eccentricity and patch";
/// Eccentricities at most.
const MOST: usize = 60;

/// A standing box over all patches at each eccentricity, whiskers to the whole range, with a thin line for each patch; the
/// patches of smallest, median and largest blur at the largest eccentricity are named. `label` is that of the blur with its
/// unit, for example `σ_s (px)`.
#[must_use]
pub fn blur_by_eccentricity(patches: &[PatchBlur], label: &str) -> String {
    let good = |p: &&[f64; 2]| p.iter().all(|v| drawable(*v));
    let mut eccentricities: Vec<f64> =
        patches.iter().flat_map(|patch| &patch.points).filter(good).map(|p| p[0]).collect();
    eccentricities.sort_by(f64::total_cmp);
    eccentricities.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * b.abs().max(1e-9));
    if eccentricities.is_empty() {
        return nothing(TITLE, "no patch has a blur at any eccentricity");
    }
    let more = eccentricities.len().saturating_sub(MOST);
    eccentricities.truncate(MOST);
    let all = patches.iter().map(|patch| patch.points.len()).sum::<usize>();
    let bad = all - patches.iter().flat_map(|patch| &patch.points).filter(good).count();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs().max(1e-9);
    let at_each: Vec<(f64, Vec<(&str, f64)>)> = eccentricities
        .iter()
        .map(|&e| {
            let here = patches.iter().flat_map(|patch| {
                patch.points.iter().filter(good).filter(|p| near(p[0], e)).map(|p| (patch.patch.as_str(), p[1]))
            });
            (e, here.collect())
        })
        .collect();

    let values = at_each.iter().flat_map(|(_, here)| here).map(|(_, blur)| *blur);
    let y = Axis::over(label, values.collect::<Vec<_>>(), false).starting_at_zero().with_ticks(7);
    let step = eccentricities.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let last = eccentricities[eccentricities.len() - 1];
    let step = if step.is_finite() { step } else { 1.0f64.max(0.1 * last.abs()) };
    let x = Axis::linear("Eccentricity (degrees)", eccentricities[0] - 0.6 * step, last + 0.6 * step).with_ticks(10);

    let mut canvas = Canvas::default();
    let tall = 300.0;
    let left = Panel::margin(&y, tall);
    let named = named(&at_each);
    let mut entries: Vec<(String, Mark)> = vec![
        ("median, quartiles, range over patches".to_owned(), Mark::Patch(Paint::fill(BLUE).opacity(0.35))),
        ("one patch".to_owned(), Mark::Line(Paint::muted(1.0).opacity(0.6))),
    ];
    for (what, patch, color) in &named {
        entries.push((format!("{what}: {}", shortened(patch, 12.0, 150.0)), Mark::Line(Paint::stroke(color, 2.0))));
    }
    let top = keys(&mut canvas, left, &entries) + 6.0;
    let panel = Panel::new([left, top], [WIDTH - left - 20.0, tall], x, y);
    panel.draw_grid(&mut canvas);
    panel.draw(&mut canvas, |canvas| {
        for patch in patches {
            let mut points: Vec<&[f64; 2]> = patch.points.iter().filter(good).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let line: Vec<[f64; 2]> = points.iter().map(|p| panel.px(p[0], p[1])).collect();
            let paint =
                named.iter().find(|(_, name, _)| *name == patch.patch).map(|(_, _, color)| Paint::stroke(color, 2.0));
            canvas.polyline(&line, &paint.unwrap_or(Paint::muted(1.0).opacity(0.45)));
        }
        let half = (0.18 * step / (panel.x.range()[1] - panel.x.range()[0]) * panel.size[0]).clamp(2.0, 16.0);
        for (e, here) in &at_each {
            let blurs: Vec<f64> = here.iter().map(|(_, blur)| *blur).collect();
            if let Some(stats) = BoxStats::new(&blurs, Whiskers::Range) {
                let at = |value: f64, across: f64| {
                    let [x, y] = panel.px(*e, value);
                    [x + across, y]
                };
                draw_box(canvas, &stats, half, BLUE, false, &at);
            }
        }
    });
    panel.draw_axes(&mut canvas, [true, true]);
    let more = if more > 0 { format!("{more} further eccentricities are not drawn.") } else { String::new() };
    let bottom = remark(&mut canvas, top + tall + 56.0, &sentences(&[&left_out(bad, "value"), &more]));
    let medians: Vec<String> = at_each
        .iter()
        .filter_map(|(e, here)| {
            let blurs: Vec<f64> = here.iter().map(|(_, blur)| *blur).collect();
            let stats = BoxStats::new(&blurs, Whiskers::Range)?;
            Some(format!("{} at {}°", significant(stats.median), significant(*e)))
        })
        .collect();
    let description =
        format!("{label} of {} patches by eccentricity; medians {}.", patches.len(), crate::text::listed(&medians));
    canvas.finish([WIDTH, bottom], TITLE, &description)
}

/// The patches with the smallest, the median and the largest blur at the largest eccentricity.
fn named<'a>(at_each: &[(f64, Vec<(&'a str, f64)>)]) -> Vec<(&'static str, &'a str, &'static str)> {
    let Some((_, here)) = at_each.last() else { return Vec::new() };
    let mut here = here.clone();
    here.sort_by(|a, b| a.1.total_cmp(&b.1));
    match here.as_slice() {
        [smallest, .., largest] if here.len() > 2 => {
            let median = here[here.len() / 2];
            vec![("smallest", smallest.0, GREEN), ("median", median.0, PALETTE[3]), ("largest", largest.0, VERMILION)]
        }
        _ => Vec::new(),
    }
}
