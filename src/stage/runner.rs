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
use crate::session::writer::{Acknowledgement, PATIENCE, SessionWriter};
use experiments::session::event::{Rows, Seam};
use experiments::session::{Event, Stamped};
use experiments::trial::{GazeRule, Input, Outcome, Phase, PhaseName, Presentation};
use experiments::{Display, Session};

/// How a stage's time passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// As on the wall: nothing waits for the disk. A trial that is not on disk yet is waited for by showing grey, and a
    /// page that says why if the disk fails.
    Real,
    /// As fast as it goes: the disk is waited for.
    Virtual,
}

/// A session in progress, with its log.
#[derive(Debug)]
pub struct Runner {
    session: Session,
    display: Display,
    writer: SessionWriter,
    pace: Pace,
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
    /// Frames that were shown.
    frames: u64,
    /// Frames that were sent to the log.
    frame_rows: u64,
    /// Gaze samples and frames that came while the disk failed and could not be kept any more.
    dropped: [u64; 2],
    /// Whether the session was paused because nothing more could be kept.
    held_up: bool,
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
    /// When it goes on, seconds: not before anything that was logged.
    pub t_s: f64,
}

impl Runner {
    /// Starts a new session: its first events are logged at time 0, after the log's own, and are on disk when this
    /// returns, so that even a session that is killed at once can be found and gone on with.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn begin(session: Session, events: Vec<Event>, writer: SessionWriter, pace: Pace) -> Result<Self, LabError> {
        let mut runner = Self::new(session, writer, pace, Tail { events: 1, ..Tail::default() });
        runner.log(0.0, events)?;
        runner.wait_for_disk()?;
        Ok(runner)
    }

    /// Goes on with a session that has been folded from its journal. Events that the journal lacks are written first;
    /// then the seam is marked, and told to the session as an input, at `t_s`. All of it is on disk when this returns.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn reopen(
        session: Session,
        missing: Vec<Event>,
        writer: SessionWriter,
        pace: Pace,
        tail: Tail,
        seam: Seam,
    ) -> Result<Self, LabError> {
        let mut runner = Self::new(session, writer, pace, tail);
        runner.log(tail.last_event_s, missing)?;
        runner.last_event_s = runner.last_event_s.max(tail.t_s);
        let mark = runner.mark(Event::Continued(Box::new(seam)));
        runner.writer.event(mark)?;
        runner.input(tail.t_s, Input::Reopened)?;
        runner.saving = None;
        runner.wait_for_disk()?;
        Ok(runner)
    }

    fn new(session: Session, writer: SessionWriter, pace: Pace, tail: Tail) -> Self {
        let plan = session.plan();
        let watch = Watch::new(plan.gaze.gate, tail.last_event_s);
        Self {
            display: plan.display.clone(),
            shown: Shown::of(&session),
            session,
            writer,
            pace,
            seq: tail.events,
            last_event_s: tail.last_event_s,
            phase_seq: 0,
            first_frame: tail.frames,
            watch,
            gaze: None,
            gaze_rows: tail.gaze_rows,
            frames: tail.frames,
            frame_rows: tail.frames,
            dropped: [0; 2],
            held_up: false,
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
        // A sample that cannot be logged must not place a stimulus either: nobody could say later where it was.
        if !self.admits()? {
            self.dropped[0] += 1;
            return Ok(());
        }
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

    /// Whether there is room for another row. In virtual time it is waited for.
    fn admits(&self) -> Result<bool, LabError> {
        let began = std::time::Instant::now();
        while !self.writer.admits() {
            if self.pace == Pace::Real {
                return Ok(false);
            }
            if began.elapsed() > PATIENCE {
                return Err(self.out_of_patience());
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        Ok(true)
    }

    fn out_of_patience(&self) -> LabError {
        let why = self.writer.trouble().map_or_else(|| "the disk does not answer".to_owned(), |(_, why)| why);
        LabError::Failed(format!(
            "{}: {why}; given up after {} s. What was acknowledged is on disk: go on with --resume",
            self.folder().display(),
            PATIENCE.as_secs()
        ))
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
    /// `frame_s` is the time between frames; a phase ends with the frame that is nearest to its end. In virtual time the
    /// call waits for the disk; in real time the session waits between trials.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn tick(&mut self, t_s: f64, frame_s: f64) -> Result<(), LabError> {
        if let Some(saving) = &self.saving {
            let saved = match self.pace {
                Pace::Virtual if !saving.wait(PATIENCE)? => return Err(self.out_of_patience()),
                Pace::Virtual => true,
                Pace::Real => saving.arrived()?,
            };
            if !saved {
                return self.tell_trouble(t_s);
            }
            self.saving = None;
            self.tell_dropped()?;
            tracing::info!("on disk: {} completed trials", self.completed);
        }
        if self.phase().is_some_and(|phase| phase.name == PhaseName::Save) {
            self.input(t_s, Input::Saved)?;
        }
        let held_up = self.pace == Pace::Real && !self.writer.admits();
        if held_up && !std::mem::replace(&mut self.held_up, held_up) {
            // The disk has failed for minutes within one phase: what is shown from here on could not be logged.
            self.input(t_s, Input::Pause)?;
        }
        self.held_up = held_up;
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

    /// Says on the display why the session does not go on, once.
    fn tell_trouble(&mut self, t_s: f64) -> Result<(), LabError> {
        let shows_grey =
            self.phase().is_some_and(|phase| phase.name == PhaseName::Save && phase.presentation == Presentation::Grey);
        match self.writer.trouble() {
            Some((trouble, _)) if shows_grey => self.input(t_s, Input::Unsaved { trouble }),
            _ => Ok(()),
        }
    }

    /// Writes down what could not be logged while the disk failed.
    fn tell_dropped(&mut self) -> Result<(), LabError> {
        let [gaze_samples, frames] = std::mem::take(&mut self.dropped);
        if gaze_samples + frames > 0 {
            let mark = self.mark(Event::Gap { gaze_samples, frames });
            self.writer.event(mark)?;
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
    pub fn log_frame(&mut self, row: FrameRow) -> Result<(), LabError> {
        if !self.admits()? {
            self.dropped[1] += 1;
            return Ok(());
        }
        // A row's number is its place in the table, also where rows before it could not be kept.
        let row = FrameRow { index: self.frame_rows, ..row };
        self.frame_rows += 1;
        self.writer.frame(row)
    }

    /// Ends the log; everything sent is on disk when this returns, and marked as whole.
    ///
    /// # Errors
    /// When something could not be written.
    pub fn close(mut self) -> Result<(), LabError> {
        self.tell_dropped()?;
        let mark = self.mark(Event::Closed(self.rows()));
        self.writer.close(mark, PATIENCE)
    }

    /// Rows that were sent to the log.
    fn rows(&self) -> Rows {
        Rows { gaze_rows: self.gaze_rows, frame_rows: self.frame_rows }
    }

    /// The next event, with its number.
    fn mark(&mut self, event: Event) -> Stamped {
        let seq = self.seq;
        self.seq += 1;
        Stamped { seq, t_s: self.last_event_s, event }
    }

    /// Asks for everything so far to be on disk.
    fn sync(&mut self) -> Result<Acknowledgement, LabError> {
        let mark = self.mark(Event::Tables(self.rows()));
        self.writer.sync(mark)
    }

    fn wait_for_disk(&mut self) -> Result<(), LabError> {
        if self.sync()?.wait(PATIENCE)? { Ok(()) } else { Err(self.out_of_patience()) }
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
            let stamped = self.mark(event);
            self.writer.event(stamped)?;
        }
        if new_phase || self.session.finished() {
            let before = self.shown.take().map_or(GazeRule::Free, |shown| shown.gaze);
            self.shown = Shown::of(&self.session);
            self.watch.phase_began(before, self.shown.as_ref().map_or(GazeRule::Free, |shown| shown.gaze));
        }
        if must_save {
            self.saving = Some(self.sync()?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
