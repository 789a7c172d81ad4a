//! QUEST+ over a psychometric function, and Psi: levels from lists, and a grid of parameters.

use super::one_parameter::{finest_mar, fixed, ring};
use super::stop::{Offered, bounded};
use super::{Around, MOST_CELLS, MOST_LEVELS, Written, combinations, in_bounds, number_parameter};
use crate::procedures::tabulation::Shared;
use crate::study::draft::{FunctionDraft, PsiDraft, SpacedDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{Axis, Function, FunctionPlan, Level, PsiPlan};
use crate::study::source::Field;
use crate::study::validate::values::{listed, spaced};
use std::ops::RangeInclusive;

/// Widths and slopes.
const SCALES: RangeInclusive<f64> = 1e-6..=1e6;
const ANY: RangeInclusive<f64> = -1e9..=1e9;

pub(super) fn quest_plus(
    draft: &FunctionDraft,
    around: Around<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<FunctionPlan> {
    let before = report.count();
    let axis = draft.axis.unwrap_or(Axis::Linear);
    if draft.function == Some(Function::Weibull) && draft.axis == Some(Axis::Linear) {
        report.at(
            &field.key("axis"),
            "expected \"log\" for a Weibull function, whose shape over the parameter itself is \"gumbel\"; found \"linear\"",
        );
    }
    if draft.covariate.is_some() && draft.covariate == draft.parameter {
        let other = format!("expected another parameter than the function's, found {:?}", draft.covariate.as_deref()?);
        report.at(&field.key("covariate"), other);
    }
    let levels = stimuli(draft, axis, around, field, report);

    let prior_field = field.key("prior");
    let prior = draft.prior.as_ref();
    let of_list = |key: &str, list: Option<&Vec<Option<f64>>>, bounds, report: &mut Report<'_>| {
        bounded_list(list.map(Vec::as_slice)?, bounds, &prior_field.key(key), report)
    };
    let threshold = prior.and_then(|prior| prior.threshold.as_ref());
    let threshold = threshold.and_then(|draft| values(draft, axis, &prior_field.key("threshold"), report));
    let width = of_list("width", prior.and_then(|prior| prior.width.as_ref()), SCALES, report);
    let lapse = prior.map_or(Some(vec![0.02]), |prior| match &prior.lapse {
        Some(list) => of_list("lapse", Some(list), 0.0..=0.5, report),
        None => Some(vec![0.02]),
    });
    let guess = prior.map_or(Some(vec![0.5]), |prior| match &prior.guess {
        Some(list) => of_list("guess", Some(list), 0.0..=0.5, report),
        None => Some(vec![0.5]),
    });
    let slope_field = prior_field.key("threshold_slope");
    let slope_draft = prior.and_then(|prior| prior.threshold_slope.as_ref());
    let threshold_slope = match (slope_draft, draft.covariate.as_deref()) {
        (Some(list), Some(_)) => of_list("threshold_slope", Some(list), ANY, report),
        (Some(_), None) => {
            report.at_key(&slope_field, "expected a covariate for it to multiply, found none");
            None
        }
        (None, Some(covariate)) => {
            if prior.is_some() && !report.has(&slope_field) {
                let expected = "expected a list of numbers, how far the threshold rises with";
                report.at(&slope_field, format!("{expected} {covariate}; found no such key"));
            }
            None
        }
        (None, None) => Some(vec![0.0]),
    };
    if let (Axis::Log, Some(covariate), Some((levels, _)), Some(thresholds), Some(slopes)) =
        (axis, &draft.covariate, &levels, &threshold, &threshold_slope)
    {
        let at = levels.iter().filter_map(|level| level.get(covariate));
        let rises = at.flat_map(|c| slopes.iter().map(move |slope| slope * c));
        let lowest = rises.fold(f64::INFINITY, f64::min) + thresholds.iter().copied().fold(f64::INFINITY, f64::min);
        if lowest <= 0.0 {
            report.at(&slope_field, format!("expected thresholds above 0 at every {covariate}, found {lowest}"));
        }
    }

    let mut quantities = vec!["threshold", "width", "lapse", "guess"];
    if draft.covariate.is_some() {
        quantities.push("threshold_slope");
    }
    let offered = Offered { procedure: "QUEST+ over this function", quantities: &quantities, reversals: false };
    let stop = draft.stop.as_ref().and_then(|draft| bounded(draft, offered, &field.key("stop"), report));
    if report.count() > before {
        return None;
    }
    let (levels, levels_beyond_display) = levels?;
    let plan = FunctionPlan {
        levels,
        levels_beyond_display,
        parameter: draft.parameter.clone()?,
        covariate: draft.covariate.clone(),
        harder: draft.harder?,
        function: draft.function?,
        axis: draft.axis?,
        threshold: threshold?,
        threshold_slope: threshold_slope?,
        width: width?,
        lapse: lapse?,
        guess: guess?,
        stop: stop?,
        tables: Shared::default(),
    };
    let axes = [&plan.threshold, &plan.threshold_slope, &plan.width, &plan.lapse, &plan.guess];
    few_enough_cells(plan.levels.len(), &axes, field, report).then_some(plan)
}

pub(super) fn psi(draft: &PsiDraft, around: Around<'_>, field: &Field, report: &mut Report<'_>) -> Option<PsiPlan> {
    let before = report.count();
    let function = draft.function.unwrap_or(Function::CumulativeGauss);
    if !matches!(function, Function::CumulativeGauss | Function::Logistic) {
        report.at(
            &field.key("function"),
            "expected \"cumulative-gauss\" or \"logistic\", whose slopes Psi is stated in, found another function",
        );
    }
    let axis = draft.axis.unwrap_or(Axis::Linear);
    let values_field = field.key("values");
    let moving: Vec<&str> = draft.parameter.as_deref().into_iter().collect();
    let fixed = fixed(draft.fixed.as_ref(), &moving, around, field, report);
    let list = draft.parameter.as_deref().zip(draft.values.as_ref()).and_then(|(name, draft)| {
        let schema_field = field.key("parameter");
        stimulus_values(name, draft, axis, (around, &schema_field, Written::AsValue), &values_field, report)
    });
    let levels = draft
        .parameter
        .as_deref()
        .zip(list)
        .and_then(|(name, values)| on_display(vec![(name, values)], &fixed, around, &values_field, report));
    let of = |key: &str, draft: &Option<SpacedDraft>, axis, report: &mut Report<'_>| {
        values(draft.as_ref()?, axis, &field.key(key), report)
    };
    let threshold = of("threshold", &draft.threshold, axis, report);
    let slope = of("slope", &draft.slope, Axis::Log, report);
    let offered = Offered { procedure: "Psi", quantities: &["threshold", "slope"], reversals: false };
    let stop = draft.stop.as_ref().and_then(|draft| bounded(draft, offered, &field.key("stop"), report));
    if report.count() > before {
        return None;
    }
    let (levels, levels_beyond_display) = levels?;
    let plan = PsiPlan {
        levels,
        levels_beyond_display,
        parameter: draft.parameter.clone()?,
        harder: draft.harder?,
        function,
        axis: draft.axis?,
        threshold: threshold?,
        slope: slope?,
        guess: draft.guess.unwrap_or(0.5),
        lapse: draft.lapse.unwrap_or(0.02),
        stop: stop?,
        tables: Shared::default(),
    };
    few_enough_cells(plan.levels.len(), &[&plan.threshold, &plan.slope], field, report).then_some(plan)
}

