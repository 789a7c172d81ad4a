//! Pictures must not depend on what was shown before, however little of it is kept.

use super::*;
use crate::stage::ghost;
use experiments::catalogue::{DetailLaw, ParameterValue};
use experiments::study::plan::{Fixation, FoveationCentre};
use experiments::trial::Stimulus;

fn condition(scene: &str, parameter: Option<(&str, &str)>, renderer: &str) -> Condition {
    let catalogue = ghost::registry().catalogue();
    let complete = |schemas: &[experiments::catalogue::ParameterSchema], given: Parameters| {
        experiments::catalogue::complete_parameters(schemas, &given).expect("valid")
    };
    let text = |(name, value): (&str, &str)| (name.to_owned(), ParameterValue::Text(value.to_owned()));
    let (scene_info, renderer_info) =
        (catalogue.scene(scene).expect("ships"), catalogue.renderer(renderer).expect("ships"));
    Condition {
        name: format!("{scene} {parameter:?} {renderer}"),
        scene: scene.to_owned(),
        scene_parameters: complete(&scene_info.parameters, parameter.map(text).into_iter().collect()),
        renderer: renderer.to_owned(),
        renderer_parameters: complete(&renderer_info.parameters, Parameters::new()),
        detail: DetailLaw::Unknown,
        fixation: Fixation::Cross,
        foveation: FoveationCentre::Gaze,
    }
}

fn painter() -> Painter {
    let display = Display::named("demo-540p").expect("ships");
    let registry = ghost::registry();
    Painter::new(Gpu::headless().expect("a device"), &registry, &display, [0.0; 2], wgpu::TextureFormat::Rgba8Unorm)
}

fn frame<'a>(presentation: &'a Presentation, condition: &'a Condition, level: &'a Level) -> View<'a> {
    View { condition: Some(condition), level: Some(level), gaze_deg: [2.0, 1.0], ..View::blank(presentation) }
}

/// Six scenes, more than are kept, under two renderers and two levels: forwards, backwards and interleaved, with a
/// painter that has seen everything and with one that has seen nothing.
#[test]
fn pictures_are_the_same_in_whichever_order_conditions_alternate() {
    let scenes = [
        condition("photo", Some(("image", "coffee")), "ring"),
        condition("photo", Some(("image", "chelsea")), "ring"),
        condition("orbit", None, "layers"),
        condition("noise", None, "ring"),
        condition("orbit", None, "ring"),
        condition("photo", Some(("image", "coffee")), "layers"),
        condition("noise", None, "layers"),
    ];
    let mut other = condition("photo", Some(("image", "chelsea")), "ring");
    other.scene_parameters = scenes[0].scene_parameters.clone();
    let level = |mar_deg: f64| Level::from([("mar_deg".to_owned(), mar_deg)]);
    let mut shown: Vec<(Condition, Alternative, Level)> = Vec::new();
    for condition in &scenes {
        shown.push((condition.clone(), Alternative::Reference, Level::new()));
        shown.push((condition.clone(), Alternative::Test, Level::new()));
        if condition.renderer == "ring" {
            shown.push((condition.clone(), Alternative::Test, level(1.5)));
        }
    }

    let hash = |painter: &mut Painter, (condition, alternative, level): &(Condition, Alternative, Level)| {
        let presentation = Presentation::stimulus(*alternative);
        let (picture, cost) = painter.picture(&frame(&presentation, condition, level)).expect("drawn");
        assert!(cost.is_some());
        crate::stage::frame_hash::picture_hash(picture.as_raw())
    };
    let mut alone = Vec::new();
    let mut used = painter();
    for item in &shown {
        alone.push(hash(&mut used, item));
    }
    // Conditions of which some differ in nothing but the scene, the renderer or the level give different pictures.
    let mut distinct = alone.clone();
    distinct.sort();
    distinct.dedup();
    assert!(distinct.len() >= 10, "{} of {}", distinct.len(), alone.len());

    let backwards = (0..shown.len()).rev();
    let interleaved = (0..shown.len()).map(|index| (index * 5) % shown.len());
    for index in backwards.chain(interleaved) {
        assert_eq!(hash(&mut used, &shown[index]), alone[index], "{:?}", shown[index]);
    }
    // A device and painter of its own for one that was evicted above.
    let fresh = hash(&mut painter(), &shown[1]);
    assert_eq!(fresh, alone[1]);
}

