//! What several observers come to together: the pooled MAR line, analyses of variance, the papers' own rules.

use super::ObserverResult;
use analysis::answers::{Protocol, Row, Summary};
use analysis::mar::hierarchical::{HierarchicalConfig, HierarchicalFit, ObserverTrials, fit_hierarchical};
use analysis::mar::linearity::{Linearity, LinearityConfig, test_linearity};
use analysis::rules::{Bootstrap, ObserverRows, RuleResult, of_block};
use analysis::statistics::anova::{Anova, AnovaConfig, Observations, Pairwise, Replicates, pairwise, rm_anova};
use analysis::statistics::multiple::Adjustment;
use analysis::{MarFit, MarTrial};
use serde::Serialize;
use std::collections::BTreeMap;

/// What several observers come to together.
#[derive(Debug, Clone, Default, Serialize)]
pub struct OverObservers {
    /// The pooled MAR line, of two observers and more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group_mar: Option<HierarchicalFit>,
    /// Why there is no pooled line though several observers have trials for one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_group_mar: Option<String>,
    /// Whether the line of each observer is one, by observer.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub linearity: BTreeMap<String, Linearity>,
    /// Analyses of variance of blocks with factors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub anovas: Vec<BlockAnova>,
    /// Blocks by the rule of the paper that their protocol comes from, also of one observer.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<BlockRule>,
}

/// The analysis of variance of one measure of one block.
#[derive(Debug, Clone, Serialize)]
pub struct BlockAnova {
    /// The study.
    pub study: String,
    /// The block.
    pub block: String,
    /// What was measured: an item, a setting, or `right` for the share of right answers.
    pub measure: String,
    /// The analysis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anova: Option<Anova>,
    /// p of every effect that was tested, adjusted for their number by Holm's method, in the effects' order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub p_holm: Vec<Option<f64>>,
    /// Pairs of levels of every factor with three levels and more, p by Holm's method.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairwise: Vec<Pairwise>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
}

/// A block by its paper's rule.
#[derive(Debug, Clone, Serialize)]
pub struct BlockRule {
    /// The study.
    pub study: String,
    /// The block.
    pub block: String,
    /// What the rule gives.
    pub result: RuleResult,
}

