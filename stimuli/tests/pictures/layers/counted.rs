//! Pixels counted on the GPU against Guenter's published ratios, and layers in turn.

use super::settings;
use crate::common::{Setup, display, gpu, looking_at};
use experiments::catalogue::Parameters;
use experiments::display::Display;
use stimuli::tally::{Tallied, Tally};
use stimuli::{FrameInput, make_scene};

/// Guenter 2012, §6: 13.3 times fewer pixels at quality level A and 9.8 at level B, the middle and outer layers counted half.
#[test]
fn pixels_counted_on_the_gpu_are_those_of_the_paper() {
    let display = Display::named("guenter-2012").unwrap();
    for (m, published) in [(0.0275, 13.3), (0.022, 9.8)] {
        let parameters = settings([("restrict_s2", "2")], [("m", m)]);
        let mut setup = Setup::new(&display, ("noise", &Parameters::new()), ("layers", &parameters));
        let tally = Tally::new(gpu(), display.resolution_px());
        let mut counted = Tallied::new(setup.scene.as_mut(), &tally);
        let mut pixels = Vec::new();
        let mut costs = Vec::new();
        for index in 0..5 {
            let frame = FrameInput { frame_index: index, animation_s: index as f64 / 120.0, ..looking_at([0.0; 2]) };
            costs.push(setup.renderer.render(gpu(), &mut counted, &frame).unwrap().pixels_shaded);
            pixels.push(tally.counts(gpu()).unwrap().pixels());
        }
        // Of the frames after the first, which draws everything.
        let mean = (pixels[4] - pixels[0]) as f64 / 4.0;
        let ratio = display.pixels() as f64 / mean;
        println!("m {m}: {mean:.0} px a frame, ratio {ratio:.3}, published {published}; costs {costs:?}");
        assert!((ratio / published - 1.0).abs() < 0.05, "{ratio}");
        assert_eq!(pixels[4], costs.iter().sum::<u64>(), "the cost is what was counted");
    }
}

#[test]
fn layers_are_drawn_in_turn_and_after_a_saccade() {
    let display = display([480, 270], [510.0, 286.9], 590.0);
    for (layers, names) in [
        ("2", &["inner", "outer"][..]),
        ("3", &["inner", "middle", "outer"]),
        ("4", &["inner", "middle", "far middle", "outer"]),
    ] {
        let parameters = settings([("layers", layers)], [("m", 0.1)]);
        let mut setup = Setup::new(&display, ("noise", &Parameters::new()), ("layers", &parameters));
        let mut drawn = |gaze_deg| -> Vec<bool> {
            let (_, cost) = setup.frame(&looking_at(gaze_deg));
            let costs = setup.renderer.layer_costs();
            assert_eq!(costs.iter().map(|layer| layer.name).collect::<Vec<_>>(), names);
            assert_eq!(costs.iter().map(|layer| layer.cost.pixels_shaded).sum::<u64>(), cost.pixels_shaded);
            for layer in costs {
                let pixels = if layer.drawn { layer.view.unwrap().pixels() } else { 0 };
                assert_eq!(layer.cost.pixels_shaded, pixels, "{}", layer.name);
            }
            costs.iter().map(|layer| layer.drawn).collect()
        };
        let n = names.len();
        assert_eq!(drawn([0.0, 0.0]), vec![true; n], "the first frame draws all");
        for frame in 1..7_usize {
            // A drift of a few minutes of arc does not bring a layer out of turn.
            let expected: Vec<bool> = (0..n).map(|i| i == 0 || (frame + n - 1 - i) % 2 == 1).collect();
            assert_eq!(drawn([0.03 * frame as f64, 0.0]), expected, "{layers} layers, frame {frame}");
        }
        // A saccade in frame 7, where the outermost has its turn: all layers that do not cover the display are drawn.
        assert_eq!(drawn([9.0, -4.0]), vec![true; n]);
        // Off the display, only what shows the display is left, and in frame 8 it rests.
        assert_eq!(drawn([200.0, 0.0]), vec![false; n]);
        assert!(setup.renderer.layer_costs()[0].view.is_none());
        assert!(setup.renderer.layer_costs()[n - 1].view.is_some());
    }
}

