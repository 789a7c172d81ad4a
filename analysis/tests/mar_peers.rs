//! The fit against scipy and numpy on a committed data set; script, versions and numbers are in `tests/peers/README.md`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::mar::{MarFitConfig, MarTrial, fit_mar};

const DATA: &str = include_str!("../../tests/peers/data/mar_constant.csv");

fn trials() -> Vec<MarTrial> {
    let mut trials = Vec::new();
    for line in DATA.lines().skip(1) {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let (n, k) = (fields[2] as usize, fields[3] as usize);
        trials.extend((0..n).map(|i| MarTrial { eccentricity_deg: fields[0], mar_deg: fields[1], correct: i < k }));
    }
    trials
}

/// The largest error of an estimate and its interval ends, in units of the peer's interval.
fn error(ours: [f64; 3], peer: [f64; 3]) -> f64 {
    let width = peer[2] - peer[0];
    ours.iter().zip(peer).map(|(a, b)| ((a - b) / width).abs()).fold(0.0, f64::max)
}

#[test]
fn mode_moments_quantiles_and_thresholds_agree_with_scipy_and_numpy() {
    let fit = fit_mar(&trials(), &MarFitConfig::default()).unwrap();
    assert_eq!(fit.trials, 700);

    for (name, ours, peer) in [
        ("m", fit.map.m, 0.0209524732),
        ("omega0", fit.map.omega0_deg, 0.0215112855),
        ("width", fit.map.width, 0.934751264),
        ("lapse", fit.map.lapse, 0.00666593),
    ] {
        println!("mode of {name}: off by {:+.1e} relative", ours / peer - 1.0);
        assert!((ours / peer - 1.0).abs() < 1e-5, "mode of {name}: {ours} against {peer}");
    }
    for (name, ours, mean, sd) in [
        ("ln m", fit.moments.ln_m, -3.873547, 0.053218),
        ("ln omega0", fit.moments.ln_omega0, -3.848217, 0.088307),
        ("ln width", fit.moments.ln_width, -0.088820, 0.178628),
        ("lapse", fit.moments.lapse, 0.013454, 0.009313),
    ] {
        println!(
            "{name}: mean off by {:+.4} SD, SD by {:+.2} %",
            (ours.mean - mean) / sd,
            100.0 * (ours.sd / sd - 1.0)
        );
        assert!(((ours.mean - mean) / sd).abs() < 0.03, "mean of {name}");
        assert!((ours.sd / sd - 1.0).abs() < 0.03, "SD of {name}");
    }
    for (name, ours, peer) in [
        ("m", fit.m, [0.018672019, 0.020803986, 0.023012513]),
        ("omega0", fit.omega0, [0.017951799, 0.021304307, 0.025400976]),
        ("width", fit.width, [0.63580735, 0.91902775, 1.2819483]),
        ("lapse", fit.lapse, [0.0010690015, 0.011499196, 0.036194847]),
    ] {
        let error = error([ours.ci95[0], ours.estimate, ours.ci95[1]], peer);
        println!("{name}: median and interval within {error:.4} of the interval");
        assert!(error < 0.02, "{name}: {ours:?} against {peer:?}");
    }
    // Thresholds are integrated by quadrature and held more tightly.
    for (threshold, peer) in fit.thresholds.iter().zip([
        [0.018025803, 0.021440122, 0.025655029],
        [0.091755727, 0.11169321, 0.13606939],
        [0.19072602, 0.22706335, 0.27126215],
        [0.30779424, 0.36426208, 0.43291078],
        [0.36097087, 0.43245687, 0.52038579],
    ]) {
        let error = error([threshold.ci95[0], threshold.mar_deg, threshold.ci95[1]], peer);
        println!("threshold at {}°: within {error:.5} of the interval", threshold.eccentricity_deg);
        assert!(error < 0.005, "{threshold:?} against {peer:?}");
    }
}
