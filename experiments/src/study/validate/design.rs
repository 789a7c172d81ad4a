//! Designs: factors into cells, orders that can be kept, groups and sittings that come out even.

use super::condition::{Parts, World, checked as checked_condition};
use super::listed_names;
use crate::design::order::arrange;
use crate::streams::Stream;
use crate::study::draft::{
    BlockDraft, CriterionDraft, FactorDraft, FactorLevelDraft, GroupDraft, OrderDraft, Otherwise, PilotDraft,
    SittingsDraft,
};
use crate::study::mistakes::{Report, suggestion};
use crate::study::plan::{
    BlockPlan, Cell, CriterionPlan, GroupPlan, OrderPlan, PilotPlan, ProcedurePlan, SittingsPlan,
};
use crate::study::source::Field;
use std::collections::{BTreeMap, BTreeSet};

/// The most cells of a block.
const MOST_CELLS: usize = 10_000;
/// Seeds with which `check` tries whether an order can keep its constraints.
const TRIED_SEEDS: u64 = 5;
/// How often practice is repeated where a study does not say.
const DEFAULT_ROUNDS: u32 = 3;

/// The cells of a block: every combination of its factors' levels on its condition.
pub(super) fn cells(
    draft: &BlockDraft,
    base: &Parts,
    base_name: &str,
    world: World<'_>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Vec<Cell>> {
    let factors_field = field.key("factors");
    let drafts = draft.factors.as_deref().unwrap_or_default();
    let before = report.count();
    let names = listed_names(drafts.iter().map(|d| d.as_ref().and_then(|d| d.name.as_deref())), &factors_field, report);
    let count = drafts.iter().map(|d| d.as_ref().and_then(|d| d.levels.as_ref()).map_or(1, Vec::len));
    let count = count.fold(1_usize, usize::saturating_mul);
    if count > MOST_CELLS {
        report.at(&factors_field, format!("expected at most {MOST_CELLS} cells, found {count} combinations of levels"));
        return None;
    }
    for (index, factor) in drafts.iter().enumerate() {
        if let Some(factor) = factor {
            check_factor(factor, &names, &factors_field.item(index), report);
        }
    }
    if report.count() > before {
        return None;
    }

    let whole: Vec<(&FactorDraft, Field)> =
        drafts.iter().enumerate().filter_map(|(i, d)| Some((d.as_ref()?, factors_field.item(i)))).collect();
    if whole.len() < drafts.len() {
        return None;
    }
    let combinations = combine(&whole);
    report_unused(&whole, &combinations, report);
    if draft.unbalanced != Some(true) {
        report_unbalanced(&whole, &combinations, &factors_field, report);
    }
    let cells: Vec<Option<Cell>> = combinations
        .into_iter()
        .map(|combination| {
            let mut parts = base.clone();
            let mut factors = BTreeMap::new();
            let mut name = base_name.to_owned();
            for Chosen { factor, level, field } in combination {
                parts = parts.with(level, &field);
                let (factor, level) = (factor.name.clone()?, level.name.clone()?);
                name.push_str(if factors.is_empty() { ":" } else { "," });
                name.push_str(&level);
                factors.insert(factor, level);
            }
            Some(Cell { factors, condition: checked_condition(&name, &parts, world, report)? })
        })
        .collect();
    cells.into_iter().collect::<Option<Vec<Cell>>>().filter(|_| report.count() == before)
}

/// A level in a combination.
#[derive(Clone)]
struct Chosen<'a> {
    factor: &'a FactorDraft,
    level: &'a FactorLevelDraft,
    field: Field,
}

/// Every combination of levels, the last factor varying fastest. A factor with no level that may stand in a combination
/// is not part of it: it is nested in others.
fn combine<'a>(factors: &[(&'a FactorDraft, Field)]) -> Vec<Vec<Chosen<'a>>> {
    let mut combinations: Vec<Vec<Chosen<'a>>> = vec![Vec::new()];
    for (factor, field) in factors {
        let field = field.key("levels");
        combinations = combinations
            .into_iter()
            .flat_map(|combination| {
                let levels = factor.levels.iter().flatten().enumerate();
                let fitting: Vec<Vec<Chosen<'a>>> = levels
                    .filter_map(|(index, level)| Some((index, level.as_ref()?)))
                    .filter(|(_, level)| stands_within(level, &combination))
                    .map(|(index, level)| {
                        let mut longer = combination.clone();
                        longer.push(Chosen { factor, level, field: field.item(index) });
                        longer
                    })
                    .collect();
                if fitting.is_empty() { vec![combination] } else { fitting }
            })
            .collect();
    }
    combinations
}

