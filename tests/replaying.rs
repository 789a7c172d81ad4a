//! Sessions seen again: every renderer's frames from the log alone, what a changed log shows, other adapters, videos,
//! logs of the first format.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{Ran, copy_folder, finish, program, run, write_json};
use experiments::Display;
use experiments::catalogue::{ParameterKind, ParameterSchema, ParameterValue, Parameters, RendererInfo};
use experiments::session::event::{Event, Seam, Stamped};
use experiments::trial::{Alternative, Input};
use parafovea::gaze::GazeSample;
use parafovea::replay::Replay;
use parafovea::resources::Resources;
use parafovea::session::tables::FrameRow;
use parafovea::session::writer::PATIENCE;
use parafovea::session::{SessionFolder, SessionWriter};
use parafovea::stage::frame_hash::{picture_signature, signature_difference};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use stimuli::contract::FrameInput;
use stimuli::display_pass::{Background, DisplayPass};
use stimuli::gpu::Gpu;

/// A display on which a frame costs next to nothing.
fn tiny_display() -> Value {
    json!({ "name": "tiny", "resolution_px": [64, 48], "size_mm": [200, 150], "distance_mm": 300, "refresh_hz": 20 })
}

/// A study of one renderer with these parameters at two values of the first, so short that it has little more than 500
/// frames.
fn study(renderer: &str, parameters: &BTreeMap<String, f64>) -> Value {
    let (name, value) = parameters.first_key_value().unwrap();
    json!({
        "format": 1, "name": format!("seen-{renderer}"), "title": "Frames to be seen again", "display": tiny_display(),
        "conditions": { "one": {
            "scene": "photo", "renderer": renderer, "renderer_parameters": parameters, "fixation": { "kind": "free" }
        } },
        "blocks": [{
            "name": "main", "condition": "one",
            "protocol": { "kind": "two-interval", "fixation_s": 0.1, "interval_s": 1.5, "gap_s": 0.1 },
            "procedure": { "kind": "constant", "repetitions": 4, "levels": { name: [value, 1.05 * value] } }
        }]
    })
}

/// Parameters of a renderer with which its pictures depend on the gaze as much as they can: each number is near one end of
/// its range or the other, whichever together make the mean colours of two gazes most different.
fn telling_parameters(here: &Path, info: &RendererInfo) -> BTreeMap<String, f64> {
    let gpu = Gpu::headless().unwrap();
    let display = Display::new("tiny", [64, 48], [200.0, 150.0], 300.0).unwrap();
    let pass = DisplayPass::for_display(&gpu, wgpu::TextureFormat::Rgba8Unorm, &display);
    let mut scene = stimuli::registry::make_scene(&gpu, &display, "photo", &Parameters::new()).unwrap();
    let numbers: Vec<(&str, f64, f64)> = info.parameters.iter().filter_map(number).collect();
    let mut tried: Vec<(u8, BTreeMap<String, f64>)> = Vec::new();
    for choice in 0..1_u32 << numbers.len() {
        let at = |(index, (name, min, max)): (usize, &(&str, f64, f64))| {
            let share = if choice >> index & 1 == 0 { 0.02 } else { 0.9 };
            ((*name).to_owned(), min + share * (max - min))
        };
        let parameters: BTreeMap<String, f64> = numbers.iter().enumerate().map(at).collect();
        let given: Parameters =
            parameters.iter().map(|(name, value)| (name.clone(), ParameterValue::Number(*value))).collect();
        let mut renderer = stimuli::registry::make_renderer(&gpu, &display, &info.id, &given).unwrap();
        let [a, b] = [[-8.0, 3.0], [6.0, -2.0]].map(|gaze_deg| {
            renderer.begin();
            let frame = FrameInput { gaze_deg, gaze_motion_deg_s: [0.0; 2], frame_index: 0, animation_s: 0.0 };
            renderer.render(&gpu, scene.as_mut(), &frame).unwrap();
            let background = Background::Picture(renderer.output(), scene.light());
            let picture = stimuli::readback::displayed(&gpu, &pass, [64, 48], background, None).unwrap();
            picture_signature(picture.as_raw(), [64, 48])
        });
        tried.push((signature_difference(&a, &b).unwrap(), parameters));
    }
    tried.sort_by_key(|(difference, _)| std::cmp::Reverse(*difference));
    let accepted = |(_, parameters): &(u8, BTreeMap<String, f64>)| {
        let file = write_json(here, "tried.json", &study(&info.id, parameters));
        run(here, &["check", file.to_str().unwrap()]).code == 0
    };
    let (difference, parameters) =
        tried.into_iter().find(accepted).unwrap_or_else(|| panic!("{}: no accepted study", info.id));
    println!("{}: {parameters:?}, two gazes differ by up to {difference} levels", info.id);
    assert!(difference > 1, "{}: pictures do not depend on the gaze", info.id);
    parameters
}

