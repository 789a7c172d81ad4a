//! Reading a table of gaze samples, with every mistake at its line and column.

use super::{EyeSample, GazeSample};
use crate::mistakes::{CsvMistake, Mistakes};
use experiments::Display;

/// The columns that a gaze file may have, in the order in which sessions write them; `left_` and `right_` also go with
/// `x_deg` and `y_deg`.
pub const COLUMNS: [&str; 17] = [
    "t_s",
    "arrived_s",
    "t_device_s",
    "x_px",
    "y_px",
    "x_deg",
    "y_deg",
    "valid",
    "pupil_mm",
    "left_x_px",
    "left_y_px",
    "left_valid",
    "left_pupil_mm",
    "right_x_px",
    "right_y_px",
    "right_valid",
    "right_pupil_mm",
];

/// Pixels and degrees of one sample may differ by the rounding of whoever wrote them, in degrees.
const AGREEMENT_DEG: f64 = 0.05;
/// Places farther from the display's origin are taken for mistakes, in pixels.
const MAX_PX: f64 = 1e6;
/// Places farther from the display's centre are taken for mistakes, in degrees of one axis.
const MAX_DEG: f64 = 89.0;
/// Values that stand for a missing number, in lower case.
const MISSING: [&str; 3] = ["", "na", "nan"];

/// A table without mistakes: samples in the file's own time.
pub(super) struct Table {
    pub(super) samples: Vec<GazeSample>,
    pub(super) ignored_columns: Vec<String>,
}

/// Reads the whole text.
pub(super) fn read(file: &str, text: &str, display: &Display) -> Result<Table, Vec<CsvMistake>> {
    let mut mistakes = Mistakes::of(file);
    let mut reader = csv::ReaderBuilder::new()
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let header = match reader.headers() {
        Ok(header) if !header.is_empty() => header.clone(),
        Ok(_) => {
            mistakes.add(1, "header", "column names such as t_s,x_px,y_px,valid", "an empty file");
            return Err(mistakes.all());
        }
        Err(error) => {
            mistakes.add(1, "header", "comma-separated column names", error);
            return Err(mistakes.all());
        }
    };
    let (columns, ignored_columns) = Columns::find(&header, &mut mistakes);
    let Some(columns) = columns else {
        return Err(mistakes.all());
    };

    let centre = display.resolution_px().map(|extent| 0.5 * f64::from(extent));
    let mut rows =
        Rows { header: &header, columns, display, last_t_s: None, last_px: [centre; 3], disagreed: false, mistakes };
    let mut samples = Vec::new();
    for (index, record) in reader.records().enumerate() {
        match record {
            Ok(record) => samples.extend(rows.sample(&record)),
            Err(error) => rows.mistakes.add(index as u64 + 2, "row", "comma-separated values", error),
        }
    }
    let mut mistakes = rows.mistakes;
    if samples.is_empty() && mistakes.none() {
        mistakes.add(2, "row", "at least one sample", "no rows");
    }
    if mistakes.none() { Ok(Table { samples, ignored_columns }) } else { Err(mistakes.all()) }
}

/// Where the columns of a table are.
struct Columns {
    t_s: usize,
    arrived_s: Option<usize>,
    t_device_s: Option<usize>,
    /// The combined gaze, the left and the right eye.
    eyes: [Option<EyeColumns>; 3],
}

/// The columns of one eye; at least one of the pairs is there.
#[derive(Clone, Copy)]
struct EyeColumns {
    px: Option<[usize; 2]>,
    deg: Option<[usize; 2]>,
    valid: Option<usize>,
    pupil_mm: Option<usize>,
}

