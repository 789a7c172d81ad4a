//! `dataset_description.json` and `README.md` of a Psych-DS data set.

use crate::export::columns::NamedColumn;
use crate::export::tables::{Table, Tables};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// The variables of all files, each once: Psych-DS has one list for a data set, whatever files they are in.
#[derive(Debug, Default)]
pub(super) struct Variables {
    list: Vec<Variable>,
}

#[derive(Debug)]
struct Variable {
    name: String,
    /// What it is in which tables.
    uses: Vec<(&'static str, NamedColumn)>,
}

impl Variables {
    /// Adds the columns of a file of `table`.
    pub(super) fn add(&mut self, table: Table, columns: &[NamedColumn]) {
        for column in columns {
            let index = self.list.iter().position(|known| known.name == column.name).unwrap_or_else(|| {
                self.list.push(Variable { name: column.name.clone(), uses: Vec::new() });
                self.list.len() - 1
            });
            let uses = &mut self.list[index].uses;
            if !uses.iter().any(|(known, _)| *known == table.name()) {
                uses.push((table.name(), column.clone()));
            }
        }
    }

    fn measured(&self) -> Vec<Value> {
        self.list.iter().map(Variable::measured).collect()
    }
}

impl Variable {
    /// As a `PropertyValue` of schema.org.
    fn measured(&self) -> Value {
        let first = &self.uses[0].1;
        let same = self.uses.iter().all(|(_, column)| column == first);
        let description = if same {
            in_words(first)
        } else {
            let each: Vec<String> =
                self.uses.iter().map(|(table, column)| format!("In {table}: {}.", in_words(column))).collect();
            each.join(" ")
        };
        let mut value = json!({ "@type": "PropertyValue", "name": self.name, "description": description });
        if !first.unit.is_empty() && self.uses.iter().all(|(_, column)| column.unit == first.unit) {
            value["unitText"] = json!(first.unit);
        }
        value
    }
}

/// Meaning, unit, frame of reference and levels in one text.
fn in_words(column: &NamedColumn) -> String {
    let mut words = column.meaning.clone();
    if !column.unit.is_empty() {
        words += &format!(" [{}]", column.unit);
    }
    if !column.reference.is_empty() {
        words += &format!("; measured on {}", column.reference);
    }
    if !column.levels.is_empty() {
        let levels: Vec<String> = column.levels.iter().map(|(value, meaning)| format!("{value} = {meaning}")).collect();
        words += &format!("; levels: {}", levels.join(", "));
    }
    words
}

/// The studies that were exported, by name and title.
fn studies(tables: &Tables<'_>) -> BTreeSet<(String, String)> {
    tables.sessions.iter().map(|s| (s.header.study.name.clone(), s.header.study.title.clone())).collect()
}

pub(super) fn description(tables: &Tables<'_>, variables: &Variables) -> Value {
    let studies = studies(tables);
    let names: Vec<&str> = studies.iter().map(|(name, _)| name.as_str()).collect();
    let titles: Vec<&str> = studies.iter().map(|(_, title)| title.as_str()).collect();
    json!({
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": names.join(", "),
        "description": format!(
            "Gaze-contingent psychophysics run with Parafovea: {}. {} session(s). Times are seconds on each session's own \
             clock, 0 at its start; places are pixels from the display's top left corner (y down) or degrees of visual \
             angle from its centre (y up).",
            titles.join("; "),
            tables.sessions.len()
        ),
        "schemaVersion": "Psych-DS 1.5.0",
        "variableMeasured": variables.measured(),
    })
}

pub(super) fn readme(tables: &Tables<'_>) -> String {
    let mut text = "# Data of a Parafovea study\n\n".to_owned();
    for (name, title) in studies(tables) {
        text += &format!("- {name}: {title}\n");
    }
    text += "\nEach file under `data/` is one table of one session: `study`, `subject` and `session` say which, `description` \
             says what. `description-sessions_data.csv` has a row for each session, with its display, program and seed. \
             `dataset_description.json` explains every column: unit, meaning, levels, and the clock or axes that times and \
             places are measured on. Empty cells mean: not known, or without a meaning in that row.\n";
    text
}

pub(super) fn changes() -> String {
    format!("# Changes\n\n- Exported from the sessions' own logs by Parafovea {}.\n", env!("CARGO_PKG_VERSION"))
}
