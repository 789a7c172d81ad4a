//! The data dictionary: every column of every exported table, with its type, unit, meaning, levels and frame of
//! reference. The columns that tables have whatever the data stand in `fixed`.

mod fixed;

pub use fixed::{
    DEVICE_CLOCK, DISPLAY_DEG, DISPLAY_PX, FITS, FORMS, FRAMES, FROM_GAZE, GAZE, PHASE_LEVELS, PHASES, SCENE_CLOCK,
    SEAMS, SESSION_CLOCK, SESSIONS, THRESHOLDS, TRIALS,
};

use super::cells::Kind;
use super::tables::Table;
use crate::session::SessionFolder;
use experiments::trial::Outcome;
use serde::Serialize;
use serde::ser::SerializeMap;
use serde::ser::Serializer;
use std::collections::BTreeSet;

/// Values that a column can have, each with its meaning.
pub type Levels = &'static [(&'static str, &'static str)];

/// One column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Its name in the table's first line.
    pub name: &'static str,
    /// What its cells are.
    pub kind: Kind,
    /// Unit, empty for none.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: &'static str,
    /// For times and places: the clock or the axes that they are measured on. Empty for everything else.
    pub reference: &'static str,
    /// The values it can have, where they are few; empty if they are not.
    pub levels: Levels,
}

impl Column {
    const fn on(self, reference: &'static str) -> Self {
        Self { reference, ..self }
    }

    const fn of(self, levels: Levels) -> Self {
        Self { levels, ..self }
    }
}

/// A column whose name may be known only from the data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NamedColumn {
    /// Its name in the table's first line.
    pub name: String,
    /// What its cells are.
    #[serde(rename = "type")]
    pub kind: Kind,
    /// Unit, empty for none.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: String,
    /// For times and places: the clock or the axes that they are measured on.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub reference: &'static str,
    /// The values it can have, where they are few.
    #[serde(skip_serializing_if = "<[_]>::is_empty", serialize_with = "as_object")]
    pub levels: Levels,
}

fn as_object<S: Serializer>(levels: &Levels, serializer: S) -> Result<S::Ok, S::Error> {
    let mut object = serializer.serialize_map(Some(levels.len()))?;
    for (value, meaning) in *levels {
        object.serialize_entry(value, meaning)?;
    }
    object.end()
}

impl From<&Column> for NamedColumn {
    fn from(column: &Column) -> Self {
        Self {
            name: column.name.to_owned(),
            kind: column.kind,
            unit: column.unit,
            meaning: column.meaning.to_owned(),
            reference: column.reference,
            levels: column.levels,
        }
    }
}

/// The names that trials brought with them, each of which has a column of its own.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TrialNames {
    /// Factors of the design.
    pub factors: BTreeSet<String>,
    /// Renderer parameters that levels set.
    pub levels: BTreeSet<String>,
    /// What trials found besides their answers.
    pub found: BTreeSet<String>,
}

impl TrialNames {
    /// The names in all trials of some sessions.
    #[must_use]
    pub fn of(sessions: &[SessionFolder]) -> Self {
        let mut names = Self::default();
        for record in sessions.iter().flat_map(|session| &session.record.trials) {
            names.factors.extend(record.trial.factors.keys().cloned());
            names.levels.extend(record.trial.level.keys().cloned());
            if let Outcome::Answered { found, .. } = &record.outcome {
                names.found.extend(found.keys().cloned());
            }
        }
        names
    }

    /// Their columns, in the order in which rows are written.
    #[must_use]
    pub fn columns(&self) -> Vec<NamedColumn> {
        let named =
            |name: String, kind, unit, meaning| NamedColumn { name, kind, unit, meaning, reference: "", levels: &[] };
        let factors = self.factors.iter().map(|name| {
            let meaning = format!("level of the factor {name}; empty in blocks without it");
            named(format!("factor_{name}"), Kind::Text, "", meaning)
        });
        let levels = self.levels.iter().map(|name| {
            let meaning = format!("the renderer parameter {name} as the trial set it, in the parameter's own unit");
            named(format!("level_{name}"), Kind::Real, unit(name), meaning)
        });
        let found = self.found.iter().map(|name| {
            let meaning = format!(
                "what the trial found for {name}: a setting, a rating, a count, or how often something was done"
            );
            named(format!("found_{name}"), Kind::Real, unit(name), meaning)
        });
        factors.chain(levels).chain(found).collect()
    }
}

