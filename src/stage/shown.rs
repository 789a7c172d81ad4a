//! What a phase presents, with all that its frames need: the part of a [`View`] that stays the same while it lasts.
//!
//! The runner takes it from the session that runs, a replay from the session that is folded again; what changes from
//! frame to frame (marks, the place to look at) is a function of the animation time, so both show the same.

use super::painter::View;
use experiments::Session;
use experiments::marks::{Mark, look_at_deg, marks};
use experiments::study::Plan;
use experiments::study::plan::{Condition, Fixation, FoveationCentre, Level};
use experiments::trial::keys::shown_hint;
use experiments::trial::{GazeRule, Presentation};

/// What one phase presents.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// What is on the display.
    pub presentation: Presentation,
    /// The trial's condition.
    pub condition: Option<Condition>,
    /// The level shown: the trial's, with the phase's own on top.
    pub level: Option<Level>,
    /// Decides paths and spheres.
    pub path_seed: Option<u64>,
    /// The line that names the keys, where one is shown.
    pub hint: Option<String>,
    /// What gaze may do.
    pub gaze: GazeRule,
}

/// What changes from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Where the eye looks, degrees; nothing before the first sample.
    pub gaze_deg: Option<[f64; 2]>,
    /// How fast it moves, degrees per second.
    pub gaze_motion_deg_s: [f64; 2],
    /// How long the scene has been moving, seconds; 0 for what does not move.
    pub animation_s: f64,
    /// Number of the phase's first event, which tells presentations apart.
    pub presentation: u64,
    /// Frames since the phase began.
    pub frame_index: u64,
}

impl Shown {
    /// What a session presents now; nothing once it is over.
    #[must_use]
    pub fn of(session: &Session) -> Option<Self> {
        let phase = session.phase()?;
        Some(Self {
            presentation: phase.presentation.clone(),
            condition: session.condition().cloned(),
            level: session.shown_level(),
            path_seed: session.trial().and_then(|trial| trial.path_seed),
            hint: shown_hint(phase),
            gaze: phase.gaze,
        })
    }

    /// Whether a stimulus is shown.
    #[must_use]
    pub fn is_stimulus(&self) -> bool {
        matches!(self.presentation, Presentation::Stimulus(_))
    }

    fn fixation(&self) -> Fixation {
        self.condition.as_ref().map_or(Fixation::Cross, |condition| condition.fixation)
    }

    /// Where observers are to look at an animation time, degrees: the fixation mark, or the moving target.
    #[must_use]
    pub fn look_at_deg(&self, plan: &Plan, animation_s: f64) -> [f64; 2] {
        look_at_deg(self.fixation(), self.path_seed, plan.gaze.fixation_deg, animation_s)
    }

    /// Where the frames' log says that observers were to look: while a stimulus is shown, and not where they please.
    #[must_use]
    pub fn target_deg(&self, plan: &Plan, animation_s: f64) -> Option<[f64; 2]> {
        let asked = self.is_stimulus() && self.fixation() != Fixation::Free;
        asked.then(|| self.look_at_deg(plan, animation_s))
    }

    /// Whether gaze is bound to the place to look at. Free viewing is not, and with a moving target nothing is asked
    /// while the eye travels from where the target went to where it will begin.
    #[must_use]
    pub fn binds_gaze(&self) -> bool {
        match (self.gaze, self.fixation()) {
            (GazeRule::Free | GazeRule::Hold, _) | (_, Fixation::Cross) => true,
            (_, Fixation::Free) => false,
            (rule, Fixation::Moving(_)) => self.is_stimulus() || rule == GazeRule::AwaitReturn,
        }
    }

    /// What is drawn over the picture.
    fn marks(&self, plan: &Plan, animation_s: f64) -> Vec<Mark> {
        marks(
            &self.presentation,
            self.condition.as_ref(),
            self.path_seed,
            plan.gaze.fixation_deg,
            plan.display.half_field_deg(),
            animation_s,
        )
    }

    /// One frame.
    #[must_use]
    pub fn view(&self, plan: &Plan, moment: Moment) -> View<'_> {
        let foveation = self.condition.as_ref().map_or(FoveationCentre::Gaze, |condition| condition.foveation);
        let (gaze_deg, gaze_motion_deg_s) = match (foveation, moment.gaze_deg) {
            (FoveationCentre::Gaze, Some(gaze_deg)) => (gaze_deg, moment.gaze_motion_deg_s),
            (FoveationCentre::Gaze, None) => (plan.gaze.fixation_deg, [0.0; 2]),
            (FoveationCentre::Target, _) => self.target_and_motion(plan, moment.animation_s),
        };
        View {
            presentation: &self.presentation,
            condition: self.condition.as_ref(),
            level: self.level.as_ref(),
            marks: self.marks(plan, moment.animation_s),
            hint: self.hint.as_deref(),
            gaze_deg,
            gaze_motion_deg_s,
            animation_s: moment.animation_s,
            presentation_seq: moment.presentation,
            frame_index: moment.frame_index,
        }
    }

    /// The place to look at and its velocity, from places a millisecond apart.
    fn target_and_motion(&self, plan: &Plan, animation_s: f64) -> ([f64; 2], [f64; 2]) {
        const STEP_S: f64 = 1e-3;
        let [before, at] = [animation_s - STEP_S, animation_s].map(|t_s| self.look_at_deg(plan, t_s));
        (at, std::array::from_fn(|axis| (at[axis] - before[axis]) / STEP_S))
    }
}
