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

/// Room between two numbers of an axis, pixels.
pub(crate) const ROOM: f64 = 8.0;

/// The middle of a number at a tick, moved so far inward that it does not reach the number of a neighbouring panel or the
/// page's edge; `at` in pixels along an axis of `pixels`.
pub(crate) fn inward(at: f64, width: f64, pixels: f64) -> f64 {
    let over = ROOM - 1.0;
    at.max(0.5 * width - over).min(pixels - 0.5 * width + over)
}

/// No quantity of this field is larger; what is, cannot be drawn beside anything else.
pub(crate) const LARGEST: f64 = 1e12;
/// The smallest positive number that a logarithmic axis shows.
const SMALLEST: f64 = 1e-12;

impl Axis {
    /// A linear axis over `low..high`; an empty or impossible range becomes a range of one around `low`.
    pub(crate) fn linear(label: impl Into<String>, low: f64, high: f64) -> Self {
        let low = if low.is_finite() { low.clamp(-LARGEST, LARGEST) } else { 0.0 };
        let high = if high.is_finite() { high.min(2.0 * LARGEST) } else { low };
        // Narrower than this, neighbouring ticks could not be told apart.
        let least = 1e-6 * low.abs();
        let high = if high > low + least { high } else { low + least.max(1.0) };
        Self { label: label.into(), low, high, logarithmic: false, most_ticks: 7, percent: false }
    }

    /// A logarithmic axis over `low..high`, both above 0.
    pub(crate) fn logarithmic(label: impl Into<String>, low: f64, high: f64) -> Self {
        let low = if low.is_finite() && low > 0.0 { low.clamp(SMALLEST, LARGEST) } else { 1e-3 };
        let high = if high.is_finite() { high.min(10.0 * LARGEST) } else { low };
        let high = if high > low * (1.0 + 1e-6) { high } else { low * 10.0 };
        Self { label: label.into(), low, high, logarithmic: true, most_ticks: 7, percent: false }
    }

    /// An axis over some values with a little room at both ends; values that cannot be drawn are passed over. One value
    /// alone stands in the middle.
    pub(crate) fn over(label: impl Into<String>, values: impl IntoIterator<Item = f64>, logarithmic: bool) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|v| v.is_finite() && v.abs() <= LARGEST) {
            if !logarithmic || value >= SMALLEST {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        let any = low <= high;
        if logarithmic {
            let room = if high > low * (1.0 + 1e-6) { (high / low).powf(0.06) } else { 2.0 };
            if any { Self::logarithmic(label, low / room, high * room) } else { Self::logarithmic(label, 0.1, 10.0) }
        } else {
            let room = if high - low > 1e-6 * low.abs() { 0.06 * (high - low) } else { 0.5 * low.abs().max(1e-9) };
            if any { Self::linear(label, low - room, high + room) } else { Self::linear(label, 0.0, 1.0) }
        }
    }

    /// Begins at 0 if it is linear and all of it lies above.
    pub(crate) fn starting_at_zero(self) -> Self {
        if self.logarithmic || self.low <= 0.0 && self.high <= 0.0 {
            return self;
        }
        Self { low: 0.0, ..self }
    }

    /// At most about this many ticks.
    pub(crate) fn with_ticks(self, most_ticks: usize) -> Self {
        Self { most_ticks: most_ticks.max(2), ..self }
    }

    /// As many ticks as have room for their numbers along so many pixels, where a number takes what `needed` says of it.
    pub(crate) fn fitting(mut self, pixels: f64, needed: impl Fn(&str) -> f64) -> Self {
        while self.most_ticks > 1 && self.crowded(pixels, &needed) {
            self.most_ticks -= 1;
        }
        self
    }

    fn crowded(&self, pixels: f64, needed: &impl Fn(&str) -> f64) -> bool {
        let places: Vec<(f64, f64)> = self
            .ticks()
            .iter()
            .map(|(value, text)| (inward(pixels * self.place(*value), needed(text) - ROOM, pixels), needed(text)))
            .collect();
        places.windows(2).any(|pair| pair[1].0 - pair[0].0 < 0.5 * (pair[0].1 + pair[1].1))
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
        let farthest = values.iter().map(|v| v.abs()).fold(0.0, f64::max);
        values
            .into_iter()
            .map(|value| {
                let text = match (self.percent, self.logarithmic) {
                    (true, _) => format!("{} %", with_decimals(100.0 * value, 100.0 * step)),
                    (false, true) => plain(value),
                    (false, false) if !(1e-4..1e6).contains(&farthest) => scientific(value, step),
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
        let inside = |v: &f64| *v >= self.low * (1.0 - 1e-9) && *v <= self.high * (1.0 + 1e-9);
        for digits in [&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0][..], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]] {
            let ticks: Vec<f64> = (from..=to)
                .flat_map(|decade| digits.iter().map(move |d| d * 10f64.powi(decade)))
                .filter(inside)
                .collect();
            // One tick does not say that an axis is logarithmic.
            if ticks.len() <= self.most_ticks && ticks.len() > usize::from(self.most_ticks > 1) {
                return ticks;
            }
        }
        // Within a fraction of a decade, the ticks of a linear axis are as good as any.
        if self.high / self.low < 10.0 {
            return self.linear_ticks().into_iter().filter(|v| *v > 0.0).collect();
        }
        let every = ((to - from) as usize / self.most_ticks + 1) as i32;
        (from..=to).filter(|decade| decade % every == 0).map(|decade| 10f64.powi(decade)).filter(inside).collect()
    }
}

/// A number without needless digits, for ticks of a logarithmic axis.
fn plain(value: f64) -> String {
    if (1e-4..1e5).contains(&value) {
        let text = format!("{value:.decimals$}", decimals = (2 - value.log10().floor() as i32).max(0) as usize);
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        scientific(value, f64::INFINITY)
    }
}

/// `2.5·10⁻⁷`, with as many digits as steps of that size need.
fn scientific(value: f64, step: f64) -> String {
    if value == 0.0 || value.abs() < 1e-9 * step.min(1e300) && step.is_finite() {
        return "0".to_owned();
    }
    let exponent = (value.abs() * (1.0 + 1e-12)).log10().floor() as i32;
    let digits = if step.is_finite() { (exponent - step.log10().floor() as i32 + 1).clamp(0, 9) as usize } else { 1 };
    let mantissa = format!("{:.digits$}", value / 10f64.powi(exponent));
    let mantissa =
        if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa.as_str() };
    let power: String = exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            c => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c.to_digit(10).unwrap_or(0) as usize],
        })
        .collect();
    let text = if mantissa == "1" { format!("10{power}") } else { format!("{mantissa}·10{power}") };
    text.replace('-', "−")
}

