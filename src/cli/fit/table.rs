//! Reading a table of answers, with every mistake at its line and column.

use crate::mistakes::{CsvMistake, Mistakes};
use analysis::psychometric::Count;

/// Which columns hold what.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// The level.
    pub(super) level: String,
    /// How many answers a row stands for.
    pub(super) n: String,
    /// How many of them were right.
    pub(super) k: String,
    /// Right or wrong, in a table with one answer a row.
    pub(super) correct: String,
    /// What tells one function's rows from another's.
    pub(super) group: Vec<String>,
}

/// The rows of one function.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    /// The values of the group's columns.
    pub(super) values: Vec<String>,
    /// Its rows.
    pub(super) counts: Vec<Count>,
}

/// Where the right answers of a row are.
enum Answers {
    Counted { n: usize, k: usize },
    Single { correct: usize },
}

/// Reads the whole text; groups in the order in which they first appear.
pub(super) fn read(file: &str, text: &str, columns: &Columns) -> Result<Vec<Group>, Vec<CsvMistake>> {
    let mut mistakes = Mistakes::of(file);
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = csv::ReaderBuilder::new()
        .flexible(true)
        .delimiter(delimiter(text))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = match reader.headers() {
        Ok(header) if header.iter().any(|name| !name.is_empty()) => header.clone(),
        Ok(_) => {
            mistakes.add(1, "header", "column names such as level,n,k", "an empty line");
            return Err(mistakes.all());
        }
        Err(error) => {
            mistakes.add(1, "header", "column names such as level,n,k", error);
            return Err(mistakes.all());
        }
    };
    let Some((level, answers, group)) = find(&header, columns, &mut mistakes) else {
        return Err(mistakes.all());
    };

    let mut groups: Vec<Group> = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                mistakes.add(index as u64 + 2, "row", "comma-separated values", error);
                continue;
            }
        };
        let line = record.position().map_or(index as u64 + 2, csv::Position::line);
        if record.len() != header.len() {
            mistakes.add(line, "row", format!("{} values", header.len()), record.len());
            continue;
        }
        let mut row = Row { header: &header, record: &record, line, mistakes: &mut mistakes };
        if let Some(count) = row.count(level, &answers) {
            let values: Vec<String> = group.iter().map(|&index| record[index].to_owned()).collect();
            match groups.iter_mut().find(|group| group.values == values) {
                Some(group) => group.counts.push(count),
                None => groups.push(Group { values, counts: vec![count] }),
            }
        }
    }
    if groups.is_empty() && mistakes.none() {
        mistakes.add(2, "row", "at least one row of answers", "none");
    }
    if mistakes.none() { Ok(groups) } else { Err(mistakes.all()) }
}

/// Comma, or the tab or semicolon that the first line has instead.
fn delimiter(text: &str) -> u8 {
    let first = text.lines().next().unwrap_or_default();
    match (first.contains(','), first.contains('\t'), first.contains(';')) {
        (_, true, _) => b'\t',
        (false, _, true) => b';',
        _ => b',',
    }
}

fn find(
    header: &csv::StringRecord,
    columns: &Columns,
    mistakes: &mut Mistakes<'_>,
) -> Option<(usize, Answers, Vec<usize>)> {
    let there: Vec<&str> = header.iter().collect();
    let found = there.join(",");
    for (index, name) in there.iter().enumerate() {
        if !name.is_empty() && there[..index].contains(name) {
            mistakes.add(1, name, "each column once", "it twice");
        }
    }
    let place = |name: &str| there.iter().position(|there| *there == name);
    let level = place(&columns.level);
    if level.is_none() {
        mistakes.add(1, &columns.level, "a column of levels (another name: --level NAME)", &found);
    }
    let answers = match (place(&columns.n), place(&columns.k), place(&columns.correct)) {
        (Some(n), Some(k), _) => Some(Answers::Counted { n, k }),
        (None, None, Some(correct)) => Some(Answers::Single { correct }),
        (n, k, _) => {
            if n.is_none() {
                let expected = "a column of numbers of answers (another name: --n NAME)";
                mistakes.add(1, &columns.n, expected, &found);
            }
            if k.is_none() {
                let expected = format!(
                    "a column of numbers of right answers (another name: --k NAME), or `{}` with one answer a row",
                    columns.correct
                );
                mistakes.add(1, &columns.k, expected, &found);
            }
            None
        }
    };
    let mut group = Vec::new();
    for name in &columns.group {
        match place(name) {
            Some(index) => group.push(index),
            None => mistakes.add(1, name, "a column to group by (--group)", &found),
        }
    }
    let answers = answers.filter(|_| mistakes.none())?;
    Some((level?, answers, group))
}

