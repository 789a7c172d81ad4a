//! Conditions against the catalogue: does the scene exist, does the renderer, do their parameters, is the target on the
//! display?

use crate::catalogue::{Catalogue, ParameterSchema, ParameterValue, Parameters, complete_parameters};
use crate::display::Display;
use crate::study::draft::{ConditionDraft, FactorLevelDraft, FixationDraft, MovingDraft, OptionalParameters};
use crate::study::mistakes::{Report, suggestion};
use crate::study::plan::{Condition, Fixation, FoveationCentre, MovingTarget};
use crate::study::source::Field;
use std::collections::{BTreeMap, BTreeSet};

/// The speed of a moving target where a study does not say, degrees per second.
const DEFAULT_TARGET_SPEED_DEG_S: f64 = 5.0;
/// The diameter of a moving target where a study does not say, degrees.
const DEFAULT_TARGET_DIAMETER_DEG: f64 = 0.8;
/// The share of the room around the fixation mark that a target uses where a study does not say.
const DEFAULT_REACH: f64 = 0.6;

/// What a condition is checked against.
#[derive(Clone, Copy)]
pub(super) struct World<'a> {
    pub(super) catalogue: &'a Catalogue,
    /// Names that the study gives to files: one that the catalogue does not hold has been reported where it stands.
    pub(super) own_names: &'a BTreeSet<String>,
    pub(super) display: Option<&'a Display>,
    pub(super) fixation_deg: Option<[f64; 2]>,
}

/// A value of a study and where it stands.
type Placed<T> = (T, Field);

/// A condition as it is put together: the draft's own, with the levels of factors on top, each value with its place.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    /// Where the condition stands as a whole.
    field: Field,
    scene: Option<Placed<String>>,
    scene_parameters: BTreeMap<String, Placed<ParameterValue>>,
    renderer: Option<Placed<String>>,
    renderer_parameters: BTreeMap<String, Placed<ParameterValue>>,
    fixation: Option<Placed<FixationDraft>>,
    foveate: Option<Placed<FoveationCentre>>,
}

impl Parts {
    pub(super) fn of(draft: &ConditionDraft, field: &Field) -> Self {
        Self {
            field: field.clone(),
            scene: placed(draft.scene.as_ref(), field, "scene"),
            scene_parameters: placed_parameters(draft.scene_parameters.as_ref(), field, "scene_parameters"),
            renderer: placed(draft.renderer.as_ref(), field, "renderer"),
            renderer_parameters: placed_parameters(draft.renderer_parameters.as_ref(), field, "renderer_parameters"),
            fixation: placed(draft.fixation.as_ref(), field, "fixation"),
            foveate: placed(draft.foveate.as_ref(), field, "foveate"),
        }
    }

    /// Lays a factor's level on top. Another scene or renderer begins with its own defaults.
    pub(super) fn with(mut self, level: &FactorLevelDraft, field: &Field) -> Self {
        if let Some(scene) = placed(level.scene.as_ref(), field, "scene") {
            self.scene_parameters.clear();
            self.scene = Some(scene);
        }
        if let Some(renderer) = placed(level.renderer.as_ref(), field, "renderer") {
            self.renderer_parameters.clear();
            self.renderer = Some(renderer);
        }
        self.scene_parameters.extend(placed_parameters(level.scene_parameters.as_ref(), field, "scene_parameters"));
        self.renderer_parameters.extend(placed_parameters(
            level.renderer_parameters.as_ref(),
            field,
            "renderer_parameters",
        ));
        self.fixation = placed(level.fixation.as_ref(), field, "fixation").or(self.fixation);
        self.foveate = placed(level.foveate.as_ref(), field, "foveate").or(self.foveate);
        self
    }
}

fn placed<T: Clone>(value: Option<&T>, field: &Field, key: &str) -> Option<Placed<T>> {
    value.map(|value| (value.clone(), field.key(key)))
}

fn placed_parameters(
    parameters: Option<&OptionalParameters>,
    field: &Field,
    key: &str,
) -> BTreeMap<String, Placed<ParameterValue>> {
    let field = field.key(key);
    let given = parameters.into_iter().flatten();
    given.filter_map(|(name, value)| Some((name.clone(), (value.clone()?, field.key(name))))).collect()
}

