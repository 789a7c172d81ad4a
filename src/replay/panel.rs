//! The replay's screen: the picture with what is laid over it, what is to be said of the frame, buttons and keys, the
//! timeline. A function of plain data, so that a test can press its buttons.

use super::export::Look;
use super::facts::facts;
use super::overlay::{Line, Overlay};
use super::player::Player;
use super::strip::{Strip, clock};
use super::timeline::Timeline;
use super::{Replay, ink};
use egui::{
    Align, Align2, Color32, FontId, Frame, Key, Layout, Margin, Modifiers, Rect, RichText, Sense, Shape, Stroke,
    TextureId, Ui, Vec2, pos2, vec2,
};
use std::sync::Arc;
use std::time::Duration;

/// While it plays, a picture that is older than this is said to be, seconds.
const BEHIND_S: f64 = 0.3;

/// The colours of the screen: dark greys and one accent.
pub mod palette {
    use egui::Color32;

    /// Where one looks, what was answered, the foveated picture.
    pub const ACCENT: Color32 = Color32::from_rgb(255, 176, 64);
    /// Values.
    pub const BRIGHT: Color32 = Color32::from_rgb(226, 229, 234);
    /// Names of values.
    pub const QUIET: Color32 = Color32::from_rgb(142, 147, 156);
    /// Lines.
    pub const LINE: Color32 = Color32::from_rgb(58, 61, 67);
    /// Panels.
    pub const PANEL: Color32 = Color32::from_rgb(30, 32, 35);
    /// Behind pictures.
    pub const BACK: Color32 = Color32::from_rgb(20, 21, 23);
    /// Lanes where nothing is.
    pub const TROUGH: Color32 = Color32::from_rgb(38, 40, 44);
}

/// A picture that can be shown, and of which frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// The texture.
    pub texture: TextureId,
    /// Its size, pixels.
    pub size_px: [usize; 2],
    /// The frame, counted from 0 among the logged ones.
    pub frame: usize,
}

/// What there is to show.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pictures {
    /// What the observer saw.
    pub seen: Option<Shown>,
    /// The full-resolution reference.
    pub reference: Option<Shown>,
}

/// Everything on the screen and all that can be moved on it.
#[derive(Debug)]
pub struct Desk {
    /// The log.
    pub replay: Arc<Replay>,
    /// Where one looks.
    pub player: Player,
    /// What is switched on.
    pub look: Look,
    /// What happened when.
    pub timeline: Timeline,
    strip: Strip,
}

impl Desk {
    /// A desk with a log on it, at its first frame or that of a trial.
    #[must_use]
    pub fn new(replay: Arc<Replay>, look: Look, trial: Option<u32>) -> Self {
        let timeline = Timeline::of(&replay);
        let mut player = Player::new(Arc::clone(&timeline.frames), Arc::clone(&timeline.trials));
        if let Some(first) = trial.and_then(|trial| replay.frames().iter().position(|row| row.trial == Some(trial))) {
            player.go_to(first);
        }
        Self { replay, player, look, timeline, strip: Strip::default() }
    }
}

/// Sets the screen's colours and type.
pub fn dress(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.style_mut_of(egui::Theme::Dark, |style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = palette::PANEL;
        visuals.window_fill = palette::PANEL;
        visuals.extreme_bg_color = palette::BACK;
        visuals.override_text_color = Some(palette::BRIGHT);
        visuals.selection.bg_fill = Color32::from_rgb(92, 68, 34);
        visuals.selection.stroke = Stroke::new(1.0, palette::ACCENT);
        let widgets = &mut visuals.widgets;
        widgets.noninteractive.bg_stroke = Stroke::new(1.0, palette::LINE);
        for (widget, fill) in [
            (&mut widgets.inactive, Color32::from_rgb(46, 49, 54)),
            (&mut widgets.hovered, Color32::from_rgb(60, 64, 70)),
            (&mut widgets.active, Color32::from_rgb(72, 76, 83)),
        ] {
            (widget.bg_fill, widget.weak_bg_fill) = (fill, fill);
            widget.bg_stroke = Stroke::NONE;
            widget.expansion = 0.0;
        }
        style.spacing.item_spacing = vec2(8.0, 6.0);
        style.spacing.button_padding = vec2(9.0, 4.0);
        style.interaction.selectable_labels = false;
    });
}

