//! Reading completed parameters. A value that is absent or of the wrong kind here is a mistake in a schema of this
//! crate, not in a study; it still becomes an error, never a panic.

use experiments::catalogue::{ParameterError, ParameterValue, Parameters};

/// The number called `name`.
pub(crate) fn number(parameters: &Parameters, name: &str) -> Result<f64, Vec<ParameterError>> {
    match parameters.get(name) {
        Some(ParameterValue::Number(value)) => Ok(*value),
        other => Err(vec![refused(name, "a number", other)]),
    }
}

/// The choice called `name`.
pub(crate) fn text<'a>(parameters: &'a Parameters, name: &str) -> Result<&'a str, Vec<ParameterError>> {
    match parameters.get(name) {
        Some(ParameterValue::Text(value)) => Ok(value),
        other => Err(vec![refused(name, "a name", other)]),
    }
}

fn refused(name: &str, expected: &str, found: Option<&ParameterValue>) -> ParameterError {
    ParameterError {
        name: name.to_owned(),
        expected: expected.to_owned(),
        found: found.map_or_else(|| "nothing".to_owned(), ToString::to_string),
    }
}
