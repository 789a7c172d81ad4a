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

use crate::design::{Planned, Schedule};
use crate::marks::{self, Mark};
use crate::streams::Stream;
use crate::study::Plan;
use crate::study::plan::{BlockPlan, Condition, Level};
use crate::trial::form::Form;
use crate::trial::{
    self, AbortReason, Answer, Asked, GazeRule, Input, Outcome, Phase, PhaseName, Presentation, Protocol, SceneClock,
    Setup, Step, Stimulus,
};
use event::{EndReason, Rules};
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
    schedule: Option<Schedule>,
    round: Round,
    completed_in_block: u32,
    /// Whether a completed trial is the last thing that happened: only then may a break follow.
    break_allowed: bool,
    /// The trial that the end of the program interrupted: the next one.
    again: Option<Planned>,
    rules: Rules,
    /// When the block began or its last break ended, seconds.
    rested_s: f64,
    trials: u32,
}

/// How a round of a practice block goes.
#[derive(Debug, Clone, Copy, Default)]
struct Round {
    /// From 1.
    number: u32,
    answered: u32,
    right: u32,
}

/// Where in the study the session is.
#[derive(Debug)]
enum Place {
    /// The consent page.
    Consent,
    /// The participant form.
    Participant(Form),
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
    /// The page before practice is repeated.
    Repeat,
    /// The questionnaire after a block.
    Questionnaire(Form),
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
    planned: Planned,
    protocol: Box<dyn Protocol>,
    /// When something was asked for the first time, and when the last answer came.
    asked_s: Option<f64>,
    answered_s: Option<f64>,
    /// When the first stimulus began.
    stimulus_s: Option<f64>,
}

const PAUSED_TEXT: &str =
    "Paused.\n\nPress space to go on, or Escape to leave. Nothing is lost: a trial that was interrupted comes again.";
const REOPENED_TEXT: &str = "Welcome back.\n\nEverything up to the last answer is saved. Press space to go on.";
const UNSAVED_TEXT: &str = "\n\nNothing is lost: your answers are kept and will be saved as soon as that is possible. Please tell the \
     experimenter. The study goes on by itself.";
const BREAK_TEXT: &str = "Time for a short break.\n\nPress space when you are ready to go on.";
const THANKS_TEXT: &str = "That was the last trial. Thank you.\n\nPress space to finish.";
const REPEAT_TEXT: &str = "That was not quite enough yet. Practice comes once more.\n\nPress space to go on.";
const CONSENT_KEYS: &str = "1   I agree.\n2   I do not agree.";

impl Session {
    /// A session at its first page, with the events of its beginning.
    ///
    /// `plan` is what this observer runs in this sitting: [`Plan::assigned`].
    #[must_use]
    pub fn begin(plan: Arc<Plan>, seed: u64) -> (Self, Vec<Event>) {
        Self::begin_by(Rules::NEWEST, plan, seed)
    }

