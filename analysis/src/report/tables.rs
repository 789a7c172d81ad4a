//! Sections of optional plain data: the group, ANOVAs, exclusions, the papers' own rules, gaze quality.
//!
//! Whoever has the numbers fills these; each becomes a [`Section`] whose tables paste as numbers. Empty data become empty
//! sections, which a page leaves out.

use super::page::{Cell, Section, Table};
use crate::mar::Estimate;
use serde::{Deserialize, Serialize};

/// One parameter of a group that was fitted as a whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupParameter {
    /// Name with unit, for example `m (degrees per cycle per degree)`.
    pub name: String,
    /// The typical observer.
    pub typical: Estimate,
    /// Standard deviation between observers, in the unit that `spread_unit` names.
    pub spread: Option<Estimate>,
    /// Unit of the spread, for example `ln`; may be empty.
    pub spread_unit: String,
    /// Each observer, as (code, alone, within the group); what is not there is `None`.
    pub observers: Vec<(String, Option<Estimate>, Option<Estimate>)>,
}

/// A group that was fitted as a whole.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct HierarchicalGroup {
    /// How it was fitted, as full sentences.
    pub method: Vec<String>,
    /// Why the numbers are no result, if they are none.
    pub warnings: Vec<String>,
    /// The parameters.
    pub parameters: Vec<GroupParameter>,
}

/// The group's result.
#[must_use]
pub fn group_section(group: &HierarchicalGroup) -> Section {
    let mut section =
        Section { prose: group.method.clone(), warnings: group.warnings.clone(), ..Section::new("The group") };
    if group.parameters.is_empty() {
        return section;
    }
    let mut typical = Table::new(
        "The typical observer and the standard deviation between observers, with 95 % intervals.",
        &["Parameter", "Typical", "2.5 %", "97.5 %", "SD between", "2.5 %", "97.5 %", "Unit of SD"],
    );
    for parameter in &group.parameters {
        let mut row = vec![Cell::from(parameter.name.as_str())];
        row.extend(Cell::estimate(&parameter.typical));
        row.extend(Cell::maybe_estimate(parameter.spread.as_ref()));
        row.push(parameter.spread_unit.as_str().into());
        typical.push(row);
    }
    section.tables.push(typical);
    for parameter in group.parameters.iter().filter(|parameter| !parameter.observers.is_empty()) {
        let mut table = Table::new(
            format!(
                "{} of every observer: alone, and drawn to the group as far as the data leave it open.",
                parameter.name
            ),
            &["Observer", "Alone", "2.5 %", "97.5 %", "Within the group", "2.5 %", "97.5 %"],
        );
        for (observer, alone, within) in &parameter.observers {
            let mut row = vec![Cell::from(observer.as_str())];
            row.extend(Cell::maybe_estimate(alone.as_ref()));
            row.extend(Cell::maybe_estimate(within.as_ref()));
            table.push(row);
        }
        section.tables.push(table);
    }
    section
}

/// One effect of an analysis of variance.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AnovaRow {
    /// The effect, for example `foveal region × scene`.
    pub effect: String,
    /// Degrees of freedom of the effect and of the error, uncorrected.
    pub df: [f64; 2],
    /// F.
    pub f: f64,
    /// p, uncorrected.
    pub p: f64,
    /// Epsilon of the correction for sphericity (Greenhouse–Geisser or Huynh–Feldt).
    pub epsilon: Option<f64>,
    /// p with that correction.
    pub p_corrected: Option<f64>,
    /// Partial eta squared.
    pub partial_eta2: Option<f64>,
    /// Generalised eta squared.
    pub generalised_eta2: Option<f64>,
}

/// An analysis of variance.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AnovaTable {
    /// What was analysed, for example `Ratings of artefacts, 15 observers`.
    pub title: String,
    /// Method and correction, as full sentences.
    pub method: Vec<String>,
    /// The effects.
    pub rows: Vec<AnovaRow>,
}

