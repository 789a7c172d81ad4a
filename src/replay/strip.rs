//! The timeline as it is drawn: lanes, a ruler, the place one looks at; clicked and dragged to seek, scrolled to look closer.

use super::panel::palette;
use super::player::Player;
use super::timeline::{Lane, Timeline, Tone};
use egui::{Align2, Color32, CursorIcon, FontId, Pos2, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2};
use std::ops::Range;

/// Height of a lane, points.
const LANE: f32 = 17.0;
/// Space between lanes, points.
const BETWEEN: f32 = 3.0;
/// Height of the ruler, points.
const RULER: f32 = 20.0;
/// Width of the lanes' names, points.
const NAMES: f32 = 104.0;
/// The least that can be looked at, seconds.
const CLOSEST_S: f64 = 0.05;

/// Which part of the axis is looked at, and what was computed for it.
#[derive(Debug, Clone, Default)]
pub struct Strip {
    seen: Option<Range<f64>>,
    /// For which part and how many columns the runs were computed.
    computed: Option<(Range<f64>, usize)>,
    runs: Vec<Vec<(Range<usize>, Tone)>>,
}

/// How high a timeline of so many lanes is, points.
#[must_use]
pub fn height(lanes: usize) -> f32 {
    RULER + lanes as f32 * (LANE + BETWEEN)
}

/// The colour that stands for something.
#[must_use]
pub fn colour(tone: Tone) -> Color32 {
    match tone {
        Tone::Blank => Color32::from_rgb(58, 60, 65),
        Tone::Page => Color32::from_rgb(78, 81, 88),
        Tone::Ask => Color32::from_rgb(116, 120, 129),
        Tone::Reference => Color32::from_rgb(86, 122, 166),
        Tone::Test | Tone::Response | Tone::Seam => palette::ACCENT,
        Tone::Aborted => Color32::from_rgb(96, 98, 104),
        Tone::TimedOut => Color32::from_rgb(128, 110, 84),
        Tone::Answered => Color32::from_rgb(104, 134, 166),
        Tone::Right => Color32::from_rgb(92, 148, 110),
        Tone::Wrong => Color32::from_rgb(184, 92, 88),
        Tone::Open => Color32::from_rgb(70, 72, 78),
        Tone::Missed => Color32::from_rgb(214, 98, 92),
        Tone::Lost => Color32::from_rgb(150, 104, 164),
    }
}

impl Strip {
    /// Draws the timeline into the width there is, and moves the player where it is clicked or dragged to.
    pub fn show(&mut self, ui: &mut Ui, timeline: &Timeline, player: &mut Player) {
        let size = vec2(ui.available_width(), height(timeline.lanes.len()));
        let (response, painter) = ui.allocate_painter(size, Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, "Timeline"));
        let whole = response.rect;
        let lanes = Rect::from_min_max(pos2(whole.left() + NAMES, whole.top() + RULER), whole.max);
        if lanes.width() < 16.0 {
            return;
        }
        let length = timeline.axis.length().max(CLOSEST_S);
        let mut seen = self.seen.clone().unwrap_or(0.0..length);
        seen = scrolled(ui, &response, lanes, seen, length);
        if player.is_playing() {
            seen = following(seen, player.place(), length);
        }
        let x_of = |place: f64| lanes.left() + ((place - seen.start) / (seen.end - seen.start)) as f32 * lanes.width();

        if let Some(at) = response.interact_pointer_pos().filter(|at| at.x >= lanes.left() - 4.0) {
            let share = f64::from((at.x - lanes.left()) / lanes.width()).clamp(0.0, 1.0);
            player.seek(seen.start + share * (seen.end - seen.start));
        }
        if response.hover_pos().is_some_and(|at| at.x >= lanes.left()) {
            ui.set_cursor_icon(CursorIcon::PointingHand);
        }

        // Lanes are computed anew only for another part of the axis or another width.
        let columns = (lanes.width() * ui.pixels_per_point()).round().max(1.0) as usize;
        if self.computed.as_ref() != Some(&(seen.clone(), columns)) {
            self.runs = timeline.lanes.iter().map(|lane| lane.runs(&seen, columns)).collect();
            self.computed = Some((seen.clone(), columns));
        }
        let point = lanes.width() / columns as f32;
        for (index, (lane, runs)) in timeline.lanes.iter().zip(&self.runs).enumerate() {
            let top = lanes.top() + index as f32 * (LANE + BETWEEN);
            let row = Rect::from_min_size(pos2(lanes.left(), top), vec2(lanes.width(), LANE));
            painter.rect_filled(row, 2.0, palette::TROUGH);
            let at = pos2(whole.left(), row.center().y);
            painter.text(at, Align2::LEFT_CENTER, lane.name, FontId::proportional(12.0), palette::QUIET);
            for (run, tone) in runs {
                let left = lanes.left() + run.start as f32 * point;
                // An instant is as wide as can be seen.
                let width = (run.len() as f32 * point).max(1.5);
                let bar = Rect::from_min_size(pos2(left, row.top()), vec2(width, LANE));
                painter.rect_filled(bar, if width > 6.0 { 2.0 } else { 0.0 }, colour(*tone));
            }
            labels(&painter, lane, &seen, row, &x_of);
        }
        ruler(&painter, timeline, &seen, lanes, whole.top(), &x_of);

        let x = x_of(player.place());
        if (lanes.left()..=lanes.right()).contains(&x) {
            let line = [pos2(x, whole.top() + RULER - 5.0), pos2(x, lanes.bottom() - BETWEEN)];
            painter.line_segment(line, Stroke::new(3.0, Color32::from_black_alpha(140)));
            painter.line_segment(line, Stroke::new(1.0, palette::BRIGHT));
            let knob = [vec2(-5.0, -7.0), vec2(5.0, -7.0), vec2(0.0, 1.0)].map(|off| line[0] + off).to_vec();
            painter.add(egui::Shape::convex_polygon(knob, palette::BRIGHT, Stroke::NONE));
        }
        self.seen = Some(seen);
    }
}

