//! Analyses of variance with their interaction plots.

use crate::figures::{CellMean, Interaction, InteractionLine, InteractionPanel, interaction, within_subject_means};
use crate::report::page::{Cell, Figure, Section, Table};
use crate::report::tables::{AnovaRow, AnovaTable, anova_section};
use crate::statistics::anova::{Anova, Pairwise};

/// The analysis of variance of one measure of one block.
#[derive(Debug, Clone, Copy)]
pub struct BlockVariance<'a> {
    /// The block.
    pub block: &'a str,
    /// What was measured.
    pub measure: &'a str,
    /// The analysis, or why there is none.
    pub anova: Result<&'a Anova, &'a str>,
    /// p of every effect, adjusted for their number by Holm's method.
    pub p_holm: &'a [Option<f64>],
    /// Pairs of levels.
    pub pairwise: &'a [Pairwise],
}

/// All analyses of variance.
#[must_use]
pub fn variance_section(analyses: &[BlockVariance<'_>]) -> Section {
    let tables: Vec<AnovaTable> = analyses.iter().filter_map(|one| Some(table(one, one.anova.ok()?))).collect();
    let mut section = anova_section(&tables);
    for one in analyses {
        match one.anova {
            Ok(anova) => {
                section.tables.extend(adjusted(one, anova));
                section.tables.extend(one.pairwise.iter().map(|pairs| pairs_table(one, pairs)));
                section.figures.extend(plot(one, anova));
            }
            Err(reason) => section
                .warnings
                .push(format!("{}, {}: no analysis of variance, because {reason}.", one.block, one.measure)),
        }
    }
    section
}

fn table(one: &BlockVariance<'_>, anova: &Anova) -> AnovaTable {
    AnovaTable {
        title: format!("Block {}: {} of {} observers.", one.block, one.measure, anova.table.subjects().len()),
        method: vec![
            "Repeated-measures analyses of variance on each observer’s mean in each cell; p corrected for departures from \
             sphericity by Greenhouse and Geisser’s ε; generalised η² as in Olejnik and Algina (2003)."
                .to_owned(),
        ],
        rows: anova
            .effects
            .iter()
            .filter_map(|effect| {
                let test = effect.test.as_ref()?;
                Some(AnovaRow {
                    effect: effect.name(),
                    df: [effect.df as f64, effect.df_error as f64],
                    f: test.f,
                    p: test.p,
                    epsilon: Some(test.greenhouse_geisser.epsilon),
                    p_corrected: Some(test.greenhouse_geisser.p),
                    partial_eta2: Some(test.partial_eta_squared.estimate),
                    generalised_eta2: effect.generalised_eta_squared,
                })
            })
            .collect(),
    }
}

/// Sphericity and p adjusted over effects.
fn adjusted(one: &BlockVariance<'_>, anova: &Anova) -> Option<Table> {
    let mut table = Table::new(
        format!(
            "Block {}, {}: sphericity, Huynh and Feldt’s ε, and p adjusted for all effects (Holm).",
            one.block, one.measure
        ),
        &["Effect", "Mauchly W", "p", "ε (HF)", "p (HF)", "p (GG, Holm)"],
    );
    for (index, effect) in anova.effects.iter().enumerate() {
        let test = effect.test.as_ref()?;
        let mauchly = test.mauchly.test();
        table.push([
            Cell::from(effect.name().as_str()),
            Cell::maybe(mauchly.map(|m| m.w)),
            Cell::maybe(mauchly.map(|m| m.p)),
            Cell::maybe(test.huynh_feldt.as_ref().map(|hf| hf.epsilon)),
            Cell::maybe(test.huynh_feldt.as_ref().map(|hf| hf.p)),
            Cell::maybe(one.p_holm.get(index).copied().flatten()),
        ]);
    }
    Some(table)
}

fn pairs_table(one: &BlockVariance<'_>, pairs: &Pairwise) -> Table {
    let mut table = Table::new(
        format!("Block {}, {}: pairs of levels of {}, p by Holm’s method.", one.block, one.measure, pairs.factor),
        &["First", "Second", "Mean difference", "2.5 %", "97.5 %", "t", "df", "p", "p adjusted"],
    );
    for pair in &pairs.comparisons {
        let test = pair.test.as_ref();
        let interval = Cell::interval(test.map(|test| test.ci));
        let mut row: Vec<Cell> = vec![pair.first.as_str().into(), pair.second.as_str().into()];
        row.push(Cell::maybe(test.map(|test| test.difference)));
        row.extend(interval);
        row.extend([
            Cell::maybe(test.map(|test| test.t)),
            Cell::maybe(test.map(|test| test.df)),
            Cell::maybe(test.map(|test| test.p)),
            Cell::maybe(pair.p_adjusted),
        ]);
        table.push(row);
    }
    table
}

/// Means by the first two factors, the others averaged over, with within-subject intervals.
fn plot(one: &BlockVariance<'_>, anova: &Anova) -> Option<Figure> {
    let table = &anova.table;
    let (first, second) = (table.factors().first()?, table.factors().get(1));
    let seconds = second.map_or(1, |factor| factor.levels.len());
    let (cells, shown) = (table.cells(), first.levels.len() * seconds);
    // Cells run over the last factor fastest, so that those of the first two factors lie in runs.
    let run = cells / shown;
    let by_subject: Vec<Vec<f64>> = (0..table.subjects().len())
        .map(|subject| {
            let values = &table.values()[subject * cells..(subject + 1) * cells];
            values.chunks(run).map(|chunk| chunk.iter().sum::<f64>() / run as f64).collect()
        })
        .collect();
    let means = within_subject_means(&by_subject);
    let cell = |i: usize, j: usize| -> Option<CellMean> { means.get(i * seconds + j).cloned() };
    let lines = (0..seconds)
        .map(|j| InteractionLine {
            name: second.map_or_else(String::new, |factor| factor.levels[j].clone()),
            cells: (0..first.levels.len()).map(|i| cell(i, j)).collect(),
        })
        .collect();
    Some(Figure {
        svg: interaction(&Interaction {
            label: one.measure.to_owned(),
            factor: first.name.clone(),
            levels: first.levels.clone(),
            interval: "within-subject 95 % (Cousineau–Morey)".to_owned(),
            panels: vec![InteractionPanel { name: String::new(), lines }],
        }),
        caption: format!("Block {}: means of {} by condition over observers.", one.block, one.measure),
    })
}
