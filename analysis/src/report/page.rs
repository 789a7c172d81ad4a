//! A page of sections: prose, tables that paste into a spreadsheet as numbers, figures, and the data as JSON.
//!
//! The building blocks of every page of ours. What a section says is up to whoever fills it; nothing is computed here.

use crate::mar::Estimate;
use crate::svg::escape;
use serde::{Deserialize, Serialize};

/// A cell of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// A number, in its column's unit; shown with three significant digits and copied in full. Not finite shows as missing.
    Number(f64),
    /// A text.
    Text(String),
    /// Nothing to say.
    Missing,
}

impl Cell {
    /// A number, or nothing.
    #[must_use]
    pub fn maybe(value: Option<f64>) -> Self {
        value.map_or(Self::Missing, Self::Number)
    }

    /// Estimate, low and high end of an interval: three cells.
    #[must_use]
    pub fn estimate(estimate: &Estimate) -> [Self; 3] {
        [estimate.estimate, estimate.ci95[0], estimate.ci95[1]].map(Self::Number)
    }

    /// Three cells of an estimate that may be missing.
    #[must_use]
    pub fn maybe_estimate(estimate: Option<&Estimate>) -> [Self; 3] {
        estimate.map_or([Self::Missing, Self::Missing, Self::Missing], Self::estimate)
    }

    /// Low and high end of an interval that may be missing: two cells.
    #[must_use]
    pub fn interval(interval: Option<[f64; 2]>) -> [Self; 2] {
        interval.map_or([Self::Missing, Self::Missing], |ends| ends.map(Self::Number))
    }

    /// A share as a percentage: the column's unit is then %.
    #[must_use]
    pub fn percent(share: Option<f64>) -> Self {
        Self::maybe(share.map(|share| 100.0 * share))
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Number(value as f64)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

/// A table: real rows and columns, one number in a cell, units in the header.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// What it holds.
    pub caption: String,
    /// The columns' names, each with its unit in parentheses.
    pub columns: Vec<String>,
    /// The rows, one cell for each column; the first cell names its row.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new(caption: impl Into<String>, columns: &[&str]) -> Self {
        Self {
            caption: caption.into(),
            columns: columns.iter().map(|column| (*column).to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        self.rows.push(row.into_iter().collect());
    }

    /// The table as HTML, everything escaped.
    #[must_use]
    pub fn html(&self) -> String {
        let mut html =
            format!("<div class=\"table\"><table>\n<caption>{}</caption>\n<thead><tr>", escape(&self.caption));
        // A column of texts is set like text.
        let texts: Vec<bool> = (0..self.columns.len())
            .map(|i| {
                let mut cells = self.rows.iter().filter_map(|row| row.get(i)).filter(|cell| **cell != Cell::Missing);
                cells.next().is_some_and(|cell| matches!(cell, Cell::Text(_)))
                    && cells.all(|cell| matches!(cell, Cell::Text(_)))
            })
            .collect();
        let class = |i: usize| if i > 0 && texts.get(i) == Some(&true) { " class=\"text\"" } else { "" };
        for (i, column) in self.columns.iter().enumerate() {
            html.push_str(&format!("<th scope=\"col\"{}>{}</th>", class(i), escape(column)));
        }
        html.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            html.push_str("<tr>");
            for (i, cell) in row.iter().enumerate().take(self.columns.len()) {
                let (tag, scope) = if i == 0 { ("th", " scope=\"row\"") } else { ("td", "") };
                let class = class(i);
                html.push_str(&match cell {
                    Cell::Number(value) if value.is_finite() => {
                        // Adding 0 turns −0 into 0.
                        let value = value + 0.0;
                        format!("<{tag}{scope} data-v=\"{value}\">{}</{tag}>", shown(value))
                    }
                    Cell::Text(text) => format!("<{tag}{scope}{class}>{}</{tag}>", escape(text)),
                    Cell::Number(_) | Cell::Missing => format!("<{tag}{scope}{class}></{tag}>"),
                });
            }
            // Rows that are too short are filled, so that columns stay under their names.
            (row.len()..self.columns.len()).for_each(|_| html.push_str("<td></td>"));
            html.push_str("</tr>\n");
        }
        html.push_str("</tbody>\n</table></div>\n");
        html
    }
}

/// A number as spreadsheets read it: digits, a point and a hyphen for minus.
fn shown(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e9 {
        return format!("{value}");
    }
    crate::text::significant(value, 3).replace('−', "-")
}

/// A figure with its caption.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// An SVG document as [`crate::figures`] makes it; it enters the page as it is.
    pub svg: String,
    /// What it shows; escaped.
    pub caption: String,
}

/// A part of a page under its own heading.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// The heading.
    pub title: String,
    /// Paragraphs; escaped.
    pub prose: Vec<String>,
    /// What a reader must see first, for example why data do not support a fit; escaped, set apart.
    pub warnings: Vec<String>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Figures, below the tables.
    pub figures: Vec<Figure>,
}

