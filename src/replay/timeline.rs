//! What happened when, in lanes: trials by outcome, phases, answers, missed frames, lost gaze, places where the session went
//! on. Lanes are computed once and looked at by pixel column, so that a long session costs no more than a short one.

use super::Replay;
use crate::session::tables::GazeRow;
use experiments::session::{Event, Stamped};
use experiments::trial::{Alternative, Input, Outcome, PhaseName};
use std::ops::Range;
use std::sync::Arc;

/// Longer without a frame or an event is a gap, seconds.
const GAP_S: f64 = 2.0;
/// How long a gap looks, seconds.
const SHORT_GAP_S: f64 = 1.0;
/// A tracker that has sent nothing for so long has lost the eye, seconds: as in a run.
const SILENCE_S: f64 = 0.25;

/// The axis of a timeline: session time with gaps cut short, such as the night between two parts of a session.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// Session time and place, both growing, in seconds; in between it is straight.
    knots: Vec<[f64; 2]>,
}

impl Axis {
    /// An axis for things that happened at these times, in any order.
    #[must_use]
    pub fn new(mut times_s: Vec<f64>) -> Self {
        times_s.retain(|time_s| time_s.is_finite());
        times_s.sort_by(f64::total_cmp);
        let Some((&first, &last)) = times_s.first().zip(times_s.last()) else { return Self::default() };
        let (mut knots, mut place) = (vec![[first, 0.0]], 0.0);
        let mut from = first;
        for pair in times_s.windows(2) {
            if pair[1] - pair[0] > GAP_S {
                place += pair[0] - from;
                knots.push([pair[0], place]);
                place += SHORT_GAP_S;
                knots.push([pair[1], place]);
                from = pair[1];
            }
        }
        knots.push([last, place + last - from]);
        Self { knots }
    }

    /// The place of a session time, seconds; before the first and after the last it goes on straight.
    #[must_use]
    pub fn place(&self, t_s: f64) -> f64 {
        self.along(t_s, 0)
    }

    /// The session time of a place, seconds.
    #[must_use]
    pub fn t_s(&self, place: f64) -> f64 {
        self.along(place, 1)
    }

    /// How long it is, seconds.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot[1])
    }

    fn along(&self, value: f64, from: usize) -> f64 {
        let to = 1 - from;
        let next = self.knots.partition_point(|knot| knot[from] <= value);
        let before = next.checked_sub(1).and_then(|at| self.knots.get(at));
        match (before, self.knots.get(next)) {
            (Some(before), Some(after)) => {
                let share = (value - before[from]) / (after[from] - before[from]);
                before[to] + share * (after[to] - before[to])
            }
            (Some(only), None) | (None, Some(only)) => only[to] + value - only[from],
            (None, None) => value,
        }
    }
}

/// What a stretch or an instant means. The order is that of importance: where several share a pixel, the last is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Tone {
    /// Grey or black between pictures, fixation.
    Blank,
    /// Pages and forms.
    Page,
    /// The question.
    Ask,
    /// The full-resolution reference.
    Reference,
    /// The foveated picture.
    Test,
    /// A trial that was aborted.
    Aborted,
    /// A trial without an answer in time.
    TimedOut,
    /// An answer that is neither right nor wrong.
    Answered,
    /// A right answer.
    Right,
    /// A wrong answer.
    Wrong,
    /// The trial in which the log stops.
    Open,
    /// An answer was given.
    Response,
    /// A frame was late.
    Missed,
    /// The eye was lost.
    Lost,
    /// The session went on.
    Seam,
}

/// A stretch of a lane; an instant where it ends as it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Where it begins, on the axis, seconds.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// What it means.
    pub tone: Tone,
    /// What can be written on it where there is room.
    pub label: String,
}

/// One lane: stretches in order that do not overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct Lane {
    /// Its name.
    pub name: &'static str,
    /// Its stretches and instants.
    pub spans: Vec<Span>,
}

