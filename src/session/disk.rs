//! The few things that a session asks of a disk, so that a test can put a failing one in its place ([`super::faults`]).

use std::fmt::Debug;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// A place where sessions are kept.
pub trait Disk: Debug + Send + Sync {
    /// Makes a folder and those above it.
    ///
    /// # Errors
    /// As the system says.
    fn make_folders(&self, path: &Path) -> io::Result<()>;

    /// Makes a folder that must not be there yet.
    ///
    /// # Errors
    /// As the system says.
    fn make_folder(&self, path: &Path) -> io::Result<()>;

    /// Makes a file that must not be there yet.
    ///
    /// # Errors
    /// As the system says.
    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>>;

    /// Opens a file that is there for writing.
    ///
    /// # Errors
    /// As the system says.
    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>>;

    /// The length of the file that has a path now, bytes: a file that is open may have been deleted.
    ///
    /// # Errors
    /// As the system says.
    fn length_of(&self, path: &Path) -> io::Result<u64>;

    /// Gives a folder its name.
    ///
    /// # Errors
    /// As the system says.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Makes the names in a folder durable, where the platform can.
    ///
    /// # Errors
    /// As the system says.
    fn sync_folder(&self, path: &Path) -> io::Result<()>;
}

/// A file that is being written.
pub trait DiskFile: Debug + Send {
    /// Its length, bytes.
    ///
    /// # Errors
    /// As the system says.
    fn length(&self) -> io::Result<u64>;

    /// Writes some of `bytes` at a place and says how many: at least one, unless there are none.
    ///
    /// # Errors
    /// As the system says.
    fn write_at(&mut self, place: u64, bytes: &[u8]) -> io::Result<usize>;

    /// Cuts the file or fills it with zeros.
    ///
    /// # Errors
    /// As the system says.
    fn set_length(&mut self, length: u64) -> io::Result<()>;

    /// Returns once everything that was written is on the device.
    ///
    /// # Errors
    /// As the system says. What had not been synced before may then be lost, even if a later call succeeds.
    fn sync(&mut self) -> io::Result<()>;

    /// Takes the file for this program alone, until it is closed.
    ///
    /// # Errors
    /// `WouldBlock` when another program holds it.
    fn lock(&self) -> io::Result<()>;
}

/// The system's own disk.
#[derive(Debug, Clone, Copy, Default)]
pub struct SystemDisk;

impl Disk for SystemDisk {
    fn make_folders(&self, path: &Path) -> io::Result<()> {
        fs::create_dir_all(path)
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        fs::create_dir(path)
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        Ok(Box::new(SystemFile(File::create_new(path)?)))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        Ok(Box::new(SystemFile(OpenOptions::new().write(true).open(path)?)))
    }

    fn length_of(&self, path: &Path) -> io::Result<u64> {
        Ok(fs::metadata(path)?.len())
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        // Windows cannot open folders; names are durable there without it.
        if cfg!(unix) { File::open(path)?.sync_all() } else { Ok(()) }
    }
}

#[derive(Debug)]
struct SystemFile(File);

impl DiskFile for SystemFile {
    fn length(&self) -> io::Result<u64> {
        Ok(self.0.metadata()?.len())
    }

    fn write_at(&mut self, place: u64, bytes: &[u8]) -> io::Result<usize> {
        self.0.seek(SeekFrom::Start(place))?;
        self.0.write(bytes)
    }

    fn set_length(&mut self, length: u64) -> io::Result<()> {
        self.0.set_len(length)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.0.sync_data()
    }

    fn lock(&self) -> io::Result<()> {
        self.0.try_lock().map_err(|error| match error {
            fs::TryLockError::WouldBlock => io::Error::from(io::ErrorKind::WouldBlock),
            fs::TryLockError::Error(error) => error,
        })
    }
}

/// Writes all of `bytes` at a place.
///
/// # Errors
/// As the system says; some of them may have been written.
pub(super) fn write_all(file: &mut dyn DiskFile, place: u64, bytes: &[u8]) -> io::Result<()> {
    let mut written = 0;
    while written < bytes.len() {
        match file.write_at(place + written as u64, &bytes[written..]) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(some) => written += some,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
