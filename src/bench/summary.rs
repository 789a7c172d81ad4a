//! What the two passes come to: sums over the same frames, ratios to the reference, layers, and a warning wherever what a
//! renderer or scene says of itself is not what was counted.

use super::frames::Frame;
use super::{Entrant, Ratio, Request, WARM_UP_FRAMES};
use experiments::catalogue::Parameters;
use serde::Serialize;
use stimuli::gpu::Gpu;

/// What was measured; with its names the document of `parafovea bench renderers --json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
    /// Version of this program.
    pub program_version: &'static str,
    /// The graphics device.
    pub adapter: String,
    /// The display's name.
    pub display: String,
    /// Its resolution, width and height.
    pub resolution_px: [u32; 2],
    /// The scene.
    pub scene: String,
    /// What was set of it.
    pub scene_parameters: Parameters,
    /// Where the eye looked.
    pub gaze: String,
    /// Frames in a second of the scene's clock.
    pub fps: f64,
    /// Frames before those that count.
    pub warm_up_frames: u32,
    /// Frames that count.
    pub frames: u32,
    /// Each renderer, the reference first.
    pub renderers: Vec<RendererMeasured>,
    /// Where something is not as it says it is.
    pub warnings: Vec<String>,
}

/// One renderer over all frames that count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RendererMeasured {
    /// Its name.
    pub renderer: String,
    /// The quality index that it ran at, where that was varied.
    pub quality_index: Option<f64>,
    /// What was set of it.
    pub parameters: Parameters,
    /// What all frames cost.
    pub sums: Sums,
    /// What was counted on the GPU.
    pub counted: Counted,
    /// The reference's costs over its own.
    pub ratios: Ratios,
    /// Its layers, innermost first; empty for renderers without.
    pub layers: Vec<LayerSums>,
}

/// Costs, summed over frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sums {
    /// Pixels whose colour was computed, by the scene and by the renderer's own filters, as the renderer says.
    pub pixels_shaded: u64,
    /// Those of them that the scene drew, as the scene says.
    pub pixels_drawn: u64,
    /// Triangles handed to the rasteriser.
    pub triangles: u64,
    /// Camera rays.
    pub rays_traced: u64,
    /// GPU time, seconds; nothing where the device measures none.
    pub gpu_time_s: Option<f64>,
    /// From the call of the renderer to the end of its work on the GPU, seconds.
    pub wall_time_s: f64,
}

/// What was counted on the GPU of the scene's drawings; a renderer's own filters are not counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Counted {
    /// Pixels that were drawn.
    pub pixels: u64,
    /// Runs of the scene's shading function.
    pub shading_runs: u64,
}

/// Ratios of the reference's costs over a renderer's: larger saves more. Nothing where there is none, as of triangles
/// where nobody draws any.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratios {
    /// Of pixels shaded.
    pub pixels: Option<Ratio>,
    /// Of triangles.
    pub triangles: Option<Ratio>,
    /// Of GPU time.
    pub gpu_time: Option<Ratio>,
    /// Of wall time.
    pub wall_time: Option<Ratio>,
}

/// One layer, summed over frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerSums {
    /// Its name.
    pub name: String,
    /// In how many of the frames it was drawn.
    pub drawn_in_frames: u32,
    /// Pixels of its drawings.
    pub pixels: u64,
    /// Pixels of them that were counted on the GPU; nothing where drawings cannot be told to be this layer's.
    pub pixels_counted: Option<u64>,
    /// Triangles of its drawings.
    pub triangles: u64,
    /// GPU time of its drawings, seconds; nothing where one was not measured.
    pub gpu_time_s: Option<f64>,
}

/// Sums up the frames of both passes, for each renderer the same ones.
pub(super) fn measured(gpu: &Gpu, request: &Request, timed: &[Vec<Frame>], counted: &[Vec<Frame>]) -> Measured {
    let reference = timed.first().map_or(&[][..], Vec::as_slice);
    let mut warnings = Vec::new();
    let renderers = request.entrants.iter().zip(timed).zip(counted).map(|((entrant, timed), counted)| {
        let renderer = RendererMeasured {
            renderer: entrant.renderer.clone(),
            quality_index: entrant.quality_index,
            parameters: entrant.parameters.clone(),
            sums: sums(timed),
            counted: counts(counted),
            ratios: ratios(reference, timed),
            layers: layers(timed, counted),
        };
        warnings.extend(disagreements(entrant, &renderer, &sums(counted)));
        renderer
    });
    let renderers = renderers.collect();
    Measured {
        program_version: env!("CARGO_PKG_VERSION"),
        adapter: format!("{} ({:?})", gpu.adapter_info.name, gpu.adapter_info.backend),
        display: request.display.name().to_owned(),
        resolution_px: request.display.resolution_px(),
        scene: request.scene.clone(),
        scene_parameters: request.scene_parameters.clone(),
        gaze: request.gaze.name().to_owned(),
        fps: request.fps,
        warm_up_frames: WARM_UP_FRAMES,
        frames: request.frames,
        renderers,
        warnings,
    }
}