impl Lane {
    fn new(name: &'static str, axis: &Axis, spans: impl IntoIterator<Item = (f64, f64, Tone, String)>) -> Self {
        let placed = |(from_s, to_s, tone, label): (f64, f64, Tone, String)| {
            let from = axis.place(from_s);
            Span { from, to: axis.place(to_s).max(from), tone, label }
        };
        let mut spans: Vec<Span> = spans.into_iter().map(placed).collect();
        spans.sort_by(|a, b| a.from.total_cmp(&b.from));
        // What overlaps, as in a log whose clock went back, ends where the next begins, so that ends grow as well.
        for index in 1..spans.len() {
            let begins = spans[index].from;
            spans[index - 1].to = spans[index - 1].to.min(begins);
        }
        Self { name, spans }
    }

    /// The stretches and instants of which a part is seen.
    #[must_use]
    pub fn within(&self, seen: &Range<f64>) -> &[Span] {
        let first = self.spans.partition_point(|span| span.to < seen.start);
        let last = self.spans.partition_point(|span| span.from <= seen.end);
        self.spans.get(first..last).unwrap_or_default()
    }

    /// What each of `columns` equal parts of `seen` shows, as runs of columns with one tone.
    #[must_use]
    pub fn runs(&self, seen: &Range<f64>, columns: usize) -> Vec<(Range<usize>, Tone)> {
        let length = seen.end - seen.start;
        if columns == 0 || length.is_nan() || length <= 0.0 {
            return Vec::new();
        }
        let most = columns - 1;
        let column = |place: f64| (((place - seen.start) / length * columns as f64).max(0.0) as usize).min(most);
        let mut tones: Vec<Option<Tone>> = vec![None; columns];
        for span in self.within(seen) {
            // A stretch that ends where a column begins is not part of it.
            let (from, to) = (column(span.from), column(span.to));
            let ends_before = span.to > span.from && to > from && begins(seen, columns, to) >= span.to;
            for tone in &mut tones[from..=if ends_before { to - 1 } else { to }] {
                *tone = (*tone).max(Some(span.tone));
            }
        }
        let mut runs: Vec<(Range<usize>, Tone)> = Vec::new();
        for (index, tone) in tones.into_iter().enumerate() {
            let Some(tone) = tone else { continue };
            match runs.last_mut().filter(|(run, last)| run.end == index && *last == tone) {
                Some((run, _)) => run.end = index + 1,
                None => runs.push((index..index + 1, tone)),
            }
        }
        runs
    }
}

/// Where a column begins, on the axis.
fn begins(seen: &Range<f64>, columns: usize, column: usize) -> f64 {
    seen.start + (seen.end - seen.start) * column as f64 / columns as f64
}

/// All lanes of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct Timeline {
    /// Session time and places.
    pub axis: Axis,
    /// The lanes, from top to bottom.
    pub lanes: Vec<Lane>,
    /// Where each frame was presented, on the axis, not decreasing.
    pub frames: Arc<[f64]>,
    /// The first frame of each trial, in order.
    pub trials: Arc<[usize]>,
}

impl Timeline {
    /// The lanes of a session.
    #[must_use]
    pub fn of(replay: &Replay) -> Self {
        let frames = replay.frames();
        let (events, record) = (&replay.events, &replay.record);
        let mut latest_s = f64::NEG_INFINITY;
        let presented_s: Vec<f64> = frames
            .iter()
            .map(|frame| {
                latest_s = latest_s.max(frame.presented_s);
                latest_s
            })
            .collect();
        let times_s = events.iter().map(|event| event.t_s).chain(presented_s.iter().copied()).collect();
        let axis = Axis::new(times_s);
        let end_s = events.last().map_or(0.0, |event| event.t_s).max(latest_s);

        let trials = record.trials.iter().map(|trial| {
            let label = trial.trial.trial.to_string();
            (trial.began_s, trial.ended_s, tone_of(&trial.outcome), label)
        });
        let open = record.open_trial.as_ref().map(|trial| {
            let began = events.iter().rfind(|event| matches!(event.event, Event::TrialBegan(_)));
            (began.map_or(end_s, |event| event.t_s), end_s, Tone::Open, trial.trial.to_string())
        });
        let lanes = vec![
            Lane::new("Trials", &axis, trials.chain(open)),
            Lane::new("Phases", &axis, phases(events, end_s)),
            Lane::new("Answers", &axis, answers(events)),
            Lane::new(
                "Missed frames",
                &axis,
                frames.iter().filter(|frame| frame.missed).map(|frame| instant(frame.presented_s, Tone::Missed)),
            ),
            Lane::new("Gaze lost", &axis, losses(replay.gaze(), &record.reopened_s)),
            Lane::new("Seams", &axis, record.reopened_s.iter().map(|&t_s| instant(t_s, Tone::Seam))),
        ];
        let mut firsts = Vec::new();
        let mut before = None;
        for (index, frame) in frames.iter().enumerate() {
            if frame.trial.is_some() && frame.trial != before {
                firsts.push(index);
            }
            before = frame.trial;
        }
        let places = presented_s.iter().map(|&t_s| axis.place(t_s)).collect();
        Self { lanes, frames: places, trials: firsts.into(), axis }
    }
}

