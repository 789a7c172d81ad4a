//! Forms: names of their own, scales with a digit for every step, ranges that hold a number.

use crate::study::draft::{ChoiceDraft, ItemDraft, NumberDraft, ScaleDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{Item, ItemKind};
use crate::study::source::Field;
use std::collections::BTreeSet;

/// The most steps of a scale or options of a choice: one for each digit key.
const MOST_STEPS: usize = 9;
/// The length of a text where a study says none.
const DEFAULT_LENGTH: usize = 200;
/// The longest name of an item.
const LONGEST_NAME: usize = 64;

/// The items of a form with every default filled in; those that are wrong are reported and left out.
pub(super) fn checked(items: &[Option<ItemDraft>], field: &Field, report: &mut Report<'_>) -> Vec<Item> {
    let mut seen = BTreeSet::new();
    let mut checked = Vec::new();
    for (index, draft) in items.iter().enumerate() {
        let Some(draft) = draft else { continue };
        let field = field.item(index);
        let [name, question] = draft.words();
        if let Some(name) = name {
            let field = field.key("name");
            report_bad_name(name, &field, report);
            if !seen.insert(name) {
                report.at(&field, format!("expected a name of its own, found \"{name}\" as in an earlier item"));
            }
        }
        let kind = kind(draft, &field, report);
        if let (Some(name), Some(question), Some(kind)) = (name, question, kind) {
            checked.push(Item { name: name.to_owned(), question: question.to_owned(), kind });
        }
    }
    checked
}

/// Names become columns: letters, digits, and hyphens or underscores between them.
fn report_bad_name(name: &str, field: &Field, report: &mut Report<'_>) {
    let is_part = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit());
    let starts = name.starts_with(|first: char| first.is_ascii_lowercase());
    if name.len() > LONGEST_NAME || !starts || !name.split(['-', '_']).all(is_part) {
        report.at(
            field,
            format!(
                "expected a name of at most {LONGEST_NAME} letters a-z, digits, and hyphens or underscores between them, \
                 a letter first (as in \"artefact-free\"), found {name:?}"
            ),
        );
    }
}

fn kind(draft: &ItemDraft, field: &Field, report: &mut Report<'_>) -> Option<ItemKind> {
    match draft {
        ItemDraft::Scale(draft) => scale(draft, field, report),
        ItemDraft::Choice(draft) => choice(draft, field, report),
        ItemDraft::Number(draft) => number(draft, field, report),
        ItemDraft::Text(draft) => {
            let max_length = draft.max_length.and_then(|length| usize::try_from(length).ok());
            Some(ItemKind::Text { max_length: max_length.unwrap_or(DEFAULT_LENGTH) })
        }
    }
}

fn scale(draft: &ScaleDraft, field: &Field, report: &mut Report<'_>) -> Option<ItemKind> {
    // A bound that could not be read has been reported; its default would be held against the other one for nothing.
    if report.has(&field.key("low")) || report.has(&field.key("high")) {
        return None;
    }
    let (low, high) = (draft.low.unwrap_or(-3), draft.high.unwrap_or(3));
    let steps = i64::from(high) - i64::from(low) + 1;
    if steps < 2 {
        report.at(&field.key("high"), format!("expected more than low ({low}), found {high}"));
        return None;
    }
    if steps > MOST_STEPS as i64 {
        report.at(
            &field.key("high"),
            format!("expected at most {MOST_STEPS} steps, one for each digit key, found {steps} from {low} to {high}"),
        );
        return None;
    }
    let anchor = |given: &Option<String>, default: &str| given.clone().unwrap_or_else(|| default.to_owned());
    Some(ItemKind::Scale {
        low,
        high,
        low_anchor: anchor(&draft.low_anchor, "strongly disagree"),
        high_anchor: anchor(&draft.high_anchor, "strongly agree"),
    })
}

fn choice(draft: &ChoiceDraft, field: &Field, report: &mut Report<'_>) -> Option<ItemKind> {
    let given = draft.options.as_ref()?;
    let field = field.key("options");
    let before = report.count();
    if !(2..=MOST_STEPS).contains(&given.len()) {
        report.at(&field, format!("expected 2 to {MOST_STEPS} options, one for each digit key, found {}", given.len()));
    }
    let mut seen = BTreeSet::new();
    for (index, option) in given.iter().enumerate() {
        let Some(option) = option else { continue };
        if option.trim().is_empty() {
            report.at(&field.item(index), "expected some text, found an empty string");
        } else if !seen.insert(option.trim()) {
            report.at(&field.item(index), format!("expected each option once, found {option:?} again"));
        }
    }
    let options: Vec<String> = given.iter().cloned().collect::<Option<_>>()?;
    (report.count() == before).then_some(ItemKind::Choice { options })
}

fn number(draft: &NumberDraft, field: &Field, report: &mut Report<'_>) -> Option<ItemKind> {
    let (min, max) = (draft.min?, draft.max?);
    let whole = draft.whole.unwrap_or(false);
    if min >= max {
        report.at(&field.key("max"), format!("expected more than min ({min}), found {max}"));
        return None;
    }
    if whole && min.ceil() > max.floor() {
        report.at(&field.key("max"), format!("expected a whole number between min ({min}) and max, found {max}"));
        return None;
    }
    Some(ItemKind::Number { min, max, unit: draft.unit.clone().unwrap_or_default(), whole })
}
