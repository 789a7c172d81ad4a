//! `parafovea demo`: the whole idea at work, with an observer whose acuity is known.

use super::{analyze, inputs, print, replay, run, say};
use crate::error::LabError;
use crate::export;
use crate::replay::Replay;
use crate::replay::export::Look;
use crate::resources::Resources;
use crate::results::fit_sessions;
use crate::results::over_observers::over_observers;
use crate::results::traces::quality;
use crate::session::SessionFolder;
use crate::session::disk::SystemDisk;
use crate::session::tables::FrameRow;
use crate::stage::launch::{OffscreenGaze, Request, StudyFile};
use clap::Args;
use experiments::design::assignment::Assignment;
use experiments::observers::{Simulation, Truth};
use experiments::trial::{Alternative, PhaseName, Presentation};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

/// The study that is run.
const STUDY: &str = "mar-demo";
/// The simulated observer: Guenter's m for a pair test and the average adult's foveal acuity.
const TRUTH: &str = "omega0=0.021,m=0.022,width=0.6,lapse=0.02";

#[derive(Debug, Args)]
pub(super) struct DemoArgs {
    /// Where everything goes.
    #[arg(long, default_value = "demo", value_name = "DIR")]
    data: PathBuf,
    /// Fixes everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Draw no pictures: everything else as fast as it goes.
    #[arg(long)]
    no_render: bool,
}

pub(super) fn run(args: &DemoArgs) -> Result<(), LabError> {
    let simulation = Simulation::parse(TRUTH).map_err(|error| LabError::Failed(error.to_string()))?;
    let Some(Truth::Mar(truth)) = simulation.truth else {
        return Err(LabError::Failed("the demo's observer has no MAR line".to_owned()));
    };
    let study = inputs::study_file(STUDY)?;
    let assignment = Assignment::default();
    let plan = inputs::plan(&study, None)?.assigned(&assignment);
    let plan = Arc::new(plan.map_err(|error| LabError::BadInput(error.to_string()))?);

    say(&format!("1. The study \"{STUDY}\" with a simulated observer ({TRUTH}), seed {}", args.seed));
    let (observer, data) = ("SIM".to_owned(), args.data.clone());
    let resources = Resources::built_in();
    let disk = Arc::new(SystemDisk);
    let request = Request { plan, assignment, study, resources, observer, data, seed: args.seed, earlier: None, disk };
    let folder = run::offscreen_with_progress(request, &simulation, &OffscreenGaze::Simulated, !args.no_render)?;
    let sessions = [SessionFolder::open(&folder)?];
    let trials = sessions[0].record.trials.len();
    say(&format!("   {trials} trials in {}", folder.display()));

    say("2. The fit and its report");
    let results = fit_sessions(&sessions)?;
    let report = folder.with_extension("report.html");
    let quality = quality(results.iter().flat_map(|result| result.sessions.iter().copied()))?;
    crate::report::write(&results, &over_observers(&results).with_linearity(&results), &quality, &report)?;

    say("3. The tables");
    let tables = folder.with_extension("csv");
    export::csv::export(&sessions, &results, &tables)?;

    let mut pictures = None;
    if !args.no_render {
        say("4. Frames drawn again from the log alone, compared with the run's hashes");
        let session = &sessions[0];
        let plan = inputs::plan(
            &StudyFile { file: STUDY.to_owned(), text: session.header.study.text.clone() },
            Some(&session.display),
        )?;
        let replayed = Arc::new(Replay::open(session, plan)?);
        let frames = some_frames(&replayed);
        let dir = folder.with_extension("frames");
        let outcome =
            replay::draw(&replayed, &Resources::built_in().registry, &frames, Some(&dir), Look::default(), true)?;
        if let Some(failure) = outcome.verdict.and_then(|verdict| verdict.failure()) {
            return Err(LabError::Failed(failure));
        }
        say(&format!("   {} frames, all the same as in the run", outcome.frames));
        pictures = Some(dir);
    }

    let fit = results[0].fit.as_ref().ok_or_else(|| LabError::Failed("the demo's trials gave no fit".to_owned()))?;
    let mut text = analyze::table(&results[0]);
    let _ = writeln!(text, "\n  quantity   true       fitted     95 % interval");
    let compared = [
        ("m", truth.m, fit.m),
        ("omega0", truth.omega0_deg, fit.omega0),
        ("width", truth.width, fit.width),
        ("lapse", truth.lapse, fit.lapse),
    ];
    for (name, truth, estimate) in compared {
        let [low, high] = estimate.ci95;
        let held = if (low..=high).contains(&truth) { "holds the truth" } else { "misses the truth" };
        let _ =
            writeln!(text, "  {name:<8}   {truth:<8.4}   {:<8.4}   {low:.4} – {high:.4}   {held}", estimate.estimate);
    }
    let _ =
        write!(text, "\nsession  {}\nreport   {}\ntables   {}", folder.display(), report.display(), tables.display());
    if let Some(pictures) = pictures {
        let _ = write!(text, "\nframes   {}", pictures.display());
    }
    print(&text)
}

/// One frame of each kind from the coarsest trial, and every frame of its degraded interval.
fn some_frames(replay: &Replay) -> Vec<&FrameRow> {
    let omega = |frame: &FrameRow| {
        let view = replay.view(frame).ok()?;
        let is_test =
            matches!(view.presentation, Presentation::Stimulus(shown) if shown.alternative == Alternative::Test);
        is_test.then_some(())?;
        view.level?.get("mar_deg").copied()
    };
    let coarsest = replay
        .frames()
        .iter()
        .filter_map(|frame| Some((omega(frame)?, frame.trial?)))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, trial)) = coarsest else {
        return Vec::new();
    };
    let mut seen: Vec<PhaseName> = Vec::new();
    replay
        .frames()
        .iter()
        .filter(|frame| frame.trial == Some(trial))
        .filter(|frame| {
            let first = !seen.contains(&frame.phase);
            seen.push(frame.phase);
            first || omega(frame).is_some()
        })
        .collect()
}
