//! Gaze and frames: whether they refer to what is there, and where something is missing.

use super::files::{marked, table};
use super::{Counts, Findings};
use crate::session::journal::Damage;
use crate::session::tables::{FrameRow, GazeRow};
use crate::session::{SessionFolder, names};
use experiments::session::Event;
use experiments::trial::PhaseName;
use std::collections::BTreeMap;

/// Samples are missing where the time between two is this many times the usual one…
const GAP_INTERVALS: f64 = 3.0;
/// … and at least this long, seconds.
const GAP_S: f64 = 0.05;

pub(super) fn look_at(session: &SessionFolder, counts: &mut Counts, found: &mut Findings) {
    let [gaze_mark, frame_mark] = marked(session);
    let gaze = match session.gaze() {
        Ok(gaze) => gaze,
        Err(error) => return found.damage(names::GAZE, error.to_string()),
    };
    table(names::GAZE, gaze.damage.as_ref(), gaze.rows.len(), &gaze_mark, found);
    look_at_gaze(session, &gaze.rows, counts, found);
    let frames = match session.frames() {
        Ok(frames) => frames,
        Err(error) => return found.damage(names::FRAMES, error.to_string()),
    };
    table(names::FRAMES, frames.damage.as_ref(), frames.rows.len(), &frame_mark, found);
    look_at_frames(session, &frames.rows, gaze.rows.len(), counts, found);
}

fn look_at_gaze(session: &SessionFolder, rows: &[GazeRow], counts: &mut Counts, found: &mut Findings) {
    counts.gaze_samples = rows.len();
    let lost = rows.iter().filter(|row| !row.valid).count();
    counts.gaze_lost = (!rows.is_empty()).then(|| lost as f64 / rows.len() as f64);
    let mut intervals: Vec<f64> = rows.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return;
    }
    let usual_s = *intervals.select_nth_unstable_by(middle, f64::total_cmp).1;
    counts.gaze_rate_hz = (usual_s > 0.0).then(|| 1.0 / usual_s);
    let longest_usual_s = (GAP_INTERVALS * usual_s).max(GAP_S);
    let across_seam = |from: f64, to: f64| session.record.reopened_s.iter().any(|&seam| from <= seam && seam <= to);
    let gaps: Vec<(f64, f64)> = rows
        .windows(2)
        .map(|pair| (pair[0].t_s, pair[1].t_s))
        .filter(|&(from, to)| to - from > longest_usual_s && !across_seam(from, to))
        .collect();
    counts.gaze_gaps = gaps.len();
    if let Some(longest) = gaps.iter().max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0))) {
        found.warn(
            names::GAZE,
            format!(
                "{} times no sample came for more than {longest_usual_s:.3} s; longest {:.3} s, at {:.3} s",
                gaps.len(),
                longest.1 - longest.0,
                longest.0
            ),
        );
    }
    if lost == rows.len() {
        found.warn(names::GAZE, "the eye was never seen");
    }
    if let Some(at) = rows.windows(2).position(|pair| pair[1].t_s < pair[0].t_s) {
        found.damage(names::GAZE, format!("line {}: the sample is earlier than the one before it", at + 3));
    }
}

fn look_at_frames(
    session: &SessionFolder,
    rows: &[FrameRow],
    gaze_rows: usize,
    counts: &mut Counts,
    found: &mut Findings,
) {
    counts.frames = rows.len();
    counts.missed_frames = rows.iter().filter(|row| row.missed).count();
    if counts.missed_frames > 0 {
        let late = rows.iter().map(|row| row.presented_s - row.scheduled_s).fold(0.0, f64::max);
        found.warn(
            names::FRAMES,
            format!("{} of {} frames came late, at most by {:.1} ms", counts.missed_frames, rows.len(), late * 1e3),
        );
    }
    let phases: BTreeMap<u64, (Option<u32>, PhaseName)> = session
        .journal
        .events
        .iter()
        .filter_map(|stamped| match stamped.event {
            Event::PhaseBegan { trial, phase, .. } => Some((stamped.seq, (trial, phase))),
            _ => None,
        })
        .collect();
    let events = session.journal.events.len() as u64;
    let killed = !session.is_closed();
    let mut beyond = 0;
    for (number, row) in rows.iter().enumerate() {
        let problem = if row.index != number as u64 {
            format!("expected frame {number}, found frame {}", row.index)
        } else if row.phase_seq >= events || row.gaze_row.is_some_and(|gaze| gaze >= gaze_rows as u64) {
            // A kill may take an event or a sample that a frame rests on, at the very end.
            beyond += 1;
            continue;
        } else if phases.get(&row.phase_seq) != Some(&(row.trial, row.phase)) {
            format!("the journal has no phase {} of that name at event {}", row.phase.as_str(), row.phase_seq)
        } else {
            continue;
        };
        return found.damage(names::FRAMES, format!("line {}: {problem}", number + 2));
    }
    if beyond > 0 {
        let what = format!("{beyond} frames at the end rest on events or gaze samples that are not there");
        if killed && !matches!(session.journal.damage, Some(Damage::Corrupt { .. })) {
            found.note(format!("{what}, as after a kill; they are left out"));
        } else {
            found.damage(names::FRAMES, what);
        }
    }
}
