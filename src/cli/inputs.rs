//! Reading what the user names: studies and displays, by file or by the name under which they ship.

use crate::error::LabError;
use crate::resources::Resources;
use crate::stage::launch::StudyFile;
use experiments::Display;
use experiments::display::NAMED_DISPLAYS;
use experiments::study::{self, Mistakes, Plan};
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report, Severity};
use std::fmt::Write as _;
use std::io::IsTerminal;
use std::path::Path;

/// The display that a `--display` option names.
pub(super) fn display(name_or_file: Option<&str>) -> Result<Option<Display>, LabError> {
    let Some(name) = name_or_file else {
        return Ok(None);
    };
    if let Some(display) = Display::named(name) {
        return Ok(Some(display));
    }
    if !Path::new(name).exists() {
        return Err(LabError::BadInput(format!(
            "--display {name}: expected a display file or one of {}",
            NAMED_DISPLAYS.join(", ")
        )));
    }
    let text = read_text(name)?;
    Ok(Some(study::parse_display(name, &text)?))
}

/// The text of a study file or shipped study.
pub(super) fn study_file(name_or_file: &str) -> Result<StudyFile, LabError> {
    if let Some(shipped) = study::shipped().iter().find(|shipped| shipped.name == name_or_file) {
        return Ok(StudyFile { file: shipped.name.to_owned(), text: shipped.json.to_owned() });
    }
    if !Path::new(name_or_file).exists() {
        let names: Vec<&str> = study::shipped().iter().map(|shipped| shipped.name).collect();
        return Err(LabError::BadInput(format!(
            "{name_or_file}: expected a study file or one of the studies that ship: {}",
            names.join(", ")
        )));
    }
    Ok(StudyFile { file: name_or_file.to_owned(), text: read_text(name_or_file)? })
}

/// The name that a study gives itself, if it can be read that far.
pub(super) fn name(study: &StudyFile) -> Option<String> {
    let text: serde_json::Value = serde_json::from_str(&study.text).ok()?;
    Some(text.get("name")?.as_str()?.to_owned())
}

/// The plan of a study on a display.
pub(super) fn plan(study: &StudyFile, display: Option<&Display>) -> Result<Plan, LabError> {
    Resources::of(study).plan(&study.file, &study.text, display)
}

/// A text file, or one message that says why not.
pub(super) fn read_text(file: &str) -> Result<String, LabError> {
    let bytes = std::fs::read(file).map_err(|error| LabError::BadInput(format!("cannot read {file}: {error}")))?;
    String::from_utf8(bytes).map_err(|error| {
        let line = 1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        LabError::BadInput(format!("{file}:{line}: expected text in UTF-8"))
    })
}

/// Every mistake, first as one line each for editors and scripts, then with the text around it for people.
pub(super) fn snippets(mistakes: &Mistakes) -> String {
    let count = mistakes.list.len();
    let plural = if count == 1 { "mistake" } else { "mistakes" };
    let mut text = format!("{mistakes}\n");
    if std::io::stderr().is_terminal() {
        let labels = mistakes
            .list
            .iter()
            .map(|mistake| LabeledSpan::new_with_span(Some(mistake.message.clone()), mistake.span.clone()));
        let language = if mistakes.file.ends_with(".wgsl") { "WGSL" } else { "JSON" };
        let diagnostic =
            MietteDiagnostic::new(format!("{count} {plural}")).with_severity(Severity::Error).with_labels(labels);
        let report = Report::from(diagnostic)
            .with_source_code(NamedSource::new(&mistakes.file, mistakes.text.clone()).with_language(language));
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode());
        let mut drawn = String::new();
        if handler.render_report(&mut drawn, report.as_ref()).is_ok() {
            text.push_str(&drawn);
        }
    }
    let _ = write!(text, "{}: {count} {plural}; nothing was done", mistakes.file);
    text
}
