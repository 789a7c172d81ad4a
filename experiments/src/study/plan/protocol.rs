//! How a trial asks: one plan for each protocol.

use crate::trial::Alternative;

/// How a trial asks.
#[derive(Debug, Clone, PartialEq)]
pub enum ProtocolPlan {
    /// Two intervals, one of them degraded; "which one was it?".
    TwoInterval(TwoIntervalPlan),
}

impl ProtocolPlan {
    /// Whether it matters which of reference and test comes first.
    #[must_use]
    pub fn alternatives_matter(&self) -> bool {
        match self {
            Self::TwoInterval(_) => true,
        }
    }

    /// Whether answers are right or wrong, so that shares can be counted and adaptive procedures learn.
    #[must_use]
    pub fn has_right_answers(&self) -> bool {
        match self {
            Self::TwoInterval(_) => true,
        }
    }

    /// How long stimuli are shown, to be shortened in a pilot run.
    pub(crate) fn stimulus_durations_mut(&mut self) -> Vec<&mut f64> {
        match self {
            Self::TwoInterval(plan) => vec![&mut plan.interval_s],
        }
    }

    /// How long one trial takes, in seconds, if every answer comes after `answer_s`.
    #[must_use]
    pub fn trial_s(&self, answer_s: f64) -> f64 {
        match self {
            Self::TwoInterval(plan) => plan.fixation_s + 2.0 * plan.interval_s + plan.gap_s + answer_s,
        }
    }
}

/// Which of two pictures a forced choice asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// The degraded one.
    Degraded,
    /// The full-resolution reference.
    Reference,
}

impl Wanted {
    /// Whether this picture is the one that is asked for.
    #[must_use]
    pub fn is(self, alternative: Alternative) -> bool {
        match self {
            Self::Degraded => alternative == Alternative::Test,
            Self::Reference => alternative == Alternative::Reference,
        }
    }
}

/// Timing and texts of the two-interval 2AFC.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoIntervalPlan {
    /// Fixation before the first interval, seconds.
    pub fixation_s: f64,
    /// Each interval, seconds.
    pub interval_s: f64,
    /// Grey between the intervals, seconds.
    pub gap_s: f64,
    /// How long an answer is waited for, seconds; without it, for ever.
    pub answer_timeout_s: Option<f64>,
    /// The question.
    pub question: String,
    /// Which picture the question asks for.
    pub wanted: Wanted,
}
