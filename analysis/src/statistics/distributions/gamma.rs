//! The regularised incomplete gamma function, both tails, and Stirling's error that its factor is made from.

use super::Tails;
use super::beta::deviance;
use std::f64::consts::TAU;

/// lnΓ(z + 1) − (z + ½) ln z + z − ½ ln 2π at z = 0, ½, 1 … 15 (0 stands for its infinite limit and is not used), by
/// mpmath with 40 digits.
const AT_HALVES: [f64; 31] = [
    0.0,
    0.15342640972002736,
    0.08106146679532726,
    0.05481412105191765,
    0.0413406959554093,
    0.03316287351993629,
    0.02767792568499834,
    0.023746163656297496,
    0.020790672103765093,
    0.018488450532673187,
    0.016644691189821193,
    0.015134973221917378,
    0.013876128823070748,
    0.012810465242920227,
    0.01189670994589177,
    0.011104559758206917,
    0.010411265261972096,
    0.009799416126158804,
    0.009255462182712733,
    0.008768700134139386,
    0.00833056343336287,
    0.00793411456431402,
    0.007573675487951841,
    0.007244554301320383,
    0.00694284010720953,
    0.006665247032707682,
    0.006408994188004207,
    0.006171712263039458,
    0.0059513701127588475,
    0.0057462165130101155,
    0.005554733551962801,
];

/// What Stirling's formula lacks: lnΓ(z + 1) − (z + ½) ln z + z − ½ ln 2π, for z > 0.
pub(super) fn stirling_error(z: f64) -> f64 {
    if z <= 15.0 {
        let halves = 2.0 * z;
        if halves == halves.trunc() {
            return AT_HALVES[halves as usize];
        }
        // δ(z) − δ(z + 1) = (z + ½) ln(1 + 1/z) − 1, up to where the series holds.
        let mut sum = 0.0;
        let mut at = z;
        while at <= 15.0 {
            sum += (at + 0.5) * (1.0 / at).ln_1p() - 1.0;
            at += 1.0;
        }
        return sum + stirling_error(at);
    }
    let w = 1.0 / (z * z);
    // Bernoulli numbers: 1/12, 1/360, 1/1260, 1/1680, 1/1188, 691/360360, 1/156.
    let series = 1.0 / 12.0
        - w * (1.0 / 360.0
            - w * (1.0 / 1260.0 - w * (1.0 / 1680.0 - w * (1.0 / 1188.0 - w * (691.0 / 360_360.0 - w / 156.0)))));
    series / z
}

/// The gamma distribution with shape `a` > 0 and scale 1.
pub(super) fn gamma_tails(a: f64, x: f64) -> Tails {
    if x <= 0.0 {
        return Tails::NOTHING_BELOW;
    }
    if x.is_infinite() {
        return Tails::NOTHING_ABOVE;
    }
    // xᵃ e⁻ˣ / Γ(a + 1), by its distance from the mode.
    let term = (-stirling_error(a) - deviance(a, x) - 0.5 * (TAU * a).ln()).exp();
    if x < a + 1.0 {
        let mut sum = 1.0;
        let mut next = 1.0;
        let mut n = a;
        while next > 1e-17 * sum {
            n += 1.0;
            next *= x / n;
            sum += next;
        }
        let lower = (term * sum).min(1.0);
        Tails { lower, upper: 1.0 - lower }
    } else {
        let upper = (term * a * upper_fraction(a, x)).min(1.0);
        Tails { lower: 1.0 - upper, upper }
    }
}

/// Γ(a, x) / (xᵃ e⁻ˣ) as Legendre's continued fraction, evaluated as Lentz does; x > a.
fn upper_fraction(a: f64, x: f64) -> f64 {
    let mut b = x + 1.0 - a;
    let mut c = f64::MAX;
    let mut d = 1.0 / b;
    let mut value = d;
    for i in 1..200_000 {
        let i = f64::from(i);
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() < 1e-16 {
            break;
        }
    }
    value
}

/// Γ(m/2) / (√(m/2) Γ((m − 1)/2)), by which Cohen's d is multiplied to be unbiased (Hedges 1981, eq. 6e); m > 1.
pub(in super::super) fn hedges_factor(m: f64) -> f64 {
    let z = 0.5 * m;
    (-(z - 1.0) * (-0.5 / z).ln_1p() - 0.5 + stirling_error(z) - stirling_error(z - 0.5)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::function::gamma::ln_gamma;

    /// To what a difference of numbers of the size of 30 lets one see.
    #[test]
    fn stirlings_error_is_the_remainder_of_the_logarithm_of_gamma() {
        for z in [0.01, 0.3, 1.0, 4.25, 7.5, 14.99, 15.0, 15.01, 30.0] {
            let remainder = ln_gamma(z + 1.0) - (z + 0.5) * f64::ln(z) + z - 0.5 * TAU.ln();
            assert!((stirling_error(z) - remainder).abs() < 5e-13, "{z}: {} {remainder}", stirling_error(z));
        }
    }

    /// Hedges (1981), table 1, gives c(2) = 0.5642, c(3) = 0.7236, c(10) = 0.9228 and c(50) = 0.9849; c(2) is 1/√π.
    #[test]
    fn the_factor_of_hedges_is_the_tabulated_one() {
        for (m, c) in [(2.0, 0.5642), (3.0, 0.7236), (10.0, 0.9228), (50.0, 0.9849)] {
            assert!((hedges_factor(m) - c).abs() < 6e-5, "{m}: {}", hedges_factor(m));
        }
        assert!((hedges_factor(2.0) - std::f64::consts::PI.sqrt().recip()).abs() < 1e-15);
    }
}
