//! From a draft to a plan: everything that a schema cannot say.
//!
//! Names are resolved in the catalogue, numbers are held against renderer and display, and every mistake is reported
//! before the answer is given. `condition`, `display`, `procedure` and `values` are one subject each.

mod agreement;
mod condition;
mod design;
mod display;
mod files;
mod form;
mod procedure;
mod protocol;
mod values;

pub(super) use display::described as display_from;
pub use display::finest_mar_around;
pub(super) use files::listed as listed_files;

use super::draft::{
    BlockDraft, ConditionDraft, FORMAT, GazeDraft, NAME_PATTERN, ProtocolDraft, StudyDraft, TextsDraft,
};
use super::mistakes::{Report, suggestion};
use super::plan::{BlockPlan, BreakPlan, Cell, Condition, GatePlan, GazePlan, Plan, ProtocolPlan, Texts};
use super::source::Field;
use crate::catalogue::{Catalogue, RendererInfo};
use crate::display::Display;
use condition::{Parts, World};
use display::Geometry;
use std::collections::{BTreeMap, BTreeSet};

/// The question of a two-interval trial that states none.
pub const DEFAULT_QUESTION: &str = "Which one was degraded: the first or the second?";
/// How long feedback is shown where a study does not say, in seconds.
pub const DEFAULT_FEEDBACK_S: f64 = 0.5;
/// How long gaze may leave the gate where a study does not say, in seconds.
pub const DEFAULT_GATE_GRACE_S: f64 = 0.1;
/// The page at a break where a study has none.
pub const DEFAULT_PAUSE: &str = "Time for a short break. Press the space bar when you are ready to go on.";
/// The last page where a study has none.
pub const DEFAULT_THANKS: &str = "That was all. Thank you for taking part.";

/// Checks a draft. `None` only if something was reported.
pub(super) fn study(
    draft: &StudyDraft,
    catalogue: &Catalogue,
    display: Option<&Display>,
    report: &mut Report<'_>,
) -> Option<Plan> {
    let root = Field::root();
    if let Some(format) = draft.format.filter(|&format| format != FORMAT) {
        report.at(&root.key("format"), format!("expected {FORMAT}, found {format}"));
    }
    let name = draft.name.as_deref().and_then(|name| checked_name(name, &root.key("name"), report));
    let display = display::chosen(draft.display.as_ref(), display, &root.key("display"), report);
    let fixation_deg = fixation(draft.gaze.as_ref(), display.as_ref(), &root.key("gaze"), report);
    let gaze = gaze(draft.gaze.as_ref(), fixation_deg, &root.key("gaze"), report);
    let geometry = display.as_ref().zip(fixation_deg).map(|(display, fixation_deg)| Geometry { display, fixation_deg });

    let files = files::checked(draft, catalogue, report);
    let own_names = files::names(draft);
    let world = World { catalogue, own_names: &own_names, display: display.as_ref(), fixation_deg };
    let conditions = draft.conditions.as_ref().map(|drafts| conditions(drafts, world, report));
    let context = Context {
        world,
        conditions: conditions.as_ref(),
        refresh_hz: display.as_ref().map(Display::refresh_hz),
        geometry,
    };
    let blocks = draft.blocks.as_ref().and_then(|blocks| context.blocks(blocks, &root.key("blocks"), report));
    report_unused_conditions(draft, report);
    let groups = design::groups(draft.groups.as_ref(), blocks.as_deref(), &root.key("groups"), report);
    let sittings = design::sittings(draft.sittings.as_ref(), blocks.as_deref(), &root.key("sittings"), report);

    let items = draft.participant.as_deref().unwrap_or_default();
    let participant = form::checked(items, &root.key("participant"), report);

    Some(Plan {
        name: name?,
        title: draft.title.clone()?,
        about: draft.about.clone().unwrap_or_default(),
        gaze: gaze?,
        texts: texts(draft.texts.as_ref()),
        participant,
        files,
        blocks: blocks?,
        groups: groups?,
        sittings: sittings?,
        pilot: design::pilot(draft.pilot.as_ref()),
        display: display?,
    })
}

/// What the blocks of a study are checked against.
struct Context<'a> {
    world: World<'a>,
    /// Every condition that is named, with its parts and its checked form if it has one; nothing if they could not be
    /// read.
    conditions: Option<&'a BTreeMap<String, Named>>,
    refresh_hz: Option<f64>,
    geometry: Option<Geometry<'a>>,
}

pub(super) fn checked_name(name: &str, field: &Field, report: &mut Report<'_>) -> Option<String> {
    let is_part = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit());
    // This is NAME_PATTERN, which editors check, without a regular expression engine.
    debug_assert_eq!(NAME_PATTERN, "^[a-z0-9]+(-[a-z0-9]+)*$");
    if name.len() > 64 || !name.split('-').all(is_part) {
        let expected =
            "expected a name of at most 64 letters a-z, digits and hyphens between them (as in \"my-study-2\")";
        report.at(field, format!("{expected}, found {name:?}"));
        return None;
    }
    Some(name.to_owned())
}

