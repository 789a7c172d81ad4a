//! `parafovea replay`: a session seen again, from its log alone: in a window, as pictures, as a video, or as a check.

use super::{print, print_json, progress, say, settings};
use crate::error::LabError;
use crate::replay::export::{Look, PictureFolder};
use crate::replay::overlay::Parts;
use crate::replay::verify::{Judge, Verdict};
use crate::replay::video::{self, Written};
use crate::replay::{Drawer, Replay, window};
use crate::resources::{Resources, add_path};
use crate::session::SessionFolder;
use crate::session::tables::FrameRow;
use clap::{Args, ValueEnum};
use experiments::catalogue::ParameterValue;
use experiments::trial::Presentation;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stimuli::Registry;

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("what").multiple(true).args(["frames", "video", "verify"]))]
pub(super) struct ReplayArgs {
    /// The session's folder. Without --frames, --video or --verify a window shows it.
    session: PathBuf,
    /// Draw the logged frames into this folder as PNG files.
    #[arg(long, value_name = "DIR")]
    frames: Option<PathBuf>,
    /// Make a video of the logged frames with ffmpeg; without ffmpeg, numbered PNG files in a folder of the same name.
    #[arg(long, value_name = "FILE.mp4|FILE.webm")]
    video: Option<PathBuf>,
    /// Draw every frame that was hashed in the run and compare.
    #[arg(long)]
    verify: bool,
    /// Only this trial; in a window, begin with it.
    #[arg(long)]
    trial: Option<u32>,
    /// At most so many frames.
    #[arg(long, value_name = "N", requires = "what")]
    limit: Option<usize>,
    /// Only frames with a stimulus.
    #[arg(long, requires = "what")]
    stimuli: bool,
    /// What is laid over the pictures.
    #[arg(long, value_name = "PART,...", value_enum, value_delimiter = ',')]
    overlay: Vec<OverlayPart>,
    /// Show the full-resolution reference beside the picture.
    #[arg(long)]
    reference: bool,
    /// How fast the video plays, times real time.
    #[arg(long, value_name = "TIMES", default_value_t = 1.0, value_parser = speed, requires = "video")]
    speed: f64,
    /// Draw foveated pictures with this renderer (see `parafovea devices`) or WGSL file instead, on the same gaze. The
    /// trial's level does not apply to it.
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "verify")]
    renderer: Option<String>,
    /// A parameter of that renderer; may be given again.
    #[arg(long, value_name = "NAME=VALUE", value_parser = settings::assignment, requires = "renderer")]
    set: Vec<(String, ParameterValue)>,
    /// Print one JSON document.
    #[arg(long, requires = "what")]
    json: bool,
}

/// A part of the overlay, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OverlayPart {
    /// Where gaze was.
    Gaze,
    /// Where it came from in the last half second.
    Trail,
    /// Rings at 5, 10, 20, 30 … degrees of eccentricity.
    Rings,
}

fn speed(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|x| (0.01..=100.0).contains(x));
    number.ok_or_else(|| "expected a number from 0.01 to 100".to_owned())
}

/// What a replay found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Outcome {
    /// Frames that were looked at.
    pub frames: usize,
    pub pictures_written: usize,
    /// Frames of the video, which may show a logged frame several times or not at all.
    pub video_frames: usize,
    /// Where the video, or its pictures without ffmpeg, are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub video: Option<PathBuf>,
    /// What was compared.
    #[serde(flatten)]
    pub verdict: Option<Verdict>,
}

pub(super) fn run(args: &ReplayArgs) -> Result<(), LabError> {
    let (replay, registry) = opened(args)?;
    let look = Look { parts: parts(&args.overlay), reference: args.reference };
    if args.frames.is_none() && args.video.is_none() && !args.verify {
        // A window shows where gaze was unless it is told what to show.
        let parts = if args.overlay.is_empty() { Parts { gaze: true, trail: true, rings: false } } else { look.parts };
        let options = window::Options { look: Look { parts, ..look }, trial: args.trial };
        return window::run(replay, registry, options);
    }
    let frames = chosen(args, &replay)?;
    let mut outcome = draw(&replay, &registry, &frames, args.frames.as_deref(), look, args.verify)?;
    if let Some(file) = &args.video {
        let mut drawer = Drawer::new(Arc::clone(&replay), Arc::clone(&registry));
        let bar = progress::bar(0, "video frames");
        let written = video::write(&mut drawer, &frames, file, look, args.speed, |done, of| {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
        })?;
        bar.finish_and_clear();
        (outcome.video, outcome.video_frames) = match written {
            Written::Video(frames) => (Some(file.clone()), frames),
            Written::Pictures(folder, frames) => {
                let rate_hz = frames_rate_hz(&replay);
                say(&format!(
                    "ffmpeg is not installed: {frames} numbered pictures are in {} instead; with ffmpeg they become a \
                     video by `ffmpeg -framerate {rate_hz} -i {}/%06d.png {}`",
                    folder.display(),
                    folder.display(),
                    file.display()
                ));
                (Some(folder), frames)
            }
        };
    }
    if args.json {
        print_json(&outcome)?;
    } else {
        print(&in_words(args, &outcome))?;
    }
    match outcome.verdict.and_then(|verdict| verdict.failure()) {
        Some(failure) => Err(LabError::Failed(failure)),
        None => Ok(()),
    }
}