impl Columns {
    /// The columns of a header, if it has what is needed, and the names that mean nothing here.
    fn find(header: &csv::StringRecord, mistakes: &mut Mistakes) -> (Option<Self>, Vec<String>) {
        let mut used = vec![false; header.len()];
        for (index, name) in header.iter().enumerate() {
            if header.iter().take(index).any(|earlier| earlier == name) {
                mistakes.add(1, name, "each column once", "it twice");
            }
        }
        let mut find = |name: &str| {
            let index = header.iter().position(|there| there == name)?;
            used[index] = true;
            Some(index)
        };
        let found = header.iter().collect::<Vec<_>>().join(",");

        let t_s = find("t_s");
        if t_s.is_none() {
            mistakes.add(1, "t_s", "a column of times in seconds", &found);
        }
        let (arrived_s, t_device_s) = (find("arrived_s"), find("t_device_s"));
        let eyes = ["", "left_", "right_"].map(|eye| {
            let mut pair = |unit: &str| {
                let names = ["x", "y"].map(|axis| format!("{eye}{axis}_{unit}"));
                match (find(&names[0]), find(&names[1])) {
                    (Some(x), Some(y)) => Some([x, y]),
                    (None, None) => None,
                    (x, _) => {
                        let missing = &names[usize::from(x.is_some())];
                        mistakes.add(
                            1,
                            missing,
                            format!("it beside its other axis, {}", names[usize::from(x.is_none())]),
                            &found,
                        );
                        None
                    }
                }
            };
            let (px, deg) = (pair("px"), pair("deg"));
            let (valid, pupil_mm) = (find(&format!("{eye}valid")), find(&format!("{eye}pupil_mm")));
            (px.is_some() || deg.is_some()).then_some(EyeColumns { px, deg, valid, pupil_mm })
        });
        if eyes[0].is_none() && mistakes.listed().iter().all(|m| !names_place(m)) {
            mistakes.add(1, "x_px", "columns x_px and y_px, or x_deg and y_deg", &found);
        }

        let ignored = header.iter().zip(&used).filter(|(_, used)| !**used).map(|(name, _)| name.to_owned());
        let ignored = ignored.collect();
        let complete = mistakes.none();
        let columns = t_s.filter(|_| complete).map(|t_s| Self { t_s, arrived_s, t_device_s, eyes });
        (columns, ignored)
    }
}

/// Whether a mistake already says that half of the combined place is missing.
fn names_place(mistake: &CsvMistake) -> bool {
    matches!(mistake, CsvMistake::At { column, .. } if ["x_px", "y_px", "x_deg", "y_deg"].contains(&column.as_str()))
}

/// Turns rows into samples, remembering what must hold from row to row.
struct Rows<'a> {
    header: &'a csv::StringRecord,
    columns: Columns,
    display: &'a Display,
    last_t_s: Option<f64>,
    /// The last valid place of the combined gaze, the left and the right eye.
    last_px: [[f64; 2]; 3],
    disagreed: bool,
    mistakes: Mistakes<'a>,
}