/// Times of layers arrive as those of frames do, also of layers that are drawn in every other frame.
#[test]
fn every_layer_is_timed_where_that_is_possible() {
    let display = display([160, 90], [510.0, 286.9], 590.0);
    let mut setup = Setup::new(&display, ("noise", &Parameters::new()), ("layers", &settings([], [("m", 0.3)])));
    for _ in 0..8 {
        setup.frame(&looking_at([0.0; 2]));
    }
    let times: Vec<_> = setup.renderer.layer_costs().iter().map(|layer| (layer.name, layer.gpu_time_s)).collect();
    println!("{times:?}");
    assert!(times.iter().all(|(_, time)| time.is_some() == gpu().timestamps));
    assert!(times.iter().all(|(_, time)| time.is_none_or(|s| (0.0..60.0).contains(&s))));
}

/// Curved surfaces are coarser in the outermost layer alone, edges are smooth, motion is asked for where it is used.
#[test]
fn each_layer_asks_the_scene_for_what_its_switches_say() {
    let display = display([160, 90], [510.0, 286.9], 590.0);
    let asked = |names: &[(&str, &str)]| {
        let mut parameters = settings([], [("m", 0.3)]);
        for &(name, value) in names {
            parameters.extend(settings([(name, value)], []));
        }
        let mut setup = Setup::new(&display, ("noise", &Parameters::new()), ("layers", &parameters));
        let inner = make_scene(gpu(), &display, "noise", &Parameters::new()).unwrap();
        let mut spy = spy::Spy::new(inner);
        setup.renderer.render(gpu(), &mut spy, &looking_at([0.0; 2])).unwrap();
        spy.asked
    };
    let usual = asked(&[]);
    assert_eq!(usual.iter().map(|r| r.detail).collect::<Vec<_>>(), [1.0, 1.0, 0.4]);
    assert_eq!(usual.iter().map(|r| r.motion).collect::<Vec<_>>(), [false, true, true]);
    assert!(usual.iter().all(|r| r.multisampled));
    assert!(asked(&[("lod", "off")]).iter().all(|r| r.detail >= 1.0));
    assert!(asked(&[("msaa", "off")]).iter().all(|r| !r.multisampled));
    assert!(asked(&[("reprojection", "off")]).iter().all(|r| !r.motion));
    assert_eq!(asked(&[("jitter", "all")]).iter().map(|r| r.motion).collect::<Vec<_>>(), [true; 3]);
    // The shift is within half a layer pixel, and none where jitter is off.
    for (usual, unshifted) in usual.iter().zip(asked(&[("jitter", "off")])) {
        assert_eq!(usual.view.target_px, unshifted.view.target_px);
        for axis in 0..2 {
            let shift = (usual.view.origin_px[axis] - unshifted.view.origin_px[axis]) / usual.view.step_px()[axis];
            assert!(shift.abs() < 0.5 && (shift.abs() > 0.0) == usual.motion);
        }
    }
}

/// A scene that notes what is asked of it.
mod spy {
    use stimuli::{DrawCost, DrawRequest, Gpu, RenderError, Scene, SceneIdentity, View};

    #[derive(Debug, Clone, Copy)]
    pub(super) struct Asked {
        pub(super) view: View,
        pub(super) detail: f64,
        pub(super) multisampled: bool,
        pub(super) motion: bool,
    }

    pub(super) struct Spy {
        inner: Box<dyn Scene>,
        pub(super) asked: Vec<Asked>,
    }

    impl Spy {
        pub(super) fn new(inner: Box<dyn Scene>) -> Self {
            Self { inner, asked: Vec::new() }
        }
    }

    impl Scene for Spy {
        fn draw(
            &mut self,
            gpu: &Gpu,
            encoder: &mut wgpu::CommandEncoder,
            request: &DrawRequest<'_>,
            target: &wgpu::TextureView,
        ) -> Result<DrawCost, RenderError> {
            let DrawRequest { view, detail, multisampled, motion, .. } = *request;
            self.asked.push(Asked { view, detail, multisampled, motion: motion.is_some() });
            self.inner.draw(gpu, encoder, request, target)
        }

        fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
            self.inner.picture_changes(from_s, to_s)
        }

        fn identity(&self) -> SceneIdentity {
            self.inner.identity()
        }
    }
}
