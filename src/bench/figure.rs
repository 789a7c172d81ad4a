//! The figure of a measurement at several qualities: savings by quality and what each layer costs (after Guenter 2012,
//! Figs. 10 and 11).

use super::{Measured, RendererMeasured};
use analysis::figures::{LayerCurve, LayerPoint, PublishedSaving, QualityMark, Speedup, SpeedupPoint, speedup};

/// The display on which Guenter et al. measured, and its resolution.
const GUENTERS: (&str, [u32; 2]) = ("guenter-2012", [1920, 1080]);
/// m · j (Guenter 2012, §5).
const SLOPE_TIMES_QUALITY: f64 = 0.33;
/// The two qualities of Guenter's study, and what was measured there (§6): ratio of pixels, ratio of time.
const PUBLISHED: [(&str, f64, f64, f64); 2] = [("A", 12.0, 13.3, 5.7), ("B", 15.0, 9.8, 4.8)];

/// Ratios and layers by quality, from every renderer that ran at one.
#[must_use]
pub fn figure(measured: &Measured) -> String {
    let at_quality: Vec<(f64, &RendererMeasured)> =
        measured.renderers.iter().filter_map(|renderer| Some((renderer.quality_index?, renderer))).collect();
    let frames = f64::from(measured.frames.max(1));
    let points = at_quality.iter().map(|(quality, renderer)| SpeedupPoint {
        quality: *quality,
        pixels: renderer.ratios.pixels.map(|ratio| ratio.of_sums),
        time: renderer.ratios.wall_time.map(|ratio| ratio.of_sums),
        ..SpeedupPoint::default()
    });
    let point = |quality, pixels: u64, gpu_time_s: Option<f64>| LayerPoint {
        quality,
        pixels: Some(pixels as f64 / frames),
        time_ms: gpu_time_s.map(|time_s| 1e3 * time_s / frames),
    };

    let mut names: Vec<&str> = Vec::new();
    for layer in at_quality.iter().flat_map(|(_, renderer)| &renderer.layers) {
        if !names.contains(&layer.name.as_str()) {
            names.push(&layer.name);
        }
    }
    let curve = |name: &str| LayerCurve {
        name: name.to_owned(),
        points: at_quality
            .iter()
            .flat_map(|(quality, renderer)| renderer.layers.iter().map(move |layer| (*quality, layer)))
            .filter(|(_, layer)| layer.name == name)
            .map(|(quality, layer)| point(quality, layer.pixels, layer.gpu_time_s))
            .collect(),
    };
    let mut layers: Vec<LayerCurve> = names.into_iter().map(curve).collect();
    let whole = |(quality, renderer): &(f64, &RendererMeasured)| {
        point(*quality, renderer.sums.pixels_shaded, renderer.sums.gpu_time_s)
    };
    layers.push(LayerCurve { name: "S: whole frame".to_owned(), points: at_quality.iter().map(whole).collect() });

    // Only where something was measured is there anything to mark.
    let within = |quality: f64| {
        at_quality.iter().any(|(measured, _)| *measured <= quality)
            && at_quality.iter().any(|(measured, _)| *measured >= quality)
    };
    let known = || PUBLISHED.iter().filter(|(_, quality, ..)| within(*quality));
    let published = (measured.display.as_str(), measured.resolution_px) == GUENTERS;
    speedup(&Speedup {
        points: points.collect(),
        marks: known()
            .map(|(level, quality, ..)| QualityMark { name: format!("{level}: j = {quality}"), quality: *quality })
            .collect(),
        published: known()
            .filter(|_| published)
            .map(|(_, quality, pixels, time)| PublishedSaving { quality: *quality, pixels: *pixels, time: *time })
            .collect(),
        publication: "Guenter et al. 2012, on their GPU".to_owned(),
        layers,
        slope_times_quality: Some(SLOPE_TIMES_QUALITY),
    })
}
