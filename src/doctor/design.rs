//! Whether the journal is what the study and the seed give, and how far the design has come.

use super::{Findings, Severity};
use crate::error::LabError;
use crate::resources::Resources;
use crate::session::{SessionFolder, names};
use experiments::session::refold::refold;
use experiments::study::Plan;
use std::collections::BTreeMap;
use std::sync::Arc;

pub(super) fn look_at(session: &SessionFolder, found: &mut Findings) {
    let plan = match plan(session) {
        Ok(plan) => Arc::new(plan),
        Err(error) => {
            let what = format!("the design cannot be checked: {error}");
            return found.add(Severity::Warning, None, what);
        }
    };
    // Marks, which are no part of the design, and the events before a damage: whatever is there must agree.
    match refold(Arc::clone(&plan), session.header.seed, &session.journal.events, |_, _| {}) {
        Ok(refolded) => {
            if refolded.session.finished() && !session.record.is_over() && refolded.missing.is_empty() {
                found.damage(names::EVENTS, "the study is at its end, and the journal does not say so");
            }
        }
        Err(error) => return found.damage(names::EVENTS, error.to_string()),
    }
    balance(session, &plan, found);
}

/// The plan as it was in force at the session's end.
fn plan(session: &SessionFolder) -> Result<Plan, LabError> {
    let resources = Resources::of_session(session)?;
    let file = format!("{} (study)", session.path.join(names::HEADER).display());
    let plan = resources.plan(&file, session.study_text(), Some(&session.display_now()?))?;
    plan.assigned(&session.header.assignment).map_err(|error| LabError::BadInput(format!("{file}: {error}")))
}

/// How often each condition of a block was answered: uneven counts bias whatever averages over them.
fn balance(session: &SessionFolder, plan: &Plan, found: &mut Findings) {
    for block in plan.blocks.iter().filter(|block| !block.practice) {
        let mut answered: BTreeMap<&str, u32> =
            block.cells.iter().map(|cell| (cell.condition.name.as_str(), 0)).collect();
        let trials = session.record.trials.iter().filter(|trial| trial.trial.block == block.name && trial.counts());
        for trial in trials {
            if let Some(count) = answered.get_mut(trial.trial.condition.as_str()) {
                *count += 1;
            }
        }
        let (least, most) = (answered.values().min().copied(), answered.values().max().copied());
        if let (Some(least), Some(most)) = (least, most)
            && most > least + 1
        {
            let word = if session.record.finished { Severity::Warning } else { Severity::Note };
            let what = format!("block {}: conditions were answered {least} to {most} times", block.name);
            found.add(word, None, what);
        }
    }
}
