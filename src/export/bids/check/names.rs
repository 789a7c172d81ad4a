//! Names of files: entities in their order, labels of letters and digits, and folders that agree with them.

use super::Check;

/// Entities that we use, in the order in which the standard has them.
const ORDER: [&str; 4] = ["sub", "ses", "task", "recording"];
/// What a name may end with.
const ENDS: [&str; 6] =
    ["events.tsv", "events.json", "physio.tsv.gz", "physio.json", "physioevents.tsv.gz", "physioevents.json"];

impl Check<'_> {
    pub(super) fn names(&mut self) {
        let files: Vec<String> = self.files.iter().filter(|file| file.starts_with("sub-")).cloned().collect();
        for file in files {
            for what in name_problems(&file) {
                self.problem(&file, what);
            }
        }
    }
}

/// What is wrong with a path below an observer's folder.
pub(super) fn name_problems(file: &str) -> Vec<String> {
    let mut problems = Vec::new();
    let parts: Vec<&str> = file.split('/').collect();
    let (folders, name) = parts.split_at(parts.len() - 1);
    let name = name[0];
    let subject = folders[0];
    // What an observer's sessions were stands in a table of its own.
    if folders.len() == 1 && [".tsv", ".json"].iter().any(|end| name == format!("{subject}_sessions{end}")) {
        return problems;
    }
    let mut pieces: Vec<&str> = name.split('_').collect();
    let end = pieces.pop().unwrap_or_default();
    if !ENDS.contains(&end) {
        problems.push(format!("\"{end}\" is no kind of file that belongs here"));
    }
    let mut last = None;
    let (mut folder, mut has_task, mut has_recording) = (Vec::new(), false, false);
    for piece in pieces {
        let Some((key, label)) = piece.split_once('-') else {
            problems.push(format!("\"{piece}\" is no entity"));
            continue;
        };
        let place = ORDER.iter().position(|known| *known == key);
        if place.is_none() || place <= last {
            problems.push(format!("the entity {key} is unknown, repeated or out of order"));
        }
        last = place.max(last);
        if label.is_empty() || !label.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
            problems.push(format!("the label \"{label}\" has more than letters and digits"));
        }
        match key {
            "sub" | "ses" => folder.push(piece.to_owned()),
            "task" => has_task = true,
            "recording" => has_recording = true,
            _ => {}
        }
    }
    folder.push("beh".to_owned());
    if folder != folders {
        problems.push(format!("is not in {}", folder.join("/")));
    }
    if !has_task {
        problems.push("the entity task is missing".to_owned());
    }
    // Required for eye tracking, which the validator forgets.
    if end.starts_with("physio") != has_recording {
        let what = if has_recording { "does not belong here" } else { "is missing" };
        problems.push(format!("the entity recording {what}"));
    }
    problems
}
