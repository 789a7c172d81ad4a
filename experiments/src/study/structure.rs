//! A file against its schema: types, keys, bounds that hold for every study.
//!
//! Walks text and schema together, reports everything that does not fit, and returns what does: a wrong value comes
//! back as `null`, so that the typed draft still loads and the checks of [`super::validate`] still run. It knows the
//! keywords that [`super::schema`] generates; names against their pattern are left to `validate`.

use super::mistakes::{Report, suggestion};
use super::schema::resolved;
use super::source::{Field, span_of};
use jsonc_parser::ast::Value as Node;
use serde_json::{Map, Number, Value};

/// Checks a tree against a schema and returns the part of it that fits.
pub(super) fn check(root: &Value, node: &Node<'_>, report: &mut Report<'_>) -> Value {
    Walker { root, report }.check(root, node, &Field::root(), None)
}

struct Walker<'a, 's> {
    root: &'a Value,
    report: &'a mut Report<'s>,
}

impl<'a> Walker<'a, '_> {
    /// `unit` is what the list around this value says of its elements; the value's own schema may say otherwise.
    fn check(&mut self, schema: &'a Value, node: &Node<'_>, field: &Field, unit: Option<&'a str>) -> Value {
        let unit = schema.get("x-unit").and_then(Value::as_str).or(unit);
        let schema = resolved(self.root, schema);
        if let Some(names) = names_of(schema) {
            return self.check_name(&names, node, field);
        }
        if let Some(branches) = branches(schema) {
            return self.check_branches(branches, node, field);
        }
        match (node, type_of(schema)) {
            (Node::Object(object), "object") => self.check_object(schema, object, field),
            (Node::Array(array), "array") => self.check_array(schema, array, field, unit),
            (Node::StringLit(string), "string") => self.check_string(schema, &string.value, field),
            (Node::BooleanLit(boolean), "boolean") => Value::Bool(boolean.value),
            (Node::NumberLit(number), "number" | "integer") => self.check_number(schema, number.value, field, unit),
            _ => self.refuse(schema, node, field, unit),
        }
    }

    /// One of a list of names.
    fn check_name(&mut self, names: &[&str], node: &Node<'_>, field: &Field) -> Value {
        let word = node.as_string_lit().map(|string| string.value.as_ref());
        if let Some(name) = names.iter().find(|name| Some(**name) == word) {
            return Value::from(*name);
        }
        let hint = suggestion(word.unwrap_or_default(), names.iter().copied());
        self.report.at(field, format!("expected {}, found {}{hint}", quoted(names), found(node)));
        Value::Null
    }

    fn refuse(&mut self, schema: &Value, node: &Node<'_>, field: &Field, unit: Option<&str>) -> Value {
        let expected = expectation(schema, field, unit);
        self.report.at(field, format!("expected {expected}, found {}", found(node)));
        Value::Null
    }

    /// Alternatives: told apart by their `kind` if they have one, by the type of the value otherwise.
    fn check_branches(&mut self, branches: &'a [Value], node: &Node<'_>, field: &Field) -> Value {
        let branches: Vec<&Value> = branches.iter().map(|branch| resolved(self.root, branch)).collect();
        let kinds: Vec<(&str, &Value)> = branches.iter().filter_map(|b| Some((kind_of(b)?, *b))).collect();
        if kinds.is_empty() {
            let fits = |branch: &&&Value| accepts_type(type_of(branch), node);
            if let Some(branch) = branches.iter().find(fits) {
                return self.check(branch, node, field, None);
            }
            let expected: Vec<String> = branches.iter().map(|b| expectation(b, field, None)).collect();
            self.report.at(field, format!("expected {}, found {}", expected.join(" or "), found(node)));
            return Value::Null;
        }

        let names: Vec<&str> = kinds.iter().map(|(name, _)| *name).collect();
        let expected = names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(" or ");
        let kind_field = field.key("kind");
        let Node::Object(object) = node else {
            self.report.at(field, format!("expected an object with the kind {expected}, found {}", found(node)));
            return Value::Null;
        };
        let Some(kind) = object.get("kind") else {
            self.report.at(&kind_field, format!("expected {expected}, found no such key"));
            return Value::Null;
        };
        let name = kind.value.as_string_lit().map(|string| string.value.as_ref());
        match kinds.iter().find(|(known, _)| Some(*known) == name) {
            Some((_, branch)) => self.check_object(branch, object, field),
            None => {
                let hint = suggestion(name.unwrap_or_default(), names);
                self.report.at(&kind_field, format!("expected {expected}, found {}{hint}", found(&kind.value)));
                Value::Null
            }
        }
    }

    fn check_object(&mut self, schema: &'a Value, object: &jsonc_parser::ast::Object<'_>, field: &Field) -> Value {
        let properties = schema.get("properties").and_then(Value::as_object);
        let known = || properties.into_iter().flatten();
        // A map of names to values has no fixed keys; everything else refuses keys that it does not know.
        let others = schema.get("additionalProperties").filter(|others| others.is_object());
        let mut out = Map::new();

        for property in &object.properties {
            let name = property.name.as_str();
            let member = field.key(name);
            if out.contains_key(name) {
                self.report.at_span(
                    span_of(&property.name),
                    &member,
                    format!("expected each key once, found \"{name}\" again"),
                );
                continue;
            }
            let value = match properties.and_then(|p| p.get(name)).or(others) {
                Some(schema) => self.check(schema, &property.value, &member, None),
                None => {
                    let keys: Vec<&str> = known().map(|(key, _)| key.as_str()).filter(|k| *k != "$schema").collect();
                    let hint = suggestion(name, keys.iter().copied());
                    let expected = keys.join(", ");
                    self.report.at_key(&member, format!("expected one of the keys {expected}, found \"{name}\"{hint}"));
                    Value::Null
                }
            };
            out.insert(name.to_owned(), value);
        }

        let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
        for name in required.filter_map(Value::as_str) {
            if !out.contains_key(name) {
                let member = field.key(name);
                let schema = properties.and_then(|p| p.get(name)).unwrap_or(&Value::Null);
                let unit = schema.get("x-unit").and_then(Value::as_str);
                let expected = expectation(resolved(self.root, schema), &member, unit);
                self.report.at(&member, format!("expected {expected}, found no such key"));
            }
        }
        out.retain(|name, _| others.is_some() || properties.is_some_and(|p| p.contains_key(name)));
        Value::Object(out)
    }

    fn check_array(
        &mut self,
        schema: &'a Value,
        array: &jsonc_parser::ast::Array<'_>,
        field: &Field,
        unit: Option<&'a str>,
    ) -> Value {
        let count = array.elements.len() as u64;
        let bound = |name: &str| schema.get(name).and_then(Value::as_u64);
        let (least, most) = (bound("minItems"), bound("maxItems"));
        if least.is_some_and(|least| count < least) || most.is_some_and(|most| count > most) {
            let expected = expectation(schema, field, unit);
            self.report.at(field, format!("expected {expected}, found {count}"));
            return Value::Null;
        }
        let items = schema.get("items").unwrap_or(&Value::Null);
        let elements = array.elements.iter().enumerate();
        let out: Vec<Value> =
            elements.map(|(index, element)| self.check(items, element, &field.item(index), unit)).collect();
        // A pair with a wrong half is no pair.
        if least.is_some() && least == most && out.contains(&Value::Null) {
            return Value::Null;
        }
        Value::Array(out)
    }

    fn check_string(&mut self, schema: &Value, text: &str, field: &Field) -> Value {
        let shortest = schema.get("minLength").and_then(Value::as_u64).unwrap_or(0);
        if (text.chars().count() as u64) < shortest {
            self.report.at(field, "expected some text, found an empty string");
            return Value::Null;
        }
        Value::from(text)
    }

    fn check_number(&mut self, schema: &Value, text: &str, field: &Field, unit: Option<&str>) -> Value {
        let Some(value) = serde_json::from_str::<f64>(text).ok().filter(|value| value.is_finite()) else {
            let expected = expectation(schema, field, unit);
            self.report.at(field, format!("expected {expected}, found {text}, which is no number that JSON can carry"));
            return Value::Null;
        };
        let bound = |name: &str| schema.get(name).and_then(Value::as_f64);
        let whole = type_of(schema) == "integer";
        let accepted = bound("minimum").is_none_or(|least| value >= least)
            && bound("maximum").is_none_or(|most| value <= most)
            && bound("exclusiveMinimum").is_none_or(|below| value > below)
            && bound("const").is_none_or(|only| value.total_cmp(&only).is_eq())
            && (!whole || value.fract().abs() <= 0.0);
        if !accepted {
            let expected = expectation(schema, field, unit);
            self.report.at(field, format!("expected {expected}, found {text}"));
            return Value::Null;
        }
        // `1e3` is a whole number to JSON Schema, so it is one here.
        let number = if whole { Some(Number::from(value as i64)) } else { Number::from_f64(value) };
        number.map_or(Value::Null, Value::Number)
    }
}

