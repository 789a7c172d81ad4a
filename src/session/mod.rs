//! A session on disk: one folder, written while it happens by a thread of its own, readable for ever after.
//!
//! - [`header`]: `session.json`, written first and never changed;
//! - [`journal`]: the format of `events.jsonl`, one event a line, each with its number and CRC;
//! - [`tables`]: the rows of `gaze.csv` and `frames.csv`;
//! - [`writer`]: the thread that puts all of it on disk and says when; [`disk`] and [`faults`] are what it writes to;
//! - [`changes`]: what is different from how a session was run before;
//! - [`folder`]: opening a session again, after an orderly end or a kill;

pub mod changes;
mod create;
pub mod disk;
pub mod faults;
pub mod folder;
pub mod header;
pub mod journal;
mod stream;
pub mod tables;
pub mod writer;

pub use folder::SessionFolder;
pub use header::Header;
pub use writer::SessionWriter;

/// File names inside a session's folder.
pub mod names {
    /// The header.
    pub const HEADER: &str = "session.json";
    /// The journal.
    pub const EVENTS: &str = "events.jsonl";
    /// Every gaze sample.
    pub const GAZE: &str = "gaze.csv";
    /// Every frame.
    pub const FRAMES: &str = "frames.csv";
}
