//! What an observer remembers of a trial: what it saw, in order, and how far it got with what it adjusts.

use super::adjusting::Adjusting;
use super::comparing::Toggles;
use super::matching::Matching;
use super::rating::Rating;
use super::{Presented, Sight};
use crate::trial::{Alternative, PhaseName, Presentation, Stimulus};

/// A stimulus that was seen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Glimpse {
    name: PhaseName,
    stimulus: Stimulus,
    pub(super) sight: Sight,
}

/// The memory of one trial.
#[derive(Debug, Clone, Default)]
pub(super) struct Memory {
    trial: Option<u32>,
    seen: Vec<Glimpse>,
    /// Whether the last stimulus was only hidden since: then the same again is the same still.
    interrupted: bool,
    pub(super) toggles: Toggles,
    pub(super) matching: Matching,
    pub(super) adjusting: Adjusting,
    pub(super) rating: Rating,
}

impl Memory {
    /// Forgets everything when another trial has begun.
    pub(super) fn turn_to(&mut self, trial: Option<u32>) {
        if self.trial != trial {
            *self = Self { trial, ..Self::default() };
        }
    }

    /// Takes in a phase.
    pub(super) fn phase(&mut self, presented: &Presented<'_>, sight: Sight) {
        let name = presented.phase.name;
        let Presentation::Stimulus(stimulus) = &presented.phase.presentation else {
            self.interrupted = name == PhaseName::Hidden;
            return;
        };
        let sight = if stimulus.alternative == Alternative::Reference { Sight::REFERENCE } else { sight };
        let glimpse = Glimpse { name, stimulus: stimulus.clone(), sight };
        match self.seen.last_mut() {
            Some(last) if self.interrupted && last.name == name && last.stimulus == glimpse.stimulus => *last = glimpse,
            _ => self.seen.push(glimpse),
        }
        self.interrupted = false;
        self.rating = Rating::default();
    }

    pub(super) fn last(&self) -> Option<&Glimpse> {
        self.seen.last()
    }

    pub(super) fn last_mut(&mut self) -> Option<&mut Glimpse> {
        self.seen.last_mut()
    }

    /// What the first and the last stimulus gave: both intervals of a comparison, both ends of a ramp.
    pub(super) fn first_and_last(&self) -> [Sight; 2] {
        [self.seen.first(), self.seen.last()].map(|glimpse| glimpse.map_or(Sight::REFERENCE, |glimpse| glimpse.sight))
    }

    /// δ of the alternative A less δ of the alternative B, as far as they were seen.
    pub(super) fn toggled_difference(&self) -> f64 {
        let delta = |name| {
            let glimpse = self.seen.iter().rev().find(|glimpse| glimpse.name == name);
            glimpse.map_or(0.0, |glimpse| glimpse.sight.delta)
        };
        delta(PhaseName::AlternativeA) - delta(PhaseName::AlternativeB)
    }

    /// How many spheres the last stimulus with spheres had.
    pub(super) fn spheres(&self) -> Option<u32> {
        self.seen.iter().rev().find_map(|glimpse| glimpse.stimulus.spheres).map(|spheres| spheres.count)
    }
}
