//! Any bytes are a table up to their first damage, or a gaze file with mistakes; what was read is written again the same.
#![no_main]

use experiments::Display;
use libfuzzer_sys::fuzz_target;
use parafovea::gaze::{GazeSource, Recorded};
use parafovea::session::tables::{FrameRow, GazeRow, Layout, Row, read_rows};

fn again<R: Row>(bytes: &[u8]) {
    for format in [1, 2] {
        let table = read_rows::<R>(bytes, format);
        assert!(table.sound_bytes <= bytes.len());
        // Sealed anew, every row that was read comes back.
        let (mut layout, mut text) = Layout::<R>::new(2);
        table.rows.iter().for_each(|row| text += &layout.line(row));
        let read = read_rows::<R>(text.as_bytes(), 2);
        assert_eq!(read.damage, None);
        assert_eq!(read.rows.len(), table.rows.len());
    }
}

fuzz_target!(|bytes: &[u8]| {
    again::<GazeRow>(bytes);
    again::<FrameRow>(bytes);
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Some(display) = Display::named("demo-540p") else { return };
    match Recorded::parse("gaze.csv", text, &display) {
        Ok(mut recorded) => {
            let mut samples = Vec::new();
            recorded.poll(f64::MAX, &mut samples);
            assert!(samples.iter().all(|sample| sample.px.iter().all(|place| place.is_finite())));
        }
        Err(mistakes) => assert!(!mistakes.is_empty()),
    }
});
