//! When an adaptive procedure ends, as a study writes it.

use schemars::JsonSchema;
use serde::Deserialize;

/// A rule for the end: one of `trials`, `reversals`, `quantity` (with `sd` or `relative_sd`), `all` or `any`.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopDraft {
    /// So many completed trials.
    #[schemars(range(min = 1, max = 100000))]
    pub trials: Option<u32>,
    /// So many reversals of a staircase.
    #[schemars(range(min = 1, max = 100000))]
    pub reversals: Option<u32>,
    /// A quantity that the procedure estimates is known well enough.
    pub quantity: Option<String>,
    /// Its standard deviation, at most.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub sd: Option<f64>,
    /// Its standard deviation divided by its mean, at most.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0))]
    pub relative_sd: Option<f64>,
    /// Every one of these rules holds.
    pub all: Option<Vec<Option<StopDraft>>>,
    /// At least one of these rules holds.
    pub any: Option<Vec<Option<StopDraft>>>,
}

/// When QUEST+ over the MAR model ends: at `max_trials`, or from `min_trials` on as soon as every precision that is given
/// holds. Or, in their place, one of the rules that every adaptive procedure takes.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MarStopDraft {
    /// The block never has more completed trials.
    #[schemars(range(min = 1, max = 100000))]
    pub max_trials: Option<u32>,
    /// The precisions are not asked before; a quarter of `max_trials` when absent.
    #[schemars(range(min = 1, max = 100000))]
    pub min_trials: Option<u32>,
    /// Posterior SD of m divided by its mean, at most.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0))]
    pub m_relative_sd: Option<f64>,
    /// Posterior SD of omega0 divided by its mean, at most.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0))]
    pub omega0_relative_sd: Option<f64>,
    /// So many completed trials.
    #[schemars(range(min = 1, max = 100000))]
    pub trials: Option<u32>,
    /// So many reversals of a staircase; QUEST+ has none.
    #[schemars(range(min = 1, max = 100000))]
    pub reversals: Option<u32>,
    /// A quantity that the procedure estimates is known well enough: `m`, `omega0_deg`, `width` or `lapse`.
    pub quantity: Option<String>,
    /// Its standard deviation, at most.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub sd: Option<f64>,
    /// Its standard deviation divided by its mean, at most.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0))]
    pub relative_sd: Option<f64>,
    /// Every one of these rules holds.
    pub all: Option<Vec<Option<StopDraft>>>,
    /// At least one of these rules holds.
    pub any: Option<Vec<Option<StopDraft>>>,
}

impl MarStopDraft {
    /// The part that every adaptive procedure takes.
    #[must_use]
    pub fn rule(&self) -> StopDraft {
        StopDraft {
            trials: self.trials,
            reversals: self.reversals,
            quantity: self.quantity.clone(),
            sd: self.sd,
            relative_sd: self.relative_sd,
            all: self.all.clone(),
            any: self.any.clone(),
        }
    }
}
