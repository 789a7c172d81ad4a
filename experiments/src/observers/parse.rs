//! Reading a simulation from one line of text, as it is given on a command line.

use super::options::{DEFAULT_LAPSE, DEFAULT_WIDTH, Options};
use super::truth::{ParameterTruth, Truth};
use super::{Observer, ParametricObserver, PixelObserver};
use crate::mar::MarModel;
use crate::study::suggestion;
use std::collections::BTreeMap;

/// A simulated observer, described.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// What it can see; nothing for one that looks at the pixels.
    pub truth: Option<Truth>,
    /// How it decides.
    pub options: Options,
}

/// Why a `--simulate` text was refused: one sentence a problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", .0.join("; "))]
pub struct SimulationError(pub Vec<String>);

/// Numbers by name, with their bounds.
const NUMBERS: [(&str, f64, f64); 11] = [
    ("m", 0.0, 1.0),
    ("omega0", 1e-4, 10.0),
    ("width", 1e-3, 1e6),
    ("lapse", 0.0, 0.5),
    ("bias", -5.0, 5.0),
    ("zone", 0.0, 5.0),
    ("criterion", -5.0, 10.0),
    ("spacing", 0.05, 5.0),
    ("fatigue", 0.0, 1.0),
    ("rt", 0.05, 60.0),
    ("log", 0.0, 1.0),
];

/// All names that are not a renderer's parameter.
fn known_names() -> impl Iterator<Item = &'static str> {
    NUMBERS.into_iter().map(|(name, ..)| name).chain(["finer", "pixels"])
}

/// What has been read so far.
#[derive(Debug, Default)]
struct Reading {
    problems: Vec<String>,
    numbers: BTreeMap<&'static str, f64>,
    /// Names that were there, right or wrong.
    named: Vec<String>,
    finer_up: Option<bool>,
    /// Names that are none of ours, with their values as far as they are numbers.
    others: Vec<(String, Option<f64>)>,
}

impl Simulation {
    /// Reads a simulation.
    ///
    /// - `omega0=0.021,m=0.022`: a MAR line; also `width` (in ln omega, 0.6) and `lapse` (0.02).
    /// - `quality_index=14,width=3,finer=up`: a threshold of one renderer parameter, in its own unit; with `log=1` the width
    ///   is that of its natural logarithm.
    /// - `pixels`: one that looks at the pictures.
    ///
    /// Each may have `bias`, `zone`, `criterion`, `spacing`, `fatigue` (an hour) and `rt` (seconds); see [`Options`].
    ///
    /// # Errors
    /// One sentence for every unknown, repeated, missing or impossible entry.
    pub fn parse(text: &str) -> Result<Self, SimulationError> {
        let mut reading = Reading::default();
        for entry in text.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
            let (name, value) = entry.split_once('=').map_or((entry, ""), |(n, v)| (n.trim(), v.trim()));
            reading.take(name, value);
        }
        let truth = reading.truth();
        if !reading.problems.is_empty() {
            return Err(SimulationError(reading.problems));
        }
        let default = Options::default();
        let number = |name: &str, default: f64| reading.numbers.get(name).copied().unwrap_or(default);
        let options = Options {
            bias: number("bias", default.bias),
            zone: number("zone", default.zone),
            criterion: number("criterion", default.criterion),
            spacing: number("spacing", default.spacing),
            lapse: number("lapse", default.lapse),
            fatigue: number("fatigue", default.fatigue),
            response_s: number("rt", default.response_s),
        };
        Ok(Self { truth, options })
    }

    /// The observer, with the `observer` stream of `seed`.
    #[must_use]
    pub fn observer(&self, seed: u64) -> Box<dyn Observer> {
        match &self.truth {
            Some(truth) => Box::new(ParametricObserver::new(truth.clone(), self.options, seed)),
            None => Box::new(PixelObserver::new(self.options, seed)),
        }
    }
}

