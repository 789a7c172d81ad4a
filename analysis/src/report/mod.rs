//! One self-contained HTML page that reads like a short results section.
//!
//! Plain data in, one string out: no file, no network; the one script copies tables, and nothing depends on it. The page carries its figures as SVG and its
//! numbers as JSON (`<script type="application/json" id="parafovea-analysis">`), and reads on light and dark screens and
//! on paper. Text that came from outside is escaped everywhere.

mod blocks;
mod methods;
mod page;
pub mod results;
mod sections;
mod tables;

pub use methods::{MethodsFacts, methods_prose};
pub use page::{Cell, Figure, Section, Table, page};
pub use tables::{
    AnovaRow, AnovaTable, Exclusions, FlaggedTrial, GazeQuality, GroupParameter, HierarchicalGroup, PaperRule,
    anova_section, exclusions_section, gaze_section, group_section, paper_section,
};

use crate::answers::BlockSummary;
use crate::figures::{GazeView, TrackPoint};
use crate::gaze::GazeSample;
use crate::mar::MarFit;
use crate::summary::{Analysis, FormSummary, ObserverSummary};
use crate::timing::Frame;
use experiments::Display;
use experiments::mar::MarModel;

/// Everything that a report shows.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportInput {
    /// Heading of the page, for example the study's title.
    pub title: String,
    /// Version of the program that analysed, for example `parafovea 0.1.0`.
    pub program_version: String,
    /// When the report was made, as the reader should see it; left out if `None`, so that a page can be the same twice.
    pub generated: Option<String>,
    /// Further software with its version, as (name, version).
    pub software: Vec<(String, String)>,
    /// One entry per fitted observer, in the order in which they should appear.
    pub sessions: Vec<SessionReport>,
}

/// One observer's session (or several sessions fitted together) with its fit.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionReport {
    /// The observer's code.
    pub observer: String,
    /// The study's name.
    pub study: String,
    /// The session folder, or several.
    pub session: String,
    /// When the session started, as the reader should see it.
    pub started: Option<String>,
    /// The display it ran on.
    pub display: Display,
    /// The gaze source, for example `mouse` or `simulated (drift, 250 Hz)`.
    pub gaze_source: String,
    /// Scene and renderer, for example `photograph, renderer ring`.
    pub stimulus: String,
    /// The graphics adapter.
    pub adapter: String,
    /// The session's seed.
    pub seed: u64,
    /// Version of the program that ran the session.
    pub run_version: String,
    /// Further facts, as (label, value).
    pub facts: Vec<(String, String)>,
    /// The parameters of a simulated observer, shown beside what was fitted; `None` for a person.
    pub truth: Option<MarModel>,
    /// The MAR fit, for sessions whose trials allow one.
    pub fit: Option<MarFit>,
    /// What the answers of each block come to.
    pub blocks: Vec<BlockSummary>,
    /// Forms that were filled in.
    pub forms: Vec<FormSummary>,
    /// The data are from pilot runs: the page says so first.
    pub pilot: bool,
    /// How the levels were chosen, trial by trial; may be empty.
    pub track: Vec<TrackPoint>,
    /// Gaze during stimulus phases; may be empty.
    pub gaze: Vec<GazeSample>,
    /// What the gaze is drawn against.
    pub gaze_view: GazeView,
    /// Trials aborted by the fixation gate or a timeout, and repeated.
    pub aborted_trials: usize,
    /// Presented frames; may be empty.
    pub frames: Vec<Frame>,
    /// Refresh rate measured by the stage, hertz; the display's declared rate is used if `None`.
    pub measured_refresh_hz: Option<f64>,
    /// The session ran offscreen in virtual time: its frame timing says nothing about a display.
    pub virtual_time: bool,
}

impl SessionReport {
    fn summary(&self) -> ObserverSummary {
        ObserverSummary {
            pilot: self.pilot,
            forms: self.forms.clone(),
            ..ObserverSummary::new(self.observer.clone(), self.fit.as_ref(), self.blocks.clone())
        }
    }

    /// Trials in the MAR fit, or all answered ones without it.
    fn trials(&self) -> usize {
        self.fit.as_ref().map_or_else(|| self.blocks.iter().map(|block| block.trials).sum(), |fit| fit.trials)
    }
}

/// The JSON document that `html` embeds, for these sessions.
#[must_use]
pub fn analysis(input: &ReportInput) -> Analysis {
    Analysis::new(input.sessions.iter().map(SessionReport::summary).collect())
}

/// What a page may say beyond its sessions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extra {
    /// Facts for the methods, in place of what the sessions say by themselves ([`MethodsFacts::of`]).
    pub methods: Option<MethodsFacts>,
    /// Sections after the overview and before the methods: group, ANOVAs, exclusions, the papers' rules, gaze quality.
    pub sections: Vec<Section>,
    /// Further data for the page's JSON, each under its own key; keys of the analysis itself are kept.
    pub json: serde_json::Map<String, serde_json::Value>,
}

/// The whole page, as one HTML document in UTF-8 without any external resource.
#[must_use]
pub fn html(input: &ReportInput) -> String {
    html_with(input, &Extra::default())
}

/// The page of [`html`] with further sections, facts and data.
#[must_use]
pub fn html_with(input: &ReportInput, extra: &Extra) -> String {
    let own;
    let facts = match &extra.methods {
        Some(facts) => facts,
        None => {
            own = MethodsFacts::of(input);
            &own
        }
    };
    let mut body = String::new();
    body.push_str(&sections::header(input));
    body.push_str(&sections::pilot(input));
    body.push_str(&sections::overview(input));
    body.push_str(&blocks::group(input));
    extra.sections.iter().for_each(|section| body.push_str(&section.html()));
    if !input.sessions.is_empty() {
        body.push_str(&sections::methods(input, facts));
        body.push_str(&blocks::methods(input));
    }
    for session in &input.sessions {
        body.push_str(&sections::session(session, input.sessions.len() == 1));
    }
    body.push_str(&sections::software(input));
    let mut json = serde_json::to_value(analysis(input)).unwrap_or(serde_json::Value::Null);
    if let serde_json::Value::Object(document) = &mut json {
        for (key, value) in &extra.json {
            document.entry(key.clone()).or_insert_with(|| value.clone());
        }
    }
    page::document(&input.title, Some(&input.program_version), &body, &json)
}
