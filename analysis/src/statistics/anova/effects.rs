//! Sums of squares and tests of every effect, from one orthonormal transform of the table.
//!
//! Each factor's levels are turned into their mean (times √L) and L − 1 normalised Helmert contrasts. Doing so along
//! every factor multiplies each subject's row by the Kronecker product of these matrices; every effect is then a set of
//! columns, no two effects share one, and sums of squares add up to the total by construction.

use super::Anova;
use super::sphericity::{Corrected, HuynhFeldt, Mauchly, Sphericity};
use super::table::Table;
use crate::statistics::distributions::{f_tails, noncentrality_limits_of_f};
use serde::{Deserialize, Serialize};

/// A main effect or an interaction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// The factors that interact; one for a main effect.
    pub factors: Vec<String>,
    /// Sum of squares, in the square of the data's unit.
    pub ss: f64,
    /// Degrees of freedom.
    pub df: usize,
    /// Sum of squares of the effect's interaction with subjects.
    pub ss_error: f64,
    /// Its degrees of freedom.
    pub df_error: usize,
    /// `ss / df`.
    pub mean_square: f64,
    /// `ss_error / df_error`.
    pub mean_square_error: f64,
    /// Generalised η² (Olejnik & Algina 2003, eq. 2, all factors manipulated): SS / (SS + SS of subjects + SS of all
    /// errors). Nothing where all of these are 0.
    pub generalised_eta_squared: Option<f64>,
    /// The test; nothing where all subjects show exactly the same effect, so that there is no error to hold it against.
    pub test: Option<EffectTest>,
}

/// An effect's F test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectTest {
    /// Mean square over mean square of error.
    pub f: f64,
    /// p if sphericity holds.
    pub p: f64,
    /// Greenhouse and Geisser's (1959) ε and p.
    pub greenhouse_geisser: Corrected,
    /// Huynh and Feldt's (1976) ε and p; nothing where their ratio is not defined (too few subjects).
    pub huynh_feldt: Option<HuynhFeldt>,
    /// Whether sphericity holds.
    pub mauchly: Mauchly,
    /// SS / (SS + SS of error).
    pub partial_eta_squared: EtaSquared,
}

/// A share of variance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EtaSquared {
    /// In the sample.
    pub estimate: f64,
    /// Interval of the noncentrality λ that F is compatible with, under sphericity (Steiger 2004).
    pub noncentrality_ci: [f64; 2],
    /// The same as a share of variance: λ / (λ + df + df_error + 1) (Steiger 2004; Smithson 2003). The whole interval
    /// can lie below the estimate, which is biased upwards.
    pub ci: [f64; 2],
}

impl Effect {
    /// The factors with × between them.
    #[must_use]
    pub fn name(&self) -> String {
        self.factors.join(" × ")
    }
}

pub(super) fn effects(table: &Table, confidence: f64) -> Anova {
    let cells = table.cells();
    let n = table.subjects().len();
    let lengths: Vec<usize> = table.factors().iter().map(|factor| factor.levels.len()).collect();

    // Around the grand mean, so that a large offset costs no digits.
    let grand_mean = crate::statistics::mean(table.values());
    let mut rows: Vec<f64> = table.values().iter().map(|value| value - grand_mean).collect();
    let ss_total: f64 = rows.iter().map(|value| value * value).sum();
    let largest = table.values().iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let rounding = 16.0 * f64::EPSILON * largest * (cells as f64).sqrt();
    rows.chunks_mut(cells).for_each(|row| to_contrasts(row, &lengths));

    // Columns of every effect: which factors vary in them, as bits.
    let mut columns: Vec<Vec<usize>> = vec![Vec::new(); 1 << lengths.len()];
    for cell in 0..cells {
        let (mut rest, mut mask) = (cell, 0);
        for (bit, length) in lengths.iter().enumerate().rev() {
            mask |= usize::from(rest % length > 0) << bit;
            rest /= length;
        }
        columns[mask].push(cell);
    }
    let mut masks: Vec<usize> = (1..columns.len()).collect();
    // Main effects first; among equals, in the order of the factors' names in the table.
    masks.sort_by_key(|mask| (mask.count_ones(), mask.reverse_bits().wrapping_neg()));

    let ss_subjects = {
        let mean = rows.iter().step_by(cells).sum::<f64>() / n as f64;
        rows.iter().step_by(cells).map(|value| (value - mean).powi(2)).sum::<f64>()
    };
    let parts: Vec<Part> = masks.iter().map(|&mask| Part::new(&rows, cells, &columns[mask])).collect();
    let ss_all_errors: f64 = ss_subjects + parts.iter().map(|part| part.ss_error).sum::<f64>();
    let effects = masks
        .iter()
        .zip(&parts)
        .map(|(mask, part)| {
            let factors =
                table.factors().iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1).map(|(_, f)| f.name.clone());
            part.effect(factors.collect(), n, ss_all_errors, rounding, confidence)
        })
        .collect();
    Anova { effects, grand_mean, ss_total, ss_subjects, df_subjects: n - 1, table: table.clone(), confidence }
}

