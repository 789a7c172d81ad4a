//! What a study brings along: renderers in WGSL, folders of frames, pictures. They are read beside the study's own file,
//! join what is built in, and are written into the header of a session, so that a replay shows what was shown.
//!
//! A recorded session is never drawn with another version of a file: its WGSL text is the header's, and everything else
//! must still have the hash that it had.

use crate::error::LabError;
use crate::session::SessionFolder;
use crate::session::header::{FileHash, FileRecord, sha256_hex};
use crate::stage::launch::StudyFile;
use experiments::Display;
use experiments::catalogue::RefusedFile;
use experiments::study::frames::MANIFEST;
use experiments::study::plan::{FileSource, NamedFile};
use experiments::study::{self, Mistakes, Plan};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stimuli::{AddError, Registry};

/// How many folders around a session, and how many names of a recorded folder, are tried when files have moved.
const FOLDERS_AROUND: usize = 4;

/// Scenes and renderers of one study: what is built in and what the study brings along.
#[derive(Debug, Clone)]
pub struct Resources {
    /// All of them.
    pub registry: Arc<Registry>,
    files: Vec<Found>,
    /// Files with mistakes in their text.
    mistakes: Vec<Mistakes>,
}

/// A file that was read.
#[derive(Debug, Clone)]
struct Found {
    named: NamedFile,
    folder: PathBuf,
    text: Option<String>,
    /// Relative to the folder.
    contents: Vec<String>,
}

impl Resources {
    /// What is built in alone.
    #[must_use]
    pub fn built_in() -> Self {
        Self::with(Arc::new(Registry::built_in()))
    }

    /// Those of a registry, without files of a study.
    #[must_use]
    pub fn with(registry: Arc<Registry>) -> Self {
        Self { registry, files: Vec::new(), mistakes: Vec::new() }
    }

    /// Reads what a study names. Mistakes are kept for [`Resources::plan`], which reports them with the study's own.
    #[must_use]
    pub fn of(study: &StudyFile) -> Self {
        let home = Path::new(&study.file).parent().unwrap_or(Path::new(""));
        let mut registry = Registry::built_in();
        let (mut files, mut mistakes) = (Vec::new(), Vec::new());
        for named in study::named_files(&study.text) {
            match add(&mut registry, &named.name, &named.source, home, None) {
                Ok((text, contents)) => files.push(Found { folder: home.to_owned(), text, contents, named }),
                Err(error) => {
                    let message = match error {
                        AddError::Mistakes(found) => {
                            let count = found.list.len();
                            let plural = if count == 1 { "mistake" } else { "mistakes" };
                            let message =
                                format!("expected a file without mistakes, found {count} {plural} in {}", found.file);
                            mistakes.push(*found);
                            message
                        }
                        AddError::File { file, reason } => format!("{reason} ({file})"),
                        other @ (AddError::Taken { .. } | AddError::World(_)) => other.to_string(),
                    };
                    registry.refuse(RefusedFile { name: named.name, message });
                }
            }
        }
        Self { registry: Arc::new(registry), files, mistakes }
    }

    /// What a session was run with, from its header. Files may have moved with it: those that are not where they were are
    /// looked for from the session's folder, the folders around it and the current folder on, and taken if they hold what
    /// they held.
    ///
    /// # Errors
    /// Every file that is gone or not what it was, by name.
    pub fn of_session(session: &SessionFolder) -> Result<Self, LabError> {
        let here = session.path.canonicalize().unwrap_or_else(|_| session.path.clone());
        let around = here.ancestors().take(FOLDERS_AROUND).map(Path::to_owned);
        let homes: Vec<PathBuf> = around.chain(std::env::current_dir().ok()).collect();
        let found = session.header.files.iter().map(|record| found_near(record, &homes));
        Self::from_records(&found.collect::<Vec<_>>())
    }

    fn from_records(records: &[FileRecord]) -> Result<Self, LabError> {
        let mut registry = Registry::built_in();
        let changed: Vec<String> = records.iter().flat_map(changes).collect();
        if !changed.is_empty() {
            return Err(LabError::BadInput(format!(
                "the session cannot be shown again without the files that it was run with:\n{}",
                changed.join("\n")
            )));
        }
        let mut files = Vec::new();
        for FileRecord { name, source, folder, text, contents } in records.iter().cloned() {
            let folder = PathBuf::from(folder);
            add(&mut registry, &name, &source, &folder, text.as_deref())?;
            let contents = contents.into_iter().map(|content| content.path).collect();
            files.push(Found { named: NamedFile { name, source }, folder, text, contents });
        }
        Ok(Self { registry: Arc::new(registry), files, mistakes: Vec::new() })
    }