/// Shows the screen, and takes in keys, buttons and the time that has passed.
pub fn show(ui: &mut Ui, desk: &mut Desk, pictures: &Pictures) {
    let passed_s = ui.input(|input| f64::from(input.unstable_dt));
    // After a long rest, what passes begins now.
    desk.player.advance(passed_s.min(0.25));
    keys(ui, desk);
    let margin = |x: i8, y: i8| Frame::new().fill(palette::PANEL).inner_margin(Margin::symmetric(x, y));
    egui::Panel::top("head").frame(margin(14, 8)).show(ui, |ui| head(ui, desk));
    egui::Panel::bottom("below").frame(margin(14, 10)).show(ui, |ui| {
        transport(ui, desk);
        ui.add_space(4.0);
        desk.strip.show(ui, &desk.timeline, &mut desk.player);
    });
    let width = (0.25 * ui.available_width()).clamp(248.0, 320.0);
    egui::Panel::right("facts").resizable(false).exact_size(width).frame(margin(14, 10)).show(ui, |ui| {
        said(ui, desk);
    });
    let back = Frame::new().fill(palette::BACK).inner_margin(Margin::same(10));
    egui::CentralPanel::default().frame(back).show(ui, |ui| picture(ui, desk, pictures));
    if desk.player.is_playing() {
        ui.request_repaint_after(Duration::from_millis(16));
    }
}

/// Keys: space plays, arrows step by frame, with shift by trial, up and down change the speed.
fn keys(ui: &Ui, desk: &mut Desk) {
    let pressed = |modifiers: Modifiers, key: Key| ui.input_mut(|input| input.consume_key(modifiers, key));
    let player = &mut desk.player;
    // With shift first: without it a key counts whatever else is held.
    if pressed(Modifiers::SHIFT, Key::ArrowLeft) {
        player.step_trial(false);
    }
    if pressed(Modifiers::SHIFT, Key::ArrowRight) {
        player.step_trial(true);
    }
    if pressed(Modifiers::NONE, Key::ArrowLeft) {
        player.step(-1);
    }
    if pressed(Modifiers::NONE, Key::ArrowRight) {
        player.step(1);
    }
    if pressed(Modifiers::NONE, Key::ArrowUp) {
        player.change_speed(true);
    }
    if pressed(Modifiers::NONE, Key::ArrowDown) {
        player.change_speed(false);
    }
    if pressed(Modifiers::NONE, Key::Home) {
        player.go_to(0);
    }
    if pressed(Modifiers::NONE, Key::End) {
        player.go_to(usize::MAX);
    }
    if pressed(Modifiers::NONE, Key::Space) {
        player.toggle();
    }
}

/// What this is, and what is switched on.
fn head(ui: &mut Ui, desk: &mut Desk) {
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let look = &mut desk.look;
            for (on, name, about) in [
                (&mut look.reference, "Reference", "The full-resolution picture beside it"),
                (&mut look.parts.rings, "Rings", "Eccentricity, degrees from the gaze"),
                (&mut look.parts.trail, "Trail", "Gaze of the last half second"),
                (&mut look.parts.gaze, "Gaze", "Where the eye looked"),
            ] {
                let button = egui::Button::selectable(*on, name).frame_when_inactive(true);
                if ui.add(button).on_hover_text(about).clicked() {
                    *on = !*on;
                }
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(&desk.replay.title).size(15.0).strong()).truncate());
                let name = RichText::new(&desk.replay.name).color(palette::QUIET).size(12.0);
                ui.add(egui::Label::new(name).truncate());
            });
        });
    });
}

/// Buttons to play and step, and where one is.
fn transport(ui: &mut Ui, desk: &mut Desk) {
    ui.horizontal(|ui| {
        let player = &mut desk.player;
        if icon(ui, Icon::Trial { on: false }, "Previous trial", "The trial before (shift + left)") {
            player.step_trial(false);
        }
        if icon(ui, Icon::Frame { on: false }, "Back", "One frame back (left)") {
            player.step(-1);
        }
        let play = if player.is_playing() { "Pause" } else { "Play" };
        let button = egui::Button::new(RichText::new(play).color(palette::BACK)).fill(palette::ACCENT);
        if ui.add(button.min_size(vec2(76.0, 26.0))).on_hover_text("Space").clicked() {
            player.toggle();
        }
        if icon(ui, Icon::Frame { on: true }, "Forward", "One frame on (right)") {
            player.step(1);
        }
        if icon(ui, Icon::Trial { on: true }, "Next trial", "The next trial (shift + right)") {
            player.step_trial(true);
        }
        ui.add_space(10.0);
        if ui.add(egui::Button::new("−").min_size(vec2(26.0, 26.0))).on_hover_text("Slower (down)").clicked() {
            player.change_speed(false);
        }
        let speed = egui::Label::new(RichText::new(format!("×{}", player.speed())).monospace());
        ui.add_sized([44.0, 26.0], speed);
        if ui.add(egui::Button::new("+").min_size(vec2(26.0, 26.0))).on_hover_text("Faster (up)").clicked() {
            player.change_speed(true);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let frames = desk.replay.frames();
            let place = match frames.get(desk.player.frame()) {
                Some(_) => {
                    let t_s = desk.timeline.axis.t_s(desk.player.place());
                    format!("frame {} of {}    {}", desk.player.frame() + 1, frames.len(), clock(t_s, 0.01))
                }
                None => "no frames were logged".to_owned(),
            };
            ui.label(RichText::new(place).monospace().color(palette::QUIET));
        });
    });
}

