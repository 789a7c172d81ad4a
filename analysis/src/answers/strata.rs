//! Parts of a block: all trials, then the trials of each level of each factor, then those of each cell of the design.

use super::Row;
use std::collections::{BTreeMap, BTreeSet};

/// Rows that agree in some factors; no factors for all rows.
pub(super) struct Stratum<'a> {
    pub(super) by: BTreeMap<String, String>,
    pub(super) rows: Vec<&'a Row>,
}

/// Which parts there are besides the whole and the levels of the factors.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Parts<'a> {
    /// Each combination of factor levels that occurs, where there is more than one factor.
    pub(crate) cells: bool,
    /// The varying parameters of the level count as factors, with this before their names.
    pub(crate) level_prefix: Option<&'a str>,
}

/// The parts of a block.
pub(super) fn strata<'a>(rows: &'a [Row], parts: Parts<'_>) -> Vec<Stratum<'a>> {
    let all: Vec<&Row> = rows.iter().collect();
    let strata = strata_indices(&all, parts).into_iter();
    strata.map(|(by, indices)| Stratum { by, rows: indices.into_iter().map(|index| &rows[index]).collect() }).collect()
}

/// The parts of a block, each with the indices of its rows. Only factors of which more than one level occurs make parts;
/// where none does, the condition is a factor.
pub(crate) fn strata_indices(rows: &[&Row], parts: Parts<'_>) -> Vec<(BTreeMap<String, String>, Vec<usize>)> {
    let labels: Vec<BTreeMap<String, String>> = rows
        .iter()
        .map(|row| {
            let mut labels = row.factors.clone();
            if let Some(prefix) = parts.level_prefix {
                labels.extend(row.level.iter().map(|(name, value)| (format!("{prefix}{name}"), value.to_string())));
            }
            labels
        })
        .collect();
    let names: BTreeSet<&String> = labels.iter().flat_map(BTreeMap::keys).collect();
    let varying: Vec<&String> = names.into_iter().filter(|name| levels(&labels, name).len() > 1).collect();
    let indices = |is: &dyn Fn(usize) -> bool| (0..rows.len()).filter(|&index| is(index)).collect::<Vec<usize>>();

    let mut strata = vec![(BTreeMap::new(), indices(&|_| true))];
    if varying.is_empty() {
        let conditions: BTreeSet<&String> = rows.iter().map(|row| &row.condition).collect();
        if conditions.len() > 1 {
            strata.extend(conditions.into_iter().map(|condition| {
                let by = BTreeMap::from([("condition".to_owned(), condition.clone())]);
                (by, indices(&|index| rows[index].condition == *condition))
            }));
        }
        return strata;
    }
    for name in &varying {
        for level in levels(&labels, name) {
            let by = BTreeMap::from([((*name).clone(), level.clone())]);
            strata.push((by, indices(&|index| labels[index].get(*name) == Some(level))));
        }
    }
    if parts.cells && varying.len() > 1 {
        let mut cells: BTreeMap<BTreeMap<String, String>, Vec<usize>> = BTreeMap::new();
        for (index, labels) in labels.iter().enumerate() {
            let by = labels.iter().filter(|(name, _)| varying.contains(name));
            cells.entry(by.map(|(name, level)| (name.clone(), level.clone())).collect()).or_default().push(index);
        }
        strata.extend(cells);
    }
    strata
}

/// The levels of a factor, numbers in their order, other texts alphabetically.
fn levels<'a>(labels: &'a [BTreeMap<String, String>], name: &str) -> Vec<&'a String> {
    let found: BTreeSet<&String> = labels.iter().filter_map(|labels| labels.get(name)).collect();
    let mut levels: Vec<&String> = found.into_iter().collect();
    let number = |level: &String| level.parse::<f64>().ok();
    if levels.iter().all(|level| number(level).is_some()) {
        levels.sort_by(|a, b| number(a).unwrap_or(0.0).total_cmp(&number(b).unwrap_or(0.0)));
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::super::tests::row;
    use super::*;
    use experiments::trial::Answer;

    fn names(strata: &[Stratum<'_>]) -> Vec<(String, usize)> {
        strata.iter().map(|stratum| (super::super::part_name(&stratum.by), stratum.rows.len())).collect()
    }

    #[test]
    fn the_whole_then_levels_then_cells() {
        let cell =
            |scene, k| row(Answer::First, Some(true)).in_cell("scene", scene).in_cell("k", k).in_cell("one", "1");
        let rows = [cell("b", "10"), cell("a", "9"), cell("a", "10")];
        let all = strata(&rows, Parts { cells: true, level_prefix: None });
        let expected = [
            ("all trials", 3),
            ("k = 9", 1),
            ("k = 10", 2),
            ("scene = a", 2),
            ("scene = b", 1),
            ("k = 10, scene = a", 1),
            ("k = 10, scene = b", 1),
            ("k = 9, scene = a", 1),
        ]
        .map(|(name, rows)| (name.to_owned(), rows));
        assert_eq!(names(&all), expected);
        assert_eq!(names(&strata(&rows, Parts::default())), expected[..5]);
    }

    #[test]
    fn conditions_and_levels_can_be_parts() {
        let mut rows = [row(Answer::First, None).at("j", 4.0), row(Answer::First, None).at("j", 12.0)];
        let started = strata(&rows, Parts { cells: true, level_prefix: Some("start ") });
        assert_eq!(names(&started)[1..], [("start j = 4".to_owned(), 1), ("start j = 12".to_owned(), 1)]);
        rows[1].condition = "two".to_owned();
        assert_eq!(names(&strata(&rows, Parts::default()))[2], ("condition = two".to_owned(), 1));
    }
}