fn with_decimals(value: f64, step: f64) -> String {
    if !step.is_finite() || step <= 0.0 {
        return crate::text::significant(value, 3);
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
    fn very_large_and_very_small_numbers_are_written_as_powers() {
        assert_eq!(texts(&Axis::linear("", 0.0, 2.0e8).with_ticks(4)), ["0", "5·10⁷", "10⁸", "1.5·10⁸", "2·10⁸"]);
        assert_eq!(texts(&Axis::linear("", -4e-6, 0.0).with_ticks(2)), ["−4·10⁻⁶", "−2·10⁻⁶", "0"]);
        assert_eq!(
            texts(&Axis::logarithmic("", 1e-7, 1e-5)),
            ["10⁻⁷", "2·10⁻⁷", "5·10⁻⁷", "10⁻⁶", "2·10⁻⁶", "5·10⁻⁶", "10⁻⁵"]
        );
    }

    #[test]
    fn ticks_give_way_to_their_numbers() {
        let wide = |text: &str| 8.0 * text.chars().count() as f64 + 8.0;
        let axis = Axis::linear("", 0.0, 0.01).fitting(130.0, wide);
        assert_eq!(texts(&axis), ["0", "0.005", "0.010"]);
        assert_eq!(texts(&Axis::over("", [3.0, f64::NAN, 3.0], false).with_ticks(3)), ["2", "3", "4"]);
    }

    #[test]
    fn impossible_ranges_still_map() {
        for axis in [
            Axis::linear("", f64::NAN, 0.0),
            Axis::logarithmic("", -1.0, f64::INFINITY),
            Axis::linear("", 3.0, 3.0),
            Axis::linear("", -1e300, 1e300),
            Axis::linear("", 1e300, 1e300),
            Axis::linear("", 123_456_789.0, 123_456_789.1),
            Axis::logarithmic("", 1e-300, 1e300),
            Axis::over("", [], true),
        ] {
            assert!(axis.place(f64::NAN).is_finite() && axis.place(3.0).is_finite());
            assert!(!axis.ticks().is_empty() && axis.ticks().len() < 40, "{axis:?}");
            assert!(axis.ticks().iter().all(|(_, text)| text.chars().count() < 16), "{:?}", axis.ticks());
        }
    }
}
