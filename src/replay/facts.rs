//! What is to be said of a frame, in words: its trial, what the observer answered and how fast, the frame itself.

use super::Replay;
use experiments::session::Trial;
use experiments::session::record::TrialRecord;
use experiments::trial::{AbortReason, Alternative, Answer, Outcome};
use std::fmt::Display;

/// A heading with what stands below it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// The heading.
    pub title: &'static str,
    /// What, and its value.
    pub rows: Vec<(String, String)>,
}

impl Section {
    fn new(title: &'static str) -> Self {
        Self { title, rows: Vec::new() }
    }

    fn row(&mut self, what: &str, value: impl Display) {
        self.rows.push((what.to_owned(), value.to_string()));
    }

    fn maybe(&mut self, what: &str, value: Option<String>) {
        self.rows.extend(value.map(|value| (what.to_owned(), value)));
    }
}

/// All that is to be said of a frame, counted from 0 among the logged ones; nothing where there is no such frame.
#[must_use]
pub fn facts(replay: &Replay, frame: usize) -> Vec<Section> {
    let Some(row) = replay.frames().get(frame) else { return Vec::new() };
    let mut sections = Vec::new();
    let ended = row.trial.and_then(|number| replay.trial(number));
    let open = replay.record.open_trial.as_ref().filter(|open| row.trial == Some(open.trial));
    if let Some(trial) = ended.map(|ended| &ended.trial).or(open) {
        sections.push(of_trial(trial, replay.record.trials.len() + usize::from(replay.record.open_trial.is_some())));
    }
    if let Some(ended) = ended {
        sections.push(of_answer(ended));
    }

    let mut section = Section::new("Now");
    section.row("Phase", row.phase.as_str());
    let shown = replay.alternative(row).map(|alternative| match alternative {
        Alternative::Reference => "reference",
        Alternative::Test => "test",
    });
    section.row("Picture", shown.unwrap_or("none"));
    let of_phase = replay.shown(row).and_then(|shown| shown.level.as_ref());
    let of_trial = ended.map(|ended| &ended.trial.level);
    if let Some(level) = of_phase.filter(|level| !level.is_empty() && of_trial != Some(*level)) {
        section.row("Shown at", in_words(level.iter().map(|(name, value)| (name.as_str(), *value))));
    }
    let gaze = row.gaze_row.and_then(|row| replay.gaze().get(usize::try_from(row).ok()?));
    let age = row.gaze_age_s.map_or_else(String::new, |age_s| format!(", {:.0} ms old", 1e3 * age_s));
    section.maybe("Gaze", gaze.map(|gaze| format!("{:.2}°, {:.2}°{age}", gaze.x_deg, gaze.y_deg)));
    if let (Some(gaze), Some(x_deg), Some(y_deg)) = (gaze, row.target_x_deg, row.target_y_deg) {
        let off_deg = replay.display(row).eccentricity_deg([gaze.x_deg, gaze.y_deg], [x_deg, y_deg]);
        section.row("Off target", format!("{off_deg:.2}°"));
    }
    sections.push(section);

    let mut section = Section::new("Frame");
    section.row("Number", format!("{}, at {:.3} s", row.index, row.presented_s));
    let missed = if row.missed { ", missed" } else { "" };
    section.row("Late by", format!("{:.1} ms{missed}", 1e3 * (row.presented_s - row.scheduled_s)));
    section.maybe("Animation", (row.animation_s > 0.0).then(|| format!("{:.3} s", row.animation_s)));
    section.maybe("Shaded", row.pixels_shaded.map(|pixels| format!("{pixels} px")));
    section.maybe("GPU time", row.gpu_time_s.map(|time_s| format!("{:.2} ms", 1e3 * time_s)));
    section.row("Hash", row.hash.as_deref().unwrap_or("none"));
    sections.push(section);
    sections
}

fn of_trial(trial: &Trial, of: usize) -> Section {
    let mut section = Section::new("Trial");
    section.row("Number", format!("{} of {of}", trial.trial));
    section.row("Block", if trial.practice { format!("{}, practice", trial.block) } else { trial.block.clone() });
    section.row("Condition", &trial.condition);
    for (factor, level) in &trial.factors {
        section.row(factor, level);
    }
    section.row("Level", in_words(trial.level.iter().map(|(name, value)| (name.as_str(), *value))));
    let order = trial.order.map(|alternative| match alternative {
        Alternative::Reference => "reference",
        Alternative::Test => "test",
    });
    section.row("Order", order.join(", "));
    section.maybe("Repetition", trial.repetition.map(|number| number.to_string()));
    section
}

fn of_answer(trial: &TrialRecord) -> Section {
    let mut section = Section::new("Answer");
    match &trial.outcome {
        Outcome::Answered { answer, correct, found } => {
            let right = match correct {
                Some(true) => ", right",
                Some(false) => ", wrong",
                None => "",
            };
            section.row("Said", format!("{}{right}", answer_in_words(*answer)));
            if !found.is_empty() {
                section.row("Found", in_words(found.iter().map(|(name, value)| (name.as_str(), *value))));
            }
        }
        Outcome::TimedOut => section.row("Said", "nothing in time"),
        Outcome::Aborted { reason } => {
            let why = match reason {
                AbortReason::GazeLeft => "gaze left",
                AbortReason::Paused => "paused",
                AbortReason::Interrupted => "interrupted",
            };
            section.row("Said", format!("nothing, {why}"));
        }
    }
    section.maybe("After", trial.response_time_s.map(|time_s| format!("{time_s:.3} s")));
    section
}

fn answer_in_words(answer: Answer) -> String {
    let words = match answer {
        Answer::First => "first",
        Answer::Second => "second",
        Answer::Same => "same",
        Answer::Increased => "increased",
        Answer::Decreased => "decreased",
        Answer::Continue => "done",
        Answer::Up => "up",
        Answer::Down => "down",
        Answer::Compare => "compare",
        Answer::Switch => "switch",
        Answer::Select => "select",
        Answer::Option(number) => return number.to_string(),
        Answer::Typed(character) => return character.to_string(),
        Answer::Erase => "erase",
    };
    words.to_owned()
}

/// Names with their values, with as many digits as are looked at.
fn in_words<'a>(values: impl Iterator<Item = (&'a str, f64)>) -> String {
    // One a line: parameters have long names.
    let words: Vec<String> = values.map(|(name, value)| format!("{name} {}", rounded(value))).collect();
    if words.is_empty() { "–".to_owned() } else { words.join("\n") }
}

/// Four significant digits, without zeros at the end.
fn rounded(value: f64) -> String {
    let digits = if value.abs() > 1e-12 { (3.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize } else { 0 };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let texts = [0.0, 1.0, 0.123_456, 12.345_67, 1234.56, 0.000_123_456, -2.5].map(rounded);
        assert_eq!(texts, ["0", "1", "0.1235", "12.35", "1235", "0.0001235", "-2.5"]);
    }
}