fn branches(schema: &Value) -> Option<&[Value]> {
    schema.get("oneOf").or_else(|| schema.get("anyOf")).and_then(Value::as_array).map(Vec::as_slice)
}

/// The names that a schema of names accepts, whether they stand in a list or in alternatives with a text each.
fn names_of(schema: &Value) -> Option<Vec<&str>> {
    if let Some(list) = schema.get("enum").and_then(Value::as_array) {
        return list.iter().map(Value::as_str).collect();
    }
    schema.get("oneOf").and_then(Value::as_array)?.iter().map(|name| name.get("const")?.as_str()).collect()
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(" or ")
}

fn type_of(schema: &Value) -> &str {
    schema.get("type").and_then(Value::as_str).unwrap_or_default()
}

fn kind_of(branch: &Value) -> Option<&str> {
    branch.pointer("/properties/kind/const").and_then(Value::as_str)
}

fn accepts_type(name: &str, node: &Node<'_>) -> bool {
    match node {
        Node::Object(_) => name == "object",
        Node::Array(_) => name == "array",
        Node::StringLit(_) => name == "string",
        Node::NumberLit(_) => name == "number" || name == "integer",
        Node::BooleanLit(_) => name == "boolean",
        Node::NullKeyword(_) => name == "null",
    }
}

