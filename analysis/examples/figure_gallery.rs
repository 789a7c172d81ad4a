//! Every figure of this crate with simulated data: `cargo run --release -p analysis --example figure_gallery -- DIR`
//! writes them as SVG files and `index.html` into the folder, so that anyone can look at them.
//!
//! Observers, ratings and gaze are drawn from known distributions with fixed seeds; none of these numbers is a result.
#![allow(clippy::print_stdout)]

use analysis::figures;
use analysis::figures::{
    BandPoint, BoxChart, BoxGroup, GazeView, GroupLine, HistogramView, Interaction, InteractionLine, InteractionPanel,
    JointPosterior, LevelCount, LikertChart, LikertGroup, LikertRow, LineThreshold, MarGroup, ObserverLine, PatchBlur,
    PsychometricCurve, PsychometricView, Published, QualityMark, RatePoint, RateSeries, RateView, ReferenceLine,
    Speedup, SpeedupPoint, ThresholdGroup, TrackPoint, Whiskers,
};
use analysis::gaze::GazeSample;
use analysis::mar::{Estimate, MarFit, MarFitConfig, MarTrial, fit_mar};
use analysis::report::{Cell, Figure, Section, Table, page};
use analysis::timing::Frame;
use experiments::Display;
use experiments::mar::MarModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::error::Error;
use std::path::Path;

struct Random(ChaCha8Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        self.0.random::<f64>()
    }

    /// About normal: the sum of twelve uniform numbers.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn binomial(&mut self, n: usize, p: f64) -> usize {
        (0..n).filter(|_| self.uniform() < p).count()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: figure_gallery DIR")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let fits = observers()?;
    let mut gallery: Vec<(&str, String)> = vec![
        ("psychometric-one", functions(1, false)),
        ("psychometric-groups", functions(3, false)),
        ("psychometric-multiples", functions(6, true)),
        ("mar-line", figures::mar_line(&fits[0].1)),
        ("psychometric-curves", figures::psychometric_curves(&fits[0].1)),
        ("mar-group", group(&fits)),
        ("joint-posterior", joint(&fits)),
        ("joint-posterior-one", joint(&fits[..1])),
        ("threshold-histograms", histograms()),
        ("speedup", savings()),
        ("likert", likert()),
        ("box-plots", boxes(false)),
        ("box-plots-notched", boxes(true)),
        ("blur-by-eccentricity", blur()),
        ("detection-rates", rates()),
        ("interaction", interaction(1)),
        ("interaction-three-way", interaction(4)),
        ("track", track(&fits[0].1)),
    ];
    let display = Display::named("guenter-2012").ok_or("the display is not known")?;
    gallery.push(("gaze", gaze(&display)));
    gallery.push(("frame-timing", frames()));
    gallery.push(("nothing", figures::threshold_histograms(&[], &histogram_view())));

    let mut sections = Vec::new();
    for (name, svg) in &gallery {
        std::fs::write(folder.join(format!("{name}.svg")), svg)?;
        let figure = Figure { svg: svg.clone(), caption: format!("{name}.svg, simulated data.") };
        sections.push(Section { figures: vec![figure], ..Section::new(*name) });
    }
    let mut table = Table::new("Simulated observers.", &["Observer", "m (°/cycle per °)", "2.5 %", "97.5 %", "Trials"]);
    for (name, fit) in &fits {
        let mut row = vec![Cell::from(name.as_str())];
        row.extend(Cell::estimate(&fit.m));
        row.push(fit.trials.into());
        table.push(row);
    }
    sections.insert(
        0,
        Section {
            prose: vec![
                "Every figure with simulated data, and a table to copy. None of these numbers is a result.".to_owned(),
            ],
            tables: vec![table],
            ..Section::new("What this is")
        },
    );
    let json = serde_json::json!({ "figures": gallery.iter().map(|(name, _)| name).collect::<Vec<_>>() });
    std::fs::write(folder.join("index.html"), page("Figure gallery", &sections, &json))?;
    println!("{} figures and index.html in {}", gallery.len(), folder.display());
    Ok(())
}

