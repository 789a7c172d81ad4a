//! The command line: one file for each command, and here what they share.
//!
//! Results go to stdout, messages and progress to stderr; with `--json` stdout holds one JSON document and nothing else.
//! Exit codes: 0 done, 1 failed, 2 bad usage or bad input.

mod analyze;
mod bench;
mod blocks;
mod check;
mod demo;
mod devices;
mod doctor;
mod export;
mod fit;
mod inputs;
mod new;
mod power;
mod predict;
mod progress;
mod render;
mod replay;
mod resources;
mod run;
mod settings;
mod together;

use crate::error::LabError;
use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// A laboratory for foveated vision: studies, gaze-contingent stimuli, durable logs, fitted acuity.
#[derive(Debug, Parser)]
#[command(name = "parafovea", version, propagate_version = true, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a study to start from.
    New(new::NewArgs),
    /// Say what a study will do, or everything that is wrong with it.
    Check(check::CheckArgs),
    /// Run a study with an observer, in a window or offscreen.
    Run(run::RunArgs),
    /// Simulate a study before recruiting: bias, error, interval width and coverage.
    Power(power::PowerArgs),
    /// Show a session's frames again, from its log alone.
    Replay(replay::ReplayArgs),
    /// Say what is wrong with sessions and what can still be used; write repaired copies.
    Doctor(doctor::DoctorArgs),
    /// Fit omega0 and m from sessions.
    Analyze(analyze::AnalyzeArgs),
    /// Fit psychometric functions to any table of level, answers and right answers.
    Fit(fit::FitArgs),
    /// Hand sessions on as tables.
    Export(export::ExportArgs),
    /// Draw one picture of a scene under a renderer.
    Render(render::RenderArgs),
    /// Measure what renderers cost, and what they save against full resolution.
    Bench(bench::BenchArgs),
    /// Layers, sampling rates and savings that follow from an acuity slope on a display.
    Predict(predict::PredictArgs),
    /// List displays, scenes, renderers and the graphics adapter.
    Devices(devices::DevicesArgs),
    /// Run the calibration with a simulated observer and see the whole idea work.
    Demo(demo::DemoArgs),
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    // Who rehearses a bad disk wants to see what is on it, and when.
    let rehearses = matches!(&command, Command::Run(args) if args.rehearses());
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_max_level(if rehearses { tracing::Level::INFO } else { tracing::Level::WARN })
        .without_time()
        .with_target(false)
        .init();
    let result = match command {
        Command::New(args) => new::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Power(args) => power::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Analyze(args) => analyze::run(&args),
        Command::Fit(args) => fit::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Predict(args) => predict::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Demo(args) => demo::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

/// Says what went wrong: mistakes in a file with the lines at fault, anything else in one sentence.
fn report(error: &LabError) {
    match error {
        LabError::Mistakes(mistakes) => say(&inputs::snippets(mistakes)),
        LabError::ManyFiles(files) => files.iter().for_each(|mistakes| say(&inputs::snippets(mistakes))),
        other => say(&format!("parafovea: {other}")),
    }
}

/// A message for people, on stderr.
fn say(message: &str) {
    // Nobody can be told when stderr itself is closed.
    let _ = writeln!(std::io::stderr(), "{message}");
}

/// A result, on stdout.
fn print(result: &str) -> Result<(), LabError> {
    match writeln!(std::io::stdout(), "{result}") {
        // A reader such as `head` that has seen enough is no failure.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(LabError::Failed(format!("cannot write the result: {error}")))
        }
        _ => Ok(()),
    }
}

/// A result as one JSON document on stdout.
fn print_json(result: &impl serde::Serialize) -> Result<(), LabError> {
    let text = serde_json::to_string_pretty(result).map_err(|error| LabError::Failed(error.to_string()))?;
    print(&text)
}
