//! The regularised incomplete beta function: both tails, and its inverse.
//!
//! The factor in front, xᵃyᵇ/B(a, b), is taken from Loader's saddle-point form of the binomial probability (Loader 2000,
//! "Fast and accurate computation of binomial probabilities"), since a difference of logarithms of gamma functions loses
//! eight digits at n = 10⁶. The rest is the continued fraction of Didonato and Morris (1992, ACM TOMS 18, eq. 9).

use super::Tails;
use super::gamma::stirling_error;
use super::roots::increasing_root;
use std::f64::consts::TAU;

/// Beta distribution with shapes `a`, `b` > 0 at `x`, where `y` = 1 − x is given apart so that neither loses digits.
pub(in super::super) fn beta_tails(a: f64, b: f64, x: f64, y: f64) -> Tails {
    if x <= 0.0 {
        return Tails::NOTHING_BELOW;
    }
    if y <= 0.0 {
        return Tails::NOTHING_ABOVE;
    }
    // The fraction converges on the side of the mean where the tail is the smaller one.
    if a * y >= b * x {
        let lower = (power_term(a, b, x, y) / fraction(a, b, x, y)).min(1.0);
        Tails { lower, upper: 1.0 - lower }
    } else {
        let upper = (power_term(a, b, x, y) / fraction(b, a, y, x)).min(1.0);
        Tails { lower: 1.0 - upper, upper }
    }
}

/// xᵃyᵇ/B(a, b).
pub(super) fn power_term(a: f64, b: f64, x: f64, y: f64) -> f64 {
    a * b / (a + b) * ln_probability(a, b, x, y).exp()
}

/// ln of Γ(a+b+1)/(Γ(a+1)Γ(b+1)) xᵃyᵇ for a, b > 0.
fn ln_probability(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let n = a + b;
    let saddle = stirling_error(n) - stirling_error(a) - stirling_error(b);
    saddle - deviance(a, n * x) - deviance(b, n * y) - 0.5 * (TAU * a * (b / n)).ln()
}

/// ln P(K = k) of `n` trials with probability `p`, 0 < p < 1.
pub(in super::super) fn ln_binomial_probability(k: u64, n: u64, p: f64) -> f64 {
    let (a, b) = (k as f64, (n - k) as f64);
    if k == 0 {
        return b * (-p).ln_1p();
    }
    if k == n {
        return a * p.ln();
    }
    ln_probability(a, b, p, 1.0 - p)
}

/// x ln(x/m) − x + m, without cancellation near x = m.
pub(super) fn deviance(x: f64, m: f64) -> f64 {
    let v = (x - m) / (x + m);
    if v.abs() >= 0.1 {
        return x * (x / m).ln() + m - x;
    }
    // ln(x/m) = 2 artanh v, summed with the linear terms taken out.
    let mut sum = (x - m) * v;
    let mut term = 2.0 * x * v;
    let mut odd = 3.0;
    loop {
        term *= v * v;
        let next = sum + term / odd;
        if next == sum {
            return next;
        }
        sum = next;
        odd += 2.0;
    }
}

/// The continued fraction by which `power_term` has to be divided; a y ≥ b x.
fn fraction(a: f64, b: f64, x: f64, y: f64) -> f64 {
    /// Enough for shapes of 10⁹; the fraction needs a number of the order of their root.
    const MOST: u32 = 200_000;
    let tiny = 1e-300;
    let denominator = |m: f64| {
        m + m * (b - m) * x / (a + 2.0 * m - 1.0)
            + (a + m) * (a * y - b * x + 1.0 + m * (1.0 + y)) / (a + 2.0 * m + 1.0)
    };
    let mut value = a * (a * y - b * x + 1.0) / (a + 1.0);
    let (mut c, mut d) = (value, 0.0);
    for m in 1..MOST {
        let m = f64::from(m);
        let root = a + 2.0 * m - 1.0;
        let numerator = (a + m - 1.0) / root * ((a + b + m - 1.0) / root) * m * (b - m) * x * x;
        let step = denominator(m);
        d = step + numerator * d;
        c = step + numerator / c;
        if d == 0.0 {
            d = tiny;
        }
        if c == 0.0 {
            c = tiny;
        }
        d = 1.0 / d;
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() < 1e-16 {
            break;
        }
    }
    value
}