    /// [`Self::begin`] by the rules of an earlier version.
    pub(crate) fn begin_by(rules: Rules, plan: Arc<Plan>, seed: u64) -> (Self, Vec<Event>) {
        let mut session = Self {
            design: Stream::Design.generator(seed),
            choice: Stream::Procedure.generator(seed),
            place: Place::Finished,
            phase: save_phase(),
            phase_began_s: 0.0,
            block: 0,
            schedule: None,
            round: Round::default(),
            completed_in_block: 0,
            break_allowed: false,
            again: None,
            rules,
            rested_s: 0.0,
            trials: 0,
            plan,
        };
        let mut events = Vec::new();
        if session.plan.texts.consent.is_some() {
            session.enter_page(Place::Consent, 0.0, &mut events);
        } else {
            session.after_consent(0.0, &mut events);
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

    /// The condition of the running trial, if one is running.
    #[must_use]
    pub fn condition(&self) -> Option<&Condition> {
        let Place::Trial(running) = &self.place else { return None };
        Some(&self.block()?.cells.get(running.planned.cell)?.condition)
    }

    /// The level that the current phase shows: the trial's, with the phase's own on top.
    #[must_use]
    pub fn shown_level(&self) -> Option<Level> {
        let mut level = self.trial()?.level.clone();
        if let Presentation::Stimulus(stimulus) = &self.phase.presentation {
            level.extend(stimulus.level.clone());
        }
        Some(level)
    }

    /// How long the scene has been moving at `t_s`, seconds; 0 for what does not move.
    #[must_use]
    pub fn animation_s(&self, t_s: f64) -> f64 {
        let Presentation::Stimulus(Stimulus { clock, .. }) = &self.phase.presentation else { return 0.0 };
        let since_s = match (clock, &self.place) {
            (SceneClock::Trial, Place::Trial(running)) => running.stimulus_s.unwrap_or(self.phase_began_s),
            _ => self.phase_began_s,
        };
        (t_s - since_s).max(0.0)
    }

    /// What is drawn over the picture at an animation time.
    #[must_use]
    pub fn marks(&self, animation_s: f64) -> Vec<Mark> {
        marks::marks(
            &self.phase.presentation,
            self.condition(),
            self.trial().and_then(|trial| trial.path_seed),
            self.plan.gaze.fixation_deg,
            self.plan.display.half_field_deg(),
            animation_s,
        )
    }

    /// Where observers are to look at an animation time: the fixation mark, or the moving target.
    #[must_use]
    pub fn look_at_deg(&self, animation_s: f64) -> [f64; 2] {
        let fixation_deg = self.plan.gaze.fixation_deg;
        match (self.condition(), self.trial()) {
            (Some(condition), Some(trial)) => {
                marks::look_at_deg(condition.fixation, trial.path_seed, fixation_deg, animation_s)
            }
            _ => fixation_deg,
        }
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
            (Place::Trial(_), Input::GazeLeft) => match self.phase.gaze {
                GazeRule::Abort => {
                    let outcome = Outcome::Aborted { reason: AbortReason::GazeLeft };
                    self.end_trial(&outcome, t_s, events);
                }
                GazeRule::Hide => self.advance_trial(&input, t_s, events),
                GazeRule::Free | GazeRule::Hold | GazeRule::AwaitReturn => return false,
            },
            (Place::Trial(_), Input::GazeReturned) if self.phase.gaze == GazeRule::AwaitReturn => {
                self.advance_trial(&input, t_s, events);
            }
            (Place::Trial(running), Input::Answered { answer }) if self.phase.takes(answer) => {
                running.answered_s = Some(t_s);
                self.advance_trial(&input, t_s, events);
            }
            (Place::Trial(_), Input::Elapsed) if self.phase.duration_s.is_some() => {
                self.advance_trial(&input, t_s, events);
            }
            (Place::Trial(_), _) => return false,
            (Place::Save, Input::Saved) => self.after_trial(t_s, events),
            (Place::Save, Input::Unsaved { trouble }) => {
                let text = format!("{}{UNSAVED_TEXT}", trouble.in_words());
                self.present(Phase::new(PhaseName::Save, Presentation::Text(text), None), t_s, events);
            }
            (Place::Save, Input::Pause) => self.enter_paused(None, PAUSED_TEXT, t_s, events),
            (Place::Save, Input::Reopened) => self.enter_paused(None, REOPENED_TEXT, t_s, events),
            (Place::Save, _) => return false,
            (_, Input::Answered { answer }) if self.phase.takes(answer) => self.answer_page(answer, t_s, events),
            (_, Input::Pause) => self.pause_page(PAUSED_TEXT, t_s, events),
            (_, Input::Reopened) => self.pause_page(REOPENED_TEXT, t_s, events),
            (_, _) => return false,
        }
        true
    }

    // --- pages -----------------------------------------------------------------------------------------------------

    fn after_consent(&mut self, t_s: f64, events: &mut Vec<Event>) {
        let items = &self.plan.participant;
        if items.is_empty() {
            self.after_participant(t_s, events);
        } else {
            self.enter_page(Place::Participant(Form::new(items)), t_s, events);
        }
    }

    fn after_participant(&mut self, t_s: f64, events: &mut Vec<Event>) {
        if self.plan.texts.instructions.is_empty() {
            self.enter_block(t_s, events);
        } else {
            self.enter_page(Place::Instructions(0), t_s, events);
        }
    }

    fn enter_page(&mut self, place: Place, t_s: f64, events: &mut Vec<Event>) {
        let texts = &self.plan.texts;
        let otherwise = |text: &String, default: &str| if text.is_empty() { default.to_owned() } else { text.clone() };
        let phase = match &place {
            Place::Consent => {
                let text = format!("{}\n\n{CONSENT_KEYS}", texts.consent.as_deref().unwrap_or_default());
                Phase::new(PhaseName::Consent, Presentation::Text(text), None)
                    .asking(Asked::Consent, vec![Answer::First, Answer::Second])
            }
            Place::Participant(form) | Place::Questionnaire(form) => form.phase().unwrap_or_else(save_phase),
            Place::Instructions(page) => text_page(texts.instructions.get(*page).map_or("", String::as_str)),
            Place::BlockPage => text_page(self.block().and_then(|block| block.instructions.as_deref()).unwrap_or("")),
            Place::Break => text_page(&otherwise(&texts.pause, BREAK_TEXT)),
            Place::Repeat => text_page(REPEAT_TEXT),
            _ => text_page(&otherwise(&texts.thanks, THANKS_TEXT)),
        };
        self.place = place;
        self.present(phase, t_s, events);
    }

    fn answer_page(&mut self, answer: Answer, t_s: f64, events: &mut Vec<Event>) {
        match std::mem::replace(&mut self.place, Place::Save) {
            Place::Consent if answer == Answer::First => self.after_consent(t_s, events),
            Place::Consent => self.end_early(EndReason::Declined, events),
            Place::Participant(mut form) => {
                form.take(answer);
                if form.phase().is_some() {
                    return self.enter_page(Place::Participant(form), t_s, events);
                }
                let entries = form.entries().clone();
                events.push(Event::FormFilled { form: "participant".to_owned(), entries });
                self.after_participant(t_s, events);
            }
            Place::Instructions(page) if page + 1 < self.plan.texts.instructions.len() => {
                self.enter_page(Place::Instructions(page + 1), t_s, events);
            }
            Place::Instructions(_) => self.enter_block(t_s, events),
            Place::BlockPage => self.begin_trials(t_s, events),
            Place::Break => {
                self.rested_s = t_s;
                self.start_trial(t_s, events);
            }
            Place::Repeat => self.begin_trials(t_s, events),
            Place::Questionnaire(mut form) => {
                form.take(answer);
                if form.phase().is_some() {
                    return self.enter_page(Place::Questionnaire(form), t_s, events);
                }
                let block = self.block().map(|block| block.name.clone()).unwrap_or_default();
                events.push(Event::FormFilled { form: block, entries: form.entries().clone() });
                self.leave_block(t_s, events);
            }
            _ => {
                self.place = Place::Finished;
                events.push(Event::Finished);
            }
        }
    }

    fn end_early(&mut self, reason: EndReason, events: &mut Vec<Event>) {
        self.place = Place::Finished;
        events.push(Event::Ended { reason });
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
        self.present(Phase { name: PhaseName::Paused, ..text_page(text) }, t_s, events);
    }

    fn unpause(&mut self, t_s: f64, events: &mut Vec<Event>) {
        match std::mem::replace(&mut self.place, Place::Save) {
            Place::Paused(Some(before)) => self.enter_page(*before, t_s, events),
            // The place is `Save` now.
            _ if self.rules >= Rules::Second => self.present(save_phase(), t_s, events),
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
        self.round = Round::default();
        self.completed_in_block = 0;
        events.push(Event::BlockBegan { block: block.name.clone() });
        if block.instructions.is_some() {
            self.enter_page(Place::BlockPage, t_s, events);
        } else {
            self.begin_trials(t_s, events);
        }
    }

    /// Begins a round of the block's trials.
    fn begin_trials(&mut self, t_s: f64, events: &mut Vec<Event>) {
        self.schedule = self.plan.blocks.get(self.block).map(|block| Schedule::new(block, &mut self.design));
        self.round = Round { number: self.round.number + 1, ..Round::default() };
        self.rested_s = t_s;
        self.start_trial(t_s, events);
    }

    fn start_trial(&mut self, t_s: f64, events: &mut Vec<Event>) {
        let plan = Arc::clone(&self.plan);
        let new = |session: &mut Self| session.schedule.as_mut()?.next(&mut session.design, &mut session.choice);
        let next = self.again.take().or_else(|| new(self));
        let (Some(block), Some(planned)) = (plan.blocks.get(self.block), next) else {
            return self.after_round(t_s, events);
        };
        let Some(cell) = block.cells.get(planned.cell) else { return self.after_round(t_s, events) };
        self.trials += 1;
        let [eccentricity_deg, mar_deg] = cell.condition.tested_at(&planned.level);
        let trial = Trial {
            trial: self.trials,
            block: block.name.clone(),
            practice: block.practice,
            condition: cell.condition.name.clone(),
            factors: cell.factors.clone(),
            level: planned.level.clone(),
            order: planned.order,
            eccentricity_deg,
            mar_deg,
            repetition: planned.repetition,
            path_seed: Some(planned.path_seed),
        };
        let setup = Setup { level: &planned.level, order: planned.order, path_seed: planned.path_seed };
        let mut protocol = trial::start(block, setup);
        events.push(Event::TrialBegan(trial.clone()));
        let step = protocol.next(None);
        let running = RunningTrial { trial, planned, protocol, asked_s: None, answered_s: None, stimulus_s: None };
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
                if let Place::Trial(running) = &mut self.place {
                    if phase.asked.is_some() {
                        running.asked_s.get_or_insert(t_s);
                    }
                    if matches!(phase.presentation, Presentation::Stimulus(_)) {
                        running.stimulus_s.get_or_insert(t_s);
                    }
                }
                self.present(phase, t_s, events);
            }
            Step::End(outcome) => self.end_trial(&outcome, t_s, events),
        }
    }

