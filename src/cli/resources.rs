//! `--scene` and `--renderer` by name or by file, and drawing again whenever a file changes.

use super::say;
use crate::error::LabError;
use crate::resources::add_path;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use stimuli::Registry;

/// How often files are looked at for changes.
const LOOK_EVERY: Duration = Duration::from_millis(300);

/// A registry that knows a scene and a renderer, each by the name under which it ships or by its file, and the names that
/// they have in it.
pub(super) fn registry_for(scene: &str, renderer: &str) -> Result<(Arc<Registry>, [String; 2]), LabError> {
    let mut registry = Registry::built_in();
    let catalogue = registry.catalogue();
    let mut names = [scene.to_owned(), renderer.to_owned()];
    let is_file = |name: &str| Path::new(name).exists();
    if catalogue.scene(scene).is_none() && is_file(scene) {
        names[0] = name_of(scene, &registry);
        add_path(&mut registry, &names[0], Path::new(scene), true)?;
    }
    // One folder of frames is a scene and a renderer at once.
    if scene == renderer && registry.catalogue().capture(&names[0]).is_some() {
        names[1] = names[0].clone();
    } else if catalogue.renderer(renderer).is_none() && is_file(renderer) {
        names[1] = name_of(renderer, &registry);
        add_path(&mut registry, &names[1], Path::new(renderer), false)?;
    }
    Ok((Arc::new(registry), names))
}

/// A name for a file: its own without the folder and the ending, unless that is taken.
fn name_of(file: &str, registry: &Registry) -> String {
    let stem = Path::new(file).file_stem().map_or_else(|| file.to_owned(), |stem| stem.to_string_lossy().into_owned());
    let catalogue = registry.catalogue();
    match catalogue.scene(&stem).is_some() || catalogue.renderer(&stem).is_some() {
        true => format!("{stem}-file"),
        false => stem,
    }
}

/// The files among a command's names that can be watched: a folder of frames changes with its manifest.
pub(super) fn watchable(names: &[&str]) -> Vec<PathBuf> {
    let path = |name: &&str| {
        let path = PathBuf::from(name);
        let path = if path.is_dir() { path.join(experiments::study::frames::MANIFEST) } else { path };
        path.is_file().then_some(path)
    };
    names.iter().filter_map(path).collect()
}

/// Runs `draw` now and whenever one of the files changes, until the program is ended. What is wrong with a file is said,
/// and the next change waited for.
pub(super) fn watch(files: &[PathBuf], mut draw: impl FnMut() -> Result<(), LabError>) -> Result<(), LabError> {
    if files.is_empty() {
        return Err(LabError::BadInput("--watch: expected a scene or renderer from a file, found none".to_owned()));
    }
    let mut seen = None;
    loop {
        let now: Vec<Option<(SystemTime, u64)>> = files.iter().map(|file| stamp(file)).collect();
        if seen.as_ref() != Some(&now) {
            match draw() {
                Ok(()) => {}
                Err(error) => {
                    super::report(&error);
                    say("waiting for a change");
                }
            }
            seen = Some(now);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// What tells versions of a file apart; nothing while an editor has it away.
fn stamp(file: &Path) -> Option<(SystemTime, u64)> {
    let metadata = file.metadata().ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}
