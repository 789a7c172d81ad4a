//! The rows of `gaze.csv`.

use super::Row;
use super::cells::{Cells, Line};
pub use crate::gaze::recorded::COLUMNS as GAZE_COLUMNS;
use crate::gaze::{EyeSample, GazeSample};
use experiments::Display;

/// One gaze sample as it stands in the table: the sample, and its place in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GazeRow {
    /// When the eye was there, seconds.
    pub t_s: f64,
    /// When the program had the sample, seconds.
    pub arrived_s: f64,
    /// The tracker's own time, seconds.
    pub t_device_s: f64,
    /// Place in pixels, right of the display's left edge.
    pub x_px: f64,
    /// Place in pixels, below the display's top edge.
    pub y_px: f64,
    /// Place in degrees, right of the display's centre.
    pub x_deg: f64,
    /// Place in degrees, above the display's centre.
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

impl GazeRow {
    /// The row of a sample on a display.
    #[must_use]
    pub fn of(sample: &GazeSample, display: &Display) -> Self {
        let [x_deg, y_deg] = display.deg_from_px(sample.px);
        let GazeSample { t_s, arrived_s, t_device_s, px: [x_px, y_px], valid, pupil_mm, left, right } = *sample;
        Self { t_s, arrived_s, t_device_s, x_px, y_px, x_deg, y_deg, valid, pupil_mm, left, right }
    }
}

impl Row for GazeRow {
    const COLUMNS: &'static [&'static str] = &GAZE_COLUMNS;
    const FEWEST: usize = GAZE_COLUMNS.len();

    fn write(&self, line: &mut Line) {
        for value in [self.t_s, self.arrived_s, self.t_device_s, self.x_px, self.y_px, self.x_deg, self.y_deg] {
            line.real(value);
        }
        line.bit(self.valid);
        line.maybe_real(self.pupil_mm);
        for eye in [&self.left, &self.right] {
            match eye {
                Some(eye) => {
                    line.real(eye.px[0]);
                    line.real(eye.px[1]);
                    line.bit(eye.valid);
                    line.maybe_real(eye.pupil_mm);
                }
                None => (0..4).for_each(|_| line.text("")),
            }
        }
    }

    fn read(cells: &mut Cells<'_>) -> Result<Self, String> {
        Ok(Self {
            t_s: cells.real()?,
            arrived_s: cells.real()?,
            t_device_s: cells.real()?,
            x_px: cells.real()?,
            y_px: cells.real()?,
            x_deg: cells.real()?,
            y_deg: cells.real()?,
            valid: cells.bit()?,
            pupil_mm: cells.maybe_real()?,
            left: eye(cells)?,
            right: eye(cells)?,
        })
    }
}

fn eye(cells: &mut Cells<'_>) -> Result<Option<EyeSample>, String> {
    let place = [cells.maybe_real()?, cells.maybe_real()?];
    match place {
        [Some(x), Some(y)] => Ok(Some(EyeSample { px: [x, y], valid: cells.bit()?, pupil_mm: cells.maybe_real()? })),
        _ => {
            // An eye that the tracker does not tell apart has no cells at all.
            for _ in 0..2 {
                match cells.text()? {
                    "" => {}
                    other => return Err(cells.problem("nothing for an eye without a place", other)),
                }
            }
            Ok(None)
        }
    }
}