/// x and 1 − x at which the beta distribution has these tails, found in whichever of them is smaller.
///
/// Both tails lie strictly between 0 and 1, or the answer is an end.
pub(in super::super) fn beta_quantile(a: f64, b: f64, tails: Tails) -> (f64, f64) {
    if tails.lower <= 0.0 {
        return (0.0, 1.0);
    }
    if tails.upper <= 0.0 {
        return (1.0, 0.0);
    }
    if tails.lower > tails.upper {
        let (y, x) = beta_quantile(b, a, tails.swapped());
        return (x, y);
    }
    // In the logit, the logarithm of the lower tail is concave, so that Newton's steps overshoot to one side only.
    let goal = tails.lower.ln();
    let pair = |logit: f64| (1.0 / (1.0 + (-logit).exp()), 1.0 / (1.0 + logit.exp()));
    let spread = (1.0 / a + 1.0 / b).sqrt();
    let start = (a / b).ln() + crate::numerics::normal_quantile(tails.lower).max(-3.0) * spread;
    let limit = 745.0;
    let logit = increasing_root(-limit, limit, start, |logit| {
        let (x, y) = pair(logit);
        let lower = beta_tails(a, b, x, y).lower;
        (lower.ln() - goal, power_term(a, b, x, y) / lower)
    });
    pair(logit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviance_is_smooth_where_its_two_forms_meet() {
        // x ln(x/m) − x + m for x = 10, m = 8.1 (v = 0.105) and 8.2 (v = 0.099), by mpmath with 40 digits.
        assert!((deviance(10.0, 8.1) / 0.207_210_313_156_526_1 - 1.0).abs() < 1e-13);
        assert!((deviance(10.0, 8.2) / 0.184_509_387_238_382_7 - 1.0).abs() < 1e-13);
        assert_eq!(deviance(5.0, 5.0), 0.0);
    }

    /// I_x(1, b) = 1 − (1 − x)ᵇ and I_x(½, ½) = (2/π) asin √x.
    #[test]
    fn closed_forms_of_the_incomplete_beta() {
        for x in [1e-12, 1e-3, 0.2, 0.5, 0.9, 1.0 - 1e-9] {
            let y = 1.0 - x;
            let arc = beta_tails(0.5, 0.5, x, y);
            let exact = std::f64::consts::FRAC_2_PI * if x < 0.5 { x.sqrt().asin() } else { y.sqrt().asin() };
            let found = if x < 0.5 { arc.lower } else { arc.upper };
            assert!((found / exact - 1.0).abs() < 1e-13, "{x}: {arc:?}");
            for b in [0.5, 3.0, 30.0] {
                let tails = beta_tails(1.0, b, x, y);
                assert!((tails.lower / -(b * (-x).ln_1p()).exp_m1() - 1.0).abs() < 1e-12, "{x}, {b}: {tails:?}");
                assert!((tails.upper / y.powf(b) - 1.0).abs() < 1e-12, "{x}, {b}: {tails:?}");
            }
        }
    }

    #[test]
    fn quantiles_invert() {
        for (a, b) in [(0.5, 0.5), (1.0, 20.0), (40.0, 3.0), (3e5, 7e5), (1.0, 1e6)] {
            for lower in [1e-100, 1e-12, 0.005, 0.3, 0.5, 0.8, 1.0 - 1e-9] {
                let (x, y) = beta_quantile(a, b, Tails { lower, upper: 1.0 - lower });
                let again = beta_tails(a, b, x, y);
                let error = (again.lower / lower - 1.0).abs().min((again.upper / (1.0 - lower) - 1.0).abs());
                assert!(error < 1e-10, "{a}, {b}, {lower}: {x} {again:?}");
            }
        }
    }
}