/// A number's name and ends.
fn number(schema: &ParameterSchema) -> Option<(&str, f64, f64)> {
    match schema.kind {
        ParameterKind::Number { min, max, .. } => Some((&schema.name, min, max)),
        ParameterKind::Choice { .. } => None,
    }
}

/// Runs a study file offscreen with pictures and returns the session's folder.
fn seen(folder: &Path, file: &str) -> PathBuf {
    let arguments =
        ["run", file, "--observer", "SIM", "--offscreen", "--simulate", "pixels", "--data", "data", "--seed", "11"];
    folder.join(run(folder, &arguments).expect(0).out.trim_end())
}

fn verify(folder: &Path, session: &Path) -> Ran {
    run(folder, &["replay", session.to_str().unwrap(), "--verify", "--json"])
}

/// The session again as another program would write it, row by row through the log's own writer: with another adapter in
/// its header, or one gaze sample somewhere else.
fn rewritten(session: &Path, data: &Path, adapter: Option<&str>, moved: Option<(usize, [f64; 2])>) -> PathBuf {
    let from = SessionFolder::open(session).unwrap();
    let mut header = from.header.clone();
    if let Some(adapter) = adapter {
        header.stage.gpu = Some(adapter.to_owned());
    }
    let writer = SessionWriter::create(data, &header, &from.display).unwrap();
    let folder = writer.folder().to_owned();
    // Event 0, which names the header, is the writer's own.
    let (closed, events) = from.journal.events.split_last().unwrap();
    for event in events.iter().filter(|event| event.seq > 0) {
        writer.event(event.clone()).unwrap();
    }
    for (row, gaze) in from.gaze().unwrap().rows.iter().enumerate() {
        let mut px = [gaze.x_px, gaze.y_px];
        if let Some((at, by_px)) = moved
            && at == row
        {
            px = [px[0] + by_px[0], px[1] + by_px[1]];
        }
        let sample = GazeSample {
            t_s: gaze.t_s,
            arrived_s: gaze.arrived_s,
            t_device_s: gaze.t_s,
            px,
            valid: gaze.valid,
            pupil_mm: None,
            left: None,
            right: None,
        };
        writer.gaze(sample).unwrap();
    }
    for frame in from.frames().unwrap().rows {
        writer.frame(frame).unwrap();
    }
    writer.close(closed.clone(), PATIENCE).unwrap();
    folder
}

/// The frames that show one of the two pictures, in order.
fn frames_of(session: &Path, alternative: Alternative) -> Vec<FrameRow> {
    let folder = SessionFolder::open(session).unwrap();
    let resources = Resources::of_session(&folder).unwrap();
    let replay = Replay::recorded(&folder, &resources).unwrap();
    replay.frames().iter().filter(|frame| replay.alternative(frame) == Some(alternative)).cloned().collect()
}

/// A gaze sample that placed the test picture of some frame in the middle of the session.
fn sample_that_matters(session: &Path) -> usize {
    let frames = frames_of(session, Alternative::Test);
    usize::try_from(frames[frames.len() / 2].gaze_row.unwrap()).unwrap()
}

