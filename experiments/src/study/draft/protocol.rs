//! How a trial asks, as a study writes it.

use schemars::JsonSchema;
use serde::Deserialize;

/// How a trial asks.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ProtocolDraft {
    /// Two intervals, one of them degraded; the observer says which.
    TwoInterval(TwoIntervalDraft),
}

impl ProtocolDraft {
    /// How long feedback is shown in practice, if the study says.
    pub(in crate::study) fn feedback_s(&self) -> Option<f64> {
        match self {
            Self::TwoInterval(draft) => draft.feedback_s,
        }
    }
}

/// Two intervals, one of them degraded; the observer says which.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwoIntervalDraft {
    /// Fixation before the first interval, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub fixation_s: Option<f64>,
    /// Each interval, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub interval_s: Option<f64>,
    /// Grey between the intervals, in seconds.
    #[schemars(required, range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub gap_s: Option<f64>,
    /// How long an answer is waited for, in seconds, before the trial is asked again later; for ever when absent.
    #[schemars(range(max = 3600.0), extend("exclusiveMinimum" = 0))]
    pub answer_timeout_s: Option<f64>,
    /// How long "right" or "wrong" is shown in practice, in seconds; 0.5 when absent.
    #[schemars(range(max = 600.0), extend("exclusiveMinimum" = 0))]
    pub feedback_s: Option<f64>,
    /// The question; "Which one was degraded: the first or the second?" when absent.
    #[schemars(length(min = 1))]
    pub question: Option<String>,
}
