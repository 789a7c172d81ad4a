//! Recorded gaze: a round trip through the session's columns, playback, and every kind of mistake.

use super::*;
use crate::gaze::{Simulated, SimulatedEye};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn display() -> Display {
    Display::named("guenter-2012").expect("ships")
}

fn parse(text: &str) -> Result<Recorded, Vec<CsvMistake>> {
    Recorded::parse("gaze.csv", text, &display())
}

fn mistakes(text: &str) -> Vec<String> {
    parse(text).expect_err("refused").iter().map(ToString::to_string).collect()
}

fn played(recorded: &mut Recorded, now_s: f64) -> Vec<GazeSample> {
    let mut out = Vec::new();
    recorded.poll(now_s, &mut out);
    out
}

fn eye_cells(eye: Option<EyeSample>) -> String {
    let eye = eye.expect("binocular");
    format!("{},{},{},{}", eye.px[0], eye.px[1], u8::from(eye.valid), cell(eye.pupil_mm))
}

fn cell(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

#[test]
fn a_session_file_comes_back_as_it_was_written() {
    let seed = 11;
    println!("seed {seed}");
    let display = display();
    let eye =
        SimulatedEye { blink_rate_per_min: 40.0, loss_share: 0.05, device_offset_s: 1234.5, ..SimulatedEye::default() };
    let mut simulated =
        Simulated::new(eye, &display, [3.0, -2.0], ChaCha8Rng::seed_from_u64(seed)).expect("possible eye");
    let mut written = Vec::new();
    simulated.poll(8.0, &mut written);
    // Nothing valid has been seen before the first valid sample, so start there: playback would start there too.
    let first = written.iter().position(|sample| sample.valid).expect("some are valid");
    let written = &written[first..];

    let mut text = COLUMNS.join(",") + "\n";
    for s in written {
        let deg = display.deg_from_px(s.px);
        text += &format!(
            "{},{},{},{},{},{:.4},{:.4},{},{},{},{}\n",
            s.t_s,
            s.arrived_s,
            s.t_device_s,
            s.px[0],
            s.px[1],
            deg[0],
            deg[1],
            s.valid,
            cell(s.pupil_mm),
            eye_cells(s.left),
            eye_cells(s.right)
        );
    }
    let mut recorded = parse(&text).expect("our own columns");
    assert_eq!(recorded.samples(), written.len());
    let t0_s = written[0].t_s;
    let read = played(&mut recorded, f64::MAX);
    assert_eq!(read.len(), written.len() + 1);
    for (there, here) in written.iter().zip(&read) {
        assert!((here.t_s - (there.t_s - t0_s)).abs() < 1e-12);
        assert!((here.arrived_s - (there.arrived_s - t0_s)).abs() < 1e-12);
        let same_clock = GazeSample { t_s: there.t_s, arrived_s: there.arrived_s, ..*here };
        assert_eq!(same_clock, *there);
    }
    assert!(written.iter().any(|sample| !sample.valid), "the test needs lost samples");
}

#[test]
fn playback_starts_at_zero_honours_arrival_and_ends_lost() {
    let mut recorded =
        parse("t_s,arrived_s,x_px,y_px\n100.00,100.03,1,2\n100.01,100.02,3,4\n100.02,100.06,5,6\n").expect("valid");
    assert!(played(&mut recorded, 0.029).is_empty() && played(&mut recorded, f64::INFINITY).is_empty());
    // The second sample overtook the first on its way; order is kept, so it waits.
    let first = played(&mut recorded, 0.031);
    assert_eq!(first.iter().map(|s| s.px[0]).collect::<Vec<_>>(), [1.0, 3.0]);
    assert_eq!(first[0].t_s, 0.0);
    assert_eq!(first[0].t_device_s, 100.0);
    assert_eq!(played(&mut recorded, 0.065).len(), 1);
    assert!(!recorded.finished());
    let end = played(&mut recorded, 1.0);
    assert_eq!(end.len(), 1);
    assert!(!end[0].valid && end[0].px == [5.0, 6.0]);
    assert!((end[0].t_s - 0.03).abs() < 1e-9);
    assert!(recorded.finished());
    assert!(played(&mut recorded, 2.0).is_empty());
    assert_eq!(recorded.describe()["samples"], 3);
}

#[test]
fn degrees_alone_and_lost_samples_are_enough() {
    let text = "\u{feff}x_deg, y_deg, t_s, colour\n0,0,5,red\n,,5.01,red\nNaN,NA,5.01,red\n23.374,0,5.03,blue\n";
    let mut recorded = parse(text).expect("valid");
    assert_eq!(recorded.describe()["ignored_columns"][0], "colour");
    assert_eq!(recorded.describe()["lost_samples"], 2);
    let samples = played(&mut recorded, 0.035);
    assert_eq!(samples.iter().map(|s| s.valid).collect::<Vec<_>>(), [true, false, false, true]);
    assert_eq!(samples[1].px, [960.0, 540.0]);
    // Guenter 2012: the edge of this display is at e* = 23.374°.
    assert!((samples[3].px[0] - 1920.0).abs() < 0.1);
}

#[test]
fn files_without_samples_are_refused() {
    assert_eq!(
        mistakes(""),
        ["gaze.csv:1: header: expected column names such as t_s,x_px,y_px,valid, found an empty file"]
    );
    assert_eq!(mistakes("t_s,x_px,y_px\n"), ["gaze.csv:2: row: expected at least one sample, found no rows"]);
}

#[test]
fn missing_and_doubled_columns_are_all_named() {
    assert_eq!(
        mistakes("time,pupil_mm\n1,2\n"),
        [
            "gaze.csv:1: t_s: expected a column of times in seconds, found time,pupil_mm",
            "gaze.csv:1: x_px: expected columns x_px and y_px, or x_deg and y_deg, found time,pupil_mm",
        ]
    );
    assert_eq!(
        mistakes("t_s,t_s,x_px,left_y_deg\n"),
        [
            "gaze.csv:1: t_s: expected each column once, found it twice",
            "gaze.csv:1: y_px: expected it beside its other axis, x_px, found t_s,t_s,x_px,left_y_deg",
            "gaze.csv:1: left_x_deg: expected it beside its other axis, left_y_deg, found t_s,t_s,x_px,left_y_deg",
        ]
    );
}

#[test]
fn every_bad_line_is_reported_with_its_column() {
    let text = "t_s,x_px,y_px,valid,pupil_mm\n\
                0.00,10,20,1,4.0\n\
                0.01,NaN,20,1,4.0\n\
                0.02,10,20,perhaps,4.0\n\
                0.01,10,20,1,4.0\n\
                0.03,10,20,1\n\
                soon,10,inf,1,-4.0\n\
                0.04,,,0,\n\
                0.05,2000000,,1,0\n";
    assert_eq!(
        mistakes(text),
        [
            "gaze.csv:3: x_px: expected a finite number, found NaN",
            "gaze.csv:4: valid: expected 1, 0, true or false, found perhaps",
            "gaze.csv:5: t_s: expected no time before the last row's, 0.02, found 0.01",
            "gaze.csv:6: row: expected 5 values as in the header, found 4",
            "gaze.csv:7: t_s: expected a finite number, found soon",
            "gaze.csv:7: pupil_mm: expected a diameter of 0 mm or more, or nothing, found -4.0",
            "gaze.csv:7: y_px: expected a finite number, found inf",
            "gaze.csv:9: x_px: expected pixels from -1000000 to 1000000, found 2000000",
            "gaze.csv:9: y_px: expected a finite number, found nothing",
        ]
    );
}

#[test]
fn a_recording_from_another_display_is_noticed_once() {
    let found = mistakes("t_s,x_px,y_px,x_deg,y_deg\n0,960,540,0,0\n1,1060,540,9.9,0\n2,1160,540,19,0\n");
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("gaze.csv:3: x_deg: expected 2.578 (and 0.000 on the other axis)"), "{}", found[0]);
}

#[test]
fn a_sample_cannot_arrive_before_it_is_taken() {
    assert_eq!(
        mistakes("t_s,arrived_s,x_px,y_px\n1,0.9,1,1\n"),
        ["gaze.csv:2: arrived_s: expected no time before t_s, 1, found 0.9"]
    );
}

#[test]
fn long_lists_end_in_a_count() {
    let text = format!("t_s,x_px,y_px\n{}", "x,1,1\n".repeat(50));
    let found = mistakes(&text);
    assert_eq!(found.len(), 21);
    assert_eq!(found[20], "gaze.csv: and 30 more");
}