/// Every renderer of the registry: at least 500 hashed frames are the same when drawn from the log alone; one gaze value
/// that was moved is found; on another adapter the mean colours decide, and find it too.
#[test]
fn every_renderer_is_seen_again() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let catalogue = stimuli::registry::catalogue();
    let (mut renderers, mut references) = (0, 0);
    for info in &catalogue.renderers {
        // The reference has nothing to vary: it is half of every other session.
        if info.id == "reference" {
            continue;
        }
        renderers += 1;
        let file = format!("{}.json", info.id);
        write_json(here, &file, &study(&info.id, &telling_parameters(here, info)));
        let session = seen(here, &file);
        let found = verify(here, &session).expect(0).json();
        let compared = found["hashes_compared"].as_u64().unwrap();
        println!("{}: {compared} hashes compared, {} different", info.id, found["hashes_different"]);
        assert!(compared >= 500 && found["hashes_different"] == 0, "{}: {found}", info.id);
        references += frames_of(&session, Alternative::Reference).len();

        // The same through the writer: still sound. One value moved, by 20 pixels (11° to 12°): found.
        let row = sample_that_matters(&session);
        let data = |name: &str| here.join(format!("{}-{name}", info.id));
        let copy = rewritten(&session, &data("copy"), None, None);
        assert_eq!(verify(here, &copy).expect(0).json()["hashes_compared"], compared, "{}", info.id);
        let moved = rewritten(&session, &data("moved"), None, Some((row, [16.0, 12.0])));
        let refused = verify(here, &moved).expect(1);
        let found = refused.json();
        println!(
            "{}: one gaze sample moved: {} frames different, the first {}, by up to {} levels",
            info.id, found["hashes_different"], found["first_different"], found["largest_signature_difference"]
        );
        assert!(found["hashes_different"].as_u64().unwrap() > 0 && refused.err.contains("first frame"), "{refused:?}");

        let another = Some("a card of another maker (Vulkan, driver 1.0)");
        let elsewhere = rewritten(&session, &data("elsewhere"), another, None);
        let found = verify(here, &elsewhere).expect(0).json();
        assert_eq!((&found["hashes_compared"], &found["signatures_compared"]), (&json!(0), &json!(compared)));
        assert!(found["largest_signature_difference"].as_u64().unwrap() <= 1, "{found}");
        let moved = rewritten(&session, &data("elsewhere-moved"), another, Some((row, [16.0, 12.0])));
        let refused = verify(here, &moved).expect(1);
        let found = refused.json();
        assert!(found["signatures_different"].as_u64().unwrap() > 0, "{}: {found}", info.id);
        assert!(refused.err.contains("of 255 levels"), "{refused:?}");
    }
    println!("reference: {references} of these frames");
    assert!(references >= 500 && renderers + 1 == catalogue.renderers.len(), "{renderers}, {references}");
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/sessions/format-1").join(name)
}

/// Sessions of the first format, drawn by Mesa's software Vulkan. On another adapter nothing can be said of them, and that
/// is said.
#[test]
fn sessions_of_the_first_format_are_seen_again() {
    let here = tempfile::tempdir().unwrap();
    for (name, hashed) in [("finished", 88), ("torn", 38), ("resumed", 112)] {
        let ran = verify(here.path(), &fixture(name));
        let found = ran.json();
        let adapter = SessionFolder::open(&fixture(name)).unwrap().header.stage.gpu.unwrap();
        if found["adapter"] == adapter.as_str() {
            assert_eq!(
                (ran.code, &found["hashes_compared"], &found["hashes_different"]),
                (0, &json!(hashed), &json!(0))
            );
        } else {
            println!("{name} was drawn on {adapter}, this is {}: hashes cannot be compared", found["adapter"]);
            assert_eq!(ran.code == 0, found["unjudged"] == 0, "{ran:?}");
        }
    }
}

