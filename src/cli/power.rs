//! `parafovea power`: what a study can be expected to give, from simulated observers, before anybody is recruited.

use super::{inputs, print, print_json, progress, say};
use crate::error::LabError;
use crate::power::{Request, run as simulate};
use analysis::power::{Point, Power, QuantityPower, power_figure};
use clap::Args;
use experiments::observers::Simulation;
use std::fmt::Write as _;
use std::path::PathBuf;

/// The typical observer where none is given: Guenter's m for a pair test and the average adult's foveal acuity.
const TYPICAL: &str = "omega0=0.021,m=0.022";
/// The most sessions of one analysis.
const MOST_SESSIONS: u64 = 1_000_000;

#[derive(Debug, Args)]
pub(super) struct PowerArgs {
    /// A study file, or the name of a study that ships.
    study: String,
    /// The display, by name or file; the study's own if not given.
    #[arg(long, value_name = "NAME|FILE")]
    display: Option<String>,
    /// Observers of one study.
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    observers: u32,
    /// How often the whole study is repeated.
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    repeats: u32,
    /// The typical observer's truth, for example omega0=0.021,m=0.022 or quality_index=14,width=3,finer=up.
    #[arg(long, default_value = TYPICAL, value_name = "TRUTH")]
    simulate: String,
    /// How much observers differ: SD of ln m and ln omega0, or of a threshold relative to itself.
    #[arg(long, default_value_t = 0.15, value_name = "SD", value_parser = spread)]
    spread: f64,
    /// Fixes everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write a figure.
    #[arg(long, value_name = "FILE.svg")]
    figure: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

fn spread(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|spread| (0.0..=1.0).contains(spread)).ok_or("expected a number from 0 to 1".to_owned())
}

pub(super) fn run(args: &PowerArgs) -> Result<(), LabError> {
    let display = inputs::display(args.display.as_deref())?;
    let plan = inputs::plan(&inputs::study_file(&args.study)?, display.as_ref())?;
    let simulation =
        Simulation::parse(&args.simulate).map_err(|error| LabError::BadInput(format!("--simulate: {error}")))?;
    if simulation.truth.is_none() {
        return Err(LabError::BadInput(
            "--simulate pixels: expected a truth, since nothing is drawn here, found an observer who looks at pictures; \
             `run --offscreen --simulate pixels` draws them"
                .to_owned(),
        ));
    }
    let sessions = u64::from(args.observers) * u64::from(args.repeats);
    if sessions > MOST_SESSIONS {
        return Err(LabError::BadInput(format!(
            "--observers {} × --repeats {}: expected at most {MOST_SESSIONS} simulated sessions, found {sessions}",
            args.observers, args.repeats
        )));
    }
    let bar = progress::bar(sessions, "observers");
    let request = Request {
        plan,
        simulation,
        observers: args.observers,
        repeats: args.repeats,
        seed: args.seed,
        spread: args.spread,
    };
    let power = simulate(&request, &|| bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(path) = &args.figure {
        std::fs::write(path, power_figure(&power)).map_err(|error| LabError::io("write", path, &error))?;
        say(&format!("figure: {}", path.display()));
    }
    if args.json { print_json(&power) } else { print(&text(&power, args)) }
}

/// The result as tables for a terminal.
fn text(power: &Power, args: &PowerArgs) -> String {
    // Writing to a string cannot fail.
    let mut text = format!(
        "{} simulated observers ({} studies of {}), truth {}, spread {}: {} without every estimate\n",
        power.sessions, args.repeats, args.observers, args.simulate, args.spread, power.failed
    );
    if power.quantities.is_empty() {
        text.push_str("\n  This study gives nothing that could be estimated.\n");
    }
    for quantity in &power.quantities {
        let QuantityPower { quantity: what, by_trials, by_observers } = quantity;
        let unit = if what.unit.is_empty() { String::new() } else { format!(" ({})", what.unit) };
        let truth = what.truth.map_or_else(|| "no truth to compare with".to_owned(), |t| format!("truth {}", short(t)));
        let _ = writeln!(text, "\n{}{unit}, {truth}", what.label);
        let _ = writeln!(
            text,
            "  observers   trials   mean       bias ± s.e.           RMSE      95 % interval   coverage   failed"
        );
        by_trials.iter().chain(by_observers.iter().skip(1)).for_each(|point| {
            let _ = writeln!(text, "{}", line(point));
        });
    }
    text
}

fn line(point: &Point) -> String {
    let or_dash = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), short);
    let bias = match (point.bias, point.bias_se) {
        (Some(bias), Some(se)) => format!("{} ± {}", short(bias), short(se)),
        (bias, _) => or_dash(bias),
    };
    let coverage = point.coverage.map_or_else(|| "–".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    format!(
        "  {:>9}   {:>6}   {:<9}  {:<20}  {:<8}  {:<14}  {:<9}  {:>6}",
        point.observers,
        point.trials,
        short(point.mean),
        bias,
        or_dash(point.rmse),
        or_dash(point.ci_width),
        coverage,
        point.failed
    )
}

/// Four significant digits.
fn short(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let magnitude = value.abs().max(1e-12).log10().floor() as i32;
    let decimals = usize::try_from((3 - magnitude).clamp(0, 7)).unwrap_or(0);
    format!("{value:.decimals$}")
}
