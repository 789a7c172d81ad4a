//! `parafovea bench renderers`: what frames of a moving camera cost under each renderer, and what that saves.

mod request;
mod table;

use super::{print, print_json, progress, say};
use crate::bench;
use crate::error::LabError;
use clap::{Args, Subcommand};
use std::path::PathBuf;
use stimuli::gpu::Gpu;

#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Pixels, triangles, GPU and wall time of a camera path under each renderer, and their ratios to full resolution.
    Renderers(RenderersArgs),
}

/// Everything that can be wrong is taken as text, so that all mistakes are reported at once.
#[derive(Debug, Args)]
struct RenderersArgs {
    /// The scene (see `parafovea devices`).
    #[arg(long, default_value = "orbit")]
    scene: String,
    /// A renderer to compare with the reference; may be given again. All there are if not given.
    #[arg(long)]
    renderer: Vec<String>,
    /// The display, by name or file.
    #[arg(long, value_name = "NAME|FILE", default_value = "demo-540p")]
    display: String,
    /// Another resolution of the same display.
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    size: Option<String>,
    /// How many frames count, after two that do not.
    #[arg(long, value_name = "N", default_value = "12", allow_hyphen_values = true)]
    frames: String,
    /// Frames in a second of the scene's clock and of the gaze.
    #[arg(long, value_name = "HZ", default_value = "30", allow_hyphen_values = true)]
    fps: String,
    /// Where the eye looks: over the display in fixations and saccades (sweep), at its centre (centre), or where a
    /// recorded eye looked (recorded:SESSION or recorded:FILE).
    #[arg(long, value_name = "sweep|centre|recorded:SESSION|FILE", default_value = "sweep")]
    gaze: String,
    /// A parameter of the renderers that have it, or of the scene as scene.NAME; may be given again.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Run renderers that have Guenter's quality index at each of these, for example 4,7,10,12,15,18,22.
    #[arg(long, value_name = "J,J,…", value_delimiter = ',', allow_hyphen_values = true)]
    quality: Vec<String>,
    /// Write a figure of savings and layers by quality; needs --quality.
    #[arg(long, value_name = "FILE.svg")]
    figure: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &BenchArgs) -> Result<(), LabError> {
    let What::Renderers(args) = &args.what;
    let request = request::read(args)?;
    let gpu = Gpu::headless()?;
    let bar = progress::bar(request.steps(), "frames");
    let measured = bench::run(&gpu, &request, &|| bar.inc(1));
    bar.finish_and_clear();
    let measured = measured?;
    measured.warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
    if let Some(path) = &args.figure {
        std::fs::write(path, bench::figure(&measured)).map_err(|error| LabError::io("write", path, &error))?;
        say(&format!("figure: {}", path.display()));
    }
    if args.json { print_json(&measured) } else { print(&table::text(&measured)) }
}
