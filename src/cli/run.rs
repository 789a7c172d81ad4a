//! `parafovea run`: a study with an observer, in a window or offscreen, new or gone on with.

use super::{inputs, print, progress, say};
use crate::error::LabError;
use crate::gaze::{GazeSource, Mouse, Recorded, Simulated, SimulatedEye};
use crate::session::header::{DisplayRecord, FORMAT, Header, Program, StageRecord, StudyText, sha256_hex};
use crate::session::{SessionFolder, SessionWriter};
use crate::stage::runner::Tail;
use crate::stage::{Painter, Runner, offscreen, window};
use clap::Args;
use experiments::Session;
use experiments::observers::{MarObserver, Observer, Presented};
use experiments::session::refold::refold;
use experiments::streams::{self, Stream};
use experiments::study::Plan;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use stimuli::gpu::Gpu;

#[derive(Debug, Args)]
pub(super) struct RunArgs {
    /// A study file, or the name of a study that ships.
    study: String,
    /// Who answers: a code without spaces or slashes, never a name.
    #[arg(long, value_name = "P01", value_parser = observer_code)]
    observer: String,
    /// The display, by name or file; the study's own if not given.
    #[arg(long, value_name = "NAME|FILE")]
    display: Option<String>,
    /// Where sessions go.
    #[arg(long, default_value = "data", value_name = "DIR")]
    data: PathBuf,
    /// Fixes everything random; drawn from the clock if not given.
    #[arg(long)]
    seed: Option<u64>,
    /// Run without a window, in virtual time; needs --simulate.
    #[arg(long, requires = "simulate")]
    offscreen: bool,
    /// A simulated observer's truth, for example omega0=0.021,m=0.022 (also width, lapse).
    #[arg(long, value_name = "TRUTH", requires = "offscreen")]
    simulate: Option<String>,
    /// Draw no pictures: everything else as fast as it goes.
    #[arg(long, requires = "offscreen")]
    no_render: bool,
    /// Where gaze comes from: mouse in a window; simulated or recorded:FILE offscreen.
    #[arg(long, value_name = "SOURCE")]
    gaze: Option<String>,
    /// Cover the monitor; without it the window is as large as the display in pixels.
    #[arg(long, conflicts_with = "offscreen")]
    fullscreen: bool,
    /// Go on with this observer's unfinished session.
    #[arg(long, conflicts_with_all = ["fresh", "seed"])]
    resume: bool,
    /// Start anew although an unfinished session exists.
    #[arg(long)]
    fresh: bool,
}

fn observer_code(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
    if !text.is_empty() && text.len() <= 32 && text.chars().all(plain) {
        Ok(text.to_owned())
    } else {
        Err("expected up to 32 letters, digits or -".to_owned())
    }
}

pub(super) fn run(args: &RunArgs) -> Result<(), LabError> {
    let display = inputs::display(args.display.as_deref())?;
    let study = inputs::study_file(&args.study)?;
    let plan = Arc::new(inputs::plan(&study, display.as_ref())?);
    check_gaze_option(args)?;

    let unfinished = unfinished_session(&args.data, &study, &args.observer);
    let earlier = match (unfinished, args.resume, args.fresh) {
        (Some(session), false, false) => {
            return Err(LabError::BadInput(format!(
                "{} has an unfinished session of this study, {} ({} trials): give --resume to go on with it or --fresh \
                 to start anew",
                args.observer,
                session.path.display(),
                session.record.trials.len()
            )));
        }
        (None, true, _) => {
            return Err(LabError::BadInput(format!(
                "--resume: {} has no unfinished session of this study in {}",
                args.observer,
                args.data.display()
            )));
        }
        (session, true, _) => session,
        _ => None,
    };
    let seed = match (&earlier, args.seed) {
        (Some(session), _) => session.header.seed,
        (None, Some(seed)) => seed,
        (None, None) => seed_from_clock(),
    };
    let request = Request { plan, study, observer: args.observer.clone(), data: args.data.clone(), seed, earlier };
    let folder = match &args.simulate {
        Some(truth) => {
            let model =
                MarObserver::parse_model(truth).map_err(|error| LabError::BadInput(format!("--simulate: {error}")))?;
            let observer = MarObserver::new(model, seed);
            run_offscreen(request, observer, args.gaze.as_deref(), !args.no_render)?
        }
        None => run_in_window(request, args.fullscreen)?,
    };
    print(&folder.display().to_string())
}

fn check_gaze_option(args: &RunArgs) -> Result<(), LabError> {
    let fits = match (args.gaze.as_deref(), args.offscreen) {
        (None, _) | (Some("simulated"), true) | (Some("mouse"), false) => true,
        (Some(source), true) => source.starts_with("recorded:"),
        _ => false,
    };
    if fits {
        return Ok(());
    }
    let (place, sources) =
        if args.offscreen { ("offscreen", "simulated or recorded:FILE") } else { ("in a window", "mouse") };
    Err(LabError::BadInput(format!("--gaze {}: expected {sources} {place}", args.gaze.as_deref().unwrap_or_default())))
}

/// What a run needs, wherever it takes place.
#[derive(Debug)]
pub(super) struct Request {
    pub plan: Arc<Plan>,
    pub study: inputs::StudyFile,
    pub observer: String,
    pub data: PathBuf,
    pub seed: u64,
    /// The session to go on with.
    pub earlier: Option<SessionFolder>,
}

