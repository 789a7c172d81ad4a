//! The rows of `frames.csv`.

use super::Row;
use super::cells::{Cells, Line};
use experiments::trial::PhaseName;

/// One presented frame.
#[derive(Debug, Clone, PartialEq)]
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
    pub target_x_deg: Option<f64>,
    /// The same, degrees above the centre.
    pub target_y_deg: Option<f64>,
    /// Mean colours of the frame's parts ([`crate::stage::frame_hash`]), where it was read back: what a replay on another
    /// graphics adapter, whose rounding differs, is held against. Logs of format 1 do not have it.
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

impl Row for FrameRow {
    const COLUMNS: &'static [&'static str] = &FRAME_COLUMNS;
    /// The first logs end with the hash.
    const FEWEST: usize = 13;

    fn write(&self, line: &mut Line) {
        line.whole(self.index);
        line.whole(self.phase_seq);
        line.maybe_whole(self.trial.map(u64::from));
        line.text(self.phase.as_str());
        line.real(self.scheduled_s);
        line.real(self.presented_s);
        line.bit(self.missed);
        line.real(self.animation_s);
        line.maybe_whole(self.gaze_row);
        line.maybe_real(self.gaze_age_s);
        line.maybe_whole(self.pixels_shaded);
        line.maybe_real(self.gpu_time_s);
        line.text(self.hash.as_deref().unwrap_or_default());
        line.maybe_real(self.target_x_deg);
        line.maybe_real(self.target_y_deg);
        line.text(self.signature.as_deref().unwrap_or_default());
    }

    fn read(cells: &mut Cells<'_>) -> Result<Self, String> {
        let text = |text: &str| (!text.is_empty()).then(|| text.to_owned());
        Ok(Self {
            index: cells.whole()?,
            phase_seq: cells.whole()?,
            trial: match cells.maybe_whole()? {
                None => None,
                Some(trial) => Some(u32::try_from(trial).map_err(|_| cells.problem("a trial", &trial.to_string()))?),
            },
            phase: phase(cells)?,
            scheduled_s: cells.real()?,
            presented_s: cells.real()?,
            missed: cells.bit()?,
            animation_s: cells.real()?,
            gaze_row: cells.maybe_whole()?,
            gaze_age_s: cells.maybe_real()?,
            pixels_shaded: cells.maybe_whole()?,
            gpu_time_s: cells.maybe_real()?,
            hash: text(cells.text()?),
            target_x_deg: cells.maybe_real()?,
            target_y_deg: cells.maybe_real()?,
            signature: text(cells.text()?),
        })
    }
}

fn phase(cells: &mut Cells<'_>) -> Result<PhaseName, String> {
    let name = cells.text()?;
    PhaseName::from_name(name).ok_or_else(|| cells.problem("the name of a phase", name))
}
