//! The plan of each adaptive procedure.

use super::Stop;
use crate::procedures::tabulation::Shared;
use crate::study::plan::Level;
use schemars::JsonSchema;
use serde::Deserialize;

/// Where a procedure on one renderer parameter moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    parameter: String,
    fixed: Level,
    limits: [f64; 2],
    ends: [Level; 2],
}

impl Place {
    /// `parameter` moves within `limits` (the smaller first), everything in `fixed` stays.
    #[must_use]
    pub fn new(parameter: impl Into<String>, fixed: Level, limits: [f64; 2]) -> Self {
        let parameter = parameter.into();
        let ends = limits.map(|value| with(&fixed, &parameter, value));
        Self { parameter, fixed, limits, ends }
    }

    /// The renderer parameter that moves.
    #[must_use]
    pub fn parameter(&self) -> &str {
        &self.parameter
    }

    /// The smallest and the largest value.
    #[must_use]
    pub fn limits(&self) -> [f64; 2] {
        self.limits
    }

    /// The levels at the limits.
    #[must_use]
    pub fn ends(&self) -> &[Level] {
        &self.ends
    }

    /// A value put within the limits.
    #[must_use]
    pub fn clamped(&self, value: f64) -> f64 {
        value.max(self.limits[0]).min(self.limits[1])
    }

    /// The level with the parameter at a value, put within the limits.
    #[must_use]
    pub fn level(&self, value: f64) -> Level {
        with(&self.fixed, &self.parameter, self.clamped(value))
    }
}

fn with(fixed: &Level, parameter: &str, value: f64) -> Level {
    let mut level = fixed.clone();
    level.insert(parameter.to_owned(), value);
    level
}

/// Which way a parameter goes where the task gets harder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Harder {
    /// Smaller values are harder, as of a MAR: finer blur is harder to see.
    Down,
    /// Larger values are harder, as of a quality index.
    Up,
}

impl Harder {
    /// −1 where smaller values are harder, 1 where larger ones are.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Down => -1.0,
            Self::Up => 1.0,
        }
    }
}

/// What a step of a staircase is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StepType {
    /// A difference, in the parameter's unit.
    Linear,
    /// A factor, in log10 units.
    Log,
    /// A factor, in decibels of 20 log10.
    Db,
}

/// The axis on which a psychometric function has its shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The parameter itself.
    Linear,
    /// Its logarithm.
    Log,
}

/// A staircase: n-up-m-down (Levitt 1971), with unequal steps if wanted (Kaernbach 1991).
#[derive(Debug, Clone, PartialEq)]
pub struct StaircasePlan {
    /// Where it moves.
    pub place: Place,
    /// Which way is harder.
    pub harder: Harder,
    /// Where each of the interleaved tracks starts; at least one.
    pub start: Vec<f64>,
    /// Steps towards harder levels; the next one is taken at each reversal, the last one stays. At least one.
    pub steps: Vec<f64>,
    /// What the steps are.
    pub step_type: StepType,
    /// A step towards easier levels as a multiple of one towards harder levels.
    pub up_down_ratio: f64,
    /// Wrong answers in a row after which the level gets easier.
    pub n_up: u32,
    /// Right answers in a row after which the level gets harder.
    pub n_down: u32,
    /// Whether every answer moves the level until the first reversal.
    pub initial_rule: bool,
    /// How many of each track's last reversals make the estimate.
    pub estimate_reversals: u32,
    /// When each track ends.
    pub stop: Stop,
}

impl StaircasePlan {
    /// The fewest trials in which one track can have so many reversals.
    #[must_use]
    pub fn fewest_trials(&self, reversals: u32) -> u32 {
        if reversals == 0 {
            return 0;
        }
        let from = |first: u32, second: u32| {
            // A run that begins, then one run a reversal, the other way each time.
            let runs = |count: u32, cost: u32| count.saturating_mul(cost);
            if self.initial_rule {
                // One answer begins, one turns.
                let left = reversals - 1;
                2_u32.saturating_add(runs(left.div_ceil(2), first)).saturating_add(runs(left / 2, second))
            } else {
                runs(reversals / 2 + 1, first).saturating_add(runs(reversals.div_ceil(2), second))
            }
        };
        from(self.n_up, self.n_down).min(from(self.n_down, self.n_up))
    }
}

