//! Procedures in words.

use crate::study::plan::{
    Axis, Function, FunctionPlan, Harder, Precision, ProcedurePlan, QuestMethod, StaircasePlan, StepType, Stop,
};

/// The procedure, when it ends, and how many levels were left out because the display cannot show them.
pub(super) fn in_words(plan: &ProcedurePlan) -> (String, String, usize) {
    let beyond = match plan {
        ProcedurePlan::QuestPlus(plan) => plan.levels_beyond_display,
        ProcedurePlan::QuestPlusFunction(plan) => plan.levels_beyond_display,
        ProcedurePlan::Psi(plan) => plan.levels_beyond_display,
        ProcedurePlan::Constant(_) | ProcedurePlan::Staircase(_) | ProcedurePlan::Quest(_) => 0,
    };
    (procedure_in_words(plan), ending_in_words(plan), beyond)
}

fn procedure_in_words(plan: &ProcedurePlan) -> String {
    match plan {
        ProcedurePlan::Constant(constant) => format!("constant stimuli, {} × each level", constant.repetitions),
        ProcedurePlan::Staircase(plan) => staircase_in_words(plan),
        ProcedurePlan::Quest(plan) => {
            let method = match plan.method {
                QuestMethod::Quantile => "best quantile",
                QuestMethod::Mean => "mean",
                QuestMethod::Mode => "mode",
            };
            let [parameter, axis] = [plan.place.parameter(), axis_in_words(plan.axis)];
            format!(
                "QUEST on {parameter}{axis}, first {}, then at the {method} of the threshold for {} % right",
                plan.start,
                100.0 * plan.p_threshold
            )
        }
        ProcedurePlan::QuestPlus(quest) => {
            let points = quest.m.len() * quest.omega0_deg.len() * quest.width.len() * quest.lapse.len();
            let where_to = if quest.balanced { "every eccentricity equally often" } else { "any eccentricity" };
            format!("QUEST+ over the MAR model, {points} grid points, {where_to}")
        }
        ProcedurePlan::QuestPlusFunction(plan) => function_in_words(plan),
        ProcedurePlan::Psi(plan) => format!(
            "Psi over threshold and slope of a {} of {}{}, {} grid points",
            shape_in_words(plan.function),
            plan.parameter,
            axis_in_words(plan.axis),
            plan.threshold.len() * plan.slope.len()
        ),
    }
}

fn staircase_in_words(plan: &StaircasePlan) -> String {
    let unit = match plan.step_type {
        StepType::Linear => "",
        StepType::Log => " log10",
        StepType::Db => " dB",
    };
    let joined = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let weighted = (plan.up_down_ratio - 1.0).abs() > 0.0;
    let [kind, ratio] = match weighted {
        true => ["weighted ", &format!(" to the harder side, {} × to the easier", plan.up_down_ratio)],
        false => ["", ""],
    };
    let direction = if plan.harder == Harder::Down { "smaller" } else { "larger" };
    let tracks = if plan.start.len() > 1 { format!(" in {} tracks", plan.start.len()) } else { String::new() };
    format!(
        "{kind}staircase on {}, {}-up-{}-down, {direction} is harder, from {}{tracks}, steps {}{unit}{ratio}",
        plan.place.parameter(),
        plan.n_up,
        plan.n_down,
        joined(&plan.start),
        joined(&plan.steps)
    )
}

fn function_in_words(plan: &FunctionPlan) -> String {
    let axes = [&plan.threshold, &plan.threshold_slope, &plan.width, &plan.lapse, &plan.guess];
    let points: usize = axes.iter().map(|axis| axis.len()).product();
    let covariate = plan.covariate.as_ref().map(|name| format!(", threshold linear in {name}")).unwrap_or_default();
    format!(
        "QUEST+ over a {} of {}{}{covariate}, {points} grid points",
        shape_in_words(plan.function),
        plan.parameter,
        axis_in_words(plan.axis)
    )
}

fn shape_in_words(function: Function) -> &'static str {
    match function {
        Function::CumulativeGauss => "cumulative Gauss",
        Function::Logistic => "logistic function",
        Function::Weibull => "Weibull function",
        Function::Gumbel => "Gumbel function",
        Function::HyperbolicSecant => "cumulative hyperbolic secant",
    }
}

fn axis_in_words(axis: Axis) -> &'static str {
    match axis {
        Axis::Linear => "",
        Axis::Log => " on a log axis",
    }
}

fn ending_in_words(plan: &ProcedurePlan) -> String {
    match plan {
        ProcedurePlan::Constant(_) => "after every level has had its repetitions".to_owned(),
        ProcedurePlan::Staircase(plan) if plan.start.len() > 1 => {
            format!("each track {}", stop_in_words(&plan.stop))
        }
        _ => plan.stop().map(stop_in_words).unwrap_or_default(),
    }
}

fn stop_in_words(stop: &Stop) -> String {
    // The usual rule reads better in words of its own.
    if let Stop::Any(rules) = stop
        && let [Stop::Trials(most), Stop::All(all)] = rules.as_slice()
        && let [Stop::Trials(fewest), narrow @ ..] = all.as_slice()
        && !narrow.is_empty()
        && narrow.iter().all(|rule| matches!(rule, Stop::Narrow { limit: Precision::RelativeSd(_), .. }))
    {
        let rules: Vec<String> = narrow.iter().map(narrow_in_words).collect();
        let rules = rules.join(" and ");
        return format!("after {most} trials, or from {fewest} on when {rules} (posterior SD / mean)");
    }
    match stop {
        Stop::Trials(count) => format!("after {count} trials"),
        _ => format!("when {}", rule_in_words(stop, false)),
    }
}

fn rule_in_words(stop: &Stop, within: bool) -> String {
    let joined = |rules: &[Stop], word: &str| {
        let rules: Vec<String> = rules.iter().map(|rule| rule_in_words(rule, true)).collect();
        let text = rules.join(word);
        if within && rules.len() > 1 { format!("({text})") } else { text }
    };
    match stop {
        Stop::Trials(count) => format!("{count} trials are done"),
        Stop::Reversals(count) => format!("{count} reversals are reached"),
        Stop::Narrow { .. } => narrow_in_words(stop),
        Stop::All(rules) => joined(rules, " and "),
        Stop::Any(rules) => joined(rules, " or "),
    }
}

fn narrow_in_words(rule: &Stop) -> String {
    let Stop::Narrow { quantity, limit } = rule else { return String::new() };
    match limit {
        Precision::Sd(sd) => format!("the SD of {quantity} is at most {sd}"),
        Precision::RelativeSd(share) => {
            let name = if quantity == "omega0_deg" { "omega0" } else { quantity };
            format!("{name} is known to {:.3} %", 100.0 * share).replace(".000", "")
        }
    }
}
