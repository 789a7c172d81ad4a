//! `parafovea analyze`: omega0 and m with their intervals, and what every block's answers come to, from sessions.

use super::{blocks, print, print_json, say, together};
use crate::error::LabError;
use crate::results::over_observers::{OverObservers, over_observers};
use crate::results::traces::quality;
use crate::results::{ObserverResult, document, fit_sessions, silence};
use crate::session::SessionFolder;
use analysis::MarFit;
use analysis::mar::Support;
use analysis::summary::Analysis;
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct AnalyzeArgs {
    /// Session folders; those of one observer are fitted together.
    #[arg(required = true)]
    sessions: Vec<PathBuf>,
    /// Write a report with figures, one self-contained page.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the figures as SVG files into this folder.
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &AnalyzeArgs) -> Result<(), LabError> {
    let sessions: Vec<SessionFolder> =
        args.sessions.iter().map(|path| SessionFolder::open(path)).collect::<Result<_, _>>()?;
    sessions.iter().flat_map(SessionFolder::notices).for_each(|notice| say(&notice));
    let results = fit_sessions(&sessions)?;
    let mut together = over_observers(&results);
    if args.json || args.report.is_some() {
        together = together.with_linearity(&results);
    }
    if let Some(path) = &args.report {
        let quality = quality(results.iter().flat_map(|result| result.sessions.iter().copied()))?;
        crate::report::write(&results, &together, &quality, path)?;
        say(&format!("report: {}", path.display()));
    }
    if let Some(folder) = &args.figures {
        crate::report::write_figures(&results, folder)?;
        say(&format!("figures: {}", folder.display()));
    }
    let document = document(&results);
    if args.json {
        return print_json(&Whole { analysis: &document, over_observers: &together });
    }
    let mut texts: Vec<String> = results.iter().map(table).collect();
    if !document.group.is_empty() {
        texts.push(blocks::group(&document.group));
    }
    texts.extend(together::text(&together));
    print(&texts.join("\n"))
}

/// The JSON document: what every observer gave, and what they come to together.
#[derive(Serialize)]
struct Whole<'a> {
    #[serde(flatten)]
    analysis: &'a Analysis,
    over_observers: &'a OverObservers,
}

/// One observer's results as a table for a terminal.
pub(super) fn table(result: &ObserverResult<'_>) -> String {
    let mut text = String::new();
    if result.pilot {
        text.push_str("PILOT DATA: shortened runs, no results\n");
    }
    if !result.says_anything() {
        return text + &silence(result) + "\n";
    }
    let trials = result.summary().trials;
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}: {trials} trials in {} session(s)", result.observer, result.sessions.len());
    if let Some(fit) = &result.fit {
        mar_table(&mut text, fit);
    }
    for block in result.blocks.iter().filter(|block| !block.in_mar_fit) {
        text.push_str(&blocks::table(block));
    }
    text.push_str(&blocks::forms(&result.forms));
    text
}

fn mar_table(text: &mut String, fit: &MarFit) {
    text.push('\n');
    let _ = writeln!(text, "  quantity   estimate   95 % interval         unit");
    for (name, estimate, unit) in [
        ("m", fit.m, "°/cycle per °"),
        ("omega0", fit.omega0, "°/cycle"),
        ("width", fit.width, "ln omega"),
        ("lapse", fit.lapse, "share"),
    ] {
        let [low, high] = estimate.ci95;
        let _ = writeln!(text, "  {name:<8}   {:<8.5}   {low:.5} – {high:<9.5}   {unit}", estimate.estimate);
    }
    if fit.display_limited {
        let _ = writeln!(
            text,
            "  omega0 lies below everything that the display could show: it is extrapolated from the line."
        );
    }
    let _ = writeln!(text, "\n  eccentricity   threshold (°/cycle)   95 % interval        trials");
    for threshold in &fit.thresholds {
        let bound = if threshold.limited { "≤" } else { " " };
        let _ = writeln!(
            text,
            "  {:>10.2}°   {bound}{:<18.4}   {:.4} – {:<8.4}    {:>6}",
            threshold.eccentricity_deg, threshold.mar_deg, threshold.ci95[0], threshold.ci95[1], threshold.trials
        );
    }
    if let Support::Unsupported { reasons } = &fit.support {
        let _ = writeln!(text, "\n  THE DATA DO NOT SUPPORT THIS FIT:");
        reasons.iter().for_each(|reason| {
            let _ = writeln!(text, "  - {reason}");
        });
    }
    for warning in &fit.warnings {
        let _ = writeln!(text, "  note: {warning}");
    }
}
