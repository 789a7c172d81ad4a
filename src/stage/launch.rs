//! Starting a session: its folder, its machine and its stage, new or gone on with.
//!
//! What `run` and `demo` share. Reading studies and talking to people is the command line's work; nothing here prints.

use super::runner::{Pace, Tail};
use super::{Painter, Runner, offscreen, window};
use crate::error::LabError;
use crate::gaze::{GazeSample, GazeSource, Mouse, Recorded, Simulated, SimulatedEye};
use crate::resources::Resources;
use crate::session::changes::changes;
use crate::session::disk::Disk;
use crate::session::header::{DisplayRecord, Header, Program, StageRecord};
use crate::session::tables::GazeRow;
use crate::session::{SessionFolder, SessionWriter};
use experiments::design::assignment::{self, Assignment};
use experiments::observers::{Observer, Rejoin};
use experiments::session::event::{Change, Seam};
use experiments::session::refold::{refold, seam_at};
use experiments::streams::Stream;
use experiments::study::Plan;
use experiments::{Display, Session};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use stimuli::gpu::Gpu;

/// A study's text and where it came from.
#[derive(Debug, Clone)]
pub struct StudyFile {
    /// The file, or the name of a shipped study.
    pub file: String,
    /// The text.
    pub text: String,
}

/// What a run needs, wherever it takes place.
#[derive(Debug)]
pub struct Request {
    /// What this session runs of the study: the checked plan with the assignment put in.
    pub plan: Arc<Plan>,
    /// The assignment.
    pub assignment: Assignment,
    /// Its text, for the header.
    pub study: StudyFile,
    /// Scenes and renderers, those of the study among them.
    pub resources: Resources,
    /// The observer's code.
    pub observer: String,
    /// Where sessions go.
    pub data: PathBuf,
    /// Seed of every random stream.
    pub seed: u64,
    /// The session to go on with, and what is different from how it was run before and was accepted.
    pub earlier: Option<Earlier>,
    /// What the session is written to.
    pub disk: Arc<dyn Disk>,
}

/// A session that goes on.
#[derive(Debug)]
pub struct Earlier {
    /// The session as it stands.
    pub session: SessionFolder,
    /// What is different from here on; nothing unless somebody has agreed to it.
    pub changed: Vec<Change>,
}

/// Where gaze comes from that is no device's.
#[derive(Debug)]
pub enum OffscreenGaze {
    /// A simulated eye.
    Simulated,
    /// A simulated eye of one's own.
    Eye(Box<SimulatedEye>),
    /// The eye of an earlier session, wherever it looked then, in degrees.
    Session(Box<SessionFolder>),
    /// A recording: the file's name for messages, and its text.
    Recorded {
        /// Name of the file.
        file: String,
        /// Its text.
        text: String,
    },
}

/// Runs a session offscreen with a simulated observer and returns its folder. `progress` is told the completed trials
/// whenever there is one more.
///
/// # Errors
/// When there is no graphics device, the recording or the earlier session cannot be used, or the log not be written.
pub fn run_offscreen(
    mut request: Request,
    mut observer: Box<dyn Observer>,
    gaze: &OffscreenGaze,
    render: bool,
    mut progress: impl FnMut(u32),
) -> Result<PathBuf, LabError> {
    let plan = Arc::clone(&request.plan);
    let display = &plan.display;
    let mut gaze = gaze_source(gaze, &plan, request.seed)?;
    let mut painter = if render {
        let gpu = Gpu::headless()?;
        // Nothing is late in virtual time, so each frame's own GPU time can be waited for.
        gpu.set_blocking_timing(true);
        let registry = &request.resources.registry;
        let mut painter = Painter::new(gpu, registry, display, plan.gaze.fixation_deg, wgpu::TextureFormat::Rgba8Unorm);
        for cell in plan.blocks.iter().flat_map(|block| &block.cells) {
            painter.prepare(&cell.condition)?;
        }
        Some(painter)
    } else {
        None
    };
    let stage = StageRecord {
        gpu: painter.as_ref().map(|painter| adapter_text(&painter.gpu)),
        ..StageRecord::offscreen(display, render)
    };
    let (runner, start_s) = match request.earlier.take() {
        None => begin(&request, stage, gaze.describe(), Some(observer.describe()), Pace::Virtual)?,
        Some(earlier) => {
            // A simulated observer is led through what was asked already.
            let mut rejoin = Rejoin::new(observer);
            let begun =
                go_on(&earlier, &request, stage, Pace::Virtual, &mut |session, seam| rejoin.meet(session, seam))?;
            observer = rejoin.into_observer();
            // So is a simulated eye: what it saw up to here is in the log already.
            gaze.poll(begun.1, &mut Vec::new());
            begun
        }
    };
    let folder = runner.folder().to_owned();
    let mut shown = 0;
    offscreen::run(runner, observer.as_mut(), gaze.as_mut(), painter.as_mut(), start_s, |runner| {
        let completed = runner.completed_trials();
        if completed != shown {
            shown = completed;
            progress(completed);
        }
    })?;
    Ok(folder)
}

