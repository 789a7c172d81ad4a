//! On which axis a function rises or falls.

use super::Count;
use serde::{Deserialize, Serialize};

/// On which axis the function has its shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// The level itself.
    #[default]
    Linear,
    /// Its natural logarithm; levels must be above zero.
    Logarithmic,
}

impl Scale {
    /// The axis on which levels are spaced more evenly: logarithmic if their ratios vary less than their differences.
    #[must_use]
    pub fn of_levels(levels: &[f64]) -> Self {
        let mut sorted = crate::numerics::sorted_finite(levels.iter().copied());
        sorted.dedup();
        if sorted.len() < 3 || sorted[0] <= 0.0 {
            return Self::Linear;
        }
        let unevenness = |steps: &[f64]| {
            let mean = steps.iter().sum::<f64>() / steps.len() as f64;
            (steps.iter().map(|step| (step - mean).powi(2)).sum::<f64>() / steps.len() as f64).sqrt() / mean
        };
        let differences: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let ratios: Vec<f64> = sorted.windows(2).map(|pair| (pair[1] / pair[0]).ln()).collect();
        if unevenness(&ratios) + 1e-9 < unevenness(&differences) { Self::Logarithmic } else { Self::Linear }
    }

    /// Where a level lies on the axis.
    #[must_use]
    pub fn coordinate(self, level: f64) -> f64 {
        match self {
            Self::Linear => level,
            Self::Logarithmic => level.ln(),
        }
    }

    /// The level at a place on the axis.
    #[must_use]
    pub fn level(self, coordinate: f64) -> f64 {
        match self {
            Self::Linear => coordinate,
            Self::Logarithmic => coordinate.exp(),
        }
    }
}

/// Whether right answers become more or less frequent as the level grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// More frequent: a larger level is easier to tell from the reference.
    #[default]
    Rises,
    /// Less frequent, as with Guenter's quality index, of which a larger one is finer. The shape's complement is taken,
    /// 1 − S, so that a falling Weibull function is exp(−ln 2 · (level/threshold)^β).
    Falls,
}

impl Direction {
    /// The direction that the answers themselves take: the sign of their covariance with the level; rising if there is
    /// none.
    #[must_use]
    pub fn of_counts(counts: &[Count]) -> Self {
        if trend(counts).is_some_and(|z| z < 0.0) { Self::Falls } else { Self::Rises }
    }

    /// Falling only if the answers fall by more than chance would make them in one of a thousand data sets, so that a
    /// table without any effect is not read as a falling function.
    #[must_use]
    pub fn of_decided_counts(counts: &[Count]) -> Self {
        if trend(counts).is_some_and(|z| z < -3.0) { Self::Falls } else { Self::Rises }
    }

    /// A pair (seen, missed) as this direction has it.
    #[inline]
    pub(super) fn orient(self, pair: (f64, f64)) -> (f64, f64) {
        match self {
            Self::Rises => pair,
            Self::Falls => (pair.1, pair.0),
        }
    }
}

/// How many standard errors the share of right answers rises with the level (Cochran 1954, Armitage 1955); nothing where
/// either does not vary.
fn trend(counts: &[Count]) -> Option<f64> {
    let total: f64 = counts.iter().map(|count| f64::from(count.n)).sum();
    let mean = counts.iter().map(|count| f64::from(count.n) * count.level).sum::<f64>() / total;
    let share = counts.iter().map(|count| f64::from(count.k)).sum::<f64>() / total;
    let covariance: f64 =
        counts.iter().map(|count| (count.level - mean) * (f64::from(count.k) - share * f64::from(count.n))).sum();
    let spread: f64 = counts.iter().map(|count| f64::from(count.n) * (count.level - mean).powi(2)).sum();
    let variance = share * (1.0 - share) * spread;
    (variance > 0.0).then(|| covariance / variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_follows_the_spacing_of_the_levels() {
        assert_eq!(Scale::of_levels(&[8.0, 10.0, 12.0, 14.0, 22.0, 20.0, 18.0, 16.0]), Scale::Linear);
        assert_eq!(Scale::of_levels(&[0.1, 0.2, 0.4, 0.8]), Scale::Logarithmic);
        assert_eq!(Scale::of_levels(&[0.0, 1.0, 4.0]), Scale::Linear);
        assert_eq!(Scale::of_levels(&[1.0, 9.0]), Scale::Linear);
    }

    #[test]
    fn the_direction_is_the_sign_of_the_covariance() {
        let counts = |ks: [u32; 3]| [0, 1, 2].map(|i| Count { level: f64::from(i), n: 10, k: ks[i as usize] });
        assert_eq!(Direction::of_counts(&counts([9, 5, 1])), Direction::Falls);
        assert_eq!(Direction::of_counts(&counts([1, 5, 9])), Direction::Rises);
        assert_eq!(Direction::of_counts(&counts([5, 5, 5])), Direction::Rises);
        assert_eq!(Direction::of_counts(&counts([10, 10, 10])), Direction::Rises);
        assert_eq!(Direction::of_decided_counts(&counts([6, 5, 4])), Direction::Rises);
        assert_eq!(Direction::of_decided_counts(&counts([9, 5, 1])), Direction::Falls);
    }
}