/// The unit that a name ends with.
fn unit(name: &str) -> &'static str {
    let name = name.strip_suffix("_settled").unwrap_or(name);
    [("mar_deg", "deg/cycle"), ("_deg", "deg"), ("_px", "px"), ("_s", "s"), ("_mm", "mm")]
        .into_iter()
        .find_map(|(end, unit)| name.ends_with(end).then_some(unit))
        .unwrap_or("")
}

/// The dictionary as one JSON document: file → columns. `names` are those of the trials that were exported, `extension` is that
/// of the tables' files.
#[must_use]
pub fn dictionary(names: &TrialNames, extension: &str) -> serde_json::Value {
    let tables =
        Table::ALL.map(|table| (format!("{}.{extension}", table.name()), serde_json::json!(table.columns(names))));
    serde_json::Value::Object(tables.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::tables::{FRAME_COLUMNS, GAZE_COLUMNS};

    #[test]
    fn the_session_tables_are_described_column_by_column() {
        let names = |columns: &[Column]| columns.iter().skip(2).map(|column| column.name).collect::<Vec<_>>();
        assert_eq!(names(GAZE), GAZE_COLUMNS);
        assert_eq!(names(FRAMES), FRAME_COLUMNS);
    }

    #[test]
    fn names_from_the_data_are_described_with_their_units() {
        let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let names = TrialNames {
            factors: set(&["scene"]),
            levels: set(&["quality_index", "radius_deg"]),
            found: set(&["mar_deg_settled", "moves"]),
        };
        let described: Vec<(String, &str)> =
            names.columns().into_iter().map(|column| (column.name, column.unit)).collect();
        let expected = [
            ("factor_scene", ""),
            ("level_quality_index", ""),
            ("level_radius_deg", "deg"),
            ("found_mar_deg_settled", "deg/cycle"),
            ("found_moves", ""),
        ];
        assert_eq!(described, expected.map(|(name, unit)| (name.to_owned(), unit)));
        let trials = dictionary(&names, "csv")["trials.csv"].as_array().map_or(0, Vec::len);
        assert_eq!(trials, TRIALS.len() + expected.len());
    }

    /// Nobody should have to guess what a time or a place is measured from.
    #[test]
    fn every_time_and_place_says_what_it_is_measured_from_and_every_unit_is_in_the_name() {
        let durations = ["response_time_s", "gaze_age_s", "gpu_time_s", "frame_s"];
        for (table, column) in
            Table::ALL.iter().flat_map(|table| table.fixed().iter().map(move |column| (table, column)))
        {
            let name = column.name;
            let is_time = name.ends_with("_s") && !durations.contains(&name);
            let is_place = ["x_px", "y_px", "x_deg", "y_deg"].iter().any(|end| name.ends_with(end))
                || name.contains("eccentricity");
            assert_eq!(!column.reference.is_empty(), is_time || is_place, "{table:?}: {name}");
            for (end, unit) in [("_s", "s"), ("_px", "px"), ("_mm", "mm"), ("_hz", "Hz")] {
                assert!(!name.ends_with(end) || column.unit == unit, "{table:?}: {name} in {}", column.unit);
            }
            assert!(!name.ends_with("_deg") || column.unit.starts_with("deg"), "{table:?}: {name} in {}", column.unit);
            assert!(!column.meaning.is_empty(), "{table:?}: {name}");
        }
    }

    #[test]
    fn every_phase_is_a_level() {
        use experiments::trial::PhaseName;
        for (name, _) in PHASE_LEVELS {
            let phase: PhaseName = serde_json::from_value(serde_json::json!(name)).expect("a phase");
            assert_eq!(phase.as_str(), *name);
        }
    }
}
