//! What the laboratory can show, described as data.
//!
//! `stimuli` knows scenes and renderers; this crate knows none of them by name. The lab builds a [`Catalogue`] from the
//! registries of `stimuli` and hands it to [`crate::study`], so that a study is checked against what really exists.

use crate::mar::{SIGMA_PER_MAR, slope_from_quality_index};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Everything that a study may name.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Catalogue {
    /// Scenes, in the order in which they are listed to users.
    pub scenes: Vec<SceneInfo>,
    /// Renderers, the full-resolution reference among them.
    pub renderers: Vec<RendererInfo>,
    /// Folders of frames, each of them a scene and a renderer of one name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub captures: Vec<CaptureInfo>,
    /// Names that a study gives to files which cannot be used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<RefusedFile>,
}

/// What holds for a folder of frames, whatever is set: its renderer shows its own scene alone, on a display that is not
/// smaller than the frames, since they are never scaled.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaptureInfo {
    /// The name of the scene and of the renderer.
    pub id: String,
    /// Width and height of the frames in pixels.
    pub size_px: [u32; 2],
}

/// A file that a study names and that is no scene or renderer; what is wrong in it is said apart.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RefusedFile {
    /// The name that the study gives it.
    pub name: String,
    /// What was expected and what was found.
    pub message: String,
}

/// A scene, as studies see it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneInfo {
    /// Name used in studies and on the command line.
    pub id: String,
    /// Changes whenever the same parameters would give another picture.
    pub version: u32,
    /// One sentence for users.
    pub about: String,
    /// What may be set, with units and bounds.
    pub parameters: Vec<ParameterSchema>,
    /// Whether the picture changes with the animation time.
    pub animated: bool,
}

/// A renderer, as studies see it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RendererInfo {
    /// Name used in studies and on the command line.
    pub id: String,
    /// Changes whenever the same parameters would give another picture.
    pub version: u32,
    /// One sentence for users.
    pub about: String,
    /// The work it comes from, empty for our own.
    pub source: String,
    /// What may be set, with units and bounds.
    pub parameters: Vec<ParameterSchema>,
    /// How its parameters decide the detail that is left.
    pub detail: DetailLaw,
}

/// How a renderer's parameters decide the detail that is left at an eccentricity: the finest detail in the picture, as an
/// omega in degrees per cycle.
///
/// Checks ask it whether a display can show a level at all, simulated observers whether anybody could see it. Texts are
/// names of the renderer's parameters.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "kebab-case")]
pub enum DetailLaw {
    /// Nothing is removed.
    Full,
    /// Detail finer than `mar` is removed in a ring of `width` around `eccentricity`.
    Ring {
        /// The middle of the ring, degrees.
        eccentricity: String,
        /// Its full width, degrees.
        width: String,
        /// The detail limit within it, degrees per cycle.
        mar: String,
    },
    /// omega = m e + omega0 (Guenter 2012, Eq. 1).
    Line {
        /// The slope m.
        m: String,
        /// The intercept omega0, degrees per cycle.
        omega0: String,
        /// Guenter's quality index, which sets the slope instead of `m` where it is above zero.
        quality_index: Option<String>,
    },
    /// A Gaussian whose standard deviation is `rate` · (e − `radius`) degrees beyond `radius` (Tursun 2019, Eq. 14).
    Gaussian {
        /// The radius r of the untouched part, degrees.
        radius: String,
        /// The rate k, degrees per degree.
        rate: String,
    },
    /// Pictures of a few qualities: the coarsest that is finer than the line m e + omega0, or one of them everywhere.
    Levels {
        /// Which is shown: the name of a level, or anything else for what the line says.
        show: String,
        /// The slope m.
        m: String,
        /// The intercept omega0, degrees per cycle.
        omega0: String,
        /// Each level's name and detail limit in degrees per cycle, from the finest on; the first is the reference.
        levels: Vec<(String, f64)>,
    },
    /// It cannot be said.
    #[default]
    Unknown,
}

