//! `parafovea replay`: a session's frames again, from its log alone, as pictures or as a check.

use super::{print, print_json, progress, say};
use crate::error::LabError;
use crate::replay::Replay;
use crate::resources::Resources;
use crate::session::SessionFolder;
use crate::session::tables::FrameRow;
use crate::stage::Painter;
use crate::stage::frame_hash::picture_hash;
use crate::stage::painter::FrameKey;
use clap::Args;
use experiments::trial::Presentation;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stimuli::Registry;
use stimuli::gpu::Gpu;

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("what").required(true).multiple(true).args(["frames", "verify"]))]
pub(super) struct ReplayArgs {
    /// The session's folder.
    session: PathBuf,
    /// Draw the logged frames into this folder as PNG files.
    #[arg(long, value_name = "DIR")]
    frames: Option<PathBuf>,
    /// Draw every frame that was hashed in the run and compare.
    #[arg(long)]
    verify: bool,
    /// Only this trial.
    #[arg(long)]
    trial: Option<u32>,
    /// At most so many frames.
    #[arg(long, value_name = "N")]
    limit: Option<usize>,
    /// Only frames with a stimulus.
    #[arg(long)]
    stimuli: bool,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// What a replay found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Outcome {
    pub frames: usize,
    pub pictures_written: usize,
    pub hashes_compared: usize,
    pub hashes_different: usize,
    pub first_different: Option<u64>,
}

pub(super) fn run(args: &ReplayArgs) -> Result<(), LabError> {
    let outcome = replay(args)?;
    if args.json {
        print_json(&outcome)?;
    } else {
        let mut lines = vec![format!("{} frames", outcome.frames)];
        if let Some(dir) = &args.frames {
            lines.push(format!("{} pictures in {}", outcome.pictures_written, dir.display()));
        }
        if args.verify {
            lines.push(format!("{} hashes compared, {} different", outcome.hashes_compared, outcome.hashes_different));
        }
        print(&lines.join("\n"))?;
    }
    if args.verify {
        verdict(&outcome)?;
    }
    Ok(())
}

fn verdict(outcome: &Outcome) -> Result<(), LabError> {
    match outcome.first_different {
        Some(first) => Err(LabError::Failed(format!(
            "{} of {} frames are not what the run showed, first frame {first}; another graphics adapter or driver may \
             round differently, a changed log shows something else",
            outcome.hashes_different, outcome.hashes_compared
        ))),
        None if outcome.hashes_compared == 0 => {
            Err(LabError::Failed("the run wrote no hashes to compare with; was it run with --no-render?".to_owned()))
        }
        None => Ok(()),
    }
}

fn replay(args: &ReplayArgs) -> Result<Outcome, LabError> {
    let session = SessionFolder::open(&args.session)?;
    session.notices().iter().for_each(|notice| say(notice));
    let file = format!("{} (study)", args.session.join("session.json").display());
    let resources = Resources::recorded(&session.header)?;
    let plan = resources.plan(&file, &session.header.study.text, Some(&session.display))?;
    let plan =
        plan.assigned(&session.header.assignment).map_err(|error| LabError::BadInput(format!("{file}: {error}")))?;
    let replay = Replay::open(&session, plan)?;
    replay.notices.iter().for_each(|notice| say(notice));
    let wanted = |frame: &&FrameRow| {
        args.trial.is_none_or(|trial| frame.trial == Some(trial))
            && (args.frames.is_some() || frame.hash.is_some())
            && (!args.stimuli
                || replay.view(frame).is_ok_and(|view| matches!(view.presentation, Presentation::Stimulus(_))))
    };
    let frames: Vec<&FrameRow> = replay.frames().iter().filter(wanted).take(args.limit.unwrap_or(usize::MAX)).collect();
    draw(&replay, &resources.registry, &frames, args.frames.as_deref(), args.verify)
}

