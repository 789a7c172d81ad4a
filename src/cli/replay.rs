//! `parafovea replay`: a session's frames again, from its log alone, as pictures or as a check.

use super::{inputs, print, print_json, progress, say};
use crate::error::LabError;
use crate::replay::Replay;
use crate::session::SessionFolder;
use crate::session::tables::FrameRow;
use crate::stage::Painter;
use crate::stage::frame_hash::picture_hash;
use crate::stage::painter::FrameKey;
use clap::Args;
use experiments::study;
use experiments::trial::Presentation;
use serde::Serialize;
use std::path::{Path, PathBuf};
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
    let plan = study::parse_study(&file, &session.header.study.text, &inputs::catalogue(), Some(&session.display))?;
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
    draw(&replay, &frames, args.frames.as_deref(), args.verify)
}

/// Draws frames again; used by `demo` as well.
pub(super) fn draw(
    replay: &Replay,
    frames: &[&FrameRow],
    pictures: Option<&Path>,
    verify: bool,
) -> Result<Outcome, LabError> {
    let plan = replay.plan();
    let mut painter =
        Painter::new(Gpu::headless()?, &plan.display, plan.gaze.fixation_deg, wgpu::TextureFormat::Rgba8Unorm);
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
    for frame in frames {
        let view = replay.view(frame)?;
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
