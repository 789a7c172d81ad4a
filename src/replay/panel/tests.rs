//! The screen, pressed and looked at: a session of the first format on the desk, buttons and keys as a user presses them.

use super::*;
use crate::replay::overlay::Parts;
use crate::resources::Resources;
use crate::session::SessionFolder;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use experiments::trial::Outcome;

fn desk() -> Desk {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/sessions/format-1/finished");
    let session = SessionFolder::open(&path).expect("a session");
    let resources = Resources::of_session(&session).expect("no files");
    let replay = Replay::recorded(&session, &resources).expect("a log");
    Desk::new(Arc::new(replay), Look { parts: Parts { gaze: true, trail: true, rings: true }, reference: false }, None)
}

fn harness(size: Vec2) -> Harness<'static, Desk> {
    let app = |ui: &mut Ui, desk: &mut Desk| show(ui, desk, &Pictures::default());
    Harness::builder().with_size(size).with_step_dt(0.05).with_context_setup(dress).build_ui_state(app, desk())
}

#[test]
fn buttons_play_step_and_seek() {
    let mut screen = harness(vec2(1280.0, 800.0));
    assert_eq!(screen.state().player.frame(), 0);
    screen.get_by_label("Forward").click();
    screen.run_steps(2);
    assert_eq!(screen.state().player.frame(), 1);
    screen.get_by_label("Back").click();
    screen.run_steps(2);
    assert_eq!(screen.state().player.frame(), 0);

    // The session has 20 frames a second: a twentieth of a second is a frame.
    screen.get_by_label("Play").click();
    screen.run_steps(12);
    let played = screen.state().player.frame();
    assert!((8..=12).contains(&played) && screen.state().player.is_playing(), "{played}");
    screen.get_by_label("Pause").click();
    screen.run_steps(2);
    let paused = screen.state().player.frame();
    screen.run_steps(5);
    assert_eq!((screen.state().player.frame(), screen.state().player.is_playing()), (paused, false));

    screen.get_by_label("Next trial").click();
    screen.run_steps(2);
    let trials: Vec<usize> = screen.state().timeline.trials.to_vec();
    assert!(trials.contains(&screen.state().player.frame()));

    // A click in the timeline's middle, right of the lanes' names.
    let timeline = screen.get_by_label("Timeline").rect();
    let at = pos2(timeline.left() + 104.0 + 0.5 * (timeline.width() - 104.0), timeline.center().y);
    screen.drag_at(at);
    screen.run_steps(1);
    screen.drop_at(at);
    screen.run_steps(2);
    let (place, length) = (screen.state().player.place(), screen.state().timeline.axis.length());
    assert!((place / length - 0.5).abs() < 0.02, "{place} of {length} s");
}

#[test]
fn keys_do_what_buttons_do() {
    let mut screen = harness(vec2(1280.0, 800.0));
    let press = |screen: &mut Harness<'static, Desk>, modifiers: Modifiers, key: Key| {
        screen.key_press_modifiers(modifiers, key);
        screen.run_steps(2);
        screen.state().player.frame()
    };
    assert_eq!(press(&mut screen, Modifiers::NONE, Key::ArrowRight), 1);
    assert_eq!(press(&mut screen, Modifiers::NONE, Key::ArrowRight), 2);
    assert_eq!(press(&mut screen, Modifiers::NONE, Key::ArrowLeft), 1);
    // The first trial begins with the first frame.
    let trials = screen.state().timeline.trials.to_vec();
    assert_eq!(trials[0], 0);
    assert_eq!(press(&mut screen, Modifiers::SHIFT, Key::ArrowRight), trials[1]);
    assert_eq!(press(&mut screen, Modifiers::SHIFT, Key::ArrowRight), trials[2]);
    assert_eq!(press(&mut screen, Modifiers::SHIFT, Key::ArrowLeft), trials[1]);
    press(&mut screen, Modifiers::NONE, Key::ArrowUp);
    assert!(screen.query_by_label("×1.5").is_some());
    press(&mut screen, Modifiers::NONE, Key::Space);
    assert!(screen.state().player.is_playing());
    press(&mut screen, Modifiers::NONE, Key::Space);
    assert!(!screen.state().player.is_playing());
    let last = screen.state().replay.frames().len() - 1;
    assert_eq!(press(&mut screen, Modifiers::NONE, Key::End), last);
    assert_eq!(press(&mut screen, Modifiers::NONE, Key::Home), 0);
}

