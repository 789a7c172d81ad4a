//! Procedures against renderer and display: do the levels exist, are they in bounds, can they be shown?

mod function;
mod one_parameter;
mod stop;
mod track;

use super::display::Geometry;
use super::values::{geometric, listed, log_spaced};
use crate::catalogue::{ParameterKind, ParameterSchema, ParameterValue, RendererInfo};
use crate::procedures::tabulation::Shared;
use crate::study::draft::{AxisDraft, ConstantDraft, PriorDraft, ProcedureDraft, QuestPlusDraft};
use crate::study::mistakes::{Report, suggestion};
use crate::study::plan::{Condition, ConstantPlan, Level, MarAxes, ProcedurePlan, QuestPlusPlan};
use crate::study::source::Field;
use std::collections::BTreeMap;

/// The most levels of a constant block.
const MOST_LEVELS: usize = 10_000;
/// The most trials of one block.
const MOST_TRIALS: usize = 100_000;
/// The most cells of a QUEST+ likelihood table (levels × grid points): 160 MB of f64, about 20 ms a trial.
const MOST_CELLS: usize = 20_000_000;

/// What the levels of a procedure are set on.
type Target<'a> = Option<(&'a Condition, &'a RendererInfo)>;

/// What the levels of a procedure are held against.
#[derive(Clone, Copy)]
struct Around<'a> {
    target: Target<'a>,
    geometry: Option<Geometry<'a>>,
}

/// A procedure with every level listed.
pub(super) fn checked(
    draft: &ProcedureDraft,
    target: Target<'_>,
    geometry: Option<Geometry<'_>>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<ProcedurePlan> {
    let around = Around { target, geometry };
    match draft {
        ProcedureDraft::Constant(draft) => {
            constant(draft, target, geometry, field, report).map(ProcedurePlan::Constant)
        }
        ProcedureDraft::Staircase(draft) => {
            track::staircase(draft, around, field, report).map(ProcedurePlan::Staircase)
        }
        ProcedureDraft::Quest(draft) => track::quest(draft, around, field, report).map(ProcedurePlan::Quest),
        ProcedureDraft::QuestPlusFunction(draft) => {
            function::quest_plus(draft, around, field, report).map(ProcedurePlan::QuestPlusFunction)
        }
        ProcedureDraft::Psi(draft) => function::psi(draft, around, field, report).map(ProcedurePlan::Psi),
        ProcedureDraft::QuestPlus(draft) => {
            quest_plus(draft, target, geometry, field, report).map(ProcedurePlan::QuestPlus)
        }
    }
}

