//! A disk that fails as disks do: short writes, no space, device errors, slow syncs, and a program that is killed in the
//! middle of an operation. Tests run whole sessions on it, and `run --faults` lets a lab rehearse a bad disk.

use super::disk::{Disk, DiskFile, SystemDisk};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// What goes wrong, how often.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Faults {
    /// Seed of what goes wrong when.
    pub seed: u64,
    /// Share of writes that write only a part, 0–1.
    pub short: f64,
    /// Share of writes that write a part and then fail because the disk is full.
    pub no_space: f64,
    /// Share of writes, syncs and renames that fail with a device error.
    pub device_error: f64,
    /// Every operation from this one on fails because the disk is full…
    pub full_from: Option<u64>,
    /// … up to this one.
    pub full_until: Option<u64>,
    /// Time that every sync takes more, milliseconds.
    pub slow_sync_ms: u64,
    /// The program is killed in the middle of this operation, counted from 1.
    pub kill_at: Option<u64>,
}

impl Faults {
    /// Reads `short=0.1,no-space=0.02,device-error=0.01,full-from=30,full-until=60,slow-sync-ms=200,kill-at=57,seed=3`; all
    /// parts are optional.
    ///
    /// # Errors
    /// What was expected instead.
    pub fn parse(text: &str) -> Result<Self, String> {
        fn number<T: std::str::FromStr>(name: &str, value: &str, expected: &str) -> Result<T, String> {
            value.parse().map_err(|_| format!("{name}: expected {expected}, found \"{value}\""))
        }
        let share = |name: &str, value: &str| {
            let share: f64 = number(name, value, "a share from 0 to 1")?;
            if (0.0..=1.0).contains(&share) {
                Ok(share)
            } else {
                Err(format!("{name}: expected a share from 0 to 1, found {value}"))
            }
        };
        let mut faults = Self::default();
        for part in text.split(',').filter(|part| !part.is_empty()) {
            let (name, value) =
                part.split_once('=').ok_or_else(|| format!("expected NAME=NUMBER, found \"{part}\""))?;
            let whole = || number::<u64>(name, value, "a whole number");
            match name {
                "seed" => faults.seed = whole()?,
                "short" => faults.short = share(name, value)?,
                "no-space" => faults.no_space = share(name, value)?,
                "device-error" => faults.device_error = share(name, value)?,
                "full-from" => faults.full_from = Some(whole()?),
                "full-until" => faults.full_until = Some(whole()?),
                "slow-sync-ms" => faults.slow_sync_ms = whole()?,
                "kill-at" => faults.kill_at = Some(whole()?),
                _ => {
                    return Err(format!(
                        "expected seed, short, no-space, device-error, full-from, full-until, slow-sync-ms or kill-at, \
                         found \"{name}\""
                    ));
                }
            }
        }
        Ok(faults)
    }
}

/// The system's disk with faults.
#[derive(Debug, Clone)]
pub struct FaultyDisk(Arc<Mutex<State>>);

#[derive(Debug)]
struct State {
    faults: Faults,
    operations: u64,
    rng: ChaCha8Rng,
}

/// What happens to one operation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fate {
    Well,
    /// Only this share of the bytes is written.
    Short(f64),
    /// This share of the bytes is written, then it fails.
    Fails(f64, io::ErrorKind),
    /// This share of the bytes is written, then the program is killed.
    Kill(f64),
}

impl FaultyDisk {
    /// A disk with these faults.
    #[must_use]
    pub fn new(faults: Faults) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(faults.seed);
        Self(Arc::new(Mutex::new(State { faults, operations: 0, rng })))
    }

    fn fate(&self, writes: bool) -> Fate {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.operations += 1;
        // The same draws for every operation, so that one seed gives one sequence whatever operations come.
        let (dice, share): (f64, f64) = (state.rng.random(), state.rng.random());
        let (at, faults) = (state.operations, &state.faults);
        let full = faults.full_from.is_some_and(|from| at >= from) && faults.full_until.is_none_or(|until| at <= until);
        if faults.kill_at == Some(at) {
            return Fate::Kill(share);
        }
        if full {
            return Fate::Fails(share, io::ErrorKind::StorageFull);
        }
        let mut from = 0.0;
        let mut happens = |how_often: f64| {
            from += how_often;
            dice < from
        };
        if happens(faults.device_error) {
            return Fate::Fails(share, io::ErrorKind::Other);
        }
        if writes && happens(faults.no_space) {
            return Fate::Fails(share, io::ErrorKind::StorageFull);
        }
        if writes && happens(faults.short) {
            return Fate::Short(share);
        }
        Fate::Well
    }

    /// An operation that either happens or does not.
    fn attempt<T>(&self, operation: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
        match self.fate(false) {
            Fate::Well | Fate::Short(_) => operation(),
            Fate::Fails(_, kind) => Err(injected(kind)),
            Fate::Kill(share) => {
                // Half of the kills come after the operation.
                if share < 0.5 {
                    let _ = operation();
                }
                kill_this_program()
            }
        }
    }

    fn wrap(&self, inner: Box<dyn DiskFile>) -> io::Result<Box<dyn DiskFile>> {
        let synced = inner.length()?;
        Ok(Box::new(FaultyFile { disk: self.clone(), inner, synced }))
    }
}