impl DetailLaw {
    /// The finest detail left at `eccentricity_deg` in degrees per cycle, 0 where nothing is removed; nothing if it
    /// cannot be said.
    #[must_use]
    pub fn mar_deg(&self, parameters: &Parameters, eccentricity_deg: f64) -> Option<f64> {
        let number = |name: &String| match parameters.get(name) {
            Some(ParameterValue::Number(value)) => Some(*value),
            _ => None,
        };
        match self {
            Self::Full => Some(0.0),
            Self::Ring { eccentricity, width, mar } => {
                let beyond = (eccentricity_deg - number(eccentricity)?).abs() - 0.5 * number(width)?;
                Some(if beyond <= 0.0 { number(mar)? } else { 0.0 })
            }
            Self::Line { m, omega0, quality_index } => {
                let index = quality_index.as_ref().and_then(number).filter(|&index| index > 0.0);
                let slope = index.map_or_else(|| number(m), |index| Some(slope_from_quality_index(index)))?;
                Some(slope * eccentricity_deg + number(omega0)?)
            }
            Self::Gaussian { radius, rate } => {
                let sigma_deg = number(rate)? * (eccentricity_deg - number(radius)?).max(0.0);
                Some(sigma_deg / SIGMA_PER_MAR)
            }
            Self::Levels { show, m, omega0, levels } => {
                let (_, coarser) = levels.split_first()?;
                let line = number(m)? * eccentricity_deg + number(omega0)?;
                match parameters.get(show)? {
                    ParameterValue::Text(name) if levels.iter().any(|(level, _)| level == name) => {
                        Some(coarser.iter().find(|(level, _)| level == name).map_or(0.0, |(_, mar_deg)| *mar_deg))
                    }
                    _ => {
                        Some(coarser.iter().map(|(_, mar_deg)| *mar_deg).filter(|mar| *mar <= line).fold(0.0, f64::max))
                    }
                }
            }
            Self::Unknown => None,
        }
    }
}

/// One parameter of a scene or renderer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterSchema {
    /// Name, with its unit as a suffix where it has one (`eccentricity_deg`).
    pub name: String,
    /// One sentence for users.
    pub about: String,
    /// What values it takes.
    pub kind: ParameterKind,
}

/// The values a parameter takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ParameterKind {
    /// A real number.
    Number {
        /// Unit for display, empty for a pure number.
        unit: String,
        /// Smallest accepted value.
        min: f64,
        /// Largest accepted value.
        max: f64,
        /// Value when the study says nothing.
        default: f64,
    },
    /// One of a list of names.
    Choice {
        /// The names.
        options: Vec<String>,
        /// Value when the study says nothing.
        default: String,
    },
}

/// The value of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ParameterValue {
    /// A number, in the parameter's unit.
    Number(f64),
    /// A name.
    Text(String),
}

/// Values by parameter name.
pub type Parameters = BTreeMap<String, ParameterValue>;

impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value}"),
            Self::Text(value) => write!(f, "\"{value}\""),
        }
    }
}

/// Why a parameter was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name}: expected {expected}, found {found}")]
pub struct ParameterError {
    /// The parameter at fault.
    pub name: String,
    /// What would have been accepted.
    pub expected: String,
    /// What was there.
    pub found: String,
}

impl ParameterSchema {
    /// A number with its unit, bounds and default.
    #[must_use]
    pub fn number(name: &str, unit: &str, bounds: std::ops::RangeInclusive<f64>, default: f64, about: &str) -> Self {
        Self {
            name: name.to_owned(),
            about: about.to_owned(),
            kind: ParameterKind::Number { unit: unit.to_owned(), min: *bounds.start(), max: *bounds.end(), default },
        }
    }

    /// A choice among names; the first is the default.
    #[must_use]
    pub fn choice(name: &str, options: &[&str], about: &str) -> Self {
        Self {
            name: name.to_owned(),
            about: about.to_owned(),
            kind: ParameterKind::Choice {
                options: options.iter().map(|&o| o.to_owned()).collect(),
                default: options.first().map_or_else(String::new, |&o| o.to_owned()),
            },
        }
    }

    /// The value when none is given.
    #[must_use]
    pub fn default_value(&self) -> ParameterValue {
        match &self.kind {
            ParameterKind::Number { default, .. } => ParameterValue::Number(*default),
            ParameterKind::Choice { default, .. } => ParameterValue::Text(default.clone()),
        }
    }

    /// What the parameter accepts, in words.
    #[must_use]
    pub fn expectation(&self) -> String {
        match &self.kind {
            ParameterKind::Number { unit, min, max, .. } => {
                let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
                format!("a number from {min} to {max}{unit}")
            }
            ParameterKind::Choice { options, .. } => format!("one of {}", options.join(", ")),
        }
    }

    /// Checks one value.
    ///
    /// # Errors
    /// When the value is of the wrong kind or out of bounds.
    pub fn check(&self, value: &ParameterValue) -> Result<(), ParameterError> {
        let accepted = match (&self.kind, value) {
            (ParameterKind::Number { min, max, .. }, ParameterValue::Number(value)) => (*min..=*max).contains(value),
            (ParameterKind::Choice { options, .. }, ParameterValue::Text(value)) => options.contains(value),
            _ => false,
        };
        if accepted {
            Ok(())
        } else {
            Err(ParameterError { name: self.name.clone(), expected: self.expectation(), found: value.to_string() })
        }
    }
}

