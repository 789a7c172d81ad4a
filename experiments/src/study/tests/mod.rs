//! Tests of the whole way from text to plan, against a catalogue made by hand.

mod designs;
mod hostile;
mod kinds;
mod machines;
mod plans;
mod procedures;
mod protocols;
mod shipped;

use super::{Mistakes, Plan, parse_study};
use crate::catalogue::{Catalogue, DetailLaw, ParameterSchema, RendererInfo, SceneInfo};

/// The scenes and renderers that the shipped studies name, without `stimuli`.
pub(crate) fn catalogue() -> Catalogue {
    let scene = |id: &str, parameters| SceneInfo {
        id: id.to_owned(),
        version: 1,
        about: String::new(),
        parameters,
        animated: false,
    };
    let renderer = |id: &str, parameters| RendererInfo {
        id: id.to_owned(),
        version: 1,
        about: String::new(),
        source: String::new(),
        parameters,
        detail: match id {
            "ring" => DetailLaw::Ring {
                eccentricity: "eccentricity_deg".to_owned(),
                width: "width_deg".to_owned(),
                mar: "mar_deg".to_owned(),
            },
            _ => DetailLaw::Full,
        },
    };
    Catalogue {
        scenes: vec![
            scene(
                "photo",
                vec![
                    ParameterSchema::choice("image", &["gravel", "chelsea", "coffee", "grass"], "photograph"),
                    ParameterSchema::number("scale", "px/px", 0.25..=16.0, 1.0, "display pixels per its pixel"),
                ],
            ),
            scene("noise", vec![]),
        ],
        renderers: vec![
            renderer("reference", vec![]),
            renderer(
                "ring",
                vec![
                    ParameterSchema::number("eccentricity_deg", "°", 0.0..=60.0, 5.0, "where the ring is"),
                    ParameterSchema::number("width_deg", "°", 0.0..=60.0, 4.0, "how wide it is"),
                    ParameterSchema::number("edge_deg", "°", 0.0..=20.0, 0.5, "how soft its edges are"),
                    ParameterSchema::number("mar_deg", "°/cycle", 0.005..=20.0, 0.5, "detail limit"),
                ],
            ),
        ],
        ..Catalogue::default()
    }
}

/// A small study without a mistake; the line numbers of the tests count in it.
pub(crate) const STUDY: &str = r#"{
  "format": 1,
  "name": "small",
  "title": "A small study",
  "display": "tursun-2019-27in",
  "gaze": {
    "fixation_deg": [0, 0],
    "gate_deg": 2.0,
    "gate_grace_s": 0.1
  },
  "conditions": {
    "photo": {
      "scene": "photo",
      "scene_parameters": { "image": "coffee" },
      "renderer": "ring",
      "renderer_parameters": { "width_deg": 4 }
    }
  },
  "blocks": [
    {
      "name": "practice",
      "practice": true,
      "condition": "photo",
      "protocol": {
        "kind": "two-interval",
        "fixation_s": 0.5,
        "interval_s": 0.3,
        "gap_s": 0.3
      },
      "procedure": {
        "kind": "constant",
        "levels": {
          "eccentricity_deg": [5, 10],
          "mar_deg": [1.5, 2.5, 3]
        },
        "repetitions": 4
      }
    },
    {
      "name": "main",
      "condition": "photo",
      "break_every_trials": 60,
      "protocol": { "kind": "two-interval", "fixation_s": 0.4, "interval_s": 0.2, "gap_s": 0.25 },
      "procedure": {
        "kind": "quest-plus",
        "eccentricity": { "values": [0, 5, 10] },
        "mar": { "min": 0.05, "max": 3.0, "steps": 24 },
        "prior": {
          "m": { "min": 0.005, "max": 0.08, "steps": 10 },
          "lapse": [0, 0.02]
        },
        "stop": { "max_trials": 240, "min_trials": 80, "m_relative_sd": 0.08 }
      }
    }
  ]
}
"#;

/// The study with each `(old, new)` put in; every `old` must be there, once.
fn edited(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(STUDY.to_owned(), |text, (old, new)| {
        assert_eq!(text.matches(old).count(), 1, "{old} must occur once");
        text.replace(old, new)
    })
}

pub(crate) fn parse(text: &str) -> Result<Plan, Mistakes> {
    parse_study("study.json", text, &catalogue(), None)
}

/// The mistakes of a text as `(line, field, message)`.
fn mistakes(text: &str) -> Vec<(usize, String, String)> {
    let mistakes = parse(text).expect_err("a mistake");
    mistakes.list.into_iter().map(|m| (m.line, m.field, m.message)).collect()
}

/// The only mistake of the study after the edits.
fn only(edits: &[(&str, &str)]) -> (usize, String, String) {
    let mut found = mistakes(&edited(edits));
    assert_eq!(found.len(), 1, "{found:#?}");
    found.remove(0)
}

/// Asserts that the edits make one mistake, at this line and field, with these words in its message.
#[track_caller]
fn assert_only(edits: &[(&str, &str)], line: usize, field: &str, words: &[&str]) {
    let (found_line, found_field, message) = only(edits);
    assert_eq!((found_line, found_field.as_str()), (line, field), "{message}");
    assert!(message.starts_with("expected "), "{message}");
    for word in words {
        assert!(message.contains(word), "{word:?} is not in {message:?}");
    }
}
