//! Looking again: what a session's log says was shown, drawn again frame by frame.
//!
//! The journal is folded again to know what each phase presented, `gaze.csv` places the stimulus, `frames.csv` says which
//! frames there were. Nothing else is needed, and nothing of the run is trusted that the log does not say.
//!
//! - [`drawing`]: a frame's picture, and the full-resolution one beside it;
//! - [`verify`]: whether the pictures are those of the run;
//! - [`overlay`], [`ink`]: gaze, its trail and eccentricity rings, as lines and painted into a picture;
//! - [`export`], [`video`]: pictures and videos as files;
//! - [`player`], [`timeline`], [`facts`]: where in the log one looks, what happened when, what is to be said of a frame;
//! - [`panel`], [`strip`], [`window`]: the same to look at and to press.

pub mod drawing;
pub mod export;
pub mod facts;
pub mod ink;
pub mod overlay;
pub mod panel;
pub mod player;
mod segments;
pub mod strip;
pub mod timeline;
pub mod verify;
pub mod video;
pub mod window;
mod worker;

pub use drawing::{Drawer, Drawn};

use crate::error::LabError;
use crate::resources::Resources;
use crate::session::SessionFolder;
use crate::session::tables::{FrameRow, GazeRow, TableDamage};
use crate::stage::View;
use crate::stage::shown::{Moment, Shown};
use experiments::Display;
use experiments::catalogue::{Catalogue, Parameters, complete_parameters};
use experiments::session::Stamped;
use experiments::session::record::{Record, TrialRecord};
use experiments::session::refold::refold;
use experiments::study::Plan;
use experiments::study::plan::Condition;
use experiments::trial::{Alternative, Presentation};
use segments::Segment;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A session's frames with all that is needed to draw them.
#[derive(Debug)]
pub struct Replay {
    /// The folder's name.
    pub name: String,
    /// The study's title.
    pub title: String,
    /// The journal, up to any damage.
    pub events: Vec<Stamped>,
    /// Its trials.
    pub record: Record,
    /// What a reader should know about the tables.
    pub notices: Vec<String>,
    /// What is wrong with the log; a log that was merely cut off by a kill is not wrong.
    pub damage: Vec<String>,
    segments: Vec<Segment>,
    phases: BTreeMap<u64, Shown>,
    frames: Vec<FrameRow>,
    /// The first frame of each phase.
    first_frames: BTreeMap<u64, u64>,
    gaze: Vec<GazeRow>,
    trials: BTreeMap<u32, usize>,
}

impl Replay {
    /// Reads the log of a session that ran one plan from its beginning to its end.
    ///
    /// # Errors
    /// When the journal is not what its study gives, or a table cannot be read.
    pub fn open(session: &SessionFolder, plan: Plan) -> Result<Self, LabError> {
        Self::of(session, segments::only(session, plan))
    }

    /// Reads a session's log, with the study and display that were in force at each time. `resources` are those of the
    /// session: [`Resources::of_session`].
    ///
    /// # Errors
    /// As [`Replay::open`], and when a study that the log holds is none any more.
    pub fn recorded(session: &SessionFolder, resources: &Resources) -> Result<Self, LabError> {
        Self::of(session, segments::of(session, resources)?)
    }