/// Fills in defaults and checks every value against `schemas`.
///
/// # Errors
/// One [`ParameterError`] for each unknown name and each refused value.
pub fn complete_parameters(schemas: &[ParameterSchema], given: &Parameters) -> Result<Parameters, Vec<ParameterError>> {
    let mut errors: Vec<ParameterError> = given
        .iter()
        .filter_map(|(name, value)| match schemas.iter().find(|schema| &schema.name == name) {
            Some(schema) => schema.check(value).err(),
            None => Some(ParameterError {
                name: name.clone(),
                expected: format!(
                    "one of the parameters {}",
                    schemas.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ")
                ),
                found: format!("the unknown name \"{name}\""),
            }),
        })
        .collect();
    if errors.is_empty() {
        let mut complete = given.clone();
        for schema in schemas {
            complete.entry(schema.name.clone()).or_insert_with(|| schema.default_value());
        }
        Ok(complete)
    } else {
        errors.sort_by(|a, b| a.name.cmp(&b.name));
        Err(errors)
    }
}

impl Catalogue {
    /// The scene of this name.
    #[must_use]
    pub fn scene(&self, id: &str) -> Option<&SceneInfo> {
        self.scenes.iter().find(|scene| scene.id == id)
    }

    /// The renderer of this name.
    #[must_use]
    pub fn renderer(&self, id: &str) -> Option<&RendererInfo> {
        self.renderers.iter().find(|renderer| renderer.id == id)
    }

    /// The folder of frames of this name.
    #[must_use]
    pub fn capture(&self, id: &str) -> Option<&CaptureInfo> {
        self.captures.iter().find(|capture| capture.id == id)
    }

    /// Why a scene cannot be shown by a renderer on a display of `resolution_px`, as "expected …, found …"; nothing where
    /// it can.
    #[must_use]
    pub fn mismatch(&self, scene: &str, renderer: &str, resolution_px: Option<[u32; 2]>) -> Option<String> {
        if self.capture(renderer).is_some() && scene != renderer {
            return Some(format!(
                "expected the scene \"{renderer}\", whose frames the renderer \"{renderer}\" shows, found \"{scene}\""
            ));
        }
        let (capture, [width, height]) = self.capture(scene).zip(resolution_px)?;
        let [frame_width, frame_height] = capture.size_px;
        (frame_width > width || frame_height > height).then(|| {
            format!(
                "expected frames of at most {width}×{height} pixels, the display's own, since they are never scaled, \
                 found frames of {frame_width}×{frame_height}"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schemas() -> Vec<ParameterSchema> {
        vec![
            ParameterSchema::number("mar_deg", "°/cycle", 0.01..=10.0, 0.1, "detail limit"),
            ParameterSchema::choice("image", &["coffee", "chelsea"], "photograph"),
        ]
    }

    #[test]
    fn defaults_fill_what_is_not_given() {
        let given = Parameters::from([("mar_deg".to_owned(), ParameterValue::Number(0.5))]);
        let complete = complete_parameters(&schemas(), &given).expect("valid");
        assert_eq!(complete["mar_deg"], ParameterValue::Number(0.5));
        assert_eq!(complete["image"], ParameterValue::Text("coffee".to_owned()));
    }

    /// Levels of 0.1 and 0.4° per cycle on the line 0.02 e + 0.02: the first from 4° on, the second from 19°.
    #[test]
    fn levels_begin_where_the_line_reaches_them() {
        let text = |text: &str| text.to_owned();
        let law = DetailLaw::Levels {
            show: text("show"),
            m: text("m"),
            omega0: text("omega0_deg"),
            levels: vec![(text("reference"), 0.05), (text("half"), 0.1), (text("quarter"), 0.4)],
        };
        let shown = |show: &str, e: f64| {
            let mut set = Parameters::from([(text("show"), ParameterValue::Text(text(show)))]);
            set.insert(text("m"), ParameterValue::Number(0.02));
            set.insert(text("omega0_deg"), ParameterValue::Number(0.02));
            law.mar_deg(&set, e).expect("is known")
        };
        let along: Vec<f64> = [0.0, 3.9, 4.1, 18.9, 19.1, 60.0].map(|e| shown("foveated", e)).to_vec();
        assert_eq!(along, [0.0, 0.0, 0.1, 0.1, 0.4, 0.4]);
        assert_eq!([shown("reference", 60.0), shown("half", 0.0), shown("quarter", 0.0)], [0.0, 0.1, 0.4]);
    }

    #[test]
    fn every_refusal_is_reported() {
        let given = Parameters::from([
            ("mar_deg".to_owned(), ParameterValue::Number(f64::NAN)),
            ("image".to_owned(), ParameterValue::Number(1.0)),
            ("colour".to_owned(), ParameterValue::Text("red".to_owned())),
        ]);
        let errors = complete_parameters(&schemas(), &given).expect_err("three faults");
        assert_eq!(errors.len(), 3);
        assert!(errors.iter().any(|e| e.expected.contains("0.01 to 10 °/cycle")));
    }
}
