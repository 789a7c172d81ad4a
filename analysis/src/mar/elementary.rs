//! The two functions on which the fits spend their time: ln and Φ, inlined and free of branches where it counts.
//!
//! Both are exact to nearly the last digit and are held against the standard library and statrs; they exist because the
//! likelihood of one fit takes half a million of each.

use std::f64::consts::LN_2;
use std::sync::LazyLock;

/// Entries of the table of logarithms, and the bits of a mantissa that name them.
const LN_BITS: u32 = 8;
const LN_ENTRIES: usize = 1 << LN_BITS;

/// (1/c, ln c) for the middles c of 256 equal parts of 1..2.
static LN: LazyLock<[(f64, f64); LN_ENTRIES]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let inverse = 1.0 / (1.0 + (i as f64 + 0.5) / LN_ENTRIES as f64);
        (inverse, -inverse.ln())
    })
});

/// ln x for positive, finite, normal x (so no zero, no subnormal, no NaN), to an absolute 3e-16 near 1 and a relative one
/// elsewhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ln(&'static [(f64, f64); LN_ENTRIES]);

impl Ln {
    pub(super) fn new() -> Self {
        Self(&LN)
    }

    /// x = 2^e·m, m = c(1 + r) with |r| < 1/512, and ln(1 + r) by its series to the sixth power.
    #[inline]
    pub(super) fn of(self, x: f64) -> f64 {
        let bits = x.to_bits();
        let exponent = (bits >> 52) as i32 - 1023;
        let mantissa = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
        let (inverse, ln) = self.0[(bits >> (52 - LN_BITS)) as usize % LN_ENTRIES];
        let r = mantissa * inverse - 1.0;
        let q = r * r;
        let series = r + q * ((-0.5 + r * (1.0 / 3.0)) + q * ((-0.25 + r * 0.2) - q * (1.0 / 6.0)));
        f64::from(exponent) * LN_2 + (ln + series)
    }
}

/// 2^(i/64).
static EXP: LazyLock<[f64; 64]> = LazyLock::new(|| std::array::from_fn(|i| (i as f64 / 64.0).exp2()));

/// eˣ for x ≤ 0 to a relative 1e-15; 0 below −700.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exp(&'static [f64; 64]);

impl Exp {
    pub(super) fn new() -> Self {
        Self(&EXP)
    }

    /// x = (64 k + i) ln 2/64 + r with |r| ≤ ln 2/128, and eʳ by its series to the sixth power.
    #[inline]
    pub(super) fn of(self, x: f64) -> f64 {
        // The two parts of ln 2/64 hold k·high exactly.
        const HIGH: f64 = f64::from_bits(0x3f86_2e42_fee0_0000);
        const LOW: f64 = 2.9815858269852933e-12;
        if x.is_nan() || x <= -700.0 {
            return 0.0;
        }
        let steps = (x * (64.0 / LN_2) - 0.5) as i64;
        let r = (x - steps as f64 * HIGH) - steps as f64 * LOW;
        let q = r * r;
        let series = r + q * ((0.5 + r * (1.0 / 6.0)) + q * ((1.0 / 24.0 + r * (1.0 / 120.0)) + q * (1.0 / 720.0)));
        let power = f64::from_bits(((steps.div_euclid(64) + 1023) as u64) << 52);
        let base = self.0[steps.rem_euclid(64) as usize];
        power * (base + base * series)
    }

    /// ln Σ exp(xᵢ), −∞ for no terms; `ln` gives the outer logarithm.
    #[inline]
    pub(super) fn ln_sum(self, ln: Ln, values: &[f64]) -> f64 {
        let top = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if top == f64::NEG_INFINITY {
            return top;
        }
        top + ln.of(values.iter().map(|v| self.of(v - top)).sum::<f64>())
    }
}

/// Nodes per unit, and the last node; beyond it the tail comes from erfc.
const PER_UNIT: f64 = 32.0;
const LAST: usize = 270;
const TERMS: usize = 8;

/// Q(x + δ) = Q(x) − φ(x) Σ (−1)ⁿ Heₙ(x) δⁿ⁺¹/(n + 1)! around nodes x = k/32, |δ| ≤ 1/64.
static TAIL: LazyLock<Vec<[f64; TERMS]>> = LazyLock::new(|| {
    (0..=LAST + 1)
        .map(|k| {
            let x = k as f64 / PER_UNIT;
            let density = crate::numerics::normal_pdf(x);
            let (mut before, mut hermite) = (0.0, 1.0);
            let mut scale = -density;
            let mut row = [0.0; TERMS];
            row[0] = upper_tail(x);
            for (n, coefficient) in row.iter_mut().skip(1).enumerate() {
                scale /= (n + 1) as f64;
                *coefficient = scale * hermite;
                scale = -scale;
                (before, hermite) = (hermite, x * hermite - n as f64 * before);
            }
            row
        })
        .collect()
});

