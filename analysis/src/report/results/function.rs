//! Single psychometric functions: a table of parameters and the curves with their bands.

use crate::figures::{BandPoint, LevelCount, PsychometricCurve, PsychometricView, psychometric_functions};
use crate::mar::Estimate;
use crate::psychometric::{PsychometricPosterior, Scale};
use crate::report::page::{Cell, Figure, Section, Table};

/// Points of a curve.
const POINTS: u32 = 49;

/// One fitted function.
#[derive(Debug, Clone, Copy)]
pub struct FunctionFit<'a> {
    /// Its group; may be empty.
    pub name: &'a str,
    /// Its posterior.
    pub posterior: &'a PsychometricPosterior,
    /// The deviance's simulated p.
    pub deviance_p: Option<f64>,
}

/// Functions of one variable, whose name and unit are `level_label`.
#[must_use]
pub fn functions_section(fits: &[FunctionFit<'_>], level_label: &str) -> Section {
    let mut section = Section::new("Psychometric functions");
    let Some(first) = fits.first() else { return section };
    let mut table = Table::new(
        "Posterior medians with 95 % intervals, modes, and the deviance of the mode with its simulated p.",
        &["Group", "Parameter", "Median", "2.5 %", "97.5 %", "Mode", "Answers", "Deviance", "p"],
    );
    for fit in fits {
        let summary = fit.posterior.fit();
        let rows: [(&str, &Estimate, f64); 5] = [
            ("threshold", &summary.threshold, summary.map.threshold),
            ("width", &summary.width, summary.map.width),
            ("lapse rate", &summary.lapse, summary.map.lapse),
            ("guess rate", &summary.guess, summary.map.guess),
            ("overdispersion", &summary.overdispersion, summary.map.overdispersion),
        ];
        for (name, estimate, mode) in rows {
            let mut row: Vec<Cell> = vec![fit.name.into(), name.into()];
            row.extend(Cell::estimate(estimate));
            row.extend([
                mode.into(),
                (summary.n_trials() as f64).into(),
                Cell::maybe(summary.deviance),
                Cell::maybe(fit.deviance_p),
            ]);
            table.push(row);
        }
        let named = |text: &String| if fit.name.is_empty() { text.clone() } else { format!("{}: {text}", fit.name) };
        section.warnings.extend(summary.support.reasons().iter().map(named));
        section.prose.extend(summary.warnings.iter().map(named));
    }
    section.tables.push(table);
    let view = PsychometricView {
        level_label: level_label.to_owned(),
        share_label: "Share of right answers".to_owned(),
        logarithmic: first.posterior.config().scale == Scale::Logarithmic,
        small_multiples: fits.len() > 3,
    };
    let curves: Vec<PsychometricCurve> = fits.iter().map(curve).collect();
    section.figures.push(Figure {
        svg: psychometric_functions(&curves, &view),
        caption: "Shares of right answers with 95 % Wilson intervals, areas as numbers of answers; the curve's posterior median \
                  with its pointwise 95 % band; the threshold with its 95 % interval. Dashed: not supported by the data."
            .to_owned(),
    });
    section
}

/// A curve with its band, over the levels and a tenth of their range beyond.
fn curve(fit: &FunctionFit<'_>) -> PsychometricCurve {
    let (posterior, summary) = (fit.posterior, fit.posterior.fit());
    let config = posterior.config();
    let counts = posterior.counts();
    let ends =
        [counts.first(), counts.last()].map(|count| count.map_or(0.0, |count| config.scale.coordinate(count.level)));
    let margin = 0.1 * (ends[1] - ends[0]);
    let (low, high) = (ends[0] - margin, ends[1] + margin);
    let above_zero = config.sigmoid == crate::psychometric::Sigmoid::Weibull;
    let band = (0..POINTS)
        .map(|i| config.scale.level(low + (high - low) * f64::from(i) / f64::from(POINTS - 1)))
        .filter(|level| *level > 0.0 || !above_zero)
        .filter_map(|x| {
            let Estimate { estimate, ci95: [low, high] } = posterior.probability_at(x)?;
            Some(BandPoint { x, low, mid: estimate, high })
        })
        .collect();
    PsychometricCurve {
        name: fit.name.to_owned(),
        points: counts
            .iter()
            .map(|count| LevelCount { level: count.level, k: count.k as usize, n: count.n as usize })
            .collect(),
        band,
        threshold: Some(summary.threshold),
        guess: Some(summary.guess.estimate),
        lapse: Some(summary.lapse.estimate),
        supported: summary.support.is_supported(),
    }
}
