//! Starting a session: its folder, its machine and its stage, new or gone on with.
//!
//! What `run` and `demo` share. Reading studies and talking to people is the command line's work; nothing here prints.

use super::runner::Tail;
use super::{Painter, Runner, offscreen, window};
use crate::error::LabError;
use crate::gaze::{GazeSource, Mouse, Recorded, Simulated, SimulatedEye};
use crate::resources::Resources;
use crate::session::header::{DisplayRecord, FORMAT, Header, Program, StageRecord, StudyText, sha256_hex};
use crate::session::{SessionFolder, SessionWriter};
use experiments::Session;
use experiments::design::assignment::{Assignment, Earlier};
use experiments::observers::{Observer, Presented};
use experiments::session::refold::refold;
use experiments::streams::{self, Stream};
use experiments::study::Plan;
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
    /// The session to go on with.
    pub earlier: Option<SessionFolder>,
}

/// Where an offscreen session's gaze comes from.
#[derive(Debug, Clone)]
pub enum OffscreenGaze {
    /// A simulated eye.
    Simulated,
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
        kind: "offscreen".to_owned(),
        rendered: render,
        frame_s: 1.0 / display.refresh_hz(),
        pacing: "virtual time".to_owned(),
        gpu: painter.as_ref().map(|painter| adapter_text(&painter.gpu)),
    };
    let (runner, start_s) = match request.earlier.take() {
        None => begin(&request, stage, gaze.describe(), Some(observer.describe()))?,
        Some(session) => {
            // A simulated observer has drawn as many numbers as it was asked questions.
            let mut meet = |session: &Session| {
                if let Some(phase) = session.phase() {
                    let level = session.shown_level();
                    let began_s = session.phase_began_s();
                    observer.meet(&Presented {
                        phase,
                        trial: session.trial(),
                        condition: session.condition(),
                        level: level.as_ref(),
                        fixation_deg: session.look_at_deg(session.animation_s(began_s)),
                        display: &session.plan().display,
                        t_s: began_s,
                    });
                }
            };
            let (runner, last_s) = go_on(&session, &request.plan, None, &mut meet)?;
            // So has a simulated eye: what it saw up to here is in the log already.
            gaze.poll(last_s, &mut Vec::new());
            (runner, last_s)
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
        OffscreenGaze::Simulated => {
            let generator = Stream::Gaze.generator(seed);
            let eye = Simulated::new(SimulatedEye::default(), &plan.display, plan.gaze.fixation_deg, generator)
                .map_err(|mistakes| {
                    let lines: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
                    LabError::BadInput(lines.join("; "))
                })?;
            Ok(Box::new(eye))
        }
    }
}

