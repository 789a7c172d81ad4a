//! Drift, microsaccades, saccades: statistics with tolerances of at least four standard errors.

use super::*;
use crate::gaze::simulated::motion::saccade_progress;

/// The duration of a saccade in seconds, Carpenter 1988: 2.2 ms/deg · A + 21 ms.
fn carpenter_1988_s(amplitude_deg: f64) -> f64 {
    1e-3 * (2.2 * amplitude_deg + 21.0)
}

/// Closed forms of the Ornstein–Uhlenbeck process: each axis has the variance D·τ, and the mean squared displacement
/// over a lag is 2·D·τ·(1 − exp(−lag/τ)), which is 2·D·lag for short lags.
#[test]
fn drift_diffuses_and_stays_as_its_parameters_say() {
    let (diffusion, time_s) = (20.0, 1.0);
    let eye = SimulatedEye {
        drift_diffusion_arcmin2_s: diffusion,
        drift_time_constant_s: time_s,
        rate_hz: 200.0,
        ..SimulatedEye::ideal()
    };
    let samples = polled(&mut eye_at(eye, [0.0, 0.0], 1), 2000.0);
    for axis in 0..2 {
        let x: Vec<f64> = samples.iter().map(|s| 60.0 * display().deg_from_px(s.px)[axis]).collect();
        for lag in [1usize, 20] {
            let lag_s = lag as f64 / eye.rate_hz;
            let squared: Vec<f64> = x.iter().zip(&x[lag..]).map(|(a, b)| (b - a).powi(2)).collect();
            let expected = 2.0 * diffusion * time_s * (1.0 - (-lag_s / time_s).exp());
            assert_near(&format!("displacement² over {lag_s} s, arcmin²"), mean(&squared), expected, 0.05);
        }
        // 2000 s are about 1000 independent looks at a variance: a standard error of 4.5 %.
        assert_near("variance, arcmin²", sd(&x).powi(2), diffusion * time_s, 0.18);
    }
}

/// The share of a normal distribution below `z`, by the midpoint rule; an oracle of its own.
fn normal_cdf(z: f64) -> f64 {
    let steps = 20_000;
    let (from, width) = (-9.0, (z + 9.0) / f64::from(steps));
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    (0..steps).map(|i| width * density(from + (f64::from(i) + 0.5) * width)).sum()
}

#[test]
fn microsaccades_have_their_rate_amplitudes_and_durations() {
    let eye = SimulatedEye {
        microsaccade_rate_hz: 1.0,
        drift_time_constant_s: 20.0,
        rate_hz: 1000.0,
        ..SimulatedEye { drift_diffusion_arcmin2_s: 0.0, ..SimulatedEye::ideal() }
    };
    let duration_s = 1000.0;
    let samples = polled(&mut eye_at(eye, [10.0, 5.0], 2), duration_s);
    let found = movements(&samples, 0.5);
    // Intervals have a mean of 1 s and a standard deviation of 0.9 s.
    assert_near("microsaccades per second", found.len() as f64 / duration_s, 1.0, 4.0 * 0.9 / duration_s.sqrt());

    let amplitudes: Vec<f64> = found.iter().map(|&(a, b)| angle_deg(&samples[a], &samples[b])).collect();
    let below = |deg: f64| normal_cdf((deg / eye.microsaccade_median_deg).ln() / eye.microsaccade_log_sd);
    for deg in [0.15, 0.25, 0.4] {
        let expected = below(deg) / below(eye.microsaccade_max_deg);
        let share = amplitudes.iter().filter(|&&a| a < deg).count() as f64 / amplitudes.len() as f64;
        let standard_error = (expected * (1.0 - expected) / amplitudes.len() as f64).sqrt();
        assert_near(&format!("share of amplitudes below {deg}°"), share, expected, 4.0 * standard_error / expected);
    }
    let largest = amplitudes.iter().copied().fold(0.0, f64::max);
    println!("largest {largest}°, mean {}°", mean(&amplitudes));
    assert!(largest <= eye.microsaccade_max_deg + 1e-6);

    for (&(from, to), amplitude_deg) in found.iter().zip(&amplitudes).filter(|(_, a)| **a > 0.1) {
        let lasted_s = samples[to].t_s - samples[from].t_s;
        // Both ends fall between samples, and the slowest millisecond at each may stay below the threshold.
        assert!((lasted_s - carpenter_1988_s(*amplitude_deg)).abs() < 2.5e-3, "{amplitude_deg}° in {lasted_s} s");
    }
}

