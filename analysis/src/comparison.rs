//! Comparisons with a third answer, "the same": the threshold of a pair test from all three answers at once.
//!
//! The reference is compared with a test whose visibility is F. Two looks differ by δ with ½ + ½F = Φ(δ/√2), so that a
//! forced choice would be right with ½ + ½F; here the difference, normal around d = δ/√2, has to pass a zone of
//! indifference on either side: "reference better" Φ(d − z), "test better" Φ(−d − z), "the same" in between. Lapses λ
//! take any of the three. F is a cumulative Gaussian of the level; its ½ is the threshold, which is what a forced choice
//! would measure too, whatever the observer's zone.
//!
//! The share of "reference better" alone cannot tell a wide zone from a high threshold; the share of "test better" can.
//! Model of ties: Thurstone's comparative judgment with a zone of indifference (Glenn & David 1960).

use crate::mar::{Estimate, Support};
use crate::numerics::normal_cdf_pair;
use crate::psychometric::{Direction, Scale};
use experiments::mar::WIDTH_SCALE;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Points of the grid.
const THRESHOLDS: usize = 61;
const WIDTHS: usize = 25;
const ZONES: usize = 21;
/// Lapse rates of the grid.
const LAPSES: [f64; 5] = [0.005, 0.02, 0.045, 0.08, 0.15];
/// SD of the zone's half-normal prior.
const ZONE_SD: f64 = 0.7;
/// The widest zone, in standard deviations of a difference.
const WIDEST_ZONE: f64 = 2.5;
/// d beyond which every difference is seen.
const LARGEST_D: f64 = 7.0;
/// The 95 % point of χ² with one degree of freedom.
const CHI_SQUARE_1_95: f64 = 3.841_458_820_694_124;

/// The answers at one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// The level, in its parameter's unit.
    pub level: f64,
    /// The reference was called better.
    pub reference: u32,
    /// Both were called the same.
    pub same: u32,
    /// The test was called better.
    pub test: u32,
}

impl Compared {
    fn n(&self) -> u32 {
        self.reference + self.same + self.test
    }
}

/// What three answers say about the threshold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComparisonFit {
    /// The level at which F is ½: posterior median and 95 % interval.
    pub threshold: Estimate,
    /// From 5 % to 95 % of F, in units of the level, or of its natural logarithm on a logarithmic axis.
    pub width: Estimate,
    /// The zone of indifference, in standard deviations of a difference.
    pub zone: Estimate,
    /// The axis.
    pub scale: Scale,
    /// Whether visibility grows or falls with the level.
    pub direction: Direction,
    /// The data.
    pub counts: Vec<Compared>,
    /// Whether the data carry the fit.
    pub support: Support,
}

