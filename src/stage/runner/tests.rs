//! Whole sessions offscreen with targets that move and with free viewing: what the gate demands, what the log says, and
//! that a replay shows the same.

use super::*;
use crate::replay::Replay;
use crate::resources::Resources;
use crate::session::SessionFolder;
use crate::session::disk::SystemDisk;
use crate::session::header::{Header, StageRecord};
use crate::stage::Painter;
use crate::stage::frame_hash::picture_hash;
use crate::stage::launch::{OffscreenGaze, Request, StudyFile, run_offscreen};
use experiments::design::assignment::Assignment;
use experiments::marks::TargetPath;
use experiments::observers::Simulation;
use experiments::study::Plan;
use experiments::study::plan::{Fixation, FoveationCentre, GatePlan, MovingTarget};
use experiments::trial::Presentation;
use std::sync::Arc;
use stimuli::gpu::Gpu;

const TARGET: MovingTarget = MovingTarget { speed_deg_s: 4.0, reach_deg: [6.0, 3.0], diameter_deg: 0.8 };

const STUDY: &str = r#"{
    "format": 1, "name": "looking", "title": "A study for tests",
    "display": { "name": "small", "resolution_px": [160, 90], "size_mm": [100, 56], "distance_mm": 300 },
    "conditions": { "photo": { "scene": "photo", "renderer": "ring", "renderer_parameters": { "width_deg": 2 } } },
    "blocks": [{
        "name": "main", "condition": "photo",
        "protocol": { "kind": "two-interval", "fixation_s": 0.2, "interval_s": 1.5, "gap_s": 0.6 },
        "procedure": {
            "kind": "constant", "repetitions": 2,
            "levels": { "eccentricity_deg": [1.5, 3], "mar_deg": [0.8, 1.6] }
        }
    }]
}"#;

fn header(plan: &Plan) -> Header {
    Header::new(plan, STUDY, "P01", 1, StageRecord::offscreen(&plan.display, false))
}

fn plan(fixation: Fixation, foveation: FoveationCentre) -> Plan {
    let catalogue = stimuli::registry::catalogue();
    let mut plan = experiments::study::parse_study("study", STUDY, &catalogue, None).expect("a study");
    plan.gaze.gate = Some(GatePlan { radius_deg: 2.5, grace_s: 0.3 });
    for cell in plan.blocks.iter_mut().flat_map(|block| &mut block.cells) {
        (cell.condition.fixation, cell.condition.foveation) = (fixation, foveation);
    }
    plan
}

/// Runs a plan offscreen and returns its session, with the folder that holds it.
fn run(plan: &Plan, render: bool) -> (tempfile::TempDir, SessionFolder) {
    let data = tempfile::tempdir().expect("a folder");
    let observer = Simulation::parse("omega0=0.35,m=0.15").expect("a truth").observer(5);
    let request = Request {
        plan: Arc::new(plan.clone()),
        assignment: Assignment::default(),
        study: StudyFile { file: "study".to_owned(), text: STUDY.to_owned() },
        observer: "P01".to_owned(),
        data: data.path().to_owned(),
        seed: 5,
        resources: Resources::built_in(),
        earlier: None,
        disk: Arc::new(SystemDisk),
    };
    let folder = run_offscreen(request, observer, &OffscreenGaze::Simulated, render, |_| {}).expect("runs");
    let session = SessionFolder::open(&folder).expect("a session");
    assert!(session.record.finished);
    (data, session)
}

/// Draws every frame that the run hashed once more and counts those that are not the same.
fn different_when_replayed(session: &SessionFolder, plan: &Plan) -> (usize, usize) {
    let replay = Replay::open(session, plan.clone()).expect("a log");
    let gpu = Gpu::headless().expect("a device");
    let registry = Resources::built_in().registry;
    let mut painter =
        Painter::new(gpu, &registry, &plan.display, plan.gaze.fixation_deg, wgpu::TextureFormat::Rgba8Unorm);
    let hashed: Vec<&FrameRow> = replay.frames().iter().filter(|frame| frame.hash.is_some()).collect();
    let different = hashed.iter().filter(|frame| {
        let (picture, _) = painter.picture(&replay.view(frame).expect("a frame")).expect("drawn");
        frame.hash.as_deref() != Some(picture_hash(picture.as_raw()).as_str())
    });
    (hashed.len(), different.count())
}

fn is_stimulus(frame: &FrameRow) -> bool {
    matches!(frame.phase, PhaseName::Interval1 | PhaseName::Interval2)
}