fn instant(t_s: f64, tone: Tone) -> (f64, f64, Tone, String) {
    (t_s, t_s, tone, String::new())
}

fn tone_of(outcome: &Outcome) -> Tone {
    match outcome {
        Outcome::Answered { correct: Some(true), .. } => Tone::Right,
        Outcome::Answered { correct: Some(false), .. } => Tone::Wrong,
        Outcome::Answered { correct: None, .. } => Tone::Answered,
        Outcome::TimedOut => Tone::TimedOut,
        Outcome::Aborted { .. } => Tone::Aborted,
    }
}

/// A phase lasts until the next one begins.
fn phases(events: &[Stamped], end_s: f64) -> Vec<(f64, f64, Tone, String)> {
    let mut spans: Vec<(f64, f64, Tone, String)> = Vec::new();
    for Stamped { t_s, event, .. } in events {
        let ends =
            matches!(event, Event::PhaseBegan { .. } | Event::Finished | Event::Ended { .. } | Event::Continued(_));
        if ends && let Some(last) = spans.last_mut() {
            last.1 = last.1.min(*t_s);
        }
        if let Event::PhaseBegan { phase, shown, .. } = event {
            let tone = match (shown, phase) {
                (Some(Alternative::Test), _) => Tone::Test,
                (Some(Alternative::Reference), _) => Tone::Reference,
                (None, PhaseName::Ask | PhaseName::Adjust) => Tone::Ask,
                (
                    None,
                    PhaseName::Page | PhaseName::Form | PhaseName::Consent | PhaseName::Paused | PhaseName::Task,
                ) => Tone::Page,
                (None, _) => Tone::Blank,
            };
            spans.push((*t_s, end_s, tone, phase.as_str().to_owned()));
        }
    }
    spans
}

/// Answers that were taken.
fn answers(events: &[Stamped]) -> impl Iterator<Item = (f64, f64, Tone, String)> + '_ {
    events.iter().filter_map(|stamped| match &stamped.event {
        Event::Input { input: Input::Answered { .. }, accepted: true } => Some(instant(stamped.t_s, Tone::Response)),
        _ => None,
    })
}