impl Reading {
    fn take(&mut self, name: &str, value: &str) {
        if self.named.iter().any(|known| known == name) {
            self.problems.push(format!("{name} is given twice"));
            return;
        }
        self.named.push(name.to_owned());
        if let Some((name, min, max)) = NUMBERS.into_iter().find(|(known, ..)| *known == name) {
            match value.parse::<f64>() {
                Ok(value) if (min..=max).contains(&value) => {
                    self.numbers.insert(name, value);
                }
                _ => self.problems.push(format!("{name}: expected a number from {min} to {max}, found \"{value}\"")),
            }
        } else if name == "finer" {
            match value {
                "up" => self.finer_up = Some(true),
                "down" => self.finer_up = Some(false),
                _ => self.problems.push(format!("finer: expected up or down, found \"{value}\"")),
            }
        } else if name == "pixels" {
            if !value.is_empty() {
                self.problems.push(format!("pixels: expected no value, found \"{value}\""));
            }
        } else {
            let may_be_parameter =
                !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
            let number = value.parse::<f64>().ok().filter(|value| value.is_finite());
            if !may_be_parameter {
                let expected: Vec<&str> = known_names().collect();
                self.problems.push(format!(
                    "\"{name}\": expected one of {} or a renderer's parameter{}",
                    expected.join(", "),
                    suggestion(name, known_names())
                ));
            } else if number.is_none() {
                self.problems.push(format!(
                    "{name}: expected the number at which it is at threshold, found \"{value}\"{}",
                    suggestion(name, known_names())
                ));
            }
            self.others.push((name.to_owned(), number));
        }
    }

    fn has(&self, name: &str) -> bool {
        self.named.iter().any(|known| known == name)
    }

    fn needs(&mut self, name: &str, example: &str) {
        if !self.has(name) {
            self.problems.push(format!("{name} is missing; expected for example {example}"));
        }
    }

