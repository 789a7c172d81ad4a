//! An export is whole or not there: it is written to a new folder beside the target and moved there at the end.

use crate::error::LabError;
use std::fs;
use std::path::{Path, PathBuf};

/// Lets `write` fill a new folder, which becomes `out` if it succeeds and is taken away again if it does not.
///
/// # Errors
/// When `out` is a file or holds something already, when a folder cannot be made or moved, and what `write` says.
pub fn whole<T>(out: &Path, write: impl FnOnce(&Path) -> Result<T, LabError>) -> Result<T, LabError> {
    let occupied = fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_some());
    if occupied || out.is_file() {
        return Err(LabError::BadInput(format!("--out {}: expected a new or empty folder", out.display())));
    }
    let partial = out.with_file_name(format!(
        ".{}.partial-{}",
        out.file_name().map_or_else(|| "export".into(), |name| name.to_string_lossy()),
        std::process::id()
    ));
    fs::create_dir_all(&partial).map_err(|error| LabError::io("make", &partial, &error))?;
    let written = write(&partial).and_then(|written| {
        if out.exists() {
            fs::remove_dir(out).map_err(|error| LabError::io("replace", out, &error))?;
        }
        fs::rename(&partial, out).map_err(|error| LabError::io("make", out, &error))?;
        Ok(written)
    });
    if written.is_err() {
        // The error that is returned says what went wrong; a leftover folder is only untidy.
        let _ = fs::remove_dir_all(&partial);
    }
    written
}

/// Writes a text file, with the folders above it.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn text(path: &Path, text: &str) -> Result<(), LabError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| LabError::io("make", folder, &error))?;
    }
    fs::write(path, text).map_err(|error| LabError::io("write", path, &error))
}

/// Writes a JSON file, indented, with the folders above it.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn json(path: &Path, value: &serde_json::Value) -> Result<(), LabError> {
    let whole = serde_json::to_string_pretty(value).map_err(|error| LabError::Failed(error.to_string()))?;
    text(path, &(whole + "\n"))
}

/// The paths as they are once the folder has been moved to `out`.
pub(crate) fn moved(written: Vec<(PathBuf, usize)>, out: &Path) -> Vec<(PathBuf, usize)> {
    written.into_iter().map(|(path, rows)| (out.join(path), rows)).collect()
}
