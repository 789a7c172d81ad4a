//! The thread that draws for the window, so that the window answers however long a frame takes. It is told which frame is
//! wanted now and forgets what was wanted before.

use super::{Drawer, Drawn, Replay};
use crate::error::LabError;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use stimuli::Registry;

/// A frame, counted from 0 among the logged ones, and whether its reference is wanted too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Wanted {
    pub(super) frame: usize,
    pub(super) reference: bool,
}

/// What was drawn of a frame.
#[derive(Debug, Clone)]
pub(super) struct Done {
    pub(super) wanted: Wanted,
    pub(super) seen: Drawn,
    pub(super) reference: Option<Drawn>,
}

#[derive(Debug, Default)]
struct Desk {
    wanted: Option<Wanted>,
    done: Option<Result<Done, LabError>>,
    over: bool,
}

#[derive(Debug, Default)]
struct Shared {
    desk: Mutex<Desk>,
    told: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The drawing thread; it ends when this is dropped.
#[derive(Debug)]
pub(super) struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    asked: Option<Wanted>,
}

impl Worker {
    /// Starts it. `tell` is called from the thread whenever something is done.
    pub(super) fn start(
        replay: Arc<Replay>,
        registry: Arc<Registry>,
        tell: impl Fn() + Send + 'static,
    ) -> Result<Self, LabError> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let work = move || {
            let mut drawer = Drawer::new(replay, registry);
            while let Some(wanted) = next(&theirs) {
                let done = drawn(&mut drawer, wanted);
                theirs.lock().done = Some(done);
                tell();
            }
        };
        let thread = std::thread::Builder::new().name("replay-drawing".to_owned()).spawn(work);
        let thread = thread.map_err(|error| LabError::Failed(format!("cannot start the drawing thread: {error}")))?;
        Ok(Self { shared, thread: Some(thread), asked: None })
    }

    /// Asks for a frame, unless it was the last one asked for.
    pub(super) fn ask(&mut self, wanted: Wanted) {
        if self.asked.replace(wanted) != Some(wanted) {
            self.shared.lock().wanted = Some(wanted);
            self.shared.told.notify_one();
        }
    }

    /// What was done since the last call.
    pub(super) fn take(&self) -> Option<Result<Done, LabError>> {
        self.shared.lock().done.take()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.lock().over = true;
        self.shared.told.notify_one();
        if let Some(thread) = self.thread.take() {
            // A thread that failed has nothing left to say.
            let _ = thread.join();
        }
    }
}

/// Waits for what is wanted next; nothing once it is over.
fn next(shared: &Shared) -> Option<Wanted> {
    let mut desk = shared.lock();
    loop {
        if desk.over {
            return None;
        }
        if let Some(wanted) = desk.wanted.take() {
            return Some(wanted);
        }
        desk = shared.told.wait(desk).unwrap_or_else(PoisonError::into_inner);
    }
}

fn drawn(drawer: &mut Drawer, wanted: Wanted) -> Result<Done, LabError> {
    let replay = Arc::clone(drawer.replay());
    let frame = replay.frames().get(wanted.frame);
    let frame = frame.ok_or_else(|| LabError::Failed(format!("there is no frame {}", wanted.frame)))?;
    let seen = drawer.seen(frame)?;
    let reference = if wanted.reference { Some(drawer.reference(frame)?) } else { None };
    Ok(Done { wanted, seen, reference })
}
