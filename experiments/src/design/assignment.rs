//! What one observer runs in one sitting: the study's plan, with the group, the sitting, the Latin square's row and the
//! pilot mode put in.

use super::latin_square;
use crate::study::Plan;
use crate::study::plan::{BlockPlan, GroupOrder, ProcedurePlan, ProtocolPlan};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a session was given of its study. It is in the session's header.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Assignment {
    /// The observer's number in the study, from 0: decides the row of Latin squares.
    pub number: u32,
    /// The group of a between-subject design.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// The sitting, from 1.
    pub sitting: u32,
    /// Whether it is a pilot run, which is shortened and marked.
    #[serde(default)]
    pub pilot: bool,
}

impl Default for Assignment {
    fn default() -> Self {
        Self { number: 0, group: None, sitting: 1, pilot: false }
    }
}

/// Why an assignment does not fit its study.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AssignmentError {
    /// The study has no such group.
    #[error("the study has no group \"{found}\"; it has {known}")]
    Group {
        /// What was asked for.
        found: String,
        /// What there is.
        known: String,
    },
    /// The study has groups, and none was named.
    #[error("the study has the groups {known}, and one of them is needed")]
    NoGroup {
        /// What there is.
        known: String,
    },
    /// The study has no such sitting.
    #[error("the study has {count} sitting(s), and this would be number {found}")]
    Sitting {
        /// What was asked for.
        found: u32,
        /// What there is.
        count: u32,
    },
}

/// What an earlier session of a study was given, and to whom.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Earlier {
    /// The observer's code.
    pub observer: String,
    /// What they were given.
    pub assignment: Assignment,
    /// Whether the session was finished.
    pub finished: bool,
}

/// What the next session of an observer is given: the number and group that they have already, or a new number and the
/// group with the fewest observers; and the first sitting that they have not finished.
///
/// Pilot runs count for nothing but their own observer's number. Of groups with equally few observers the first listed is
/// taken.
#[must_use]
pub fn next_assignment(plan: &Plan, observer: &str, earlier: &[Earlier], pilot: bool) -> Assignment {
    let own: Vec<&Earlier> = earlier.iter().filter(|session| session.observer == observer).collect();
    let real = |session: &&Earlier| session.assignment.pilot == pilot;
    // One entry for each observer: the first assignment that they were given.
    let mut observers: BTreeMap<&str, &Assignment> = BTreeMap::new();
    for session in earlier.iter().filter(real) {
        observers.entry(&session.observer).or_insert(&session.assignment);
    }
    let known = own.iter().copied().find(real).map(|session| &session.assignment);
    let number = known.map_or_else(
        || observers.values().map(|assignment| assignment.number + 1).max().unwrap_or(0),
        |assignment| assignment.number,
    );
    let fewest = || {
        let count = |name: &str| observers.values().filter(|a| a.group.as_deref() == Some(name)).count();
        plan.groups.iter().min_by_key(|group| count(&group.name)).map(|group| group.name.clone())
    };
    let group = known.and_then(|assignment| assignment.group.clone()).or_else(fewest);
    let done = |sitting: u32| {
        own.iter().any(|session| {
            session.finished && session.assignment.pilot == pilot && session.assignment.sitting == sitting
        })
    };
    let count = plan.sittings.as_ref().map_or(1, |sittings| sittings.count);
    // A study of one sitting may be run again.
    let sitting = if count == 1 { 1 } else { (1..=count).find(|&sitting| !done(sitting)).unwrap_or(count + 1) };
    Assignment { number, group, sitting, pilot }
}