    fn of(session: &SessionFolder, segments: Vec<Segment>) -> Result<Self, LabError> {
        let mut phases = BTreeMap::new();
        let events = &session.journal.events;
        for (at, segment) in segments.iter().enumerate() {
            let until = segments.get(at + 1).map_or(u64::MAX, |next| next.from_seq);
            let known = events.partition_point(|event| event.seq < until);
            refold(Arc::clone(&segment.plan), session.header.seed, &events[..known], |session, seq| {
                if seq >= segment.from_seq
                    && let Some(shown) = Shown::of(session)
                {
                    phases.insert(seq, shown);
                }
            })
            .map_err(|error| LabError::Failed(format!("{}: {error}", session.path.display())))?;
        }
        let (frames, gaze) = (session.frames()?, session.gaze()?);
        let (mut notices, mut damage) = (Vec::new(), Vec::new());
        if let Some(problem @ crate::session::journal::Damage::Corrupt { .. }) = &session.journal.damage {
            damage.push(format!("events.jsonl: {problem}"));
        }
        for (name, problem) in [("frames.csv", &frames.damage), ("gaze.csv", &gaze.damage)] {
            match problem {
                Some(TableDamage::Torn(_)) if !session.record.is_over() => {}
                Some(problem) => damage.push(format!("{name}: {problem}")),
                None => {}
            }
            notices.extend(problem.as_ref().map(|problem| format!("{name}: {problem}")));
        }
        let mut frames = frames.rows;
        let sound = session.sound_frames(&frames, gaze.rows.len());
        let stray = frames.len() - sound;
        if stray > 0 {
            frames.truncate(sound);
            let said = format!(
                "frames.csv: the last {stray} frames name events or gaze samples that the log does not hold, and are \
                 left out"
            );
            // A kill leaves such frames; in a session that ran to its end, or whose log is damaged, something is gone.
            if session.record.is_over() {
                damage.push(said.clone());
            }
            notices.push(said);
        }
        let mut first_frames = BTreeMap::new();
        for frame in &frames {
            first_frames.entry(frame.phase_seq).or_insert(frame.index);
        }
        let record = session.record.clone();
        let trials = record.trials.iter().enumerate().map(|(at, trial)| (trial.trial.trial, at)).collect();
        Ok(Self {
            name: session.name(),
            title: session.header.study.title.clone(),
            events: events.clone(),
            record,
            notices,
            damage,
            segments,
            phases,
            frames,
            first_frames,
            gaze: gaze.rows,
            trials,
        })
    }

    /// The same log with another renderer in the place of every condition's: its parameters are those given and its
    /// defaults, whatever the trial's level, and all else (gaze, scene, marks, reference) is as it was.
    ///
    /// # Errors
    /// When there is no such renderer, it refuses a parameter, or a scene or display does not go with it.
    pub fn with_renderer(mut self, known: &Catalogue, name: &str, given: &Parameters) -> Result<Self, LabError> {
        let Some(info) = known.renderer(name) else {
            let names: Vec<&str> = known.renderers.iter().map(|renderer| renderer.id.as_str()).collect();
            return Err(LabError::BadInput(format!("--renderer {name}: expected one of {}", names.join(", "))));
        };
        let parameters = complete_parameters(&info.parameters, given).map_err(|errors| {
            let all: Vec<String> = errors.iter().map(ToString::to_string).collect();
            LabError::BadInput(format!("--set: {}", all.join("; ")))
        })?;
        for (&seq, shown) in &mut self.phases {
            if let Some(condition) = &mut shown.condition {
                let display = &segments::in_force(&self.segments, seq).plan.display;
                if let Some(mismatch) = known.mismatch(&condition.scene, name, Some(display.resolution_px())) {
                    return Err(LabError::BadInput(format!("--renderer {name}: {mismatch}")));
                }
                *condition = Condition {
                    renderer: name.to_owned(),
                    renderer_parameters: parameters.clone(),
                    detail: info.detail.clone(),
                    ..condition.clone()
                };
            }
            shown.level = shown.level.as_ref().map(|_| BTreeMap::new());
            if let Presentation::Stimulus(stimulus) = &mut shown.presentation {
                stimulus.level.clear();
            }
        }
        Ok(self)
    }

    /// The logged frames.
    #[must_use]
    pub fn frames(&self) -> &[FrameRow] {
        &self.frames
    }

    /// The gaze samples.
    #[must_use]
    pub fn gaze(&self) -> &[GazeRow] {
        &self.gaze
    }

    /// What became of a trial; nothing for one that did not end.
    #[must_use]
    pub fn trial(&self, number: u32) -> Option<&TrialRecord> {
        self.record.trials.get(*self.trials.get(&number)?)
    }

    /// Every logged frame of a frame's presentation, in order, itself among them.
    #[must_use]
    pub fn presentation(&self, frame: &FrameRow) -> &[FrameRow] {
        // Phases have growing numbers.
        let from = self.frames.partition_point(|other| other.phase_seq < frame.phase_seq);
        let to = self.frames.partition_point(|other| other.phase_seq <= frame.phase_seq);
        self.frames.get(from..to).unwrap_or_default()
    }