/// Replaces a subject's row by its orthonormal contrasts along every factor; contrast 0 of a factor is its mean.
fn to_contrasts(row: &mut [f64], lengths: &[usize]) {
    let mut inner = row.len();
    for &length in lengths {
        inner /= length;
        for block in row.chunks_mut(inner * length) {
            for offset in 0..inner {
                // The sum so far is kept in place of the level that has been used.
                let mut sum = block[offset];
                for level in 1..length {
                    let at = offset + level * inner;
                    let used = level as f64;
                    let contrast = (sum - used * block[at]) / (used * (used + 1.0)).sqrt();
                    sum += block[at];
                    block[at] = contrast;
                }
                block[offset] = sum / (length as f64).sqrt();
            }
        }
    }
}

/// An effect's contrasts: subjects × df, around their means over subjects.
struct Part {
    deviations: Vec<f64>,
    df: usize,
    ss: f64,
    ss_error: f64,
}

impl Part {
    fn new(rows: &[f64], cells: usize, columns: &[usize]) -> Self {
        let n = (rows.len() / cells) as f64;
        let mut deviations: Vec<f64> =
            rows.chunks(cells).flat_map(|row| columns.iter().map(|&column| row[column])).collect();
        let df = columns.len();
        let mut ss = 0.0;
        for contrast in 0..df {
            let mean = deviations.iter().skip(contrast).step_by(df).sum::<f64>() / n;
            deviations.iter_mut().skip(contrast).step_by(df).for_each(|value| *value -= mean);
            ss += n * mean * mean;
        }
        let ss_error = deviations.iter().map(|value| value * value).sum();
        Self { deviations, df, ss, ss_error }
    }

    fn effect(&self, factors: Vec<String>, n: usize, ss_all_errors: f64, rounding: f64, confidence: f64) -> Effect {
        let (ss, ss_error, df) = (self.ss, self.ss_error, self.df);
        let df_error = df * (n - 1);
        let [mean_square, mean_square_error] = [ss / df as f64, ss_error / df_error as f64];
        let varies = mean_square_error.sqrt() > rounding && mean_square_error > f64::MIN_POSITIVE;
        Effect {
            factors,
            ss,
            df,
            ss_error,
            df_error,
            mean_square,
            mean_square_error,
            generalised_eta_squared: (ss + ss_all_errors > 0.0).then(|| ss / (ss + ss_all_errors)),
            test: varies.then(|| self.test(n, mean_square / mean_square_error, confidence)),
        }
    }

    fn test(&self, n: usize, f: f64, confidence: f64) -> EffectTest {
        let sphericity = Sphericity::new(&self.deviations, self.df, n);
        let (df, df_error) = (self.df as f64, (self.df * (n - 1)) as f64);
        let p_at = |epsilon: f64| f_tails(f, epsilon * df, epsilon * df_error).upper;
        let epsilon = sphericity.greenhouse_geisser;
        // The confidence has been checked, so that limits exist unless F itself is beyond numbers.
        let limits = noncentrality_limits_of_f(f, df, df_error, confidence).unwrap_or([0.0, f64::MAX]);
        EffectTest {
            f,
            p: p_at(1.0),
            greenhouse_geisser: Corrected { epsilon, p: p_at(epsilon) },
            huynh_feldt: sphericity.huynh_feldt.map(|uncapped| {
                let epsilon = uncapped.min(1.0);
                HuynhFeldt { epsilon, uncapped, p: p_at(epsilon) }
            }),
            mauchly: sphericity.mauchly,
            partial_eta_squared: EtaSquared {
                estimate: self.ss / (self.ss + self.ss_error),
                noncentrality_ci: limits,
                ci: limits.map(|lambda| lambda / (lambda + df + df_error + 1.0)),
            },
        }
    }
}