/// One row while it is read.
struct Row<'a, 'b> {
    header: &'a csv::StringRecord,
    record: &'a csv::StringRecord,
    line: u64,
    mistakes: &'a mut Mistakes<'b>,
}

impl Row<'_, '_> {
    fn count(&mut self, level: usize, answers: &Answers) -> Option<Count> {
        let level = self.value(level, "a finite number", |text| text.parse::<f64>().ok().filter(|x| x.is_finite()));
        match *answers {
            Answers::Counted { n, k } => {
                let whole = "a whole number, 0 or more";
                let (n_place, k_place) = (n, k);
                let (n, k) = (self.value(n, whole, count), self.value(k, whole, count));
                let (level, n, k) = (level?, n?, k?);
                if k > n {
                    let expected = format!("at most {} ({})", n, &self.header[n_place]);
                    self.mistakes.add(self.line, &self.header[k_place], expected, k);
                    return None;
                }
                Some(Count { level, n, k })
            }
            Answers::Single { correct } => {
                let right =
                    self.value(correct, "1, 0, true or false", |text| match text.to_ascii_lowercase().as_str() {
                        "1" | "true" => Some(1),
                        "0" | "false" => Some(0),
                        _ => None,
                    });
                Some(Count { level: level?, n: 1, k: right? })
            }
        }
    }

    fn value<T>(&mut self, index: usize, expected: &str, read: impl Fn(&str) -> Option<T>) -> Option<T> {
        let text = &self.record[index];
        let value = read(text);
        if value.is_none() {
            let found = if text.is_empty() { "nothing" } else { text };
            self.mistakes.add(self.line, &self.header[index], expected, found);
        }
        value
    }
}

/// A count, also one that a spreadsheet wrote as 19.0.
fn count(text: &str) -> Option<u32> {
    let value = text.parse::<f64>().ok()?;
    (value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn columns(group: &[&str]) -> Columns {
        Columns {
            level: "level".to_owned(),
            n: "n".to_owned(),
            k: "k".to_owned(),
            correct: "correct".to_owned(),
            group: group.iter().map(|name| (*name).to_owned()).collect(),
        }
    }

    fn errors(text: &str, group: &[&str]) -> Vec<String> {
        read("data.csv", text, &columns(group)).unwrap_err().iter().map(ToString::to_string).collect()
    }

    #[test]
    fn counts_single_answers_and_other_separators_are_read() {
        let counted = read("", "\u{feff}k, level ,n\n3,0.5,4\n4.0,1,4\n", &columns(&[])).unwrap();
        assert_eq!(counted[0].counts, [Count { level: 0.5, n: 4, k: 3 }, Count { level: 1.0, n: 4, k: 4 }]);
        let single = read("", "who;level;correct\na;1;1\nb;1;false\na;2;0\n", &columns(&["who"])).unwrap();
        assert_eq!(single.len(), 2);
        assert_eq!((single[0].values[0].as_str(), single[0].counts.len()), ("a", 2));
        assert_eq!(single[1].counts, [Count { level: 1.0, n: 1, k: 0 }]);
        assert_eq!(read("", "level\tn\tk\n1\t2\t0\n", &columns(&[])).unwrap()[0].counts[0].n, 2);
    }

    #[test]
    fn every_mistake_is_at_its_line() {
        let found = errors("level,n,k\n1,4,5\nx,4.5,-1\n2,4\n3,,4\n", &[]);
        assert_eq!(
            found,
            [
                "data.csv:2: k: expected at most 4 (n), found 5",
                "data.csv:3: level: expected a finite number, found x",
                "data.csv:3: n: expected a whole number, 0 or more, found 4.5",
                "data.csv:3: k: expected a whole number, 0 or more, found -1",
                "data.csv:4: row: expected 3 values, found 2",
                "data.csv:5: n: expected a whole number, 0 or more, found nothing",
            ]
        );
        let found = errors("x,y\n1,2\n", &["who"]);
        assert_eq!(found.len(), 4, "{found:?}");
        assert!(found[0].contains("--level NAME") && found[3].contains("--group"), "{found:?}");
        assert_eq!(errors("level,n,k\n", &[]), ["data.csv:2: row: expected at least one row of answers, found none"]);
        assert_eq!(errors("", &[]).len(), 1);
        assert!(errors("level,level,n,k\n1,1,2,1\n", &[])[0].contains("it twice"));
    }
}