/// Rows that are gone from a finished session are damage even where every remaining row is sound.
#[test]
fn a_damaged_log_does_not_verify() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let session = here.join("session");
    copy_folder(&fixture("finished"), &session);
    for (file, words) in [("frames.csv", "frames.csv"), ("gaze.csv", "gaze.csv")] {
        let path = session.join(file);
        let whole = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = whole.split_inclusive('\n').collect();
        // A line in the middle that is no row.
        let mut torn = lines.clone();
        torn[40] = "nothing,of,this,is,a,row\n";
        std::fs::write(&path, torn.concat()).unwrap();
        let refused = verify(here, &session);
        assert!(refused.code == 1 && refused.err.contains(words), "{refused:?}");
        // Samples at the end that are gone.
        if file == "gaze.csv" {
            std::fs::write(&path, lines[..lines.len() - 20].concat()).unwrap();
            let refused = verify(here, &session).expect(1);
            assert!(refused.err.contains("the log does not hold"), "{refused:?}");
        }
        std::fs::write(&path, whole).unwrap();
    }
}

fn ffmpeg(arguments: &[&str]) -> Option<Vec<u8>> {
    let output = Command::new("ffmpeg").args(["-hide_banner", "-loglevel", "error"]).args(arguments).output().ok()?;
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(output.stdout)
}

/// A video has the session's frames at the display's rate; each decoded frame has nearly the colours of its picture.
#[test]
fn a_video_shows_the_frames() {
    if ffmpeg(&["-version"]).is_none() {
        println!("skipped: ffmpeg is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let session = fixture("finished");
    let session = session.to_str().unwrap();
    run(here, &["replay", session, "--frames", "pictures"]).expect(0);
    for file in ["all.mp4", "all.webm"] {
        let ran = run(here, &["replay", session, "--video", file]).expect(0);
        assert!(ran.out.contains("88 video frames"), "{ran:?}");
        let path = here.join(file);
        let raw = ffmpeg(&["-i", path.to_str().unwrap(), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]).unwrap();
        let frames: Vec<&[u8]> = raw.chunks_exact(64 * 48 * 3).collect();
        assert_eq!(frames.len(), 88, "{file}");
        let mut largest: f64 = 0.0;
        for (index, frame) in frames.iter().enumerate() {
            let picture = image::open(here.join(format!("pictures/frame-{index:06}.png"))).unwrap().to_rgb8();
            for channel in 0..3 {
                let mean = |bytes: &[u8]| {
                    bytes.iter().skip(channel).step_by(3).map(|&b| f64::from(b)).sum::<f64>() / (64.0 * 48.0)
                };
                largest = largest.max((mean(frame) - mean(picture.as_raw())).abs());
            }
        }
        println!("{file}: mean colours differ by up to {largest:.2} of 255 levels");
        assert!(largest < 4.0, "{file}: {largest}");
    }
    // Half as fast: twice as many; and nothing half-written lies about.
    let ran = run(here, &["replay", session, "--video", "slow.mp4", "--speed", "0.5", "--trial", "2", "--json"]);
    let found = ran.expect(0).json();
    assert_eq!(found["video_frames"].as_u64(), found["frames"].as_u64().map(|frames| 2 * frames));
    let mut names: Vec<String> =
        std::fs::read_dir(here).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["all.mp4", "all.webm", "pictures", "slow.mp4"]);
}

#[test]
fn without_ffmpeg_a_video_becomes_numbered_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let session = fixture("finished");
    let arguments = ["replay", session.to_str().unwrap(), "--video", "clip.mp4", "--trial", "1"];
    let ran = finish(program(here).args(arguments).env("PATH", here)).expect(0);
    assert!(ran.err.contains("ffmpeg is not installed") && ran.err.contains("clip/%06d.png"), "{ran:?}");
    let mut names: Vec<String> = std::fs::read_dir(here.join("clip"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert!(names.len() > 5 && names[0] == "000000.png" && !here.join("clip.mp4").exists(), "{names:?}");
    assert_eq!(std::fs::read_dir(here).unwrap().count(), 1);
}

/// The reference stands unchanged beside the picture, and an overlay changes the picture.
#[test]
fn exports_lay_over_and_stand_beside() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let session = fixture("finished");
    let session = session.to_str().unwrap();
    let export = |name: &str, more: &[&str]| {
        let base = ["replay", session, "--stimuli", "--frames", name];
        run(here, &[&base[..], more].concat()).expect(0);
        let first = std::fs::read_dir(here.join(name)).unwrap().map(|entry| entry.unwrap().path()).min().unwrap();
        image::open(first).unwrap().to_rgb8()
    };
    let plain = export("plain", &[]);
    let marked = export("marked", &["--overlay", "gaze,rings"]);
    let beside = export("beside", &["--reference"]);
    assert_eq!((plain.dimensions(), marked.dimensions()), ((64, 48), (64, 48)));
    assert!(plain != marked);
    assert_eq!(beside.dimensions(), (64 + 8 + 64, 48));
    let left = image::imageops::crop_imm(&beside, 0, 0, 64, 48).to_image();
    assert!(left == plain);
    // The first stimulus of a trial is its reference or its test; some exported picture has two different halves.
    let different = std::fs::read_dir(here.join("beside")).unwrap().any(|entry| {
        let both = image::open(entry.unwrap().path()).unwrap().to_rgb8();
        let half = |x| image::imageops::crop_imm(&both, x, 0, 64, 48).to_image();
        half(0) != half(72)
    });
    assert!(different, "every test picture looks like its reference");
}

/// Another renderer on the same gaze: its pictures are others, the reference's are not, and it cannot be verified.
#[test]
fn another_renderer_takes_the_tests_place() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let session = fixture("finished");
    let session = session.to_str().unwrap();
    run(here, &["replay", session, "--frames", "ring", "--stimuli"]).expect(0);
    let other = ["--renderer", "gaussian-falloff", "--set", "rate=0.1", "--set", "radius_deg=1"];
    run(here, &[&["replay", session, "--frames", "falloff", "--stimuli"], &other[..]].concat()).expect(0);
    for alternative in [Alternative::Reference, Alternative::Test] {
        let frames = frames_of(&fixture("finished"), alternative);
        let different = frames.iter().filter(|frame| {
            let [ring, falloff] = ["ring", "falloff"]
                .map(|folder| std::fs::read(here.join(format!("{folder}/frame-{:06}.png", frame.index))).unwrap());
            ring != falloff
        });
        let (different, all) = (different.count(), frames.len());
        println!("{alternative:?}: {different} of {all} pictures are others");
        assert_eq!(different, if alternative == Alternative::Test { all } else { 0 });
    }
    let refused = run(here, &["replay", session, "--verify", "--renderer", "ring"]);
    assert_eq!(refused.code, 2, "{refused:?}");
    let refused = run(here, &["replay", session, "--frames", "x", "--renderer", "nothing"]).expect(2);
    assert!(refused.err.contains("expected one of") && refused.err.contains("ring"), "{refused:?}");
    let refused = run(here, &["replay", session, "--frames", "x", "--renderer", "ring", "--set", "scene.image=street"]);
    assert!(refused.expect(2).err.contains("the scene is the one that was seen"));
    assert!(!here.join("x").exists());
}