/// What is drawn on a button, pointing on or back.
#[derive(Debug, Clone, Copy)]
enum Icon {
    Frame { on: bool },
    Trial { on: bool },
}

/// A button with a drawn triangle, with a bar before it for trials; answers whether it was pressed.
fn icon(ui: &mut Ui, icon: Icon, name: &str, about: &str) -> bool {
    let response = ui.add(egui::Button::new("").min_size(vec2(34.0, 26.0)));
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    let (middle, painter) = (response.rect.center(), ui.painter());
    let (on, bar) = match icon {
        Icon::Frame { on } => (on, false),
        Icon::Trial { on } => (on, true),
    };
    let way = if on { 1.0 } else { -1.0 };
    let corners = [vec2(-4.0, -5.5), vec2(5.0, 0.0), vec2(-4.0, 5.5)].map(|off| middle + vec2(way * off.x, off.y));
    painter.add(Shape::convex_polygon(corners.to_vec(), palette::BRIGHT, Stroke::NONE));
    if bar {
        let x = middle.x + way * 6.5;
        let line = [pos2(x, middle.y - 5.5), pos2(x, middle.y + 5.5)];
        painter.line_segment(line, Stroke::new(1.8, palette::BRIGHT));
    }
    response.on_hover_text(about).clicked()
}

/// What is to be said of the frame.
fn said(ui: &mut Ui, desk: &Desk) {
    egui::ScrollArea::vertical().auto_shrink([false; 2]).show(ui, |ui| {
        // In a low window everything stands closer, so that it is still seen at once.
        let low = ui.available_height() < 420.0;
        let (size, between, line) = if low { (11.5, 1.0, 13.5) } else { (12.5, 3.0, 16.0) };
        ui.spacing_mut().item_spacing.y = between;
        ui.spacing_mut().interact_size.y = line;
        for (index, section) in facts(&desk.replay, desk.player.frame()).into_iter().enumerate() {
            if index > 0 {
                ui.add_space(3.0 * between);
            }
            ui.label(RichText::new(section.title).size(size).strong().color(palette::ACCENT));
            for (what, value) in section.rows {
                ui.horizontal_top(|ui| {
                    let name = egui::Label::new(RichText::new(what).size(size).color(palette::QUIET)).truncate();
                    ui.allocate_ui_with_layout(vec2(76.0, line), Layout::left_to_right(Align::Min), |ui| {
                        ui.set_width(76.0);
                        ui.add(name);
                    });
                    ui.add(egui::Label::new(RichText::new(value).size(size)).wrap());
                });
            }
        }
    });
}

/// The picture, and the reference beside it.
fn picture(ui: &mut Ui, desk: &Desk, pictures: &Pictures) {
    let room = ui.available_rect_before_wrap();
    ui.allocate_rect(room, Sense::hover());
    let Some(row) = desk.replay.frames().get(desk.player.frame()) else {
        let text = "No frames were logged.";
        ui.painter().text(room.center(), Align2::CENTER_CENTER, text, FontId::proportional(15.0), palette::QUIET);
        return;
    };
    let overlay = Overlay::of(&desk.replay, row, desk.look.parts);
    let sides: &[(&str, Option<Shown>)] = if desk.look.reference {
        &[("seen", pictures.seen), ("reference", pictures.reference)]
    } else {
        &[("seen", pictures.seen)]
    };
    let size = desk.replay.display(row).resolution_px().map(|px| px as f32);
    for ((name, shown), part) in sides.iter().zip(parts_of(room, sides.len(), size)) {
        let caption = if sides.len() > 1 { 20.0 } else { 0.0 };
        let room = Rect::from_min_max(part.min + vec2(0.0, caption), part.max);
        let place = fitted(room, size);
        if sides.len() > 1 {
            let at = pos2(place.left(), place.top() - 4.0);
            ui.painter().text(at, Align2::LEFT_BOTTOM, name, FontId::proportional(12.0), palette::QUIET);
        }
        let painter = ui.painter().with_clip_rect(place.intersect(room));
        painter.rect_filled(place, 0.0, palette::TROUGH);
        match shown {
            Some(shown) => {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                painter.image(shown.texture, whole_of(place, *shown, size), whole, Color32::WHITE);
                lay_over(&painter, &overlay, place, size);
                if is_behind(desk, shown.frame) {
                    note(&painter, place, "drawing …");
                }
            }
            None => note(&painter, place, "drawing …"),
        }
    }
}

