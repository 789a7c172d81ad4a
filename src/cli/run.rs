//! `parafovea run`: a study with an observer, in a window or offscreen, new or gone on with.

use super::{inputs, print, progress, say};
use crate::error::LabError;
use crate::gaze::SimulatedEye;
use crate::resources::Resources;
use crate::session::SessionFolder;
use crate::session::changes::in_words;
use crate::session::disk::SystemDisk;
use crate::session::faults::{Faults, FaultyDisk};
use crate::stage::launch::{
    Earlier, OffscreenGaze, Request, StudyFile, assignments, differences, run_in_window, run_offscreen, sessions_of,
    take_newest,
};
use clap::Args;
use experiments::design::assignment::{self, Assignment, next_assignment};
use experiments::observers::Simulation;
use experiments::study::Plan;
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
    /// A simulated observer's truth, for example omega0=0.021,m=0.022 or quality_index=14,width=3,finer=up or
    /// pixels (also lapse, bias, zone, criterion, spacing, fatigue, rt).
    #[arg(long, value_name = "TRUTH", requires = "offscreen")]
    simulate: Option<String>,
    /// Draw no pictures: everything else as fast as it goes.
    #[arg(long, requires = "offscreen")]
    no_render: bool,
    /// Where gaze comes from: mouse in a window, simulated or simulated:rate_hz=1000 offscreen, and recorded:SESSION or
    /// recorded:FILE in both.
    #[arg(long, value_name = "SOURCE")]
    gaze: Option<String>,
    /// Cover the monitor; without it the window is as large as the display in pixels.
    #[arg(long, conflicts_with = "offscreen")]
    fullscreen: bool,
    /// Go on with this observer's unfinished session.
    #[arg(long, conflicts_with_all = ["fresh", "seed"])]
    resume: bool,
    /// Go on although study or display have changed; the change is marked in the session.
    #[arg(long, requires = "resume")]
    force: bool,
    /// Start anew although an unfinished session exists.
    #[arg(long)]
    fresh: bool,
    /// The group of a between-subject design; the one with the fewest observers in --data if not given.
    #[arg(long, value_name = "NAME", conflicts_with = "resume")]
    group: Option<String>,
    /// Which sitting of a study that has several, from 1; the next one if not given.
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    sitting: Option<u32>,
    /// A pilot run: shortened as the study says, and marked as pilot in the data.
    #[arg(long)]
    pilot: bool,
    /// Rehearse a bad disk, for example short=0.1,no-space=0.02,device-error=0.01,slow-sync-ms=200,seed=3 (also
    /// full-from, full-until and kill-at, in operations of the disk from 1).
    #[arg(long, value_name = "FAULTS", value_parser = Faults::parse)]
    faults: Option<Faults>,
}

impl RunArgs {
    /// Whether a bad disk is rehearsed.
    pub(super) fn rehearses(&self) -> bool {
        self.faults.is_some()
    }
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
    let gaze = gaze(args)?;

    // A study that has no name has mistakes, which are reported before any session is looked for.
    let mut sessions = inputs::name(&study).map_or_else(Vec::new, |name| sessions_of(&args.data, &name));
    let before = assignments(&sessions);
    let newest = take_newest(&mut sessions, &args.observer, args.pilot);
    if let Some(session) = newest.as_ref().filter(|session| args.resume && session.record.is_over()) {
        return Err(LabError::BadInput(format!(
            "--resume: {} is over ({} trials); there is nothing to go on with, and --fresh starts anew",
            session.path.display(),
            session.record.trials.len()
        )));
    }
    let unfinished = newest.filter(|session| !session.record.is_over());
    // What was begun goes on with the files that it was begun with.
    let resources = match unfinished.as_ref().filter(|_| args.resume) {
        Some(session) => Resources::of_session(session)?,
        None => Resources::of(&study),
    };
    let whole = resources.plan(&study.file, &study.text, display.as_ref())?;
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
        (Some(session), true, _) => Some(earlier(session, &study, &whole, args.force)?),
        _ => None,
    };
    let seed = match (&earlier, args.seed) {
        (Some(earlier), _) => earlier.session.header.seed,
        (None, Some(seed)) => seed,
        (None, None) => seed_from_clock(),
    };
    if let Some(earlier) = &earlier {
        earlier.session.notices().iter().for_each(|notice| say(notice));
    }
    let assignment = match &earlier {
        Some(earlier) => earlier.session.header.assignment.clone(),
        None => assigned(args, &whole, &before),
    };
    let plan = whole.assigned(&assignment).map_err(|error| LabError::BadInput(error.to_string()))?;
    announce(&whole, &assignment);
    let request = Request {
        plan: Arc::new(plan),
        assignment,
        study,
        resources,
        observer: args.observer.clone(),
        data: args.data.clone(),
        seed,
        earlier,
        disk: match &args.faults {
            Some(faults) => Arc::new(FaultyDisk::new(faults.clone())),
            None => Arc::new(SystemDisk),
        },
    };
    let folder = match &args.simulate {
        Some(truth) => {
            let simulation =
                Simulation::parse(truth).map_err(|error| LabError::BadInput(format!("--simulate: {error}")))?;
            let gaze = gaze.unwrap_or(OffscreenGaze::Simulated);
            offscreen_with_progress(request, &simulation, &gaze, !args.no_render)?
        }
        None => {
            let (folder, finished) = run_in_window(request, gaze.as_ref(), args.fullscreen)?;
            if !finished {
                say("left before the end; everything is saved. Go on with --resume.");
            }
            folder
        }
    };
    print(&folder.display().to_string())
}

