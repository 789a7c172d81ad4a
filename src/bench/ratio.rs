//! Ratios of what the reference costs over what a renderer costs, so that larger saves more.

use analysis::figures::{BoxStats, Whiskers};
use serde::Serialize;

/// A ratio over some frames, the reference's cost over the renderer's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratio {
    /// The sum over all frames of the one, over that of the other.
    pub of_sums: f64,
    /// Median of the frames' own ratios; nothing where no frame has one, as a frame without costs.
    pub median: Option<f64>,
    /// First and third quartile of the same.
    pub quartiles: Option<[f64; 2]>,
}

impl Ratio {
    /// The ratio of `reference` over `renderer`, frame by frame the same ones; nothing where a frame was not measured or
    /// where the sums have no ratio.
    #[must_use]
    pub fn new(reference: &[Option<f64>], renderer: &[Option<f64>]) -> Option<Self> {
        let [all, own] = [reference, renderer].map(|costs| costs.iter().copied().collect::<Option<Vec<f64>>>());
        let (all, own) = (all?, own?);
        let over = |a: f64, b: f64| Some(a / b).filter(|ratio| b > 0.0 && ratio.is_finite());
        let of_sums = over(all.iter().sum(), own.iter().sum())?;
        let of_frames: Vec<f64> = all.iter().zip(&own).filter_map(|(&a, &b)| over(a, b)).collect();
        let stats = BoxStats::new(&of_frames, Whiskers::Range);
        Some(Self {
            of_sums,
            median: stats.as_ref().map(|stats| stats.median),
            quartiles: stats.as_ref().map(|stats| stats.quartiles),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(values: &[f64]) -> Vec<Option<f64>> {
        values.iter().copied().map(Some).collect()
    }

    /// Worked by hand: sums 40 and 18; ratios of frames 1, 2, 3, 10, of which type 7 takes quartiles at 1.75 and 4.75.
    #[test]
    fn a_ratio_is_of_sums_and_its_spread_of_frames() {
        let ratio = Ratio::new(&costs(&[8.0, 10.0, 12.0, 10.0]), &costs(&[8.0, 5.0, 4.0, 1.0])).unwrap();
        assert!((ratio.of_sums - 40.0 / 18.0).abs() < 1e-12);
        assert!((ratio.median.unwrap() - 2.5).abs() < 1e-12);
        let [low, high] = ratio.quartiles.unwrap();
        assert!((low - 1.75).abs() < 1e-12 && (high - 4.75).abs() < 1e-12, "{low} {high}");
    }

    #[test]
    fn anything_over_itself_is_one() {
        let own = costs(&[0.3, 1e-9, 7e5]);
        let ratio = Ratio::new(&own, &own).unwrap();
        assert_eq!((ratio.of_sums, ratio.median, ratio.quartiles), (1.0, Some(1.0), Some([1.0, 1.0])));
    }

    #[test]
    fn frames_that_cost_nothing_count_in_the_sums_only() {
        let ratio = Ratio::new(&costs(&[4.0, 4.0]), &costs(&[0.0, 2.0])).unwrap();
        assert_eq!((ratio.of_sums, ratio.median), (4.0, Some(2.0)));
        assert_eq!(Ratio::new(&costs(&[4.0]), &costs(&[0.0])), None);
        assert_eq!(Ratio::new(&costs(&[0.0]), &costs(&[0.0])), None);
        assert_eq!(Ratio::new(&[], &[]), None);
    }

    #[test]
    fn what_was_not_measured_in_every_frame_has_no_ratio() {
        assert_eq!(Ratio::new(&[Some(1.0), None], &costs(&[1.0, 1.0])), None);
    }
}
