//! The rows of `gaze.csv` and `frames.csv`, written and read by one definition each.
//!
//! Numbers are written with as many digits as it takes to read the same value back, so a replay starts from exactly what
//! the run had. Empty cells mean "not known".

pub use crate::gaze::recorded::COLUMNS as GAZE_COLUMNS;
use crate::gaze::{EyeSample, GazeSample};
use experiments::Display;
use experiments::trial::PhaseName;
use serde::{Deserialize, Serialize};

/// A gaze sample as a CSV line, with its newline.
#[must_use]
pub fn gaze_line(sample: &GazeSample, display: &Display) -> String {
    let deg = display.deg_from_px(sample.px);
    let mut cells = vec![
        cell(sample.t_s),
        cell(sample.arrived_s),
        cell(sample.t_device_s),
        cell(sample.px[0]),
        cell(sample.px[1]),
        cell(deg[0]),
        cell(deg[1]),
        u8::from(sample.valid).to_string(),
        sample.pupil_mm.map_or_else(String::new, cell),
    ];
    for eye in [&sample.left, &sample.right] {
        cells.extend(eye_cells(eye.as_ref()));
    }
    let mut line = cells.join(",");
    line.push('\n');
    line
}

fn eye_cells(eye: Option<&EyeSample>) -> [String; 4] {
    match eye {
        Some(eye) => [
            cell(eye.px[0]),
            cell(eye.px[1]),
            u8::from(eye.valid).to_string(),
            eye.pupil_mm.map_or_else(String::new, cell),
        ],
        None => Default::default(),
    }
}

/// The shortest text that reads back as the same number; empty for what is not a number.
fn cell(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

/// One presented frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameRow {
    /// Number within the session, from 0.
    pub index: u64,
    /// Number of the journal's event that began the phase shown.
    pub phase_seq: u64,
    /// Trial, if in one.
    pub trial: Option<u32>,
    /// Phase.
    pub phase: PhaseName,
    /// When the frame was due, seconds.
    pub scheduled_s: f64,
    /// When it was handed to the display, seconds (software time, not light).
    pub presented_s: f64,
    /// Whether it came more than half a frame late.
    #[serde(with = "zero_or_one")]
    pub missed: bool,
    /// Animation time of the scene, seconds.
    pub animation_s: f64,
    /// Row of `gaze.csv`, from 0, that placed the stimulus; empty before the first sample.
    pub gaze_row: Option<u64>,
    /// Age of that sample when the frame was presented, seconds.
    pub gaze_age_s: Option<f64>,
    /// Pixels shaded; empty when nothing was drawn.
    pub pixels_shaded: Option<u64>,
    /// GPU time, seconds, where it is known.
    pub gpu_time_s: Option<f64>,
    /// XXH3-64 of the frame's 8-bit RGBA bytes, where it was read back.
    pub hash: Option<String>,
    /// Where observers were to look while a stimulus was shown, degrees to the right of the display's centre; empty with
    /// free viewing. Logs from before there were moving targets do not have it.
    #[serde(default)]
    pub target_x_deg: Option<f64>,
    /// The same, degrees above the centre.
    #[serde(default)]
    pub target_y_deg: Option<f64>,
    /// Mean colours of the frame's parts ([`crate::stage::frame_hash`]), where it was read back: what a replay on another
    /// graphics adapter, whose rounding differs, is held against.
    #[serde(default)]
    pub signature: Option<String>,
}

/// Columns of `frames.csv`, in the order of [`FrameRow`]'s fields.
pub const FRAME_COLUMNS: [&str; 16] = [
    "index",
    "phase_seq",
    "trial",
    "phase",
    "scheduled_s",
    "presented_s",
    "missed",
    "animation_s",
    "gaze_row",
    "gaze_age_s",
    "pixels_shaded",
    "gpu_time_s",
    "hash",
    "target_x_deg",
    "target_y_deg",
    "signature",
];

