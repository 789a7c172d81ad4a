//! A writer whose disk stands still, is full, loses what it was given, or is another program's.

use super::*;
use crate::session::SessionFolder;
use crate::session::disk::DiskFile;
use crate::session::faults::{Faults, FaultyDisk};
use crate::session::header::StageRecord;
use experiments::session::event::{Event, Rows};
use experiments::study::parse_study;
use experiments::trial::PhaseName;
use std::sync::Condvar;

const STUDY: &str = r#"{
    "format": 1, "name": "kept", "title": "A study for tests",
    "display": { "name": "small", "resolution_px": [64, 48], "size_mm": [100, 75], "distance_mm": 300 },
    "conditions": { "photo": { "scene": "photo", "renderer": "ring", "renderer_parameters": { "width_deg": 2 } } },
    "blocks": [{
        "name": "main", "condition": "photo",
        "protocol": { "kind": "two-interval", "fixation_s": 0.1, "interval_s": 0.1, "gap_s": 0.05 },
        "procedure": { "kind": "constant", "repetitions": 1, "levels": { "eccentricity_deg": [3], "mar_deg": [1.2] } }
    }]
}"#;

fn writer(disk: Arc<dyn Disk>, data: &Path) -> SessionWriter {
    let plan = parse_study("study", STUDY, &stimuli::registry::catalogue(), None).expect("a study");
    let header = Header::new(&plan, STUDY, "P01", 1, StageRecord::offscreen(&plan.display, false));
    SessionWriter::create_on(disk, data, &header, &plan.display).expect("a folder")
}

fn sample(number: u32) -> GazeSample {
    let t_s = f64::from(number) * 1e-3;
    GazeSample {
        t_s,
        arrived_s: t_s,
        t_device_s: t_s,
        px: [10.0, 20.0],
        valid: true,
        pupil_mm: None,
        left: None,
        right: None,
    }
}

fn event(seq: u64) -> Stamped {
    let event = Event::PhaseBegan { trial: None, phase: PhaseName::Page, shown: None, at: Default::default() };
    Stamped { seq, t_s: seq as f64, event }
}

fn mark(seq: u64, gaze_rows: u64) -> Stamped {
    Stamped { seq, t_s: seq as f64, event: Event::Tables(Rows { gaze_rows, frame_rows: 0 }) }
}

fn closed(seq: u64, gaze_rows: u64) -> Stamped {
    Stamped { seq, t_s: seq as f64, event: Event::Closed(Rows { gaze_rows, frame_rows: 0 }) }
}

/// A disk on which syncs do not return while it is shut.
#[derive(Debug, Clone, Default)]
struct Shut(Arc<(Mutex<bool>, Condvar)>);

impl Shut {
    fn set(&self, shut: bool) {
        *self.0.0.lock().expect("not poisoned") = shut;
        self.0.1.notify_all();
    }
}

#[derive(Debug)]
struct ShutFile(Shut, Box<dyn DiskFile>);

impl Disk for Shut {
    fn make_folders(&self, path: &Path) -> io::Result<()> {
        SystemDisk.make_folders(path)
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        SystemDisk.make_folder(path)
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        SystemDisk.create(path)
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        Ok(Box::new(ShutFile(self.clone(), SystemDisk.open(path)?)))
    }

    fn length_of(&self, path: &Path) -> io::Result<u64> {
        SystemDisk.length_of(path)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        SystemDisk.rename(from, to)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        SystemDisk.sync_folder(path)
    }
}

impl DiskFile for ShutFile {
    fn length(&self) -> io::Result<u64> {
        self.1.length()
    }

    fn write_at(&mut self, place: u64, bytes: &[u8]) -> io::Result<usize> {
        self.1.write_at(place, bytes)
    }

    fn set_length(&mut self, length: u64) -> io::Result<()> {
        self.1.set_length(length)
    }

    fn sync(&mut self) -> io::Result<()> {
        let shut = self.0.0.0.lock().expect("not poisoned");
        drop(self.0.0.1.wait_while(shut, |shut| *shut).expect("not poisoned"));
        self.1.sync()
    }

    fn lock(&self) -> io::Result<()> {
        self.1.lock()
    }
}

/// While a sync does not return, a minute of a 1 kHz tracker is taken without waiting, and nothing is acknowledged. If the
/// sender waited for the disk, this test would never end.
#[test]
fn a_disk_that_stands_still_stops_nobody() {
    let data = tempfile::tempdir().expect("a folder");
    let disk = Shut::default();
    let writer = writer(Arc::new(disk.clone()), data.path());
    disk.set(true);
    let acknowledgement = writer.sync(mark(1, 0)).expect("sent");
    for number in 0..60_000 {
        assert!(writer.admits());
        writer.gaze(sample(number)).expect("sent");
    }
    assert!(!acknowledgement.arrived().expect("not yet"));
    // Beyond that, samples are refused and events still taken.
    let refused = (60_000..70_000).find(|&number| {
        let admitted = writer.admits();
        if admitted {
            writer.gaze(sample(number)).expect("sent");
        }
        !admitted
    });
    let rows = u64::from(refused.expect("a bound"));
    for seq in 2..1_000 {
        writer.event(event(seq)).expect("sent");
    }
    disk.set(false);
    assert!(acknowledgement.wait(PATIENCE).expect("works"));
    let folder = writer.folder().to_owned();
    writer.close(closed(1_000, rows), PATIENCE).expect("written");
    let session = SessionFolder::open(&folder).expect("a session");
    assert_eq!((session.journal.events.len(), session.journal.damage.clone()), (1_001, None));
    let gaze = session.gaze().expect("read");
    assert_eq!((gaze.rows.len() as u64, gaze.damage), (rows, None));
}