/// Runs a session in a window. Returns its folder and whether it ran to its end.
///
/// # Errors
/// When no window can be opened, the earlier session cannot go on, or the log cannot be written.
pub fn run_in_window(mut request: Request, fullscreen: bool) -> Result<(PathBuf, bool), LabError> {
    let plan = Arc::clone(&request.plan);
    let options = window::WindowOptions {
        title: plan.title.clone(),
        fullscreen,
        display: plan.display.clone(),
        gaze: plan.gaze.clone(),
        registry: Arc::clone(&request.resources.registry),
        // What an observer sees must not change under their eyes, and must be what the header says.
        reloaded: if request.assignment.pilot { request.resources.wgsl_files() } else { Vec::new() },
    };
    // The folder is made inside the window, once its frames have been measured.
    let folder = Arc::new(Mutex::new(None));
    let made = Arc::clone(&folder);
    let start: window::StartSession = Box::new(move |measured| {
        let (runner, start_s) = match request.earlier.take() {
            None => {
                let stage = StageRecord {
                    kind: "window".to_owned(),
                    rendered: true,
                    frame_s: measured.frame_s,
                    pacing: measured.pacing.to_owned(),
                    gpu: Some(measured.gpu.clone()),
                };
                begin(&request, stage, Mouse::new(&request.plan.display).describe(), None)?
            }
            Some(session) => go_on(&session, &request.plan, Some(chrono::Local::now()), &mut |_| {})?,
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
) -> Result<(Runner, f64), LabError> {
    let plan = &request.plan;
    let header = Header {
        format: FORMAT,
        observer: request.observer.clone(),
        started: chrono::Local::now().to_rfc3339_opts(chrono::SecondsFormat::Millis, false),
        study: StudyText {
            name: plan.name.clone(),
            title: plan.title.clone(),
            file: request.study.file.clone(),
            sha256: sha256_hex(request.study.text.as_bytes()),
            text: request.study.text.clone(),
        },
        files: request.resources.records()?,
        display: DisplayRecord::from(&plan.display),
        assignment: request.assignment.clone(),
        seed: request.seed,
        generator: streams::GENERATOR.to_owned(),
        gaze_source,
        simulated,
        stage,
        program: Program::here(),
    };
    let writer = SessionWriter::create(&request.data, &header, &plan.display)?;
    let (session, events) = Session::begin(Arc::clone(plan), request.seed);
    Ok((Runner::begin(session, events, writer)?, 0.0))
}

/// Brings an unfinished session back and goes on with it at `now` (real time) or right after what it logged last.
fn go_on(
    earlier: &SessionFolder,
    plan: &Arc<Plan>,
    now: Option<chrono::DateTime<chrono::Local>>,
    meet: &mut dyn FnMut(&Session),
) -> Result<(Runner, f64), LabError> {
    if earlier.display != plan.display {
        return Err(LabError::BadInput(format!(
            "{} was run on the display \"{}\" and cannot go on with another geometry",
            earlier.path.display(),
            earlier.header.display.name
        )));
    }
    let refolded = refold(Arc::clone(plan), earlier.header.seed, &earlier.journal.events, |session, _| meet(session))
        .map_err(|error| LabError::Failed(format!("{}: {error}", earlier.path.display())))?;
    // Only now, when it is sure that the session can go on, is anything changed.
    let writer = SessionWriter::append(&earlier.path, &plan.display)?;
    earlier.cut_torn_tails()?;
    let (gaze, frames) = (earlier.gaze()?, earlier.frames()?);
    let last_event_s = earlier.journal.events.last().map_or(0.0, |event| event.t_s);
    let tail = Tail {
        events: earlier.journal.events.len() as u64,
        gaze_rows: gaze.rows.len() as u64,
        frames: frames.rows.len() as u64,
        last_event_s,
    };
    // The tables may be ahead of the journal; time goes on after whatever was logged last.
    let gaze_s = gaze.rows.last().map_or(0.0, |row| row.arrived_s);
    let frame_s = frames.rows.last().map_or(0.0, |row| row.presented_s + earlier.header.stage.frame_s);
    let last_s = last_event_s.max(gaze_s).max(frame_s);
    let since_start_s = now.and_then(|now| {
        let started = chrono::DateTime::parse_from_rfc3339(&earlier.header.started).ok()?;
        (now.signed_duration_since(started)).to_std().ok().map(|gap| gap.as_secs_f64())
    });
    let start_s = since_start_s.unwrap_or(last_s).max(last_s);
    Ok((Runner::reopen(refolded.session, refolded.missing, writer, tail, start_s)?, start_s))
}

/// Every readable session of a study in a folder, whoever ran it, oldest first.
#[must_use]
pub fn sessions_of(data: &Path, study: &str) -> Vec<SessionFolder> {
    let entries = std::fs::read_dir(data).into_iter().flatten();
    let mut sessions: Vec<SessionFolder> = entries
        .filter_map(|entry| SessionFolder::open(&entry.ok()?.path()).ok())
        .filter(|session| session.header.study.name == study)
        .collect();
    sessions.sort_by(|a, b| a.header.started.cmp(&b.header.started));
    sessions
}

/// What sessions say about who was given what.
#[must_use]
pub fn assignments(sessions: &[SessionFolder]) -> Vec<Earlier> {
    let earlier = |session: &SessionFolder| Earlier {
        observer: session.header.observer.clone(),
        assignment: session.header.assignment.clone(),
        finished: session.record.finished,
    };
    sessions.iter().map(earlier).collect()
}

/// Takes the newest unfinished session of this very study and observer out of `sessions`.
#[must_use]
pub fn take_unfinished(
    sessions: &mut Vec<SessionFolder>,
    study: &StudyFile,
    observer: &str,
    pilot: bool,
) -> Option<SessionFolder> {
    let sha256 = sha256_hex(study.text.as_bytes());
    let at = sessions.iter().rposition(|session| {
        session.header.observer == observer
            && session.header.study.sha256 == sha256
            && session.header.assignment.pilot == pilot
            && !session.record.is_over()
    })?;
    Some(sessions.remove(at))
}
