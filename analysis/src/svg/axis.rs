//! An axis: from a value to a pixel, linear or logarithmic, and the round numbers at which to put ticks.

/// A mapping of one quantity along one direction of a panel.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    pub(crate) label: String,
    low: f64,
    high: f64,
    logarithmic: bool,
    most_ticks: usize,
    percent: bool,
}

impl Axis {
    /// A linear axis over `low..high`; an empty or impossible range becomes a range of one around `low`.
    pub(crate) fn linear(label: impl Into<String>, low: f64, high: f64) -> Self {
        let low = if low.is_finite() { low } else { 0.0 };
        let high = if high.is_finite() && high > low { high } else { low + 1.0 };
        Self { label: label.into(), low, high, logarithmic: false, most_ticks: 7, percent: false }
    }

    /// A logarithmic axis over `low..high`, both above 0.
    pub(crate) fn logarithmic(label: impl Into<String>, low: f64, high: f64) -> Self {
        let low = if low.is_finite() && low > 0.0 { low } else { 1e-3 };
        let high = if high.is_finite() && high > low { high } else { low * 10.0 };
        Self { label: label.into(), low, high, logarithmic: true, most_ticks: 7, percent: false }
    }

    /// At most about this many ticks.
    pub(crate) fn with_ticks(self, most_ticks: usize) -> Self {
        Self { most_ticks: most_ticks.max(2), ..self }
    }

    /// Ticks as percentages of one.
    pub(crate) fn in_percent(self) -> Self {
        Self { percent: true, ..self }
    }

    pub(crate) fn range(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Place of a value from 0 (low end) to 1 (high end); values off the axis lie outside, but never far.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let place = if self.logarithmic {
            (value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        if place.is_finite() { place.clamp(-10.0, 10.0) } else { -10.0 }
    }

    /// Evenly drawn positions along the axis, ends included.
    pub(crate) fn steps(&self, n: usize) -> Vec<f64> {
        (0..=n)
            .map(|i| {
                let share = i as f64 / n.max(1) as f64;
                if self.logarithmic {
                    self.low * (self.high / self.low).powf(share)
                } else {
                    self.low + (self.high - self.low) * share
                }
            })
            .collect()
    }

    /// Tick values with their texts.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let values = if self.logarithmic { self.log_ticks() } else { self.linear_ticks() };
        let step = values.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        values
            .into_iter()
            .map(|value| {
                let text = match (self.percent, self.logarithmic) {
                    (true, _) => format!("{:.0} %", 100.0 * value),
                    (false, true) => plain(value),
                    (false, false) => with_decimals(value, step),
                };
                (value, text)
            })
            .collect()
    }

    fn linear_ticks(&self) -> Vec<f64> {
        let rough = (self.high - self.low) / self.most_ticks as f64;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|f| f * decade).into_iter().find(|s| *s >= rough).unwrap_or(rough);
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }

    fn log_ticks(&self) -> Vec<f64> {
        let (from, to) = (self.low.log10().floor() as i32 - 1, self.high.log10().ceil() as i32 + 1);
        for digits in [&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0][..], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]] {
            let ticks: Vec<f64> = (from..=to)
                .flat_map(|decade| digits.iter().map(move |d| d * 10f64.powi(decade)))
                .filter(|v| *v >= self.low * (1.0 - 1e-9) && *v <= self.high * (1.0 + 1e-9))
                .collect();
            if ticks.len() <= self.most_ticks && !ticks.is_empty() {
                return ticks;
            }
        }
        let every = ((to - from) as usize / self.most_ticks + 1) as i32;
        (from..=to)
            .filter(|decade| decade % every == 0)
            .map(|decade| 10f64.powi(decade))
            .filter(|v| *v >= self.low && *v <= self.high)
            .collect()
    }
}

/// A number without needless digits, for ticks of a logarithmic axis.
fn plain(value: f64) -> String {
    if (1e-4..1e5).contains(&value) {
        let decimals = (1 - value.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:e}")
    }
}

fn with_decimals(value: f64, step: f64) -> String {
    if !step.is_finite() || step <= 0.0 {
        return plain(value.abs().max(1e-4));
    }
    let mut decimals = (-step.log10().floor()).clamp(0.0, 8.0) as usize;
    // 2.5, 0.25, … need one more.
    if ((step * 10f64.powi(decimals as i32)).fract() - 0.5).abs() < 1e-6 {
        decimals += 1;
    }
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) {
        "0".to_owned()
    } else {
        text.replace('-', "−")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|tick| tick.1).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(texts(&Axis::linear("", 0.0, 27.0).with_ticks(6)), ["0", "5", "10", "15", "20", "25"]);
        assert_eq!(texts(&Axis::linear("", -1.0, 1.0).with_ticks(4)), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(texts(&Axis::logarithmic("", 0.009, 1.2).with_ticks(4)), ["0.01", "0.1", "1"]);
        assert_eq!(
            texts(&Axis::linear("", 0.0, 1.0).with_ticks(4).in_percent()),
            ["0 %", "25 %", "50 %", "75 %", "100 %"]
        );
    }

    #[test]
    fn impossible_ranges_still_map() {
        for axis in
            [Axis::linear("", f64::NAN, 0.0), Axis::logarithmic("", -1.0, f64::INFINITY), Axis::linear("", 3.0, 3.0)]
        {
            assert!(axis.place(f64::NAN).is_finite() && axis.place(3.0).is_finite());
            assert!(axis.ticks().len() < 40);
        }
    }
}