/// The cumulative normal distribution, by its logistic approximation (Bowling et al. 2009); good enough to draw.
fn rise(t: f64) -> f64 {
    1.0 / (1.0 + (-0.07056 * t.powi(3) - 1.5976 * t).exp())
}

fn functions(count: usize, small_multiples: bool) -> String {
    let mut random = Random::new(11);
    let names = ["photograph", "foliage", "corridor", "city at night", "noise, 4 cycles per degree", "text"];
    let curves: Vec<PsychometricCurve> = (0..count)
        .map(|i| {
            let threshold = 0.13 * 1.35f64.powi(i as i32);
            let lapse = 0.02;
            let at = |omega: f64| 0.5 + (0.5 - lapse) * rise(3.29 * (omega / threshold).ln() / 0.9);
            let points = (0..8).map(|j| {
                let level = threshold * 1.3f64.powi(j - 4);
                let n = [8, 16, 24, 40, 48, 40, 24, 12][j as usize];
                LevelCount { level, k: random.binomial(n, at(level)), n }
            });
            let points: Vec<LevelCount> = points.collect();
            let band = (0..60).map(|j| {
                let omega = threshold * 0.25 * 1.05f64.powi(j);
                let half = 0.035 + 0.03 * (omega / threshold).ln().abs().min(1.0);
                let mid = at(omega);
                BandPoint { x: omega, low: (mid - half).max(0.5), mid, high: (mid + half).min(0.995) }
            });
            PsychometricCurve {
                name: if count > 1 { names[i].to_owned() } else { String::new() },
                points,
                band: band.collect(),
                threshold: Some(Estimate { estimate: threshold, ci95: [threshold / 1.12, threshold * 1.13] }),
                guess: Some(0.5),
                lapse: Some(lapse),
                supported: i != 4,
            }
        })
        .collect();
    figures::psychometric_functions(
        &curves,
        &PsychometricView {
            level_label: "Detail limit ω (degrees per cycle)".to_owned(),
            share_label: "Share correct".to_owned(),
            logarithmic: true,
            small_multiples,
        },
    )
}

/// Four observers whose lines differ, fitted by the crate itself.
fn observers() -> Result<Vec<(String, MarFit)>, Box<dyn Error>> {
    let truths = [(0.022, 0.021), (0.027, 0.024), (0.0185, 0.03), (0.025, 0.012)];
    let display = Display::named("guenter-2012").ok_or("the display is not known")?;
    let eccentricities = [2.0, 6.0, 11.0, 16.0, 21.0];
    truths
        .iter()
        .enumerate()
        .map(|(i, &(m, omega0_deg))| {
            let truth = MarModel { m, omega0_deg, width: 0.8, lapse: 0.02 };
            let mut random = Random::new(i as u64 + 1);
            let trials: Vec<MarTrial> = (0..400)
                .map(|t| {
                    let eccentricity_deg = eccentricities[t % 5];
                    let mar_deg = truth.threshold_deg(eccentricity_deg) * ((t / 5 % 7) as f64 * 0.25 - 0.75).exp();
                    let p = truth.probability_correct(eccentricity_deg, mar_deg, 0.5);
                    MarTrial { eccentricity_deg, mar_deg, correct: random.uniform() < p }
                })
                .collect();
            let finest_mar = eccentricities.iter().map(|&e| (e, display.finest_mar_deg([e, 0.0]))).collect();
            let fit = fit_mar(&trials, &MarFitConfig { finest_mar, seed: i as u64, ..MarFitConfig::default() })?;
            Ok((format!("P{:02}", i + 1), fit))
        })
        .collect()
}

