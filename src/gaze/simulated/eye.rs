//! The parameters of a simulated eye and of the tracker in front of it, with their units, bounds and sources.

use serde::{Deserialize, Serialize};

/// A simulated eye and tracker: every number that shapes its samples.
///
/// Absent fields take the defaults of [`SimulatedEye::default`]; unknown ones are refused. The sources say where a
/// model or an order of magnitude comes from; where they leave a value open, it is our choice and marked so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimulatedEye {
    /// Diffusion constant D of fixational drift, arcmin²/s: over short times each axis's variance grows as 2·D·t.
    ///
    /// Drift as Brownian motion, with D of tens of arcmin²/s: Kuang, Poletti, Victor & Rucci 2012; Aytekin, Victor &
    /// Rucci 2014. The value is our choice.
    pub drift_diffusion_arcmin2_s: f64,
    /// Time in which drift forgets its distance from the target, s; an Ornstein–Uhlenbeck process with a standard
    /// deviation of sqrt(D·time) on each axis.
    ///
    /// That fixation pulls the eye back over long times: Engbert & Kliegl 2004. Form and value are our choice.
    pub drift_time_constant_s: f64,
    /// Microsaccades per second of fixation. Martinez-Conde, Macknik & Hubel 2004: about one or two.
    pub microsaccade_rate_hz: f64,
    /// Shortest time from one microsaccade's onset to the next, s; beyond it intervals are exponential. Our choice.
    pub microsaccade_refractory_s: f64,
    /// Median amplitude of microsaccades before the cut at `microsaccade_max_deg`, deg; amplitudes are log-normal.
    ///
    /// Most are well below 1° (Engbert & Kliegl 2003; Martinez-Conde, Otero-Millan & Macknik 2013). Our choice.
    pub microsaccade_median_deg: f64,
    /// Standard deviation of the natural logarithm of microsaccade amplitudes. Our choice.
    pub microsaccade_log_sd: f64,
    /// No microsaccade is larger, deg. The half-degree convention: Poletti & Rucci 2016.
    pub microsaccade_max_deg: f64,
    /// Share of microsaccades that head for the target, 0–1; the others go anywhere. That many correct fixation:
    /// Engbert & Kliegl 2004. Our choice.
    pub microsaccade_corrective_share: f64,
    /// Median time from a new target to the saccade, s. Carpenter 1988: about 200 ms.
    pub saccade_latency_s: f64,
    /// Standard deviation of 1/latency, 1/s; latencies are reciprocal-normal (LATER; Carpenter & Williams 1995) and
    /// kept within 0.08–1 s. Value: our choice.
    pub saccade_promptness_sd_hz: f64,
    /// Duration of an infinitely small saccade, s. Carpenter 1988: 21 ms.
    pub saccade_duration_base_s: f64,
    /// Further duration for each degree of amplitude, s/deg. Carpenter 1988: 2.2 ms/deg; the linear main sequence of
    /// durations: Bahill, Clark & Stark 1975.
    pub saccade_duration_per_deg_s: f64,
    /// Peak velocity over mean velocity, 1.5 (a parabola) to 1.875 (minimum jerk, Flash & Hogan 1985). Near-constant
    /// over amplitudes and close to 1.65: Becker 1989; Harwood, Mezey & Harris 1999.
    pub saccade_peak_to_mean: f64,
    /// Mean share of the way to the target that a saccade covers. Becker & Fuchs 1969: about 10 % short.
    pub saccade_gain: f64,
    /// Standard deviation of that share. Our choice.
    pub saccade_gain_sd: f64,
    /// A saccade that lands farther from its target, deg, is followed by a corrective one; less is left to drift and
    /// microsaccades. Our choice.
    pub corrective_threshold_deg: f64,
    /// Time from landing to the corrective saccade, s. Becker & Fuchs 1969: well under a normal latency. Our choice.
    pub corrective_latency_s: f64,
    /// The eye's velocity over the target's in smooth pursuit. A little below one, as for slow targets; our choice.
    pub pursuit_gain: f64,
    /// Time by which the eye's velocity lags behind the target's in smooth pursuit, s. About a tenth of a second; our
    /// choice.
    pub pursuit_lag_s: f64,
    /// A pursued target that is farther from the eye, deg, is caught up with by a saccade, `corrective_latency_s` later,
    /// which aims at where the target will be: catch-up saccades take its motion into account (de Brouwer, Missal, Barnes
    /// & Lefèvre 2002). The value is our choice.
    pub catch_up_threshold_deg: f64,
    /// Shortest and longest time from one goal to the next in free viewing, s; goals are uniform over the middle of the
    /// display. Our choice, of the order of a fixation in looking at pictures.
    pub free_viewing_s: [f64; 2],
    /// The share of the display's width and height in which those goals lie, 0–1. Our choice.
    pub free_viewing_share: f64,
    /// Blinks per minute. Bentivoglio et al. 1997: 4.5 reading, 17 at rest; between the two is our choice.
    pub blink_rate_per_min: f64,
    /// Mean time of a blink without a signal, s. Stern, Walrath & Goldstein 1984: tenths of a second. Our choice.
    pub blink_duration_s: f64,
    /// Standard deviation of that time, s; no blink is shorter than 0.05 s. Our choice.
    pub blink_duration_sd_s: f64,
    /// The tracker's sampling rate, Hz. Our choice, a desk-mounted research tracker.
    pub rate_hz: f64,
    /// Time from the eye's position to the sample's arrival, s. EyeLink at 1000 Hz under 2 ms, consumer trackers
    /// 20–50 ms (manufacturers' figures); our choice lies between.
    pub latency_s: f64,
    /// White tracker noise of the combined gaze, deg RMS from sample to sample (Holmqvist et al. 2011): twice its
    /// standard deviation on each axis. Each eye alone has sqrt(2) times as much. Our choice.
    pub noise_rms_s2s_deg: f64,
    /// Constant calibration error (right, up), deg. None by our choice.
    pub bias_deg: [f64; 2],
    /// Share of samples lost at random besides blinks, 0–1. Our choice.
    pub loss_share: f64,
    /// Whether the tracker tells the eyes apart.
    pub binocular: bool,
    /// Pupil diameter, mm. Watson & Yellott 2012: about 4 at the luminance of a display.
    pub pupil_mm: f64,
    /// Standard deviation of the measured diameter of one eye, mm. Our choice.
    pub pupil_noise_mm: f64,
    /// What the device's clock reads when the session's reads zero, s. Our choice.
    pub device_offset_s: f64,
}