impl Rows<'_> {
    /// The sample of a row; rows with a mistake may give none, since then the whole table is refused.
    fn sample(&mut self, row: &csv::StringRecord) -> Option<GazeSample> {
        let line = row.position().map_or(0, csv::Position::line);
        if row.len() != self.header.len() {
            let expected = format!("{} values as in the header", self.header.len());
            self.mistakes.add(line, "row", expected, row.len());
            return None;
        }
        let t_s = self.required(row, line, self.columns.t_s);
        if let (Some(t_s), Some(last_t_s)) = (t_s, self.last_t_s)
            && t_s < last_t_s
        {
            self.add(row, line, self.columns.t_s, format!("no time before the last row's, {last_t_s}"));
        }
        self.last_t_s = t_s.or(self.last_t_s);
        let arrived_s = self.columns.arrived_s.map(|index| self.required(row, line, index));
        if let (Some(t_s), Some(Some(arrived_s)), Some(index)) = (t_s, arrived_s, self.columns.arrived_s)
            && arrived_s < t_s
        {
            self.add(row, line, index, format!("no time before t_s, {t_s}"));
        }
        let t_device_s = self.columns.t_device_s.map(|index| self.required(row, line, index));
        let [combined, left, right] = std::array::from_fn(|eye| {
            let columns = self.columns.eyes[eye]?;
            Some(self.eye(row, line, eye, columns))
        });
        let combined = combined??;
        let t_s = t_s?;
        Some(GazeSample {
            t_s,
            arrived_s: arrived_s.flatten().unwrap_or(t_s),
            t_device_s: t_device_s.flatten().unwrap_or(t_s),
            px: combined.px,
            valid: combined.valid,
            pupil_mm: combined.pupil_mm,
            left: left.flatten(),
            right: right.flatten(),
        })
    }

    /// One eye's part of a row, or `None` after a mistake.
    fn eye(&mut self, row: &csv::StringRecord, line: u64, eye: usize, columns: EyeColumns) -> Option<EyeSample> {
        let said_valid = match columns.valid {
            Some(index) => Some(self.flag(row, line, index)?),
            None => None,
        };
        let absent = columns.px.into_iter().chain(columns.deg).flatten().all(|index| missing(&row[index]));
        let valid = said_valid.unwrap_or(!absent);
        let pupil_mm = match columns.pupil_mm {
            Some(index) if !missing(&row[index]) => {
                let pupil_mm = self.required(row, line, index)?;
                if pupil_mm < 0.0 {
                    self.add(row, line, index, "a diameter of 0 mm or more, or nothing");
                }
                // A zero is how trackers write an unseen pupil.
                (valid && pupil_mm > 0.0).then_some(pupil_mm)
            }
            _ => None,
        };
        if valid {
            self.last_px[eye] = self.place_px(row, line, columns)?;
        }
        Some(EyeSample { px: self.last_px[eye], valid, pupil_mm })
    }

    /// The place of a valid sample in pixels.
    fn place_px(&mut self, row: &csv::StringRecord, line: u64, columns: EyeColumns) -> Option<[f64; 2]> {
        let deg = match columns.deg {
            Some(pair) => Some(self.pair(row, line, pair, MAX_DEG, "degrees")?),
            None => None,
        };
        let Some(px_columns) = columns.px else {
            return deg.map(|deg| self.display.px_from_deg(deg));
        };
        let px = self.pair(row, line, px_columns, MAX_PX, "pixels")?;
        if let (Some(deg), Some(deg_columns)) = (deg, columns.deg)
            && !self.disagreed
            && self.display.eccentricity_deg(self.display.deg_from_px(px), deg) > AGREEMENT_DEG
        {
            self.disagreed = true;
            let [x, y] = self.display.deg_from_px(px);
            let expected = format!(
                "{x:.3} (and {y:.3} on the other axis), where the row's pixels are on the display {}; recorded on \
                 another display? Keep only the columns in degrees, or only those in pixels",
                self.display.name()
            );
            self.add(row, line, deg_columns[0], expected);
        }
        Some(px)
    }

    fn pair(&mut self, row: &csv::StringRecord, line: u64, pair: [usize; 2], max: f64, unit: &str) -> Option<[f64; 2]> {
        let [x, y] = pair.map(|index| {
            let value = self.required(row, line, index)?;
            if value.abs() > max {
                self.add(row, line, index, format!("{unit} from -{max} to {max}"));
            }
            Some(value)
        });
        Some([x?, y?])
    }

    /// A finite number, or `None` after a mistake.
    fn required(&mut self, row: &csv::StringRecord, line: u64, index: usize) -> Option<f64> {
        let value = row[index].parse::<f64>().ok().filter(|value| value.is_finite());
        if value.is_none() {
            self.add(row, line, index, "a finite number");
        }
        value
    }

    fn flag(&mut self, row: &csv::StringRecord, line: u64, index: usize) -> Option<bool> {
        match row[index].to_ascii_lowercase().as_str() {
            "1" | "true" => Some(true),
            "0" | "false" => Some(false),
            _ => {
                self.add(row, line, index, "1, 0, true or false");
                None
            }
        }
    }

    fn add(&mut self, row: &csv::StringRecord, line: u64, index: usize, expected: impl Into<String>) {
        let found = if row[index].is_empty() { "nothing" } else { &row[index] };
        self.mistakes.add(line, &self.header[index], expected, found);
    }
}

fn missing(value: &str) -> bool {
    MISSING.contains(&value.to_ascii_lowercase().as_str())
}