fn gaze_source(gaze: &OffscreenGaze, plan: &Plan, seed: u64) -> Result<Box<dyn GazeSource>, LabError> {
    match gaze {
        OffscreenGaze::Recorded { file, text } => {
            let recorded = Recorded::parse(file, text, &plan.display).map_err(|mistakes| {
                let lines: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
                LabError::BadInput(lines.join("\n"))
            })?;
            Ok(Box::new(recorded))
        }
        OffscreenGaze::Session(session) => Ok(Box::new(gaze_of(session, &plan.display)?)),
        OffscreenGaze::Simulated | OffscreenGaze::Eye(_) => {
            let generator = Stream::Gaze.generator(seed);
            let eye = if let OffscreenGaze::Eye(eye) = gaze { **eye } else { SimulatedEye::default() };
            let eye = Simulated::new(eye, &plan.display, plan.gaze.fixation_deg, generator).map_err(|mistakes| {
                let lines: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
                LabError::BadInput(lines.join("; "))
            })?;
            Ok(Box::new(eye))
        }
    }
}

/// The gaze of an earlier session, to be played back on a display. Places are the same angles as then, which on another
/// display are other pixels.
///
/// # Errors
/// When the session's gaze cannot be read or was never seen.
pub fn gaze_of(session: &SessionFolder, display: &Display) -> Result<Recorded, LabError> {
    let table = session.gaze()?;
    if let Some(damage) = &table.damage {
        tracing::warn!("{}: gaze.csv: {damage}; the gaze before it is used", session.path.display());
    }
    let same = session.record.seams.is_empty() && session.display == *display;
    let place = |row: &GazeRow| if same { [row.x_px, row.y_px] } else { display.px_from_deg([row.x_deg, row.y_deg]) };
    let samples: Vec<GazeSample> = table
        .rows
        .iter()
        .map(|row| GazeSample {
            t_s: row.t_s,
            arrived_s: row.arrived_s,
            t_device_s: row.t_device_s,
            px: place(row),
            valid: row.valid,
            pupil_mm: row.pupil_mm,
            left: row.left.filter(|_| same),
            right: row.right.filter(|_| same),
        })
        .collect();
    if !samples.iter().any(|sample| sample.valid) {
        return Err(LabError::BadInput(format!("{}: the eye was never seen in it", session.path.display())));
    }
    Ok(Recorded::of(&session.path.display().to_string(), samples))
}

