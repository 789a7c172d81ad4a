//! Adaptive procedures on one renderer parameter, as a study writes them.

use super::StopDraft;
use crate::study::draft::NumberList;
use crate::study::plan::{Axis, Function, Harder, QuestMethod, StepType};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Renderer parameters that keep a value.
pub type FixedDraft = BTreeMap<String, Option<f64>>;

/// The smallest and the largest value of a parameter.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitsDraft {
    /// The smallest value.
    pub min: Option<f64>,
    /// The largest value.
    pub max: Option<f64>,
}

/// A number, or a list of them.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum OneOrMore {
    /// One.
    One(f64),
    /// Several.
    Several(NumberList),
}

/// Values: a list, or a range whose spacing follows the axis, equal differences on a linear one and equal ratios on a log
/// one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SpacedDraft {
    /// The values.
    List(NumberList),
    /// A range.
    Range(SpanDraft),
}

/// A range whose spacing follows the axis.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpanDraft {
    /// The smallest value.
    #[schemars(required)]
    pub min: Option<f64>,
    /// The largest value.
    #[schemars(required)]
    pub max: Option<f64>,
    /// How many, both ends included.
    #[schemars(required, range(min = 2, max = 1000))]
    pub steps: Option<u32>,
}

/// A staircase on one parameter: n-up-m-down (Levitt 1971), with unequal steps if wanted (Kaernbach 1991).
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaircaseDraft {
    /// The renderer parameter that moves.
    #[schemars(required)]
    pub parameter: Option<String>,
    /// Which way the task gets harder.
    #[schemars(required)]
    pub harder: Option<Harder>,
    /// Where it starts; a list makes as many interleaved tracks.
    #[schemars(required)]
    pub start: Option<OneOrMore>,
    /// Steps towards harder levels: the next one from each reversal on, the last one to the end.
    #[schemars(required)]
    pub steps: Option<NumberList>,
    /// What a step is: a difference (linear), a factor in log10 units (log), or a factor in decibels of 20 log10 (db).
    #[schemars(required)]
    pub step_type: Option<StepType>,
    /// A step towards easier levels as a multiple of one towards harder levels; 1 when absent. With n_up and n_down of 1 the
    /// staircase settles where the share of right answers is ratio / (1 + ratio).
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0))]
    pub up_down_ratio: Option<f64>,
    /// Wrong answers in a row after which the level gets easier; 1 when absent.
    #[schemars(range(min = 1, max = 100))]
    pub n_up: Option<u32>,
    /// Right answers in a row after which the level gets harder.
    #[schemars(required, range(min = 1, max = 100))]
    pub n_down: Option<u32>,
    /// Whether every answer moves the level until the first reversal; true when absent.
    pub initial_rule: Option<bool>,
    /// Levels beyond are put at the limit; the renderer's own bounds, and for a ring's MAR what the display can show, when
    /// absent.
    pub limits: Option<LimitsDraft>,
    /// Other renderer parameters of the level, which stay.
    pub fixed: Option<FixedDraft>,
    /// How many of each track's last reversals make the estimate; 6 when absent.
    #[schemars(range(min = 2, max = 1000))]
    pub estimate_reversals: Option<u32>,
    /// When each track ends.
    #[schemars(required)]
    pub stop: Option<StopDraft>,
}

/// QUEST (Watson & Pelli 1983) on one parameter.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QuestDraft {
    /// The renderer parameter that moves.
    #[schemars(required)]
    pub parameter: Option<String>,
    /// Which way the task gets harder.
    #[schemars(required)]
    pub harder: Option<Harder>,
    /// Whether the Weibull function has its shape over the parameter (linear) or over its log10 (log).
    #[schemars(required)]
    pub axis: Option<Axis>,
    /// The threshold that is expected, and the first level.
    #[schemars(required)]
    pub start: Option<f64>,
    /// Standard deviation of the prior around it: in the parameter's unit, or in log10 units on a log axis.
    #[schemars(required, extend("exclusiveMinimum" = 0, "x-unit" = "the axis's unit"))]
    pub start_sd: Option<f64>,
    /// The probability of a right answer at threshold; 0.82 when absent.
    #[schemars(range(max = 0.999), extend("exclusiveMinimum" = 0))]
    pub p_threshold: Option<f64>,
    /// Steepness β of the Weibull function; 3.5 when absent, which is for log10 units.
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0))]
    pub beta: Option<f64>,
    /// δ, the share of answers given blindly; 0.01 when absent.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub delta: Option<f64>,
    /// γ, the probability of a right answer with nothing to be seen; 0.5 when absent.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub gamma: Option<f64>,
    /// Spacing of the thresholds held possible; 0.01 when absent.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "the axis's unit"))]
    pub grain: Option<f64>,
    /// Extent of the thresholds held possible, around the start; 500 times the grain when absent.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "the axis's unit"))]
    pub range: Option<f64>,
    /// What is asked at next: the quantile of the posterior that tells most (when absent), its mean or its mode.
    pub method: Option<QuestMethod>,
    /// Levels beyond are put at the limit; the renderer's own bounds, and for a ring's MAR what the display can show, when
    /// absent.
    pub limits: Option<LimitsDraft>,
    /// Other renderer parameters of the level, which stay.
    pub fixed: Option<FixedDraft>,
    /// When the block ends.
    #[schemars(required)]
    pub stop: Option<StopDraft>,
}