    /// The plan that was in force when a frame was shown.
    #[must_use]
    pub fn plan(&self, frame: &FrameRow) -> &Plan {
        &segments::in_force(&self.segments, frame.phase_seq).plan
    }

    /// The display that a frame was shown on.
    #[must_use]
    pub fn display(&self, frame: &FrameRow) -> &Display {
        &self.plan(frame).display
    }

    /// Every display that frames were shown on, in order.
    pub fn displays(&self) -> impl Iterator<Item = &Display> {
        self.segments.iter().map(|segment| &segment.plan.display)
    }

    /// Number of the stretch, from 0, with one plan and display that a frame was shown in.
    #[must_use]
    pub(crate) fn segment(&self, frame: &FrameRow) -> usize {
        segments::index(&self.segments, frame.phase_seq)
    }

    /// The graphics adapter that a frame was drawn on, where the log says one.
    #[must_use]
    pub fn adapter(&self, frame: &FrameRow) -> Option<&str> {
        let first = self.segments.first().and_then(|segment| segment.gpu.as_deref());
        let seams = self.record.seams.iter().take_while(|seam| seam.seq < frame.phase_seq);
        seams.filter_map(|seam| seam.seam.gpu.as_deref()).last().or(first)
    }

    /// What a logged frame presents, without its gaze.
    #[must_use]
    pub fn shown(&self, frame: &FrameRow) -> Option<&Shown> {
        self.phases.get(&frame.phase_seq)
    }

    /// Which picture of a stimulus a frame shows, if any.
    #[must_use]
    pub fn alternative(&self, frame: &FrameRow) -> Option<Alternative> {
        match &self.shown(frame)?.presentation {
            Presentation::Stimulus(stimulus) => Some(stimulus.alternative),
            _ => None,
        }
    }

    /// What a logged frame showed.
    ///
    /// # Errors
    /// When the frame names a phase or a gaze sample that the log does not hold.
    pub fn view<'a>(&'a self, frame: &FrameRow) -> Result<View<'a>, LabError> {
        let missing = |what: String| LabError::BadInput(format!("frames.csv: frame {} names {what}", frame.index));
        let shown = self
            .phases
            .get(&frame.phase_seq)
            .ok_or_else(|| missing(format!("phase {}, which the journal does not hold", frame.phase_seq)))?;
        let gaze = match frame.gaze_row {
            Some(row) => {
                let row = usize::try_from(row).unwrap_or(usize::MAX);
                let sample = self.gaze.get(row);
                let sample = sample.ok_or_else(|| missing(format!("gaze row {row}, which gaze.csv does not hold")))?;
                Some(([sample.x_deg, sample.y_deg], self.motion_deg_s(row, sample)))
            }
            None => None,
        };
        let moment = Moment {
            gaze_deg: gaze.map(|(deg, _)| deg),
            gaze_motion_deg_s: gaze.map_or([0.0; 2], |(_, motion_deg_s)| motion_deg_s),
            animation_s: frame.animation_s,
            presentation: frame.phase_seq,
            frame_index: frame.index.saturating_sub(self.first_frames.get(&frame.phase_seq).copied().unwrap_or(0)),
        };
        Ok(shown.view(self.plan(frame), moment))
    }

    /// How fast gaze moved at a sample, degrees per second: from the last valid sample before it, as in the run. A run
    /// that goes on knows no sample from before.
    fn motion_deg_s(&self, row: usize, sample: &GazeRow) -> [f64; 2] {
        let before = self.gaze[..row].iter().rev().find(|before| before.valid);
        let seam_between =
            |before: &GazeRow| self.record.reopened_s.iter().any(|s| before.arrived_s <= *s && *s <= sample.arrived_s);
        before.filter(|before| sample.t_s > before.t_s && !seam_between(before)).map_or([0.0; 2], |before| {
            let step_s = sample.t_s - before.t_s;
            [(sample.x_deg - before.x_deg) / step_s, (sample.y_deg - before.y_deg) / step_s]
        })
    }
}
