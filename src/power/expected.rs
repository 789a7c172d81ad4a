//! What a simulated observer's estimates would be with endless trials: the truth that each is held against.

use analysis::answers::Protocol;
use experiments::display::Display;
use experiments::observers::truth::View;
use experiments::observers::{Options, Truth};
use experiments::study::Plan;
use experiments::study::plan::{BlockPlan, Level, ProtocolPlan};

/// How far beyond the levels of a study a threshold is looked for, as a factor.
const BEYOND: f64 = 5.0;

/// An observer before a block of a study.
#[derive(Clone, Copy)]
pub(super) struct Before<'a> {
    pub(super) truth: &'a Truth,
    pub(super) options: &'a Options,
    pub(super) block: &'a BlockPlan,
    pub(super) display: &'a Display,
    pub(super) fixation_deg: [f64; 2],
}

impl<'a> Before<'a> {
    pub(super) fn new(plan: &'a Plan, block: &'a BlockPlan, truth: &'a Truth, options: &'a Options) -> Self {
        Self { truth, options, block, display: &plan.display, fixation_deg: plan.gaze.fixation_deg }
    }

    /// F of the block's first cell at a level.
    fn visibility(&self, level: &Level) -> Option<f64> {
        let view = View { display: self.display, fixation_deg: self.fixation_deg };
        self.truth.visibility(&self.block.cells.first()?.condition, level, view)
    }

    /// The probability of a right answer when the test's visibility is F.
    fn probability_right(&self, protocol: Protocol, visibility: f64) -> f64 {
        match protocol {
            Protocol::TwoInterval | Protocol::Toggle => self.options.probability_correct(visibility),
            Protocol::Ramp => {
                let reference = match &self.block.protocol {
                    ProtocolPlan::Ramp(plan) => {
                        self.visibility(&Level::from([(plan.parameter.clone(), plan.from)])).unwrap_or(0.0)
                    }
                    _ => 0.0,
                };
                self.options.direction_shares(visibility, reference)[0]
            }
            _ => self.options.probability_reference_better(visibility),
        }
    }

    /// The value of a parameter at which the probability of a right answer is half way between what it is where nothing
    /// can be seen and where everything can: what a psychometric function calls its threshold.
    pub(super) fn threshold(&self, protocol: Protocol, parameter: &str) -> Option<f64> {
        if protocol == Protocol::Pair {
            // Its fit allows for the zone of indifference, and so finds F itself.
            return self.half_visible(parameter);
        }
        let right = |visibility| self.probability_right(protocol, visibility);
        let halfway = 0.5 * (right(0.0) + right(1.0));
        self.crossing(parameter, |level| Some(right(self.visibility(level)?) - halfway))
    }

    /// The value of a parameter at which F is ½.
    pub(super) fn half_visible(&self, parameter: &str) -> Option<f64> {
        self.crossing(parameter, |level| Some(self.visibility(level)? - 0.5))
    }

    /// The probability that the reference is called better, over the block's levels.
    pub(super) fn share_recognised(&self) -> Option<f64> {
        let levels = self.block.procedure.levels();
        let shares: Vec<f64> = levels
            .iter()
            .map(|level| Some(self.options.probability_reference_better(self.visibility(level)?)))
            .collect::<Option<_>>()?;
        (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
    }

    /// Where a function of one parameter changes its sign, within reach of the block's levels.
    fn crossing(&self, parameter: &str, f: impl Fn(&Level) -> Option<f64>) -> Option<f64> {
        let shown: Vec<f64> = match &self.block.protocol {
            ProtocolPlan::Slider(plan) => plan.values.clone(),
            _ => self.block.procedure.levels().iter().filter_map(|level| level.get(parameter).copied()).collect(),
        };
        let (least, most) = shown.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        if !(least > 0.0 && most.is_finite()) {
            return None;
        }
        // What a level sets besides the parameter stays.
        let base = self.block.procedure.levels().first().cloned().unwrap_or_default();
        let at = |x: f64| {
            let mut level = base.clone();
            level.insert(parameter.to_owned(), x);
            f(&level)
        };
        let (mut low, mut high) = (least / BEYOND, most * BEYOND);
        let rises = at(high)? > at(low)?;
        let sign = |value: f64| if rises { value } else { -value };
        if sign(at(low)?) > 0.0 || sign(at(high)?) < 0.0 {
            return None;
        }
        for _ in 0..60 {
            let middle = (low * high).sqrt();
            if sign(at(middle)?) < 0.0 { low = middle } else { high = middle }
        }
        Some((low * high).sqrt())
    }
}