/// QUEST (Watson & Pelli 1983), with the tables of Pelli's program.
///
/// Intensities within are values of the parameter, or their log10, negated where larger values are harder.
#[derive(Debug, Clone, PartialEq)]
pub struct QuestPlan {
    /// Where it moves.
    pub place: Place,
    /// Which way is harder.
    pub harder: Harder,
    /// The axis on which the Weibull function has its shape.
    pub axis: Axis,
    /// The threshold that is expected, in the parameter's unit; the first trial's level.
    pub start: f64,
    /// Standard deviation of the normal prior around it: in the parameter's unit, or in log10 units on a log axis.
    pub start_sd: f64,
    /// The probability of a right answer at threshold.
    pub p_threshold: f64,
    /// Steepness β of the Weibull function.
    pub beta: f64,
    /// δ: the share of answers given blindly.
    pub delta: f64,
    /// γ: the probability of a right answer with nothing to be seen.
    pub gamma: f64,
    /// Spacing of the thresholds held possible, in the axis's unit.
    pub grain: f64,
    /// Extent of the thresholds held possible, around the start, in the axis's unit.
    pub range: f64,
    /// What the next level is.
    pub method: QuestMethod,
    /// When to stop.
    pub stop: Stop,
}

/// Which summary of QUEST's posterior is asked at next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum QuestMethod {
    /// The quantile that tells most (Pelli 1987).
    Quantile,
    /// The mean (King-Smith et al. 1994).
    Mean,
    /// The mode (Watson & Pelli 1983).
    Mode,
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
    pub stop: Stop,
    /// The likelihood tables, made at the first use and kept for all sessions of the plan.
    pub tables: Shared,
}

/// The shape of a psychometric function, by the names of Schütt et al. 2016.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Function {
    /// Φ, the cumulative normal.
    CumulativeGauss,
    /// The logistic function.
    Logistic,
    /// The Weibull function: a Gumbel function of the logarithm, so it needs a log axis.
    Weibull,
    /// The Gumbel function, 1 − exp(−exp(x)).
    Gumbel,
    /// The cumulative hyperbolic secant, (2/π) atan(exp(x)).
    HyperbolicSecant,
}

/// QUEST+ over a psychometric function (Watson 2017).
#[derive(Debug, Clone, PartialEq)]
pub struct FunctionPlan {
    /// The stimuli: every combination of the function's parameter and the covariate, with what is fixed.
    pub levels: Vec<Level>,
    /// How many were left out because the display cannot show them.
    pub levels_beyond_display: usize,
    /// The renderer parameter that the function reads.
    pub parameter: String,
    /// A second renderer parameter in which the threshold is linear: threshold + threshold_slope · covariate, in the unit of
    /// `parameter`.
    pub covariate: Option<String>,
    /// Which way is harder.
    pub harder: Harder,
    /// The function's shape.
    pub function: Function,
    /// The axis on which it has this shape.
    pub axis: Axis,
    /// Prior values of the threshold (half way up the unscaled function), uniform.
    pub threshold: Vec<f64>,
    /// Prior values of the threshold's slope over the covariate, uniform; a zero without a covariate.
    pub threshold_slope: Vec<f64>,
    /// Prior values of the width from 5 % to 95 % of the unscaled function, uniform: in the parameter's unit, or in
    /// natural-log units on a log axis.
    pub width: Vec<f64>,
    /// Prior values of the lapse rate, uniform.
    pub lapse: Vec<f64>,
    /// Prior values of the guess rate, uniform.
    pub guess: Vec<f64>,
    /// When to stop.
    pub stop: Stop,
    /// The likelihood tables, made at the first use and kept for all sessions of the plan.
    pub tables: Shared,
}

/// Psi (Kontsevich & Tyler 1999): the level that is expected to leave the least entropy over threshold × slope, with guess
/// and lapse rate fixed.
#[derive(Debug, Clone, PartialEq)]
pub struct PsiPlan {
    /// The stimuli.
    pub levels: Vec<Level>,
    /// How many were left out because the display cannot show them.
    pub levels_beyond_display: usize,
    /// The renderer parameter that the function reads.
    pub parameter: String,
    /// Which way is harder.
    pub harder: Harder,
    /// Cumulative Gauss Φ(s (x − t)) or logistic 1 / (1 + exp(−s (x − t))).
    pub function: Function,
    /// The axis on which it has this shape: the value, or its natural logarithm.
    pub axis: Axis,
    /// Prior values of the threshold t, uniform.
    pub threshold: Vec<f64>,
    /// Prior values of the slope s, uniform: per unit of the parameter, or per natural-log unit on a log axis.
    pub slope: Vec<f64>,
    /// The guess rate.
    pub guess: f64,
    /// The lapse rate.
    pub lapse: f64,
    /// When to stop.
    pub stop: Stop,
    /// The likelihood tables, made at the first use and kept for all sessions of the plan.
    pub tables: Shared,
}