/// Looks closer or further around the pointer when it scrolls, and along when it scrolls sideways.
fn scrolled(ui: &Ui, response: &egui::Response, lanes: Rect, seen: Range<f64>, length: f64) -> Range<f64> {
    let Some(at) = response.hover_pos() else { return seen };
    let (scroll, zoom) = ui.input(|input| (input.smooth_scroll_delta(), f64::from(input.zoom_delta())));
    let factor = (f64::from(-scroll.y) * 0.004).exp() / zoom;
    let share = f64::from((at.x - lanes.left()) / lanes.width()).clamp(0.0, 1.0);
    let now = seen.end - seen.start;
    let span = (now * factor).clamp(CLOSEST_S.min(length), length);
    let along = -f64::from(scroll.x / lanes.width()) * span;
    let start = (seen.start + share * (now - span) + along).clamp(0.0, length - span);
    start..start + span
}

/// Turns the page when playing leaves the part that is looked at.
fn following(seen: Range<f64>, place: f64, length: f64) -> Range<f64> {
    if seen.contains(&place) {
        return seen;
    }
    let span = seen.end - seen.start;
    let start = place.clamp(0.0, (length - span).max(0.0));
    start..start + span
}

/// Names on stretches that are wide enough for them.
fn labels(painter: &egui::Painter, lane: &Lane, seen: &Range<f64>, row: Rect, x_of: &impl Fn(f64) -> f32) {
    let spans = lane.within(seen);
    // With more of them than this none is wide enough.
    if spans.len() > row.width() as usize / 8 {
        return;
    }
    for span in spans.iter().filter(|span| !span.label.is_empty()) {
        let (left, right) = (x_of(span.from).max(row.left()), x_of(span.to).min(row.right()));
        // Where one ends as the next begins, a line tells them apart.
        painter.vline(left, row.y_range(), Stroke::new(1.0, palette::BACK));
        let ink = if span.tone == Tone::Test { palette::BACK } else { palette::BRIGHT };
        let galley = painter.layout_no_wrap(span.label.clone(), FontId::proportional(11.0), ink);
        if right - left > galley.size().x + 8.0 {
            painter.galley(pos2(left + 4.0, row.center().y - 0.5 * galley.size().y), galley, ink);
        }
    }
}

/// Times above the lanes; the axis jumps over gaps, and so do they.
fn ruler(
    painter: &egui::Painter,
    timeline: &Timeline,
    seen: &Range<f64>,
    lanes: Rect,
    top: f32,
    x_of: &impl Fn(f64) -> f32,
) {
    let per_label_s = (seen.end - seen.start) * 90.0 / f64::from(lanes.width());
    let steps = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0];
    let step_s = steps.into_iter().find(|step| *step >= per_label_s).unwrap_or(3600.0);
    let mut place = seen.start;
    let mut last_x = f32::NEG_INFINITY;
    while place <= seen.end {
        let t_s = (timeline.axis.t_s(place) / step_s).ceil() * step_s;
        place = timeline.axis.place(t_s);
        let x = x_of(place);
        if x > lanes.right() {
            break;
        }
        if x >= lanes.left() && x - last_x > 46.0 {
            painter.line_segment(
                [pos2(x, top + RULER - 5.0), pos2(x, top + RULER - 1.0)],
                Stroke::new(1.0, palette::LINE),
            );
            let fits = x + 40.0 < lanes.right();
            let (align, at) = if fits { (Align2::LEFT_CENTER, x + 3.0) } else { (Align2::RIGHT_CENTER, x - 3.0) };
            let text = clock(t_s, step_s);
            painter.text(Pos2::new(at, top + 8.0), align, text, FontId::proportional(11.0), palette::QUIET);
            last_x = x;
        }
        // A little further than this tick, so that the next one is another.
        place = place.max(timeline.axis.place(t_s + 0.5 * step_s));
    }
}

/// A session time as a clock shows it, as fine as the steps between times.
#[must_use]
pub fn clock(t_s: f64, step_s: f64) -> String {
    let digits = if step_s < 0.1 { 2 } else { usize::from(step_s < 1.0) };
    let whole = t_s.max(0.0);
    let (hours, minutes) = ((whole / 3600.0).floor(), (whole / 60.0).floor() % 60.0);
    let seconds = whole - 60.0 * (whole / 60.0).floor();
    let width = if digits > 0 { 3 + digits } else { 2 };
    if hours > 0.0 {
        format!("{hours:.0}:{minutes:02.0}:{seconds:0width$.digits$}")
    } else {
        format!("{minutes:.0}:{seconds:0width$.digits$}")
    }
}

/// The size of a timeline in a window, points: what must be there at least.
#[must_use]
pub fn least_size(lanes: usize) -> Vec2 {
    vec2(NAMES + 200.0, height(lanes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_read_like_a_clock() {
        let texts = [(0.0, 1.0), (9.5, 0.5), (75.0, 5.0), (3723.25, 0.05)].map(|(t_s, step_s)| clock(t_s, step_s));
        assert_eq!(texts, ["0:00", "0:09.5", "1:15", "1:02:03.25"]);
    }

    #[test]
    fn playing_turns_the_page() {
        assert_eq!(following(0.0..10.0, 5.0, 100.0), 0.0..10.0);
        assert_eq!(following(0.0..10.0, 12.0, 100.0), 12.0..22.0);
        assert_eq!(following(0.0..10.0, 99.0, 100.0), 90.0..100.0);
    }
}