#[test]
fn switches_switch() {
    let mut screen = harness(vec2(900.0, 600.0));
    assert!(screen.state().look.parts.rings && !screen.state().look.reference);
    for name in ["Gaze", "Trail", "Rings", "Reference"] {
        // The facts have a row "Gaze" too; the switch is the button.
        screen.get_by_role_and_label(egui::accesskit::Role::Button, name).click();
        screen.run_steps(2);
    }
    assert_eq!(screen.state().look, Look { parts: Parts::default(), reference: true });
}

/// The labels say what the journal says of every trial.
#[test]
fn labels_say_what_was_answered() {
    let mut screen = harness(vec2(1280.0, 800.0));
    let record = screen.state().replay.record.clone();
    assert!(record.trials.len() >= 3);
    for (index, trial) in record.trials.iter().enumerate() {
        // The first trial begins with the first frame.
        if index > 0 {
            screen.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
        }
        screen.run_steps(3);
        let Outcome::Answered { answer, correct, .. } = &trial.outcome else { panic!("answered") };
        let word = serde_json::to_value(answer).expect("serialises").as_str().expect("a name").to_owned();
        let said = format!("{word}, {}", if *correct == Some(true) { "right" } else { "wrong" });
        assert!(screen.query_by_label(&said).is_some(), "{said}");
        let after = format!("{:.3} s", trial.response_time_s.expect("timed"));
        assert!(screen.query_all_by_label(&after).next().is_some(), "{after}");
        let number = format!("{} of {}", trial.trial.trial, record.trials.len());
        assert!(screen.query_by_label(&number).is_some(), "{number}");
    }
}

/// Nothing is clipped in a small window: every label and button is within it.
#[test]
fn everything_is_on_the_screen() {
    for size in [vec2(1280.0, 800.0), vec2(900.0, 600.0)] {
        let mut screen = harness(size);
        screen.run_steps(3);
        let whole = Rect::from_min_size(pos2(0.0, 0.0), size);
        for name in [
            "Previous trial",
            "Back",
            "Play",
            "Forward",
            "Next trial",
            "−",
            "+",
            "Rings",
            "Trail",
            "Reference",
            "Timeline",
        ] {
            let rect = screen.get_by_label(name).rect();
            assert!(whole.contains_rect(rect), "{name} at {rect:?} of {size:?}");
        }
    }
}

/// The screen as it is drawn: the play button in the accent, and every trial in the colour of its outcome.
#[test]
fn the_screen_is_drawn() {
    let app = |ui: &mut Ui, desk: &mut Desk| show(ui, desk, &Pictures::default());
    let builder = Harness::builder().with_size(vec2(1280.0, 800.0)).with_context_setup(dress).wgpu();
    let mut screen = builder.build_ui_state(app, desk());
    screen.run_steps(3);
    let drawn = screen.render().expect("drawn");
    let is = |at: egui::Pos2, colour: Color32| {
        let found = drawn.get_pixel(at.x as u32, at.y as u32).0;
        let near = (0..3).all(|channel| found[channel].abs_diff(colour.to_array()[channel]) <= 2);
        assert!(near, "expected {colour:?}, found {found:?} at {at:?}");
    };
    let play = screen.get_by_label("Play").rect();
    is(pos2(play.left() + 5.0, play.center().y), palette::ACCENT);
    let timeline = screen.get_by_label("Timeline").rect();
    let lanes = timeline.right() - timeline.left() - 104.0;
    let desk = screen.state();
    for span in &desk.timeline.lanes[0].spans {
        // Three quarters into the trial, where its number does not stand.
        let place = span.from + 0.75 * (span.to - span.from);
        let x = timeline.left() + 104.0 + (place / desk.timeline.axis.length()) as f32 * lanes;
        is(pos2(x, timeline.top() + 20.0 + 8.0), crate::replay::strip::colour(span.tone));
    }
}