fn injected(kind: io::ErrorKind) -> io::Error {
    let what = if kind == io::ErrorKind::StorageFull { "no space left on device" } else { "input/output error" };
    io::Error::new(kind, format!("{what} (rehearsed)"))
}

/// SIGKILL: nothing of this program runs any more. The caller stands still until then.
fn kill_this_program() -> ! {
    if cfg!(unix) {
        let _ = std::process::Command::new("kill").args(["-KILL", &std::process::id().to_string()]).status();
        std::thread::sleep(Duration::from_secs(5));
    }
    std::process::abort()
}

impl Disk for FaultyDisk {
    fn make_folders(&self, path: &Path) -> io::Result<()> {
        self.attempt(|| SystemDisk.make_folders(path))
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        self.attempt(|| SystemDisk.make_folder(path))
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        self.wrap(self.attempt(|| SystemDisk.create(path))?)
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        self.wrap(self.attempt(|| SystemDisk.open(path))?)
    }

    fn length_of(&self, path: &Path) -> io::Result<u64> {
        SystemDisk.length_of(path)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.attempt(|| SystemDisk.rename(from, to))
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        self.attempt(|| SystemDisk.sync_folder(path))
    }
}

#[derive(Debug)]
struct FaultyFile {
    disk: FaultyDisk,
    inner: Box<dyn DiskFile>,
    /// How long the file was when it was synced last.
    synced: u64,
}

impl FaultyFile {
    /// Writes a share of the bytes, for a write that is cut short.
    fn write_share(&mut self, place: u64, bytes: &[u8], share: f64) -> io::Result<usize> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
        let some = ((bytes.len() as f64 * share) as usize).min(bytes.len());
        super::disk::write_all(self.inner.as_mut(), place, &bytes[..some])?;
        Ok(some)
    }
}

impl DiskFile for FaultyFile {
    fn length(&self) -> io::Result<u64> {
        self.inner.length()
    }

    fn write_at(&mut self, place: u64, bytes: &[u8]) -> io::Result<usize> {
        match self.disk.fate(true) {
            Fate::Well => self.inner.write_at(place, bytes),
            // A write that writes nothing would be an error, not a short write.
            Fate::Short(share) => self.write_share(place, bytes, share.max(1.0 / bytes.len().max(1) as f64)),
            Fate::Fails(share, kind) => {
                self.write_share(place, bytes, share)?;
                Err(injected(kind))
            }
            Fate::Kill(share) => {
                let _ = self.write_share(place, bytes, share);
                kill_this_program()
            }
        }
    }

    fn set_length(&mut self, length: u64) -> io::Result<()> {
        let disk = self.disk.clone();
        disk.attempt(|| self.inner.set_length(length))
    }

    /// A sync that fails throws away what it was to make durable, as Linux does: the caller has to write that again.
    fn sync(&mut self) -> io::Result<()> {
        let slow_ms = self.disk.0.lock().unwrap_or_else(PoisonError::into_inner).faults.slow_sync_ms;
        if slow_ms > 0 {
            std::thread::sleep(Duration::from_millis(slow_ms));
        }
        let disk = self.disk.clone();
        let outcome = disk.attempt(|| self.inner.sync());
        if outcome.is_ok() {
            self.synced = self.inner.length()?;
        } else {
            self.inner.set_length(self.synced)?;
        }
        outcome
    }

    fn lock(&self) -> io::Result<()> {
        self.inner.lock()
    }
}