fn sums(frames: &[Frame]) -> Sums {
    Sums {
        pixels_shaded: frames.iter().map(|frame| frame.cost.pixels_shaded).sum(),
        pixels_drawn: frames.iter().map(|frame| frame.drawn.pixels_shaded).sum(),
        triangles: frames.iter().map(|frame| frame.cost.triangles).sum(),
        rays_traced: frames.iter().map(|frame| frame.cost.rays_traced).sum(),
        gpu_time_s: frames.iter().map(|frame| frame.cost.gpu_time_s).sum(),
        wall_time_s: frames.iter().map(|frame| frame.wall_s).sum(),
    }
}

fn counts(frames: &[Frame]) -> Counted {
    let draws = || frames.iter().flat_map(|frame| &frame.counts);
    Counted {
        pixels: draws().map(|draw| u64::from(draw.pixels)).sum(),
        shading_runs: draws().map(|draw| u64::from(draw.runs)).sum(),
    }
}

fn ratios(reference: &[Frame], renderer: &[Frame]) -> Ratios {
    let ratio = |cost: fn(&Frame) -> Option<f64>| {
        let [reference, renderer] = [reference, renderer].map(|frames| frames.iter().map(cost).collect::<Vec<_>>());
        Ratio::new(&reference, &renderer)
    };
    Ratios {
        pixels: ratio(|frame| Some(frame.cost.pixels_shaded as f64)),
        triangles: ratio(|frame| Some(frame.cost.triangles as f64)),
        gpu_time: ratio(|frame| frame.cost.gpu_time_s),
        wall_time: ratio(|frame| Some(frame.wall_s)),
    }
}

/// The layers by name, in the order of the first frame that has them.
fn layers(timed: &[Frame], counted: &[Frame]) -> Vec<LayerSums> {
    let mut names: Vec<&'static str> = Vec::new();
    for layer in timed.iter().flat_map(|frame| &frame.layers) {
        if !names.contains(&layer.name) {
            names.push(layer.name);
        }
    }
    let of_name = |name: &'static str| {
        let drawn =
            || timed.iter().flat_map(|frame| &frame.layers).filter(move |layer| layer.drawn && layer.name == name);
        LayerSums {
            name: name.to_owned(),
            drawn_in_frames: drawn().map(|_| 1).sum(),
            pixels: drawn().map(|layer| layer.cost.pixels_shaded).sum(),
            pixels_counted: counted.iter().map(|frame| counted_of_layer(frame, name)).sum(),
            triangles: drawn().map(|layer| layer.cost.triangles).sum(),
            // The sum of nothing is −0.
            gpu_time_s: drawn().map(|layer| layer.gpu_time_s).sum::<Option<f64>>().map(|time_s| time_s + 0.0),
        }
    };
    names.into_iter().map(of_name).collect()
}

/// Pixels that were counted of a layer in one frame. Layers are drawn in the order in which they are listed, one drawing
/// each; where the numbers of both differ, nothing can be said.
fn counted_of_layer(frame: &Frame, name: &str) -> Option<u64> {
    let drawn: Vec<_> = frame.layers.iter().filter(|layer| layer.drawn).collect();
    (drawn.len() == frame.counts.len()).then(|| {
        let own = drawn.iter().zip(&frame.counts).filter(|(layer, _)| layer.name == name);
        own.map(|(_, count)| u64::from(count.pixels)).sum()
    })
}

