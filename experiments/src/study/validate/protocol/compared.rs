//! Protocols that show reference and test one after the other: two intervals, toggled, pairs, pairs with a task.

use super::super::DEFAULT_QUESTION;
use super::Context;
use crate::study::draft::{CountDraft, PairDraft, PairedTaskDraft, TaskDraft, ToggleDraft, TwoIntervalDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{OnGazeLeft, PairPlan, PairedTaskPlan, Task, TogglePlan, TwoIntervalPlan, Wanted};
use crate::study::source::Field;

/// Each sequence of a pair and the black between, in seconds, where a study does not say (Guenter 2012, §5).
const PAIR_S: [f64; 2] = [8.0, 0.5];

pub(super) fn two_interval(
    draft: &TwoIntervalDraft,
    context: Context<'_>,
    report: &mut Report<'_>,
) -> Option<TwoIntervalPlan> {
    let phases = [
        ("fixation_s", draft.fixation_s),
        ("interval_s", draft.interval_s),
        ("gap_s", draft.gap_s),
        ("feedback_s", draft.feedback_s),
    ];
    context.report_short_phases(&phases, report);
    let wanted = draft.asks_for.unwrap_or(Wanted::Degraded);
    let question = match wanted {
        Wanted::Reference => "Which one was not degraded: the first or the second?",
        Wanted::Degraded => DEFAULT_QUESTION,
    };
    Some(TwoIntervalPlan {
        fixation_s: draft.fixation_s?,
        interval_s: draft.interval_s?,
        gap_s: draft.gap_s?,
        answer_timeout_s: draft.answer_timeout_s,
        question: or_default(draft.question.as_ref(), question),
        wanted,
    })
}

pub(super) fn toggle(draft: &ToggleDraft, context: Context<'_>, report: &mut Report<'_>) -> Option<TogglePlan> {
    let phases = [("fixation_s", draft.fixation_s), ("switch_s", draft.switch_s), ("feedback_s", draft.feedback_s)];
    context.report_short_phases(&phases, report);
    let wanted = draft.asks_for.unwrap_or(Wanted::Reference);
    let question = match wanted {
        Wanted::Degraded => "Which one is degraded: A or B?",
        Wanted::Reference => "Which one is not degraded: A or B?",
    };
    Some(TogglePlan {
        fixation_s: draft.fixation_s?,
        switch_s: draft.switch_s?,
        most_switches: draft.most_switches,
        question: or_default(draft.question.as_ref(), question),
        wanted,
        on_gaze_left: draft.on_gaze_left.unwrap_or(OnGazeLeft::Hide),
    })
}

pub(super) fn pair(draft: &PairDraft, context: Context<'_>, report: &mut Report<'_>) -> Option<PairPlan> {
    let phases = [
        ("fixation_s", draft.fixation_s),
        ("sequence_s", draft.sequence_s),
        ("black_s", draft.black_s),
        ("feedback_s", draft.feedback_s),
    ];
    context.report_short_phases(&phases, report);
    let question = "Which one was better: the first, the second, or were both the same?";
    Some(PairPlan {
        fixation_s: draft.fixation_s,
        sequence_s: draft.sequence_s.unwrap_or(PAIR_S[0]),
        black_s: draft.black_s.unwrap_or(PAIR_S[1]),
        answer_timeout_s: draft.answer_timeout_s,
        question: or_default(draft.question.as_ref(), question),
        on_gaze_left: draft.on_gaze_left.unwrap_or_default().into(),
    })
}

pub(super) fn paired_task(
    draft: &PairedTaskDraft,
    context: Context<'_>,
    report: &mut Report<'_>,
) -> Option<PairedTaskPlan> {
    let phases = [("sequence_s", draft.sequence_s), ("marker_s", draft.marker_s), ("feedback_s", draft.feedback_s)];
    context.report_short_phases(&phases, report);
    let task = draft.task.as_ref().and_then(|draft| task(draft, &context.field.key("task"), report));
    Some(PairedTaskPlan {
        task: task?,
        sequence_s: draft.sequence_s?,
        marker_s: draft.marker_s?,
        question: or_default(
            draft.question.as_ref(),
            "Which one was better: the first, the second, or were they equal?",
        ),
        answer_timeout_s: draft.answer_timeout_s,
        on_gaze_left: draft.on_gaze_left.unwrap_or_default().into(),
    })
}

fn task(draft: &TaskDraft, field: &Field, report: &mut Report<'_>) -> Option<Task> {
    let instructions = |given: Option<&String>, default: &str| or_default(given, default);
    match draft {
        TaskDraft::Count(draft) => count(draft, field, report),
        TaskDraft::FreeViewing(draft) => {
            let default = "Look around as you like.\n\nPress space to begin.";
            Some(Task::FreeViewing { instructions: instructions(draft.instructions.as_ref(), default) })
        }
        TaskDraft::Follow(draft) => {
            let default = "Follow the moving sphere with your eyes.\n\nPress space to begin.";
            Some(Task::Follow { instructions: instructions(draft.instructions.as_ref(), default) })
        }
    }
}

fn count(draft: &CountDraft, field: &Field, report: &mut Report<'_>) -> Option<Task> {
    let (min, max) = (draft.min?, draft.max?);
    if min >= max {
        // One number alone would be known after the first sequence.
        report.at(&field.key("max"), format!("expected more than min ({min}), found {max}"));
        return None;
    }
    Some(Task::Count {
        instructions: or_default(
            draft.instructions.as_ref(),
            "Count the coloured spheres. You will be asked how many there were.\n\nPress space to begin.",
        ),
        question: or_default(draft.question.as_ref(), "How many spheres were there?"),
        min,
        max,
    })
}

/// The words of a study, or ours.
pub(super) fn or_default(given: Option<&String>, default: &str) -> String {
    given.cloned().unwrap_or_else(|| default.to_owned())
}
