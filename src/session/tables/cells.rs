//! Cells of a line, written and read. Our tables need no quotes: their cells are numbers and plain words.

use std::fmt::Write as _;
use std::str::FromStr;

/// A line being written, cell by cell.
#[derive(Debug, Default)]
pub struct Line {
    text: String,
    cells: usize,
}

impl Line {
    fn next(&mut self) -> &mut String {
        if self.cells > 0 {
            self.text.push(',');
        }
        self.cells += 1;
        &mut self.text
    }

    pub(super) fn text(&mut self, text: &str) {
        self.next().push_str(text);
    }

    pub(super) fn whole(&mut self, value: u64) {
        // Writing to a string cannot fail.
        let _ = write!(self.next(), "{value}");
    }

    pub(super) fn maybe_whole(&mut self, value: Option<u64>) {
        match value {
            Some(value) => self.whole(value),
            None => self.text(""),
        }
    }

    /// The shortest text that reads back as the same number; empty for what is not a number.
    pub(super) fn real(&mut self, value: f64) {
        let text = self.next();
        if value.is_finite() {
            let _ = write!(text, "{value}");
        }
    }

    pub(super) fn maybe_real(&mut self, value: Option<f64>) {
        self.real(value.unwrap_or(f64::NAN));
    }

    /// Booleans are 0 and 1, which R and pandas read as numbers.
    pub(super) fn bit(&mut self, value: bool) {
        self.whole(u64::from(value));
    }

    pub(super) fn into_text(self) -> String {
        self.text
    }
}

/// A line being read, cell by cell, with the names of its columns for messages.
#[derive(Debug)]
pub struct Cells<'a> {
    cells: std::str::Split<'a, char>,
    columns: &'static [&'static str],
    next: usize,
    /// How many columns this file has: columns that it lacks read as empty.
    present: usize,
}

impl<'a> Cells<'a> {
    pub(super) fn new(line: &'a str, columns: &'static [&'static str], present: usize) -> Self {
        Self { cells: line.split(','), columns, next: 0, present }
    }

    pub(super) fn text(&mut self) -> Result<&'a str, String> {
        let at = self.next;
        self.next += 1;
        if at >= self.present {
            return Ok("");
        }
        self.cells.next().ok_or_else(|| format!("expected {} columns, found {at}", self.present))
    }

    fn parsed<T: FromStr>(&mut self, expected: &str) -> Result<T, String> {
        self.maybe(expected)?.ok_or_else(|| self.problem(expected, ""))
    }

    fn maybe<T: FromStr>(&mut self, expected: &str) -> Result<Option<T>, String> {
        match self.text()? {
            "" => Ok(None),
            text => text.parse().map(Some).map_err(|_| self.problem(expected, text)),
        }
    }

    /// A message about the cell that was read last.
    pub(super) fn problem(&self, expected: &str, found: &str) -> String {
        let column = self.columns.get(self.next.wrapping_sub(1)).copied().unwrap_or_default();
        format!("column {column}: expected {expected}, found \"{found}\"")
    }

    pub(super) fn whole(&mut self) -> Result<u64, String> {
        self.parsed("a whole number")
    }

    pub(super) fn maybe_whole(&mut self) -> Result<Option<u64>, String> {
        self.maybe("a whole number or nothing")
    }

    pub(super) fn real(&mut self) -> Result<f64, String> {
        let value = self.parsed::<f64>("a number")?;
        if value.is_finite() { Ok(value) } else { Err(self.problem("a finite number", &value.to_string())) }
    }

    pub(super) fn maybe_real(&mut self) -> Result<Option<f64>, String> {
        let value = self.maybe::<f64>("a number or nothing")?;
        if value.is_none_or(f64::is_finite) {
            Ok(value)
        } else {
            Err(self.problem("a finite number or nothing", &format!("{value:?}")))
        }
    }

    pub(super) fn bit(&mut self) -> Result<bool, String> {
        match self.text()? {
            "0" => Ok(false),
            "1" => Ok(true),
            other => Err(self.problem("0 or 1", other)),
        }
    }

    /// Nothing may follow.
    pub(super) fn end(mut self) -> Result<(), String> {
        match self.cells.next() {
            None => Ok(()),
            Some(_) => Err(format!("expected {} columns, found more", self.present)),
        }
    }
}