/// The levels of a function with its covariate, and how many the display cannot show.
fn stimuli(
    draft: &FunctionDraft,
    axis: Axis,
    around: Around<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<(Vec<Level>, usize)> {
    let stimuli_field = field.key("stimuli");
    let moving: Vec<&str> = [&draft.covariate, &draft.parameter].into_iter().flatten().map(String::as_str).collect();
    let fixed = fixed(draft.fixed.as_ref(), &moving, around, field, report);
    let given = draft.stimuli.as_ref()?;
    for name in given.keys().filter(|name| !moving.contains(&name.as_str()) && draft.parameter.is_some()) {
        report.at_key(
            &stimuli_field.key(name),
            format!("expected only what the function reads ({}), found \"{name}\"", moving.join(", ")),
        );
    }
    let before = report.count();
    let mut lists = Vec::new();
    for &name in &moving {
        let list_field = stimuli_field.key(name);
        match given.get(name) {
            None => report.at(&list_field, format!("expected values for {name}, found no such key")),
            Some(None) => return None,
            Some(Some(values)) => {
                let axis = if draft.parameter.as_deref() == Some(name) { axis } else { Axis::Linear };
                let at = (around, &list_field, Written::AsKey);
                lists.push((name, stimulus_values(name, values, axis, at, &list_field, report)));
            }
        }
    }
    if report.count() > before || draft.parameter.is_none() {
        return None;
    }
    let lists: Vec<(&str, Vec<f64>)> =
        lists.into_iter().map(|(name, values)| Some((name, values?))).collect::<Option<_>>()?;
    on_display(lists, &fixed, around, &stimuli_field, report)
}

/// The values of a renderer parameter, within its bounds, and on the display where they are the ring's eccentricity.
fn stimulus_values(
    name: &str,
    draft: &SpacedDraft,
    axis: Axis,
    (around, name_field, written): (Around<'_>, &Field, Written),
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Vec<f64>> {
    let before = report.count();
    let schema = around.target.and_then(|(_, renderer)| number_parameter(name, renderer, name_field, written, report));
    let values = values(draft, axis, field, report)?;
    for (index, &value) in values.iter().enumerate() {
        // A range is at fault at its ends.
        let field = match draft {
            SpacedDraft::List(_) => field.item(index),
            SpacedDraft::Range(_) if index == 0 => field.key("min"),
            SpacedDraft::Range(_) if index + 1 == values.len() => field.key("max"),
            SpacedDraft::Range(_) => continue,
        };
        let fits = schema.is_some_and(|schema| in_bounds(schema, value, &field, report));
        if let Some(geometry) = around.geometry.filter(|_| fits)
            && ring(around).is_some_and(|[eccentricity, _]| eccentricity == name)
        {
            geometry.ring_is_visible(value, &field, report);
        }
    }
    (report.count() == before).then_some(values)
}

/// All combinations that the display can show, and how many it cannot.
fn on_display<'n>(
    mut lists: Vec<(&'n str, Vec<f64>)>,
    fixed: &'n Level,
    around: Around<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<(Vec<Level>, usize)> {
    let count = lists.iter().map(|(_, values)| values.len()).fold(1_usize, usize::saturating_mul);
    if count > MOST_LEVELS {
        report.at(field, format!("expected at most {MOST_LEVELS} combinations of levels, found {count}"));
        return None;
    }
    lists.extend(fixed.iter().map(|(name, &value)| (name.as_str(), vec![value])));
    let shown = |level: &Level| {
        let omega = around.target.and_then(|(condition, _)| condition.tested_at(level)[1]);
        omega.zip(finest_mar(level, around)).is_none_or(|(omega, (_, finest))| omega >= finest)
    };
    let levels: Vec<Level> = combinations(&lists).into_iter().filter(shown).collect();
    if levels.len() < 2 {
        let beyond = count - levels.len();
        report.at(
            field,
            format!(
                "expected at least two levels that the display can show, found {} ({beyond} are too fine for it)",
                levels.len()
            ),
        );
        return None;
    }
    let beyond = count - levels.len();
    Some((levels, beyond))
}

/// A list without repetition, or a range along the axis; all above zero on a log axis.
fn values(draft: &SpacedDraft, axis: Axis, field: &Field, report: &mut Report<'_>) -> Option<Vec<f64>> {
    let before = report.count();
    let bounds = if axis == Axis::Log { f64::MIN_POSITIVE..=1e9 } else { ANY };
    match draft {
        SpacedDraft::List(list) => bounded_list(list, bounds, field, report),
        SpacedDraft::Range(range) => {
            for (key, value) in [("min", range.min), ("max", range.max)] {
                if let Some(value) = value.filter(|value| !bounds.contains(value)) {
                    let expected = if axis == Axis::Log { "above 0" } else { "that is not so large" };
                    report.at(&field.key(key), format!("expected a number {expected}, found {value}"));
                }
            }
            let values = (report.count() == before).then(|| spaced(range, axis, field, report))?;
            values.filter(|_| report.count() == before)
        }
    }
}

fn bounded_list(
    list: &[Option<f64>],
    bounds: RangeInclusive<f64>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Vec<f64>> {
    let before = report.count();
    let given = listed(Some(list), field, report);
    for &(index, value) in given.iter().filter(|(_, value)| !bounds.contains(value)) {
        let (least, most) = (bounds.start(), bounds.end());
        let expected = match *least <= f64::MIN_POSITIVE && *least > 0.0 {
            true => "a number above 0".to_owned(),
            false => format!("a number from {least} to {most}"),
        };
        report.at(&field.item(index), format!("expected {expected}, found {value}"));
    }
    let is_whole = report.count() == before && given.len() == list.len();
    is_whole.then(|| given.into_iter().map(|(_, value)| value).collect())
}

/// Reports a likelihood table that would be too large.
fn few_enough_cells(levels: usize, axes: &[&Vec<f64>], field: &Field, report: &mut Report<'_>) -> bool {
    let points = axes.iter().map(|axis| axis.len()).fold(1, usize::saturating_mul);
    let count = points.saturating_mul(levels);
    if count > MOST_CELLS {
        report.at_key(
            field,
            format!(
                "expected at most {MOST_CELLS} cells in the likelihood table, found {levels} levels × {points} parameter \
                 values = {count}"
            ),
        );
    }
    count <= MOST_CELLS
}
