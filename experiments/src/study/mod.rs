//! Studies: the file a lab writes, the checks it passes, and the plan that runs.
//!
//! Text is read with its positions, held against the schema that is generated from [`draft`], and validated into a
//! [`plan`]; every mistake on the way carries its line and field, and all are reported at once. [`mod@describe`] says what a
//! plan will do, [`shipped()`] holds the studies that come with the program. Nothing here reads a disk.

pub mod describe;
pub mod draft;
pub mod frames;
mod mistakes;
pub mod plan;
mod schema;
mod shipped;
mod source;
mod structure;
#[cfg(test)]
pub(crate) mod tests;
pub mod validate;

pub use describe::{Description, describe};
pub(crate) use mistakes::suggestion;
pub use mistakes::{Mistake, Mistakes};
pub use plan::Plan;
pub use schema::{display_schema, frames_schema, study_schema};
pub use shipped::{ShippedStudy, shipped};
pub use validate::{
    DEFAULT_FEEDBACK_S, DEFAULT_GATE_GRACE_S, DEFAULT_PAUSE, DEFAULT_QUESTION, DEFAULT_THANKS, finest_mar_around,
};

use crate::catalogue::Catalogue;
use crate::display::Display;
use mistakes::Report;
use serde::de::DeserializeOwned;
use serde_json::Value;
use source::{Field, Source};

/// Reads and checks a study.
///
/// `file` is only for messages. `display` overrides the study's own and may be given for a study that states none.
///
/// # Errors
/// Every mistake in the text, in the order of its lines. After a syntax error nothing further is known, so that it
/// comes alone.
pub fn parse_study(file: &str, text: &str, catalogue: &Catalogue, display: Option<&Display>) -> Result<Plan, Mistakes> {
    parse(file, text, schema::study(), |draft, report| validate::study(&draft, catalogue, display, report))
}

/// The files that a study's text names, as far as it can be read: what to read before [`parse_study`], which says what is
/// wrong with the rest.
#[must_use]
pub fn named_files(text: &str) -> Vec<plan::NamedFile> {
    let (tree, _) = source::parse(text);
    let source = Source::new(text, tree.as_ref());
    let mut report = Report::new(&source);
    let fitting = tree.map(|tree| structure::check(schema::study(), &tree, &mut report));
    let draft = fitting.and_then(|fitting| serde_json::from_value::<draft::StudyDraft>(fitting).ok());
    draft.map_or_else(Vec::new, |draft| validate::listed_files(&draft))
}

/// Reads and checks a display file: a name, a resolution in pixels, a size and a distance in millimetres.
///
/// # Errors
/// Every mistake in the text, in the order of its lines.
pub fn parse_display(file: &str, text: &str) -> Result<Display, Mistakes> {
    parse(file, text, schema::display(), |draft, report| validate::display_from(&draft, &Field::root(), report))
}

fn parse<D: DeserializeOwned, T>(
    file: &str,
    text: &str,
    schema: &Value,
    validate: impl FnOnce(D, &mut Report<'_>) -> Option<T>,
) -> Result<T, Mistakes> {
    let (tree, syntax) = source::parse(text);
    let source = Source::new(text, tree.as_ref());
    let mut report = Report::new(&source);
    for (span, message) in syntax {
        report.at_span(span, &Field::root(), message);
    }
    let checked = tree.and_then(|tree| {
        let fitting = structure::check(schema, &tree, &mut report);
        // What does not fit has been reported and is null; a whole file that does not fit has nothing to validate.
        if fitting.is_null() {
            return None;
        }
        match serde_json::from_value::<D>(fitting) {
            Ok(draft) => validate(draft, &mut report),
            Err(error) => {
                report.at(&Field::root(), format!("expected a file that follows its schema, found: {error}"));
                None
            }
        }
    });
    if let Some((span, message)) = report.is_empty().then(|| source::strictly(text)).flatten() {
        report.at_span(span, &Field::root(), message);
    }
    match checked {
        Some(checked) if report.is_empty() => Ok(checked),
        _ => {
            if report.is_empty() {
                report.at(&Field::root(), "expected a complete file, found one with parts missing");
            }
            Err(report.into_mistakes(file, text))
        }
    }
}
