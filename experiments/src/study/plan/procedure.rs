//! How the next level is chosen.

mod adaptive;
mod stop;

pub use adaptive::*;
pub use stop::*;

use super::Level;

/// How the next level is chosen.
#[derive(Debug, Clone, PartialEq)]
pub enum ProcedurePlan {
    /// Constant stimuli: every level, so many times, shuffled.
    Constant(ConstantPlan),
    /// A transformed or weighted staircase on one parameter.
    Staircase(StaircasePlan),
    /// QUEST on one parameter.
    Quest(QuestPlan),
    /// QUEST+ over the MAR model.
    QuestPlus(QuestPlusPlan),
    /// QUEST+ over a psychometric function.
    QuestPlusFunction(FunctionPlan),
    /// Psi: threshold and slope of a psychometric function.
    Psi(PsiPlan),
}

impl ProcedurePlan {
    /// Every level that may be shown. A staircase and QUEST may show any level between two limits; of them these are the
    /// two limits.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        match self {
            Self::Constant(plan) => &plan.levels,
            Self::Staircase(plan) => plan.place.ends(),
            Self::Quest(plan) => plan.place.ends(),
            Self::QuestPlus(plan) => &plan.levels,
            Self::QuestPlusFunction(plan) => &plan.levels,
            Self::Psi(plan) => &plan.levels,
        }
    }

    /// Whether levels are anything between two limits, rather than one of a list.
    #[must_use]
    pub fn is_continuous(&self) -> bool {
        matches!(self, Self::Staircase(_) | Self::Quest(_))
    }

    /// The most trials that the block can have, aborted ones aside; `u32::MAX` where a rule sets no limit, which no
    /// checked study has.
    #[must_use]
    pub fn max_trials(&self) -> u32 {
        match self {
            Self::Constant(plan) => plan.repetitions.saturating_mul(plan.levels.len() as u32),
            Self::Staircase(plan) => in_every_track(plan, plan.stop.max_trials().unwrap_or(u32::MAX)),
            adaptive => adaptive.stop().and_then(Stop::max_trials).unwrap_or(u32::MAX),
        }
    }

    /// The fewest trials that the block can have.
    #[must_use]
    pub fn min_trials(&self) -> u32 {
        match self {
            Self::Constant(_) => self.max_trials(),
            Self::Staircase(plan) => in_every_track(plan, plan.stop.min_trials(|n| plan.fewest_trials(n))),
            adaptive => adaptive.stop().map_or(0, |stop| stop.min_trials(|_| u32::MAX)),
        }
    }

    /// When an adaptive procedure stops; nothing for constant stimuli. Of a staircase, each track has this rule to itself.
    #[must_use]
    pub fn stop(&self) -> Option<&Stop> {
        match self {
            Self::Constant(_) => None,
            Self::Staircase(plan) => Some(&plan.stop),
            Self::Quest(plan) => Some(&plan.stop),
            Self::QuestPlus(plan) => Some(&plan.stop),
            Self::QuestPlusFunction(plan) => Some(&plan.stop),
            Self::Psi(plan) => Some(&plan.stop),
        }
    }

    /// Whether levels depend on the answers; then every cell of the design has a procedure of its own.
    #[must_use]
    pub fn is_adaptive(&self) -> bool {
        !matches!(self, Self::Constant(_))
    }
}

fn in_every_track(plan: &StaircasePlan, trials: u32) -> u32 {
    trials.saturating_mul(plan.start.len() as u32)
}

/// Constant stimuli.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantPlan {
    /// The levels, each shown `repetitions` times.
    pub levels: Vec<Level>,
    /// Times each level is shown.
    pub repetitions: u32,
}