fn group(fits: &[(String, MarFit)]) -> String {
    let mean = |of: fn(&MarFit) -> f64| fits.iter().map(|(_, fit)| of(fit)).sum::<f64>() / fits.len() as f64;
    let (m, omega0) = (mean(|fit| fit.m.estimate), mean(|fit| fit.omega0.estimate));
    let around =
        |estimate: f64, share: f64| Estimate { estimate, ci95: [estimate * (1.0 - share), estimate * (1.0 + share)] };
    let band = (0..=22).map(|e| {
        let mid = m * f64::from(e) + omega0;
        BandPoint { x: f64::from(e), low: 0.86 * mid, mid, high: 1.15 * mid }
    });
    let line = |(name, fit): &(String, MarFit)| ObserverLine {
        observer: name.clone(),
        m: fit.m.estimate,
        omega0_deg: fit.omega0.estimate,
        thresholds: fit
            .thresholds
            .iter()
            .map(|t| LineThreshold {
                eccentricity_deg: t.eccentricity_deg,
                mar_deg: t.mar_deg,
                ci95: Some(t.ci95),
                limited: t.limited,
            })
            .collect(),
    };
    figures::mar_group(&MarGroup {
        observers: fits.iter().map(line).collect(),
        group: Some(GroupLine { m: around(m, 0.15), omega0: around(omega0, 0.2), band: band.collect() }),
        finest_mar: fits[0].1.config.finest_mar.clone(),
        references: vec![ReferenceLine {
            name: "Guenter 2012, m = 0.0220".to_owned(),
            m: 0.022,
            omega0_deg: 1.0 / 48.0,
        }],
    })
}

fn joint(fits: &[(String, MarFit)]) -> String {
    let posteriors: Vec<JointPosterior> = fits
        .iter()
        .map(|(name, fit)| JointPosterior {
            name: name.clone(),
            draws: fit.posterior.iter().map(|model| [model.m, model.omega0_deg]).collect(),
            estimate: Some([fit.m.estimate, fit.omega0.estimate]),
        })
        .collect();
    figures::joint_posterior(&posteriors)
}

fn histogram_view() -> HistogramView {
    HistogramView { label: "Quality index j (coarse to fine)".to_owned(), bin: Some(1.0), range: Some([4.0, 22.0]) }
}

fn histograms() -> String {
    let mut random = Random::new(3);
    let tests = [("Pair", 14.9, 3.07), ("Ramp", 11.9, 3.48), ("Slider", 14.5, 4.1)];
    let groups: Vec<ThresholdGroup> = tests
        .iter()
        .map(|&(name, mean, sd)| ThresholdGroup {
            name: name.to_owned(),
            values: (0..15).map(|_| (mean + sd * random.normal()).round().clamp(4.0, 22.0)).collect(),
            without: usize::from(name == "Ramp"),
            published: Some(Published { source: "Guenter 2012 (15 observers)".to_owned(), mean, sd }),
        })
        .collect();
    figures::threshold_histograms(&groups, &histogram_view())
}

fn savings() -> String {
    let points = (4..=22).map(|j| {
        let quality = f64::from(j);
        let pixels = 2.2 + 41.0 / quality.powf(0.86);
        SpeedupPoint {
            quality,
            pixels: Some(pixels),
            pixels_half_rate: Some(1.55 * pixels),
            time: Some(0.62 * pixels),
            time_ci95: Some([0.58 * pixels, 0.66 * pixels]),
        }
    });
    figures::speedup(&Speedup {
        points: points.collect(),
        marks: vec![
            QualityMark { name: "A: ramp, j = 11.9".to_owned(), quality: 11.9 },
            QualityMark { name: "B: pair, j = 14.9".to_owned(), quality: 14.9 },
        ],
        published: Vec::new(),
        publication: String::new(),
        layers: Vec::new(),
        slope_times_quality: Some(0.33),
    })
}

