//! Tab-separated rows as BIDS has them: `n/a` for what is not there, and no tab or line break within a cell.

use crate::export::cells::Cell;

/// A cell's text.
pub(super) fn cell(cell: &Cell<'_>) -> String {
    plain(&cell.text())
}

/// A text without tabs and line breaks; `n/a` for an empty one.
pub(super) fn plain(text: &str) -> String {
    let plain = text.split(['\t', '\n', '\r']).collect::<Vec<_>>().join(" ");
    if plain.trim().is_empty() { "n/a".to_owned() } else { plain }
}

/// A number, or `n/a` for what is none.
pub(super) fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { "n/a".to_owned() }
}

/// A difference of two times, rounded to nanoseconds: what lies below is what doubles lose in subtracting.
pub(super) fn duration(seconds: f64) -> String {
    number((seconds.max(0.0) * 1e9).round() / 1e9)
}

/// A line of cells.
pub(super) fn line<T: AsRef<str>>(cells: &[T]) -> String {
    let mut line = cells.iter().map(AsRef::as_ref).collect::<Vec<&str>>().join("\t");
    line.push('\n');
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cell_is_empty_or_breaks_its_line() {
        assert_eq!((plain("a\tb\r\nc"), plain(" \n")), ("a b  c".to_owned(), "n/a".to_owned()));
        assert_eq!(cell(&Cell::Real(f64::NAN)), "n/a");
        assert_eq!((cell(&Cell::Boolean(true)), number(f64::INFINITY)), ("1".to_owned(), "n/a".to_owned()));
        assert_eq!(line(&["a", "b"]), "a\tb\n");
        assert_eq!(
            (duration(4.404 - 4.4), duration(-1e-17), duration(f64::NAN)),
            ("0.004".into(), "0".into(), "0".into())
        );
    }
}
