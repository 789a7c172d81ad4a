//! Quantiles without sorting, so that an hour of samples costs time in proportion to its length; intervals of time.

use super::GazeSample;

/// Times closer than this are the same time, seconds: no tracker samples so often.
pub(crate) const SAME_TIME_S: f64 = 1e-9;

/// Times from each sample to the next, seconds, without those that do not advance.
pub(crate) fn intervals_s(samples: &[GazeSample]) -> Vec<f64> {
    let advances = |dt: &f64| dt.is_finite() && *dt > SAME_TIME_S;
    samples.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).filter(advances).collect()
}

/// The finite values.
pub(crate) fn finite(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    values.into_iter().filter(|v| v.is_finite()).collect()
}

/// The `q` quantile (0–1), linear between order statistics (Hyndman and Fan's type 7); reorders the values.
///
/// The same number as `numerics::quantile_of_sorted` gives. `None` for no values.
pub(crate) fn quantile_in_place(values: &mut [f64], q: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let position = q.clamp(0.0, 1.0) * last as f64;
    let below = (position.floor() as usize).min(last);
    let (_, low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let low = *low;
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    Some(low + (high - low) * (position - below as f64))
}

/// The median; reorders the values.
pub(crate) fn median_in_place(values: &mut [f64]) -> Option<f64> {
    quantile_in_place(values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{quantile_of_sorted, sorted_finite};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn selection_gives_what_sorting_gives(values in prop::collection::vec(-1e3..1e3f64, 0..40), q in 0.0..=1.0f64) {
            let sorted = sorted_finite(values.iter().copied());
            let mut values = values;
            prop_assert_eq!(quantile_in_place(&mut values, q), quantile_of_sorted(&sorted, q));
        }
    }
}