/// Fits the threshold. Nothing for fewer than three levels with answers, or levels that do not fit the axis.
///
/// The posterior is summed on a grid. Priors: threshold flat over the range R of levels, falling to 0 as a raised cosine
/// over R/2 on either side; ln width flat from the smallest step to R; zone half-normal with SD 0.7; λ Beta(1, 10).
#[must_use]
pub fn fit_comparison(counts: &[Compared], scale: Scale, direction: Direction) -> Option<ComparisonFit> {
    let counts: Vec<Compared> = counts.iter().copied().filter(|count| count.n() > 0).collect();
    let sign = if direction == Direction::Rises { 1.0 } else { -1.0 };
    let mut places: Vec<f64> = counts.iter().map(|count| sign * scale.coordinate(count.level)).collect();
    if places.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let xs = places.clone();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let (first, last) = (*places.first()?, *places.last()?);
    let step = places.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let range = last - first;
    if places.len() < 3 {
        return None;
    }

    // Axes of the grid.
    let along = |low: f64, high: f64, n: usize| -> Vec<f64> {
        (0..n).map(|i| low + (high - low) * i as f64 / (n - 1) as f64).collect()
    };
    let thresholds = along(first - 0.5 * range, last + 0.5 * range, THRESHOLDS);
    let ln_widths = along(step.ln(), range.ln(), WIDTHS);
    let zones = along(0.0, WIDEST_ZONE, ZONES);
    let ln_threshold_prior = |t: f64| {
        let beyond = ((first - t).max(t - last).max(0.0) / (0.5 * range)).min(1.0);
        (0.5 + 0.5 * (PI * beyond).cos()).max(1e-12).ln()
    };

    let table = Table::new(&zones);
    let mut ln_posterior = vec![0.0; THRESHOLDS * WIDTHS * ZONES];
    let mut largest = f64::NEG_INFINITY;
    for (i, &threshold) in thresholds.iter().enumerate() {
        for (j, &ln_width) in ln_widths.iter().enumerate() {
            let seen = |x: &f64| normal_cdf_pair(WIDTH_SCALE * (x - threshold) / ln_width.exp()).0;
            let bins: Vec<usize> = xs.iter().map(|x| Table::bin(d_of(seen(x)))).collect();
            for (k, &zone) in zones.iter().enumerate() {
                let of_lapses = (0..LAPSES.len()).map(|lapse| {
                    let likelihood: f64 =
                        counts.iter().zip(&bins).map(|(count, &bin)| table.ln_of(count, bin, k, lapse)).sum();
                    likelihood + 9.0 * (1.0 - LAPSES[lapse]).ln()
                });
                let value = ln_sum(of_lapses) + ln_threshold_prior(threshold) - 0.5 * (zone / ZONE_SD).powi(2);
                ln_posterior[(i * WIDTHS + j) * ZONES + k] = value;
                largest = largest.max(value);
            }
        }
    }
    let weights: Vec<f64> = ln_posterior.iter().map(|value| (value - largest).exp()).collect();
    let marginal = |n: usize, index: &dyn Fn(usize) -> usize| -> Vec<f64> {
        let mut sums = vec![0.0; n];
        weights.iter().enumerate().for_each(|(at, weight)| sums[index(at)] += weight);
        sums
    };
    let threshold = summary(&thresholds, &marginal(THRESHOLDS, &|at| at / (WIDTHS * ZONES)));
    let ln_width = summary(&ln_widths, &marginal(WIDTHS, &|at| at / ZONES % WIDTHS));
    let zone = summary(&zones, &marginal(ZONES, &|at| at % ZONES));

    let level = |x: f64| scale.level(sign * x);
    let ends = if sign > 0.0 { threshold.ci95 } else { [threshold.ci95[1], threshold.ci95[0]] };
    let mut reasons = Vec::new();
    if !depends_on_level(&counts, &xs) {
        reasons.push("The answers do not depend on the level by more than chance would make them.".to_owned());
    }
    if !(first..=last).contains(&threshold.estimate) {
        reasons.push("The threshold lies outside the levels that were shown: it is extrapolated.".to_owned());
    }
    Some(ComparisonFit {
        threshold: Estimate { estimate: level(threshold.estimate), ci95: ends.map(level) },
        width: Estimate { estimate: ln_width.estimate.exp(), ci95: ln_width.ci95.map(f64::exp) },
        zone,
        scale,
        direction,
        counts,
        support: if reasons.is_empty() { Support::Supported } else { Support::Unsupported { reasons } },
    })
}

/// d = δ/√2 of a visibility: ½ + ½F = Φ(d).
fn d_of(seen: f64) -> f64 {
    if seen > 1.0 - 1e-12 { LARGEST_D } else { crate::numerics::normal_quantile(0.5 + 0.5 * seen).min(LARGEST_D) }
}

/// Logarithms of the three shares for every d, zone and lapse rate: a fit asks for them a million times.
struct Table(Vec<[f64; 3]>);

/// Steps of d.
const BINS: usize = 350;

impl Table {
    fn new(zones: &[f64]) -> Self {
        let mut entries = Vec::with_capacity((BINS + 1) * zones.len() * LAPSES.len());
        for bin in 0..=BINS {
            let d = LARGEST_D * bin as f64 / BINS as f64;
            for zone in zones {
                let (reference, test) = (normal_cdf_pair(d - zone).0, normal_cdf_pair(-d - zone).0);
                entries.extend(LAPSES.iter().map(|lapse| {
                    let (attentive, random) = (1.0 - 2.0 * lapse, 2.0 * lapse / 3.0);
                    let [reference, test] = [reference, test].map(|share| attentive * share + random);
                    [reference, 1.0 - reference - test, test].map(|share| share.max(1e-300).ln())
                }));
            }
        }
        Self(entries)
    }

    fn bin(d: f64) -> usize {
        ((d / LARGEST_D * BINS as f64).round() as usize).min(BINS)
    }

    fn ln_of(&self, count: &Compared, bin: usize, zone: usize, lapse: usize) -> f64 {
        let [reference, same, test] = self.0[(bin * ZONES + zone) * LAPSES.len() + lapse];
        f64::from(count.reference) * reference + f64::from(count.same) * same + f64::from(count.test) * test
    }
}

fn ln_sum(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = values.clone().fold(f64::NEG_INFINITY, f64::max);
    largest + values.map(|value| (value - largest).exp()).sum::<f64>().ln()
}