impl Plan {
    /// The part of the study that an assignment names, ready to run.
    ///
    /// # Errors
    /// When the study has no such group or sitting.
    pub fn assigned(&self, assignment: &Assignment) -> Result<Self, AssignmentError> {
        let mut plan = self.clone();
        let names = || self.groups.iter().map(|group| group.name.as_str()).collect::<Vec<_>>().join(", ");
        match &assignment.group {
            None if self.groups.is_empty() => {}
            None => return Err(AssignmentError::NoGroup { known: names() }),
            Some(name) => {
                let group = self.groups.iter().find(|group| group.name == *name).ok_or_else(|| {
                    let known = if self.groups.is_empty() { "none".to_owned() } else { names() };
                    AssignmentError::Group { found: name.clone(), known }
                })?;
                let block = |name: &String| self.blocks.iter().find(|block| block.name == *name).cloned();
                plan.blocks = group.blocks.iter().filter_map(block).collect();
                plan.groups.clear();
            }
        }
        let count = self.sittings.as_ref().map_or(1, |sittings| sittings.count);
        if assignment.sitting == 0 || assignment.sitting > count {
            return Err(AssignmentError::Sitting { found: assignment.sitting, count });
        }
        if let Some(sittings) = plan.sittings.take() {
            let sitting = assignment.sitting - 1;
            for block in plan.blocks.iter_mut().filter(|block| !block.practice) {
                match &sittings.split_by {
                    Some(factor) => keep_share(block, factor, sitting, count, assignment.number),
                    None => keep_repetitions(block, sitting, count),
                }
            }
            plan.blocks.retain(|block| !block.cells.is_empty() && block.max_trials() > 0);
        }
        // What was asked once is not asked again.
        if assignment.sitting > 1 {
            plan.participant.clear();
        }
        plan.blocks.iter_mut().for_each(|block| take_row(block, assignment.number));
        if assignment.pilot {
            let pilot = self.pilot;
            for block in &mut plan.blocks {
                block.at_most_trials = Some(block.at_most_trials.map_or(pilot.trials, |most| most.min(pilot.trials)));
                shorten(&mut block.protocol, pilot.time_factor);
            }
        }
        Ok(plan)
    }
}

/// The levels of a factor in the order in which the study lists them.
fn levels_of(block: &BlockPlan, factor: &str) -> Vec<String> {
    let mut levels: Vec<String> = Vec::new();
    for level in block.cells.iter().filter_map(|cell| cell.factors.get(factor)) {
        if !levels.contains(level) {
            levels.push(level.clone());
        }
    }
    levels
}

/// Deals a factor's levels out over the sittings; which share comes first goes round with the observer's number. A block
/// without the factor is run in every sitting.
fn keep_share(block: &mut BlockPlan, factor: &str, sitting: u32, count: u32, number: u32) {
    let levels = levels_of(block, factor);
    let share = (sitting + number) % count;
    block.cells.retain(|cell| {
        let level = cell.factors.get(factor).and_then(|level| levels.iter().position(|known| known == level));
        level.is_none_or(|level| level as u32 % count == share)
    });
}

/// Deals repetitions out over the sittings, the first ones getting one more where they do not divide.
fn keep_repetitions(block: &mut BlockPlan, sitting: u32, count: u32) {
    if let ProcedurePlan::Constant(constant) = &mut block.procedure {
        let more = u32::from(sitting < constant.repetitions % count);
        constant.repetitions = constant.repetitions / count + more;
    }
}

/// Lists the cells in the order of the Latin square's row, and says so: from here on groups come as listed.
fn take_row(block: &mut BlockPlan, number: u32) {
    if block.order.groups != GroupOrder::LatinSquare {
        return;
    }
    for factor in block.order.grouped_by.clone().iter().rev() {
        let levels = levels_of(block, factor);
        let row = latin_square::row(levels.len(), number as usize);
        let rank = |level: Option<&String>| {
            let level = level.and_then(|level| levels.iter().position(|known| known == level))?;
            row.iter().position(|&at| at == level)
        };
        block.cells.sort_by_key(|cell| rank(cell.factors.get(factor)));
    }
    block.order.groups = GroupOrder::Listed;
}

fn shorten(protocol: &mut ProtocolPlan, factor: f64) {
    for duration_s in protocol.stimulus_durations_mut() {
        if *duration_s >= 1.0 {
            *duration_s *= factor;
        }
    }
}
