//! The tracker: sampling, delay, noise, losses and blinks, and that nothing depends on who polls when.

use super::*;

/// The movements asked of the eye in the tests of repeatability: when and where to.
const TOLD: [(f64, [f64; 2]); 4] = [(0.5, [10.0, 3.0]), (1.31, [-10.0, 0.0]), (1.40, [-5.0, 5.0]), (3.017, [0.0, 0.0])];

/// All samples up to 6 s, polled at the given instants, each instruction given just before the first poll after it.
fn run(seed: u64, polls_s: impl IntoIterator<Item = f64>) -> Vec<GazeSample> {
    let eye = SimulatedEye { blink_rate_per_min: 40.0, loss_share: 0.05, latency_s: 0.013, ..SimulatedEye::default() };
    let mut source = eye_at(eye, [1.0, 2.0], seed);
    let mut told = TOLD.into_iter().peekable();
    let mut out = Vec::new();
    for now_s in polls_s.into_iter().chain([6.0]) {
        while let Some((told_s, target_deg)) = told.next_if(|(told_s, _)| *told_s <= now_s) {
            source.look_at(told_s, target_deg);
        }
        source.poll(now_s, &mut out);
    }
    out
}

#[test]
fn samples_do_not_depend_on_the_polling() {
    let expected = run(21, (0..6000).map(|i| f64::from(i) / 1000.0));
    assert_eq!(expected.len(), 1497, "250 Hz for 6 s, less the 13 ms on their way");
    assert_eq!(run(21, (0..360).map(|i| f64::from(i) / 60.0)), expected);
    assert_eq!(run(21, []), expected);
    assert_eq!(run(21, (0..77).map(|i| (f64::from(i) / 32.0).powi(2))), expected);
}

#[test]
fn samples_depend_on_the_seed_alone() {
    assert_eq!(run(22, []), run(22, []));
    assert_ne!(run(22, []), run(23, []));
}

#[test]
fn telling_the_same_again_changes_nothing() {
    let mut once = eye_at(SimulatedEye::default(), [0.0, 0.0], 24);
    let mut often = eye_at(SimulatedEye::default(), [0.0, 0.0], 24);
    once.look_at(0.5, [7.0, 0.0]);
    for frame in 30..300 {
        often.look_at(f64::from(frame) / 60.0, [7.0, 0.0]);
    }
    assert_eq!(polled(&mut once, 5.0), polled(&mut often, 5.0));
}

#[test]
fn nothing_arrives_before_its_time_and_nothing_late() {
    let eye = SimulatedEye { latency_s: 0.035, rate_hz: 120.0, device_offset_s: 77.0, ..SimulatedEye::default() };
    let mut source = eye_at(eye, [0.0, 0.0], 25);
    let mut all = Vec::new();
    for poll in 0..500 {
        let now_s = 0.0071 * f64::from(poll);
        let samples = polled(&mut source, now_s);
        assert!(samples.iter().all(|s| s.arrived_s <= now_s && s.arrived_s > now_s - 0.0071 - 1e-12));
        all.extend(samples);
        assert!((all.len() as f64 + 1e-9) / 120.0 + 0.035 > now_s, "a sample was kept back at {now_s} s");
    }
    for (k, sample) in all.iter().enumerate() {
        assert!((sample.t_s - k as f64 / 120.0).abs() < 1e-12);
        assert!((sample.arrived_s - sample.t_s - 0.035).abs() < 1e-12);
        assert!((sample.t_device_s - sample.t_s - 77.0).abs() < 1e-12);
    }
    assert!(polled(&mut source, f64::NAN).is_empty() && polled(&mut source, f64::INFINITY).is_empty());
}

/// RMS-S2S = sqrt(mean(dAzi² + dEle²)) and STD = hypot(SD azi, SD ele), as in ETDQualitizer 1.2.
fn rms_s2s_and_std(azi: &[f64], ele: &[f64]) -> (f64, f64) {
    let squared: Vec<f64> =
        azi.windows(2).zip(ele.windows(2)).map(|(a, e)| (a[1] - a[0]).powi(2) + (e[1] - e[0]).powi(2)).collect();
    (mean(&squared).sqrt(), sd(azi).hypot(sd(ele)))
}

#[test]
fn noise_has_its_rms() {
    // Figures of ETDQualitizer 1.2: azi = ele = [1, 2, 3] gives 1.41421, and 0.81650 on each axis, so 1.15470 together.
    let (rms, std) = rms_s2s_and_std(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]);
    assert_eq!((format!("{rms:.5}"), format!("{std:.5}")), ("1.41421".to_owned(), "1.15470".to_owned()));

    let eye = SimulatedEye { noise_rms_s2s_deg: 0.1, rate_hz: 1000.0, ..SimulatedEye::ideal() };
    let samples = polled(&mut eye_at(eye, [0.0, 0.0], 26), 60.0);
    let quality = |px: &dyn Fn(&GazeSample) -> [f64; 2]| {
        let deg: Vec<[f64; 2]> = samples.iter().map(|s| display().deg_from_px(px(s))).collect();
        let axis = |i: usize| deg.iter().map(|d| d[i]).collect::<Vec<_>>();
        rms_s2s_and_std(&axis(0), &axis(1))
    };
    let (rms, std) = quality(&|s| s.px);
    // Each of 60,000 steps has a squared length with a relative standard deviation of about 1.
    assert_near("RMS-S2S, deg", rms, 0.1, 0.02);
    assert_near("STD of white noise, deg", std, 0.1 / std::f64::consts::SQRT_2, 0.02);
    let one_eye = 0.1 * std::f64::consts::SQRT_2;
    assert_near("RMS-S2S of the left eye, deg", quality(&|s| s.left.expect("binocular").px).0, one_eye, 0.02);
    assert_near("RMS-S2S of the right eye, deg", quality(&|s| s.right.expect("binocular").px).0, one_eye, 0.02);

    // Far from the centre too, noise is a true angle.
    let samples = polled(&mut eye_at(eye, [20.0, -12.0], 27), 60.0);
    let squared: Vec<f64> = samples.windows(2).map(|pair| angle_deg(&pair[0], &pair[1]).powi(2)).collect();
    assert_near("RMS-S2S off the axis, deg", mean(&squared).sqrt(), 0.1, 0.02);
}