/// Median and central 95 % of a marginal on an even grid; each point stands for the stretch around it.
fn summary(at: &[f64], weights: &[f64]) -> Estimate {
    let sum: f64 = weights.iter().sum();
    let half = 0.5 * (at[1] - at[0]);
    let quantile = |p: f64| {
        let mut below = 0.0;
        for (x, weight) in at.iter().zip(weights) {
            let share = weight / sum;
            if below + share >= p && share > 0.0 {
                return x - half + 2.0 * half * (p - below) / share;
            }
            below += share;
        }
        at[at.len() - 1] + half
    };
    Estimate { estimate: quantile(0.5), ci95: [quantile(0.025).max(at[0]), quantile(0.975).min(at[at.len() - 1])] }
}

/// Whether "reference better" follows the level: the score test of a slope in a logistic regression (Cochran 1954,
/// Armitage 1955).
fn depends_on_level(counts: &[Compared], xs: &[f64]) -> bool {
    let n: f64 = counts.iter().map(|count| f64::from(count.n())).sum();
    let share = counts.iter().map(|count| f64::from(count.reference)).sum::<f64>() / n;
    let mean = counts.iter().zip(xs).map(|(count, x)| f64::from(count.n()) * x).sum::<f64>() / n;
    let score: f64 = counts
        .iter()
        .zip(xs)
        .map(|(count, x)| (f64::from(count.reference) - share * f64::from(count.n())) * (x - mean))
        .sum();
    let spread: f64 = counts.iter().zip(xs).map(|(count, x)| f64::from(count.n()) * (x - mean).powi(2)).sum();
    score * score / (share * (1.0 - share) * spread).max(1e-300) > CHI_SQUARE_1_95
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// The pair test of Guenter 2012: quality indices 8 to 22, each in two orders, by observers of a known threshold.
    fn simulated(threshold: f64, width: f64, zone: f64, each: u32, seed: u64) -> Vec<Compared> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (8..=22)
            .map(|j| {
                let level = f64::from(j);
                let d = d_of(normal_cdf_pair(WIDTH_SCALE * (threshold - level) / width).0);
                let mut count = Compared { level, reference: 0, same: 0, test: 0 };
                for _ in 0..each {
                    let u: f64 = rng.random();
                    let reference = normal_cdf_pair(d - zone).0;
                    let test = normal_cdf_pair(-d - zone).0;
                    if u < reference {
                        count.reference += 1;
                    } else if u < reference + test {
                        count.test += 1;
                    } else {
                        count.same += 1;
                    }
                }
                count
            })
            .collect()
    }

    #[test]
    fn thresholds_of_thirty_trials_are_unbiased_and_their_intervals_hold() {
        for (threshold, zone) in [(12.0, 0.4), (14.0, 0.674), (15.0, 1.2)] {
            let (mut sum, mut held, n) = (0.0, 0, 60);
            for seed in 0..n {
                let counts = simulated(threshold, 3.0, zone, 2, seed);
                let fit = fit_comparison(&counts, Scale::Linear, Direction::Falls).expect("levels");
                sum += fit.threshold.estimate;
                held += u32::from((fit.threshold.ci95[0]..=fit.threshold.ci95[1]).contains(&threshold));
            }
            let (mean, coverage) = (sum / n as f64, f64::from(held) / n as f64);
            println!("threshold {threshold}, zone {zone}: mean {mean:.3}, coverage {coverage:.3}");
            assert!((mean - threshold).abs() < 1.0, "more than one index step: {mean}");
            assert!((0.90..=1.0).contains(&coverage), "{coverage}");
        }
    }

    #[test]
    fn many_answers_find_threshold_width_and_zone() {
        let fit = fit_comparison(&simulated(13.0, 5.0, 0.8, 400, 3), Scale::Linear, Direction::Falls).expect("levels");
        println!("{:?} {:?} {:?}", fit.threshold, fit.width, fit.zone);
        assert!((fit.threshold.estimate - 13.0).abs() < 0.4);
        assert!((fit.width.estimate - 5.0).abs() < 1.0);
        assert!((fit.zone.estimate - 0.8).abs() < 0.1);
        assert!(fit.support.is_supported());
    }

    #[test]
    fn answers_that_ignore_the_level_support_nothing() {
        let counts: Vec<Compared> =
            (8..=22).map(|j| Compared { level: f64::from(j), reference: 1, same: 1, test: 1 }).collect();
        let fit = fit_comparison(&counts, Scale::Linear, Direction::Falls).expect("levels");
        assert!(!fit.support.is_supported());
        assert!(fit_comparison(&counts[..2], Scale::Linear, Direction::Falls).is_none());
    }
}
