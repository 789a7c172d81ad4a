//! The house is built as ARCHITECTURE.md says: imports run one way, the pure crates link no graphics, every source file
//! says what it is for, and nothing names the machine it was written on.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Our own crates.
const OURS: [&str; 4] = ["experiments", "stimuli", "analysis", "parafovea"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Normal dependencies of every package, by name, as cargo resolves them for this platform.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let text = |command: &mut Command| {
        let output = command.current_dir(root()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let version = text(Command::new(std::env::var("RUSTC").as_deref().unwrap_or("rustc")).arg("-vV"));
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    let arguments = ["metadata", "--format-version=1", "--locked", "--offline", "--filter-platform", host];
    let metadata: Value = serde_json::from_str(&text(Command::new(env!("CARGO")).args(arguments))).unwrap();

    let names: BTreeMap<&str, &str> = metadata["packages"]
        .as_array()
        .unwrap()
        .iter()
        .map(|package| (package["id"].as_str().unwrap(), package["name"].as_str().unwrap()))
        .collect();
    let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for node in metadata["resolve"]["nodes"].as_array().unwrap() {
        let needed = graph.entry(names[node["id"].as_str().unwrap()].to_owned()).or_default();
        for dependency in node["deps"].as_array().unwrap() {
            let kinds = dependency["dep_kinds"].as_array().unwrap();
            if kinds.iter().any(|kind| kind["kind"].is_null()) {
                needed.insert(names[dependency["pkg"].as_str().unwrap()].to_owned());
            }
        }
    }
    graph
}

/// Everything that a package links, itself left out.
fn linked(graph: &BTreeMap<String, BTreeSet<String>>, package: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut left = vec![package];
    while let Some(next) = left.pop() {
        left.extend(graph[next].iter().filter(|name| found.insert((*name).clone())).map(String::as_str));
    }
    found
}

/// Files below the folders and files of `places`, which may be missing.
fn files(places: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut left: Vec<PathBuf> = places.iter().map(|place| root().join(place)).filter(|path| path.exists()).collect();
    while let Some(next) = left.pop() {
        if next.is_dir() {
            left.extend(std::fs::read_dir(&next).unwrap().map(|entry| entry.unwrap().path()));
        } else {
            found.push(next);
        }
    }
    found.sort();
    found
}

fn with_extension(files: Vec<PathBuf>, extension: &str) -> Vec<PathBuf> {
    files.into_iter().filter(|path| path.extension() == Some(OsStr::new(extension))).collect()
}

const SOURCES: [&str; 4] = ["src", "experiments/src", "stimuli/src", "analysis/src"];

#[test]
fn imports_run_one_way() {
    let graph = dependencies();
    let ours = |package: &str| -> Vec<&str> {
        let linked = linked(&graph, package);
        OURS.into_iter().filter(|name| linked.contains(*name)).collect()
    };
    assert_eq!(ours("experiments"), Vec::<&str>::new());
    assert_eq!(ours("stimuli"), ["experiments"]);
    assert_eq!(ours("analysis"), ["experiments"]);
    assert_eq!(ours("parafovea"), ["experiments", "stimuli", "analysis"]);
}

#[test]
fn what_is_asked_and_what_it_means_link_no_graphics() {
    let graph = dependencies();
    let graphics = |name: &String| {
        ["wgpu", "winit", "egui", "naga", "ash"]
            .iter()
            .any(|prefix| name.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with(['-', '_'])))
    };
    for package in ["experiments", "analysis"] {
        let found: Vec<String> = linked(&graph, package).into_iter().filter(graphics).collect();
        assert!(found.is_empty(), "{package} links {found:?}");
    }
    // The test would see them if they were there.
    assert!(linked(&graph, "stimuli").iter().any(graphics));
}

#[test]
fn every_shader_is_included_by_the_code_beside_it() {
    let shaders = with_extension(files(&["stimuli/src"]), "wgsl");
    assert!(shaders.len() >= 3, "{shaders:?}");
    for shader in shaders {
        let name = shader.file_name().unwrap().to_str().unwrap();
        let beside = std::fs::read_dir(shader.parent().unwrap()).unwrap().map(|entry| entry.unwrap().path());
        let included = with_extension(beside.collect(), "rs")
            .iter()
            .any(|code| std::fs::read_to_string(code).unwrap().contains(&format!("include_str!(\"{name}\")")));
        assert!(included, "{} is included nowhere", shader.display());
    }
}

#[test]
fn every_source_file_begins_with_what_it_is_for() {
    let sources = with_extension(files(&SOURCES), "rs");
    assert!(sources.len() > 50, "{} files", sources.len());
    let silent: Vec<&PathBuf> =
        sources.iter().filter(|path| !std::fs::read_to_string(path).unwrap().starts_with("//! ")).collect();
    assert!(silent.is_empty(), "without module documentation: {silent:#?}");
}

#[test]
fn nothing_names_the_machine_it_was_written_on() {
    // Written in pieces, so that this file does not find itself.
    let words = [concat!("/wo", "rk/"), concat!(".libr", "ary")];
    let places = [
        "src",
        "experiments",
        "stimuli",
        "analysis",
        "tests",
        "benches",
        "examples",
        "docs",
        "Cargo.toml",
        "Makefile",
        ".ci",
        ".gitignore",
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "clippy.toml",
        "rust-toolchain.toml",
    ];
    for path in files(&places) {
        // Pictures are no text.
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        for word in words {
            assert!(!text.contains(word), "{} names {word}", path.display());
        }
    }
}
