//! The runner: it stands between a stage and the session machine, decides when a phase's time is up and when gaze has
//! left the gate, and sends everything that happens to the log.
//!
//! It has no clock of its own. A stage says what time it is; a window says the real time, the offscreen stage a virtual
//! one.

use super::painter::View;
use super::shown::{Moment, Shown};
use super::watch::Watch;
use crate::error::LabError;
use crate::gaze::GazeSample;
use crate::session::tables::FrameRow;
use crate::session::writer::{Acknowledgement, SessionWriter};
use experiments::session::{Event, Stamped};
use experiments::trial::{GazeRule, Input, Outcome, Phase, PhaseName};
use experiments::{Display, Session};

/// A session in progress, with its log.
#[derive(Debug)]
pub struct Runner {
    session: Session,
    display: Display,
    writer: SessionWriter,
    seq: u64,
    last_event_s: f64,
    /// Number of the event that began the current phase.
    phase_seq: u64,
    /// Number of the first frame of the phase.
    first_frame: u64,
    /// What that phase presents.
    shown: Option<Shown>,
    watch: Watch,
    gaze: Option<Gaze>,
    gaze_rows: u64,
    frames: u64,
    completed: u32,
    saving: Option<Acknowledgement>,
}

/// The newest gaze sample, as frames use it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaze {
    /// Its row in `gaze.csv`, from 0.
    pub row: u64,
    /// When the eye was there, seconds.
    pub t_s: f64,
    /// Where it looked, degrees.
    pub deg: [f64; 2],
    /// How fast it moved, degrees per second, from the sample before.
    pub motion_deg_s: [f64; 2],
}

/// Where a log that goes on has stopped.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tail {
    /// Events written.
    pub events: u64,
    /// Rows of `gaze.csv`.
    pub gaze_rows: u64,
    /// Rows of `frames.csv`.
    pub frames: u64,
    /// Time of the last event, seconds.
    pub last_event_s: f64,
}

