//! A session: the one machine behind running, resuming, replaying and simulating.
//!
//! [`Session`] is pure. It is fed [`Input`]s with their times by a window, an offscreen stage, a journal or a test, says
//! which [`Phase`] to present, and returns the [`Event`]s that each input caused.

pub mod event;
pub mod record;
pub mod refold;
pub mod simulate;
#[cfg(test)]
mod tests;

pub use event::{Event, Stamped, Trial};

use crate::procedures::{self, Procedure};
use crate::streams::Stream;
use crate::study::Plan;
use crate::study::plan::{BlockPlan, Condition, ProtocolPlan};
use crate::trial::two_interval::TwoInterval;
use crate::trial::{AbortReason, Alternative, Answer, Input, Outcome, Phase, PhaseName, Presentation, Protocol, Step};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// The running state of a session, a fold over its inputs.
#[derive(Debug)]
pub struct Session {
    plan: Arc<Plan>,
    design: ChaCha8Rng,
    choice: ChaCha8Rng,
    place: Place,
    phase: Phase,
    phase_began_s: f64,
    /// Index of the current block; equal to the number of blocks after the last.
    block: usize,
    procedure: Option<Box<dyn Procedure>>,
    completed_in_block: u32,
    /// Whether a completed trial is the last thing that happened: only then may a break follow.
    break_allowed: bool,
    trials: u32,
}

/// Where in the study the session is.
#[derive(Debug)]
enum Place {
    /// A page of the instructions.
    Instructions(usize),
    /// The page before a block.
    BlockPage,
    /// In a trial.
    Trial(Box<RunningTrial>),
    /// Between trials, until the last one is on disk.
    Save,
    /// A break.
    Break,
    /// Paused; what was shown before, unless it was a trial.
    Paused(Option<Box<Place>>),
    /// The last page.
    Thanks,
    /// Over.
    Finished,
}

#[derive(Debug)]
struct RunningTrial {
    trial: Trial,
    protocol: Box<dyn Protocol>,
    /// When the question came up and when it was answered.
    asked_s: Option<f64>,
    answered_s: Option<f64>,
}

const PAUSED_TEXT: &str =
    "Paused.\n\nPress space to go on, or Escape to leave. Nothing is lost: a trial that was interrupted comes again.";
const REOPENED_TEXT: &str = "Welcome back.\n\nEverything up to the last answer is saved. Press space to go on.";
const BREAK_TEXT: &str = "Time for a short break.\n\nPress space when you are ready to go on.";
const THANKS_TEXT: &str = "That was the last trial. Thank you.\n\nPress space to finish.";

impl Session {
    /// A session at its first page, with the events of its beginning.
    #[must_use]
    pub fn begin(plan: Arc<Plan>, seed: u64) -> (Self, Vec<Event>) {
        let mut session = Self {
            design: Stream::Design.generator(seed),
            choice: Stream::Procedure.generator(seed),
            place: Place::Finished,
            phase: save_phase(),
            phase_began_s: 0.0,
            block: 0,
            procedure: None,
            completed_in_block: 0,
            break_allowed: false,
            trials: 0,
            plan,
        };
        let mut events = Vec::new();
        if session.plan.texts.instructions.is_empty() {
            session.enter_block(0.0, &mut events);
        } else {
            session.enter_page(Place::Instructions(0), 0.0, &mut events);
        }
        (session, events)
    }

    /// The plan it runs.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What to present now; nothing once the session is over.
    #[must_use]
    pub fn phase(&self) -> Option<&Phase> {
        (!self.finished()).then_some(&self.phase)
    }

    /// When the current phase began, seconds.
    #[must_use]
    pub fn phase_began_s(&self) -> f64 {
        self.phase_began_s
    }

    /// The trial that is running, if one is.
    #[must_use]
    pub fn trial(&self) -> Option<&Trial> {
        match &self.place {
            Place::Trial(running) => Some(&running.trial),
            _ => None,
        }
    }

    /// The current block's plan, if the session is in one.
    #[must_use]
    pub fn block(&self) -> Option<&BlockPlan> {
        self.plan.blocks.get(self.block)
    }

    /// The condition of the current block.
    #[must_use]
    pub fn condition(&self) -> Option<&Condition> {
        self.block().map(|block| &block.condition)
    }

    /// Completed trials of the current block.
    #[must_use]
    pub fn completed_in_block(&self) -> u32 {
        self.completed_in_block
    }

    /// Whether everything has been asked.
    #[must_use]
    pub fn finished(&self) -> bool {
        matches!(self.place, Place::Finished)
    }

    /// Takes in what happened at `t_s` and returns the input itself, marked accepted or not, and what it caused.
    pub fn handle(&mut self, t_s: f64, input: Input) -> Vec<Event> {
        let mut events = vec![Event::Input { input, accepted: false }];
        let accepted = self.dispatch(t_s, input, &mut events);
        events[0] = Event::Input { input, accepted };
        events
    }