#[test]
fn losses_have_their_share_and_keep_the_last_place() {
    let eye = SimulatedEye { loss_share: 0.03, noise_rms_s2s_deg: 0.1, rate_hz: 1000.0, ..SimulatedEye::ideal() };
    let samples = polled(&mut eye_at(eye, [0.0, 0.0], 28), 100.0);
    let lost = samples.iter().filter(|s| !s.valid).count() as f64 / samples.len() as f64;
    // Binomial: a standard error of sqrt(0.97 / 3000) = 1.8 %.
    assert_near("share of lost samples", lost, 0.03, 0.072);
    for pair in samples.windows(2).filter(|pair| !pair[1].valid) {
        assert_eq!(pair[1].px, pair[0].px);
        assert_eq!((pair[1].pupil_mm, pair[1].left.expect("binocular").valid), (None, false));
    }
}

#[test]
fn blinks_have_their_rate_and_duration() {
    let eye = SimulatedEye { blink_rate_per_min: 17.0, rate_hz: 250.0, binocular: false, ..SimulatedEye::ideal() };
    let minutes = 120.0;
    let samples = polled(&mut eye_at(eye, [0.0, 0.0], 29), 60.0 * minutes);
    let onsets = samples.windows(2).filter(|pair| pair[0].valid && !pair[1].valid).count() as f64;
    // At most Poisson: 2040 blinks have a standard error of 2.2 %.
    assert_near("blinks per minute", onsets / minutes, 17.0, 0.09);
    let lost_s = samples.iter().filter(|s| !s.valid).count() as f64 / eye.rate_hz;
    // A standard deviation of 0.05 s among 2040 is 0.6 % of the mean.
    assert_near("seconds per blink", lost_s / onsets, 0.2, 0.03);
    assert!(samples.iter().all(|s| s.valid == s.pupil_mm.is_some() && s.left.is_none() && s.right.is_none()));
}

#[test]
fn an_ideal_eye_with_a_bias_misses_by_the_bias() {
    let eye = SimulatedEye { bias_deg: [0.3, -0.4], ..SimulatedEye::ideal() };
    let at_deg = [12.0, 7.0];
    for sample in polled(&mut eye_at(eye, at_deg, 30), 1.0) {
        let off_deg = display().eccentricity_deg(display().deg_from_px(sample.px), at_deg);
        assert!(sample.valid && (off_deg - 0.5).abs() < 1e-9);
        assert_eq!(sample.pupil_mm, Some(4.0));
    }
}

#[test]
fn impossible_eyes_and_places_are_refused_or_kept_finite() {
    let eye = SimulatedEye { rate_hz: -1.0, loss_share: 2.0, ..SimulatedEye::default() };
    let mistakes = Simulated::new(eye, &display(), [f64::NAN, 0.0], ChaCha8Rng::seed_from_u64(31)).expect_err("three");
    assert_eq!(mistakes.iter().map(|m| m.field).collect::<Vec<_>>(), ["rate_hz", "loss_share", "start_deg"]);

    let eye = SimulatedEye { noise_rms_s2s_deg: 10.0, ..SimulatedEye::default() };
    let mut source = eye_at(eye, [0.0, 0.0], 32);
    source.look_at(0.1, [f64::NAN, 0.0]);
    source.look_at(f64::NAN, [1.0, 0.0]);
    source.look_at(0.2, [1e9, -170.0]);
    assert!(polled(&mut source, 20.0).iter().all(|s| s.px.iter().all(|x| x.is_finite())));
}

#[test]
fn instructions_that_nobody_polls_for_stay_bounded() {
    let mut source = eye_at(SimulatedEye::default(), [0.0, 0.0], 33);
    for i in 0..3 * MAX_WAITING {
        source.look_at(i as f64 * 1e-3, [10.0 * (i as f64).sin(), 0.0]);
    }
    assert_eq!(source.waiting.len(), MAX_WAITING);
    let samples = polled(&mut source, 20.0);
    let end_deg = display().deg_from_px(samples[samples.len() - 1].px)[0];
    let target_deg = 10.0 * ((3 * MAX_WAITING - 1) as f64).sin();
    assert!((end_deg - target_deg).abs() < 1.5, "the last instruction holds: {end_deg} is not near {target_deg}");
}

#[test]
fn the_header_names_every_parameter() {
    let source = eye_at(SimulatedEye::default(), [1.0, 2.0], 34);
    let described = source.describe();
    assert_eq!(described["id"], source.id());
    assert_eq!(described["start_deg"][1], 2.0);
    let eye: SimulatedEye = serde_json::from_value(described["eye"].clone()).expect("complete");
    assert_eq!(eye, *source.eye());
}
