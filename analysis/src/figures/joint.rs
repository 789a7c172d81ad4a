//! The joint posterior of m and omega0: how far slope and intercept of a MAR line trade against each other.

use super::density::{Density, marginal};
use super::parts::{Mark, capped, color, diamond, drawable, keys, left_out, line, nothing, remark, sentences};
use super::{WIDTH, significant};
use crate::numerics::{quantile_of_sorted, sorted_finite};
use crate::svg::{Axis, Canvas, Paint, Panel};
use serde::{Deserialize, Serialize};

/// One posterior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointPosterior {
    /// Observer or group.
    pub name: String,
    /// Equally weighted draws of (m in degrees per cycle per degree, omega0 in degrees per cycle).
    pub draws: Vec<[f64; 2]>,
    /// The point estimate of both.
    pub estimate: Option<[f64; 2]>,
}

/// Posteriors drawn at most.
const MOST: usize = 21;
const TITLE: &str = "Joint posterior of m and ω₀";

/// Regions of 50 % and 95 % of the posterior of (m, omega0), the smallest ones that hold as much, with the point estimates
/// and, at the sides, the densities of each. By a Gaussian kernel along and across the draws (Scott's rule).
#[must_use]
pub fn joint_posterior(posteriors: &[JointPosterior]) -> String {
    let mut bad = 0;
    let shown: Vec<Drawn<'_>> = posteriors
        .iter()
        .take(MOST)
        .map(|posterior| {
            let good: Vec<[f64; 2]> =
                posterior.draws.iter().copied().filter(|d| d.iter().all(|v| drawable(*v) && *v >= 0.0)).collect();
            bad += posterior.draws.len() - good.len();
            let regions = Density::new(&good).map(|density| [0.95, 0.5].map(|share| density.contour(share)));
            Drawn { posterior, draws: good, regions }
        })
        .filter(|drawn| !drawn.draws.is_empty())
        .collect();
    if shown.is_empty() {
        return nothing(TITLE, "no posterior has a draw");
    }
    let axis = |label: &str, i: usize| {
        let ends = shown.iter().flat_map(|Drawn { posterior, draws, regions }| {
            let sorted = sorted_finite(draws.iter().map(|d| d[i]));
            // A few draws far out would make everything else small.
            let mut ends = [0.005, 0.995].map(|q| quantile_of_sorted(&sorted, q).unwrap_or(0.0)).to_vec();
            ends.extend(regions.iter().flat_map(|[outer, _]| outer).flatten().map(|point| point[i].max(0.0)));
            ends.extend(posterior.estimate.map(|estimate| estimate[i]));
            ends
        });
        Axis::over(label, ends.collect::<Vec<_>>(), false)
    };
    let positive = |axis: Axis| if axis.range()[0] < 0.0 { axis.starting_at_zero() } else { axis };
    let x = positive(axis("Slope m (degrees per cycle per degree)", 0)).with_ticks(7);
    let y = positive(axis("ω₀ (degrees per cycle)", 1)).with_ticks(7);

    let mut canvas = Canvas::default();
    let (tall, side) = (300.0, 84.0);
    let left = Panel::margin(&y, tall);
    let width = WIDTH - left - 20.0 - side - 10.0;
    let mut entries: Vec<(String, Mark)> = Vec::new();
    if shown.len() > 1 || !shown[0].posterior.name.is_empty() {
        entries.extend(shown.iter().enumerate().map(|(i, d)| (d.posterior.name.clone(), Mark::Line(line(i, 1.8)))));
    }
    entries.push(("50 % and 95 % of the posterior".to_owned(), Mark::LineInBand(Paint::muted(1.6))));
    if shown.iter().any(|drawn| drawn.posterior.estimate.is_some()) {
        entries.push(("estimate".to_owned(), Mark::Diamond));
    }
    let top = keys(&mut canvas, left, &entries) + 4.0;
    let main = Panel::new([left, top + side + 10.0], [width, tall], x, y);
    main.draw_grid(&mut canvas);
    main.draw(&mut canvas, |canvas| {
        for (index, drawn) in shown.iter().enumerate() {
            draw_regions(canvas, &main, drawn, index);
        }
        for Drawn { posterior, .. } in &shown {
            if let Some([m, omega0]) = posterior.estimate.filter(|e| e.iter().all(|v| drawable(*v))) {
                diamond(canvas, main.px(m, omega0), 5.0);
            }
        }
    });
    main.draw_axes(&mut canvas, [true, true]);
    draw_sides(&mut canvas, &main, &shown, top, side);

    let thin = shown.iter().filter(|drawn| drawn.regions.is_none()).count();
    let thin = match thin {
        0 => String::new(),
        1 => "The draws of one posterior are too few or without spread: they are drawn as points.".to_owned(),
        n => format!("The draws of {n} posteriors are too few or without spread: they are drawn as points."),
    };
    let more = posteriors.len().saturating_sub(MOST);
    let more = if more > 0 { format!("{more} further posteriors are not drawn.") } else { String::new() };
    let note = sentences(&[&thin, &left_out(bad, "draw"), &more]);
    let bottom = remark(&mut canvas, main.corner[1] + tall + 56.0, &note);
    canvas.finish([WIDTH, bottom], TITLE, &described(&shown))
}

