//! A measurement as tables for a terminal: means of one frame, ratios to the reference, and the layers.

use crate::bench::{Measured, Ratio, RendererMeasured};
use std::fmt::Write as _;

/// The whole text.
pub(super) fn text(measured: &Measured) -> String {
    let [width, height] = measured.resolution_px;
    // Writing to a string cannot fail.
    let mut text = format!(
        "{} on {} ({width}×{height}), gaze {}, {} frames at {} a second after {} that do not count\n{}\n\n\
         means of one frame\n  renderer                pixels   drawn   counted    shader runs   triangles     GPU ms    wall ms\n",
        measured.scene,
        measured.display,
        measured.gaze,
        measured.frames,
        measured.fps,
        measured.warm_up_frames,
        measured.adapter
    );
    let frames = f64::from(measured.frames.max(1));
    for renderer in &measured.renderers {
        let sums = &renderer.sums;
        let _ = writeln!(
            text,
            "  {:<18} {:>11.0} {:>7}   {:>7}    {:>11.0} {:>11.0} {:>10} {:>10.2}",
            name(renderer),
            sums.pixels_shaded as f64 / frames,
            share(sums.pixels_drawn, sums.pixels_shaded),
            share(renderer.counted.pixels, sums.pixels_drawn),
            renderer.counted.shading_runs as f64 / frames,
            sums.triangles as f64 / frames,
            sums.gpu_time_s.map_or_else(|| "–".to_owned(), |time_s| format!("{:.2}", 1e3 * time_s / frames)),
            1e3 * sums.wall_time_s / frames,
        );
    }
    text.push_str(
        "  drawn: the scene's share of the pixels, the rest is the renderer's own; counted: on the GPU, of those drawn\n\n\
         reference / renderer: of sums (quartiles of frames)\n  \
         renderer           pixels                GPU time              wall time             triangles\n",
    );
    for renderer in &measured.renderers {
        let ratios = &renderer.ratios;
        let _ = writeln!(
            text,
            "  {:<18} {:<21} {:<21} {:<21} {}",
            name(renderer),
            ratio(ratios.pixels),
            ratio(ratios.gpu_time),
            ratio(ratios.wall_time),
            ratio(ratios.triangles)
        );
    }
    if measured.renderers.iter().any(|renderer| !renderer.layers.is_empty()) {
        text.push_str("\nlayers, means of one frame\n  renderer           layer         drawn in       pixels   triangles     GPU ms\n");
    }
    for renderer in &measured.renderers {
        for layer in &renderer.layers {
            let _ = writeln!(
                text,
                "  {:<18} {:<11} {:>5} of {:<3} {:>11.0} {:>11.0} {:>10}",
                name(renderer),
                layer.name,
                layer.drawn_in_frames,
                measured.frames,
                layer.pixels as f64 / frames,
                layer.triangles as f64 / frames,
                layer.gpu_time_s.map_or_else(|| "–".to_owned(), |time_s| format!("{:.2}", 1e3 * time_s / frames)),
            );
        }
    }
    text.truncate(text.trim_end().len());
    text
}

fn name(renderer: &RendererMeasured) -> String {
    renderer.quality_index.map_or_else(|| renderer.renderer.clone(), |j| format!("{} j = {j}", renderer.renderer))
}

/// A share in percent, exact where it is all.
fn share(part: u64, whole: u64) -> String {
    match (part, whole) {
        (0, 0) => "–".to_owned(),
        (part, whole) if part == whole => "100 %".to_owned(),
        (part, whole) => format!("{:.1} %", 100.0 * part as f64 / whole.max(1) as f64),
    }
}

fn ratio(ratio: Option<Ratio>) -> String {
    let Some(ratio) = ratio else { return "–".to_owned() };
    let spread = ratio.quartiles.map_or_else(String::new, |[low, high]| format!(" ({low:.2}–{high:.2})"));
    format!("{:.2}{spread}", ratio.of_sums)
}
