//! The writer: one named thread that owns a session's files, fed through a bounded channel.
//!
//! The frame loop only sends; it never waits for the disk. An acknowledgement is sent back once everything that was sent
//! before it is on disk (flushed and synced), which is what lets the next trial begin.

use super::header::Header;
use super::journal::line_from_event;
use super::names;
use super::tables::{FRAME_COLUMNS, FrameRow, GAZE_COLUMNS, frame_line, gaze_line};
use crate::error::LabError;
use crate::gaze::GazeSample;
use experiments::Display;
use experiments::session::{Event, Stamped};
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;

/// Messages that may wait for the disk: the bound on the writer's memory (about 10 MB).
const QUEUE: usize = 65_536;

enum Message {
    Event(Stamped),
    Gaze(Box<GazeSample>),
    Frame(Box<FrameRow>),
    /// Sync, then answer.
    Sync(SyncSender<Result<(), String>>),
}

/// The sending side of a session's files.
#[derive(Debug)]
pub struct SessionWriter {
    folder: PathBuf,
    to_thread: Option<SyncSender<Message>>,
    thread: Option<JoinHandle<Result<(), String>>>,
}

/// A promise that everything sent so far will be on disk.
#[derive(Debug)]
pub struct Acknowledgement(Receiver<Result<(), String>>);

impl Acknowledgement {
    /// Whether the data are on disk yet.
    ///
    /// # Errors
    /// When they never will be.
    pub fn arrived(&self) -> Result<bool, LabError> {
        match self.0.try_recv() {
            Ok(Ok(())) => Ok(true),
            Ok(Err(problem)) => Err(LabError::Failed(problem)),
            Err(TryRecvError::Empty) => Ok(false),
            Err(TryRecvError::Disconnected) => Err(gone()),
        }
    }

    /// Waits for the disk.
    ///
    /// # Errors
    /// When the data could not be written.
    pub fn wait(&self) -> Result<(), LabError> {
        self.0.recv().map_err(|_| gone())?.map_err(LabError::Failed)
    }
}

fn gone() -> LabError {
    LabError::Failed("the session's writer has stopped; the disk may be full or gone".to_owned())
}

impl SessionWriter {
    /// Makes a new folder `DATA/STUDY_OBSERVER_TIME` with its header, starts the writer and writes event 0, which ties the
    /// journal to the header.
    ///
    /// # Errors
    /// When the folder cannot be made or the header not written.
    pub fn create(data: &Path, header: &Header, display: &Display) -> Result<Self, LabError> {
        fs::create_dir_all(data).map_err(|error| LabError::io("make", data, &error))?;
        let stamp: String = header.started.chars().take(19).filter(|c| *c != ':').collect();
        let base = format!("{}_{}_{stamp}", header.study.name, header.observer);
        let folder = new_folder(data, &base)?;
        let unwritable = |error: serde_json::Error| LabError::Failed(error.to_string());
        let text = serde_json::to_string_pretty(header).map_err(unwritable)? + "\n";
        let header_sha256 = header.fingerprint().map_err(unwritable)?;
        let path = folder.join(names::HEADER);
        let write = || -> std::io::Result<()> {
            let mut file = File::create_new(&path)?;
            file.write_all(text.as_bytes())?;
            file.sync_all()
        };
        write().map_err(|error| LabError::io("write", &path, &error))?;
        for (name, first_line) in [
            (names::EVENTS, String::new()),
            (names::GAZE, GAZE_COLUMNS.join(",") + "\n"),
            (names::FRAMES, FRAME_COLUMNS.join(",") + "\n"),
        ] {
            let path = folder.join(name);
            File::create_new(&path)
                .and_then(|mut file| file.write_all(first_line.as_bytes()).and_then(|()| file.sync_all()))
                .map_err(|error| LabError::io("write", &path, &error))?;
        }
        sync_folder(&folder);
        sync_folder(data);
        let writer = Self::append(&folder, display)?;
        writer.event(Stamped { seq: 0, t_s: 0.0, event: Event::Opened { header_sha256 } })?;
        Ok(writer)
    }

