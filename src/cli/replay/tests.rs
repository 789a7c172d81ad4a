//! Frames of a renderer that remembers, drawn again in order and alone.

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
    let replay = Arc::new(Replay::open(&session, plan).expect("a log"));

    let all: Vec<&FrameRow> = replay.frames().iter().collect();
    let outcome = draw(&replay, &resources.registry, &all, None, Look::default(), true)
        .expect("drawn")
        .verdict
        .expect("verified");
    assert!(outcome.hashes_compared > 200, "{outcome:?}");
    assert_eq!(outcome.hashes_different, 0, "{outcome:?}");

    // Every 17th frame alone.
    let some: Vec<&FrameRow> = replay.frames().iter().step_by(17).collect();
    let outcome = draw(&replay, &resources.registry, &some, None, Look::default(), true)
        .expect("drawn")
        .verdict
        .expect("verified");
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
