//! What is wrong with a renderer's text: mistakes at its own lines, whether they were found in the head, by the compiler, or
//! only where the frame around the function calls it.

use experiments::study::{Mistake, Mistakes};
use std::fmt::Write as _;
use std::ops::Range;
use wgpu::naga;

/// How the function is declared.
const FUNCTION: &str = "fn colour(at: Place, given: Parameters) -> vec3f";
/// Names that begin so are the frame's own.
const OWN_PREFIX: &str = "parafovea_";

/// Collects what is wrong with a text.
pub(super) struct Faults<'t> {
    text: &'t str,
    list: Vec<Mistake>,
}

impl<'t> Faults<'t> {
    /// Nothing wrong yet with `text`.
    pub(super) fn of(text: &'t str) -> Self {
        Self { text, list: Vec::new() }
    }

    /// Notes a mistake at bytes of the text.
    pub(super) fn at(&mut self, span: Range<usize>, message: impl Into<String>) {
        let start = self.text.floor_char_boundary(span.start.min(self.text.len()));
        let before = &self.text[..start];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        self.list.push(Mistake {
            span: start..span.end.clamp(start, self.text.len()),
            line: 1 + before.matches('\n').count(),
            column: 1 + before[line_start..].chars().count(),
            field: String::new(),
            message: message.into(),
        });
    }

    pub(super) fn count(&self) -> usize {
        self.list.len()
    }

    /// Everything that was noted, in the order of the text.
    pub(super) fn into_mistakes(mut self, file: &str) -> Mistakes {
        self.list.sort_by_key(|mistake| mistake.span.start);
        Mistakes { file: file.to_owned(), text: self.text.to_owned(), list: self.list }
    }
}

/// Parses and validates the whole program, and reports the compiler's first error where the user's text caused it.
pub(super) fn check(text: &str, source: &str, faults: &mut Faults<'_>) {
    let within = |span: &Range<usize>| span.start < text.len() && span.end <= text.len() + 1;
    let module = match naga::front::wgsl::parse_str(source) {
        Ok(module) => module,
        Err(error) => {
            let labels: Vec<(Range<usize>, String)> =
                error.labels().filter_map(|(span, label)| Some((span.to_range()?, label.to_owned()))).collect();
            let message = with_notes(error.message(), error.notes());
            return blame(text, source, &labels, &message, faults);
        }
    };
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    if let Err(error) = validator.validate(&module) {
        let labels: Vec<(Range<usize>, String)> =
            error.spans().filter_map(|(span, label)| Some((span.to_range()?, label.clone()))).collect();
        let mut message = error.as_inner().to_string();
        let mut cause = std::error::Error::source(error.as_inner());
        while let Some(error) = cause {
            let _ = write!(message, ": {error}");
            cause = error.source();
        }
        return blame(text, source, &labels, &message, faults);
    }

    // What the frame does not provide for.
    for (handle, variable) in module.global_variables.iter() {
        let span = module.global_variables.get_span(handle).to_range().unwrap_or_default();
        if variable.binding.is_some() && within(&span) {
            faults.at(span, "expected no bindings, which belong to the frame around the function, found one");
        }
    }
    for (handle, _) in module.overrides.iter() {
        let span = module.overrides.get_span(handle).to_range().unwrap_or_default();
        faults.at(span, "expected a parameter in the head, found an override, which nobody sets");
    }
    for (handle, function) in module.functions.iter() {
        let span = module.functions.get_span(handle).to_range().unwrap_or_default();
        let name = function.name.as_deref().unwrap_or_default();
        if name.starts_with(OWN_PREFIX) && within(&span) {
            faults.at(span, format!("expected a name that does not begin with {OWN_PREFIX}, found {name}"));
        }
    }
}

fn with_notes<'n>(message: &str, notes: impl Iterator<Item = &'n str>) -> String {
    notes.fold(message.to_owned(), |all, note| format!("{all} ({note})"))
}

/// Puts a compiler's error where the user can do something about it.
fn blame(text: &str, source: &str, labels: &[(Range<usize>, String)], message: &str, faults: &mut Faults<'_>) {
    // A compiler that names a function and a place within it means the place.
    let own = labels.iter().filter(|(span, _)| span.start < text.len()).min_by_key(|(span, _)| span.len());
    let elsewhere = labels.iter().find(|(span, _)| span.start >= text.len());
    match (own, elsewhere) {
        // Two things of one name: the compiler sees the frame's as the second one.
        (Some((span, _)), Some(_)) if message.contains("redefinition") => {
            let name = text.get(span.clone()).unwrap_or_default();
            faults.at(
                span.clone(),
                format!("expected a name of its own, found \"{name}\", which the frame around the function uses"),
            );
        }
        (Some((span, label)), _) => {
            // Of the compiler's own types nobody outside it has heard.
            let is_said = label.is_empty() || label.starts_with("naga::") || message.contains(label.as_str());
            let label = if is_said { String::new() } else { format!(": {label}") };
            faults.at(span.clone(), format!("expected valid WGSL: {message}{label}"));
        }
        (None, _) => {
            // The frame's call failed, so the function is missing or is another one.
            match function_name(text) {
                None => faults.at(0..0, format!("expected a function `{FUNCTION}`, found none called colour")),
                Some(span) => {
                    let calls = elsewhere.and_then(|(span, _)| source.get(span.clone())).unwrap_or_default();
                    let hint = if calls.is_empty() {
                        String::new()
                    } else {
                        format!(" (at `{calls}` of the frame around it)")
                    };
                    faults.at(span, format!("expected `{FUNCTION}`, found another declaration: {message}{hint}"));
                }
            }
        }
    }
}

/// Where the text declares a function called `colour`.
fn function_name(text: &str) -> Option<Range<usize>> {
    text.match_indices("colour").map(|(at, name)| at..at + name.len()).find(|span| {
        let before = text[..span.start].trim_end();
        let after = text[span.end..].trim_start();
        before.ends_with("fn") && after.starts_with('(') && before.len() < span.start
    })
}
