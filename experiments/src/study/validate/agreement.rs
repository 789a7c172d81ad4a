//! A block as a whole: do its protocol, its procedure, its design and the display agree?

use super::display::Geometry;
use crate::catalogue::DetailLaw;
use crate::study::mistakes::Report;
use crate::study::plan::{BlockPlan, Condition, Fixation, Level, PresentationOrder, ProcedurePlan, ProtocolPlan};
use crate::study::source::Field;

/// Reports everything that only the whole block shows.
pub(super) fn report(block: &BlockPlan, geometry: Option<Geometry<'_>>, field: &Field, report: &mut Report<'_>) {
    adaptive_needs_right_answers(block, field, report);
    levels_suit_the_protocol(block, field, report);
    presentation_matters(block, field, report);
    if block.protocol.needs_moving_target()
        && !block.cells.iter().all(|cell| matches!(cell.condition.fixation, Fixation::Moving(_)))
    {
        report.at(
            &field.key("condition"),
            "expected a condition with \"fixation\": { \"kind\": \"moving\" }, since the task is to follow a target, \
             found another",
        );
    }
    if let Some(geometry) = geometry {
        levels_can_be_shown(block, geometry, field, report);
    }
}

fn adaptive_needs_right_answers(block: &BlockPlan, field: &Field, report: &mut Report<'_>) {
    if block.procedure.is_adaptive() && !block.protocol.has_right_answers() {
        report.at(
            &field.key("procedure").key("kind"),
            format!(
                "expected \"constant\" with the protocol \"{}\", whose answers are neither right nor wrong, found an \
                 adaptive procedure, which could not learn",
                block.protocol.kind()
            ),
        );
    }
}

fn levels_suit_the_protocol(block: &BlockPlan, field: &Field, report: &mut Report<'_>) {
    let levels_field = field.key("procedure").key("levels");
    let sets = |parameter: &str| block.procedure.levels().iter().all(|level| level.contains_key(parameter));
    if let Some(parameter) = block.protocol.needs_level().filter(|parameter| !sets(parameter)) {
        report.at(
            &levels_field,
            format!("expected levels of \"{parameter}\", to which the {} goes, found none", block.protocol.kind()),
        );
    }
    if let ProtocolPlan::Slider(plan) = &block.protocol
        && block.procedure.levels().iter().any(|level| level.contains_key(&plan.parameter))
    {
        report.at_key(
            &levels_field.key(&plan.parameter),
            "expected levels of other parameters, found the slider's own, which the observer sets",
        );
    }
}

fn presentation_matters(block: &BlockPlan, field: &Field, report: &mut Report<'_>) {
    if block.presentation_order != PresentationOrder::Random && !block.protocol.alternatives_matter() {
        report.at_key(
            &field.key("presentation"),
            format!(
                "expected none with the protocol \"{}\", which has no order of reference and test, found one",
                block.protocol.kind()
            ),
        );
    }
}

/// A level that the display cannot tell from the reference in any cell is no level.
fn levels_can_be_shown(block: &BlockPlan, geometry: Geometry<'_>, field: &Field, report: &mut Report<'_>) {
    let ProcedurePlan::Constant(constant) = &block.procedure else { return };
    for level in constant.levels.iter().filter(|level| !level.is_empty()) {
        let shown = block.cells.iter().map(|cell| differs(&cell.condition, level, geometry));
        if shown.clone().all(|shown| shown == Some(false)) && !block.cells.is_empty() {
            let words: Vec<String> = level.iter().map(|(name, value)| format!("{name} {value}")).collect();
            report.at(
                &field.key("procedure").key("levels"),
                format!(
                    "expected levels that the display \"{}\" can show, found {}, whose detail is as fine as the display \
                     everywhere",
                    geometry.display.name(),
                    words.join(", ")
                ),
            );
        }
    }
}

/// Whether a level removes detail that the display could have shown; nothing if the renderer cannot say, or says it by
/// ring, which the procedure's own checks hold against the display.
fn differs(condition: &Condition, level: &Level, geometry: Geometry<'_>) -> Option<bool> {
    if !matches!(condition.detail, DetailLaw::Line { .. } | DetailLaw::Gaussian { .. } | DetailLaw::Levels { .. }) {
        return None;
    }
    let parameters = condition.parameters_at(level);
    for half_degrees in 0..180 {
        let e = 0.5 * f64::from(half_degrees);
        if geometry.display.visible_share(geometry.fixation_deg, e) <= 0.0 {
            break;
        }
        if condition.detail.mar_deg(&parameters, e)? > geometry.finest_mar_deg(e) {
            return Some(true);
        }
    }
    Some(false)
}