impl Default for SimulatedEye {
    fn default() -> Self {
        Self {
            drift_diffusion_arcmin2_s: 20.0,
            drift_time_constant_s: 1.0,
            microsaccade_rate_hz: 1.0,
            microsaccade_refractory_s: 0.1,
            microsaccade_median_deg: 0.25,
            microsaccade_log_sd: 0.5,
            microsaccade_max_deg: 0.5,
            microsaccade_corrective_share: 0.5,
            saccade_latency_s: 0.2,
            saccade_promptness_sd_hz: 1.0,
            saccade_duration_base_s: 0.021,
            saccade_duration_per_deg_s: 0.0022,
            saccade_peak_to_mean: 1.65,
            saccade_gain: 0.92,
            saccade_gain_sd: 0.04,
            corrective_threshold_deg: 0.5,
            corrective_latency_s: 0.15,
            pursuit_gain: 0.95,
            pursuit_lag_s: 0.1,
            catch_up_threshold_deg: 1.0,
            free_viewing_s: [0.25, 0.5],
            free_viewing_share: 0.8,
            blink_rate_per_min: 10.0,
            blink_duration_s: 0.2,
            blink_duration_sd_s: 0.05,
            rate_hz: 250.0,
            latency_s: 0.01,
            noise_rms_s2s_deg: 0.05,
            bias_deg: [0.0, 0.0],
            loss_share: 0.005,
            binocular: true,
            pupil_mm: 4.0,
            pupil_noise_mm: 0.02,
            device_offset_s: 0.0,
        }
    }
}