impl Runner {
    /// Starts a new session: its first events are logged at time 0, after the log's own, and are on disk when this
    /// returns, so that even a session that is killed at once can be found and gone on with.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn begin(session: Session, events: Vec<Event>, writer: SessionWriter) -> Result<Self, LabError> {
        let mut runner = Self::new(session, writer, Tail { events: 1, ..Tail::default() });
        runner.log(0.0, events)?;
        runner.writer.sync()?.wait()?;
        Ok(runner)
    }

    /// Goes on with a session that has been folded from its journal. Events that the journal lacks are written first;
    /// the seam is marked as an input at `t_s`.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn reopen(
        session: Session,
        missing: Vec<Event>,
        writer: SessionWriter,
        tail: Tail,
        t_s: f64,
    ) -> Result<Self, LabError> {
        let mut runner = Self::new(session, writer, tail);
        runner.log(tail.last_event_s, missing)?;
        runner.saving = None;
        runner.input(t_s, Input::Reopened)?;
        Ok(runner)
    }

    fn new(session: Session, writer: SessionWriter, tail: Tail) -> Self {
        let plan = session.plan();
        let watch = Watch::new(plan.gaze.gate, tail.last_event_s);
        Self {
            display: plan.display.clone(),
            shown: Shown::of(&session),
            session,
            writer,
            seq: tail.events,
            last_event_s: tail.last_event_s,
            phase_seq: 0,
            first_frame: tail.frames,
            watch,
            gaze: None,
            gaze_rows: tail.gaze_rows,
            frames: tail.frames,
            completed: 0,
            saving: None,
        }
    }

    /// The session machine.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// What to present; nothing once the session is over.
    #[must_use]
    pub fn phase(&self) -> Option<&Phase> {
        self.session.phase()
    }

    /// Number of the event that began the current phase: changes with every phase.
    #[must_use]
    pub fn phase_seq(&self) -> u64 {
        self.phase_seq
    }

    /// The session's folder.
    #[must_use]
    pub fn folder(&self) -> &std::path::Path {
        self.writer.folder()
    }

    /// Completed trials, all blocks together, since this runner began.
    #[must_use]
    pub fn completed_trials(&self) -> u32 {
        self.completed
    }

    /// The newest gaze.
    #[must_use]
    pub fn gaze(&self) -> Option<Gaze> {
        self.gaze
    }

    /// Takes in what happened at `t_s`.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn input(&mut self, t_s: f64, input: Input) -> Result<(), LabError> {
        let events = self.session.handle(t_s.max(self.last_event_s), input);
        self.log(t_s, events)
    }

    /// Takes in a gaze sample that has arrived by `now_s`.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn gaze_sample(&mut self, now_s: f64, sample: GazeSample) -> Result<(), LabError> {
        let deg = self.display.deg_from_px(sample.px);
        let angle_deg = self.angle_to_target_deg(sample.t_s, sample.valid.then_some(deg));
        self.watch.sample(sample.t_s, now_s, angle_deg);
        if sample.valid {
            let motion_deg_s = match self.gaze {
                Some(before) if sample.t_s > before.t_s => {
                    std::array::from_fn(|axis| (deg[axis] - before.deg[axis]) / (sample.t_s - before.t_s))
                }
                _ => [0.0; 2],
            };
            self.gaze = Some(Gaze { row: self.gaze_rows, t_s: sample.t_s, deg, motion_deg_s });
        }
        self.gaze_rows += 1;
        self.writer.gaze(sample)?;
        self.tell_gaze(now_s)
    }

    /// The angle between gaze and the place to look at, as the gate takes it: nothing where gaze is lost, none where gaze
    /// is not bound to a place. A target has moved on since a sample was taken, so its place then counts.
    fn angle_to_target_deg(&self, t_s: f64, gaze_deg: Option<[f64; 2]>) -> Option<f64> {
        if !self.shown.as_ref().is_none_or(Shown::binds_gaze) {
            return Some(0.0);
        }
        let place_deg = self.session.look_at_deg(self.session.animation_s(t_s));
        Some(self.display.eccentricity_deg(place_deg, gaze_deg?))
    }

    /// Tells the session what gaze did, as far as the phase wants to know.
    fn tell_gaze(&mut self, now_s: f64) -> Result<(), LabError> {
        let rule = self.phase().map_or(GazeRule::Free, |phase| phase.gaze);
        match self.watch.tells(rule, now_s) {
            Some(input) => self.input(now_s, input),
            None => Ok(()),
        }
    }

    /// Lets time pass up to a frame that is due at `t_s`: ends the phase if its time is up, and goes on from a saved trial.
    ///
    /// `frame_s` is the time between frames; a phase ends with the frame that is nearest to its end. With `wait`, the
    /// call waits for the disk (virtual time); without it, the session waits between trials (real time).
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn tick(&mut self, t_s: f64, frame_s: f64, wait: bool) -> Result<(), LabError> {
        if let Some(saving) = &self.saving {
            if wait {
                saving.wait()?;
            } else if !saving.arrived()? {
                return Ok(());
            }
            self.saving = None;
            if self.phase().is_some_and(|phase| phase.name == PhaseName::Save) {
                self.input(t_s, Input::Saved)?;
            }
        }
        if self.watch.is_silent(t_s) {
            self.watch.update(t_s, self.angle_to_target_deg(t_s, None));
        }
        self.tell_gaze(t_s)?;
        let held = |phase: &Phase| Some((phase.duration_s?, phase.gaze == GazeRule::Hold));
        let Some((duration_s, hold)) = self.phase().and_then(held) else {
            return Ok(());
        };
        let began_s = self.session.phase_began_s();
        let since_s = if hold { self.watch.held_since_s(began_s) } else { Some(began_s) };
        if since_s.is_some_and(|since_s| t_s + 0.5 * frame_s >= since_s + duration_s) {
            self.input(t_s, Input::Elapsed)?;
        }
        Ok(())
    }

    /// What a frame due at `t_s` shows.
    #[must_use]
    pub fn view(&self, t_s: f64) -> Option<View<'_>> {
        let moment = Moment {
            gaze_deg: self.gaze.map(|gaze| gaze.deg),
            gaze_motion_deg_s: self.gaze.map_or([0.0; 2], |gaze| gaze.motion_deg_s),
            animation_s: self.session.animation_s(t_s),
            presentation: self.phase_seq,
            frame_index: self.frames - self.first_frame,
        };
        Some(self.shown.as_ref()?.view(self.session.plan(), moment))
    }

    /// The row of the frame that is about to be shown, to be completed with what showing it tells.
    #[must_use]
    pub fn frame_row(&self, scheduled_s: f64, animation_s: f64) -> Option<FrameRow> {
        let phase = self.session.phase()?;
        let target_deg = self.shown.as_ref().and_then(|shown| shown.target_deg(self.session.plan(), animation_s));
        Some(FrameRow {
            index: self.frames,
            phase_seq: self.phase_seq,
            trial: self.session.trial().map(|trial| trial.trial),
            phase: phase.name,
            scheduled_s,
            presented_s: scheduled_s,
            missed: false,
            animation_s,
            gaze_row: self.gaze.map(|gaze| gaze.row),
            gaze_age_s: self.gaze.map(|gaze| scheduled_s - gaze.t_s),
            pixels_shaded: None,
            gpu_time_s: None,
            hash: None,
            target_x_deg: target_deg.map(|[x, _]| x),
            target_y_deg: target_deg.map(|[_, y]| y),
            signature: None,
        })
    }

    /// Counts a frame as shown; its row is sent to the log now or, when its hash is still on the GPU, later.
    pub fn count_frame(&mut self) {
        self.frames += 1;
    }

    /// Sends a frame's row to the log.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn log_frame(&self, row: FrameRow) -> Result<(), LabError> {
        self.writer.frame(row)
    }

    /// Ends the log; everything sent is on disk when this returns.
    ///
    /// # Errors
    /// When something could not be written.
    pub fn close(self) -> Result<(), LabError> {
        self.writer.close()
    }

    fn log(&mut self, t_s: f64, events: Vec<Event>) -> Result<(), LabError> {
        self.last_event_s = self.last_event_s.max(t_s);
        let (mut must_save, mut new_phase) = (false, false);
        for event in events {
            must_save |= matches!(event, Event::TrialEnded { .. } | Event::Finished);
            if matches!(event, Event::TrialEnded { outcome: Outcome::Answered { .. }, .. }) {
                self.completed += 1;
            }
            if matches!(event, Event::PhaseBegan { .. }) {
                self.phase_seq = self.seq;
                self.first_frame = self.frames;
                new_phase = true;
            }
            self.writer.event(Stamped { seq: self.seq, t_s: self.last_event_s, event })?;
            self.seq += 1;
        }
        if new_phase || self.session.finished() {
            let before = self.shown.take().map_or(GazeRule::Free, |shown| shown.gaze);
            self.shown = Shown::of(&self.session);
            self.watch.phase_began(before, self.shown.as_ref().map_or(GazeRule::Free, |shown| shown.gaze));
        }
        if must_save {
            self.saving = Some(self.writer.sync()?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