/// A posterior with its draws that can be drawn, and the rings around its 95 % and its 50 % if they have a density.
struct Drawn<'a> {
    posterior: &'a JointPosterior,
    draws: Vec<[f64; 2]>,
    regions: Option<[Vec<Vec<[f64; 2]>>; 2]>,
}

fn described(shown: &[Drawn<'_>]) -> String {
    let mut text = "Regions that hold 50 % and 95 % of the posterior of slope and intercept.".to_owned();
    for Drawn { posterior, draws, .. } in shown {
        let estimate = posterior.estimate.map_or_else(String::new, |[m, omega0]| {
            format!(", estimate m = {}, omega0 = {}", significant(m), significant(omega0))
        });
        text.push_str(&format!(" {}: {} draws{estimate}.", posterior.name, draws.len()));
    }
    text
}

fn draw_regions(canvas: &mut Canvas, panel: &Panel, drawn: &Drawn<'_>, index: usize) {
    let color = color(index);
    let Some(regions) = &drawn.regions else {
        let dot = Paint::fill(color).opacity(0.5);
        drawn.draws.iter().take(500).for_each(|d| canvas.circle(panel.px(d[0], d[1]), 2.4, &dot));
        return;
    };
    for (rings, opacity) in regions.iter().zip([0.13, 0.24]) {
        let rings: Vec<Vec<[f64; 2]>> =
            rings.iter().map(|ring| ring.iter().map(|[m, omega0]| panel.px(*m, *omega0)).collect()).collect();
        canvas.rings(&rings, &Paint::fill(color).opacity(opacity));
        for mut ring in rings {
            ring.extend(ring.first().copied());
            canvas.polyline(&ring, &line(index, 1.5));
        }
    }
}

/// Densities of m above the panel and of omega0 to its right, with the central 95 % of each along the panel's edge.
fn draw_sides(canvas: &mut Canvas, main: &Panel, shown: &[Drawn<'_>], top: f64, side: f64) {
    let right = main.corner[0] + main.size[0] + 10.0;
    // Room for the intervals between the panel and the densities.
    let foot = 5.0 * shown.len().min(6) as f64 + 4.0;
    for i in 0..2 {
        let axis = if i == 0 { &main.x } else { &main.y };
        let places = axis.steps(160);
        let curves: Vec<(usize, Vec<f64>)> = shown
            .iter()
            .enumerate()
            .filter_map(|(index, drawn)| {
                let values: Vec<f64> = drawn.draws.iter().map(|d| d[i]).collect();
                Some((index, marginal(&values, &places)?))
            })
            .collect();
        let most = curves.iter().flat_map(|(_, density)| density).copied().fold(0.0, f64::max);
        let room = side - foot;
        let at = |place: f64, height: f64| {
            if i == 0 {
                [main.corner[0] + main.size[0] * axis.place(place), top + side - foot - room * height]
            } else {
                [right + foot + room * height, main.corner[1] + main.size[1] * (1.0 - axis.place(place))]
            }
        };
        for (index, density) in curves {
            let curve: Vec<[f64; 2]> = places.iter().zip(&density).map(|(&p, d)| at(p, d / most.max(1e-300))).collect();
            let mut area = curve.clone();
            area.extend([at(places[places.len() - 1], 0.0), at(places[0], 0.0)]);
            canvas.polygon(&area, &Paint::fill(color(index)).opacity(0.13));
            canvas.polyline(&curve, &line(index, 1.5));
        }
        for (index, drawn) in shown.iter().enumerate().take(6) {
            let sorted = sorted_finite(drawn.draws.iter().map(|d| d[i]));
            let [low, high] = [0.025, 0.975].map(|q| quantile_of_sorted(&sorted, q).unwrap_or(0.0));
            let [low, high] = [low, high].map(|v| v.clamp(axis.range()[0], axis.range()[1]));
            let shift = 5.0 * index as f64 + 3.0;
            let inset = |[x, y]: [f64; 2]| if i == 0 { [x, y + shift] } else { [x - shift, y] };
            capped(canvas, inset(at(low, 0.0)), inset(at(high, 0.0)), 2.0, &Paint::stroke(color(index), 1.6));
        }
    }
}
