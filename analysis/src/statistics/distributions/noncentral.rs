//! The noncentral t and F distributions, and the noncentralities that an observed statistic is compatible with.
//!
//! Both distributions are sums or integrals of positive terms only, so that either tail keeps its relative precision.

use super::Tails;
use super::beta::{beta_tails, power_term};
use super::gamma::{gamma_tails, stirling_error};
use super::normal::{ln_normal_cdf, normal_quantile_above};
use super::roots::increasing_root;
use crate::numerics::LN_SQRT_TAU;
use std::f64::consts::{LN_2, TAU};

/// The noncentral F distribution: `df1`, `df2` > 0, noncentrality `lambda` ≥ 0.
///
/// A mixture of beta distributions with Poisson weights; each tail is summed in the direction in which the recurrence
/// between neighbouring terms only adds.
#[must_use]
pub fn noncentral_f(x: f64, df1: f64, df2: f64, lambda: f64) -> Option<Tails> {
    let defined = [df1, df2].iter().all(|df| *df > 0.0 && df.is_finite());
    if !defined || x.is_nan() || !(lambda >= 0.0 && lambda.is_finite()) {
        return None;
    }
    if x <= 0.0 {
        return Some(Tails::NOTHING_BELOW);
    }
    if x.is_infinite() {
        return Some(Tails::NOTHING_ABOVE);
    }
    let mixture = Mixture::new(x, df1, df2, lambda);
    // The larger tail is one minus the smaller.
    let above_mean = x * df1 * df2 > (df1 + lambda) * df2;
    Some(if above_mean {
        let upper = mixture.upper().0.min(1.0);
        Tails { lower: 1.0 - upper, upper }
    } else {
        let lower = mixture.lower().0.min(1.0);
        Tails { lower, upper: 1.0 - lower }
    })
}

struct Mixture {
    a: f64,
    b: f64,
    x: f64,
    y: f64,
    /// Mean of the Poisson weights.
    mean: f64,
}

impl Mixture {
    fn new(f: f64, df1: f64, df2: f64, lambda: f64) -> Self {
        let sum = df1 * f + df2;
        Self { a: 0.5 * df1, b: 0.5 * df2, x: df1 * f / sum, y: df2 / sum, mean: 0.5 * lambda }
    }

    fn weight(&self, j: f64) -> f64 {
        if self.mean == 0.0 {
            return if j == 0.0 { 1.0 } else { 0.0 };
        }
        if j == 0.0 {
            return (-self.mean).exp();
        }
        (-stirling_error(j) - super::beta::deviance(j, self.mean)).exp() / (TAU * j).sqrt()
    }

    /// What the tail gains from one j to the next: xᵃ⁺ʲ yᵇ / ((a + j) B(a + j, b)).
    fn step(&self, j: f64) -> f64 {
        power_term(self.a + j, self.b, self.x, self.y) / (self.a + j)
    }

    /// P(X > f) and its derivative with respect to λ, up from the first weight that counts.
    fn upper(&self) -> (f64, f64) {
        let mut j = (self.mean - 12.0 * self.mean.sqrt() - 12.0).floor().max(0.0);
        let mut weight = self.weight(j);
        let mut tail = beta_tails(self.a + j, self.b, self.x, self.y).upper;
        let mut step = self.step(j);
        let (mut sum, mut slope) = (0.0, 0.0);
        loop {
            let term = weight * tail;
            sum += term;
            slope += 0.5 * weight * step;
            // From here on, terms fall faster than the weights' ratio.
            let ratio = self.mean / (j + 1.0);
            let growth = if tail > 0.0 { ratio * ((tail + step) / tail) } else { f64::INFINITY };
            if growth < 0.9 && term * growth / (1.0 - growth) < 1e-17 * sum || weight == 0.0 && ratio < 1.0 {
                return (sum, slope);
            }
            tail = (tail + step).min(1.0);
            step *= self.x * (self.a + self.b + j) / (self.a + j + 1.0);
            weight *= ratio;
            j += 1.0;
        }
    }