/// Runs a session in a window, with the mouse for the eye or an earlier session's or file's gaze. Returns its folder and whether it ran to its end.
///
/// # Errors
/// When no window can be opened, the earlier session cannot go on, or the log cannot be written.
pub fn run_in_window(
    mut request: Request,
    gaze: Option<&OffscreenGaze>,
    fullscreen: bool,
) -> Result<(PathBuf, bool), LabError> {
    let plan = Arc::clone(&request.plan);
    let gaze = gaze.map(|gaze| gaze_source(gaze, &plan, request.seed)).transpose()?;
    let described = gaze.as_ref().map_or_else(|| Mouse::new(&plan.display).describe(), |gaze| gaze.describe());
    let options = window::WindowOptions {
        title: plan.title.clone(),
        fullscreen,
        display: plan.display.clone(),
        gaze: plan.gaze.clone(),
        instead_of_mouse: gaze,
        registry: Arc::clone(&request.resources.registry),
        // What an observer sees must not change under their eyes, and must be what the header says.
        reloaded: if request.assignment.pilot { request.resources.wgsl_files() } else { Vec::new() },
    };
    // The folder is made inside the window, once its frames have been measured.
    let folder = Arc::new(Mutex::new(None));
    let made = Arc::clone(&folder);
    let start: window::StartSession = Box::new(move |measured| {
        let stage = StageRecord {
            kind: "window".to_owned(),
            rendered: true,
            frame_s: measured.frame_s,
            pacing: measured.pacing.to_owned(),
            gpu: Some(measured.gpu.clone()),
        };
        let (runner, start_s) = match request.earlier.take() {
            None => begin(&request, stage, described, None, Pace::Real)?,
            Some(earlier) => go_on(&earlier, &request, stage, Pace::Real, &mut |_, _| {})?,
        };
        *made.lock().unwrap_or_else(PoisonError::into_inner) = Some(runner.folder().to_owned());
        Ok((runner, start_s))
    });
    let finished = window::run(options, start)?;
    let folder = folder.lock().unwrap_or_else(PoisonError::into_inner).take();
    let Some(folder) = folder else {
        return Err(LabError::Failed("the window was closed before the session began".to_owned()));
    };
    Ok((folder, finished))
}

fn adapter_text(gpu: &Gpu) -> String {
    let info = &gpu.adapter_info;
    format!("{} ({:?}, {} {})", info.name, info.backend, info.driver, info.driver_info)
}

/// Starts a new session's folder and machine.
fn begin(
    request: &Request,
    stage: StageRecord,
    gaze_source: serde_json::Value,
    simulated: Option<serde_json::Value>,
    pace: Pace,
) -> Result<(Runner, f64), LabError> {
    let plan = &request.plan;
    let mut header = Header::new(plan, &request.study.text, &request.observer, request.seed, stage);
    header.started = now();
    header.study.file.clone_from(&request.study.file);
    header.files = request.resources.records()?;
    header.assignment = request.assignment.clone();
    header.gaze_source = gaze_source;
    header.simulated = simulated;
    let writer = SessionWriter::create_on(Arc::clone(&request.disk), &request.data, &header, &plan.display)?;
    let (session, events) = Session::begin(Arc::clone(plan), request.seed);
    Ok((Runner::begin(session, events, writer, pace)?, 0.0))
}

/// The wall-clock time, RFC 3339.
fn now() -> String {
    chrono::Local::now().to_rfc3339_opts(chrono::SecondsFormat::Millis, false)
}