/// The resumed fixture with a seam's mark before its `reopened`, and everything after it numbered one higher.
fn with_seam(data: &Path, seam: &Seam) -> (PathBuf, u64) {
    let from = SessionFolder::open(&fixture("resumed")).unwrap();
    let reopened = |stamped: &&Stamped| matches!(stamped.event, Event::Input { input: Input::Reopened, .. });
    let at = from.journal.events.iter().find(reopened).unwrap().clone();
    let display = &from.display;
    let writer = SessionWriter::create(data, &from.header, display).unwrap();
    let folder = writer.folder().to_owned();
    let shifted = |seq: u64| seq + u64::from(seq >= at.seq);
    let (last, events) = from.journal.events.split_last().unwrap();
    for stamped in events.iter().filter(|stamped| stamped.seq > 0) {
        if stamped.seq == at.seq {
            let mark = Event::Continued(Box::new(seam.clone()));
            writer.event(Stamped { seq: at.seq, t_s: at.t_s, event: mark }).unwrap();
        }
        writer.event(Stamped { seq: shifted(stamped.seq), ..stamped.clone() }).unwrap();
    }
    for gaze in from.gaze().unwrap().rows {
        let (t_s, px) = (gaze.t_s, [gaze.x_px, gaze.y_px]);
        let (arrived_s, t_device_s, valid) = (gaze.arrived_s, gaze.t_s, gaze.valid);
        let sample = GazeSample { t_s, arrived_s, t_device_s, px, valid, pupil_mm: None, left: None, right: None };
        writer.gaze(sample).unwrap();
    }
    let mut first_after = None;
    for frame in from.frames().unwrap().rows {
        if frame.phase_seq >= at.seq {
            first_after.get_or_insert(frame.index);
        }
        writer.frame(FrameRow { phase_seq: shifted(frame.phase_seq), ..frame }).unwrap();
    }
    writer.close(Stamped { seq: shifted(last.seq), ..last.clone() }, PATIENCE).unwrap();
    (folder, first_after.unwrap())
}