/// QUEST+ (Watson 2017) over a psychometric function of one parameter, whose threshold may be linear in a second one.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FunctionDraft {
    /// The function's shape.
    #[schemars(required)]
    pub function: Option<Function>,
    /// Whether it has this shape over the parameter (linear) or over its logarithm (log).
    #[schemars(required)]
    pub axis: Option<Axis>,
    /// The renderer parameter that the function reads.
    #[schemars(required)]
    pub parameter: Option<String>,
    /// A second renderer parameter c: the threshold is threshold + threshold_slope · c, in the unit of `parameter`.
    pub covariate: Option<String>,
    /// Which way the task gets harder.
    #[schemars(required)]
    pub harder: Option<Harder>,
    /// Renderer parameter → the values it takes: `parameter`, and `covariate` if there is one. The levels are all
    /// combinations.
    #[schemars(required)]
    pub stimuli: Option<BTreeMap<String, Option<SpacedDraft>>>,
    /// Other renderer parameters of the level, which stay.
    pub fixed: Option<FixedDraft>,
    /// What is held possible before the first answer.
    #[schemars(required)]
    pub prior: Option<FunctionPriorDraft>,
    /// When the block ends.
    #[schemars(required)]
    pub stop: Option<StopDraft>,
}

/// What is held possible before the first answer: a grid, every point of it equally likely.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FunctionPriorDraft {
    /// The threshold, half way up the unscaled function.
    #[schemars(required)]
    pub threshold: Option<SpacedDraft>,
    /// How far the threshold rises with each unit of the covariate; needed where there is one.
    pub threshold_slope: Option<NumberList>,
    /// The width from 5 % to 95 % of the unscaled function: in the parameter's unit, or in natural-log units on a log axis.
    #[schemars(required)]
    pub width: Option<NumberList>,
    /// The lapse rate; 0.02 when absent.
    pub lapse: Option<NumberList>,
    /// The guess rate; 0.5 when absent.
    pub guess: Option<NumberList>,
}

/// Psi (Kontsevich & Tyler 1999): threshold and slope of a psychometric function of one parameter.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PsiDraft {
    /// The function's shape: cumulative-gauss, Φ(slope · (x − threshold)), when absent; or logistic.
    pub function: Option<Function>,
    /// Whether it has this shape over the parameter (linear) or over its natural logarithm (log).
    #[schemars(required)]
    pub axis: Option<Axis>,
    /// The renderer parameter that the function reads.
    #[schemars(required)]
    pub parameter: Option<String>,
    /// Which way the task gets harder.
    #[schemars(required)]
    pub harder: Option<Harder>,
    /// The values that are asked about.
    #[schemars(required)]
    pub values: Option<SpacedDraft>,
    /// Other renderer parameters of the level, which stay.
    pub fixed: Option<FixedDraft>,
    /// Thresholds held possible before the first answer, all equally likely.
    #[schemars(required)]
    pub threshold: Option<SpacedDraft>,
    /// Slopes held possible before the first answer, all equally likely: per unit of the axis. A range has equal ratios.
    #[schemars(required)]
    pub slope: Option<SpacedDraft>,
    /// The guess rate; 0.5 when absent.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub guess: Option<f64>,
    /// The lapse rate; 0.02 when absent.
    #[schemars(range(min = 0.0, max = 0.4))]
    pub lapse: Option<f64>,
    /// When the block ends.
    #[schemars(required)]
    pub stop: Option<StopDraft>,
}
