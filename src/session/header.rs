//! `session.json`: everything that a session's data mean, written before the first event and never changed.
//!
//! The study is kept as text, byte for byte, with its SHA-256, so that the session explains itself without any other
//! file.

use experiments::Display;
use experiments::design::assignment::Assignment;
use experiments::display::{Transfer, TransferNumbers};
use experiments::streams;
use experiments::study::Plan;
use experiments::study::plan::FileSource;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Version of the session folder's format that is written.
///
/// 1 had no chain in the journal, no CRC in the tables, no seal in the header and no marks but the first. Sessions of
/// every format are read, and go on in their own.
pub const FORMAT: u32 = 2;

/// What stands before the seal, the last member of the header's text.
const SEAL: &str = ",\n  \"seal\": \"";
/// What stands after it.
const SEAL_END: &str = "\"\n}\n";

/// The header of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// Version of the folder's format, at most [`FORMAT`].
    pub format: u32,
    /// Who answered.
    pub observer: String,
    /// Wall-clock time of the start, RFC 3339.
    pub started: String,
    /// The study.
    pub study: StudyText,
    /// Scenes and renderers that the study brings along in files, as they were. Left out where there are none, so that
    /// the headers of studies without files are what they always were.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileRecord>,
    /// The display, with its geometry.
    pub display: DisplayRecord,
    /// What part of the study this session runs: group, sitting, row of Latin squares, pilot or not.
    #[serde(default)]
    pub assignment: Assignment,
    /// Seed of every random stream.
    pub seed: u64,
    /// The generator behind the streams.
    pub generator: String,
    /// Where gaze came from, with all parameters.
    pub gaze_source: serde_json::Value,
    /// Who answered, if it was a simulation: the model and its truth.
    pub simulated: Option<serde_json::Value>,
    /// How frames were shown.
    pub stage: StageRecord,
    /// The program that wrote it.
    pub program: Program,
}

impl Header {
    /// The header of a session that begins now, of a study without files, a tracker or a simulated observer, which
    /// whoever has them adds. `study` is the study's text, `started` is left empty.
    #[must_use]
    pub fn new(plan: &Plan, study: &str, observer: &str, seed: u64, stage: StageRecord) -> Self {
        Self {
            format: FORMAT,
            observer: observer.to_owned(),
            started: String::new(),
            study: StudyText {
                name: plan.name.clone(),
                title: plan.title.clone(),
                file: plan.name.clone(),
                sha256: sha256_hex(study.as_bytes()),
                text: study.to_owned(),
            },
            files: Vec::new(),
            display: DisplayRecord::from(&plan.display),
            assignment: Assignment::default(),
            seed,
            generator: streams::GENERATOR.to_owned(),
            gaze_source: serde_json::Value::Null,
            simulated: None,
            stage,
            program: Program::here(),
        }
    }

    /// The text of `session.json`. Since format 2 it ends with a seal: the SHA-256 of all that stands before it, so that
    /// no byte of it can be changed unnoticed.
    ///
    /// # Errors
    /// When the header cannot be serialised.
    pub fn to_text(&self) -> Result<String, serde_json::Error> {
        let text = serde_json::to_string_pretty(self)?;
        Ok(match text.strip_suffix("\n}") {
            Some(body) if self.format >= 2 => format!("{body}{SEAL}{}{SEAL_END}", sha256_hex(body.as_bytes())),
            _ => text + "\n",
        })
    }

    /// Reads the text of a `session.json` of any format.
    ///
    /// # Errors
    /// What is wrong with it, after the line and column where that is known.
    pub fn from_text(bytes: &[u8]) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Format {
            format: u32,
        }
        let at = |error: &serde_json::Error| {
            format!("{}:{}: expected a session header: {error}", error.line(), error.column())
        };
        let Format { format } = serde_json::from_slice(bytes).map_err(|error| at(&error))?;
        if format > FORMAT {
            return Err(format!(
                "1: expected session format {FORMAT} or older, found {format}; a newer program wrote it"
            ));
        }
        if format < 2 {
            return serde_json::from_slice(bytes).map_err(|error| at(&error));
        }
        let text = std::str::from_utf8(bytes).map_err(|_| "1: expected UTF-8".to_owned())?;
        let sealed = text.strip_suffix(SEAL_END).and_then(|text| text.rsplit_once(SEAL));
        let Some((body, seal)) = sealed else {
            return Err(format!("{}: expected a header that ends with its seal", text.lines().count()));
        };
        if sha256_hex(body.as_bytes()) != seal {
            return Err("1: the header does not match its seal; it was changed or the disk failed".to_owned());
        }
        serde_json::from_str(&format!("{body}\n}}")).map_err(|error| at(&error))
    }

    /// SHA-256, in hex, of everything but the wall-clock time: what event 0 of the journal says of its header. The time is
    /// left out so that the same seed, study and inputs give the same journal.
    ///
    /// # Errors
    /// When the header cannot be serialised.
    pub fn fingerprint(&self) -> Result<String, serde_json::Error> {
        let timeless = Self { started: String::new(), ..self.clone() };
        Ok(sha256_hex(&serde_json::to_vec(&timeless)?))
    }
}

/// The study's text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyText {
    /// The study's name.
    pub name: String,
    /// Its title.
    pub title: String,
    /// File or shipped name it was read from.
    pub file: String,
    /// SHA-256 of the text, in hex.
    pub sha256: String,
    /// The text, verbatim.
    pub text: String,
}