/// What is not as it was said to be.
fn disagreements(entrant: &Entrant, measured: &RendererMeasured, in_counted_pass: &Sums) -> Vec<String> {
    let quality = entrant.quality_index.map_or_else(String::new, |j| format!(" at j = {j}"));
    let who = format!("{}{quality}", entrant.renderer);
    let sums = &measured.sums;
    let mut found = Vec::new();
    if measured.counted.pixels != in_counted_pass.pixels_drawn {
        found.push(format!(
            "{who}: {} pixels of the scene were counted on the GPU, {} computed",
            measured.counted.pixels, in_counted_pass.pixels_drawn
        ));
    }
    if sums.pixels_shaded < sums.pixels_drawn {
        found.push(format!(
            "{who}: the renderer states {} pixels shaded, less than the {} that the scene drew for it",
            sums.pixels_shaded, sums.pixels_drawn
        ));
    }
    if (sums.pixels_shaded, sums.triangles) != (in_counted_pass.pixels_shaded, in_counted_pass.triangles) {
        found.push(format!(
            "{who}: {} pixels and {} triangles in the timed frames, {} and {} in the same frames when counted",
            sums.pixels_shaded, sums.triangles, in_counted_pass.pixels_shaded, in_counted_pass.triangles
        ));
    }
    for layer in &measured.layers {
        if let Some(counted) = layer.pixels_counted.filter(|counted| *counted != layer.pixels) {
            found.push(format!("{who}: the {} layer has {} pixels, {counted} counted", layer.name, layer.pixels));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use stimuli::contract::{DrawCost, FrameCost, LayerCost};
    use stimuli::tally::DrawCount;

    fn layer(name: &'static str, drawn: bool, pixels: u64) -> LayerCost {
        let cost = DrawCost { pixels_shaded: if drawn { pixels } else { 0 }, ..DrawCost::default() };
        // A layer that rests still knows the time of its last drawing.
        LayerCost { name, view: None, drawn, cost, gpu_time_s: Some(pixels as f64) }
    }

    fn frame(layers: Vec<LayerCost>) -> Frame {
        let pixels_shaded = layers.iter().map(|layer| layer.cost.pixels_shaded).sum();
        let drawn: Vec<_> = layers.iter().filter(|layer| layer.drawn).collect();
        let count = |layer: &&LayerCost| DrawCount { pixels: layer.cost.pixels_shaded as u32, runs: 1 };
        Frame {
            cost: FrameCost { pixels_shaded, ..FrameCost::default() },
            counts: drawn.iter().map(count).collect(),
            drawn: DrawCost { pixels_shaded, ..DrawCost::default() },
            wall_s: 1.0,
            layers,
        }
    }

    #[test]
    fn layers_that_rest_cost_nothing_and_are_counted_apart() {
        let frames = [
            frame(vec![layer("inner", true, 10), layer("outer", true, 100)]),
            frame(vec![layer("inner", true, 12), layer("outer", false, 100)]),
        ];
        let sums = layers(&frames, &frames);
        let of = |index: usize| {
            let layer: &LayerSums = &sums[index];
            (layer.name.as_str(), layer.drawn_in_frames, layer.pixels, layer.pixels_counted, layer.gpu_time_s)
        };
        assert_eq!(of(0), ("inner", 2, 22, Some(22), Some(22.0)));
        assert_eq!(of(1), ("outer", 1, 100, Some(100), Some(100.0)));
        assert_eq!(sums.len(), 2);
    }

    #[test]
    fn time_that_is_missing_once_is_missing() {
        let mut frames = vec![frame(vec![layer("inner", true, 10)]); 2];
        frames[1].layers[0].gpu_time_s = None;
        assert_eq!(layers(&frames, &frames)[0].gpu_time_s, None);
        assert_eq!(super::sums(&frames).gpu_time_s, None);
        assert!((super::sums(&frames).wall_time_s - 2.0).abs() < 1e-12);
    }

    #[test]
    fn every_disagreement_is_found() {
        let entrant =
            Entrant { renderer: "layers".to_owned(), quality_index: Some(12.0), parameters: Parameters::new() };
        let timed = [frame(vec![layer("inner", true, 10)])];
        let found = |counted: &[Frame]| {
            let measured = RendererMeasured {
                renderer: entrant.renderer.clone(),
                quality_index: entrant.quality_index,
                parameters: Parameters::new(),
                sums: sums(&timed),
                counted: counts(counted),
                ratios: ratios(&timed, &timed),
                layers: layers(&timed, counted),
            };
            disagreements(&entrant, &measured, &sums(counted))
        };
        assert_eq!(found(&timed), Vec::<String>::new());
        let mut off = timed.clone();
        off[0].counts[0].pixels = 11;
        let texts = found(&off);
        assert_eq!(texts.len(), 2, "{texts:?}");
        assert!(texts[0].starts_with("layers at j = 12: 11 pixels of the scene were counted"), "{texts:?}");
        let other = [frame(vec![layer("inner", true, 9)])];
        assert!(found(&other).iter().any(|text| text.contains("in the same frames when counted")));
    }
}
