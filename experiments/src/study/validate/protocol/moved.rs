//! Protocols that move a parameter of the renderer within a trial: ramp, slider, adjustment.

use super::super::procedure::{Written, in_bounds, number_parameter};
use super::super::values::listed;
use super::Context;
use super::compared::or_default;
use crate::catalogue::ParameterSchema;
use crate::study::draft::{AdjustedDraft, AdjustmentDraft, RampDraft, SliderDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{Adjusted, AdjustmentPlan, AdjustmentStep, RampPlan, SliderPlan};
use crate::study::source::Field;
use std::collections::BTreeSet;

/// Steps of a ramp where a study does not say, and the seconds of each and of the black between (Guenter 2012, §5, which
/// calls the black short and gives it as 0.5 s for pairs).
const RAMP_STEPS: u32 = 5;
const RAMP_S: [f64; 2] = [5.0, 0.5];
/// Parameters that can be adjusted together, one for each digit.
const MOST_ADJUSTED: usize = 9;
/// The most moves that an adjustment may need from one end of its range to the other.
const MOST_CROSSING: f64 = 10_000.0;

impl<'a> Context<'a> {
    /// The renderer's parameter of a name, reported where there is none.
    fn parameter(&self, name: Option<&str>, field: &Field, report: &mut Report<'_>) -> Option<&'a ParameterSchema> {
        let (name, (_, renderer)) = (name?, self.target?);
        number_parameter(name, renderer, field, Written::AsValue, report)
    }
}

pub(super) fn ramp(draft: &RampDraft, context: Context<'_>, report: &mut Report<'_>) -> Option<RampPlan> {
    let phases = [("step_s", draft.step_s), ("black_s", draft.black_s), ("feedback_s", draft.feedback_s)];
    context.report_short_phases(&phases, report);
    let schema = context.parameter(draft.parameter.as_deref(), &context.field.key("parameter"), report);
    let from = draft
        .from
        .filter(|&from| schema.is_none_or(|schema| in_bounds(schema, from, &context.field.key("from"), report)));
    Some(RampPlan {
        parameter: draft.parameter.clone()?,
        from: from?,
        finer: draft.finer.unwrap_or_default(),
        steps: draft.steps.unwrap_or(RAMP_STEPS),
        step_s: draft.step_s.unwrap_or(RAMP_S[0]),
        black_s: draft.black_s.unwrap_or(RAMP_S[1]),
        answer_timeout_s: draft.answer_timeout_s,
        question: or_default(draft.question.as_ref(), "Did the quality increase, decrease, or stay the same?"),
        on_gaze_left: draft.on_gaze_left.unwrap_or_default().into(),
    })
}

pub(super) fn slider(draft: &SliderDraft, context: Context<'_>, report: &mut Report<'_>) -> Option<SliderPlan> {
    context.report_short_phases(&[("reference_s", draft.reference_s), ("compare_s", draft.compare_s)], report);
    let schema = context.parameter(draft.parameter.as_deref(), &context.field.key("parameter"), report);
    let field = context.field.key("values");
    let before = report.count();
    let given = draft.values.as_deref();
    let values = listed(given, &field, report);
    for &(index, value) in &values {
        if let Some(schema) = schema {
            in_bounds(schema, value, &field.item(index), report);
        }
    }
    if values.len() == 1 && given.is_some_and(|given| given.len() == 1) {
        report.at(&field, "expected at least two values, found one");
    }
    // Values that occur twice have been reported; which way the others go shows without them.
    if report.count() == before {
        report_turn(&values, &field, report);
    }
    let is_whole = report.count() == before && given.is_some_and(|given| given.len() == values.len());
    let values = is_whole.then(|| values.into_iter().map(|(_, value)| value).collect());
    Some(SliderPlan {
        parameter: draft.parameter.clone()?,
        values: values?,
        reference_s: draft.reference_s?,
        compare_s: draft.compare_s,
        most_moves: draft.most_moves,
    })
}

/// Reports the first value at which a list turns round.
fn report_turn(values: &[(usize, f64)], field: &Field, report: &mut Report<'_>) {
    let [(_, first), (_, second), ..] = values else { return };
    let rises = second > first;
    let turn = values.windows(2).find(|pair| (pair[1].1 > pair[0].1) != rises);
    if let Some([(_, before), (index, value)]) = turn {
        let (way, than) = if rises { ("rise", "more") } else { ("fall", "less") };
        report.at(
            &field.item(*index),
            format!("expected values that {way} throughout, so {than} than {before}, found {value}"),
        );
    }
}

pub(super) fn adjustment(
    draft: &AdjustmentDraft,
    context: Context<'_>,
    report: &mut Report<'_>,
) -> Option<AdjustmentPlan> {
    let field = context.field.key("parameters");
    let drafts = draft.parameters.as_ref()?;
    let before = report.count();
    if !(1..=MOST_ADJUSTED).contains(&drafts.len()) {
        report.at(
            &field,
            format!("expected 1 to {MOST_ADJUSTED} parameters, one for each digit, found {}", drafts.len()),
        );
    }
    let mut seen = BTreeSet::new();
    let mut parameters = Vec::new();
    for (index, draft) in drafts.iter().enumerate() {
        let field = field.item(index);
        let Some(draft) = draft else { continue };
        if let Some(name) = draft.parameter.as_deref().filter(|name| !seen.insert(name.to_owned())) {
            report.at(&field.key("parameter"), format!("expected each parameter once, found {name:?} again"));
        }
        parameters.push(adjusted(draft, context, &field, report));
    }
    let is_whole = report.count() == before && parameters.len() == drafts.len();
    let parameters: Option<Vec<Adjusted>> = parameters.into_iter().collect();
    Some(AdjustmentPlan { parameters: parameters.filter(|_| is_whole)?, most_moves: draft.most_moves })
}

fn adjusted(draft: &AdjustedDraft, context: Context<'_>, field: &Field, report: &mut Report<'_>) -> Option<Adjusted> {
    let schema = context.parameter(draft.parameter.as_deref(), &field.key("parameter"), report);
    for (name, value) in [("min", draft.min), ("max", draft.max)] {
        if let Some((schema, value)) = schema.zip(value) {
            in_bounds(schema, value, &field.key(name), report);
        }
    }
    if let Some((min, max)) = draft.min.zip(draft.max).filter(|(min, max)| min >= max) {
        report.at(&field.key("max"), format!("expected more than min ({min}), found {max}"));
    }
    let step = step(draft, field, report);
    if let (Some(step), Some((min, max))) = (step, draft.min.zip(draft.max).filter(|(min, max)| min < max)) {
        report_crossing(step, min, max, field, report);
    }
    Some(Adjusted { parameter: draft.parameter.clone()?, min: draft.min?, max: draft.max?, step: step? })
}

/// Reports a step that is larger than its range, or so small that nobody crosses it.
fn report_crossing(step: AdjustmentStep, min: f64, max: f64, field: &Field, report: &mut Report<'_>) {
    let (name, size, moves) = match step {
        AdjustmentStep::Add(step) => ("add", step, (max - min) / step),
        AdjustmentStep::Multiply(factor) => ("multiply", factor, (max / min).ln() / factor.ln()),
    };
    // A range of one step is still a choice; rounding must not refuse it.
    if !(1.0 - 1e-9..=MOST_CROSSING).contains(&moves) {
        report.at(
            &field.key(name),
            format!("expected a step that leads from {min} to {max} in 1 to {MOST_CROSSING} moves, found {size}"),
        );
    }
}

fn step(draft: &AdjustedDraft, field: &Field, report: &mut Report<'_>) -> Option<AdjustmentStep> {
    let (add, multiply) = (field.key("add"), field.key("multiply"));
    match (draft.add, draft.multiply) {
        (Some(step), None) if step > 0.0 => Some(AdjustmentStep::Add(step)),
        (Some(step), None) => {
            report.at(&add, format!("expected a step above 0, found {step}"));
            None
        }
        (None, Some(factor)) if factor <= 1.0 => {
            report.at(&multiply, format!("expected a factor above 1, found {factor}"));
            None
        }
        (None, Some(factor)) => match draft.min {
            Some(min) if min <= 0.0 => {
                let expected =
                    "expected a range above 0, which a factor can cross (or \"add\" instead of \"multiply\")";
                report.at(&field.key("min"), format!("{expected}, found {min}"));
                None
            }
            _ => Some(AdjustmentStep::Multiply(factor)),
        },
        (Some(_), Some(_)) => {
            report.at_key(&multiply, "expected either \"add\" or \"multiply\", found both");
            None
        }
        (None, None) => {
            // One that is there but could not be read has been reported.
            if !report.has(&add) && !report.has(&multiply) {
                report.at(&add, "expected \"add\" or \"multiply\", which say what one move does, found neither");
            }
            None
        }
    }
}
