//! Psychometric functions of any table: answers with Wilson intervals, the fitted curve with its band, threshold and
//! asymptotes.
//!
//! The data are plain, so that one figure serves `fit`, blocks and groups. The function of every eccentricity of a MAR fit
//! is [`super::psychometric_curves`]'s.

use super::parts::{Mark, Multiples, capped, color, drawable_interval, drawable_on, keys, left_out, nothing, remark};
use crate::mar::Estimate;
use crate::shares::Share;
use crate::svg::{Axis, BLUE, Canvas, GREEN, Paint, Panel, shortened};
use serde::{Deserialize, Serialize};

/// Answers at one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LevelCount {
    /// The level, in the unit of the view's label.
    pub level: f64,
    /// Answers of the kind that is counted.
    pub k: usize,
    /// All answers.
    pub n: usize,
}

/// One place of a curve with its pointwise 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BandPoint {
    /// Where: level or eccentricity, in the unit of the figure's horizontal axis.
    pub x: f64,
    /// 2.5 % point of the curve there.
    pub low: f64,
    /// The curve: median or mode.
    pub mid: f64,
    /// 97.5 % point of the curve there.
    pub high: f64,
}

/// One psychometric function with its answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PsychometricCurve {
    /// Group, observer or condition; may be empty where there is one curve only.
    pub name: String,
    /// The answers, in any order.
    pub points: Vec<LevelCount>,
    /// The fitted curve as shares 0–1, sampled ascending in level; empty without a fit.
    pub band: Vec<BandPoint>,
    /// The threshold with its 95 % interval, in the unit of the level.
    pub threshold: Option<Estimate>,
    /// Lower asymptote, 0–1.
    pub guess: Option<f64>,
    /// Distance of the upper asymptote from 1.
    pub lapse: Option<f64>,
    /// False draws the curve dashed: the data do not support it.
    pub supported: bool,
}

/// How psychometric functions are shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PsychometricView {
    /// Label of the level's axis, with its unit.
    pub level_label: String,
    /// Label of the share's axis, for example `Share correct`.
    pub share_label: String,
    /// A logarithmic axis of levels; levels at or below 0 are then left out.
    pub logarithmic: bool,
    /// One panel for each curve instead of one for all.
    pub small_multiples: bool,
}

/// Panels drawn at most; tables hold all.
const MOST_PANELS: usize = 18;
/// Curves overlaid at most.
const MOST_OVERLAID: usize = 7;
const TITLE: &str = "Psychometric functions";