    /// The plan of a study on a display.
    ///
    /// # Errors
    /// Every mistake of the study and of the files that it names.
    pub fn plan(&self, file: &str, text: &str, display: Option<&Display>) -> Result<Plan, LabError> {
        match (study::parse_study(file, text, &self.registry.catalogue(), display), self.mistakes.is_empty()) {
            (Ok(plan), true) => Ok(plan),
            (Err(mistakes), true) => Err(mistakes.into()),
            (parsed, false) => {
                let all = parsed.err().into_iter().chain(self.mistakes.iter().cloned());
                Err(LabError::ManyFiles(all.collect()))
            }
        }
    }

    /// What the header of a session says of the files, with their hashes.
    ///
    /// # Errors
    /// When a file can no longer be read.
    pub fn records(&self) -> Result<Vec<FileRecord>, LabError> {
        self.files.iter().map(Found::record).collect()
    }

    /// The WGSL files, by the names of their renderers.
    #[must_use]
    pub fn wgsl_files(&self) -> Vec<(String, PathBuf)> {
        let wgsl = |found: &Found| match &found.named.source {
            FileSource::Wgsl { file } => Some((found.named.name.clone(), found.folder.join(file))),
            _ => None,
        };
        self.files.iter().filter_map(wgsl).collect()
    }
}

impl Found {
    fn record(&self) -> Result<FileRecord, LabError> {
        let folder = match &self.folder {
            here if here.as_os_str().is_empty() => Path::new("."),
            folder => folder.as_path(),
        };
        // A session may be looked at from anywhere.
        let folder = folder.canonicalize().map_err(|error| LabError::io("find", folder, &error))?;
        let hash = |path: &String| {
            let (bytes, sha256) = match &self.text {
                // What was read is what is drawn, whatever the file says by now.
                Some(text) if is_text(&self.named.source, path) => (text.len() as u64, sha256_hex(text.as_bytes())),
                _ => hash_of(&folder.join(path)).map_err(|error| LabError::io("read", &folder.join(path), &error))?,
            };
            Ok(FileHash { path: path.clone(), bytes, sha256 })
        };
        Ok(FileRecord {
            name: self.named.name.clone(),
            source: self.named.source.clone(),
            folder: folder.display().to_string(),
            text: self.text.clone(),
            contents: self.contents.iter().map(hash).collect::<Result<_, LabError>>()?,
        })
    }
}

/// Whether a file's text is kept whole.
fn is_text(source: &FileSource, path: &str) -> bool {
    match source {
        FileSource::Wgsl { file } => file == path,
        FileSource::Frames { folder } => inside(folder, MANIFEST) == path,
        _ => false,
    }
}

fn hash_of(path: &Path) -> std::io::Result<(u64, String)> {
    let bytes = std::fs::read(path)?;
    Ok((bytes.len() as u64, sha256_hex(&bytes)))
}

/// A record with the folder in which its files are now. A folder counts by its last names too, so that a study which was
/// moved as a whole is found beside its sessions; where nothing is found the record stays what it was.
fn found_near(record: &FileRecord, homes: &[PathBuf]) -> FileRecord {
    if changes(record).is_empty() {
        return record.clone();
    }
    let folder = Path::new(&record.folder);
    let names: Vec<_> = folder.iter().collect();
    // The folder itself, then what its last name, its last two names and so on lead to.
    let tails =
        (0..=names.len().min(FOLDERS_AROUND)).map(|count| names[names.len() - count..].iter().collect::<PathBuf>());
    let tails: Vec<PathBuf> = tails.filter(|tail| tail.is_relative()).collect();
    let places = homes.iter().flat_map(|home| tails.iter().map(move |tail| home.join(tail)));
    let mut moved = places.map(|place| FileRecord { folder: place.display().to_string(), ..record.clone() });
    moved.find(|moved| changes(moved).is_empty()).unwrap_or_else(|| record.clone())
}

