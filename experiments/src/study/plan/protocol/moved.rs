//! Protocols that move a parameter of the renderer within a trial: ramp, slider, adjustment.

use super::OnGazeLeft;
use schemars::JsonSchema;
use serde::Deserialize;

/// Which way a parameter makes the picture finer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Finer {
    /// Larger values are finer, as with Guenter's quality index.
    #[default]
    Up,
    /// Smaller values are finer, as with a MAR slope.
    Down,
}

/// Timing and texts of the ramp test (Guenter 2012, §5).
#[derive(Debug, Clone, PartialEq)]
pub struct RampPlan {
    /// The renderer parameter that is ramped; its other end, j1, is what the level says.
    pub parameter: String,
    /// The end that is the same in every trial, the reference quality j0.
    pub from: f64,
    /// Which way the parameter makes the picture finer.
    pub finer: Finer,
    /// Steps, both ends included; at least two.
    pub steps: u32,
    /// Each step, seconds.
    pub step_s: f64,
    /// Black between steps, seconds.
    pub black_s: f64,
    /// How long an answer is waited for, seconds; without it, for ever.
    pub answer_timeout_s: Option<f64>,
    /// The question.
    pub question: String,
    /// What follows when gaze leaves the gate: not [`OnGazeLeft::Hide`].
    pub on_gaze_left: OnGazeLeft,
}

/// Timing and values of the slider test (Guenter 2012, §5).
#[derive(Debug, Clone, PartialEq)]
pub struct SliderPlan {
    /// The renderer parameter that the observer moves.
    pub parameter: String,
    /// Its values from the lowest quality up; at least two.
    pub values: Vec<f64>,
    /// The first showing of the reference, seconds.
    pub reference_s: f64,
    /// How long a comparison shows the reference, seconds; without it, until a key.
    pub compare_s: Option<f64>,
    /// After so many moves the value stays where it is; without it, moving is free.
    pub most_moves: Option<u32>,
}

/// The method of adjustment with several parameters (Stengel 2016, §6.1).
#[derive(Debug, Clone, PartialEq)]
pub struct AdjustmentPlan {
    /// What is adjusted; at most nine, one for each digit.
    pub parameters: Vec<Adjusted>,
    /// After so many moves the values stay where they are; without it, moving is free.
    pub most_moves: Option<u32>,
}

/// A parameter that the observer adjusts.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjusted {
    /// The renderer parameter.
    pub parameter: String,
    /// The smallest value, in the parameter's unit.
    pub min: f64,
    /// The largest value.
    pub max: f64,
    /// What one move does.
    pub step: AdjustmentStep,
}

impl Adjusted {
    /// Where the adjustment starts if the level says nothing: the arithmetic middle of the range for sums, the geometric
    /// one for ratios.
    #[must_use]
    pub fn middle(&self) -> f64 {
        match self.step {
            AdjustmentStep::Add(_) => 0.5 * (self.min + self.max),
            AdjustmentStep::Multiply(_) => (self.min * self.max).sqrt(),
        }
    }

    /// The value one move up or down from `value`, kept within the range. What comes within a billionth of the range to an
    /// end is that end, so that rounding leaves no sliver of a step.
    #[must_use]
    pub fn moved(&self, value: f64, up: bool) -> f64 {
        let moved = match self.step {
            AdjustmentStep::Add(step) => value + if up { step } else { -step },
            AdjustmentStep::Multiply(factor) => value * if up { factor } else { 1.0 / factor },
        };
        let sliver = 1e-9 * (self.max - self.min);
        if moved >= self.max - sliver {
            self.max
        } else if moved <= self.min + sliver {
            self.min
        } else {
            moved
        }
    }
}

/// What one move of an adjustment does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AdjustmentStep {
    /// Adds or subtracts this, above 0.
    Add(f64),
    /// Multiplies or divides by this, above 1; the range is then above 0.
    Multiply(f64),
}
