//! Looking again: what a session's log says was shown, drawn again frame by frame.
//!
//! The journal is folded again to know what each phase presented, `gaze.csv` places the stimulus, `frames.csv` says which
//! frames there were. Nothing else is needed, and nothing of the run is trusted that the log does not say.

use crate::error::LabError;
use crate::session::SessionFolder;
use crate::session::tables::{FrameRow, GazeRow};
use crate::stage::View;
use crate::stage::shown::{Moment, Shown};
use experiments::session::refold::refold;
use experiments::study::Plan;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A session's frames with all that is needed to draw them.
#[derive(Debug)]
pub struct Replay {
    plan: Arc<Plan>,
    phases: BTreeMap<u64, Shown>,
    frames: Vec<FrameRow>,
    /// The first frame of each phase.
    first_frames: BTreeMap<u64, u64>,
    gaze: Vec<GazeRow>,
    /// What a reader should know about the tables.
    pub notices: Vec<String>,
}

impl Replay {
    /// Reads a session's log.
    ///
    /// # Errors
    /// When the journal is not what its study gives, or a table cannot be read.
    pub fn open(session: &SessionFolder, plan: Plan) -> Result<Self, LabError> {
        let plan = Arc::new(plan);
        let mut phases = BTreeMap::new();
        refold(Arc::clone(&plan), session.header.seed, &session.journal.events, |session, seq| {
            if let Some(shown) = Shown::of(session) {
                phases.insert(seq, shown);
            }
        })
        .map_err(|error| LabError::Failed(format!("{}: {error}", session.path.display())))?;
        let (frames, gaze) = (session.frames()?, session.gaze()?);
        let notices = [("frames.csv", frames.damage), ("gaze.csv", gaze.damage)]
            .into_iter()
            .filter_map(|(name, damage)| damage.map(|damage| format!("{name}: {damage}")))
            .collect();
        let mut first_frames = BTreeMap::new();
        for frame in &frames.rows {
            first_frames.entry(frame.phase_seq).or_insert(frame.index);
        }
        Ok(Self { plan, phases, frames: frames.rows, first_frames, gaze: gaze.rows, notices })
    }

    /// The logged frames.
    #[must_use]
    pub fn frames(&self) -> &[FrameRow] {
        &self.frames
    }

    /// Every logged frame of a frame's presentation, in order, itself among them.
    #[must_use]
    pub fn presentation(&self, frame: &FrameRow) -> &[FrameRow] {
        // Phases have growing numbers.
        let from = self.frames.partition_point(|other| other.phase_seq < frame.phase_seq);
        let to = self.frames.partition_point(|other| other.phase_seq <= frame.phase_seq);
        self.frames.get(from..to).unwrap_or_default()
    }

    /// The plan of the session.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
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
        Ok(shown.view(&self.plan, moment))
    }

    /// How fast gaze moved at a sample, degrees per second: from the last valid sample before it, as in the run.
    fn motion_deg_s(&self, row: usize, sample: &GazeRow) -> [f64; 2] {
        let before = self.gaze[..row].iter().rev().find(|before| before.valid);
        before.filter(|before| sample.t_s > before.t_s).map_or([0.0; 2], |before| {
            let step_s = sample.t_s - before.t_s;
            [(sample.x_deg - before.x_deg) / step_s, (sample.y_deg - before.y_deg) / step_s]
        })
    }
}