/// A scene or renderer of the study's own, as it was when the session began.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// The name that the study gives it.
    pub name: String,
    /// What it is and where, as in the study.
    pub source: FileSource,
    /// The folder that the paths of `contents` start from.
    pub folder: String,
    /// The text of a WGSL file or of the manifest of frames, verbatim.
    pub text: Option<String>,
    /// Every file that it consists of.
    pub contents: Vec<FileHash>,
}

/// One file by what it holds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileHash {
    /// Its path.
    pub path: String,
    /// Its length.
    pub bytes: u64,
    /// SHA-256, in hex.
    pub sha256: String,
}

/// A display as plain numbers, in the form of a display file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisplayRecord {
    /// Name.
    pub name: String,
    /// Pixels.
    pub resolution_px: [u32; 2],
    /// Millimetres.
    pub size_mm: [f64; 2],
    /// Millimetres.
    pub distance_mm: f64,
    /// Hertz.
    pub refresh_hz: f64,
    /// cd/m², where measured.
    pub peak_cd_m2: Option<f64>,
    /// How much light each channel gives for what is sent to it; absent for sRGB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferNumbers>,
}

/// How frames were shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageRecord {
    /// `window` or `offscreen`.
    pub kind: String,
    /// Whether pictures were drawn (`--no-render` draws none).
    pub rendered: bool,
    /// Seconds between frames, measured in a window, declared offscreen.
    pub frame_s: f64,
    /// How frames were paced: by the display's vertical blank, a timer, or virtual time.
    pub pacing: String,
    /// The GPU adapter and driver.
    pub gpu: Option<String>,
}

impl StageRecord {
    /// The offscreen stage for a display, without a GPU.
    #[must_use]
    pub fn offscreen(display: &Display, rendered: bool) -> Self {
        Self {
            kind: "offscreen".to_owned(),
            rendered,
            frame_s: 1.0 / display.refresh_hz(),
            pacing: "virtual time".to_owned(),
            gpu: None,
        }
    }
}

/// The program and machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Name.
    pub name: String,
    /// Version.
    pub version: String,
    /// Operating system and processor.
    pub host: String,
}

impl Program {
    /// This program, here.
    #[must_use]
    pub fn here() -> Self {
        Self {
            name: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            host: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

impl From<&Display> for DisplayRecord {
    fn from(display: &Display) -> Self {
        Self {
            name: display.name().to_owned(),
            resolution_px: display.resolution_px(),
            size_mm: display.size_mm(),
            distance_mm: display.distance_mm(),
            refresh_hz: display.refresh_hz(),
            peak_cd_m2: display.peak_cd_m2(),
            transfer: display.transfer().numbers(),
        }
    }
}

impl DisplayRecord {
    /// The display that a JSON value describes.
    ///
    /// # Errors
    /// When it is not a display, in words.
    pub fn from_value(value: &serde_json::Value) -> Result<Display, String> {
        Self::deserialize(value).map_err(|error| format!("expected a display: {error}"))?.display()
    }

    /// The display it describes.
    ///
    /// # Errors
    /// When the numbers are not a display, in words.
    pub fn display(&self) -> Result<Display, String> {
        let built = Display::new(self.name.as_str(), self.resolution_px, self.size_mm, self.distance_mm)
            .map_err(|errors| all_of(&errors))?;
        let transfer = Transfer::from_numbers(self.transfer.clone()).map_err(|errors| all_of(&errors))?;
        let built =
            built.with_transfer(transfer).with_refresh_hz(self.refresh_hz).map_err(|error| error.to_string())?;
        match self.peak_cd_m2 {
            Some(peak) => built.with_peak_cd_m2(peak).map_err(|error| error.to_string()),
            None => Ok(built),
        }
    }
}

fn all_of(errors: &[impl ToString]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// SHA-256 in hex.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1.
    #[test]
    fn the_hash_is_sha256() {
        assert_eq!(sha256_hex(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn a_display_survives_its_record() {
        for name in experiments::display::NAMED_DISPLAYS {
            let display = Display::named(name).expect("ships");
            assert_eq!(DisplayRecord::from(&display).display(), Ok(display));
        }
    }

    /// sRGB adds nothing to a header, so that the hashes of sessions from before still hold.
    #[test]
    fn a_transfer_is_kept_and_srgb_leaves_no_trace() {
        let srgb = Display::named("demo-540p").expect("ships");
        let text = serde_json::to_string(&DisplayRecord::from(&srgb)).expect("serialises");
        assert!(text.ends_with("\"peak_cd_m2\":null}"), "{text}");
        let gamma = srgb.with_transfer(Transfer::Gamma([2.2, 2.2, 2.25]));
        let text = serde_json::to_string(&DisplayRecord::from(&gamma)).expect("serialises");
        assert!(text.ends_with("\"transfer\":{\"gamma\":[2.2,2.2,2.25]}}"), "{text}");
        let record: DisplayRecord = serde_json::from_str(&text).expect("parses");
        assert_eq!(record.display(), Ok(gamma));
        let wrong = DisplayRecord { transfer: Some(TransferNumbers::Gamma { gamma: [0.0, 2.0, 9.0] }), ..record };
        let said = wrong.display().expect_err("two exponents");
        assert!(said.contains("gamma[0]") && said.contains("gamma[2]"), "{said}");
    }
}