    /// P(X ≤ f) and its derivative with respect to λ, down from the last weight that counts.
    fn lower(&self) -> (f64, f64) {
        if self.mean == 0.0 {
            return (beta_tails(self.a, self.b, self.x, self.y).lower, -0.5 * self.step(0.0));
        }
        let mut j = (self.mean + 12.0 * self.mean.sqrt() + 30.0).ceil();
        let mut weight = self.weight(j);
        let mut tail = beta_tails(self.a + j, self.b, self.x, self.y).lower;
        let mut step = self.step(j);
        let (mut sum, mut slope) = (0.0, 0.0);
        loop {
            let term = weight * tail;
            sum += term;
            slope -= 0.5 * weight * step;
            if j == 0.0 || term < 1e-18 * sum && j < self.mean {
                return (sum, slope);
            }
            step *= (self.a + j) / (self.x * (self.a + self.b + j - 1.0));
            tail += step;
            weight *= j / self.mean;
            j -= 1.0;
        }
    }
}

/// The noncentral t distribution: `df` > 0, noncentrality `delta`.
///
/// P(T ≤ t) is the mean of Φ(tS − δ) over S = √(χ²/df). With u = ln S the integrand is smooth and falls off at both ends
/// as fast as an exponential or faster, so that the trapezoidal rule converges geometrically; intervals are halved until
/// the sum stands.
#[must_use]
pub fn noncentral_t(t: f64, df: f64, delta: f64) -> Option<Tails> {
    if !(df > 0.0 && df.is_finite() && delta.is_finite()) || t.is_nan() {
        return None;
    }
    if t.is_infinite() {
        return Some(if t > 0.0 { Tails::NOTHING_ABOVE } else { Tails::NOTHING_BELOW });
    }
    let (lower, upper) = (noncentral_t_lower(t, df, delta).0, noncentral_t_lower(-t, df, -delta).0);
    Some(Tails { lower: lower.min(1.0), upper: upper.min(1.0) })
}

/// P(T ≤ t) and its derivative with respect to δ.
fn noncentral_t_lower(t: f64, df: f64, delta: f64) -> (f64, f64) {
    // Φ(tS − δ) becomes a step that no even grid of u would catch; then χ's tail is smooth along the normal deviate.
    if delta.abs() > 300.0 && t.abs() > 30.0 * (2.0 * df).sqrt() {
        return noncentral_t_along_normal(t, df, delta);
    }
    let z = 0.5 * df;
    // The density of u: constant · exp(−z (e²ᵘ − 1 − 2u)).
    let ln_constant = LN_2 + 0.5 * z.ln() - LN_SQRT_TAU - stirling_error(z);
    let ln_density = |u: f64| -z * ((2.0 * u).exp_m1() - 2.0 * u);
    let ln_integrand = |u: f64| ln_density(u) + ln_normal_cdf(t * u.exp() - delta);

    // Where the integrand is largest, and where it has fallen by e⁻⁴⁴ on either side.
    let reach = |sign: f64| {
        let mut far = sign * (1.0 / (2.0 * z).sqrt()).max(1e-9);
        while ln_density(far) > -800.0 {
            far *= 2.0;
        }
        far
    };
    let (left, right) = (reach(-1.0), reach(1.0));
    let top = maximum(left, right, ln_integrand);
    let highest = ln_integrand(top);
    if highest < -760.0 {
        return (0.0, 0.0);
    }
    let edge = |mut far: f64| {
        let mut near = top;
        for _ in 0..16 {
            let middle = 0.5 * (near + far);
            if ln_integrand(middle) < highest - 44.0 { far = middle } else { near = middle }
        }
        far
    };
    let (left, right) = (edge(2.0 * left), edge(2.0 * right));

    let at = |u: f64| {
        let s = u.exp();
        let weight = (ln_density(u) - highest).exp();
        let x = t * s - delta;
        (((ln_density(u) + ln_normal_cdf(x)) - highest).exp(), weight * (-0.5 * x * x - LN_SQRT_TAU).exp())
    };
    let mut intervals = 32u32;
    let width = right - left;
    let sum_of = |first: f64, step: f64, count: u32| {
        (0..count)
            .map(|i| at(left + first + step * f64::from(i)))
            .fold((0.0, 0.0), |sum, new| (sum.0 + new.0, sum.1 + new.1))
    };
    let mut step = width / f64::from(intervals);
    let mut sums = sum_of(0.0, step, intervals + 1);
    loop {
        let middles = sum_of(0.5 * step, step, intervals);
        let finer = (sums.0 + middles.0, sums.1 + middles.1);
        let stands = (finer.0 - 2.0 * sums.0).abs() <= 1e-11 * finer.0 || finer.0 == 0.0;
        sums = finer;
        intervals *= 2;
        step *= 0.5;
        // The error squares with every halving, so that the second of two sums that differ by 1e-11 is exact.
        if stands || intervals >= 1 << 16 {
            break;
        }
    }
    let scale = (ln_constant + highest).exp() * step;
    (scale * sums.0, -scale * sums.1)
}

