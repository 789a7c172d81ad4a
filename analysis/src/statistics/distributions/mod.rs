//! Tail probabilities and quantiles of the distributions that tests stand on, central and noncentral.
//!
//! Every function computes the tail that is asked for directly and never as one minus the other, so that p = 1e-30 comes
//! out as 1e-30 to ten digits and more. It is not a general library of distributions: there are no densities to plot and
//! no random numbers. Functions take any real arguments and answer `None` where the distribution is not defined.

mod beta;
mod gamma;
mod noncentral;
mod normal;
mod roots;

pub use noncentral::{noncentral_f, noncentral_t, noncentrality_limits_of_f, noncentrality_limits_of_t};

pub(super) use beta::{beta_quantile, beta_tails, ln_binomial_probability};
pub(super) use gamma::hedges_factor;
pub(super) use normal::{normal_quantile_above, normal_tails};

use serde::{Deserialize, Serialize};

/// P(X ≤ x) and P(X > x), each to full relative precision even where it is tiny.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tails {
    /// P(X ≤ x).
    pub lower: f64,
    /// P(X > x).
    pub upper: f64,
}

impl Tails {
    const NOTHING_BELOW: Self = Self { lower: 0.0, upper: 1.0 };
    const NOTHING_ABOVE: Self = Self { lower: 1.0, upper: 0.0 };

    fn swapped(self) -> Self {
        Self { lower: self.upper, upper: self.lower }
    }
}

/// The standard normal distribution at `z`; `None` for what is not a number.
#[must_use]
pub fn normal(z: f64) -> Option<Tails> {
    (!z.is_nan()).then(|| normal_tails(z))
}

/// χ² with `df` > 0 degrees of freedom.
///
/// ```
/// let tails = analysis::statistics::distributions::chi_square(300.0, 4.0).unwrap();
/// assert!((tails.upper / 1.083_439_491_947_826e-63 - 1.0).abs() < 1e-9);
/// ```
#[must_use]
pub fn chi_square(x: f64, df: f64) -> Option<Tails> {
    (df > 0.0 && df.is_finite() && !x.is_nan()).then(|| gamma::gamma_tails(0.5 * df, 0.5 * x))
}

/// Student's t with `df` > 0 degrees of freedom.
#[must_use]
pub fn student_t(t: f64, df: f64) -> Option<Tails> {
    if !(df > 0.0 && df.is_finite()) || t.is_nan() {
        return None;
    }
    let beyond = 0.5 * two_sided_t(t, df);
    Some(if t >= 0.0 {
        Tails { lower: 1.0 - beyond, upper: beyond }
    } else {
        Tails { lower: beyond, upper: 1.0 - beyond }
    })
}

/// P(|T| ≥ |t|).
pub(super) fn two_sided_t(t: f64, df: f64) -> f64 {
    let squares = t * t / df;
    beta_tails(0.5 * df, 0.5, 1.0 / (1.0 + squares), 1.0 / (1.0 + 1.0 / squares)).lower
}

/// The t ≥ 0 that Student's distribution with `df` > 0 exceeds with probability `upper`, 0 < `upper` ≤ ½; `None` also where
/// that t is too large for a number.
#[must_use]
pub fn student_t_quantile(upper: f64, df: f64) -> Option<f64> {
    if !(upper > 0.0 && upper <= 0.5 && df > 0.0 && df.is_finite()) {
        return None;
    }
    let (x, y) = beta_quantile(0.5 * df, 0.5, Tails { lower: 2.0 * upper, upper: 1.0 - 2.0 * upper });
    Some((df * y / x).sqrt()).filter(|t| t.is_finite())
}

/// The F distribution with `df1` and `df2` > 0 degrees of freedom.
#[must_use]
pub fn f(x: f64, df1: f64, df2: f64) -> Option<Tails> {
    let defined = [df1, df2].iter().all(|df| *df > 0.0 && df.is_finite()) && !x.is_nan();
    defined.then(|| f_tails(x, df1, df2))
}

pub(super) fn f_tails(x: f64, df1: f64, df2: f64) -> Tails {
    if x <= 0.0 {
        return Tails::NOTHING_BELOW;
    }
    let ratio = df1 * x / df2;
    beta_tails(0.5 * df1, 0.5 * df2, 1.0 / (1.0 + 1.0 / ratio), 1.0 / (1.0 + ratio))
}

