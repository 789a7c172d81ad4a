//! The manifest of a folder of frames that another engine rendered: what is in it, at what size and speed, and how good
//! each of its levels is.
//!
//! A folder holds the same frames several times: once as they are at full quality, the reference, and once for each level
//! of quality, from the finest to the coarsest. This module reads `manifest.json` and knows which file holds which frame;
//! it opens none of them.

use super::draft::NAME_PATTERN;
use super::mistakes::{Mistakes, Report};
use super::source::Field;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeSet;

/// The version of the manifest's format that this program reads.
pub const FRAMES_FORMAT: u32 = 1;
/// The manifest's name in its folder.
pub const MANIFEST: &str = "manifest.json";
/// The most levels of one folder beside the reference.
pub const MOST_LEVELS: usize = 15;
/// The name of the reference among the levels.
pub const REFERENCE: &str = "reference";
/// What the renderer shows where no single level is asked for.
pub const FOVEATED: &str = "foveated";

/// A folder of frames: the same pictures at full quality and at coarser levels.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Parafovea frames")]
pub struct FramesDraft {
    /// Where editors find this schema.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// Version of the format: 1.
    #[schemars(required, extend("const" = 1))]
    pub format: Option<u32>,
    /// One sentence for users.
    pub about: Option<String>,
    /// What made the frames: engine, version, settings, paper.
    pub source: Option<String>,
    /// Width and height of every frame in pixels. A frame's pixel is a pixel of the display.
    #[schemars(required, inner(range(min = 1, max = 16384)))]
    pub size_px: Option<[u32; 2]>,
    /// Frames per second.
    #[schemars(required, range(max = 1000.0), extend("exclusiveMinimum" = 0))]
    pub fps: Option<f64>,
    /// How many frames there are of every level.
    #[schemars(required, range(min = 1, max = 100000))]
    pub frames: Option<u32>,
    /// The number of the first frame in file names; 0 when absent.
    #[schemars(range(max = 1000000))]
    pub first: Option<u32>,
    /// What the files' values are: "srgb" or "linear" light. PNG is sRGB and EXR linear when absent.
    pub colour: Option<Colour>,
    /// What follows the last frame: the first one again ("loop", when absent), or itself ("hold").
    pub end: Option<End>,
    /// The frames at full quality.
    #[schemars(required)]
    pub reference: Option<ReferenceDraft>,
    /// The coarser levels, from the finest on.
    #[schemars(required, length(min = 1, max = 15))]
    pub levels: Option<Vec<Option<LevelDraft>>>,
}

/// Where the frames at full quality are.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceDraft {
    /// The files, relative to the folder, with the frame's number as {frame} or, with leading zeros, {frame:04}.
    #[schemars(required)]
    pub files: Option<String>,
    /// The finest detail that the frames carry, degrees per cycle. If one level states it, all must.
    #[schemars(range(max = 90.0), extend("exclusiveMinimum" = 0))]
    pub mar_deg: Option<f64>,
}

/// One coarser level.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LevelDraft {
    /// Its name: a-z, 0-9 and hyphens.
    #[schemars(required, extend("pattern" = NAME_PATTERN))]
    pub name: Option<String>,
    /// The files, relative to the folder, with the frame's number as {frame} or, with leading zeros, {frame:04}.
    #[schemars(required)]
    pub files: Option<String>,
    /// The finest detail that the frames carry, degrees per cycle. If one level states it, all must.
    #[schemars(range(max = 90.0), extend("exclusiveMinimum" = 0))]
    pub mar_deg: Option<f64>,
}

/// What the values of a picture file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Colour {
    /// Encoded for an sRGB display.
    Srgb,
    /// Proportional to light; 1 is the most that the display shows.
    Linear,
}

/// What follows the last frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// The first frame.
    #[default]
    Loop,
    /// The last frame, for as long as it is shown.
    Hold,
}

/// A checked manifest.
#[derive(Debug, Clone, PartialEq)]
pub struct Frames {
    /// One sentence for users, may be empty.
    pub about: String,
    /// What made the frames, may be empty.
    pub source: String,
    /// Width and height of every frame, pixels.
    pub size_px: [u32; 2],
    /// Frames per second.
    pub fps: f64,
    /// Frames of every level, at least 1.
    pub count: u32,
    /// Number of the first frame in file names.
    pub first: u32,
    /// What the values are, where the manifest says it.
    pub colour: Option<Colour>,
    /// What follows the last frame.
    pub end: End,
    /// The levels from the finest on; the first is the reference.
    pub levels: Vec<FrameLevel>,
}