/// Puts observers together.
#[must_use]
pub fn over_observers(results: &[ObserverResult<'_>]) -> OverObservers {
    let (group_mar, no_group_mar) = match pooled(results) {
        None => (None, None),
        Some(Ok(fit)) => (Some(fit), None),
        Some(Err(reason)) => (None, Some(reason)),
    };
    OverObservers {
        group_mar,
        no_group_mar,
        linearity: BTreeMap::new(),
        anovas: anovas(results),
        rules: rules(results),
    }
}

impl OverObservers {
    /// Adds the test of every observer's line. Its bend needs hundreds of simulated data sets, so that it is made only for
    /// documents that show it.
    #[must_use]
    pub fn with_linearity(mut self, results: &[ObserverResult<'_>]) -> Self {
        let test = |result: &ObserverResult<'_>| linearity(result.fit.as_ref()?, &result.mar_trials);
        let tests = results.iter().filter_map(|result| Some((result.observer.clone(), test(result)?)));
        self.linearity = tests.collect();
        self
    }
}

fn pooled(results: &[ObserverResult<'_>]) -> Option<Result<HierarchicalFit, String>> {
    let observers: Vec<ObserverTrials> = results
        .iter()
        .filter_map(|result| {
            let fit = result.fit.as_ref()?;
            Some(ObserverTrials {
                id: result.observer.clone(),
                trials: result.mar_trials.clone(),
                finest_mar: fit.config.finest_mar.clone(),
            })
        })
        .collect();
    (observers.len() > 1)
        .then(|| fit_hierarchical(&observers, &HierarchicalConfig::default()).map_err(|error| error.to_string()))
}

/// One observer's rows of a block.
type Rows<'a> = Vec<(&'a str, &'a [Row])>;

/// Blocks by study and name, in the order in which they first appear.
fn blocks<'a>(results: &'a [ObserverResult<'_>]) -> Vec<((&'a str, &'a str), Option<Protocol>, Rows<'a>)> {
    let mut blocks: Vec<((&str, &str), Option<Protocol>, Rows<'_>)> = Vec::new();
    for result in results {
        for (summary, rows) in result.blocks.iter().zip(&result.rows) {
            if rows.is_empty() {
                continue;
            }
            let key = (summary.study.as_str(), summary.block.as_str());
            let entry = (result.observer.as_str(), rows.as_slice());
            match blocks.iter_mut().find(|(known, ..)| *known == key) {
                Some((.., rows)) => rows.push(entry),
                None => blocks.push((key, summary.protocol, vec![entry])),
            }
        }
    }
    blocks
}

fn rules(results: &[ObserverResult<'_>]) -> Vec<BlockRule> {
    blocks(results)
        .into_iter()
        .filter_map(|((study, block), protocol, rows)| {
            let observers: Vec<ObserverRows<'_>> =
                rows.iter().map(|&(observer, rows)| ObserverRows { observer, rows }).collect();
            // A protocol without a rule, or a block that its rule says nothing about, has its other numbers.
            let result = of_block(block, protocol?, &observers, Bootstrap::default()).ok()?;
            Some(BlockRule { study: study.to_owned(), block: block.to_owned(), result })
        })
        .collect()
}

fn anovas(results: &[ObserverResult<'_>]) -> Vec<BlockAnova> {
    let mut anovas = Vec::new();
    for ((study, block), protocol, rows) in blocks(results) {
        let factors = varying_factors(&rows);
        if rows.len() < 2 || factors.is_empty() {
            continue;
        }
        for measure in measures(results, study, block, protocol) {
            let mut observations = Observations::new(factors.iter().copied());
            for (observer, row) in rows.iter().flat_map(|(observer, rows)| rows.iter().map(move |row| (observer, row)))
            {
                let levels: Option<Vec<&String>> = factors.iter().map(|factor| row.factors.get(*factor)).collect();
                if let (Some(levels), Some(value)) = (levels, value(row, &measure)) {
                    observations.push(*observer, levels, value);
                }
            }
            anovas.push(analysed(study, block, measure, &observations));
        }
    }
    anovas
}

fn analysed(study: &str, block: &str, measure: String, observations: &Observations) -> BlockAnova {
    // Repetitions of a cell are averaged: the observer is the unit.
    let config = AnovaConfig { replicates: Replicates::Mean, ..AnovaConfig::default() };
    let mut result = BlockAnova {
        study: study.to_owned(),
        block: block.to_owned(),
        measure,
        anova: None,
        p_holm: Vec::new(),
        pairwise: Vec::new(),
        refused: None,
    };
    match rm_anova(observations, &config) {
        Ok(anova) => {
            result.p_holm = holm(&anova);
            result.pairwise = anova
                .table
                .factors()
                .iter()
                .filter(|factor| factor.levels.len() > 2)
                .filter_map(|factor| pairwise(&anova.table, &factor.name, Adjustment::Holm, config.confidence).ok())
                .collect();
            result.anova = Some(anova);
        }
        Err(error) => result.refused = Some(error.to_string()),
    }
    result
}

/// p by Greenhouse and Geisser of every tested effect, adjusted together.
fn holm(anova: &Anova) -> Vec<Option<f64>> {
    let tested: Vec<(usize, f64)> = anova
        .effects
        .iter()
        .enumerate()
        .filter_map(|(index, effect)| Some((index, effect.test.as_ref()?.greenhouse_geisser.p)))
        .collect();
    let raw: Vec<f64> = tested.iter().map(|(_, p)| *p).collect();
    let mut adjusted = vec![None; anova.effects.len()];
    if let Ok(values) = analysis::statistics::multiple::adjust(&raw, Adjustment::Holm) {
        for ((index, _), value) in tested.iter().zip(values) {
            adjusted[*index] = Some(value);
        }
    }
    adjusted
}

/// Factors that every trial has and that take at least two levels.
fn varying_factors<'a>(rows: &Rows<'a>) -> Vec<&'a str> {
    let all = || rows.iter().flat_map(|(_, rows)| rows.iter());
    let mut levels: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (factor, level) in all().flat_map(|row| &row.factors) {
        let levels = levels.entry(factor).or_default();
        if !levels.contains(&level.as_str()) {
            levels.push(level);
        }
    }
    let everywhere = |factor: &str| all().all(|row| row.factors.contains_key(factor));
    levels
        .into_iter()
        .filter(|(factor, levels)| levels.len() > 1 && everywhere(factor))
        .map(|(factor, _)| factor)
        .collect()
}

/// What a block measures.
fn measures(results: &[ObserverResult<'_>], study: &str, block: &str, protocol: Option<Protocol>) -> Vec<String> {
    let summary = results
        .iter()
        .flat_map(|result| &result.blocks)
        .find(|summary| summary.study == study && summary.block == block)
        .map(|summary| &summary.summary);
    match (summary, protocol) {
        (Some(Summary::Ratings(ratings)), _) => ratings.items.iter().map(|item| item.item.clone()).collect(),
        (Some(Summary::Matches(matches)), _) => {
            let all = matches.parts.first().map(|part| part.quantities.as_slice()).unwrap_or_default();
            all.iter().filter(|quantity| quantity.is_setting()).map(|quantity| quantity.quantity.clone()).collect()
        }
        (Some(Summary::Detection(_)), _) => vec![RIGHT.to_owned()],
        _ => Vec::new(),
    }
}

/// The name of the share of right answers as a measure.
const RIGHT: &str = "right";

fn value(row: &Row, measure: &str) -> Option<f64> {
    match row.found.get(measure) {
        Some(value) => Some(*value),
        None if measure == RIGHT => row.correct.map(|correct| f64::from(u8::from(correct))),
        None => None,
    }
}

/// Simulated data sets behind a bend's p.
const BEND_SIMULATIONS: usize = 200;

/// The test of the line; nothing for data that it cannot be asked of, such as a single eccentricity.
fn linearity(fit: &MarFit, trials: &[MarTrial]) -> Option<Linearity> {
    let config = LinearityConfig {
        finest_mar: fit.config.finest_mar.clone(),
        simulations: BEND_SIMULATIONS,
        ..LinearityConfig::default()
    };
    test_linearity(trials, &config).ok()
}
