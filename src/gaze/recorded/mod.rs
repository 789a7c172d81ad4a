//! Gaze from a file: the samples of an earlier session, or any table with the same columns.
//!
//! [`Recorded::parse`] checks a whole CSV text and reports every mistake at once; playback then hands the samples over
//! in session time, with the file's first sample at 0. It does not read files: whoever does names the file in messages.

mod table;
#[cfg(test)]
mod tests;

pub use crate::mistakes::CsvMistake;
pub use table::COLUMNS;

use super::{EyeSample, GazeSample, GazeSource};
use experiments::Display;
use serde_json::json;

/// Samples of a file, played back.
#[derive(Debug)]
pub struct Recorded {
    file: String,
    samples: Vec<GazeSample>,
    next: usize,
    interval_s: f64,
    first_t_s: f64,
    ignored_columns: Vec<String>,
}

impl Recorded {
    /// Reads a CSV text with a header line; `file` names it in mistakes and in the session header.
    ///
    /// Required columns: `t_s` (seconds, never decreasing) and `x_px`, `y_px` (pixels of `display`, origin top left) or
    /// `x_deg`, `y_deg` (degrees from its centre, x right, y up). With both pairs pixels count, and a file in which the
    /// two disagree by more than 0.05° was made on another display and is refused until one pair is removed. Optional:
    /// `t_device_s` (else the file's `t_s`), `arrived_s` (else no latency), `valid` (0, 1, false, true), `pupil_mm`,
    /// and with the prefixes `left_` and `right_` the place, validity and pupil of each eye. Other columns are ignored
    /// and listed by [`GazeSource::describe`].
    ///
    /// A sample is lost when `valid` says so; its place may then be empty. Without a `valid` column it is lost when
    /// both coordinates are empty, `NA` or `NaN`.
    ///
    /// # Errors
    /// Every mistake of the text in the order of its lines, up to 20, and then how many more there are.
    pub fn parse(file: &str, text: &str, display: &Display) -> Result<Self, Vec<CsvMistake>> {
        let table::Table { samples, ignored_columns } = table::read(file, text, display)?;
        Ok(Self { ignored_columns, ..Self::of(file, samples) })
    }

    /// Plays back samples in the order of their times; `file` says where they are from.
    #[must_use]
    pub fn of(file: &str, mut samples: Vec<GazeSample>) -> Self {
        // Move the recording to session time 0, keeping each sample's latency.
        let first_t_s = samples.first().map_or(0.0, |sample| sample.t_s);
        let mut arrived_s = f64::NEG_INFINITY;
        for sample in &mut samples {
            sample.t_s -= first_t_s;
            arrived_s = (sample.arrived_s - first_t_s).max(arrived_s).max(sample.t_s);
            sample.arrived_s = arrived_s;
        }

        let interval_s = median_interval_s(&samples);
        if let Some(end) = samples.last().copied() {
            samples.push(lost_after(end, interval_s));
        }
        Self { file: file.to_owned(), samples, next: 0, interval_s, first_t_s, ignored_columns: Vec::new() }
    }

    /// Whether every sample has been handed over.
    #[must_use]
    pub fn finished(&self) -> bool {
        self.next == self.samples.len()
    }

    /// How many samples the file holds.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples.len().saturating_sub(1)
    }
}

/// The sample that ends a recording: gaze is lost one interval after the last one, and so remains.
fn lost_after(end: GazeSample, interval_s: f64) -> GazeSample {
    let lost = |eye: EyeSample| EyeSample { valid: false, pupil_mm: None, ..eye };
    GazeSample {
        t_s: end.t_s + interval_s,
        arrived_s: end.arrived_s + interval_s,
        t_device_s: end.t_device_s + interval_s,
        valid: false,
        pupil_mm: None,
        left: end.left.map(lost),
        right: end.right.map(lost),
        ..end
    }
}

/// The median time between samples, in seconds; 1/60 s when the file has none to tell.
fn median_interval_s(samples: &[GazeSample]) -> f64 {
    let mut intervals_s: Vec<f64> =
        samples.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).filter(|&interval_s| interval_s > 0.0).collect();
    intervals_s.sort_by(f64::total_cmp);
    intervals_s.get(intervals_s.len() / 2).copied().unwrap_or(1.0 / 60.0)
}

impl GazeSource for Recorded {
    fn id(&self) -> &'static str {
        "recorded"
    }

    fn describe(&self) -> serde_json::Value {
        let recorded = &self.samples[..self.samples()];
        let lost = recorded.iter().filter(|sample| !sample.valid).count();
        json!({
            "id": self.id(),
            "file": self.file,
            "samples": recorded.len(),
            "duration_s": recorded.last().map(|sample| sample.t_s),
            "median_interval_s": self.interval_s,
            "lost_samples": lost,
            "file_t_s_at_session_0": self.first_t_s,
            "ignored_columns": self.ignored_columns,
        })
    }

    /// After the last sample of the file comes one more that is lost, one median interval later, and then nothing: a
    /// recording that is too short reads as lost gaze, not as an eye that stands still.
    fn poll(&mut self, now_s: f64, out: &mut Vec<GazeSample>) {
        if !now_s.is_finite() {
            return;
        }
        while let Some(sample) = self.samples.get(self.next).filter(|sample| sample.arrived_s <= now_s) {
            out.push(*sample);
            self.next += 1;
        }
    }
}
