//! Interaction plots: cell means of a factorial design with within-subject intervals.

use super::parts::{
    Mark, Multiples, capped, color, drawable, drawable_interval, keys, left_out, line, nothing, remark, sentences,
};
use super::{WIDTH, significant};
use crate::svg::{Anchor, Axis, Canvas, Paint, Panel, TextStyle, shortened, text_width};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The mean of one cell, in the unit of the plot's label.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CellMean {
    /// The mean over observers.
    pub mean: f64,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
}

/// The cells of one level of the factor that lines stand for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InteractionLine {
    /// The level's name.
    pub name: String,
    /// One cell for each level of the horizontal factor; `None` where the design has none.
    pub cells: Vec<Option<CellMean>>,
}

/// One panel: one level of a third factor, or the whole design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InteractionPanel {
    /// The level's name; may be empty for one panel.
    pub name: String,
    /// One line for each level of the second factor, the same ones in every panel.
    pub lines: Vec<InteractionLine>,
}

/// What [`interaction`] draws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interaction {
    /// Label of the means with their unit.
    pub label: String,
    /// Name of the horizontal factor.
    pub factor: String,
    /// Its levels.
    pub levels: Vec<String>,
    /// What the intervals are, for example `within-subject 95 % (Cousineau–Morey)`.
    pub interval: String,
    /// The panels.
    pub panels: Vec<InteractionPanel>,
}

const TITLE: &str = "Means by condition";
/// Panels and lines at most.
const MOST: [usize; 2] = [12, 14];