fn likert() -> String {
    let mut random = Random::new(5);
    let scenes = ["Sponza", "Tunnel with maps", "Tunnel with geometry", "Rungholt"];
    let groups = [("Small", 0.0), ("Medium", 1.5), ("Large", 1.8), ("Full", 1.9)].map(|(heading, mean)| LikertGroup {
        heading: heading.to_owned(),
        rows: scenes
            .iter()
            .enumerate()
            .map(|(i, scene)| {
                let mut counts = vec![0; 7];
                for _ in 0..45 {
                    let rating = mean - if i == 1 { 1.2 } else { 0.0 } + 1.5 * random.normal();
                    counts[(rating.round().clamp(-3.0, 3.0) + 3.0) as usize] += 1;
                }
                LikertRow { name: (*scene).to_owned(), counts }
            })
            .collect(),
    });
    figures::likert_bars(&LikertChart {
        title: "The sequence was free of visual artefacts".to_owned(),
        steps: [-3, 3],
        ends: ["strongly disagree".to_owned(), "strongly agree".to_owned()],
        groups: groups.to_vec(),
    })
}

fn boxes(notches: bool) -> String {
    let mut random = Random::new(8);
    let groups = [("Small", 0.1, 1.8), ("Medium", 1.4, 1.3), ("Large", 1.6, 1.2), ("Full", 1.8, 0.8)];
    figures::box_plots(&BoxChart {
        title: "Ratings by foveal region".to_owned(),
        label: if notches { "Response time (s)" } else { "Rating (−3 to 3)" }.to_owned(),
        groups: groups
            .iter()
            .map(|&(name, mean, sd)| BoxGroup {
                name: name.to_owned(),
                values: (0..60)
                    .map(|_| {
                        let value = mean + sd * random.normal();
                        if notches { (0.4 * value).exp() } else { value.round().clamp(-3.0, 3.0) }
                    })
                    .collect(),
            })
            .collect(),
        whiskers: Whiskers::Tukey,
        notches,
        range: (!notches).then_some([-3.0, 3.0]),
    })
}

fn blur() -> String {
    let mut random = Random::new(9);
    let patches: Vec<PatchBlur> = (0..18)
        .map(|i| {
            let strength = (0.5 * random.normal()).exp();
            PatchBlur {
                patch: format!("patch {:02}", i + 1),
                points: [5.0, 10.0, 15.0, 20.0, 25.0, 30.0]
                    .map(|e| [e, strength * (0.15 + 0.0018 * e * e) * (0.12 * random.normal()).exp()])
                    .to_vec(),
            }
        })
        .collect();
    figures::blur_by_eccentricity(&patches, "Tolerable blur σₛ (px)")
}

fn rates() -> String {
    let series = [("GLSL, desktop", 12, 0.0), ("Unity, headset", 14, 0.05), ("VRS, desktop", 5, -0.06)];
    let points = |shift: f64, n: usize| {
        [1.0, 2.0, 3.0, 4.0, 5.0]
            .map(|multiplier| {
                let rate: f64 = 0.5 + 0.48 * (1.0 - f64::exp(-0.42 * multiplier)) + shift;
                RatePoint { multiplier, rate, standard_error: Some((rate * (1.0 - rate) / (4.0 * n as f64)).sqrt()), n }
            })
            .to_vec()
    };
    let series: Vec<RateSeries> =
        series.iter().map(|&(name, n, shift)| RateSeries { name: name.to_owned(), points: points(shift, n) }).collect();
    let view = RateView {
        label: "Multiplier of the predicted σₛ".to_owned(),
        chance: Some(0.5),
        criterion: Some(0.75),
        logarithmic: false,
    };
    figures::detection_rates(&series, &view)
}

