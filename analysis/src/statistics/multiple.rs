//! p values adjusted for how many tests there were.
//!
//! An adjusted p is to be compared with the same level as a single one would be. Holm's method holds the chance of any
//! false finding and is never weaker than Bonferroni's; Benjamini and Hochberg's holds the share of false findings.

use super::TestError;
use serde::{Deserialize, Serialize};

/// How p values are adjusted for one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Adjustment {
    /// Times the number of tests.
    Bonferroni,
    /// Step-down Bonferroni (Holm 1979, Scandinavian Journal of Statistics 6).
    #[default]
    Holm,
    /// Step-up false discovery rate (Benjamini & Hochberg 1995, JRSS B 57).
    BenjaminiHochberg,
    /// As they are.
    None,
}

/// Adjusted p values, in the order of the raw ones; 0–1, and never below them.
///
/// # Errors
///
/// [`TestError::Probability`] for a p outside 0–1 or one that is not a number.
///
/// ```
/// use analysis::statistics::multiple::{Adjustment, adjust};
/// let adjusted = adjust(&[0.52, 0.12, 0.0001, 0.03, 0.14], Adjustment::Holm)?;
/// let expected = [0.52, 0.36, 0.0005, 0.12, 0.36];
/// assert!(adjusted.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
/// # Ok::<(), analysis::statistics::TestError>(())
/// ```
pub fn adjust(p: &[f64], method: Adjustment) -> Result<Vec<f64>, TestError> {
    if let Some(index) = p.iter().position(|p| !(0.0..=1.0).contains(p)) {
        return Err(TestError::Probability { what: format!("p value {}", index + 1), value: p[index] });
    }
    let m = p.len() as f64;
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = p.to_vec();
    match method {
        Adjustment::None => {}
        Adjustment::Bonferroni => adjusted.iter_mut().for_each(|p| *p = (*p * m).min(1.0)),
        Adjustment::Holm => {
            let mut highest = 0.0f64;
            for (rank, &at) in order.iter().enumerate() {
                highest = highest.max(p[at] * (m - rank as f64)).min(1.0);
                adjusted[at] = highest;
            }
        }
        Adjustment::BenjaminiHochberg => {
            let mut lowest = 1.0f64;
            for (rank, &at) in order.iter().enumerate().rev() {
                // p m / rank can round below p where m = rank.
                lowest = lowest.min((p[at] * m / (rank + 1) as f64).max(p[at]));
                adjusted[at] = lowest;
            }
        }
    }
    Ok(adjusted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ties_share_their_adjusted_value() {
        // By hand: Holm's multipliers 4, 3, 2, 1; Benjamini and Hochberg's 4/1, 4/2, 4/3, 4/4.
        let p = [0.01, 0.02, 0.02, 0.5];
        assert_eq!(adjust(&p, Adjustment::Holm).unwrap(), [0.04, 0.06, 0.06, 0.5]);
        let found = adjust(&p, Adjustment::BenjaminiHochberg).unwrap();
        let expected = [0.08 / 3.0, 0.08 / 3.0, 0.08 / 3.0, 0.5];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?}");
        assert_eq!(adjust(&p, Adjustment::Bonferroni).unwrap(), [0.04, 0.08, 0.08, 1.0]);
        assert!(adjust(&[], Adjustment::Holm).unwrap().is_empty());
    }

    #[test]
    fn what_is_no_probability_is_named() {
        for (p, at) in [(vec![0.1, -1e-9], 2), (vec![f64::NAN], 1), (vec![0.0, 1.0, 1.1], 3)] {
            let message = adjust(&p, Adjustment::Holm).unwrap_err().to_string();
            assert!(message.starts_with(&format!("p value {at} must be a probability")), "{message}");
        }
    }

    proptest! {
        #[test]
        fn adjusted_values_keep_order_and_never_fall_below(p in prop::collection::vec(0.0..=1.0f64, 1..30)) {
            let [holm, bonferroni, fdr] = [Adjustment::Holm, Adjustment::Bonferroni, Adjustment::BenjaminiHochberg]
                .map(|method| adjust(&p, method).unwrap());
            for i in 0..p.len() {
                prop_assert!(p[i] <= fdr[i] && fdr[i] <= holm[i] + 1e-15 && holm[i] <= bonferroni[i] && bonferroni[i] <= 1.0);
                for j in 0..p.len() {
                    if p[i] <= p[j] {
                        prop_assert!(holm[i] <= holm[j] && fdr[i] <= fdr[j]);
                    }
                }
            }
        }
    }
}
