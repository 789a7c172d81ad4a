//! The JSON Schemas of study, display and frames files, generated from [`super::draft`].
//!
//! They are committed beside the shipped studies, so that editors complete and check a file while it is written; a
//! test holds that the committed files are what this module generates.

use super::draft::{DisplayDraft, StudyDraft};
use super::frames::FramesDraft;
use serde_json::{Map, Value};
use std::sync::OnceLock;

/// The JSON Schema (draft 2020-12) of a study file.
#[must_use]
pub fn study_schema() -> Value {
    study().clone()
}

/// The JSON Schema (draft 2020-12) of a display file.
#[must_use]
pub fn display_schema() -> Value {
    display().clone()
}

/// The JSON Schema (draft 2020-12) of the manifest of a folder of frames.
#[must_use]
pub fn frames_schema() -> Value {
    frames().clone()
}

pub(super) fn frames() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| strict(schemars::schema_for!(FramesDraft).to_value()))
}

pub(super) fn study() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| strict(schemars::schema_for!(StudyDraft).to_value()))
}

pub(super) fn display() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| strict(schemars::schema_for!(DisplayDraft).to_value()))
}

/// What `reference` (`#/$defs/Name`) points to in `root`, or `schema` itself if it points nowhere.
pub(super) fn resolved<'s>(root: &'s Value, schema: &'s Value) -> &'s Value {
    let target = schema.get("$ref").and_then(Value::as_str).and_then(|r| r.strip_prefix('#'));
    target.and_then(|pointer| root.pointer(pointer)).unwrap_or(schema)
}

/// Takes `null` out of the schema: the draft's `Option`s mean "may be absent", never "may be null".
fn strict(value: Value) -> Value {
    match value {
        Value::Object(map) => Value::Object(strict_object(map)),
        Value::Array(list) => Value::Array(list.into_iter().map(strict).collect()),
        other => other,
    }
}

fn strict_object(map: Map<String, Value>) -> Map<String, Value> {
    let mut out = Map::new();
    for (key, value) in map {
        match (key.as_str(), value) {
            ("type", Value::Array(types)) => {
                let mut types: Vec<Value> = types.into_iter().filter(|t| t != "null").collect();
                let value = if types.len() == 1 { types.remove(0) } else { Value::Array(types) };
                out.insert(key, value);
            }
            ("anyOf", Value::Array(branches)) => {
                let is_null = |b: &Value| b.get("type").is_some_and(|t| t == "null");
                let mut branches: Vec<Value> = branches.into_iter().filter(|b| !is_null(b)).map(strict).collect();
                match branches.pop() {
                    Some(Value::Object(only)) if branches.is_empty() => out.extend(only),
                    Some(last) => {
                        branches.push(last);
                        out.insert(key, Value::Array(branches));
                    }
                    None => {}
                }
            }
            // How Rust stores a number is of no use to who writes a study.
            ("format", Value::String(_)) | ("default", Value::Null) => {}
            (_, value) => {
                out.insert(key, strict(value));
            }
        }
    }
    out
}
