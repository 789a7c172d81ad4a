//! `--set NAME=VALUE` and `--size WIDTHxHEIGHT`, for the commands that draw scenes under renderers.

use experiments::catalogue::{ParameterKind, ParameterSchema, ParameterValue, Parameters};

/// One `NAME=VALUE`: a number where it reads as one, otherwise a name.
pub(super) fn assignment(text: &str) -> Result<(String, ParameterValue), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    let value = value.parse::<f64>().map_or_else(|_| ParameterValue::Text(value.to_owned()), ParameterValue::Number);
    Ok((name.trim().to_owned(), value))
}

/// Parameters of the scene, given as `scene.NAME`, and those of the renderer, given as `NAME`.
pub(super) fn of_scene_and_renderer(assignments: &[(String, ParameterValue)]) -> (Parameters, Parameters) {
    let (mut of_scene, mut of_renderer) = (Parameters::new(), Parameters::new());
    for (name, value) in assignments {
        match name.strip_prefix("scene.") {
            Some(name) => of_scene.insert(name.to_owned(), value.clone()),
            None => of_renderer.insert(name.clone(), value.clone()),
        };
    }
    (of_scene, of_renderer)
}

/// Reads numbers as names where `schemas` have a choice among names: `layers=2`.
pub(super) fn name_choices(parameters: &mut Parameters, schemas: &[ParameterSchema]) {
    for schema in schemas.iter().filter(|schema| matches!(schema.kind, ParameterKind::Choice { .. })) {
        if let Some(value) = parameters.get_mut(&schema.name)
            && let ParameterValue::Number(number) = value
        {
            *value = ParameterValue::Text(number.to_string());
        }
    }
}

/// A size in pixels, as `1920x1080`.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || "expected WIDTHxHEIGHT in pixels, as 1920x1080".to_owned();
    let (width, height) = text.split_once(['x', '×']).ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong());
    Ok([number(width)?, number(height)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments_are_numbers_or_names_of_the_scene_or_the_renderer() {
        let given = ["m=0.03", "scene.image=street", "msaa=off"].map(|text| assignment(text).unwrap());
        let (of_scene, of_renderer) = of_scene_and_renderer(&given);
        assert_eq!(of_scene["image"], ParameterValue::Text("street".to_owned()));
        assert_eq!(of_renderer["m"], ParameterValue::Number(0.03));
        assert_eq!(of_renderer["msaa"], ParameterValue::Text("off".to_owned()));
        assert!(assignment("m").is_err());
    }

    #[test]
    fn a_name_may_look_like_a_number() {
        let schemas =
            [ParameterSchema::choice("layers", &["3", "2"], ""), ParameterSchema::number("m", "", 0.0..=3.0, 1.0, "")];
        let (_, mut parameters) = of_scene_and_renderer(&["layers=2", "m=2"].map(|text| assignment(text).unwrap()));
        name_choices(&mut parameters, &schemas);
        assert_eq!(parameters["layers"], ParameterValue::Text("2".to_owned()));
        assert_eq!(parameters["m"], ParameterValue::Number(2.0));
    }

    #[test]
    fn sizes_are_two_whole_numbers() {
        assert_eq!(size("64x36"), Ok([64, 36]));
        assert_eq!(size("1920×1080"), Ok([1920, 1080]));
        for wrong in ["64", "64x", "x36", "64x36x3", "-1x5", "6.4x36"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