/// A disk that is full for a while loses nothing, and says why it waits.
#[test]
fn a_disk_that_was_full_is_caught_up_with() {
    let data = tempfile::tempdir().expect("a folder");
    // Making the folder takes fewer operations than 30.
    let faults = Faults { full_from: Some(30), full_until: Some(60), short: 0.3, seed: 4, ..Faults::default() };
    let writer = writer(Arc::new(FaultyDisk::new(faults)), data.path());
    let mut seq = 0;
    let mut told = None;
    for trial in 0..20u32 {
        for number in 0..100 {
            writer.gaze(sample(100 * trial + number)).expect("sent");
        }
        seq += 1;
        writer.event(event(seq)).expect("sent");
        seq += 1;
        let acknowledgement = writer.sync(mark(seq, u64::from(100 * (trial + 1)))).expect("sent");
        while !acknowledgement.wait(Duration::from_millis(1)).expect("works") {
            told = told.or_else(|| writer.trouble());
        }
        // What was acknowledged is there, whatever comes after.
        let session = SessionFolder::open(writer.folder()).expect("a session");
        assert!(session.journal.events.len() as u64 > seq);
        assert!(session.gaze().expect("read").rows.len() as u32 >= 100 * (trial + 1));
    }
    let (trouble, words) = told.expect("the disk was full");
    assert_eq!(trouble, Trouble::Full);
    assert!(words.contains("full"), "{words}");
    assert_eq!(writer.trouble(), None);
    let folder = writer.folder().to_owned();
    writer.close(closed(seq + 1, 2_000), PATIENCE).expect("written");
    let session = SessionFolder::open(&folder).expect("a session");
    assert_eq!((session.journal.damage.clone(), session.gaze().expect("read").damage), (None, None));
}

/// Device errors throw away what was written since the last sync; it is written again.
#[test]
fn what_a_failed_sync_has_lost_is_written_again() {
    for seed in 0..8 {
        let data = tempfile::tempdir().expect("a folder");
        let healthy = writer(Arc::new(SystemDisk), data.path());
        let folder = healthy.folder().to_owned();
        healthy.close(closed(1, 0), PATIENCE).expect("written");
        let session = SessionFolder::open(&folder).expect("a session");
        let (gaze, frames) = (session.gaze().expect("read"), session.frames().expect("read"));
        let ends = session.ends(&gaze, &frames).expect("sound");
        let disk = FaultyDisk::new(Faults { device_error: 0.03, short: 0.3, seed, ..Faults::default() });
        // Opening may fail too; then nothing was changed.
        let Ok(writer) = SessionWriter::append_on(Arc::new(disk), &folder, &session.display, ends) else { continue };
        for seq in 2..40 {
            writer.gaze(sample(seq as u32)).expect("sent");
            writer.event(event(2 * seq - 2)).expect("sent");
            let acknowledgement = writer.sync(mark(2 * seq - 1, seq - 1)).expect("sent");
            assert!(acknowledgement.wait(PATIENCE).expect("works"), "seed {seed}");
        }
        writer.close(closed(78, 38), PATIENCE).expect("written");
        let session = SessionFolder::open(&folder).expect("a session");
        assert_eq!((session.journal.events.len(), session.journal.damage.clone()), (79, None), "seed {seed}");
        assert_eq!(session.gaze().expect("read").rows.len(), 38, "seed {seed}");
    }
}

/// What is written to a file that somebody has deleted is nowhere. It is not acknowledged until the folder is back.
#[test]
fn a_folder_that_is_gone_is_noticed_and_waited_for() {
    let data = tempfile::tempdir().expect("a folder");
    let writer = writer(Arc::new(SystemDisk), data.path());
    writer.gaze(sample(0)).expect("sent");
    assert!(writer.sync(mark(1, 1)).expect("sent").wait(PATIENCE).expect("works"));
    let folder = writer.folder().to_owned();
    let elsewhere = data.path().join("elsewhere");
    std::fs::rename(&folder, &elsewhere).expect("moved");
    writer.gaze(sample(1)).expect("sent");
    let acknowledgement = writer.sync(mark(2, 2)).expect("sent");
    assert!(!acknowledgement.wait(Duration::from_millis(100)).expect("works"));
    assert_eq!(writer.trouble().map(|(trouble, _)| trouble), Some(Trouble::Gone));
    std::fs::rename(&elsewhere, &folder).expect("moved back");
    assert!(acknowledgement.wait(PATIENCE).expect("works"));
    writer.close(closed(3, 2), PATIENCE).expect("written");
    let session = SessionFolder::open(&folder).expect("a session");
    assert_eq!((session.journal.events.len(), session.gaze().expect("read").rows.len()), (4, 2));
}

#[test]
fn two_programs_cannot_write_to_one_session() {
    let data = tempfile::tempdir().expect("a folder");
    let writer = writer(Arc::new(SystemDisk), data.path());
    assert!(writer.sync(mark(1, 0)).expect("sent").wait(PATIENCE).expect("works"));
    let session = SessionFolder::open(writer.folder()).expect("a session");
    let (gaze, frames) = (session.gaze().expect("read"), session.frames().expect("read"));
    let ends = session.ends(&gaze, &frames).expect("sound");
    let second = SessionWriter::append(&session.path, &session.display, ends).expect_err("locked");
    assert!(second.to_string().contains("another program is writing to this session"), "{second}");
}
