//! Typed cells: what a table holds before it is CSV, Parquet or anything else.

use crate::error::LabError;
use std::borrow::Cow;

/// What a column's cells are. Any of them may be empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Whole numbers (64 bits).
    Integer,
    /// Numbers (double precision).
    Real,
    /// True or false; 0 and 1 in text files.
    Boolean,
    /// Text (UTF-8).
    Text,
}

/// One cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell<'a> {
    /// Nothing: not known, or without a meaning in this row.
    Empty,
    /// A whole number.
    Integer(i64),
    /// A number; one that is not finite is written as empty.
    Real(f64),
    /// True or false.
    Boolean(bool),
    /// A text; an empty one is written as empty.
    Text(Cow<'a, str>),
}

impl Cell<'_> {
    /// The cell as text files have it: the shortest text that reads back as the same number, 0 or 1, nothing for empty.
    #[must_use]
    pub fn text(&self) -> Cow<'_, str> {
        match self {
            Self::Empty => Cow::Borrowed(""),
            Self::Integer(value) => Cow::Owned(value.to_string()),
            Self::Real(value) if value.is_finite() => Cow::Owned(value.to_string()),
            Self::Real(_) => Cow::Borrowed(""),
            Self::Boolean(value) => Cow::Borrowed(if *value { "1" } else { "0" }),
            Self::Text(text) => Cow::Borrowed(text),
        }
    }
}

impl<'a> From<&'a str> for Cell<'a> {
    fn from(text: &'a str) -> Self {
        if text.is_empty() { Self::Empty } else { Self::Text(Cow::Borrowed(text)) }
    }
}

impl From<String> for Cell<'_> {
    fn from(text: String) -> Self {
        if text.is_empty() { Self::Empty } else { Self::Text(Cow::Owned(text)) }
    }
}

impl From<f64> for Cell<'_> {
    fn from(value: f64) -> Self {
        if value.is_finite() { Self::Real(value) } else { Self::Empty }
    }
}

impl From<bool> for Cell<'_> {
    fn from(value: bool) -> Self {
        Self::Boolean(value)
    }
}

impl From<u32> for Cell<'_> {
    fn from(value: u32) -> Self {
        Self::Integer(i64::from(value))
    }
}

impl From<u64> for Cell<'_> {
    fn from(value: u64) -> Self {
        // Counts: none comes near the end of 63 bits.
        Self::Integer(i64::try_from(value).unwrap_or(i64::MAX))
    }
}

impl From<usize> for Cell<'_> {
    fn from(value: usize) -> Self {
        Self::from(value as u64)
    }
}

impl<'a, T: Into<Cell<'a>>> From<Option<T>> for Cell<'a> {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

/// Where rows go.
pub trait Sink {
    /// Takes a row with a cell for every column.
    ///
    /// # Errors
    /// When it cannot be written.
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), LabError>;
}