/// Analyses of variance, one table each.
#[must_use]
pub fn anova_section(tables: &[AnovaTable]) -> Section {
    let mut section = Section::new("Analysis of variance");
    for anova in tables {
        section
            .prose
            .extend(anova.method.iter().filter(|text| !section.prose.contains(text)).cloned().collect::<Vec<_>>());
        let mut table = Table::new(
            anova.title.clone(),
            &["Effect", "df effect", "df error", "F", "p", "ε", "p corrected", "partial η²", "generalised η²"],
        );
        for row in &anova.rows {
            table.push([
                row.effect.as_str().into(),
                row.df[0].into(),
                row.df[1].into(),
                row.f.into(),
                row.p.into(),
                Cell::maybe(row.epsilon),
                Cell::maybe(row.p_corrected),
                Cell::maybe(row.partial_eta2),
                Cell::maybe(row.generalised_eta2),
            ]);
        }
        section.tables.push(table);
    }
    section
}

/// A trial that was flagged or left out.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlaggedTrial {
    /// The session.
    pub session: String,
    /// Its trial, from 1.
    pub trial: u32,
    /// Why.
    pub reason: String,
    /// Left out of the analysis; otherwise only flagged.
    pub excluded: bool,
}

/// What was left out, and what a reader may want to leave out.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Exclusions {
    /// The rules, as full sentences.
    pub rules: Vec<String>,
    /// Observers left out, as (code, reason).
    pub observers: Vec<(String, String)>,
    /// Trials flagged or left out.
    pub trials: Vec<FlaggedTrial>,
    /// Trials that were looked at.
    pub looked_at: usize,
}

/// Rows of flagged trials on the page at most; the counts are of all.
const MOST_TRIALS: usize = 200;

/// Observers and trials left out or flagged, counted by reason and listed.
#[must_use]
pub fn exclusions_section(exclusions: &Exclusions) -> Section {
    let mut section = Section { prose: exclusions.rules.clone(), ..Section::new("Exclusions and flags") };
    if !exclusions.observers.is_empty() {
        let mut table = Table::new("Observers left out.", &["Observer", "Reason"]);
        exclusions.observers.iter().for_each(|(who, why)| table.push([who.as_str().into(), why.as_str().into()]));
        section.tables.push(table);
    }
    if exclusions.trials.is_empty() {
        return section;
    }
    let mut counts: std::collections::BTreeMap<&str, [usize; 2]> = std::collections::BTreeMap::new();
    for trial in &exclusions.trials {
        counts.entry(&trial.reason).or_default()[usize::from(!trial.excluded)] += 1;
    }
    let mut table = Table::new(
        format!("Trials by reason, of {}; one trial may have several.", exclusions.looked_at),
        &["Reason", "Left out", "Only flagged", "Share (%)"],
    );
    for (reason, [out, flagged]) in counts {
        let share = (exclusions.looked_at > 0).then(|| (out + flagged) as f64 / exclusions.looked_at as f64);
        table.push([reason.into(), out.into(), flagged.into(), Cell::percent(share)]);
    }
    section.tables.push(table);
    let mut table = Table::new("The trials.", &["Session", "Trial", "Reason", "Left out"]);
    for trial in exclusions.trials.iter().take(MOST_TRIALS) {
        table.push([
            trial.session.as_str().into(),
            (trial.trial as usize).into(),
            trial.reason.as_str().into(),
            if trial.excluded { "yes" } else { "no" }.into(),
        ]);
    }
    if exclusions.trials.len() > MOST_TRIALS {
        table.caption = format!("The first {MOST_TRIALS} of {} trials.", exclusions.trials.len());
    }
    section.tables.push(table);
    section
}

/// A number by a paper's own rule, beside what the paper published.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PaperRule {
    /// The paper, for example `Guenter 2012`.
    pub paper: String,
    /// The rule in words, for example `pair: lowest j called equal or better`.
    pub rule: String,
    /// Unit; may be empty.
    pub unit: String,
    /// Observers (or trials) behind the number.
    pub n: Option<usize>,
    /// Our number by that rule.
    pub value: Option<f64>,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Its standard deviation over observers.
    pub sd: Option<f64>,
    /// The published number.
    pub published: Option<f64>,
    /// The published standard deviation.
    pub published_sd: Option<f64>,
}