    /// The truth that was described, or one more problem.
    fn truth(&mut self) -> Option<Truth> {
        let others = std::mem::take(&mut self.others);
        let number = |reading: &Self, name: &str| reading.numbers.get(name).copied();
        let (line, pixels) = (self.has("m") || self.has("omega0"), self.has("pixels"));
        if pixels {
            let belongs = ["m", "omega0", "width", "log", "finer"];
            let strange: Vec<&str> = belongs.into_iter().filter(|name| self.has(name)).collect();
            let strange = strange.into_iter().chain(others.iter().map(|(name, _)| name.as_str()));
            for name in strange.collect::<Vec<_>>() {
                self.problems.push(format!("{name}: an observer that looks at the pixels has no threshold of its own"));
            }
            return None;
        }
        if line || others.is_empty() {
            for (name, value) in &others {
                if value.is_some() {
                    self.problems.push(format!(
                        "{name}: a renderer's parameter cannot have a threshold beside m and omega0{}",
                        suggestion(name, known_names())
                    ));
                }
            }
            for name in ["log", "finer"].into_iter().filter(|name| self.has(name)).collect::<Vec<_>>() {
                self.problems.push(format!("{name}: belongs to the threshold of a renderer's parameter"));
            }
            self.needs("m", "omega0=0.021,m=0.022");
            self.needs("omega0", "omega0=0.021,m=0.022");
            return Some(Truth::Mar(MarModel {
                m: number(self, "m")?,
                omega0_deg: number(self, "omega0")?,
                width: number(self, "width").unwrap_or(DEFAULT_WIDTH),
                lapse: number(self, "lapse").unwrap_or(DEFAULT_LAPSE),
            }));
        }
        if others.len() > 1 {
            let names: Vec<&str> = others.iter().map(|(name, _)| name.as_str()).collect();
            let hints: String = names.iter().map(|name| suggestion(name, known_names())).collect();
            self.problems.push(format!(
                "{}: expected one renderer parameter, found {}{hints}",
                names.join(", "),
                names.len()
            ));
        }
        let (parameter, threshold) = others.into_iter().next()?;
        let hint = suggestion(&parameter, known_names());
        let log = match number(self, "log") {
            Some(log) if log.fract().abs() > 0.0 => {
                self.problems.push(format!("log: expected 0 or 1, found \"{log}\""));
                false
            }
            log => log.unwrap_or(0.0) > 0.5,
        };
        if log && threshold.is_some_and(|threshold| threshold <= 0.0) {
            self.problems.push(format!("{parameter}: expected a number above 0 on a logarithmic axis"));
        }
        if !log && !self.has("width") {
            self.problems.push(format!("width is missing; expected for example {parameter}=14,width=3,finer=up{hint}"));
        }
        self.needs("finer", &format!("{parameter}=14,width=3,finer=up"));
        Some(Truth::Parameter(ParameterTruth {
            parameter,
            threshold: threshold?,
            width: number(self, "width").unwrap_or(DEFAULT_WIDTH),
            finer_up: self.finer_up?,
            log,
            lapse: number(self, "lapse").unwrap_or(DEFAULT_LAPSE),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problems(text: &str) -> Vec<String> {
        Simulation::parse(text).expect_err("has faults").0
    }

    #[test]
    fn a_mar_line_is_read_with_all_its_mistakes() {
        let simulation = Simulation::parse("omega0=0.021, m=0.022,zone=0.5,rt=1").expect("valid");
        let model = MarModel { m: 0.022, omega0_deg: 0.021, width: DEFAULT_WIDTH, lapse: DEFAULT_LAPSE };
        assert_eq!(simulation.truth, Some(Truth::Mar(model)));
        assert_eq!(simulation.options, Options { zone: 0.5, response_s: 1.0, ..Options::default() });
        let found = problems("omega0=x,slope=2,lapse=0.9");
        assert_eq!(found.len(), 4, "{found:?}");
        assert_eq!(problems("m=0.02,m=0.03,omega0=0.02").len(), 1);
        assert_eq!(problems("").len(), 2);
    }

    #[test]
    fn a_parameters_threshold_is_read_with_all_its_mistakes() {
        let simulation = Simulation::parse("quality_index=14,width=3,finer=up,lapse=0.1").expect("valid");
        let truth = ParameterTruth {
            parameter: "quality_index".to_owned(),
            threshold: 14.0,
            width: 3.0,
            finer_up: true,
            log: false,
            lapse: 0.1,
        };
        assert_eq!(simulation.truth, Some(Truth::Parameter(truth)));
        assert!(Simulation::parse("rate=0.003,finer=down,log=1").is_ok());
        // Neither width nor direction can be guessed.
        assert_eq!(problems("quality_index=14").len(), 2);
        assert_eq!(problems("quality_index=x,finer=sideways,width=0").len(), 3);
        assert_eq!(problems("quality_index=14,m=0.02,omega0=0.02").len(), 1);
        assert_eq!(problems("a=1,b=2,width=1,finer=up").len(), 1);
        assert_eq!(problems("rate=0,finer=down,log=1").len(), 1);
        assert_eq!(problems("rate=1,finer=down,log=0.5,width=1").len(), 1);
    }

    #[test]
    fn misspelt_names_are_suggested() {
        assert!(problems("omega0=0.021,m=0.022,lapze=0.1")[0].contains("did you mean \"lapse\""));
        assert!(problems("Zone=1,omega0=0.021,m=0.022")[0].contains("did you mean \"zone\""));
    }

    #[test]
    fn an_observer_of_pixels_has_options_and_no_threshold() {
        let simulation = Simulation::parse("pixels,bias=0.2").expect("valid");
        assert_eq!((simulation.truth.clone(), simulation.options.bias), (None, 0.2));
        assert!(simulation.observer(1).wants_pixels());
        assert_eq!(problems("pixels,m=0.02,quality_index=3").len(), 2);
    }
}
