//! Any bytes are a model, or mistakes at their elements.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::PathBuf;
use std::sync::LazyLock;
use stimuli::Registry;

static REGISTRY: LazyLock<Registry> = LazyLock::new(Registry::built_in);

/// Loading is by path, since a model names files beside it.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    let shared = PathBuf::from("/dev/shm");
    let folder = if shared.is_dir() { shared } else { std::env::temp_dir() };
    folder.join(format!("parafovea-fuzz-{}.glb", std::process::id()))
});

fuzz_target!(|bytes: &[u8]| {
    if std::fs::write(&*FILE, bytes).is_err() {
        return;
    }
    if let Err(error) = REGISTRY.clone().add_gltf("model", &FILE, None) {
        assert!(!error.to_string().is_empty());
    }
});
