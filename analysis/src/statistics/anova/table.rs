//! The balanced table: one value for every subject in every cell.

use super::effects::effects;
use super::{Anova, AnovaError, MissingCell};
use crate::statistics::check_confidence;
use serde::{Deserialize, Serialize};

/// The largest value that is taken: its square, summed, is still a number.
pub(super) const LARGEST: f64 = 1e150;
/// The most subjects × cells.
const MOST_VALUES: usize = 1_000_000;

/// A factor that was varied within subjects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Factor {
    /// Its name.
    pub name: String,
    /// Its levels.
    pub levels: Vec<String>,
}

/// One value for every subject in every cell of the crossed factors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Draft")]
pub struct Table {
    factors: Vec<Factor>,
    subjects: Vec<String>,
    /// Subject by subject; within a subject the last factor's level changes fastest.
    values: Vec<f64>,
    missing: Vec<MissingCell>,
}

/// A table as it is written down, which need not be one.
#[derive(Deserialize)]
struct Draft {
    factors: Vec<Factor>,
    subjects: Vec<String>,
    values: Vec<f64>,
    missing: Vec<MissingCell>,
}

impl TryFrom<Draft> for Table {
    type Error = AnovaError;

    fn try_from(draft: Draft) -> Result<Self, AnovaError> {
        Ok(Self { missing: draft.missing, ..Self::new(draft.factors, draft.subjects, draft.values)? })
    }
}

impl Table {
    /// A table of `values`, subject by subject, the last factor's level changing fastest.
    ///
    /// # Errors
    ///
    /// No factors or two of one name, a factor with fewer than two levels, fewer than two subjects, another number of
    /// values than subjects × cells, values that are not finite (or beyond ±1e150).
    pub fn new(factors: Vec<Factor>, subjects: Vec<String>, values: Vec<f64>) -> Result<Self, AnovaError> {
        let names: Vec<String> = factors.iter().map(|factor| factor.name.clone()).collect();
        check_names(&names)?;
        let cells = cell_count(&factors, subjects.len())?;
        let expected = subjects.len() * cells;
        if values.len() != expected {
            return Err(AnovaError::ValueCount { expected, found: values.len() });
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite() || value.abs() > LARGEST) {
            let (subject, cell) = (subjects[at / cells].clone(), cell_name(&factors, at % cells));
            return Err(AnovaError::Value { subject, cell, value: values[at] });
        }
        Self::build(factors, subjects, values, Vec::new())
    }

    pub(super) fn build(
        factors: Vec<Factor>,
        subjects: Vec<String>,
        values: Vec<f64>,
        missing: Vec<MissingCell>,
    ) -> Result<Self, AnovaError> {
        if let Some(factor) = factors.iter().find(|factor| factor.levels.len() < 2) {
            let level = factor.levels.first().cloned().unwrap_or_default();
            return Err(AnovaError::OneLevel { factor: factor.name.clone(), level });
        }
        let table = Self { factors, subjects, values, missing };
        if table.subjects.len() < 2 {
            return Err(AnovaError::TooFewSubjects { kept: table.subjects.len(), dropped: table.dropped().len() });
        }
        Ok(table)
    }

    /// The factors, in the order in which effects name them.
    #[must_use]
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// The subjects that are in it.
    #[must_use]
    pub fn subjects(&self) -> &[String] {
        &self.subjects
    }