/// Brings an unfinished session back and goes on with it. Its time goes on right after what was logged last: the time in
/// between is the wall clock's business, which may have been set since, and stands in the seam.
///
/// `meet` is called for every phase that was presented, and told whether it came of an earlier reopening.
fn go_on(
    earlier: &Earlier,
    request: &Request,
    stage: StageRecord,
    pace: Pace,
    meet: &mut dyn FnMut(&Session, bool),
) -> Result<(Runner, f64), LabError> {
    let (plan, session) = (&request.plan, &earlier.session);
    let events = &session.journal.events;
    let refolded = refold(Arc::clone(plan), session.header.seed, events, |machine, seq| {
        meet(machine, seam_at(events, seq));
    })
    .map_err(|error| match earlier.changed.as_slice() {
        [] => LabError::Failed(format!("{}: {error}", session.path.display())),
        _ => LabError::BadInput(format!(
            "{} cannot go on with what has changed, since that concerns what was run already: {error}",
            session.path.display()
        )),
    })?;
    let (gaze, frames) = (session.gaze()?, session.frames()?);
    // Only now, when it is sure that the session can go on, is anything written.
    let ends = session.ends(&gaze, &frames)?;
    let kept = session.sound_frames(&frames.rows, gaze.rows.len());
    let writer = SessionWriter::append_on(Arc::clone(&request.disk), &session.path, &plan.display, ends)?;
    let last_event_s = events.last().map_or(0.0, |event| event.t_s);
    // The tables may be ahead of the journal; time goes on after whatever was logged last.
    let gaze_s = gaze.rows.last().map_or(0.0, |row| row.arrived_s);
    let frame_s = frames.rows.last().map_or(0.0, |row| row.presented_s + stage.frame_s);
    let tail = Tail {
        events: events.len() as u64,
        gaze_rows: gaze.rows.len() as u64,
        frames: kept as u64,
        last_event_s,
        t_s: last_event_s.max(gaze_s).max(frame_s),
    };
    let Program { name, version, .. } = Program::here();
    let seam = Seam {
        wall: now(),
        program: format!("{name} {version}"),
        gpu: stage.gpu,
        frame_s: stage.frame_s,
        pacing: stage.pacing,
        changed: earlier.changed.clone(),
        study: (request.study.text != session.study_text()).then(|| request.study.text.clone()),
        display: (plan.display != session.display_now()?)
            .then(|| serde_json::to_value(DisplayRecord::from(&plan.display)))
            .transpose()
            .map_err(|error| LabError::Failed(error.to_string()))?,
    };
    let runner = Runner::reopen(refolded.session, refolded.missing, writer, pace, tail, seam)?;
    Ok((runner, tail.t_s))
}

/// Every readable session of a study in a folder, whoever ran it, oldest first.
#[must_use]
pub fn sessions_of(data: &Path, study: &str) -> Vec<SessionFolder> {
    let entries = std::fs::read_dir(data).into_iter().flatten();
    let mut sessions: Vec<SessionFolder> = entries
        .filter_map(Result::ok)
        // A folder with a hidden name is a session that never began.
        .filter(|entry| !entry.file_name().to_string_lossy().starts_with('.'))
        .filter_map(|entry| SessionFolder::open(&entry.path()).ok())
        .filter(|session| session.header.study.name == study)
        .collect();
    // A repaired copy has the original's time, and comes after it.
    sessions.sort_by(|a, b| (&a.header.started, &a.path).cmp(&(&b.header.started, &b.path)));
    sessions
}

/// What sessions say about who was given what.
#[must_use]
pub fn assignments(sessions: &[SessionFolder]) -> Vec<assignment::Earlier> {
    let earlier = |session: &SessionFolder| assignment::Earlier {
        observer: session.header.observer.clone(),
        assignment: session.header.assignment.clone(),
        finished: session.record.finished,
    };
    sessions.iter().map(earlier).collect()
}

/// Takes an observer's newest session out of `sessions`, which are of one study.
#[must_use]
pub fn take_newest(sessions: &mut Vec<SessionFolder>, observer: &str, pilot: bool) -> Option<SessionFolder> {
    let at = sessions
        .iter()
        .rposition(|session| session.header.observer == observer && session.header.assignment.pilot == pilot)?;
    Some(sessions.remove(at))
}

/// What is different between how a session was run last and how it is to go on.
///
/// # Errors
/// When the session's display cannot be used.
pub fn differences(session: &SessionFolder, study: &StudyFile, plan: &Plan) -> Result<Vec<Change>, LabError> {
    let value = |text: &str| serde_json::from_str(text).unwrap_or_else(|_| serde_json::Value::String(text.to_owned()));
    let mut found = changes("study", &value(session.study_text()), &value(&study.text));
    if found.is_empty() && session.study_text() != study.text {
        found.push(Change { field: "study".to_owned(), from: "other spaces".to_owned(), to: "spaces".to_owned() });
    }
    let before = session.display_now()?;
    if before != plan.display {
        let value = |display| serde_json::to_value(DisplayRecord::from(display)).unwrap_or_default();
        found.extend(changes("display", &value(&before), &value(&plan.display)));
    }
    Ok(found)
}