/// A condition with every name resolved and every parameter filled in.
pub(super) fn checked(name: &str, parts: &Parts, world: World<'_>, report: &mut Report<'_>) -> Option<Condition> {
    let catalogue = world.catalogue;
    let scene = parts.scene.as_ref().and_then(|(id, field)| {
        let ids = catalogue.scenes.iter().map(|scene| scene.id.as_str());
        found_or_reported(catalogue.scene(id), "scenes", id, ids, world.own_names, field, report)
    });
    let renderer = parts.renderer.as_ref().and_then(|(id, field)| {
        let ids = catalogue.renderers.iter().map(|renderer| renderer.id.as_str());
        found_or_reported(catalogue.renderer(id), "renderers", id, ids, world.own_names, field, report)
    });
    if let (Some(scene), Some(renderer)) = (scene, renderer) {
        let resolution_px = world.display.map(Display::resolution_px);
        let mismatch = catalogue.mismatch(&scene.id, &renderer.id, resolution_px);
        if let Some((mismatch, (_, field))) = mismatch.zip(parts.scene.as_ref()) {
            report.at(field, mismatch);
        }
    }
    let scene_parameters = scene.and_then(|scene| parameters(&scene.parameters, &parts.scene_parameters, report));
    let renderer_parameters =
        renderer.and_then(|renderer| parameters(&renderer.parameters, &parts.renderer_parameters, report));
    let fixation = fixation(parts, world, report);
    let (foveation, field) =
        parts.foveate.as_ref().map_or((FoveationCentre::default(), &parts.field), |(centre, field)| (*centre, field));
    if (fixation, foveation) == (Some(Fixation::Free), FoveationCentre::Target) {
        report.at(field, "expected \"gaze\" with free viewing, where there is no target, found \"target\"");
    }
    Some(Condition {
        name: name.to_owned(),
        scene: scene?.id.clone(),
        scene_parameters: scene_parameters?,
        renderer: renderer?.id.clone(),
        renderer_parameters: renderer_parameters?,
        detail: renderer?.detail.clone(),
        fixation: fixation?,
        foveation,
    })
}

fn fixation(parts: &Parts, world: World<'_>, report: &mut Report<'_>) -> Option<Fixation> {
    match &parts.fixation {
        None | Some((FixationDraft::Cross(_), _)) => Some(Fixation::Cross),
        Some((FixationDraft::Free(_), _)) => Some(Fixation::Free),
        Some((FixationDraft::Moving(draft), field)) => moving(draft, world, field, report).map(Fixation::Moving),
    }
}

/// A moving target that stays on the display.
fn moving(draft: &MovingDraft, world: World<'_>, field: &Field, report: &mut Report<'_>) -> Option<MovingTarget> {
    let diameter_deg = draft.diameter_deg.unwrap_or(DEFAULT_TARGET_DIAMETER_DEG);
    let (display, fixation_deg) = world.display.zip(world.fixation_deg)?;
    let half = display.half_field_deg();
    let room_deg: [f64; 2] =
        std::array::from_fn(|axis| (half[axis] - fixation_deg[axis].abs() - 0.5 * diameter_deg).max(0.0));
    let reach_deg = draft.reach_deg.unwrap_or(room_deg.map(|room| DEFAULT_REACH * room));
    if (0..2).any(|axis| reach_deg[axis] > room_deg[axis]) {
        let [x, y] = room_deg;
        let [reach_x, reach_y] = reach_deg;
        report.at(
            &field.key("reach_deg"),
            format!(
                "expected a reach that keeps the target on the display \"{}\" (up to [{x:.1}, {y:.1}] here), found \
                 [{reach_x}, {reach_y}]",
                display.name()
            ),
        );
        return None;
    }
    let speed_deg_s = draft.speed_deg_s.unwrap_or(DEFAULT_TARGET_SPEED_DEG_S);
    Some(MovingTarget { speed_deg_s, reach_deg, diameter_deg })
}

fn found_or_reported<'c, T>(
    entry: Option<&'c T>,
    what: &str,
    id: &str,
    ids: impl Iterator<Item = &'c str> + Clone,
    own_names: &BTreeSet<String>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<&'c T> {
    if entry.is_none() && !own_names.contains(id) {
        let hint = suggestion(id, ids.clone());
        let ids = ids.collect::<Vec<_>>().join(", ");
        report.at(field, format!("expected one of the {what} {ids}, found {id:?}{hint}"));
    }
    entry
}

fn parameters(
    schemas: &[ParameterSchema],
    given: &BTreeMap<String, Placed<ParameterValue>>,
    report: &mut Report<'_>,
) -> Option<Parameters> {
    let values: Parameters = given.iter().map(|(name, (value, _))| (name.clone(), value.clone())).collect();
    match complete_parameters(schemas, &values) {
        Ok(complete) => Some(complete),
        Err(errors) => {
            for error in errors {
                let Some((_, at)) = given.get(&error.name) else { continue };
                match schemas.iter().any(|schema| schema.name == error.name) {
                    true => report.at(at, format!("expected {}, found {}", error.expected, error.found)),
                    false => {
                        let hint = suggestion(&error.name, schemas.iter().map(|schema| schema.name.as_str()));
                        report.at_key(at, format!("expected {}, found {}{hint}", error.expected, error.found));
                    }
                }
            }
            None
        }
    }
}