fn interaction(panels: usize) -> String {
    let mut random = Random::new(14);
    let scenes = ["Sponza", "Tunnel with maps", "Tunnel with geometry", "Rungholt"];
    let levels = ["small", "medium", "large", "full"];
    let fixations = ["fixed", "moving target", "free"];
    let make = |panel: usize, random: &mut Random| {
        let values: Vec<Vec<f64>> = (0..15)
            .map(|_| {
                let own = 0.9 * random.normal();
                (0..12)
                    .map(|cell| {
                        let (line, level) = (cell / 4, cell % 4);
                        let effect = [0.2, 1.3, 1.5, 1.7][level] - 0.25 * line as f64 * (3 - level) as f64;
                        own + effect - 0.3 * panel as f64 + 0.5 * random.normal()
                    })
                    .collect()
            })
            .collect();
        let means = figures::within_subject_means(&values);
        let lines = fixations.iter().enumerate().map(|(line, name)| InteractionLine {
            name: (*name).to_owned(),
            cells: means[4 * line..4 * line + 4].iter().copied().map(Some).collect(),
        });
        InteractionPanel {
            name: if panels > 1 { scenes[panel].to_owned() } else { String::new() },
            lines: lines.collect(),
        }
    };
    figures::interaction(&Interaction {
        label: "Mean rating (−3 to 3)".to_owned(),
        factor: "Foveal region".to_owned(),
        levels: levels.iter().map(|level| (*level).to_owned()).collect(),
        interval: "within-subject 95 % (Cousineau–Morey)".to_owned(),
        panels: (0..panels).map(|panel| make(panel, &mut random)).collect(),
    })
}

fn track(fit: &MarFit) -> String {
    let mut random = Random::new(2);
    let track: Vec<TrackPoint> = (0..200)
        .map(|i| {
            let wide = 1.0 + 9.0 / (f64::from(i) + 2.0);
            let around = |e: &Estimate| Estimate { estimate: e.estimate, ci95: [e.ci95[0] / wide, e.ci95[1] * wide] };
            let eccentricity_deg = fit.thresholds[i as usize % 5].eccentricity_deg;
            TrackPoint {
                trial: i + 1,
                eccentricity_deg,
                mar_deg: fit.line_at(eccentricity_deg).estimate * (0.35 * random.normal() * wide.min(2.5)).exp(),
                correct: random.uniform() < 0.8,
                m: Some(around(&fit.m)),
                omega0: Some(around(&fit.omega0)),
            }
        })
        .collect();
    figures::adaptive_track(&track)
}

fn gaze(display: &Display) -> String {
    let mut random = Random::new(6);
    let mut drift = [0.0f64; 2];
    let samples: Vec<GazeSample> = (0..40_000)
        .map(|i| {
            drift = drift.map(|d| 0.995 * d + 0.08 * (random.uniform() - 0.5));
            let away = if i % 4000 > 3900 { [6.0 + random.normal(), 2.0 + random.normal()] } else { [0.0, 0.0] };
            let position_deg = [drift[0] + away[0], drift[1] + away[1]];
            GazeSample {
                t_s: f64::from(i) * 0.004,
                position_deg,
                deviation_deg: position_deg[0].hypot(position_deg[1]),
                valid: i % 400 > 6,
            }
        })
        .collect();
    let view = GazeView { half_field_deg: display.half_field_deg(), fixation_deg: [0.0, 0.0], gate_deg: Some(2.0) };
    figures::gaze_density(&samples, &view)
}

fn frames() -> String {
    let mut random = Random::new(4);
    let mut presented_s = 0.0;
    let frames: Vec<Frame> = (0..24_000)
        .map(|i| {
            let missed = i % 1571 == 1570 || (4000..4005).contains(&i);
            presented_s += if missed { 2.0 } else { 1.0 + 0.02 * (random.uniform() - 0.5) } / 120.0;
            Frame { presented_s, missed, gaze_age_s: Some(0.004 + 0.006 * random.uniform()), after_gap: i % 300 == 0 }
        })
        .collect();
    figures::frame_timing(&frames, Some(120.0))
}
