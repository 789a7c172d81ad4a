//! Analysis of variance for repeated measures: any number of factors, all of them within subjects.
//!
//! Every subject has one value in every cell of the fully crossed factors. Each effect is tested against its own
//! interaction with subjects, as in Kirk (2013, ch. 10) and Winer (1971), with the sphericity that this test assumes
//! measured from the effect's own contrasts. Factors between subjects, and cells that miss values, need another model:
//! they are not here.
//!
//! [`Observations`] collects the values, [`Table`] is the balanced table that they make, [`rm_anova`] analyses it and
//! [`pairwise`] compares the levels of a factor two by two.

mod effects;
mod observations;
mod posthoc;
mod sphericity;
mod table;

pub use effects::{Effect, EffectTest, EtaSquared};
pub use observations::{Missing, MissingCell, Observation, Observations, Replicates};
pub use posthoc::{Comparison, Pairwise, pairwise};
pub use sphericity::{Corrected, HuynhFeldt, Mauchly, MauchlyTest};
pub use table::{Factor, Table};

use super::TestError;
use serde::{Deserialize, Serialize};

/// What an analysis of variance may be told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AnovaConfig {
    /// What is done with several values of one subject in one cell.
    pub replicates: Replicates,
    /// What is done with subjects that lack a cell.
    pub missing: Missing,
    /// Confidence of intervals, 0–1.
    pub confidence: f64,
}

impl Default for AnovaConfig {
    fn default() -> Self {
        Self { replicates: Replicates::Refuse, missing: Missing::Refuse, confidence: 0.95 }
    }
}

/// Why there is no analysis of variance of these data.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnovaError {
    /// No factor was named.
    #[error("an analysis of variance needs at least one factor")]
    NoFactors,
    /// Two factors have one name.
    #[error("two factors are called {0:?}")]
    DuplicateFactor(String),
    /// There is no such factor.
    #[error("there is no factor {0:?}")]
    UnknownFactor(String),
    /// There is no such level.
    #[error("factor {factor:?} has no level {level:?}")]
    UnknownLevel {
        /// Factor.
        factor: String,
        /// The level that was asked for.
        level: String,
    },
    /// Nothing was observed.
    #[error("there are no observations")]
    NoObservations,
    /// An observation names too many or too few levels.
    #[error("observation {} (subject {subject:?}) names {found} levels for {expected} factors", index + 1)]
    LevelCount {
        /// Which observation, from 0.
        index: usize,
        /// Whose.
        subject: String,
        /// Factors there are.
        expected: usize,
        /// Levels it names.
        found: usize,
    },
    /// A value that is not a number that can be squared.
    #[error(
        "subject {subject:?} has the value {value} at {cell}: it must be a finite number of a size that can be squared"
    )]
    Value {
        /// Whose.
        subject: String,
        /// Where, as "factor=level, factor=level".
        cell: String,
        /// The value.
        value: f64,
    },
    /// A subject has several values in one cell, and nobody said that they may be averaged.
    #[error("subject {subject:?} has more than one value at {cell}; average them first, or ask for `Replicates::Mean`")]
    Duplicate {
        /// Whose.
        subject: String,
        /// Where.
        cell: String,
    },
    /// Subjects lack cells.
    #[error("{} missing: {}", cells.len(), cells.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    MissingCells {
        /// All of them, by subject.
        cells: Vec<MissingCell>,
    },
    /// A factor that does not vary.
    #[error("factor {factor:?} has only the level {level:?}: there is nothing to compare")]
    OneLevel {
        /// Factor.
        factor: String,
        /// Its level.
        level: String,
    },
    /// No variance between subjects can be seen.
    #[error("{kept} subjects ({dropped} dropped for missing cells): at least 2 are needed")]
    TooFewSubjects {
        /// Subjects with all cells.
        kept: usize,
        /// Subjects left out.
        dropped: usize,
    },
    /// Crossing all levels gives a table that cannot be meant.
    #[error("crossing all levels gives {subjects} subjects × {cells} cells, more than this can be meant for")]
    TooLarge {
        /// Subjects.
        subjects: usize,
        /// Cells of each.
        cells: usize,
    },
    /// As many values as subjects × cells.
    #[error("the table has {found} values; its subjects and levels make {expected}")]
    ValueCount {
        /// subjects × cells.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// A confidence outside (0, 1), or a comparison that cannot be made.
    #[error(transparent)]
    Test(#[from] TestError),
}

/// A repeated-measures analysis of variance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Anova {
    /// Main effects first, then interactions of two, of three …
    pub effects: Vec<Effect>,
    /// Mean of all cells.
    pub grand_mean: f64,
    /// Sum of squares of all values around the grand mean.
    pub ss_total: f64,
    /// Sum of squares of the subjects' means.
    pub ss_subjects: f64,
    /// Subjects − 1.
    pub df_subjects: usize,
    /// What was analysed, and who was left out of it.
    pub table: Table,
    /// Confidence of intervals, 0–1.
    pub confidence: f64,
}

impl Anova {
    /// The effect of these factors, in any order.
    #[must_use]
    pub fn effect(&self, factors: &[&str]) -> Option<&Effect> {
        self.effects.iter().find(|effect| {
            effect.factors.len() == factors.len() && effect.factors.iter().all(|name| factors.contains(&name.as_str()))
        })
    }
}

/// Analyses what was observed.
///
/// # Errors
///
/// Whatever keeps the observations from being a balanced table ([`Observations::table`]), and a confidence outside (0, 1).
///
/// ```
/// use analysis::statistics::anova::{AnovaConfig, Observations, rm_anova};
///
/// let mut seen = Observations::new(["method"]);
/// for (subject, values) in [("P1", [4.0, 6.0, 9.0]), ("P2", [3.0, 6.0, 7.0]), ("P3", [5.0, 5.0, 8.0])] {
///     for (method, value) in ["small", "medium", "large"].into_iter().zip(values) {
///         seen.push(subject, [method], value);
///     }
/// }
/// let anova = rm_anova(&seen, &AnovaConfig::default())?;
/// let effect = anova.effect(&["method"]).unwrap();
/// assert_eq!((effect.df, effect.df_error), (2, 4));
/// assert!((effect.test.as_ref().unwrap().f - 109.0 / 7.0).abs() < 1e-9);
/// # Ok::<(), analysis::statistics::anova::AnovaError>(())
/// ```
pub fn rm_anova(observations: &Observations, config: &AnovaConfig) -> Result<Anova, AnovaError> {
    observations.table(config.replicates, config.missing)?.analyse(config.confidence)
}