#[test]
fn a_moving_target_is_gated_logged_and_replayed() {
    let plan = plan(Fixation::Moving(TARGET), FoveationCentre::Target);
    let (_data, session) = run(&plan, true);
    let aborted = session.record.trials.iter().filter(|trial| matches!(trial.outcome, Outcome::Aborted { .. })).count();
    assert!(aborted <= 2, "{aborted} of {} trials aborted although the eye follows", session.record.trials.len());

    // The log says where the target was: on the trial's path, and nowhere else.
    let frames = session.frames().expect("readable").rows;
    let seeds: std::collections::BTreeMap<u32, u64> =
        session.record.trials.iter().filter_map(|record| Some((record.trial.trial, record.trial.path_seed?))).collect();
    let mut moved: f64 = 0.0;
    for frame in &frames {
        let target = frame.target_x_deg.zip(frame.target_y_deg);
        assert_eq!(target.is_some(), is_stimulus(frame), "{:?}", frame.phase);
        if let (Some((x, y)), Some(seed)) = (target, frame.trial.and_then(|trial| seeds.get(&trial))) {
            assert_eq!([x, y], TargetPath::new(TARGET, *seed).at(frame.animation_s));
            moved = moved.max(x.hypot(y));
        }
    }
    assert!(moved > 2.0, "{moved}°");

    // The eye was there: within the gate nearly always.
    let gaze = session.gaze().expect("readable").rows;
    let off: Vec<f64> = frames
        .iter()
        .filter(|frame| is_stimulus(frame) && frame.animation_s > 0.3)
        .filter_map(|frame| {
            let sample = &gaze[frame.gaze_row? as usize];
            Some(
                plan.display.eccentricity_deg([sample.x_deg, sample.y_deg], [frame.target_x_deg?, frame.target_y_deg?]),
            )
        })
        .collect();
    let within = off.iter().filter(|off_deg| **off_deg < 2.0).count() as f64 / off.len() as f64;
    assert!(within > 0.95, "{within}");

    // The picture follows the target, and follows it again.
    let hashes: std::collections::BTreeSet<&str> =
        frames.iter().filter(|frame| is_stimulus(frame)).filter_map(|frame| frame.hash.as_deref()).collect();
    assert!(hashes.len() > 200, "{} pictures", hashes.len());
    let (compared, different) = different_when_replayed(&session, &plan);
    assert!(compared > 500 && different == 0, "{different} of {compared}");
}

/// Runs the first trial with a gaze that is wherever `gaze_deg` says, and answers whether it came to the question.
fn comes_to_the_question(plan: &Plan, gaze_deg: impl Fn(&Session, f64) -> [f64; 2]) -> bool {
    let folder = tempfile::tempdir().expect("a folder");
    let writer = SessionWriter::create(folder.path(), &header(plan), &plan.display).expect("a log");
    let (session, events) = Session::begin(Arc::new(plan.clone()), 1);
    let mut runner = Runner::begin(session, events, writer, Pace::Virtual).expect("begins");
    let step_s = 0.01;
    for step in 0..3000 {
        let t_s = f64::from(step) * step_s;
        let deg = gaze_deg(runner.session(), t_s);
        let sample = GazeSample {
            t_s,
            arrived_s: t_s,
            t_device_s: t_s,
            px: plan.display.px_from_deg(deg),
            valid: true,
            pupil_mm: None,
            left: None,
            right: None,
        };
        runner.gaze_sample(t_s, sample).expect("logged");
        runner.tick(t_s, step_s).expect("logged");
        // An aborted trial is on disk and followed by the next one within a tick.
        if runner.session().trial().is_some_and(|trial| trial.trial > 1) {
            return false;
        }
        if runner.phase().is_some_and(|phase| phase.name == PhaseName::Ask) {
            return true;
        }
    }
    panic!("the trial never ended");
}

#[test]
fn the_gate_stands_around_the_moving_target() {
    let mut plan = plan(Fixation::Moving(TARGET), FoveationCentre::Gaze);
    plan.gaze.gate = Some(GatePlan { radius_deg: 1.0, grace_s: 0.1 });
    assert!(comes_to_the_question(&plan, |session, t_s| session.look_at_deg(session.animation_s(t_s))));
    // An eye that stays where the target began is left behind by it.
    assert!(!comes_to_the_question(&plan, |session, _| session.look_at_deg(0.0)));
}

#[test]
fn the_gate_stands_around_the_mark_and_free_viewing_has_none() {
    let looking_away = |session: &Session, _: f64| {
        let stimulus = session.phase().is_some_and(|phase| matches!(phase.presentation, Presentation::Stimulus(_)));
        if stimulus { [7.0, 3.0] } else { [0.0; 2] }
    };
    assert!(comes_to_the_question(&plan(Fixation::Free, FoveationCentre::Gaze), looking_away));
    assert!(!comes_to_the_question(&plan(Fixation::Cross, FoveationCentre::Gaze), looking_away));
    assert!(comes_to_the_question(&plan(Fixation::Cross, FoveationCentre::Gaze), |_, _| [0.5, 0.5]));
}

#[test]
fn free_viewing_is_not_gated_and_the_eye_wanders() {
    let plan = plan(Fixation::Free, FoveationCentre::Gaze);
    let (_data, session) = run(&plan, true);
    assert!(session.record.trials.iter().all(|trial| matches!(trial.outcome, Outcome::Answered { .. })));
    let frames = session.frames().expect("readable").rows;
    assert!(frames.iter().all(|frame| frame.target_x_deg.is_none() && frame.target_y_deg.is_none()));
    let gaze = session.gaze().expect("readable").rows;
    let far = frames.iter().filter(|frame| is_stimulus(frame)).filter_map(|frame| frame.gaze_row).filter(|row| {
        let sample = &gaze[*row as usize];
        sample.x_deg.hypot(sample.y_deg) > 3.0
    });
    assert!(far.count() > 100, "looks around");
    let (compared, different) = different_when_replayed(&session, &plan);
    assert!(compared > 500 && different == 0, "{different} of {compared}");
}