#[test]
fn only_a_few_scenes_and_one_renderer_for_each_name_are_kept() {
    let mut painter = painter();
    let conditions =
        [("photo", "ring"), ("orbit", "layers"), ("noise", "ring"), ("photo", "layers")].map(|(scene, renderer)| {
            let mut condition = condition(scene, None, renderer);
            condition.name = format!("{scene} {renderer}");
            condition
        });
    for condition in &conditions {
        painter.prepare(condition).expect("made");
    }
    assert_eq!(painter.tests.keys().collect::<Vec<_>>(), ["layers", "ring"]);
    assert!(painter.scenes.get(|key| key.0 == "photo").is_some() && !painter.scenes.is_full());
}

#[test]
fn black_is_black_and_grey_is_grey() {
    let mut painter = painter();
    for (presentation, value) in [(Presentation::Black, 0), (Presentation::Grey, 128)] {
        let (picture, cost) = painter.picture(&View::blank(&presentation)).expect("drawn");
        assert_eq!(cost, None);
        assert!(picture.pixels().all(|pixel| pixel.0 == [value, value, value, 255]), "{presentation:?}");
    }
}

#[test]
fn letters_hints_and_scales_are_part_of_the_picture_and_of_its_key() {
    let mut painter = painter();
    let condition = condition("photo", None, "ring");
    let level = Level::new();
    let presentation = Presentation::Stimulus(Stimulus { letter: Some('A'), ..Stimulus::new(Alternative::Reference) });
    let plain = frame(&presentation, &condition, &level);
    let with = |marks: Vec<Mark>| View { marks, ..plain.clone() };
    let letter = |letter| with(vec![Mark::Letter { at_deg: [0.0; 2], letter }]);
    let views = [plain.clone(), letter('A'), letter('B'), with(vec![Mark::Fixation { at_deg: [0.0; 2] }])];
    let pictures: Vec<RgbaImage> = views.iter().map(|view| painter.picture(view).expect("drawn").0).collect();
    for (i, a) in views.iter().enumerate() {
        for (j, b) in views.iter().enumerate() {
            assert_eq!(pictures[i] == pictures[j], i == j, "pictures {i} and {j}");
            assert_eq!(painter.same_picture(&FrameKey::from(a), &FrameKey::from(b)), i == j, "keys {i} and {j}");
        }
    }
    // A sphere that moves makes another frame, also over a scene that stands still.
    let sphere = |x| with(vec![Mark::Sphere { at_deg: [x, 0.0], diameter_deg: 0.8, colour: [40, 200, 60] }]);
    assert!(!painter.same_picture(&FrameKey::from(&sphere(0.0)), &FrameKey::from(&sphere(0.1))));

    let page = Presentation::Text("Which?".to_owned());
    let bare = View::blank(&page);
    let hinted = View { hint: Some("1: the first"), ..bare.clone() };
    assert!(!painter.same_picture(&FrameKey::from(&bare), &FrameKey::from(&hinted)));
    assert_ne!(painter.picture(&bare).expect("drawn").0, painter.picture(&hinted).expect("drawn").0);
}

#[test]
fn the_reference_of_a_frame_is_its_picture_without_foveation() {
    let mut painter = painter();
    let condition = condition("photo", None, "ring");
    let level = Level::from([("mar_deg".to_owned(), 1.5)]);
    let [test, reference] = [Alternative::Test, Alternative::Reference].map(Presentation::stimulus);
    let view = frame(&test, &condition, &level);
    let foveated = painter.picture(&view).expect("drawn").0;
    let found = painter.reference_picture(&view).expect("drawn").expect("a stimulus");
    assert_ne!(found, foveated);
    assert_eq!(found, painter.picture(&frame(&reference, &condition, &level)).expect("drawn").0);
    assert_eq!(painter.reference_picture(&View::blank(&Presentation::Grey)).expect("nothing to draw"), None);
}

/// Closed form: a sphere in the middle has the radius d·tan(½·diameter) on the display.
#[test]
fn spheres_are_as_large_as_they_say_and_stand_on_the_display() {
    let painter = painter();
    let display = Display::named("demo-540p").expect("ships");
    let marks = vec![
        Mark::Sphere { at_deg: [0.0; 2], diameter_deg: 1.2, colour: [1, 2, 3] },
        Mark::Fixation { at_deg: [0.0; 2] },
    ];
    let view = View { marks, ..View::blank(&Presentation::Fixation) };
    let found = painter.discs(&view, [960, 540]);
    let expected_px = display.distance_mm() * (0.6_f64).to_radians().tan() / display.pitch_mm()[0];
    assert_eq!(found.len(), 1);
    assert!((found[0].radius_px - expected_px).abs() < 0.01 * expected_px, "{found:?}");
    assert_eq!(found[0].centre_px, [480.0, 270.0]);
    // In a larger window the display stands in the middle.
    assert_eq!(painter.discs(&view, [1000, 600])[0].centre_px, [500.0, 300.0]);
}

