//! The estimates of one simulated observer: what `analyze` would print, as numbers with their truths.

use super::expected::Before;
use crate::results::mar_trial;
use analysis::answers::{Protocol, Row, Summary, summarise};
use analysis::mar::{MarFitConfig, fit_mar};
use analysis::power::{Quantity, Simulated};
use analysis::{MarTrial, mar};
use experiments::observers::{Simulation, Truth};
use experiments::session::record::TrialRecord;
use experiments::study::Plan;
use experiments::study::finest_mar_around;
use experiments::study::plan::BlockPlan;
use std::collections::BTreeMap;

/// Posterior evaluations of a MAR fit to a part of the trials: enough for a planning figure.
const DRAWS_OF_A_PART: usize = 1024;

/// One observer's answers.
pub(super) struct Observed<'a> {
    pub(super) simulation: &'a Simulation,
    /// Answered trials that are no practice, in order.
    pub(super) answered: &'a [TrialRecord],
}

/// Makes estimates for a study.
pub(super) struct Estimator<'a> {
    plan: &'a Plan,
    typical: &'a Simulation,
    config: MarFitConfig,
}

impl<'a> Estimator<'a> {
    pub(super) fn new(plan: &'a Plan, typical: &'a Simulation) -> Self {
        let mut eccentricities: Vec<f64> = plan
            .blocks
            .iter()
            .flat_map(|block| block.cells.iter().map(move |cell| (block, &cell.condition)))
            .flat_map(|(block, condition)| {
                block.procedure.levels().iter().filter_map(|level| condition.tested_at(level)[0])
            })
            .collect();
        eccentricities.sort_by(f64::total_cmp);
        eccentricities.dedup();
        let fixation = plan.gaze.fixation_deg;
        let finest_mar = eccentricities.iter().map(|&e| (e, finest_mar_around(&plan.display, fixation, e))).collect();
        Self { plan, typical, config: MarFitConfig { finest_mar, ..MarFitConfig::default() } }
    }

    /// The estimates after a share of the trials of every block.
    pub(super) fn estimates(&self, observed: &Observed<'_>, share: f64) -> Vec<Simulated> {
        let mut by_block: BTreeMap<&str, Vec<&TrialRecord>> = BTreeMap::new();
        for record in observed.answered {
            by_block.entry(&record.trial.block).or_default().push(record);
        }
        for records in by_block.values_mut() {
            records.truncate((share * records.len() as f64).ceil() as usize);
        }
        let mut estimates = self.mar_line(observed, &by_block, share);
        for block in self.plan.blocks.iter().filter(|block| !block.practice) {
            if let Some(records) = by_block.get(block.name.as_str()) {
                estimates.extend(self.of_block(observed, block, records));
            }
        }
        estimates
    }

    /// m and omega0, where trials test at an eccentricity.
    fn mar_line(
        &self,
        observed: &Observed<'_>,
        by_block: &BTreeMap<&str, Vec<&TrialRecord>>,
        share: f64,
    ) -> Vec<Simulated> {
        let trials: Vec<MarTrial> = by_block.values().flatten().filter_map(|record| mar_trial(record)).collect();
        if trials.is_empty() {
            return Vec::new();
        }
        let draws = if share < 1.0 { DRAWS_OF_A_PART } else { self.config.draws };
        let fit = fit_mar(&trials, &MarFitConfig { draws, ..self.config.clone() }).ok();
        let fit = fit.filter(|fit| fit.support.is_supported() || share < 1.0);
        let truth = match &observed.simulation.truth {
            Some(Truth::Mar(model)) => [Some(model.m), Some(model.omega0_deg)],
            _ => [None, None],
        };
        let value = |of: fn(&mar::MarFit) -> mar::Estimate| fit.as_ref().map(of);
        [("m", value(|fit| fit.m), truth[0]), ("omega0_deg", value(|fit| fit.omega0), truth[1])]
            .into_iter()
            .map(|(quantity, estimate, truth)| {
                let simulated = blank(quantity, trials.len(), truth);
                match estimate {
                    Some(estimate) => simulated.with_fit(estimate),
                    None => simulated,
                }
            })
            .collect()
    }