    fn dispatch(&mut self, t_s: f64, input: Input, events: &mut Vec<Event>) -> bool {
        match (&mut self.place, input) {
            (Place::Finished, _) => return false,
            (Place::Paused(_), Input::Resume | Input::Answered { answer: Answer::Continue }) => {
                self.unpause(t_s, events);
            }
            (Place::Paused(_), Input::Reopened) => self.enter_paused(None, REOPENED_TEXT, t_s, events),
            (Place::Paused(_), _) => return false,
            (Place::Trial(_), Input::Pause) => self.abort(AbortReason::Paused, PAUSED_TEXT, t_s, events),
            (Place::Trial(_), Input::Reopened) => self.abort(AbortReason::Interrupted, REOPENED_TEXT, t_s, events),
            (Place::Trial(_), Input::GazeLeft) if self.phase.gated => {
                let outcome = Outcome::Aborted { reason: AbortReason::GazeLeft };
                self.end_trial(outcome, t_s, events);
            }
            (Place::Trial(running), Input::Answered { answer }) if self.phase.accepts.contains(&answer) => {
                running.answered_s = Some(t_s);
                self.advance_trial(&input, t_s, events);
            }
            (Place::Trial(_), Input::Elapsed) if self.phase.duration_s.is_some() => {
                self.advance_trial(&input, t_s, events);
            }
            (Place::Trial(_), _) => return false,
            (Place::Save, Input::Saved) => self.after_trial(t_s, events),
            (Place::Save, Input::Pause) => self.enter_paused(None, PAUSED_TEXT, t_s, events),
            (Place::Save, Input::Reopened) => self.enter_paused(None, REOPENED_TEXT, t_s, events),
            (Place::Save, _) => return false,
            (_, Input::Answered { answer: Answer::Continue }) => self.turn_page(t_s, events),
            (_, Input::Pause) => self.pause_page(PAUSED_TEXT, t_s, events),
            (_, Input::Reopened) => self.pause_page(REOPENED_TEXT, t_s, events),
            (_, _) => return false,
        }
        true
    }

    // --- pages -----------------------------------------------------------------------------------------------------

    fn enter_page(&mut self, place: Place, t_s: f64, events: &mut Vec<Event>) {
        let texts = &self.plan.texts;
        let otherwise = |text: &String, default: &str| if text.is_empty() { default.to_owned() } else { text.clone() };
        let text = match &place {
            Place::Instructions(page) => texts.instructions.get(*page).cloned().unwrap_or_default(),
            Place::BlockPage => self.block().and_then(|block| block.instructions.clone()).unwrap_or_default(),
            Place::Break => otherwise(&texts.pause, BREAK_TEXT),
            _ => otherwise(&texts.thanks, THANKS_TEXT),
        };
        self.place = place;
        self.present(page_phase(PhaseName::Page, &text), t_s, events);
    }

    fn turn_page(&mut self, t_s: f64, events: &mut Vec<Event>) {
        match self.place {
            Place::Instructions(page) if page + 1 < self.plan.texts.instructions.len() => {
                self.enter_page(Place::Instructions(page + 1), t_s, events);
            }
            Place::Instructions(_) => self.enter_block(t_s, events),
            Place::BlockPage | Place::Break => self.start_trial(t_s, events),
            _ => {
                self.place = Place::Finished;
                events.push(Event::Finished);
            }
        }
    }

    fn pause_page(&mut self, text: &str, t_s: f64, events: &mut Vec<Event>) {
        let before = std::mem::replace(&mut self.place, Place::Save);
        self.enter_paused(Some(Box::new(before)), text, t_s, events);
    }

    fn enter_paused(&mut self, before: Option<Box<Place>>, text: &str, t_s: f64, events: &mut Vec<Event>) {
        let before = match std::mem::replace(&mut self.place, Place::Save) {
            Place::Paused(earlier) => earlier,
            _ => before,
        };
        self.place = Place::Paused(before);
        self.present(page_phase(PhaseName::Paused, text), t_s, events);
    }

    fn unpause(&mut self, t_s: f64, events: &mut Vec<Event>) {
        match std::mem::replace(&mut self.place, Place::Save) {
            Place::Paused(Some(before)) => self.enter_page(*before, t_s, events),
            _ => self.after_trial(t_s, events),
        }
    }

    // --- blocks and trials -----------------------------------------------------------------------------------------

    fn enter_block(&mut self, t_s: f64, events: &mut Vec<Event>) {
        let plan = Arc::clone(&self.plan);
        let Some(block) = plan.blocks.get(self.block) else {
            self.enter_page(Place::Thanks, t_s, events);
            return;
        };
        self.procedure = Some(procedures::start(&block.procedure, &mut self.design));
        self.completed_in_block = 0;
        events.push(Event::BlockBegan { block: block.name.clone() });
        if block.instructions.is_some() {
            self.enter_page(Place::BlockPage, t_s, events);
        } else {
            self.start_trial(t_s, events);
        }
    }

