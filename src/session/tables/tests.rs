//! Tables: what is written is read, and what was changed is found at its line.

use super::*;
use crate::gaze::{EyeSample, GazeSample};
use experiments::Display;
use experiments::trial::PhaseName;

fn row(index: u64) -> FrameRow {
    FrameRow {
        index,
        phase_seq: 7,
        trial: index.is_multiple_of(2).then_some(3),
        phase: PhaseName::Interval1,
        scheduled_s: 0.1 + 0.2,
        presented_s: 1.0 / 3.0,
        missed: index == 1,
        animation_s: 1e-17,
        gaze_row: Some(12),
        gaze_age_s: None,
        pixels_shaded: Some(518_400),
        gpu_time_s: None,
        hash: Some("00ff".to_owned()),
        target_x_deg: (index > 0).then_some(-0.1 - 0.2),
        target_y_deg: (index > 0).then_some(1.0 / 7.0),
        signature: (index > 0).then(|| "00ff".to_owned()),
    }
}

fn text<R: Row>(rows: &[R], format: u32) -> String {
    let (mut layout, mut text) = Layout::new(format);
    rows.iter().for_each(|row| text.push_str(&layout.line(row)));
    text
}

#[test]
fn frames_read_back_bit_for_bit_and_a_torn_tail_is_left_out() {
    for format in [1, 2] {
        let rows: Vec<FrameRow> = (0..3).map(row).collect();
        let text = text(&rows, format);
        let table = read_rows::<FrameRow>(text.as_bytes(), format);
        assert_eq!((&table.rows, &table.damage, table.sound_bytes), (&rows, &None, text.len()));
        let torn = read_rows::<FrameRow>(&text.as_bytes()[..text.len() - 4], format);
        assert_eq!(torn.rows, rows[..2]);
        assert!(matches!(torn.damage, Some(TableDamage::Torn(_))));
        let corrupt = read_rows::<FrameRow>(text.replace(",interval1,", ",intervall,").as_bytes(), format);
        assert_eq!(corrupt.rows, []);
        assert!(matches!(corrupt.damage, Some(TableDamage::Corrupt(problem)) if problem.starts_with("line 2")));
    }
}

/// What a session of an earlier version looks like: without the columns at the end.
#[test]
fn frames_of_earlier_versions_read_back_without_what_they_did_not_have_and_go_on_so() {
    let text = "index,phase_seq,trial,phase,scheduled_s,presented_s,missed,animation_s,gaze_row,gaze_age_s,\
                pixels_shaded,gpu_time_s,hash\n\
                0,7,3,interval1,0.5,0.51,0,0.25,12,,518400,,00ff\n";
    let table = read_rows::<FrameRow>(text.as_bytes(), 1);
    assert_eq!(table.damage, None);
    assert_eq!((table.rows[0].hash.as_deref(), table.rows[0].animation_s.to_bits()), (Some("00ff"), 0.25f64.to_bits()));
    assert_eq!((table.rows[0].target_x_deg, table.rows[0].target_y_deg), (None, None));
    let mut layout = table.layout.expect("a first line");
    assert_eq!(text.lines().nth(1).map(|line| format!("{line}\n")), Some(layout.line(&table.rows[0])));
    assert!(matches!(read_rows::<FrameRow>(text.as_bytes(), 2).damage, Some(TableDamage::Corrupt(_))));
}

#[test]
fn gaze_reads_back_and_lost_samples_stay_lost() {
    let display = Display::named("demo-540p").expect("ships");
    let eye = EyeSample { px: [1.5, 2.5], valid: true, pupil_mm: Some(3.0) };
    let seen = GazeSample {
        t_s: 0.1,
        arrived_s: 0.104,
        t_device_s: 5.1,
        px: [480.0, 270.0],
        valid: true,
        pupil_mm: Some(3.25),
        left: Some(eye),
        right: None,
    };
    let lost = GazeSample { valid: false, pupil_mm: None, left: None, ..seen };
    let rows = [seen, lost].map(|sample| GazeRow::of(&sample, &display));
    for format in [1, 2] {
        let table = read_rows::<GazeRow>(text(&rows, format).as_bytes(), format);
        assert_eq!((table.rows.as_slice(), table.damage), (rows.as_slice(), None));
        assert!(table.rows[0].x_deg.abs() < 1e-12);
    }
}

/// The documented rule, with a CRC-32 of another implementation: `zlib.crc32(b"1234567890,7")` of Python 3.11.
#[test]
fn the_crc_is_what_it_is_said_to_be() {
    assert_eq!(crc_after(123_456_789, b"0,7"), 0xd232_7305);
    for value in [0, 7, 10, 4_294_967_295] {
        assert_eq!(digits(value, &mut [0; 10]), value.to_string().as_bytes());
    }
}

/// Every flipped bit, dropped line and swapped pair of lines is found at its line, and all rows before it are kept.
#[test]
fn every_change_is_found_at_its_line() {
    let rows: Vec<FrameRow> = (0..5).map(row).collect();
    let whole = text(&rows, 2);
    let first = whole.find('\n').expect("lines") + 1;
    for at in 0..whole.len() {
        for bit in 0..8 {
            let mut bytes = whole.clone().into_bytes();
            bytes[at] ^= 1 << bit;
            let table = read_rows::<FrameRow>(&bytes, 2);
            assert!(table.damage.is_some(), "byte {at} bit {bit}");
            let lines = whole[..at].matches('\n').count();
            assert_eq!(table.rows.len(), lines.saturating_sub(1), "byte {at} bit {bit}: {:?}", table.damage);
        }
    }
    let lines: Vec<&str> = whole[first..].split_inclusive('\n').collect();
    for order in [[1usize, 0, 2, 3, 4].as_slice(), &[0, 2, 1, 3, 4], &[0, 1, 2, 4], &[1, 2, 3, 4], &[0, 1, 1, 2]] {
        let mixed: String = whole[..first].to_owned() + &order.iter().map(|&at| lines[at]).collect::<String>();
        let table = read_rows::<FrameRow>(mixed.as_bytes(), 2);
        assert!(matches!(table.damage, Some(TableDamage::Corrupt(_))), "{order:?}");
        let sound = order.iter().enumerate().take_while(|&(place, &at)| place == at).count();
        assert_eq!(table.rows, rows[..sound], "{order:?}");
    }
}

/// Tables of several chunks are read in parallel; damage is found where a reading from the front finds it.
#[test]
fn large_tables_are_read_in_chunks() {
    let rows: Vec<FrameRow> = (0..30_000).map(row).collect();
    let whole = text(&rows, 2);
    assert!(whole.len() > 2 * CHUNK_BYTES);
    let table = read_rows::<FrameRow>(whole.as_bytes(), 2);
    assert_eq!((table.rows == rows, table.damage, table.sound_bytes), (true, None, whole.len()));
    // The last line of the first chunk and the first one of the second are the places where threads meet.
    let (_, end) = chunks(&whole.as_bytes()[whole.find('\n').expect("lines") + 1..])[0];
    let end = end + whole.find('\n').expect("lines") + 1;
    for at in [end - 10, end - 2, end, end + 3, whole.len() - 5] {
        let mut bytes = whole.clone().into_bytes();
        bytes[at] ^= 2;
        let table = read_rows::<FrameRow>(&bytes, 2);
        let line = whole[..at].matches('\n').count();
        assert!(matches!(table.damage, Some(TableDamage::Corrupt(_))));
        assert_eq!(table.rows.len(), line - 1, "byte {at}");
        assert_eq!(bytes[..table.sound_bytes].iter().filter(|&&byte| byte == b'\n').count(), line);
    }
}