fn constant(
    draft: &ConstantDraft,
    target: Target<'_>,
    geometry: Option<Geometry<'_>>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<ConstantPlan> {
    let levels_field = field.key("levels");
    let axes = MarAxes::default();
    let unstated = BTreeMap::new();
    let lists = draft.levels.as_ref().unwrap_or(&unstated);
    if draft.levels.is_some() && lists.is_empty() {
        report.at(&levels_field, "expected at least one renderer parameter with its values, found an empty object");
        return None;
    }

    // Each list on its own: known parameter, values in bounds, none twice, rings on the display.
    let before = report.count();
    for (name, values) in lists {
        let list_field = levels_field.key(name);
        let schema =
            target.and_then(|(_, renderer)| number_parameter(name, renderer, &list_field, Written::AsKey, report));
        for (index, value) in listed(values.as_deref(), &list_field, report) {
            let field = list_field.item(index);
            let in_bounds = schema.is_none_or(|schema| in_bounds(schema, value, &field, report));
            if let Some(geometry) = geometry.filter(|_| in_bounds && *name == axes.eccentricity) {
                geometry.ring_is_visible(value, &field, report);
            }
        }
    }
    if report.count() > before {
        return None;
    }

    // All combinations. A list with a gap has been reported, and says nothing about the others.
    let lists: Vec<(&str, Vec<f64>)> = lists
        .iter()
        .map(|(name, values)| Some((name.as_str(), values.as_ref()?.iter().copied().collect::<Option<Vec<f64>>>()?)))
        .collect::<Option<_>>()?;
    let count = lists.iter().map(|(_, values)| values.len()).fold(1_usize, usize::saturating_mul);
    if count > MOST_LEVELS {
        report.at(&levels_field, format!("expected at most {MOST_LEVELS} combinations of levels, found {count}"));
        return None;
    }
    if let Some(geometry) = geometry {
        // What the condition holds constant is shown with every level.
        let mut shown = lists.clone();
        for axis in [&axes.eccentricity, &axes.mar] {
            let constant = target.and_then(|(condition, _)| condition.renderer_parameters.get(axis));
            if let Some(ParameterValue::Number(value)) = constant.filter(|_| lists.iter().all(|(name, _)| name != axis))
            {
                shown.push((axis, vec![*value]));
            }
        }
        report_too_fine(&shown, &axes, geometry, &levels_field, report);
    }
    let repetitions = draft.repetitions?;
    let trials = count.saturating_mul(repetitions as usize);
    if trials > MOST_TRIALS {
        report.at(
            &field.key("repetitions"),
            format!(
                "expected at most {MOST_TRIALS} trials in a block, found {count} levels × {repetitions} = {trials}"
            ),
        );
        return None;
    }
    Some(ConstantPlan { levels: combinations(&lists), repetitions })
}

/// Every combination of the lists' values, the last list varying fastest.
fn combinations(lists: &[(&str, Vec<f64>)]) -> Vec<Level> {
    lists.iter().fold(vec![Level::new()], |levels, (name, values)| {
        levels
            .iter()
            .flat_map(|level| {
                values.iter().map(move |&value| {
                    let mut level = level.clone();
                    level.insert((*name).to_owned(), value);
                    level
                })
            })
            .collect()
    })
}

/// Reports each MAR that some ring of the block is too coarse a place for.
fn report_too_fine(
    lists: &[(&str, Vec<f64>)],
    axes: &MarAxes,
    geometry: Geometry<'_>,
    field: &Field,
    report: &mut Report<'_>,
) {
    let values = |axis: &str| lists.iter().find(|(name, _)| *name == axis).map_or(&[][..], |(_, values)| values);
    let eccentricities = values(&axes.eccentricity);
    for (index, &mar_deg) in values(&axes.mar).iter().enumerate() {
        let limits = eccentricities.iter().map(|&e| (e, geometry.finest_mar_deg(e)));
        let coarsest = limits.max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((eccentricity_deg, finest)) = coarsest.filter(|(_, finest)| mar_deg < *finest) {
            report.at(
                &field.key(&axes.mar).item(index),
                format!(
                    "expected a MAR that the display \"{}\" can show at {eccentricity_deg}° ({finest:.4}° per cycle or \
                     coarser), found {mar_deg}",
                    geometry.display.name()
                ),
            );
        }
    }
}