/// One level of quality.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameLevel {
    /// Its name.
    pub name: String,
    /// Its files.
    pub files: FilePattern,
    /// The finest detail it carries, degrees per cycle; all levels have it or none.
    pub mar_deg: Option<f64>,
}

impl Frames {
    /// The frame, from 0, that is shown at a time on the scene's clock in seconds.
    #[must_use]
    pub fn at(&self, animation_s: f64) -> u32 {
        // A display's frame times are sums of intervals: one that falls short of a frame by rounding counts as in it.
        let frame = (animation_s * self.fps + 1e-6).floor();
        let count = f64::from(self.count);
        let within = match self.end {
            End::Loop => frame.rem_euclid(count),
            End::Hold => frame.clamp(0.0, count - 1.0),
        };
        // Within 0..count, so that nothing is cut off; NaN becomes 0.
        within as u32
    }

    /// The file of a frame, from 0, relative to the folder.
    #[must_use]
    pub fn file(&self, level: usize, frame: u32) -> Option<String> {
        Some(self.levels.get(level)?.files.file(self.first.saturating_add(frame)))
    }

    /// The MAR of every level, where the manifest states them.
    #[must_use]
    pub fn mars_deg(&self) -> Option<Vec<f64>> {
        self.levels.iter().map(|level| level.mar_deg).collect()
    }
}

/// File names that differ in a frame's number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilePattern {
    before: String,
    digits: usize,
    after: String,
}

impl FilePattern {
    /// Reads a pattern such as `fine/{frame:04}.png`.
    ///
    /// # Errors
    /// What was expected and found, in words: no or several numbers, a path that leaves the folder, another kind of file.
    pub fn parse(text: &str) -> Result<Self, String> {
        let fault = |expected: &str| format!("expected {expected}, found {text:?}");
        let number = "one {frame} or {frame:04} where the frame's number stands";
        let (before, rest) = text.split_once('{').ok_or_else(|| fault(number))?;
        let (inner, after) = rest.split_once('}').ok_or_else(|| fault(number))?;
        let digits = match inner.strip_prefix("frame") {
            Some("") => 1,
            Some(width) => {
                let width = width.strip_prefix(":0").and_then(|width| width.parse().ok());
                width
                    .filter(|width| (1..=9).contains(width))
                    .ok_or_else(|| fault("{frame} or {frame:01} to {frame:09}"))?
            }
            None => return Err(fault(number)),
        };
        if [before, after].iter().any(|part| part.contains(['{', '}'])) {
            return Err(fault(number));
        }
        let whole = format!("{before}0{after}");
        let leaves = whole.starts_with('/')
            || whole.contains(['\\', ':', '\0'])
            || whole.split('/').any(|part| matches!(part, "" | "." | ".."));
        if leaves {
            return Err(fault("a path within the folder, relative to it, with / between its parts"));
        }
        let extension = whole.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
        if !matches!(extension.as_deref(), Some("png" | "exr")) {
            return Err(fault("a name that ends in .png or .exr"));
        }
        Ok(Self { before: before.to_owned(), digits, after: after.to_owned() })
    }

    /// The file of a frame by its number.
    #[must_use]
    pub fn file(&self, number: u32) -> String {
        format!("{}{number:0width$}{}", self.before, self.after, width = self.digits)
    }
}

/// What is wrong with the files of a level, as somebody who looked at them says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilesFault {
    /// The level, 0 for the reference.
    pub level: usize,
    /// What was expected and found.
    pub message: String,
}

/// Reads and checks a manifest. `look` is asked what is wrong with the files themselves once the rest is right.
///
/// # Errors
/// Every mistake in the text, in the order of its lines, and every fault of the files at the line that names them.
pub fn parse_frames(file: &str, text: &str, look: impl FnOnce(&Frames) -> Vec<FilesFault>) -> Result<Frames, Mistakes> {
    super::parse(file, text, super::schema::frames(), |draft, report| {
        let frames = checked(&draft, report)?;
        if report.is_empty() {
            for fault in look(&frames) {
                report.at(&files_field(fault.level), fault.message);
            }
        }
        Some(frames)
    })
}

fn level_field(level: usize) -> Field {
    match level.checked_sub(1) {
        None => Field::root().key("reference"),
        Some(index) => Field::root().key("levels").item(index),
    }
}

fn files_field(level: usize) -> Field {
    level_field(level).key("files")
}

