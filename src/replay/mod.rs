//! Looking again: what a session's log says was shown, drawn again frame by frame.
//!
//! The journal is folded again to know what each phase presented, `gaze.csv` places the stimulus, `frames.csv` says which
//! frames there were. Nothing else is needed, and nothing of the run is trusted that the log does not say.

use crate::error::LabError;
use crate::session::SessionFolder;
use crate::session::tables::{FrameRow, GazeRow};
use crate::stage::View;
use experiments::session::refold::refold;
use experiments::study::Plan;
use experiments::study::plan::{Condition, Level};
use experiments::trial::Presentation;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What one phase presented.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    presentation: Presentation,
    condition: Option<Condition>,
    level: Option<Level>,
}

/// A session's frames with all that is needed to draw them.
#[derive(Debug)]
pub struct Replay {
    plan: Arc<Plan>,
    phases: BTreeMap<u64, Shown>,
    frames: Vec<FrameRow>,
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
            if let Some(phase) = session.phase() {
                let shown = Shown {
                    presentation: phase.presentation.clone(),
                    condition: session.condition().cloned(),
                    level: session.trial().map(|trial| trial.level.clone()),
                };
                phases.insert(seq, shown);
            }
        })
        .map_err(|error| LabError::Failed(format!("{}: {error}", session.path.display())))?;
        let (frames, gaze) = (session.frames()?, session.gaze()?);
        let notices = [("frames.csv", frames.damage), ("gaze.csv", gaze.damage)]
            .into_iter()
            .filter_map(|(name, damage)| damage.map(|damage| format!("{name}: {damage}")))
            .collect();
        Ok(Self { plan, phases, frames: frames.rows, gaze: gaze.rows, notices })
    }

    /// The logged frames.
    #[must_use]
    pub fn frames(&self) -> &[FrameRow] {
        &self.frames
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
        let gaze_deg = match frame.gaze_row {
            Some(row) => {
                let sample = usize::try_from(row).ok().and_then(|row| self.gaze.get(row));
                let sample = sample.ok_or_else(|| missing(format!("gaze row {row}, which gaze.csv does not hold")))?;
                [sample.x_deg, sample.y_deg]
            }
            None => self.plan.gaze.fixation_deg,
        };
        Ok(View {
            presentation: &shown.presentation,
            condition: shown.condition.as_ref(),
            level: shown.level.as_ref(),
            gaze_deg,
            gaze_motion_deg_s: [0.0; 2],
            animation_s: frame.animation_s,
            frame_index: frame.index,
        })
    }
}
