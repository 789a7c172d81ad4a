//! Any text is a study, or a list of mistakes that lie within it. What is a study can be described and begun.
#![no_main]

use experiments::catalogue::Catalogue;
use experiments::study::parse_study;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static CATALOGUE: LazyLock<Catalogue> = LazyLock::new(stimuli::catalogue);

fuzz_target!(|text: &str| {
    match parse_study("study.json", text, &CATALOGUE, None) {
        Ok(plan) => {
            let _ = experiments::Session::begin(std::sync::Arc::new(plan), 1);
        }
        Err(mistakes) => assert!(!mistakes.to_string().is_empty()),
    }
});
