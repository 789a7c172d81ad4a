//! The population's change between two conditions: the hierarchical fit in seven coordinates.

use super::super::hierarchical::sampler::{Observer, Population};
use super::super::hierarchical::{Diagnostics, GroupEstimate, draws, estimate, group_estimate, settled_chains};
use super::super::posterior::Posterior;
use super::super::{Estimate, unpooled};
use super::{ByObserver, Change, Condition, ConditionsConfig, change_of_pairs, single_config};
use nalgebra::SVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The population's lines in two conditions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairedContrast {
    /// The condition.
    pub condition: String,
    /// What it is held against.
    pub reference: String,
    /// Observers that saw either.
    pub observers: Vec<String>,
    /// How many of them saw both.
    pub observers_in_both: usize,
    /// The median observer's slopes.
    pub m: Change,
    /// The median observer's MARs at the fovea.
    pub omega0: Change,
    /// The median observer's widths.
    pub width: Change,
    /// The ratio of m's over observers: population median (as in `m.ratio`), SD of its logarithm, a new observer's ratio.
    pub m_ratio: GroupEstimate,
    /// Each observer's own ratio of m's within the group, in the order of `observers`.
    pub observers_m_ratio: Vec<Estimate>,
    /// Whether the chains agree.
    pub diagnostics: Diagnostics,
}

/// The hierarchical contrast of condition `index` against the first; `None` if nobody saw either.
pub(super) fn paired(
    conditions: &[Condition],
    index: usize,
    seen: &ByObserver<'_>,
    config: &ConditionsConfig,
) -> Option<PairedContrast> {
    let of_two = |condition: usize| condition == 0 || condition == index;
    let group: Vec<_> = seen.iter().filter(|(_, parts)| parts.iter().any(|part| of_two(part.condition))).collect();
    if group.is_empty() {
        return None;
    }
    let prepared: Vec<(Observer<'_>, SVector<f64, 7>)> = group
        .par_iter()
        .map(|(_, parts)| {
            let parts: Vec<_> = parts.iter().filter(|part| of_two(part.condition)).collect();
            let fits: Vec<_> = parts
                .iter()
                .map(|part| {
                    let mut single = single_config(config, part.given, config.hierarchical.seed);
                    single.draws = 1024;
                    let offset = if part.condition == 0 { -0.5 } else { 0.5 };
                    (Posterior::new(&part.data, &single), offset, unpooled(&part.data, &single).start)
                })
                .collect();
            let mut start = SVector::<f64, 7>::zeros();
            let n = fits.len() as f64;
            for (_, offset, at) in &fits {
                for axis in 0..3 {
                    start[axis] += at[axis] / n;
                    if fits.len() > 1 {
                        start[3 + axis] += 2.0 * offset * at[axis];
                    }
                }
                start[6] += at[3] / n;
            }
            (Observer { conditions: fits.into_iter().map(|(target, offset, _)| (target, offset)).collect() }, start)
        })
        .collect();
    let (observers, starts): (Vec<Observer<'_>>, Vec<SVector<f64, 7>>) = prepared.into_iter().unzip();

    let base = &config.hierarchical;
    let priors = [base.priors.m, base.priors.omega0, base.priors.width];
    let mut population = Population {
        center: SVector::<f64, 7>::zeros(),
        spread: SVector::repeat(1.0),
        sd_scale: SVector::repeat(1.0),
        sd_df: base.priors.sd_df,
    };
    for (axis, prior) in priors.iter().enumerate() {
        population.center[axis] = prior.median.ln();
        population.spread[axis] = prior.sd_ln;
        population.sd_scale[axis] = base.priors.sd_scale[axis];
        population.spread[3 + axis] = config.difference_spread[axis];
        population.sd_scale[3 + axis] = config.difference_sd_scale[axis];
    }
    let seed = base.seed.wrapping_add(1000 * index as u64);
    let (chains, diagnostics) = settled_chains(&observers, &population, &starts, base, seed);

    let change = |axis: usize| {
        let pairs: Vec<(f64, f64)> = draws(&chains)
            .map(|(chain, i)| {
                let (middle, half) = (chain.mean[i][axis], 0.5 * chain.mean[i][3 + axis]);
                ((middle + half).exp(), (middle - half).exp())
            })
            .collect();
        change_of_pairs(&pairs)
    };
    Some(PairedContrast {
        condition: conditions[index].name.clone(),
        reference: conditions[0].name.clone(),
        observers: group.iter().map(|(id, _)| id.clone()).collect(),
        observers_in_both: group
            .iter()
            .filter(|(_, parts)| parts.iter().filter(|part| of_two(part.condition)).count() == 2)
            .count(),
        m: change(0),
        omega0: change(1),
        width: change(2),
        m_ratio: group_estimate(&chains, 3, seed),
        observers_m_ratio: (0..observers.len())
            .map(|who| estimate(draws(&chains).map(|(chain, i)| chain.observers[i][who][3].exp())))
            .collect(),
        diagnostics,
    })
}
