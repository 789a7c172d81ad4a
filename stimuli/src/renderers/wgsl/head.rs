//! The head of a renderer in WGSL: lines of `//!` before the first code that say what it is and what may be set.
//!
//! ```text
//! //! Colour that fades away from the gaze.
//! //! source: where the idea comes from
//! //! version: 2
//! //! parameter radius_deg [°] 0..60 = 8: Radius of the part that keeps its colour.
//! //! parameter strength [] 0..1 = 0.5: How much of the colour is gone far out.
//! //! detail: line m omega0_deg
//! ```
//!
//! A pure number has `[]`. `detail` says how the parameters decide the detail that is left, for checks and simulated
//! observers: `full`, `line M OMEGA0`, `gaussian RADIUS RATE` or `ring ECCENTRICITY WIDTH MAR`, each a parameter's name.
//! Everything else is the sentence for users.

use super::check::Faults;
use experiments::catalogue::{DetailLaw, ParameterKind, ParameterSchema};
use std::ops::Range;
use wgpu::naga;

/// The most parameters of one renderer.
const MOST_PARAMETERS: usize = 64;
/// The longest name of a parameter.
const LONGEST_NAME: usize = 64;
/// What a parameter's line looks like.
const FORM: &str = "`//! parameter NAME [UNIT] MIN..MAX = DEFAULT: ABOUT`";

/// What the head says.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Head {
    pub(super) about: String,
    pub(super) source: String,
    pub(super) version: u32,
    pub(super) parameters: Vec<ParameterSchema>,
    pub(super) detail: DetailLaw,
}

/// A part of the text with its place.
#[derive(Clone, Copy)]
struct Part<'t> {
    text: &'t str,
    /// Byte at which it begins.
    at: usize,
}

impl<'t> Part<'t> {
    fn range(self) -> Range<usize> {
        self.at..self.at + self.text.len()
    }

    fn slice(self, range: Range<usize>) -> Self {
        Self { text: &self.text[range.clone()], at: self.at + range.start }
    }

    fn trim(self) -> Self {
        let start = self.text.len() - self.text.trim_start().len();
        self.slice(start..start + self.text.trim().len())
    }

    /// What stands before and after the first `mark`, trimmed.
    fn split(self, mark: &str) -> Option<(Self, Self)> {
        let at = self.text.find(mark)?;
        Some((self.slice(0..at).trim(), self.slice(at + mark.len()..self.text.len()).trim()))
    }
}

/// Reads the head, noting every mistake.
pub(super) fn read(text: &str, faults: &mut Faults<'_>) -> Head {
    let mut head = Head { version: 1, ..Head::default() };
    let mut about: Vec<&str> = Vec::new();
    let mut detail = None;
    let mut at = 0;
    let mut in_code = false;
    for line in text.split_inclusive('\n') {
        let part = Part { text: line, at }.trim();
        at += line.len();
        let Some(said) = part.text.strip_prefix("//!") else {
            in_code |= !part.text.is_empty() && !part.text.starts_with("//");
            continue;
        };
        let said = part.slice(part.text.len() - said.len()..part.text.len()).trim();
        let word = said.text.split([' ', ':', '\t']).next().unwrap_or_default();
        let rest = said.slice(word.len()..said.text.len());
        let value = rest.text.strip_prefix(':').map(|_| rest.slice(1..rest.text.len()).trim());
        match (word, value) {
            ("parameter", _) if in_code => {
                faults.at(said.range(), "expected every parameter before the first code, found one after it");
            }
            ("parameter", _) => {
                if let Some(schema) = parameter(rest.trim(), &head.parameters, faults) {
                    head.parameters.push(schema);
                }
            }
            ("parameters" | "param" | "params", _) => {
                faults.at(said.range(), format!("expected {FORM}, found \"{word}\""));
            }
            ("source", Some(value)) => head.source = value.text.to_owned(),
            ("detail", Some(value)) => detail = Some(value),
            ("version", Some(value)) => match value.text.parse() {
                Ok(version) if version >= 1 => head.version = version,
                _ => faults.at(value.range(), format!("expected a whole number from 1, found {:?}", value.text)),
            },
            _ if !in_code => about.push(said.text),
            _ => {}
        }
    }
    if head.parameters.len() > MOST_PARAMETERS {
        let found = head.parameters.len();
        faults.at(0..0, format!("expected at most {MOST_PARAMETERS} parameters, found {found}"));
    }
    head.about = about.join(" ").trim().to_owned();
    if let Some(detail) = detail {
        head.detail = law(detail, &head.parameters, faults);
    }
    head
}

