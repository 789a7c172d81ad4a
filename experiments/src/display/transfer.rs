//! A display's transfer: how much light a channel gives for a value that is sent to it, and which value to send for the
//! light that is wanted.
//!
//! Light is relative to the channel's own peak, 0–1; signals are 0–1, which an 8-bit display takes in steps of 1/255. A
//! measured display need not be black at signal 0: light below its black is shown as its black.

use crate::contrast::csf::Pchip;
use serde::{Deserialize, Serialize, Serializer};

/// The channels by the names that display files give them, in the order of every `[_; 3]` here.
pub const CHANNELS: [&str; 3] = ["red", "green", "blue"];
/// The largest level of a measured table: tables are of 8-bit values.
const LARGEST_LEVEL: f64 = 255.0;
/// Halvings of the range of signals when a measured curve is inverted: 2⁻⁴⁰ is far below any step of a display.
const HALVINGS: u32 = 40;

/// A display's transfer.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Transfer {
    /// That of IEC 61966-2-1 in every channel.
    #[default]
    Srgb,
    /// Light is the signal to the power of each channel's gamma, 1–4.
    Gamma([f64; 3]),
    /// As measured.
    Measured(Box<MeasuredTransfer>),
}

/// A transfer as it was measured: a monotone cubic (PCHIP) through each channel's luminances.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredTransfer {
    levels: Vec<f64>,
    luminances: [Vec<f64>; 3],
    /// Relative light over signal.
    curves: [Pchip; 3],
}

/// A transfer in the form of a display file; sRGB is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum TransferNumbers {
    /// One exponent for each channel.
    Gamma {
        /// Red, green, blue.
        gamma: [f64; 3],
    },
    /// Luminances in any unit at 8-bit levels.
    Measured {
        /// The levels, rising from 0 to 255.
        levels: Vec<f64>,
        /// Luminance of the red channel at each level.
        red: Vec<f64>,
        /// Luminance of the green channel at each level.
        green: Vec<f64>,
        /// Luminance of the blue channel at each level.
        blue: Vec<f64>,
    },
}

/// What is wrong with a transfer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("transfer.{key}{}: expected {expected}, found {found}", .index.map_or_else(String::new, |i| format!("[{i}]")))]
pub struct TransferError {
    /// The key at fault, as it is written in a display file within `transfer`.
    pub key: &'static str,
    /// Which element of the list, if it is one.
    pub index: Option<usize>,
    /// What would have been accepted.
    pub expected: String,
    /// What was there.
    pub found: String,
}

impl TransferError {
    fn new(key: &'static str, index: Option<usize>, expected: impl Into<String>, found: &impl ToString) -> Self {
        Self { key, index, expected: expected.into(), found: found.to_string() }
    }
}

impl Transfer {
    /// A power law in each channel.
    ///
    /// # Errors
    /// One for each exponent outside 1–4.
    pub fn gamma(gamma: [f64; 3]) -> Result<Self, Vec<TransferError>> {
        let errors: Vec<_> = (0..3)
            .filter(|&channel| !(1.0..=4.0).contains(&gamma[channel]))
            .map(|channel| TransferError::new("gamma", Some(channel), "an exponent from 1 to 4", &gamma[channel]))
            .collect();
        if errors.is_empty() { Ok(Self::Gamma(gamma)) } else { Err(errors) }
    }