/// 1 − Φ(x) for x ≥ 0 to the last digits: ½ less the series φ(x) Σ x²ⁿ⁺¹/(2n + 1)!! below 2.5, beyond it the continued
/// fraction φ(x)/(x + 1/(x + 2/(x + 3/…))) (Abramowitz & Stegun 26.2.11 and 26.2.14).
fn upper_tail(x: f64) -> f64 {
    let density = crate::numerics::normal_pdf(x);
    if x < 2.5 {
        let (mut term, mut sum) = (x, x);
        for n in 1..80 {
            term *= x * x / f64::from(2 * n + 1);
            sum += term;
        }
        0.5 - density * sum
    } else {
        let fraction = (1..200).rev().fold(x, |below, n| x + f64::from(n) / below);
        density / fraction
    }
}

/// Φ(t) and 1 − Φ(t), each to a relative precision of 1e-12 in its own tail out to 8.4, and to that of erfc beyond.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormalCdf(&'static [[f64; TERMS]]);

impl NormalCdf {
    pub(super) fn new() -> Self {
        Self(TAIL.as_slice())
    }

    #[inline]
    pub(super) fn pair(self, t: f64) -> (f64, f64) {
        let size = t.abs();
        let node = size * PER_UNIT + 0.5;
        if node.is_nan() || node >= LAST as f64 {
            return crate::numerics::normal_cdf_pair(t);
        }
        let node = node as usize;
        let d = size - node as f64 / PER_UNIT;
        let tail = match self.0.get(node) {
            Some(c) => {
                let q = d * d;
                let low = (c[0] + c[1] * d) + (c[2] + c[3] * d) * q;
                low + ((c[4] + c[5] * d) + (c[6] + c[7] * d) * q) * (q * q)
            }
            None => 0.0,
        };
        if t >= 0.0 { (1.0 - tail, tail) } else { (tail, 1.0 - tail) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_the_libraries() {
        let ln = Ln::new();
        for i in 0..200_000 {
            let x = (f64::from(i) * 0.007 - 700.0).exp();
            let expected = x.ln();
            assert!((ln.of(x) - expected).abs() <= 4e-16 * expected.abs().max(1.0), "{x}: {} {expected}", ln.of(x));
        }
        for i in 1..100_000 {
            let x = f64::from(i) * 1e-5;
            assert!((ln.of(x) - x.ln()).abs() <= 5e-16 * x.ln().abs().max(1.0), "{x}");
        }
        assert!((ln.of(f64::MIN_POSITIVE) - f64::MIN_POSITIVE.ln()).abs() < 1e-12);
        assert!(ln.of(1.0).abs() < 3e-16);
    }

    #[test]
    fn the_exponential_is_the_libraries() {
        let (exp, ln) = (Exp::new(), Ln::new());
        for i in 0..200_000 {
            let x = -f64::from(i) * 0.003_5;
            assert!((exp.of(x) - x.exp()).abs() <= 2e-15 * x.exp(), "{x}: {} against {}", exp.of(x), x.exp());
        }
        assert_eq!(exp.of(0.0), 1.0);
        assert_eq!((exp.of(f64::NEG_INFINITY), exp.of(-1e9)), (0.0, 0.0));
        let values = [-3.0, 2.5, 1.0, f64::NEG_INFINITY];
        assert!((exp.ln_sum(ln, &values) - crate::numerics::ln_sum_exp(&values)).abs() < 1e-14);
        assert_eq!(exp.ln_sum(ln, &[f64::NEG_INFINITY]), f64::NEG_INFINITY);
    }

    #[test]
    fn both_tails_are_those_of_erfc() {
        let cdf = NormalCdf::new();
        for i in -40_000..=40_000 {
            let t = f64::from(i) * 0.000_97;
            let (lower, upper) = cdf.pair(t);
            let (a, b) = crate::numerics::normal_cdf_pair(t);
            // The library's erfc is good to some 1e-10.
            assert!((lower - a).abs() <= 1e-9 * a && (upper - b).abs() <= 1e-9 * b, "{t}: {lower} {a}, {upper} {b}");
        }
        // scipy 1.17.1, norm.sf.
        for (t, tail) in [
            (0.0137, 0.49453466172392535),
            (0.5, 0.3085375387259869),
            (1.2345, 0.10850832336267019),
            (2.0, 0.022750131948179195),
            (2.71, 0.0033641604066691933),
            (3.98767, 3.3362694562189e-5),
            (4.49692, 3.447245713705079e-6),
            (6.3, 1.4882282217623072e-10),
            (8.2, 1.2019351542735735e-16),
        ] {
            for (ours, name) in [(cdf.pair(t).1, t), (cdf.pair(-t).0, -t)] {
                assert!((ours / tail - 1.0).abs() < 1e-12, "{name}: {ours} against {tail}");
            }
        }
        assert!(cdf.pair(f64::NAN).0.is_nan());
        assert_eq!(cdf.pair(f64::INFINITY), (1.0, 0.0));
    }
}
