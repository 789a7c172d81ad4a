//! Words out of a short list, as studies write options.

use crate::study::mistakes::{Report, suggestion};
use crate::study::source::Field;

/// What a word stands for; the first when there is none, nothing when it is not in the list, which is reported.
pub(super) fn chosen<T: Copy>(
    word: Option<&str>,
    options: &[(&str, T)],
    field: &Field,
    report: &mut Report<'_>,
) -> Option<T> {
    let Some(word) = word else { return options.first().map(|(_, value)| *value) };
    let found = options.iter().find(|(name, _)| *name == word);
    if found.is_none() {
        let names: Vec<String> = options.iter().map(|(name, _)| format!("\"{name}\"")).collect();
        let hint = suggestion(word, options.iter().map(|(name, _)| *name));
        report.at(field, format!("expected {}, found {word:?}{hint}", names.join(" or ")));
    }
    found.map(|(_, value)| *value)
}