/// The wall clock's nanoseconds: good enough for a seed, which is written to the header.
pub(super) fn seed_from_clock() -> u64 {
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(1, |since| u64::try_from(since.as_nanos() & u128::from(u32::MAX)).unwrap_or(1))
}

/// Runs a session offscreen with a simulated observer and returns its folder.
pub(super) fn run_offscreen(
    mut request: Request,
    mut observer: MarObserver,
    gaze: Option<&str>,
    render: bool,
) -> Result<PathBuf, LabError> {
    let plan = Arc::clone(&request.plan);
    let display = &plan.display;
    let mut gaze = gaze_source(gaze, &plan, request.seed)?;
    let mut painter = if render {
        let gpu = Gpu::headless()?;
        // Nothing is late in virtual time, so each frame's own GPU time can be waited for.
        gpu.set_blocking_timing(true);
        let mut painter = Painter::new(gpu, display, plan.gaze.fixation_deg, wgpu::TextureFormat::Rgba8Unorm);
        for block in &plan.blocks {
            painter.prepare(&block.condition)?;
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
                    let fixation_deg = session.plan().gaze.fixation_deg;
                    observer.meet(&Presented { phase, trial: session.trial(), fixation_deg });
                }
            };
            let (runner, last_s) = go_on(&session, &request.plan, None, &mut meet)?;
            // So has a simulated eye: what it saw up to here is in the log already.
            gaze.poll(last_s, &mut Vec::new());
            (runner, last_s)
        }
    };
    let folder = runner.folder().to_owned();
    let most: u32 = plan.blocks.iter().map(|block| block.procedure.max_trials()).sum();
    let bar = progress::bar(u64::from(most), "trials");
    let mut shown = 0;
    offscreen::run(runner, &mut observer, gaze.as_mut(), painter.as_mut(), start_s, |runner| {
        let completed = runner.completed_trials();
        if completed != shown {
            shown = completed;
            bar.set_position(u64::from(completed));
        }
    })?;
    bar.finish_and_clear();
    Ok(folder)
}

fn gaze_source(name: Option<&str>, plan: &Plan, seed: u64) -> Result<Box<dyn GazeSource>, LabError> {
    match name.and_then(|name| name.strip_prefix("recorded:")) {
        Some(file) => {
            let text = inputs::read_text(file)?;
            let recorded = Recorded::parse(file, &text, &plan.display).map_err(|mistakes| {
                let lines: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
                LabError::BadInput(lines.join("\n"))
            })?;
            Ok(Box::new(recorded))
        }
        None => {
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

fn run_in_window(mut request: Request, fullscreen: bool) -> Result<PathBuf, LabError> {
    let plan = Arc::clone(&request.plan);
    let options = window::WindowOptions {
        title: plan.title.clone(),
        fullscreen,
        display: plan.display.clone(),
        gaze: plan.gaze.clone(),
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
    if !finished {
        say(&format!("left before the end; everything is saved in {}. Go on with --resume.", folder.display()));
    }
    Ok(folder)
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
        display: DisplayRecord::from(&plan.display),
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

/// Brings an unfinished session back and goes on with it at `now` (real time) or right after its last event.
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
    for notice in earlier.notices() {
        say(&notice);
    }
    let refolded = refold(Arc::clone(plan), earlier.header.seed, &earlier.journal.events, |session, _| meet(session))
        .map_err(|error| LabError::Failed(format!("{}: {error}", earlier.path.display())))?;
    // Only now, when it is sure that the session can go on, is anything changed.
    let writer = SessionWriter::append(&earlier.path, &plan.display)?;
    earlier.cut_torn_tails()?;
    let last_event_s = earlier.journal.events.last().map_or(0.0, |event| event.t_s);
    let tail = Tail {
        events: earlier.journal.events.len() as u64,
        gaze_rows: earlier.gaze()?.rows.len() as u64,
        frames: earlier.frames()?.rows.len() as u64,
        last_event_s,
    };
    let since_start_s = now.and_then(|now| {
        let started = chrono::DateTime::parse_from_rfc3339(&earlier.header.started).ok()?;
        (now.signed_duration_since(started)).to_std().ok().map(|gap| gap.as_secs_f64())
    });
    let start_s = since_start_s.unwrap_or(last_event_s).max(last_event_s);
    Ok((Runner::reopen(refolded.session, refolded.missing, writer, tail, start_s)?, start_s))
}

/// The newest unfinished session of this study and observer, if there is one that can be read.
fn unfinished_session(data: &Path, study: &inputs::StudyFile, observer: &str) -> Option<SessionFolder> {
    let sha256 = sha256_hex(study.text.as_bytes());
    let mut sessions: Vec<SessionFolder> = std::fs::read_dir(data)
        .ok()?
        .filter_map(|entry| SessionFolder::open(&entry.ok()?.path()).ok())
        .filter(|session| {
            session.header.observer == observer && session.header.study.sha256 == sha256 && !session.record.finished
        })
        .collect();
    sessions.sort_by(|a, b| a.header.started.cmp(&b.header.started));
    sessions.pop()
}