/// A new version of a renderer in WGSL is drawn from the next frame on; one with mistakes or other parameters is refused and
/// changes nothing.
#[test]
fn a_new_version_of_a_renderer_takes_its_place() {
    let version = |more: &str, value: f64| {
        format!(
            "//! parameter dim [] 0..1 = 1: How dim.\n{more}fn colour(at: Place, given: Parameters) -> vec3f {{ return vec3f({value:.1} * given.dim); }}\n"
        )
    };
    let mut registry = Registry::built_in();
    registry.add_wgsl("mine", &version("", 0.5), "mine.wgsl").expect("no mistake");
    let display = Display::named("demo-540p").expect("ships");
    let gpu = Gpu::headless().expect("a device");
    let mut painter = Painter::new(gpu, &Arc::new(registry), &display, [0.0; 2], wgpu::TextureFormat::Rgba8Unorm);
    let mut condition = condition("noise", None, "ring");
    condition.renderer = "mine".to_owned();
    condition.renderer_parameters = Parameters::from([("dim".to_owned(), ParameterValue::Number(0.8))]);
    let presentation = Presentation::stimulus(Alternative::Test);
    let level = Level::new();
    let grey =
        |painter: &mut Painter| painter.picture(&frame(&presentation, &condition, &level)).expect("drawn").0[(9, 9)][0];
    // sRGB of 0.4 and 0.8 of the peak, IEC 61966-2-1.
    assert_eq!(grey(&mut painter), 170);
    for (wrong, words) in [
        (version("", 0.5).replace("given.dim", "given.dam"), "mine.wgsl:2:"),
        (version("//! parameter more [] 0..1 = 1: Another.\n", 1.0), "the same parameters"),
    ] {
        let refused = painter.replace_wgsl("mine", &wrong, "mine.wgsl").expect_err("refused");
        assert!(refused.to_string().contains(words), "{refused}");
        assert_eq!(grey(&mut painter), 170);
    }
    painter.replace_wgsl("mine", &version("", 1.0), "mine.wgsl").expect("no mistake");
    assert_eq!(grey(&mut painter), 231);
}

/// A presentation of a renderer that remembers is the same whatever was shown, warmed up or looked at aside before it, and
/// none of its frames is taken for another.
#[test]
fn a_presentation_begins_anew() {
    let mut painter = painter();
    let condition = condition("photo", None, "ghost");
    let level = Level::from([("step_px".to_owned(), 2.0)]);
    let presentation = Presentation::stimulus(Alternative::Test);
    let at = |presentation_seq, frame_index| View {
        presentation_seq,
        frame_index,
        ..frame(&presentation, &condition, &level)
    };
    let shown = |painter: &mut Painter, seq, frames: std::ops::Range<u64>| -> Vec<String> {
        let one = |frame| {
            let (picture, _) = painter.picture(&at(seq, frame)).expect("drawn");
            crate::stage::frame_hash::picture_hash(picture.as_raw())
        };
        frames.map(one).collect()
    };
    let first = shown(&mut painter, 7, 0..4);
    let mut distinct = first.clone();
    distinct.dedup();
    assert_eq!(distinct.len(), 4, "every frame is another picture");
    assert!(painter.remembers(&at(7, 3)).expect("made"));
    assert!(!painter.same_picture(&FrameKey::from(&at(7, 3)), &FrameKey::from(&at(7, 4))));

    assert_eq!(shown(&mut painter, 8, 0..4), first, "another presentation");
    let fixation = Presentation::Fixation;
    painter.warm_up(&View { presentation: &fixation, ..at(9, 0) }).expect("drawn");
    assert_eq!(shown(&mut painter, 9, 0..4), first, "after a warm-up under its own number");
    // An observer who looks at pixels sees the first picture before it is shown.
    painter.reference_picture(&at(10, 0)).expect("drawn");
    painter.picture(&at(10, 0)).expect("drawn");
    assert_eq!(shown(&mut painter, 10, 0..4), first, "after a look aside");
    // Passing over frames is as good as showing them.
    painter.pass_over(&at(11, 0)).expect("drawn");
    painter.pass_over(&at(11, 1)).expect("drawn");
    assert_eq!(shown(&mut painter, 11, 2..4), first[2..]);
    // And leaving them out is not, or this test would say nothing.
    assert_ne!(shown(&mut painter, 12, 3..4), first[3..]);
}