/// One parameter's line after the word `parameter`.
fn parameter(said: Part<'_>, known: &[ParameterSchema], faults: &mut Faults<'_>) -> Option<ParameterSchema> {
    let wrong = |faults: &mut Faults<'_>| {
        faults.at(said.range(), format!("expected {FORM}, found {:?}", said.text));
        None
    };
    let Some((name, rest)) = said.split("[") else { return wrong(faults) };
    let Some((unit, rest)) = rest.split("]") else { return wrong(faults) };
    let Some((bounds, rest)) = rest.split("=") else { return wrong(faults) };
    let Some((default, about)) = rest.split(":") else { return wrong(faults) };
    let Some((min, max)) = bounds.split("..") else { return wrong(faults) };

    let before = faults.count();
    check_name(name, faults);
    if known.iter().any(|schema| schema.name == name.text) {
        faults.at(name.range(), format!("expected each parameter once, found \"{}\" again", name.text));
    }
    if about.text.is_empty() {
        faults.at(said.range(), "expected a sentence about the parameter after the colon, found none");
    }
    let [low, high, value] = [min, max, default].map(|part| finite(part, faults));
    let (low, high, value) = (low?, high?, value?);
    if low >= high {
        faults.at(bounds.range(), format!("expected a range from its smaller to its larger end, found {low}..{high}"));
    } else if !(low..=high).contains(&value) {
        faults.at(default.range(), format!("expected a default from {low} to {high}, found {value}"));
    }
    let schema = ParameterSchema {
        name: name.text.to_owned(),
        about: about.text.to_owned(),
        kind: ParameterKind::Number { unit: unit.text.to_owned(), min: low, max: high, default: value },
    };
    (faults.count() == before).then_some(schema)
}

/// A number that a shader can hold.
fn finite(part: Part<'_>, faults: &mut Faults<'_>) -> Option<f64> {
    let number = part.text.parse::<f64>().ok().filter(|x| x.abs() <= f64::from(f32::MAX));
    if number.is_none() {
        faults.at(part.range(), format!("expected a number, found {:?}", part.text));
    }
    number
}

fn check_name(name: Part<'_>, faults: &mut Faults<'_>) {
    let is_plain = name.text.starts_with(|c: char| c.is_ascii_lowercase())
        && name.text.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
        && name.text.len() <= LONGEST_NAME;
    if !is_plain {
        let expected = format!("expected a name of at most {LONGEST_NAME} letters a-z, digits and _");
        faults.at(name.range(), format!("{expected}, found {:?}", name.text));
        return;
    }
    // The language's own list of words is the parser's.
    if naga::front::wgsl::parse_str(&format!("struct Parameters {{ {}: f32 }}", name.text)).is_err() {
        faults.at(name.range(), format!("expected a name that WGSL allows, found \"{}\", a word it keeps", name.text));
    }
}

/// How the parameters decide the detail that is left.
fn law(said: Part<'_>, parameters: &[ParameterSchema], faults: &mut Faults<'_>) -> DetailLaw {
    let words: Vec<&str> = said.text.split_whitespace().collect();
    let text = |word: &&str| (*word).to_owned();
    let law = match words.as_slice() {
        ["full"] => DetailLaw::Full,
        ["line", m, omega0] => DetailLaw::Line { m: text(m), omega0: text(omega0), quality_index: None },
        ["gaussian", radius, rate] => DetailLaw::Gaussian { radius: text(radius), rate: text(rate) },
        ["ring", eccentricity, width, mar] => {
            DetailLaw::Ring { eccentricity: text(eccentricity), width: text(width), mar: text(mar) }
        }
        _ => {
            let forms = "full, line M OMEGA0, gaussian RADIUS RATE or ring ECCENTRICITY WIDTH MAR";
            faults.at(said.range(), format!("expected {forms}, found {:?}", said.text));
            return DetailLaw::Unknown;
        }
    };
    for word in words.iter().skip(1) {
        if !parameters.iter().any(|schema| schema.name == *word) {
            faults.at(said.range(), format!("expected the names of parameters, found \"{word}\""));
        }
    }
    law
}
