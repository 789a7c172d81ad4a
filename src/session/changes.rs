//! What is different between the study or display that a session was run with and the one that it is to go on with.

use experiments::session::event::Change;
use serde_json::Value;

/// Values are shown up to this many characters.
const SHOWN_CHARS: usize = 60;

/// Every difference between two JSON values, at its field; `name` stands before each.
#[must_use]
pub fn changes(name: &str, before: &Value, after: &Value) -> Vec<Change> {
    let mut found = Vec::new();
    walk(String::new(), Some(before), Some(after), &mut |field, before, after| {
        let field = if field.is_empty() { name.to_owned() } else { format!("{name}: {field}") };
        found.push(Change { field, from: shown(before), to: shown(after) });
    });
    found
}

/// What is told of each difference: field, value before, value after.
type Found<'a> = dyn FnMut(String, Option<&Value>, Option<&Value>) + 'a;

fn walk(field: String, before: Option<&Value>, after: Option<&Value>, found: &mut Found<'_>) {
    match (before, after) {
        (before, after) if before == after => {}
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let names = a.keys().chain(b.keys().filter(|name| !a.contains_key(*name)));
            for name in names {
                let below = if field.is_empty() { name.clone() } else { format!("{field}.{name}") };
                walk(below, a.get(name), b.get(name), found);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) => {
            for at in 0..a.len().max(b.len()) {
                walk(format!("{field}[{at}]"), a.get(at), b.get(at), found);
            }
        }
        (before, after) => found(field, before, after),
    }
}

fn shown(value: Option<&Value>) -> String {
    let text = value.map(Value::to_string).unwrap_or_default();
    if text.chars().count() <= SHOWN_CHARS {
        return text;
    }
    text.chars().take(SHOWN_CHARS).chain(['…']).collect()
}

/// Differences as lines for people.
#[must_use]
pub fn in_words(changes: &[Change]) -> String {
    let line = |change: &Change| match (change.from.as_str(), change.to.as_str()) {
        ("", to) => format!("  {}: new, {to}", change.field),
        (from, "") => format!("  {}: {from}, now gone", change.field),
        (from, to) => format!("  {}: {from}, now {to}", change.field),
    };
    changes.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_difference_is_named_at_its_field() {
        let before = json!({ "a": 1, "blocks": [{ "s": 0.5 }, { "s": 1 }], "gone": "x", "same": [1, 2] });
        let after = json!({ "a": 1, "blocks": [{ "s": 0.6 }], "same": [1, 2], "new": true });
        let found = changes("study", &before, &after);
        let lines = in_words(&found);
        assert_eq!(
            lines,
            "  study: blocks[0].s: 0.5, now 0.6\n  study: blocks[1]: {\"s\":1}, now gone\n  study: gone: \"x\", now \
             gone\n  study: new: new, true"
        );
        assert!(changes("study", &before, &before).is_empty());
    }
}