fn quest_plus(
    draft: &QuestPlusDraft,
    target: Target<'_>,
    geometry: Option<Geometry<'_>>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<QuestPlusPlan> {
    let (eccentricity_field, mar_field) = (field.key("eccentricity"), field.key("mar"));
    let defaults = MarAxes::default();
    let axes = MarAxes {
        eccentricity: draft.eccentricity.as_ref().and_then(|d| d.parameter.clone()).unwrap_or(defaults.eccentricity),
        mar: draft.mar.as_ref().and_then(|d| d.parameter.clone()).unwrap_or(defaults.mar),
    };
    if axes.eccentricity == axes.mar {
        let other = format!("expected another parameter than the eccentricity's, found {:?}", axes.mar);
        report.at(&mar_field.key("parameter"), other);
    }

    let eccentricities = draft.eccentricity.as_ref().and_then(|draft| {
        let parameter = &eccentricity_field.key("parameter");
        let schema = target.and_then(|(_, renderer)| {
            number_parameter(&axes.eccentricity, renderer, parameter, Written::AsValue, report)
        });
        let before = report.count();
        let values_field = eccentricity_field.key("values");
        let values = listed(draft.values.as_deref(), &values_field, report);
        for &(index, value) in &values {
            let field = values_field.item(index);
            let in_bounds = schema.is_none_or(|schema| in_bounds(schema, value, &field, report));
            if let Some(geometry) = geometry.filter(|_| in_bounds) {
                geometry.ring_is_visible(value, &field, report);
            }
        }
        let is_whole = report.count() == before && values.len() == draft.values.as_ref()?.len();
        is_whole.then_some(values)
    });
    let mars = draft.mar.as_ref().and_then(|draft| {
        let parameter = &mar_field.key("parameter");
        let schema =
            target.and_then(|(_, renderer)| number_parameter(&axes.mar, renderer, parameter, Written::AsValue, report));
        let before = report.count();
        for (name, value) in [("min", draft.min), ("max", draft.max)] {
            if let Some((schema, value)) = schema.zip(value) {
                in_bounds(schema, value, &mar_field.key(name), report);
            }
        }
        let values = log_spaced(draft.min, draft.max, draft.steps, &mar_field, report);
        values.filter(|_| report.count() == before)
    });
    let levels = eccentricities.zip(mars).and_then(|(eccentricities, mars)| {
        levels_on_display(&eccentricities, &mars, &axes, geometry, &eccentricity_field.key("values"), report)
    });

    let prior = prior(draft.prior.as_ref(), &field.key("prior"), report);
    let stop = draft.stop.as_ref().and_then(|draft| stop::of_mar(draft, &field.key("stop"), report));
    let (levels, beyond) = levels?;
    let [m, omega0_deg, width, lapse] = prior?;
    let cells = [levels.len(), m.len(), omega0_deg.len(), width.len(), lapse.len()];
    let count = cells.into_iter().fold(1, usize::saturating_mul);
    if count > MOST_CELLS {
        let [levels, m, omega0, width, lapse] = cells;
        report.at_key(
            field,
            format!(
                "expected at most {MOST_CELLS} cells in the likelihood table, found {levels} levels × {m} m × {omega0} \
                 omega0 × {width} widths × {lapse} lapse rates = {count}"
            ),
        );
        return None;
    }
    Some(QuestPlusPlan {
        levels,
        levels_beyond_display: beyond,
        axes,
        balanced: draft.eccentricity.as_ref().and_then(|draft| draft.balanced).unwrap_or(true),
        m,
        omega0_deg,
        width,
        lapse,
        stop: stop?,
        tables: Shared::default(),
    })
}

/// Every pair of eccentricity and MAR that the display can show, and how many it cannot.
fn levels_on_display(
    eccentricities: &[(usize, f64)],
    mars: &[f64],
    axes: &MarAxes,
    geometry: Option<Geometry<'_>>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<(Vec<Level>, usize)> {
    let before = report.count();
    let mut levels = Vec::with_capacity(eccentricities.len() * mars.len());
    for &(index, eccentricity_deg) in eccentricities {
        let finest = geometry.map_or(0.0, |geometry| geometry.finest_mar_deg(eccentricity_deg));
        let shown = mars.iter().filter(|&&mar_deg| mar_deg >= finest);
        let count = levels.len();
        levels.extend(
            shown.map(|&mar_deg| {
                Level::from([(axes.eccentricity.clone(), eccentricity_deg), (axes.mar.clone(), mar_deg)])
            }),
        );
        if levels.len() == count {
            report.at(
                &field.item(index),
                format!(
                    "expected an eccentricity at which the display can show some of the MARs ({finest:.4}° per cycle or \
                     coarser), found {eccentricity_deg}° with none"
                ),
            );
        }
    }
    let beyond = eccentricities.len() * mars.len() - levels.len();
    (report.count() == before).then_some((levels, beyond))
}

