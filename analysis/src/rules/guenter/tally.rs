//! Answers of pair and ramp trials by level, and the coarsest level that once went unnoticed: the core of both rules.

use crate::answers::Row;
use crate::psychometric::Direction;
use experiments::trial::Answer;
use serde::{Deserialize, Serialize};

/// Whether a pair or ramp trial counts as unnoticed by the paper's rule: anything but the reference called better, or the
/// ramp's direction named.
///
/// "The same" is unnoticed even where it is true, at a ramp that stays at the reference's quality: the paper counts every
/// ramp that was "reported" not to change, and one of its targets is the reference's own index, 22.
#[must_use]
pub fn went_unnoticed(row: &Row) -> bool {
    row.correct != Some(true) || row.answer == Answer::Same
}

/// Whether a ramp had no change to name, since both its ends are the same.
#[must_use]
pub fn is_without_change(row: &Row) -> bool {
    match (row.found.get("from"), row.found.get("to")) {
        (Some(from), Some(to)) => from.total_cmp(to).is_eq(),
        _ => false,
    }
}

/// The paper's threshold of a pair or ramp test in the parameter's unit: the coarsest level of the trials with a right or
/// wrong answer that once [went unnoticed](went_unnoticed). Nothing if none did.
///
/// It has no interval; see [`super::NO_INTERVAL`].
#[must_use]
pub fn coarsest_unnoticed<'a>(
    parameter: &str,
    direction: Direction,
    rows: impl IntoIterator<Item = &'a Row>,
) -> Option<f64> {
    coarsest(&tally(parameter, rows), direction)
}

pub(super) fn coarsest(tally: &[LevelTally], direction: Direction) -> Option<f64> {
    let mut levels = tally.iter().filter(|level| level.unnoticed > 0).map(|level| level.level);
    match direction {
        Direction::Falls => levels.next(),
        Direction::Rises => levels.next_back(),
    }
}

/// The answers of one observer at one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LevelTally {
    /// The level.
    pub level: f64,
    /// Answers.
    pub n: u32,
    /// Those that count as unnoticed.
    pub unnoticed: u32,
    /// Whether there was nothing to notice: a ramp that stays where it is.
    pub without_change: bool,
}

/// Answers by level, ascending; rows without the parameter or without right and wrong are left out.
pub(super) fn tally<'a>(parameter: &str, rows: impl IntoIterator<Item = &'a Row>) -> Vec<LevelTally> {
    let mut levels: Vec<LevelTally> = Vec::new();
    for row in rows.into_iter().filter(|row| row.correct.is_some()) {
        let Some(&level) = row.level.get(parameter).filter(|level| level.is_finite()) else { continue };
        let at = levels.iter().position(|known| known.level.total_cmp(&level).is_eq()).unwrap_or_else(|| {
            levels.push(LevelTally { level, n: 0, unnoticed: 0, without_change: true });
            levels.len() - 1
        });
        levels[at].n += 1;
        levels[at].unnoticed += u32::from(went_unnoticed(row));
        levels[at].without_change &= is_without_change(row);
    }
    levels.sort_by(|a, b| a.level.total_cmp(&b.level));
    levels
}

/// Coarse levels first.
pub(in crate::rules) fn direction_order(direction: Direction, a: f64, b: f64) -> std::cmp::Ordering {
    match direction {
        Direction::Falls => a.total_cmp(&b),
        Direction::Rises => b.total_cmp(&a),
    }
}

/// 1 − pⁿ: the probability that a level which is noticed with probability p is missed at least once in n trials.
pub(in crate::rules) fn unnoticed_once(noticed: f64, trials: u32) -> f64 {
    1.0 - noticed.clamp(0.0, 1.0).powi(i32::try_from(trials).unwrap_or(i32::MAX))
}