#[test]
fn fixation_stays_within_a_degree_of_the_target() {
    let eye = SimulatedEye { noise_rms_s2s_deg: 0.0, ..SimulatedEye::default() };
    let samples = polled(&mut eye_at(eye, [8.0, -6.0], 3), 600.0);
    let off: Vec<f64> =
        samples.iter().map(|s| display().eccentricity_deg(display().deg_from_px(s.px), [8.0, -6.0])).collect();
    let rms_deg = mean(&off.iter().map(|x| x * x).collect::<Vec<_>>()).sqrt();
    let largest = off.iter().copied().fold(0.0, f64::max);
    println!("RMS distance from the target {rms_deg:.3}°, largest {largest:.3}°");
    assert!((0.05..0.4).contains(&rms_deg) && largest < 1.5, "{rms_deg} {largest}");
}

/// Duration within one sample interval of Carpenter's formula, peak velocity within 1 % of 1.65 · amplitude / duration,
/// amplitude exact, with samples on the way.
#[test]
fn saccades_follow_the_main_sequence() {
    let eye = SimulatedEye { rate_hz: 4000.0, ..SimulatedEye::ideal() };
    let from_deg = [-20.0, 8.0];
    for target_deg in [[-19.0, 8.0], [-15.0, 8.0], [-10.0, 6.0], [0.0, 0.0], [20.0, -8.0]] {
        let mut source = eye_at(eye, from_deg, 4);
        source.look_at(0.5, target_deg);
        let samples = polled(&mut source, 1.5);
        let found = movements(&samples, 0.01);
        assert_eq!(found.len(), 1);
        let (from, to) = found[0];
        let amplitude_deg = display().eccentricity_deg(from_deg, target_deg);
        assert!((angle_deg(&samples[from], &samples[to]) - amplitude_deg).abs() < 1e-6);

        let duration_s = carpenter_1988_s(amplitude_deg);
        let lasted_s = samples[to].t_s - samples[from].t_s;
        let onset_s = samples[from].t_s;
        assert!((onset_s - 0.7).abs() <= 1.0 / eye.rate_hz, "latency of 0.2 s, not {}", onset_s - 0.5);
        assert!((lasted_s - duration_s).abs() <= 1.5 / eye.rate_hz, "{lasted_s} is not {duration_s}");
        let peak_deg_s = (from..to).map(|i| angle_deg(&samples[i], &samples[i + 1]) * eye.rate_hz).fold(0.0, f64::max);
        println!("{amplitude_deg:.2}°: {:.2} ms", 1e3 * lasted_s);
        assert_near("peak velocity, deg/s", peak_deg_s, 1.65 * amplitude_deg / duration_s, 0.01);
        // All on the great circle: the two parts of the way add up to the whole.
        for i in from..to {
            let sum = angle_deg(&samples[from], &samples[i]) + angle_deg(&samples[i], &samples[to]);
            assert!((sum - amplitude_deg).abs() < 1e-9);
        }
    }
}