/// Means ± 95 % within-subject intervals after Cousineau (2005) with Morey's correction (2008), one for each column.
///
/// `values[observer][condition]`: every observer must have every condition. An observer's own mean is taken away before the
/// spread of a condition is taken, which is then enlarged by √(C/(C − 1)) for C conditions; the quantile is Student's with
/// n − 1 degrees of freedom. Observers with a missing (not finite) value are left out. Nothing for no complete observer; no
/// intervals for one observer or one condition.
///
/// ```
/// let means = analysis::figures::within_subject_means(&[vec![1.0, 3.0], vec![4.0, 7.0], vec![2.0, 3.0]]);
/// assert!((means[0].mean - 7.0 / 3.0).abs() < 1e-12);
/// // Of two conditions, each interval is that of their difference (mean 2, SD 1) divided by √2.
/// let half = 4.302_652_73 * 1.0 / 3f64.sqrt() / 2f64.sqrt();
/// assert!((means[0].ci95.unwrap()[1] - means[0].mean - half).abs() < 1e-6);
/// ```
#[must_use]
pub fn within_subject_means(values: &[Vec<f64>]) -> Vec<CellMean> {
    let conditions = values.iter().map(Vec::len).max().unwrap_or(0);
    let complete: Vec<&Vec<f64>> =
        values.iter().filter(|row| row.len() == conditions && row.iter().all(|v| v.is_finite())).collect();
    let n = complete.len() as f64;
    if complete.is_empty() {
        return Vec::new();
    }
    let own: Vec<f64> = complete.iter().map(|row| row.iter().sum::<f64>() / conditions as f64).collect();
    let t = StudentsT::new(0.0, 1.0, n - 1.0).ok().filter(|_| n > 1.0 && conditions > 1).map(|t| t.inverse_cdf(0.975));
    let correction = (conditions as f64 / (conditions as f64 - 1.0)).sqrt();
    (0..conditions)
        .map(|condition| {
            let mean = complete.iter().map(|row| row[condition]).sum::<f64>() / n;
            let normalised = || complete.iter().zip(&own).map(|(row, own)| row[condition] - own);
            let centre = normalised().sum::<f64>() / n;
            let ci95 = t.map(|t| {
                let sd = (normalised().map(|v| (v - centre).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
                let half = t * correction * sd / n.sqrt();
                [mean - half, mean + half]
            });
            CellMean { mean, ci95 }
        })
        .collect()
}

/// Means with their intervals over the levels of one factor, a line for each level of a second, a panel for each of a third.
#[must_use]
pub fn interaction(plot: &Interaction) -> String {
    let panels: Vec<&InteractionPanel> = plot.panels.iter().take(MOST[0]).collect();
    let cells = || {
        panels
            .iter()
            .flat_map(|panel| panel.lines.iter().take(MOST[1]))
            .flat_map(|line| line.cells.iter().take(plot.levels.len()))
            .flatten()
    };
    let bad = cells().filter(|cell| !drawable(cell.mean)).count();
    let values: Vec<f64> = cells()
        .filter(|cell| drawable(cell.mean))
        .flat_map(|cell| [cell.mean].into_iter().chain(cell.ci95.and_then(drawable_interval).into_iter().flatten()))
        .collect();
    if values.is_empty() {
        return nothing(TITLE, "no condition has a mean");
    }
    let axis = |label: &str| Axis::over(label, values.iter().copied(), false).with_ticks(6);
    let columns = if plot.levels.len() > 6 { 1 } else { Multiples::columns(panels.len()) };
    let tall = if panels.len() > 1 { 180.0 } else { 280.0 };

    let mut canvas = Canvas::default();
    let named = panels.iter().max_by_key(|panel| panel.lines.len());
    let mut entries: Vec<(String, Mark)> = named
        .iter()
        .flat_map(|panel| panel.lines.iter().take(MOST[1]).enumerate())
        .filter(|(_, line)| !line.name.is_empty())
        .map(|(i, level)| (level.name.clone(), Mark::LineWithDot(line(i, 1.8))))
        .collect();
    if cells().any(|cell| cell.ci95.is_some()) && !plot.interval.is_empty() {
        entries.push((plot.interval.clone(), Mark::Standing(Paint::muted(1.4))));
    }
    let margin = Panel::margin(&axis(&plot.label), tall).max(54.0);
    let top = keys(&mut canvas, margin, &entries) + if panels.len() > 1 { 24.0 } else { 6.0 };
    let multiples = Multiples::new(panels.len(), columns, top, tall, &axis(&plot.label));
    let slots = plot.levels.len().max(1) as f64;
    for (index, panel) in panels.iter().enumerate() {
        let frame = Panel::new(
            multiples.corner(index),
            multiples.size,
            Axis::linear("", 0.0, slots),
            axis(if multiples.is_left(index) { &plot.label } else { "" }),
        );
        draw_panel(&mut canvas, &frame, panel, panel.lines.len().min(MOST[1]), multiples.is_left(index));
        draw_levels(&mut canvas, &frame, plot);
        if panels.len() > 1 {
            frame.draw_heading(&mut canvas, &panel.name, "");
        }
    }
    multiples.draw_label(&mut canvas, &plot.factor);
    let more = plot.panels.len() - panels.len();
    let more = if more > 0 { format!("{more} further panels are not drawn.") } else { String::new() };
    let bottom = remark(&mut canvas, multiples.bottom(), &sentences(&[&left_out(bad, "mean"), &more]));
    canvas.finish([WIDTH, bottom], TITLE, &described(plot))
}

fn draw_panel(canvas: &mut Canvas, frame: &Panel, panel: &InteractionPanel, lines: usize, numbered: bool) {
    for (value, _) in frame.y.ticks() {
        let y = frame.px(0.0, value)[1];
        canvas.line([frame.corner[0], y], [frame.corner[0] + frame.size[0], y], &Paint::grid());
    }
    let slots = frame.x.range()[1];
    frame.draw(canvas, |canvas| {
        for (i, level) in panel.lines.iter().take(lines).enumerate() {
            // Intervals of different lines stand beside each other within half a slot.
            let shift = (0.5 * frame.size[0] / slots / lines as f64).min(9.0) * (i as f64 - 0.5 * (lines - 1) as f64);
            let at = |slot: usize, value: f64| {
                let [x, y] = frame.px(slot as f64 + 0.5, value);
                [x + shift, y]
            };
            let good: Vec<(usize, CellMean)> = level
                .cells
                .iter()
                .take(slots as usize)
                .enumerate()
                .filter_map(|(slot, cell)| Some((slot, (*cell)?)))
                .filter(|(_, cell)| drawable(cell.mean))
                .collect();
            let joined: Vec<[f64; 2]> = good.iter().map(|(slot, cell)| at(*slot, cell.mean)).collect();
            canvas.polyline(&joined, &line(i, 1.8));
            for (slot, cell) in good {
                if let Some([low, high]) = cell.ci95.and_then(drawable_interval) {
                    capped(canvas, at(slot, low), at(slot, high), 3.0, &Paint::stroke(color(i), 1.5));
                }
                canvas.circle(at(slot, cell.mean), 3.8, &Paint::fill(color(i)));
            }
        }
    });
    frame.draw_frame(canvas, numbered);
}

fn draw_levels(canvas: &mut Canvas, frame: &Panel, plot: &Interaction) {
    let slot = frame.size[0] / plot.levels.len().max(1) as f64;
    let bottom = frame.corner[1] + frame.size[1];
    // Where not every name has room, every second (third, …) is written.
    let widest = plot.levels.iter().map(|level| text_width(level, 12.0)).fold(0.0, f64::max);
    let every = ((widest.min(110.0) + 8.0) / slot).ceil().max(1.0) as usize;
    for (i, level) in plot.levels.iter().enumerate() {
        let x = frame.corner[0] + (i as f64 + 0.5) * slot;
        canvas.line([x, bottom], [x, bottom + 4.0], &Paint::ink(1.0));
        if i % every == 0 {
            // The first and the last name stay within the panel and half its gap.
            let edge = (x - frame.corner[0]).min(frame.corner[0] + frame.size[0] - x);
            let text = shortened(level, 12.0, (every as f64 * slot - 6.0).min(2.0 * edge + 14.0));
            canvas.text([x, bottom + 18.0], &text, TextStyle::new(12.0, Anchor::Middle).muted());
        }
    }
}

fn described(plot: &Interaction) -> String {
    let mut text = format!("{} by {}.", plot.label, plot.factor);
    for panel in plot.panels.iter().take(4) {
        for level in panel.lines.iter().take(4) {
            let means: Vec<String> = level
                .cells
                .iter()
                .take(8)
                .map(|cell| cell.map_or("none".to_owned(), |c| significant(c.mean)))
                .collect();
            text.push_str(&format!(" {} {}: {}.", panel.name, level.name, means.join(", ")));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `tests/peers/figures_peer.py`: numpy 2.4.6 and scipy 1.17.1.
    #[test]
    fn intervals_are_those_of_another_program() {
        let rows =
            [[3.0, 4.5, 5.0], [1.0, 2.0, 4.5], [4.0, 4.0, 6.5], [2.5, 3.5, 3.0], [5.0, 7.0, 7.5], [f64::NAN, 9.0, 9.0]];
        let means = within_subject_means(&rows.map(|row| row.to_vec()));
        let expected = [(3.1, 0.660_926_133_484_939), (4.2, 0.948_336_543_245_043), (5.3, 1.183_386_784_485_72)];
        assert_eq!(means.len(), 3);
        for (found, (mean, half)) in means.iter().zip(expected) {
            assert!((found.mean - mean).abs() < 1e-12, "{found:?}");
            assert!((found.ci95.unwrap()[1] - mean - half).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn one_observer_or_one_condition_has_no_interval() {
        assert_eq!(within_subject_means(&[vec![1.0, 2.0]])[0], CellMean { mean: 1.0, ci95: None });
        assert_eq!(within_subject_means(&[vec![1.0], vec![3.0]])[0], CellMean { mean: 2.0, ci95: None });
        assert!(within_subject_means(&[vec![f64::NAN]]).is_empty());
    }
}
