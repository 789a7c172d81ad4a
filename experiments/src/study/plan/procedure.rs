//! How the next level is chosen.

use super::Level;

/// How the next level is chosen.
#[derive(Debug, Clone, PartialEq)]
pub enum ProcedurePlan {
    /// Constant stimuli: every level, so many times, shuffled.
    Constant(ConstantPlan),
    /// QUEST+ over the MAR model.
    QuestPlus(QuestPlusPlan),
}

impl ProcedurePlan {
    /// Every level that may be shown.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        match self {
            Self::Constant(plan) => &plan.levels,
            Self::QuestPlus(plan) => &plan.levels,
        }
    }

    /// The most trials that the block can have, aborted ones aside.
    #[must_use]
    pub fn max_trials(&self) -> u32 {
        match self {
            Self::Constant(plan) => plan.repetitions.saturating_mul(plan.levels.len() as u32),
            Self::QuestPlus(plan) => plan.stop.max_trials,
        }
    }

    /// The fewest trials that the block can have.
    #[must_use]
    pub fn min_trials(&self) -> u32 {
        match self {
            Self::Constant(_) => self.max_trials(),
            Self::QuestPlus(plan) if plan.stop.has_posterior_rule() => plan.stop.min_trials,
            Self::QuestPlus(plan) => plan.stop.max_trials,
        }
    }

    /// Whether levels depend on the answers; then every cell of the design has a procedure of its own.
    #[must_use]
    pub fn is_adaptive(&self) -> bool {
        !matches!(self, Self::Constant(_))
    }
}

/// Which renderer parameters QUEST+ over the MAR model sets.
#[derive(Debug, Clone, PartialEq)]
pub struct MarAxes {
    /// The parameter that is the eccentricity, in degrees.
    pub eccentricity: String,
    /// The parameter that is omega, in degrees per cycle.
    pub mar: String,
}

impl Default for MarAxes {
    fn default() -> Self {
        Self { eccentricity: "eccentricity_deg".to_owned(), mar: "mar_deg".to_owned() }
    }
}

/// Constant stimuli.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantPlan {
    /// The levels, each shown `repetitions` times.
    pub levels: Vec<Level>,
    /// Times each level is shown.
    pub repetitions: u32,
}

/// QUEST+ over the MAR model (Watson 2017; the model is [`crate::mar::MarModel`]).
#[derive(Debug, Clone, PartialEq)]
pub struct QuestPlusPlan {
    /// The stimuli: eccentricity × omega, without those finer than the display can show.
    pub levels: Vec<Level>,
    /// How many eccentricity × omega pairs were left out because the display cannot show them.
    pub levels_beyond_display: usize,
    /// Where eccentricity and omega are set.
    pub axes: MarAxes,
    /// Whether every eccentricity comes equally often, in shuffled rounds, so that the line can be held against the
    /// thresholds; else the procedure asks wherever it learns most about the line, which is at its two ends.
    pub balanced: bool,
    /// Prior values of m, uniform.
    pub m: Vec<f64>,
    /// Prior values of omega0 in degrees per cycle, uniform.
    pub omega0_deg: Vec<f64>,
    /// Prior values of the width in ln omega, uniform.
    pub width: Vec<f64>,
    /// Prior values of the lapse rate, uniform.
    pub lapse: Vec<f64>,
    /// When to stop.
    pub stop: StopRule,
}

/// When an adaptive block ends: at `max_trials`, or as soon as `min_trials` are done and every posterior rule holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopRule {
    /// The block never has more completed trials.
    pub max_trials: u32,
    /// The posterior rules are not asked before.
    pub min_trials: u32,
    /// Posterior SD of m divided by its mean, at most.
    pub m_relative_sd: Option<f64>,
    /// Posterior SD of omega0 divided by its mean, at most.
    pub omega0_relative_sd: Option<f64>,
}

impl StopRule {
    /// Whether the block can end before `max_trials`.
    #[must_use]
    pub fn has_posterior_rule(&self) -> bool {
        self.m_relative_sd.is_some() || self.omega0_relative_sd.is_some()
    }
}