/// Draws frames again; used by `demo` as well.
pub(super) fn draw(
    replay: &Replay,
    registry: &Arc<Registry>,
    frames: &[&FrameRow],
    pictures: Option<&Path>,
    verify: bool,
) -> Result<Outcome, LabError> {
    let plan = replay.plan();
    let mut painter = Painter::new(
        Gpu::headless()?,
        registry,
        &plan.display,
        plan.gaze.fixation_deg,
        wgpu::TextureFormat::Rgba8Unorm,
    );
    if let Some(dir) = pictures {
        std::fs::create_dir_all(dir).map_err(|error| LabError::io("make", dir, &error))?;
    }
    let mut outcome = Outcome {
        frames: frames.len(),
        pictures_written: 0,
        hashes_compared: 0,
        hashes_different: 0,
        first_different: None,
    };
    let bar = progress::bar(frames.len() as u64, "frames");
    let mut last: Option<(FrameKey, image::RgbaImage, String)> = None;
    // The phase and number of the frame before.
    let mut drawn: Option<(u64, u64)> = None;
    for frame in frames {
        let view = replay.view(frame)?;
        // A picture that depends on those before it needs them drawn, wanted or not.
        if painter.remembers(&view)? {
            for earlier in replay.presentation(frame).iter().filter(|earlier| earlier.index < frame.index) {
                if drawn.is_none_or(|(phase, index)| phase != frame.phase_seq || index < earlier.index) {
                    painter.pass_over(&replay.view(earlier)?)?;
                }
            }
        }
        drawn = Some((frame.phase_seq, frame.index));
        let key = FrameKey::from(&view);
        let (picture, hash) = match last.take().filter(|(before, ..)| painter.same_picture(before, &key)) {
            Some((_, picture, hash)) => (picture, hash),
            None => {
                let (picture, _) = painter.picture(&view)?;
                let hash = picture_hash(picture.as_raw());
                (picture, hash)
            }
        };
        if let Some(dir) = pictures {
            let path = dir.join(format!("frame-{:06}.png", frame.index));
            picture
                .save(&path)
                .map_err(|error| LabError::Failed(format!("cannot write {}: {error}", path.display())))?;
            outcome.pictures_written += 1;
        }
        if verify && let Some(expected) = &frame.hash {
            outcome.hashes_compared += 1;
            if *expected != hash {
                outcome.hashes_different += 1;
                outcome.first_different.get_or_insert(frame.index);
            }
        }
        last = Some((key, picture, hash));
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::ghost;
    use crate::stage::launch::{OffscreenGaze, Request, StudyFile, run_offscreen};
    use experiments::design::assignment::Assignment;
    use experiments::observers::Simulation;

    const STUDY: &str = r#"{
        "format": 1, "name": "ghosts", "title": "A study for tests",
        "display": { "name": "small", "resolution_px": [64, 48], "size_mm": [100, 75], "distance_mm": 300 },
        "conditions": {
            "photo": { "scene": "photo", "renderer": "ghost", "fixation": { "kind": "free" } }
        },
        "blocks": [{
            "name": "main", "condition": "photo",
            "protocol": { "kind": "two-interval", "fixation_s": 0.1, "interval_s": 0.6, "gap_s": 0.1 },
            "procedure": { "kind": "constant", "repetitions": 2, "levels": { "step_px": [1, 2] } }
        }]
    }"#;

    /// With a renderer whose pictures depend on those before them, every frame is the same again, and so is one that is
    /// asked for alone.
    #[test]
    fn what_remembers_is_replayed_from_the_start_of_its_presentation() {
        let data = tempfile::tempdir().expect("a folder");
        let resources = Resources::with(ghost::registry());
        let plan = resources.plan("study", STUDY, None).expect("a study");
        let request = Request {
            plan: Arc::new(plan.clone()),
            assignment: Assignment::default(),
            study: StudyFile { file: "study".to_owned(), text: STUDY.to_owned() },
            resources: resources.clone(),
            observer: "P01".to_owned(),
            data: data.path().to_owned(),
            seed: 3,
            earlier: None,
            disk: Arc::new(crate::session::disk::SystemDisk),
        };
        let observer = Simulation::parse("pixels").expect("valid").observer(3);
        let folder = run_offscreen(request, observer, &OffscreenGaze::Simulated, true, |_| {}).expect("runs");
        let session = SessionFolder::open(&folder).expect("a session");
        let replay = Replay::open(&session, plan).expect("a log");

        let all: Vec<&FrameRow> = replay.frames().iter().collect();
        let outcome = draw(&replay, &resources.registry, &all, None, true).expect("drawn");
        assert!(outcome.hashes_compared > 200, "{outcome:?}");
        assert_eq!(outcome.hashes_different, 0, "{outcome:?}");

        // Every 17th frame alone.
        let some: Vec<&FrameRow> = replay.frames().iter().step_by(17).collect();
        let outcome = draw(&replay, &resources.registry, &some, None, true).expect("drawn");
        assert_eq!((outcome.hashes_compared, outcome.hashes_different), (some.len(), 0));
        let is_ghost = |frame: &&&FrameRow| {
            replay.view(frame).is_ok_and(|view| {
                view.frame_index > 0
                    && matches!(view.presentation, Presentation::Stimulus(shown)
                        if shown.alternative == experiments::trial::Alternative::Test)
            })
        };
        assert!(some.iter().filter(is_ghost).count() > 3, "the test needs frames in the middle of a presentation");
    }
}
