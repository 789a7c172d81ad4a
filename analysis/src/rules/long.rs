//! Measurements in the long form that analyses of variance take: one row for each measurement, with its subject and the
//! level of each factor.

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// One measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LongRow {
    /// The subject's code.
    pub subject: String,
    /// Factor → level.
    pub factors: BTreeMap<String, String>,
    /// What was measured.
    pub value: f64,
}

/// A table in long form.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LongTable {
    /// What was measured.
    pub measure: String,
    /// The measurements.
    pub rows: Vec<LongRow>,
}

impl LongTable {
    /// The subjects, in alphabetical order.
    #[must_use]
    pub fn subjects(&self) -> Vec<&str> {
        let subjects: BTreeSet<&str> = self.rows.iter().map(|row| row.subject.as_str()).collect();
        subjects.into_iter().collect()
    }

    /// The levels of each factor, in alphabetical order.
    #[must_use]
    pub fn levels(&self) -> BTreeMap<&str, Vec<&str>> {
        let mut levels = BTreeMap::<&str, BTreeSet<&str>>::new();
        for (factor, level) in self.rows.iter().flat_map(|row| &row.factors) {
            levels.entry(factor).or_default().insert(level);
        }
        levels.into_iter().map(|(factor, levels)| (factor, levels.into_iter().collect())).collect()
    }

    /// Each subject's mean in each cell of the design, which is what a repeated-measures analysis takes where a cell was
    /// shown more than once; ordered by subject, then cell. Values that are not finite are left out.
    #[must_use]
    pub fn cell_means(&self) -> Self {
        let mut cells = BTreeMap::<(&String, &BTreeMap<String, String>), (f64, usize)>::new();
        for row in self.rows.iter().filter(|row| row.value.is_finite()) {
            let cell = cells.entry((&row.subject, &row.factors)).or_insert((0.0, 0));
            cell.0 += row.value;
            cell.1 += 1;
        }
        let rows = cells
            .into_iter()
            .map(|((subject, factors), (sum, n))| LongRow {
                subject: subject.clone(),
                factors: factors.clone(),
                value: sum / n as f64,
            })
            .collect();
        Self { measure: self.measure.clone(), rows }
    }

    /// The subjects' cells without any measurement, out of all combinations of the levels: what keeps a design from being
    /// complete. At most `most` are listed.
    #[must_use]
    pub fn missing(&self, most: usize) -> Vec<(String, BTreeMap<String, String>)> {
        let levels = self.levels();
        let present: BTreeSet<(&str, BTreeMap<&str, &str>)> = self
            .rows
            .iter()
            .map(|row| {
                let cell = row.factors.iter().map(|(factor, level)| (factor.as_str(), level.as_str()));
                (row.subject.as_str(), cell.collect())
            })
            .collect();
        let mut missing = Vec::new();
        for subject in self.subjects() {
            // Count through the cells as an odometer does, so that nothing is built that is not asked for.
            let mut at = vec![0; levels.len()];
            loop {
                let cell: BTreeMap<&str, &str> =
                    levels.iter().zip(&at).map(|((factor, levels), &i)| (*factor, levels[i])).collect();
                if !present.contains(&(subject, cell.clone())) {
                    if missing.len() == most {
                        return missing;
                    }
                    let owned = cell.into_iter().map(|(factor, level)| (factor.to_owned(), level.to_owned()));
                    missing.push((subject.to_owned(), owned.collect()));
                }
                let turned = levels.values().zip(&mut at).find_map(|(levels, i)| {
                    *i += 1;
                    if *i < levels.len() {
                        return Some(());
                    }
                    *i = 0;
                    None
                });
                if turned.is_none() {
                    break;
                }
            }
        }
        missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(subject: &str, scene: &str, region: &str, value: f64) -> LongRow {
        let factors = [("scene", scene), ("region", region)].map(|(f, l)| (f.to_owned(), l.to_owned()));
        LongRow { subject: subject.to_owned(), factors: BTreeMap::from(factors), value }
    }

    #[test]
    fn repeated_cells_are_averaged_and_missing_ones_named() {
        let rows = vec![
            row("B", "x", "small", -1.0),
            row("A", "x", "small", 1.0),
            row("A", "x", "small", 2.0),
            row("A", "y", "full", 3.0),
            row("A", "y", "full", f64::NAN),
            row("B", "y", "small", 0.0),
        ];
        let table = LongTable { measure: "free-of-artifacts".to_owned(), rows };
        assert_eq!(table.subjects(), ["A", "B"]);
        assert_eq!(table.levels()["region"], ["full", "small"]);
        let means: Vec<f64> = table.cell_means().rows.iter().map(|row| row.value).collect();
        // Within a subject by cell: (full, y) comes before (small, x).
        assert_eq!(means, [3.0, 1.5, -1.0, 0.0]);
        // 2 subjects × 4 cells, four of which were measured.
        assert_eq!(table.missing(9).len(), 4);
        assert_eq!(table.missing(1)[0].1, row("A", "x", "full", 0.0).factors);
        assert!(table.missing(0).is_empty());
        let empty = LongTable { measure: String::new(), rows: Vec::new() };
        assert!(empty.missing(3).is_empty() && empty.cell_means().rows.is_empty());
    }
}