/// Why a simulated eye cannot exist: one field and what it should have been.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field}: expected {expected}, found {found}")]
pub struct EyeMistake {
    /// The field at fault, as it is written in [`SimulatedEye`].
    pub field: &'static str,
    /// What would have been accepted, with its unit.
    pub expected: String,
    /// What was there.
    pub found: f64,
}

impl SimulatedEye {
    /// An eye that never strays from its target, blinks or misses, seen by a tracker without noise, loss or latency;
    /// it still needs time to reach a new target.
    #[must_use]
    pub fn ideal() -> Self {
        Self {
            drift_diffusion_arcmin2_s: 0.0,
            microsaccade_rate_hz: 0.0,
            saccade_promptness_sd_hz: 0.0,
            saccade_gain: 1.0,
            saccade_gain_sd: 0.0,
            pursuit_gain: 1.0,
            blink_rate_per_min: 0.0,
            latency_s: 0.0,
            noise_rms_s2s_deg: 0.0,
            loss_share: 0.0,
            pupil_noise_mm: 0.0,
            ..Self::default()
        }
    }

    /// Every field that is out of its bounds; empty when the eye can exist.
    #[must_use]
    pub fn mistakes(&self) -> Vec<EyeMistake> {
        let bounds: [(&'static str, f64, f64, f64, &str); 35] = [
            ("drift_diffusion_arcmin2_s", self.drift_diffusion_arcmin2_s, 0.0, 10_000.0, "arcmin²/s"),
            ("drift_time_constant_s", self.drift_time_constant_s, 0.01, 100.0, "s"),
            ("microsaccade_rate_hz", self.microsaccade_rate_hz, 0.0, 5.0, "per second"),
            ("microsaccade_refractory_s", self.microsaccade_refractory_s, 0.0, 10.0, "s"),
            ("microsaccade_median_deg", self.microsaccade_median_deg, 0.01, 2.0, "deg"),
            ("microsaccade_log_sd", self.microsaccade_log_sd, 0.0, 2.0, ""),
            ("microsaccade_max_deg", self.microsaccade_max_deg, 0.01, 2.0, "deg"),
            ("microsaccade_corrective_share", self.microsaccade_corrective_share, 0.0, 1.0, ""),
            ("saccade_latency_s", self.saccade_latency_s, 0.08, 1.0, "s"),
            ("saccade_promptness_sd_hz", self.saccade_promptness_sd_hz, 0.0, 10.0, "1/s"),
            ("saccade_duration_base_s", self.saccade_duration_base_s, 0.005, 0.2, "s"),
            ("saccade_duration_per_deg_s", self.saccade_duration_per_deg_s, 0.0, 0.02, "s/deg"),
            ("saccade_peak_to_mean", self.saccade_peak_to_mean, 1.5, 1.875, ""),
            ("saccade_gain", self.saccade_gain, 0.5, 1.2, ""),
            ("saccade_gain_sd", self.saccade_gain_sd, 0.0, 0.2, ""),
            ("corrective_threshold_deg", self.corrective_threshold_deg, 0.1, 10.0, "deg"),
            ("corrective_latency_s", self.corrective_latency_s, 0.02, 1.0, "s"),
            ("pursuit_gain", self.pursuit_gain, 0.0, 1.2, ""),
            ("pursuit_lag_s", self.pursuit_lag_s, 0.0, 1.0, "s"),
            ("catch_up_threshold_deg", self.catch_up_threshold_deg, 0.1, 10.0, "deg"),
            ("free_viewing_s", self.free_viewing_s[0], 0.05, 60.0, "s"),
            ("free_viewing_s", self.free_viewing_s[1], 0.05, 60.0, "s"),
            ("free_viewing_share", self.free_viewing_share, 0.0, 1.0, ""),
            ("blink_rate_per_min", self.blink_rate_per_min, 0.0, 60.0, "per minute"),
            ("blink_duration_s", self.blink_duration_s, 0.05, 1.0, "s"),
            ("blink_duration_sd_s", self.blink_duration_sd_s, 0.0, 0.5, "s"),
            ("rate_hz", self.rate_hz, 10.0, 4000.0, "Hz"),
            ("latency_s", self.latency_s, 0.0, 1.0, "s"),
            ("noise_rms_s2s_deg", self.noise_rms_s2s_deg, 0.0, 10.0, "deg"),
            ("bias_deg", self.bias_deg[0], -20.0, 20.0, "deg"),
            ("bias_deg", self.bias_deg[1], -20.0, 20.0, "deg"),
            ("loss_share", self.loss_share, 0.0, 1.0, ""),
            ("pupil_mm", self.pupil_mm, 1.0, 10.0, "mm"),
            ("pupil_noise_mm", self.pupil_noise_mm, 0.0, 0.25, "mm"),
            ("device_offset_s", self.device_offset_s, -1e9, 1e9, "s"),
        ];
        let mut mistakes: Vec<EyeMistake> = bounds
            .into_iter()
            .filter(|(_, value, min, max, _)| !(min..=max).contains(&value))
            .map(|(field, found, min, max, unit)| EyeMistake {
                field,
                expected: format!("a number from {min} to {max} {unit}").trim_end().to_owned(),
                found,
            })
            .collect();
        if self.microsaccade_median_deg > self.microsaccade_max_deg {
            mistakes.push(EyeMistake {
                field: "microsaccade_median_deg",
                expected: format!("at most microsaccade_max_deg, {} deg", self.microsaccade_max_deg),
                found: self.microsaccade_median_deg,
            });
        }
        if self.free_viewing_s[0] > self.free_viewing_s[1] {
            mistakes.push(EyeMistake {
                field: "free_viewing_s",
                expected: format!("the shortest time first, at most {} s", self.free_viewing_s[1]),
                found: self.free_viewing_s[0],
            });
        }
        if self.microsaccade_rate_hz * self.microsaccade_refractory_s > 0.9 {
            mistakes.push(EyeMistake {
                field: "microsaccade_refractory_s",
                expected: format!("at most 0.9 / microsaccade_rate_hz, {} s", 0.9 / self.microsaccade_rate_hz),
                found: self.microsaccade_refractory_s,
            });
        }
        if self.blink_rate_per_min * self.blink_duration_s > 0.9 * 60.0 {
            mistakes.push(EyeMistake {
                field: "blink_duration_s",
                expected: format!("at most 54 / blink_rate_per_min, {} s", 54.0 / self.blink_rate_per_min),
                found: self.blink_duration_s,
            });
        }
        mistakes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_eyes_are_possible() {
        assert_eq!(SimulatedEye::default().mistakes(), []);
        assert_eq!(SimulatedEye::ideal().mistakes(), []);
    }

    #[test]
    fn every_mistake_is_named_at_once() {
        let eye = SimulatedEye {
            drift_diffusion_arcmin2_s: f64::NAN,
            microsaccade_median_deg: 0.6,
            microsaccade_refractory_s: 2.0,
            rate_hz: 0.0,
            loss_share: 1.5,
            bias_deg: [0.0, f64::INFINITY],
            blink_rate_per_min: 60.0,
            blink_duration_s: 1.0,
            ..SimulatedEye::default()
        };
        let fields: Vec<_> = eye.mistakes().iter().map(|m| m.field).collect();
        assert_eq!(
            fields,
            [
                "drift_diffusion_arcmin2_s",
                "rate_hz",
                "bias_deg",
                "loss_share",
                "microsaccade_median_deg",
                "microsaccade_refractory_s",
                "blink_duration_s"
            ]
        );
        assert_eq!(eye.mistakes()[1].to_string(), "rate_hz: expected a number from 10 to 4000 Hz, found 0");
    }

    #[test]
    fn a_file_may_name_some_fields_but_no_unknown_ones() {
        let eye: SimulatedEye = serde_json::from_str(r#"{"rate_hz": 1000}"#).expect("partial");
        assert_eq!(eye, SimulatedEye { rate_hz: 1000.0, ..SimulatedEye::default() });
        let error = serde_json::from_str::<SimulatedEye>(r#"{"rate": 1000}"#).expect_err("typo");
        assert!(error.to_string().contains("unknown field `rate`"));
        let text = serde_json::to_string(&eye).expect("plain data");
        assert_eq!(serde_json::from_str::<SimulatedEye>(&text).expect("round trip"), eye);
    }
}