fn checked(draft: &FramesDraft, report: &mut Report<'_>) -> Option<Frames> {
    if let Some(format) = draft.format.filter(|&format| format != FRAMES_FORMAT) {
        report.at(&Field::root().key("format"), format!("expected {FRAMES_FORMAT}, found {format}"));
    }
    let mut levels = Vec::new();
    if let Some(reference) = &draft.reference {
        levels.push(level(0, Some(REFERENCE), reference.files.as_deref(), reference.mar_deg, report));
    }
    let listed = draft.levels.as_deref().unwrap_or_default();
    if draft.levels.as_ref().is_some_and(|levels| levels.is_empty() || levels.len() > MOST_LEVELS) {
        let expected = format!("expected 1 to {MOST_LEVELS} levels, found {}", listed.len());
        report.at(&Field::root().key("levels"), expected);
    }
    let mut names = BTreeSet::from([REFERENCE, FOVEATED]);
    for (index, entry) in listed.iter().enumerate().take(MOST_LEVELS) {
        let Some(entry) = entry else { continue };
        let name = entry.name.as_deref();
        if let Some(name) = name.filter(|name| !names.insert(name)) {
            let field = level_field(index + 1).key("name");
            report.at(&field, format!("expected a name of its own, found \"{name}\" again"));
        }
        let name = name
            .filter(|name| super::validate::checked_name(name, &level_field(index + 1).key("name"), report).is_some());
        levels.push(level(index + 1, name, entry.files.as_deref(), entry.mar_deg, report));
    }
    let levels: Option<Vec<FrameLevel>> = levels.into_iter().collect();
    let levels = levels?;
    check_mars(&levels, report);
    Some(Frames {
        about: draft.about.clone().unwrap_or_default(),
        source: draft.source.clone().unwrap_or_default(),
        size_px: draft.size_px?,
        fps: draft.fps?,
        count: draft.frames?,
        first: draft.first.unwrap_or(0),
        colour: draft.colour,
        end: draft.end.unwrap_or_default(),
        levels,
    })
}

fn level(
    index: usize,
    name: Option<&str>,
    files: Option<&str>,
    mar_deg: Option<f64>,
    report: &mut Report<'_>,
) -> Option<FrameLevel> {
    let files = match FilePattern::parse(files?) {
        Ok(files) => files,
        Err(message) => {
            report.at(&files_field(index), message);
            return None;
        }
    };
    Some(FrameLevel { name: name?.to_owned(), files, mar_deg })
}

