//! What can be wrong with a table in a text file, each mistake at its line and column.

use std::fmt;

/// Mistakes listed before the rest is only counted.
const MAX_LISTED: usize = 20;

/// What is wrong with a table.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CsvMistake {
    /// One mistake at its place.
    #[error("{file}:{line}: {column}: expected {expected}, found {found}")]
    At {
        /// The file, as the reader named it.
        file: String,
        /// Line in the file, from 1.
        line: u64,
        /// Name of the column; `header` or `row` where the whole line is at fault.
        column: String,
        /// What would have been accepted.
        expected: String,
        /// What was there.
        found: String,
    },
    /// The last of a long list.
    #[error("{file}: and {count} more")]
    More {
        /// The file, as the reader named it.
        file: String,
        /// How many mistakes are not listed.
        count: u64,
    },
}

/// Mistakes so far; the first are listed, the rest counted.
pub(crate) struct Mistakes<'a> {
    file: &'a str,
    listed: Vec<CsvMistake>,
    more: u64,
}

impl<'a> Mistakes<'a> {
    /// No mistakes yet in `file`.
    pub(crate) fn of(file: &'a str) -> Self {
        Self { file, listed: Vec::new(), more: 0 }
    }

    /// Whether there are none.
    pub(crate) fn none(&self) -> bool {
        self.listed.is_empty()
    }

    /// Those that are listed.
    pub(crate) fn listed(&self) -> &[CsvMistake] {
        &self.listed
    }

    /// Notes a mistake at its line (from 1) and column.
    pub(crate) fn add(&mut self, line: u64, column: &str, expected: impl Into<String>, found: impl fmt::Display) {
        if self.listed.len() == MAX_LISTED {
            self.more += 1;
            return;
        }
        self.listed.push(CsvMistake::At {
            file: self.file.to_owned(),
            line,
            column: column.to_owned(),
            expected: expected.into(),
            found: found.to_string(),
        });
    }

    /// The list, ended by a count where it was cut.
    pub(crate) fn all(mut self) -> Vec<CsvMistake> {
        if self.more > 0 {
            self.listed.push(CsvMistake::More { file: self.file.to_owned(), count: self.more });
        }
        self.listed
    }
}