    fn end_trial(&mut self, outcome: &Outcome, t_s: f64, events: &mut Vec<Event>) {
        let Place::Trial(running) = std::mem::replace(&mut self.place, Place::Save) else {
            return;
        };
        let RunningTrial { trial, planned, asked_s, answered_s, .. } = *running;
        let response_time_s = answered_s.zip(asked_s).map(|(answered, asked)| answered - asked);
        events.push(Event::TrialEnded { trial: trial.trial, outcome: outcome.clone(), response_time_s });
        self.break_allowed = matches!(outcome, Outcome::Answered { .. });
        if let Some(schedule) = self.schedule.as_mut() {
            match outcome {
                Outcome::Answered { correct, .. } => {
                    let correct = *correct;
                    schedule.complete(&planned, correct);
                    self.completed_in_block += 1;
                    self.round.answered += u32::from(correct.is_some());
                    self.round.right += u32::from(correct == Some(true));
                    let estimate = schedule.estimate(planned.cell);
                    if !estimate.is_empty() {
                        events.push(Event::Estimated { trial: trial.trial, estimate });
                    }
                }
                Outcome::Aborted { reason: AbortReason::Interrupted } if self.rules >= Rules::Second => {
                    self.again = Some(planned);
                }
                Outcome::TimedOut | Outcome::Aborted { .. } => schedule.put_back(planned, &mut self.design),
            }
        }
        self.present(save_phase(), t_s, events);
    }