/// Answers by level with 95 % Wilson intervals (area of a point: its number of trials), the fitted curve with its pointwise
/// 95 % band, asymptotes (dotted) and the threshold with its interval along the foot of the panel.
///
/// ```
/// use analysis::figures::{LevelCount, PsychometricCurve, PsychometricView, psychometric_functions};
/// let curve = PsychometricCurve {
///     name: String::new(),
///     points: vec![LevelCount { level: 1.0, k: 11, n: 20 }, LevelCount { level: 2.0, k: 18, n: 20 }],
///     band: Vec::new(),
///     threshold: None,
///     guess: Some(0.5),
///     lapse: None,
///     supported: true,
/// };
/// let view = PsychometricView {
///     level_label: "Contrast (%)".to_owned(),
///     share_label: "Share correct".to_owned(),
///     logarithmic: true,
///     small_multiples: false,
/// };
/// assert!(psychometric_functions(&[curve], &view).starts_with("<svg"));
/// ```
#[must_use]
pub fn psychometric_functions(curves: &[PsychometricCurve], view: &PsychometricView) -> String {
    let level_drawable = |level: f64| drawable_on(level, view.logarithmic);
    let most = if view.small_multiples { MOST_PANELS } else { MOST_OVERLAID };
    let shown: Vec<&PsychometricCurve> = curves.iter().take(most).collect();
    let answers = || shown.iter().flat_map(|curve| &curve.points);
    let bad = answers().filter(|point| point.n == 0 || !level_drawable(point.level)).count();
    let levels = answers().filter(|point| point.n > 0).map(|point| point.level).filter(|level| level_drawable(*level));
    let sampled = shown.iter().flat_map(|curve| &curve.band).map(|point| point.x).filter(|x| level_drawable(*x));
    let mut extent: Vec<f64> = levels.collect();
    if extent.is_empty() {
        extent = sampled.collect();
    }
    if extent.is_empty() {
        return nothing(TITLE, "no answers at levels that can be drawn");
    }
    // A threshold outside the levels is shown, unless it is so far off that the levels would shrink to a point.
    let tested = Axis::over("", extent.iter().copied(), view.logarithmic);
    let near = |level: &f64| level_drawable(*level) && (-0.6..1.6).contains(&tested.place(*level));
    extent.extend(shown.iter().filter_map(|curve| curve.threshold).map(|t| t.estimate).filter(near));

    let panels = if view.small_multiples { shown.len() } else { 1 };
    let strips = if view.small_multiples { 1 } else { shown.iter().filter(|c| c.threshold.is_some()).count() };
    let tall = if panels > 1 { 170.0 } else { 300.0 };
    // The foot of the panel holds one row for each threshold.
    let foot = (12.0 + 9.0 * strips as f64) / tall;
    let y = |label: &str| Axis::linear(label, -1.05 * foot / (1.0 - foot), 1.05).with_ticks(6).in_percent();
    let x = |label: &str| Axis::over(label, extent.iter().copied(), view.logarithmic).with_ticks(8);
    let (mut canvas, legend_left) = (Canvas::default(), Panel::margin(&y(&view.share_label), tall).max(54.0));
    let top = keys(&mut canvas, legend_left, &legend(&shown, view)) + if panels > 1 { 24.0 } else { 6.0 };
    let multiples = Multiples::new(panels, Multiples::columns(panels), top, tall, &y(&view.share_label));
    let trials = answers().map(|point| point.n).max().unwrap_or(1);
    for index in 0..panels {
        let panel = Panel::new(
            multiples.corner(index),
            multiples.size,
            x(""),
            y(if multiples.is_left(index) { &view.share_label } else { "" }),
        );
        let here = if view.small_multiples { &shown[index..=index] } else { &shown[..] };
        panel.draw_grid(&mut canvas);
        panel.draw(&mut canvas, |canvas| {
            let mut strip = 0;
            for (series, curve) in here.iter().enumerate() {
                let style = if here.len() > 1 { Style::of(series) } else { Style::ALONE };
                draw_curve(canvas, &panel, curve, &style);
                draw_points(canvas, &panel, curve, &style, trials, view.logarithmic);
                if let Some(threshold) = &curve.threshold {
                    draw_threshold(canvas, &panel, threshold, &style, strip, view.logarithmic);
                    strip += 1;
                }
            }
        });
        panel.draw_axes(&mut canvas, [true, multiples.is_left(index)]);
        if panels > 1 {
            let n: usize = here[0].points.iter().map(|point| point.n).sum();
            panel.draw_heading(&mut canvas, &here[0].name, &format!("n = {n}"));
        }
    }
    multiples.draw_label(&mut canvas, &view.level_label);
    let mut note = left_out(bad, "level");
    if curves.len() > shown.len() {
        note = format!("{note} {} further functions are not drawn.", curves.len() - shown.len());
    }
    let bottom = remark(&mut canvas, multiples.bottom(), note.trim());
    canvas.finish([super::WIDTH, bottom], TITLE, &described(&shown, view))
}

fn described(shown: &[&PsychometricCurve], view: &PsychometricView) -> String {
    let mut text = format!("{} against {}, with 95 % Wilson intervals.", view.share_label, view.level_label);
    for curve in shown {
        if let Some(threshold) = &curve.threshold {
            let [low, high] = threshold.ci95.map(super::significant);
            let name = if curve.name.is_empty() { String::new() } else { format!(" of {}", curve.name) };
            text.push_str(&format!(" Threshold{name} {} ({low} to {high}).", super::significant(threshold.estimate)));
        }
    }
    text
}

/// Colours of one curve.
struct Style {
    points: Paint<'static>,
    bars: Paint<'static>,
    curve: &'static str,
    threshold: &'static str,
}

impl Style {
    const ALONE: Self = Self {
        points: Paint { fill: "#1b1f24", stroke: "none", width: 0.0, opacity: 0.75, dash: "", class: "ink-dot" },
        bars: Paint { fill: "none", stroke: "#1b1f24", width: 1.2, opacity: 0.75, dash: "", class: "ink-line" },
        curve: BLUE,
        threshold: GREEN,
    };

    fn of(series: usize) -> Self {
        let color = color(series);
        Self {
            points: Paint::fill(color).opacity(0.8),
            bars: Paint::stroke(color, 1.2).opacity(0.8),
            curve: color,
            threshold: color,
        }
    }
}