/// The beta distribution with shapes `a` and `b` > 0, at `x`.
#[must_use]
pub fn beta(x: f64, a: f64, b: f64) -> Option<Tails> {
    let defined = [a, b].iter().all(|shape| *shape > 0.0 && shape.is_finite()) && !x.is_nan();
    defined.then(|| beta_tails(a, b, x, 1.0 - x))
}

/// P(K ≤ k) and P(K > k) of `n` trials with probability `p` each; `None` for k > n or p outside 0–1.
#[must_use]
pub fn binomial(k: u64, n: u64, p: f64) -> Option<Tails> {
    if k > n || !(0.0..=1.0).contains(&p) {
        return None;
    }
    if k == n {
        return Some(Tails::NOTHING_ABOVE);
    }
    Some(beta_tails((k + 1) as f64, (n - k) as f64, p, 1.0 - p).swapped())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed forms: t with 1 and 2 degrees of freedom, F(2, d), χ² with 2, the last binomial term.
    #[test]
    fn closed_forms_hold_far_into_the_tails() {
        for t in [0.0, 1e-8, 0.3, 1.0, 7.0, 1e4, 1e9] {
            let cauchy = student_t(t, 1.0).unwrap();
            let exact = if t > 0.0 { (1.0 / t).atan() / std::f64::consts::PI } else { 0.5 };
            assert!((cauchy.upper / exact - 1.0).abs() < 1e-13, "{t}: {cauchy:?} against {exact}");
            let two = student_t(-t, 2.0).unwrap().lower;
            let root = (2.0 + t * t).sqrt();
            let exact = 1.0 / (root * (root + t));
            assert!((two / exact - 1.0).abs() < 1e-13, "{t}: {two} against {exact}");
        }
        for (x, d) in [(0.01, 3.0f64), (2.0, 7.0), (50.0, 40.0), (1e6, 90.0)] {
            let exact = (1.0 + 2.0 * x / d).powf(-d / 2.0);
            assert!((f(x, 2.0, d).unwrap().upper / exact - 1.0).abs() < 1e-12);
        }
        for x in [1e-12, 0.5, 3.0, 100.0, 1400.0f64] {
            let tails = chi_square(x, 2.0).unwrap();
            assert!((tails.upper / (-x / 2.0).exp() - 1.0).abs() < 1e-12, "{x}: {tails:?}");
            assert!((tails.lower / -(-x / 2.0).exp_m1() - 1.0).abs() < 1e-13, "{x}: {tails:?}");
        }
        let all = binomial(199, 200, 0.03).unwrap().upper;
        assert!((all / 0.03f64.powi(200) - 1.0).abs() < 1e-12, "{all}");
    }

    #[test]
    fn quantiles_invert_the_tails() {
        for df in [1.0, 2.5, 11.0, 400.0, 1e6] {
            for upper in [1e-100, 1e-30, 1e-6, 0.025, 0.3, 0.4999, 0.5] {
                let t = student_t_quantile(upper, df).unwrap();
                let again = student_t(t, df).unwrap().upper;
                assert!((again / upper - 1.0).abs() < 1e-11, "{df}, {upper}: {t} gives {again}");
            }
        }
    }

    #[test]
    fn what_is_undefined_is_none() {
        assert_eq!(f(1.0, 0.0, 3.0), None);
        assert_eq!(f(f64::NAN, 1.0, 3.0), None);
        assert_eq!(student_t(1.0, f64::NAN), None);
        assert_eq!(student_t(f64::NAN, 3.0), None);
        assert_eq!(student_t_quantile(0.0, 3.0), None);
        assert_eq!(student_t_quantile(0.7, 3.0), None);
        assert_eq!(student_t_quantile(1e-250, 1.0), None);
        assert_eq!(chi_square(1.0, -1.0), None);
        assert_eq!(binomial(3, 2, 0.5), None);
        assert_eq!(binomial(1, 2, 1.5), None);
        assert_eq!(beta(0.5, 1.0, f64::INFINITY), None);
        assert_eq!(normal(f64::NAN), None);
        assert_eq!(f(f64::INFINITY, 1.0, 3.0).unwrap().upper, 0.0);
        assert_eq!(student_t(f64::NEG_INFINITY, 3.0).unwrap().lower, 0.0);
    }
}
