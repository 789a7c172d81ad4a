//! One moving renderer parameter, its limits, and those that stay.

use super::{Around, Written, in_bounds, number_parameter};
use crate::catalogue::{DetailLaw, ParameterKind};
use crate::study::draft::{FixedDraft, LimitsDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{Level, Place};
use crate::study::source::Field;

/// The renderer's parameter that is the eccentricity of its ring, and the one that is the ring's MAR.
pub(super) fn ring(around: Around<'_>) -> Option<[&str; 2]> {
    match &around.target?.0.detail {
        DetailLaw::Ring { eccentricity, mar, .. } => Some([eccentricity, mar]),
        _ => None,
    }
}

/// What stays in every level, without the parameters that move.
pub(super) fn fixed(
    draft: Option<&FixedDraft>,
    moving: &[&str],
    around: Around<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Level {
    let mut level = Level::new();
    for (name, value) in draft.into_iter().flatten() {
        let field = field.key("fixed").key(name);
        if moving.contains(&name.as_str()) {
            report.at_key(&field, format!("expected a parameter that stays, found \"{name}\", which moves"));
            continue;
        }
        let schema =
            around.target.and_then(|(_, renderer)| number_parameter(name, renderer, &field, Written::AsKey, report));
        let Some(value) = *value else { continue };
        if schema.is_some_and(|schema| in_bounds(schema, value, &field, report)) {
            if ring(around).is_some_and(|[eccentricity, _]| eccentricity == name)
                && let Some(geometry) = around.geometry
            {
                geometry.ring_is_visible(value, &field, report);
            }
            level.insert(name.clone(), value);
        }
    }
    level
}

/// The finest MAR that the display can show at a level, and the eccentricity; nothing where the level has no ring.
pub(super) fn finest_mar(level: &Level, around: Around<'_>) -> Option<(f64, f64)> {
    let eccentricity_deg = around.target?.0.tested_at(level)[0]?;
    Some((eccentricity_deg, around.geometry?.finest_mar_deg(eccentricity_deg)))
}

/// Where a procedure on one parameter moves: its parameter, what stays, and limits within renderer and display.
pub(super) fn place(
    parameter: Option<&str>,
    fixed_draft: Option<&FixedDraft>,
    limits: Option<&LimitsDraft>,
    around: Around<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Place> {
    let before = report.count();
    let moving: Vec<&str> = parameter.into_iter().collect();
    let fixed = fixed(fixed_draft, &moving, around, field, report);
    let parameter = parameter?;
    let (_, renderer) = around.target?;
    let schema = number_parameter(parameter, renderer, &field.key("parameter"), Written::AsValue, report)?;
    let ParameterKind::Number { min: lowest, max: highest, .. } = schema.kind else { return None };

    let limits_field = field.key("limits");
    let [min, max] = [("min", limits.and_then(|l| l.min)), ("max", limits.and_then(|l| l.max))]
        .map(|(key, value)| value.filter(|&value| in_bounds(schema, value, &limits_field.key(key), report)));
    let mut limits = [min.unwrap_or(lowest), max.unwrap_or(highest)];
    match ring(around) {
        Some([_, mar]) if mar == parameter => {
            if let Some((eccentricity_deg, finest)) = finest_mar(&fixed, around)
                && limits[0] < finest
            {
                limits[0] = finest;
                if let Some((min, geometry)) = min.zip(around.geometry) {
                    report.at(
                        &limits_field.key("min"),
                        format!(
                            "expected a MAR that the display \"{}\" can show at {eccentricity_deg}° ({finest:.4}° per \
                             cycle or coarser), found {min}",
                            geometry.display.name()
                        ),
                    );
                }
            }
        }
        Some([eccentricity, _]) if eccentricity == parameter => {
            if let Some(geometry) = around.geometry {
                geometry.ring_is_visible(limits[0], &limits_field.key("min"), report);
                geometry.ring_is_visible(limits[1], &limits_field.key("max"), report);
            }
        }
        _ => {}
    }
    if report.count() == before && limits[0] >= limits[1] {
        let expected = format!("expected more than the lower limit ({:.4})", limits[0]);
        report.at(&limits_field.key("max"), format!("{expected}, found {}", limits[1]));
    }
    (report.count() == before).then(|| Place::new(parameter, fixed, limits))
}

/// Reports a value beyond the limits, or one that has no logarithm where one is needed.
pub(super) fn within(place: Option<&Place>, value: f64, log: bool, field: &Field, report: &mut Report<'_>) {
    if log && value <= 0.0 {
        report.at(field, format!("expected a number above 0, which has a logarithm, found {value}"));
    } else if let Some([min, max]) = place.map(Place::limits).filter(|[min, max]| !(*min..=*max).contains(&value)) {
        report.at(field, format!("expected a start within the limits ({min:.4} to {max:.4}), found {value}"));
    }
}