/// The same as the mean over Z of P(S ≥ (Z + δ)/t), for t > 0, or of P(S ≤ (Z + δ)/t).
fn noncentral_t_along_normal(t: f64, df: f64, delta: f64) -> (f64, f64) {
    const STEP: f64 = 0.125;
    let (mut sum, mut slope) = (0.0, 0.0);
    for i in -80..=80 {
        let z = STEP * f64::from(i);
        let s = (z + delta) / t;
        let tails = gamma_tails(0.5 * df, 0.5 * df * s * s.abs());
        let weight = STEP * (-0.5 * z * z - LN_SQRT_TAU).exp();
        let share = if t > 0.0 { tails.upper } else { tails.lower };
        sum += weight * share;
        slope += weight * z * share;
    }
    (sum, slope)
}

/// Where a function with one hill is highest, to a hundredth of the hill's width.
fn maximum(mut left: f64, mut right: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..24 {
        let third = (right - left) / 3.0;
        let (a, b) = (left + third, right - third);
        if f(a) < f(b) { left = a } else { right = b }
    }
    0.5 * (left + right)
}

/// The noncentralities between which an observed `t` lies in the central `confidence` (0–1) of its distribution.
///
/// The interval of Steiger and Fouladi (1997): P(T ≥ t) is (1 − confidence)/2 at the lower end and P(T ≤ t) at the upper.
#[must_use]
pub fn noncentrality_limits_of_t(t: f64, df: f64, confidence: f64) -> Option<[f64; 2]> {
    if !(df > 0.0 && df.is_finite() && t.is_finite() && confidence > 0.0 && confidence < 1.0) {
        return None;
    }
    let outside = 0.5 * (1.0 - confidence);
    // The upper limit of t is the mirrored lower limit of −t.
    let upper = |t: f64| {
        let z = normal_quantile_above(outside);
        let spread = (1.0 + t * t / (2.0 * df)).sqrt();
        let mut reach = 2.0 * (z + 2.0) * spread;
        while noncentral_t_lower(t, df, t + reach).0 > outside {
            reach *= 2.0;
        }
        // P(T ≤ t) falls with δ; its logarithm is nearly a parabola.
        increasing_root(t - 2.0 * (z + 2.0) * spread, t + reach, t + z * spread, |delta| {
            let (p, slope) = noncentral_t_lower(t, df, delta);
            (outside.ln() - p.ln(), -slope / p)
        })
    };
    Some([-upper(-t), upper(t)])
}

