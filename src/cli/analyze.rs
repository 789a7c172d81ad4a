//! `parafovea analyze`: omega0 and m with their intervals, from sessions.

use super::{print, print_json, say};
use crate::error::LabError;
use crate::results::{ObserverResult, fit_sessions};
use crate::session::SessionFolder;
use analysis::mar::Support;
use analysis::summary::{Analysis, ObserverSummary};
use clap::Args;
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
    if let Some(path) = &args.report {
        crate::report::write(&results, path)?;
        say(&format!("report: {}", path.display()));
    }
    if let Some(folder) = &args.figures {
        crate::report::write_figures(&results, folder)?;
        say(&format!("figures: {}", folder.display()));
    }
    if args.json {
        let observers = results.iter().map(|result| ObserverSummary::new(&result.observer, &result.fit)).collect();
        return print_json(&Analysis { observers });
    }
    print(&results.iter().map(table).collect::<Vec<_>>().join("\n"))
}

/// One observer's results as a table for a terminal.
pub(super) fn table(result: &ObserverResult<'_>) -> String {
    let fit = &result.fit;
    // Writing to a string cannot fail.
    let mut text = format!("{}: {} trials in {} session(s)\n\n", result.observer, fit.trials, result.sessions.len());
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
    text
}
