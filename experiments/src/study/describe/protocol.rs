//! Protocols in words.

use crate::study::plan::{
    Adjusted, AdjustmentStep, Finer, Item, ItemKind, OnGazeLeft, ProtocolPlan, RampPlan, SliderPlan, Task, Wanted,
};

/// The protocol with its timing.
pub(super) fn in_words(plan: &ProtocolPlan) -> String {
    match plan {
        ProtocolPlan::TwoInterval(plan) => format!(
            "two intervals: fixation {} s, {} s each, gap {} s, {}answer {}",
            plan.fixation_s,
            plan.interval_s,
            plan.gap_s,
            // The usual question goes without saying.
            if plan.wanted == Wanted::Reference { "which is the reference, " } else { "" },
            within(plan.answer_timeout_s)
        ),
        ProtocolPlan::Toggle(plan) => format!(
            "toggled, \"{}\": fixation {} s, then A and B with {} s of grey between, {}{}",
            plan.question,
            plan.fixation_s,
            plan.switch_s,
            at_most(plan.most_switches, "switch", "switches"),
            on_gaze_left(plan.on_gaze_left)
        ),
        ProtocolPlan::Pair(plan) => format!(
            "pair, first or second better or the same: {}{} s each, black {} s, answer {}{}",
            fixation(plan.fixation_s),
            plan.sequence_s,
            plan.black_s,
            within(plan.answer_timeout_s),
            on_gaze_left(plan.on_gaze_left)
        ),
        ProtocolPlan::Ramp(plan) => ramp(plan),
        ProtocolPlan::Slider(plan) => slider(plan),
        ProtocolPlan::Likert(plan) => format!(
            "rated sequence: {}{} s, then {}{}",
            fixation(plan.fixation_s),
            plan.sequence_s,
            plan.items.iter().map(item).collect::<Vec<_>>().join(", "),
            on_gaze_left(plan.on_gaze_left)
        ),
        ProtocolPlan::Adjustment(plan) => format!(
            "adjustment, with the reference to toggle to: {}, {}",
            plan.parameters.iter().map(adjusted).collect::<Vec<_>>().join("; "),
            at_most(plan.most_moves, "move", "moves")
        ),
        ProtocolPlan::PairedTask(plan) => format!(
            "pair with a task ({}), first or second better or equal: {} s each, mark {} s after each, answer {}{}",
            task(&plan.task),
            plan.sequence_s,
            plan.marker_s,
            within(plan.answer_timeout_s),
            on_gaze_left(plan.on_gaze_left)
        ),
    }
}

fn ramp(plan: &RampPlan) -> String {
    format!(
        "ramp of {} between {} and the level ({} is finer), increased, decreased or the same: {} steps of {} s, black {} \
         s, answer {}{}",
        plan.parameter,
        plan.from,
        if plan.finer == Finer::Up { "larger" } else { "smaller" },
        plan.steps,
        plan.step_s,
        plan.black_s,
        within(plan.answer_timeout_s),
        on_gaze_left(plan.on_gaze_left)
    )
}

fn slider(plan: &SliderPlan) -> String {
    let ends = plan.values.first().zip(plan.values.last());
    let ends = ends.map_or_else(String::new, |(first, last)| format!(" from {first} to {last}"));
    let compared = plan.compare_s.map_or_else(|| "until a key".to_owned(), |compare_s| format!("for {compare_s} s"));
    format!(
        "slider over {} values of {}{ends}: reference {} s, comparisons {compared}, {}",
        plan.values.len(),
        plan.parameter,
        plan.reference_s,
        at_most(plan.most_moves, "move", "moves")
    )
}

fn item(item: &Item) -> String {
    let kind = match &item.kind {
        ItemKind::Scale { low, high, .. } => format!("{low} to {high}"),
        ItemKind::Choice { options } => format!("{} options", options.len()),
        ItemKind::Number { min, max, .. } => format!("a number from {min} to {max}"),
        ItemKind::Text { .. } => "a text".to_owned(),
    };
    format!("{} ({kind})", item.name)
}

fn adjusted(adjusted: &Adjusted) -> String {
    let step = match adjusted.step {
        AdjustmentStep::Add(step) => format!("steps of {step}"),
        AdjustmentStep::Multiply(factor) => format!("factors of {factor}"),
    };
    format!("{} from {} to {} in {step}", adjusted.parameter, adjusted.min, adjusted.max)
}

fn task(task: &Task) -> String {
    match task {
        Task::Count { min, max, .. } => format!("count {min} to {max} spheres"),
        Task::FreeViewing { .. } => "free viewing".to_owned(),
        Task::Follow { .. } => "follow the target".to_owned(),
    }
}

fn fixation(fixation_s: Option<f64>) -> String {
    fixation_s.map_or_else(String::new, |fixation_s| format!("fixation {fixation_s} s, "))
}

fn within(timeout_s: Option<f64>) -> String {
    timeout_s.map_or_else(|| "without limit".to_owned(), |timeout_s| format!("within {timeout_s} s"))
}

fn at_most(limit: Option<u32>, one: &str, many: &str) -> String {
    match limit {
        None => format!("{many} without limit"),
        Some(1) => format!("at most 1 {one}"),
        Some(most) => format!("at most {most} {many}"),
    }
}

fn on_gaze_left(rule: OnGazeLeft) -> &'static str {
    match rule {
        OnGazeLeft::Ignore => "",
        OnGazeLeft::Abort => ", aborted when gaze leaves",
        OnGazeLeft::Hide => ", hidden while gaze is away",
    }
}