    /// All values, subject by subject; within a subject the last factor's level changes fastest.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Cells of each subject.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.factors.iter().map(|factor| factor.levels.len()).product()
    }

    /// Cells that were missing, for which their subjects were left out.
    #[must_use]
    pub fn missing(&self) -> &[MissingCell] {
        &self.missing
    }

    /// The subjects that were left out, in order.
    #[must_use]
    pub fn dropped(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.missing.iter().map(|cell| cell.subject.as_str()).collect();
        names.dedup();
        names
    }

    /// Mean of every cell over subjects, in the order of a subject's values.
    #[must_use]
    pub fn cell_means(&self) -> Vec<f64> {
        let cells = self.cells();
        (0..cells).map(|cell| self.column(cell).sum::<f64>() / self.subjects.len() as f64).collect()
    }

    fn column(&self, cell: usize) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().skip(cell).step_by(self.cells()).copied()
    }

    /// For every level of `factor`, each subject's mean over all other factors.
    ///
    /// # Errors
    ///
    /// [`AnovaError::UnknownFactor`].
    pub fn margins(&self, factor: &str) -> Result<Vec<Vec<f64>>, AnovaError> {
        let (levels, inner) = self.place(factor)?;
        let cells = self.cells();
        let others = (cells / levels) as f64;
        Ok((0..levels)
            .map(|level| {
                let of_level = |row: &[f64]| {
                    let sum: f64 =
                        row.iter().enumerate().filter(|(cell, _)| cell / inner % levels == level).map(|(_, v)| v).sum();
                    sum / others
                };
                self.values.chunks(cells).map(of_level).collect()
            })
            .collect())
    }

    /// The table at one level of a factor, which it then no longer has: for simple effects.
    ///
    /// # Errors
    ///
    /// A factor or level that is not there; the only factor of a table.
    pub fn at(&self, factor: &str, level: &str) -> Result<Self, AnovaError> {
        let (levels, inner) = self.place(factor)?;
        let index = self.factors.iter().position(|known| known.name == factor);
        let number = index.and_then(|index| self.factors[index].levels.iter().position(|known| known == level));
        let number =
            number.ok_or_else(|| AnovaError::UnknownLevel { factor: factor.to_owned(), level: level.to_owned() })?;
        let factors: Vec<Factor> = self.factors.iter().filter(|known| known.name != factor).cloned().collect();
        if factors.is_empty() {
            return Err(AnovaError::NoFactors);
        }
        let cells = self.cells();
        let inside = |at: &usize| at % cells / inner % levels == number;
        let values = (0..self.values.len()).filter(inside).map(|at| self.values[at]).collect();
        Self::build(factors, self.subjects.clone(), values, self.missing.clone())
    }

    /// A factor's number of levels, and how far apart in a row they lie.
    fn place(&self, factor: &str) -> Result<(usize, usize), AnovaError> {
        let unknown = || AnovaError::UnknownFactor(factor.to_owned());
        let index = self.factors.iter().position(|known| known.name == factor).ok_or_else(unknown)?;
        Ok((
            self.factors[index].levels.len(),
            self.factors[index + 1..].iter().map(|factor| factor.levels.len()).product(),
        ))
    }

    /// The analysis of variance of this table; `confidence` (0–1) is that of its intervals.
    ///
    /// # Errors
    ///
    /// A confidence outside (0, 1).
    pub fn analyse(&self, confidence: f64) -> Result<Anova, AnovaError> {
        check_confidence(confidence)?;
        Ok(effects(self, confidence))
    }
}

pub(super) fn check_names(names: &[String]) -> Result<(), AnovaError> {
    if names.is_empty() {
        return Err(AnovaError::NoFactors);
    }
    match names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        Some((_, name)) => Err(AnovaError::DuplicateFactor(name.clone())),
        None => Ok(()),
    }
}

/// Cells of the crossed factors, unless they are more than can be meant.
pub(super) fn cell_count(factors: &[Factor], subjects: usize) -> Result<usize, AnovaError> {
    let cells = factors.iter().fold(1usize, |cells, factor| cells.saturating_mul(factor.levels.len()));
    if cells.saturating_mul(subjects) > MOST_VALUES {
        return Err(AnovaError::TooLarge { subjects, cells });
    }
    Ok(cells)
}

/// Factors and levels of a cell.
pub(super) fn cell_levels(factors: &[Factor], cell: usize) -> Vec<(String, String)> {
    let mut rest = cell;
    let mut pairs: Vec<(String, String)> = factors
        .iter()
        .rev()
        .map(|factor| {
            let level = &factor.levels[rest % factor.levels.len()];
            rest /= factor.levels.len();
            (factor.name.clone(), level.clone())
        })
        .collect();
    pairs.reverse();
    pairs
}

pub(super) fn cell_name(factors: &[Factor], cell: usize) -> String {
    let pairs = cell_levels(factors, cell);
    pairs.iter().map(|(factor, level)| format!("{factor}={level}")).collect::<Vec<_>>().join(", ")
}