/// The grids of m, omega0, width and lapse.
fn prior(draft: Option<&PriorDraft>, field: &Field, report: &mut Report<'_>) -> Option<[Vec<f64>; 4]> {
    let unstated = PriorDraft::default();
    let draft = draft.unwrap_or(&unstated);
    let m = grid(draft.m.as_ref(), || geometric(0.005, 0.08, 20), 0.0..=10.0, &field.key("m"), report);
    let omega0 =
        grid(draft.omega0_deg.as_ref(), || geometric(0.005, 0.1, 20), 1e-4..=10.0, &field.key("omega0_deg"), report);
    let width = grid(draft.width.as_ref(), || geometric(0.2, 3.0, 7), 0.01..=20.0, &field.key("width"), report);
    let lapse = grid(draft.lapse.as_ref(), || vec![0.0, 0.02, 0.05], 0.0..=0.5, &field.key("lapse"), report);
    Some([m?, omega0?, width?, lapse?])
}

fn grid(
    draft: Option<&AxisDraft>,
    default: impl FnOnce() -> Vec<f64>,
    bounds: std::ops::RangeInclusive<f64>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Vec<f64>> {
    let before = report.count();
    let refuse = |value: f64, field: &Field, report: &mut Report<'_>| {
        if !bounds.contains(&value) {
            report.at(field, format!("expected a number from {} to {}, found {value}", bounds.start(), bounds.end()));
        }
    };
    let values = match draft {
        None => return Some(default()),
        Some(AxisDraft::List(values)) => {
            let listed = listed(Some(values), field, report);
            for &(index, value) in &listed {
                refuse(value, &field.item(index), report);
            }
            (listed.len() == values.len()).then(|| listed.into_iter().map(|(_, value)| value).collect())
        }
        Some(AxisDraft::Range(range)) => {
            for (name, value) in [("min", range.min), ("max", range.max)] {
                if let Some(value) = value {
                    refuse(value, &field.key(name), report);
                }
            }
            log_spaced(range.min, range.max, range.steps, field, report)
        }
    };
    values.filter(|_| report.count() == before)
}

/// Where a parameter's name stands: as a key, or as a value that may be absent.
#[derive(Clone, Copy)]
pub(super) enum Written {
    AsKey,
    AsValue,
}

/// A renderer's numeric parameter, reported where there is none.
pub(super) fn number_parameter<'r>(
    name: &str,
    renderer: &'r RendererInfo,
    field: &Field,
    written: Written,
    report: &mut Report<'_>,
) -> Option<&'r ParameterSchema> {
    let is_number = |schema: &&ParameterSchema| matches!(schema.kind, ParameterKind::Number { .. });
    let known = || renderer.parameters.iter().filter(is_number).map(|schema| schema.name.as_str());
    let schema = renderer.parameters.iter().filter(is_number).find(|schema| schema.name == name);
    if schema.is_none() {
        let names = match known().count() {
            0 => "none at all".to_owned(),
            _ => known().collect::<Vec<_>>().join(", "),
        };
        let hint = suggestion(name, known());
        let message =
            format!("expected a numeric parameter of the renderer \"{}\" ({names}), found {name:?}{hint}", renderer.id);
        match written {
            Written::AsKey => report.at_key(field, message),
            Written::AsValue => report.at(field, message),
        }
    }
    schema
}

/// Reports a value out of a parameter's bounds, and says whether it is within.
pub(super) fn in_bounds(schema: &ParameterSchema, value: f64, field: &Field, report: &mut Report<'_>) -> bool {
    match schema.check(&ParameterValue::Number(value)) {
        Ok(()) => true,
        Err(error) => {
            report.at(field, format!("expected {}, found {}", error.expected, error.found));
            false
        }
    }
}
