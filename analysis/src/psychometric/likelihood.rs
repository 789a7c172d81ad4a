//! The likelihood of counts: independent answers, or beta-binomial blocks with overdispersion η.
//!
//! With r = η²/(1 − η²) = 1/v, a block's likelihood is Π_{j<k}(ψ + j r) · Π_{j<n−k}(1 − ψ + j r) / Π_{j<n}(1 + j r), which is
//! the binomial one at r = 0 and needs no gamma function for the counts of an experiment. Binomial coefficients are left
//! out everywhere.

use super::function::{Placed, coordinate};
use super::sigmoid::Shape;
use super::{Count, Overdispersion, PsychometricConfig};

/// Blocks with more answers than this together are summed by Stirling's series instead of multiplied out.
const MOST_FACTORS: u32 = 3000;
/// Below this probability the product of sixteen factors could underflow.
const SMALL: f64 = 1e-15;

/// Answers at one place of the axis.
#[derive(Debug, Clone, Copy)]
struct Cell {
    x: f64,
    right: u32,
    wrong: u32,
}

/// The likelihood of one data set.
#[derive(Debug, Clone)]
pub(super) struct Likelihood {
    config: PsychometricConfig,
    shape: Shape,
    /// Blocks first, then answers that are independent of each other.
    cells: Vec<Cell>,
    blocks: usize,
    /// Whether blocks are multiplied out.
    short: bool,
}

/// The terms of a beta-binomial likelihood that do not depend on ψ, for one η.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dispersion {
    r: f64,
    /// Σ ln Π_{j<n}(1 + j r) over blocks.
    ln_denominator: f64,
}

impl Likelihood {
    pub(super) fn new(counts: &[Count], config: &PsychometricConfig) -> Self {
        let cell =
            |count: &Count| Cell { x: coordinate(config, count.level), right: count.k, wrong: count.n - count.k };
        let (mut blocks, mut single) = (Vec::new(), Vec::new());
        for count in counts {
            // One answer has nothing to hang together with.
            if config.overdispersion == Overdispersion::Free && count.n > 1 {
                blocks.push(cell(count));
            } else {
                single.push(*count);
            }
        }
        let factors: u32 = blocks.iter().map(|cell| cell.right + cell.wrong).fold(0, u32::saturating_add);
        let mut cells = blocks;
        let blocks = cells.len();
        cells.extend(super::data::merged(&single).iter().map(cell));
        Self { config: *config, shape: Shape::new(config.sigmoid), cells, blocks, short: factors <= MOST_FACTORS }
    }

    /// (seen, missed) of every cell, into `seen`; threshold and width in the axis's coordinate.
    pub(super) fn fill_seen(&self, threshold: f64, width: f64, seen: &mut Vec<(f64, f64)>) {
        let placed = Placed::new(self.shape, &self.config, threshold, width);
        seen.clear();
        seen.extend(self.cells.iter().map(|cell| placed.value(cell.x)));
    }

    pub(super) fn dispersion(&self, eta: f64) -> Dispersion {
        let r = eta * eta / (1.0 - eta * eta);
        let ln_denominator =
            self.cells[..self.blocks].iter().map(|cell| ln_rising(1.0, r, cell.right + cell.wrong)).sum();
        Dispersion { r, ln_denominator }
    }

    /// The log likelihood at rates and each dispersion, given (seen, missed) of every cell.
    pub(super) fn ln_likelihoods(
        &self,
        seen: &[(f64, f64)],
        lapse: f64,
        guess: f64,
        dispersions: &[Dispersion],
        result: &mut [f64],
    ) {
        let rise = 1.0 - guess - lapse;
        if rise <= 0.0 {
            result.fill(f64::NEG_INFINITY);
            return;
        }
        let shares = |seen: &(f64, f64)| (guess + rise * seen.0, lapse + rise * seen.1);
        let independent: f64 = self.cells[self.blocks..]
            .iter()
            .zip(&seen[self.blocks..])
            .map(|(cell, seen)| ln_independent(cell, shares(seen)))
            .sum();
        let blocks = &self.cells[..self.blocks];
        if blocks.is_empty() {
            result.fill(independent);
            return;
        }
        let smallest = seen[..self.blocks].iter().map(shares).fold(1.0, |least: f64, (p, q)| least.min(p).min(q));
        if self.short && smallest > SMALL {
            // Eight at a time keep the processor's pipelines full; what is left over goes by twos and singly.
            let (eights, rest) = dispersions.as_chunks::<8>();
            let (twos, ones) = rest.as_chunks::<2>();
            let (of_eights, of_rest) = result.split_at_mut(8 * eights.len());
            let (of_twos, of_ones) = of_rest.split_at_mut(2 * twos.len());
            for (result, eight) in of_eights.as_chunks_mut::<8>().0.iter_mut().zip(eights) {
                *result = ln_products(blocks, seen, guess, lapse, eight);
            }
            for (result, two) in of_twos.as_chunks_mut::<2>().0.iter_mut().zip(twos) {
                *result = ln_products(blocks, seen, guess, lapse, two);
            }
            for (result, one) in of_ones.as_chunks_mut::<1>().0.iter_mut().zip(ones.as_chunks::<1>().0) {
                *result = ln_products(blocks, seen, guess, lapse, one);
            }
            result.iter_mut().for_each(|ln| *ln += independent);
        } else {
            for (result, dispersion) in result.iter_mut().zip(dispersions) {
                let ln: f64 = blocks
                    .iter()
                    .zip(seen)
                    .map(|(cell, seen)| {
                        let (p, q) = shares(seen);
                        ln_rising(p, dispersion.r, cell.right) + ln_rising(q, dispersion.r, cell.wrong)
                    })
                    .sum();
                *result = independent + ln - dispersion.ln_denominator;
            }
        }
    }

