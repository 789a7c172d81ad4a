//! Conditions against the catalogue: do the scene and the renderer exist, and do they take these parameters?

use crate::catalogue::{Catalogue, ParameterSchema, ParameterValue, Parameters, complete_parameters};
use crate::study::draft::ConditionDraft;
use crate::study::mistakes::{Report, suggestion};
use crate::study::plan::{Condition, Fixation, FoveationCentre};
use crate::study::source::Field;
use std::collections::BTreeMap;

/// A condition with every name resolved and every parameter filled in.
pub(super) fn checked(
    name: &str,
    draft: &ConditionDraft,
    catalogue: &Catalogue,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Condition> {
    let scene = draft.scene.as_deref().and_then(|id| {
        let ids = catalogue.scenes.iter().map(|scene| scene.id.as_str());
        found_or_reported(catalogue.scene(id), "scenes", id, ids, &field.key("scene"), report)
    });
    let renderer = draft.renderer.as_deref().and_then(|id| {
        let ids = catalogue.renderers.iter().map(|renderer| renderer.id.as_str());
        found_or_reported(catalogue.renderer(id), "renderers", id, ids, &field.key("renderer"), report)
    });
    let scene_parameters = scene.and_then(|scene| {
        parameters(&scene.parameters, draft.scene_parameters.as_ref(), &field.key("scene_parameters"), report)
    });
    let renderer_parameters = renderer.and_then(|renderer| {
        parameters(&renderer.parameters, draft.renderer_parameters.as_ref(), &field.key("renderer_parameters"), report)
    });
    Some(Condition {
        name: name.to_owned(),
        scene: scene?.id.clone(),
        scene_parameters: scene_parameters?,
        renderer: renderer?.id.clone(),
        renderer_parameters: renderer_parameters?,
        detail: renderer?.detail.clone(),
        fixation: Fixation::Cross,
        foveation: FoveationCentre::Gaze,
    })
}

fn found_or_reported<'c, T>(
    entry: Option<&'c T>,
    what: &str,
    id: &str,
    ids: impl Iterator<Item = &'c str> + Clone,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<&'c T> {
    if entry.is_none() {
        let hint = suggestion(id, ids.clone());
        let ids = ids.collect::<Vec<_>>().join(", ");
        report.at(field, format!("expected one of the {what} {ids}, found {id:?}{hint}"));
    }
    entry
}

fn parameters(
    schemas: &[ParameterSchema],
    given: Option<&BTreeMap<String, Option<ParameterValue>>>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Parameters> {
    let given: Parameters =
        given.into_iter().flatten().filter_map(|(name, value)| Some((name.clone(), value.clone()?))).collect();
    match complete_parameters(schemas, &given) {
        Ok(complete) => Some(complete),
        Err(errors) => {
            for error in errors {
                let at = field.key(&error.name);
                match schemas.iter().any(|schema| schema.name == error.name) {
                    true => report.at(&at, format!("expected {}, found {}", error.expected, error.found)),
                    false => {
                        let hint = suggestion(&error.name, schemas.iter().map(|schema| schema.name.as_str()));
                        report.at_key(&at, format!("expected {}, found {}{hint}", error.expected, error.found));
                    }
                }
            }
            None
        }
    }
}