/// A frame as a CSV line, with its newline.
#[must_use]
pub fn frame_line(row: &FrameRow) -> String {
    let number = |value: Option<u64>| value.map_or_else(String::new, |value| value.to_string());
    let real = |value: Option<f64>| value.map_or_else(String::new, cell);
    let mut line = [
        row.index.to_string(),
        row.phase_seq.to_string(),
        number(row.trial.map(u64::from)),
        row.phase.as_str().to_owned(),
        cell(row.scheduled_s),
        cell(row.presented_s),
        u8::from(row.missed).to_string(),
        cell(row.animation_s),
        number(row.gaze_row),
        real(row.gaze_age_s),
        number(row.pixels_shaded),
        real(row.gpu_time_s),
        row.hash.clone().unwrap_or_default(),
        real(row.target_x_deg),
        real(row.target_y_deg),
        row.signature.clone().unwrap_or_default(),
    ]
    .join(",");
    line.push('\n');
    line
}

/// One row of `gaze.csv`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(from = "GazeCells")]
pub struct GazeRow {
    /// When the eye was there, seconds.
    pub t_s: f64,
    /// When the program had the sample, seconds.
    pub arrived_s: f64,
    /// The tracker's own time, seconds; not a number where it is not known.
    pub t_device_s: f64,
    /// Place in pixels.
    pub x_px: f64,
    /// Place in pixels.
    pub y_px: f64,
    /// Place in degrees.
    pub x_deg: f64,
    /// Place in degrees.
    pub y_deg: f64,
    /// Whether the tracker saw the eye.
    pub valid: bool,
    /// Pupil diameter in millimetres, where the tracker measured one.
    pub pupil_mm: Option<f64>,
    /// The left eye, where the tracker tells the eyes apart.
    pub left: Option<EyeSample>,
    /// The right eye, where the tracker tells the eyes apart.
    pub right: Option<EyeSample>,
}

/// The cells of a row of `gaze.csv`.
#[derive(Deserialize)]
struct GazeCells {
    t_s: f64,
    arrived_s: f64,
    t_device_s: Option<f64>,
    x_px: f64,
    y_px: f64,
    x_deg: f64,
    y_deg: f64,
    #[serde(with = "zero_or_one")]
    valid: bool,
    pupil_mm: Option<f64>,
    left_x_px: Option<f64>,
    left_y_px: Option<f64>,
    left_valid: Option<u8>,
    left_pupil_mm: Option<f64>,
    right_x_px: Option<f64>,
    right_y_px: Option<f64>,
    right_valid: Option<u8>,
    right_pupil_mm: Option<f64>,
}

impl From<GazeCells> for GazeRow {
    fn from(cells: GazeCells) -> Self {
        let eye = |place: [Option<f64>; 2], valid: Option<u8>, pupil_mm| {
            let [Some(x), Some(y)] = place else { return None };
            Some(EyeSample { px: [x, y], valid: valid == Some(1), pupil_mm })
        };
        Self {
            t_s: cells.t_s,
            arrived_s: cells.arrived_s,
            t_device_s: cells.t_device_s.unwrap_or(f64::NAN),
            x_px: cells.x_px,
            y_px: cells.y_px,
            x_deg: cells.x_deg,
            y_deg: cells.y_deg,
            valid: cells.valid,
            pupil_mm: cells.pupil_mm,
            left: eye([cells.left_x_px, cells.left_y_px], cells.left_valid, cells.left_pupil_mm),
            right: eye([cells.right_x_px, cells.right_y_px], cells.right_valid, cells.right_pupil_mm),
        }
    }
}

/// What was wrong with a table: its sound rows, and a sentence for the rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Table<T> {
    /// Rows before the first damage.
    pub rows: Vec<T>,
    /// What was wrong after them.
    pub damage: Option<TableDamage>,
}