impl Section {
    /// A section without anything in it.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// The section as HTML; one without any content is left out.
    #[must_use]
    pub fn html(&self) -> String {
        let Self { prose, warnings, tables, figures, .. } = self;
        if prose.is_empty() && warnings.is_empty() && tables.is_empty() && figures.is_empty() {
            return String::new();
        }
        let mut html = format!("<section>\n<h2>{}</h2>\n", escape(&self.title));
        if !warnings.is_empty() {
            let list: String = warnings.iter().map(|text| format!("<li>{}</li>\n", escape(text))).collect();
            html.push_str(&format!("<aside class=\"unsupported\" role=\"note\">\n<ul>\n{list}</ul>\n</aside>\n"));
        }
        prose.iter().for_each(|text| html.push_str(&format!("<p>{}</p>\n", escape(text))));
        tables.iter().for_each(|table| html.push_str(&table.html()));
        figures.iter().for_each(|figure| html.push_str(&crate::text::figure(&figure.svg, &figure.caption)));
        html + "</section>\n"
    }
}

/// Puts a button above every table that copies it as tab-separated values with full precision. Without script there are
/// no buttons, and the tables are as they are.
const COPY_SCRIPT: &str = include_str!("copy.js");

/// One self-contained page: a title, sections, and the data as JSON in the element `parafovea-analysis`.
///
/// ```
/// use analysis::report::{Cell, Section, Table, page};
/// let mut table = Table::new("Parameters.", &["Parameter", "Estimate", "2.5 %", "97.5 %"]);
/// table.push([Cell::from("Threshold (°)"), 0.021.into(), 0.018.into(), 0.025.into()]);
/// let section = Section { tables: vec![table], ..Section::new("Fit") };
/// let html = page("A fit", &[section], &serde_json::json!({ "threshold": 0.021 }));
/// assert!(html.contains("<td data-v=\"0.018\">0.0180</td>"));
/// ```
#[must_use]
pub fn page(title: &str, sections: &[Section], json: &serde_json::Value) -> String {
    let mut body = format!("<header>\n<h1>{}</h1>\n</header>\n", escape(title));
    sections.iter().for_each(|section| body.push_str(&section.html()));
    document(title, None, &body, json)
}

/// The whole document around the body of its `main` element; `generator` names the program.
pub(super) fn document(title: &str, generator: Option<&str>, body: &str, json: &serde_json::Value) -> String {
    // `<` never appears in the data block, so no string can close it.
    let json = json.to_string().replace('<', "\\u003c");
    let generator =
        generator.map_or_else(String::new, |name| format!("<meta name=\"generator\" content=\"{}\">\n", escape(name)));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n{generator}<title>{}</title>\n<style>\n{}\
         </style>\n</head>\n<body>\n<main>\n{body}</main>\n\
         <script type=\"application/json\" id=\"parafovea-analysis\">{json}</script>\n\
         <script>\n{COPY_SCRIPT}</script>\n</body>\n</html>\n",
        escape(title),
        include_str!("style.css"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_escape_what_they_hold_and_keep_numbers_plain() {
        let mut table = Table::new("<c>", &["a&b", "x", "y", "z"]);
        table.push(["<script>".into(), Cell::from(-0.020_833_333), f64::NAN.into(), Cell::from(1_234_567usize)]);
        table.push([Cell::from(-0.0), "a \"note\"".into()]);
        let html = table.html();
        assert!(!html.contains("<script>") && html.contains("&lt;c&gt;") && html.contains("a&amp;b"));
        // What is shown is what a spreadsheet reads: a hyphen, a point, no separators, one number in a cell.
        assert!(
            html.contains("<td data-v=\"-0.020833333\">-0.0208</td><td></td><td data-v=\"1234567\">1234567</td>"),
            "{html}"
        );
        assert!(
            html.contains("<th scope=\"row\" data-v=\"0\">0</th><td>a &quot;note&quot;</td><td></td><td></td>"),
            "{html}"
        );
    }

    #[test]
    fn a_page_is_one_document_whatever_it_is_given() {
        let hostile = "</script><script>alert(1)</script>\"'&<";
        let mut table = Table::new(hostile, &[hostile]);
        table.push([Cell::from(hostile)]);
        let section = Section {
            prose: vec![hostile.to_owned()],
            warnings: vec![hostile.to_owned()],
            tables: vec![table],
            ..Section::new(hostile)
        };
        let json = serde_json::json!({ hostile: hostile });
        let html = page(hostile, &[section, Section::new("empty")], &json);
        assert!(!html.contains("<script>alert") && !html.contains("empty"));
        assert_eq!(html.matches("</script>").count(), 2);
        let start = html.find("id=\"parafovea-analysis\">").unwrap() + "id=\"parafovea-analysis\">".len();
        let end = start + html[start..].find("</script>").unwrap();
        assert_eq!(serde_json::from_str::<serde_json::Value>(&html[start..end]).unwrap(), json);
    }
}
