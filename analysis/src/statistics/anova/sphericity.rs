//! How far an effect's contrasts are from equal variances and no covariance, and what that does to its F test.

use crate::statistics::distributions::chi_square;
use serde::{Deserialize, Serialize};

/// ε and the p value at degrees of freedom multiplied by it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Corrected {
    /// 1/df to 1; 1 if sphericity holds.
    pub epsilon: f64,
    /// p value.
    pub p: f64,
}

/// Huynh and Feldt's correction.
///
/// (n df ε − 2) / (df (n − 1 − df ε)) of Huynh and Feldt (1976), as in R's car, SPSS and pingouin. Lecoutre's (1991)
/// correction of it differs only where there are groups of subjects; with one group it is the same number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HuynhFeldt {
    /// At most 1.
    pub epsilon: f64,
    /// As the formula has it, which can be above 1; car prints this one.
    pub uncapped: f64,
    /// p value at `epsilon`.
    pub p: f64,
}

/// Mauchly's test of sphericity, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "status")]
pub enum Mauchly {
    /// The test.
    Tested(MauchlyTest),
    /// One degree of freedom: there is nothing that could differ.
    OneContrast,
    /// The covariance of `contrasts` contrasts cannot be estimated from `subjects` subjects.
    TooFewSubjects {
        /// Subjects.
        subjects: usize,
        /// Degrees of freedom of the effect.
        contrasts: usize,
    },
    /// Some contrast is a sum of others in every subject, as if a condition had been computed from others.
    Singular,
}

/// Mauchly's (1940) test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MauchlyTest {
    /// Determinant over the mean variance to the power of df, 0–1.
    pub w: f64,
    /// −(n − 1 − (2d² + d + 2)/(6d)) ln W for d contrasts.
    pub chi_square: f64,
    /// d(d + 1)/2 − 1.
    pub df: usize,
    /// Its upper tail, as in SPSS.
    pub p: f64,
    /// With the second-order term of Anderson (2003, §10.7.4, eq. 10), as R and pingouin intend; both put the number of
    /// conditions where Anderson has that of contrasts, so that theirs differs slightly.
    pub p_second_order: f64,
}

impl Mauchly {
    /// The test, if there is one.
    #[must_use]
    pub fn test(&self) -> Option<&MauchlyTest> {
        match self {
            Self::Tested(test) => Some(test),
            _ => None,
        }
    }
}

/// What an effect's contrasts say of sphericity.
pub(super) struct Sphericity {
    pub(super) greenhouse_geisser: f64,
    pub(super) huynh_feldt: Option<f64>,
    pub(super) mauchly: Mauchly,
}

impl Sphericity {
    /// Of `n` subjects' deviations from the mean of `df` orthonormal contrasts, subject by subject, not all zero.
    pub(super) fn new(deviations: &[f64], df: usize, n: usize) -> Self {
        if df == 1 {
            return Self { greenhouse_geisser: 1.0, huynh_feldt: Some(1.0), mauchly: Mauchly::OneContrast };
        }
        // tr(S) and tr(S²) are the same for contrasts × contrasts and subjects × subjects: the smaller one is summed.
        let largest = deviations.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let scaled: Vec<f64> = deviations.iter().map(|value| value / largest).collect();
        let between_contrasts = df < n;
        let products = if between_contrasts { products_of_columns(&scaled, df) } else { products_of_rows(&scaled, df) };
        let size = if between_contrasts { df } else { n };
        let trace: f64 = (0..size).map(|i| products[i * size + i]).sum();
        let squares: f64 = products.iter().map(|value| value * value).sum();
        let (contrasts, subjects) = (df as f64, n as f64);
        let epsilon = (trace * trace / (contrasts * squares)).clamp(1.0 / contrasts, 1.0);

        let left = subjects - 1.0 - contrasts * epsilon;
        // At its limit, the number of subjects − 1, the ratio is a rounding error over another.
        let defined = left > 1e-9 * subjects;
        let huynh_feldt = defined.then(|| (subjects * contrasts * epsilon - 2.0) / (contrasts * left));
        let mauchly = if n <= df {
            Mauchly::TooFewSubjects { subjects: n, contrasts: df }
        } else {
            mauchly(products, df, n, trace)
        };
        Self { greenhouse_geisser: epsilon, huynh_feldt, mauchly }
    }
}

fn products_of_columns(rows: &[f64], width: usize) -> Vec<f64> {
    let mut products = vec![0.0; width * width];
    for row in rows.chunks(width) {
        for (i, a) in row.iter().enumerate() {
            for (product, b) in products[i * width..].iter_mut().zip(row) {
                *product += a * b;
            }
        }
    }
    products
}

fn products_of_rows(rows: &[f64], width: usize) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    rows.chunks(width).flat_map(|a| rows.chunks(width).map(move |b| dot(a, b))).collect()
}

fn mauchly(mut products: Vec<f64>, d: usize, n: usize, trace: f64) -> Mauchly {
    let Some(ln_determinant) = ln_determinant(&mut products, d) else {
        return Mauchly::Singular;
    };
    let (contrasts, residual) = (d as f64, (n - 1) as f64);
    let d = contrasts;
    // Rounding can put a perfect sphere a hair above 1.
    let ln_w = (ln_determinant - d * (trace / d).ln()).min(0.0);
    let rho = 1.0 - (2.0 * d * d + d + 2.0) / (6.0 * d * residual);
    let chi = -residual * rho * ln_w;
    let df = d * (d + 1.0) / 2.0 - 1.0;
    let upper = |df: f64| chi_square(chi, df).map_or(1.0, |tails| tails.upper);
    let second = (d + 2.0) * (d - 1.0) * (d - 2.0) * (2.0 * d.powi(3) + 6.0 * d * d + 3.0 * d + 2.0)
        / (288.0 * (residual * d * rho).powi(2));
    let p = upper(df);
    let p_second_order = (p + second * (upper(df + 4.0) - p)).clamp(0.0, 1.0);
    Mauchly::Tested(MauchlyTest { w: ln_w.exp(), chi_square: chi, df: df as usize, p, p_second_order })
}

/// ln det of a positive definite matrix by Cholesky's decomposition in place; nothing if it is singular.
fn ln_determinant(matrix: &mut [f64], size: usize) -> Option<f64> {
    let largest = (0..size).map(|i| matrix[i * size + i]).fold(0.0, f64::max);
    let smallest = 16.0 * size as f64 * f64::EPSILON * largest;
    let mut ln = 0.0;
    for i in 0..size {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i * size + k] * matrix[j * size + k]).sum();
            let rest = matrix[i * size + j] - sum;
            if i > j {
                matrix[i * size + j] = rest / matrix[j * size + j];
            } else if rest <= smallest {
                return None;
            } else {
                ln += rest.ln();
                matrix[i * size + i] = rest.sqrt();
            }
        }
    }
    Some(ln)
}