/// What a schema accepts, in words.
fn expectation(schema: &Value, field: &Field, unit: Option<&str>) -> String {
    if let Some(only) = schema.get("const") {
        return only.to_string();
    }
    if let Some(names) = names_of(schema) {
        return quoted(&names);
    }
    if let Some(branches) = branches(schema) {
        let kinds: Vec<String> = branches.iter().filter_map(kind_of).map(|kind| format!("\"{kind}\"")).collect();
        return match kinds.is_empty() {
            true => "a value".to_owned(),
            false => format!("an object with the kind {}", kinds.join(" or ")),
        };
    }
    let unit = unit.or_else(|| unit_of(field.last_key())).map_or_else(String::new, |unit| format!(" in {unit}"));
    match type_of(schema) {
        "number" => format!("a number{unit}{}", bounds(schema)),
        "integer" if unit.is_empty() => format!("a whole number{}", bounds(schema)),
        "integer" => format!("a whole number{unit}{}", bounds(schema)),
        "string" => "a string".to_owned(),
        "boolean" => "true or false".to_owned(),
        "array" => {
            let items = schema.get("items").unwrap_or(&Value::Null);
            let what = match type_of(items) {
                "number" => format!("numbers{unit}"),
                "integer" => format!("whole numbers{unit}"),
                "string" => "strings".to_owned(),
                _ => "objects".to_owned(),
            };
            match schema.get("minItems").and_then(Value::as_u64) {
                Some(count) if schema.get("maxItems").and_then(Value::as_u64) == Some(count) => {
                    format!("a list of {count} {what}")
                }
                _ => format!("a list of {what}"),
            }
        }
        "object" => {
            let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
            let keys: Vec<&str> = required.filter_map(Value::as_str).collect();
            match keys.is_empty() {
                true => "an object".to_owned(),
                false => format!("an object with {}", keys.join(", ")),
            }
        }
        _ => "a value".to_owned(),
    }
}

fn bounds(schema: &Value) -> String {
    let bound = |name: &str| schema.get(name).and_then(Value::as_f64);
    match (bound("minimum"), bound("exclusiveMinimum"), bound("maximum")) {
        (Some(least), _, Some(most)) => format!(" from {least} to {most}"),
        (None, Some(below), Some(most)) => format!(" above {below} and up to {most}"),
        (Some(least), _, None) => format!(" of at least {least}"),
        (None, Some(below), None) => format!(" above {below}"),
        (None, None, Some(most)) => format!(" of at most {most}"),
        (None, None, None) => String::new(),
    }
}

/// The unit that a name carries as its suffix.
fn unit_of(name: &str) -> Option<&'static str> {
    const UNITS: [(&str, &str); 6] = [
        ("_deg", "degrees"),
        ("_mm", "millimetres"),
        ("_px", "pixels"),
        ("_hz", "hertz"),
        ("_cd_m2", "cd/m²"),
        ("_s", "seconds"),
    ];
    UNITS.iter().find(|(suffix, _)| name.ends_with(suffix)).map(|(_, unit)| *unit)
}

/// A value as it stands in the file, in few words.
fn found(node: &Node<'_>) -> String {
    const LONGEST: usize = 40;
    match node {
        Node::StringLit(string) if string.value.chars().count() > LONGEST => {
            format!("{:?}…", string.value.chars().take(LONGEST).collect::<String>())
        }
        Node::StringLit(string) => format!("{:?}", string.value),
        Node::NumberLit(number) => number.value.to_owned(),
        Node::BooleanLit(boolean) => boolean.value.to_string(),
        Node::Object(_) => "an object".to_owned(),
        Node::Array(_) => "a list".to_owned(),
        Node::NullKeyword(_) => "null".to_owned(),
    }
}
