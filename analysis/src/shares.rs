//! Proportions of a binomial count, with the intervals that one gives with them, and means with theirs.

use crate::statistics::binomial::{clopper_pearson, wilson};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// `k` of `n`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// How many.
    pub k: usize,
    /// Of how many.
    pub n: usize,
    /// k/n, 0–1.
    pub share: f64,
    /// 95 % interval of Wilson (1927), without correction for continuity.
    pub wilson95: [f64; 2],
    /// 95 % interval of Clopper and Pearson (1934), which never covers less than it says.
    pub exact95: [f64; 2],
}

impl Share {
    /// The share of `k` in `n`; nothing for no trials. `k` beyond `n` is taken for `n`.
    #[must_use]
    pub fn new(k: usize, n: usize) -> Option<Self> {
        let k = k.min(n);
        let (wilson95, exact95) =
            (wilson(k as u64, n as u64, 0.95).ok()?, clopper_pearson(k as u64, n as u64, 0.95).ok()?);
        Some(Self { k, n, share: k as f64 / n as f64, wilson95, exact95 })
    }

    /// The share of those for which `is` holds.
    pub(crate) fn of<T>(items: impl IntoIterator<Item = T>, is: impl Fn(T) -> bool) -> Option<Self> {
        let (mut k, mut n) = (0, 0);
        for item in items {
            n += 1;
            k += usize::from(is(item));
        }
        Self::new(k, n)
    }
}

/// The mean of some values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    /// How many.
    pub n: usize,
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation (n − 1); nothing for one value.
    pub sd: Option<f64>,
    /// 95 % interval of the mean by Student's t; nothing for one value.
    pub ci95: Option<[f64; 2]>,
}

impl Mean {
    /// The mean of the finite values; nothing if there are none.
    #[must_use]
    pub fn new(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        let n = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n;
        let sd = (values.len() > 1)
            .then(|| (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt());
        let t = StudentsT::new(0.0, 1.0, n - 1.0).ok().map(|t| t.inverse_cdf(0.975));
        let half = sd.zip(t).map(|(sd, t)| t * sd / n.sqrt());
        Some(Self { n: values.len(), mean, sd, ci95: half.map(|half| [mean - half, mean + half]) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: [f64; 2], expected: [f64; 2], error: f64) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < error), "{found:?} against {expected:?}");
    }

    /// Newcombe (1998), Statistics in Medicine 17, Table I: 81/263, 15/148, 0/20 and 1/29 by methods 3 and 5; 8/10 by
    /// scipy 1.17.1, `binomtest(8, 10).proportion_ci(method="wilson")` and `"exact"`.
    #[test]
    fn intervals_are_the_published_ones() {
        for (k, n, of_wilson, of_exact) in [
            (81, 263, [0.2553, 0.3662], [0.2527, 0.3676]),
            (15, 148, [0.0624, 0.1605], [0.0578, 0.1617]),
            (0, 20, [0.0000, 0.1611], [0.0000, 0.1684]),
            (1, 29, [0.0061, 0.1718], [0.0009, 0.1776]),
        ] {
            let share = Share::new(k, n).unwrap();
            near(share.wilson95, of_wilson, 5.1e-5);
            near(share.exact95, of_exact, 5.1e-5);
        }
        let share = Share::new(8, 10).unwrap();
        near(share.wilson95, [0.490_162_471_536_641_8, 0.943_317_848_545_624_8], 1e-12);
        near(share.exact95, [0.443_904_537_692_358_5, 0.974_789_273_673_166_5], 1e-12);
    }

    #[test]
    fn all_and_none_end_at_the_ends() {
        let [none, all] = [0, 12].map(|k| Share::new(k, 12).unwrap());
        assert_eq!((none.wilson95[0], none.exact95[0], all.wilson95[1], all.exact95[1]), (0.0, 0.0, 1.0, 1.0));
        // 1 − 0.025^(1/12), in closed form.
        assert!((none.exact95[1] - (1.0 - 0.025f64.powf(1.0 / 12.0))).abs() < 1e-15);
        assert_eq!(Share::new(0, 0), None);
    }

    /// By hand: 2, 4, 9 have mean 5 and SD √13; t(0.975, 2) = 4.302653 (Fisher and Yates).
    #[test]
    fn a_mean_has_students_interval() {
        let mean = Mean::new([2.0, 4.0, 9.0, f64::NAN]).unwrap();
        assert_eq!((mean.n, mean.mean), (3, 5.0));
        let half = 4.302_653 * 13f64.sqrt() / 3f64.sqrt();
        near(mean.ci95.unwrap(), [5.0 - half, 5.0 + half], 1e-5);
        assert_eq!(Mean::new([7.0]), Some(Mean { n: 1, mean: 7.0, sd: None, ci95: None }));
        assert_eq!(Mean::new([]), None);
    }
}