    /// The luminances of the red, green and blue channel, in any unit, at 8-bit `levels`; each channel is divided by its
    /// last luminance.
    ///
    /// # Errors
    /// Levels that do not rise from 0 to 255, luminances that are negative or do not rise strictly, lists of different
    /// lengths: all of them.
    pub fn measured(levels: Vec<f64>, luminances: [Vec<f64>; 3]) -> Result<Self, Vec<TransferError>> {
        let mut errors = level_errors(&levels);
        for (channel, values) in CHANNELS.into_iter().zip(&luminances) {
            if values.len() == levels.len() {
                errors.extend(luminance_errors(channel, values));
            } else {
                let expected = format!("as many luminances as there are levels, {}", levels.len());
                errors.push(TransferError::new(channel, None, expected, &values.len()));
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let signals: Vec<f64> = levels.iter().map(|level| level / LARGEST_LEVEL).collect();
        let curve = |values: &Vec<f64>| {
            let peak = values.last().copied().unwrap_or(1.0);
            Pchip::new(&signals, &values.iter().map(|value| value / peak).collect::<Vec<_>>())
        };
        match (curve(&luminances[0]), curve(&luminances[1]), curve(&luminances[2])) {
            (Some(red), Some(green), Some(blue)) => {
                Ok(Self::Measured(Box::new(MeasuredTransfer { levels, luminances, curves: [red, green, blue] })))
            }
            _ => Err(vec![TransferError::new("levels", None, "at least two levels", &levels.len())]),
        }
    }

    /// A transfer from a display file's numbers; sRGB where there are none.
    ///
    /// # Errors
    /// As [`Transfer::gamma`] and [`Transfer::measured`].
    pub fn from_numbers(numbers: Option<TransferNumbers>) -> Result<Self, Vec<TransferError>> {
        match numbers {
            None => Ok(Self::Srgb),
            Some(TransferNumbers::Gamma { gamma }) => Self::gamma(gamma),
            Some(TransferNumbers::Measured { levels, red, green, blue }) => Self::measured(levels, [red, green, blue]),
        }
    }

    /// The numbers of a display file.
    #[must_use]
    pub fn numbers(&self) -> Option<TransferNumbers> {
        match self {
            Self::Srgb => None,
            Self::Gamma(gamma) => Some(TransferNumbers::Gamma { gamma: *gamma }),
            Self::Measured(measured) => {
                let [red, green, blue] = measured.luminances.clone();
                Some(TransferNumbers::Measured { levels: measured.levels.clone(), red, green, blue })
            }
        }
    }

    /// Whether it is that of sRGB.
    #[must_use]
    pub fn is_srgb(&self) -> bool {
        *self == Self::Srgb
    }

    /// The light, 0–1 of its peak, that channel 0–2 gives for a signal of 0–1.
    #[must_use]
    pub fn light_from_signal(&self, channel: usize, signal: f64) -> f64 {
        let signal = signal.clamp(0.0, 1.0);
        match self {
            Self::Srgb if signal <= 0.040_45 => signal / 12.92,
            Self::Srgb => ((signal + 0.055) / 1.055).powf(2.4),
            Self::Gamma(gamma) => signal.powf(gamma[channel.min(2)]),
            Self::Measured(measured) => measured.curves[channel.min(2)].at(signal),
        }
    }

    /// The signal, 0–1, at which channel 0–2 gives `light`, 0–1 of its peak.
    #[must_use]
    pub fn signal_from_light(&self, channel: usize, light: f64) -> f64 {
        let light = light.clamp(0.0, 1.0);
        match self {
            Self::Srgb if light <= 0.003_130_8 => light * 12.92,
            Self::Srgb => 1.055 * light.powf(1.0 / 2.4) - 0.055,
            Self::Gamma(gamma) => light.powf(1.0 / gamma[channel.min(2)]),
            Self::Measured(measured) => inverted(&measured.curves[channel.min(2)], light),
        }
    }
}

/// Where a curve that rises over 0–1 reaches `light`, by halving.
fn inverted(curve: &Pchip, light: f64) -> f64 {
    if light <= curve.at(0.0) {
        return 0.0;
    }
    if light >= curve.at(1.0) {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if curve.at(middle) < light {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn level_errors(levels: &[f64]) -> Vec<TransferError> {
    if levels.len() < 2 {
        return vec![TransferError::new("levels", None, "at least two levels, from 0 to 255", &levels.len())];
    }
    let at = |index: usize| TransferError::new("levels", Some(index), "levels that rise from 0 to 255", &levels[index]);
    let last = levels.len() - 1;
    (0..=last)
        .filter(|&index| match index {
            0 => levels[0].to_bits() != 0.0_f64.to_bits(),
            _ if index == last => levels[last].to_bits() != LARGEST_LEVEL.to_bits(),
            _ => !(levels[index - 1] < levels[index] && levels[index] < LARGEST_LEVEL),
        })
        .map(at)
        .collect()
}

fn luminance_errors(channel: &'static str, values: &[f64]) -> Vec<TransferError> {
    let finite = |value: f64| value.is_finite() && value >= 0.0;
    (0..values.len())
        .filter(|&index| !finite(values[index]) || (index > 0 && values[index] <= values[index - 1]))
        .map(|index| {
            let expected = match index {
                0 => "a luminance of at least 0".to_owned(),
                _ => format!("a luminance above that of the level before, {}", values[index - 1]),
            };
            TransferError::new(channel, Some(index), expected, &values[index])
        })
        .collect()
}

impl Serialize for Transfer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.numbers().serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Transfer {
        // Black of 0.2 % of the peak, and no power law: the middle is lifted by a sine.
        let levels: Vec<f64> = (0..=17).map(|i| f64::from(i) * 15.0).collect();
        let of = |gamma: f64, peak: f64| -> Vec<f64> {
            let at = |x: f64| x.powf(gamma) + 0.02 * (std::f64::consts::PI * x).sin() * x;
            levels.iter().map(|level| peak * (0.002 + 0.998 * at(level / 255.0))).collect()
        };
        Transfer::measured(levels.clone(), [of(2.1, 40.0), of(2.3, 130.0), of(2.6, 12.0)]).expect("rises")
    }

    #[test]
    fn signal_and_light_undo_each_other() {
        for transfer in [Transfer::Srgb, Transfer::gamma([1.0, 2.2, 4.0]).expect("in range"), table()] {
            for channel in 0..3 {
                for step in 0..=255 {
                    let signal = f64::from(step) / 255.0;
                    let light = transfer.light_from_signal(channel, signal);
                    let back = transfer.signal_from_light(channel, light);
                    assert!((back - signal).abs() < 1e-9, "{transfer:?} {channel} {step}: {back}");
                }
            }
        }
    }

    #[test]
    fn a_measured_table_is_passed_through_at_its_own_levels_and_ends() {
        let Transfer::Measured(measured) = table() else { panic!("a table") };
        for (channel, values) in measured.luminances.iter().enumerate() {
            for (level, value) in measured.levels.iter().zip(values) {
                let light = table().light_from_signal(channel, level / 255.0);
                assert!((light - value / values[values.len() - 1]).abs() < 1e-12);
            }
            // Nothing is darker than its black or brighter than its peak.
            assert!(table().signal_from_light(channel, 0.0).abs() < 1e-12);
            assert!(table().signal_from_light(channel, 0.001).abs() < 1e-12);
            assert!((table().signal_from_light(channel, 7.0) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn every_mistake_is_named() {
        let errors = Transfer::gamma([0.5, 2.2, f64::NAN]).expect_err("two");
        assert_eq!(errors.iter().map(|e| e.index).collect::<Vec<_>>(), [Some(0), Some(2)]);
        let errors = Transfer::measured(
            vec![0.0, 100.0, 90.0, 254.0],
            [vec![0.0, 1.0, 1.0, 2.0], vec![0.0, 1.0, 2.0], vec![-1.0, 0.5, f64::NAN, 2.0]],
        )
        .expect_err("many");
        let places: Vec<_> = errors.iter().map(|e| (e.key, e.index)).collect();
        let expected = [
            ("levels", Some(2)),
            ("levels", Some(3)),
            ("red", Some(2)),
            ("green", None),
            ("blue", Some(0)),
            ("blue", Some(2)),
        ];
        assert_eq!(places, expected);
        assert_eq!(errors[0].to_string(), "transfer.levels[2]: expected levels that rise from 0 to 255, found 90");
        assert!(Transfer::measured(vec![0.0], [vec![0.0], vec![0.0], vec![0.0]]).is_err());
    }

    #[test]
    fn numbers_survive_json() {
        for transfer in [Transfer::Srgb, Transfer::Gamma([2.2, 2.2, 2.25]), table()] {
            let text = serde_json::to_string(&transfer.numbers()).expect("serialises");
            let numbers = serde_json::from_str(&text).expect("parses");
            assert_eq!(Transfer::from_numbers(numbers), Ok(transfer));
        }
    }
}