fn draw_curve(canvas: &mut Canvas, panel: &Panel, curve: &PsychometricCurve, style: &Style) {
    let good: Vec<&BandPoint> =
        curve.band.iter().filter(|p| [p.x, p.low, p.mid, p.high].iter().all(|v| v.is_finite())).collect();
    let px = |x: f64, share: f64| panel.px(x, share.clamp(0.0, 1.0));
    let mut region: Vec<[f64; 2]> = good.iter().map(|p| px(p.x, p.high)).collect();
    region.extend(good.iter().rev().map(|p| px(p.x, p.low)));
    canvas.polygon(&region, &Paint::fill(style.curve).opacity(0.17));
    let middle: Vec<[f64; 2]> = good.iter().map(|p| px(p.x, p.mid)).collect();
    let paint = Paint::stroke(style.curve, 2.0);
    canvas.polyline(&middle, &if curve.supported { paint } else { paint.dashed("6 4") });
    let [from, to] = [panel.corner[0], panel.corner[0] + panel.size[0]];
    let asymptotes = [curve.guess, curve.lapse.map(|lapse| 1.0 - lapse)];
    for share in asymptotes.into_iter().flatten().filter(|share| (0.0..=1.0).contains(share)) {
        let y = panel.px(1.0, share)[1];
        canvas.line([from, y], [to, y], &Paint::stroke(style.curve, 1.1).dashed("2 4"));
    }
}

fn draw_points(
    canvas: &mut Canvas,
    panel: &Panel,
    curve: &PsychometricCurve,
    style: &Style,
    most: usize,
    logarithmic: bool,
) {
    for point in curve.points.iter().filter(|point| drawable_on(point.level, logarithmic)) {
        let Some(share) = Share::new(point.k, point.n) else { continue };
        let [low, high] = share.wilson95.map(|p| panel.px(point.level, p));
        canvas.line(low, high, &style.bars);
        // Area in proportion to the number of trials, down to a size that is still seen.
        let radius = (7.0 * (point.n as f64 / most.max(1) as f64).sqrt()).max(1.6);
        canvas.circle(panel.px(point.level, share.share), radius, &style.points);
    }
}

fn draw_threshold(
    canvas: &mut Canvas,
    panel: &Panel,
    threshold: &Estimate,
    style: &Style,
    strip: usize,
    logarithmic: bool,
) {
    if !drawable_on(threshold.estimate, logarithmic) {
        return;
    }
    let y = panel.corner[1] + panel.size[1] - 8.0 - 9.0 * strip as f64;
    let x = panel.px(threshold.estimate, 0.0)[0];
    canvas.line([x, panel.corner[1]], [x, y], &Paint::stroke(style.threshold, 1.2).dashed("4 3"));
    if let Some([low, high]) = drawable_interval(threshold.ci95) {
        let at = |level: f64| [panel.px(level, 0.0)[0], y];
        capped(canvas, at(low), at(high), 3.0, &Paint::stroke(style.threshold, 1.8));
    }
    canvas.circle([x, y], 3.8, &Paint::fill(style.threshold));
}

fn legend(shown: &[&PsychometricCurve], view: &PsychometricView) -> Vec<(String, Mark)> {
    let mut entries: Vec<(String, Mark)> = Vec::new();
    let several = shown.len() > 1 && !view.small_multiples;
    if several {
        for (series, curve) in shown.iter().enumerate() {
            entries.push((shortened(&curve.name, 12.0, 200.0), Mark::LineWithDot(Paint::stroke(color(series), 2.0))));
        }
    } else if shown.iter().any(|curve| !curve.points.is_empty()) {
        entries.push(("share, 95 % (Wilson)".to_owned(), Mark::Standing(Paint::ink(1.4))));
    }
    if shown.iter().flat_map(|curve| &curve.points).any(|point| Some(point.n) != shown[0].points.first().map(|p| p.n)) {
        entries.push(("area: trials".to_owned(), Mark::Area));
    }
    let fitted = shown.iter().any(|curve| !curve.band.is_empty());
    if fitted && !several {
        entries.push(("fit, pointwise 95 %".to_owned(), Mark::LineInBand(Paint::stroke(BLUE, 2.0))));
    }
    if shown.iter().any(|curve| curve.guess.is_some() || curve.lapse.is_some()) {
        let paint = if several { Paint::muted(1.1) } else { Paint::stroke(BLUE, 1.1) };
        entries.push(("guess and lapse".to_owned(), Mark::Line(paint.dashed("2 4"))));
    }
    if shown.iter().any(|curve| curve.threshold.is_some()) {
        let mark = if several { Mark::Lying(Paint::muted(1.6)) } else { Mark::Lying(Paint::stroke(GREEN, 1.8)) };
        entries.push(("threshold, 95 %".to_owned(), mark));
    }
    if fitted && shown.iter().any(|curve| !curve.supported) {
        entries.push(("dashed: not supported by the data".to_owned(), Mark::Line(Paint::muted(2.0).dashed("6 4"))));
    }
    entries
}
