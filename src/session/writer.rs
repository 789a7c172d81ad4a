//! The writer: one named thread that owns a session's files, fed through a bounded channel.
//!
//! The frame loop only sends; it never waits for the disk. An acknowledgement is sent back once everything that was sent
//! before it is on disk (flushed and synced), which is what lets the next trial begin. Between acknowledgements the thread
//! syncs by itself every second.
//!
//! When the disk fails (full, read-only, gone) nothing is lost and nothing stops: the thread keeps what it has in memory,
//! says so ([`SessionWriter::trouble`]), and tries again until the disk is back. [`HELD_BYTES`] bound that memory: beyond
//! them gaze samples and frames are refused ([`SessionWriter::admits`]) and counted, events never.

use super::create::new_session;
use super::disk::{Disk, SystemDisk};
use super::header::Header;
use super::journal::{Chain, line_from_event};
use super::names;
use super::stream::Stream;
use super::tables::{FrameRow, GazeRow, Layout};
use crate::error::LabError;
use crate::gaze::GazeSample;
use experiments::Display;
use experiments::session::Stamped;
use experiments::trial::Trouble;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Messages that may wait for the thread: more than a minute of a 1 kHz tracker, about 10 MB.
const QUEUE: usize = 65_536;
/// Of these, places that only events may take.
const EVENTS_ONLY: usize = 4_096;
/// What is kept in memory while the disk fails, bytes: five minutes of a binocular 1 kHz tracker.
pub const HELD_BYTES: usize = 64 << 20;
/// Rows are handed to the system in pieces of this size, bytes.
const PIECE_BYTES: usize = 64 << 10;
/// Time between syncs that nobody asked for.
const SYNC_EVERY: Duration = Duration::from_secs(1);
/// First and longest time until a disk that failed is tried again.
const RETRY: [Duration; 2] = [Duration::from_millis(5), Duration::from_secs(1)];
/// How long a session that ends, or one that nobody watches, waits for a disk that fails.
pub const PATIENCE: Duration = Duration::from_secs(60);

enum Message {
    Event(Stamped),
    Gaze(Box<GazeSample>),
    Frame(Box<FrameRow>),
    /// Put everything on disk, then this mark, then answer.
    Sync(Stamped, SyncSender<()>),
}

/// What the thread tells while it works.
#[derive(Debug, Default)]
struct Status {
    /// Why the disk cannot be written, while it cannot.
    trouble: Mutex<Option<(Trouble, String)>>,
    /// Messages on their way to the thread.
    queued: AtomicUsize,
    /// Whether the memory for what the disk does not take is used up.
    full: AtomicBool,
    /// Whether nobody waits for the disk any more: one more attempt, then the thread ends.
    give_up: AtomicBool,
}

/// The sending side of a session's files.
#[derive(Debug)]
pub struct SessionWriter {
    folder: PathBuf,
    to_thread: Option<SyncSender<Message>>,
    thread: Option<JoinHandle<Result<(), String>>>,
    status: Arc<Status>,
}

/// A promise that everything sent so far will be on disk.
#[derive(Debug)]
pub struct Acknowledgement(Receiver<()>);

impl Acknowledgement {
    /// Whether the data are on disk yet.
    ///
    /// # Errors
    /// When they never will be.
    pub fn arrived(&self) -> Result<bool, LabError> {
        match self.0.try_recv() {
            Ok(()) => Ok(true),
            Err(TryRecvError::Empty) => Ok(false),
            Err(TryRecvError::Disconnected) => Err(gone()),
        }
    }

    /// Waits for the disk, as long as `patience`. Returns whether the data are on it.
    ///
    /// # Errors
    /// When they never will be.
    pub fn wait(&self, patience: Duration) -> Result<bool, LabError> {
        match self.0.recv_timeout(patience) {
            Ok(()) => Ok(true),
            Err(RecvTimeoutError::Timeout) => Ok(false),
            Err(RecvTimeoutError::Disconnected) => Err(gone()),
        }
    }
}