/// All levels state their detail or none, and each is coarser than the one before.
fn check_mars(levels: &[FrameLevel], report: &mut Report<'_>) {
    if levels.iter().all(|level| level.mar_deg.is_none()) {
        return;
    }
    let mut before: Option<f64> = None;
    for (index, level) in levels.iter().enumerate() {
        let field = level_field(index).key("mar_deg");
        match (level.mar_deg, before) {
            (None, _) => {
                report.at(&field, "expected mar_deg at every level or at none, found none here".to_owned());
            }
            (Some(mar), Some(before)) if mar <= before => {
                report.at(
                    &field,
                    format!("expected coarser detail than the level before ({before}° per cycle), found {mar}"),
                );
            }
            _ => {}
        }
        before = level.mar_deg.or(before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MANIFEST: &str = r#"{
  "format": 1,
  "size_px": [320, 180],
  "fps": 30,
  "frames": 8,
  "end": "loop",
  "reference": { "files": "full/{frame:04}.png", "mar_deg": 0.05 },
  "levels": [
    { "name": "half", "files": "half/{frame:04}.png", "mar_deg": 0.1 },
    { "name": "quarter", "files": "quarter-{frame}.exr", "mar_deg": 0.2 }
  ]
}
"#;

    fn mistakes(text: &str) -> Vec<(usize, String, String)> {
        let found = parse_frames("manifest.json", text, |_| Vec::new()).expect_err("a mistake");
        found.list.into_iter().map(|m| (m.line, m.field, m.message)).collect()
    }

    #[test]
    fn a_manifest_names_its_files() {
        let frames = parse_frames("manifest.json", MANIFEST, |_| Vec::new()).expect("no mistake");
        assert_eq!(frames.file(0, 3).as_deref(), Some("full/0003.png"));
        assert_eq!(frames.file(2, 12).as_deref(), Some("quarter-12.exr"));
        assert_eq!(frames.file(3, 0), None);
        assert_eq!(frames.mars_deg(), Some(vec![0.05, 0.1, 0.2]));
    }

    /// A display at 60 Hz shows each frame of 30 per second twice, however its times are rounded.
    #[test]
    fn time_chooses_the_frame() {
        let mut frames = parse_frames("manifest.json", MANIFEST, |_| Vec::new()).expect("no mistake");
        for step in 0..1000_u32 {
            assert_eq!(frames.at(f64::from(step) * (1.0 / 60.0)), (step / 2) % 8, "{step}");
            let summed = (0..step).fold(0.0, |t, _| t + 1.0 / 60.0);
            assert_eq!(frames.at(summed), (step / 2) % 8, "{step}");
        }
        assert_eq!(frames.at(-0.01), 7);
        frames.end = End::Hold;
        assert_eq!([frames.at(-3.0), frames.at(0.1), frames.at(9.0), frames.at(1e300)], [0, 3, 7, 7]);
    }

    #[test]
    fn each_mistake_is_reported_at_its_line() {
        let edits: [(&str, &str, usize, &str, &str); 17] = [
            ("\"format\": 1", "\"format\": 2", 2, "format", "1"),
            ("\"fps\": 30", "\"fps\": 0", 4, "fps", "above 0"),
            ("\"fps\": 30", "\"fps\": -1", 4, "fps", "above 0"),
            ("\"fps\": 30", "\"fps\": \"fast\"", 4, "fps", "number"),
            ("\"frames\": 8", "\"frames\": 4000000000", 5, "frames", "100000"),
            ("\"frames\": 8", "\"frames\": 0", 5, "frames", "1"),
            ("\"frames\": 8", "\"frames\": 1.5", 5, "frames", "whole"),
            ("[320, 180]", "[320, 0]", 3, "size_px[1]", "1"),
            ("\"loop\"", "\"bounce\"", 6, "end", "hold"),
            ("full/{frame:04}.png", "full/0001.png", 7, "reference.files", "{frame}"),
            ("full/{frame:04}.png", "full/{frame:04}{frame}.png", 7, "reference.files", "one {frame}"),
            ("full/{frame:04}.png", "full/{frame:4}.png", 7, "reference.files", "{frame:01}"),
            ("full/{frame:04}.png", "../{frame:04}.png", 7, "reference.files", "within the folder"),
            ("full/{frame:04}.png", "a/../../{frame}.png", 7, "reference.files", "within the folder"),
            ("full/{frame:04}.png", "/etc/{frame}.png", 7, "reference.files", "within the folder"),
            ("half/{frame:04}.png", "half/{frame:04}.tiff", 9, "levels[0].files", ".exr"),
            ("\"name\": \"quarter\"", "\"name\": \"half\"", 10, "levels[1].name", "of its own"),
        ];
        for (old, new, line, field, words) in edits {
            assert_eq!(MANIFEST.matches(old).count(), 1, "{old}");
            let found = mistakes(&MANIFEST.replace(old, new));
            assert_eq!(found.len(), 1, "{new}: {found:#?}");
            assert_eq!((found[0].0, found[0].1.as_str()), (line, field), "{found:?}");
            assert!(found[0].2.contains(words), "{words} is not in {found:?}");
        }
        let found = mistakes(&MANIFEST.replace(", \"mar_deg\": 0.1 ", " "));
        assert_eq!(found[0].1, "levels[0].mar_deg");
        let found = mistakes(&MANIFEST.replace("0.2 }", "0.05 }"));
        assert!(found[0].2.contains("coarser"), "{found:?}");
    }

    /// Cut off anywhere, a manifest is refused, with a place, and nothing panics.
    #[test]
    fn a_torn_manifest_is_refused() {
        for end in 0..MANIFEST.trim_end().len() {
            if let Some(torn) = MANIFEST.get(..end) {
                assert!(!mistakes(torn).is_empty(), "{end}");
            }
        }
    }

    #[test]
    fn a_missing_key_is_named() {
        for key in ["format", "size_px", "fps", "frames", "reference", "levels"] {
            let renamed = MANIFEST.replacen(&format!("\"{key}\":"), "\"other\":", 1);
            let found = mistakes(&renamed);
            assert!(
                found.iter().any(|(_, field, message)| field == key && message.contains("no such key")),
                "{found:?}"
            );
        }
    }

    #[test]
    fn what_is_wrong_with_files_stands_where_they_are_named() {
        let fault = |level| FilesFault { level, message: "expected a file, found none".to_owned() };
        let found = parse_frames("m", MANIFEST, |_| vec![fault(0), fault(2)]).expect_err("two faults");
        let places: Vec<(usize, &str)> = found.list.iter().map(|m| (m.line, m.field.as_str())).collect();
        assert_eq!(places, [(7, "reference.files"), (10, "levels[1].files")]);
    }
}