/// What is wrong with a table.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TableDamage {
    /// The last line is incomplete, as after a kill.
    #[error("the last line ({0} bytes) is torn")]
    Torn(usize),
    /// A whole line cannot be read; the text names it.
    #[error("{0}")]
    Corrupt(String),
}

/// Reads a table up to its first damage. A last line without newline is torn, as after a kill, and is left out.
#[must_use]
pub fn read_rows<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> Table<T> {
    let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    let mut table =
        Table { rows: Vec::new(), damage: (whole < bytes.len()).then(|| TableDamage::Torn(bytes.len() - whole)) };
    let mut reader = csv::Reader::from_reader(&bytes[..whole]);
    for (index, row) in reader.deserialize().enumerate() {
        match row {
            Ok(row) => table.rows.push(row),
            Err(error) => {
                table.damage = Some(TableDamage::Corrupt(format!("line {}: {error}", index + 2)));
                break;
            }
        }
    }
    table
}

/// Booleans as 0 and 1, which R and pandas read as numbers.
mod zero_or_one {
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::ser::Serializer;

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
    pub(super) fn serialize<S: Serializer>(value: &bool, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(u8::from(*value))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
        match u8::deserialize(deserializer)? {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(D::Error::custom(format!("expected 0 or 1, found {other}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn frames_read_back_bit_for_bit_and_a_torn_tail_is_left_out() {
        let rows: Vec<FrameRow> = (0..3).map(row).collect();
        let mut text = FRAME_COLUMNS.join(",") + "\n";
        rows.iter().for_each(|row| text.push_str(&frame_line(row)));
        let table = read_rows::<FrameRow>(text.as_bytes());
        assert_eq!(table, Table { rows: rows.clone(), damage: None });
        let torn = read_rows::<FrameRow>(&text.as_bytes()[..text.len() - 4]);
        assert_eq!(torn.rows, rows[..2]);
        assert!(matches!(torn.damage, Some(TableDamage::Torn(_))));
        let corrupt = read_rows::<FrameRow>(text.replace(",interval1,", ",intervall,").as_bytes());
        assert_eq!(corrupt.rows, []);
        assert!(matches!(corrupt.damage, Some(TableDamage::Corrupt(problem)) if problem.starts_with("line 2")));
    }

    /// What a session of an earlier version looks like: without the columns at the end.
    #[test]
    fn frames_of_earlier_versions_read_back_without_what_they_did_not_have() {
        let columns = FRAME_COLUMNS.len() - 3;
        let text = "index,phase_seq,trial,phase,scheduled_s,presented_s,missed,animation_s,gaze_row,gaze_age_s,\
                    pixels_shaded,gpu_time_s,hash\n\
                    0,7,3,interval1,0.5,0.51,0,0.25,12,,518400,,00ff\n";
        assert_eq!(text.lines().next(), Some(FRAME_COLUMNS[..columns].join(",").as_str()));
        let table = read_rows::<FrameRow>(text.as_bytes());
        assert_eq!(table.damage, None);
        assert_eq!(
            (table.rows[0].hash.as_deref(), table.rows[0].animation_s.to_bits()),
            (Some("00ff"), 0.25f64.to_bits())
        );
        assert_eq!((table.rows[0].target_x_deg, table.rows[0].target_y_deg), (None, None));
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
        let text = GAZE_COLUMNS.join(",") + "\n" + &gaze_line(&seen, &display) + &gaze_line(&lost, &display);
        let table = read_rows::<GazeRow>(text.as_bytes());
        assert_eq!(table.damage, None);
        assert!((table.rows[0].x_px - 480.0).abs() < 1e-12);
        assert!(table.rows[0].x_deg.abs() < 1e-12);
        assert!(!table.rows[1].valid);
        assert_eq!((table.rows[0].left, table.rows[0].right, table.rows[1].left), (Some(eye), None, None));
        assert_eq!((table.rows[0].pupil_mm, table.rows[1].pupil_mm), (Some(3.25), None));
    }
}