fn gone() -> LabError {
    LabError::Failed("the session's writer has stopped; what was acknowledged is on disk".to_owned())
}

/// Where the files of a session that goes on are sound up to, and what their next lines follow on.
#[derive(Debug, Clone, Copy)]
pub struct Ends {
    /// Bytes of the journal, and its chain after them.
    pub events: (u64, Chain),
    /// Bytes of `gaze.csv`, and how to go on.
    pub gaze: (u64, Layout<GazeRow>),
    /// Bytes of `frames.csv`, and how to go on.
    pub frames: (u64, Layout<FrameRow>),
}

impl SessionWriter {
    /// Makes a new folder `DATA/STUDY_OBSERVER_TIME` with its header and event 0, which ties the journal to the header,
    /// and starts the writer. The folder appears whole or not at all.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn create(data: &Path, header: &Header, display: &Display) -> Result<Self, LabError> {
        Self::create_on(Arc::new(SystemDisk), data, header, display)
    }

    /// [`Self::create`] on a given disk.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn create_on(disk: Arc<dyn Disk>, data: &Path, header: &Header, display: &Display) -> Result<Self, LabError> {
        let (folder, ends) = new_session(disk.as_ref(), data, header)?;
        Self::append_on(disk, &folder, display, ends)
    }

    /// Starts a writer that goes on where an existing folder's files are sound; what comes after in them is cut off.
    ///
    /// # Errors
    /// When a file cannot be opened, or another program is writing to the folder.
    pub fn append(folder: &Path, display: &Display, ends: Ends) -> Result<Self, LabError> {
        Self::append_on(Arc::new(SystemDisk), folder, display, ends)
    }

    /// [`Self::append`] on a given disk.
    ///
    /// # Errors
    /// When a file cannot be opened, or another program is writing to the folder.
    pub fn append_on(disk: Arc<dyn Disk>, folder: &Path, display: &Display, ends: Ends) -> Result<Self, LabError> {
        let open = |name: &str, locked: bool, sound: u64| {
            let path = folder.join(name);
            Stream::open(disk.as_ref(), path.clone(), locked, Some(sound)).map_err(|error| match error.kind() {
                io::ErrorKind::WouldBlock => {
                    LabError::Failed(format!("{}: another program is writing to this session", folder.display()))
                }
                _ => LabError::io("open", &path, &error),
            })
        };
        let status = Arc::new(Status::default());
        let mut files = Files {
            events: open(names::EVENTS, true, ends.events.0)?,
            gaze: open(names::GAZE, false, ends.gaze.0)?,
            frames: open(names::FRAMES, false, ends.frames.0)?,
            disk,
            display: display.clone(),
            chain: ends.events.1,
            gaze_layout: ends.gaze.1,
            frame_layout: ends.frames.1,
            waiting: Vec::new(),
            marks: Vec::new(),
            status: Arc::clone(&status),
            retry: None,
            synced: Instant::now(),
        };
        let (to_thread, from_session) = sync_channel::<Message>(QUEUE);
        let thread = std::thread::Builder::new()
            .name("session-writer".to_owned())
            .spawn(move || files.serve(&from_session))
            .map_err(|error| LabError::Failed(format!("cannot start the session's writer: {error}")))?;
        Ok(Self { folder: folder.to_owned(), to_thread: Some(to_thread), thread: Some(thread), status })
    }

    /// The session's folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Why the disk cannot be written, while it cannot.
    #[must_use]
    pub fn trouble(&self) -> Option<(Trouble, String)> {
        self.status.trouble.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether there is room for another gaze sample or frame. There always is while the disk works.
    #[must_use]
    pub fn admits(&self) -> bool {
        !self.status.full.load(Ordering::Relaxed) && self.status.queued.load(Ordering::Relaxed) < QUEUE - EVENTS_ONLY
    }

    /// Sends an event.
    ///
    /// # Errors
    /// When the writer has stopped.
    pub fn event(&self, event: Stamped) -> Result<(), LabError> {
        self.send(Message::Event(event))
    }

    /// Sends a gaze sample.
    ///
    /// # Errors
    /// When the writer has stopped.
    pub fn gaze(&self, sample: GazeSample) -> Result<(), LabError> {
        self.send(Message::Gaze(Box::new(sample)))
    }

    /// Sends a frame.
    ///
    /// # Errors
    /// When the writer has stopped.
    pub fn frame(&self, row: FrameRow) -> Result<(), LabError> {
        self.send(Message::Frame(Box::new(row)))
    }

    /// Asks for everything sent so far to be on disk, followed by a mark that says so.
    ///
    /// # Errors
    /// When the writer has stopped.
    pub fn sync(&self, mark: Stamped) -> Result<Acknowledgement, LabError> {
        let (answer, acknowledgement) = sync_channel(1);
        self.send(Message::Sync(mark, answer))?;
        Ok(Acknowledgement(acknowledgement))
    }

    /// Waits until all is on disk, with `mark` at its end, and ends the thread. A disk that fails is given as long as
    /// `patience`.
    ///
    /// # Errors
    /// When something could not be written; it says what.
    pub fn close(mut self, mark: Stamped, patience: Duration) -> Result<(), LabError> {
        let on_disk = self.sync(mark)?.wait(patience)?;
        if !on_disk {
            self.status.give_up.store(true, Ordering::Relaxed);
        }
        self.join()
    }

    fn send(&self, message: Message) -> Result<(), LabError> {
        self.status.queued.fetch_add(1, Ordering::Relaxed);
        self.to_thread.as_ref().ok_or_else(gone)?.send(message).map_err(|_| gone())
    }

    fn join(&mut self) -> Result<(), LabError> {
        self.to_thread = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result.map_err(LabError::Failed),
            Some(Err(_)) => Err(gone()),
            None => Ok(()),
        }
    }
}

