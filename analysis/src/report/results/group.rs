//! The pooled MAR line over observers, and whether the line is one.

use crate::figures::{BandPoint, GroupLine, JointPosterior, LineThreshold, MarGroup, ObserverLine, ReferenceLine};
use crate::figures::{joint_posterior, mar_group};
use crate::mar::hierarchical::{HierarchicalFit, Shrunken};
use crate::mar::linearity::Linearity;
use crate::mar::{Estimate, MarFit};
use crate::report::page::{Cell, Figure, Section, Table};
use crate::report::tables::{GroupParameter, HierarchicalGroup, group_section};

/// Points of the group's line.
const POINTS: u32 = 41;

/// The group's line with its observers; `fits` are theirs alone, by observer, in any order.
#[must_use]
pub fn pooled_section(group: &HierarchicalFit, fits: &[(String, &MarFit)]) -> Section {
    let parameter = |name: &str, of: &dyn Fn(&HierarchicalFit) -> (Estimate, Estimate), each: &[(String, Shrunken)]| {
        let (typical, spread) = of(group);
        GroupParameter {
            name: name.to_owned(),
            typical,
            spread: Some(spread),
            spread_unit: "ln".to_owned(),
            observers: each.iter().map(|(id, own)| (id.clone(), Some(own.alone), Some(own.pooled))).collect(),
        }
    };
    let each = |of: fn(&crate::mar::hierarchical::ObserverEstimate) -> Shrunken| -> Vec<(String, Shrunken)> {
        group.observers.iter().map(|observer| (observer.id.clone(), of(observer))).collect()
    };
    let mut section = group_section(&HierarchicalGroup {
        method: vec![format!(
            "One model was fitted to all {} observers (partial pooling of ln m, ln omega0 and ln width; half-t priors on the \
             standard deviations between observers; a shared lapse prior), integrated by {} draws of a Markov chain (largest \
             R-hat {:.3}, least effective sample size {:.0}). A new observer of the population would have an m of {:.4} to \
             {:.4} with 95 % probability.",
            group.observers.len(),
            group.diagnostics.draws,
            group.diagnostics.max_r_hat,
            group.diagnostics.least_ess,
            group.m.new_observer.ci95[0],
            group.m.new_observer.ci95[1],
        )],
        warnings: group.warnings.clone(),
        parameters: vec![
            parameter("m (degrees per cycle per degree)", &|g| (g.m.median, g.m.sd_ln), &each(|o| o.m)),
            parameter("omega0 (degrees per cycle)", &|g| (g.omega0.median, g.omega0.sd_ln), &each(|o| o.omega0)),
            parameter("width (ln omega)", &|g| (g.width.median, g.width.sd_ln), &each(|o| o.width)),
        ],
    });
    section.figures.push(Figure {
        svg: mar_group(&line_figure(group, fits)),
        caption:
            "Thresholds and lines of every observer, and the line of the typical one with its pointwise 95 % band. The \
                  dashed lines are those of Guenter et al. (2012)."
                .to_owned(),
    });
    let mut posteriors: Vec<JointPosterior> = fits
        .iter()
        .map(|(observer, fit)| JointPosterior {
            name: observer.clone(),
            draws: fit.posterior.iter().map(|model| [model.m, model.omega0_deg]).collect(),
            estimate: Some([fit.m.estimate, fit.omega0.estimate]),
        })
        .collect();
    posteriors.push(JointPosterior {
        name: "typical observer".to_owned(),
        draws: group.posterior.iter().map(|draw| [draw.m, draw.omega0_deg]).collect(),
        estimate: Some([group.m.median.estimate, group.omega0.median.estimate]),
    });
    section.figures.push(Figure {
        svg: joint_posterior(&posteriors),
        caption: "Joint posterior of m and omega0: regions that hold 50 % and 95 %, for every observer alone and for the typical \
                  one."
            .to_owned(),
    });
    section
}

fn line_figure(group: &HierarchicalFit, fits: &[(String, &MarFit)]) -> MarGroup {
    let farthest = fits
        .iter()
        .flat_map(|(_, fit)| fit.thresholds.iter().map(|threshold| threshold.eccentricity_deg))
        .fold(1.0, f64::max);
    let band = (0..POINTS)
        .map(|i| {
            let x = farthest * f64::from(i) / f64::from(POINTS - 1);
            let Estimate { estimate, ci95: [low, high] } = group.line_at(x);
            BandPoint { x, low, mid: estimate, high }
        })
        .collect();
    let reference = |m: f64, name: &str| ReferenceLine { name: name.to_owned(), m, omega0_deg: 1.0 / 48.0 };
    MarGroup {
        observers: fits
            .iter()
            .map(|(observer, fit)| ObserverLine {
                observer: observer.clone(),
                m: fit.m.estimate,
                omega0_deg: fit.omega0.estimate,
                thresholds: fit
                    .thresholds
                    .iter()
                    .map(|threshold| LineThreshold {
                        eccentricity_deg: threshold.eccentricity_deg,
                        mar_deg: threshold.mar_deg,
                        ci95: Some(threshold.ci95),
                        limited: threshold.limited,
                    })
                    .collect(),
            })
            .collect(),
        group: Some(GroupLine { m: group.m.median, omega0: group.omega0.median, band }),
        finest_mar: fits.first().map(|(_, fit)| fit.config.finest_mar.clone()).unwrap_or_default(),
        references: vec![reference(0.0220, "Guenter 2012, m = 0.0220"), reference(0.0275, "Guenter 2012, m = 0.0275")],
    }
}

/// Whether MAR grows along a line: a quadratic term and a bend, for every observer.
#[must_use]
pub fn linearity_section(tests: &[(String, &Linearity)]) -> Section {
    let mut section = Section::new("Is it a line?");
    if tests.is_empty() {
        return section;
    }
    section.prose.push(
        "The line was held against a line with a quadratic term and against a line with one bend, by likelihood ratio with the \
         same psychometric function and lapse rate. The place of a bend is not defined if there is none, so that its p comes \
         from data sets simulated from the line. A lower AIC speaks for a model."
            .to_owned(),
    );
    let mut table = Table::new(
        "Tests of the line.",
        &[
            "Observer",
            "AIC of the line",
            "χ² quadratic",
            "df",
            "p",
            "AIC",
            "χ² bend",
            "p simulated",
            "Bend at (°)",
            "AIC",
        ],
    );
    for (observer, test) in tests {
        let bend = test.broken.as_ref();
        table.push([
            observer.as_str().into(),
            test.line.size.aic.into(),
            test.quadratic.test.deviance_difference.into(),
            (test.quadratic.test.df as f64).into(),
            Cell::maybe(test.quadratic.test.p_chi_square),
            test.quadratic.size.aic.into(),
            Cell::maybe(bend.map(|bend| bend.test.deviance_difference)),
            Cell::maybe(bend.and_then(|bend| bend.test.p_simulated)),
            Cell::maybe(bend.map(|bend| bend.break_deg)),
            Cell::maybe(bend.map(|bend| bend.size.aic)),
        ]);
    }
    section.tables.push(table);
    section
}