    fn abort(&mut self, reason: AbortReason, text: &str, t_s: f64, events: &mut Vec<Event>) {
        self.end_trial(&Outcome::Aborted { reason }, t_s, events);
        self.enter_paused(None, text, t_s, events);
    }

    /// What comes after a trial that is on disk: the next one, a break, or the end of the round.
    fn after_trial(&mut self, t_s: f64, events: &mut Vec<Event>) {
        let plan = Arc::clone(&self.plan);
        let Some(block) = plan.blocks.get(self.block) else {
            return self.enter_page(Place::Thanks, t_s, events);
        };
        if self.schedule.as_ref().is_none_or(Schedule::finished) {
            self.after_round(t_s, events);
        } else if self.break_is_due(block, t_s) {
            self.enter_page(Place::Break, t_s, events);
        } else {
            self.start_trial(t_s, events);
        }
    }

    /// After the last trial of a round: practice is judged, the questionnaire asked, the block left.
    fn after_round(&mut self, t_s: f64, events: &mut Vec<Event>) {
        let plan = Arc::clone(&self.plan);
        let Some(block) = plan.blocks.get(self.block) else {
            return self.enter_page(Place::Thanks, t_s, events);
        };
        if let Some(criterion) = block.criterion {
            let Round { number, answered, right } = self.round;
            let share_correct = f64::from(right) / f64::from(answered.max(1));
            let passed = share_correct >= criterion.share_correct;
            events.push(Event::PracticeJudged { block: block.name.clone(), round: number, share_correct, passed });
            if !passed && number < criterion.max_rounds {
                return self.enter_page(Place::Repeat, t_s, events);
            }
            if !passed && criterion.ends_session {
                return self.end_early(EndReason::PracticeFailed, events);
            }
        }
        if block.questionnaire.is_empty() {
            self.leave_block(t_s, events);
        } else {
            self.enter_page(Place::Questionnaire(Form::new(&block.questionnaire)), t_s, events);
        }
    }

    fn leave_block(&mut self, t_s: f64, events: &mut Vec<Event>) {
        if let Some(block) = self.plan.blocks.get(self.block) {
            events.push(Event::BlockEnded { block: block.name.clone(), completed: self.completed_in_block });
        }
        self.block += 1;
        self.enter_block(t_s, events);
    }

    /// A break is due once after every n completed trials, and as soon as the time since the last one is up; not again
    /// when the trial after it had to be repeated.
    fn break_is_due(&self, block: &BlockPlan, t_s: f64) -> bool {
        let by_trials = |every: u32| self.completed_in_block.is_multiple_of(every.max(1));
        let by_time = |every_s: f64| t_s - self.rested_s >= every_s;
        self.break_allowed
            && (block.breaks.every_trials.is_some_and(by_trials) || block.breaks.every_s.is_some_and(by_time))
    }

    fn present(&mut self, phase: Phase, t_s: f64, events: &mut Vec<Event>) {
        let (shown, at) = match &phase.presentation {
            Presentation::Stimulus(stimulus) => (Some(stimulus.alternative), stimulus.level.clone()),
            _ => (None, Level::new()),
        };
        events.push(Event::PhaseBegan { trial: self.trial().map(|trial| trial.trial), phase: phase.name, shown, at });
        self.phase = phase;
        self.phase_began_s = t_s;
    }
}

fn text_page(text: &str) -> Phase {
    let phase = Phase::new(PhaseName::Page, Presentation::Text(text.to_owned()), None);
    Phase { accepts: vec![Answer::Continue], ..phase }
}

fn save_phase() -> Phase {
    Phase::new(PhaseName::Save, Presentation::Grey, None)
}