/// Whether the picture shown is another than the one meant; while it plays, one of a moment before is good enough.
fn is_behind(desk: &Desk, shown: usize) -> bool {
    let place = |frame: usize| desk.timeline.frames.get(frame).copied().unwrap_or_default();
    let now = desk.player.frame();
    if desk.player.is_playing() { (place(now) - place(shown)).abs() > BEHIND_S } else { shown != now }
}

/// Where a picture stands that may be of a display of another size than the one shown now.
fn whole_of(place: Rect, shown: Shown, size: [f32; 2]) -> Rect {
    if shown.size_px.map(|px| px as f32) == size { place } else { fitted(place, shown.size_px.map(|px| px as f32)) }
}

fn note(painter: &egui::Painter, place: Rect, text: &str) {
    let at = place.left_top() + vec2(10.0, 8.0);
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), palette::BRIGHT);
    let behind = Rect::from_min_size(at, galley.size()).expand2(vec2(6.0, 3.0));
    painter.rect_filled(behind, 3.0, Color32::from_black_alpha(150));
    painter.galley(at, galley, palette::BRIGHT);
}

/// The room of each of `count` pictures: beside each other, or below where they are larger so.
fn parts_of(room: Rect, count: usize, [width, height]: [f32; 2]) -> Vec<Rect> {
    if count < 2 {
        return vec![room];
    }
    let gap = 10.0;
    let (beside, below) =
        (vec2(0.5 * (room.width() - gap), room.height()), vec2(room.width(), 0.5 * (room.height() - gap)));
    let scale = |part: Vec2| (part.x / width).min((part.y - 20.0) / height);
    let (size, step) = if scale(beside) >= scale(below) {
        (beside, vec2(beside.x + gap, 0.0))
    } else {
        (below, vec2(0.0, below.y + gap))
    };
    vec![Rect::from_min_size(room.min, size), Rect::from_min_size(room.min + step, size)]
}

/// The largest place of a shape in the middle of a room.
fn fitted(room: Rect, [width, height]: [f32; 2]) -> Rect {
    let scale = (room.width() / width).min(room.height() / height).max(0.0);
    Rect::from_center_size(room.center(), scale * vec2(width, height))
}

/// Gaze, its trail and rings over the picture of a display of `size` pixels at `place`.
fn lay_over(painter: &egui::Painter, overlay: &Overlay, place: Rect, size: [f32; 2]) {
    let scale = place.width() / size[0];
    let at = |[x, y]: [f64; 2]| place.min + scale * vec2(x as f32, y as f32);
    let points = |line: &Line| line.iter().map(|place| at(*place)).collect::<Vec<_>>();
    let ring_colour = Color32::from_rgba_unmultiplied(ink::RING[0], ink::RING[1], ink::RING[2], 150);
    for ring in &overlay.rings {
        for line in &ring.lines {
            let points = points(line);
            painter.add(Shape::line(points.clone(), Stroke::new(3.0, Color32::from_black_alpha(70))));
            painter.add(Shape::line(points, Stroke::new(1.2, ring_colour)));
        }
        if let Some(label_px) = ring.label_px {
            let text = format!("{}°", ring.eccentricity_deg);
            let at = at(label_px) + vec2(5.0, 0.0);
            let font = FontId::proportional(13.0);
            let shade = Color32::from_black_alpha(180);
            painter.text(at + vec2(1.0, 1.0), Align2::LEFT_CENTER, &text, font.clone(), shade);
            painter.text(at, Align2::LEFT_CENTER, &text, font, palette::BRIGHT);
        }
    }
    for line in &overlay.trail {
        let points = points(line);
        for (index, pair) in points.windows(2).enumerate() {
            let strength = 40.0 + 190.0 * (index + 1) as f32 / points.len() as f32;
            let [red, green, blue] = ink::ACCENT;
            let colour = Color32::from_rgba_unmultiplied(red, green, blue, strength as u8);
            painter.line_segment([pair[0], pair[1]], Stroke::new(2.0, colour));
        }
    }
    if let Some(gaze_px) = overlay.gaze_px {
        let (at, strength) = (at(gaze_px), if overlay.lost { 0.4 } else { 1.0 });
        painter.circle_stroke(at, 10.0, Stroke::new(4.5, Color32::from_black_alpha(90)));
        painter.circle_stroke(at, 10.0, Stroke::new(2.2, palette::ACCENT.gamma_multiply(strength)));
        painter.circle_filled(at, 2.2, palette::ACCENT.gamma_multiply(strength));
    }
}

#[cfg(test)]
mod tests;
