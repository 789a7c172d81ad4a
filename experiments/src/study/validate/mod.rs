//! From a draft to a plan: everything that a schema cannot say.
//!
//! Names are resolved in the catalogue, numbers are held against renderer and display, and every mistake is reported
//! before the answer is given. `condition`, `display`, `procedure` and `values` are one subject each.

mod condition;
mod display;
mod form;
mod procedure;
mod protocol;
mod values;

pub(super) use display::described as display_from;
pub use display::finest_mar_around;

use super::draft::{
    BlockDraft, ConditionDraft, FORMAT, GazeDraft, NAME_PATTERN, ProtocolDraft, StudyDraft, TextsDraft,
};
use super::mistakes::{Report, suggestion};
use super::plan::{
    BlockPlan, BreakPlan, Cell, Condition, GatePlan, GazePlan, OrderPlan, PilotPlan, Plan, PresentationOrder, Texts,
};
use super::source::Field;
use crate::catalogue::Catalogue;
use crate::display::Display;
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

    let conditions = draft.conditions.as_ref().map(|drafts| conditions(drafts, catalogue, report));
    let context = Context {
        catalogue,
        conditions: conditions.as_ref(),
        refresh_hz: display.as_ref().map(Display::refresh_hz),
        geometry,
    };
    let blocks = draft.blocks.as_ref().and_then(|blocks| context.blocks(blocks, &root.key("blocks"), report));
    report_unused_conditions(draft, report);

    Some(Plan {
        name: name?,
        title: draft.title.clone()?,
        about: draft.about.clone().unwrap_or_default(),
        gaze: gaze?,
        texts: texts(draft.texts.as_ref()),
        participant: Vec::new(),
        blocks: blocks?,
        groups: Vec::new(),
        sittings: None,
        pilot: PilotPlan::default(),
        display: display?,
    })
}

/// What the blocks of a study are checked against.
struct Context<'a> {
    catalogue: &'a Catalogue,
    /// Every condition that is named, with its checked form if it has one; nothing if they could not be read.
    conditions: Option<&'a BTreeMap<String, Option<Condition>>>,
    refresh_hz: Option<f64>,
    geometry: Option<Geometry<'a>>,
}

fn checked_name(name: &str, field: &Field, report: &mut Report<'_>) -> Option<String> {
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
        consent: None,
        instructions: draft.and_then(|d| d.instructions.as_ref()).into_iter().flatten().flatten().cloned().collect(),
        pause: text(|d| d.pause.as_ref(), DEFAULT_PAUSE),
        thanks: text(|d| d.thanks.as_ref(), DEFAULT_THANKS),
    }
}

fn conditions(
    drafts: &BTreeMap<String, Option<ConditionDraft>>,
    catalogue: &Catalogue,
    report: &mut Report<'_>,
) -> BTreeMap<String, Option<Condition>> {
    let field = Field::root().key("conditions");
    let mut conditions = BTreeMap::new();
    for (name, condition) in drafts {
        let field = field.key(name);
        let named = checked_name(name, &field, report);
        let checked = condition.as_ref().and_then(|c| condition::checked(name, c, catalogue, &field, report));
        conditions.insert(name.clone(), checked.filter(|_| named.is_some()));
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
        let name = draft.name.as_deref().and_then(|name| checked_name(name, &field.key("name"), report));
        let condition =
            draft.condition.as_deref().and_then(|name| self.condition(name, &field.key("condition"), report));
        let protocol = draft.protocol.as_ref().and_then(|p| {
            let target = condition.as_ref().and_then(|c| Some((c, self.catalogue.renderer(&c.renderer)?)));
            protocol::checked(p, target, self.refresh_hz, &field.key("protocol"), report)
        });
        let procedure = draft.procedure.as_ref().and_then(|draft| {
            let renderer = condition.as_ref().and_then(|c| self.catalogue.renderer(&c.renderer));
            let target = condition.as_ref().zip(renderer);
            procedure::checked(draft, target, self.geometry, &field.key("procedure"), report)
        });
        Some(BlockPlan {
            name: name?,
            practice: draft.practice.unwrap_or(false),
            instructions: draft.instructions.clone(),
            criterion: None,
            cells: vec![Cell { factors: BTreeMap::new(), condition: condition? }],
            protocol: protocol?,
            feedback_s: draft.protocol.as_ref().and_then(ProtocolDraft::feedback_s).unwrap_or(DEFAULT_FEEDBACK_S),
            procedure: procedure?,
            presentation_order: PresentationOrder::Random,
            order: OrderPlan::default(),
            breaks: BreakPlan { every_trials: draft.break_every_trials, every_s: None },
            at_most_trials: None,
            questionnaire: Vec::new(),
        })
    }

    fn condition(&self, name: &str, field: &Field, report: &mut Report<'_>) -> Option<Condition> {
        let conditions = self.conditions?;
        let known = conditions.get(name);
        if known.is_none() {
            let names: Vec<&str> = conditions.keys().map(String::as_str).collect();
            let hint = suggestion(name, names.iter().copied());
            let expected = names.join(", ");
            report.at(field, format!("expected one of the study's conditions ({expected}), found {name:?}{hint}"));
        }
        known.cloned().flatten()
    }
}
