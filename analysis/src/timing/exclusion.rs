//! Leaving flagged trials out: a step that is asked for by name, and that reports what it left out and under which rule.

use super::flags::{FlagReport, FlagRule, FlaggedTrial};
use crate::gaze::TrialId;
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};

/// What was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exclusion {
    /// The rule that trials were held against.
    pub rule: FlagRule,
    /// Trials before.
    pub before: usize,
    /// Trials kept.
    pub kept: usize,
    /// Those left out, with their reasons.
    pub excluded: Vec<FlaggedTrial>,
    /// Trials that were kept because the flag report does not speak of them.
    pub never_judged: usize,
    /// Before and after by condition, in the order in which conditions first appear: exclusion that falls on one
    /// condition more than on another biases their comparison.
    pub conditions: Vec<ConditionExclusion>,
    /// The same in words.
    pub words: String,
}

/// What was left out of one condition.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ConditionExclusion {
    /// The condition.
    pub condition: String,
    /// Its trials before.
    pub before: usize,
    /// Of these, left out.
    pub excluded: usize,
}

/// The trials that are not flagged, in their order, and a report of the others.
///
/// `id` tells which trial an item belongs to; several items may belong to one trial.
#[must_use]
pub fn exclude<T>(trials: Vec<T>, id: impl Fn(&T) -> TrialId, flags: &FlagReport) -> (Vec<T>, Exclusion) {
    let flagged: HashMap<&TrialId, &FlaggedTrial> = flags.flagged.iter().map(|trial| (&trial.id, trial)).collect();
    let judged: HashMap<&TrialId, &str> =
        flags.trials.iter().map(|trial| (&trial.id, trial.condition.as_str())).collect();
    let before = trials.len();
    let mut conditions: Vec<ConditionExclusion> = Vec::new();
    let (mut kept, mut out, mut never_judged) = (Vec::with_capacity(before), HashSet::new(), 0);
    for trial in trials {
        let of = id(&trial);
        let is_out = flagged.contains_key(&of);
        match judged.get(&of) {
            Some(condition) => count(&mut conditions, condition, is_out),
            None => never_judged += 1,
        }
        if is_out {
            out.insert(of);
        } else {
            kept.push(trial);
        }
    }
    let excluded: Vec<FlaggedTrial> = flags.flagged.iter().filter(|trial| out.contains(&trial.id)).cloned().collect();
    let left_out = before - kept.len();
    let share = if before > 0 { 100.0 * left_out as f64 / before as f64 } else { 0.0 };
    let unknown =
        if never_judged > 0 { format!(" {never_judged} were kept without having been judged.") } else { String::new() };
    let words = format!("{left_out} of {before} trials ({share:.1} %) were left out.{unknown}");
    let exclusion = Exclusion { rule: flags.rule, before, kept: kept.len(), excluded, never_judged, conditions, words };
    (kept, exclusion)
}

fn count(conditions: &mut Vec<ConditionExclusion>, condition: &str, excluded: bool) {
    let at = conditions.iter().position(|of| of.condition == condition).unwrap_or_else(|| {
        conditions.push(ConditionExclusion { condition: condition.to_owned(), before: 0, excluded: 0 });
        conditions.len() - 1
    });
    conditions[at].before += 1;
    conditions[at].excluded += usize::from(excluded);
}
