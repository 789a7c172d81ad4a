//! Lists and ranges of numbers, as procedures and priors write them.

use crate::study::draft::SpanDraft;
use crate::study::mistakes::Report;
use crate::study::plan::Axis;
use crate::study::source::Field;

/// Values from `min` to `max` with equal ratios, reporting a range that is none.
pub(super) fn log_spaced(
    min: Option<f64>,
    max: Option<f64>,
    steps: Option<u32>,
    field: &Field,
    report: &mut Report<'_>,
) -> Option<Vec<f64>> {
    let (min, max) = (min?, max?);
    if min >= max {
        report.at(&field.key("max"), format!("expected more than min ({min}), found {max}"));
        return None;
    }
    Some(geometric(min, max, steps?))
}

/// Values from `min` to `max`, with equal differences or on a log axis equal ratios (both ends above zero), reporting a range
/// that is none.
pub(super) fn spaced(range: &SpanDraft, axis: Axis, field: &Field, report: &mut Report<'_>) -> Option<Vec<f64>> {
    let (Axis::Linear, Some(min), Some(max), Some(steps)) = (axis, range.min, range.max, range.steps) else {
        return log_spaced(range.min, range.max, range.steps, field, report);
    };
    if min >= max {
        report.at(&field.key("max"), format!("expected more than min ({min}), found {max}"));
        return None;
    }
    let last = f64::from(steps.saturating_sub(1).max(1));
    Some((0..steps).map(|step| min + (max - min) * (f64::from(step) / last)).collect())
}

/// `steps` (at least 2) values from `min` to `max` with equal ratios; both ends are exact.
pub(super) fn geometric(min: f64, max: f64, steps: u32) -> Vec<f64> {
    let last = steps.saturating_sub(1).max(1);
    let log_ratio = (max / min).ln();
    let mut values: Vec<f64> =
        (0..=last).map(|step| min * (log_ratio * f64::from(step) / f64::from(last)).exp()).collect();
    if let Some(end) = values.last_mut() {
        *end = max;
    }
    values
}

/// The values of a list with their places, reporting an empty list and values that occur twice.
pub(super) fn listed(values: Option<&[Option<f64>]>, field: &Field, report: &mut Report<'_>) -> Vec<(usize, f64)> {
    let Some(values) = values else { return Vec::new() };
    if values.is_empty() {
        report.at(field, "expected at least one number, found an empty list");
    }
    let listed: Vec<(usize, f64)> =
        values.iter().enumerate().filter_map(|(index, value)| Some((index, (*value)?))).collect();
    let mut sorted = listed.clone();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    for pair in sorted.windows(2) {
        // Zero and minus zero are one value.
        if let [(_, first), (index, second)] = pair
            && first >= second
        {
            report.at(&field.item(*index), format!("expected each value once, found {second} again"));
        }
    }
    listed
}

#[cfg(test)]
mod tests {
    use super::geometric;

    #[test]
    fn a_geometric_range_has_exact_ends_and_equal_ratios() {
        let values = geometric(0.05, 3.0, 24);
        assert_eq!((values.len(), values[0], values[23]), (24, 0.05, 3.0));
        let ratio = 60.0_f64.powf(1.0 / 23.0);
        assert!(values.windows(2).all(|pair| (pair[1] / pair[0] - ratio).abs() < 1e-12));
    }
}