/// Whether a nested level may stand in a combination.
fn stands_within(level: &FactorLevelDraft, combination: &[Chosen<'_>]) -> bool {
    level.within.iter().flatten().all(|(factor, levels)| {
        let chosen = combination.iter().find(|chosen| chosen.factor.name.as_ref() == Some(factor));
        let name = chosen.and_then(|chosen| chosen.level.name.as_ref());
        name.is_some_and(|name| levels.iter().flatten().flatten().any(|allowed| allowed == name))
    })
}

fn check_factor(factor: &FactorDraft, names: &[String], field: &Field, report: &mut Report<'_>) {
    let levels_field = field.key("levels");
    let Some(levels) = &factor.levels else { return };
    if levels.is_empty() {
        report.at(&levels_field, "expected at least one level, found an empty list");
    }
    listed_names(levels.iter().map(|l| l.as_ref().and_then(|l| l.name.as_deref())), &levels_field, report);
    let own = factor.name.as_ref().and_then(|name| names.iter().position(|known| known == name));
    for (index, level) in levels.iter().enumerate() {
        for outer in level.iter().flat_map(|level| level.within.iter().flatten()).map(|(outer, _)| outer) {
            let earlier = &names[..own.unwrap_or(0)];
            if !earlier.contains(outer) {
                let known = if earlier.is_empty() { "none".to_owned() } else { earlier.join(", ") };
                let hint = suggestion(outer, earlier.iter().map(String::as_str));
                report.at_key(
                    &levels_field.item(index).key("within").key(outer),
                    format!("expected a factor that is listed before this one ({known}), found {outer:?}{hint}"),
                );
            }
        }
    }
    let sets_nothing = |level: &FactorLevelDraft| {
        level.scene.is_none()
            && level.scene_parameters.is_none()
            && level.renderer.is_none()
            && level.renderer_parameters.is_none()
            && level.fixation.is_none()
            && level.foveate.is_none()
    };
    if levels.len() > 1 && levels.iter().flatten().count() == levels.len() && levels.iter().flatten().all(sets_nothing)
    {
        report.at(&levels_field, "expected levels that set something, found none that does: no trial would use them");
    }
}

/// A factor or level that no combination holds is used by no trial.
fn report_unused(factors: &[(&FactorDraft, Field)], combinations: &[Vec<Chosen<'_>>], report: &mut Report<'_>) {
    for (factor, field) in factors {
        for (index, level) in factor.levels.iter().flatten().enumerate() {
            let Some(level) = level else { continue };
            let used = combinations.iter().flatten().any(|chosen| std::ptr::eq(chosen.level, level));
            if !used {
                let name = level.name.as_deref().unwrap_or_default();
                report.at(
                    &field.key("levels").item(index),
                    format!("expected a level that some trial uses, found \"{name}\", which stands within none"),
                );
            }
        }
    }
}

/// In a balanced design each level of a factor is in equally many cells.
fn report_unbalanced(
    factors: &[(&FactorDraft, Field)],
    combinations: &[Vec<Chosen<'_>>],
    field: &Field,
    report: &mut Report<'_>,
) {
    for (index, (factor, _)) in factors.iter().enumerate() {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for chosen in combinations.iter().flatten().filter(|chosen| std::ptr::eq(chosen.factor, *factor)) {
            *counts.entry(chosen.level.name.as_deref().unwrap_or_default()).or_default() += 1;
        }
        let (least, most) = (counts.values().min(), counts.values().max());
        if least != most {
            let counted: Vec<String> = counts.iter().map(|(level, n)| format!("{level} in {n}")).collect();
            report.at(
                &field.item(index),
                format!(
                    "expected each level in equally many cells, found {}; say \"unbalanced\": true beside the factors \
                     if that is meant",
                    counted.join(", ")
                ),
            );
        }
    }
}

/// The order of a block's trials, with every factor that it names known.
pub(super) fn order(
    draft: Option<&OrderDraft>,
    cells: Option<&[Cell]>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<OrderPlan> {
    let Some(draft) = draft else { return Some(OrderPlan::default()) };
    let before = report.count();
    let known: BTreeSet<&str> =
        cells.into_iter().flatten().flat_map(|c| c.factors.keys().map(String::as_str)).collect();
    let mut named = |names: Option<&Vec<Option<String>>>, key: &str| -> Vec<String> {
        let field = field.key(key);
        let names: Vec<String> = names.into_iter().flatten().flatten().cloned().collect();
        for (index, name) in names.iter().enumerate() {
            if cells.is_some() && !known.contains(name.as_str()) {
                let all: Vec<&str> = known.iter().copied().collect();
                let hint = suggestion(name, all.iter().copied());
                let all = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
                report.at(
                    &field.item(index),
                    format!("expected one of the block's factors ({all}), found {name:?}{hint}"),
                );
            }
        }
        names
    };
    let grouped_by = named(draft.grouped_by.as_ref(), "grouped_by");
    let no_repeat = named(draft.no_repeat.as_ref(), "no_repeat");
    if draft.groups.is_some() && grouped_by.is_empty() && report.count() == before {
        report
            .at_key(&field.key("groups"), "expected grouped_by beside it, without which it has no effect, found none");
    }
    let shuffled = draft.shuffled.unwrap_or(true);
    if !shuffled && !no_repeat.is_empty() {
        report.at_key(
            &field.key("no_repeat"),
            "expected trials that are shuffled, found \"shuffled\": false, with which they come as listed",
        );
    }
    if let Some(name) = no_repeat.iter().find(|name| grouped_by.contains(name)) {
        report.at(
            &field.key("no_repeat"),
            format!("expected factors that trials are not grouped by, found \"{name}\", which a group repeats"),
        );
    }
    (report.count() == before).then_some(OrderPlan {
        grouped_by,
        groups: draft.groups.unwrap_or_default(),
        shuffled,
        no_repeat,
    })
}

/// Reports an order whose constraint the block's trials cannot keep.
pub(super) fn report_impossible_order(block: &BlockPlan, field: &Field, report: &mut Report<'_>) {
    let repetitions = match &block.procedure {
        ProcedurePlan::Constant(constant) => constant.repetitions as usize * constant.levels.len(),
        _ => 1,
    };
    if block.order.no_repeat.is_empty() {
        return;
    }
    let orders = block.orders() as usize;
    let trials: Vec<_> =
        block.cells.iter().flat_map(|cell| std::iter::repeat_n(&cell.factors, repetitions * orders)).collect();
    let repeats = (0..TRIED_SEEDS).map(|seed| arrange(&trials, &block.order, &mut Stream::Design.generator(seed)).1);
    if let Some(repeats) = repeats.min().filter(|&repeats| repeats > 0) {
        report.at(
            &field.key("order").key("no_repeat"),
            format!(
                "expected a constraint that an order of the block's {} trials can keep, found {repeats} repetitions in \
                 the best one",
                trials.len()
            ),
        );
    }
}

pub(super) fn criterion(
    draft: &CriterionDraft,
    practice: bool,
    has_right_answers: bool,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<CriterionPlan> {
    if !practice {
        report.at_key(field, "expected a criterion for practice, found a block that is none");
    }
    if !has_right_answers {
        report
            .at_key(field, "expected a protocol with right answers, found one without, whose share cannot be counted");
    }
    Some(CriterionPlan {
        share_correct: draft.share_correct?,
        max_rounds: draft.max_rounds.unwrap_or(DEFAULT_ROUNDS),
        ends_session: draft.otherwise.unwrap_or_default() == Otherwise::End,
    })
}

/// Groups whose blocks exist; a block of no group is run by nobody.
pub(super) fn groups(
    drafts: Option<&Vec<Option<GroupDraft>>>,
    blocks: Option<&[BlockPlan]>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Vec<GroupPlan>> {
    let Some(drafts) = drafts else { return Some(Vec::new()) };
    let before = report.count();
    if drafts.len() < 2 {
        report.at(field, format!("expected at least two groups, found {}", drafts.len()));
    }
    listed_names(drafts.iter().map(|d| d.as_ref().and_then(|d| d.name.as_deref())), field, report);
    let known: Vec<&str> = blocks.into_iter().flatten().map(|block| block.name.as_str()).collect();
    let mut plans = Vec::new();
    for (index, draft) in drafts.iter().enumerate() {
        let Some(draft) = draft else { continue };
        let blocks_field = field.item(index).key("blocks");
        let names: Vec<String> = draft.blocks.iter().flatten().flatten().cloned().collect();
        if draft.blocks.as_ref().is_some_and(Vec::is_empty) {
            report.at(&blocks_field, "expected at least one block, found an empty list");
        }
        for (place, name) in names.iter().enumerate() {
            if blocks.is_some() && !known.contains(&name.as_str()) {
                let hint = suggestion(name, known.iter().copied());
                let known = known.join(", ");
                report.at(
                    &blocks_field.item(place),
                    format!("expected one of the study's blocks ({known}), found {name:?}{hint}"),
                );
            }
            if names[..place].contains(name) {
                report.at(&blocks_field.item(place), format!("expected each block once, found {name:?} again"));
            }
        }
        plans.push(GroupPlan { name: draft.name.clone().unwrap_or_default(), blocks: names });
    }
    for (index, name) in known.iter().enumerate() {
        if report.count() == before && !plans.iter().any(|group| group.blocks.iter().any(|block| block == name)) {
            report.at(
                &Field::root().key("blocks").item(index),
                format!("expected a block that some group runs, found \"{name}\", which no group names"),
            );
        }
    }
    (report.count() == before).then_some(plans)
}

/// Sittings that come out even: as many levels, or repetitions, in each.
pub(super) fn sittings(
    draft: Option<&SittingsDraft>,
    blocks: Option<&[BlockPlan]>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Option<SittingsPlan>> {
    let Some(draft) = draft else { return Some(None) };
    let count = draft.count?;
    let before = report.count();
    let asked: Vec<&BlockPlan> = blocks.into_iter().flatten().filter(|block| !block.practice).collect();
    if let Some(factor) = &draft.split_by {
        let field = field.key("split_by");
        let levels: Vec<BTreeSet<&String>> =
            asked.iter().map(|block| block.cells.iter().filter_map(|c| c.factors.get(factor)).collect()).collect();
        if blocks.is_some() && levels.iter().all(BTreeSet::is_empty) {
            let known: BTreeSet<&str> =
                asked.iter().flat_map(|b| &b.cells).flat_map(|c| c.factors.keys().map(String::as_str)).collect();
            let known: Vec<&str> = known.into_iter().collect();
            let hint = suggestion(factor, known.iter().copied());
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            report.at(&field, format!("expected one of the factors ({known}), found {factor:?}{hint}"));
        }
        for levels in levels.iter().filter(|levels| !levels.is_empty()) {
            if levels.len() % count as usize != 0 {
                report.at(
                    &field,
                    format!("expected a number of levels that {count} sittings divide, found {}", levels.len()),
                );
            }
        }
    } else {
        for block in &asked {
            match &block.procedure {
                ProcedurePlan::Constant(constant) if constant.repetitions % count != 0 => report.at(
                    &field.key("count"),
                    format!(
                        "expected a number of sittings that divides the {} repetitions of \"{}\", found {count}",
                        constant.repetitions, block.name
                    ),
                ),
                ProcedurePlan::Constant(_) => {}
                _ => report.at(
                    &field.key("count"),
                    format!(
                        "expected split_by beside it, since the adaptive block \"{}\" has no repetitions to deal out, \
                         found none",
                        block.name
                    ),
                ),
            }
        }
    }
    (report.count() == before).then(|| Some(SittingsPlan { count, split_by: draft.split_by.clone() }))
}

pub(super) fn pilot(draft: Option<&PilotDraft>) -> PilotPlan {
    let default = PilotPlan::default();
    draft.map_or(default, |draft| PilotPlan {
        trials: draft.trials.unwrap_or(default.trials),
        time_factor: draft.time_factor.unwrap_or(default.time_factor),
    })
}
