//! `parafovea devices`: what there is to run with.

use super::{inputs, print, print_json};
use crate::error::LabError;
use crate::resources::Resources;
use clap::Args;
use experiments::Display;
use experiments::display::NAMED_DISPLAYS;
use serde_json::json;
use std::fmt::Write as _;
use stimuli::gpu::Gpu;

#[derive(Debug, Args)]
pub(super) struct DevicesArgs {
    /// A study, to list what it brings along as well.
    study: Option<String>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DevicesArgs) -> Result<(), LabError> {
    let resources = match &args.study {
        None => Resources::built_in(),
        Some(study) => {
            let study = inputs::study_file(study)?;
            let resources = Resources::of(&study);
            // A study with mistakes is not asked what it brings along.
            resources.plan(&study.file, &study.text, None)?;
            resources
        }
    };
    let catalogue = resources.registry.catalogue();
    let adapter = match Gpu::headless() {
        Ok(gpu) => Ok(format!(
            "{} ({:?}, {} {})",
            gpu.adapter_info.name, gpu.adapter_info.backend, gpu.adapter_info.driver, gpu.adapter_info.driver_info
        )),
        Err(error) => Err(error.to_string()),
    };
    let displays: Vec<Display> = NAMED_DISPLAYS.iter().filter_map(|name| Display::named(name)).collect();
    if args.json {
        return print_json(&json!({
            "adapter": adapter.as_ref().ok(),
            "adapter_error": adapter.as_ref().err(),
            "displays": displays,
            "scenes": catalogue.scenes,
            "renderers": catalogue.renderers,
            "gaze_sources": ["mouse", "simulated", "recorded:FILE"],
        }));
    }
    // Writing to a string cannot fail.
    let mut text = String::new();
    let _ = writeln!(text, "graphics adapter\n  {}", adapter.unwrap_or_else(|error| error));
    let _ = writeln!(text, "\ndisplays (--display)");
    for display in &displays {
        let [width, height] = display.resolution_px();
        let half = display.half_field_deg();
        let _ = writeln!(
            text,
            "  {:<18} {width}×{height} px, {:.1}° × {:.1}°, finest MAR {:.4}°/cycle, {} Hz",
            display.name(),
            2.0 * half[0],
            2.0 * half[1],
            display.finest_mar_deg([0.0, 0.0]),
            display.refresh_hz()
        );
    }
    let parameters = |schemas: &[experiments::catalogue::ParameterSchema]| {
        schemas.iter().fold(String::new(), |mut list, schema| {
            let default = schema.default_value();
            let _ =
                write!(list, "\n      {}: {} (default {default}); {}", schema.name, schema.expectation(), schema.about);
            list
        })
    };
    let _ = writeln!(text, "\nscenes");
    for scene in &catalogue.scenes {
        let _ = writeln!(text, "  {:<18} {}{}", scene.id, scene.about, parameters(&scene.parameters));
    }
    let _ = writeln!(text, "\nrenderers");
    for renderer in &catalogue.renderers {
        let _ = writeln!(text, "  {:<18} {}{}", renderer.id, renderer.about, parameters(&renderer.parameters));
    }
    let _ = write!(text, "\ngaze sources\n  mouse (window), simulated (offscreen), recorded:FILE (offscreen)");
    print(&text)
}
