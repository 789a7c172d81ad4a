//! New versions of a study's WGSL files while a pilot runs, so that a renderer can be tuned in front of one's own eyes.
//!
//! Pilots only: a recorded session must not change under the observer, and its pictures must be those that its header's
//! text gives. What a pilot showed after a change cannot be replayed.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, SystemTime};

/// How often files are looked at.
const LOOK_EVERY: Duration = Duration::from_millis(300);
/// Changes that may wait to be taken.
const WAITING: usize = 4;

/// A file's new text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// The renderer's name.
    pub name: String,
    /// The file.
    pub file: PathBuf,
    /// What it says now.
    pub text: String,
}

/// Looks at files from a thread of its own, which ends with it.
#[derive(Debug)]
pub struct Reload {
    changes: Receiver<Change>,
}

impl Reload {
    /// Watches files, each the renderer of a name; nothing if there are none or no thread can be had.
    #[must_use]
    pub fn of(files: Vec<(String, PathBuf)>) -> Option<Self> {
        if files.is_empty() {
            return None;
        }
        let (sender, changes) = sync_channel(WAITING);
        let mut seen: Vec<Option<(SystemTime, u64)>> = files.iter().map(|(_, file)| stamp(file)).collect();
        let look = move || {
            loop {
                for ((name, file), seen) in files.iter().zip(&mut seen) {
                    let now = stamp(file);
                    // While an editor has the file away, or it is no text, there is nothing new.
                    if now.is_some()
                        && now != *seen
                        && let Ok(text) = std::fs::read_to_string(file)
                    {
                        *seen = now;
                        let change = Change { name: name.clone(), file: file.clone(), text };
                        if sender.send(change).is_err() {
                            return;
                        }
                    }
                }
                std::thread::sleep(LOOK_EVERY);
            }
        };
        std::thread::Builder::new().name("renderer files".to_owned()).spawn(look).ok()?;
        Some(Self { changes })
    }

    /// The next change, if there is one; never waits.
    #[must_use]
    pub fn take(&self) -> Option<Change> {
        self.changes.try_recv().ok()
    }
}

fn stamp(file: &std::path::Path) -> Option<(SystemTime, u64)> {
    let metadata = file.metadata().ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn a_new_version_is_noticed_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("mine.wgsl");
        std::fs::write(&file, "one").expect("writable");
        let reload = Reload::of(vec![("mine".to_owned(), file.clone())]).expect("a thread");
        assert_eq!(reload.take(), None);
        std::fs::write(&file, "another").expect("writable");
        let began = Instant::now();
        let change = loop {
            if let Some(change) = reload.take() {
                break change;
            }
            assert!(began.elapsed() < Duration::from_secs(20), "nothing was noticed");
            std::thread::sleep(Duration::from_millis(20));
        };
        assert_eq!((change.name.as_str(), change.text.as_str()), ("mine", "another"));
        std::thread::sleep(2 * LOOK_EVERY);
        assert_eq!(reload.take(), None);
        assert!(Reload::of(Vec::new()).is_none());
    }
}