    /// Starts a writer that goes on at the end of an existing folder's files.
    ///
    /// # Errors
    /// When a file cannot be opened, or another program is writing to the folder.
    pub fn append(folder: &Path, display: &Display) -> Result<Self, LabError> {
        let open = |name: &str| {
            let path = folder.join(name);
            OpenOptions::new().append(true).open(&path).map_err(|error| LabError::io("open", &path, &error))
        };
        let events = open(names::EVENTS)?;
        events.try_lock().map_err(|_| {
            LabError::Failed(format!("{}: another program is writing to this session", folder.display()))
        })?;
        let mut files = Files {
            events: BufWriter::new(events),
            gaze: BufWriter::new(open(names::GAZE)?),
            frames: BufWriter::new(open(names::FRAMES)?),
            display: display.clone(),
        };
        let (to_thread, from_session) = sync_channel::<Message>(QUEUE);
        let thread = std::thread::Builder::new()
            .name("session-writer".to_owned())
            .spawn(move || files.serve(&from_session))
            .map_err(|error| LabError::Failed(format!("cannot start the session's writer: {error}")))?;
        Ok(Self { folder: folder.to_owned(), to_thread: Some(to_thread), thread: Some(thread) })
    }

    /// The session's folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
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

    /// Asks for everything sent so far to be on disk.
    ///
    /// # Errors
    /// When the writer has stopped.
    pub fn sync(&self) -> Result<Acknowledgement, LabError> {
        let (answer, acknowledgement) = sync_channel(1);
        self.send(Message::Sync(answer))?;
        Ok(Acknowledgement(acknowledgement))
    }

    /// Waits until all is on disk and ends the thread.
    ///
    /// # Errors
    /// When something could not be written.
    pub fn close(mut self) -> Result<(), LabError> {
        self.join()
    }

    fn send(&self, message: Message) -> Result<(), LabError> {
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
    /// Leaving early loses nothing: what was sent is still written.
    fn drop(&mut self) {
        if let Err(error) = self.join() {
            tracing::error!("{error}");
        }
    }
}

struct Files {
    events: BufWriter<File>,
    gaze: BufWriter<File>,
    frames: BufWriter<File>,
    display: Display,
}

impl Files {
    fn serve(&mut self, from_session: &Receiver<Message>) -> Result<(), String> {
        for message in from_session {
            let problem = match message {
                // Handed to the system at once, so that a killed program leaves a trace of the trial it was in.
                Message::Event(event) => {
                    self.events.write_all(line_from_event(&event).as_bytes()).and_then(|()| self.events.flush()).err()
                }
                Message::Gaze(sample) => self.gaze.write_all(gaze_line(&sample, &self.display).as_bytes()).err(),
                Message::Frame(row) => self.frames.write_all(frame_line(&row).as_bytes()).err(),
                Message::Sync(answer) => {
                    let outcome = self.sync().map_err(|error| describe(&error));
                    let stop = outcome.clone().err();
                    // Nobody may be waiting any more; the data are on disk all the same.
                    let _ = answer.send(outcome);
                    match stop {
                        Some(problem) => return Err(problem),
                        None => None,
                    }
                }
            };
            if let Some(error) = problem {
                return Err(describe(&error));
            }
        }
        self.sync().map_err(|error| describe(&error))
    }

    fn sync(&mut self) -> std::io::Result<()> {
        for file in [&mut self.gaze, &mut self.frames, &mut self.events] {
            file.flush()?;
        }
        // The journal comes last: an acknowledged response never points at gaze or frames that are not there.
        for file in [&self.gaze, &self.frames, &self.events] {
            file.get_ref().sync_data()?;
        }
        Ok(())
    }
}

fn describe(error: &std::io::Error) -> String {
    format!("the session's data cannot be written: {error}")
}

/// Makes a folder that did not exist; a number is added if two sessions start in one second.
fn new_folder(data: &Path, base: &str) -> Result<PathBuf, LabError> {
    for attempt in 1..1000 {
        let name = if attempt == 1 { base.to_owned() } else { format!("{base}-{attempt}") };
        let folder = data.join(name);
        match fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(LabError::io("make", &folder, &error)),
        }
    }
    Err(LabError::Failed(format!("{}: a thousand sessions started at once", data.join(base).display())))
}

/// Makes new names in a folder durable, where the platform can.
fn sync_folder(folder: &Path) {
    if let Ok(handle) = File::open(folder) {
        // Windows cannot sync folders; names are durable there without it.
        let _ = handle.sync_all();
    }
}