/// The noncentralities between which an observed `f` lies in the central `confidence` (0–1) of its distribution.
///
/// An end at which even λ = 0 is too large is 0 (Steiger 2004, Psychological Methods 9).
#[must_use]
pub fn noncentrality_limits_of_f(f: f64, df1: f64, df2: f64, confidence: f64) -> Option<[f64; 2]> {
    let defined = [df1, df2].iter().all(|df| *df > 0.0 && df.is_finite());
    if !(defined && f >= 0.0 && f.is_finite() && confidence > 0.0 && confidence < 1.0) {
        return None;
    }
    let outside = 0.5 * (1.0 - confidence);
    let central = super::f_tails(f, df1, df2);
    let middle = (df1 * f - df1).max(0.0);
    let spread = 2.0 * (df1 + 2.0 * middle).sqrt() + middle * (2.0 / df2).sqrt();
    let z = normal_quantile_above(outside);

    let low = if central.upper >= outside {
        0.0
    } else {
        let mut top = middle + df1;
        while Mixture::new(f, df1, df2, top).upper().0 < outside {
            top = 2.0 * top + 1.0;
        }
        increasing_root(0.0, top, middle - 0.7 * z * spread, |lambda| {
            let (p, slope) = Mixture::new(f, df1, df2, lambda).upper();
            (p.ln() - outside.ln(), slope / p)
        })
    };
    let high = if central.lower <= outside {
        0.0
    } else {
        let mut top = middle + (z + 1.0) * spread + 10.0;
        while Mixture::new(f, df1, df2, top).lower().0 > outside {
            top *= 2.0;
        }
        increasing_root(0.0, top, middle + 0.7 * z * spread, |lambda| {
            let (p, slope) = Mixture::new(f, df1, df2, lambda).lower();
            (outside.ln() - p.ln(), -slope / p)
        })
    };
    Some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_noncentrality_they_are_the_central_distributions() {
        for (x, df1, df2) in [(0.01, 1.0, 5.0), (3.0, 2.0, 22.0), (40.0, 6.0, 66.0), (1e4, 3.0, 9.0)] {
            let (central, other) = (super::super::f(x, df1, df2).unwrap(), noncentral_f(x, df1, df2, 0.0).unwrap());
            assert!((central.upper / other.upper - 1.0).abs() < 1e-12, "{central:?} {other:?}");
            assert!((central.lower / other.lower - 1.0).abs() < 1e-12, "{central:?} {other:?}");
        }
        for (t, df) in [(-40.0, 3.0), (-1.0, 1.0), (0.0, 7.0), (2.5, 11.0), (9.0, 100.0)] {
            let (central, other) = (super::super::student_t(t, df).unwrap(), noncentral_t(t, df, 0.0).unwrap());
            assert!((central.upper / other.upper - 1.0).abs() < 1e-11, "{t}, {df}: {central:?} {other:?}");
            assert!((central.lower / other.lower - 1.0).abs() < 1e-11, "{t}, {df}: {central:?} {other:?}");
        }
    }

    /// T² is noncentral F with 1 and ν degrees of freedom and λ = δ²; P(T ≤ 0) = Φ(−δ).
    #[test]
    fn squared_t_is_f_and_zero_is_normal() {
        for (t, df, delta) in [
            (2.0f64, 4.0, 1.5),
            (5.0, 30.0, 3.0),
            (0.3, 9.0, -2.0),
            (60.0, 8.0, 30.0),
            (290.0, 8.0, 295.0),
            (310.0, 8.0, 305.0),
            (310.0, 4000.0, 305.0),
        ] {
            let beyond = noncentral_t(t, df, delta).unwrap().upper + noncentral_t(-t, df, delta).unwrap().lower;
            let of_f = noncentral_f(t * t, 1.0, df, delta * delta).unwrap().upper;
            assert!((beyond / of_f - 1.0).abs() < 1e-11, "{t}, {df}, {delta}: {beyond} {of_f}");
            let (zero, normal) =
                (noncentral_t(0.0, df, delta).unwrap().lower, super::super::normal(-delta).unwrap().lower);
            assert!((zero - normal).abs() <= 1e-12 * normal, "{zero} against {normal}");
        }
    }

    #[test]
    fn limits_put_the_statistic_at_their_tails() {
        for (t, df, confidence) in [
            (0.0, 5.0, 0.95),
            (2.3, 11.0, 0.95),
            (-9.0, 3.0, 0.9),
            (50.0, 40.0, 0.999),
            (1e4, 1.0, 0.95),
            (1e12, 2.0, 0.95),
            (-310.0, 50.0, 0.99),
        ] {
            let [low, high] = noncentrality_limits_of_t(t, df, confidence).unwrap();
            let outside = 0.5 * (1.0 - confidence);
            assert!((noncentral_t(t, df, low).unwrap().upper / outside - 1.0).abs() < 1e-9, "{t}, {df}: {low}");
            assert!((noncentral_t(t, df, high).unwrap().lower / outside - 1.0).abs() < 1e-9, "{t}, {df}: {high}");
        }
        for (f, df1, df2) in
            [(0.02, 3.0, 24.0), (1.0, 2.0, 22.0), (5.2, 3.0, 24.0), (300.0, 6.0, 66.0), (1e5, 1.0, 3.0)]
        {
            let [low, high] = noncentrality_limits_of_f(f, df1, df2, 0.95).unwrap();
            if low > 0.0 {
                assert!((noncentral_f(f, df1, df2, low).unwrap().upper / 0.025 - 1.0).abs() < 1e-9, "{f}: {low}");
            } else {
                assert!(noncentral_f(f, df1, df2, 0.0).unwrap().upper >= 0.025);
            }
            if high > 0.0 {
                assert!((noncentral_f(f, df1, df2, high).unwrap().lower / 0.025 - 1.0).abs() < 1e-9, "{f}: {high}");
            } else {
                assert!(noncentral_f(f, df1, df2, 0.0).unwrap().lower <= 0.025);
            }
            assert!(low <= high);
        }
        assert_eq!(noncentrality_limits_of_f(f64::NAN, 1.0, 3.0, 0.95), None);
        assert_eq!(noncentrality_limits_of_t(1.0, 3.0, 1.0), None);
    }
}