/// What has happened to the files of a record since.
fn changes(record: &FileRecord) -> Vec<String> {
    let has_changed = |content: &FileHash| {
        // The text of a renderer is in the header.
        if matches!(record.source, FileSource::Wgsl { .. }) {
            return None;
        }
        let path = Path::new(&record.folder).join(&content.path);
        let what = match hash_of(&path) {
            Ok((bytes, sha256)) if (bytes, &sha256) == (content.bytes, &content.sha256) => return None,
            Ok((bytes, sha256)) => {
                format!("SHA-256 {} and {} bytes, found {sha256} and {bytes}", content.sha256, content.bytes)
            }
            Err(error) => format!("the file of SHA-256 {}, found: {error}", content.sha256),
        };
        Some(format!("{}: {}: expected {what}", record.name, path.display()))
    };
    record.contents.iter().filter_map(has_changed).collect()
}

fn inside(folder: &str, file: &str) -> String {
    format!("{}/{file}", folder.trim_end_matches('/'))
}

/// Adds a file to a registry. `text` stands for a WGSL file's own where it is given. Returns the text that is kept whole and
/// the paths of every file, relative to `home`.
fn add(
    registry: &mut Registry,
    name: &str,
    source: &FileSource,
    home: &Path,
    text: Option<&str>,
) -> Result<(Option<String>, Vec<String>), AddError> {
    match source {
        FileSource::Wgsl { file } => {
            let path = home.join(file);
            let text = text.map_or_else(|| read_wgsl(&path), |text| Ok(text.to_owned()))?;
            registry.add_wgsl(name, &text, &path.display().to_string())?;
            Ok((Some(text), vec![file.clone()]))
        }
        FileSource::Frames { folder } => {
            let added = registry.add_frames(name, &home.join(folder))?;
            let files = std::iter::once(MANIFEST.to_owned()).chain(added.files);
            Ok((Some(added.manifest), files.map(|file| inside(folder, &file)).collect()))
        }
        FileSource::Gltf { file, environment } => {
            let light = environment.as_ref().map(|environment| home.join(environment));
            for notice in registry.add_gltf(name, &home.join(file), light.as_deref())? {
                tracing::warn!("{file}: {notice}");
            }
            Ok((None, std::iter::once(file.clone()).chain(environment.clone()).collect()))
        }
        FileSource::Environment { file } => {
            registry.add_environment(name, &home.join(file))?;
            Ok((None, vec![file.clone()]))
        }
        FileSource::Picture { file } => {
            registry.add_picture(name, &home.join(file))?;
            Ok((None, vec![file.clone()]))
        }
    }
}

/// The text of a WGSL file.
///
/// # Errors
/// When it cannot be read or is not UTF-8.
pub fn read_wgsl(path: &Path) -> Result<String, AddError> {
    std::fs::read_to_string(path).map_err(|error| AddError::File {
        file: path.display().to_string(),
        reason: format!("expected a file of text in UTF-8, found: {error}"),
    })
}

/// A registry with the file or folder at `path` as the scene or renderer `name`: what it is follows from its kind.
///
/// # Errors
/// When it is none of those that are known, or cannot be used.
pub fn add_path(registry: &mut Registry, name: &str, path: &Path, as_scene: bool) -> Result<(), LabError> {
    let here = Path::new("");
    let text = path.display().to_string();
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let source = match (extension.as_str(), as_scene) {
        _ if path.is_dir() => FileSource::Frames { folder: text },
        ("wgsl", false) => FileSource::Wgsl { file: text },
        ("glb" | "gltf", true) => FileSource::Gltf { file: text, environment: None },
        ("hdr", true) => FileSource::Environment { file: text },
        ("png" | "jpg" | "jpeg" | "exr", true) => FileSource::Picture { file: text },
        (_, true) => {
            let kinds =
                "a folder of frames, a .png, .jpg or .exr picture, a .glb or .gltf model or an .hdr environment";
            return Err(LabError::BadInput(format!("--scene {text}: expected {kinds}")));
        }
        (_, false) => {
            return Err(LabError::BadInput(format!("--renderer {text}: expected a .wgsl file or a folder of frames")));
        }
    };
    Ok(add(registry, name, &source, here, None).map(|_| ())?)
}