    /// The log likelihood at one point, threshold and width in the axis's coordinate.
    pub(super) fn ln_likelihood(&self, threshold: f64, width: f64, lapse: f64, guess: f64, eta: f64) -> f64 {
        let mut seen = Vec::with_capacity(self.cells.len());
        self.fill_seen(threshold, width, &mut seen);
        let mut result = [0.0];
        self.ln_likelihoods(&seen, lapse, guess, &[self.dispersion(eta)], &mut result);
        result[0]
    }
}

fn ln_independent(cell: &Cell, (p, q): (f64, f64)) -> f64 {
    let term = |count: u32, share: f64| if count > 0 { f64::from(count) * share.ln() } else { 0.0 };
    term(cell.right, p) + term(cell.wrong, q)
}

/// ln Π_{j<k}(p + j r).
fn ln_rising(p: f64, r: f64, k: u32) -> f64 {
    if k == 0 {
        return 0.0;
    }
    if r <= 0.0 || p <= 0.0 {
        // From zero, one factor is zero and so is the product.
        return if p <= 0.0 { f64::NEG_INFINITY } else { f64::from(k) * p.ln() };
    }
    // Stirling's series wants an argument of at least twelve; what comes before is multiplied out.
    let shift = if p / r >= 12.0 { 0 } else { ((12.0 - p / r).ceil() as u32).min(k) };
    let mut ln = 0.0;
    let mut product = 1.0f64;
    for j in 0..shift {
        product *= p + f64::from(j) * r;
        if !(1e-200..=1e200).contains(&product) {
            ln += product.ln();
            product = 1.0;
        }
    }
    ln += product.ln();
    let rest = f64::from(k - shift);
    if rest > 0.0 {
        let from = p + f64::from(shift) * r;
        let a = from / r;
        let b = a + rest;
        let tail = |x: f64| {
            let y = 1.0 / (x * x);
            (1.0 - y * (1.0 / 30.0 - y * (1.0 / 105.0 - y / 140.0))) / (12.0 * x)
        };
        // ln Γ(a + rest) − ln Γ(a) + rest ln r, arranged so that nothing large cancels.
        ln += rest * from.ln() + (b - 0.5) * (rest / a).ln_1p() - rest + tail(b) - tail(a);
    }
    ln
}

/// ln of all blocks' likelihood for N dispersions side by side.
///
/// Mantissas are multiplied and exponents added up, so that one logarithm is enough.
fn ln_products<const N: usize>(
    blocks: &[Cell],
    seen: &[(f64, f64)],
    guess: f64,
    lapse: f64,
    dispersions: &[Dispersion; N],
) -> [f64; N] {
    let rise = 1.0 - guess - lapse;
    let r = dispersions.map(|dispersion| dispersion.r);
    let mut mantissa = [1.0f64; N];
    let mut exponent = [0i64; N];
    let mut room = FACTORS;
    for (cell, seen) in blocks.iter().zip(seen) {
        for (share, answers) in [(guess + rise * seen.0, cell.right), (lapse + rise * seen.1, cell.wrong)] {
            let (mut factor, mut left) = ([share; N], answers);
            while left > 0 {
                let now = left.min(room);
                (mantissa, factor) = multiplied(mantissa, factor, &r, now);
                left -= now;
                room -= now;
                if room == 0 {
                    room = FACTORS;
                    split_exponents(&mut mantissa, &mut exponent);
                }
            }
        }
    }
    std::array::from_fn(|lane| {
        let numerator = mantissa[lane].ln() + exponent[lane] as f64 * std::f64::consts::LN_2;
        numerator - dispersions[lane].ln_denominator
    })
}

/// So many factors above [`SMALL`] neither underflow nor, at the largest η and a few thousand answers, overflow.
const FACTORS: u32 = 16;

