//! Scenes and renderers in files: one source to a name, a name of its own, and whether the lab could use the file.

use super::checked_name;
use crate::catalogue::Catalogue;
use crate::study::draft::{RendererFileDraft, SceneFileDraft, StudyDraft};
use crate::study::mistakes::Report;
use crate::study::plan::{FileSource, NamedFile};
use crate::study::source::Field;
use std::collections::BTreeSet;

/// Every name that the study gives to a file, well formed or not.
pub(super) fn names(draft: &StudyDraft) -> BTreeSet<String> {
    let renderers = draft.renderers.iter().flat_map(|files| files.keys());
    renderers.chain(draft.scenes.iter().flat_map(|files| files.keys())).cloned().collect()
}

/// The files that a draft names, without those that are no file.
pub(in crate::study) fn listed(draft: &StudyDraft) -> Vec<NamedFile> {
    let renderers = draft.renderers.iter().flatten().map(|(name, file)| (name, file.as_ref().map(renderer)));
    let scenes = draft.scenes.iter().flatten().map(|(name, file)| (name, file.as_ref().map(scene)));
    let named = |(name, source): (&String, Option<Result<FileSource, String>>)| {
        Some(NamedFile { name: name.clone(), source: source?.ok()? })
    };
    renderers.chain(scenes).filter_map(named).collect()
}

/// The files that a draft names, reporting what is wrong with them.
pub(super) fn checked(draft: &StudyDraft, catalogue: &Catalogue, report: &mut Report<'_>) -> Vec<NamedFile> {
    let root = Field::root();
    let (renderers, scenes) = (root.key("renderers"), root.key("scenes"));
    for (name, file) in draft.renderers.iter().flatten() {
        check(name, file.as_ref().map(renderer), catalogue, &renderers.key(name), report);
    }
    for (name, file) in draft.scenes.iter().flatten() {
        let field = scenes.key(name);
        if draft.renderers.as_ref().is_some_and(|renderers| renderers.contains_key(name)) {
            report.at_key(&field, format!("expected a name of its own, found \"{name}\" as in renderers"));
        }
        check(name, file.as_ref().map(scene), catalogue, &field, report);
    }
    listed(draft)
}

fn check(
    name: &str,
    source: Option<Result<FileSource, String>>,
    catalogue: &Catalogue,
    field: &Field,
    report: &mut Report<'_>,
) {
    checked_name(name, field, report);
    match source {
        None => {}
        Some(Err(message)) => report.at(field, message),
        Some(Ok(source)) => {
            let is_there = !source.is_renderer() || catalogue.renderer(name).is_some();
            let is_there = is_there && (!source.is_scene() || catalogue.scene(name).is_some());
            if let Some(refused) = catalogue.refused.iter().find(|refused| refused.name == name) {
                report.at(field, refused.message.clone());
            } else if !is_there {
                report.at(field, format!("expected a {} that has been read, found none", source.what()));
            }
        }
    }
}

fn renderer(draft: &RendererFileDraft) -> Result<FileSource, String> {
    match (&draft.wgsl, &draft.frames) {
        (Some(file), None) => Ok(FileSource::Wgsl { file: file.clone() }),
        (None, Some(folder)) => Ok(FileSource::Frames { folder: folder.clone() }),
        (None, None) => Err("expected the key wgsl or frames, found neither".to_owned()),
        (Some(_), Some(_)) => Err("expected one of the keys wgsl and frames, found both".to_owned()),
    }
}

fn scene(draft: &SceneFileDraft) -> Result<FileSource, String> {
    let file = |file: &String| file.clone();
    match (&draft.gltf, &draft.environment, &draft.picture) {
        (Some(gltf), environment, None) => {
            Ok(FileSource::Gltf { file: file(gltf), environment: environment.as_ref().map(file) })
        }
        (None, Some(environment), None) => Ok(FileSource::Environment { file: file(environment) }),
        (None, None, Some(picture)) => Ok(FileSource::Picture { file: file(picture) }),
        (None, None, None) => Err("expected one of the keys gltf, environment and picture, found none".to_owned()),
        (_, _, Some(_)) => Err("expected a picture alone, found gltf or environment beside it".to_owned()),
    }
}