/// What was different after a seam is drawn as it was then, and what came before as it was before.
#[test]
fn each_frame_is_drawn_with_the_study_and_display_of_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let same = Seam { gpu: None, ..Seam::default() };
    let header = SessionFolder::open(&fixture("resumed")).unwrap().header;
    let wider = header.study.text.replace("\"width_deg\": 2", "\"width_deg\": 9");
    assert_ne!(wider, header.study.text);

    let (session, _) = with_seam(&here.join("same"), &same);
    let first = verify(here, &session);
    if first.json()["hashes_compared"] == 0 {
        println!("skipped: the fixture was drawn on another adapter");
        return;
    }
    assert_eq!(first.expect(0).json()["hashes_compared"], 112);

    let (session, first_after) = with_seam(&here.join("study"), &Seam { study: Some(wider), ..same.clone() });
    let found = verify(here, &session).expect(1).json();
    println!("another width from frame {first_after} on: first different {}", found["first_different"]);
    assert!(found["first_different"].as_u64().unwrap() >= first_after, "{found}");

    let mut display = serde_json::to_value(&header.display).unwrap();
    display["resolution_px"] = json!([80, 60]);
    let (session, first_after) = with_seam(&here.join("display"), &Seam { display: Some(display), ..same });
    run(here, &["replay", session.to_str().unwrap(), "--frames", "pictures"]).expect(0);
    for index in 0..112_u64 {
        let size = image::image_dimensions(here.join(format!("pictures/frame-{index:06}.png"))).unwrap();
        assert_eq!(size, if index < first_after { (64, 48) } else { (80, 60) }, "frame {index}");
    }
}

/// A study that was moved with its files and its sessions is found again; one whose files are gone is refused by name.
#[test]
fn files_that_moved_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/studies/own-renderers");
    let before = here.join("before");
    copy_folder(&examples.join("captures/full"), &before.join("captures/full"));
    copy_folder(&examples.join("captures/half"), &before.join("captures/half"));
    copy_folder(&examples.join("captures/quarter"), &before.join("captures/quarter"));
    for file in ["captures.json", "captures/manifest.json"] {
        std::fs::copy(examples.join(file), before.join(file)).unwrap();
    }
    let arguments = ["run", "captures.json", "--observer", "SIM", "--offscreen", "--simulate"];
    let more = ["omega0=0.03,m=0.05,width=0.8", "--data", "data", "--seed", "4"];
    let ran = run(&before, &[&arguments[..], &more[..]].concat()).expect(0);
    let session = Path::new(ran.out.trim_end()).file_name().unwrap().to_owned();

    std::fs::rename(&before, here.join("after")).unwrap();
    let moved = here.join("after/data").join(&session);
    let arguments = ["replay", moved.to_str().unwrap(), "--verify", "--stimuli", "--limit", "60", "--json"];
    let found = run(here, &arguments).expect(0).json();
    assert_eq!((&found["hashes_compared"], &found["hashes_different"]), (&json!(60), &json!(0)));

    std::fs::rename(here.join("after/captures"), here.join("gone")).unwrap();
    let refused = run(here, &arguments).expect(2).err;
    assert!(refused.contains("cannot be shown again") && refused.contains("full/05.png"), "{refused}");
}
