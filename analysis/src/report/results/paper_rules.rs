//! Blocks by the rules of the papers, beside what those published.

use crate::answers::part_name;
use crate::figures::{
    BoxChart, BoxGroup, HistogramView, LikertChart, LikertGroup, LikertRow, PatchBlur, Published, ThresholdGroup,
    Whiskers, blur_by_eccentricity, box_plots, likert_bars, threshold_histograms,
};
use crate::report::page::{Figure, Section};
use crate::report::tables::{PaperRule, paper_section};
use crate::rules::{OverObservers, RuleResult, guenter, stengel, tursun, weier};

/// Blocks by their paper's rule, as (block, what the rule gives).
#[must_use]
pub fn rules_section(blocks: &[(&str, &RuleResult)]) -> Section {
    let rows: Vec<PaperRule> = blocks.iter().flat_map(|(block, result)| rows(block, result)).collect();
    let mut section = paper_section(&rows);
    let thresholds: Vec<&guenter::Thresholds> = blocks
        .iter()
        .filter_map(|(_, result)| match result {
            RuleResult::Guenter(thresholds) => Some(thresholds),
            _ => None,
        })
        .collect();
    section.figures.extend(histogram(&thresholds));
    for (block, result) in blocks {
        match result {
            RuleResult::Tursun(tolerances) => section.figures.push(blur(tolerances)),
            RuleResult::Weier(ratings) => {
                section.figures.extend(ratings.items.iter().flat_map(|item| ratings_figures(block, item)));
            }
            RuleResult::Guenter(_) | RuleResult::StengelTask(_) | RuleResult::StengelSettings(_) => {}
        }
    }
    section
}

fn row(paper: &str, rule: String, unit: &str, over: Option<&OverObservers>) -> PaperRule {
    PaperRule {
        paper: paper.to_owned(),
        rule,
        unit: unit.to_owned(),
        n: over.map(|over| over.n),
        value: over.map(|over| over.mean),
        ci95: over.and_then(|over| over.ci95),
        sd: over.and_then(|over| over.sd),
        published: None,
        published_sd: None,
    }
}

fn rows(block: &str, result: &RuleResult) -> Vec<PaperRule> {
    match result {
        RuleResult::Guenter(thresholds) => {
            let published = thresholds.published.as_ref();
            vec![PaperRule {
                published: published.map(|published| published.value),
                published_sd: published.and_then(|published| published.sd),
                ..row(
                    "Guenter 2012",
                    format!("{block}: {}", thresholds.rule.says),
                    &thresholds.options.parameter,
                    thresholds.over_observers.as_ref(),
                )
            }]
        }
        RuleResult::Tursun(tolerances) => tolerances
            .patches
            .iter()
            .flat_map(|patch| {
                patch.over_observers.iter().map(|at| {
                    let rule =
                        format!("{block}, {}: strongest undetected blur at {}°", patch.patch, at.eccentricity_deg);
                    row("Tursun 2019", rule, "σ_s, degrees", Some(&at.sigma_deg))
                })
            })
            .collect(),
        RuleResult::StengelTask(recognised) => vec![task(recognised)],
        RuleResult::StengelSettings(settings) => settings
            .settings
            .iter()
            .filter(|setting| setting.by.is_empty())
            .map(|setting| {
                let rule = format!("{block}: mean setting of {}", setting.parameter);
                row("Stengel 2016", rule, &setting.parameter, Some(&setting.over_observers))
            })
            .collect(),
        RuleResult::Weier(ratings) => ratings
            .items
            .iter()
            .flat_map(|item| {
                item.conditions.iter().map(|condition| PaperRule {
                    published: condition.published.as_ref().map(|published| published.value),
                    published_sd: condition.published.as_ref().and_then(|published| published.sd),
                    ..row(
                        "Weier 2016",
                        format!("{block}, {}: mean rating, {}", item.item, part_name(&condition.by)),
                        "scale",
                        Some(&condition.over_observers),
                    )
                })
            })
            .collect(),
    }
}

