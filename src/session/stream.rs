//! One file of a session while it is written: what is durable, and in memory whatever is not yet.
//!
//! Nothing leaves memory before it has been synced. A write or sync that fails therefore costs nothing: the file is opened
//! again and everything after its durable part is written anew. That is also the only right answer to a failed sync, after
//! which the system may have dropped what it had been given.

use super::disk::{Disk, DiskFile, write_all};
use std::io;
use std::path::PathBuf;

/// A file that grows at its end.
#[derive(Debug)]
pub(super) struct Stream {
    path: PathBuf,
    /// Nothing after a failure, until it has been opened again.
    file: Option<Box<dyn DiskFile>>,
    /// Whether this program must hold the file alone.
    locked: bool,
    /// Bytes that are on the device.
    durable: u64,
    /// The bytes after them.
    tail: Vec<u8>,
    /// How many of the tail's bytes the system has been given.
    written: usize,
}

impl Stream {
    /// Goes on at the end of a file of which the first `sound` bytes are kept.
    pub(super) fn open(disk: &dyn Disk, path: PathBuf, locked: bool, sound: Option<u64>) -> io::Result<Self> {
        let mut file = disk.open(&path)?;
        if locked {
            file.lock()?;
        }
        let length = file.length()?;
        let durable = sound.unwrap_or(length).min(length);
        if durable < length {
            file.set_length(durable)?;
            file.sync()?;
        }
        Ok(Self { path, file: Some(file), locked, durable, tail: Vec::new(), written: 0 })
    }

    pub(super) fn push(&mut self, text: &str) {
        self.tail.extend_from_slice(text.as_bytes());
    }

    /// Bytes that are in memory only, or with the system but not known to be on the device.
    pub(super) fn held(&self) -> usize {
        self.tail.len()
    }

    /// Bytes that the system has not been given.
    pub(super) fn unwritten(&self) -> usize {
        self.tail.len() - self.written
    }

    /// Gives the system everything.
    pub(super) fn flush(&mut self, disk: &dyn Disk) -> io::Result<()> {
        if self.unwritten() == 0 && self.file.is_some() {
            return Ok(());
        }
        self.healthy(disk)?;
        let Some(file) = self.file.as_mut() else { return Err(io::ErrorKind::NotConnected.into()) };
        let place = self.durable + self.written as u64;
        let outcome = write_all(file.as_mut(), place, &self.tail[self.written..]);
        match outcome {
            Ok(()) => self.written = self.tail.len(),
            Err(_) => self.file = None,
        }
        outcome
    }

    /// Puts everything on the device.
    pub(super) fn sync(&mut self, disk: &dyn Disk) -> io::Result<()> {
        if self.tail.is_empty() && self.file.is_some() {
            return Ok(());
        }
        self.flush(disk)?;
        let Some(file) = self.file.as_mut() else { return Err(io::ErrorKind::NotConnected.into()) };
        let synced = file.sync().and_then(|()| {
            let length = disk.length_of(&self.path)?;
            if length == self.durable + self.tail.len() as u64 { Ok(()) } else { Err(io::ErrorKind::NotFound.into()) }
        });
        match synced {
            Ok(()) => {
                self.durable += self.tail.len() as u64;
                self.tail.clear();
                // A tail that was long once is not kept for ever.
                self.tail.shrink_to(1 << 20);
                self.written = 0;
                Ok(())
            }
            Err(error) => {
                // What was written since the last sync may be gone.
                self.written = 0;
                self.file = None;
                Err(error)
            }
        }
    }

    /// Opens the file again after a failure.
    fn healthy(&mut self, disk: &dyn Disk) -> io::Result<()> {
        if self.file.is_some() {
            return Ok(());
        }
        let file = disk.open(&self.path)?;
        if self.locked {
            file.lock()?;
        }
        if file.length()? < self.durable {
            let lost = format!("{}: what was on disk before is not there any more", self.path.display());
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, lost));
        }
        self.written = 0;
        self.file = Some(file);
        Ok(())
    }
}