    /// What a block's answers give by themselves.
    fn of_block(&self, observed: &Observed<'_>, block: &BlockPlan, records: &[&TrialRecord]) -> Vec<Simulated> {
        // Trials on a ring are the line's.
        if records.iter().any(|record| record.trial.mar_deg.is_some()) {
            return Vec::new();
        }
        let protocol = Protocol::named(block.protocol.kind());
        let rows: Vec<Row> = records.iter().filter_map(|record| Row::of_record(record)).collect();
        let summary = summarise(&self.plan.name, &block.name, protocol, &rows);
        let before =
            observed.simulation.truth.as_ref().map(|t| Before::new(self.plan, block, t, &observed.simulation.options));
        let named =
            |what: &str| if self.plan.blocks.len() > 1 { format!("{} {what}", block.name) } else { what.to_owned() };
        let mut estimates = Vec::new();
        match &summary.summary {
            Summary::Detection(detection) => {
                if let (Some(parameter), Some(part), Some(protocol)) =
                    (detection.parameter(), detection.parts.first(), protocol)
                {
                    let truth = before.and_then(|before| before.threshold(protocol, parameter));
                    let simulated = blank(&named(&format!("threshold of {parameter}")), rows.len(), truth);
                    // A pair test has a third answer, and a fit that uses it.
                    let supported = match &part.comparison {
                        Some(fit) => fit.support.is_supported().then_some(fit.threshold),
                        None => part.fit.as_ref().and_then(|fit| fit.support.is_supported().then_some(fit.threshold)),
                    };
                    estimates.push(match supported {
                        Some(threshold) => simulated.with_fit(threshold),
                        None => simulated,
                    });
                    if matches!(protocol, Protocol::Pair | Protocol::Ramp) {
                        let rule = blank(&named(&format!("{parameter} by Guenter's rule")), rows.len(), truth);
                        estimates.push(Simulated { estimate: part.coarsest_unnoticed, ..rule });
                    }
                } else if let Some(part) = detection.parts.first() {
                    let simulated = blank(&named("share of right answers"), rows.len(), None);
                    estimates.push(Simulated {
                        estimate: Some(part.right.share),
                        ci95: Some(part.right.wilson95),
                        ..simulated
                    });
                }
            }
            Summary::Matches(matches) => {
                let settings = matches.parts.first().into_iter().flat_map(|part| &part.quantities);
                for quantity in settings.filter(|quantity| quantity.is_setting()) {
                    let truth = match protocol {
                        Some(Protocol::Slider) => before.and_then(|before| before.half_visible(&quantity.quantity)),
                        _ => None,
                    };
                    let simulated = blank(&named(&format!("{} as set", quantity.quantity)), rows.len(), truth);
                    estimates.push(Simulated {
                        estimate: Some(quantity.mean.mean),
                        ci95: quantity.mean.ci95,
                        ..simulated
                    });
                }
            }
            Summary::Ratings(ratings) => {
                for item in ratings.parts.first().into_iter().flat_map(|part| &part.items) {
                    let simulated = blank(&named(&format!("mean rating of {}", item.item)), rows.len(), None);
                    estimates.push(Simulated { estimate: Some(item.mean.mean), ci95: item.mean.ci95, ..simulated });
                }
            }
            Summary::Tasks(tasks) => {
                if let Some(part) = tasks.parts.first() {
                    let truth = before.and_then(|before| before.share_recognised());
                    let simulated = blank(&named("share recognised"), rows.len(), truth);
                    estimates.push(Simulated {
                        estimate: Some(part.recognised.share),
                        ci95: Some(part.recognised.wilson95),
                        ..simulated
                    });
                }
            }
            Summary::Nothing { .. } => {}
        }
        estimates
    }

    /// What is known of a quantity that [`Estimator::estimates`] has named.
    pub(super) fn quantity(&self, name: &str) -> Quantity {
        let model = match &self.typical.truth {
            Some(Truth::Mar(model)) => Some(model),
            _ => None,
        };
        let (label, unit, logarithmic, truth) = match name {
            "m" => ("slope m of the MAR line".to_owned(), "°/cycle/°", true, model.map(|model| model.m)),
            "omega0_deg" => ("foveal MAR omega0".to_owned(), "°/cycle", true, model.map(|model| model.omega0_deg)),
            other => (other.to_owned(), "", false, self.typical_truth(other)),
        };
        Quantity { name: name.to_owned(), label, unit: unit.to_owned(), logarithmic, truth }
    }

    /// The typical observer's truth for a quantity of a block.
    fn typical_truth(&self, name: &str) -> Option<f64> {
        let truth = self.typical.truth.as_ref()?;
        self.plan.blocks.iter().filter(|block| !block.practice).find_map(|block| {
            let own = if self.plan.blocks.len() > 1 { name.strip_prefix(&format!("{} ", block.name))? } else { name };
            let before = Before::new(self.plan, block, truth, &self.typical.options);
            let protocol = Protocol::named(block.protocol.kind())?;
            if let Some(parameter) = own.strip_prefix("threshold of ") {
                before.threshold(protocol, parameter)
            } else if let Some(parameter) = own.strip_suffix(" by Guenter's rule") {
                before.threshold(protocol, parameter)
            } else if let Some(parameter) = own.strip_suffix(" as set") {
                (protocol == Protocol::Slider).then(|| before.half_visible(parameter)).flatten()
            } else if own == "share recognised" {
                before.share_recognised()
            } else {
                None
            }
        })
    }
}

/// A quantity without an estimate.
fn blank(quantity: &str, trials: usize, truth: Option<f64>) -> Simulated {
    Simulated {
        repeat: 0,
        observer: 0,
        quantity: quantity.to_owned(),
        share: 0.0,
        trials,
        estimate: None,
        ci95: None,
        truth,
    }
}
