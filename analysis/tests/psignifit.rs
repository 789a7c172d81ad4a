//! Against psignifit 4.3: `tests/peers/psignifit_peer.py` wrote `psignifit_4_3.json`.
//!
//! Held: our mode has at least the density of theirs; our means are theirs within 0.05 posterior standard deviations; our
//! intervals are theirs once their known shift by half a grid step is put right, within a step of their grid.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use analysis::psychometric::{
    Count, Guess, Overdispersion, Psychometric, PsychometricConfig, PsychometricPosterior, Scale, Sigmoid,
};
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct Peer {
    origin: String,
    fits: Vec<Fit>,
}

#[derive(Deserialize)]
struct Fit {
    data: String,
    sigmoid: String,
    experiment: String,
    levels: Vec<f64>,
    n: Vec<u32>,
    k: Vec<u32>,
    map: BTreeMap<String, f64>,
    mean: BTreeMap<String, f64>,
    ci95: BTreeMap<String, [f64; 2]>,
    step: BTreeMap<String, f64>,
}

impl Fit {
    fn counts(&self) -> Vec<Count> {
        let rows = self.levels.iter().zip(&self.n).zip(&self.k);
        rows.map(|((&level, &n), &k)| Count { level, n, k }).collect()
    }

    fn config(&self) -> PsychometricConfig {
        let sigmoid = match self.sigmoid.as_str() {
            "norm" => Sigmoid::CumulativeGauss,
            "logistic" => Sigmoid::Logistic,
            "gumbel" => Sigmoid::Gumbel,
            "rgumbel" => Sigmoid::ReversedGumbel,
            "tdist" => Sigmoid::StudentT { df: 1.0 },
            "weibull" => Sigmoid::Weibull,
            other => panic!("unknown shape {other}"),
        };
        let guess = match self.experiment.as_str() {
            "2AFC" => Guess::of_alternatives(2),
            "3AFC" => Guess::of_alternatives(3),
            _ => Guess::Free,
        };
        PsychometricConfig {
            sigmoid,
            guess,
            scale: if sigmoid == Sigmoid::Weibull { Scale::Logarithmic } else { Scale::Linear },
            overdispersion: Overdispersion::Free,
            ..PsychometricConfig::TWO_ALTERNATIVES
        }
    }

    /// Theirs is in the axis's coordinate.
    fn function(&self, of: &BTreeMap<String, f64>) -> Psychometric {
        Psychometric {
            threshold: self.config().scale.level(of["threshold"]),
            width: of["width"],
            lapse: of["lambda"],
            guess: of["gamma"],
            overdispersion: of["eta"],
        }
    }
}

fn peer() -> Peer {
    serde_json::from_str(include_str!("psignifit_4_3.json")).unwrap()
}

#[test]
fn modes_are_at_least_as_high() {
    let peer = peer();
    println!("{}", peer.origin);
    for fit in &peer.fits {
        let posterior = PsychometricPosterior::new(&fit.counts(), &fit.config()).unwrap();
        let theirs = posterior.ln_density(&fit.function(&fit.map));
        let ours = posterior.ln_density_at_map();
        let map = posterior.map();
        println!(
            "{} {} {}: {:+.2e}  threshold {:.5} {:.5} width {:.5} {:.5}",
            fit.data,
            fit.sigmoid,
            fit.experiment,
            ours - theirs,
            map.threshold,
            fit.map["threshold"],
            map.width,
            fit.map["width"]
        );
        assert!(ours >= theirs - 1e-9, "{} {} {}", fit.data, fit.sigmoid, fit.experiment);
        assert!(ours - theirs < 0.01, "psignifit would have found it: {}", ours - theirs);
    }
}

#[test]
fn means_and_intervals_are_psignifits() {
    for fit in &peer().fits {
        let posterior = PsychometricPosterior::new(&fit.counts(), &fit.config()).unwrap();
        let (summary, mean) = (posterior.fit(), posterior.mean());
        let width_sd = posterior.ln_width.sd * mean.width;
        let coordinate = |level: f64| fit.config().scale.coordinate(level);
        let threshold_ends = summary.threshold.ci95.map(coordinate);
        let (threshold, lapse, eta) = (&posterior.threshold, &posterior.lapse, &posterior.overdispersion);
        let rows = [
            ("threshold", coordinate(mean.threshold), threshold.sd, threshold_ends),
            ("width", mean.width, width_sd, summary.width.ci95),
            ("lambda", mean.lapse, lapse.sd, summary.lapse.ci95),
            ("eta", mean.overdispersion, eta.sd, summary.overdispersion.ci95),
        ];
        for (name, ours, sd, ci95) in rows {
            let off = (ours - fit.mean[name]) / sd;
            let step = fit.step[name];
            let shifted = fit.ci95[name].map(|end| end + 0.5 * step);
            let ends = [0, 1].map(|i| (ci95[i] - shifted[i]) / step);
            println!(
                "{} {} {} {name}: mean off by {off:+.3} SD, ends by {:+.2} {:+.2} steps of {:.3} SD",
                fit.data,
                fit.sigmoid,
                fit.experiment,
                ends[0],
                ends[1],
                step / sd
            );
            assert!(off.abs() < 0.05);
            assert!(ends.iter().all(|end| end.abs() < 1.0));
        }
    }
}
