//! Designs in words: factors, orders, groups, sittings.

use super::{BlockDescription, Effort, FactorDescription, GroupDescription, ParameterRange, describe_block, total};
use crate::design::assignment::Assignment;
use crate::study::Plan;
use crate::study::plan::{BlockPlan, CriterionPlan, Fixation, FoveationCentre, GroupOrder, Level, PresentationOrder};
use std::collections::BTreeMap;

/// The factors of a block in alphabetical order, with their levels as listed.
pub(super) fn factors(block: &BlockPlan) -> Vec<FactorDescription> {
    let mut factors: Vec<FactorDescription> = Vec::new();
    for (name, level) in block.cells.iter().flat_map(|cell| &cell.factors) {
        match factors.iter_mut().find(|factor| factor.name == *name) {
            Some(factor) if factor.levels.contains(level) => {}
            Some(factor) => factor.levels.push(level.clone()),
            None => factors.push(FactorDescription { name: name.clone(), levels: vec![level.clone()] }),
        }
    }
    factors
}

/// How observers look, over all cells.
pub(super) fn looks(block: &BlockPlan) -> String {
    let mut ways: Vec<String> = Vec::new();
    for condition in block.cells.iter().map(|cell| &cell.condition) {
        let way = match condition.fixation {
            Fixation::Cross => "at the fixation mark".to_owned(),
            Fixation::Moving(target) => format!("at a target that moves at {} degrees per second", target.speed_deg_s),
            Fixation::Free => "wherever they like".to_owned(),
        };
        let centre = match condition.foveation {
            FoveationCentre::Gaze => "",
            FoveationCentre::Target => " (foveated there)",
        };
        let way = format!("{way}{centre}");
        if !ways.contains(&way) {
            ways.push(way);
        }
    }
    ways.join(", or ")
}

pub(super) fn presentation(block: &BlockPlan) -> String {
    if !block.protocol.alternatives_matter() {
        return String::new();
    }
    match block.presentation_order {
        PresentationOrder::Random => "reference and test in random order",
        PresentationOrder::Both => "every trial in both orders",
        PresentationOrder::ReferenceFirst => "the reference first",
        PresentationOrder::TestFirst => "the test first",
    }
    .to_owned()
}

pub(super) fn order(block: &BlockPlan) -> String {
    let order = &block.order;
    let mut words = Vec::new();
    if !order.grouped_by.is_empty() {
        let groups = match order.groups {
            GroupOrder::Shuffled => "in random order",
            GroupOrder::Listed => "as listed",
            GroupOrder::LatinSquare => "by the observer's row of a balanced Latin square",
        };
        words.push(format!("grouped by {}, {groups}", order.grouped_by.join(" and ")));
    }
    words.push(match (order.shuffled, block.procedure.is_adaptive(), block.cells.len()) {
        (true, true, 1) => String::new(),
        (true, true, _) => "cells interleaved in shuffled rounds".to_owned(),
        (false, true, _) => "one cell after the other".to_owned(),
        (true, false, _) => "shuffled".to_owned(),
        (false, false, _) => "as listed".to_owned(),
    });
    if !order.no_repeat.is_empty() {
        words.push(format!("never the same {} twice in a row", order.no_repeat.join(" or ")));
    }
    words.retain(|word| !word.is_empty());
    words.join(", ")
}

pub(super) fn criterion(criterion: CriterionPlan) -> String {
    let share = 100.0 * criterion.share_correct;
    let rounds = criterion.max_rounds;
    let otherwise = if criterion.ends_session { "the session ends" } else { "the session goes on" };
    format!("{share:.0} % right, in up to {rounds} rounds; otherwise {otherwise}")
}

/// What each renderer parameter is set to by some levels.
pub(super) fn parameter_ranges(levels: &[Level]) -> Vec<ParameterRange> {
    let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (name, &value) in levels.iter().flatten() {
        values.entry(name).or_default().push(value);
    }
    values
        .into_iter()
        .filter_map(|(name, mut values)| {
            values.sort_by(f64::total_cmp);
            values.dedup_by(|a, b| a.total_cmp(b).is_eq());
            let (min, max) = (*values.first()?, *values.last()?);
            Some(ParameterRange { name: name.to_owned(), values: values.len(), min, max })
        })
        .collect()
}

pub(super) fn groups(plan: &Plan, blocks: &[BlockDescription]) -> Vec<GroupDescription> {
    let of_group = |names: &[String]| total(blocks.iter().filter(|block| names.contains(&block.name)));
    let groups = plan.groups.iter();
    groups
        .map(|group| GroupDescription {
            name: group.name.clone(),
            blocks: group.blocks.clone(),
            effort: of_group(&group.blocks),
        })
        .collect()
}

/// The effort of each sitting of the first group's first observer.
pub(super) fn sittings(plan: &Plan) -> Vec<Effort> {
    let Some(sittings) = &plan.sittings else { return Vec::new() };
    let group = plan.groups.first().map(|group| group.name.clone());
    let parts = (1..=sittings.count).filter_map(|sitting| {
        let assignment = Assignment { sitting, group: group.clone(), ..Assignment::default() };
        let part = plan.assigned(&assignment).ok()?;
        let blocks: Vec<BlockDescription> = part.blocks.iter().map(|block| describe_block(block, &part)).collect();
        Some(total(blocks.iter()))
    });
    parts.collect()
}
