//! `parafovea fit`: psychometric functions from any table of levels, answers and right answers.
//!
//! The model and the priors are psignifit's unless told otherwise: overdispersed counts, a free lapse rate, and the guess
//! rate of the number of alternatives. Groups of rows are fitted side by side.

mod answer;
mod table;

use super::{inputs, print, print_json, progress, say};
use crate::error::LabError;
use analysis::psychometric::{
    Direction, Guess, Lapse, Overdispersion, Parameter, PsychometricConfig, Scale, Sigmoid, compare,
};
use answer::{Document, FitAnswer};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use table::{Columns, Group};

#[derive(Debug, Args)]
pub(super) struct FitArgs {
    /// A table with a header line: a level, how many answers and how many right ones in each row, or one answer a row in a
    /// column `correct`.
    #[arg(value_name = "DATA.csv")]
    table: PathBuf,
    /// The column of levels.
    #[arg(long, value_name = "NAME", default_value = "level")]
    level: String,
    /// The column of numbers of answers.
    #[arg(long, value_name = "NAME", default_value = "n")]
    n: String,
    /// The column of numbers of right answers.
    #[arg(long, value_name = "NAME", default_value = "k")]
    k: String,
    /// The column of single answers, for tables with one a row.
    #[arg(long, value_name = "NAME", default_value = "correct")]
    correct: String,
    /// Columns whose values tell the functions apart, such as observer,condition; one function each.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    group: Vec<String>,
    /// The function's shape.
    #[arg(long, default_value = "gauss")]
    sigmoid: Shape,
    /// Degrees of freedom of Student's t.
    #[arg(long, value_name = "DF", default_value_t = 1.0)]
    df: f64,
    /// The axis on which the function has its shape.
    #[arg(long, default_value = "linear")]
    axis: AxisArg,
    /// Whether right answers become more or less frequent as the level grows; `auto` lets the data decide.
    #[arg(long, default_value = "auto")]
    direction: DirectionArg,
    /// Alternatives of a forced choice, of which one is right.
    #[arg(long, value_name = "COUNT", default_value_t = 2, value_parser = clap::value_parser!(u32).range(2..=1000))]
    alternatives: u32,
    /// Yes or no was asked: the guess rate is free (the same as --guess free).
    #[arg(long, conflicts_with_all = ["alternatives", "guess"])]
    yes_no: bool,
    /// The guess rate: a number, `free`, or `lapse` for the same as the lapse rate.
    #[arg(long, value_name = "RATE", conflicts_with = "alternatives", value_parser = guess)]
    guess: Option<Guess>,
    /// The lapse rate: a number, or `free`.
    #[arg(long, value_name = "RATE", default_value = "free", value_parser = lapse)]
    lapse: Lapse,
    /// Take answers of one row as independent: no overdispersion.
    #[arg(long)]
    independent: bool,
    /// Lowest and highest level that could be shown, for the priors; otherwise those in the table.
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// Also the level and the slope at these shares of right answers.
    #[arg(long, value_name = "SHARE,...", value_delimiter = ',', value_parser = share)]
    at: Vec<f64>,
    /// Test whether the groups share these parameters; all that is not tested but the lapse rate is each group's own.
    #[arg(long, value_name = "PARAMETER,...", value_delimiter = ',')]
    compare: Vec<ParameterArg>,
    /// Simulated data sets behind the deviance's p.
    #[arg(long, value_name = "COUNT", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    simulations: u32,
    /// Seed of the simulated data sets.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write a page with the curves, the tables and the JSON document.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the curves as an SVG file.
    #[arg(long, value_name = "FILE.svg")]
    figure: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Shape {
    /// Cumulative Gaussian.
    Gauss,
    /// Logistic.
    Logistic,
    /// Gumbel; on a logarithmic axis, Weibull.
    Gumbel,
    /// Reversed Gumbel.
    Rgumbel,
    /// Weibull.
    Weibull,
    /// Hyperbolic secant.
    Secant,
    /// Cumulative Student's t.
    Student,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum AxisArg {
    /// The level itself.
    Linear,
    /// Its logarithm.
    Log,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum DirectionArg {
    /// Rising, unless the answers fall by more than chance would make them.
    Auto,
    /// Rising.
    Rises,
    /// Falling.
    Falls,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ParameterArg {
    /// The threshold.
    Threshold,
    /// The width.
    Width,
}

impl From<ParameterArg> for Parameter {
    fn from(parameter: ParameterArg) -> Self {
        match parameter {
            ParameterArg::Threshold => Self::Threshold,
            ParameterArg::Width => Self::Width,
        }
    }
}

fn number_in(text: &str, from: f64, below: f64) -> Option<f64> {
    text.parse::<f64>().ok().filter(|value| (from..below).contains(value))
}

fn guess(text: &str) -> Result<Guess, String> {
    match text {
        "free" => Ok(Guess::Free),
        "lapse" => Ok(Guess::EqualToLapse),
        _ => number_in(text, 0.0, 1.0)
            .map(Guess::Fixed)
            .ok_or_else(|| "expected `free`, `lapse`, or a rate from 0 to below 1".to_owned()),
    }
}

fn lapse(text: &str) -> Result<Lapse, String> {
    match text {
        "free" => Ok(Lapse::Free),
        _ => number_in(text, 0.0, 1.0)
            .map(Lapse::Fixed)
            .ok_or_else(|| "expected `free` or a rate from 0 to below 1".to_owned()),
    }
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let ends: Vec<f64> = text.split(',').filter_map(|end| end.trim().parse().ok()).collect();
    match ends.as_slice() {
        &[low, high] if text.split(',').count() == 2 && low < high && (high - low).is_finite() => Ok([low, high]),
        _ => Err("expected two rising numbers such as 0.5,8".to_owned()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    number_in(text, f64::MIN_POSITIVE, 1.0).ok_or_else(|| "expected a share between 0 and 1, such as 0.75".to_owned())
}

impl FitArgs {
    fn columns(&self) -> Columns {
        Columns {
            level: self.level.clone(),
            n: self.n.clone(),
            k: self.k.clone(),
            correct: self.correct.clone(),
            group: self.group.clone(),
        }
    }

    /// How a group is fitted; the direction may be the data's.
    fn config(&self, group: &Group) -> PsychometricConfig {
        let counts = &group.counts;
        let guess = match self.guess {
            Some(guess) => guess,
            None if self.yes_no => Guess::Free,
            None => Guess::of_alternatives(self.alternatives),
        };
        // Single answers cannot tell overdispersion.
        let blocks = counts.iter().any(|count| count.n > 1);
        PsychometricConfig {
            sigmoid: match self.sigmoid {
                Shape::Gauss => Sigmoid::CumulativeGauss,
                Shape::Logistic => Sigmoid::Logistic,
                Shape::Gumbel => Sigmoid::Gumbel,
                Shape::Rgumbel => Sigmoid::ReversedGumbel,
                Shape::Weibull => Sigmoid::Weibull,
                Shape::Secant => Sigmoid::HyperbolicSecant,
                Shape::Student => Sigmoid::StudentT { df: self.df },
            },
            scale: match self.axis {
                AxisArg::Linear => Scale::Linear,
                AxisArg::Log => Scale::Logarithmic,
            },
            direction: match self.direction {
                DirectionArg::Auto => Direction::of_decided_counts(counts),
                DirectionArg::Rises => Direction::Rises,
                DirectionArg::Falls => Direction::Falls,
            },
            guess,
            lapse: self.lapse,
            overdispersion: if blocks && !self.independent { Overdispersion::Free } else { Overdispersion::None },
            range: self.range,
            ..PsychometricConfig::TWO_ALTERNATIVES
        }
    }
}

pub(super) fn run(args: &FitArgs) -> Result<(), LabError> {
    let file = args.table.display().to_string();
    let text = inputs::read_text(&file)?;
    let groups = table::read(&file, &text, &args.columns()).map_err(|mistakes| {
        let lines: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
        LabError::BadInput(lines.join("\n"))
    })?;

    let bar = progress::bar(groups.len() as u64, "functions");
    let options = answer::Options { at: &args.at, simulations: args.simulations as usize, seed: args.seed };
    let fitted = answer::fit_all(&groups, |group| args.config(group), &options, &bar);
    bar.finish_and_clear();
    let mut refusals = Vec::new();
    let mut fits: Vec<FitAnswer> = Vec::new();
    for (group, fit) in groups.iter().zip(fitted) {
        match fit {
            Ok(fit) => fits.push(fit),
            Err(error) => {
                let name = answer::name(group).map_or_else(String::new, |name| format!(" group {name}:"));
                refusals.push(format!("{file}:{name} {error}"));
            }
        }
    }
    if !refusals.is_empty() {
        return Err(LabError::BadInput(refusals.join("\n")));
    }
    let comparison = compared(args, &groups, &fits)?;
    let document = Document::new(fits, comparison);
    write_pages(args, &document)?;
    if args.json {
        return print_json(&document);
    }
    if args.simulations == 0 {
        say("no simulations: deviances have no p");
    }
    print(&document.text())
}

fn compared(
    args: &FitArgs,
    groups: &[Group],
    fits: &[FitAnswer],
) -> Result<Option<analysis::psychometric::Comparison>, LabError> {
    if args.compare.is_empty() {
        return Ok(None);
    }
    if groups.len() < 2 {
        return Err(LabError::BadInput(
            "--compare: expected at least two groups (--group NAME), found one function".to_owned(),
        ));
    }
    let config = *fits[0].config();
    if fits.iter().any(|fit| fit.config().direction != config.direction) {
        return Err(LabError::BadInput(
            "--compare: some groups rise and others fall; expected one --direction for all".to_owned(),
        ));
    }
    let counts: Vec<&[analysis::psychometric::Count]> = groups.iter().map(|group| group.counts.as_slice()).collect();
    let tested: Vec<Parameter> = args.compare.iter().map(|&parameter| parameter.into()).collect();
    let common = [Parameter::Lapse, Parameter::Guess, Parameter::Overdispersion];
    compare(&counts, &config, &tested, &common).map(Some).map_err(|error| LabError::BadInput(error.to_string()))
}

/// The page and the figure that were asked for.
fn write_pages(args: &FitArgs, document: &Document) -> Result<(), LabError> {
    let write = |path: &PathBuf, text: &str, what: &str| {
        std::fs::write(path, text).map_err(|error| LabError::io("write", path, &error))?;
        say(&format!("{what}: {}", path.display()));
        Ok::<(), LabError>(())
    };
    if args.report.is_none() && args.figure.is_none() {
        return Ok(());
    }
    let section = document.section(&args.level);
    if let Some(path) = &args.figure {
        let svg = section.figures.first().map_or("", |figure| figure.svg.as_str());
        write(path, svg, "figure")?;
    }
    if let Some(path) = &args.report {
        write(path, &document.page(&args.table.display().to_string(), section)?, "report")?;
    }
    Ok(())
}
