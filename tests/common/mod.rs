//! What the tests of the whole program share: running it as a user does, small studies, and looking at folders.
//!
//! The studies here fit a display of 160 × 90 pixels, so that a picture costs almost nothing.

#![allow(dead_code, reason = "every test file uses its own part")]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A truth whose thresholds (0.6° to 1.0° per cycle) the small display can show.
pub(crate) const TRUTH: &str = "omega0=0.35,m=0.15,width=0.8,lapse=0.02";

/// What a run of the program gave.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ran {
    /// The output as one JSON document.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("one JSON document: {error}\n{self:#?}"))
    }

    pub(crate) fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{self:#?}");
        assert!(!self.err.contains("panicked"), "{self:#?}");
        self
    }
}

/// The program, to be run in `folder`.
pub(crate) fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_parafovea"));
    command.current_dir(folder).stdin(Stdio::null());
    command
}

/// Runs the program in `folder` to its end.
pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Ran {
    finish(program(folder).args(arguments))
}

/// Runs a command to its end.
pub(crate) fn finish(command: &mut Command) -> Ran {
    let output = command.output().unwrap();
    Ran {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// The small display, as a study or a display file states it.
pub(crate) fn small_display() -> Value {
    json!({ "name": "small", "resolution_px": [160, 90], "size_mm": [100, 56], "distance_mm": 300 })
}

/// A study of constant stimuli at three eccentricities and six detail limits on the small display, without a gate.
pub(crate) fn small_study(name: &str, repetitions: u32) -> Value {
    json!({
        "format": 1,
        "name": name,
        "title": "A study for tests",
        "display": small_display(),
        "conditions": {
            "photo": {
                "scene": "photo",
                "renderer": "ring",
                "renderer_parameters": { "width_deg": 2 }
            }
        },
        "blocks": [{
            "name": "main",
            "condition": "photo",
            "protocol": { "kind": "two-interval", "fixation_s": 0.1, "interval_s": 0.1, "gap_s": 0.05 },
            "procedure": {
                "kind": "constant",
                "levels": { "eccentricity_deg": [1.5, 3, 4.5], "mar_deg": [0.3, 0.45, 0.6, 0.8, 1.1, 1.6] },
                "repetitions": repetitions
            }
        }]
    })
}

/// Writes a JSON file and returns its path.
pub(crate) fn write_json(folder: &Path, file: &str, value: &Value) -> PathBuf {
    let path = folder.join(file);
    std::fs::write(&path, serde_json::to_string_pretty(value).unwrap()).unwrap();
    path
}

/// Runs a study file of `folder` offscreen without pictures and returns the session's folder.
pub(crate) fn session(folder: &Path, study: &str, data: &str, seed: u64, more: &[&str]) -> PathBuf {
    let seed = seed.to_string();
    let mut arguments =
        vec!["run", study, "--observer", "P01", "--offscreen", "--simulate", TRUTH, "--data", data, "--seed", &seed];
    arguments.extend(more);
    folder.join(run(folder, &arguments).expect(0).out.trim_end())
}

/// The one entry of a folder.
pub(crate) fn only_entry(folder: &Path) -> PathBuf {
    let entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(entries.len(), 1, "{entries:?}");
    entries.into_iter().next().unwrap()
}

/// Every file below a folder with its bytes, and every folder, by relative path.
pub(crate) fn contents(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    let mut left = vec![folder.to_owned()];
    while let Some(next) = left.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().to_owned();
            if path.is_dir() {
                found.insert(name, None);
                left.push(path);
            } else {
                found.insert(name, Some(std::fs::read(&path).unwrap()));
            }
        }
    }
    found
}

/// Copies the files of a folder into a new one.
pub(crate) fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

/// A random generator whose seed is printed; set `PARAFOVEA_TEST_SEED` to have the same again.
pub(crate) fn random() -> ChaCha8Rng {
    let given = std::env::var("PARAFOVEA_TEST_SEED").ok().and_then(|seed| seed.parse::<u64>().ok());
    let seed = given.unwrap_or_else(|| {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
        since.as_secs() ^ u64::from(since.subsec_nanos())
    });
    println!("PARAFOVEA_TEST_SEED={seed}");
    ChaCha8Rng::seed_from_u64(seed)
}

/// A CSV file's column names and its rows, every cell a text.
pub(crate) fn csv_table(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let columns = reader.headers().unwrap().iter().map(ToOwned::to_owned).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(ToOwned::to_owned).collect()).collect();
    (columns, rows)
}
