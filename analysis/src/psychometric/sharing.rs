//! Which parameters several data sets share: likelihood-ratio tests between nested hypotheses.

use super::ml::Surface;
use super::{Count, Psychometric, PsychometricConfig, PsychometricError};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// A parameter of a psychometric function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Parameter {
    /// The threshold.
    Threshold,
    /// The width.
    Width,
    /// The lapse rate.
    Lapse,
    /// The guess rate.
    Guess,
    /// Overdispersion.
    Overdispersion,
}

impl Parameter {
    fn index(self) -> usize {
        match self {
            Self::Threshold => 0,
            Self::Width => 1,
            Self::Lapse => 2,
            Self::Guess => 3,
            Self::Overdispersion => 4,
        }
    }
}

/// One hypothesis: the functions that it fits, and how well.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hypothesis {
    /// What all data sets share.
    pub shared: Vec<Parameter>,
    /// The function of each data set.
    pub functions: Vec<Psychometric>,
    /// The log likelihood of all answers, without binomial coefficients.
    pub ln_likelihood: f64,
    /// Free parameters.
    pub parameters: usize,
    /// Akaike's criterion, up to the constant that both hypotheses share.
    pub aic: f64,
}

/// Two nested hypotheses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The tested parameters are shared.
    pub together: Hypothesis,
    /// Each data set has its own.
    pub apart: Hypothesis,
    /// Twice the difference in log likelihood.
    pub deviance: f64,
    /// Parameters that `apart` has more.
    pub df: usize,
    /// The probability of a deviance at least as large if they are shared, by χ² with `df` degrees of freedom. A rate whose
    /// estimate is zero makes it too large (Self and Liang 1987).
    pub p: f64,
    /// How functions were fitted.
    pub config: PsychometricConfig,
    /// The data of each set, ascending in level.
    pub counts: Vec<Vec<Count>>,
}

/// Tests whether data sets share the `tested` parameters, beside the `common` ones that they share under both hypotheses.
///
/// # Errors
/// As [`super::likelihood_fit`], for the first data set that has one.
///
/// ```
/// use analysis::psychometric::{Count, Parameter, PsychometricConfig, compare};
/// let counts = |ks: [u32; 5]| (1u8..).zip(ks).map(|(level, k)| Count { level: level.into(), n: 40, k }).collect();
/// let near: Vec<Count> = counts([22, 28, 35, 39, 40]);
/// let far: Vec<Count> = counts([19, 21, 22, 27, 36]);
/// let config = PsychometricConfig::TWO_ALTERNATIVES;
/// let test = compare(&[&near, &far], &config, &[Parameter::Threshold], &[Parameter::Lapse])?;
/// assert!(test.df == 1 && test.p < 0.001);
/// # Ok::<(), analysis::psychometric::PsychometricError>(())
/// ```
pub fn compare(
    groups: &[&[Count]],
    config: &PsychometricConfig,
    tested: &[Parameter],
    common: &[Parameter],
) -> Result<Comparison, PsychometricError> {
    let surfaces: Vec<Surface> = groups.iter().map(|counts| Surface::new(counts, config)).collect::<Result<_, _>>()?;
    let tops: Vec<Vec<f64>> = surfaces.iter().map(|surface| surface.highest().0).collect();
    let apart = hypothesis(&surfaces, &tops, common, None);
    let mut shared = common.to_vec();
    shared.extend(tested.iter().filter(|parameter| !common.contains(parameter)));
    let together = hypothesis(&surfaces, &tops, &shared, None);
    // From where the shared fit ended, the separate one cannot end lower.
    let apart = hypothesis(&surfaces, &tops, common, Some(&together)).better_of(apart);
    let deviance = (2.0 * (apart.ln_likelihood - together.ln_likelihood)).max(0.0);
    let df = apart.parameters - together.parameters;
    let p = if df == 0 { 1.0 } else { ChiSquared::new(df as f64).map_or(1.0, |chi| chi.sf(deviance)) };
    let counts = surfaces.into_iter().map(|surface| surface.data.counts).collect();
    Ok(Comparison { together, apart, deviance, df, p, config: *config, counts })
}

impl Hypothesis {
    fn better_of(self, other: Self) -> Self {
        if other.ln_likelihood > self.ln_likelihood { other } else { self }
    }
}

/// The best fit with some parameters shared; each data set has a slot for every parameter that is its own.
fn hypothesis(surfaces: &[Surface], tops: &[Vec<f64>], shared: &[Parameter], from: Option<&Hypothesis>) -> Hypothesis {
    let is_shared: Vec<bool> = (0..5).map(|i| shared.iter().any(|parameter| parameter.index() == i)).collect();
    let mut slots = vec![[0usize; 5]; surfaces.len()];
    let (mut start, mut bounds, mut scales): (Vec<f64>, Vec<[f64; 2]>, Vec<f64>) = Default::default();
    for i in 0..5 {
        let own: Vec<f64> = match from {
            Some(hypothesis) => surfaces
                .iter()
                .zip(&hypothesis.functions)
                .map(|(surface, function)| {
                    let x = surface.posterior.point(function)[i];
                    if i == 1 { x.ln() } else { x }
                })
                .collect(),
            None => tops.iter().map(|top| top[i]).collect(),
        };
        for (group, surface) in surfaces.iter().enumerate() {
            if is_shared[i] && group > 0 {
                slots[group][i] = slots[0][i];
                let slot = slots[0][i];
                // The widest bounds of any, so that no data set forbids what another needs.
                bounds[slot] = [bounds[slot][0].min(surface.bounds[i][0]), bounds[slot][1].max(surface.bounds[i][1])];
                continue;
            }
            slots[group][i] = start.len();
            start.push(if is_shared[i] { own.iter().sum::<f64>() / own.len() as f64 } else { own[group] });
            bounds.push(surface.bounds[i]);
            scales.push(surface.scales[i]);
        }
    }
    let place_of = |x: &[f64], group: usize| -> [f64; 5] { std::array::from_fn(|i| x[slots[group][i]]) };
    let value = |x: &[f64]| {
        surfaces.iter().enumerate().map(|(group, surface)| surface.likelihood(&place_of(x, group))).sum::<f64>()
    };
    let (at, ln_likelihood) = super::maximum::maximise(value, &start, &bounds, &scales);
    let parameters = bounds.iter().filter(|[low, high]| low < high).count();
    Hypothesis {
        shared: shared.to_vec(),
        functions: surfaces
            .iter()
            .enumerate()
            .map(|(group, surface)| surface.function(&place_of(&at, group)))
            .collect(),
        ln_likelihood,
        parameters,
        aic: 2.0 * parameters as f64 - 2.0 * ln_likelihood,
    }
}