/// Stretches in which the eye was not seen: invalid samples, and none at all. While the program does not run nothing is
/// lost.
fn losses(gaze: &[GazeRow], reopened_s: &[f64]) -> Vec<(f64, f64, Tone, String)> {
    let mut spans: Vec<(f64, f64, Tone, String)> = Vec::new();
    let mut lost_since: Option<f64> = None;
    for (index, row) in gaze.iter().enumerate() {
        if let Some(before) = index.checked_sub(1).and_then(|at| gaze.get(at)) {
            let seam = reopened_s.iter().any(|s| before.arrived_s <= *s && *s <= row.arrived_s);
            if seam {
                spans.extend(lost_since.take().map(|since| (since, before.t_s, Tone::Lost, String::new())));
            } else if row.t_s - before.t_s > SILENCE_S {
                lost_since.get_or_insert(before.t_s);
            }
        }
        if row.valid {
            spans.extend(lost_since.take().map(|since| (since, row.t_s, Tone::Lost, String::new())));
        } else {
            lost_since.get_or_insert(row.t_s);
        }
    }
    let end_s = gaze.last().map_or(0.0, |row| row.t_s);
    spans.extend(lost_since.map(|since| (since, end_s, Tone::Lost, String::new())));
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_cuts_gaps_short_and_can_be_read_both_ways() {
        // Ten seconds, an hour of nothing, five seconds.
        let times_s = (0..=10).map(f64::from).chain((0..=5).map(|s| 3610.0 + f64::from(s))).collect();
        let axis = Axis::new(times_s);
        for (t_s, place) in [(0.0, 0.0), (7.5, 7.5), (10.0, 10.0), (3610.0, 11.0), (3612.0, 13.0), (3615.0, 16.0)] {
            assert!((axis.place(t_s) - place).abs() < 1e-9, "{t_s}");
            assert!((axis.t_s(place) - t_s).abs() < 1e-9, "{place}");
        }
        assert!((axis.place(1810.0) - 10.5).abs() < 1e-9, "the middle of the gap");
        assert!((axis.place(-1.0) + 1.0).abs() < 1e-9 && (axis.place(3616.0) - 17.0).abs() < 1e-9);
        assert!((axis.length() - 16.0).abs() < 1e-9);
        assert_eq!(Axis::new(vec![f64::NAN]), Axis::default());
        assert!((Axis::new(vec![3.0]).place(4.0) - 1.0).abs() < 1e-9);
    }

    fn lane(spans: &[(f64, f64, Tone)]) -> Lane {
        let axis = Axis::new(vec![0.0, 1.0]);
        Lane::new("lane", &axis, spans.iter().map(|&(from, to, tone)| (from, to, tone, String::new())))
    }

    #[test]
    fn columns_show_what_matters_most() {
        let lane = lane(&[(0.0, 0.5, Tone::Right), (0.5, 0.75, Tone::Wrong), (0.9, 0.9, Tone::Missed)]);
        let runs = lane.runs(&(0.0..1.0), 4);
        assert_eq!(runs, [(0..2, Tone::Right), (2..3, Tone::Wrong), (3..4, Tone::Missed)]);
        // In one column the most important is seen; an instant has a column however far one looks in.
        assert_eq!(lane.runs(&(0.0..1.0), 1), [(0..1, Tone::Missed)]);
        assert_eq!(lane.runs(&(0.89..0.91), 100), [(50..51, Tone::Missed)]);
        assert_eq!(lane.runs(&(0.8..0.85), 100), []);
        assert_eq!(lane.runs(&(0.1..0.2), 3), [(0..3, Tone::Right)]);
        assert!(lane.runs(&(0.0..0.0), 3).is_empty() && lane.runs(&(0.0..1.0), 0).is_empty());
    }

    /// A million lost samples, one after the other: a thousand columns are there at once.
    #[test]
    fn a_long_session_is_looked_at_by_columns() {
        let spans: Vec<(f64, f64, Tone)> =
            (0..1_000_000).map(|i| (f64::from(i) * 1e-6, f64::from(i) * 1e-6 + 4e-7, Tone::Lost)).collect();
        let lane = lane(&spans);
        let began = std::time::Instant::now();
        assert_eq!(lane.runs(&(0.0..1.0), 1000), [(0..1000, Tone::Lost)]);
        let whole = began.elapsed();
        let began = std::time::Instant::now();
        for step in 0..1000 {
            let from = f64::from(step) * 9e-4;
            assert!(!lane.runs(&(from..from + 1e-4), 1000).is_empty());
        }
        println!("whole {whole:?}, a thousand parts {:?}", began.elapsed());
        assert_eq!(lane.within(&(0.5..0.500_000_5)).len(), 1);
    }

    #[test]
    fn gaze_is_lost_in_blinks_and_in_silence_but_not_across_a_seam() {
        let row = |t_s: f64, valid: bool| GazeRow {
            t_s,
            arrived_s: t_s,
            t_device_s: t_s,
            x_px: 0.0,
            y_px: 0.0,
            x_deg: 0.0,
            y_deg: 0.0,
            valid,
            pupil_mm: None,
            left: None,
            right: None,
        };
        let gaze = [
            row(0.0, true),
            row(0.1, false),
            row(0.2, false),
            row(0.3, true),
            row(0.9, true),
            row(60.0, true),
            row(60.1, false),
        ];
        let lost: Vec<(f64, f64)> = losses(&gaze, &[59.0]).into_iter().map(|(from, to, ..)| (from, to)).collect();
        assert_eq!(lost, [(0.1, 0.3), (0.3, 0.9), (60.1, 60.1)]);
    }
}