fn task(recognised: &stengel::Recognised) -> PaperRule {
    let shares = &recognised.recognised;
    let rule = format!("{}: share of comparisons in which the subsampled picture was recognised", recognised.task);
    let over = recognised.over_observers.as_ref();
    PaperRule {
        n: over.map(|over| over.n),
        value: Some(shares.share),
        published: recognised.published.as_ref().map(|published| published.value),
        ..row("Stengel 2016", rule, "share", over)
    }
}

/// Guenter's Fig. 9: how many observers at each quality index.
fn histogram(thresholds: &[&guenter::Thresholds]) -> Option<Figure> {
    let first = thresholds.first()?;
    let groups: Vec<ThresholdGroup> = thresholds
        .iter()
        .map(|one| ThresholdGroup {
            name: one.rule.name.clone(),
            values: one.observers.iter().filter_map(|observer| observer.threshold).collect(),
            without: one.without,
            published: one.published.as_ref().map(|published| Published {
                source: published.source.clone(),
                mean: published.value,
                sd: published.sd.unwrap_or(0.0),
            }),
        })
        .collect();
    let view = HistogramView { label: first.options.parameter.clone(), bin: None, range: None };
    Some(Figure {
        svg: threshold_histograms(&groups, &view),
        caption: "Thresholds of the observers by Guenter’s rules, with the published mean and standard deviation."
            .to_owned(),
    })
}

/// Tursun's Fig. 7: the tolerated blur of every patch by eccentricity.
fn blur(tolerances: &tursun::Tolerances) -> Figure {
    let patches: Vec<PatchBlur> = tolerances
        .patches
        .iter()
        .map(|patch| PatchBlur {
            patch: patch.patch.clone(),
            points: patch.over_observers.iter().map(|at| [at.eccentricity_deg, at.sigma_deg.mean]).collect(),
        })
        .collect();
    Figure {
        svg: blur_by_eccentricity(&patches, "Strongest undetected σ_s (degrees)"),
        caption: "Strongest blur that was not detected by Tursun’s rule, mean over observers: boxes over patches."
            .to_owned(),
    }
}

/// Weier's Figs. 6 and 7: ratings by condition as bars and as boxes.
fn ratings_figures(block: &str, item: &weier::ItemRatings) -> Vec<Figure> {
    let steps: Vec<i32> =
        item.conditions.iter().flat_map(|condition| condition.counts.iter().map(|count| count.step)).collect();
    let (Some(&low), Some(&high)) = (steps.iter().min(), steps.iter().max()) else { return Vec::new() };
    // A scale is symmetric about its neutral step, whether or not its ends were chosen.
    let most = low.abs().max(high.abs());
    let (low, high) = if low < 0 { (-most, most) } else { (low, high) };
    let rows = |condition: &weier::Condition| LikertRow {
        name: part_name(&condition.by),
        counts: (low..=high)
            .map(|step| condition.counts.iter().filter(|count| count.step == step).map(|count| count.n).sum())
            .collect(),
    };
    let chart = LikertChart {
        title: format!("{block}: {}", item.item),
        steps: [low, high],
        ends: Default::default(),
        groups: vec![LikertGroup { heading: String::new(), rows: item.conditions.iter().map(rows).collect() }],
    };
    let boxes = BoxChart {
        title: format!("{block}: {}", item.item),
        label: "Rating".to_owned(),
        groups: item
            .conditions
            .iter()
            .map(|condition| BoxGroup {
                name: part_name(&condition.by),
                values: condition.counts.iter().flat_map(|count| vec![f64::from(count.step); count.n]).collect(),
            })
            .collect(),
        whiskers: Whiskers::Tukey,
        notches: false,
        range: Some([f64::from(low), f64::from(high)]),
    };
    vec![
        Figure {
            svg: likert_bars(&chart), caption: format!("How often each step was chosen for “{}”.", item.item)
        },
        Figure { svg: box_plots(&boxes), caption: format!("Ratings of “{}” by condition.", item.item) },
    ]
}
