//! Values as they come, one a line, and how they become a balanced table.

use super::table::{Factor, Table, cell_count};
use super::{AnovaError, table};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fmt;

/// One value of one subject.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Whose.
    pub subject: String,
    /// The level of every factor, in the factors' order.
    pub levels: Vec<String>,
    /// The value.
    pub value: f64,
}

/// Values in long format: subject, levels, value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Observations {
    /// Names of the factors.
    pub factors: Vec<String>,
    /// All values, in any order.
    pub rows: Vec<Observation>,
}

/// What is done with several values of one subject in one cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Replicates {
    /// They are an error: a value may have been entered twice.
    #[default]
    Refuse,
    /// Their mean is taken.
    Mean,
}

/// What is done with subjects that lack a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Missing {
    /// They are an error that names every missing cell.
    #[default]
    Refuse,
    /// They are left out, and the result says so.
    DropSubjects,
}

/// A cell that a subject has no value in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MissingCell {
    /// Who.
    pub subject: String,
    /// Where: factors and levels.
    pub cell: Vec<(String, String)>,
}

impl fmt::Display for MissingCell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pairs: Vec<String> = self.cell.iter().map(|(factor, level)| format!("{factor}={level}")).collect();
        write!(f, "subject {} at {}", self.subject, pairs.join(", "))
    }
}

impl Observations {
    /// No values yet, of these factors.
    #[must_use]
    pub fn new(factors: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { factors: factors.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// One more value; `levels` are given in the factors' order.
    pub fn push(
        &mut self,
        subject: impl Into<String>,
        levels: impl IntoIterator<Item = impl Into<String>>,
        value: f64,
    ) -> &mut Self {
        let levels = levels.into_iter().map(Into::into).collect();
        self.rows.push(Observation { subject: subject.into(), levels, value });
        self
    }

    /// The balanced table of these values. Subjects and levels keep the order of their first appearance.
    ///
    /// # Errors
    ///
    /// No factors or two of one name, no observations, a wrong number of levels, values that are not finite (or beyond
    /// ±1e150), several values in a cell, missing cells (all of them), a factor with one level, fewer than two subjects.
    pub fn table(&self, replicates: Replicates, missing: Missing) -> Result<Table, AnovaError> {
        table::check_names(&self.factors)?;
        if self.rows.is_empty() {
            return Err(AnovaError::NoObservations);
        }
        // Number subjects and levels.
        let mut subjects = Names::default();
        let mut levels: Vec<Names> = self.factors.iter().map(|_| Names::default()).collect();
        let mut places: Vec<(usize, usize)> = Vec::with_capacity(self.rows.len());
        for (index, row) in self.rows.iter().enumerate() {
            if row.levels.len() != self.factors.len() {
                let (subject, expected, found) = (row.subject.clone(), self.factors.len(), row.levels.len());
                return Err(AnovaError::LevelCount { index, subject, expected, found });
            }
            for (names, level) in levels.iter_mut().zip(&row.levels) {
                names.number(level);
            }
            places.push((subjects.number(&row.subject), 0));
        }
        let factors: Vec<Factor> = self
            .factors
            .iter()
            .zip(&levels)
            .map(|(name, levels)| Factor { name: name.clone(), levels: levels.owned() })
            .collect();
        let cells = cell_count(&factors, subjects.list.len())?;
        for (place, row) in places.iter_mut().zip(&self.rows) {
            place.1 = levels.iter_mut().zip(&row.levels).fold(0, |cell, (names, level)| {
                let number = names.number(level);
                cell * names.list.len() + number
            });
        }

        // Fill the cells.
        let mut sums = vec![(0.0, 0u32); subjects.list.len() * cells];
        for (&(subject, cell), row) in places.iter().zip(&self.rows) {
            let at = || table::cell_name(&factors, cell);
            if row.value.abs() > table::LARGEST || !row.value.is_finite() {
                return Err(AnovaError::Value { subject: row.subject.clone(), cell: at(), value: row.value });
            }
            let (sum, n) = &mut sums[subject * cells + cell];
            if *n > 0 && replicates == Replicates::Refuse {
                return Err(AnovaError::Duplicate { subject: row.subject.clone(), cell: at() });
            }
            *sum += row.value;
            *n += 1;
        }

        // Name what is missing.
        let mut absent = Vec::new();
        let mut values = Vec::with_capacity(sums.len());
        let mut kept = Vec::new();
        for (subject, row) in subjects.list.iter().zip(sums.chunks(cells)) {
            let before = absent.len();
            for (cell, _) in row.iter().enumerate().filter(|(_, (_, n))| *n == 0) {
                absent.push(MissingCell { subject: (*subject).to_owned(), cell: table::cell_levels(&factors, cell) });
            }
            if absent.len() == before {
                kept.push((*subject).to_owned());
                values.extend(row.iter().map(|(sum, n)| sum / f64::from(*n)));
            }
        }
        if !absent.is_empty() && missing == Missing::Refuse {
            return Err(AnovaError::MissingCells { cells: absent });
        }
        Table::build(factors, kept, values, absent)
    }
}

/// Names in the order of their first appearance.
#[derive(Default)]
struct Names<'a> {
    list: Vec<&'a str>,
    numbers: HashMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    /// Few names are found faster by looking at all of them.
    const FEW: usize = 16;

    fn number(&mut self, name: &'a str) -> usize {
        if self.list.len() <= Self::FEW {
            if let Some(number) = self.list.iter().position(|known| *known == name) {
                return number;
            }
        } else if let Some(number) = self.numbers.get(name) {
            return *number;
        }
        self.list.push(name);
        self.numbers.insert(name, self.list.len() - 1);
        self.list.len() - 1
    }

    fn owned(&self) -> Vec<String> {
        self.list.iter().map(|name| (*name).to_owned()).collect()
    }
}
