//! What is wrong with a file: every mistake with its place, its field and what was expected.
//!
//! [`Report`] collects while a file is read; [`Mistakes`] is what the caller gets. Neither prints: the lab shows them
//! with the text around them.

use super::source::{Field, Source};
use std::fmt;
use std::ops::Range;

/// One mistake in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// Bytes of the text that are at fault; for a missing key, the place of the object that lacks it.
    pub span: Range<usize>,
    /// Line of the span's start, from 1.
    pub line: usize,
    /// Column of the span's start in characters, from 1.
    pub column: usize,
    /// The field, as `blocks[1].procedure.mar.min`; empty for the file as a whole.
    pub field: String,
    /// What was expected and what was found.
    pub message: String,
}

/// Everything that is wrong with one file, in the order of its lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistakes {
    /// The file's name, as given by the caller.
    pub file: String,
    /// The file's text, to show the lines at fault.
    pub text: String,
    /// The mistakes, sorted by place; never empty.
    pub list: Vec<Mistake>,
}

impl std::error::Error for Mistakes {}

impl fmt::Display for Mistakes {
    /// One line a mistake: `file:line:column: field: expected …, found …`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, mistake) in self.list.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{}:{}:{}: ", self.file, mistake.line, mistake.column)?;
            if !mistake.field.is_empty() {
                write!(f, "{}: ", mistake.field)?;
            }
            write!(f, "{}", mistake.message)?;
        }
        Ok(())
    }
}

/// Collects the mistakes of one file.
#[derive(Debug)]
pub(super) struct Report<'s> {
    source: &'s Source,
    list: Vec<Mistake>,
}

impl<'s> Report<'s> {
    pub(super) fn new(source: &'s Source) -> Self {
        Self { source, list: Vec::new() }
    }

    /// A mistake at a field's value or, if the field is not in the file, at the object that should hold it.
    pub(super) fn at(&mut self, field: &Field, message: impl Into<String>) {
        let span = self.source.value_span(field);
        self.push(span, field, message.into());
    }

    /// A mistake at a field's key.
    pub(super) fn at_key(&mut self, field: &Field, message: impl Into<String>) {
        let span = self.source.key_span(field);
        self.push(span, field, message.into());
    }

    /// A mistake at bytes of the text.
    pub(super) fn at_span(&mut self, span: Range<usize>, field: &Field, message: impl Into<String>) {
        self.push(span, field, message.into());
    }

    /// Whether something has been said about a field or a part of it.
    pub(super) fn has(&self, field: &Field) -> bool {
        let name = field.to_string();
        let is_within =
            |other: &str| other.strip_prefix(&name).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']));
        self.list.iter().any(|mistake| is_within(&mistake.field))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The number of mistakes so far.
    pub(super) fn count(&self) -> usize {
        self.list.len()
    }

    /// The collected mistakes in the order of the file.
    pub(super) fn into_mistakes(mut self, file: &str, text: &str) -> Mistakes {
        self.list.sort_by(|a, b| (a.span.start, &a.field).cmp(&(b.span.start, &b.field)));
        self.list.dedup();
        Mistakes { file: file.to_owned(), text: text.to_owned(), list: self.list }
    }

    fn push(&mut self, span: Range<usize>, field: &Field, message: String) {
        let (line, column) = self.source.line_and_column(span.start);
        self.list.push(Mistake { span, line, column, field: field.to_string(), message });
    }
}

/// `; did you mean "x"?` for the candidate that is nearest to `word`, or nothing when none is near.
pub(crate) fn suggestion<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let length = word.chars().count();
    let reach = length.div_ceil(3);
    // A name that was not finished is as near as one with one letter wrong.
    let distance = |candidate: &str| match length >= 3 && candidate.starts_with(word) {
        true => 1,
        false => edit_distance(word, candidate),
    };
    candidates
        .into_iter()
        .map(|candidate| (distance(candidate), candidate))
        .filter(|&(distance, _)| distance <= reach)
        .min_by_key(|&(distance, _)| distance)
        .map_or_else(String::new, |(_, candidate)| format!("; did you mean \"{candidate}\"?"))
}

/// Insertions, deletions, replacements and swaps of neighbours that lead from one word to another (optimal string
/// alignment). Words longer than any name of ours are far from everything.
fn edit_distance(a: &str, b: &str) -> usize {
    const LONGEST: usize = 64;
    let (a, b): (Vec<char>, Vec<char>) = (a.to_lowercase().chars().collect(), b.to_lowercase().chars().collect());
    if a.len() > LONGEST || b.len() > LONGEST {
        return usize::MAX;
    }
    let mut before_last = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                let swapped: &Vec<usize> = &before_last;
                best = best.min(swapped[j - 2] + 1);
            }
            row.push(best);
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_suggested_and_far_ones_are_not() {
        let names = ["fixation_s", "interval_s", "gap_s"];
        assert_eq!(suggestion("fixaton_s", names), "; did you mean \"fixation_s\"?");
        assert_eq!(suggestion("intreval_s", names), "; did you mean \"interval_s\"?");
        assert_eq!(suggestion("foto", ["noise", "photo"]), "; did you mean \"photo\"?");
        assert_eq!(suggestion("quest", ["constant", "quest-plus"]), "; did you mean \"quest-plus\"?");
        assert_eq!(suggestion("colour", names), "");
        assert_eq!(suggestion(&"x".repeat(1000), names), "");
        assert_eq!(suggestion("", names), "");
    }

    #[test]
    fn distances_are_those_of_the_textbook() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("ab", "ba"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
    }
}