impl Drop for SessionWriter {
    /// Leaving early loses nothing that the disk takes: what was sent is still written.
    fn drop(&mut self) {
        self.status.give_up.store(true, Ordering::Relaxed);
        if let Err(error) = self.join() {
            tracing::error!("{error}");
        }
    }
}

/// The thread's side.
#[derive(Debug)]
struct Files {
    events: Stream,
    gaze: Stream,
    frames: Stream,
    disk: Arc<dyn Disk>,
    display: Display,
    chain: Chain,
    gaze_layout: Layout<GazeRow>,
    frame_layout: Layout<FrameRow>,
    /// Who waits for the disk.
    waiting: Vec<SyncSender<()>>,
    /// Events from the first mark on that waits for the tables to be on disk.
    marks: Vec<Stamped>,
    status: Arc<Status>,
    /// While the disk fails: when to try again, and how long to wait after that.
    retry: Option<(Instant, Duration)>,
    synced: Instant,
}

impl Files {
    fn serve(&mut self, from_session: &Receiver<Message>) -> Result<(), String> {
        loop {
            let patience = match self.retry {
                Some((at, _)) => at.saturating_duration_since(Instant::now()),
                None => (self.synced + SYNC_EVERY).saturating_duration_since(Instant::now()),
            };
            match from_session.recv_timeout(patience) {
                Ok(message) => self.take(message),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return self.end(),
            }
            let due = match self.retry {
                Some((at, _)) => Instant::now() >= at,
                None => !self.waiting.is_empty() || self.synced.elapsed() >= SYNC_EVERY,
            };
            if due {
                self.attempt(Self::sync);
            } else if self.retry.is_none() {
                self.attempt(Self::flush);
            }
            let held = self.gaze.held() + self.frames.held() + self.events.held();
            self.status.full.store(held > HELD_BYTES, Ordering::Relaxed);
        }
    }