/// Numbers by the papers' own rules.
#[must_use]
pub fn paper_section(rules: &[PaperRule]) -> Section {
    let mut section = Section::new("By the papers’ own rules");
    if rules.is_empty() {
        return section;
    }
    let mut table = Table::new(
        "The same data by the rules of the papers, beside what they published.",
        &["Rule", "Paper", "Unit", "n", "Here", "2.5 %", "97.5 %", "SD", "Published", "Published SD"],
    );
    for rule in rules {
        let mut row = vec![rule.rule.as_str().into(), rule.paper.as_str().into(), rule.unit.as_str().into()];
        row.extend([rule.n.map_or(Cell::Missing, Cell::from), Cell::maybe(rule.value)]);
        row.extend(Cell::interval(rule.ci95));
        row.extend([Cell::maybe(rule.sd), Cell::maybe(rule.published), Cell::maybe(rule.published_sd)]);
        table.push(row);
    }
    section.tables.push(table);
    section
}

/// How good the gaze data of one session are; angles in degrees.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GazeQuality {
    /// The session.
    pub session: String,
    /// Samples per second.
    pub rate_hz: Option<f64>,
    /// Share of samples lost, 0–1.
    pub loss_share: Option<f64>,
    /// Mean distance from the fixation point.
    pub accuracy_deg: Option<f64>,
    /// Root mean square of sample-to-sample distances.
    pub precision_rms_deg: Option<f64>,
    /// Standard deviation around the mean position.
    pub precision_sd_deg: Option<f64>,
    /// Fixations found.
    pub fixations: Option<usize>,
    /// Saccades found.
    pub saccades: Option<usize>,
    /// Blinks found.
    pub blinks: Option<usize>,
}

/// Quality of gaze, a row for each session.
#[must_use]
pub fn gaze_section(qualities: &[GazeQuality], notes: &[String]) -> Section {
    let mut section = Section { prose: notes.to_vec(), ..Section::new("Quality of gaze") };
    if qualities.is_empty() {
        return section;
    }
    let mut table = Table::new(
        "Quality of gaze by session.",
        &[
            "Session",
            "Rate (Hz)",
            "Lost (%)",
            "Accuracy (°)",
            "Precision, RMS (°)",
            "Precision, SD (°)",
            "Fixations",
            "Saccades",
            "Blinks",
        ],
    );
    for quality in qualities {
        let count = |n: Option<usize>| n.map_or(Cell::Missing, Cell::from);
        table.push([
            quality.session.as_str().into(),
            Cell::maybe(quality.rate_hz),
            Cell::percent(quality.loss_share),
            Cell::maybe(quality.accuracy_deg),
            Cell::maybe(quality.precision_rms_deg),
            Cell::maybe(quality.precision_sd_deg),
            count(quality.fixations),
            count(quality.saccades),
            count(quality.blinks),
        ]);
    }
    section.tables.push(table);
    section
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_makes_no_section() {
        for section in [
            group_section(&HierarchicalGroup::default()),
            anova_section(&[]),
            exclusions_section(&Exclusions::default()),
            paper_section(&[]),
            gaze_section(&[], &[]),
        ] {
            assert_eq!(section.html(), "");
        }
    }

    #[test]
    fn every_row_has_a_cell_for_every_column() {
        let estimate = Estimate { estimate: 0.022, ci95: [0.02, 0.024] };
        let group = HierarchicalGroup {
            parameters: vec![GroupParameter {
                name: "m".to_owned(),
                typical: estimate,
                spread: None,
                spread_unit: "ln".to_owned(),
                observers: vec![("P01".to_owned(), Some(estimate), None)],
            }],
            ..HierarchicalGroup::default()
        };
        let flagged =
            |excluded| FlaggedTrial { session: "s".to_owned(), trial: 3, reason: "fast".to_owned(), excluded };
        let exclusions = Exclusions {
            observers: vec![("P07".to_owned(), "asleep".to_owned())],
            trials: vec![flagged(true), flagged(true), flagged(false)],
            looked_at: 60,
            ..Exclusions::default()
        };
        let sections = [
            group_section(&group),
            anova_section(&[AnovaTable { rows: vec![AnovaRow::default()], ..AnovaTable::default() }]),
            exclusions_section(&exclusions),
            paper_section(&[PaperRule::default()]),
            gaze_section(&[GazeQuality::default()], &[]),
        ];
        for table in sections.iter().flat_map(|section| &section.tables) {
            assert!(
                !table.rows.is_empty() && table.rows.iter().all(|row| row.len() == table.columns.len()),
                "{table:?}"
            );
        }
        let counts = &sections[2].tables[1].rows[0];
        assert_eq!(counts[..], ["fast".into(), 2usize.into(), 1usize.into(), Cell::Number(5.0)]);
    }
}