/// A session to go on with, if nothing has changed or somebody agrees to what has.
fn earlier(session: SessionFolder, study: &StudyFile, plan: &Plan, force: bool) -> Result<Earlier, LabError> {
    let changed = differences(&session, study, plan)?;
    if !changed.is_empty() && !force {
        return Err(LabError::BadInput(format!(
            "{} was run with something else:\n{}\ngive --force to go on all the same (the session is marked), --fresh to \
             start anew, or the study and display as they were",
            session.path.display(),
            in_words(&changed)
        )));
    }
    if !changed.is_empty() {
        say(&format!("from here on, and marked in the session:\n{}", in_words(&changed)));
    }
    Ok(Earlier { session, changed })
}

/// What a new session runs of its study: what is next for the observer, unless the command line says otherwise.
fn assigned(args: &RunArgs, whole: &Plan, before: &[assignment::Earlier]) -> Assignment {
    let next = next_assignment(whole, &args.observer, before, args.pilot);
    Assignment { group: args.group.clone().or(next.group), sitting: args.sitting.unwrap_or(next.sitting), ..next }
}

/// Says which part of a study is run, where it has parts.
fn announce(whole: &Plan, assignment: &Assignment) {
    let mut parts = Vec::new();
    if let Some(group) = &assignment.group {
        parts.push(format!("group {group}"));
    }
    if let Some(sittings) = &whole.sittings {
        parts.push(format!("sitting {} of {}", assignment.sitting, sittings.count));
    }
    if assignment.pilot {
        parts.push("pilot run, shortened and marked as pilot".to_owned());
    }
    if !parts.is_empty() {
        say(&parts.join(", "));
    }
}

/// Runs a session offscreen behind a progress bar; used by `demo` as well.
pub(super) fn offscreen_with_progress(
    request: Request,
    simulation: &Simulation,
    gaze: &OffscreenGaze,
    render: bool,
) -> Result<PathBuf, LabError> {
    let bar = progress::bar(u64::from(request.plan.max_trials()), "trials");
    let observer = simulation.observer(request.seed);
    let folder = run_offscreen(request, observer, gaze, render, |completed| bar.set_position(u64::from(completed)))?;
    bar.finish_and_clear();
    Ok(folder)
}

/// What `--gaze` asks for, if not for the stage's own: the mouse in a window, a simulated eye offscreen.
fn gaze(args: &RunArgs) -> Result<Option<OffscreenGaze>, LabError> {
    let text = match (args.gaze.as_deref(), args.offscreen) {
        (None | Some("mouse"), false) => return Ok(None),
        (None | Some("simulated"), true) => return Ok(Some(OffscreenGaze::Simulated)),
        (Some(text), _) => text,
    };
    if let Some(eye) = text.strip_prefix("simulated:").filter(|_| args.offscreen) {
        return Ok(Some(OffscreenGaze::Eye(Box::new(simulated_eye(eye)?))));
    }
    let Some(from) = text.strip_prefix("recorded:") else {
        let expected = if args.offscreen {
            "simulated, simulated:rate_hz=1000 (any of the eye's numbers), or recorded:SESSION|FILE offscreen"
        } else {
            "mouse or recorded:SESSION|FILE in a window"
        };
        return Err(LabError::BadInput(format!("--gaze {text}: expected {expected}")));
    };
    if Path::new(from).is_dir() {
        let session = SessionFolder::open(Path::new(from))?;
        session.notices().iter().for_each(|notice| say(notice));
        return Ok(Some(OffscreenGaze::Session(Box::new(session))));
    }
    Ok(Some(OffscreenGaze::Recorded { text: inputs::read_text(from)?, file: from.to_owned() }))
}

/// A simulated eye with some of its numbers changed.
fn simulated_eye(text: &str) -> Result<SimulatedEye, LabError> {
    let bad = |what: String| LabError::BadInput(format!("--gaze simulated:{text}: {what}"));
    let mut eye = serde_json::to_value(SimulatedEye::default()).map_err(|error| bad(error.to_string()))?;
    for part in text.split(',') {
        let (name, value) =
            part.split_once('=').ok_or_else(|| bad(format!("expected NAME=NUMBER, found \"{part}\"")))?;
        let value: f64 = value.parse().map_err(|_| bad(format!("{name}: expected a number, found \"{value}\"")))?;
        let names = eye.as_object().map(|eye| eye.keys().cloned().collect::<Vec<_>>().join(", ")).unwrap_or_default();
        match eye.get_mut(name) {
            Some(number) => *number = serde_json::json!(value),
            None => return Err(bad(format!("expected one of {names}, found \"{name}\""))),
        }
    }
    serde_json::from_value(eye).map_err(|error| bad(error.to_string()))
}

/// The wall clock's nanoseconds: good enough for a seed, which is written to the header.
fn seed_from_clock() -> u64 {
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(1, |since| u64::try_from(since.as_nanos() & u128::from(u32::MAX)).unwrap_or(1))
}