/// Flash & Hogan 1985: minimum jerk is 10u³ − 15u⁴ + 6u⁵, with a peak of 1.875 times the mean velocity.
#[test]
fn velocity_profiles_have_the_wanted_peak() {
    for u in [0.1, 0.3, 0.5, 0.9f64] {
        let jerk = 10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5);
        assert!((saccade_progress(u, 1.875) - jerk).abs() < 1e-12);
    }
    for ratio in [1.5, 1.65, 1.875] {
        assert!(saccade_progress(0.0, ratio).abs() < 1e-12 && (saccade_progress(1.0, ratio) - 1.0).abs() < 1e-12);
        let slope = |u: f64| (saccade_progress(u + 1e-5, ratio) - saccade_progress(u - 1e-5, ratio)) / 2e-5;
        let peak = (1..1000).map(|i| slope(f64::from(i) * 1e-3)).fold(0.0, f64::max);
        assert!((peak - ratio).abs() < 1e-6, "{peak} is not {ratio}");
    }
}

#[test]
fn a_saccade_that_falls_short_is_corrected() {
    let eye = SimulatedEye { saccade_gain: 0.9, corrective_latency_s: 0.15, rate_hz: 1000.0, ..SimulatedEye::ideal() };
    let mut source = eye_at(eye, [0.0, 0.0], 5);
    source.look_at(0.0, [10.0, 0.0]);
    let samples = polled(&mut source, 1.0);
    let found = movements(&samples, 0.01);
    assert_eq!(found.len(), 2);
    assert!((angle_deg(&samples[found[0].0], &samples[found[0].1]) - 9.0).abs() < 1e-6);
    assert!((angle_deg(&samples[found[1].0], &samples[found[1].1]) - 1.0).abs() < 1e-6);
    let pause_s = samples[found[1].0].t_s - samples[found[0].1].t_s;
    assert!((pause_s - 0.15).abs() <= 2e-3, "{pause_s}");
    let end_deg = display().deg_from_px(samples[samples.len() - 1].px);
    assert!((end_deg[0] - 10.0).abs() < 1e-6 && end_deg[1].abs() < 1e-6);
}

/// Carpenter & Williams 1995: the reciprocal of the latency is normal.
#[test]
fn latencies_are_reciprocal_normal() {
    let eye = SimulatedEye { saccade_promptness_sd_hz: 1.0, rate_hz: 1000.0, ..SimulatedEye::ideal() };
    let mut source = eye_at(eye, [0.0, 0.0], 6);
    let promptness: Vec<f64> = (0..400)
        .map(|i| {
            let told_s = 2.0 * f64::from(i);
            source.look_at(told_s, [if i % 2 == 0 { 5.0 } else { 0.0 }, 0.0]);
            let samples = polled(&mut source, told_s + 1.9);
            let (from, _) = movements(&samples, 0.01)[0];
            // On average the onset is half an interval after the last sample at rest.
            1.0 / (samples[from].t_s + 0.5e-3 - told_s)
        })
        .collect();
    assert_near("mean promptness, 1/s", mean(&promptness), 5.0, 4.0 / 400f64.sqrt() / 5.0);
    assert_near("SD of promptness, 1/s", sd(&promptness), 1.0, 4.0 / 800f64.sqrt());
}

#[test]
fn a_target_in_steady_motion_is_followed_in_steps() {
    let mut source = eye_at(SimulatedEye::ideal(), [-15.0, 0.0], 7);
    let mut saccades = 0;
    let mut last = None;
    for frame in 0..600 {
        let now_s = f64::from(frame) / 60.0;
        let target_deg = [-15.0 + 3.0 * now_s, 0.0];
        source.look_at(now_s, target_deg);
        for sample in polled(&mut source, now_s) {
            let lag_deg = target_deg[0] - display().deg_from_px(sample.px)[0];
            // At most the saccade's latency and two of its durations behind, 3 deg/s each second.
            assert!((-0.1..1.0).contains(&lag_deg), "{lag_deg}° behind at {now_s} s");
            let moved = last.is_some_and(|last| angle_deg(&last, &sample) > 1e-9);
            saccades += u32::from(moved);
            last = Some(sample);
        }
    }
    assert!(saccades > 100, "{saccades} samples in motion");
}