/// Where observers look, if it is on the display.
fn fixation(
    draft: Option<&GazeDraft>,
    display: Option<&Display>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<[f64; 2]> {
    let Some(draft) = draft else { return Some([0.0, 0.0]) };
    let fixation_deg = draft.fixation_deg.unwrap_or([0.0, 0.0]);
    if let Some(display) = display {
        let [x, y] = display.half_field_deg();
        if fixation_deg[0].abs() >= x || fixation_deg[1].abs() >= y {
            let [at_x, at_y] = fixation_deg;
            report.at(
                &field.key("fixation_deg"),
                format!(
                    "expected a place on the display \"{}\" (within ±{x:.2}° across and ±{y:.2}° up and down), \
                     found [{at_x}, {at_y}]",
                    display.name()
                ),
            );
            return None;
        }
    }
    Some(fixation_deg)
}

fn gaze(
    draft: Option<&GazeDraft>,
    fixation_deg: Option<[f64; 2]>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<GazePlan> {
    let gate_deg = draft.and_then(|gaze| gaze.gate_deg);
    let grace_s = draft.and_then(|gaze| gaze.gate_grace_s);
    if grace_s.is_some() && gate_deg.is_none() && !report.has(&field.key("gate_deg")) {
        report.at_key(
            &field.key("gate_grace_s"),
            "expected gate_deg beside it, without which it has no effect, found no gate",
        );
    }
    let gate = gate_deg.map(|radius_deg| GatePlan { radius_deg, grace_s: grace_s.unwrap_or(DEFAULT_GATE_GRACE_S) });
    Some(GazePlan { fixation_deg: fixation_deg?, gate })
}

fn texts(draft: Option<&TextsDraft>) -> Texts {
    let text = |choose: fn(&TextsDraft) -> Option<&String>, default: &str| {
        draft.and_then(choose).cloned().unwrap_or_else(|| default.to_owned())
    };
    Texts {
        consent: draft.and_then(|d| d.consent.clone()),
        instructions: draft.and_then(|d| d.instructions.as_ref()).into_iter().flatten().flatten().cloned().collect(),
        pause: text(|d| d.pause.as_ref(), DEFAULT_PAUSE),
        thanks: text(|d| d.thanks.as_ref(), DEFAULT_THANKS),
    }
}

/// A condition of the study, for blocks that name it.
struct Named {
    parts: Option<Parts>,
    checked: Option<Condition>,
}

fn conditions(
    drafts: &BTreeMap<String, Option<ConditionDraft>>,
    world: World<'_>,
    report: &mut Report<'_>,
) -> BTreeMap<String, Named> {
    let field = Field::root().key("conditions");
    let mut conditions = BTreeMap::new();
    for (name, condition) in drafts {
        let field = field.key(name);
        let named = checked_name(name, &field, report);
        let parts = condition.as_ref().map(|draft| Parts::of(draft, &field));
        let checked = parts.as_ref().and_then(|parts| condition::checked(name, parts, world, report));
        conditions.insert(name.clone(), Named { parts, checked: checked.filter(|_| named.is_some()) });
    }
    conditions
}

fn report_unused_conditions(draft: &StudyDraft, report: &mut Report<'_>) {
    let (Some(conditions), Some(blocks)) = (&draft.conditions, &draft.blocks) else { return };
    // A block that could not be read might have named any of them.
    let Some(used): Option<BTreeSet<&str>> = blocks.iter().map(|b| b.as_ref()?.condition.as_deref()).collect() else {
        return;
    };
    // No blocks at all, or a misspelt name, has been reported already.
    if used.is_empty() || used.iter().any(|name| !conditions.contains_key(*name)) {
        return;
    }
    for name in conditions.keys().filter(|name| !used.contains(name.as_str())) {
        let field = Field::root().key("conditions").key(name);
        report.at_key(&field, format!("expected a block that shows this condition, found none that names \"{name}\""));
    }
}

impl Context<'_> {
    fn blocks(&self, drafts: &[Option<BlockDraft>], field: &Field, report: &mut Report<'_>) -> Option<Vec<BlockPlan>> {
        if drafts.is_empty() {
            report.at(field, "expected at least one block, found an empty list");
            return None;
        }
        let mut seen = BTreeSet::new();
        let mut plans = Vec::new();
        for (index, draft) in drafts.iter().enumerate() {
            let field = field.item(index);
            let Some(draft) = draft else { continue };
            if let Some(name) = draft.name.as_deref().filter(|name| !seen.insert(name.to_owned())) {
                report.at(
                    &field.key("name"),
                    format!("expected a name of its own, found \"{name}\" as in an earlier block"),
                );
            }
            plans.push(self.block(draft, &field, report));
        }
        if drafts.iter().all(|draft| draft.as_ref().is_some_and(|draft| draft.practice == Some(true))) {
            report.at_key(
                field,
                "expected at least one block that is not practice, found only practice, which no fit uses",
            );
        }
        plans.into_iter().collect()
    }

    fn block(&self, draft: &BlockDraft, field: &Field, report: &mut Report<'_>) -> Option<BlockPlan> {
        let before = report.count();
        let name = draft.name.as_deref().and_then(|name| checked_name(name, &field.key("name"), report));
        let named = draft.condition.as_deref().and_then(|name| self.condition(name, &field.key("condition"), report));
        // Without factors there is one cell, and its condition has been checked already.
        let cells = match (named, &draft.factors) {
            (Some((_, Named { checked: Some(condition), .. })), None) => {
                Some(vec![Cell { factors: BTreeMap::new(), condition: condition.clone() }])
            }
            (Some((name, Named { parts: Some(parts), .. })), Some(_)) => {
                design::cells(draft, parts, name, self.world, field, report)
            }
            _ => None,
        };
        // What is set must be there in every renderer that a cell shows; each of them may find its own mistakes.
        let (mut protocol, mut procedure) = (None, None);
        for target in self.targets(cells.as_deref()) {
            let target = target.as_ref().map(|(condition, renderer)| (*condition, *renderer));
            protocol = draft.protocol.as_ref().and_then(|protocol| {
                protocol::checked(protocol, target, self.refresh_hz, &field.key("protocol"), report)
            });
            procedure = draft.procedure.as_ref().and_then(|procedure| {
                procedure::checked(procedure, target, self.geometry, &field.key("procedure"), report)
            });
        }
        let order = design::order(draft.order.as_ref(), cells.as_deref(), &field.key("order"), report);
        let practice = draft.practice.unwrap_or(false);
        let criterion = draft.criterion.as_ref().map(|criterion| {
            let has_right_answers = protocol.as_ref().is_none_or(ProtocolPlan::has_right_answers);
            design::criterion(criterion, practice, has_right_answers, &field.key("criterion"), report)
        });
        let items = draft.questionnaire.as_deref().unwrap_or_default();
        let questionnaire = form::checked(items, &field.key("questionnaire"), report);
        let block = BlockPlan {
            name: name?,
            practice,
            criterion: criterion.map_or(Some(None), |criterion| criterion.map(Some))?,
            instructions: draft.instructions.clone(),
            cells: cells?,
            protocol: protocol?,
            feedback_s: draft.protocol.as_ref().and_then(ProtocolDraft::feedback_s).unwrap_or(DEFAULT_FEEDBACK_S),
            procedure: procedure?,
            presentation_order: draft.presentation.unwrap_or_default(),
            order: order?,
            breaks: BreakPlan {
                every_trials: draft.break_every_trials,
                every_s: draft.break_every_minutes.map(|minutes| 60.0 * minutes),
            },
            at_most_trials: None,
            questionnaire,
        };
        design::report_impossible_order(&block, field, report);
        // What is wrong in its parts would only be said again.
        if report.count() == before {
            agreement::report(&block, self.geometry, field, report);
        }
        Some(block)
    }

    /// What a block's protocol and procedure are set on: one cell for each renderer; nothing where cells are not known.
    fn targets<'c>(&self, cells: Option<&'c [Cell]>) -> Vec<Option<(&'c Condition, &RendererInfo)>> {
        let mut targets: Vec<Option<(&Condition, &RendererInfo)>> = Vec::new();
        for condition in cells.into_iter().flatten().map(|cell| &cell.condition) {
            let is_new = !targets.iter().flatten().any(|(known, _)| known.renderer == condition.renderer);
            let renderer = self.world.catalogue.renderer(&condition.renderer);
            if let Some(renderer) = renderer.filter(|_| is_new) {
                targets.push(Some((condition, renderer)));
            }
        }
        if targets.is_empty() {
            targets.push(None);
        }
        // The first one listed has the last word on what a constant level inherits from its condition.
        targets.reverse();
        targets
    }

    fn condition(&self, name: &str, field: &Field, report: &mut Report<'_>) -> Option<(&str, &Named)> {
        let conditions = self.conditions?;
        let known = conditions.get_key_value(name);
        if known.is_none() {
            let names: Vec<&str> = conditions.keys().map(String::as_str).collect();
            let hint = suggestion(name, names.iter().copied());
            let expected = names.join(", ");
            report.at(field, format!("expected one of the study's conditions ({expected}), found {name:?}{hint}"));
        }
        known.map(|(name, named)| (name.as_str(), named))
    }
}

/// The names of a list's entries, each checked and reported where it comes again.
fn listed_names<'n>(
    names: impl Iterator<Item = Option<&'n str>>,
    field: &Field,
    report: &mut Report<'_>,
) -> Vec<String> {
    let mut listed: Vec<String> = Vec::new();
    for (index, name) in names.enumerate() {
        let Some(name) = name else { continue };
        let field = field.item(index).key("name");
        if listed.iter().any(|known| known == name) {
            report.at(&field, format!("expected a name of its own, found {name:?} again"));
        } else {
            checked_name(name, &field, report);
            listed.push(name.to_owned());
        }
    }
    listed
}