fn parts(named: &[OverlayPart]) -> Parts {
    Parts {
        gaze: named.contains(&OverlayPart::Gaze),
        trail: named.contains(&OverlayPart::Trail),
        rings: named.contains(&OverlayPart::Rings),
    }
}

fn frames_rate_hz(replay: &Replay) -> f64 {
    replay.displays().next().map_or(0.0, experiments::Display::refresh_hz)
}

fn in_words(args: &ReplayArgs, outcome: &Outcome) -> String {
    let mut lines = vec![format!("{} frames", outcome.frames)];
    if let Some(dir) = &args.frames {
        lines.push(format!("{} pictures in {}", outcome.pictures_written, dir.display()));
    }
    if let Some(video) = &outcome.video {
        lines.push(format!("{} video frames in {}", outcome.video_frames, video.display()));
    }
    lines.extend(outcome.verdict.as_ref().map(Verdict::summary));
    lines.join("\n")
}

/// The log, and what draws it.
fn opened(args: &ReplayArgs) -> Result<(Arc<Replay>, Arc<Registry>), LabError> {
    let session = SessionFolder::open(&args.session)?;
    session.notices().iter().for_each(|notice| say(notice));
    let resources = Resources::of_session(&session)?;
    let mut replay = Replay::recorded(&session, &resources)?;
    replay.notices.iter().for_each(|notice| say(notice));
    let mut registry = Arc::clone(&resources.registry);
    if let Some(name) = &args.renderer {
        let mut name = name.clone();
        if registry.catalogue().renderer(&name).is_none() && Path::new(&name).exists() {
            let mut with_file = Registry::clone(&registry);
            let file = std::mem::replace(&mut name, "instead".to_owned());
            add_path(&mut with_file, &name, Path::new(&file), false)?;
            registry = Arc::new(with_file);
        }
        let known = registry.catalogue();
        let (of_scene, mut of_renderer) = settings::of_scene_and_renderer(&args.set);
        if let Some(of_scene) = of_scene.keys().next() {
            return Err(LabError::BadInput(format!(
                "--set scene.{of_scene}: the scene is the one that was seen; expected a parameter of the renderer"
            )));
        }
        if let Some(info) = known.renderer(&name) {
            settings::name_choices(&mut of_renderer, &info.parameters);
        }
        replay = replay.with_renderer(&known, &name, &of_renderer)?;
    }
    Ok((Arc::new(replay), registry))
}

/// The frames that are asked for.
fn chosen<'a>(args: &ReplayArgs, replay: &'a Replay) -> Result<Vec<&'a FrameRow>, LabError> {
    if let Some(trial) = args.trial
        && !replay.frames().iter().any(|frame| frame.trial == Some(trial))
    {
        let last = replay.frames().iter().filter_map(|frame| frame.trial).max();
        let found = last.map_or("none".to_owned(), |last| format!("trials up to {last}"));
        return Err(LabError::BadInput(format!(
            "--trial {trial}: expected a trial with frames, the session has {found}"
        )));
    }
    let pictures = args.frames.is_some() || args.video.is_some();
    let wanted = |frame: &&FrameRow| {
        args.trial.is_none_or(|trial| frame.trial == Some(trial))
            && (pictures || frame.hash.is_some())
            && (!args.stimuli
                || replay.shown(frame).is_some_and(|shown| matches!(shown.presentation, Presentation::Stimulus(_))))
    };
    Ok(replay.frames().iter().filter(wanted).take(args.limit.unwrap_or(usize::MAX)).collect())
}

/// Draws frames again; used by `demo` as well.
pub(super) fn draw(
    replay: &Arc<Replay>,
    registry: &Arc<Registry>,
    frames: &[&FrameRow],
    pictures: Option<&Path>,
    look: Look,
    verify: bool,
) -> Result<Outcome, LabError> {
    let mut outcome =
        Outcome { frames: frames.len(), pictures_written: 0, video_frames: 0, video: None, verdict: None };
    if pictures.is_none() && !verify {
        return Ok(outcome);
    }
    let mut drawer = Drawer::new(Arc::clone(replay), Arc::clone(registry));
    let mut judge = if verify { Some(Judge::new(replay, drawer.adapter()?)) } else { None };
    let mut folder = pictures.map(PictureFolder::begin).transpose()?;
    let bar = progress::bar(frames.len() as u64, "frames");
    for frame in frames {
        let seen = drawer.seen(frame)?;
        if let Some(folder) = &mut folder {
            let picture = look.picture(&mut drawer, frame, &seen)?;
            folder.add(format!("frame-{:06}.png", frame.index), &picture)?;
        }
        if let Some(judge) = &mut judge {
            judge.judge(replay, frame, &seen);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    outcome.pictures_written = folder.map(PictureFolder::finish).transpose()?.unwrap_or_default();
    outcome.verdict = judge.map(Judge::verdict);
    Ok(outcome)
}

#[cfg(test)]
mod tests;