    fn start_trial(&mut self, t_s: f64, events: &mut Vec<Event>) {
        let plan = Arc::clone(&self.plan);
        let (Some(block), Some(procedure)) = (plan.blocks.get(self.block), self.procedure.as_mut()) else {
            return self.enter_page(Place::Thanks, t_s, events);
        };
        let level = procedure.level(&mut self.choice);
        let test_first: bool = self.design.random();
        self.trials += 1;
        let axes = block.procedure.axes();
        let trial = Trial {
            trial: self.trials,
            block: block.name.clone(),
            practice: block.practice,
            condition: block.condition.name.clone(),
            order: if test_first {
                [Alternative::Test, Alternative::Reference]
            } else {
                [Alternative::Reference, Alternative::Test]
            },
            eccentricity_deg: level.get(&axes.eccentricity).copied(),
            mar_deg: level.get(&axes.mar).copied(),
            level,
        };
        let protocol: Box<dyn Protocol> = match &block.protocol {
            ProtocolPlan::TwoInterval(timing) => Box::new(TwoInterval::new(timing, test_first, block.practice)),
        };
        events.push(Event::TrialBegan(trial.clone()));
        let mut running = RunningTrial { trial, protocol, asked_s: None, answered_s: None };
        let step = running.protocol.next(None);
        self.place = Place::Trial(Box::new(running));
        self.take_step(step, t_s, events);
    }

    fn advance_trial(&mut self, input: &Input, t_s: f64, events: &mut Vec<Event>) {
        if let Place::Trial(running) = &mut self.place {
            let step = running.protocol.next(Some(input));
            self.take_step(step, t_s, events);
        }
    }

    fn take_step(&mut self, step: Step, t_s: f64, events: &mut Vec<Event>) {
        match step {
            Step::Show(phase) => {
                if let Place::Trial(running) = &mut self.place
                    && phase.name == PhaseName::Ask
                {
                    running.asked_s = Some(t_s);
                }
                self.present(phase, t_s, events);
            }
            Step::End(outcome) => self.end_trial(outcome, t_s, events),
        }
    }

    fn end_trial(&mut self, outcome: Outcome, t_s: f64, events: &mut Vec<Event>) {
        let Place::Trial(running) = std::mem::replace(&mut self.place, Place::Save) else {
            return;
        };
        let RunningTrial { trial, asked_s, answered_s, .. } = *running;
        let response_time_s = answered_s.zip(asked_s).map(|(answered, asked)| answered - asked);
        events.push(Event::TrialEnded { trial: trial.trial, outcome, response_time_s });
        self.break_allowed = matches!(outcome, Outcome::Answered { .. });
        if let Some(procedure) = self.procedure.as_mut() {
            match outcome {
                Outcome::Answered { correct, .. } => {
                    procedure.update(&trial.level, correct);
                    self.completed_in_block += 1;
                    let estimate = procedure.estimate();
                    if !estimate.is_empty() {
                        events.push(Event::Estimated { trial: trial.trial, estimate });
                    }
                }
                Outcome::TimedOut | Outcome::Aborted { .. } => procedure.put_back(trial.level, &mut self.design),
            }
        }
        self.present(save_phase(), t_s, events);
    }

    fn abort(&mut self, reason: AbortReason, text: &str, t_s: f64, events: &mut Vec<Event>) {
        self.end_trial(Outcome::Aborted { reason }, t_s, events);
        self.enter_paused(None, text, t_s, events);
    }

    /// What comes after a trial that is on disk: the next one, a break, the next block or the last page.
    fn after_trial(&mut self, t_s: f64, events: &mut Vec<Event>) {
        let plan = Arc::clone(&self.plan);
        let Some(block) = plan.blocks.get(self.block) else {
            return self.enter_page(Place::Thanks, t_s, events);
        };
        if self.procedure.as_ref().is_none_or(|procedure| procedure.finished()) {
            events.push(Event::BlockEnded { block: block.name.clone(), completed: self.completed_in_block });
            self.block += 1;
            self.enter_block(t_s, events);
        } else if self.break_is_due(block) {
            self.enter_page(Place::Break, t_s, events);
        } else {
            self.start_trial(t_s, events);
        }
    }

    /// A break is due once after every n completed trials; not again when the trial after it had to be repeated.
    fn break_is_due(&self, block: &BlockPlan) -> bool {
        let due = |every: u32| self.completed_in_block.is_multiple_of(every.max(1));
        self.break_allowed && block.break_every_trials.is_some_and(due)
    }

    fn present(&mut self, phase: Phase, t_s: f64, events: &mut Vec<Event>) {
        events.push(Event::PhaseBegan { trial: self.trial().map(|trial| trial.trial), phase: phase.name });
        self.phase = phase;
        self.phase_began_s = t_s;
    }
}

fn page_phase(name: PhaseName, text: &str) -> Phase {
    Phase {
        name,
        presentation: Presentation::Text(text.to_owned()),
        duration_s: None,
        accepts: vec![Answer::Continue],
        gated: false,
        hold_for_gaze: false,
    }
}

fn save_phase() -> Phase {
    Phase {
        name: PhaseName::Save,
        presentation: Presentation::Grey,
        duration_s: None,
        accepts: Vec::new(),
        gated: false,
        hold_for_gaze: false,
    }
}