/// A product times `count` factors, each of which is `r` larger than the one before. By value, so that all of it stays in
/// registers.
#[inline(always)]
fn multiplied<const N: usize>(
    mut product: [f64; N],
    mut factor: [f64; N],
    r: &[f64; N],
    count: u32,
) -> ([f64; N], [f64; N]) {
    for _ in 0..count {
        for lane in 0..N {
            product[lane] *= factor[lane];
            factor[lane] += r[lane];
        }
    }
    (product, factor)
}

/// Takes the binary exponents out of products above zero.
fn split_exponents<const N: usize>(mantissa: &mut [f64; N], exponent: &mut [i64; N]) {
    for lane in 0..N {
        let bits = mantissa[lane].to_bits();
        exponent[lane] += (bits >> 52) as i64 - 1023;
        mantissa[lane] = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::function::gamma::ln_gamma;

    /// The textbook form with six gamma functions.
    fn by_gamma(k: u32, n: u32, p: f64, eta: f64) -> f64 {
        let v = 1.0 / (eta * eta) - 1.0;
        let (k, n) = (f64::from(k), f64::from(n));
        ln_gamma(k + p * v) + ln_gamma(n - k + (1.0 - p) * v)
            - ln_gamma(n + v)
            - ln_gamma(p * v)
            - ln_gamma((1.0 - p) * v)
            + ln_gamma(v)
    }

    fn config(overdispersion: Overdispersion) -> PsychometricConfig {
        PsychometricConfig { overdispersion, ..PsychometricConfig::TWO_ALTERNATIVES }
    }

    #[test]
    fn blocks_are_beta_binomial() {
        for (k, n) in [(0, 1), (1, 1), (0, 40), (40, 40), (19, 40), (700, 1000), (3000, 5000)] {
            let counts = [Count { level: 0.0, n, k }];
            let likelihood = Likelihood::new(&counts, &config(Overdispersion::Free));
            for eta in [0.01, 0.1, 0.4, 0.9] {
                for threshold in [-2.0, 0.0, 1.0] {
                    let found = likelihood.ln_likelihood(threshold, 2.0, 0.02, 0.5, eta);
                    let (seen, _) = super::super::Sigmoid::CumulativeGauss.value(-threshold / 2.0);
                    let expected = by_gamma(k, n, 0.5 + 0.48 * seen, eta);
                    // The gamma functions lose digits at a small η, where v is large.
                    assert!(
                        (found - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                        "{k}/{n}, {eta}: {found} {expected}"
                    );
                }
            }
        }
    }

    /// Products and Stirling's series agree, and both with independent answers as η goes to zero.
    #[test]
    fn both_ways_of_summing_agree() {
        let counts: Vec<Count> =
            [(1.0, 40, 19), (2.0, 37, 30), (3.0, 60, 60)].map(|(level, n, k)| Count { level, n, k }).to_vec();
        let short = Likelihood::new(&counts, &config(Overdispersion::Free));
        let long = Likelihood { short: false, ..short.clone() };
        for eta in [0.0, 1e-8, 1e-3, 0.05, 0.3, 0.95] {
            let (a, b) = (short.ln_likelihood(2.0, 1.5, 0.01, 0.5, eta), long.ln_likelihood(2.0, 1.5, 0.01, 0.5, eta));
            assert!((a - b).abs() < 1e-10 * a.abs(), "{eta}: {a} {b}");
        }
        let independent =
            Likelihood::new(&counts, &config(Overdispersion::None)).ln_likelihood(2.0, 1.5, 0.01, 0.5, 0.0);
        for eta in [0.0, 1e-9] {
            assert!((short.ln_likelihood(2.0, 1.5, 0.01, 0.5, eta) - independent).abs() < 1e-9);
        }
    }

    /// Over all outcomes of a block, probabilities sum to one.
    #[test]
    fn probabilities_of_all_outcomes_sum_to_one() {
        for eta in [0.0, 0.2, 0.7] {
            let n = 30;
            let sum: f64 = (0..=n)
                .map(|k| {
                    let counts = [Count { level: 1.0, n, k }];
                    let ln =
                        Likelihood::new(&counts, &config(Overdispersion::Free)).ln_likelihood(1.2, 2.0, 0.03, 0.5, eta);
                    let [n, k] = [n, k].map(f64::from);
                    (ln + ln_gamma(n + 1.0) - ln_gamma(k + 1.0) - ln_gamma(n - k + 1.0)).exp()
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-9, "{eta}: {sum}");
        }
    }

    #[test]
    fn single_answers_do_not_tell_overdispersion() {
        let singles: Vec<Count> =
            (0..20).map(|i| Count { level: f64::from(i % 4), n: 1, k: u32::from(i % 3 > 0) }).collect();
        let likelihood = Likelihood::new(&singles, &config(Overdispersion::Free));
        assert_eq!(likelihood.blocks, 0);
        assert_eq!(
            likelihood.ln_likelihood(1.0, 2.0, 0.02, 0.5, 0.5),
            likelihood.ln_likelihood(1.0, 2.0, 0.02, 0.5, 0.0)
        );
    }
}
