//! Trials checked and counted: the only form in which the fit sees the data.
//!
//! Equal (eccentricity, omega) pairs become one binomial cell; cells that the display could not show are kept for the
//! record but leave the likelihood (see the parent module).

use super::{MarFitConfig, MarTrial};
use serde::{Deserialize, Serialize};

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Nothing to fit.
    #[error("no trials: a fit needs at least one answered trial")]
    NoTrials,
    /// A trial holds an impossible number.
    #[error("trial {index} (counted from 0): {field} must be {expected}, found {found}")]
    BadTrial {
        /// Position in the slice given, from 0.
        index: usize,
        /// The field at fault.
        field: &'static str,
        /// What would have been accepted.
        expected: &'static str,
        /// What was there.
        found: f64,
    },
    /// The configuration is impossible.
    #[error("fit configuration: {field} must be {expected}, found {found}")]
    BadConfig {
        /// The field at fault.
        field: &'static str,
        /// What would have been accepted.
        expected: &'static str,
        /// What was there.
        found: f64,
    },
}

/// The answers at one eccentricity and one omega.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Eccentricity, degrees.
    pub eccentricity_deg: f64,
    /// Detail limit shown, degrees per cycle.
    pub mar_deg: f64,
    /// Trials.
    pub n: u32,
    /// Correct answers.
    pub k: u32,
    /// False when the display could not show so fine a limit: the cell is left out of the likelihood.
    pub shown: bool,
}

/// A shown cell, ready for the likelihood.
#[derive(Debug, Clone, Copy)]
pub(super) struct Count {
    pub(super) ln_omega: f64,
    pub(super) correct: f64,
    pub(super) wrong: f64,
}

/// All that was seen at one eccentricity.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    pub(super) eccentricity_deg: f64,
    pub(super) ln_e: f64,
    pub(super) counts: Vec<Count>,
    pub(super) trials: usize,
}

/// The checked and counted data.
#[derive(Debug, Clone)]
pub(super) struct Data {
    pub(super) cells: Vec<Cell>,
    pub(super) rings: Vec<Ring>,
    pub(super) not_shown: usize,
}

impl Data {
    pub(super) fn new(trials: &[MarTrial], config: &MarFitConfig) -> Result<Self, FitError> {
        check_config(config)?;
        if trials.is_empty() {
            return Err(FitError::NoTrials);
        }
        for (index, trial) in trials.iter().enumerate() {
            if !(0.0..=180.0).contains(&trial.eccentricity_deg) {
                return Err(FitError::BadTrial {
                    index,
                    field: "eccentricity_deg",
                    expected: "degrees from 0 to 180",
                    found: trial.eccentricity_deg,
                });
            }
            if !(trial.mar_deg.is_finite() && trial.mar_deg > 0.0) {
                return Err(FitError::BadTrial {
                    index,
                    field: "mar_deg",
                    expected: "degrees per cycle, finite and above 0",
                    found: trial.mar_deg,
                });
            }
        }

        let cells = count(trials, config);
        let not_shown = cells.iter().filter(|cell| !cell.shown).map(|cell| cell.n as usize).sum();
        let mut rings: Vec<Ring> = Vec::new();
        for cell in &cells {
            if rings.last().is_none_or(|ring| ring.eccentricity_deg < cell.eccentricity_deg) {
                rings.push(Ring {
                    eccentricity_deg: cell.eccentricity_deg,
                    ln_e: cell.eccentricity_deg.ln(),
                    counts: Vec::new(),
                    trials: 0,
                });
            }
            if let Some(ring) = rings.last_mut() {
                ring.trials += cell.n as usize;
                if cell.shown {
                    ring.counts.push(Count {
                        ln_omega: cell.mar_deg.ln(),
                        correct: f64::from(cell.k),
                        wrong: f64::from(cell.n - cell.k),
                    });
                }
            }
        }
        Ok(Self { cells, rings, not_shown })
    }
}

/// Cells in ascending order of eccentricity, then omega.
fn count(trials: &[MarTrial], config: &MarFitConfig) -> Vec<Cell> {
    let mut sorted: Vec<&MarTrial> = trials.iter().collect();
    sorted.sort_by(|a, b| a.eccentricity_deg.total_cmp(&b.eccentricity_deg).then(a.mar_deg.total_cmp(&b.mar_deg)));
    let mut cells: Vec<Cell> = Vec::new();
    for trial in sorted {
        // −0.0 and 0.0 are one eccentricity.
        let eccentricity_deg = trial.eccentricity_deg + 0.0;
        match cells.last_mut() {
            Some(cell) if cell.eccentricity_deg == eccentricity_deg && cell.mar_deg == trial.mar_deg => {
                cell.n += 1;
                cell.k += u32::from(trial.correct);
            }
            _ => cells.push(Cell {
                eccentricity_deg,
                mar_deg: trial.mar_deg,
                n: 1,
                k: u32::from(trial.correct),
                shown: config
                    .finest_mar_at(eccentricity_deg)
                    .is_none_or(|finest| trial.mar_deg > finest * (1.0 + 1e-9)),
            }),
        }
    }
    cells
}

pub(super) fn check_config(config: &MarFitConfig) -> Result<(), FitError> {
    let bad = |field, expected, found| Err(FitError::BadConfig { field, expected, found });
    if !(0.0..=0.95).contains(&config.guess) {
        return bad("guess", "a probability from 0 to 0.95", config.guess);
    }
    let priors = &config.priors;
    for (field, prior) in [("priors.m", priors.m), ("priors.omega0", priors.omega0), ("priors.width", priors.width)] {
        if !(1e-9..=1e9).contains(&prior.median) {
            return bad(field, "a median from 1e-9 to 1e9", prior.median);
        }
        if !(1e-6..=20.0).contains(&prior.sd_ln) {
            return bad(field, "a standard deviation of the logarithm from 1e-6 to 20", prior.sd_ln);
        }
    }
    for shape in priors.lapse_beta {
        if !(1.0..=1e6).contains(&shape) {
            return bad("priors.lapse_beta", "shape parameters from 1 to 1e6", shape);
        }
    }
    for &(eccentricity_deg, omega) in &config.finest_mar {
        if !(0.0..=180.0).contains(&eccentricity_deg) {
            return bad("finest_mar", "eccentricities from 0 to 180 degrees", eccentricity_deg);
        }
        if !(omega.is_finite() && omega > 0.0) {
            return bad("finest_mar", "degrees per cycle, finite and above 0", omega);
        }
    }
    if !(256..=10_000_000).contains(&config.draws) {
        return bad("draws", "from 256 to 10 million", config.draws as f64);
    }
    Ok(())
}

/// Piecewise linear through unsorted `(x, y)` points, constant outside them; `None` for no points.
pub(super) fn interpolate(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let below = points.iter().filter(|p| p.0 <= x).max_by(|a, b| a.0.total_cmp(&b.0));
    let above = points.iter().filter(|p| p.0 >= x).min_by(|a, b| a.0.total_cmp(&b.0));
    match (below, above) {
        (Some(a), Some(b)) if b.0 > a.0 => Some(a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0)),
        (Some(a), _) => Some(a.1),
        (None, Some(b)) => Some(b.1),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finest_mar_is_interpolated_and_held_outside() {
        let points = [(10.0, 0.04), (5.0, 0.05)];
        assert_eq!(interpolate(&points, 0.0), Some(0.05));
        assert!((interpolate(&points, 7.5).unwrap_or(0.0) - 0.045).abs() < 1e-12);
        assert_eq!(interpolate(&points, 30.0), Some(0.04));
        assert_eq!(interpolate(&[], 3.0), None);
    }
}