    fn take(&mut self, message: Message) {
        self.status.queued.fetch_sub(1, Ordering::Relaxed);
        match message {
            Message::Event(event) if self.marks.is_empty() => {
                let line = line_from_event(&event, &mut self.chain);
                self.events.push(&line);
            }
            Message::Event(event) => self.marks.push(event),
            Message::Gaze(sample) => {
                let line = self.gaze_layout.line(&GazeRow::of(&sample, &self.display));
                self.gaze.push(&line);
            }
            Message::Frame(row) => {
                let line = self.frame_layout.line(&row);
                self.frames.push(&line);
            }
            Message::Sync(mark, answer) => {
                self.marks.push(mark);
                self.waiting.push(answer);
            }
        }
    }

    /// Events are handed to the system at once, so that a killed program leaves a trace of the trial it was in.
    fn flush(&mut self) -> io::Result<()> {
        for table in [&mut self.gaze, &mut self.frames] {
            if table.unwritten() >= PIECE_BYTES {
                table.flush(self.disk.as_ref())?;
            }
        }
        self.events.flush(self.disk.as_ref())
    }

    /// The journal comes last: an acknowledged response never points at gaze or frames that are not there, and a mark
    /// never counts rows that are not.
    fn sync(&mut self) -> io::Result<()> {
        self.gaze.sync(self.disk.as_ref())?;
        self.frames.sync(self.disk.as_ref())?;
        for event in std::mem::take(&mut self.marks) {
            let line = line_from_event(&event, &mut self.chain);
            self.events.push(&line);
        }
        self.events.sync(self.disk.as_ref())?;
        self.synced = Instant::now();
        for answer in self.waiting.drain(..) {
            // Nobody may be waiting any more; the data are on disk all the same.
            let _ = answer.send(());
        }
        Ok(())
    }

    /// Does something with the disk, and takes note of whether it works.
    fn attempt(&mut self, what: fn(&mut Self) -> io::Result<()>) {
        let trouble = match what(self) {
            Ok(()) if self.retry.is_some() => {
                tracing::warn!("the session's data can be written again; nothing was lost");
                self.retry = None;
                None
            }
            Ok(()) => return,
            Err(error) => {
                let wait = self.retry.map_or(RETRY[0], |(_, wait)| (2 * wait).min(RETRY[1]));
                self.retry = Some((Instant::now() + wait, wait));
                Some((trouble_of(&error), describe(&error)))
            }
        };
        let mut known = self.status.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        if known.is_none()
            && let Some((_, trouble)) = &trouble
        {
            tracing::warn!("{trouble}; it is kept in memory and tried again");
        }
        *known = trouble;
    }

    /// Nobody sends any more: whatever is left goes to the disk, which may need several attempts.
    fn end(&mut self) -> Result<(), String> {
        let began = Instant::now();
        loop {
            let gives_up = self.status.give_up.load(Ordering::Relaxed);
            let error = match self.sync() {
                Ok(()) => return Ok(()),
                Err(error) => error,
            };
            // A fault of a moment is not worth giving up for.
            if began.elapsed() > if gives_up { RETRY[1] } else { PATIENCE } {
                let held = self.gaze.held() + self.frames.held() + self.events.held();
                return Err(format!(
                    "{}; {held} bytes of gaze, frames and events since the last acknowledgement are lost, everything \
                     before is on disk",
                    describe(&error)
                ));
            }
            std::thread::sleep(10 * RETRY[0]);
        }
    }
}

fn trouble_of(error: &io::Error) -> Trouble {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Trouble::Full,
        io::ErrorKind::ReadOnlyFilesystem | io::ErrorKind::PermissionDenied => Trouble::ReadOnly,
        io::ErrorKind::NotFound | io::ErrorKind::UnexpectedEof => Trouble::Gone,
        _ => Trouble::Fails,
    }
}

fn describe(error: &io::Error) -> String {
    format!("the session's data cannot be written. {} ({error})", trouble_of(error).in_words())
}

#[cfg(test)]
mod tests;
