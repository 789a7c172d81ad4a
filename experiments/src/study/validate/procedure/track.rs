//! Staircases and QUEST, which move freely between limits.

use super::one_parameter::{place, within};
use super::stop::{Offered, bounded};
use super::{Around, MOST_TRIALS};
use crate::procedures::quest::MOST_HALF_POINTS;
use crate::study::draft::{OneOrMore, QuestDraft, StaircaseDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{Axis, QuestMethod, QuestPlan, StaircasePlan, StepType};
use crate::study::source::Field;

/// The most tracks of a staircase.
const MOST_TRACKS: usize = 100;
/// A staircase's reversals that make the estimate where a study does not say.
const ESTIMATE_REVERSALS: u32 = 6;

pub(super) fn staircase(
    draft: &StaircaseDraft,
    around: Around<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<StaircasePlan> {
    let before = report.count();
    let parameter = draft.parameter.as_deref();
    let place = place(parameter, draft.fixed.as_ref(), draft.limits.as_ref(), around, field, report);

    let log = draft.step_type.is_some_and(|step_type| step_type != StepType::Linear);
    let start_field = field.key("start");
    let start: Vec<(Field, f64)> = match &draft.start {
        None => Vec::new(),
        Some(OneOrMore::One(value)) => vec![(start_field, *value)],
        Some(OneOrMore::Several(values)) => {
            if values.is_empty() {
                report.at(&start_field, "expected at least one number, found an empty list");
            }
            if values.len() > MOST_TRACKS {
                report.at(&start_field, format!("expected at most {MOST_TRACKS} tracks, found {}", values.len()));
            }
            let values = values.iter().enumerate();
            values.filter_map(|(index, value)| Some((start_field.item(index), (*value)?))).collect()
        }
    };
    for (field, value) in &start {
        within(place.as_ref(), *value, log, field, report);
    }

    let steps_field = field.key("steps");
    let steps = draft.steps.as_deref().unwrap_or_default();
    if draft.steps.is_some() && steps.is_empty() {
        report.at(&steps_field, "expected at least one step, found an empty list");
    }
    for (index, step) in steps.iter().enumerate() {
        if let Some(step) = step.filter(|&step| step <= 0.0) {
            report.at(&steps_field.item(index), format!("expected a step above 0, found {step}"));
        }
    }

    let quantities: Vec<&str> = parameter.into_iter().collect();
    let offered = Offered { procedure: "a staircase", quantities: &quantities, reversals: true };
    let stop_field = field.key("stop");
    let stop = draft.stop.as_ref().and_then(|draft| bounded(draft, offered, &stop_field, report));
    let trials = stop.as_ref().and_then(|stop| stop.max_trials()).unwrap_or(0) as usize * start.len();
    if trials > MOST_TRIALS {
        let tracks = start.len();
        report.at(
            &stop_field,
            format!("expected at most {MOST_TRIALS} trials in a block, found up to {trials} in {tracks} tracks"),
        );
    }
    if report.count() > before {
        return None;
    }
    Some(StaircasePlan {
        place: place?,
        harder: draft.harder?,
        start: start.into_iter().map(|(_, value)| value).collect(),
        steps: steps.iter().copied().collect::<Option<_>>()?,
        step_type: draft.step_type?,
        up_down_ratio: draft.up_down_ratio.unwrap_or(1.0),
        n_up: draft.n_up.unwrap_or(1),
        n_down: draft.n_down?,
        initial_rule: draft.initial_rule.unwrap_or(true),
        estimate_reversals: draft.estimate_reversals.unwrap_or(ESTIMATE_REVERSALS),
        stop: stop?,
    })
}

pub(super) fn quest(
    draft: &QuestDraft,
    around: Around<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<QuestPlan> {
    let before = report.count();
    let parameter = draft.parameter.as_deref();
    let place = place(parameter, draft.fixed.as_ref(), draft.limits.as_ref(), around, field, report);
    if let Some(start) = draft.start {
        within(place.as_ref(), start, draft.axis == Some(Axis::Log), &field.key("start"), report);
    }

    // Between γ and the highest probability, and reached within the tables.
    let [gamma, delta] = [draft.gamma.unwrap_or(0.5), draft.delta.unwrap_or(0.01)];
    let (p_threshold, beta) = (draft.p_threshold.unwrap_or(0.82), draft.beta.unwrap_or(3.5));
    let grain = draft.grain.unwrap_or(0.01);
    let range = draft.range.unwrap_or(500.0 * grain);
    let highest = delta * gamma + 1.0 - delta;
    let unread = ["gamma", "delta", "p_threshold", "beta", "grain", "range"].map(|key| report.has(&field.key(key)));
    if !unread.contains(&true) {
        let points = (0.5 * range / grain).ceil();
        let weibull = |x: f64| highest - (1.0 - delta) * (1.0 - gamma) * (-10_f64.powf(beta * x)).exp();
        let reach = 2.0 * points * grain;
        if p_threshold <= gamma || p_threshold >= highest {
            report.at(
                &field.key("p_threshold"),
                format!("expected more than gamma ({gamma}) and less than {highest:.4}, found {p_threshold}"),
            );
        } else if points < 1.0 || points > MOST_HALF_POINTS as f64 {
            report.at(
                &field.key("range"),
                format!("expected 1 to {} grains of {grain}, found {range}", 2 * MOST_HALF_POINTS),
            );
        } else if weibull(-reach) >= p_threshold || weibull(reach) <= p_threshold {
            report.at(
                &field.key("range"),
                format!("expected a range in which the function of beta {beta} passes p_threshold, found {range}"),
            );
        }
    }

    let quantities: Vec<&str> = parameter.into_iter().collect();
    let offered = Offered { procedure: "QUEST", quantities: &quantities, reversals: false };
    let stop = draft.stop.as_ref().and_then(|draft| bounded(draft, offered, &field.key("stop"), report));
    if report.count() > before {
        return None;
    }
    Some(QuestPlan {
        place: place?,
        harder: draft.harder?,
        axis: draft.axis?,
        start: draft.start?,
        start_sd: draft.start_sd?,
        p_threshold,
        beta,
        delta,
        gamma,
        grain,
        range,
        method: draft.method.unwrap_or(QuestMethod::Quantile),
        stop: stop?,
    })
}
